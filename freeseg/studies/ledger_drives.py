"""Drives that the ledger makes again: a law that switches, sensors that mislead, errors that stay.

They are quick, so that none of them is stored; notebook 12 shows `switch`, too.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from freeseg.disturbance import Disturbance
from freeseg.path import Line, Path
from freeseg.reference import SPEED, Reference, make_reference
from freeseg.robot import Robot
from freeseg.simulate import simulate
from freeseg.studies import comparing, courses, tracking, tuning
from freeseg.trackers import Pid, SlidingMode
from freeseg.trackers.feedback import Law, Tracker, watch

#: Rates (m/s, rad/s) near the best that notebook 08 finds for a law that switches.
SWITCHING_RATES = {"k1": 0.01, "k2": 0.1}

#: Time for which a command is held (s), and the delay before (s), from hardly any on.
LATENESS = tuple((hold, delay) for hold in (0.01, 0.05) for delay in (0.0, 0.05))

#: By how much noise is multiplied, and factors by which a sensor reads too much.
NOISE_TIMES, TOO_MUCH = 8.0, np.arange(2, 17) / 2

#: Of a straight course, the time (s) after which its beginning is forgotten.
FORGOTTEN = 5.0


def _straight(length: float) -> Reference:
    return make_reference(Path([Line((0, 0), (length, 0))]), speed=SPEED)


def _tuned() -> dict[str, SlidingMode]:
    law = tuning.load_gains()["SlidingMode"][0].tracker
    return {"sat": law, "sign": replace(law, switching="sign", **SWITCHING_RATES)}


def switch() -> dict[tuple[str, float], np.ndarray]:
    """Roughness of runs with sat and with sign, without and with the usual delay.

    Returns
    -------
    dict
        (``"sat"`` or ``"sign"``, delay in s) to ndarray of 16 runs (m/s^2).
    """
    some = courses.random_courses(2, comparing.JUDGED["seed"])
    few = courses.spread_offsets(8, seed=1)
    return {
        (name, delay): tracking.evaluate(law, some, few, 1, Disturbance(delay=delay))[
            "roughness_m_s2"
        ].ravel()
        for name, law in _tuned().items()
        for delay in (0.0, tracking.DISTURBANCE.delay)
    }


def swing() -> dict[tuple[str, float, float], float]:
    """How far the heading swings on a straight line, where nothing but the law moves it.

    Returns
    -------
    dict
        (``"sat"`` or ``"sign"``, hold in s, delay in s) to the standard deviation of the
        heading's error (rad), once the start is forgotten.
    """
    line = _straight(0.9)
    found = {}
    for name, law in _tuned().items():
        for hold, delay in LATENESS:
            run: Any = simulate(
                law, line, None, hold, (-0.002, 0.002, 0.02), Disturbance(delay=delay)
            )
            late = (run.t > FORGOTTEN) & (run.t < line.duration - 1)
            found[name, hold, delay] = float(run.error[2][late].std())
    return found


class Misread:
    """A tracker that takes y and the heading, measured from the line, for a multiple of them."""

    def __init__(self, tracker: Tracker, factors: np.ndarray) -> None:
        self.tracker, self.factors = tracker, factors

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The tracker's own law, for the poses that it believes."""
        law, one = self.tracker.start(reference, robot, dt), np.ones_like(self.factors)
        return lambda t, pose: law(t, pose * [one, self.factors, self.factors])


class Differenced:
    """A PID whose derivative is the difference of the last two errors, as notebook 10 has it."""

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The PID's law, with the heading's part of D replaced."""
        gains = Pid()
        law, see, seen = gains.start(reference, robot, dt), watch(reference, dt), []

        def differenced(t: float, pose: np.ndarray) -> tuple[Any, Any]:
            v, w = law(t, pose)
            (_, y_e, alpha_e), look = see(t, pose)
            seen.append(y_e)
            change = (y_e - seen[-2]) / dt if len(seen) > 1 else 0
            return v, w + gains.kd_y * (change - look.v * np.sin(alpha_e))

        return differenced


def mislead() -> dict[str, dict[str, np.ndarray]]:
    """What becomes of laws on a straight line whose sensors are noisy, or read too much.

    Returns
    -------
    dict
        ``"noise"``: name of the law to the RMS of y_e (m) at the usual noise and at
        `NOISE_TIMES` as much. ``"gain"``: name to the largest y_e (m) in the second half of
        the run, for each of `TOO_MUCH`, after a start 1 mm beside the line.
    """
    late = Disturbance(lag=tracking.DISTURBANCE.lag, delay=tracking.DISTURBANCE.delay)
    noisy, line = ("position_noise", "heading_noise"), _straight(2.5)
    careful: dict[str, Tracker] = {"PID": Pid(), "sliding mode": SlidingMode()}
    start = np.zeros((3, len(TOO_MUCH)))
    noise = {}
    for name, law in {**careful, "PID, D by differences": Differenced()}.items():
        rms = []
        for times in (1, NOISE_TIMES):
            how = {one: times * getattr(tracking.DISTURBANCE, one) for one in noisy}
            run: Any = simulate(
                law, line, None, courses.DT, np.zeros((3, 20)), replace(late, **how)
            )
            rms.append(np.sqrt((run.error[1][:, run.t > FORGOTTEN] ** 2).mean()))
        noise[name] = np.array(rms)
    start[1] = 1e-3
    gain = {}
    for name, law in careful.items():
        run = simulate(Misread(law, TOO_MUCH), line, None, courses.DT, start, late)
        gain[name] = np.abs(run.error[1][:, run.t > line.duration / 2]).max(1)
    return {"noise": noise, "gain": gain}


def leave_rest() -> dict[str, dict[str, np.ndarray]]:
    """Errors of robots that begin on their reference, disturbed as usual and not at all.

    Returns
    -------
    dict
        Name of each law that drives robots in one batch to ``"disturbed"``, RMS of the
        position error (m) of 8 runs with all that a law can be told; and ``"calm"``, of 8
        plain ones.
    """
    some, begun = courses.random_courses(1, comparing.JUDGED["seed"]), np.zeros((3, 8))
    forms = {"disturbed": ("observed", tracking.DISTURBANCE), "calm": ("plain", Disturbance())}
    found: dict[str, dict[str, np.ndarray]] = {}
    for kind, (form, how) in forms.items():
        for name, tuned in tuning.load_gains(form=form).items():
            if name not in tracking.SINGLE:
                runs = tracking.evaluate(tuned[0].tracker, some, begun, 1, how)
                law = found.setdefault(comparing.LAWS[name], {})
                law[kind] = runs["position_rms_m"].ravel()
    return found
