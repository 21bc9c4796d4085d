"""What a notebook shows besides figures: tables, flipbooks, and animations as pictures."""

import base64
import io
import json
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
from matplotlib.animation import PillowWriter
from matplotlib.figure import Figure

from freeseg import checks
from freeseg.errors import InvalidParameter

#: Dots per inch of a page of a flipbook.
DOTS = 90

#: The slider is made by the script, so that where scripts are not run, as on GitHub, a plain
#: picture stands there, and nothing that looks as if it could be moved.
FLIPBOOK = """
<figure style="margin:0;max-width:{width}px">
<img alt="{alt}" style="width:100%" src="{source}">
<figcaption style="text-align:center;font-family:sans-serif">{label}</figcaption>
<script>
(() => {{
  const pages = {pages}, book = document.currentScript.parentElement;
  const slider = document.createElement("input");
  Object.assign(slider, {{type: "range", min: 0, max: pages.length - 1, value: {first}}});
  slider.setAttribute("aria-label", book.querySelector("img").alt);
  slider.style.width = "100%";
  slider.oninput = () => {{
    const [source, label] = pages[slider.value];
    book.querySelector("img").src = source;
    book.querySelector("figcaption").textContent = label;
  }};
  book.append(slider);
}})();
</script>
</figure>
"""


def as_gif(animation, dpi=70, alt="animation"):
    """An animation as a picture that any notebook viewer shows.

    Parameters
    ----------
    animation : matplotlib Animation
        What to show; its figure is closed.
    dpi : int, optional
        Resolution.
    alt : str, optional
        What it shows, in words.

    Returns
    -------
    IPython.display.HTML
    """
    # Imported here: IPython comes with the extra [notebooks] only.
    from IPython.display import HTML

    with TemporaryDirectory() as folder:
        file = Path(folder) / "animation.gif"
        animation.save(file, writer=PillowWriter(fps=10), dpi=dpi)
        data = base64.b64encode(file.read_bytes()).decode()
    plt.close(animation._fig)
    return HTML(f'<img alt="{escape(alt)}" src="data:image/gif;base64,{data}">')


def flipbook(draw, values, labels, size=(6, 4.5), first=0, alt="flipbook"):
    """A slider through pictures drawn in advance; it needs no kernel.

    Parameters
    ----------
    draw : callable
        ``draw(figure, value)`` draws one page on an empty Matplotlib figure.
    values : sequence
        What to draw a page of each; shown in this order.
    labels : sequence of str
        What to write below each page: which value it is, and what comes of it.
    size : tuple of float, optional
        Width and height of a page (inches).
    first : int, optional
        Page that is open at first; the only one where scripts are not run.
    alt : str, optional
        What it shows, in words.

    Returns
    -------
    IPython.display.HTML

    Raises
    ------
    InvalidParameter
        For what is no such function, or not as many labels as values.
    """
    from IPython.display import HTML

    checks.function("draw", draw, "draw(figure, value)", None, None)
    values, labels = list(values), [str(label) for label in labels]
    if not values or len(values) != len(labels):
        raise InvalidParameter(
            f"labels is {len(labels)} texts for {len(values)} values; give one each, and at "
            "least one"
        )
    size = tuple(checks.positive("size", length) for length in size)
    (first,) = checks.indices("first", [first], len(values), "pages")
    pages = [
        (_as_picture(draw, value, size), label) for value, label in zip(values, labels, strict=True)
    ]
    source, label = pages[first]
    return HTML(
        FLIPBOOK.format(
            width=round(DOTS * size[0]),
            alt=escape(alt),
            source=source,
            label=escape(label),
            # A label must not end the script.
            pages=json.dumps(pages).replace("</", "<\\/"),
            first=first,
        )
    )


def _as_picture(draw, value, size):
    """One page as the address of a picture that holds the picture itself."""
    figure, file = Figure(size, dpi=DOTS, layout="constrained"), io.BytesIO()
    draw(figure, value)
    figure.savefig(file, format="webp", pil_kwargs={"lossless": True, "quality": 100})
    return f"data:image/webp;base64,{base64.b64encode(file.getvalue()).decode()}"


def show_table(header, rows):
    """A table for a notebook.

    Parameters
    ----------
    header : sequence of str
        Column titles.
    rows : sequence of sequences
        Cells; formatted with ``str``.

    Returns
    -------
    IPython.display.Markdown
    """
    from IPython.display import Markdown

    lines = [header, ["---"] * len(header), *rows]
    return Markdown(
        "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)
    )
