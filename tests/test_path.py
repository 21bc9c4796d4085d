import json

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.geometry import unit
from freeseg.path import Arc, Line, taut_path

#: 2 m east, a quarter turn left of radius 1 m, 3 m north, a half turn right of radius 0.5 m.
HOOK = fs.Path(
    [
        Line((0, 0), (2, 0)),
        Arc((2, 1), 1, -np.pi / 2, np.pi / 2),
        Line((3, 1), (3, 4)),
        Arc((3.5, 4), 0.5, np.pi, -np.pi),
    ]
)
HOOK_JOINTS = np.cumsum([0, 2, np.pi / 2, 3, np.pi / 2])


def random_paths(seed, n):
    """Taut paths round up to four random circles."""
    rng, paths = np.random.default_rng(seed), []
    while len(paths) < n:
        count = rng.integers(0, 5)
        circles = zip(rng.uniform(-2, 2, (count, 2)), rng.uniform(-0.5, 0.5, count), strict=True)
        path, _ = taut_path(rng.uniform(-2, 2, 2), list(circles), rng.uniform(-2, 2, 2))
        if path is not None:
            paths.append(path)
    return paths


# --- pieces --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ((0, 0), (0, 0)),
        ((0, np.nan), (1, 0)),
        ((0, 0), (np.inf, 0)),
        ((0, 0, 0), (1, 0)),
        ((0, 0), 1),
        ((0, 0), None),
        ("ab", (1, 0)),
    ],
)
def test_invalid_line(arguments):
    with pytest.raises(fs.InvalidParameter, match="Line"):
        Line(*arguments)


@pytest.mark.parametrize(
    "arguments",
    [
        ((0, 0), 1, 0, 0),
        ((0, 0), 0, 0, 1),
        ((0, 0), -1, 0, 1),
        ((0, 0), np.nan, 0, 1),
        ((0, 0), 1, np.inf, 1),
        ((0, 0), 1, 0, np.nan),
        ((np.nan, 0), 1, 0, 1),
        ((0,), 1, 0, 1),
        ((0, 0), (1, 1), 0, 1),
        ((0, 0), 1, None, 1),
    ],
)
def test_invalid_arc(arguments):
    with pytest.raises(fs.InvalidParameter, match="Arc"):
        Arc(*arguments)


def test_arc_by_hand():
    left, right = Arc((1, 2), 2, 0, np.pi / 2), Arc((1, 2), 2, 0, -3 * np.pi / 2)
    assert (left.length, right.length) == (pytest.approx(np.pi), pytest.approx(3 * np.pi))
    assert (left.curvature, right.curvature) == (0.5, -0.5)
    assert_allclose([left.start, left.end], [(3, 2), (1, 4)], atol=1e-15)
    assert_allclose([right.start, right.end], [(3, 2), (1, 4)], atol=1e-14)
    assert_allclose([left.at(0)[2], right.at(0)[2]], [np.pi / 2, -np.pi / 2])


# --- paths ---------------------------------------------------------------------------------------


def test_lengths_by_hand():
    assert fs.Path([Line((0, 0), (3, 4))]).length == 5
    assert_allclose(HOOK.joints, HOOK_JOINTS)
    assert HOOK.length == pytest.approx(5 + np.pi)
    assert_allclose([HOOK.start, HOOK.end], [(0, 0), (4, 4)], atol=1e-15)


def test_at_by_hand():
    s = [1, 2 + np.pi / 4, 4 + np.pi / 2, 5 + 3 * np.pi / 4]
    x, y, theta, curvature = HOOK.at(s)
    assert_allclose(x, [1, 2 + np.sqrt(0.5), 3, 3.5])
    assert_allclose(y, [0, 1 - np.sqrt(0.5), 3, 4.5], atol=1e-15)
    assert_allclose(theta, [0, np.pi / 4, np.pi / 2, 0], atol=1e-14)
    assert_array_equal(curvature, [0, 1, 0, -2])


def test_at_beyond_the_ends_is_at_the_ends():
    beyond, ends = HOOK.at([-1, HOOK.length + 1]), HOOK.at([0, HOOK.length])
    assert_array_equal(beyond, ends)


@pytest.mark.parametrize("path", [HOOK, *random_paths(31, 20)])
def test_position_and_heading_are_continuous(path):
    step = path.length / 20_000
    x, y, theta, curvature = path.at(np.linspace(0, path.length, 20_001))
    assert np.hypot(np.diff(x), np.diff(y)).max() <= step * (1 + 1e-6)
    # The heading turns at the rate of the curvature, so it neither jumps nor wraps.
    assert np.abs(np.diff(theta)).max() <= step * np.abs(curvature).max() + 1e-7
    # It is the direction of travel, to first order in the step.
    travel = np.column_stack([np.diff(x), np.diff(y)]) / step
    assert_allclose(travel, unit(theta[:-1]), rtol=0, atol=step * np.abs(curvature).max() + 1e-6)


@pytest.mark.parametrize("path", [HOOK, *random_paths(32, 20)])
def test_curvature_is_the_signed_rate_of_the_heading(path):
    turned = sum(getattr(piece, "sweep", 0.0) for piece in path.pieces)
    _, _, theta, _ = path.at([0, path.length])
    assert theta[1] - theta[0] == pytest.approx(turned)
    middles = (path.joints[:-1] + path.joints[1:]) / 2
    signs = np.sign(path.at(middles)[3])
    assert_array_equal(signs, [np.sign(getattr(piece, "sweep", 0.0)) for piece in path.pieces])


@pytest.mark.parametrize("step", [0.003, 0.1, 0.7, 100, np.inf])
def test_samples_are_dense_and_contain_the_joints(step):
    for path in [HOOK, *random_paths(33, 20)]:
        points = path.sample(step)
        assert np.hypot(*np.diff(points, axis=0).T).max() <= step * (1 + 1e-12)
        # As many as are needed, and no more than one extra a piece.
        assert len(points) <= path.length / step + len(path.pieces) + 1
        assert_array_equal(points[[0, -1]], [path.start, path.end])
        joints = np.column_stack(path.at(path.joints)[:2])
        apart = np.hypot(*np.moveaxis(points[:, None] - joints, -1, 0))
        assert apart.min(0).max() < 1e-12


def test_samples_agree_with_at():
    for path in [HOOK, *random_paths(34, 20)]:
        counts = [int(np.ceil(piece.length / 0.05)) for piece in path.pieces]
        s = [
            np.linspace(first, last, count, endpoint=False)
            for first, last, count in zip(path.joints, path.joints[1:], counts, strict=False)
        ]
        x, y, _, _ = path.at(np.concatenate([*s, [path.length]]))
        assert_allclose(path.sample(0.05), np.column_stack([x, y]), rtol=0, atol=1e-12)


@pytest.mark.parametrize("step", [0, -0.1, np.nan])
def test_invalid_step(step):
    with pytest.raises(fs.InvalidParameter, match="step is"):
        HOOK.sample(step)


@pytest.mark.parametrize(
    "pieces",
    [
        [],
        [Line((0, 0), (1, 0)), Line((1, 1e-3), (2, 1e-3))],  # a gap
        [Line((0, 0), (1, 0)), Line((1, 0), (2, 1))],  # a kink
        [Line((0, 0), (1, 0)), Line((1, 0), (0, 0))],  # turns back
        [Line((0, 0), (1, 0)), Arc((1, 1), 1, -np.pi / 2, -1)],  # an arc the wrong way
        [Arc((0, 0), 1, 0, 1), Line((5, 5), (6, 5))],
    ],
)
def test_invalid_path(pieces):
    with pytest.raises(fs.InvalidParameter):
        fs.Path(pieces)


@pytest.mark.parametrize("pieces", [[1], [1, 2], [Line((0, 0), (1, 0)), "Arc"]])
def test_path_of_what_is_no_piece(pieces):
    with pytest.raises(fs.InvalidParameter):
        fs.Path(pieces)


# --- clearance -----------------------------------------------------------------------------------

POLYGONS = [
    fs.Polygon([(-1.5, -1.5), (-0.9, -1.4), (-1.2, -0.8)]),
    fs.Polygon([(0.5, 0.5), (1.5, 0.5), (1.5, 0.7), (0.7, 0.7), (0.7, 1.5), (0.5, 1.5)]),
]
DISCS = [fs.Disc((-1, 1), 0.3), fs.Disc((1.2, -1), 0.5), fs.Disc((1.2, 1.2), 0.1)]


def sampled_clearance(path, obstacle, step):
    """Least distance of points on the path from a disc or a polygon, by Shapely."""
    points = shapely.points(path.sample(step))
    if isinstance(obstacle, fs.Disc):
        return shapely.distance(points, shapely.Point(obstacle.center)).min() - obstacle.radius
    return shapely.distance(points, shapely.Polygon(obstacle.vertices)).min()


@pytest.mark.parametrize("obstacle", [*DISCS, *POLYGONS])
def test_clearance_against_dense_samples(obstacle):
    world, step, met = fs.World([obstacle]), 1e-3, 0
    for path in random_paths(35, 60):
        clearance, sampled = path.clearance(world), sampled_clearance(path, obstacle, step)
        assert clearance <= sampled + 1e-12
        assert sampled <= clearance + step / 2 + 1e-12
        met += clearance <= 0
    assert 0 < met < 60


def test_clearance_is_the_least_of_all_obstacles_and_pieces():
    world = fs.World([*DISCS, *POLYGONS])
    for path in random_paths(36, 20):
        distances = path.distances(world)
        assert distances.shape == (len(path.pieces), len(world))
        for column, obstacle in zip(distances.T, world.obstacles, strict=True):
            assert column.min() == path.clearance(fs.World([obstacle]))
        assert path.clearance(world) == distances.min()


def test_clearance_by_hand():
    assert HOOK.clearance(fs.World([fs.Disc((2, 1), 0.25)])) == pytest.approx(0.75)
    assert HOOK.clearance(fs.World([fs.Disc((3.5, 4), 0.25)])) == pytest.approx(0.25)
    assert HOOK.clearance(fs.World([fs.Disc((0, 5), 0.5)])) == pytest.approx(np.hypot(3.5, 1) - 1)
    square = fs.Polygon([(1, 2), (2, 2), (2, 3), (1, 3)])
    assert HOOK.clearance(fs.World([square])) == pytest.approx(1)


@pytest.mark.parametrize(
    "path",
    [
        fs.Path([Line((-1, 0), (1, 0))]),  # all inside: the outline is far
        fs.Path([Arc((0, 0), 1, 0, 2 * np.pi)]),
        fs.Path([Line((-9, 0), (0, 0))]),  # ends inside
        fs.Path([Line((0, 0), (9, 0))]),  # starts inside
        fs.Path([Line((-9, 0), (9, 0))]),  # crosses
        fs.Path([Line((-9, 5), (9, 5))]),  # touches
    ],
)
def test_clearance_of_a_path_that_meets_a_polygon(path):
    world = fs.World([fs.Polygon([(-5, -5), (5, -5), (5, 5), (-5, 5)])])
    assert path.clearance(world) <= 0


def test_clearance_of_a_path_inside_a_disc():
    assert fs.Path([Line((-1, 0), (1, 0))]).clearance(fs.World([fs.Disc((0, 0), 5)])) <= 0


def test_clearance_in_an_empty_world():
    assert HOOK.clearance(fs.World([])) == np.inf
    assert HOOK.distances(fs.World([])).shape == (4, 0)


# --- files ---------------------------------------------------------------------------------------


def test_a_path_is_read_as_it_was_saved(tmp_path):
    for path in [HOOK, *random_paths(37, 10)]:
        path.save(tmp_path / "path.json")
        assert fs.Path.load(tmp_path / "path.json") == path


def test_missing_file(tmp_path):
    with pytest.raises(fs.InvalidData, match=r"nothing\.json is not a path"):
        fs.Path.load(tmp_path / "nothing.json")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "not json",
        "[]",
        "5",
        "{}",
        '{"pieces": []}',
        '{"pieces": 5}',
        '{"pieces": [5]}',
        '{"pieces": [{}]}',
        '{"pieces": [{"kind": "Spline"}]}',
        '{"pieces": [{"kind": "Line", "start": [0, 0]}]}',
        '{"pieces": [{"kind": "Line", "start": [0, 0], "end": [1, 0], "width": 1}]}',
    ],
)
def test_broken_file(tmp_path, text):
    file = tmp_path / "path.json"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(fs.InvalidData, match=r"path\.json is not a path"):
        fs.Path.load(file)


@pytest.mark.parametrize(
    ("piece", "field", "value"),
    [
        (0, "start", [0, None]),
        (0, "end", [0, 0]),
        (0, "end", [1, 0]),  # a gap
        (0, "end", [float("nan"), 0]),
        (1, "radius", -1),
        (1, "sweep", 0),
        (1, "sweep", "a lot"),
        (1, "start_angle", 0),  # a kink
        (2, "kind", "Arc"),
    ],
)
def test_file_with_a_broken_piece(tmp_path, piece, field, value):
    file = tmp_path / "path.json"
    HOOK.save(file)
    content = json.loads(file.read_text(encoding="utf-8"))
    content["pieces"][piece][field] = value
    file.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(fs.InvalidData, match=r"path\.json is not a path"):
        fs.Path.load(file)


# --- taut paths ----------------------------------------------------------------------------------


def test_taut_path_without_circles_is_the_straight_line():
    assert taut_path((0, 0), [], (3, 4)) == (fs.Path([Line((0, 0), (3, 4))]), [0])


@pytest.mark.parametrize("sense", [1, -1])
def test_taut_path_round_a_circle_by_hand(sense):
    # Tangents from 5 m off a circle of radius 3 m are 4 m long and leave at acos(3/5).
    path, passed = taut_path((-5, 0), [((0, 0), 3 * sense)], (5, 0))
    sweep = np.pi - 2 * np.arccos(3 / 5)
    assert [type(piece) for piece in path.pieces] == [Line, Arc, Line]
    assert passed == [0, 0, 1]
    assert path.length == pytest.approx(8 + 3 * sweep)
    assert path.pieces[1].sweep == pytest.approx(sense * sweep)
    # Counter-clockwise with the centre on the left: the path passes below.
    assert path.pieces[1].start == pytest.approx((-1.8, -2.4 * sense))


def test_taut_path_round_two_circles_by_hand():
    # Left of the lower one, right of the upper one, as wide as 3-4-5 triangles make it.
    path, passed = taut_path((0, -9), [((0, 0), -3), ((10, 0), 3)], (10, 9))
    assert passed == [0, 0, 1, 1, 2]
    inner = path.pieces[2]
    assert_allclose([inner.start, inner.end], [(1.8, 2.4), (8.2, -2.4)], atol=1e-14)
    assert inner.length == pytest.approx(8)
    first, second = path.pieces[1], path.pieces[3]
    assert (first.sweep < 0, second.sweep > 0) == (True, True)
    assert first.length == pytest.approx(second.length)
    # By symmetry about the middle of the inner tangent.
    assert path.length == pytest.approx(8 + 2 * (first.length + np.sqrt(72)))


@pytest.mark.parametrize("sense", [1, -1])
def test_taut_path_that_only_grazes_a_circle_does_not_go_round_it(sense):
    # Turned by any angle: round-off makes the sweep a little more, or less, than zero.
    for angle in np.random.default_rng(38).uniform(-np.pi, np.pi, 100):
        ahead, left = unit(angle), unit(angle + np.pi / 2)
        path, _ = taut_path(-5 * ahead, [(sense * left, sense)], 5 * ahead)
        assert path.length == pytest.approx(10)
        assert {type(piece) for piece in path.pieces} == {Line}


@pytest.mark.parametrize(
    ("start", "circles", "goal"),
    [
        ((0.5, 0), [((0, 0), 1)], (5, 0)),  # the start is inside
        ((-5, 0), [((0, 0), 1)], (0, 0.5)),  # the goal is inside
        ((-5, 0), [((0, 0), 3), ((1, 0), 1)], (5, 0)),  # a circle is inside the other
        ((-5, 0), [((0, 0), 1), ((1, 0), -1)], (5, 0)),  # no inner tangent
    ],
)
def test_taut_path_that_does_not_exist(start, circles, goal):
    assert taut_path(start, circles, goal) == (None, [])


def test_a_file_with_a_byte_order_mark(tmp_path):
    path = fs.Path([Line((0, 0), (1, 0))])
    path.save(tmp_path / "path.json")
    marked = tmp_path / "marked.json"
    marked.write_bytes(b"\xef\xbb\xbf" + (tmp_path / "path.json").read_bytes())
    assert fs.Path.load(marked) == path


def test_a_gap_and_a_kink_are_told_where_and_what_to_do():
    first = Line((0, 0), (1, 0))
    for after in (Line((1, 0.1), (2, 0.1)), Line((1, 0), (1, 1))):
        with pytest.raises(
            fs.InvalidParameter, match=r"ends, at \(1, 0\) m .*; join them by"
        ) as found:
            fs.Path([first, after])
        assert "Arc" in str(found.value)
