"""Tests of problem set 3: a sliding-mode law on another surface than the paper's."""

from functools import cache
from typing import Any

import numpy as np

from freeseg.disturbance import Disturbance
from freeseg.geometry import unit
from freeseg.metrics import tracking
from freeseg.paper import load_cases, load_table
from freeseg.planners import plan
from freeseg.reference import Reference, make_reference, tracking_error
from freeseg.robot import KheperaIV
from freeseg.simulate import simulate
from freeseg.teaching.answered import numbers
from freeseg.teaching.check import Ask, Tracker

__all__ = ["controls", "law", "nearest", "singular", "tuned"]

#: Time step of all runs (s).
TIME_STEP = 0.05
#: Gains with which the tuned ones are compared, as the set states them.
START_GAINS = {
    "k1": 0.4,
    "k2": 2.0,
    "phi1": 0.1,
    "phi2": 0.5,
    "A": 1.2,
    "c": 0.005,
    "floor": 0.25,
}
#: What the poses are measured with while gains are tuned (m, rad).
NOISE = Disturbance(position_noise=0.003, heading_noise=float(np.radians(2)))
#: Robots of a run, and how far off they start: ahead, aside (m), turned (rad).
ROBOTS, OFF = 48, np.array([[0.02], [0.02], [np.radians(20)]])
#: Costs for none and for all of the points; the start gains cost 2.
NO_POINTS, ALL_POINTS = 1.8, 1.63
#: The reference bends where it turns faster (rad/s).
BEND = 0.3
#: For derivatives by differences.
SHORTLY = 1e-6


def _gamma(v_r: Any, y_e: Any, a: Any, c: Any) -> Any:
    """The set's surface."""
    return a * np.tanh(v_r * y_e / c)


def _rate_of_s2(error: Any, w: Any, v_r: Any, w_r: Any, v_dot: Any, a: Any, c: Any) -> Any:
    """Rate of s2 at a turn rate, by how it changes in a short time: without any formula of it."""
    x_e, y_e, alpha_e = error
    y_rate = v_r * np.sin(alpha_e) - x_e * w
    ahead, behind = (
        _gamma(v_r + step * v_dot, y_e + step * y_rate, a, c) for step in (SHORTLY, -SHORTLY)
    )
    return w_r - w + (ahead - behind) / (2 * SHORTLY)


def controls(ask: Ask, rng: np.random.Generator) -> None:
    """V and w, put back into (12)."""
    error = rng.uniform(-0.1, 0.1, (3, 40)) * [[1], [1], [9]]
    _, y_e, alpha_e = error
    v_r, w_r, v_dot, reach1, reach2 = rng.uniform(0.02, 0.2, (5, 40))
    a, c = rng.uniform(0.5, 1.5), rng.uniform(0.05, 0.1)
    pair = numbers(
        ask("controls", error, v_r, w_r, v_dot, reach1, reach2, a, c),
        (2, 40),
        "give back V and w, one of each for every state",
    )
    v, w = pair
    assert np.allclose(y_e * w + v_r * np.cos(alpha_e) - v, -reach1), (
        "the first row of (12) does not hold: solve it for V, with your w in it, and mind the "
        "sign of k1 sat1"
    )
    off = _rate_of_s2(error, w, v_r, w_r, v_dot, a, c) + reach2
    still = _rate_of_s2(error, w, v_r, w_r, 0.0, a, c) + reach2
    assert not np.allclose(still, 0, atol=1e-6), "the rate of V_r is missing in your w"
    assert np.allclose(off, 0, atol=1e-6), (
        f"the second row of (12) is off by up to {np.abs(off).max():.3f} rad/s: are both "
        "derivatives those of A tanh(V_r y_e / c), did you gather both w, and has k2 sat2 the "
        "sign that (12) gives it?"
    )


def singular(ask: Ask, rng: np.random.Generator) -> None:
    """Where a turn has no influence on s2."""
    y_e, v_r = rng.uniform(-0.1, 0.1, 40), rng.uniform(0.02, 0.2, 40)
    a, c = rng.uniform(0.5, 1.5), rng.uniform(0.005, 0.02)
    x_e = numbers(ask("singular_x", y_e, v_r, a, c), (40,), "give back one x_e for each y_e (m)")
    assert (x_e < 0).all(), (
        "the denominator is 1 plus something of the sign of x_e: it can vanish only where the "
        "robot is ahead of its reference, x_e < 0"
    )
    step = SHORTLY * c / (v_r * np.abs(x_e))
    ahead, behind = (_gamma(v_r, y_e - x_e * turn, a, c) - turn for turn in (step, -step))
    change = (ahead - behind) / (2 * step)
    assert np.allclose(change, 0, atol=1e-4), (
        "at your x_e a turn still changes s2: the derivative of tanh u is 1 / cosh(u)^2"
    )


def nearest(ask: Ask, rng: np.random.Generator) -> None:
    """How far ahead of its reference the robot may be, whatever its other errors."""
    for v_top, a, c in rng.uniform((0.05, 0.5, 0.005), (0.2, 1.5, 0.02), (20, 3)):
        mine = float(
            numbers(ask("safe_ahead", v_top, a, c), (), "give back one length (m), positive")
        )
        y_e, v_r = np.meshgrid(np.linspace(-0.1, 0.1, 401), np.linspace(0.01, 1, 100) * v_top)
        assert mine > 0, "how far ahead is a length, and positive"
        # A turn changes s2 downwards everywhere: w has the same influence in sign.
        for share, works in ((0.99, True), (1.01, False)):
            there = np.full_like(y_e, -share * mine)
            slopes = [_gamma(v_r, y_e - there * turn, a, c) - turn for turn in (SHORTLY, -SHORTLY)]
            falls = ((slopes[0] - slopes[1]) < 0).all()
            assert falls == works, (
                f"up to {1000 * mine:.1f} mm ahead, says yours, the denominator stays positive for "
                f"all y_e and all V_r up to {v_top:.2f} m/s: "
                + ("but it does not" if works else "it does so farther ahead, too")
            )


@cache
def reference() -> Reference:
    """The reference of all runs: case 15(a) at 0.1 m/s."""
    world, case = load_table(1), load_cases()["15a"]
    path = plan(world, case.start, case.goal).path
    return make_reference(path, KheperaIV(), speed=0.1, smoothing=0.03, world=world)


def law(ask: Ask, rng: np.random.Generator) -> None:
    """The law, on random states and in a run."""
    low, high = (0.1, 1, 0.05, 0.2, 0.5, 0.004, 0.2), (0.3, 3, 0.2, 1, 1.5, 0.01, 0.4)
    gains = dict(zip(START_GAINS, rng.uniform(low, high).tolist(), strict=True))
    mine = Tracker(ask, "start", gains).start(reference(), KheperaIV(), TIME_STEP)
    times = [*rng.uniform(0.02, 0.2, 6), *rng.uniform(0.5, reference().duration - 0.5, 24)]
    # Where the reference drives straight, a law with and one without the floor have no turn.
    bends = reference().t[np.abs(reference().omega) > BEND]
    times.append(float(rng.choice(bends[(bends > 0.5) & (bends < reference().duration - 0.5)])))
    for t in times:
        here, ahead = reference().at(t), reference().at(t + TIME_STEP / 2)
        pose = here.pose + rng.normal(size=3) * (0.06, 0.03, 0.4)
        if t == times[-1]:
            # On the path and so far ahead that the floor counts.
            far = 1.5 * gains["c"] / (gains["A"] * ahead.v)
            pose = here.pose + far * np.array([*unit(here.pose[2]), 0.0])
        v, w = numbers(mine(t, pose), (2,), "a law gives back V and w")
        error = tracking_error(here.pose, pose)
        _assert_law(error, ahead, gains, v, w, t)
    run = simulate(
        Tracker(ask, "start", START_GAINS),
        reference(),
        None,
        TIME_STEP,
        initial_offset=(-0.02, 0.03, 0.3),
    )
    final = tracking(run)["position_final_m"]
    assert final < 0.002, f"your robot ends {1000 * final:.1f} mm from its goal; 2 mm are allowed"


def _assert_law(error: Any, ahead: Any, gains: dict[str, float], v: Any, w: Any, t: float) -> None:
    """Raise an `AssertionError` unless V and w fulfil (12), with the floor."""
    a, c = gains["A"], gains["c"]
    known = ahead.v, ahead.omega, ahead.v_dot, a, c
    rest = _rate_of_s2(error, 0.0, *known)
    slope = rest - _rate_of_s2(error, 1.0, *known)
    s2 = error[2] + _gamma(ahead.v, error[1], a, c)
    reach1 = gains["k1"] * np.clip(error[0] / gains["phi1"], -1, 1)
    reach2 = gains["k2"] * np.clip(s2 / gains["phi2"], -1, 1)
    wanted = (rest + reach2) / max(slope, gains["floor"])
    bare = (rest + reach2) / slope
    right = abs(w - wanted) < 1e-4 * max(1.0, abs(wanted))
    assert right or slope > gains["floor"] or abs(w - bare) > 1e-4 * abs(bare), (
        "your denominator goes below floor"
    )
    assert right, (
        f"at t = {t:.2f} s your w is {w:.3f} rad/s; {wanted:.3f} fulfils (12). Is the error taken "
        "from the reference now, the speeds and V_r's rate from half a step later, and sat cut "
        "off at ±1 with its own phi?"
    )
    due = error[1] * w + ahead.v * np.cos(error[2]) + reach1
    assert abs(v - due) < 1e-6, (
        f"at t = {t:.2f} s your V is {v:.4f} m/s; with your w, {due:.4f} fulfils (12)"
    )


def _measured(ask: Ask, gains: dict[str, float], seed: int) -> np.ndarray:
    """RMS position error (m) and wheel variation (m/s) of a student's law with gains."""
    offsets = OFF * np.random.default_rng(seed).uniform(-1, 1, (3, ROBOTS))
    tracker = Tracker(ask, "start", gains)
    run = simulate(tracker, reference(), None, TIME_STEP, offsets, NOISE, seed=seed)
    found = tracking(run)
    return np.array([np.mean(found[key]) for key in ("position_rms_m", "wheel_variation_m_s")])


def tuned(ask: Ask, rng: np.random.Generator) -> tuple[float, str]:
    """Gains of your law under noise."""
    gains = ask("tuned")
    assert isinstance(gains, dict), f"give back a dict of gains, with {', '.join(START_GAINS)}"
    assert set(gains) == set(START_GAINS), f"give all of {', '.join(START_GAINS)}, and no others"
    numbers(list(gains.values()), (len(START_GAINS),), "every gain is a number")
    seed = int(rng.integers(2**31))
    known = _measured(ask, START_GAINS, seed)
    assert (known > 0).all(), "your law does not drive at all: write it first"
    error, wear = _measured(ask, gains, seed) / known
    cost = error + wear
    share = float(np.clip((NO_POINTS - cost) / (NO_POINTS - ALL_POINTS), 0, 1))
    told = f"cost {cost:.2f}: {error:.2f} for the error and {wear:.2f} for the wheels"
    assert share > 0, (
        f"{told}; points begin below {NO_POINTS}. Which gains multiply the measured noise, and "
        "which do the robots need to come back?"
    )
    return share, told
