"""Pictures of reactive laws, of rivals' tracks and of who solves what others do not."""

import numpy as np
import pytest
from drawn import texts
from matplotlib.colors import to_rgb
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.plotting import PALETTE
from freeseg.plotting.rivals import ARROW

DISC, GOAL = fs.World([fs.Disc((0.4, 0.05), 0.05)]), (1.0, 0.0)


def labels(ax):
    return ax.get_legend_handles_labels()[1]


def test_forces_add_up_and_point_where_they_should():
    ax = fs.plotting.plot_forces(fs.PotentialField(), DISC, GOAL, (0.28, 0.0))
    arrows = {arrow.get_label(): np.array([arrow.U[0], arrow.V[0]]) for arrow in ax.collections}
    pull, push = arrows["attraction"], arrows["repulsion"]
    assert_allclose(arrows["sum"], pull + push, atol=1e-12)
    assert_allclose(pull / np.hypot(*pull), (1, 0), atol=1e-12)
    # Straight away from the disc.
    assert_allclose(np.cross([*push, 0], [0.12, 0.05, 0])[2], 0, atol=0.02)
    assert push[0] < 0
    assert max(np.hypot(*arrow) for arrow in arrows.values()) == pytest.approx(ARROW)
    with pytest.raises(fs.InvalidParameter, match="PotentialField"):
        fs.plotting.plot_forces(fs.DynamicWindow(), DISC, GOAL, (0, 0))


def test_sectors_are_as_high_as_the_histogram_and_the_arrow_is_the_choice():
    law, pose = fs.VectorFieldHistogram(), (0.22, 0.0, 0.0)
    ax = fs.plotting.plot_histogram(law, DISC, GOAL, pose)
    assert len(ax.patches) >= law.sectors
    assert {"free sector", "blocked sector", "reading", "direction chosen"} <= set(labels(ax))
    blocked = [
        patch for patch in ax.patches if patch.get_facecolor()[:3] == to_rgb(PALETTE["danger"])
    ]
    # Towards the disc, which is ahead and to the left, it is blocked.
    ways = np.array([patch.get_xy()[:4].mean(0) - pose[:2] for patch in blocked])
    angles = np.arctan2(*ways.T[::-1])
    assert angles.min() < np.arctan2(0.05, 0.18) < angles.max()
    (arrow,) = [one for one in ax.texts if one.arrow_patch]
    chosen = np.arctan2(*(np.array(arrow.xy) - pose[:2])[::-1])
    assert not angles.min() - 0.05 < chosen < angles.max() + 0.05
    closed = fs.World(
        [fs.Disc((0.22 + 0.15 * np.cos(a), 0.15 * np.sin(a)), 0.05) for a in np.arange(0, 6.3, 0.5)]
    )
    assert "direction chosen" not in labels(fs.plotting.plot_histogram(law, closed, GOAL, pose))


def test_the_window_shows_what_was_driven_and_chosen():
    law = fs.DynamicWindow()
    run = fs.react(law, DISC, (0, 0), GOAL)
    ax = fs.plotting.plot_window(law, DISC, GOAL, run, 40)
    points = {line.get_label(): line.get_xydata()[0] for line in ax.lines if len(line.get_xdata())}
    v, omega = run.robot.to_body(run.wheels[:, 39])
    assert_allclose(points["driven now"], (omega, v))
    v, omega = run.robot.to_body(run.asked[:, 40])
    assert_allclose(points["chosen"], (omega, v))
    # Left is on the left.
    assert ax.get_xlim() == (law.turn_rate, -law.turn_rate)
    assert fs.plotting.plot_window(law, DISC, GOAL, run, 0).lines
    for step in (-1, len(run.t) - 1):
        with pytest.raises(fs.InvalidParameter, match="step"):
            fs.plotting.plot_window(law, DISC, GOAL, run, step)


def test_a_track_that_ends_elsewhere_has_a_cross():
    tracks = {
        "exact": fs.shortest_path(DISC, (0, 0), GOAL),
        "run": fs.react(fs.PotentialField(), DISC, (0, 0), GOAL),
        "stuck": np.array([(0, 0), (0.2, 0.1)]),
    }
    ax = fs.plotting.plot_tracks(DISC, (0, 0), GOAL, tracks, colors={"run": "red"})
    lines = {line.get_label(): line for line in ax.lines}
    assert labels(ax) == ["exact", "run", "stuck", "start", "goal"]
    assert lines["run"].get_color() == "red"
    assert len({lines[name].get_color() for name in tracks}) == 3
    crosses = [line.get_xydata()[0] for line in ax.lines if line.get_marker() == "X"]
    assert_allclose(crosses, [(0.2, 0.1)])
    with pytest.raises(fs.InvalidParameter, match="track of 'none'"):
        fs.plotting.plot_tracks(DISC, (0, 0), GOAL, {"none": np.zeros((0, 2))})


def test_many_tracks_have_styles_of_their_own():
    tracks = {str(k): [(0, 0), (1, k / 10)] for k in range(15)}
    ax = fs.plotting.plot_tracks(fs.World([]), (0, 0), GOAL, tracks)
    styles = {
        (
            line.get_color(),
            line.get_linestyle(),
            line._dash_pattern[1] and tuple(line._dash_pattern[1]),
        )
        for line in ax.lines
        if line.get_label() in tracks
    }
    assert len(styles) == 15


def test_duels_are_coloured_where_they_are_decided():
    alone = [[0, 9, 3], [1, 0, 2], [2, 2, 0]]
    decided = np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]], bool)
    ax = fs.plotting.plot_duels(["a", "b", "c"], alone, decided)
    assert texts(ax) == ["9", "3", "1", "2", "2", "2"]
    colors = [patch.get_facecolor()[:3] for patch in ax.patches]
    assert colors[0] == to_rgb(PALETTE["safe"])
    assert colors[2] == to_rgb(PALETTE["danger"])
    assert colors.count((1, 1, 1)) == 4
    with pytest.raises(fs.InvalidParameter, match="decided"):
        fs.plotting.plot_duels(["a", "b", "c"], alone, alone)


def test_a_chase_shows_what_was_driven_by_then():
    run = fs.react(fs.PotentialField(), DISC, (0, 0), GOAL)
    t = run.t[30]
    ax = fs.plotting.plot_chase(DISC, (0, 0), GOAL, run, t)
    assert_allclose(ax.lines[-1].get_xydata(), run.pose[:2, :31].T)
    for t, count in ((-1.0, 1), (1e6, len(run.t))):
        ax = fs.plotting.plot_chase(DISC, (0, 0), GOAL, run, t)
        assert len(ax.lines[-1].get_xdata()) == count


def test_turns_have_a_line_for_each_number_and_a_dot_for_each_case():
    judged = [
        {"n": n, "share": share, "ratio": 1.1 - share / 10, "searched": 3}
        for n in (5, 9)
        for share in (0.0, 0.5, 0.9)
    ]
    empty = {"n": 9, "share": 1.0, "ratio": np.nan, "searched": 0}
    ax = fs.plotting.plot_turns([*judged, empty], [(0.5, 0.9)])
    assert labels(ax) == ["5 obstacles", "9 obstacles", "the paper's cases"]
    assert_allclose(ax.lines[1].get_xydata(), [(0, 1.1), (0.5, 1.05), (0.9, 1.01)])
    assert_allclose(ax.lines[2].get_xydata(), [(0.5, 0.9)])
    with pytest.raises(fs.InvalidParameter, match="judge_orders"):
        fs.plotting.plot_turns([{"n": 3}])
