"""Free segments, turning points and sliding mode, as in Hassani et al. 2018.

Path planning and path tracking for a Khepera IV robot among known
obstacles. Everything is in metres, seconds and radians.
"""

from importlib import import_module
from typing import Any

from freeseg import metrics
from freeseg.disturbance import Disturbance
from freeseg.errors import (
    FreesegError,
    InvalidData,
    InvalidParameter,
    InvalidQuery,
    InvalidWorld,
    NoPath,
    SolverFailed,
    Trapped,
)
from freeseg.following import Following
from freeseg.paper import load_cases, load_table
from freeseg.path import Arc, Line, Path
from freeseg.plan import Plan, Planner
from freeseg.planners import (
    length_first_plan,
    literal_plan,
    nearest_free,
    plan,
    plan_rooms,
    shortest_path,
    time_minimal_plan,
    widest_segment_plan,
    with_fallback,
)
from freeseg.random_worlds import random_query, random_world
from freeseg.react import ReactiveRun, react
from freeseg.reactive import DynamicWindow, PotentialField, VectorFieldHistogram
from freeseg.reference import Reference, make_reference, tracking_error
from freeseg.replanning import Replanning
from freeseg.robot import KheperaIV, Robot
from freeseg.scene import Mover, Scene
from freeseg.segments import free_segments
from freeseg.simulate import Run, drive, simulate
from freeseg.trackers import (
    FeedbackLinearisation,
    Fuzzy,
    Kanayama,
    Lqr,
    Pid,
    PurePursuit,
    SlidingMode,
    Stanley,
    SuperTwisting,
)
from freeseg.trackers.feedback import Law, Tracker
from freeseg.trackers.predictor import Predicting
from freeseg.world import Disc, Polygon, World

__version__ = "1.0.0"

#: Where the names are that are imported when first asked for, since they are slow to load.
_LAZY = {
    "Explorer": "freeseg.explorer",
    "Mpc": "freeseg.trackers",
    "display": "freeseg.display",
    "maps": "freeseg.maps",
    "plotting": "freeseg.plotting",
    "studies": "freeseg.studies",
    "teaching": "freeseg.teaching",
}

__all__ = [
    "Arc",
    "Disc",
    "Disturbance",
    "DynamicWindow",
    "Explorer",
    "FeedbackLinearisation",
    "Following",
    "FreesegError",
    "Fuzzy",
    "InvalidData",
    "InvalidParameter",
    "InvalidQuery",
    "InvalidWorld",
    "Kanayama",
    "KheperaIV",
    "Law",
    "Line",
    "Lqr",
    "Mover",
    "Mpc",
    "NoPath",
    "Path",
    "Pid",
    "Plan",
    "Planner",
    "Polygon",
    "PotentialField",
    "Predicting",
    "PurePursuit",
    "ReactiveRun",
    "Reference",
    "Replanning",
    "Robot",
    "Run",
    "Scene",
    "SlidingMode",
    "SolverFailed",
    "Stanley",
    "SuperTwisting",
    "Tracker",
    "Trapped",
    "VectorFieldHistogram",
    "World",
    "display",
    "drive",
    "free_segments",
    "length_first_plan",
    "literal_plan",
    "load_cases",
    "load_table",
    "make_reference",
    "maps",
    "metrics",
    "nearest_free",
    "plan",
    "plan_rooms",
    "plotting",
    "random_query",
    "random_world",
    "react",
    "shortest_path",
    "simulate",
    "studies",
    "teaching",
    "time_minimal_plan",
    "tracking_error",
    "widest_segment_plan",
    "with_fallback",
]


def __getattr__(name: str) -> Any:
    """Import one of `_LAZY`."""
    if name not in _LAZY:
        raise AttributeError(f"module 'freeseg' has no attribute {name!r}")
    module = import_module(_LAZY[name])
    return getattr(module, name) if _LAZY[name] != f"freeseg.{name}" else module


def __dir__() -> list[str]:
    return sorted({*globals(), *_LAZY})
