"""What the book does beyond its extensions.

Names of the package in running text, such as `fs.plan`, lead to their reference. Bars in
docstrings are absolute values, not reStructuredText's substitutions.
"""

import re

from docutils import nodes
from sphinx import addnodes
from sphinx.transforms import SphinxTransform

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


def escape_bars(app, what, name, obj, options, lines):
    """Escape in place the bars that stand in no literal and no example."""
    for number, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...")):
            parts = re.split(r"(``.*?``)", line)
            parts[::2] = [part.replace("|", r"\|") for part in parts[::2]]
            lines[number] = "".join(parts)


def setup(app):
    """Register with Sphinx."""
    app.add_transform(LinkNames)
    # After numpydoc, which reads the sections of a docstring as it is written.
    app.connect("autodoc-process-docstring", escape_bars, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
