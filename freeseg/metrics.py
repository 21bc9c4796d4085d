"""Numbers of a plan and of a run; every name ends in its unit."""

import numpy as np

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plan import Plan, check_plan
from freeseg.scene import Scene, check_scene
from freeseg.simulate import Run
from freeseg.world import World, check_world

#: A run has settled once its position error stays below this (m).
SETTLED = 0.01

#: A wheel this close to a limit is at it: the rest is round-off (relative).
AT_LIMIT = 1e-9


def planning(world: World, plan: Plan) -> dict[str, float]:
    """Numbers of a plan.

    Parameters
    ----------
    world : World
        Obstacles that it was planned for.
    plan : Plan
        The plan.

    Returns
    -------
    dict
        ``length_m``, ``clearance_m`` (centre line to the nearest obstacle),
        ``turns``, ``safe_segments``, ``danger_segments`` and ``repairs``, the
        steps that solved a danger problem of the path first planned.

    Raises
    ------
    InvalidParameter, InvalidQuery
        For what is no plan, no world, or another one than was planned in.
    """
    check_plan(plan, check_world(world))
    safe = sum(segment.safe for segment in plan.segments)
    return {
        "length_m": plan.path.length,
        "clearance_m": plan.path.clearance(world),
        "turns": len(plan.turning_points),
        "safe_segments": safe,
        "danger_segments": len(plan.segments) - safe,
        "repairs": sum(step.kind.is_repair for step in plan.steps),
    }


def tracking(
    run: Run,
    world: World | Scene | None = None,
    since: float = 0.0,
    until: float = np.inf,
    settled_heading: float = np.inf,
) -> dict[str, float | np.ndarray]:
    """Numbers of a run, or of a part of it.

    Parameters
    ----------
    run : Run
        One robot, or a batch of n.
    world : World or Scene, optional
        Obstacles, for the clearance; of a scene, where they are at each time.
    since, until : float, optional
        First time that counts, and the first that no longer does (s), for
        all numbers but the settling time.
    settled_heading : float, optional
        Largest heading error (rad) at which a robot counts as settled; by
        default any.

    Returns
    -------
    dict
        Floats, or arrays of shape (n,) for a batch: ``position_rms_m``,
        ``position_max_m``, ``position_final_m``; the part of it along the
        reference's heading and the part across, ``along_track_rms_m`` and
        ``cross_track_rms_m``; ``heading_rms_rad``, ``heading_final_rad``;
        ``settling_time_s``, after which the position error stays below 10 mm,
        and the heading's within `settled_heading` (infinite if they do not);
        per wheel ``wheel_speed_max_m_s``,
        ``wheel_acceleration_max_m_s2`` (from rest on) and
        ``wheel_variation_m_s``, the total variation, as the larger of both
        wheels; ``wheel_acceleration_rms_m_s2``, over both, the control
        effort; ``limited_share``, the share of time at which what a wheel is
        asked for is at a limit of speed or acceleration. With a world,
        ``clearance_m``, the smallest distance of the robot's centre to an
        obstacle.

    Raises
    ------
    InvalidParameter
        For what is no run, one that followed no reference, or where no time
        of it counts.
    """
    checks.instance("run", run, Run, "what simulate returns")
    if run.error is None:
        raise InvalidParameter("run followed no reference; give what simulate returns")
    heading = checks.as_float(settled_heading)
    if not heading > 0:
        raise InvalidParameter(
            f"settled_heading is {checks.shown(settled_heading)}; give a positive angle (rad)"
        )
    times = [checks.as_float(since), checks.as_float(until)]
    part = slice(*np.searchsorted(run.t, times))
    if np.isnan(times).any() or part.start >= part.stop:
        raise InvalidParameter(
            f"since is {checks.shown(since)} and until {checks.shown(until)}; give times (s) with "
            f"steps of the run between them, which lasts {run.t[-1]:g} s"
        )
    errors = _error_numbers(run.error[..., part])
    values = errors | {"settling_time_s": _settling_time(run, heading)} | _wheel_numbers(run, part)
    if world is not None:
        points = np.moveaxis(run.pose[:2][..., part], 0, -1)
        distances = check_scene(world).distances(points, run.t[part])
        values["clearance_m"] = distances.min((-1, -2), initial=np.inf)
    return {name: float(value) if value.ndim == 0 else value for name, value in values.items()}


def _error_numbers(error):
    """Numbers of the tracking error (7), shape (3, ..., N)."""
    x_e, y_e, alpha_e = error
    position, heading = np.hypot(x_e, y_e), np.abs(alpha_e)
    along = np.cos(alpha_e) * x_e + np.sin(alpha_e) * y_e
    across = np.cos(alpha_e) * y_e - np.sin(alpha_e) * x_e
    return {
        "position_rms_m": np.sqrt((position**2).mean(-1)),
        "position_max_m": position.max(-1),
        "position_final_m": position[..., -1],
        "along_track_rms_m": np.sqrt((along**2).mean(-1)),
        "cross_track_rms_m": np.sqrt((across**2).mean(-1)),
        "heading_rms_rad": np.sqrt((heading**2).mean(-1)),
        "heading_final_rad": heading[..., -1],
    }


def _settling_time(run, heading):
    """First time of the last unbroken stretch that is settled (s); infinite if there is none."""
    settled = np.hypot(run.error[0], run.error[1]) < SETTLED
    settled &= np.abs(run.error[2]) <= heading
    unsettled = np.where(settled.all(-1), 0, settled.shape[-1] - np.argmin(settled[..., ::-1], -1))
    return np.append(run.t, np.inf)[unsettled]


def _wheel_numbers(run, part):
    """Numbers of the wheels and of what they are asked for, over a part of a run."""
    dt = run.t[1] - run.t[0]
    # From rest: the first change is that to the first speed.
    changes, steps = (
        np.abs(np.diff(speeds, axis=-1, prepend=0.0))[..., part]
        for speeds in (run.wheels, run.asked)
    )
    limited = steps >= run.robot.max_wheel_acceleration * dt * (1 - AT_LIMIT)
    limited |= np.abs(run.asked[..., part]) >= run.robot.max_wheel_speed * (1 - AT_LIMIT)
    return {
        "wheel_speed_max_m_s": np.abs(run.wheels[..., part]).max((0, -1)),
        "wheel_acceleration_max_m_s2": changes.max((0, -1)) / dt,
        "wheel_acceleration_rms_m_s2": np.sqrt((changes**2).mean(-1).mean(0)) / dt,
        "wheel_variation_m_s": changes.sum(-1).max(0),
        "limited_share": limited.any(0).mean(-1),
    }
