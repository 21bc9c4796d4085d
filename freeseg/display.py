"""What a notebook shows besides figures: tables, and animations as pictures."""

import base64
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
from matplotlib.animation import PillowWriter


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
    return HTML(f'<img alt="{alt}" src="data:image/gif;base64,{data}">')


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
