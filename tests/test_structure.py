"""The package as the design has it: short functions, one meaning a constant, imports downwards."""

import ast
import re
import sys
import tomllib
from collections import defaultdict
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "freeseg"
#: Modules and packages of freeseg, from the ground up: each imports only what stands before it.
LAYERS = [
    "errors",
    "checks",
    "geometry",
    "data",
    "world",
    "scene",
    "outlines",
    "maps",
    "paper",
    "robot",
    "path",
    "timed_path",
    "triangulation",
    "segments",
    "plan",
    "planners",
    "random_worlds",
    "smoothing",
    "reference",
    "disturbance",
    "trackers",
    "reactive",
    "replanning",
    "following",
    "simulate",
    "react",
    "metrics",
    "studies",
    "teaching",
    "plotting",
    "display",
    "explorer",
]
#: What only one module may import, for it is slow to load or an extra; None for nobody.
RESERVED = {
    "casadi": "freeseg.trackers.mpc",
    "control": None,
    "distributed": None,
    "joblib": "freeseg.studies.runner",
    "pyarrow": "freeseg.studies.store",
    "tqdm": "freeseg.studies.runner",
    "numba": "freeseg.planners.compilation",
    "IPython": "freeseg.display",
    "ipympl": "freeseg.explorer",
    "ipywidgets": "freeseg.explorer",
    "PIL": "freeseg.maps",
    "yaml": "freeseg.maps",
}


def module_name(file):
    parts = file.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {module_name(file): file for file in sorted(PACKAGE.rglob("*.py"))}
TREES = {name: ast.parse(file.read_text(encoding="utf-8")) for name, file in FILES.items()}


def imported(tree):
    """Names of all modules that a tree imports, also inside of functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative import"
            for alias in node.names:
                # `from freeseg import checks` imports the module `freeseg.checks`.
                inner = f"{node.module}.{alias.name}"
                yield inner if inner in FILES else node.module


IMPORTS = {name: set(imported(tree)) for name, tree in TREES.items()}


def functions():
    for name, tree in TREES.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield name, node


def length_of(function):
    """Lines of code of a function, nested ones included and its docstring not."""
    has_docstring = ast.get_docstring(function) is not None and len(function.body) > 1
    return function.end_lineno - function.body[has_docstring].lineno + 1


def test_no_function_is_longer_than_forty_lines():
    long = {
        f"{name}.{node.name}": length_of(node) for name, node in functions() if length_of(node) > 40
    }
    assert long == {}


def constants(tree):
    for node in tree.body:
        targets = [node.target] if isinstance(node, ast.AnnAssign) else getattr(node, "targets", [])
        for target in targets:
            for part in ast.walk(target):
                if isinstance(part, ast.Name) and part.id.isupper():
                    yield part.id


def test_no_constant_has_the_name_of_another():
    found = defaultdict(list)
    for name, tree in TREES.items():
        for constant in constants(tree):
            found[constant].append(name)
    assert len(found) > 30
    assert {constant: names for constant, names in found.items() if len(names) > 1} == {}


def layer_of(name):
    return LAYERS.index(name.split(".")[1])


@pytest.mark.parametrize("name", [name for name in FILES if name != "freeseg"])
def test_imports_lead_downwards(name):
    assert name.split(".")[1] in LAYERS, "give the new module its place in LAYERS"
    inner = {module for module in IMPORTS[name] if module.split(".")[0] == "freeseg"}
    assert inner - FILES.keys() <= {"freeseg._data"}
    upwards = {
        module
        for module in inner & FILES.keys()
        if module == "freeseg" or layer_of(module) > layer_of(name)
    }
    assert upwards == set()


def test_every_layer_is_there():
    assert {name.split(".")[1] for name in FILES if name != "freeseg"} == set(LAYERS)


def test_no_imports_go_round_in_circles():
    # What refuses a call runs in another module, so it imports the one that it is defined in.
    graph = {name: (modules & FILES.keys()) - {name} for name, modules in IMPORTS.items()}
    # Raises a CycleError that names the modules.
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(FILES)


def test_nothing_imports_plotting():
    drawn = re.compile(r"freeseg\.plotting\b")
    users = {name for name, modules in IMPORTS.items() if any(map(drawn.match, modules))}
    assert {name for name in users if not drawn.match(name)} == {"freeseg.explorer"}


@pytest.mark.parametrize(("package", "owner"), RESERVED.items())
def test_what_only_one_module_may_import(package, owner):
    users = [
        name
        for name, modules in IMPORTS.items()
        if any(module.split(".")[0] == package for module in modules)
    ]
    assert users == ([owner] if owner else [])


def test_every_package_that_is_imported_is_declared():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"].values()
    required = [*project["dependencies"], *(line for extra in extras for line in extra)]
    declared = {re.match(r"[\w-]+", line)[0].lower() for line in required}
    packages = {module.split(".")[0] for modules in IMPORTS.values() for module in modules}
    # These are imported by another name than they are installed by.
    packages = {{"PIL": "pillow", "yaml": "pyyaml"}.get(name, name) for name in packages}
    third_party = packages - set(sys.stdlib_module_names) - {"freeseg"}
    assert "numpy" in third_party
    assert {package.lower() for package in third_party} - declared == set()
