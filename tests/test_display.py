"""Flipbooks: as many pages as values, in their order, and no text that breaks out."""

import base64
import io
import json
import re

import pytest
from PIL import Image

import freeseg as fs


def draw_level(figure, value):
    ax = figure.subplots()
    ax.axhspan(0, value)
    ax.set_ylim(0, 1)


def pages_of(book):
    return json.loads(re.search(r"const pages = (.*?), book =", book.data, re.S)[1])


def picture(source):
    return Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2])))


def test_a_page_of_each_value():
    book = fs.display.flipbook(draw_level, [0.2, 0.5, 0.9], ["low", "half", "high"], (3, 2), 1)
    pages = pages_of(book)
    assert [label for _, label in pages] == ["low", "half", "high"]
    assert [picture(source).size for source, _ in pages] == [(270, 180)] * 3
    # The more is filled, the more of the picture is dark.
    shades = [sum(picture(source).convert("L").histogram()[:200]) for source, _ in pages]
    assert shades == sorted(shades)
    assert shades[0] < shades[2]
    shown_first = re.search(r'src="([^"]+)"', book.data)[1]
    assert shown_first == pages[1][0]
    assert "value: 1}" in book.data


def test_labels_are_text():
    label = "</script><b>R_D > 5 mm & more</b>"
    book = fs.display.flipbook(draw_level, [0.2], [label], alt='a "level"')
    assert pages_of(book)[0][1] == label
    assert book.data.count("</script>") == 1
    assert "<b>" not in re.sub(r"<script>.*</script>", "", book.data, flags=re.S)
    assert 'alt="a &quot;level&quot;"' in book.data


def test_pages_are_drawn_on_no_figure_of_pyplot():
    import matplotlib.pyplot as plt

    before = plt.get_fignums()
    fs.display.flipbook(draw_level, [0.2], ["low"])
    assert plt.get_fignums() == before


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"draw": 3}, "draw is 3; give draw"),
        ({"labels": ["low"]}, "labels is 1 texts for 2 values"),
        ({"values": [], "labels": []}, "at least one"),
        ({"first": 2}, r"first is \[2\]; give indices of pages, below 2"),
        ({"size": (0, 3)}, "size is 0"),
    ],
)
def test_bad_input(change, message):
    good = {"draw": draw_level, "values": [0.1, 0.2], "labels": ["low", "half"]}
    with pytest.raises(fs.InvalidParameter, match=message):
        fs.display.flipbook(**good | change)
