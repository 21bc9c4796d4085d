import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.segments import MARGIN, find_endpoints, group_labels

#: Distances between the centres of consecutive obstacles of the paper's tables (mm).
CENTRE_DISTANCES_MM = {
    1: (313.2, 200.0, 260.0, 375.9, 281.6, 274.6),
    2: (313.2, 200.0, 260.0, 206.2, 139.3, 120.0),
    3: (313.2, 200.0, 260.0, 167.6, 191.0, 177.2),
    4: (234.1, 103.0, 140.0, 375.9, 294.1, 270.2),
    5: (160.0, 110.5, 140.0, 206.2, 139.3, 170.0),
}
#: Numbers that a float holds exactly, so that "just safe" can be tested.
ROBOT, EXACT_MARGIN, REQUIRED = fs.KheperaIV(diameter=0.125), 0.0625, 0.1875

TRIANGLE = fs.Polygon([(0, 0), (1, 0), (0, 1)])
L_SHAPE = fs.Polygon([(3, 0), (5, 0), (5, 1), (4, 1), (4, 3), (3, 3)])
#: Two thick arms, and between them a tooth that points at the centroid above it.
TOOTHED = fs.Polygon(
    [(0, 0), (6, 0), (6, 9), (4, 9), (4, 1), (3.2, 1), (3, 3), (2.8, 1), (2, 1), (2, 9), (0, 9)]
)


def boundary(obstacle, n=600):
    """Points on an obstacle's boundary, and their largest spacing."""
    if isinstance(obstacle, fs.Disc):
        angle = np.linspace(0, 2 * np.pi, n)
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        return obstacle.center + obstacle.radius * circle, 2 * np.pi * obstacle.radius / (n - 1)
    outline = obstacle.core.exterior
    points = shapely.line_interpolate_point(outline, np.linspace(0, outline.length, n))
    return shapely.get_coordinates(points), outline.length / (n - 1)


def off_boundary(obstacle, point):
    """Distance of a point from an obstacle's boundary."""
    if isinstance(obstacle, fs.Disc):
        return abs(np.hypot(*(point - obstacle.center)) - obstacle.radius)
    return obstacle.core.exterior.distance(shapely.Point(point))


def star(rng, center):
    """A random polygon, seldom convex."""
    angle = 2 * np.pi * (np.arange(7) + rng.uniform(0, 0.8, 7)) / 7
    reach = rng.uniform(0.3, 1, 7)[:, None]
    return fs.Polygon(center + reach * np.column_stack([np.cos(angle), np.sin(angle)]))


def mixed_world(rng):
    """Six obstacles in a row, discs and polygons, no two less than 0.3 m apart."""
    centers = np.column_stack([2.4 * np.arange(6), rng.uniform(-1, 1, 6)])
    return fs.World(
        [
            fs.Disc(center, rng.uniform(0.1, 1)) if rng.random() < 0.4 else star(rng, center)
            for center in centers
        ]
    )


@pytest.mark.parametrize("table", range(1, 6))
def test_lengths_are_the_papers_distances_less_the_radii(tables, table):
    world = tables[table]
    segments = fs.free_segments(world)
    assert [segment.obstacles for segment in segments] == [(i, i + 1) for i in range(6)]
    lengths = [1000 * segment.length for segment in segments]
    radii = 1000 * (world.radii[:-1] + world.radii[1:])
    assert_allclose(lengths, CENTRE_DISTANCES_MM[table] - radii, atol=0.051)


@pytest.mark.parametrize("table", range(1, 6))
def test_safe_segments_are_those_that_fit_the_robot_and_its_margin(tables, robot, table):
    segments = fs.free_segments(tables[table])
    for segment in segments:
        assert segment.required == pytest.approx(robot.diameter + MARGIN)
        assert segment.safe == (segment.length >= 0.1408 + 0.005)


def test_the_sizes_make_the_papers_statements_true(tables):
    # Figs 13 to 16: Table 1 is all safe, Tables 2 to 4 are both, Table 5 is all danger.
    safe = {k: [segment.safe for segment in fs.free_segments(tables[k])] for k in tables}
    assert all(safe[1])
    for table in (2, 3, 4):
        assert any(safe[table])
        assert not all(safe[table])
    assert not any(safe[5])


def test_the_sizes_leave_17_mm_to_every_statement(tables, robot, cases):
    # By hand, from the printed distances: Table 1's 2-3 has 200.0 - 18 - 18 = 164.0 mm, 18.2 over
    # D_r + delta = 145.8 mm; Table 5's 4-5 has 206.2 - 39 - 39 = 128.2 mm, 17.6 under it.
    lengths = {
        k: [1000 * segment.length for segment in fs.free_segments(tables[k])] for k in (1, 5)
    }
    assert min(lengths[1]) == pytest.approx(164.0, abs=0.051)
    assert max(lengths[5]) == pytest.approx(128.2, abs=0.051)
    assert min(min(lengths[1]) - 145.8, 145.8 - max(lengths[5])) > 17
    assert 1000 * tables[1].radii.min() > 17
    for case in cases.values():
        for point in (case.start, case.goal):
            distances = tables[case.table].distances(shapely.Point(point))
            assert 1000 * (distances.min() - robot.radius) > 17
    assert all(len(world.close_pairs(0.017)[0]) == 0 for world in tables.values())


@pytest.mark.parametrize(
    ("length", "safe"),
    [(REQUIRED, True), (np.nextafter(REQUIRED, 0), False), (np.nextafter(REQUIRED, 1), True)],
)
def test_safe_is_decided_at_the_robots_diameter_plus_the_margin(length, safe):
    # Disc to the left of x = 0, polygon from x = length on.
    polygon = fs.Polygon([(length, -1), (length + 1, -1), (length + 1, 1), (length, 1)])
    (segment,) = fs.free_segments(fs.World([fs.Disc((-0.5, 0), 0.5), polygon]), ROBOT, EXACT_MARGIN)
    assert segment.required == REQUIRED
    assert segment.length == length
    assert segment.safe is safe


def test_ends_by_hand():
    world = fs.World([fs.Disc((0, 3), 0.5), TRIANGLE, L_SHAPE, fs.Disc((5, 3), 0.25)])
    ends = [segment.ends for segment in fs.free_segments(world)]
    assert_allclose(ends[0], [(0, 2.5), (0, 1)], atol=1e-15)
    assert_allclose(ends[1], [(1, 0), (3, 0)], atol=1e-15)
    # The disc in the corner of the L looks at its upright.
    assert_allclose(ends[2], [(4, 3), (4.75, 3)], atol=1e-15)


def test_ends_against_sampled_boundaries():
    rng = np.random.default_rng(21)
    for _ in range(15):
        world = mixed_world(rng)
        for segment in fs.free_segments(world):
            a, b = (world.obstacles[index] for index in segment.obstacles)
            (on_a, step_a), (on_b, step_b) = boundary(a), boundary(b)
            sampled = np.hypot(*(on_a[:, None] - on_b).T).min()
            assert segment.length <= sampled + 1e-12
            assert sampled <= segment.length + (step_a + step_b) / 2
            assert off_boundary(a, segment.ends[0]) < 1e-12
            assert off_boundary(b, segment.ends[1]) < 1e-12


@pytest.mark.parametrize("obstacles", [[], [TRIANGLE]])
def test_no_segment_without_a_neighbour(obstacles):
    assert fs.free_segments(fs.World(obstacles)) == ()


@pytest.mark.parametrize("margin", [True, -0.01, np.nan, np.inf, None, "wide"])
def test_invalid_margin(tables, margin):
    with pytest.raises(fs.InvalidParameter, match="margin is "):
        fs.free_segments(tables[1], margin=margin)


# --- endpoints -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def endpoint_worlds(tables):
    rng = np.random.default_rng(22)
    worlds = [*tables.values(), *(mixed_world(rng) for _ in range(15))]
    return [*worlds, fs.World([L_SHAPE]), fs.World([fs.Disc((0, 0), 1)]), fs.World([TOOTHED])]


def test_endpoints_lie_on_the_boundary_of_their_obstacle(endpoint_worlds):
    for world in endpoint_worlds:
        endpoints = find_endpoints(world, fs.free_segments(world))
        assert {endpoint.obstacle for endpoint in endpoints} == set(range(len(world)))
        for endpoint in endpoints:
            assert off_boundary(world.obstacles[endpoint.obstacle], endpoint.point) < 1e-12


def test_outward_points_away_from_the_obstacle(endpoint_worlds):
    for world in endpoint_worlds:
        for endpoint in find_endpoints(world, fs.free_segments(world)):
            assert np.hypot(*endpoint.outward) == pytest.approx(1)
            ahead = shapely.Point(endpoint.point + 1e-6 * endpoint.outward)
            assert world.distances(ahead)[endpoint.obstacle] > 0


def test_safe_segments_have_both_endpoints_and_danger_segments_none(endpoint_worlds):
    kinds = set()
    for world in endpoint_worlds:
        segments = fs.free_segments(world)
        endpoints = find_endpoints(world, segments)
        for number, segment in enumerate(segments):
            ends = [endpoint for endpoint in endpoints if endpoint.segment == number]
            kinds.add(segment.safe)
            if not segment.safe:
                assert ends == []
                continue
            assert tuple(end.obstacle for end in ends) == segment.obstacles
            assert_array_equal([end.point for end in ends], segment.ends)
    assert kinds == {True, False}


def test_dangerous_circles_are_centred_on_discs_and_convex_corners(endpoint_worlds):
    for world in endpoint_worlds:
        for endpoint in find_endpoints(world, fs.free_segments(world)):
            assert endpoint.center.tolist() in world.corners[endpoint.obstacle].tolist()


def test_discs_have_an_endpoint_every_quarter_turn_at_least(endpoint_worlds):
    checked = 0
    for world in endpoint_worlds:
        segments = fs.free_segments(world)
        endpoints = find_endpoints(world, segments)
        for index, obstacle in enumerate(world.obstacles):
            if not isinstance(obstacle, fs.Disc):
                continue
            # An end of a danger segment is no endpoint, but nor is there a gap to fill.
            points = [end.point for end in endpoints if end.obstacle == index]
            for segment in segments:
                if index in segment.obstacles and not segment.safe:
                    points.append(segment.ends[segment.obstacles.index(index)])
            angles = np.sort([np.arctan2(*(point - obstacle.center)[::-1]) for point in points])
            assert np.diff(angles, append=angles[0] + 2 * np.pi).max() <= np.pi / 2 + 1e-6
            checked += 1
    assert checked > 50


def test_a_single_disc_has_four_outer_endpoints():
    endpoints = find_endpoints(fs.World([fs.Disc((1, 2), 0.5)]), ())
    assert all(endpoint.segment is None for endpoint in endpoints)
    points = {tuple(np.round(endpoint.point, 12).tolist()) for endpoint in endpoints}
    assert points == {(1.5, 2), (1, 2.5), (0.5, 2), (1, 1.5)}


def test_a_disc_at_the_end_of_the_chain_has_three_outer_endpoints():
    world = fs.World([fs.Disc((0, 0), 0.5), fs.Disc((2, 0), 0.5)])
    endpoints = find_endpoints(world, fs.free_segments(world))
    outer = [end.point for end in endpoints if end.obstacle == 0 and end.segment is None]
    points = {tuple(np.round(point, 12).tolist()) for point in outer}
    assert len(outer) == 3
    assert points == {(0, 0.5), (-0.5, 0), (0, -0.5)}


def test_outer_endpoints_of_a_polygon_are_its_convex_corners():
    endpoints = find_endpoints(fs.World([L_SHAPE]), ())
    points = {tuple(endpoint.point.tolist()) for endpoint in endpoints}
    assert points == {(3, 0), (5, 0), (5, 1), (4, 3), (3, 3)}


# --- groups --------------------------------------------------------------------------------------


def test_groups_by_hand():
    row = fs.World([fs.Disc((x, 0), 0.5) for x in (0, 5, 1.25, 2.5, 6.25, 9)])
    # Gaps of 0.25 m join 1-3-4 and 2-5.
    labels = group_labels(row, 0.25)
    assert len(set(labels.tolist())) == 3
    assert labels[0] == labels[2] == labels[3]
    assert labels[1] == labels[4]
    assert len(set(group_labels(row, 0.24).tolist())) == 6
    assert len(set(group_labels(row, 1.75).tolist())) == 1


def test_groups_against_spreading_labels():
    rng = np.random.default_rng(23)
    for _ in range(20):
        world = fs.World(
            [
                fs.Disc((x + rng.uniform(-0.2, 0.2), y), rng.uniform(0.05, 0.25))
                for x in range(5)
                for y in range(5)
            ]
        )
        gap = rng.uniform(0.3, 0.8)
        apart = np.array([world.distances(core) for core in world.cores]) - world.radii[:, None]
        expected = np.arange(25)
        for _ in range(25):
            expected = np.where(apart <= gap, expected, 25).min(1)
        found = group_labels(world, gap)
        assert_array_equal(found[:, None] == found, expected[:, None] == expected)


def test_groups_of_no_obstacle():
    assert group_labels(fs.World([]), 0.1).shape == (0,)
