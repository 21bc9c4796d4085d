"""Time the exact-arc loop beside python-control's: ``python tests/benchmarks/loops.py``.

Both drive the PID tracker along the path of Fig. 15(a), its curvature in ramps,
a robot without limits, from on and from beside the path. Prints medians of
interleaved runs, errors, and for two questions how many times faster `simulate`
answers as accurately:

* Each command is held for a time step, which is how a robot's computer works
  and what the studies ask. `simulate` solves that exactly, by arcs;
  `input_output_response` integrates one hold a call, for a system with a hold
  in its loop is not one of its kind.
* The command follows the error in continuous time. `input_output_response`
  integrates that in one call, and `simulate` comes near with a small time
  step. Each has a list of settings; the fastest that is accurate enough
  counts.
"""

import statistics
import time
from functools import partial

import control as ct
import numpy as np

import freeseg as fs
from freeseg.reference import SMOOTHING

POSE = ["x", "y", "theta"]
WANTED = ["x_r", "y_r", "theta_r", "v_r", "omega_r"]
STARTS = {"on the path": (0, 0, 0), "beside it": (-0.02, 0.03, np.radians(20))}  # m, m, rad
HOLD = 0.05  # s
#: Time steps of the exact-arc loop (s).
STEPS = (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
#: Settings of input_output_response: grid of the inputs (s), method, tolerance; None for defaults.
SETTINGS = [
    (grid, method, tolerance)
    for grid in (0.05, 0.02, 0.01, 0.005)
    for method in ("RK45", "LSODA")
    for tolerance in (None, 1e-4, 1e-5)
]
BOUNDS_MM = (1, 0.1, 0.03)


def plant():
    """Model (1): pose from forward speed and turn rate."""

    def rates(t, pose, u, params):
        return np.array([u[0] * np.cos(pose[2]), u[0] * np.sin(pose[2]), u[1]])

    return ct.nlsys(rates, None, states=POSE, inputs=["v", "omega"], outputs=POSE, name="robot")


def closed_loop(pid):
    """Plant and PID in continuous time, with the reference as input."""

    def sums(t, integrals, u, params):
        x_e, y_e, _ = fs.tracking_error(u[3:6], u[:3])
        return np.array([x_e, abs(u[6]) * y_e])

    def command(t, integrals, u, params):
        v, omega, _ = pid.command(fs.tracking_error(u[3:6], u[:3]), integrals, *u[6:])
        return np.array([v, omega])

    law = ct.nlsys(
        sums, command, states=2, inputs=POSE + WANTED, outputs=["v", "omega"], name="pid"
    )
    return ct.interconnect([plant(), law], inputs=WANTED, outputs=POSE)


def hold_by_hold(pid, reference, robot, start):
    """Pose at each time step, integrated from each to the next."""
    model, law = plant(), pid.start(reference, robot, HOLD)
    sent, poses = np.zeros(2), [start]
    for t in reference.steps(HOLD)[:-1]:
        sent = robot.saturate(robot.to_wheels(*law(t, poses[-1])), sent, HOLD)
        held = np.repeat(np.transpose([robot.to_body(sent)]), 2, axis=1)
        answer = ct.input_output_response(model, [t, t + HOLD], held, poses[-1], return_states=True)
        poses.append(answer.states[:, -1])
    return np.transpose(poses)


def integrate(loop, reference, start, grid, method, tolerance):
    """Times and poses of the continuous loop."""
    t = np.linspace(0, reference.duration, round(reference.duration / grid) + 1)
    wanted = reference.at(t)
    strict = {} if tolerance is None else {"rtol": tolerance, "atol": tolerance / 1000}
    answer = ct.input_output_response(
        loop,
        t,
        [*wanted.pose, wanted.v, wanted.omega],
        [*start, 0, 0],
        solve_ivp_method=method,
        solve_ivp_kwargs=strict,
    )
    return t, answer.outputs


def medians(actions, repeats):
    """Median time of each of some named actions (s), interleaved, and what they return."""
    times, answers = {name: [] for name in actions}, {}
    for _ in range(repeats):
        for name, action in actions.items():
            begin = time.perf_counter()
            answers[name] = action()
            times[name].append(time.perf_counter() - begin)
    return {name: statistics.median(values) for name, values in times.items()}, answers


def largest_error_mm(t, pose, truth):
    """Largest distance from the true solution (mm); up to the last time of the reference."""
    true_t, true_pose = truth
    there = t <= true_t[-1]
    apart = [pose[k, there] - np.interp(t[there], true_t, true_pose[k]) for k in (0, 1)]
    return 1000 * np.hypot(*apart).max()


def main(reference=None, robots=1000, repeats=5, settings=SETTINGS):
    """Print times, errors and ratios."""
    if reference is None:
        case, world = fs.load_cases()["15a"], fs.load_table(1)
        path = fs.plan(world, case.start, case.goal).path
        reference = fs.make_reference(path, smoothing=SMOOTHING, world=world)
    pid, robot = fs.Pid(), fs.KheperaIV(max_wheel_rate=1e9, max_wheel_rate_change=1e9)
    loop = closed_loop(pid)
    for place, offset in STARTS.items():

        def drive(dt, offset=offset):
            run = fs.simulate(pid, reference, robot, dt, offset)
            return run.t, run.pose

        start = drive(HOLD)[1][:, 0]
        print(f"\nfrom {place}, commands held for {1000 * HOLD:.0f} ms")
        offsets = np.repeat(np.transpose([offset]), robots, axis=1)
        actions = {
            "input_output_response, a call a hold": partial(
                hold_by_hold, pid, reference, robot, start
            ),
            "simulate": lambda: drive(HOLD),
            f"simulate, {robots} at once": lambda offsets=offsets: drive(HOLD, offsets),
        }
        times, answers = medians(actions, repeats)
        slow, single, batch = times
        times[batch] /= robots
        apart = 1000 * np.abs(answers[slow] - answers[single][1])[:2].max()
        for name, value in times.items():
            ratio = times[slow] / value
            print(f"{name:38s} {1e3 * value:9.3f} ms a robot, ratio {ratio:8.1f}")
        print(f"they differ by at most {apart:.1e} mm")

        print(f"from {place}, in continuous time")
        truth = integrate(loop, reference, start, reference.t[1], "LSODA", 1e-9)
        arcs = {f"simulate, step {1000 * dt:g} ms": lambda dt=dt: drive(dt) for dt in STEPS}
        calls = {}
        for grid, method, tolerance in settings:
            name = f"input_output_response, inputs each {1000 * grid:g} ms, {method}, "
            calls[name + f"tolerance {tolerance or 'default'}"] = partial(
                integrate, loop, reference, start, grid, method, tolerance
            )
        times, answers = medians(arcs | calls, repeats)
        errors = {name: largest_error_mm(*answer, truth) for name, answer in answers.items()}
        for name, value in times.items():
            print(f"{name:72s} {1e3 * value:9.1f} ms, error {errors[name]:8.4f} mm")
        for bound in BOUNDS_MM:
            best = []
            for group in (calls, arcs):
                good = [name for name in group if errors[name] <= bound]
                best.append(min(good, key=times.get) if good else None)
            if None not in best:
                ratio = times[best[0]] / times[best[1]]
                print(f"within {bound:g} mm: ratio {ratio:.1f} ({best[0]} over {best[1]})")


if __name__ == "__main__":
    main()
