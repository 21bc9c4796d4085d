"""Lesson 09, its own lines: references, the loop, what comes back, and what disturbs."""

from itertools import product

import matplotlib.pyplot as plt
import numpy as np
import pytest
from lessons import definitions

import freeseg as fs
from freeseg import plotting
from freeseg.path import Arc, taut_path
from freeseg.plotting.figures import turns_of
from freeseg.reference import Reference, Sample

STEM = "09_track_the_planned_paths"
NAMES = ["robot", "dt", "gains", "cases", "worlds", "plans", "smoothed", "gaps", "steps", "smooth"]
NAMES += ["drive", "runs", "leads", "disturbances", "corners", "disturbed", "late", "widths"]
FREE = fs.KheperaIV(max_wheel_rate_change=1e6)


@pytest.fixture(scope="module")
def own():
    """What the lesson defines."""
    return definitions(STEM, *NAMES)


@pytest.mark.parametrize("name", ["15a", "16b"])
def test_the_smoothed_reference_keeps_its_limits_and_its_clearance(own, name):
    robot = own["robot"]
    for kind in ("steps", "smooth"):
        reference = own[kind][name]
        wheels = robot.to_wheels(reference.v, reference.omega)
        steepest = np.abs(np.diff(wheels) / np.diff(reference.t)).max()
        within = steepest <= robot.max_wheel_acceleration * (1 + 1e-6)
        assert within == (kind == "smooth")
        assert np.abs(wheels).max() <= robot.max_wheel_speed
        assert reference.shift <= 0.0007
        assert own["gaps"](name, reference.pose).min() >= 0


def test_a_wider_average_moves_the_path_farther(own):
    shifts = [own["smoothed"]("15a", width).shift for width in own["widths"]]
    assert (np.diff(shifts) > 0).all()
    assert shifts[-1] < 0.002


@pytest.mark.parametrize("name", ["15a", "16b"])
def test_the_loop_is_that_of_the_package_and_asks_for_no_more_than_the_wheels_can(own, name):
    off, variation = {}, {}
    for kind in ("steps", "smooth"):
        reference = own[kind][name]
        run = fs.simulate(own["gains"], reference, own["robot"], own["dt"])
        error = own["drive"](own["gains"], reference)
        np.testing.assert_allclose(run.error, error, rtol=0, atol=1e-12)
        numbers = fs.metrics.tracking(run)
        off[kind] = 1000 * numbers["position_rms_m"]
        wanted = own["robot"].to_wheels(reference.v, reference.omega)
        variation[kind] = numbers["wheel_variation_m_s"] / np.abs(np.diff(wanted)).sum(1).max()
        # For any robot, so that one without a limit of acceleration may follow it.
        loose = Reference(*(getattr(reference, field) for field in ("t", *Sample._fields)))
        free = fs.simulate(own["gains"], loose, FREE, own["dt"])
        np.testing.assert_allclose(free.wheels, run.wheels, rtol=0, atol=1e-12)
    assert off["steps"] > 5 * off["smooth"]
    assert off["steps"] <= 1.2
    assert max(variation.values()) <= 1.3
    assert np.hypot(*error[:2]).max() <= 0.0005


def test_the_errors_vanish_from_near_by(own):
    for run in own["runs"].values():
        assert np.hypot(*run.error[:2, -1]) < 0.001
        assert abs(run.error[2, -1]) < np.radians(0.1)


def test_who_leads_is_the_sense_of_the_turn_and_nobody_leads_between(own):
    assert own["leads"] == ["left at 1", "right at 2"]
    for name, plan in own["plans"].items():
        reference = own["smooth"][name]
        run = fs.simulate(own["gains"], reference, own["robot"], own["dt"])
        turns = turns_of(reference)
        assert len(turns) == len(plan.turning_points)
        for (first, last), turn in zip(turns, plan.turning_points, strict=True):
            right, left = run.wheels[:, (run.t > first) & (run.t < last - own["dt"])].mean(1)
            assert (right > left) == (turn.sense > 0)
        straight = np.abs(reference.at(run.t[:-1] + own["dt"] / 2).omega) < 1e-9
        assert np.abs(run.wheels[0] - run.wheels[1])[:-1][straight].max() < 0.002


@pytest.mark.parametrize("name", ["15a", "16b"])
def test_all_come_back_from_within_100_mm_and_the_lost_start_ahead(own, name):
    reach = np.linspace(-0.6, 0.6, 21)
    ahead, left = (grid.ravel() for grid in np.meshgrid(reach, reach))
    start = ahead, left, 0 * ahead
    run = fs.simulate(own["gains"], own["smooth"][name], own["robot"], own["dt"], start)
    final = np.hypot(*run.error[:2, :, -1])
    assert (final[np.hypot(ahead, left) <= 0.1] < 0.01).all()
    assert (ahead[final > 0.1] > 0).mean() > 0.9


@pytest.mark.parametrize("name", ["15a", "16b"])
def test_disturbances_leave_millimetres_along_the_path_and_no_collision(own, name):
    singles = {}
    for label, what in own["disturbances"].items():
        corners = own["corners"][:, :80]
        start = corners if label in ("offset", "all") else np.zeros((3, 80))
        run, rms, gap = own["disturbed"](name, own["gains"], start, **what)
        assert rms.max() < 0.005
        assert gap.min() > 0
        singles[label] = np.median(rms)
    assert max(list(singles)[1:-1], key=singles.get) == "slip"
    late = run.t > 4
    along, across = np.sqrt((run.error[:2][..., late] ** 2).mean((1, 2)))
    assert along > 2 * across
    spare = own["gaps"](name, own["smooth"][name].pose).min()
    assert 0 < gap.min() < spare
    assert (np.hypot(*run.error[:2])[:, late].max(-1) > spare).mean() > 0.9
    start = np.zeros((3, 80))
    constant = own["disturbed"](name, own["gains"], start, slip=(0.05, 0.02))
    assert constant[1].max() < 0.005


def test_being_told_of_the_delay_helps(own):
    for delay in (0.1, 0.3):
        plain, told = (
            fs.metrics.tracking(own["late"](delay, tracker))["position_rms_m"]
            for tracker in (own["gains"], fs.Predicting(own["gains"], delay))
        )
        assert told < plain / 5


def test_backing_up_is_short(own):
    start = (0.02, 0, 0)
    run = fs.simulate(own["gains"], own["smooth"]["15a"], own["robot"], own["dt"], start)
    forwards = np.flatnonzero(run.wheels.mean(0) > 0)[0]
    assert 0 < run.t[forwards] < 0.5
    assert run.error[0, forwards] < -0.005


def test_no_tight_path_of_16b_without_a_long_turn_leads_as_told(own):
    world, case, plan = own["worlds"]["16b"], own["cases"]["16b"], own["plans"]["16b"]
    circles = [(disc.center, disc.radius + plan.turning_radius) for disc in world]
    found = []
    for third in (None, *range(2, 7)):
        for senses in product((1, -1, 0), (1, -1, 0), (0,) if third is None else (1, -1)):
            order = [(circles[k], s) for k, s in zip((0, 1, third), senses, strict=True) if s]
            turns = [(center, sense * radius) for (center, radius), sense in order]
            path, _ = taut_path(case.start, turns, case.goal)
            if path is not None and path.clearance(world) >= own["robot"].radius:
                arcs = [abs(one.sweep) for one in path.pieces if isinstance(one, Arc)]
                score = sum(s == said for s, said in zip(senses, (1, 1, -1), strict=True))
                found.append((score, path.length, max(arcs, default=0), third))
    assert min(length for _, length, *_ in found) == pytest.approx(plan.path.length)
    assert {third for score, *_, third in found if score == 3} == {2}
    short = [one for one in found if one[2] <= np.pi]
    assert max(score for score, *_ in short) == 2
    assert {third for score, *_, third in short if score == 2} == {2}


def test_pictures_show_what_they_are_given(own):
    run, reference, plan = own["runs"]["16b"], own["smooth"]["16b"], own["plans"]["16b"]
    above, below = plotting.plot_reference(reference, own["robot"])
    assert np.nanmax(above.lines[1].get_ydata()) == pytest.approx(
        1 / plan.turning_points[1].radius, rel=0.01
    )
    assert len(below.lines) == 2
    ax = plotting.plot_leads(run, reference, plan)
    assert [text.get_text() for text in ax.texts] == ["obstacle 1", "obstacle 2"]
    assert len(ax.patches) == 2
    with pytest.raises(fs.InvalidParameter, match="the reference of this plan"):
        plotting.plot_leads(run, reference, own["plans"]["15a"])
    above, below = plotting.plot_pull(run, most=0.04, wheels=0.2)
    assert above.get_ylim() == (-0.01, 0.04)
    assert below.get_ylim() == (-0.05, 0.2)
    ax = plotting.plot_across({"one": run, "two": run})
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["one", "two"]
    plt.close("all")


def test_bands_hold_the_shares_they_are_named_after():
    values = np.arange(101.0)[:, None] * np.ones(3)
    ax = plotting.plot_quantiles([0, 1, 2], values)
    spans = [band.get_paths()[0].get_extents().intervaly for band in ax.collections]
    np.testing.assert_allclose(spans, [(0, 100), (5, 95), (25, 75)])
    assert [band.get_label() for band in ax.collections] == ["all", "90 %", "50 %"]
    np.testing.assert_allclose(ax.lines[0].get_ydata(), 50)
    plt.close("all")


def test_a_map_of_starts_has_a_cell_for_each():
    ax = plotting.plot_starts([-0.1, 0, 0.1], np.arange(9).reshape(3, 3) / 1000)
    assert ax.collections[0].get_array().size == 9
    with pytest.raises(fs.InvalidParameter, match="do not increase"):
        plotting.plot_starts([0.1, 0], np.zeros((2, 2)))
    plt.close("all")
