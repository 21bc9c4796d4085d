"""Time a step of the MPC beside the same problem in `Opti` with ipopt and in do-mpc.

do-mpc is no part of freeseg's environment; give it one of its own::

    pip install -r environment.txt -r tests/benchmarks/mpc.txt
    python tests/benchmarks/mpc.py            # a minute or two
    python tests/benchmarks/mpc.py --quick    # seconds, only to see that it runs

All minimise the same cost over the same model, horizon, reference and limits, and all
start from their last solution: `Mpc` and `Opti` moved on by one step, do-mpc as it does
itself. Each drives a robot of its own along the paper's case 15(a), from beside the
path. They take turns step by step, so that a slow moment of the machine hits all of
them alike. Then `Mpc` drives a robot that is late, slips and is seen through noise, told
of delay and lag, and passes seven discs that bar its way.

Times are by the clock and by the processor. On a machine that others use too, the
processor's time says more, above all of the slowest steps. Ratios are of medians.
"""

import argparse
import os
import platform
import time
import warnings
from importlib import metadata

# A step is too small to share; threads of the linear algebra would only wait for each other.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import casadi as ca
import numpy as np

import freeseg as fs
from freeseg.data import write_csv
from freeseg.path import Line
from freeseg.studies.courses import paper_courses
from freeseg.studies.tracking import DISTURBANCE
from freeseg.trackers.mpc import motion, preview

try:
    with warnings.catch_warnings():
        # Of optional parts that are not installed.
        warnings.simplefilter("ignore", UserWarning)
        import do_mpc
except ImportError:
    do_mpc = None

DT = 0.05
OFFSET = (-0.02, 0.03, np.radians(20))
STATES, INPUTS = ("x", "y", "theta", "right", "left"), ("u_right", "u_left")
#: Cost in mm^2: ipopt's tolerances are meant for numbers of about one.
SCALE = 1e6
QUIET = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False}


class ByOpti:
    """The tracker's problem in `Opti`, solved by ipopt until it converges."""

    def __init__(self, tracker):
        self.tracker = tracker

    def start(self, reference, robot, dt):
        tracker, n, opti = self.tracker, self.tracker.horizon, ca.Opti()
        z, u = opti.variable(5, n + 1), opti.variable(2, n)
        state, wanted = opti.parameter(5), opti.parameter(7, n)
        step, cost = motion(robot, dt), 0
        for k in range(n):
            factor = tracker.terminal if k == n - 1 else 1
            off = z[:3, k + 1] - wanted[2:5, k]
            cost += factor * (ca.sumsqr(off[:2]) + tracker.heading * off[2] ** 2)
            cost += tracker.acceleration * ca.sumsqr(u[:, k] - wanted[:2, k])
            opti.subject_to(z[:, k + 1] == step(z[:, k], u[:, k]))
        opti.minimize(SCALE * cost)
        opti.subject_to(z[:, 0] == state)
        opti.subject_to(opti.bounded(-robot.max_wheel_speed, z[3:, 1:], robot.max_wheel_speed))
        fastest = robot.max_wheel_acceleration
        opti.subject_to(opti.bounded(-fastest, u, fastest))
        opti.solver("ipopt", QUIET | {"expand": True, "ipopt.warm_start_init_point": "yes"})
        wheels, solution = np.zeros(2), None

        def law(t, pose):
            nonlocal wheels, solution
            opti.set_value(state, np.concatenate([pose, wheels]))
            opti.set_value(wanted, preview(reference, robot, dt, t, n).T)
            if solution is None:
                opti.set_initial(z, np.tile(np.append(pose, wheels), (n + 1, 1)).T)
            else:
                for variable in (z, u):
                    last = solution.value(variable)
                    opti.set_initial(variable, np.column_stack([last[:, 1:], last[:, -1]]))
                opti.set_initial(opti.lam_g, solution.value(opti.lam_g))
            solution = opti.solve()
            wheels = robot.saturate(solution.value(z[3:, 1]), wheels, dt)
            return robot.to_body(wheels)

        return law


class ByDoMpc:
    """The tracker's problem in do-mpc, solved by ipopt until it converges."""

    def __init__(self, tracker):
        self.tracker = tracker

    def start(self, reference, robot, dt):
        tracker, n = self.tracker, self.tracker.horizon
        model = do_mpc.model.Model("discrete", "SX")
        z = ca.vertcat(*(model.set_variable("_x", name) for name in STATES))
        u = ca.vertcat(*(model.set_variable("_u", name) for name in INPUTS))
        model.set_variable("_tvp", "wanted", (7, 1))
        after = motion(robot, dt)(z, u)
        for k, name in enumerate(STATES):
            model.set_rhs(name, after[k])
        model.setup()
        controller = do_mpc.controller.MPC(model)
        controller.settings.n_horizon = n
        controller.settings.t_step = dt
        controller.settings.store_full_solution = False
        controller.settings.nlpsol_opts = QUIET
        wanted, u = model.tvp["wanted"], ca.vertcat(*(model.u[name] for name in INPUTS))
        off = ca.vertcat(*(model.x[name] for name in STATES[:3])) - wanted[2:5]
        apart = ca.sumsqr(off[:2]) + tracker.heading * off[2] ** 2
        effort = tracker.acceleration * ca.sumsqr(u - wanted[:2])
        controller.set_objective(
            mterm=SCALE * tracker.terminal * apart, lterm=SCALE * (apart + effort)
        )
        controller.set_rterm(**dict.fromkeys(INPUTS, 0.0))
        for side in ("lower", "upper"):
            sign = 1 if side == "upper" else -1
            for name in ("right", "left"):
                controller.bounds[side, "_x", name] = sign * robot.max_wheel_speed
                controller.bounds[side, "_u", f"u_{name}"] = sign * robot.max_wheel_acceleration
        template = controller.get_tvp_template()

        def read(t):
            # Here, u of a row goes with the z that it starts from: that of the row before.
            rows = preview(reference, robot, dt, round(np.squeeze(t) / dt) * dt - dt, n + 2)
            rows = np.concatenate([rows[1:, :2], rows[:-1, 2:]], axis=1)
            for k in range(n + 1):
                template["_tvp", k, "wanted"] = rows[k]
            return template

        controller.set_tvp_fun(read)
        controller.setup()
        wheels, first = np.zeros(2), True

        def law(t, pose):
            nonlocal wheels, first
            state = np.append(pose, wheels)
            if first:
                controller.x0, first = state, False
                controller.set_initial_guess()
            u = controller.make_step(state[:, None]).ravel()
            wheels = robot.saturate(wheels + dt * u, wheels, dt)
            return robot.to_body(wheels)

        return law


def drive(trackers, reference, robot, offset, seconds=np.inf):
    """Drive one robot with each tracker, in turns, for some seconds or to the end.

    Returns
    -------
    dict
        By name: poses, shape (3, steps), and times of the laws by the clock
        and by the processor (s), shape (2, steps).
    """
    laws = {name: tracker.start(reference, robot, DT) for name, tracker in trackers.items()}
    x, y, theta = reference.pose[:, 0]
    ahead, left, turned = offset
    cos, sin = np.cos(theta), np.sin(theta)
    begin = np.array([x + ahead * cos - left * sin, y + ahead * sin + left * cos, theta + turned])
    poses, times = {name: [begin] for name in laws}, {name: [] for name in laws}
    steps, order = reference.steps(DT)[:-1], list(laws)
    for number, t in enumerate(steps[steps < seconds]):
        # Each is first in turn.
        for name in order[number % len(order) :] + order[: number % len(order)]:
            since = time.perf_counter(), time.process_time()
            command = laws[name](t, poses[name][-1])
            until = time.perf_counter(), time.process_time()
            times[name].append(np.subtract(until, since))
            wheels = robot.to_wheels(*command)
            poses[name].append(robot.move(poses[name][-1], wheels, DT))
    return {name: (np.transpose(poses[name]), np.transpose(times[name])) for name in laws}


def row_of(runs):
    """Times (ms) by the clock and by the processor: first step, then median and 99th percentile."""
    first = np.median([times[:, 0] for times in runs], axis=0)
    later = np.concatenate([times[:, 1:] for times in runs], axis=1)
    values = [*np.quantile(later, 0.5, axis=1), *np.quantile(later, 0.99, axis=1), first[1]]
    keys = "median_ms", "median_cpu_ms", "p99_ms", "p99_cpu_ms", "first_cpu_ms"
    return {key: 1e3 * value for key, value in zip(keys, values, strict=True)}


def on_the_papers_path(robot, repeats, seconds):
    """Rows of the trackers without discs."""
    case = fs.load_cases()["15a"]
    world = fs.load_table(case.table)
    plan = fs.plan(world, case.start, case.goal, robot)
    reference = fs.make_reference(plan.path, robot, smoothing=0.03, world=world)
    mpc = fs.Mpc()
    trackers = {"Mpc": mpc, "Mpc with piqp": fs.Mpc(solver="piqp"), "Opti with ipopt": ByOpti(mpc)}
    if do_mpc:
        trackers["do-mpc with ipopt"] = ByDoMpc(mpc)
    results = [drive(trackers, reference, robot, OFFSET, seconds) for _ in range(repeats)]
    rows = []
    for name in trackers:
        poses = results[0][name][0]
        wanted = reference.at(DT * np.arange(poses.shape[1])).pose
        error = fs.tracking_error(wanted, poses)
        row = row_of([result[name][1] for result in results])
        rows.append(
            {"problem": "15(a)", "tracker": name}
            | row
            | {"cross_track_rms_mm": 1e3 * np.sqrt((error[1] ** 2).mean()), "violation_mm": ""}
        )
    return rows


class Timed:
    """A tracker whose law's times by the clock and by the processor (s) are kept."""

    def __init__(self, tracker):
        self.tracker, self.times = tracker, []

    def start(self, reference, robot, dt):
        law = self.tracker.start(reference, robot, dt)

        def timed(t, pose):
            since = time.perf_counter(), time.process_time()
            command = law(t, pose)
            until = time.perf_counter(), time.process_time()
            self.times.append(np.subtract(until, since))
            return command

        return timed


def told_of_what_disturbs(robot, repeats):
    """Row of `Mpc` with prediction and observer, on the course and with what trackers meet."""
    reference, runs = paper_courses()[0].reference, []
    tracker = fs.Mpc(delay=DISTURBANCE.delay, lag=DISTURBANCE.lag, observer=3)
    for seed in range(repeats):
        timed = Timed(tracker)
        run = fs.simulate(timed, reference, robot, DT, OFFSET, DISTURBANCE, seed)
        runs.append(np.transpose(timed.times))
    error = 1e3 * np.sqrt((run.error[1] ** 2).mean())
    row = {"problem": "disturbed", "tracker": "Mpc, told"} | row_of(runs)
    return row | {"cross_track_rms_mm": error, "violation_mm": ""}


def past_discs(robot, repeats):
    """Row of `Mpc` past seven discs, all of which bar the straight way by 15 mm."""
    radius, depth = 0.03, 0.015
    beside = robot.radius + radius - depth
    world = fs.World([fs.Disc((0.3 + 0.1 * k, beside), radius) for k in range(7)])
    reference = fs.make_reference(fs.Path([Line((0, 0), (1.5, 0))]), robot, 0.5, 1.0)
    trackers = {"Mpc": fs.Mpc(obstacles=world)}
    results = [drive(trackers, reference, robot, (0, 0, 0)) for _ in range(repeats)]
    poses = results[0]["Mpc"][0]
    # How deep the robot enters each disc; where it does not, it must touch: the disc is active.
    centers = np.array([disc.center for disc in world.obstacles])
    apart = np.linalg.norm(poses[:2].T[:, None] - centers, axis=-1) - radius - robot.radius
    active = int((apart.min(0) < 1e-3).sum())
    error = fs.tracking_error(reference.at(DT * np.arange(poses.shape[1])).pose, poses)
    row = row_of([result["Mpc"][1] for result in results])
    return (
        {"problem": f"{active} active discs", "tracker": "Mpc"}
        | row
        | {
            "cross_track_rms_mm": 1e3 * np.sqrt((error[1] ** 2).mean()),
            "violation_mm": 1e3 * max(0.0, -apart.min()),
        }
    )


def show(rows):
    """Print the table, and how `Mpc` compares."""
    numbers = [key for key in rows[0] if key not in ("problem", "tracker")]
    print(f"{'':32s}" + "".join(f"{key:>20s}" for key in numbers))
    for row in rows:
        values = "".join(
            f"{row[key] if row[key] == '' else f'{row[key]:.4f}':>20}" for key in numbers
        )
        print(f"{row['problem']:16s}{row['tracker']:16s}{values}")
    own, *others = [row for row in rows if row["problem"] == rows[0]["problem"]]
    for row in others:
        ratio, by_cpu = (row[key] / own[key] for key in ("median_ms", "median_cpu_ms"))
        error = 100 * abs(own["cross_track_rms_mm"] / row["cross_track_rms_mm"] - 1)
        print(
            f"{row['tracker']} over Mpc: {ratio:.1f} times by the clock, {by_cpu:.1f} by the "
            f"processor; cross-track RMS differs by {error:.2f} %"
        )
    print(f"Python {platform.python_version()} on {platform.machine()}")
    for package in ("casadi", "do-mpc", "numpy"):
        try:
            print(package, metadata.version(package))
        except metadata.PackageNotFoundError:
            print(package, "not installed")


def main(arguments=None):
    """Run the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeats", type=int, default=5, help="runs of each")
    parser.add_argument("--quick", action="store_true", help="one run of each, a short one")
    parser.add_argument("--csv", metavar="FILE", help="write the table there, too")
    options = parser.parse_args(arguments)
    robot, repeats = fs.KheperaIV(), 1 if options.quick else options.repeats
    seconds = 2.0 if options.quick else np.inf
    # The run past the discs is short: more of them, for the slowest steps.
    rows = on_the_papers_path(robot, repeats, seconds)
    rows += [told_of_what_disturbs(robot, repeats), past_discs(robot, 4 * repeats)]
    show(rows)
    if options.csv:
        write_csv(
            options.csv,
            [
                {key: f"{v:.4f}" if isinstance(v, float) else v for key, v in row.items()}
                for row in rows
            ],
        )


if __name__ == "__main__":
    main()
