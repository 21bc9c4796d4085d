"""Worlds from and to other people's maps: by hand, there and back, and broken ones."""

import json

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image
from scipy import ndimage

import freeseg as fs
from freeseg.data import DATA
from freeseg.outlines import trace_cells

maps = fs.maps
SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]
YARD = [(1, 1), (3, 1), (3, 3), (1, 3)]
WORLD = fs.World(
    [fs.Disc((1 / 3, 6), 0.7), fs.Polygon(SQUARE, [YARD]), fs.Polygon([(5, 0), (7, 0.1), (6, 2)])],
    boundary=[(-1, -1), (9, -1), (9, 8), (-1, 8)],
)
SETTINGS = """\
image: map.pgm
resolution: 0.5
origin: [1.0, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
OCTILE = "type octile\nheight 2\nwidth 3\nmap\n@.G\nTSW\n"


def cells_of(occupied):
    """Occupied cells as one geometry."""
    rows, columns = np.nonzero(occupied)
    return shapely.union_all(shapely.box(columns, rows, columns + 1.0, rows + 1.0))


def assert_same(found, wanted, atol=0.0):
    assert len(found) == len(wanted)
    np.testing.assert_allclose(found.edges, wanted.edges, rtol=0, atol=atol)
    np.testing.assert_array_equal(found.radii, wanted.radii)
    assert (found.boundary is None) == (wanted.boundary is None)
    for one, other in zip(found, wanted, strict=True):
        assert type(one) is type(other)
        assert len(one.rings) == len(other.rings)


# ---- Shapely and WKT --------------------------------------------------------------------------


def test_every_kind_of_geometry_becomes_obstacles():
    parts = [shapely.box(0, 0, 1, 1), shapely.Point(5, 5, 0.5)]
    several = shapely.MultiPolygon([shapely.box(10, 0, 11, 1), shapely.Polygon(SQUARE, [YARD])])
    nested = shapely.GeometryCollection([parts[0], shapely.GeometryCollection([several])])
    world = maps.from_shapely([*parts, several, nested, shapely.Polygon()])
    assert [type(one).__name__ for one in world] == ["Polygon", "Disc", *["Polygon"] * 5]
    assert world.radii[1] == 0.5
    assert [len(one.holes) for one in world if isinstance(one, fs.Polygon)] == [0, 0, 1, 0, 0, 1]
    assert len(maps.from_shapely(parts[0])) == 1
    assert len(maps.from_shapely([])) == 0


def test_shapely_and_wkt_there_and_back_lose_nothing(tables):
    unbounded = fs.World(WORLD.obstacles[:3])
    for world in (WORLD, unbounded, tables[1], fs.World([])):
        assert_same(maps.from_shapely(*maps.to_shapely(world)), world)
        assert_same(maps.from_wkt(*maps.to_wkt(world)), world)


@pytest.mark.parametrize(
    ("geometries", "boundary", "match"),
    [
        ([shapely.Point(0, 0)], None, "without a radius"),
        ([shapely.LineString([(0, 0), (1, 1)])], None, "shapely.buffer"),
        (shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), None, "shapely.make_valid"),
        ([shapely.box(0, 0, 1, 1), None], None, "geometries is"),
        ("POINT (0 0)", None, "geometries is"),
        ([shapely.Point(0, 0, -1)], None, "radius of the disc"),
        ([], shapely.Point(0, 0), "boundary has"),
        ([], shapely.Polygon(SQUARE, [YARD]), "boundary has holes"),
        ([], SQUARE, "boundary is"),
    ],
)
def test_geometries_that_are_no_world(geometries, boundary, match):
    with pytest.raises(fs.InvalidWorld, match=match):
        maps.from_shapely(geometries, boundary)


def test_text_that_is_no_wkt():
    for text in ("POLYGON ((0 0, 1 1))", "hello", 5):
        with pytest.raises(fs.InvalidWorld, match="text is"):
            maps.from_wkt(text)
    with pytest.raises(fs.InvalidWorld, match="boundary is 'x'"):
        maps.from_wkt("POINT Z (0 0 1)", "x")


# ---- GeoJSON ----------------------------------------------------------------------------------


def test_geojson_there_and_back_loses_nothing(tmp_path, tables):
    for world in (WORLD, tables[1], fs.World([])):
        maps.save_geojson(world, tmp_path / "map.geojson")
        assert_same(maps.load_geojson(tmp_path / "map.geojson"), world)


@pytest.mark.parametrize("origin", [(9.1, 48.7), (0, 0), (179.99999, -35), (-70, 85)])
def test_degrees_there_and_back(tmp_path, origin):
    file = tmp_path / "map.geojson"
    maps.save_geojson(WORLD, file, "deg", origin)
    assert_same(maps.load_geojson(file, "deg", origin), WORLD, atol=1e-8)
    found = json.loads(file.read_text())["features"][1]["geometry"]["coordinates"][0]
    off = (np.subtract(found, origin) + 180) % 360 - 180
    np.testing.assert_allclose(off, 0, atol=0.01)
    assert np.abs(found).max() <= 180


def test_a_degree_is_as_long_as_on_the_ellipsoid():
    # Table values at 45 degrees: 111 131.8 m of latitude, 78 846.8 m of longitude.
    plane = maps._TangentPlane.at((7, 45))
    d = 1e-4
    ends = np.array([(7 + d, 45), (7 - d, 45), (7, 45 + d), (7, 45 - d)])
    east, west, north, south = plane.to_metres(ends)
    assert np.hypot(*(east - west)) / (2 * d) == pytest.approx(78846.8, abs=0.1)
    assert np.hypot(*(north - south)) / (2 * d) == pytest.approx(111131.8, abs=0.1)
    assert east[0] > 0 < north[1]


@pytest.mark.parametrize("away", [1e4, 9.9e4])
@pytest.mark.parametrize("latitude", [-60, 0, 45, 80])
def test_the_error_of_the_projection_is_as_stated(away, latitude):
    plane = maps._TangentPlane.at((7, latitude))
    for angle in np.linspace(0, 2 * np.pi, 17):
        here = away * np.array([[np.cos(angle), np.sin(angle)]])
        longitude, there = plane.to_degrees(here)[0]
        # In a plane of its own, what is near by has its true length.
        local = maps._TangentPlane.at((longitude, there))
        for step in ((1.0, 0.0), (0.0, 1.0), (0.7, -0.7)):
            true = np.hypot(*local.to_metres(plane.to_degrees(here + step))[0])
            assert np.hypot(*step) / true - 1 == pytest.approx(0, abs=2e-6 * (away / 1e4) ** 2)


def test_the_middle_of_a_map_in_degrees_is_the_origin(tmp_path):
    file = tmp_path / "map.geojson"
    corners = [[9, 48], [9.001, 48], [9.001, 48.001], [9, 48.001], [9, 48]]
    file.write_text(json.dumps({"type": "Polygon", "coordinates": [corners]}))
    (obstacle,) = maps.load_geojson(file, "deg")
    np.testing.assert_allclose(obstacle.vertices.mean(0), 0, atol=0.01)
    assert obstacle.core.area == pytest.approx(74.6 * 111.2, rel=0.01)


@pytest.mark.parametrize(
    "crs", ["urn:ogc:def:crs:OGC:1.3:CRS84", "urn:ogc:def:crs:EPSG::4326", "EPSG:4326"]
)
def test_a_file_that_names_degrees_is_not_read_as_metres(tmp_path, crs):
    file = tmp_path / "map.geojson"
    maps.save_geojson(WORLD, file)
    found = json.loads(file.read_text())
    found["crs"] = {"type": "name", "properties": {"name": crs}}
    file.write_text(json.dumps(found))
    with pytest.raises(fs.InvalidData, match=r"crs is .* has degrees; give unit='deg'"):
        maps.load_geojson(file)
    assert_same(maps.load_geojson(file, "m"), WORLD)
    # A projected system is in metres.
    found["crs"]["properties"]["name"] = "urn:ogc:def:crs:EPSG::25832"
    file.write_text(json.dumps(found))
    assert_same(maps.load_geojson(file), WORLD)


def test_a_building_in_degrees_does_not_become_one_of_a_centimetre(tmp_path):
    file = tmp_path / "map.geojson"
    maps.save_geojson(WORLD, file, "deg", (9.1, 48.7))
    with pytest.raises(fs.InvalidData, match=r"too small for a map in metres.*unit='deg'"):
        maps.load_geojson(file)
    assert_same(maps.load_geojson(file, "deg", (9.1, 48.7)), WORLD, atol=1e-8)
    # Who says that it is that small is believed; one disc may be anywhere.
    assert np.ptp(maps.load_geojson(file, "m")[1].rings[0], axis=0).max() < 1e-3
    maps.save_geojson(alone := fs.World([fs.Disc((3, 4), 0.01)]), file)
    assert_same(maps.load_geojson(file), alone)


def test_features_as_others_write_them(tmp_path):
    file = tmp_path / "map.geojson"
    square = {"type": "Polygon", "coordinates": [[[*corner, 7] for corner in [*SQUARE, SQUARE[0]]]]}
    point = {"type": "Point", "coordinates": [9, 9]}
    features = [
        {"type": "Feature", "geometry": square, "properties": None},
        {"type": "Feature", "geometry": point, "properties": {"radius": 2, "name": "table"}},
        {"type": "Feature", "geometry": None, "properties": {}},
        {"type": "Feature", "geometry": square, "properties": {"role": "boundary"}},
        {"type": "GeometryCollection", "geometries": [square]},
    ]
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}), "utf-8-sig")
    world = maps.load_geojson(file)
    assert [len(one.rings[0]) for one in world] == [4, 1, 4, 4]
    assert world.boundary.tolist() == np.array(SQUARE).tolist()


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("{", "Expecting"),
        ("[]", "an object with a type"),
        ('{"type": "FeatureCollection"}', "'features' is None"),
        ('{"type": "Polygon"}', "no geometry"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], [1, 1]]]}', "no geometry"),
        ('{"type": "Polygon", "coordinates": [[["a", 0], [1, 1], [1, 0], [0, 0]]]}', "no geometry"),
        ('{"type": "Point", "coordinates": [NaN, 0]}', "not finite"),
        ('{"type": "Point", "coordinates": [0, 0]}', "no property 'radius'"),
        (
            '{"type": "Feature", "geometry": {"type": "Point", "coordinates": [0, 0]}, '
            '"properties": {"radius": "1"}}',
            "radius of the disc",
        ),
        ('{"type": "LineString", "coordinates": [[0, 0], [1, 1]]}', "give polygons"),
        (
            '{"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]]}',
            "make_valid",
        ),
    ],
)
def test_broken_geojson(tmp_path, text, match):
    file = tmp_path / "map.geojson"
    file.write_text(text)
    with pytest.raises(fs.InvalidData, match=r"file map\.geojson") as caught:
        maps.load_geojson(file)
    assert match in str(caught.value)


def test_geojson_with_two_boundaries_or_off_the_globe(tmp_path):
    file = tmp_path / "map.geojson"
    maps.save_geojson(WORLD, file)
    with pytest.raises(fs.InvalidData, match="over 100 km"):
        maps.load_geojson(file, "deg")
    found = json.loads(file.read_text())
    found["features"].append(found["features"][-1])
    file.write_text(json.dumps(found))
    with pytest.raises(fs.InvalidData, match="2 boundaries"):
        maps.load_geojson(file)
    with pytest.raises(fs.InvalidParameter, match="origin"):
        maps.save_geojson(WORLD, file, "deg")
    with pytest.raises(fs.InvalidParameter, match="origin"):
        maps.load_geojson(file, "deg", (200, 0))
    with pytest.raises(fs.InvalidParameter, match="unit is 'ft'"):
        maps.load_geojson(file, "ft")


# ---- Grids ------------------------------------------------------------------------------------


def test_a_grid_by_hand():
    # Row 0 is the lowest, as in ROS's message.
    world = maps.from_grid([[1, 1, 0], [0, 0, 0], [0, 0, 1]], 0.5, (10, 20), tolerance=0)
    wall, block, frame = world
    assert shapely.equals(wall.core, shapely.box(10, 20, 11, 20.5))
    assert shapely.equals(block.core, shapely.box(11, 21, 11.5, 21.5))
    assert frame.boundary.tolist() == [[10, 20], [11.5, 20], [11.5, 21.5], [10, 21.5]]
    assert maps.from_grid([[0]], 1, boundary=False).obstacles == ()


def test_a_turned_grid():
    (block,) = maps.from_grid([[0, 1]], 2, (1, 1, np.pi / 2), boundary=False)
    assert shapely.equals_exact(
        block.core.normalize(), shapely.box(-1, 3, 1, 5).normalize(), tolerance=1e-12
    )


def test_a_slanting_wall_becomes_straight():
    stairs = np.tri(40, dtype=bool)
    assert sum(map(len, maps.from_grid(stairs, 0.1, tolerance=0)[0].rings)) > 70
    (wall,) = maps.from_grid(stairs, 0.1, boundary=False)
    # The ends of the stairs are a step each.
    assert len(wall.vertices) == 5
    # What is straight stays where it is.
    (slab,) = maps.from_grid(np.ones((3, 30), bool), 0.1, boundary=False, tolerance=1)
    assert len(slab.vertices) == 4
    np.testing.assert_allclose(slab.core.bounds, (0, 0, 3, 0.3), atol=1e-12)


def assert_covers_and_grows_little(occupied, tolerance):
    exact, simpler = trace_cells(occupied), trace_cells(occupied, tolerance)
    cells = cells_of(occupied)
    assert shapely.is_valid([*exact, *simpler]).all()
    assert shapely.union_all(exact).equals(cells)
    assert sum(polygon.area for polygon in exact) == occupied.sum()
    assert len(simpler) == len(exact)
    for polygon, before in zip(simpler, exact, strict=True):
        assert polygon.buffer(1e-9).covers(before)
        # A buffer's circles are polygons, so a little more than the tolerance.
        assert before.buffer(tolerance * 1.001 + 1e-9, quad_segs=32).covers(polygon)
        assert shapely.get_num_coordinates(polygon) <= shapely.get_num_coordinates(before)


@given(
    arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12))),
    st.sampled_from([0.0, 0.5, 0.75, 1.0, 2.0, 5.0]),
)
@settings(max_examples=150, deadline=None)
def test_simplified_cells_cover_the_cells_and_grow_by_no_more_than_the_tolerance(occupied, slack):
    assert_covers_and_grows_little(occupied, slack)


@pytest.mark.parametrize("seed", range(20))
def test_the_same_of_caves(seed):
    rng = np.random.default_rng(seed)
    occupied = rng.random((40, 50)) < rng.uniform(0.3, 0.6)
    for _ in range(3):
        padded = np.pad(occupied.astype(int), 1, constant_values=1)
        windows = np.lib.stride_tricks.sliding_window_view(padded, (3, 3))
        occupied = windows.sum((2, 3)) > 4
    assert_covers_and_grows_little(occupied, rng.choice([0.75, 1.0, 2.0]))


@pytest.mark.parametrize("seed", range(12))
def test_round_off_spoils_no_cave(seed):
    occupied = np.random.default_rng(seed).random((120, 120)) < 0.48
    for _ in range(4):
        occupied = ndimage.uniform_filter(occupied.astype(float), 5, mode="constant", cval=1) > 0.5
    cells = cells_of(occupied)
    for slack in (1, 4, 8):
        world = maps.from_grid(occupied, 0.05, (0.7, -900.3, 0.1 * seed), 0.05 * slack, False)
        found = shapely.transform(
            shapely.union_all(world.cores),
            lambda xy: rotated(xy - (0.7, -900.3), -0.1 * seed) / 0.05,
        )
        assert found.buffer(1e-7).covers(cells)
        assert cells.buffer(slack * 1.001, quad_segs=32).covers(found)


def rotated(points, angle):
    """Points (n, 2) turned about the origin."""
    turned = (points[:, 0] + 1j * points[:, 1]) * np.exp(1j * angle)
    return np.stack([turned.real, turned.imag], axis=1)


def test_grids_that_are_none():
    for bad in ([], [1, 0], [[2]], [["x"]], [[1], [0, 1]], np.ones((2, 2)) * 0.5):
        with pytest.raises(fs.InvalidParameter, match="occupied is"):
            maps.from_grid(bad, 1)
    for bad in ({"resolution": 0}, {"origin": (0,)}, {"tolerance": -1}, {"boundary": 1}):
        with pytest.raises(fs.InvalidParameter, match=next(iter(bad))):
            maps.from_grid(**{"occupied": [[1]], "resolution": 1} | bad)


# ---- ROS --------------------------------------------------------------------------------------


@pytest.fixture
def ros_map(tmp_path):
    """Writes a map of settings and pixels, and returns its file."""

    def write(pixels=((0, 254), (205, 254)), replace=("", ""), name="map.pgm"):
        file = tmp_path / "map.yaml"
        text = SETTINGS.replace("map.pgm", name)
        assert replace[0] in text
        file.write_text(text.replace(*replace))
        Image.fromarray(np.array(pixels, np.uint8)).save(tmp_path / name)
        return file

    return write


def covered(world):
    """Area of all obstacles but the boundary."""
    return shapely.union_all(world.cores[: world.frame])


def test_a_ros_map_by_hand(ros_map):
    # The image's first row is the upper one.
    world = maps.load_ros_map(ros_map(), tolerance=0, unknown="free")
    assert covered(world).equals(shapely.box(1, 2.5, 1.5, 3))
    world = maps.load_ros_map(ros_map(), tolerance=0)
    assert covered(world).equals(shapely.box(1, 2, 1.5, 3))
    assert world.boundary.tolist() == [[1, 2], [2, 2], [2, 3], [1, 3]]
    assert maps.load_ros_map(ros_map(), boundary=False).boundary is None


@pytest.mark.parametrize("kind", ["pgm", "png", "P2", "16 bit", "colour", "palette", "one bit"])
def test_every_kind_of_image(ros_map, tmp_path, kind):
    pixels = np.array([[0, 255, 255], [0, 0, 255]], np.uint8)
    file = ros_map(pixels, name="map.png" if kind not in ("pgm", "P2") else "map.pgm")
    if kind == "P2":
        (tmp_path / "map.pgm").write_text("P2\n# by hand\n3 2\n15\n0 15 15\n0 0 15\n")
    elif kind == "16 bit":
        Image.fromarray(257 * pixels.astype(np.uint16)).save(tmp_path / "map.png")
    elif kind in ("colour", "palette", "one bit"):
        mode = {"colour": "RGB", "palette": "P", "one bit": "1"}[kind]
        Image.fromarray(pixels).convert(mode).save(tmp_path / "map.png")
    assert covered(maps.load_ros_map(file, tolerance=0)).area == pytest.approx(3 * 0.25)


def test_modes_and_signs(ros_map, tmp_path):
    half_way = [[0, 130], [254, 254]]  # 130 is 49 %
    for mode, unknown, cells in (
        ("trinary", "free", 1),
        ("trinary", "occupied", 2),
        ("scale", "free", 1),
    ):
        file = ros_map(half_way, ("negate", f"mode: {mode}\nnegate"))
        assert covered(maps.load_ros_map(file, 0, unknown)).area == cells / 4
    file = ros_map([[100, 0], [255, 30]], ("negate", "mode: raw\nnegate"))
    assert covered(maps.load_ros_map(file, 0, "free")).area == 0.25
    assert covered(maps.load_ros_map(file, 0)).area == 0.75
    file = ros_map(replace=("negate: 0", "negate: 1"))
    assert covered(maps.load_ros_map(file, 0, "free")).area == 0.75
    file = ros_map(replace=("negate", "mode: scale\nnegate"), name="map.png")
    transparent = np.array([[[0, 255], [0, 0]], [[255, 255], [255, 255]]], np.uint8)
    Image.fromarray(transparent, "LA").save(tmp_path / "map.png")
    assert covered(maps.load_ros_map(file, 0, "free")).area == 0.25


def test_a_turned_ros_map(ros_map):
    world = maps.load_ros_map(ros_map(replace=("2.0, 0.0]", "2.0, 1.5707963267948966]")), 0, "free")
    assert covered(world).symmetric_difference(shapely.box(0, 2, 0.5, 2.5)).area < 1e-12


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("image: map.pgm\n", "", "no key 'image'"),
        ("image: map.pgm", "image: 5", "'image'"),
        ("image: map.pgm", "image: other.pgm", "other.pgm cannot be read"),
        ("resolution: 0.5\n", "", "no key 'resolution'"),
        ("0.5", "-1", "'resolution'"),
        ("0.5", "half", "'resolution'"),
        ("[1.0, 2.0, 0.0]", "[1.0, 2.0]", "'origin'"),
        ("[1.0, 2.0, 0.0]", "[1.0, .nan, 0.0]", "'origin'"),
        ("[1.0, 2.0, 0.0]", "[1.0, 1.0e+9, 0.0]", "map.yaml"),
        ("negate: 0", "negate: 2", "'negate'"),
        ("0.65", "65", "'occupied_thresh'"),
        ("0.196", "0.7", "'free_thresh'"),
        ("negate: 0", "negate: 0\nmode: ternary", "'mode'"),
        ("image: map.pgm", "image: [", "no YAML"),
        (SETTINGS, "just text", "no keys"),
        (SETTINGS, "", "no keys"),
    ],
)
def test_broken_settings(ros_map, old, new, match):
    with pytest.raises(fs.InvalidData, match="file") as caught:
        maps.load_ros_map(ros_map(replace=(old, new)))
    assert match in str(caught.value)


@pytest.mark.parametrize(
    "content",
    [b"", b"P5\n2 2\n255\n\0", b"P2\n2 2\n255\n0 0 0", b"P5\n0 2\n255\n", b"P5\n2", b"P9\n2 2 255"],
)
def test_broken_images(ros_map, tmp_path, content):
    file = ros_map()
    (tmp_path / "map.pgm").write_bytes(content)
    with pytest.raises(fs.InvalidData, match=r"map\.pgm cannot be read as an image"):
        maps.load_ros_map(file)


@pytest.mark.parametrize("resolution", [0.05, 0.1, 0.37])
def test_what_is_saved_covers_all_obstacles(tmp_path, resolution):
    for seed, world in enumerate([WORLD, fs.random_world(30, 0), fs.random_world(30, 1)]):
        file = tmp_path / f"{seed}.yaml"
        maps.save_ros_map(world, file, resolution)
        found = covered(maps.load_ros_map(file, tolerance=0))
        geometries, _ = maps.to_shapely(world)
        shapes = [
            shapely.force_2d(one).buffer(one.z, quad_segs=64) if one.has_z else one
            for one in geometries
        ]
        whole = shapely.union_all(shapes)
        assert found.buffer(1e-8).covers(whole)
        # No cell is marked that nothing reaches into.
        if world.frame is not None:
            whole = whole.union(world.cores[world.frame])
        assert whole.buffer(1.42 * resolution).covers(found)


def test_cells_there_and_back_are_the_same(tmp_path):
    occupied = np.random.default_rng(0).random((30, 40)) < 0.4
    world = maps.from_grid(occupied, 0.1, (0.3, -0.7), tolerance=0)
    maps.save_ros_map(world, tmp_path / "map.yaml", 0.1)
    again = maps.load_ros_map(tmp_path / "map.yaml", tolerance=0)
    np.testing.assert_allclose(again.boundary, world.boundary, atol=1e-12)
    assert covered(again).symmetric_difference(covered(world)).area < 1e-9
    image = Image.open(tmp_path / "map.pgm")
    np.testing.assert_array_equal(np.asarray(image)[::-1] == 0, occupied)


def test_a_world_without_boundary_or_obstacles_is_saved(tmp_path):
    maps.save_ros_map(fs.World([fs.Disc((0, 0), 1)]), tmp_path / "map.yaml", 0.5)
    assert maps.load_ros_map(tmp_path / "map.yaml").boundary.min() == -1.5
    maps.save_ros_map(fs.World([]), tmp_path / "map.yaml", 0.5)
    assert len(maps.load_ros_map(tmp_path / "map.yaml")) == 1


def test_saving_refuses(tmp_path):
    with pytest.raises(fs.InvalidParameter, match="resolution"):
        maps.save_ros_map(WORLD, tmp_path / "map.yaml", 1e-6)
    for save in (
        lambda file: maps.save_ros_map(WORLD, file, 1),
        lambda file: maps.save_geojson(WORLD, file),
    ):
        with pytest.raises(fs.InvalidData, match="cannot be written"):
            save(tmp_path / "no folder" / "map")


# ---- MovingAI ---------------------------------------------------------------------------------


def test_a_movingai_map_by_hand(tmp_path):
    file = tmp_path / "small.map"
    file.write_text(OCTILE)
    world = maps.load_movingai(file, 2.0, tolerance=0)
    wanted = [shapely.box(0, 0, 2, 4), shapely.box(4, 0, 6, 2)]
    assert covered(world).equals(shapely.union_all(wanted))
    assert world.boundary.max(0).tolist() == [6, 4]


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("type octile", "type hex", 1),
        ("height 2", "height two", 2),
        ("height 2", "height 0", 2),
        ("width 3", "wide 3", 3),
        ("map", "mat", 4),
        ("@.G", "@.x", 5),
        ("@.G", "@.", 5),
        ("TSW\n", "", 6),
        ("TSW\n", "TSW\n...\n", 8),
        (OCTILE, "", 1),
    ],
)
def test_broken_movingai_maps(tmp_path, old, new, line):
    file = tmp_path / "small.map"
    file.write_text(OCTILE.replace(old, new))
    with pytest.raises(fs.InvalidData, match=rf"small\.map, line {line} is"):
        maps.load_movingai(file)


@pytest.mark.parametrize("load", [maps.load_geojson, maps.load_ros_map, maps.load_movingai])
def test_files_that_are_not_there_or_no_text(tmp_path, load):
    with pytest.raises(fs.InvalidData, match="missing"):
        load(tmp_path / "missing")
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(fs.InvalidData, match="binary"):
        load(tmp_path / "binary")
    with pytest.raises(fs.InvalidParameter, match="file is None"):
        load(None)


# ---- The floor plan in data/ -------------------------------------------------------------------


def test_the_floor_plan_is_the_same_in_both_formats(tmp_path):
    plan = maps.load_geojson(DATA / "floor_plan.geojson")
    maps.save_geojson(plan, tmp_path / "floor_plan.geojson")
    assert_same(maps.load_geojson(tmp_path / "floor_plan.geojson"), plan)
    maps.save_ros_map(plan, tmp_path / "floor_plan.yaml", 0.05)
    for name in ("floor_plan.yaml", "floor_plan.pgm"):
        assert (tmp_path / name).read_bytes() == (DATA / name).read_bytes()


# ---- All together -----------------------------------------------------------------------------


def test_a_plan_in_a_map_of_cells_keeps_clear_of_them():
    occupied = np.zeros((60, 80), bool)
    occupied[10:50, 20] = occupied[30, 20:60] = occupied[5:25, 45:50] = True
    world = maps.from_grid(occupied, 0.05)
    robot = fs.KheperaIV()
    plan = fs.shortest_path(world, (0.5, 1.2), (3.5, 1.0), robot)
    exact = maps.from_grid(occupied, 0.05, tolerance=0)
    assert plan.path.clearance(exact) >= robot.radius
    best = fs.shortest_path(exact, (0.5, 1.2), (3.5, 1.0), robot)
    assert best.path.length <= plan.path.length + 1e-9
