"""Build the book, and check that every link inside it leads somewhere.

python docs/build.py [folder]; without a folder, it is docs/_build/html.

The source is the whole repository, so that a relative link means in the book what it means in
the repository, and no notebook is copied. Warnings are errors.
"""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from sphinx.cmd.build import main

DOCS = Path(__file__).resolve().parent


class Page(HTMLParser):
    """What a page can be linked at, and where it leads."""

    def __init__(self, file):
        super().__init__()
        self.anchors, self.links = {""}, []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        """Note what a tag can be linked at, and where it leads."""
        attrs = dict(attrs)
        self.anchors |= {attrs.get("id", ""), attrs.get("name") or ""}
        target = attrs.get("href") or attrs.get("src") or ""
        if not urlsplit(target).scheme and not target.startswith("//"):
            self.links.append(target)


def broken_links(book):
    """Links of a book's pages that lead nowhere inside it.

    Parameters
    ----------
    book : Path
        Folder of the pages.

    Returns
    -------
    list of str
        Page and link of each.
    """
    pages = {file: Page(file) for file in sorted(book.rglob("*.html"))}
    broken = []
    for file, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            anchors = pages[target].anchors if target in pages else None
            if not target.exists() or (anchors and unquote(parts.fragment) not in anchors):
                broken.append(f"{file.relative_to(book)}: {link}")
    return broken


if __name__ == "__main__":
    book = Path(sys.argv[1] if sys.argv[1:] else DOCS / "_build" / "html").resolve()
    # All anew: of pages that it does not write, Sphinx's search forgets the entries of the index.
    told = ["-W", "--keep-going", "-q", "-E", "-a", "-c", str(DOCS), str(DOCS.parent), str(book)]
    if failed := main(told):
        sys.exit(failed)
    if found := broken_links(book):
        sys.exit("links that lead nowhere:\n" + "\n".join(found))
    print(f"The book is there: {book / 'index.html'}")
