import numpy as np
import oracle
import pytest

import freeseg as fs
from freeseg.planners.query import ask
from freeseg.planners.shortest import ShortestWay
from freeseg.segments import MARGIN


def optimum_round_all(world, start, goal, robot):
    """Length of the shortest way round all obstacles at once; infinite where there is none."""
    query = ask(world, start, goal, robot, MARGIN)
    try:
        return query.connect(ShortestWay(query).go_round(range(len(world))))[0].length
    except fs.NoPath:
        return np.inf


@pytest.mark.parametrize("name", fs.load_cases())
def test_published_cases_against_exhaustion(name, cases, tables, robot):
    case, world = cases[name], tables[cases[name].table]
    centers = np.array([disc.center for disc in world.obstacles])
    radii = world.radii + robot.radius + MARGIN / 2
    optimum, _ = oracle.shortest(case.start, case.goal, centers, radii)
    plan = fs.shortest_path(world, case.start, case.goal)
    assert plan.path.length == pytest.approx(optimum, rel=1e-9)
    assert plan.path.clearance(world) >= robot.radius + MARGIN / 2 - 1e-9


def test_obstacles_met_decide_for_the_whole_world(robot):
    # The loop leaves obstacles out; the optimum must be that of all of them.
    rng, found, spared = np.random.default_rng(51), 0, 0
    for _ in range(100):
        obstacles = []
        for center, size in zip(
            rng.uniform(0, 1.5, (14, 2)), rng.uniform(0.02, 0.15, 14), strict=True
        ):
            corners = center + size * np.array([(-1, -1), (1, -0.5), (0.2, 1)])
            obstacle = fs.Disc(center, size) if rng.random() < 0.5 else fs.Polygon(corners)
            try:
                obstacles = list(fs.World([*obstacles, obstacle]).obstacles)
            except fs.InvalidWorld:
                continue
        world = fs.World(obstacles)
        start, goal = (-0.3, rng.uniform(0, 1.5)), (1.8, rng.uniform(0, 1.5))
        plan = fs.shortest_path(world, start, goal)
        expected = optimum_round_all(world, start, goal, robot)
        assert plan.path.length == pytest.approx(expected, rel=1e-9)
        back = fs.shortest_path(world, goal, start)
        assert back.path.length == pytest.approx(expected, rel=1e-9)
        found += len(plan.turning_points) > 1
        spared += len(plan.steps[-1].group) < len(world)
    assert found > 50
    assert spared > 90


def test_no_path_out_of_a_ring():
    angles = 2 * np.pi * np.arange(8) / 8
    ring = fs.World([fs.Disc((0.3 * np.cos(a), 0.3 * np.sin(a)), 0.08) for a in angles])
    with pytest.raises(fs.NoPath, match="leave no way"):
        fs.shortest_path(ring, (0, 0), (1, 1))


def test_no_obstacle_and_invalid_input():
    plan = fs.shortest_path(fs.World([]), (0, 0), (3, 4))
    assert plan.path.length == pytest.approx(5)
    with pytest.raises(fs.InvalidQuery, match="finite"):
        fs.shortest_path(fs.World([]), (0, np.nan), (3, 4))
    with pytest.raises(fs.InvalidParameter, match="margin"):
        fs.shortest_path(fs.World([]), (0, 0), (3, 4), margin=0)
