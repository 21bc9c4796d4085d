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
from freeseg import data, studies
from freeseg.checks import shown
from freeseg.segments import find_endpoints
from freeseg.studies import (
    comparing,
    courses,
    crossings,
    duels,
    ledger,
    moving,
    orders,
    planning,
    reacting,
    rivals,
    runner,
    sizes,
    splitting,
    statistics,
    stress,
    tracking,
    traps,
    tuning,
)
from freeseg.teaching import quietly, variant_seed

# What is compiled is so before a clock runs.
fs.shortest_path(fs.random_world(60, 0), *fs.random_query(fs.random_world(60, 0), 0))

WORLD, PATH_ENDS = fs.load_table(1), ((0, 0), (0.75, 0.75))
PLAN = fs.plan(WORLD, *PATH_ENDS)
SHORT = fs.Path([fs.Line((0, 0), (0.1, 0))])
REFERENCE = fs.make_reference(SHORT)
RUN = fs.simulate(fs.SlidingMode(), REFERENCE)
BATCH = fs.simulate(fs.SlidingMode(), REFERENCE, initial_offset=np.zeros((3, 2)))
CHAIN = fs.free_segments(WORLD)
STRAIGHT_PLAN = fs.plan(WORLD, (0.2, 0), (0.3, 0))
STRAIGHT = fs.make_reference(STRAIGHT_PLAN)
STRAIGHT_RUN = fs.simulate(fs.SlidingMode(), STRAIGHT)
ELSEWHERE = fs.plan(fs.load_table(2), (0, 0), (0.75, 0.75))
ORDER = statistics.order([statistics.Difference("one", "other", -2, -3, -1)])
DRIVES = [
    row
    for row in moving.load_drives()
    if row["scene"] < 40 and row["method"] in ("MPC", "potential field")
]
BLIND = {"nothing": fs.Following()}
COURSE = courses.Course("short", WORLD, REFERENCE, 0.1)
STATICS = np.zeros((6, 2))
NUMBERS = np.zeros((stress.samples_of(COURSE) + 1, 5, 2))
#: A drive of few steps.
NEAR = {"scene": WORLD, "start": (0, 0), "goal": (0.02, 0.0)}
REACTIVE_RUN = fs.react(fs.PotentialField(), **NEAR)
TASK = reacting.Task(WORLD, np.zeros(2), np.array([0.02, 0.0]), 0.02)
ROBOT = fs.KheperaIV()
ORDERS = orders.compare_orders(["13a"])
RIVALS = {rivals.EXACT: fs.shortest_path}
COMPARED = rivals.compare([("paper", "13a")], RIVALS)
MOVER = fs.Mover(fs.Disc((0, 0), 1), velocity=(1, 0))


def height(points):
    return points[:, 0]


def height_of(numbers):
    return numbers[0]


def integrator(s):
    return 1 / s


AX = plt.figure().add_subplot()
LEVELS = np.array([0.001, 0.002])
TAIL = splitting.Tail(LEVELS, LEVELS[::-1] * 300, LEVELS, LEVELS * 400, LEVELS, 10)
EMPTY = len(AX.get_children())
SPACE = plt.figure().add_subplot(projection="3d")
MOVING = fs.Mover(fs.Disc((0.5, 0.4), 0.05), velocity=(0, -0.01))
TIMED = fs.time_minimal_plan(fs.Scene(fs.World([]), [MOVING]), (0, 0), (1, 0), 0.1)
PLACE = fs.plotting.draw_robot((0, 0, 0), ROBOT, AX)


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
    "mover": MOVER,
    "disturbance": fs.Disturbance(),
    "word": "yes",
    "plan elsewhere": ELSEWHERE,
    "step elsewhere": ELSEWHERE.steps[-1],
    "axes": plt.figure().subplots(2),
    "polar axes": plt.figure().add_subplot(projection="polar"),
    "solid axes": plt.figure().add_subplot(projection="3d"),
    "figure": AX.figure,
    "module": plt,
    "course": COURSE,
    "tuned": tuning.load_gains()["Pid"][0],
}


def row_of(case, seed):
    """A row of a study."""
    return {"one": 1.0}


def replayed(store, row):
    """A case of a study that is stored, called again."""
    runner.run(row_of, [0], store, jobs=1)
    return runner.replay(store, row)


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
QUERY_ENDS = {name: QUERY[name] for name in ("world", "start", "goal")}
#: Function, and arguments with which it works.
CALLS = {
    "plan": (fs.plan, QUERY),
    "length_first_plan": (fs.length_first_plan, QUERY),
    "widest_segment_plan": (fs.widest_segment_plan, QUERY),
    "plan_rooms": (fs.plan_rooms, QUERY),
    "shortest_path": (fs.shortest_path, QUERY),
    "time_minimal_plan": (
        fs.time_minimal_plan,
        {
            "scene": fs.Scene(WORLD, [fs.Mover(fs.Disc((2, 0), 0.1), (0.05, 0))]),
            "start": PATH_ENDS[0],
            "goal": PATH_ENDS[1],
            "speed": 0.1,
            "robot": None,
            "margin": 0.005,
        },
    ),
    "literal_plan": (
        partial(fs.literal_plan, concentric=True, outer_endpoints=True),
        QUERY | {"turning_radius": 0.08},
    ),
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
    "Line": (fs.Line, {"start": (0, 0), "end": (1, 0)}),
    "Line.at": (fs.Line((0, 0), (1, 0)).at, {"s": 0.05}),
    "Arc": (fs.Arc, {"center": (0, 0), "radius": 1, "start_angle": 0, "sweep": 1}),
    "Arc.at": (fs.Arc((0, 0), 1, 0, 1).at, {"s": 0.05}),
    "Path": (fs.Path, {"pieces": [fs.Line((0, 0), (1, 0))]}),
    "Path.at": (SHORT.at, {"s": 0.05}),
    "Path.sample": (SHORT.sample, {"step": 0.05}),
    "Path.clearance": (SHORT.clearance, {"world": WORLD}),
    "World.distances": (WORLD.distances, {"geometry": shapely.Point(0, 0)}),
    "World.close_pairs": (WORLD.close_pairs, {"gap": 0.1}),
    "Path.distances": (SHORT.distances, {"world": WORLD}),
    "Path.near": (SHORT.near, {"world": WORLD, "within": 0.1}),
    "Path.save": (SHORT.save, {"file": "path.json"}),
    "Path.load": (fs.Path.load, {"file": "path.json"}),
    "Plan": (
        fs.Plan,
        {field.name: getattr(PLAN, field.name) for field in dataclasses.fields(fs.Plan)},
    ),
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
    "Robot.from_footprint": (
        partial(
            fs.Robot.from_footprint,
            wheel_base=0.1,
            wheel_radius=0.02,
            max_wheel_rate=40,
            max_wheel_rate_change=100,
        ),
        {"outline": [(0.1, 0), (0, 0.1), (0, -0.1)]},
    ),
    "Robot.to_wheels": (ROBOT.to_wheels, {"v": 0.1, "omega": np.zeros(3)}),
    "Robot.to_body": (ROBOT.to_body, {"wheels": (0.1, 0.2)}),
    "Robot.saturate": (
        ROBOT.saturate,
        {"wheels": np.ones((2, 3)), "previous": np.zeros((2, 3)), "dt": 0.05},
    ),
    "Robot.move": (ROBOT.move, {"pose": np.zeros((3, 4)), "wheels": (0.1, 0.2), "dt": 0.05}),
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
    "Reference.at": (REFERENCE.at, {"t": 0.05}),
    "Reference.steps": (REFERENCE.steps, {"dt": 0.05}),
    "Reference.sampler": (REFERENCE.sampler, {"dt": 0.05}),
    "Reference": (
        fs.Reference,
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
    "react": (
        fs.react,
        {
            "reactive": fs.PotentialField(),
            **NEAR,
            "robot": None,
            "dt": 0.05,
            "disturbance": None,
            "seed": 0,
            "tolerance": 0.01,
            "patience": 0.5,
            "limit": 1.0,
        },
    ),
    "ReactiveRun": (
        fs.ReactiveRun,
        {
            field.name: getattr(REACTIVE_RUN, field.name)
            for field in dataclasses.fields(fs.ReactiveRun)
        },
    ),
    "random_tasks": (
        reacting.random_tasks,
        {"count": 1, "seed": 0, "n": 8, "shapes": ("disc",), "area": 0.1},
    ),
    "attempt": (
        partial(reacting.attempt, patience=0.5),
        {"law": fs.PotentialField(), "task": TASK, "disturbance": None, "seed": 0},
    ),
    "room_like_barn": (reacting.room_like_barn, {"seed": 1}),
    "training_tasks": (reacting.training_tasks, {"name": "barn"}),
    "load_laws": (reacting.load_laws, {"file": data.DATA / "reactive_gains.csv"}),
    "read_gains": (
        reacting.read_gains,
        {
            "file": data.DATA / "movers_gains.csv",
            "keys": ("method",),
            "ranges": {
                (method,): ranges
                for method, ranges in (moving.MOVERS_RANGES | moving.PEER_RANGES).items()
            },
        },
    ),
    "reactive_rivals": (reacting.reactive_rivals, {"file": data.DATA / "reactive_gains.csv"}),
    "trap_worlds": (traps.trap_worlds, {}),
    "draw": (stress.draw, {"statics": STATICS, "numbers": NUMBERS, "times": {"noise": 2.0}}),
    "drive_drawn": (
        stress.drive_drawn,
        {
            "tracker": fs.SlidingMode(),
            "course": COURSE,
            "offsets": np.zeros((3, 2)),
            "drawn": stress.draw(STATICS, NUMBERS)[1],
        },
    ),
    "samples_of": (stress.samples_of, {"course": COURSE}),
    "outcome": (
        stress.outcome,
        {
            "tracker": fs.SlidingMode(),
            "course": COURSE,
            "statics": STATICS,
            "numbers": NUMBERS,
            "times": None,
        },
    ),
    "best_laws": (stress.best_laws, {}),
    "counted_course": (stress.counted_course, {"number": 0}),
    # What is good for the rest would take seconds.
    "count_failures": (
        partial(stress.count_failures, number=0),
        {"tracker": fs.SlidingMode(), "strong": False},
    ),
    "shortfall": (
        stress.shortfall,
        {"tracker": fs.SlidingMode(), "course": COURSE, "margin": 0.03},
    ),
    "rare_courses": (stress.rare_courses, {}),
    "split_shortfall": (partial(stress.split_shortfall, course=0), {"law": "none"}),
    "sensitivity": (
        stress.sensitivity,
        {"tracker": fs.SlidingMode(), "course": COURSE, "number": 2, "robots": 1, "seed": 0},
    ),
    "load_stress": (stress.load_stress, {"file": data.DATA / "stress.npz"}),
    "random_task": (moving.random_task, {"number": 0}),
    "methods": (moving.methods, {}),
    "told_noise": (moving.told_noise, {"given": BLIND, "noise": 0.002}),
    "with_gains": (
        moving.with_gains,
        {"method": "VFH+", "gains": moving.load_gains()["VFH+"]},
    ),
    "load_moving_gains": (moving.load_gains, {"file": moving.MOVERS_GAINS}),
    "score_among_movers": (
        moving.score_among_movers,
        {"law": fs.Following(), "numbers": [3], "noise": 0.0},
    ),
    "bound": (moving.bound, {"task": moving.random_task(3)}),
    "drive_all": (moving.drive_all, {"number": 1, "given": BLIND, "noise": 0.0}),
    "compare_movers": (
        moving.compare,
        {"numbers": [1], "given": BLIND, "noise": 0.0, "store": None, "jobs": 1},
    ),
    "save_drives": (moving.save_drives, {"rows": DRIVES, "file": "drives.npz"}),
    "load_drives": (moving.load_drives, {"file": moving.DRIVES}),
    "summarise_drives": (moving.summarise, {"rows": DRIVES, "by": ("movers",)}),
    "moving_pairs": (moving.pairs, {"rows": DRIVES}),
    "beside": (moving.beside, {"rows": DRIVES, "rival": "MPC"}),
    "random_crossing": (crossings.random_crossing, {"seed": 0}),
    "plan_crossing": (crossings.plan_crossing, {"seed": 0}),
    "load_crossings": (crossings.load_crossings, {}),
    "judge_rivals": (
        crossings.judge_rivals,
        {"rows": crossings.load_crossings()[:3], "names": ["grid"]},
    ),
    "Following": (
        fs.Following,
        {
            "tracker": fs.Kanayama(),
            "timed": False,
            "keep_out": False,
            "speed": 0.1,
            "reserve": 0.02,
            "acceleration": 0.5,
            "margin": 0.01,
            "noise": 0.002,
        },
    ),
    "Replanning": (
        fs.Replanning,
        {
            "speed": 0.1,
            "margin": 0.01,
            "noise": 0.002,
            "reach": 1.0,
            "ahead": 0.1,
            "fallback": "keep",
            "steering": 6.0,
            "turn_rate": 3.0,
        },
    ),
    "score": (reacting.score, {"law": fs.PotentialField(), "tasks": [TASK]}),
    "search": (
        reacting.search,
        {
            "cost": lambda gains: gains["gain"],
            "ranges": {"gain": (1, 10)},
            "first": {"gain": 2},
            "seed": 0,
            "budget": 5,
            "population": 5,
        },
    ),
    "tune a reactive law": (
        partial(reacting.tune, seed=0),
        {"name": "PotentialField", "tasks": [TASK], "budget": 16},
    ),
    "Run": (
        fs.Run,
        {field.name: getattr(RUN, field.name) for field in dataclasses.fields(fs.Run)},
    ),
    "metrics.planning": (fs.metrics.planning, {"world": WORLD, "plan": PLAN}),
    "Mover": (
        fs.Mover,
        {"obstacle": fs.Disc((0, 0), 1), "velocity": (1, 0), "shift": None, "growth": 0.0},
    ),
    "Mover.at": (MOVER.at, {"t": 1.0}),
    "Mover.shifts": (MOVER.shifts, {"t": np.zeros(2)}),
    "Scene": (fs.Scene, {"world": WORLD, "movers": [MOVER]}),
    "Scene.at": (fs.Scene(WORLD, [MOVER]).at, {"t": 1.0}),
    "Scene.distances": (fs.Scene(WORLD, [MOVER]).distances, {"points": (0, 0), "t": 0.0}),
    "Scene.clearance": (fs.Scene(WORLD, [MOVER]).clearance, {"timed": RUN}),
    "metrics.tracking": (
        fs.metrics.tracking,
        {"run": RUN, "world": WORLD, "since": 0.0, "until": np.inf, "settled_heading": np.inf},
    ),
    "count_in_mm": (lambda axes: fs.plotting.count_in_mm(axes), {"axes": AX.xaxis}),
    "count_in_degrees": (lambda axes: fs.plotting.count_in_degrees(axes), {"axes": AX.xaxis}),
    "map_axes": (fs.plotting.map_axes, {"ax": AX}),
    "plot_world": (fs.plotting.plot_world, {"world": WORLD, "ax": None, "numbers": None}),
    "plot_segments": (
        fs.plotting.plot_segments,
        {"segments": CHAIN, "ax": AX, "lengths": False, "names": False},
    ),
    "plot_endpoints": (
        fs.plotting.plot_endpoints,
        {"endpoints": find_endpoints(WORLD, CHAIN), "ax": AX},
    ),
    "plot_path": (fs.plotting.plot_path, {"path": SHORT, "ax": AX, "color": "red"}),
    "plot_circle": (
        fs.plotting.plot_circle,
        {"center": (0, 0), "radius": 0.1, "ax": AX, "color": "red"},
    ),
    "plot_case": (fs.plotting.plot_case, {"plan": PLAN, "best": PLAN, "ax": AX}),
    "plot_round": (
        fs.plotting.plot_round,
        {"world": WORLD, "path": SHORT, "met": (0,), "robot": ROBOT, "margin": 0.005, "ax": AX},
    ),
    "plot_clearance": (
        fs.plotting.plot_clearance,
        {"world": WORLD, "path": SHORT, "obstacle": 0, "ax": AX},
    ),
    "plot_counts": (
        fs.plotting.plot_counts,
        {
            "counts": {"discs": {"solved": [16]}, "squares": {"solved": [15]}},
            "chosen": {"solved": 16},
            "ax": AX,
        },
    ),
    "plot_growth": (
        fs.plotting.plot_growth,
        {"sizes": [7, 20], "times": [0.1, 0.2], "ax": AX, "color": "red"},
    ),
    "plot_met": (fs.plotting.plot_met, {"world": WORLD, "met": [0], "ax": AX}),
    "plot_bars": (
        fs.plotting.plot_bars,
        {"values": [1.0, 2.0], "labels": ["a", "b"], "ax": AX, "color": "red"},
    ),
    "plot_ranges": (
        fs.plotting.plot_ranges,
        {"ranges": {"any": np.ones((7, 2))}, "chosen": np.ones(7), "ax": AX},
    ),
    "plot_block_diagram": (
        fs.plotting.plot_block_diagram,
        {"blocks": {"P": (0, 0, "P"), "C": (2, 0, "C")}, "links": [("u", "P", "C")], "ax": AX},
    ),
    "plot_bode": (
        fs.plotting.plot_bode,
        {"loop": integrator, "omega": [0.1, 1, 10], "axes": None, "color": "red", "label": "L"},
    ),
    "plot_nyquist": (
        fs.plotting.plot_nyquist,
        {"loop": integrator, "lowest": 0.1, "highest": 10, "ax": AX, "color": "red"},
    ),
    "plot_gang_of_four": (
        fs.plotting.plot_gang_of_four,
        {"plant": integrator, "controller": integrator, "omega": [0.1, 1], "axes": None},
    ),
    "sketch_error": (
        fs.plotting.sketch_error,
        {"pose": (0, 0, 0), "wanted": (1, 1, 0), "robot": ROBOT, "ax": AX},
    ),
    "sketch_surface": (fs.plotting.sketch_surface, {"robot": ROBOT, "ax": AX}),
    "plot_denominator": (
        fs.plotting.plot_denominator,
        {"length_scale": 0.05, "floor": 0.2, "ax": None},
    ),
    "plot_lyapunov_rate": (
        fs.plotting.plot_lyapunov_rate,
        {"length_scale": 0.05, "speed": 0.1, "turn_rate": 1.0, "ax": AX},
    ),
    "plot_tradeoff": (
        fs.plotting.plot_tradeoff,
        {"families": {"one": [[1, 2], [0.1, 0.2]]}, "marks": [["a", "b"]], "ax": AX},
    ),
    "plot_query": (fs.plotting.plot_query, {"start": (0, 0), "goal": (1, 1), "ax": AX}),
    "plot_plan": (
        fs.plotting.plot_plan,
        {"world": WORLD, "plan": PLAN, "ax": AX, "numbers": None},
    ),
    "plot_band": (fs.plotting.plot_band, {"path": SHORT, "robot": ROBOT, "ax": AX}),
    "plot_step": (
        fs.plotting.plot_step,
        {"world": WORLD, "plan": PLAN, "step": PLAN.steps[-1], "ax": AX},
    ),
    "legend_below": (fs.plotting.legend_below, {"figure": AX.figure, "ncols": 4}),
    "sketch_danger": (
        fs.plotting.sketch_danger,
        {"distance": 0.03, "robot": ROBOT, "ax": AX, "endpoint": 0.1},
    ),
    "sketch_loop": (fs.plotting.sketch_loop, {"ax": AX}),
    "plot_repairs": (fs.plotting.plot_repairs, {"plans": {"one": PLAN}, "ax": AX}),
    "plot_moment": (fs.plotting.plot_moment, {"plan": TIMED, "t": 0.5, "ax": AX}),
    "animate_plan": (
        fs.plotting.animate_plan,
        {"plan": TIMED, "limits": (0, 1, 0, 1), "ax": AX, "frames": 2},
    ),
    "plot_space_time": (fs.plotting.plot_space_time, {"plan": TIMED, "ax": SPACE}),
    "plot_opening": (
        fs.plotting.plot_opening,
        {"t": [0.0, 1.0], "lengths": [0.1, 0.2], "required": 0.15, "ax": AX},
    ),
    "sketch_graze": (fs.plotting.sketch_graze, {"ax": AX}),
    "sketch_slide": (fs.plotting.sketch_slide, {"ax": AX}),
    "sketch_leave": (fs.plotting.sketch_leave, {"ax": AX}),
    "plot_potential": (
        fs.plotting.plot_potential,
        {
            "potential": height,
            "world": WORLD,
            "limits": (0, 1, 0, 1),
            "ax": AX,
        },
    ),
    "plot_forces": (
        fs.plotting.plot_forces,
        {"field": fs.PotentialField(), "world": WORLD, "goal": (1, 1), "point": (0, 0)}
        | {"robot": ROBOT, "ax": AX},
    ),
    "plot_chase": (
        fs.plotting.plot_chase,
        {"world": WORLD, "start": (0, 0), "goal": (1, 1), "run": RUN, "t": 0.1, "ax": AX},
    ),
    "plot_histogram": (
        fs.plotting.plot_histogram,
        {"law": fs.VectorFieldHistogram(), "world": WORLD, "goal": (1, 1), "pose": (0, 0, 0)}
        | {"robot": ROBOT, "ax": AX},
    ),
    "plot_window": (
        fs.plotting.plot_window,
        {"law": fs.DynamicWindow(), "world": WORLD, "goal": (1, 1), "run": RUN, "step": 1}
        | {"ax": AX},
    ),
    "plot_turns": (
        fs.plotting.plot_turns,
        {"judged": orders.judge_orders(ORDERS), "points": [(0, 1)], "ax": AX},
    ),
    "plot_tracks": (
        fs.plotting.plot_tracks,
        {"world": WORLD, "start": (0, 0), "goal": (1, 1), "tracks": {"one": PLAN}, "ax": AX},
    ),
    "plot_duels": (
        fs.plotting.plot_duels,
        {"names": ["a"], "alone": [[0]], "decided": np.zeros((1, 1), bool), "ax": AX},
    ),
    "plot_free_space": (
        fs.plotting.plot_free_space,
        {"world": WORLD, "goal": (1, 1), "clearance": 0.07, "ax": AX},
    ),
    "sketch_horizon": (fs.plotting.sketch_horizon, {"ax": AX}),
    "plot_turn": (
        fs.plotting.plot_turn,
        {"run": RUN, "reference": REFERENCE, "since": 0.0, "until": 1.0, "ax": AX},
    ),
    "plot_lookahead": (
        fs.plotting.plot_lookahead,
        {"path": SHORT, "driven": np.zeros((2, 3)), "plan": np.ones((2, 3)), "ax": AX},
    ),
    "plot_strip": (
        fs.plotting.plot_strip,
        {"values": {"a": [1, 2]}, "ax": AX, "quantity": "time (s)"},
    ),
    "plot_change": (
        fs.plotting.plot_change,
        {"values": {"a": (2, 1)}, "labels": ("b", "c"), "ax": AX, "quantity": "RMS (mm)"},
    ),
    "plot_keep_out": (fs.plotting.plot_keep_out, {"world": WORLD, "run": RUN, "ax": AX}),
    "plot_radii": (fs.plotting.plot_radii, {"radii": {"a": [1.1, 0.9]}, "ax": AX}),
    "plot_distances": (fs.plotting.plot_distances, {"runs": {"a": RUN}, "ax": AX}),
    "plot_group": (fs.plotting.plot_group, {"world": WORLD, "group": (0, 1), "ax": AX}),
    "plot_tracking": (
        fs.plotting.plot_tracking,
        {"world": WORLD, "plan": PLAN, "run": RUN, "ax": AX},
    ),
    "draw_robot": (fs.plotting.draw_robot, {"pose": (0, 0, 0), "robot": ROBOT, "ax": AX}),
    "move_robot": (fs.plotting.move_robot, {"place": PLACE, "pose": (0, 0, 0)}),
    "sketch_pose": (fs.plotting.sketch_pose, {"robot": ROBOT, "ax": AX}),
    "sketch_turn": (fs.plotting.sketch_turn, {"robot": ROBOT, "ax": AX}),
    "sketch_sum": (fs.plotting.sketch_sum, {"robot": ROBOT, "ax": AX}),
    "sketch_segment": (
        fs.plotting.sketch_segment,
        {"length": 0.2, "robot": ROBOT, "margin": 0.005, "ax": AX},
    ),
    "plot_detours": (
        fs.plotting.plot_detours,
        {"start": (0, 0), "goal": (1, 1), "lengths": [1.5, 2], "ax": AX, "color": "red"},
    ),
    "sketch_tangent": (fs.plotting.sketch_tangent, {"ax": AX}),
    "sketch_literal_circle": (
        fs.plotting.sketch_literal_circle,
        {"angle": 0.5, "obstacle_radius": 0.04, "robot": ROBOT, "margin": 0.005, "ax": AX},
    ),
    "sketch_step": (fs.plotting.sketch_step, {"robot": ROBOT, "ax": AX}),
    "plot_drive": (
        fs.plotting.plot_drive,
        {"right": 0.1, "left": 0.05, "duration": 2, "robot": ROBOT, "ax": AX},
    ),
    "plot_limits": (fs.plotting.plot_limits, {"robot": ROBOT, "ax": AX}),
    "plot_reference": (
        fs.plotting.plot_reference,
        {"reference": REFERENCE, "robot": ROBOT, "axes": None},
    ),
    "plot_leads": (
        fs.plotting.plot_leads,
        {"run": STRAIGHT_RUN, "reference": STRAIGHT, "plan": STRAIGHT_PLAN, "ax": AX},
    ),
    "plot_pull": (fs.plotting.plot_pull, {"run": RUN, "axes": None, "most": 0.1, "wheels": 0.1}),
    "plot_across": (fs.plotting.plot_across, {"runs": {"one": RUN}, "ax": AX, "most": 0.1}),
    "plot_on_axes": (
        fs.plotting.plot_on_axes,
        {
            "run": RUN,
            "limits": (1, 1, 1),
            "wheels": 0.2,
            "axes": None,
            "length": "mm",
            "angle": "rad",
            "until": 1,
        },
    ),
    "plot_quantiles": (
        fs.plotting.plot_quantiles,
        {"t": [0, 1], "values": np.eye(2), "ax": AX, "color": "red"},
    ),
    "plot_starts": (
        fs.plotting.plot_starts,
        {"offsets": [0, 1], "ends": np.eye(2), "ax": plt.figure().add_subplot()},
    ),
    "plot_agreement": (
        fs.plotting.plot_agreement,
        {"counts": np.ones((1, 2, 2)), "rows": ["a"], "columns": ["b", "c"], "ax": AX},
    ),
    "plot_run": (fs.plotting.plot_run, {"run": RUN, "ax": AX, "robots": 2}),
    "plot_errors": (fs.plotting.plot_errors, {"run": RUN, "axes": None}),
    "plot_wheels": (fs.plotting.plot_wheels, {"run": RUN, "ax": AX}),
    "animate": (
        fs.plotting.animate,
        {"world": WORLD, "plan": PLAN, "run": RUN, "ax": AX, "frames": 3},
    ),
    "interval": (
        statistics.interval,
        {"values": np.eye(4), "seed": 0, "studentised": True, "level": 0.9},
    ),
    "differences": (
        statistics.differences,
        {"values": {"one": np.eye(4), "other": np.ones((4, 4))}, "seed": 0, "level": 0.9},
    ),
    "verdict": (statistics.verdict, {"low": -1, "high": 2, "margin": 1}),
    "order": (
        statistics.order,
        {"found": [statistics.Difference("one", "other", 0, -1, 1)], "margin": 1},
    ),
    "share": (
        statistics.share,
        {"count": 1, "runs": 3, "method": "clopper-pearson", "level": 0.9},
    ),
    "sequential": (
        statistics.sequential,
        {"values": [0, 1], "bounds": (-1, 1), "margin": 0.1, "level": 0.9},
    ),
    "hypervolume": (statistics.hypervolume, {"points": [(0, 1)], "worst": (2, 2)}),
    "linearised": (
        statistics.linearised,
        {"values": np.ones((2, 2, 2, 2)), "statistic": np.sum, "step": 1e-6},
    ),
    "run": (
        lambda **given: list(runner.run(**given)),
        {
            "function": row_of,
            "cases": [1],
            "store": "store",
            "seed": 0,
            "jobs": 1,
            "chunk_time": 10,
            "strict": False,
            "progress": None,
        },
    ),
    "case_seed": (runner.case_seed, {"seed": 0, "case": 0}),
    # They read what a study has stored.
    "load": (
        lambda store: runner.run(row_of, [0], store, jobs=1) and studies.load(store),
        {"store": "store"},
    ),
    "replay": (lambda store, row: replayed(store, row), {"store": "store", "row": 0}),
    "random_sizes": (
        sizes.random_sizes,
        {"count": 1, "shape": "disc", "seed": 0, "margin": 0.005},
    ),
    "make_tables": (sizes.make_tables, {"sizes": WORLD.radii, "shape": "disc"}),
    "try_sizes": (sizes.try_sizes, {"sizes": WORLD.radii, "shape": "disc", "margin": 0.005}),
    "by_group": (sizes.by_group, {"plan": PLAN}),
    "senses": (sizes.senses, {"plan": PLAN}),
    "random_case": (planning.random_case, {"seed": 1}),
    "try_rules": (planning.try_rules, {"seed": 1}),
    "pose_question": (rivals.pose_question, {"case": ("paper", "13a")}),
    "judge_track": (
        rivals.judge_track,
        {
            "track": SHORT,
            "world": WORLD,
            "start": (0, 0),
            "goal": (0.1, 0),
            "robot": None,
            "within": 1e-6,
        },
    ),
    "try_rivals": (rivals.try_rivals, {"case": ("paper", "13a"), "rivals": RIVALS}),
    "compare": (
        rivals.compare,
        {"cases": [("paper", "13a")], "rivals": RIVALS, "jobs": 1, "store": None},
    ),
    "summarise": (rivals.summarise, {"rows": COMPARED}),
    "save_rivals": (rivals.save_rivals, {"rows": COMPARED, "file": "rivals.npz"}),
    "load_rivals": (rivals.load_rivals, {"file": data.DATA / "rivals.npz"}),
    "row_of_discs": (orders.row_of_discs, {"n": 3, "share": 0.5, "seed": 1}),
    "row_cases": (orders.row_cases, {"rows": 2}),
    "count_operations": (orders.count_operations, {"case": "13a"}),
    "compare_orders": (orders.compare_orders, {"cases": ["13a"], "jobs": 1, "store": None}),
    "judge_orders": (orders.judge_orders, {"rows": ORDERS}),
    "turning_share": (orders.turning_share, {"rows": ORDERS}),
    "turning_interval": (orders.turning_interval, {"rows": ORDERS, "seed": 0, "resamples": 2}),
    "pool": (duels.pool, {"rows": COMPARED, "sets": ["paper"]}),
    "fastest": (duels.fastest, {"found": duels.pool(COMPARED, ["paper"]), "near": 0.5}),
    "shortest": (duels.shortest, {"found": duels.pool(COMPARED, ["paper"])}),
    "barn_scores": (
        duels.barn_scores,
        {
            "rows": [row | {"set": "barn"} for row in COMPARED],
            "lengths": {"13a": 1.0},
            "speed": 1.0,
        },
    ),
    "differs": (duels.differs, {"one": 1, "other": 2, "tests": 1, "risk": 0.05}),
    "check_rows": (rivals.check_rows, {"rows": COMPARED}),
    "check_rivals": (rivals.check_rivals, {"rivals": {"exact": fs.shortest_path}}),
    "percent": (duels.percent, {"found": {"solved": 1, "questions": 2}}),
    "span": (
        duels.span,
        {
            "by_set": {"paper": {"a": {"x": 1.0}, "b": {"x": 2.0}}},
            "rival": "a",
            "key": "x",
            "over": "b",
        },
    ),
    "duel": (duels.duel, {"rows": COMPARED, "sets": ["paper"], "risk": 0.05}),
    "length_ratios": (
        duels.length_ratios,
        {"rows": COMPARED, "sets": ["paper"], "reference": rivals.EXACT, "risk": 0.05},
    ),
    "load_tracks": (duels.load_tracks, {"file": data.DATA / "rival_tracks.csv"}),
    "tracks_of": (
        duels.tracks_of,
        {"rivals": RIVALS, "question": rivals.pose_question(("paper", "13a"))},
    ),
    "compare_rules": (planning.compare_rules, {"seeds": [1], "jobs": 1, "store": None}),
    "make_course": (
        courses.make_course,
        {"name": "one", **QUERY_ENDS, "speed": 0.1, "planner": fs.shortest_path},
    ),
    "needed_variation": (courses.needed_variation, {"reference": REFERENCE}),
    "random_courses": (courses.random_courses, {"courses": 1, "seed": 0, "speed": 0.1}),
    "paper_courses": (courses.paper_courses, {"speed": 0.1}),
    "spread_offsets": (courses.spread_offsets, {"robots": 3, "seed": 0}),
    "drive_course": (
        tracking.drive_course,
        {
            "tracker": fs.SlidingMode(),
            "course": COURSE,
            "offsets": np.zeros((3, 2)),
            "seed": 0,
            "disturbance": None,
        },
    ),
    "evaluate": (
        tracking.evaluate,
        {
            "tracker": fs.SlidingMode(),
            "courses": [COURSE],
            "offsets": np.zeros((3, 2)),
            "seed": 0,
            "disturbance": None,
        },
    ),
    # What is good for the rest would take minutes.
    "disturbed": (tracking.disturbed, {"times": 3}),
    "ranges": (tuning.ranges, {"name": "Pid", "form": "told"}),
    "make_tracker": (
        tuning.make_tracker,
        {
            "name": "PurePursuit",
            "form": "plain",
            "gains": {"lookahead": 0.1, "k_x": 1.0},
            "times": 2,
        },
    ),
    # What is good for the rest would take minutes.
    "training_numbers": (
        partial(tuning.training_numbers, "PurePursuit", "plain", replicate=0),
        {"gains": {"lookahead": np.ones(1), "k_x": np.ones(1)}, "regime": "fast"},
    ),
    "tune": (
        partial(tuning.tune, form="plain", regime="fast", replicate=0),
        {"name": "PurePursuit"},
    ),
    "load_gains": (
        tuning.load_gains,
        {
            "file": data.DATA / "gains.csv",
            "form": "plain",
            "regime": "nominal",
            "price": 0.02,
        },
    ),
    "at_ends": (tuning.at_ends, {"form": "plain", "regime": "nominal"}),
    "judge": (
        partial(comparing.judge, regime="fast", courses=1),
        {"tracker": fs.SlidingMode()},
    ),
    "load_comparison": (comparing.load_comparison, {"file": data.DATA / "comparison.npz"}),
    "local_gains": (comparing.local_gains, {"tracker": fs.SlidingMode(), "speed": 0.1}),
    "plot_fronts": (
        fs.plotting.plot_fronts,
        {"fronts": {"one": np.ones((2, 2))}, "ax": AX},
    ),
    "plot_outcomes": (
        fs.plotting.plot_outcomes,
        {"counts": ledger.count_outcomes([]), "ax": AX},
    ),
    "plot_intervals": (
        fs.plotting.plot_intervals,
        {
            "intervals": {"kind": {"one": (1, 0, 2)}},
            "margin": 1,
            "colors": None,
            "lengths": True,
            "ax": AX,
        },
    ),
    "plot_tails": (
        fs.plotting.plot_tails,
        {"tails": {"PID": [TAIL]}, "colors": None, "aim": 1e-3, "ax": AX},
    ),
    "plot_failures": (
        fs.plotting.plot_failures,
        {
            "shares": {"PID": [statistics.share(0, 10)]},
            "strengths": [1],
            "colors": None,
            "ax": AX,
        },
    ),
    "plot_indices": (
        fs.plotting.plot_indices,
        {"names": ["slip"], "first": np.ones((3, 1)), "total": np.ones((3, 1)), "ax": AX},
    ),
    "lowest_level": (splitting.lowest_level, {"tail": TAIL, "probability": 0.3}),
    "split": (
        splitting.split,
        {
            "level": height_of,
            "dimensions": 2,
            "levels": [0.5],
            "seed": 1,
            "populations": 2,
            "particles": 10,
            "killed": 2,
            "moves": 1,
            "least": 1e-3,
        },
    ),
    "plot_order": (
        fs.plotting.plot_order,
        {"order": ORDER, "means": {"one": 1.0, "other": 2.0}, "ax": AX},
    ),
    "read_csv": (
        data.read_csv,
        {"path": data.DATA / "khepera4.csv", "columns": {"parameter": str}},
    ),
    "read_arrays": (
        data.read_arrays,
        {"path": data.DATA / "comparison.npz", "names": ["hit"], "again": "compare again"},
    ),
    "write_arrays": (data.write_arrays, {"path": "arrays.npz", "arrays": {"x": np.ones(2)}}),
    "read_rows": (
        data.read_rows,
        {
            "path": data.DATA / "rivals.npz",
            "columns": {"set": str, "length_m": float},
            "again": "compare again",
        },
    ),
    "write_rows": (
        data.write_rows,
        {"path": "rows.npz", "rows": [{"x": 1.0}], "columns": {"x": float}},
    ),
    "write_csv": (data.write_csv, {"path": "rows.csv", "rows": [{"name": 1}]}),
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
        {"file": data.DATA / "floor_plan.geojson", "unit": "deg", "origin": (0, 0)},
    ),
    "save_geojson": (
        fs.maps.save_geojson,
        {"world": WORLD, "file": "map.geojson", "unit": "deg", "origin": (0, 0)},
    ),
    "load_ros_map": (
        fs.maps.load_ros_map,
        {
            "yaml_file": data.DATA / "floor_plan.yaml",
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
}
for tracker in TRACKERS:
    good = {field.name: field.default for field in dataclasses.fields(tracker)}
    CALLS[tracker.__name__] = tracker, good
    run = {"reference": REFERENCE, "robot": ROBOT, "dt": 0.05}
    CALLS[f"{tracker.__name__}.start"] = tracker().start, run
for reactive in (getattr(fs, name) for name in fs.reactive.__all__):
    good = {field.name: field.default for field in dataclasses.fields(reactive)}
    CALLS[reactive.__name__] = reactive, good
    drive = {"scene": WORLD, "goal": (0.02, 0.0), "robot": ROBOT, "dt": 0.05}
    CALLS[f"{reactive.__name__}.start"] = reactive().start, drive
PREDICTING = {"tracker": fs.SlidingMode(), "delay": 0.05, "lag": 0.03}
CALLS["Predicting"] = fs.Predicting, PREDICTING
CALLS["Predicting.start"] = fs.Predicting(**PREDICTING).start, run
CALLS["Lqr.gains"] = fs.Lqr().gains, {"v_r": 0.1, "dt": 0.05}

#: What a function calls.
CALLED = {
    ("drive", "law"),
    ("run", "function"),
    ("plot_potential", "potential"),
    ("search", "cost"),
    ("split", "level"),
    ("linearised", "statistic"),
    ("plot_bode", "loop"),
    ("plot_nyquist", "loop"),
    ("plot_gang_of_four", "plant"),
    ("plot_gang_of_four", "controller"),
}


#: Where NaN is an answer.
MAY_BE_NAN = {"try_rules", "split", "lowest_level", "read_rows", "judge_rivals"}
MAY_BE_NAN |= {"drive_all", "compare_movers", "load_drives", "bound", "summarise_drives"}


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
        # Clearing takes longer than most calls, of which few draw.
        if len(AX.get_children()) > EMPTY:
            AX.clear()


@pytest.mark.parametrize(
    ("call", "parameter"),
    [(call, parameter) for call, (_, good) in CALLS.items() for parameter in good],
)
def test_bad_values_give_our_errors_or_right_results(call, parameter, tmp_path, monkeypatch):
    # Some values are names of files, that are written.
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("Agg")
    # A folder for what is saved, with a map for what loads one.
    monkeypatch.chdir(tmp_path)
    Path("small.map").write_text("type octile\nheight 1\nwidth 2\nmap\n@.\n")
    for kind, value in BAD.items():
        if (call, parameter) in CALLED and callable(value):
            continue  # it is called, and its own error comes through
        result = outcome(call, parameter, value)
        text = str(result) if isinstance(result, fs.FreesegError) else ""
        assert len(text) < 1000, (kind, text[:200])
        if isinstance(result, ValueError):
            named = parameter, parameter.rstrip("s"), shown(value)[:20], "has shape", "be finite"
            assert any(one in text for one in named), (kind, text)
        # Of a rule that finds no path, NaN is the length, and of what is not known, the chance.
        for array in numbers_of(result) if call not in MAY_BE_NAN else ():
            assert array.dtype.kind not in "fc" or not np.isnan(array).any(), kind


def inner(function):
    """What a bound method or a partial calls."""
    function = getattr(function, "func", function)
    return getattr(function, "__func__", function)


def public_functions(module):
    """Functions that a module defines for others."""
    for name, thing in inspect.getmembers(module, callable):
        is_function = inspect.isfunction(inspect.unwrap(thing)) and not name.startswith("_")
        # `fs.plotting` is a package: what it offers is defined in its modules.
        if is_function and f"{thing.__module__}.".startswith(f"{module.__name__}."):
            yield name, thing


def test_every_public_function_is_fed():
    fed = {inner(function) for function, _ in CALLS.values()} | {fs.with_fallback}
    for name in fs.__all__:
        thing = getattr(fs, name)
        is_error = isinstance(thing, type) and issubclass(thing, Exception)
        is_protocol = getattr(thing, "_is_protocol", False)
        takes_something = name not in ("load_cases", "Explorer")
        if callable(thing) and takes_something and not (is_error or is_protocol):
            assert thing in fed, name
    # What takes many values, or gives an iterator, is fed by a function of its own.
    names = {
        name for name, (function, _) in CALLS.items() if inner(function).__name__ == "<lambda>"
    }
    modules = fs.plotting, fs.maps, data, courses, planning, runner, sizes, statistics, tracking
    modules += (
        crossings,
        duels,
        moving,
        orders,
        reacting,
        rivals,
        splitting,
        stress,
        traps,
        tuning,
    )
    for module in modules:
        for name, function in public_functions(module):
            assert function in fed or name in names, name


@pytest.mark.parametrize(
    "kind", [fs.Robot, fs.Reference, fs.Path, fs.Plan, fs.Run, fs.Line, fs.Arc]
)
def test_every_public_method_is_fed(kind):
    fed = {inner(function) for function, _ in CALLS.values()}
    for name, method in inspect.getmembers(kind):
        is_method = inspect.isfunction(method) or inspect.ismethod(method)
        if is_method and not name.startswith("_"):
            assert inner(method) in fed, name
