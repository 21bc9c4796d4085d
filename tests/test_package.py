import inspect
import os
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

import freeseg as fs
from freeseg import errors

ROOT = Path(__file__).parent.parent
REQUIREMENTS = (ROOT / "environment.txt").read_text(encoding="utf-8")
#: What the collection uses itself; all other requirements are what these pull in.
DIRECT = [
    "build",
    "casadi",
    "control",
    "hypothesis",
    "ipympl",
    "ipython",
    "ipywidgets",
    "joblib",
    "jupyterlab",
    "matplotlib",
    "mypy",
    "nbgrader",
    "nbmake",
    "numpy",
    "pytest",
    "pytest-xdist",
    "ruff",
    "scipy",
    "setuptools",
    "shapely",
    "sympy",
    "tqdm",
]


def requirement_lines():
    lines = [line.strip() for line in REQUIREMENTS.splitlines()]
    return [line for line in lines if line and not line.startswith("#")]


@pytest.mark.parametrize("slow", ["IPython", "casadi", "control", "joblib", "matplotlib", "sympy"])
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
    for line in pins:
        requirement = line.split("#")[0].strip()
        assert re.fullmatch(
            r"[a-z0-9-]+==[0-9][0-9a-z.]*( ; [a-z_]+ [<=>!]+ '[^']+')?", requirement
        )


def test_no_requirement_is_there_twice():
    names = [line.split("==")[0] for line in requirement_lines()]
    assert len(set(names)) == len(names)


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
