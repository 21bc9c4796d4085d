"""Worlds as people have them: obstacles that meet, holes and boundaries, asked at random."""

import numpy as np
import pytest
import shapely
from oracle import shortest_way

import freeseg as fs
from freeseg.segments import find_endpoints, group_labels
from freeseg.triangulation import triangulate


def square(center, half, turned=0.0):
    """Corners of a square."""
    angles = turned + np.pi / 4 + np.pi / 2 * np.arange(4)
    reach = half * np.sqrt(2)
    return np.asarray(center) + reach * np.column_stack([np.cos(angles), np.sin(angles)])


def star(rng, center, reach):
    """A random outline, seldom convex."""
    angles = 2 * np.pi * (np.arange(7) + rng.uniform(0, 0.8, 7)) / 7
    away = reach * rng.uniform(0.3, 1, (7, 1))
    return center + away * np.column_stack([np.cos(angles), np.sin(angles)])


def an_obstacle(rng, others):
    """A random one, or one that touches, is in, or is a copy of one before."""
    center, kind = rng.uniform(0, 3, 2), rng.integers(7)
    if kind == 0 and others:
        return others[rng.integers(len(others))]
    if kind == 1 and others:
        # On a grid, neighbours share edges and corners.
        return fs.Polygon(square(rng.integers(0, 7, 2) * 0.4, 0.2))
    if kind == 2 and others:
        other = others[rng.integers(len(others))]
        return fs.Disc(other.vertices[0], rng.uniform(0.03, 0.3))
    if kind == 3:
        outer = square(center, rng.uniform(0.25, 0.6), rng.uniform(0, 1))
        middle = outer.mean(0)
        hole = middle + rng.uniform(0.3, 0.8) * (outer - middle)
        return fs.Polygon(outer, [hole])
    if kind in (4, 5):
        return fs.Disc(center, rng.uniform(0.03, 0.4))
    return fs.Polygon(star(rng, center, rng.uniform(0.1, 0.6)))


def a_world(seed):
    """A world, and positions where the robot stands free in it."""
    rng = np.random.default_rng(seed)
    obstacles = []
    for _ in range(rng.integers(1, 14)):
        obstacles.append(an_obstacle(rng, obstacles))
    boundary = None
    if seed % 2:
        boundary = star(rng, (1.5, 1.5), 4) if seed % 4 == 1 else square((1.5, 1.5), 1.7, 0.1)
    world = fs.World(obstacles, boundary)
    points = rng.uniform(-0.4, 3.4, (300, 2))
    clear = shapely.distance(material(world), shapely.points(points))
    if boundary is not None:
        clear[~shapely.contains_xy(shapely.Polygon(boundary), *points.T)] = 0
    return world, points[clear > fs.KheperaIV().radius + 0.003]


def material(world):
    """All that is not free, as Shapely has it; discs as polygons that reach as far, to 1e-6."""
    parts = [
        shapely.Polygon(one.vertices, one.holes)
        if isinstance(one, fs.Polygon)
        else shapely.Point(one.center).buffer(one.radius, quad_segs=600)
        for one in world
    ]
    return shapely.union_all(parts)


@pytest.mark.parametrize("planner", [fs.plan, fs.plan_rooms, fs.shortest_path])
def test_every_answer_is_a_path_that_keeps_clear_or_our_error(planner):
    found = refused = 0
    for seed in range(120):
        world, free = a_world(seed)
        solid = material(world)
        for start, goal in zip(free[:4:2], free[1:4:2], strict=False):
            try:
                plan = planner(world, start, goal)
            except (fs.NoPath, fs.Trapped):
                refused += 1
                continue
            points = shapely.points(plan.path.sample(0.002))
            assert shapely.distance(points, solid).min() > plan.robot.radius - 1e-5, seed
            if world.boundary is not None:
                inner = shapely.Polygon(world.boundary)
                assert shapely.contains(inner, points).all(), seed
            found += 1
    assert found > 100
    assert refused > 3


def test_rooms_lead_wherever_there_is_a_wide_way():
    # The exact planner for a robot that is a third wider decides.
    wide = fs.KheperaIV(diameter=0.19)
    there = led = 0
    for seed in range(200, 300):
        world, free = a_world(seed)
        if len(free) < 2:
            continue
        try:
            best = fs.shortest_path(world, *free[:2], wide)
        except (fs.NoPath, fs.InvalidQuery):
            continue
        there += 1
        try:
            plan = fs.plan_rooms(world, *free[:2])
        except fs.Trapped:
            continue
        led += 1
        assert plan.path.length < 2 * best.path.length
    assert there > 30
    assert led > 0.9 * there


def test_segments_between_obstacles_that_meet_have_length_zero_and_are_danger():
    square_one, disc = fs.Polygon(square((0, 0), 1)), fs.Disc((1.5, 0), 0.5)
    inside, copy = fs.Disc((0.2, 0.1), 0.1), fs.Disc((0.2, 0.1), 0.1)
    overlapping = fs.Disc((0.28, 0.1), 0.1)
    touching = fs.Polygon([(-1, 0), (-2, 1), (-2, -1)])
    world = fs.World([disc, square_one, inside, copy, overlapping, square_one, touching])
    with np.errstate(all="raise"):
        segments = fs.free_segments(world, margin=0)
        endpoints = find_endpoints(world, segments)
    assert len(segments) == 6
    for segment in segments:
        assert segment.length == 0
        assert not segment.safe
        assert np.isfinite(segment.ends).all()
        # The point is one of both obstacles.
        for owner, end in zip(segment.obstacles, segment.ends, strict=True):
            assert world.distances(shapely.Point(end))[owner] <= 1e-9
    for end in endpoints:
        assert end.segment is None
        assert np.hypot(*end.outward) == pytest.approx(1)
        assert np.isfinite(end.point).all()
    assert len(set(group_labels(world, 0).tolist())) == 1


def test_segments_in_random_worlds_are_as_long_as_obstacles_are_apart():
    met = 0
    for seed in range(60):
        world, _ = a_world(seed)
        for neighbours in ("chain", "delaunay"):
            with np.errstate(all="raise"):
                segments = fs.free_segments(world, neighbours=neighbours)
            for segment in segments:
                first, second = segment.obstacles
                apart = world.cores[first].distance(world.cores[second])
                apart -= world.radii[[first, second]].sum()
                assert segment.length == pytest.approx(max(apart, 0), abs=1e-9)
                met += apart <= 0
            if neighbours == "chain" and world.frame is not None:
                assert all(world.frame not in segment.obstacles for segment in segments)
    assert met > 30


# --- rooms ---------------------------------------------------------------------------------------


def test_walls_are_the_edges_in_the_material_and_only_those():
    checked = walls = 0
    for seed in range(0, 80, 2):
        rng = np.random.default_rng(seed)
        obstacles = [fs.Polygon(star(rng, rng.uniform(0, 3, 2), 0.6)) for _ in range(6)]
        obstacles.append(fs.Polygon(square((1, 1), 0.5), [square((1, 1), 0.4)]))
        world = fs.World(obstacles)
        rooms = triangulate(world)
        solid = material(world)
        lines = shapely.linestrings(rooms.points[rooms.edges])
        inside = shapely.length(shapely.intersection(lines, solid))
        # Of what is no wall, none runs through the material.
        assert (inside[~rooms.walls] < 1e-9 + 1e-4 * shapely.length(lines)[~rooms.walls]).all()
        # A wall is in the material, or crosses what is left of outlines that cross.
        astray = inside[rooms.walls] < 0.5 * shapely.length(lines)[rooms.walls]
        assert shapely.length(lines)[rooms.walls][astray].sum() < 0.02 * shapely.length(lines).sum()
        checked += len(lines)
        walls += rooms.walls.sum()
    assert 0.2 * checked < walls < 0.9 * checked


def test_a_long_outline_takes_no_more_sites_than_it_has_to():
    block = fs.Polygon(1000 * np.array([(-6, -1), (6, -1), (6, 1), (-6, 1)]))
    assert len(triangulate(fs.World([block])).points) < 20
    plan = fs.plan_rooms(fs.World([block]), (0, -1100), (10, 1100))
    assert plan.path.length == pytest.approx(
        fs.shortest_path(fs.World([block]), (0, -1100), (10, 1100)).path.length
    )


def test_a_scaled_world_has_the_same_rooms():
    rng = np.random.default_rng(3)
    outlines = [star(rng, (x, y), 0.6) for x in range(4) for y in range(4)]
    for scale in (1e-2, 1, 1e4):
        world = fs.World([fs.Polygon(scale * outline) for outline in outlines])
        robot = fs.KheperaIV(0.08 * scale, 0.1 * scale)
        plan = fs.plan_rooms(world, (-scale, -scale), (4 * scale, 4 * scale), robot, 0.01 * scale)
        assert plan.path.length / scale == pytest.approx(
            fs.shortest_path(
                world, (-scale, -scale), (4 * scale, 4 * scale), robot, 0.01 * scale
            ).path.length
            / scale,
            rel=0.05,
        )


def test_a_spiral_and_a_bay_are_rooms():
    turned = np.linspace(0, 6 * np.pi, 300)
    outwards = np.column_stack([np.cos(turned), np.sin(turned)])
    wall = np.concatenate(
        [
            (0.5 + 0.3 * turned)[:, None] * outwards,
            (0.3 + 0.3 * turned[::-1, None]) * outwards[::-1],
        ]
    )
    world = fs.World([fs.Polygon(wall)])
    plan = fs.plan_rooms(world, (0, 0.05), (9, 0))
    assert plan.path.length > 25
    best = fs.shortest_path(world, (0, 0.05), (9, 0)).path.length
    assert plan.path.length == pytest.approx(best, rel=1e-6)
    bay = fs.World([fs.Polygon([(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)])])
    plan = fs.plan_rooms(bay, (1.5, 1.5), (1.5, -1))
    best = fs.shortest_path(bay, (1.5, 1.5), (1.5, -1)).path.length
    assert plan.path.length == pytest.approx(best)


def test_a_straight_wall_of_many_corners_is_no_turn():
    # A corridor of a kilometre with a bend; its walls have a corner every half metre.
    along = np.arange(0, 1000.25, 0.5)
    upper = np.column_stack([along, 1 + 0 * along])
    lower = np.column_stack([along, 0 * along])
    down = [(1001, 1), (1001, -50), (1000, -50)]
    world = fs.World([], [*upper, *down, *lower[::-1]])
    plan = fs.plan_rooms(world, (0.5, 0.9), (1000.5, -49))
    assert len(plan.turning_points) <= 3
    best = fs.shortest_path(
        fs.World([], [(0, 0), (1000, 0), *down[::-1], (0, 1)]), (0.5, 0.9), (1000.5, -49)
    )
    assert plan.path.length == pytest.approx(best.path.length, rel=1e-9)


# --- the nearest free position -------------------------------------------------------------------


def test_the_nearest_free_position_by_hand():
    world = fs.World([fs.Disc((0, 0), 1), fs.Polygon(square((5, 0), 1))])
    robot = fs.KheperaIV(diameter=0.5)
    for point, expected in [
        ((0.5, 0), (1.3, 0)),
        ((5.9, 0.2), (6.3, 0.2)),
        ((6.1, 1.1), np.add((6, 1), 0.3 * np.sqrt(0.5))),
        ((3, 3), (3, 3)),
    ]:
        found = fs.nearest_free(world, point, robot, margin=0.1)
        assert found == pytest.approx(np.asarray(expected, float), abs=1e-8)
    # Between two walls, where no single one's nearest position is free.
    walls = [fs.Polygon([(-5, y), (5, y), (5, y + 0.1), (-5, y + 0.1)]) for y in (-0.3, 0.2)]
    found = fs.nearest_free(fs.World(walls), (4.9, 0), robot, margin=0.1)
    assert np.hypot(*(found - (5, 0.2))) == pytest.approx(0.3, abs=1e-7)
    assert np.hypot(*(found - (5, -0.2))) == pytest.approx(0.3, abs=1e-7)


def test_the_nearest_free_position_against_a_fine_grid():
    checked = 0
    for seed in range(60):
        world, _ = a_world(seed)
        rng = np.random.default_rng(1000 + seed)
        point, keep = rng.uniform(-0.3, 3.3, 2), fs.KheperaIV().radius + 0.0025
        found = fs.nearest_free(world, point)
        solid = material(world)
        assert solid.distance(shapely.Point(found)) > keep - 1e-5
        away = np.hypot(*(found - point))
        if world.boundary is not None:
            assert shapely.Polygon(world.boundary).contains(shapely.Point(found))
        # Nothing nearer is free: on rings round the point, up to 1 mm short of it.
        if away > 0.002:
            radii = np.linspace(0, away - 0.001, 60)[:, None]
            angles = np.linspace(0, 2 * np.pi, 400)
            around = (
                point[:, None, None] + radii * np.stack([np.cos(angles), np.sin(angles)])[:, None]
            )
            around = np.moveaxis(around, 0, -1).reshape(-1, 2)
            if world.boundary is not None:
                around = around[shapely.contains_xy(shapely.Polygon(world.boundary), *around.T)]
            shapely.prepare(solid)
            assert shapely.dwithin(solid, shapely.points(around), keep).all()
            checked += 1
    assert checked > 10


def test_the_message_names_a_position_that_is_accepted():
    for seed in range(40):
        world, free = a_world(seed)
        rng = np.random.default_rng(seed)
        for start in rng.uniform(-0.3, 3.3, (3, 2)):
            try:
                fs.shortest_path(world, start, free[0])
            except fs.InvalidQuery as error:
                text = str(error)
                given = text[text.index("gives [") + 7 : -1].split(",")
                start = [float(number) for number in given]
            except fs.NoPath:
                continue
            try:
                fs.shortest_path(world, start, free[0])
            except fs.NoPath:
                continue


def test_where_nothing_is_free_there_is_no_nearest_position():
    narrow = fs.World([], square((0, 0), 0.05))
    with pytest.raises(fs.InvalidQuery, match="no position that is free"):
        fs.nearest_free(narrow, (0, 0))
    with pytest.raises(fs.InvalidQuery, match="or plan for a smaller robot"):
        fs.plan(narrow, (0, 0), (0.01, 0))


def test_with_holes_and_boundaries_the_shortest_path_is_the_oracle_s():
    found = 0
    for seed in range(300, 420):
        rng = np.random.default_rng(seed)
        court = square((1, 1), 0.8, rng.uniform(0, 1))
        obstacles = [
            fs.Polygon(1.15 * (court - 1) + 1, [star(rng, (1, 1), 0.8)]),
            fs.Disc(rng.uniform(0.5, 1.5, 2), 0.06),
        ]
        world = fs.World(obstacles, star(rng, (1, 1), 3) if seed % 2 else None)
        ends = rng.uniform(0.3, 1.7, (2, 2)) if seed % 3 else rng.uniform(-1, 3, (2, 2))
        try:
            plan = fs.shortest_path(world, *ends, margin=0)
            expected = plan.path.length
            found += 1
        except fs.InvalidQuery:
            continue
        except fs.NoPath:
            expected = np.inf
        keep = np.minimum(
            fs.KheperaIV().radius, np.min([world.distances(shapely.Point(end)) for end in ends], 0)
        )
        assert expected == pytest.approx(shortest_way(world, *ends, keep), rel=1e-7), seed
    assert found > 5
