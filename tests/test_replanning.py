"""Laws among movers: timed references, observed scenes, planning again, and following a plan."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.following import Following, scene_after
from freeseg.reference import timed_reference
from freeseg.replanning import Estimates, Replanning, observe
from freeseg.studies import moving

#: Who drives straight from (0, 0) to (1, 0) at 0.1 m/s meets this one half way.
CROSSING = fs.Scene(fs.World([]), [fs.Mover(fs.Disc((0.5, 0.3), 0.05), velocity=(0, -0.06))])
START, GOAL = (0, 0), (1, 0)


def gate(velocity=(0.0, -0.02)):
    """A wall with one gap, in which a mover stands at first."""
    walls = [
        fs.Polygon([(0.45, y), (0.55, y), (0.55, y + 2), (0.45, y + 2)]) for y in (0.15, -2.15)
    ]
    return fs.Scene(fs.World(walls), [fs.Mover(fs.Disc((0.5, 0), 0.05), velocity=velocity)])


def test_a_straight_timed_reference_ramps_up_and_down():
    plan = fs.time_minimal_plan(fs.World([]), START, GOAL, speed=0.1)
    reference = timed_reference(plan, acceleration=0.2)
    assert reference.duration == pytest.approx(10 + 0.5)
    assert_allclose(reference.at([0.25, 5, 10.25]).v, [0.05, 0.1, 0.05], rtol=1e-3)
    assert_allclose(reference.at(0.25).v_dot, 0.2, rtol=1e-2)
    # In the middle it is where the plan was a quarter of a second before.
    assert_allclose(reference.at(5).pose, [0.475, 0, 0], atol=1e-6)
    assert_allclose(reference.pose[:, -1], [1, 0, 0], atol=1e-9)
    assert reference.shift == pytest.approx(0.1 * 0.5 / 8, rel=1e-2)
    assert reference.robot == plan.robot


def test_a_timed_reference_keeps_clear_of_the_mover_it_slides_on():
    later = scene_after(CROSSING, 0.1)
    plan = fs.time_minimal_plan(later, START, GOAL, speed=0.1, margin=0.01)
    assert plan.turns
    reference = timed_reference(plan, acceleration=0.5)
    gaps = CROSSING.distances(reference.pose[:2].T, reference.t)
    assert gaps.min() > plan.robot.radius
    wheels = plan.robot.to_wheels(reference.v, reference.omega)
    assert np.abs(wheels).max() < plan.robot.max_wheel_speed


def test_a_timed_plan_that_bends_sharply_is_driven_more_gently():
    # It waits for a gap, and turns there.
    task = moving.random_task(517)
    law, robot = Following(timed=True), fs.KheperaIV()
    plan = fs.time_minimal_plan(task.scene, task.start, task.goal, 0.098, robot, law.margin)
    sharp = timed_reference(plan, law.acceleration)
    assert np.abs(sharp.omega).max() > 5
    driven = law._reference(task.scene, task.start, task.goal, robot)
    assert np.abs(driven.omega).max() < 3
    run = fs.react(law, task.scene, task.start, task.goal, dt=moving.TICK)
    assert run.collision is None
    # Where nothing bends, nothing is lost.
    alone = law._reference(fs.Scene(fs.World([])), np.zeros(2), np.array([1.0, 0]), robot)
    assert alone.duration == pytest.approx(1 / 0.098 + 0.098 / law.acceleration)


@pytest.mark.parametrize("acceleration", [0, -1, np.nan, 1e3, "1"])
def test_accelerations_that_no_wheel_does_are_refused(acceleration):
    plan = fs.time_minimal_plan(fs.World([]), START, GOAL, speed=0.1)
    with pytest.raises(fs.InvalidParameter, match="acceleration"):
        timed_reference(plan, acceleration)


def test_a_plan_is_followed_that_waits_on_a_corner_which_stops_and_comes_back():
    # There the reference turns round at once, faster than its poses can tell.
    task = moving.random_task(160)
    law = Following(timed=True).start(task.scene, task.goal, fs.KheperaIV(), moving.TICK)
    assert np.isfinite(law(0.0, np.array([*task.start, 0.0]))).all()


def test_a_timed_reference_is_of_a_timed_plan():
    with pytest.raises(fs.InvalidParameter, match="plan is"):
        timed_reference(fs.shortest_path(fs.World([]), START, GOAL))


def test_what_is_observed_is_noisy_and_the_same_for_all():
    t = 0.05 * np.arange(400)
    seen = observe(CROSSING, noise=0.002, seed=1)
    error = np.array([seen.movers[0].at(time).center for time in t])
    error -= [CROSSING.movers[0].at(time).center for time in t]
    assert_allclose(error.std(0), 0.002, rtol=0.15)
    assert np.abs(error.mean(0)).max() < 5e-4
    again = observe(CROSSING, noise=0.002, seed=1)
    assert_allclose(again.movers[0].at(7.0).center, seen.movers[0].at(7.0).center, rtol=0)
    other = observe(CROSSING, noise=0.002, seed=2)
    assert (other.movers[0].at(7.0).center != seen.movers[0].at(7.0).center).any()
    exact = observe(CROSSING, noise=0)
    assert_allclose(exact.distances(START, t), CROSSING.distances(START, t), atol=1e-12)


def test_movers_that_are_no_discs_are_refused():
    square = fs.Polygon([(0.4, 0.3), (0.5, 0.3), (0.5, 0.4)])
    scene = fs.Scene(fs.World([]), [fs.Mover(square, velocity=(0, -0.01))])
    with pytest.raises(fs.InvalidWorld, match="Disc"):
        observe(scene)
    with pytest.raises(fs.InvalidWorld, match="Disc"):
        Replanning().start(scene, GOAL, fs.KheperaIV(), 0.05)


@pytest.mark.parametrize(("noise", "off"), [(0.0, 1e-3), (0.002, 5e-3)])
def test_velocities_are_estimated_from_places(noise, off):
    estimates = Estimates(observe(CROSSING, noise, seed=3), 0.05, noise, 0.1)
    for t in 0.05 * np.arange(60):
        mover = estimates.at(t).movers[0]
    assert_allclose(mover.velocity, (0, -0.06), atol=off)
    assert_allclose(mover.obstacle.center, CROSSING.movers[0].at(t).center, atol=0.002)
    # Whoever asks again at the same time is told the same.
    assert estimates.at(t).movers[0] is mover


def test_no_estimate_is_faster_than_what_moves():
    wild = observe(CROSSING, noise=0.2, seed=0)
    estimates = Estimates(wild, 0.05, 1e-6, 0.1)
    paces = [np.hypot(*estimates.at(t).movers[0].velocity) for t in 0.05 * np.arange(20)]
    assert max(paces) <= 0.1 * (1 + 1e-9)


def test_planning_again_lets_a_mover_cross():
    best = fs.time_minimal_plan(CROSSING, START, GOAL, speed=0.1, margin=0).arrival
    run = fs.react(Replanning(noise=0.0), CROSSING, START, GOAL)
    assert run.collision is None
    assert best - 0.1 - 0.05 <= run.t[-1] < 1.03 * best
    assert np.hypot(*np.diff(run.pose[:2])).max() <= 0.1 * 0.05 * (1 + 1e-9)


def test_without_movers_it_drives_the_shortest_path():
    world = fs.World([fs.Disc((0.5, 0.02), 0.1)])
    run = fs.react(Replanning(), world, START, GOAL)
    length = fs.shortest_path(world, START, GOAL, margin=0.01).path.length
    driven = np.hypot(*np.diff(run.pose[:2])).sum()
    assert length - 0.011 < driven < 1.01 * length


def test_it_waits_for_a_gap_that_opens():
    run = fs.react(Replanning(noise=0.0), gate(), START, GOAL)
    assert run.collision is None
    # The mover frees the gap when there is room for the robot above it.
    passed = run.t[np.argmax(run.pose[0] > 0.5)]
    robot = run.robot.radius
    opens = (0.05 + 2 * robot - 0.15) / 0.02
    assert passed > opens


@pytest.mark.parametrize("fallback", ["keep", "brake"])
def test_what_it_does_without_a_plan_is_counted(fallback):
    law = Replanning(noise=0.0, fallback=fallback).start(CROSSING, GOAL, fs.KheperaIV(), 0.05)
    assert law(0.0, np.zeros(3))[0] > 0
    assert (law.planned, law.missed) == (1, 0)
    # As if the robot was in the mover.
    command = law(0.05, np.array([0.5, 0.29, 0.0]))
    assert (law.planned, law.missed) == (1, 1)
    assert command == (0.0, 0.0) if fallback == "brake" else command[1] != 0


@pytest.mark.parametrize(
    ("name", "value"),
    [("speed", 0), ("margin", -1), ("noise", np.nan), ("reach", 0), ("ahead", 0), ("fallback", 1)],
)
def test_gains_of_planning_again_are_checked(name, value):
    with pytest.raises(fs.InvalidParameter, match=name):
        Replanning(**{name: value})


def test_doing_nothing_collides_and_knowing_does_not():
    blind = fs.react(Following(), CROSSING, START, GOAL)
    assert blind.collision == pytest.approx(4.5, abs=1)
    best = fs.time_minimal_plan(CROSSING, START, GOAL, speed=0.1, margin=0).arrival
    told = fs.react(Following(timed=True), CROSSING, START, GOAL)
    assert told.collision is None
    assert told.t[-1] < 1.06 * best


@pytest.mark.parametrize("timed", [True, False])
@pytest.mark.parametrize("heading", [2.0, -0.7])
def test_who_follows_turns_in_place_first(timed, heading):
    run = fs.react(Following(timed=timed), fs.World([]), (*START, heading), GOAL)
    moving = np.hypot(*run.pose[:2]) > 1e-4
    begin = int(np.argmax(moving))
    assert abs(run.pose[2, begin]) < 0.1
    # 2.5 rad/s, and what the wheels need to get going.
    assert run.t[begin] == pytest.approx(abs(heading) / 2.5, abs=0.15)
    assert np.abs(run.pose[1]).max() < 0.005


def test_the_time_of_the_turn_is_in_the_plan():
    """A mover that is past the straight way at once, but not for who has to turn round first."""
    scene = fs.Scene(fs.World([]), [fs.Mover(fs.Disc((0.35, 0.33), 0.05), velocity=(0, -0.06))])
    run = fs.react(Following(timed=True), scene, (*START, np.pi), GOAL)
    assert run.collision is None
    assert run.clearance > run.robot.radius + 0.003


def test_an_mpc_that_foresees_movers_keeps_out_of_them():
    seen = observe(CROSSING, noise=0.002, seed=0)
    mpc = fs.Mpc(horizon=20, nearest=1)
    run = fs.react(Following(mpc, keep_out=True), seen, START, GOAL)
    assert CROSSING.clearance(run) > run.robot.radius
    assert np.abs(run.wheels.mean(0)).max() <= 0.1 * (1 + 1e-9)


@pytest.mark.parametrize(
    "given", [{"tracker": 1}, {"keep_out": True}, {"reserve": 1}, {"speed": 0}, {"timed": 2}]
)
def test_what_cannot_follow_is_refused(given):
    with pytest.raises(fs.InvalidParameter, match=next(iter(given)).replace("keep_out", "tracker")):
        Following(**given)
