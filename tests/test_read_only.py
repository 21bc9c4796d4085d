"""What a plan and a world hold cannot be written to, and prints on one line."""

from dataclasses import is_dataclass
from functools import partial

import numpy as np
import pytest
from worlds import crowded_question

import freeseg as fs
from freeseg.path import Arc, Line
from freeseg.plan import Candidate, TurningPoint
from freeseg.segments import Endpoint, FreeSegment
from freeseg.triangulation import Triangulation, triangulate

PLANNERS = {
    "plan": fs.plan,
    "literal": partial(fs.literal_plan, concentric=True),
    "rooms": fs.plan_rooms,
    "shortest": fs.shortest_path,
}
#: Two obstacles of each kind.
WORLD = fs.World(
    [
        fs.Disc((0.3, 0.3), 0.05),
        fs.Polygon([(0.6, 0.2), (0.7, 0.2), (0.7, 0.4), (0.65, 0.25), (0.6, 0.4)]),
        fs.Disc((0.3, 0.7), 0.03),
        fs.Polygon([(0.6, 0.6), (0.7, 0.6), (0.65, 0.7)]),
    ]
)


def things(thing, seen=None):
    """A thing and all that it holds, whatever it computed and kept among it, each once."""
    seen = {} if seen is None else seen
    if id(thing) in seen:
        return
    seen[id(thing)] = thing
    yield thing
    if isinstance(thing, tuple | list | frozenset):
        parts = list(thing)
    elif is_dataclass(thing):
        # All properties, so that those are there which are computed when first asked for.
        names = [name for name in dir(type(thing)) if not name.startswith("__")]
        for name in names:
            getattr(thing, name)
        parts = [*vars(thing).values(), *(getattr(thing, name) for name in names)]
    else:
        parts = []
    for part in parts:
        yield from things(part, seen)


def arrays(thing):
    return [found for found in things(thing) if isinstance(found, np.ndarray)]


def assert_read_only(found):
    for array in found:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = array


@pytest.mark.parametrize("name", PLANNERS)
def test_no_array_of_a_plan_can_be_written_to(name):
    plan = PLANNERS[name](fs.load_table(1), (0.4, 0), (0.8, 0.5))
    kinds = {type(thing) for thing in things(plan)}
    assert {fs.Path, Line, Arc, TurningPoint} <= kinds
    assert name == "shortest" or {Endpoint, FreeSegment} <= kinds
    found = arrays(plan)
    assert len(found) > 8
    assert_read_only(found)


@pytest.mark.parametrize("seed", range(40))
def test_no_array_of_a_random_plan_can_be_written_to(seed):
    world, start, goal, margin = crowded_question(seed)
    for planner in PLANNERS.values():
        try:
            found = arrays(planner(world, start, goal, margin=margin))
        except fs.Trapped as trapped:
            found = arrays(trapped.steps)
        except fs.NoPath:
            continue
        assert found
        assert_read_only(found)


@pytest.mark.parametrize("world", [WORLD, fs.World([])], ids=["four obstacles", "empty"])
def test_no_array_of_a_world_can_be_written_to(world):
    found = arrays(world)
    assert len(found) >= (20 if len(world) else 4)
    assert_read_only(found)


def test_no_array_of_a_triangulation_can_be_written_to():
    found = arrays(triangulate(WORLD))
    assert len(found) == 9
    assert_read_only(found)


def test_no_array_of_a_segment_can_be_written_to():
    for neighbours in ("chain", "delaunay"):
        found = arrays(fs.free_segments(WORLD, neighbours=neighbours))
        assert len(found) >= 3
        assert_read_only(found)


@pytest.mark.parametrize("name", PLANNERS)
def test_whatever_a_plan_holds_prints_on_a_line(name):
    plan = PLANNERS[name](fs.load_table(1), (0.4, 0), (0.8, 0.5))
    shown = (Candidate, Endpoint, FreeSegment, TurningPoint, Triangulation, fs.Path)
    kinds = (*shown, type(plan), type(plan.steps[0]))
    printed = [repr(thing) for thing in things((plan, triangulate(WORLD))) if type(thing) in kinds]
    assert len(printed) > 6
    for line in printed:
        assert len(line) < 100
        assert "\n" not in line
        assert "array" not in line


def test_what_is_printed():
    plan = fs.plan(fs.load_table(1), (0.4, 0), (0.8, 0.5))
    step = plan.steps[1]
    assert repr(plan.path) == "Path of 0.654 m in 5 pieces"
    assert repr(plan.segments[0]) == ("FreeSegment of 0.2772 m from obstacle 1 to obstacle 2, safe")
    assert repr(plan.turning_points[0]) == (
        "TurningPoint clockwise round obstacle 1, radius 0.0909 m"
    )
    assert repr(plan.turning_points[0].endpoint) == (
        "Endpoint at (0.5552, 0.1172) m on obstacle 1, of segment 1"
    )
    assert repr(step.chosen) == ("Candidate on obstacle 1, 0.6488 m: chosen")
    assert repr(triangulate(fs.load_table(1))) == (
        "Triangulation of 7 sites and a ring of 8: 20 rooms"
    )
