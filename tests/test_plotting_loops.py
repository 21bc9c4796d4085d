"""Pictures of control loops: what is connected, where margins are, and turns that are counted."""

import numpy as np
import pytest
from drawn import texts
from matplotlib.patches import Circle, FancyBboxPatch
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.plotting import plot_block_diagram, plot_bode, plot_gang_of_four, plot_nyquist

OMEGA = np.logspace(-2, 2, 2000)


pytestmark = pytest.mark.usefixtures("ax")


def late(s):
    """A triple integrator with two zeros and a lag: stable in a range of gains only."""
    return 3 * (s + 0.3) * (s + 1) / s**3 / (0.1 * s + 1) ** 2


def test_a_diagram_has_its_boxes_sums_names_and_signs(ax):
    blocks = {"sum": (0, 0, ""), "C": (2, 0, "PID"), "P": (4, 0, "robot")}
    links = [
        ("$r$", (-1, 0), "sum"),
        ("$e$", "sum", "C"),
        ("$u$", "C", "P"),
        ("$y$", "P", (6, 0)),
        ("", (5, 0), (5, -1), "-sum"),
    ]
    assert plot_block_diagram(blocks, links, ax) is ax
    assert {"PID", "robot", "$r$", "$e$", "$u$", "$y$", "−"} == set(texts(ax))
    assert sum(isinstance(patch, FancyBboxPatch) for patch in ax.patches) == 2
    assert sum(isinstance(patch, Circle) for patch in ax.patches) == 1
    # One signal branches off, and there is a dot.
    (dot,) = (line for line in ax.lines if line.get_marker() == "o")
    assert_allclose(dot.get_xydata(), [[5, 0]])


def test_lines_run_along_the_axes_and_end_at_the_edges(ax):
    plot_block_diagram({"a": (0, 0, "a", 0.5), "b": (3, 2, "b")}, [("u", "a", "b")], ax)
    (line,) = ax.lines
    arrow = next(text for text in ax.texts if getattr(text, "arrow_patch", None))
    corners = np.vstack([line.get_xydata(), arrow.xy])
    assert_allclose(corners[0], [0.5, 0])
    assert_allclose(corners[1], [3, 0])
    assert 1 < corners[2][1] < 2
    assert ((np.diff(corners, axis=0) == 0).sum(1) == 1).all()


@pytest.mark.parametrize(
    ("blocks", "links", "named"),
    [
        ({"a": (0, 0)}, [], "blocks"),
        ({}, [], "blocks"),
        ({"a": (0, 0, "a", -1)}, [], "half the width"),
        ({"a": (0, 0, "a")}, [("u", "a")], "links"),
        ({"a": (0, 0, "a")}, [("u", "a", "b")], "'b'"),
        ({"a": (0, 0, "a")}, [("u", "a", (1, np.nan))], "links"),
    ],
)
def test_what_is_no_diagram_is_refused(ax, blocks, links, named):
    with pytest.raises(fs.InvalidParameter, match=named):
        plot_block_diagram(blocks, links, ax)


@pytest.mark.parametrize(("factor", "clockwise", "counter"), [(0.02, 2, 0), (1, 2, 2), (20, 4, 2)])
def test_turns_about_minus_one_are_the_unstable_poles(ax, factor, clockwise, counter):
    plot_nyquist(lambda s: factor * late(s), 0.01, 1000, ax)
    labels = ax.get_legend_handles_labels()[1]
    assert f"clockwise: {clockwise}" in labels
    assert f"counter-clockwise: {counter}" in labels
    closed = np.polymul([0.01, 0.2, 1], [1, 0, 0, 0])
    closed = np.polyadd(closed, 3 * factor * np.polymul([1, 0.3], [1, 1]))
    assert (np.roots(closed).real > 0).sum() == clockwise - counter


def test_the_compressed_curve_keeps_directions_and_the_circle_of_one(ax):
    plot_nyquist(late, 0.1, 1000, ax)
    curve = next(line for line in ax.lines if line.get_label() == r"$\omega>0$")
    drawn = curve.get_xdata() + 1j * curve.get_ydata()
    true = late(1j * np.geomspace(0.1, 1000, 3000))
    assert_allclose(drawn / np.abs(drawn), true / np.abs(true), atol=1e-9)
    inside = np.abs(true) < 1
    assert_allclose(drawn[inside], true[inside])
    assert np.abs(drawn).max() < 6 < np.abs(true).max()


def test_the_strokes_of_a_bode_plot_are_the_margins(ax):
    magnitudes, phases = plot_bode(lambda s: 2 / s / (s + 1) / (0.5 * s + 1), OMEGA)
    strokes = [line for line in magnitudes.lines if line.get_lw() == 6]
    (stroke,) = strokes
    # By hand: -180 degrees at sqrt(2) rad/s, where the gain is 2 / 3.
    assert_allclose(stroke.get_xdata(), 2**0.5, rtol=1e-3)
    assert_allclose(stroke.get_ydata(), [1, 2 / 3], rtol=1e-3)
    (stroke,) = (line for line in phases.lines if line.get_lw() == 6)
    at = stroke.get_xdata()[0]
    phase = -90 - np.degrees(np.arctan(at) + np.arctan(at / 2))
    assert_allclose(stroke.get_ydata(), [-180, phase], atol=0.1)


def test_the_gang_of_four_is_what_its_titles_say(ax):
    def plant(s):
        return 1 / s

    def controller(s):
        return 2 + 0 * s

    four = plot_gang_of_four(plant, controller, OMEGA, label="PI")
    assert [one.get_title().split("\n")[0][1] for one in four] == ["S", "T", "P", "C"]
    s = 1j * OMEGA
    expected = s / (s + 2), 2 / (s + 2), 1 / (s + 2), 2 * s / (s + 2)
    for one, values in zip(four, expected, strict=True):
        assert_allclose(one.lines[0].get_ydata(), np.abs(values))
        assert one.get_legend_handles_labels()[1] == ["PI"]
    # A second one goes onto the same axes.
    assert plot_gang_of_four(plant, plant, OMEGA, four) == four


def test_a_pole_on_the_way_is_refused(ax):
    with pytest.raises(fs.InvalidParameter, match="pole"), np.errstate(all="ignore"):
        plot_bode(lambda s: 1 / (s - 1j), [0.5, 1.0, 2.0])
    with pytest.raises(fs.InvalidParameter, match="highest"):
        plot_nyquist(late, 1, 1, ax)
    with pytest.raises(fs.InvalidParameter, match="omega"):
        plot_bode(late, [2, 1])
    with pytest.raises(fs.InvalidParameter, match="axes"):
        plot_bode(late, OMEGA, [ax])
