"""Trackers: gains with ``start(reference, robot, dt) -> law``.

A law maps ``(t, pose)`` to a body velocity ``(v, omega)``, once every time
step. What it has to remember lives in that closure, so a second run never
sees the first.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from freeseg.trackers.feedback_linearisation import FeedbackLinearisation
from freeseg.trackers.fuzzy import Fuzzy
from freeseg.trackers.kanayama import Kanayama
from freeseg.trackers.lqr import Lqr
from freeseg.trackers.pid import Pid
from freeseg.trackers.pure_pursuit import PurePursuit
from freeseg.trackers.sliding_mode import SlidingMode
from freeseg.trackers.stanley import Stanley
from freeseg.trackers.super_twisting import SuperTwisting

if TYPE_CHECKING:
    from freeseg.trackers.mpc import Mpc

__all__ = [
    "FeedbackLinearisation",
    "Fuzzy",
    "Kanayama",
    "Lqr",
    "Mpc",
    "Pid",
    "PurePursuit",
    "SlidingMode",
    "Stanley",
    "SuperTwisting",
]


def __getattr__(name: str) -> object:
    """Import `Mpc` when first asked for: CasADi is slow to load."""
    if name == "Mpc":
        return import_module("freeseg.trackers.mpc").Mpc
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), "Mpc"])
