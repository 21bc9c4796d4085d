"""Time every notebook: ``python tests/benchmarks/notebooks.py``.

Each runs in a fresh kernel, one after the other, as when a reader runs it;
the time of starting the kernel is included.
"""

import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from refresh_notebooks import every_notebook


def main(files=None):
    """Print the time of each notebook and of all together."""
    total = 0.0
    for file in files or every_notebook():
        notebook = nbformat.read(file, as_version=4)
        begin = time.perf_counter()
        NotebookClient(notebook, timeout=120, kernel_name="python3").execute(cwd=str(file.parent))
        total += (taken := time.perf_counter() - begin)
        print(f"{file.stem:32s} {taken:6.1f} s")
    print(f"{'all':32s} {total:6.1f} s")


if __name__ == "__main__":
    main()
