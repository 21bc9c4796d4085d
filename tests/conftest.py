"""Fixtures, and nbmake made to compare every notebook with what it prints now."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import nbformat
import pytest
from nbmake.nb_result import NotebookError, NotebookResult
from nbmake.nb_run import NotebookRun
from refresh_notebooks import stale_cell

import freeseg as fs

# Figures of the tests' own process open no windows; kernels have a backend of their own.
mpl.use("agg")
_execute = NotebookRun.execute


def _execute_and_compare(run):
    """Run a notebook as nbmake does; fail too if its committed text is stale."""
    committed = nbformat.read(run.filename, as_version=4)
    result = _execute(run)
    if result.error is None and (stale := stale_cell(committed, result.nb)):
        number, report = stale
        summary = f"{run.filename.name}: cell {number} no longer prints its committed output"
        trace = f"{summary}\n{report}\npython tests/refresh_notebooks.py brings it up to date"
        return NotebookResult(nb=result.nb, error=NotebookError(summary, trace, number))
    return result


NotebookRun.execute = _execute_and_compare


@pytest.fixture(scope="session")
def robot():
    return fs.KheperaIV()


@pytest.fixture(scope="session")
def cases():
    return fs.load_cases()


@pytest.fixture(scope="session")
def tables():
    return {number: fs.load_table(number) for number in range(1, 6)}


@pytest.fixture
def ax():
    """New axes; all figures are closed after a test that draws."""
    yield plt.figure().add_subplot()
    plt.close("all")
