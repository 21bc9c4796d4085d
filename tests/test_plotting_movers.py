"""Moments, space and time, openings and sketches of lesson 16: what they show, and name."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from drawn import texts
from matplotlib.collections import EllipseCollection
from matplotlib.patches import Circle
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.plotting import (
    PALETTE,
    animate_plan,
    plot_moment,
    plot_opening,
    plot_space_time,
    sketch_graze,
    sketch_leave,
    sketch_slide,
)

pytestmark = pytest.mark.usefixtures("ax")

MOVERS = [
    fs.Mover(fs.Disc((0.5, -0.3), 0.1), (0, 0.1)),
    fs.Mover(fs.Disc((1.0, 0.4), 0.1), growth=0.02),
]


@pytest.fixture(scope="module")
def plan():
    return fs.time_minimal_plan(fs.Scene(fs.World([]), MOVERS), (0, 0), (1.2, 0), 0.25)


def test_a_moment_has_everything_where_it_is_then(plan, ax):
    t, keep = 2.0, plan.robot.radius + plan.margin / 2
    assert plot_moment(plan, t, ax) is ax
    (drawn,) = (one for one in ax.collections if isinstance(one, EllipseCollection))
    assert_allclose(drawn.get_offsets(), [mover.at(t).center for mover in MOVERS])
    rims = [patch for patch in ax.patches if isinstance(patch, Circle) and not patch.get_fill()]
    radii = {round(patch.radius, 9) for patch in rims}
    assert radii == {round(mover.at(t).radius + keep, 9) for mover in MOVERS}
    (driven,) = (line for line in ax.lines if line.get_label() == "driven")
    assert driven.get_color() == PALETTE["planned"]
    last = plan.path.at(t)[0][:2]
    assert np.hypot(*(driven.get_xydata()[-1] - last)) < 0.01


def test_a_film_ends_at_the_arrival(plan, ax):
    film = animate_plan(plan, (-0.2, 1.4, -0.6, 0.6), ax, frames=3)
    film._func(plan.arrival)
    assert ax.get_title() == f"{plan.arrival:.1f} s"
    film._draw_was_started = True  # nobody shows it


def test_space_time_has_a_sheet_for_each_mover_and_the_path_between(plan):
    ax = plt.figure().add_subplot(projection="3d")
    assert plot_space_time(plan, ax) is ax
    assert len(ax.collections) == 2 + 2  # sheets, and the two ends
    x, y, t = ax.lines[0].get_data_3d()
    assert_allclose([x[-1], y[-1], t[-1]], [1.2, 0, plan.arrival], atol=1e-9)
    plt.close(ax.figure)


def test_space_time_wants_three_dimensions(plan, ax):
    with pytest.raises(fs.InvalidParameter, match="three dimensions"):
        plot_space_time(plan, ax)


def test_an_opening_names_the_moments_of_change(ax):
    t = np.linspace(0, 4, 41)
    plot_opening(t, np.abs(t - 2), 1.25, ax)
    assert {"danger from 0.75 s on", "safe from 3.25 s on"} < set(texts(ax))


@pytest.mark.parametrize(
    ("sketch", "names"),
    [
        (sketch_graze, {"$p$", "$d$", "$u$", "$v$", r"$\lambda e$", "$R_j$", r"$\beta$"}),
        (sketch_slide, {"$u$", "$v$", "$w\\,e$", "$R_j$", r"$\theta$"}),
        (sketch_leave, {"$p$", "$v$", "goal $g$", "too early", "too late"}),
    ],
)
def test_sketches_name_what_the_formulas_speak_of(sketch, names, ax):
    assert sketch(ax) is ax
    assert names <= set(texts(ax))


def test_the_line_that_leaves_goes_on_as_the_slide_does(ax):
    sketch_leave(ax)
    (line,) = (line for line in ax.lines if line.get_color() == PALETTE["planned"] and
               len(line.get_xdata()) == 2)  # fmt: skip
    place = line.get_xydata()[0]
    assert_allclose(np.hypot(*place), 1)
