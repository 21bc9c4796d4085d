"""Lesson 04, its own lines: distances, dangers and the loop of Fig. 3."""

import numpy as np
import pytest
import shapely
from lessons import definitions

import freeseg as fs
from freeseg.path import Arc, Line
from freeseg.plan import StepKind

STEM = "04_resolve_collisions"
NAMES = [
    "plans",
    "queries",
    "discs",
    "boxes",
    "R_r",
    "distance_from_line",
    "distance_from_arc",
    "which_case",
    "first_danger",
    "rank",
    "endpoints_of",
    "connect",
    "sense_past",
    "one_more_turn",
    "needless_turns",
    "loop",
    "show_steps",
]


@pytest.fixture(scope="module")
def own():
    """What the lesson defines."""
    return definitions(STEM, *NAMES)


def pieces_met(own):
    """World, piece and row of distances (m), of all pieces of all steps."""
    for plan in own["plans"].values():
        for step in plan.steps:
            rows = step.path.distances(plan.world)
            yield from ((plan.world, p, row) for p, row in zip(step.path.pieces, rows, strict=True))


def test_its_worlds_are_the_paper_s_and_two_more(own):
    assert set(own["plans"]) >= {"13a", "13b", "15a", "15b", "16b", "discs", "boxes"}
    assert len(own["plans"]) == 10


def test_the_two_formulas_are_the_distances_of_a_path(own):
    formula = {Line: own["distance_from_line"], Arc: own["distance_from_arc"]}
    checked = 0
    for world, piece, row in pieces_met(own):
        if world is own["boxes"]:
            continue
        mine = [formula[type(piece)](piece, disc.center, disc.radius) for disc in world]
        np.testing.assert_allclose(mine, row, rtol=0, atol=1e-12)
        checked += len(mine)
    assert checked > 500


@pytest.mark.parametrize("h", [0.01, 0.001])
def test_samples_are_too_far_away_by_half_their_spacing_at_most(own, h):
    for world, piece, row in pieces_met(own):
        samples = shapely.multipoints(fs.Path([piece]).sample(h))
        excess = world.distances(samples) - row
        assert excess.min() > -1e-12
        assert excess.max() <= h / 2


def test_it_meets_the_dangers_that_the_planner_meets(own):
    kinds = []
    for plan in own["plans"].values():
        for before, step in zip(plan.steps[1:], plan.steps[2:], strict=False):
            if step.kind != StepKind.NEEDLESS_TURN:
                _, blocking, d = own["first_danger"](before.path, plan.world)
                assert (step.kind, step.blocking) == (own["which_case"](d), blocking)
                kinds.append(step.kind)
        assert own["first_danger"](plan.path, plan.world) is None
    assert {StepKind.CASE_1, StepKind.CASE_2} <= set(kinds)


def test_the_two_worlds_show_the_two_cases(own):
    for name, case in (("discs", "case 1"), ("boxes", "case 2")):
        plan = own["plans"][name]
        _, blocking, d = own["first_danger"](plan.steps[1].path, plan.world)
        assert own["which_case"](d) == case == plan.steps[2].kind
        line = shapely.LineString(plan.steps[1].path.sample(0.0005))
        across = shapely.shortest_line(plan.world.cores[blocking], line).length
        if case == "case 2":
            assert across == pytest.approx(d, abs=1e-5)
        else:
            assert d < 0
            assert across < plan.world.radii[blocking]


def test_a_repair_ranks_the_endpoints_of_the_blocking_obstacle(own):
    step = own["plans"]["discs"].steps[2]
    among = [end for end in own["endpoints_of"](own["discs"]) if end.obstacle == step.blocking]
    ranked = own["rank"](among, step.leg)
    np.testing.assert_allclose([SD for SD, _ in ranked], [one.detour for one in step.candidates])


def test_the_loop_makes_the_turns_of_the_planner(own):
    for name, plan in own["plans"].items():
        turns, path = own["loop"](own["queries"][name])
        theirs = [(turn.obstacle, turn.sense) for turn in plan.turning_points]
        assert [(end.obstacle, sense) for end, sense in turns] == theirs
        assert path.length == pytest.approx(plan.path.length, abs=1e-12)


def test_dropping_turns_matters_in_one_case(own):
    arcs = [p for p in own["plans"]["15b"].steps[3].path.pieces if isinstance(p, Arc)]
    assert sum(abs(arc.sweep) > np.pi for arc in arcs) == 1
    longer = [
        name
        for name, query in own["queries"].items()
        if own["loop"](query, drop_needless=False)[1].length > own["plans"][name].path.length + 1e-6
    ]
    assert longer == ["15b"]


def test_repairs_make_dangerous_paths_clear(own):
    repaired = {name: plan for name, plan in own["plans"].items() if len(plan.steps) > 2}
    assert len(repaired) == 8
    for plan in repaired.values():
        assert plan.steps[1].path.clearance(plan.world) < own["R_r"]
        assert plan.path.clearance(plan.world) >= own["R_r"] - 1e-9


def test_greed_costs_little_and_only_once(own):
    ratios = {
        name: plan.path.length / fs.shortest_path(*own["queries"][name], plan.robot).path.length
        for name, plan in own["plans"].items()
    }
    # A trifle below one: lines need only keep R_r, and the shortest path keeps R_D.
    assert min(ratios.values()) > 1 - 1e-3
    assert [name for name, ratio in ratios.items() if ratio > 1 + 1e-6] == ["15a"]
