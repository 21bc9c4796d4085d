"""Both orders of the search for a turning point, and both readings of the safest segment."""

import numpy as np
import pytest

import freeseg as fs
from freeseg.plan import Effort
from freeseg.planners.length_first import measured_when_tried
from freeseg.planners.query import ask
from freeseg.studies import planning

CASES = sorted(fs.load_cases())

#: Two discs with a wide gap and two with a narrow one, in a row across the way.
ROW = fs.World([fs.Disc((0.0, y), 0.05) for y in (0.0, 0.25, 0.45, 0.85)])


def outcome(planner, *query):
    """The path's length and turns, or which error was raised."""
    try:
        plan = planner(*query)
    except fs.FreesegError as error:
        return type(error)
    return plan.path.length, [(turn.obstacle, turn.sense) for turn in plan.turning_points]


@pytest.mark.parametrize("name", CASES)
def test_both_orders_find_the_same_path_in_the_cases(cases, tables, name):
    query = tables[cases[name].table], cases[name].start, cases[name].goal
    assert outcome(fs.plan, *query) == outcome(fs.length_first_plan, *query)


def test_both_orders_find_the_same_path_in_random_worlds():
    found = [outcome(fs.plan, *planning.random_case(seed)) for seed in range(40)]
    again = [outcome(fs.length_first_plan, *planning.random_case(seed)) for seed in range(40)]
    assert found == again
    assert sum(isinstance(one, tuple) and len(one[1]) > 0 for one in found) > 20


def test_operations_are_those_counted_by_hand():
    # The straight line runs through the danger segment, 0.1 m wide.
    segments = fs.free_segments(ROW)
    assert [segment.safe for segment in segments] == [True, False, True]
    query = ROW, (-0.5, 0.34), (0.5, 0.34)
    safety, length = fs.plan(*query), fs.length_first_plan(*query)
    assert safety.path.length == length.path.length
    first = safety.steps[1]
    ends = sum(one.endpoint.segment is not None for one in first.candidates)
    assert ends == 4  # of two safe segments
    assert length.steps[1].candidates[0].rejected == "its segment is danger"
    assert sum(one.endpoint.segment is not None for one in length.steps[1].candidates) == 6
    assert safety.effort.segments == 3
    assert length.effort.retries == safety.effort.retries + 2  # both ends of the danger segment
    for plan in (safety, length):
        evaluated = sum(len(step.candidates) for step in plan.steps)
        assert plan.effort.endpoints == evaluated
        assert plan.effort.distances == plan.effort.segments + 2 * evaluated


def test_length_first_measures_what_it_looks_at_and_no_more():
    # A gap far from the way is never measured, and nothing is where the way is free.
    far = fs.World([*ROW, fs.Disc((0.0, 5.0), 0.05), fs.Disc((0.0, 5.3), 0.05)])
    near = fs.length_first_plan(far, (-0.5, 0.34), (0.5, 0.34))
    assert near.effort.segments < len(near.segments) == 5
    free = (-0.5, -0.5), (0.5, -0.5)
    assert fs.length_first_plan(far, *free).effort == Effort(0, 0, 0)
    assert fs.plan(far, *free).effort == Effort(5, 0, 0)


def test_touching_obstacles_leave_no_endpoint_to_try(robot):
    world = fs.World([fs.Disc((0, 0), 0.1), fs.Disc((0, 0.2), 0.1), fs.Disc((0, 0.6), 0.1)])
    survey = measured_when_tried(ask(world, (-1, 0.1), (1, 0.1), robot, 0.005))
    assert {end.segment for end in survey.endpoints} == {1, None}
    assert not survey.measured
    assert outcome(fs.plan, world, (-1, 0.1), (1, 0.1)) == outcome(
        fs.length_first_plan, world, (-1, 0.1), (1, 0.1)
    )


def test_the_widest_segment_is_turned_at_first():
    # Through the gap of 0.3 m although that of 0.15 m is nearer to the straight line.
    query = ROW, (-0.5, 0.2), (0.5, 0.2)
    near, wide = fs.plan(*query), fs.widest_segment_plan(*query)
    assert near.steps[1].chosen.endpoint.segment == 0
    assert wide.steps[1].chosen.endpoint.segment == 2
    assert wide.path.length > near.path.length
    tried = [one.endpoint.segment for one in wide.steps[1].candidates]
    assert tried == [2] * 2 + [0] * 2 + [None] * (len(tried) - 4)


def test_readings_agree_where_no_segment_is_to_be_chosen():
    lonely = fs.World([fs.Disc((0, 0), 0.1)])
    query = lonely, (-1, 0.02), (1, 0.02)
    assert outcome(fs.plan, *query) == outcome(fs.widest_segment_plan, *query)


def test_every_path_of_the_widest_reading_is_legal(robot):
    solved = 0
    for seed in range(30):
        world, start, goal = planning.random_case(seed)
        try:
            plan = fs.widest_segment_plan(world, start, goal)
        except fs.NoPath:
            with pytest.raises(fs.NoPath):
                fs.shortest_path(world, start, goal)
            continue
        solved += 1
        assert plan.path.clearance(world) >= robot.radius - 1e-9
    assert solved > 20


@pytest.mark.parametrize("bad", [-1, 0.5, "1", None, True, np.nan])
def test_an_effort_is_counted_in_whole_numbers(bad):
    assert Effort(np.int64(3), 0, 0) == Effort(3, 0, 0)
    for place in range(3):
        counts = [0, 0, 0]
        counts[place] = bad
        with pytest.raises(fs.InvalidParameter, match="whole number"):
            Effort(*counts)
