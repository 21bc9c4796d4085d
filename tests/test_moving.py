"""The study among movers: scenes, bounds, outcomes, and what is concluded from rows."""

import math

import numpy as np
import pytest

import freeseg as fs
from freeseg.following import Following
from freeseg.studies import moving


def row(scene=0, method="a", outcome="arrived", **other):
    """A row of the study."""
    head = {
        "scene": scene, "movers": 2, "ratio": 0.4, "possible": "yes", "proved": True,
        "bound_s": 10.1, "static_s": 10.0, "method": method, "noise_m": 0.002,
    }  # fmt: skip
    arrival = {"arrival_s": 11.0} if outcome == "arrived" else {}
    return head | moving.NOT_DRIVEN | {"outcome": outcome, "ticks": 100} | arrival | other


def test_scenes_are_the_same_for_a_number_and_of_every_kind():
    tasks = [moving.random_task(number) for number in range(6)]
    kinds = {(task.movers, task.ratio) for task in tasks}
    assert kinds == {(m, r) for m in moving.CROWDS for r in moving.RATIOS}
    for task in tasks:
        assert len(task.scene.movers) == task.movers
        paces = [math.hypot(*mover.velocity) for mover in task.scene.movers]
        np.testing.assert_allclose(paces, task.ratio * 0.1)
    again = moving.random_task(5)
    assert again.scene.distances((0, 0), 1).tolist() == tasks[5].scene.distances((0, 0), 1).tolist()


def test_bounds_are_ordered_and_an_overrun_is_recognised():
    task = moving.random_task(3)
    found = moving.bound(task)
    assert found["possible"] == "yes"
    assert found["static_s"] <= found["bound_s"] * (1 + 1e-9)
    on_it = fs.Scene(fs.World([]), [fs.Mover(fs.Disc(task.start, 0.05), velocity=(0.01, 0))])
    assert moving.bound(task._replace(scene=on_it))["possible"] == "overrun"


def test_a_scene_without_a_way_is_no_failure_of_a_method():
    wall = [(-0.05, -1), (0.05, -1), (0.05, 1), (-0.05, 1), (0, 1.1), (0, -1.1)]
    ring = fs.World([fs.Polygon(wall[:4])], boundary=[(-1, -1), (2, -1), (2, 1), (-1, 1)])
    task = moving.MovingTask(fs.Scene(ring), np.array([-0.5, 0]), np.array([1.0, 0]), 0, 0.4)
    assert moving.bound(task)["possible"] == "no"


def test_the_score_of_a_search_is_the_arrival_over_the_bound_and_three_for_a_failure():
    drives = moving.compare([1, 2, 3], {"law": Following()})
    assert {row["outcome"] for row in drives if row["possible"] == "yes"} == {"arrived", "collided"}
    scores = [
        min(row["arrival_s"] / row["bound_s"], 3.0) if row["outcome"] == "arrived" else 3.0
        for row in drives
        if row["possible"] == "yes"
    ]
    assert moving.score_among_movers(Following(), [1, 2, 3]) == pytest.approx(np.mean(scores))
    with pytest.raises(fs.InvalidParameter, match="numbers has no scene"):
        moving.score_among_movers(Following(), [])


def test_all_that_have_gains_drive_with_those_found_for_movers():
    gains, made = moving.load_gains(), moving.methods()
    assert gains.keys() == {*moving.MOVERS_RANGES, "ORCA"}
    for name, ranges in moving.MOVERS_RANGES.items():
        assert gains[name].keys() == ranges.keys()
        assert all(low <= gains[name][gain] <= high for gain, (low, high) in ranges.items())
        assert repr(made[name]) == repr(moving.with_gains(name, gains[name]))
    with pytest.raises(fs.InvalidParameter, match="choose one of"):
        moving.with_gains("ORCA", gains["ORCA"])


@pytest.mark.parametrize(
    ("was", "now", "named"),
    [
        ("MPC,horizon,", "MPC,reach,", "no gain within its range"),
        ("ORCA,turn_rate,", "ORCA,turn_rate,-", "no gain within its range"),
        ("ORCA,", "Orca,", "no gain within its range"),
    ],
)
def test_gains_that_no_search_found_are_refused(was, now, named, tmp_path):
    text = moving.MOVERS_GAINS.read_text()
    (tmp_path / "gains.csv").write_text(text.replace(was, now))
    with pytest.raises(fs.InvalidData, match=named):
        moving.load_gains(tmp_path / "gains.csv")
    (tmp_path / "gains.csv").write_text("".join(text.splitlines(True)[:-1]))
    with pytest.raises(fs.InvalidData, match="lacks gains of ORCA"):
        moving.load_gains(tmp_path / "gains.csv")


def test_blind_drives_are_judged_by_the_true_scene():
    found = moving.compare([1, 3], {"nothing": Following()})
    assert [tuple(row) for row in found] == [tuple(moving.FORM)] * 2
    overrun = [row for row in found if row["possible"] == "overrun"]
    assert all(row["outcome"] == "not driven" for row in overrun)
    for result in found:
        if result["outcome"] == "arrived":
            assert result["arrival_s"] > result["static_s"] - 0.1
            assert result["clearance_m"] >= 0.0704


class TooFast:
    """Drive straight at twice the speed allowed."""

    def start(self, scene, goal, robot, dt):
        return lambda t, pose: (0.2, 0.0)


def test_nobody_is_faster_than_the_study_allows():
    (found,) = moving.drive_all(3, {"fast": TooFast()})
    # It may leave the goal to one side, but not be there before a robot at the top speed.
    assert not found["arrival_s"] < found["static_s"] - 0.1


def test_summary_of_known_rows():
    rows = [
        row(0),
        row(1, arrival_s=12.0, proved=False),
        row(2, outcome="collided"),
        row(3, outcome="late", missed=50),
        row(4, outcome="not driven", possible="overrun", ticks=0),
        row(5, outcome="gave up", possible="no", ticks=0),
    ]
    (found,) = moving.summarise(rows)
    assert (found["scenes"], found["impossible"]) == (6, 2)
    assert found["collided"].share == found["arrived"].share / 2 == 0.25
    assert found["collided"].low < 0.25 < found["collided"].high
    assert found["delay"] == pytest.approx(0.15)
    assert found["delay_low"] <= 0.15 <= found["delay_high"]
    assert (found["proved"], found["proved_delay"]) == (1, pytest.approx(0.1))
    assert found["missed"] == pytest.approx(50 / 400)
    every = moving.summarise([*rows, *(r | {"movers": 4} for r in rows)], by=())
    assert every[0]["scenes"] == 12


def test_a_method_is_compared_in_the_same_scenes():
    good = [row(scene, "good") for scene in range(20)]
    bad = [row(scene, "bad", "collided") for scene in range(20)]
    (found,) = moving.pairs(good + bad)
    assert (found.first, found.second, found.mean) == ("good", "bad", 1.0)
    with pytest.raises(fs.InvalidParameter, match="lacks a method"):
        moving.pairs(good + bad[1:])


def test_rows_survive_the_file(tmp_path):
    rows = [row(0), row(1, outcome="collided", collision_s=3.5)]
    moving.save_drives(rows, tmp_path / "drives.npz")
    loaded = moving.load_drives(tmp_path / "drives.npz")
    assert str(loaded) == str([{name: one[name] for name in moving.FORM} for one in rows])
    (tmp_path / "broken.npz").write_bytes(b"no")
    with pytest.raises(fs.InvalidData, match=r"broken\.npz cannot be read"):
        moving.load_drives(tmp_path / "broken.npz")


def test_what_is_stored_is_of_these_scenes():
    rows = moving.load_drives()
    names = {row["method"] for row in rows}
    assert names == {*moving.methods(), "ORCA"}
    assert len(rows) == len(names) * len({row["scene"] for row in rows})
    seen = {(row["method"] == moving.OFFLINE, row["noise_m"]) for row in rows}
    assert seen == {(True, 0.0), (False, moving.SIGHT_NOISE)}
    first = next(row for row in rows if row["possible"] == "yes")
    task = moving.random_task(first["scene"])
    assert (task.movers, task.ratio) == (first["movers"], first["ratio"])
    assert moving.bound(task)["bound_s"] == pytest.approx(first["bound_s"])
    # None beats a proved bound, but for what it may be short of the goal.
    early = moving.ARRIVED / moving.SPEED + 1e-6
    proved = [row for row in rows if row["proved"] and row["outcome"] == "arrived"]
    assert all(row["arrival_s"] >= row["bound_s"] - early for row in proved)


def test_a_mover_that_leaves_the_goal_last_makes_the_bound_earlier():
    # A drive was within 10 mm of the goal before the mover was off all of these.
    task = moving.random_task(343)
    plan = fs.time_minimal_plan(*task[:3], moving.SPEED, margin=0)
    found = moving.bound(task)
    assert plan.proved
    assert found["proved"]
    assert found["static_s"] <= found["bound_s"] < plan.arrival


def test_noise_is_told_to_those_that_can_be():
    given = moving.methods()
    told = moving.told_noise(given, 0.01)
    assert told.keys() == given.keys()
    assert told["re-planning"].noise == told["MPC"].noise == 0.01
    assert told["VFH+"] == given["VFH+"]
    (row,) = moving.drive_all(3, {"re-planning": told["re-planning"]}, 0.01)
    assert row["noise_m"] == 0.01
    with pytest.raises(fs.InvalidParameter, match="noise is"):
        moving.told_noise(given, -1)


def test_what_are_no_methods_is_refused():
    for bad in (3, {"a": 3}, {"a": Following}):
        with pytest.raises(fs.InvalidParameter, match="given"):
            moving.drive_all(0, bad)
    with pytest.raises(fs.InvalidParameter, match="by is"):
        moving.summarise([row()], by=("scene",))


def test_a_method_beside_another_needs_scenes_in_which_both_arrive():
    rows = moving.load_drives()
    found = moving.beside(rows)
    assert {one.method for one in found} == {row["method"] for row in rows} - {"re-planning"}
    assert all(one.delay[0] < one.delays.mean() < one.delay[1] for one in found)
    with pytest.raises(fs.InvalidParameter, match="rival is"):
        moving.beside(rows, "luck")
    never = [row | {"arrival_s": np.nan} for row in rows]
    with pytest.raises(fs.InvalidParameter, match="rows has 0 scenes"):
        moving.beside(never)


@pytest.mark.parametrize("rows", [None, [], [{"scene": 1}], 3])
def test_what_are_no_rows_is_refused(rows):
    for function in (moving.summarise, moving.pairs):
        with pytest.raises(fs.InvalidParameter, match="rows is"):
            function(rows)
