"""Free segments, turning points and sliding mode, as in Hassani et al. 2018.

Path planning and path tracking for a Khepera IV robot among known
obstacles. Everything is in metres, seconds and radians.
"""

from importlib import import_module

from freeseg import metrics
from freeseg.disturbance import Disturbance
from freeseg.errors import (
    FreesegError,
    InvalidParameter,
    InvalidQuery,
    InvalidWorld,
    NoPath,
    SolverFailed,
    Trapped,
)
from freeseg.generate import random_query, random_world
from freeseg.path import Path
from freeseg.planners import literal_plan, plan, shortest_path
from freeseg.reference import make_reference, tracking_error
from freeseg.robot import KheperaIV
from freeseg.segments import free_segments
from freeseg.simulate import simulate
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
from freeseg.world import Disc, Polygon, World, load_cases, load_table

__version__ = "0.1.0"

__all__ = [
    "Disc",
    "Disturbance",
    "FeedbackLinearisation",
    "FreesegError",
    "Fuzzy",
    "InvalidParameter",
    "InvalidQuery",
    "InvalidWorld",
    "Kanayama",
    "KheperaIV",
    "Lqr",
    "Mpc",
    "NoPath",
    "Path",
    "Pid",
    "Polygon",
    "PurePursuit",
    "SlidingMode",
    "SolverFailed",
    "Stanley",
    "SuperTwisting",
    "Trapped",
    "World",
    "free_segments",
    "literal_plan",
    "load_cases",
    "load_table",
    "make_reference",
    "metrics",
    "plan",
    "plotting",
    "random_query",
    "random_world",
    "shortest_path",
    "simulate",
    "tracking_error",
]


def __getattr__(name):
    """Import `plotting` and `Mpc` when first asked for: Matplotlib and CasADi are slow to load."""
    if name == "plotting":
        return import_module("freeseg.plotting")
    if name == "Mpc":
        return import_module("freeseg.trackers.mpc").Mpc
    raise AttributeError(f"module 'freeseg' has no attribute {name!r}")
