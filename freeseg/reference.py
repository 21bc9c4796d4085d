"""A path with a time law: what a tracker has to follow."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import ArrayLike
from scipy.ndimage import uniform_filter1d

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import read_only, wrap_angle
from freeseg.path import Path
from freeseg.plan import Plan
from freeseg.planners.time_minimal import TimedPlan
from freeseg.robot import Robot, as_robot, same_robot
from freeseg.smoothing import moving_average
from freeseg.world import World, check_world

#: Cruising speed (m/s) and acceleration along the path (m/s^2). Not published: assumptions.
SPEED, ACCELERATION = 0.1, 0.2

#: Length (m) over which a step of the curvature may become a ramp: the robot turns 20 degrees at
#: most on it, and the path moves by half a millimetre. An assumption.
SMOOTHING = 0.03

#: Distance between two places where the speed is limited (m), and how many intervals between
#: them a short path has at least.
SPACING, LEAST_INTERVALS = 0.0005, 200

#: Time between two points of a reference (s), and how many points a slow one has at most.
GRID, MOST_POINTS = 0.001, 200_000

#: Below this share of its speed, a reference along a timed path keeps its heading; where it turns
#: at once, it does so over this many points of its grid.
STANDS, TURNS_OVER = 1e-2, 11

#: A longer run would not end, or not fit into memory.
MOST_STEPS = 1e7

#: Longest duration of a reference (s): on a slower one, points lie too far apart.
LONGEST_DURATION = 1e6


#: Signals of a reference, and their units.
SIGNALS = {
    "pose": "m, m, rad",
    "v": "m/s",
    "omega": "rad/s",
    "v_dot": "m/s^2",
    "omega_dot": "rad/s^2",
}

#: By which share of the largest one a velocity may differ from what the poses make of it, and by
#: how much over a time step (m, rad), for the round-off of poses.
CONTRADICTION, ROUGH_METRES = 0.05, 1e-7


class Sample(NamedTuple):
    """A reference at some times: pose (3, ...), speeds and their rates (...)."""

    pose: np.ndarray
    v: np.ndarray
    omega: np.ndarray
    v_dot: np.ndarray
    omega_dot: np.ndarray


@dataclass(frozen=True, eq=False)
class Reference:
    """A timed reference on a grid.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Time (s), increasing from zero.
    pose : ndarray, shape (3, n)
        x_r, y_r (m) and heading alpha_r (rad).
    v, omega : ndarray, shape (n,)
        Speed v_r (m/s) and turn rate w_r (rad/s).
    v_dot, omega_dot : ndarray, shape (n,)
        Their rates (m/s^2, rad/s^2).
    shift : float, optional
        How far smoothing moved the path at most (m).
    robot : Robot, optional
        Robot that it was made for, which no other one is to follow; None for
        any.

    Raises
    ------
    InvalidParameter
        For arrays that are not finite or do not belong together, and for
        velocities that the poses contradict; it names the place.

    Notes
    -----
    The arrays are copied, and read-only. Headings in (-pi, pi] are unwrapped.
    """

    t: np.ndarray
    pose: np.ndarray
    v: np.ndarray
    omega: np.ndarray
    v_dot: np.ndarray
    omega_dot: np.ndarray
    shift: float = 0.0
    robot: Robot | None = None

    def __post_init__(self):
        t = checks.array("reference t", self.t, (None,), unit="s")
        if len(t) < 2 or t[0] != 0 or not (np.diff(t) > 0).all():
            raise InvalidParameter(
                f"reference has times {checks.shown(t.tolist())}; give two or more, increasing "
                "from zero"
            )
        object.__setattr__(self, "t", t)
        for signal, unit in SIGNALS.items():
            shape = (3, len(t)) if signal == "pose" else (len(t),)
            found = checks.array(f"reference {signal}", getattr(self, signal), shape, unit=unit)
            object.__setattr__(self, signal, found)
        headings = self.pose[2]
        if (np.abs(np.diff(headings)) > np.pi).any():
            unwrapped = read_only(np.stack([*self.pose[:2], np.unwrap(headings)]))
            object.__setattr__(self, "pose", unwrapped)
        object.__setattr__(self, "shift", checks.not_negative("reference shift", self.shift))
        if self.robot is not None:
            as_robot(self.robot)
        self._check_velocities(headings)

    def _check_velocities(self, headings):
        """Raise where the poses contradict the velocities: a law would follow neither."""
        found = _contradiction(self.t, self.pose, self.v, self.omega)
        if not found:
            return
        in_degrees = np.stack([*self.pose[:2], np.unwrap(np.radians(headings))])
        remedy = "give the velocities of these poses"
        if not _contradiction(self.t, in_degrees, self.v, self.omega):
            remedy = "its headings look like degrees, give radians"
        signal, unit, worst, rate, driven = found
        raise InvalidParameter(
            f"reference {signal} is {rate:.6g} {unit} at {self.t[worst]:.3f} s, but there its "
            f"poses make {driven:.6g} {unit}; {remedy}"
        )

    def __repr__(self) -> str:
        return f"Reference over {self.duration:.3f} s in {len(self.t)} points"

    @property
    def duration(self) -> float:
        """Time from the first to the last point (s)."""
        return float(self.t[-1])

    def at(self, t: ArrayLike) -> Sample:
        """Reference at times, interpolated; at rest at an end beyond it.

        Parameters
        ----------
        t : array_like, shape (...)
            Time (s).

        Returns
        -------
        Sample
            ``pose, v, omega, v_dot, omega_dot``.

        Raises
        ------
        InvalidParameter
            For what is no real number.
        """
        return self._at(checks.real("t", t, "times (s)"))

    def _at(self, t: ArrayLike) -> Sample:
        """`at` without its check, for the laws."""
        t = np.asarray(t, float)
        pose = np.stack([np.interp(t, self.t, row) for row in self.pose])
        outside = (t < 0) | (t > self.duration)
        rates = (self.v, self.omega, self.v_dot, self.omega_dot)
        return Sample(pose, *(np.where(outside, 0.0, np.interp(t, self.t, rate)) for rate in rates))

    def steps(self, dt: float) -> np.ndarray:
        """Times 0, dt, ... (s) up to the end, which the last passes by less than dt.

        Raises
        ------
        InvalidParameter
            For a time step that is not positive, or makes over 10 million steps.
        """
        dt = checks.positive("dt", dt)
        if self.duration / dt > MOST_STEPS:
            raise InvalidParameter(
                f"dt is {dt} s, over {MOST_STEPS:g} steps for {self.duration:.3f} s; lengthen it"
            )
        return dt * np.arange(int(np.ceil(self.duration / dt - 1e-9)) + 1)

    def sampler(self, dt: float) -> Callable[[float], Sample]:
        """Reference at a time and half a step later, read off at the steps of a run.

        Parameters
        ----------
        dt : float
            Time step (s); zero for a law that is in continuous time.

        Returns
        -------
        callable
            ``look(t) -> Sample``, as ``at([t, t + dt / 2])`` and several times
            faster where t is one of the ``steps(dt)``.

        Raises
        ------
        InvalidParameter
            For a time step that is negative, or makes over 10 million steps.
        """
        dt = checks.not_negative("dt", dt)
        steps = self.steps(dt) if dt > 0 else np.empty(0)
        ahead = self._at(np.stack([steps, steps + dt / 2], -1))
        for values in ahead:
            read_only(values)
        indices = {t: index for index, t in enumerate(steps.tolist())}

        def look(t):
            index = indices.get(t)
            if index is None:
                return self._at([t, t + dt / 2])
            return Sample(*(values[..., index, :] for values in ahead))

        return look


def _contradiction(t, pose, v, omega):
    """Where poses contradict the velocities most; None where they do not.

    Returns
    -------
    tuple or None
        The velocity's name and its unit, the index of the place, and what the
        velocity is there and what the poses make of it.
    """
    time, (x, y, theta) = np.diff(t), np.diff(pose)
    middle = (pose[2, 1:] + pose[2, :-1]) / 2
    cos, sin = np.cos(middle), np.sin(middle)
    # Along the chord of an arc, which is shorter than the arc.
    forwards = (cos * x + sin * y) / np.sinc(theta / 2 / np.pi)
    for signal, rate, driven, unit in (
        ("v", v, forwards, "m/s"),
        ("omega", omega, theta, "rad/s"),
        ("sideways speed", np.zeros_like(v), cos * y - sin * x, "m/s"),
    ):
        scale = np.abs(v if signal == "sideways speed" else rate).max()
        allowed = CONTRADICTION * scale + ROUGH_METRES / time
        # A mean rate lies between the rates at both ends.
        least, most = np.minimum(rate[1:], rate[:-1]), np.maximum(rate[1:], rate[:-1])
        excess = np.maximum(least - driven / time, driven / time - most) - allowed
        if (excess > 0).any():
            worst = int(np.argmax(excess))
            return signal, unit, worst, rate[worst], driven[worst] / time[worst]
    return None


def make_reference(
    path: Plan | Path,
    robot: Robot | None = None,
    speed: float = SPEED,
    acceleration: float = ACCELERATION,
    smoothing: float = 0.0,
    world: World | None = None,
    start_speed: float = 0.0,
    end_speed: float = 0.0,
) -> Reference:
    """Drive a path as fast as speed, acceleration and wheels allow.

    The paper publishes no speed and no time law: both are assumptions.

    Parameters
    ----------
    path : Plan or Path
        What to follow. A plan brings its robot and its world.
    robot : Robot, optional
        Robot; its wheels limit speed and acceleration.
    speed : float, optional
        Cruising speed (m/s); slower where the outer wheel needs it.
    acceleration : float, optional
        Largest rate at which it changes (m/s^2); less where wheels need it.
    smoothing : float, optional
        Length over which a step of the curvature becomes a ramp (m), see
        `moving_average`: `SMOOTHING` is a good one. Zero leaves the steps.
    world : World, optional
        Obstacles; needed for smoothing, which moves the path a little.
    start_speed, end_speed : float, optional
        Speed at the ends of the path (m/s); at rest by default.

    Returns
    -------
    Reference
        On a grid of 1 ms, or coarser where it lasts longer than 200 s.

    Raises
    ------
    InvalidParameter
        For a speed or an acceleration that is not positive or beyond what a
        wheel can do; a smoothing without a world, longer than the radius
        of an arc, or that takes the robot's disc into an obstacle; a speed
        at an end that is negative or that the path does not allow: it names
        the place and the limit. For another robot than the plan's, and for
        what would take over a million seconds.

    Notes
    -----
    The largest v^2 at every place comes from one pass forwards and one
    backwards: from each place on, to either side, v^2 rises by at most twice
    the acceleration per metre. A ramp of the curvature changes the wheel speeds
    at constant v, too. It may take what v' leaves of the wheels'
    acceleration, and v' takes at most half of it where the path bends: not
    the fastest law, but one that keeps the limits everywhere.

    Without smoothing, w_r and the wheel speeds jump where a line meets an
    arc. No robot follows that exactly: the limits then hold but for these
    jumps, and omega_dot is the rate without them.

    Examples
    --------
    >>> import freeseg as fs
    >>> plan = fs.plan(fs.load_table(1), (0, 0), (0.75, 0.75))
    >>> reference = make_reference(plan, smoothing=0.03)
    >>> round(reference.duration, 2), round(1000 * reference.shift, 2)
    (11.81, 0.41)
    """
    made_for = robot
    if isinstance(path, Plan):
        made_for = same_robot(robot, path.robot, "the plan")
        world = path.world if world is None else world
        path = path.path
    checks.instance("path", path, Path, "a Plan, or a Path such as plan.path")
    robot = as_robot(made_for)
    speed, acceleration = _check_limits(robot, speed, acceleration)
    ends = [
        checks.not_negative("start_speed", start_speed),
        checks.not_negative("end_speed", end_speed),
    ]
    # A path shorter than that is averaged over its own length.
    width = min(checks.not_negative("smoothing", smoothing), path.length)
    course = moving_average(path, width)
    s = _nodes(path, width, speed, acceleration)
    shift = _check_shift(path, course, s, robot, world) if width else 0.0

    # Seen from just inside either end of every interval, for at the ends there may be jumps.
    inside = course(s[:-1, None] + np.diff(s)[:, None] * [1e-6, 1 - 1e-6])
    most, steepest = _limits(inside, robot, speed, acceleration)
    # At a node, those on both of its sides hold.
    most = np.minimum(np.append(most, np.inf), np.append(np.inf, most))
    lengths = np.diff(s) * inside.stretch.mean(1)
    v = _fastest(most, 2 * steepest * lengths, s, ends)
    corners = np.empty(0) if width else path.joints
    return _timed(course, s, lengths, v, corners, shift, made_for)


def _check_limits(robot, speed, acceleration):
    """Speed and acceleration as floats; `InvalidParameter` unless the wheels can do them."""
    speed = checks.positive("speed", speed)
    acceleration = checks.positive("acceleration", acceleration)
    for name, value, limit, unit in (
        ("speed", speed, robot.max_wheel_speed, "m/s"),
        ("acceleration", acceleration, robot.max_wheel_acceleration, "m/s^2"),
    ):
        if value > limit:
            raise InvalidParameter(
                f"{name} is {value:g} {unit}; the robot's wheels reach at most {limit:.4f} {unit}"
            )
    return speed, acceleration


def _nodes(path, width, speed, acceleration):
    """Arc lengths of a path (m) where the speed is limited, from zero on.

    Parameters
    ----------
    path : Path
        What to follow.
    width : float
        Width of the moving average's window (m).
    speed, acceleration : float
        Cruising speed (m/s) and the rate at which it is gained from rest (m/s^2).

    Returns
    -------
    ndarray, shape (n,)
    """
    # The curvature's rate jumps where the window comes to a joint, and where it leaves it.
    breaks = np.clip(np.add.outer(path.joints, [-width / 2, 0, width / 2]), 0, path.length)
    count = int(np.clip(np.ceil(path.length / SPACING), LEAST_INTERVALS, MOST_POINTS))
    # The ramps at the ends may be far shorter than the spacing.
    ramp = min(speed**2 / acceleration, path.length) / 2
    s = np.linspace(0, path.length, count + 1)
    s = np.union1d(s, [*breaks.flat, ramp, path.length - ramp])
    s = s[np.diff(s, append=np.inf) > 1e-12 * path.length]
    s[0] = 0
    return s


def _check_shift(path, course, s, robot, world):
    """How far smoothing moves a path (m); `InvalidParameter` if into an obstacle."""
    if world is None:
        raise InvalidParameter(
            "smoothing moves the path, and whether it stays free of collisions depends on the "
            "obstacles; give the world too"
        )
    check_world(world)
    smooth, (x, y, *_) = course(s), path.at(s)
    points = np.stack([smooth.x, smooth.y], -1)
    # What the chords between the points cut off from the curve.
    sag = np.abs(smooth.curvature).max() * np.diff(s).max() ** 2 / 8
    route = shapely.linestrings(points)
    _, met, distance = world.near(np.array([route]), robot.radius + sag)
    if len(met):
        nearest = np.argmin(distance)
        place = s[np.argmin(shapely.distance(shapely.points(points), world.cores[met[nearest]]))]
        raise InvalidParameter(
            f"smoothing takes the path to {1000 * distance[nearest]:.2f} mm from obstacle "
            f"{met[nearest] + 1} at {place:.4f} m, nearer than the robot's radius of "
            f"{1000 * robot.radius:.2f} mm; give less, or plan with a larger margin"
        )
    return float(np.hypot(smooth.x - x, smooth.y - y).max())


def _limits(course, robot, speed, acceleration):
    """Largest v^2 and v' in the intervals of a course, shape (n, k) to (n,)."""
    half_base = robot.wheel_base / 2
    outer = 1 + half_base * np.abs(course.curvature)
    share = np.where(course.curvature == 0, 1.0, 0.5) * robot.max_wheel_acceleration
    steepest = np.minimum(acceleration, share / outer).min(1)
    # The wheels' acceleration is at most outer v' + bend v^2.
    bend = half_base * np.abs(course.curvature_rate)
    left = robot.max_wheel_acceleration - steepest[:, None] * outer
    bending = np.divide(left, bend, out=np.full_like(left, np.inf), where=bend > 0)
    cruising = np.minimum(speed, robot.max_wheel_speed / outer)
    return np.minimum(cruising**2, bending).min(1), steepest


def _fastest(most, climb, s, ends):
    """Largest speed at every node, by a pass forwards and one backwards.

    Parameters
    ----------
    most : ndarray, shape (n,)
        Largest v^2 at the nodes.
    climb : ndarray, shape (n - 1,)
        Largest change of v^2 from node to node.
    s : ndarray, shape (n,)
        Where the nodes are (m).
    ends : pair of float
        Speed wanted at the first and at the last node (m/s).

    Returns
    -------
    ndarray, shape (n,)
        Speed (m/s).
    """
    climb = np.append(0, np.cumsum(climb))
    wanted = most.copy()
    wanted[[0, -1]] = np.square(ends)
    for name, node in (("start_speed", 0), ("end_speed", -1)):
        others = wanted.copy()
        others[node] = most[node]
        bound = others + np.abs(climb - climb[node])
        limit = np.argmin(bound)
        if wanted[node] > bound[limit] * (1 + 1e-9):
            raise InvalidParameter(
                f"{name} is {wanted[node] ** 0.5:g} m/s; at {s[limit]:.4f} m the speed is at most "
                f"{others[limit] ** 0.5:.4f} m/s, and so {bound[limit] ** 0.5:.4f} m/s at this end"
            )
    forwards = np.minimum.accumulate(wanted - climb) + climb
    backwards = np.minimum.accumulate((wanted + climb)[::-1])[::-1] - climb
    return np.sqrt(np.minimum(forwards, backwards))


def _timed(course, s, lengths, v, corners, shift, robot):
    """The reference along a course, whose v^2 is linear between the nodes.

    Parameters
    ----------
    course : callable
        The curve, see `moving_average`.
    s : ndarray, shape (n,)
        Where the nodes are (m).
    lengths : ndarray, shape (n - 1,)
        Length of the curve from node to node (m).
    v : ndarray, shape (n,)
        Speed at the nodes (m/s).
    corners : ndarray, shape (k,)
        Where the curvature jumps (m).
    shift : float
        How far the course is from the path at most (m).
    robot : Robot or None
        Robot that the reference is for; None for any.

    Returns
    -------
    Reference
    """
    with np.errstate(divide="ignore"):
        times = np.append(0, np.cumsum(2 * lengths / (v[1:] + v[:-1])))
    if not times[-1] <= LONGEST_DURATION:
        raise InvalidParameter(
            f"speed is at most {v.max():g} m/s, at which the path takes {times[-1]:g} s; give more "
            f"speed and acceleration, for at most {LONGEST_DURATION:g} s"
        )
    t = np.linspace(0, times[-1], int(min(np.ceil(times[-1] / GRID) + 1, MOST_POINTS)))
    # A piece between two points of the grid would turn the robot unseen.
    jumps = np.interp(corners, s, times)
    slots = np.searchsorted(t, jumps)
    hidden = slots[1:] == slots[:-1]
    t = np.union1d(t, [*jumps[:-1][hidden], *jumps[1:][hidden]]) if hidden.any() else t
    interval = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(lengths) - 1)
    v_dot = (np.diff(v**2) / (2 * lengths))[interval]
    since = t - times[interval]
    passed = since * (v[interval] + v_dot * since / 2) / lengths[interval]
    here = course(s[interval] + np.diff(s)[interval] * np.minimum(passed, 1))
    v = v[interval] + v_dot * since
    return Reference(
        t,
        np.stack([here.x, here.y, here.theta]),
        v,
        v * here.curvature,
        v_dot,
        v_dot * here.curvature + v**2 * here.curvature_rate,
        shift,
        robot,
    )


def timed_reference(plan: TimedPlan, acceleration: float = ACCELERATION) -> Reference:
    """Drive a path in time from rest to rest, a little late.

    A timed path is exact for a point that has its speed V at once and turns
    corners. The reference is its moving average over the last V / acceleration
    seconds: it begins and ends with just that acceleration, and its corners are
    blended.

    Parameters
    ----------
    plan : TimedPlan
        What to follow, from `time_minimal_plan`.
    acceleration : float, optional
        Acceleration at both ends (m/s^2).

    Returns
    -------
    Reference
        Late by half of V / acceleration (s), and arriving late by all of it.
        Its ``shift`` is how far it is, at most, from where the path was by
        that half earlier.

    Raises
    ------
    InvalidParameter
        For what is no timed plan, and an acceleration that is not positive or
        beyond what a wheel can do.

    Notes
    -----
    So an acceleration costs V / acceleration seconds of arrival. Who plans
    for where the movers will be half of that later loses nothing else where the
    path is straight; where it bends, the shift has to find room in the margin. The wheels'
    limits hold between the ends, too, where the bends are so wide that the
    outer wheel keeps up; a reserve of speed is for the planner to leave.

    Examples
    --------
    >>> import freeseg as fs
    >>> scene = fs.Scene(fs.World([]), [fs.Mover(fs.Disc((0.5, 0.2), 0.1), (0, -0.02))])
    >>> plan = fs.time_minimal_plan(scene, (0, 0), (1, 0), speed=0.1)
    >>> reference = timed_reference(plan, acceleration=0.2)
    >>> round(reference.duration - plan.arrival, 9)
    0.5
    """
    checks.instance("plan", plan, TimedPlan, "one from time_minimal_plan")
    _, acceleration = _check_limits(plan.robot, plan.speed, acceleration)
    width = plan.speed / acceleration
    end = plan.arrival + width
    t = np.linspace(0, end, int(min(np.ceil(end / GRID) + 1, MOST_POINTS)))
    before = t - width
    # Integrals of the place up to t, which stands before and after.
    fine = np.union1d(np.union1d(t, before), plan.path.joints)
    place = plan.path.at(fine)[0][:2]
    total = np.zeros_like(place)
    total[:, 1:] = np.cumsum(np.diff(fine) * (place[:, 1:] + place[:, :-1]) / 2, axis=1)
    mean, (x_dot, y_dot) = (
        np.stack([np.interp(t, fine, row) - np.interp(before, fine, row) for row in rows]) / width
        for rows in (total, place)
    )
    late = np.stack([np.interp(t - width / 2, fine, row) for row in place])
    v = np.hypot(x_dot, y_dot)
    moves = v > STANDS * plan.speed
    heading = np.unwrap(np.arctan2(y_dot[moves], x_dot[moves]))
    # Where it stops and comes back, it turns round in no time: over some points of the grid, then.
    heading = uniform_filter1d(np.interp(t, t[moves], heading), TURNS_OVER, mode="nearest")
    omega = np.gradient(heading, t)
    return Reference(
        t,
        np.stack([*mean, heading]),
        v,
        omega,
        np.gradient(v, t),
        np.gradient(omega, t),
        float(np.hypot(*(mean - late)).max()),
        plan.robot,
    )


def tracking_error(reference_pose: ArrayLike, pose: ArrayLike) -> np.ndarray:
    """Error of a pose in the robot's frame, equation (7).

    Parameters
    ----------
    reference_pose, pose : array_like, shape (3, ...)
        x, y (m) and heading (rad) wanted and actual.

    Returns
    -------
    ndarray, shape (3, ...)
        x_e, y_e (m) and alpha_e (rad, in (-pi, pi]).

    Examples
    --------
    A reference 1 m north of a robot that looks north is straight ahead.

    >>> [float(round(e, 12)) for e in tracking_error((0, 1, 0), (0, 0, np.pi / 2))]
    [1.0, 0.0, -1.570796326795]
    """
    remedy = "x, y (m) and heading (rad)"
    wanted = checks.signal("reference_pose", reference_pose, remedy, 3)
    actual = checks.signal("pose", pose, remedy, 3)
    checks.together(reference_pose=wanted.shape[1:], pose=actual.shape[1:])
    return pose_error(wanted, actual)


def pose_error(reference_pose: ArrayLike, pose: ArrayLike) -> np.ndarray:
    """`tracking_error` without its checks, for the laws and the loop."""
    x_r, y_r, theta_r = np.asarray(reference_pose)
    x, y, theta = np.asarray(pose)
    cos, sin = np.cos(theta), np.sin(theta)
    dx, dy = x_r - x, y_r - y
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx, wrap_angle(theta_r - theta)])
