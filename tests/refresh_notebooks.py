"""Run notebooks and store them clean: ``python tests/refresh_notebooks.py [file ...]``.

Without files, every notebook is refreshed; with ``--links`` instead of files, only
the links in their last cells are. Stored are source and outputs;
stripped is what differs from run to run though nothing changed: execution
times, widget ids and widget state, memory addresses, and the versions in the
metadata. The same rules decide when a committed output is stale.
"""

import base64
import os
import re
import sys
from difflib import unified_diff
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).resolve().parent.parent / "notebooks"
#: The README's picture: the first one of the first notebook.
OVERVIEW = NOTEBOOKS / "overview.png"
KERNEL = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
#: What a reader reads; pictures are not compared.
TEXT = ("text/plain", "text/markdown", "text/html", "text/latex")

# Kernels that inherit this, which many CI systems set, draw no picture into the notebook.
os.environ.pop("MPLBACKEND", None)


def every_notebook():
    """Files of the collection; not what JupyterLab and nbgrader make of them."""
    made = {".ipynb_checkpoints", "build"}
    files = sorted(NOTEBOOKS.rglob("*.ipynb"))
    return [file for file in files if made.isdisjoint(file.relative_to(NOTEBOOKS).parts)]


def lessons():
    """Files of the lessons, in the order in which they are read."""
    return [file for file in every_notebook() if file.parent == NOTEBOOKS]


def in_words(file):
    """A lesson's number and title, as a link says them."""
    title = nbformat.read(file, as_version=4).cells[0].source.partition("\n")[0].lstrip("# ")
    number, _, rest = file.stem.partition("_")
    return f"{number} {title}" if rest else title


def navigation(file):
    """Links to what comes before and after a lesson; from solutions, back to their lesson."""
    if file.parent.name == "solutions":
        return f"[← {in_words(NOTEBOOKS / file.name)}](../{file.name})"
    order = lessons()
    place = order.index(file)
    parts = [f"[← {in_words(one)}]({one.name})" for one in order[max(place - 1, 0) : place]]
    parts += ["[contents](00_start_here.ipynb)"] if place else []
    parts += [f"[{in_words(one)} →]({one.name})" for one in order[place + 1 : place + 2]]
    return " · ".join(parts)


def navigate(notebook, file):
    """Give a lesson its last cell, with links onwards; return the notebook."""
    if file.parent in (NOTEBOOKS, NOTEBOOKS / "solutions"):
        last = notebook.cells[-1]
        if "navigation" not in last.metadata.get("tags", ()):
            last = nbformat.v4.new_markdown_cell(id="navigation", metadata={"tags": ["navigation"]})
            notebook.cells.append(last)
        last.source = navigation(file)
    return notebook


def mask(text):
    """Text without memory addresses and embedded pictures."""
    text = re.sub(r"\b0x[0-9a-fA-F]{6,}", "0x0", text)
    return re.sub(r"data:image/\w+;base64,[A-Za-z0-9+/=\s]+", "data:image", text)


def clean(notebook):
    """Strip in place what differs from run to run; return the notebook."""
    notebook.metadata = {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        cell.metadata.pop("execution", None)
        cell.metadata.pop("collapsed", None)
        outputs = []
        for output in cell.outputs:
            if (
                output.output_type == "stream"
                and outputs
                and outputs[-1].get("name") == output.name
            ):
                outputs[-1].text += output.text
                continue
            if "data" in output:
                output.data.pop("application/vnd.jupyter.widget-view+json", None)
                if "text/plain" in output.data:
                    output.data["text/plain"] = mask(output.data["text/plain"])
            outputs.append(output)
        cell.outputs = outputs
    return notebook


def text_output(cell):
    """Text that a code cell prints or shows, with run-to-run differences masked."""
    parts = []
    for output in cell.outputs:
        if output.output_type == "stream":
            parts.append(("stream " + output.name, output.text))
        elif output.output_type == "error":
            parts.append(("error", f"{output.ename}: {output.evalue}\n"))
        else:
            parts += [(kind, output.data[kind] + "\n") for kind in TEXT if kind in output.data]
    # Streams may be split differently, and flushed in another order, from run to run.
    merged = {}
    for kind, text in parts:
        merged[kind] = merged.get(kind, "") + mask(text)
    return "".join(f"[{kind}]\n{text}" for kind, text in sorted(merged.items()))


def stale_cell(committed, fresh):
    """First code cell whose committed text is not what it prints now.

    Returns
    -------
    (int, str) or None
        Index of the cell, and the difference.
    """
    for number, (before, now) in enumerate(zip(committed.cells, fresh.cells, strict=True)):
        if before.cell_type != "code":
            continue
        old, new = text_output(before), text_output(now)
        if old != new:
            difference = unified_diff(
                old.splitlines(), new.splitlines(), "committed", "fresh", lineterm=""
            )
            return number, "\n".join(difference)
    return None


def pictures(notebook):
    """PNG pictures of a notebook, as bytes, in order."""
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    found = [
        output.data["image/png"] for output in outputs if "image/png" in output.get("data", ())
    ]
    return [base64.b64decode(picture) for picture in found]


def refresh(file):
    """Run one notebook from its folder and store it clean."""
    notebook = nbformat.read(file, as_version=4)
    NotebookClient(notebook, timeout=120, kernel_name="python3").execute(cwd=str(file.parent))
    nbformat.write(navigate(clean(notebook), file), file)
    if file.stem == "00_start_here":
        OVERVIEW.write_bytes(pictures(notebook)[0])


if __name__ == "__main__":
    if sys.argv[1:] == ["--links"]:
        for path in every_notebook():
            nbformat.write(navigate(nbformat.read(path, as_version=4), path), path)
        sys.exit()
    for path in map(Path, sys.argv[1:] or every_notebook()):
        print(path.name, flush=True)
        refresh(path.resolve())
