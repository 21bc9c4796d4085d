"""Worlds from and to other people's maps: Shapely, WKT, GeoJSON and occupancy grids.

Everything that comes in is in metres, but for GeoJSON in degrees, which is projected.
What is simplified on the way covers all that it was: a wall never opens.
"""

import json
from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import FreesegError, InvalidData, InvalidParameter, InvalidWorld
from freeseg.outlines import trace_cells
from freeseg.world import FARTHEST, Disc, Polygon, World, check_world

#: The WGS84 ellipsoid: equatorial radius (m) and eccentricity squared.
EQUATOR, ECCENTRICITY_2 = 6_378_137.0, 0.00669437999014

#: No place of a map in degrees is farther from its origin than that (m).
FARTHEST_MAPPED = 1e5

#: Without a unit, what is no wider than that is in degrees and not in metres.
SMALLEST_MAP = 0.1

#: Names of systems of coordinates that are longitude and latitude.
DEGREES = "CRS84", "EPSG::4326", "EPSG:4326"

#: A grid of more cells than that would fill the memory.
MOST_CELLS = 10**8

#: Parts of a cell's side that are round-off where a grid is drawn.
SLIVER = 1e-9

#: Characters of MovingAI's maps that the robot can go on, and that it cannot.
FREE, BLOCKED = ".GS", "@OTW"

#: What names a file.
File = str | PathLike[str]


# ---- Shapely and WKT --------------------------------------------------------------------------


def from_shapely(
    geometries: shapely.Geometry | Iterable[shapely.Geometry],
    boundary: shapely.Polygon | None = None,
) -> World:
    """A world of Shapely's geometries.

    Parameters
    ----------
    geometries : shapely geometry, or iterable of them
        `Polygon` with or without holes, `MultiPolygon`, and collections of
        them (m). A `Point` is a disc whose radius (m) is its z:
        ``shapely.Point(x, y, radius)``. Empty ones are left out; heights of
        polygons are ignored.
    boundary : shapely.Polygon, optional
        What the robot stays inside.

    Raises
    ------
    InvalidWorld
        For a geometry of another type, one that is not valid, a point
        without a radius, or what `Disc`, `Polygon` and `World` refuse.

    Examples
    --------
    >>> from_shapely([shapely.box(0, 0, 1, 1), shapely.Point(3, 0, 0.5)])
    World of 2 obstacles
    """
    return World(
        [obstacle for part in _parts("geometries", geometries) for obstacle in _obstacles(part)],
        None if boundary is None else _as_boundary(boundary),
    )


def to_shapely(world: World) -> tuple[list[shapely.Geometry], shapely.Polygon | None]:
    """A world as Shapely's geometries: what `from_shapely` takes.

    Parameters
    ----------
    world : World
        Obstacles.

    Returns
    -------
    geometries : list of shapely geometry
        A polygon, or a point with the radius as its z, for each obstacle.
    boundary : shapely.Polygon or None
        The boundary.

    Examples
    --------
    >>> geometries, boundary = to_shapely(World([Disc((0, 0), 1)]))
    >>> geometries[0].buffer(geometries[0].z).area > 3.1  # as a polygon
    True
    """
    geometries = [
        shapely.Point(*obstacle.center, obstacle.radius)
        if isinstance(obstacle, Disc)
        else obstacle.core
        for obstacle in check_world(world).obstacles[: world.frame]
    ]
    return geometries, None if world.boundary is None else shapely.Polygon(world.boundary)


def from_wkt(text: str, boundary: str | None = None) -> World:
    """A world of a geometry in well-known text.

    Parameters
    ----------
    text : str
        A geometry that `from_shapely` takes, such as ``"POLYGON ((0 0, 1 0, 0 1,
        0 0))"`` or a GEOMETRYCOLLECTION (m); ``"POINT Z (x y r)"`` is a disc.
    boundary : str, optional
        A POLYGON that the robot stays inside.

    Raises
    ------
    InvalidWorld
        For what is no well-known text, and as `from_shapely`.

    Examples
    --------
    >>> from_wkt("GEOMETRYCOLLECTION (POINT Z (0 0 0.1), POLYGON ((1 0, 2 0, 2 1, 1 0)))")
    World of 2 obstacles
    """
    outer = None if boundary is None else _read_wkt("boundary", boundary)
    return from_shapely(_read_wkt("text", text), outer)


def to_wkt(world: World) -> tuple[str, str | None]:
    """A world in well-known text, to the last digit: what `from_wkt` takes.

    Parameters
    ----------
    world : World
        Obstacles.

    Returns
    -------
    text : str
        A GEOMETRYCOLLECTION of the obstacles.
    boundary : str or None
        The boundary.
    """
    geometries, boundary = to_shapely(world)
    # Shapely's own text of points with a z among polygons without is one that it cannot read.
    parts = ", ".join(shapely.to_wkt(shape, rounding_precision=-1) for shape in geometries)
    text = f"GEOMETRYCOLLECTION ({parts})" if parts else "GEOMETRYCOLLECTION EMPTY"
    return text, None if boundary is None else shapely.to_wkt(boundary, rounding_precision=-1)


def _read_wkt(name: str, text: object) -> shapely.Geometry:
    try:
        return shapely.from_wkt(checks.instance(name, text, str, "well-known text", InvalidWorld))
    except shapely.GEOSException as error:
        raise InvalidWorld(
            f"{name} is {checks.shown(text)}, which is no well-known text ({error}); give such as "
            "'POLYGON ((0 0, 1 0, 0 1, 0 0))'"
        ) from None


def _parts(name: str, geometries: Any) -> list[shapely.Geometry]:
    """Single geometries out of collections."""
    one = isinstance(geometries, shapely.Geometry)
    remedy = "a shapely geometry, or a list of them"
    given = checks.instances(
        name, [geometries] if one else geometries, shapely.Geometry, remedy, InvalidWorld
    )
    parts = shapely.get_parts(list(given))
    while (shapely.get_num_geometries(parts) > 1).any() or _are_collections(parts).any():
        parts = shapely.get_parts(parts)
    return [part for part in parts if not part.is_empty]


def _are_collections(parts: np.ndarray) -> np.ndarray:
    return shapely.get_type_id(parts) >= shapely.GeometryType.MULTIPOINT


def _obstacles(geometry: shapely.Geometry) -> list[Disc | Polygon]:
    """The obstacle that a single geometry is, in a list."""
    if isinstance(geometry, shapely.Point):
        if not geometry.has_z:
            raise InvalidWorld(
                f"geometries has {geometry}, a point without a radius; give "
                "shapely.Point(x, y, radius), or a polygon: shapely.buffer(point, radius)"
            )
        return [Disc(np.array([geometry.x, geometry.y]), geometry.z)]
    return [_as_polygon("geometries", geometry)]


def _as_polygon(name: str, geometry: shapely.Geometry) -> Polygon:
    """A polygon of shapely's as one of ours, or `InvalidWorld`."""
    if not isinstance(geometry, shapely.Polygon) or geometry.is_empty:
        raise InvalidWorld(
            f"{name} has {checks.shown(geometry)}; give polygons: shapely.buffer(geometry, width) "
            "makes one of a line"
        )
    if not geometry.is_valid:
        raise InvalidWorld(
            f"{name} has {checks.shown(geometry)}, which is not valid "
            f"({shapely.is_valid_reason(geometry)}); give shapely.make_valid(geometry)"
        )
    outer, *inner = (
        shapely.get_coordinates(ring) for ring in (geometry.exterior, *geometry.interiors)
    )
    return Polygon(outer, tuple(inner))


def _as_boundary(boundary: object) -> np.ndarray:
    """Corners of a world's boundary (m), or `InvalidWorld`."""
    polygon = _as_polygon(
        "boundary",
        checks.instance("boundary", boundary, shapely.Geometry, "a shapely.Polygon", InvalidWorld),
    )
    if polygon.holes:
        raise InvalidWorld("boundary has holes; give its outer outline, and them as obstacles")
    return polygon.vertices


# ---- GeoJSON ----------------------------------------------------------------------------------


def load_geojson(
    file: File, unit: str | None = None, origin: Sequence[float] | None = None
) -> World:
    """A world of a GeoJSON file.

    Parameters
    ----------
    file : path-like
        A FeatureCollection, a Feature or a geometry: polygons, multipolygons,
        collections of them, and features that are points with a property
        ``"radius"`` (m), which are discs. A polygon with the property
        ``"role": "boundary"`` is the world's boundary. Further properties
        are ignored.
    unit : {"m", "deg"}, optional
        What the coordinates are: x and y in metres, as CAD programs and
        `save_geojson` write them, or longitude and latitude in degrees, as
        RFC 7946 wants them. No file says for sure which it is: not given, it
        is metres, unless the file looks like degrees.
    origin : (float, float), optional
        With degrees: longitude and latitude of the world's point (0, 0);
        by default the middle of the map.

    Returns
    -------
    World
        Obstacles, in the file's order.

    Raises
    ------
    InvalidData
        For a file that is missing, no GeoJSON, or of another kind of
        geometry; a point without a radius; two boundaries; or a place that is
        not on the globe or over 100 km from the origin. Without a unit, also
        for a file whose ``"crs"`` has degrees, or that would be less than
        100 mm across: a building is, in degrees.
    InvalidParameter
        For another unit, or an origin that is not on the globe.

    Notes
    -----
    Degrees become metres to the east and to the north in the plane that
    touches the WGS84 ellipsoid at the origin. There a distance is too short by
    about half the square of how far off it is over the Earth's radius: by less
    than 2e-6 of it within 10 km of the origin, 2e-4 within 100 km. (To scale
    longitudes by the cosine of one latitude would be wrong by 2e-3 at 10 km.)
    """
    if unit is not None:
        checks.choice("unit", unit, ("m", "deg"))
    path, text = _read_text(file)
    try:
        found = json.loads(text)
        shapes = list(_features(found))
        if unit is None:
            _check_metres(found, shapes)
        if unit == "deg":
            shapes = _project(shapes, origin)
        obstacles, boundaries = [], []
        for shape, properties in shapes:
            if properties.get("role") == "boundary":
                boundaries.append(_as_boundary(shape))
            else:
                obstacles += [_with_radius(part, properties) for part in _parts("file", shape)]
        if len(boundaries) > 1:
            raise InvalidData(f"there are {len(boundaries)} boundaries; leave one")
        return World(obstacles, boundaries[0] if boundaries else None)
    except InvalidParameter:
        raise
    except (FreesegError, ValueError, RecursionError) as error:
        raise InvalidData(f"file {path.name} is no GeoJSON map: {error}") from error


def save_geojson(
    world: World, file: File, unit: str = "m", origin: Sequence[float] | None = None
) -> None:
    """Write a world to a GeoJSON file, as `load_geojson` reads it.

    Parameters
    ----------
    world : World
        Obstacles.
    file : path-like
        Where to; what was there is lost.
    unit : {"m", "deg"}, optional
        Metres, exactly, or degrees of longitude and latitude.
    origin : (float, float), optional
        With degrees: longitude and latitude of the world's point (0, 0).

    Raises
    ------
    InvalidData
        Where the file cannot be written.
    InvalidParameter
        For another unit; with degrees, for no origin or one that is not on the
        globe, and for a world that goes over 100 km from it.
    """
    checks.choice("unit", unit, ("m", "deg"))
    geometries, boundary = to_shapely(world)
    shapes: list[tuple[shapely.Geometry, dict[str, Any]]] = [
        (shapely.force_2d(shape), {"radius": shape.z} if shape.has_z else {})
        for shape in geometries
    ]
    if boundary is not None:
        shapes.append((boundary, {"role": "boundary"}))
    if unit == "deg":
        plane = _TangentPlane.at(origin)
        shapes = [
            (shapely.transform(shape, plane.to_degrees), properties) for shape, properties in shapes
        ]
    features = [
        {"type": "Feature", "properties": properties, "geometry": shapely.geometry.mapping(shape)}
        for shape, properties in shapes
    ]
    lines = ",\n".join(json.dumps(feature) for feature in features)
    _write(file, f'{{"type": "FeatureCollection", "features": [\n{lines}\n]}}\n'.encode())


def _check_metres(found: dict[str, Any], shapes: list[tuple[shapely.Geometry, Any]]) -> None:
    """`InvalidData` for a GeoJSON object in degrees, as far as one can tell."""
    remedy = "give unit='deg', or unit='m' if they are metres"
    system = json.dumps(found.get("crs"))
    if any(name in system for name in DEGREES):
        raise InvalidData(f"its crs is {checks.shown(found['crs'])}, which has degrees; {remedy}")
    places = shapely.get_coordinates([shape for shape, _ in shapes])
    across = float(np.ptp(places, axis=0).max()) if len(places) else 0.0
    # What is a point is a disc, of any radius.
    if 0 < across < SMALLEST_MAP:
        raise InvalidData(
            f"its coordinates are within {across:.3g} of each other, which is too small for a map "
            f"in metres, and RFC 7946 has degrees; {remedy}"
        )


def _features(found: Any) -> Iterable[tuple[shapely.Geometry, dict[str, Any]]]:
    """Geometries of a GeoJSON object, with their properties."""
    if not isinstance(found, dict):
        raise InvalidData(f"it has {checks.shown(found)} for an object with a type")
    kind = found.get("type")
    if kind == "FeatureCollection":
        members = found.get("features")
        if not isinstance(members, list):
            raise InvalidData(f"key 'features' is {checks.shown(members)}; give a list of them")
        for feature in members:
            yield from _features(feature)
        return
    is_feature = kind == "Feature"
    geometry = found.get("geometry") if is_feature else found
    if is_feature and geometry is None:
        return  # a feature without a place, as the standard allows
    properties = (found.get("properties") or {}) if is_feature else {}
    try:
        shape = shapely.force_2d(shapely.geometry.shape(geometry))
        finite = np.isfinite(shapely.get_coordinates(shape)).all()
    except (AttributeError, LookupError, TypeError, ValueError, shapely.GEOSException) as error:
        raise InvalidData(
            f"{checks.shown(geometry)} is no geometry ({type(error).__name__}: {error}); give type "
            "and coordinates"
        ) from error
    if not finite or not isinstance(properties, dict):
        raise InvalidData(
            f"{checks.shown(found)} has a coordinate that is not finite, or properties that are no "
            "object; correct it"
        )
    yield shape, properties


def _with_radius(shape: shapely.Geometry, properties: dict[str, Any]) -> Disc | Polygon:
    """The obstacle that a feature is."""
    if not isinstance(shape, shapely.Point):
        return _as_polygon("it", shape)
    if "radius" not in properties:
        raise InvalidData(f"{shape} has no property 'radius'; give it one (m)")
    return Disc(np.array([shape.x, shape.y]), properties["radius"])


class _TangentPlane(NamedTuple):
    """The plane that touches the Earth at a place, with x to the east and y to the north."""

    longitude: float
    latitude: float

    @classmethod
    def at(cls, origin: Any) -> "_TangentPlane":
        """The plane at a longitude and latitude (deg), or `InvalidParameter`."""
        longitude, latitude = checks.numbers("origin", origin, 2)
        if abs(longitude) > 180 or abs(latitude) > 90:
            raise InvalidParameter(
                f"origin is {checks.shown(origin)}; give longitude and latitude in degrees"
            )
        return cls(longitude, latitude)

    def to_metres(self, degrees: np.ndarray) -> np.ndarray:
        """Longitudes and latitudes (n, 2) as metres, or `InvalidData`."""
        metres, distance = self._project(degrees)
        if (np.abs(degrees) > (180, 90)).any() or (distance > FARTHEST_MAPPED).any():
            raise InvalidData(
                f"it reaches over {FARTHEST_MAPPED / 1000:.0f} km from {tuple(self)}, or is not in "
                "degrees; cut it, or give another origin, or unit='m'"
            )
        return metres

    def _project(self, degrees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Longitudes and latitudes (n, 2) as metres, and how far they are from the origin (m)."""
        along, up = np.radians(degrees[:, 0] - self.longitude), np.radians(self.latitude)
        latitude = np.radians(degrees[:, 1])
        bend = EQUATOR / np.sqrt(1 - ECCENTRICITY_2 * np.sin([latitude, 0 * latitude + up]) ** 2)
        # From the Earth's middle: in the equator's plane below the origin, and to the pole.
        out = bend[0] * np.cos(latitude) * np.cos(along) - bend[1] * np.cos(up)
        pole = (1 - ECCENTRICITY_2) * (bend[0] * np.sin(latitude) - bend[1] * np.sin(up))
        east = bend[0] * np.cos(latitude) * np.sin(along)
        north = np.cos(up) * pole - np.sin(up) * out
        distance = np.hypot(np.hypot(east, north), np.sin(up) * pole + np.cos(up) * out)
        return np.stack([east, north], axis=1), distance

    def to_degrees(self, metres: np.ndarray) -> np.ndarray:
        """Metres (n, 2) as longitudes and latitudes, or `InvalidParameter`."""
        if not (np.hypot(*metres.T) <= FARTHEST_MAPPED).all() or abs(self.latitude) > 85:
            raise InvalidParameter(
                f"origin is {tuple(self)}: the world reaches over {FARTHEST_MAPPED / 1000:.0f} km "
                "from it, or is near a pole; give one in the world, or unit='m'"
            )
        found = np.broadcast_to([self.longitude, self.latitude], metres.shape)
        scale = np.degrees(1 / EQUATOR) * np.array([1 / np.cos(np.radians(self.latitude)), 1])
        # Each time, what is off falls to a fifth of what it was, or much less.
        for _ in range(40):
            found = found + scale * (metres - self._project(found)[0])
        found[:, 0] -= 360 * np.sign(found[:, 0]) * (np.abs(found[:, 0]) > 180)
        return found


def _project(shapes: list, origin: Any) -> list:
    """Geometries in degrees as ones in metres."""
    if not shapes:
        return shapes
    if origin is None:
        left, bottom, right, top = shapely.total_bounds([shape for shape, _ in shapes])
        origin = np.clip(np.nan_to_num([(left + right) / 2, (bottom + top) / 2]), -180, 180)
        origin[1] = np.clip(origin[1], -90, 90)
    plane = _TangentPlane.at(origin)
    return [(shapely.transform(shape, plane.to_metres), properties) for shape, properties in shapes]


# ---- Occupancy grids --------------------------------------------------------------------------


def from_grid(
    occupied: ArrayLike,
    resolution: float,
    origin: Sequence[float] = (0.0, 0.0),
    tolerance: float | None = None,
    boundary: bool = True,
) -> World:
    """A world of an occupancy grid.

    Parameters
    ----------
    occupied : array_like of bool, shape (h, w)
        Which cells are occupied. As in ROS's OccupancyGrid, row 0 is at the
        origin and rows go up, along y; columns go along x.
    resolution : float
        Side of a cell (m).
    origin : (float, float) or (float, float, float), optional
        Where the grid's corner at row 0 and column 0 is: x, y (m), and the
        angle (rad) that the grid is turned by about it.
    tolerance : float, optional
        How far an obstacle may reach beyond the cells that it stands for (m);
        by default one cell, which makes slanting walls of stairs straight. With
        0 it is exactly the cells.
    boundary : bool, optional
        Whether the robot stays inside the grid.

    Returns
    -------
    World
        A polygon for each set of cells that join at their sides, with holes.

    Raises
    ------
    InvalidParameter
        For what is no such array or number.

    Notes
    -----
    Simplified obstacles cover their cells, for only what turns inwards is cut
    short. So a wall never opens; but a gap narrower than twice the
    tolerance may close, and what is free in the grid's world with tolerance 0
    may not be in another.

    Examples
    --------
    >>> world = from_grid([[1, 1, 1], [1, 0, 1], [1, 1, 1]], resolution=0.5, tolerance=0)
    >>> world[0].core.area
    2.0
    """
    cells = _check_cells(occupied)
    resolution = checks.positive("resolution", resolution)
    try:
        size = len(origin)
    except TypeError:
        size = 2
    x, y, *yaw = checks.numbers("origin", origin, 3 if size == 3 else 2)
    slack = resolution if tolerance is None else checks.not_negative("tolerance", tolerance)
    checks.flag("boundary", boundary)
    turn = complex(np.cos(yaw[0]), np.sin(yaw[0])) if yaw else 1 + 0j

    def place(corners: np.ndarray) -> np.ndarray:
        turned = turn * resolution * (corners[:, 0] + 1j * corners[:, 1])
        return np.stack([x + turned.real, y + turned.imag], axis=1)

    height, width = cells.shape
    if resolution * max(height, width) > FARTHEST:
        raise InvalidParameter(
            f"resolution is {resolution:g}: the grid would be over {FARTHEST:g} m wide; give metres"
        )
    polygons = trace_cells(cells, slack / resolution)
    edge = place(np.array([(0, 0), (width, 0), (width, height), (0, height)], float))
    moved = shapely.transform(np.array(polygons, dtype=object), place)
    # Where a corner lies on another edge, round-off may have moved it across.
    broken = ~shapely.is_valid(moved)
    moved[broken] = shapely.make_valid(moved[broken], method="structure", keep_collapsed=False)
    parts = shapely.get_parts(moved)
    parts = parts[np.sqrt(shapely.area(parts)) > SLIVER * resolution]
    obstacles = [_as_polygon("occupied", part) for part in parts]
    return World(obstacles, edge if boundary else None)


def load_ros_map(
    yaml_file: File,
    tolerance: float | None = None,
    unknown: str = "occupied",
    boundary: bool = True,
) -> World:
    """A world of an occupancy grid as ROS's map_server and map_saver write it.

    Parameters
    ----------
    yaml_file : path-like
        The ``.yaml`` with `image`, `resolution` (m), `origin` [x, y, yaw]
        (m, m, rad), `negate`, `occupied_thresh`, `free_thresh` and optionally
        `mode`: trinary, scale or raw. The image, beside it, is a ``.pgm`` or
        ``.png``; its last row is the lowest.
    tolerance, boundary
        As for `from_grid`.
    unknown : {"occupied", "free"}, optional
        What cells are that are neither occupied nor free; in mode scale also
        those that are something in between.

    Raises
    ------
    InvalidData
        For a file that is missing or broken, with the key that is wrong.
    InvalidParameter
        As `from_grid`.
    """
    checks.choice("unknown", unknown, ("occupied", "free"))
    path, text = _read_text(yaml_file)
    settings = _read_settings(path, text)
    values, opaque = _read_image(path.parent / settings["image"])
    if settings["mode"] == "raw":
        # A percentage, and what is above 100 is unknown.
        share, known = np.rint(255 * values) / 100, np.rint(255 * values) <= 100
    else:
        share = values if settings["negate"] else 1 - values
        known = opaque | (settings["mode"] != "scale")
    occupied = known & (share > settings["occupied_thresh"])
    free = known & (share < settings["free_thresh"])
    cells = ~free if unknown == "occupied" else occupied
    try:
        resolution, origin = settings["resolution"], settings["origin"]
        return from_grid(cells[::-1], resolution, origin, tolerance, boundary)
    except InvalidWorld as error:
        raise InvalidData(f"file {path.name}: {error}") from error


def load_movingai(
    file: File, resolution: float = 1.0, tolerance: float | None = None, boundary: bool = True
) -> World:
    """A world of a grid map of the MovingAI benchmarks.

    Parameters
    ----------
    file : path-like
        The ``.map``: lines ``type octile``, ``height h``, ``width w`` and
        ``map``, then h rows of w characters. ``.``, ``G`` and ``S`` are free;
        ``@``, ``O``, ``T`` and ``W`` are not.
    resolution : float, optional
        Side of a cell (m).
    tolerance, boundary
        As for `from_grid`.

    Returns
    -------
    World
        As drawn: the last row is the lowest, and its left end is at (0, 0).
        The character in column c of row r is the cell round
        ``((c + 0.5) * resolution, (h - r - 0.5) * resolution)``.

    Raises
    ------
    InvalidData
        For a file that is missing or broken, with the line that is wrong.
    InvalidParameter
        As `from_grid`.

    Notes
    -----
    N. Sturtevant, "Benchmarks for grid-based pathfinding", *IEEE Trans. Comput.
    Intell. AI Games* 4, 2012.
    """
    path, text = _read_text(file)
    lines = text.rstrip().splitlines()

    def refuse(line: int, remedy: str) -> InvalidData:
        found = checks.shown(lines[line - 1]) if line <= len(lines) else "missing"
        return InvalidData(f"file {path.name}, line {line} is {found}; give {remedy}")

    sizes = []
    for line, name in enumerate(("type", "height", "width", "map"), 1):
        words = lines[line - 1].split() if line <= len(lines) else []
        number = words[1] if len(words) == 2 and words[0] == name else ""
        if name in ("height", "width"):
            if not (number.isdecimal() and 0 < len(number) < 6 and int(number) > 0):
                raise refuse(line, f"{name} and a whole number of cells")
            sizes.append(int(number))
        elif words != (["map"] if name == "map" else ["type", "octile"]):
            raise refuse(line, "map" if name == "map" else "type octile")
    height, width = sizes
    for line, row in enumerate(lines[4:], 5):
        if len(row) != width or set(row) - set(FREE + BLOCKED):
            raise refuse(line, f"a row of {width} of the characters {FREE + BLOCKED}")
    if len(lines) != 4 + height:
        raise refuse(len(lines) + 1, f"{height} rows; there are {len(lines) - 4}")
    cells = np.array([list(row) for row in lines[4:]])
    return from_grid(np.isin(cells, list(BLOCKED))[::-1], resolution, (0, 0), tolerance, boundary)


def save_ros_map(world: World, yaml_file: File, resolution: float) -> None:
    """Write a world as an occupancy grid for ROS's map_server.

    A cell is occupied where an obstacle reaches into it, or the outside of the
    boundary: the occupied cells cover all obstacles.

    Parameters
    ----------
    world : World
        Obstacles. Without a boundary, the grid ends at least a cell
        beyond them.
    yaml_file : path-like
        The ``.yaml`` to write; the image is the ``.pgm`` of that name beside
        it. What was there is lost.
    resolution : float
        Side of a cell (m).

    Raises
    ------
    InvalidData
        Where a file cannot be written.
    InvalidParameter
        For a resolution that is no positive number, or so fine that there
        would be over 1e8 cells.
    """
    import yaml  # type: ignore[import-untyped]

    check_world(world)
    resolution = checks.positive("resolution", resolution)
    path = checks.file("yaml_file", yaml_file, InvalidParameter)
    low, shape = _extent(world, resolution)
    occupied = np.zeros(shape, bool)
    for obstacle in world:
        _mark(occupied, obstacle, low, resolution)
    image = path.with_suffix(".pgm")
    settings = {
        "image": image.name,
        "mode": "trinary",
        "resolution": resolution,
        "origin": [*low.tolist(), 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.25,
    }
    _write(path, yaml.safe_dump(settings, sort_keys=False, default_flow_style=None).encode())
    header = f"P5\n{shape[1]} {shape[0]}\n255\n".encode()
    _write(image, header + np.where(occupied[::-1], 0, 254).astype(np.uint8).tobytes())


def _check_cells(occupied: Any) -> np.ndarray:
    """Cells as an array of bool, or `InvalidParameter`."""
    try:
        cells = np.asarray(occupied)
    except ValueError:
        cells = np.array(None)
    one_or_none = cells.dtype.kind in "iu" and np.isin(cells, (0, 1)).all()
    if cells.ndim != 2 or not cells.size or not (cells.dtype == bool or one_or_none):
        raise InvalidParameter(
            f"occupied is {checks.shown(occupied)}; give an array of shape (h, w) of True and False"
        )
    return cells.astype(bool)


def _extent(world: World, resolution: float) -> tuple[np.ndarray, tuple[int, int]]:
    """Corner (m) and shape of the grid that a world needs, on multiples of the resolution."""
    if world.boundary is not None:
        corners, ring = world.boundary, 0
    elif len(world):
        grown = world.radii[np.repeat(np.arange(len(world)), world.edge_counts), None]
        corners, ring = np.concatenate([world.edges[:, 0] - grown, world.edges[:, 0] + grown]), 1
    else:
        corners, ring = np.zeros((1, 2)), 1
    with np.errstate(over="ignore"):
        first = np.floor(corners.min(0) / resolution + SLIVER) - ring
        last = np.ceil(corners.max(0) / resolution - SLIVER) + ring
        counts = last - first
        if not counts.prod() <= MOST_CELLS:
            raise InvalidParameter(
                f"resolution is {resolution:g}: that makes over {MOST_CELLS:g} cells; give a "
                "coarser one"
            )
    return first * resolution, (int(counts[1]), int(counts[0]))


def _mark(
    occupied: np.ndarray, obstacle: Disc | Polygon, low: np.ndarray, resolution: float
) -> None:
    """Mark the cells that an obstacle reaches into."""
    reach = np.concatenate(
        [obstacle.vertices - obstacle.radius, obstacle.vertices + obstacle.radius]
    )
    limits = occupied.shape[::-1]
    left, bottom = np.clip((reach.min(0) - low) / resolution - 1, 0, limits).astype(int)
    right, top = np.clip((reach.max(0) - low) / resolution + 2, 0, limits).astype(int)
    x = low[0] + resolution * np.arange(left, right + 1)
    y = low[1] + resolution * np.arange(bottom, top + 1)
    # What reaches less far into a cell than this is round-off.
    sliver = SLIVER * resolution + 4 * np.spacing(np.abs(reach).max())
    if isinstance(obstacle, Disc):
        away_x, away_y = (
            np.maximum(np.maximum(side[:-1] - middle, middle - side[1:]), 0)
            for side, middle in zip((x, y), obstacle.center, strict=True)
        )
        meets = np.hypot(away_x, away_y[:, None]) < obstacle.radius - sliver
    else:
        core = obstacle.core
        shapely.prepare(core)
        meets = np.empty((top - bottom, right - left), bool)
        for row in range(len(meets)):
            boxes = shapely.box(
                x[:-1] + sliver, y[row] + sliver, x[1:] - sliver, y[row + 1] - sliver
            )
            meets[row] = shapely.intersects(core, boxes)
    occupied[bottom:top, left:right] |= meets


def _read_settings(path: Path, text: str) -> dict[str, Any]:
    """What a map's YAML file says, checked."""
    import yaml  # type: ignore[import-untyped]

    try:
        found = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        problem = " ".join(str(error).split())
        raise InvalidData(f"file {path.name} is no YAML ({problem}); correct it") from error
    needed = "image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"
    if not isinstance(found, dict):
        raise InvalidData(f"file {path.name} has no keys; give {', '.join(needed)}")
    for key in needed:
        if key not in found:
            raise InvalidData(f"file {path.name} has no key {key!r}; add it")

    def name(key: str) -> str:
        return f"file {path.name}, key {key!r}"

    image = checks.instance(name("image"), found["image"], str, "the image's name", InvalidData)
    mode = found.get("mode", "trinary")
    if mode not in ("trinary", "scale", "raw"):
        raise InvalidData(f"{name('mode')} is {checks.shown(mode)}; give trinary, scale or raw")
    negate = found["negate"]
    if negate not in (0, 1):  # also False and True
        raise InvalidData(f"{name('negate')} is {checks.shown(negate)}; give 0 or 1")
    thresholds = {}
    for key in ("occupied_thresh", "free_thresh"):
        thresholds[key] = checks.number(
            name(key), found[key], lambda share: 0 <= share <= 1, "0 to 1", InvalidData
        )
    if thresholds["free_thresh"] > thresholds["occupied_thresh"]:
        raise InvalidData(f"{name('free_thresh')} is over occupied_thresh; give less")
    return thresholds | {
        "image": image,
        "mode": mode,
        "negate": bool(negate),
        "resolution": checks.positive(name("resolution"), found["resolution"], InvalidData),
        "origin": checks.numbers(name("origin"), found["origin"], 3, InvalidData),
    }


def _read_image(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """An image's brightness from 0 to 1, shape (h, w), and which pixels are not transparent."""
    from PIL import Image

    try:
        with Image.open(path) as image:
            if image.mode.startswith("I"):
                values = np.asarray(image, float)[..., None] / 65535
            else:
                # A palette holds colours, and ones and zeros are white and black.
                plain = "L" if image.mode == "1" else "RGBA"
                wanted = image.mode if image.mode in ("L", "LA", "RGB", "RGBA") else plain
                values = np.asarray(image.convert(wanted), float) / 255
                values = values.reshape(image.height, image.width, -1)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InvalidData(
            f"file {path.name} cannot be read as an image ({error}); give a whole .pgm or .png at "
            f"{path}"
        ) from error
    colours = values.shape[2] - 1 + values.shape[2] % 2
    opaque = values[..., -1] > 0 if values.shape[2] > colours else np.ones(values.shape[:2], bool)
    return values[..., :colours].mean(2), opaque


# ---- Files ------------------------------------------------------------------------------------


def _read_text(file: Any) -> tuple[Path, str]:
    """Path and contents of a text file, or the error."""
    path = checks.file("file", file, InvalidParameter)
    try:
        return path, path.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        raise InvalidData(
            f"file {checks.shown(str(path))} cannot be read ({checks.shown(str(error))}); give the "
            "path of a text file"
        ) from error


def _write(file: Any, content: bytes) -> None:
    """Write a file, or raise the error."""
    path = checks.file("file", file, InvalidParameter)
    try:
        path.write_bytes(content)
    except (OSError, ValueError) as error:
        raise InvalidData(
            f"file {checks.shown(str(path))} cannot be written ({checks.shown(str(error))}); give "
            "a path in a folder that is there"
        ) from error
