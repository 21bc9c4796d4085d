"""Pictures of the sliding-mode law: drawn to scale, named, and where the formulas say."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from drawn import texts
from matplotlib.collections import PathCollection
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.plotting import (
    PALETTE,
    plot_denominator,
    plot_lyapunov_rate,
    plot_tradeoff,
    sketch_error,
    sketch_surface,
)

pytestmark = pytest.mark.usefixtures("ax")


def test_the_error_is_measured_along_the_robots_axes(ax):
    p, p_r = (0.1, 0, np.radians(20)), (0.34, 0.22, np.radians(55))
    assert sketch_error(p, p_r, ax=ax) is ax
    assert {"$x_e$", "$y_e$", r"$\alpha_e$", "$p$: is"} < set(texts(ax))
    legs = next(line for line in ax.lines if len(line.get_xdata()) == 3)
    along, across = np.diff(legs.get_xydata(), axis=0)
    x_e, y_e, _ = fs.tracking_error(p_r, p)
    assert_allclose([np.hypot(*along), np.hypot(*across)], [x_e, y_e])
    assert_allclose(along @ across, 0, atol=1e-12)


def test_on_the_surface_the_leash_ends_on_the_path(robot, ax):
    assert sketch_surface(robot, ax) is ax
    assert {r"$\ell$", "$y_e$", r"$\gamma$"} < set(texts(ax))
    (leash,) = (
        line for line in ax.lines if line.get_color() == PALETTE["turning"] and line.get_lw() > 2
    )
    start, end = leash.get_xydata()
    assert_allclose(end[1], 0, atol=1e-12)
    (aside,) = (line for line in ax.lines if line.get_linestyle() == "--")
    foot, target = aside.get_xydata()
    assert_allclose(foot, start)
    assert_allclose(target[1], 0, atol=1e-12)
    assert_allclose((target - start) @ (end - start), 0, atol=1e-12)


def test_the_singular_line_is_a_parabola_through_minus_l(ax):
    plot_denominator(0.045, 0.25, ax)
    labels = ax.get_legend_handles_labels()[1]
    assert labels == ["singular: 0", "floor: 0.25", "no error: 1"]
    lines = [
        c for c in ax.collections if not isinstance(c, PathCollection) and len(c.get_edgecolor())
    ]
    white = next(c for c in lines if np.allclose(c.get_edgecolor()[0], 1))
    x, y = white.get_paths()[0].vertices.T
    assert_allclose(x, -(0.045 + y**2 / 0.045), atol=5e-4)


@pytest.mark.parametrize("turn_rate", [1.0, -1.0])
def test_it_grows_where_the_turn_outweighs_the_leash(ax, turn_rate):
    plot_lyapunov_rate(0.045, 0.1, turn_rate, ax)
    (region,) = ax.collections
    x, y = np.vstack([path.vertices for path in region.get_paths()]).T
    assert (turn_rate * x * y < 1e-9).all()
    assert np.abs(x * y).max() > 1e-5
    plot_lyapunov_rate(0.045, 0.1, 0.0, plt.figure().add_subplot())  # nowhere on a line


def test_a_tradeoff_has_a_curve_for_each_family_and_its_marks(ax):
    families = {"one": [[1, 2], [0.1, 0.2]], "two": [[3], [0.3]]}
    assert plot_tradeoff(families, [["a", "b"]], ax) is ax
    assert ax.get_legend_handles_labels()[1] == ["one", "two", "the reference itself"]
    assert texts(ax) == ["a", "b"]
    assert_allclose(ax.lines[0].get_xydata().T, families["one"])
    assert ax.lines[0].get_color() != ax.lines[1].get_color()


def test_marks_of_two_families_do_not_cover_each_other_where_they_meet(ax):
    plot_tradeoff({"one": [[1], [0.1]], "two": [[1], [0.1]]}, [["40"], ["600"]], ax)
    one, two = (text.get_window_extent() for text in ax.texts)
    assert not one.overlaps(two)
