"""What Sphinx makes the book of; `python docs/build.py` builds it."""

import os
import sys
from importlib.util import find_spec
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent / "_ext"), str(Path(__file__).parent.parent)]

# Where both are there, IPython displays are imported; a build must not start a browser for them.
os.environ.setdefault("MPLBACKEND", "Agg")

import freeseg as fs  # noqa: E402

project = "freeseg"
author = "The freeseg authors"
project_copyright = "2026, The freeseg authors"
release = version = fs.__version__
language = "en"

root_doc = "docs/index"
include_patterns = [
    "docs/**.md",
    "docs/**.rst",
    "notebooks/**.ipynb",
    "notebooks/assignments/README.md",
    "data/README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
]
exclude_patterns = ["docs/_build", "**/.ipynb_checkpoints", "**/build", "**/.*", "dist", "build"]

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx_codeautolink",
    "sphinx_copybutton",
    "freeseg_book",
]

# Notebooks are shown with the outputs that are stored and tested; nothing is run here.
nb_execution_mode = "off"
nb_merge_streams = True
nb_render_markdown_format = "myst"
myst_enable_extensions = ["amsmath", "dollarmath"]
myst_heading_anchors = 4

default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc says them in words, with shapes and units
numpydoc_show_class_members = False
numpydoc_validation_checks = set()

html_theme = "furo"
html_title = f"freeseg {release}"
# MathJax comes from a package, so that equations need no network.
MATHJAX = Path(find_spec("sphinx-mathjax-offline").origin).parent / "static"
mathjax_path = "mathjax/tex-chtml.js"
html_static_path = ["_static", str(MATHJAX)]
html_css_files = ["book.css"]
html_js_files = ["book.js"]
html_search_scorer = str(Path(__file__).parent / "search.js")
html_extra_path = ["root"]
html_show_sphinx = False
html_copy_source = False
copybutton_selector = "div.cell_input pre, div.highlight-python pre, div.highlight-bash pre"
