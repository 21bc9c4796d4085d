"""Pictures of looking ahead, by what they contain."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import Circle

import freeseg as fs
from freeseg.plotting import (
    PALETTE,
    plot_change,
    plot_distances,
    plot_keep_out,
    plot_lookahead,
    plot_radii,
    plot_strip,
    plot_turn,
    sketch_horizon,
)

pytestmark = pytest.mark.usefixtures("ax")


@pytest.fixture(scope="module")
def driven():
    """A run round a bend, and its reference."""
    path = fs.Path([fs.Line((0, 0), (0.2, 0)), fs.Arc((0.2, 0.2), 0.2, -np.pi / 2, 1.2)])
    reference = fs.make_reference(path)
    return fs.simulate(fs.SlidingMode(), reference), reference, path


def labels_of(ax):
    return list(ax.get_legend_handles_labels()[1])


def test_the_sketch_names_what_is_known_predicted_planned_and_commanded(ax):
    assert sketch_horizon(ax) is ax
    texts = [text.get_text() for text in ax.texts]
    for name in ("now", "driven", "predicted", "plan", "given now", "delay", "under\nway"):
        assert name in texts
    # One command is given, filled; two are under way, hatched.
    fills = [patch.get_facecolor() for patch in ax.patches]
    given = plt.matplotlib.colors.to_rgba(PALETTE["tracked"])
    assert fills.count(given) == 1
    assert sum(bool(patch.get_hatch()) for patch in ax.patches) == 2


def test_turn_rates_are_the_runs_and_the_references(ax, driven):
    run, reference, _ = driven
    plot_turn(run, reference, 1.0, 2.5, ax)
    wanted, turned = ax.lines
    assert labels_of(ax) == ["reference", "driven"]
    assert wanted.get_ydata() == pytest.approx(reference.at(wanted.get_xdata()).omega)
    chosen = (run.t >= 1) & (run.t <= 2.5)
    assert turned.get_ydata() == pytest.approx(run.robot.to_body(run.wheels)[1][chosen])
    with pytest.raises(fs.InvalidParameter, match="since is 90"):
        plot_turn(run, reference, 90, 91, ax)


def test_a_plan_begins_where_the_drive_ends(ax, driven):
    run, _, path = driven
    plan = run.pose[:2, 10:20] + 0.01
    plot_lookahead(path, run.pose[:2, :10], plan, ax)
    assert labels_of(ax) == [
        "reference",
        "driven",
        "planned",
        "its first step: commanded",
        "the robot now",
    ]
    planned, first, now = ax.lines[-3:]
    assert planned.get_xdata() == pytest.approx(plan[0])
    assert first.get_xydata() == pytest.approx(plan[:, :1].T)
    assert now.get_xydata() == pytest.approx(run.pose[:2, 9:10].T)


def test_a_strip_has_a_dot_for_every_number_and_counts_the_others(ax):
    plot_strip({"one": [1, 2, 4], "two": [3, np.inf, np.inf]}, ax, "time (s)")
    assert ax.lines[0].get_xdata().tolist() == [1, 2, 4]
    assert list(ax.lines[1].get_xdata()) == [2, 2]
    # The median of the second row is never reached.
    assert len(ax.lines) == 3
    assert [text.get_text() for text in ax.texts] == ["never: 2 of 3"]
    assert [text.get_text() for text in ax.get_yticklabels()] == ["one", "two"]


def test_a_change_is_drawn_from_before_to_after(ax):
    plot_change({"a": (10, 1), "b": (5, 0.5)}, ("without", "with"), ax)
    before, after = ax.lines
    assert labels_of(ax) == ["without", "with"]
    assert before.get_xdata().tolist() == [10, 5]
    assert after.get_xdata().tolist() == [1, 0.5]
    assert ax.get_xscale() == "log"


def test_discs_have_the_circle_that_the_centre_keeps_out_of(ax, driven):
    run, _, _ = driven
    world = fs.World([fs.Disc((0.1, 0.2), 0.03), fs.Disc((0.1, -0.2), 0.04)])
    plot_keep_out(world, run, ax)
    dashed = [patch.radius for patch in ax.patches if isinstance(patch, Circle)]
    for disc in world:
        assert disc.radius + run.robot.radius in dashed
    assert labels_of(ax)[:2] == ["no entry for its centre", "reference"]
    with pytest.raises(fs.InvalidParameter, match=r"(?s)world is .*give a World of discs"):
        plot_keep_out(fs.World([fs.Polygon([(0, 0), (1, 0), (0, 1)])]), run, ax)


def test_radii_stand_over_the_horizon(ax):
    plot_radii({"a": [1.2, 0.9, 0.8], "b": [0.5, 0.5, 0.5]}, ax)
    drawn = [line for line in ax.lines if line.get_label() in "ab"]
    assert [line.get_xdata().tolist() for line in drawn] == [[1, 2, 3]] * 2
    assert [text.get_text() for text in ax.texts] == ["errors grow"]
    with pytest.raises(fs.InvalidParameter, match="radii has 5 lines; give at most 4"):
        plot_radii({key: [1.0] for key in "abcde"}, ax)


def test_distances_are_those_of_the_errors(ax, driven):
    run, _, _ = driven
    plot_distances({"a run": run}, ax)
    assert labels_of(ax) == ["a run"]
    assert ax.lines[0].get_ydata() == pytest.approx(np.hypot(*run.error[:2]))


@pytest.mark.parametrize("values", [{}, [1, 2], {1: [1, 2]}, {"a": []}, {"a": "b"}, {"a": [-1]}])
def test_what_are_no_rows(values):
    for function, name in ((plot_radii, "radii"), (plot_strip, "values")):
        if values == {"a": [-1]} and function is plot_strip:
            continue
        with pytest.raises(fs.InvalidParameter, match=f"^{name}"):
            function(values)
