"""The lines of a lesson, run by a test: what students read is what is checked."""

import ast

import nbformat
from refresh_notebooks import NOTEBOOKS


def touched(tree):
    """Names that a cell defines, or calls a method of, as in ``rows.append(...)``."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store):
            if isinstance(node.value, ast.Name):
                yield node.value.id
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            owner = getattr(node.value.func, "value", None)
            if isinstance(owner, ast.Name):
                yield owner.id


def needed(tree):
    """Names that a cell takes from cells before it."""
    names = [node for node in ast.walk(tree) if isinstance(node, ast.Name)]
    own = {node.id for node in names if isinstance(node.ctx, ast.Store)}
    own |= {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
    return {node.id for node in names if isinstance(node.ctx, ast.Load)} - own


def lesson(stem, *names):
    """What a notebook calls by some names, after the cells that define them have run.

    Run are the first two cells of code, the imports and the parameters, and the
    cells that define or change one of the names, or something that these need.
    """
    notebook = nbformat.read(NOTEBOOKS / f"{stem}.ipynb", as_version=4)
    sources = [cell.source for cell in notebook.cells if cell.cell_type == "code"]
    trees, run, wanted = list(map(ast.parse, sources)), {0, 1}, set(names)
    # From the last cell on, for a cell needs only what stands before it.
    for place in reversed(range(2, len(trees))):
        if not wanted.isdisjoint(touched(trees[place])):
            run.add(place)
            wanted |= needed(trees[place])
    space = {}
    for place in sorted(run):
        exec(compile(sources[place], f"{stem}, code cell {place + 1}", "exec"), space)
    found = [space[name] for name in names]
    return found[0] if len(found) == 1 else found


def definitions(stem, *names):
    """As `lesson`, by name, of two names or more."""
    return dict(zip(names, lesson(stem, *names), strict=True))
