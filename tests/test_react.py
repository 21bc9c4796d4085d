"""Driving by reactive laws: arrivals, published failures, collisions, and their study."""

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.data import DATA, read_csv, write_csv
from freeseg.react import CHECK_STEP, arc_points
from freeseg.studies import reacting, traps

LAWS = [fs.PotentialField(), fs.VectorFieldHistogram(), fs.DynamicWindow()]
NAMES = [type(law).__name__ for law in LAWS]
DISC = fs.World([fs.Disc((0.5, 0.03), 0.05)])


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_every_law_drives_past_a_disc(law):
    run = fs.react(law, DISC, (0, 0), (1, 0))
    assert isinstance(run, fs.Run)
    assert run.collision is None
    assert run.clearance > run.robot.radius
    assert np.hypot(*(run.pose[:2, -1] - (1, 0))) < 0.01
    # On the side on which there is more room, and hardly longer than it must be.
    assert run.pose[1].min() < -0.03
    driven = np.hypot(*np.diff(run.pose[:2])).sum()
    assert driven < 1.15 * fs.shortest_path(DISC, (0, 0), (1, 0)).path.length
    limits = run.robot.max_wheel_speed, run.robot.max_wheel_acceleration * 0.05
    assert np.abs(run.wheels).max() <= limits[0]
    assert np.abs(np.diff(run.wheels[:, :-1], prepend=0)).max() <= limits[1] * (1 + 1e-9)


TRAPS = traps.trap_worlds()
FAILURES = [(name, law) for name, laws in traps.TRAPPED.items() for law in laws]


@pytest.mark.parametrize(
    ("name", "law"), FAILURES, ids=[f"{name}-{type(law).__name__}" for name, law in FAILURES]
)
def test_published_failures_trap_the_laws_by_name(name, law):
    question = TRAPS[name]
    # There is a way, and a planner finds it.
    path = fs.shortest_path(*question).path
    with pytest.raises(fs.Trapped, match=type(law).__name__) as caught:
        fs.react(law, *question[:4], patience=5)
    run = caught.value.run
    # It stands, or comes and goes, until its patience ends. The track says so.
    assert run.collision is None
    left = np.hypot(*(run.pose[:2] - np.reshape(question.goal, (2, 1))))
    assert left[-1 - int(5 / 0.05) :].min() > left.min() - 0.01
    assert left[-1] > 0.01
    assert np.hypot(*(run.pose[:2, -1] - path.end)) > 0.01
    assert caught.value.steps == ()


@pytest.mark.parametrize("name", traps.SPARED)
def test_who_is_spared_arrives_where_the_other_law_fails(name):
    question = TRAPS[name]
    run = fs.react(traps.SPARED[name], *question[:4])
    assert run.collision is None
    assert {type(law) for law in traps.TRAPPED[name]} == {type(traps.SPARED[name])}


def test_traps_are_what_they_are_called():
    assert TRAPS.keys() == traps.TRAPPED.keys() > traps.SPARED.keys()
    # The goal is nearer to the disc than the fields reach, and the robot fits there.
    near = TRAPS["goal near an obstacle"]
    gap = near.world.distances(shapely.Point(near.goal)).min() - fs.KheperaIV().radius
    assert 0 < gap < traps.KHATIB.influence
    # The histogram cannot see the end of the corridor from its mouth.
    dead = TRAPS["dead end"].world
    ends = np.array([one.core.bounds for one in dead])
    assert ends[2, 0] - ends[0, 0] > fs.VectorFieldHistogram().reach
    # The robot fits through the side door with room on both sides; strong motors get it through.
    door = TRAPS["side door"]
    assert 1.3 * door.robot.diameter < 0.2
    assert fs.react(fs.DynamicWindow(), *door[:3]).collision is None
    # In Table 5 every free segment is danger.
    assert [step.kind for step in fs.plan(*TRAPS["Table 5"]).steps] == ["straight", "local minimum"]


def test_a_fast_robot_with_weak_brakes_sees_as_far_as_it_must():
    weak = fs.Robot(0.1054, 0.1408, 0.021, 47.61, 6)
    wall = fs.World([fs.Polygon([(1, -1), (1.1, -1), (1.1, 1), (1, 1)])])
    law = fs.DynamicWindow(speed=0.4)
    with pytest.raises(fs.Trapped) as caught:
        fs.react(law, wall, (0, 0), (1.5, 0), weak, patience=5)
    run = caught.value.run
    fastest = run.wheels.max()
    assert fastest**2 / (2 * weak.max_wheel_acceleration) > law.reach
    assert run.collision is None


class Blind:
    """Drive straight to the goal."""

    def start(self, scene, goal, robot, dt):
        return lambda t, pose: (0.2, 0.0)


def test_a_collision_is_found_whatever_the_law_says():
    run = fs.react(Blind(), DISC, (0, 0), (1, 0))
    assert run.clearance == pytest.approx(0.03 - 0.05, abs=1e-5)
    # The body meets the disc where its centre is as far from that of the disc as both radii.
    meets = 0.5 - np.sqrt((0.05 + run.robot.radius) ** 2 - 0.03**2)
    at = np.interp(run.collision, run.t, run.pose[0])
    assert meets <= at <= meets + CHECK_STEP
    assert "collision at" in repr(run)
    # The disc is too small and too near to be met at any of the times themselves.
    step = run.pose[0, 40], run.pose[0, 41]
    tiny = fs.World([fs.Disc((np.mean(step), run.robot.radius + 1e-5), 1.5e-5)])
    again = fs.react(Blind(), tiny, (0, 0), (1, 0))
    assert again.collision is not None
    assert tiny.distances(shapely.points(again.pose[:2].T)[:, None]).min() > run.robot.radius


def test_points_of_arcs_are_those_that_the_robot_drives_through():
    rng = np.random.default_rng(0)
    commands = rng.uniform(-0.3, 0.3, 30), rng.uniform(-8, 8, 30)
    run = fs.drive(lambda t, pose: [c[round(t / 0.05)] for c in commands], (1, 2, 3), 0.05, 30)
    points, t = arc_points(run)
    assert np.hypot(*np.diff(points, axis=0).T).max() <= CHECK_STEP * (1 + 1e-9)
    for place in range(0, len(t), 7):
        step = min(int(np.searchsorted(run.t, t[place], "right")) - 1, 29)
        moved = run.robot.move(run.pose[:, step], run.wheels[:, step], t[place] - run.t[step])
        assert_allclose(points[place], moved[:2], atol=1e-12)


def test_a_law_that_stands_or_creeps_is_trapped():
    class Still(Blind):
        def start(self, scene, goal, robot, dt):
            return lambda t, pose: (0.0, 0.0)

    with pytest.raises(fs.Trapped) as caught:
        fs.react(Still(), DISC, (0, 0), (1, 0), patience=2)
    assert caught.value.run.t[-1] == pytest.approx(2)
    with pytest.raises(fs.Trapped) as caught:
        fs.react(Blind(), DISC, (0, 0), (1, 0), limit=1)
    assert caught.value.run.t[-1] == pytest.approx(1)
    # Who has passed the goal comes no nearer.
    with pytest.raises(fs.Trapped):
        fs.react(Blind(), DISC, (0, 0, 0), (1, 0.02), patience=1)


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_noise_and_lag_are_those_of_the_trackers(law):
    disturbance = fs.Disturbance(
        position_noise=0.001, heading_noise=0.01, slip=0.05, lag=0.05, delay=0.05
    )
    run = fs.react(law, DISC, (0, 0), (1, 0), disturbance=disturbance, seed=3)
    again = fs.react(law, DISC, (0, 0), (1, 0), disturbance=disturbance, seed=3)
    assert (run.pose == again.pose).all()
    assert run.collision is None
    noise = run.measured - run.pose
    assert 0.0008 < noise[:2].std() < 0.0012
    other = fs.react(law, DISC, (0, 0), (1, 0), disturbance=disturbance, seed=4)
    assert run.pose.shape != other.pose.shape or (run.pose != other.pose).any()


#: The disc comes from below, and is out of the way in the end.
CROSSING = fs.Scene(fs.World([]), [fs.Mover(fs.Disc((0.5, -0.7), 0.05), velocity=(0, 0.15))])


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_what_moves_is_seen_where_it_is(law):
    blind = fs.react(Blind(), CROSSING, (0.0, 0), (1, 0))
    assert blind.collision is None
    run = fs.react(law, CROSSING, (0, 0), (1, 0))
    still = fs.react(law, fs.World([]), (0, 0), (1, 0))
    assert run.pose.shape != still.pose.shape
    assert run.clearance > 0


def test_questions_that_make_no_sense_are_refused():
    law, ends = fs.PotentialField(), ((0, 0), (1, 0))
    with pytest.raises(fs.InvalidParameter, match="reactive is"):
        fs.react(fs.SlidingMode(), DISC, *ends)
    with pytest.raises(fs.InvalidParameter, match="reactive is"):
        fs.react(fs.PotentialField, DISC, *ends)
    with pytest.raises(fs.InvalidQuery, match="start"):
        fs.react(law, DISC, (0.5, 0), (1, 0))
    with pytest.raises(fs.InvalidQuery, match="goal"):
        fs.react(law, DISC, (0, 0), (0.5, 0.1))
    with pytest.raises(fs.InvalidQuery, match="scene"):
        fs.react(law, [DISC], *ends)
    for name in ("tolerance", "patience", "limit", "dt"):
        with pytest.raises(fs.InvalidParameter, match=name):
            fs.react(law, DISC, *ends, **{name: 0})
    with pytest.raises(fs.InvalidParameter, match="limit"):
        fs.react(law, DISC, *ends, limit=1e9)


# The study.


def test_tasks_can_be_done_and_are_the_same_again():
    tasks = reacting.random_tasks(3, 5)
    again = reacting.random_tasks(3, 5)
    for task, other in zip(tasks, again, strict=True):
        assert task.shortest >= reacting.WORTH
        best = fs.shortest_path(task.world, task.start, task.goal).path.length
        assert task.shortest == best == other.shortest
    with pytest.raises(fs.InvalidParameter, match="n is 0"):
        reacting.random_tasks(1, 0, n=0)


def test_a_failure_counts_as_such():
    world = fs.World([])
    straight = reacting.Task(world, np.zeros(2), np.array([0.5, 0.0]), 0.5)
    blocked = reacting.Task(DISC, np.zeros(2), np.array([1.0, 0.0]), 1.0)
    assert reacting.score(Blind(), [straight]) == pytest.approx(1, abs=0.03)
    assert reacting.score(Blind(), [blocked]) == reacting.FAILED
    assert reacting.score(Blind(), [straight, blocked]) == pytest.approx(2, abs=0.02)
    _, arrived = reacting.attempt(Blind(), blocked)
    assert not arrived
    with pytest.raises(fs.InvalidParameter, match="tasks is"):
        reacting.score(Blind(), [])


def test_the_search_finds_the_least_cost():
    ranges = {"one": (0.01, 100), "other": (0.1, 10)}

    def cost(gains):
        return np.log10(gains["one"] / 2) ** 2 + np.log10(gains["other"] * 3) ** 2

    first = {"one": 50, "other": 5}
    gains, least = reacting.search(cost, ranges, first, 0, 480)
    assert least == pytest.approx(cost(gains))
    assert least < 1e-3 < cost(first)
    assert reacting.search(cost, ranges, first, 0, 480) == (gains, least)
    with pytest.raises(fs.InvalidParameter, match="first one"):
        reacting.search(cost, ranges, {"one": 1000, "other": 1}, 0, 16)
    with pytest.raises(fs.InvalidParameter, match="budget"):
        reacting.search(cost, ranges, first, 0, 20)


def test_the_defaults_are_within_the_ranges_of_the_search():
    for name, ranges in reacting.GAIN_RANGES.items():
        law = getattr(fs, name)()
        for gain, (low, high) in ranges.items():
            assert low <= getattr(law, gain) <= high, (name, gain)


@pytest.fixture(scope="module")
def tuned():
    return reacting.load_laws()


def test_stored_gains_are_what_the_study_drives_by(tuned):
    rows = read_csv(
        DATA / "reactive_gains.csv",
        {"tuned_for": str, "law": str, "gain": str, "value": float}
        | {"score_before": float, "score": float},
    )
    assert tuned.keys() == reacting.TUNED_FOR.keys()
    for row in rows:
        low, high = reacting.GAIN_RANGES[row["law"]][row["gain"]]
        assert low <= row["value"] <= high
        assert 1 <= row["score"] <= row["score_before"] <= reacting.FAILED
        name = next(name for name, law in reacting.REACTIVE.items() if law == row["law"])
        assert getattr(tuned[row["tuned_for"]][name], row["gain"]) == row["value"]
    rivals = reacting.reactive_rivals()
    assert rivals.keys() == reacting.REACTIVE.keys() == reacting.KNOWS.keys()
    for name, rival in rivals.items():
        assert rival.keywords["laws"] == {aim: tuned[aim][name] for aim in tuned}
    # All laws drive at the same top speed, and keep their other gains.
    speeds = {law.speed for laws in tuned.values() for law in laws.values()}
    assert speeds == {fs.PotentialField().speed}


def test_rivals_drive_by_the_gains_for_their_robot(tuned):
    world, ends = fs.World([]), ((0, 0), (0.5, 0))
    wide = fs.KheperaIV(diameter=0.4)
    for name, rival in reacting.reactive_rivals().items():
        for robot, aim in ((None, "random"), (wide, "barn")):
            run = rival(world, *ends, robot, 0.005)
            again = fs.react(tuned[aim][name], world, *ends, robot, patience=reacting.PATIENCE)
            assert (run.pose == again.pose).all()
            assert run.robot == again.robot


def test_other_gains_are_refused(tmp_path):
    rows = read_csv(
        DATA / "reactive_gains.csv", {"tuned_for": str, "law": str, "gain": str, "value": float}
    )
    rows = [{name: value for name, value in row.items() if name != "row"} for row in rows]
    file = tmp_path / "gains.csv"
    for change in ({"law": "Bug"}, {"gain": "speed"}, {"value": 1e6}, {"tuned_for": "others"}):
        write_csv(file, [*rows[:-1], rows[-1] | change])
        with pytest.raises(fs.InvalidData):
            reacting.load_laws(file)
    for wrong, said in (([*rows, rows[0]], "second"), (rows[:-1], "lacks gains")):
        write_csv(file, wrong)
        with pytest.raises(fs.InvalidData, match=said):
            reacting.load_laws(file)
    low = next(row for row in rows if row["gain"] == "low")
    high = {"gain": "high", "value": 0.5}
    crossed = [
        row
        | ({"value": 5.0} if row is low else {})
        | (high if row["gain"] == "high" and row["law"] == low["law"] else {})
        for row in rows
    ]
    write_csv(file, crossed)
    with pytest.raises(fs.InvalidData, match="low is 5"):
        reacting.load_laws(file)


def test_rooms_like_barn_are_crossed_by_the_wide_robot():
    for seed in range(3):
        world = reacting.room_like_barn(seed)
        centers = np.array([disc.center for disc in world])
        # Walls on three sides, open where the robot leaves; the way in is free.
        assert centers.min(0) == pytest.approx(reacting.FIRST)
        inside = (np.abs(centers[:, 0] + 2.25) < 2) & (centers[:, 1] > 0.1)
        assert centers[inside, 1].min() > 5
        assert world.distances(shapely.Point(reacting.ACROSS[0])).min() > 0.215
    assert len(reacting.room_like_barn(1)) != len(reacting.room_like_barn(2))
    for name, robot in reacting.TUNED_FOR.items():
        tasks = reacting.training_tasks(name)
        assert len(tasks) == reacting.TASKS[name] * (3 if name == "random" else 1)
        assert {task.robot for task in tasks} == {robot}


def test_a_search_of_gains_is_never_worse_than_the_defaults(monkeypatch):
    tasks = (reacting.Task(DISC, np.zeros(2), np.array([1.0, 0.0]), 1.0),)
    tried = []
    score = reacting.score
    monkeypatch.setattr(reacting, "score", lambda law, t: tried.append(law) or score(law, t))
    gains, found = reacting.tune("PotentialField", tasks, 0, 16)
    # The defaults are the first that is tried, thresholds in the wrong order cost no run.
    assert tried[0] == fs.PotentialField()
    assert len(tried) == 16
    assert found == score(fs.PotentialField(**gains), tasks) <= score(fs.PotentialField(), tasks)
