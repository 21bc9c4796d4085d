"""Kernels draw into the notebook, whatever the environment says that others draw into."""

import os
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook
from refresh_notebooks import KERNEL, pictures

TESTS = Path(__file__).resolve().parent
NBMAKE = ["-m", "pytest", "-n0", "--overwrite", "-p", "conftest", "-c", TESTS / "../pyproject.toml"]
COMMANDS = {"refresh": [TESTS / "refresh_notebooks.py"], "nbmake": NBMAKE}


@pytest.mark.parametrize("kind", COMMANDS)
def test_pictures_come_with_another_backend_in_the_environment(kind, tmp_path):
    file = tmp_path / "tiny.ipynb"
    cell = new_code_cell("import matplotlib.pyplot as plt\n\nplt.subplots();")
    nbformat.write(new_notebook(cells=[cell], metadata={"kernelspec": KERNEL}), file)
    places = os.pathsep.join([str(TESTS), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": places}
    told = subprocess.run(
        [sys.executable, *COMMANDS[kind], file], env=environment, capture_output=True, text=True
    )
    assert len(pictures(nbformat.read(file, as_version=4))) == 1, told
