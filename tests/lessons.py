"""The lines of a lesson, run by a test: what students read is what is checked."""

import ast

import nbformat
from refresh_notebooks import NOTEBOOKS


def touched(source):
    """Names that a cell defines, or calls a method of, as in ``rows.append(...)``."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            owner = getattr(node.value.func, "value", None)
            if isinstance(owner, ast.Name):
                yield owner.id


def lesson(stem, *names):
    """What a notebook calls by some names, after the cells that define them have run.

    Run are the first two cells of code, the imports and the parameters, and the
    cells that define or change one of the names.
    """
    notebook = nbformat.read(NOTEBOOKS / f"{stem}.ipynb", as_version=4)
    sources = [cell.source for cell in notebook.cells if cell.cell_type == "code"]
    space = {}
    for place, source in enumerate(sources):
        if place < 2 or not set(names).isdisjoint(touched(source)):
            exec(compile(source, f"{stem}, code cell {place + 1}", "exec"), space)
    found = [space[name] for name in names]
    return found[0] if len(found) == 1 else found


def definitions(stem, *names):
    """As `lesson`, by name, of two names or more."""
    return dict(zip(names, lesson(stem, *names), strict=True))
