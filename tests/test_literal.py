import contextlib

import pytest
import shapely

import freeseg as fs
from freeseg.plan import turning_radius
from freeseg.segments import MARGIN

CASES = sorted(fs.load_cases())

#: What the words of the paper solve, by where the circle is and which endpoints count.
SOLVED = {
    (False, False): set(),
    (False, True): set(),
    (True, False): set(CASES) - {"14c", "16c", "16d"},
    (True, True): set(CASES) - {"13d", "14c", "15c", "15d", "16c"},
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize(("concentric", "outer_endpoints"), SOLVED)
def test_what_the_words_alone_solve(cases, tables, robot, name, concentric, outer_endpoints):
    case, world = cases[name], tables[cases[name].table]
    options = {"concentric": concentric, "outer_endpoints": outer_endpoints}
    if name not in SOLVED[concentric, outer_endpoints]:
        with pytest.raises(
            fs.Trapped, match=r"no endpoint, or none left|no tangent leads"
        ) as trapped:
            fs.literal_plan(world, case.start, case.goal, **options)
        # What it tried: the straight line, and turns that were not enough.
        kinds = [step.kind for step in trapped.value.steps]
        assert kinds[0] == "straight"
        assert set(kinds[2:]) <= {"case 1", "case 2"}
        return
    plan = fs.literal_plan(world, case.start, case.goal, **options)
    line = shapely.LineString(plan.path.sample(0.001))
    # Chords of 1 mm leave the arcs by under 2 um.
    assert world.distances(line).min() >= robot.radius - 2e-6
    assert plan.path.start == pytest.approx(case.start, abs=1e-9)
    assert plan.path.end == pytest.approx(case.goal, abs=1e-9)
    assert plan.steps[-1].path is plan.path
    assert len(plan.steps) == 1 + len(plan.turning_points)
    assert all(outer_endpoints or turn.endpoint.segment is not None for turn in plan.turning_points)


def test_concentric_circles_alone_solve_13_of_the_16_cases():
    assert len(SOLVED[True, False]) == 13


def test_a_larger_circle_round_the_endpoint_solves_more(cases, tables, robot):
    solved = []
    for radius in (None, turning_radius(robot, MARGIN), 0.095, 0.145):
        found = 0
        for case in cases.values():
            query = tables[case.table], case.start, case.goal
            with contextlib.suppress(fs.Trapped):
                plan = fs.literal_plan(*query, turning_radius=radius)
                assert {turn.radius for turn in plan.turning_points} <= {radius}
                assert plan.path.clearance(plan.world) >= robot.radius - 1e-9
                found += 1
        solved.append(found)
    assert solved == [0, 0, 10, 2]


def test_a_circle_smaller_than_the_robot_is_refused(tables):
    with pytest.raises(
        fs.InvalidParameter, match=r"turning_radius is 0\.05; give at least the robot"
    ):
        fs.literal_plan(tables[1], (0, 0), (0.9, 0.8), turning_radius=0.05)


def test_circles_are_where_the_words_or_the_option_put_them(tables, robot):
    # Past one end of the gap between two discs, far enough for the literal circle not to cut in.
    world = fs.World([fs.Disc((0, 0), 0.1), fs.Disc((0, 1), 0.1)])
    reach = turning_radius(robot, MARGIN)
    for concentric in (True, False):
        try:
            plan = fs.literal_plan(world, (-1, 0.08), (1, 0.08), concentric=concentric)
        except fs.Trapped:
            # Centred on the disc's boundary the circle cuts into the disc.
            assert not concentric
            continue
        (turn,) = plan.turning_points
        assert turn.center == pytest.approx((0, 0) if concentric else (0, 0.1))
        assert turn.radius == pytest.approx(reach + (0.1 if concentric else 0))
        assert turn.sense == -1


def test_a_clear_way_is_straight_and_a_world_without_segments_is_a_trap():
    lonely = fs.World([fs.Disc((0, 0), 0.1)])
    assert len(fs.literal_plan(lonely, (-1, 1), (1, 1)).path.pieces) == 1
    # One obstacle has no neighbour, so no segment and no endpoint.
    with pytest.raises(fs.Trapped, match="none left, to turn at before obstacle 1"):
        fs.literal_plan(lonely, (-1, 0), (1, 0), concentric=True)
    path = fs.literal_plan(lonely, (-1, 0), (1, 0), concentric=True, outer_endpoints=True).path
    assert path.length == pytest.approx(fs.shortest_path(lonely, (-1, 0), (1, 0)).path.length)
