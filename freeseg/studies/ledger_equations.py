"""The paper's equations (1) to (13), each held against an independent computation.

What comes back of each is the largest deviation in random states; where an equation is an
inequality, or hides a choice, it is the number that decides.
"""

from typing import Any, cast

import numpy as np
from scipy.integrate import solve_ivp

from freeseg.geometry import unit
from freeseg.paper import load_cases, load_table
from freeseg.path import Arc, Path
from freeseg.planners import plan
from freeseg.reference import make_reference, tracking_error
from freeseg.robot import KheperaIV
from freeseg.segments import free_segments
from freeseg.trackers import SlidingMode
from freeseg.world import Disc, World

#: Random states of each check.
STATES = 200

#: Step of a difference quotient (s).
SMALL_STEP = 1e-5


def check_equations() -> dict[str, float]:
    """Deviations by equation.

    Returns
    -------
    dict
        ``"1"``, ``"2"``, ``"5"``, ``"7"``, ``"8"``, ``"12"`` and ``"13"``: the largest
        deviation, SI; ``"straight"``, that of a plan without obstacles from the straight line
        (m). ``"9"`` and ``"9 off"``: the largest rate of (9) on the first surface, and off it
        (m^2/s). ``"unit"``: by how much the turn rate of (12) differs for the same state in m
        and in mm (rad/s). ``"singular"``: share of states, within 0.2 m, in which the
        denominator of the turn rate is no longer positive.
    """
    rng = np.random.default_rng(17)
    return _planning() | _motion(rng) | _law(rng)


def _planning() -> dict[str, float]:
    lengths = []
    for world in map(load_table, range(1, 6)):
        for one in free_segments(world):
            first, second = (cast(Disc, world[k]) for k in one.obstacles)
            apart = np.linalg.norm(first.center - second.center) - first.radius - second.radius
            lengths.append(abs(one.length - apart))
    case = load_cases()["15a"]
    step = plan(load_table(case.table), case.start, case.goal).steps[1]
    start, goal = np.asarray(step.leg)
    detours: list[float] = []
    for candidate in step.candidates:
        legs = candidate.endpoint.point - start, goal - candidate.endpoint.point
        by_hand = sum(float(np.hypot(*leg)) for leg in legs)
        detours.append(abs(by_hand - candidate.detour))
    free = plan(World([Disc(np.array([5.0, 5.0]), 0.1)]), (0, 0), (0.3, 0.4))
    return {
        "2": float(max(lengths)),
        "5": float(max(detours)),
        "straight": abs(free.path.length - 0.5),
    }


def _motion(rng: np.random.Generator) -> dict[str, float]:
    robot = KheperaIV()
    base = robot.wheel_base
    right, left = rng.uniform(-0.3, 0.3, (2, 20))
    v, omega = (right + left) / 2, (right - left) / base

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        heading = state.reshape(3, -1)[2]
        return np.concatenate([v * np.cos(heading), v * np.sin(heading), omega])

    begun = rng.uniform(-1, 1, (3, 20))
    ended = solve_ivp(rate, (0, 1), begun.ravel(), rtol=1e-11, atol=1e-12).y[:, -1].reshape(3, -1)
    moved = robot.move(begun, np.stack([right, left]), 1.0)
    apart = moved - ended
    apart[2] = np.angle(np.exp(1j * apart[2]))
    wheels = np.stack([v + base * omega / 2, v - base * omega / 2])
    reference, pose = rng.uniform(-1, 1, (2, 3, STATES))
    (dx, dy, turn), heading = reference - pose, pose[2]
    by_hand = np.stack(
        [
            np.cos(heading) * dx + np.sin(heading) * dy,
            np.cos(heading) * dy - np.sin(heading) * dx,
            turn,
        ]
    )
    return {
        "1": float(np.abs(apart).max()),
        "8": float(np.abs(robot.to_wheels(v, omega) - wheels).max()),
        "7": float(np.abs(tracking_error(reference, pose) - by_hand).max()),
    }


def _law(rng: np.random.Generator) -> dict[str, float]:
    x, y, v_r, w = rng.uniform(-1, 1, (4, STATES)) * [[0.2], [0.2], [0.5], [2.0]]
    on_surface = y * v_r * np.sin(-np.arctan(v_r * y))
    h = 1e-6
    partial = (np.arctan(v_r * (y + h)) - np.arctan(v_r * (y - h))) / (2 * h)
    by_v = (np.arctan((v_r + h) * y) - np.arctan((v_r - h) * y)) / (2 * h)
    slope = 1 / (1 + (v_r * y) ** 2)
    arc = make_reference(Path([Arc((0, 0), 0.4, -np.pi / 2, 1.5)]), speed=0.1)
    law, top = SlidingMode(), np.abs(arc.v).max()
    in_m, in_mm = (SlidingMode(length_scale=one / top) for one in (1.0, 1e-6))
    time, pose = arc.t[-1] / 2, rng.uniform(-1, 1, (3, STATES)) * [[0.03], [0.03], [0.5]]
    pose = pose + arc.at(time).pose.reshape(3, 1)
    turn_m, turn_mm = (
        np.asarray(one.start(arc, KheperaIV(), SMALL_STEP)(time, pose)[1]) for one in (in_m, in_mm)
    )
    scale = top * law.length_scale
    errors = tracking_error(arc.at(time).pose.reshape(3, 1), pose)
    wide = rng.uniform(-0.2, 0.2, (2, STATES))
    below = 1 + wide[0] * 0.1 / (1 + (0.1 * wide[1] / scale) ** 2) / scale
    return {
        "9": float(on_surface.max()),
        "9 off": float((on_surface - x * y * w).max()),
        "12": _reaching(law, arc, time, pose[:, np.abs(errors[0]) < 0.6 * law.length_scale]),
        "13": float(max(abs(partial - v_r * slope).max(), abs(by_v - y * slope).max())),
        "unit": float(np.abs(turn_m - turn_mm).max()),
        "singular": float((below <= 0).mean()),
    }


def _reaching(law: SlidingMode, reference: Any, time: float, pose: np.ndarray) -> float:
    """Largest deviation of the rate of s from -k sat(s), (11), under the law solved from (12)."""
    scale = np.abs(reference.v).max() * law.length_scale
    v, omega = map(np.asarray, law.start(reference, KheperaIV(), SMALL_STEP)(time, pose))

    def surfaces(h: float) -> np.ndarray:
        forward = v * unit(pose[2] + h * omega / 2).T
        moved = np.stack([*(pose[:2] + h * forward), pose[2] + h * omega])
        now = reference.at(time + h)
        x_e, y_e, alpha_e = tracking_error(now.pose.reshape(3, 1), moved)
        return np.stack([x_e, alpha_e + np.arctan(now.v * y_e / scale)])

    rate = (surfaces(SMALL_STEP) - surfaces(-SMALL_STEP)) / (2 * SMALL_STEP)
    s1, s2 = surfaces(0.0)
    asked = np.stack(
        [-law.k1 * np.clip(s1 / law.phi1, -1, 1), -law.k2 * np.clip(s2 / law.phi2, -1, 1)]
    )
    return float(np.abs(rate - asked).max())
