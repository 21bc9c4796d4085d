"""What the book does beyond its extensions.

Names of the package in running text, such as `fs.plan`, lead to their reference, and a lesson's
title has its number. The index and the search know which section teaches a term. Links to the
README lead to the book's first page, which shows it. Equations in docstrings are kept as typed,
and bars are absolute values, not substitutions.
"""

import csv
import re
from collections import defaultdict
from pathlib import Path

from docutils import nodes
from sphinx import addnodes
from sphinx.errors import ExtensionError
from sphinx.transforms import SphinxTransform

#: Terms, each with the section that teaches it.
TERMS = Path(__file__).parent.parent / "terms.csv"
NAME = re.compile(r"(?:fs|freeseg)\.(?P<name>\w+(?:\.\w+)*)(?:\(.*\))?")


class LinkNames(SphinxTransform):
    """Turn literals that name something of freeseg into references."""

    default_priority = 700

    def apply(self, **kwargs):
        """Wrap each literal that stands in no link yet."""
        for literal in list(self.document.findall(nodes.literal)):
            found = NAME.fullmatch(literal.astext())
            if not found or isinstance(literal.parent, nodes.reference | addnodes.pending_xref):
                continue
            link = addnodes.pending_xref(
                "",
                refdomain="py",
                reftype="obj",
                reftarget=f"freeseg.{found['name']}",
                refdoc=self.env.docname,
                refwarn=False,
            )
            literal.replace_self(link)
            link += literal


class NumberLessons(SphinxTransform):
    """Let a lesson's title begin with its number, as other lessons refer to it."""

    default_priority = 700

    def apply(self, **kwargs):
        """Take the number from the file's name."""
        number = re.match(r"notebooks/(?:solutions/)?([0-9A]\d)_", self.env.docname)
        if number:
            next(self.document.findall(nodes.title)).insert(0, nodes.Text(f"{number[1]} "))


class IndexTerms(SphinxTransform):
    """List a term in the index, from where the search takes it, too."""

    default_priority = 700

    def apply(self, **kwargs):
        """Put what `TERMS` says of a page into the sections that it names."""
        wanted = defaultdict(list)
        with TERMS.open(encoding="utf-8", newline="") as stream:
            for row in csv.DictReader(stream):
                if row["page"] == self.env.docname:
                    wanted[row["heading"]].append(row["term"])
        for section in list(self.document.findall(nodes.section)):
            title = section.next_node(nodes.title).astext()
            target = section["ids"][0]
            entries = [("single", one, target, "main", None) for one in wanted.pop(title, ())]
            section.insert(1, addnodes.index(entries=entries))
        if wanted:
            raise ExtensionError(f"{self.env.docname} lacks the headings {sorted(wanted)}")


class KeepTags(SphinxTransform):
    """Let an equation of several lines have one number, where Sphinx would split it."""

    default_priority = 700

    def apply(self, **kwargs):
        """Give each such equation the delimiters that MathJax looks for."""
        for block in self.document.findall(nodes.math_block):
            if r"\tag" in block.astext():
                block["no-wrap"] = True
                block.children = [nodes.Text(rf"\[{block.astext()}\]")]


def lead_to_first_page(app, docname, source):
    """Turn links to the README, in place, into such to the page that shows it."""
    if docname.startswith("docs/"):
        source[0] = source[0].replace("](../README.md#", "](index.md#")


def lead_from_first_page(app, path, docname, content):
    """Let the links of the README, in place, lead from the page that shows it."""
    text = content[0].replace("](notebooks/solutions)", "](#solutions)")
    content[0] = re.sub(r"\]\((?!\w+:|#)", "](../", text)


def set_equations(app, what, name, obj, options, lines):
    """Mark in place what a docstring's text indents, its equations, as blocks to keep as typed."""
    end = next((i for i, line in enumerate(lines) if re.fullmatch("-{3,}", line)), len(lines))
    for i in reversed(range(2, end)):
        above = next((line for line in lines[i - 1 :: -1] if line), "")
        # Where the text above begins, after the number or bullet of an item.
        margin = len(re.match(r"\s*(?:\d+\. |[-*] )?", above)[0])
        indented = len(lines[i]) - len(lines[i].lstrip()) == margin + 4 and not lines[i - 1]
        if indented and not above.endswith("::"):
            lines[i:i] = [" " * margin + "::", ""]


def escape_bars(app, what, name, obj, options, lines):
    """Escape in place the bars that stand in no literal, no example and no equation."""
    typed = None  # how far the line above such a block is indented
    for number, line in enumerate(lines):
        indent = len(line) - len(line.lstrip())
        if line and typed is not None and indent <= typed:
            typed = None
        if typed is None and line.rstrip().endswith("::"):
            typed = indent
        elif typed is None and not line.lstrip().startswith((">>>", "...")):
            parts = re.split(r"(``.*?``)", line)
            parts[::2] = [part.replace("|", r"\|") for part in parts[::2]]
            lines[number] = "".join(parts)


def setup(app):
    """Register with Sphinx."""
    app.add_transform(LinkNames)
    app.add_transform(IndexTerms)
    app.add_transform(NumberLessons)
    app.add_transform(KeepTags)
    app.connect("source-read", lead_to_first_page)
    app.connect("include-read", lead_from_first_page)
    app.connect("autodoc-process-docstring", set_equations, priority=100)
    # After numpydoc, which reads the sections of a docstring as it is written.
    app.connect("autodoc-process-docstring", escape_bars, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
