"""What holds for every notebook, besides that it runs and prints what it says."""

import io
import re
import statistics
from copy import deepcopy
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output
from nbmake.nb_run import NotebookRun
from PIL import Image
from refresh_notebooks import (
    KERNEL,
    NOTEBOOKS,
    OVERVIEW,
    clean,
    every_notebook,
    lessons,
    navigation,
    pictures,
    stale_cell,
)

ROOT = NOTEBOOKS.parent
FILES = every_notebook()
LESSONS = lessons()


@pytest.fixture(params=FILES, ids=lambda file: file.stem)
def file(request):
    return request.param


@pytest.fixture
def notebook(file):
    return nbformat.read(file, as_version=4)


def code_of(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def forbidden(notebook):
    """What a notebook must not contain, in words."""
    found = []
    if notebook.metadata.get("kernelspec", {}).get("name") != "python3":
        found.append("another kernel than python3")
    for cell in code_of(notebook):
        if re.search(r"^\s*[!%]|sys\.path|get_ipython|https?://", cell.source, re.M):
            found.append(f"a magic, a shell command, sys.path or the network: {cell.source[:40]!r}")
        if cell.metadata.get("nbmake") or "execution" in notebook.metadata:
            found.append("instructions to the test runner")
        if set(cell.metadata.get("tags", ())) & {"skip-execution", "raises-exception"}:
            found.append("a cell that is skipped or may fail")
    return found


def test_there_are_notebooks():
    assert "00_start_here" in [file.stem for file in FILES]


def test_nothing_forbidden(notebook):
    assert forbidden(notebook) == []


@pytest.mark.parametrize(
    ("source", "metadata"),
    [
        ("!pip install x", {}),
        ("  %pip install x", {}),
        ("import sys\nsys.path.append('..')", {}),
        ("x = 1", {"tags": ["skip-execution"]}),
        ("x = 1", {"tags": ["raises-exception"]}),
        ("x = 1", {"nbmake": {"mock": {"x": 1}}}),
    ],
)
def test_forbidden_things_are_found(source, metadata):
    cell = new_code_cell(source, metadata=metadata)
    assert forbidden(new_notebook(cells=[cell], metadata={"kernelspec": KERNEL}))


def test_another_kernel_is_found():
    assert forbidden(new_notebook(metadata={"kernelspec": KERNEL | {"name": "conda-env"}}))


def as_jupyterlab_saves(notebook):
    """The notebook with what JupyterLab adds when it merely opens and saves one."""
    opened = deepcopy(notebook)
    opened.metadata["language_info"] = {"name": "python", "version": "3.12.1"}
    for cell in code_of(opened):
        cell.metadata["collapsed"] = True
    return opened


def is_clean(notebook):
    """Whether all that `clean` strips is gone, but for what JupyterLab adds to any notebook."""
    return as_jupyterlab_saves(clean(deepcopy(notebook))) == as_jupyterlab_saves(notebook)


def test_opening_in_jupyterlab_fails_no_test(notebook):
    assert is_clean(as_jupyterlab_saves(notebook))


def test_stored_clean_and_run_in_order(notebook):
    assert is_clean(notebook)
    assert [cell.execution_count for cell in code_of(notebook)] == [
        *range(1, len(code_of(notebook)) + 1)
    ]
    assert not any(o.output_type == "error" for cell in code_of(notebook) for o in cell.outputs)


def test_small_enough_to_review(file, notebook):
    assert file.stat().st_size <= 1_000_000
    for picture in pictures(notebook):
        assert max(Image.open(io.BytesIO(picture)).info["dpi"]) <= 100.1


@pytest.mark.parametrize("file", LESSONS, ids=lambda file: file.stem)
def test_first_cell_says_what_the_lesson_is(notebook):
    first = notebook.cells[0].source
    assert re.match(r"# [A-Z]", first)
    assert re.search(r"\*\*[^*]+\?\*\*", first), "the question, in bold"
    for part in ("*Paper: ", "**You will see**", "**You need**", "**Runs in** about"):
        assert part in first


def lines_of(cell):
    """Lines of code, comments and empty ones among them."""
    return len(cell.source.splitlines())


@pytest.mark.parametrize("file", LESSONS, ids=lambda file: file.stem)
def test_the_lesson_is_the_code_that_is_left(notebook):
    lengths = [lines_of(cell) for cell in code_of(notebook)]
    assert max(lengths) <= 25
    assert statistics.median(lengths) <= 8
    assert sum(lengths) <= 200
    # An answer stands in `solutions/`, so that nobody sees it before asking for it.
    assert not any(re.search(r"^#+ Solution", cell.source, re.M) for cell in notebook.cells)


@pytest.mark.parametrize(
    "file",
    [*LESSONS, *(file for file in FILES if file.parent.name == "solutions")],
    ids=lambda file: f"{file.parent.name}/{file.stem}",
)
def test_last_cell_leads_on(file, notebook):
    assert notebook.cells[-1].source == navigation(file)


def test_every_lesson_links_its_solutions():
    for file in FILES:
        if file.parent.name == "solutions":
            lesson = nbformat.read(NOTEBOOKS / file.name, as_version=4)
            assert any(f"(solutions/{file.name})" in cell.source for cell in lesson.cells)


def test_both_maps_list_every_notebook():
    readme = (ROOT / "README.md").read_text()
    start = nbformat.read(NOTEBOOKS / "00_start_here.ipynb", as_version=4)
    lesson_map = "".join(cell.source for cell in start.cells)
    for file in LESSONS:
        assert f"notebooks/{file.name}" in readme
        assert file.stem == "00_start_here" or f"({file.name})" in lesson_map


def test_readme_picture():
    start = nbformat.read(NOTEBOOKS / "00_start_here.ipynb", as_version=4)
    assert OVERVIEW.read_bytes() == pictures(start)[0]


def printed(*outputs):
    """A notebook of one code cell with these outputs."""
    return new_notebook(cells=[new_markdown_cell("text"), new_code_cell("x", outputs=[*outputs])])


def stream(text, name="stdout"):
    return new_output("stream", text=text, name=name)


def shown(**data):
    return new_output("display_data", data={key.replace("_", "/"): data[key] for key in data})


@pytest.mark.parametrize(
    ("committed", "fresh"),
    [
        ([stream("length 805.2 mm\n")], [stream("length 805.3 mm\n")]),
        ([stream("a\n")], []),
        ([], [stream("new\n")]),
        ([stream("a\n")], [stream("a\n", name="stderr")]),
        ([shown(text_markdown="| 1 |")], [shown(text_markdown="| 2 |")]),
        ([shown(text_html="<b>1</b>")], [shown(text_html="<b>2</b>")]),
    ],
)
def test_stale_text_is_found(committed, fresh):
    number, report = stale_cell(printed(*committed), printed(*fresh))
    assert number == 1
    assert "committed" in report


@pytest.mark.parametrize(
    ("committed", "fresh"),
    [
        ([stream("a\nb\n")], [stream("a\n"), stream("b\n")]),
        ([shown(text_plain="<f at 0x7f00aa00>")], [shown(text_plain="<f at 0x7fbbccdd>")]),
        ([shown(image_png="AAAA", text_plain="fig")], [shown(image_png="BBBB", text_plain="fig")]),
        (
            [shown(text_html='<img src="data:image/gif;base64,AAAA">')],
            [shown(text_html='<img src="data:image/gif;base64,BBBB">')],
        ),
    ],
)
def test_run_to_run_differences_are_not_stale(committed, fresh):
    assert stale_cell(printed(*committed), printed(*fresh)) is None


def test_clean_strips_what_differs():
    notebook = printed(
        stream("a\n"),
        stream("b\n"),
        new_output(
            "display_data",
            data={
                "application/vnd.jupyter.widget-view+json": {"model_id": "1f"},
                "text/plain": "w",
            },
        ),
    )
    notebook.metadata = {"widgets": {"state": {}}, "language_info": {"version": "3.11.7"}}
    notebook.cells[1].metadata["execution"] = {"iopub.execute_input": "2020"}
    assert not is_clean(notebook)
    stored = clean(notebook)
    assert is_clean(stored)
    assert stored.metadata == {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    assert "execution" not in stored.cells[1].metadata
    assert [output.get("text") for output in stored.cells[1].outputs] == ["a\nb\n", None]
    assert stored.cells[1].outputs[1].data == {"text/plain": "w"}


def test_nbmake_fails_a_stale_notebook(tmp_path):
    cell = new_code_cell("print(1 + 1)", outputs=[stream("3\n")])
    file = tmp_path / "stale.ipynb"
    nbformat.write(new_notebook(cells=[cell], metadata={"kernelspec": KERNEL}), file)
    result = NotebookRun(Path(file), 60, kernel="python3").execute()
    assert "cell 0 no longer prints its committed output" in result.error.summary
    assert "-3" in result.error.trace
    assert "+2" in result.error.trace
