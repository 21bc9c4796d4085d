"""Lesson 16, its own lines: grazing, sliding, leaving, and the closed form."""

import re

import numpy as np
import pytest
from lessons import definitions, lesson
from numpy.testing import assert_allclose
from refresh_notebooks import NOTEBOOKS

import freeseg as fs
from freeseg.geometry import unit
from freeseg.studies import crossings, moving

STEM = "16_avoid_moving_obstacles"


@pytest.fixture(scope="module")
def own():
    names = "V", "R_D", "start", "goal", "graze", "round_one", "closed_form", "plan", "waiting"
    return definitions(STEM, *names)


def test_a_grazing_line_touches_and_no_more(own):
    rng = np.random.default_rng(0)
    for _ in range(50):
        mover = fs.Mover(
            fs.Disc(rng.uniform(0.5, 2, 2), 0.2), 0.2 * unit(rng.uniform(-np.pi, np.pi))
        )
        for sense in (1, -1):
            t, p = rng.uniform(0, 1), np.zeros(2)
            velocity, lasts, touch = own["graze"](p, t, mover, sense)
            assert np.hypot(*velocity) == pytest.approx(own["V"])
            times = np.linspace(0, 1.2 * lasts, 600)
            seen = (
                p
                + times[:, None] * velocity
                - (mover.obstacle.center + (t + times[:, None]) * mover.velocity)
            )
            gap = np.hypot(*seen.T) - 0.2 - own["R_D"]
            assert gap.min() > -1e-9
            last = p + lasts * velocity - mover.at(t + lasts).center
            assert_allclose(last, (0.2 + own["R_D"]) * unit(touch), atol=1e-9)


@pytest.mark.parametrize("velocity", [(0.03, 0.12), (0.1, 0.15), (0, 0), (-0.08, 0.05)])
def test_the_better_way_round_one_is_the_planner_s(own, velocity):
    mover = fs.Mover(fs.Disc((0.9, 0) - 3.5 * np.array(velocity), 0.2), velocity)
    scene = fs.Scene(fs.World([]), [mover])
    arrivals = [own["round_one"](mover, sense) for sense in (1, -1)]
    plan = fs.time_minimal_plan(scene, own["start"], own["goal"], own["V"])
    assert plan.arrival == pytest.approx(min(arrivals), rel=1e-9)


@pytest.mark.parametrize("g", [0.01, 0.06, 0.1])
def test_the_closed_form_is_the_planner_s(own, g):
    scene = fs.Scene(fs.World([]), [fs.Mover(fs.Disc((0, 0), 0.1), growth=g)])
    plan = fs.time_minimal_plan(scene, (0.7, 0), 2.5 * unit(2.8), own["V"])
    formula = own["closed_form"](0.7, 0.1 + own["R_D"], g, 2.5, 2.8)
    assert plan.arrival == pytest.approx(formula, rel=1e-9)


def test_the_first_plan_is_proved_and_always_at_full_speed(own):
    plan = own["plan"]
    assert plan.proved
    speeds = np.hypot(*plan.path.at(np.linspace(0, plan.arrival, 2000))[1])
    assert_allclose(speeds, own["V"], rtol=1e-9)


def test_waiting_pays_and_is_never_too_fast(own):
    plan = own["waiting"]
    speeds = np.hypot(*plan.path.at(np.linspace(0, plan.arrival, 2000))[1])
    assert speeds.min() < 0.5 * own["V"]
    assert speeds.max() < own["V"] * (1 + 1e-6)
    # Round the outside of both it is later.
    rim = 0.4 + own["R_D"]
    outside = 2 * np.hypot(0.6, 0.42 + rim) / own["V"]
    assert plan.arrival < outside


def test_stored_rivals_are_of_the_scenes_that_their_numbers_give():
    rows = crossings.load_crossings()
    assert [row["seed"] for row in rows] == list(range(len(rows)))
    for row in rows[:: len(rows) // 10]:
        scene = crossings.random_crossing(row["seed"])
        assert (len(scene.movers), len(scene.world)) == (row["movers"], row["still"])


def test_the_robot_of_the_animation_waits():
    source = (NOTEBOOKS / f"{STEM}.ipynb").read_text(encoding="utf-8")
    (seed,) = re.findall(r"animate_plan\(crossings\.plan_crossing\((\d+)\)", source)
    plan = crossings.plan_crossing(int(seed))
    t = np.linspace(0, plan.arrival, 1000)
    slow = np.hypot(*plan.path.at(t)[1]) < crossings.CROSSING_SPEED / 3
    assert slow.mean() > 0.2
    # To the last, and on the rim of what covers the goal until then.
    assert slow[-2]
    assert plan.scene.distances(crossings.CROSSING_GOAL, 0.9 * plan.arrival).min() < 0.0729


def test_rivals_are_judged_by_the_best_of_them():
    rows = [
        {"grid": 1.1, "from_ours": 0.0, "from_random": 1.00005, "from_grid": 0.0},
        {"grid": 0.99, "from_ours": 1.2, "from_random": 0.0, "from_grid": 0.0},
        {"grid": 0.0, "from_ours": 0.0, "from_random": 0.0, "from_grid": 0.0},
    ]
    found = crossings.judge_rivals(rows, crossings.RIVAL_NAMES)
    assert (found["answers"], found["earlier"], found["near"]) == (2, 1, 1)
    assert found["least"] == 0.99
    assert np.isnan(crossings.judge_rivals(rows[2:], ["grid"])["median"])


def drives_of(outcomes, early=0.0, scenes=40):
    """Rows of two methods: the rival always arrives, the other as `outcomes` says of a scene."""
    head = dict.fromkeys(moving.FORM, 0.0) | {"possible": "yes", "bound_s": 10.0}
    rows = []
    for scene in range(scenes):
        arrival = 12 - early + 0.01 * (scene % 7)
        outcome = outcomes(scene)
        own = {"outcome": outcome, "arrival_s": arrival if outcome == "arrived" else np.nan}
        rival = {"outcome": "arrived", "arrival_s": 12.0}
        rows.append(head | {"scene": scene, "method": "re-planning"} | rival)
        rows.append(head | {"scene": scene, "method": "other"} | own)
    return rows


@pytest.mark.parametrize(
    ("crashes", "early", "arrivals", "delays"),
    [
        (lambda scene: scene % 2, 1.0, "worse", "better"),
        (lambda scene: scene % 2, -1.0, "worse", "worse"),
        (lambda scene: scene == 3, 0.03, "undecided", "undecided"),
    ],
)
def test_the_words_on_pairs_follow_the_drives(crashes, early, arrivals, delays):
    word = lesson(STEM, "word")
    rows = drives_of(lambda scene: "collided" if crashes(scene) else "arrived", early)
    ((name, ends, (low, high), gaps),) = moving.beside(rows)
    assert (name, len(gaps)) == ("other", sum(not crashes(scene) for scene in range(40)))
    assert low < np.median(gaps) < high
    assert (word(*ends), word(-high, -low)) == (arrivals, delays)


def test_the_rival_s_name_may_stand_first_or_last():
    word = lesson(STEM, "word")
    rows = drives_of(lambda scene: "arrived" if scene % 2 else "collided")
    ((_, ends, _, _),) = moving.beside(rows)
    ((_, turned, _, _),) = moving.beside(rows, rival="other")
    assert (word(*ends), word(*turned)) == ("worse", "better")
    assert_allclose(ends, np.negative(turned)[::-1])
