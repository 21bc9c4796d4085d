import inspect
import os
import re
import subprocess
import sys
from importlib.metadata import distribution, version
from importlib.util import find_spec
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import freeseg as fs
from freeseg import errors

ROOT = Path(__file__).parent.parent
#: What a reader installs, and what a lecturer and the tests of the assignments need besides.
READER = (ROOT / "environment.txt").read_text(encoding="utf-8")
LECTURER = (ROOT / "notebooks/assignments/requirements.txt").read_text(encoding="utf-8")
#: What of a reader's environment adds to JupyterLab: in the browser, and in its server.
LAB_EXTENSIONS = {
    "@jupyter-widgets/jupyterlab-manager",
    "jupyter-matplotlib",
    "jupyterlab_pygments",
}
SERVER_EXTENSIONS = {
    "jupyter-lsp-jupyter-server",
    "jupyter_server_terminals",
    "jupyterlab",
    "notebook_shim",
}
#: What the collection uses itself; all other requirements are what these pull in.
DIRECT = [
    "build",
    "casadi",
    "cloudpickle",
    "control",
    "distributed",
    "hypothesis",
    "ipympl",
    "ipython",
    "ipywidgets",
    "joblib",
    "jupyterlab",
    "matplotlib",
    "mypy",
    "nbmake",
    "numba",
    "numpy",
    "pillow",
    "pyarrow",
    "pytest",
    "pytest-xdist",
    "pyyaml",
    "ruff",
    "scipy",
    "setuptools",
    "shapely",
    "sympy",
    "tqdm",
]


def requirement_lines(text=READER):
    lines = [line.strip() for line in text.splitlines()]
    return [line for line in lines if line and not line.startswith("#")]


def pinned(text):
    """Names of the packages that are pinned for this system."""
    pins = [Requirement(line.split("#")[0]) for line in requirement_lines(text) if "==" in line]
    return {pin.name for pin in pins if pin.marker is None or pin.marker.evaluate()}


def pulled_in(names):
    """Names of packages with those of all that they require, as installed."""
    found, left = set(), {(name, "") for name in names}
    while left:
        name, extra = left.pop()
        found.add((name, extra))
        for requirement in map(Requirement, distribution(name).requires or ()):
            if requirement.marker is None or requirement.marker.evaluate({"extra": extra}):
                new = {(canonicalize_name(requirement.name), e) for e in ("", *requirement.extras)}
                left |= new - found
    return {name for name, _ in found}


@pytest.mark.parametrize(
    "slow", ["IPython", "casadi", "control", "joblib", "matplotlib", "pyarrow", "sympy"]
)
def test_importing_freeseg_does_not_import(slow):
    # In a process of its own: here, other tests have imported everything.
    code = f"import freeseg, sys; assert 'numpy' in sys.modules; sys.exit({slow!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("name", fs.__all__)
def test_every_public_name_is_there_and_documented(name):
    assert inspect.getdoc(getattr(fs, name))


def test_public_names_are_sorted_and_unique():
    assert sorted(set(fs.__all__)) == fs.__all__


@pytest.mark.parametrize("module", [fs, fs.trackers])
def test_names_that_are_imported_late_are_listed(module):
    assert set(module.__all__) <= set(dir(module))


def test_studies_need_no_import_of_their_own():
    code = "import freeseg as fs; fs.studies.tuning.load_gains; fs.plotting.plot_plan; fs.Mpc()"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_readme_s_example_runs(tmp_path):
    (example,) = re.findall(
        r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S
    )
    told = {"env": os.environ | {"MPLBACKEND": "Agg"}, "capture_output": True, "text": True}
    done = subprocess.run([sys.executable, "-c", example], check=False, cwd=tmp_path, **told)
    assert (done.returncode, done.stderr) == (0, "")
    assert "position_rms_m" in done.stdout


def test_the_version_is_that_of_the_distribution():
    assert version("freeseg") == fs.__version__


def test_a_name_that_is_not_there():
    with pytest.raises(AttributeError, match="no attribute 'planing'"):
        fs.planing  # noqa: B018


def test_every_error_is_a_freeseg_error():
    found = [
        error
        for _, error in inspect.getmembers(errors, inspect.isclass)
        if error.__module__ == errors.__name__
    ]
    assert len(found) == 8
    for error in found:
        assert issubclass(error, fs.FreesegError)
        assert issubclass(fs.FreesegError, Exception)


@pytest.mark.parametrize(
    "name", ["InvalidData", "InvalidParameter", "InvalidQuery", "InvalidWorld"]
)
def test_an_error_in_a_value_is_a_value_error(name):
    assert issubclass(getattr(fs, name), ValueError)


def test_trapped_carries_the_steps():
    error = fs.Trapped("no way out", steps=["first", "second"])
    assert str(error) == "no way out"
    assert error.steps == ("first", "second")
    assert fs.Trapped("no way out").steps == ()


def test_every_requirement_is_an_exact_pin():
    *pins, last = requirement_lines()
    assert last == "-e ."
    first, *more = requirement_lines(LECTURER)
    assert first == "-r ../../environment.txt"
    for line in pins + more:
        requirement = line.split("#")[0].strip()
        assert re.fullmatch(
            r"[a-z0-9-]+==[0-9][0-9a-z.]*( ; [a-z_]+ [<=>!]+ '[^']+')?", requirement
        )


def test_no_requirement_is_there_twice():
    names = [line.split("==")[0] for line in requirement_lines() + requirement_lines(LECTURER)]
    assert len(set(names)) == len(names)


def test_all_that_the_packages_of_a_reader_pull_in_is_pinned():
    assert pulled_in({*DIRECT, "freeseg"}) == pinned(READER) | {"freeseg"}


def test_lecturers_add_what_grades_and_what_it_alone_pulls_in():
    if not find_spec("nbgrader"):
        pytest.skip("nbgrader is not here: pip install -r notebooks/assignments/requirements.txt")
    assert pulled_in({"nbgrader", "latex2mathml"}) - pinned(READER) == pinned(LECTURER)


def test_a_reader_s_jupyterlab_shows_nothing_but_what_the_notebooks_need():
    files = [file.as_posix() for name in pinned(READER) for file in distribution(name).files]
    text = "\n".join(sorted(files))
    found = re.findall(r"share/jupyter/labextensions/(.+)/package\.json$", text, re.M)
    assert set(found) == LAB_EXTENSIONS
    found = re.findall(r"etc/jupyter/jupyter_server_config\.d/(.+)\.json$", text, re.M)
    assert set(found) == SERVER_EXTENSIONS


@pytest.mark.parametrize("name", DIRECT)
def test_direct_dependencies_are_pinned_and_explained(name):
    (line,) = (line for line in requirement_lines() if line.startswith(f"{name}=="))
    assert re.search(r"# \w+", line)


def test_only_direct_dependencies_are_explained():
    explained = {line.split("==")[0] for line in requirement_lines() if "#" in line}
    assert explained == set(DIRECT)


def test_without_extras_all_but_what_needs_them_works(tmp_path):
    # As installed without extras: neither IPython nor joblib can be imported.
    code = (
        "import sys, pydoc; sys.modules['IPython'] = sys.modules['joblib'] = None\n"
        "import freeseg as fs; from freeseg import *; pydoc.render_doc(fs)\n"
        "fs.studies.planning.compare_rules([1])"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
