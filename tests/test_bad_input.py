"""Every public function, fed with every kind of bad value in every parameter.

What comes back is right, or an error of ours that names the value: never an error from
inside a library, never NaN, never a run without end.
"""

import dataclasses
import inspect
from functools import partial
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import shapely

import freeseg as fs
from freeseg.checks import shown
from freeseg.data import DATA
from freeseg.path import Arc, Line
from freeseg.reference import Reference
from freeseg.teaching import quietly, variant_seed

WORLD, PATH_ENDS = fs.load_table(1), ((0, 0), (0.75, 0.75))
PLAN = fs.plan(WORLD, *PATH_ENDS)
SHORT = fs.Path([Line((0, 0), (0.1, 0))])
REFERENCE = fs.make_reference(SHORT)
RUN = fs.simulate(fs.SlidingMode(), REFERENCE)
BATCH = fs.simulate(fs.SlidingMode(), REFERENCE, initial_offset=np.zeros((3, 2)))
CHAIN = fs.free_segments(WORLD)


class Unprintable:
    """An object that means nothing, with a long text."""

    def __repr__(self):
        return "?" * 100_000


BAD = {
    "None": None,
    "text": "5",
    "bytes": b"5",
    "bool": True,
    "numpy bool": np.bool_(True),
    "nan": np.nan,
    "inf": np.inf,
    "minus inf": -np.inf,
    "minus one": -1,
    "zero": 0,
    "complex": 1 + 1j,
    "numpy complex": np.complex128(1 + 1j),
    "huge": 1e300,
    "huge int": 10**400,
    "minus zero": -0.0,
    "empty list": [],
    "empty array": np.empty(0),
    "four numbers": (1, 2, 3, 4),
    "ragged": [[1, 2], [3]],
    "texts": ["1", "2"],
    "nan pair": (np.nan, 0),
    "nan triple": (0, np.nan, 0),
    "complex pair": (1j, 0),
    "three axes": np.ones((2, 3, 4)),
    "dict": {"x": 1},
    "dates": np.array(["2018-01-01", "2018-01-02"], dtype="datetime64[D]"),
    "read only": (lambda array: array.setflags(write=False) or array)(np.zeros(2)),
    "object": Unprintable(),
    "function": len,
    "class": fs.SlidingMode,
    "world": WORLD,
    "plan": PLAN,
    "path": SHORT,
    "reference": REFERENCE,
    "run": RUN,
    "batch": BATCH,
    "robot": fs.KheperaIV(),
    "tracker": fs.SlidingMode(),
    "disc": fs.Disc((0, 0), 1),
    "disturbance": fs.Disturbance(),
}


def law(t, pose):
    """Stand still."""
    return 0.0, 0.0


QUERY = {
    "world": WORLD,
    "start": PATH_ENDS[0],
    "goal": PATH_ENDS[1],
    "robot": None,
    "margin": 0.005,
}
TRACKERS = [getattr(fs, name) for name in fs.trackers.__all__]
#: Function, and arguments with which it works.
CALLS = {
    "plan": (fs.plan, QUERY),
    "plan_rooms": (fs.plan_rooms, QUERY),
    "shortest_path": (fs.shortest_path, QUERY),
    "literal_plan": (partial(fs.literal_plan, concentric=True, outer_endpoints=True), QUERY),
    "with_fallback": (fs.with_fallback(fs.plan_rooms, fs.shortest_path), QUERY),
    "free_segments": (
        fs.free_segments,
        {"world": WORLD, "robot": None, "margin": 0.005, "neighbours": "chain"},
    ),
    "Disc": (fs.Disc, {"center": (0, 0), "radius": 1}),
    "Polygon": (fs.Polygon, {"vertices": [(0, 0), (1, 0), (0, 1)], "holes": ()}),
    "World": (fs.World, {"obstacles": [fs.Disc((0, 0), 1)], "boundary": None}),
    "nearest_free": (
        fs.nearest_free,
        {"world": WORLD, "point": (0.2, 0), "robot": None, "margin": 0.005},
    ),
    "Line": (Line, {"start": (0, 0), "end": (1, 0)}),
    "Arc": (Arc, {"center": (0, 0), "radius": 1, "start_angle": 0, "sweep": 1}),
    "Path": (fs.Path, {"pieces": [Line((0, 0), (1, 0))]}),
    "Path.at": (SHORT.at, {"s": 0.05}),
    "Path.sample": (SHORT.sample, {"step": 0.05}),
    "Path.clearance": (SHORT.clearance, {"world": WORLD}),
    "Path.distances": (SHORT.distances, {"world": WORLD}),
    "load_table": (fs.load_table, {"table": 1}),
    "random_world": (fs.random_world, {"n": 3, "seed": 0, "shapes": ("disc",), "area": 0.1}),
    "random_query": (fs.random_query, {"world": WORLD, "seed": 0, "robot": None, "margin": 0.005}),
    "KheperaIV": (
        fs.KheperaIV,
        {
            "wheel_base": 0.1,
            "diameter": 0.1,
            "wheel_radius": 0.02,
            "max_wheel_rate": 40,
            "max_wheel_rate_change": 100,
        },
    ),
    "Robot": (
        fs.Robot,
        {
            "wheel_base": 0.1,
            "diameter": 0.1,
            "wheel_radius": 0.02,
            "max_wheel_rate": 40,
            "max_wheel_rate_change": 100,
        },
    ),
    "Disturbance": (
        fs.Disturbance,
        {field.name: field.default for field in dataclasses.fields(fs.Disturbance)},
    ),
    "make_reference": (
        fs.make_reference,
        {
            "path": SHORT,
            "robot": None,
            "speed": 0.1,
            "acceleration": 0.2,
            "smoothing": 0.0,
            "world": WORLD,
            "start_speed": 0.0,
            "end_speed": 0.0,
        },
    ),
    "Reference": (
        Reference,
        {
            name: getattr(REFERENCE, name)
            for name in ("t", "pose", "v", "omega", "v_dot", "omega_dot", "shift")
        },
    ),
    "tracking_error": (fs.tracking_error, {"reference_pose": (0, 0, 0), "pose": (0, 0, 0)}),
    "simulate": (
        fs.simulate,
        {
            "tracker": fs.SlidingMode(),
            "reference": REFERENCE,
            "robot": None,
            "dt": 0.05,
            "initial_offset": (0, 0, 0),
            "disturbance": None,
            "seed": 0,
        },
    ),
    "drive": (
        fs.drive,
        {
            "law": law,
            "pose": (0, 0, 0),
            "dt": 0.05,
            "steps": 3,
            "robot": None,
            "disturbance": None,
            "seed": 0,
        },
    ),
    "metrics.planning": (fs.metrics.planning, {"world": WORLD, "plan": PLAN}),
    "metrics.tracking": (
        fs.metrics.tracking,
        {"run": RUN, "world": WORLD, "since": 0.0, "until": np.inf},
    ),
    "plot_world": (fs.plotting.plot_world, {"world": WORLD}),
    "plot_segments": (fs.plotting.plot_segments, {"segments": CHAIN}),
    "plot_path": (fs.plotting.plot_path, {"path": SHORT}),
    "plot_plan": (fs.plotting.plot_plan, {"world": WORLD, "plan": PLAN}),
    "plot_step": (
        fs.plotting.plot_step,
        {"world": WORLD, "plan": PLAN, "step": PLAN.steps[-1]},
    ),
    "plot_tracking": (fs.plotting.plot_tracking, {"world": WORLD, "plan": PLAN, "run": RUN}),
    "plot_errors": (fs.plotting.plot_errors, {"run": RUN}),
    "plot_wheels": (fs.plotting.plot_wheels, {"run": RUN}),
    "animate": (fs.plotting.animate, {"world": WORLD, "plan": PLAN, "run": RUN, "frames": 3}),
    "interval": (fs.studies.statistics.interval, {"values": np.eye(3), "seed": 0}),
    "from_shapely": (
        fs.maps.from_shapely,
        {"geometries": [shapely.Point(0, 0, 1)], "boundary": shapely.box(0, 0, 1, 1)},
    ),
    "to_shapely": (fs.maps.to_shapely, {"world": WORLD}),
    "from_wkt": (fs.maps.from_wkt, {"text": "POINT Z (0 0 1)", "boundary": None}),
    "to_wkt": (fs.maps.to_wkt, {"world": WORLD}),
    "from_grid": (
        fs.maps.from_grid,
        {
            "occupied": [[1, 0]],
            "resolution": 1,
            "origin": (0, 0),
            "tolerance": 0,
            "boundary": True,
        },
    ),
    "load_geojson": (
        fs.maps.load_geojson,
        {"file": DATA / "floor_plan.geojson", "unit": "deg", "origin": (0, 0)},
    ),
    "save_geojson": (
        fs.maps.save_geojson,
        {"world": WORLD, "file": "map.geojson", "unit": "deg", "origin": (0, 0)},
    ),
    "load_ros_map": (
        fs.maps.load_ros_map,
        {
            "yaml_file": DATA / "floor_plan.yaml",
            "tolerance": 0,
            "unknown": "free",
            "boundary": True,
        },
    ),
    "save_ros_map": (
        fs.maps.save_ros_map,
        {"world": WORLD, "yaml_file": "map.yaml", "resolution": 0.1},
    ),
    "load_movingai": (
        fs.maps.load_movingai,
        {"file": "small.map", "resolution": 1, "tolerance": 0, "boundary": True},
    ),
    "variant_seed": (variant_seed, {"course": "freeseg", "student": "ada"}),
} | {
    tracker.__name__: (
        tracker,
        {field.name: field.default for field in dataclasses.fields(tracker)},
    )
    for tracker in TRACKERS
}


def numbers_of(result):
    """All arrays and floats of a result."""
    if isinstance(result, float | np.floating | np.ndarray):
        yield np.asarray(result)
    elif isinstance(result, dict):
        for value in result.values():
            yield from numbers_of(value)
    elif isinstance(result, list | tuple):
        for value in result:
            yield from numbers_of(value)
    elif dataclasses.is_dataclass(result):
        for field in dataclasses.fields(result):
            yield from numbers_of(getattr(result, field.name))


def outcome(call, parameter, value):
    """What a call with one bad value leads to: its result, or our error."""
    function, good = CALLS[call]
    try:
        with quietly(20):
            return function(**good | {parameter: value})
    except fs.FreesegError as error:
        return error
    finally:
        plt.close("all")


@pytest.mark.parametrize(
    ("call", "parameter"),
    [(call, parameter) for call, (_, good) in CALLS.items() for parameter in good],
)
def test_bad_values_give_our_errors_or_right_results(call, parameter, tmp_path, monkeypatch):
    plt.switch_backend("Agg")
    # A folder for what is saved, with a map for what loads one.
    monkeypatch.chdir(tmp_path)
    Path("small.map").write_text("type octile\nheight 1\nwidth 2\nmap\n@.\n")
    for kind, value in BAD.items():
        if (call, parameter) == ("drive", "law") and callable(value):
            continue  # it is called, and its own error comes through
        result = outcome(call, parameter, value)
        text = str(result) if isinstance(result, fs.FreesegError) else ""
        assert len(text) < 1000, (kind, text[:200])
        if isinstance(result, ValueError):
            named = parameter, parameter.rstrip("s"), shown(value)[:20], "has shape", "be finite"
            assert any(one in text for one in named), (kind, text)
        for array in numbers_of(result):
            assert array.dtype.kind not in "fc" or not np.isnan(array).any(), kind


def test_every_public_function_is_fed():
    fed = {function for function, _ in CALLS.values()} | {fs.literal_plan, fs.with_fallback}
    for name in fs.__all__:
        thing = getattr(fs, name)
        is_error = isinstance(thing, type) and issubclass(thing, Exception)
        if callable(thing) and not is_error and name != "load_cases":
            assert thing in fed, name
    for name, thing in inspect.getmembers(fs.maps, inspect.isfunction):
        if thing.__module__ == "freeseg.maps" and not name.startswith("_"):
            assert thing in fed, name
    for name, thing in inspect.getmembers(fs.plotting, inspect.isfunction):
        if name.startswith("plot_") and "ax" not in list(inspect.signature(thing).parameters)[:1]:
            signature = inspect.signature(thing).parameters
            if signature["ax" if "ax" in signature else "axes"].default is None:
                assert thing in fed, name
