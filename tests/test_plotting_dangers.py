"""Pictures of dangers and of local minima, by what they contain."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from drawn import texts
from matplotlib.patches import Circle, PathPatch

import freeseg as fs
from freeseg.plotting import PALETTE, plot_free_space, plot_repairs, sketch_danger, sketch_loop

pytestmark = pytest.mark.usefixtures("ax")


@pytest.mark.parametrize("distance", [-0.03, 0.0, 0.04, 0.1])
def test_sketch_danger_is_to_scale(robot, ax, distance):
    assert sketch_danger(distance, robot, ax) is ax
    body, obstacle = (patch for patch in ax.patches if isinstance(patch, Circle))
    assert body.radius == robot.radius
    # The path runs along y = 0.
    assert obstacle.center[1] - obstacle.radius == pytest.approx(distance)
    assert body.center == (0, 0)
    assert texts(ax) == ["$R_r$", "$d$"]


def test_sketch_danger_measures_to_an_endpoint(robot, ax):
    sketch_danger(0.055, robot, ax, endpoint=-0.1)
    (point,) = (line for line in ax.lines if line.get_label() == "endpoint $p$")
    ((_, height),) = point.get_xydata()
    _, obstacle = ax.patches
    assert np.hypot(*(point.get_xydata()[0] - obstacle.center)) == pytest.approx(obstacle.radius)
    # What the lesson says of it.
    assert height > robot.radius > 0.055
    assert texts(ax) == ["$R_r$", "$d_p$"]


def test_sketch_danger_names_what_it_cannot_draw(robot):
    with pytest.raises(fs.InvalidParameter, match=r"distance is -0\.1; give a length"):
        sketch_danger(-0.1, robot)


def test_sketch_loop_is_fig_3(ax):
    assert sketch_loop(ax) is ax
    text = "\n".join(texts(ax))
    for part in ("SP_i", "D_r+\\delta", "SD", "R_D", "danger\nproblem?", "yes", "no", "done"):
        assert part in text


def test_plot_repairs_draws_the_clearance_after_every_step(cases, robot, ax):
    case = cases["15b"]
    plan = fs.plan(fs.load_table(1), case.start, case.goal)
    assert plot_repairs({"15b": plan}, ax) is ax
    (curve,) = (line for line in ax.lines if line.get_label() == "15b")
    clearances = [step.path.clearance(plan.world) for step in plan.steps]
    np.testing.assert_allclose(curve.get_ydata(), clearances)
    (limit,) = (line for line in ax.lines if line.get_label() == "$R_r$")
    np.testing.assert_allclose(limit.get_ydata(), robot.radius)
    assert texts(ax) == ["case 1", "case 2"]


def test_plot_repairs_is_of_one_robot(world_and_query):
    world, start, goal = world_and_query
    plans = {d: fs.plan(world, start, goal, fs.KheperaIV(0.08, diameter=d)) for d in (0.1, 0.12)}
    with pytest.raises(fs.InvalidParameter, match="plans are for 2 robots"):
        plot_repairs(plans)
    with pytest.raises(fs.InvalidParameter, match="plans are for 0 robots"):
        plot_repairs({})


@pytest.fixture
def world_and_query():
    return fs.World([fs.Disc((0.5, 0), 0.05)]), (0, 0), (1, 0)


def test_plot_potential_shows_hills_darker(ax, world_and_query):
    world = world_and_query[0]
    drawn = fs.plotting.plot_potential(lambda points: points[:, 0] ** 2, world, (0, 1, -1, 1), ax)
    assert drawn is ax
    assert (*ax.get_xlim(), *ax.get_ylim()) == (0, 1, -1, 1)
    shades = ax.collections[0] if len(ax.collections[0].get_facecolor()) > 1 else ax.collections[1]
    alphas = shades.get_facecolor()[:, 3]
    assert (np.diff(alphas) > 0).all()


def test_plot_potential_names_what_is_no_potential(world_and_query):
    for potential in (3, lambda: 0):
        with pytest.raises(fs.InvalidParameter, match="potential is"):
            fs.plotting.plot_potential(potential, world_and_query[0], (0, 1, 0, 1))
    for potential in (lambda points: points, lambda points: np.full(len(points), np.inf)):
        with pytest.raises(fs.InvalidParameter, match=r"potential\(points\)"):
            fs.plotting.plot_potential(potential, world_and_query[0], (0, 1, 0, 1))


@pytest.mark.parametrize(("clearance", "parts"), [(0.02, 1), (0.07, 2)])
def test_free_space_is_green_where_it_leads_to_the_goal(ax, clearance, parts):
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    ring = fs.World([fs.Disc((0.3 * np.cos(a), 0.3 * np.sin(a)), 0.03) for a in angles])
    assert plot_free_space(ring, (1, 0), clearance, ax) is ax
    drawn = [patch for patch in ax.patches if isinstance(patch, PathPatch)]
    assert len(drawn) == parts
    by_label = {patch.get_label(): patch for patch in drawn}
    assert by_label["leads to the goal"].contains_point(ax.transData.transform((1, 0)))
    green = by_label["leads to the goal"]
    assert green.get_facecolor()[:3] == pytest.approx(plt.matplotlib.colors.to_rgb(PALETTE["safe"]))
    if parts == 2:
        # What does not lead there is inside of the ring.
        corners = by_label["does not"].get_path().get_extents().get_points()
        assert (abs(corners) < 0.3).all()
