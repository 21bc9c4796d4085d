"""Model predictive control: a quadratic programme every time step."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from freeseg import checks
from freeseg.errors import InvalidParameter, SolverFailed
from freeseg.geometry import wrap_angle
from freeseg.reference import Reference
from freeseg.robot import Robot, body_velocity, reached_speeds, wheel_speeds
from freeseg.scene import Scene, check_scene
from freeseg.trackers.feedback import Law, check_gains
from freeseg.trackers.predictor import Predictor, SlipObserver
from freeseg.world import Disc, World

#: What qrqp would print.
QUIET = "print_header", "print_iter", "print_info"

#: To what piqp solves: with its own, wheel speeds would be off by tenths of a mm/s.
TOLERANCES = {"eps_abs": 1e-10, "eps_rel": 1e-11} | {
    "eps_duality_gap_abs": 1e-10,
    "eps_duality_gap_rel": 1e-11,
}

#: Solvers of the quadratic programme, and their options for at most so many iterations.
SOLVERS = {
    "piqp": lambda most: {"piqp": {"max_iter": most} | TOLERANCES},
    "qrqp": lambda most: {"max_iter": most} | dict.fromkeys(QUIET, False),
}

#: Programmes at the first step, where there is no prediction to linearise about.
FIRST_PROGRAMMES = 5

#: Longer programmes take longer than any time step.
LONGEST_HORIZON = 1000

#: Beside a larger weight, the others would be lost in round-off.
LARGEST_WEIGHT = 1e6

#: Solver of a programme in which the other one failed.
RESCUE = "piqp"

#: By how much a plan may break a constraint (m, m/s, m/s^2), and so much of its largest value more:
#: ten times what either solver leaves.
LEEWAY, LEEWAY_SHARE = 1e-7, 1e-10

#: What a failed solve may lead to.
ON_FAILURE = ("raise", "brake")


@dataclass(frozen=True)
class Mpc:
    """Tracker that looks ahead: a real-time iteration of model predictive control.

    Every time step, it predicts the robot over the horizon, weighs what
    differs from the reference, and commands the first step of the best
    prediction within the limits of the wheels. A prediction costs the sum,
    over its steps, of the squared distance from the reference (m^2) and of
    what the weights add. The paper has no such tracker: every default is an
    assumption.

    Parameters
    ----------
    horizon : int
        How many time steps N it looks ahead.
    heading : float
        Weight of a squared difference of the headings (m^2/rad^2).
    acceleration : float
        Weight of a wheel's squared acceleration beyond the reference's (s^4).
    terminal : float
        Factor on what distance and heading cost at the last step.
    obstacles : World, Scene or callable, optional
        Discs that the robot is to keep out of, or none. Of a scene, at each
        step where its movers then are. What is known of movers only while driving is a
        function: ``obstacles(t)`` gives a scene as it is foreseen from the time t
        (s) on, which is its time zero, always of as many obstacles.
    nearest : int
        How many of them a programme knows: those nearest to the prediction.
    keep_out : float
        Weight of the depth by which the robot enters a disc (m). A disc is
        entered only where nothing else is possible, as long as this is more than
        what pulls the robot in: at most twice its distance from the reference,
        summed as above.
    solver : {"qrqp", "piqp"}, optional
        Solver of the programme: an active-set method, the faster one while
        few bounds change, or an interior-point method, whose time hardly
        varies. By default the first, with obstacles the second.
    iterations : int
        Most iterations of the solver at a time step.
    on_failure : {"raise", "brake"}
        Whether a failed solve raises, or warns and brakes as hard as the
        wheels can. A solve has failed where, after the solver, ``"piqp"``
        fails too, from a standstill. A plan that breaks the model or a limit
        is a failure, whatever the solver calls it.
    delay, lag : float
        What it is told of the robot (s): after which time a command reaches
        the motors, a whole number of time steps, and their time constant.
    observer : float
        Rate (1/s) at which estimates of the pose and of the wheels' slip
        follow what is measured, see `predictor.SlipObserver`; 2 to 5 suit the
        noise and the slip that the trackers are compared under. With zero,
        poses are taken as measured, and wheels not to slip.

    Raises
    ------
    InvalidParameter
        For a weight, a delay, a lag or a rate that is negative or not finite
        (the weight of accelerations has to be positive), a count that is not a
        whole positive one, another solver, or obstacles that are no discs.

    Notes
    -----
    The state is z = (x, y, theta, V_R, V_L), the input u the wheels'
    accelerations, so that both limits of a wheel are bounds. The model is
    the exact arc of `Robot.move`. With the prediction of the step
    before, moved on by one step, as the point of linearisation, one
    Gauss-Newton step remains: a sparse quadratic programme [1]_. A disc is
    replaced by the half plane beyond its tangent that faces the predicted
    position, which holds no point of the disc.

    What it is told of delay and lag is in its prediction: it plans from where
    the commands under way will have taken the robot, see `Predicting`. What
    slip takes off the wheels' travel is estimated, and in the model, so that a
    constant slip leaves no error (offset-free control [2]_).

    Weights of accelerations down to 1e-6 follow undisturbed references more
    closely. But untold of the delay and lag that the trackers are compared
    under (50 ms and 30 ms, `studies.tracking.DISTURBANCE`), the loop is
    unstable there; with the default it is stable, told or not.

    References
    ----------
    .. [1] M. Diehl, H. G. Bock, J. P. Schlöder, "A real-time iteration scheme
       for nonlinear optimization in optimal feedback control", SIAM J.
       Control Optim. 43(5), 2005.
    .. [2] G. Pannocchia, J. B. Rawlings, "Disturbance models for offset-free
       model-predictive control", AIChE Journal 49(2), 2003.
    """

    horizon: int = 20
    heading: float = 3e-4
    acceleration: float = 1e-4
    terminal: float = 10.0
    obstacles: World | Scene | Callable[[float], Scene] | None = None
    nearest: int = 7
    keep_out: float = 100.0
    solver: str | None = None
    iterations: int = 200
    on_failure: str = "raise"
    delay: float = 0.0
    lag: float = 0.0
    observer: float = 0.0

    def __post_init__(self):
        check_gains(self, "heading", "terminal", "keep_out", "delay", "lag", "observer")
        for weight in ("heading", "acceleration", "terminal", "keep_out"):
            if getattr(self, weight) > LARGEST_WEIGHT:
                raise InvalidParameter(
                    f"{weight} is {getattr(self, weight):g}; the solvers compute with up to "
                    f"{LARGEST_WEIGHT:g}"
                )
        for name in ("horizon", "nearest", "iterations"):
            object.__setattr__(self, name, checks.whole(name, getattr(self, name), 1))
        if self.horizon > LONGEST_HORIZON:
            raise InvalidParameter(f"horizon is {self.horizon}; give at most {LONGEST_HORIZON}")
        if isinstance(self.obstacles, World | Scene):
            _check_discs(check_scene(self.obstacles))
        elif self.obstacles is not None and (
            not callable(self.obstacles) or isinstance(self.obstacles, type)
        ):
            checks.instance("obstacles", self.obstacles, World, "a World of discs, or a Scene")
        if self.solver is not None:
            checks.choice("solver", self.solver, SOLVERS)
        checks.choice("on_failure", self.on_failure, ON_FAILURE)

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`; the robot's limits are kept.

        Returns
        -------
        Law
            For a pose of shape (3,), to be called every `dt`: it assumes that the
            motors do what it commanded, for a pose says nothing of their speeds.

        Raises
        ------
        InvalidParameter
            For a time step that is not positive, and a delay that is not a
            whole number of them or longer than the reference; from the law,
            for a pose that is not three finite numbers: it drives one robot.
        SolverFailed
            From the law, where the solver gives up and it is not to brake.
        """
        predictor = Predictor(self.delay, self.lag, reference, robot, dt)
        robot, dt = predictor.robot, predictor.dt
        observer = SlipObserver(self.observer, robot, dt)
        foresee = _foresight(self.obstacles, robot, predictor.ahead, dt, self.horizon)
        programme = _Programme(self, robot, dt, foresee(0.0))
        look_ahead = _previewer(reference, robot, dt, self.horizon, predictor.ahead)

        def law(t, pose):
            now = observer.correct(_one_pose(pose), predictor.driven)
            (x, y, theta), wanted = predictor.look(now, observer.rolled), look_ahead(t)
            # Headings are counted on from the prediction's, or the reference's.
            expected = (programme.best if programme.solved else wanted)[0, 4]
            theta = expected + wrap_angle(theta - expected)
            programme.circles = foresee(t)
            programme.set_objective(wanted)
            programme.set_state((x, y, theta), predictor.motors.asked, observer.rolled)
            status = programme.solve()
            if not programme.solved:
                self._give_up(programme.asked, t, status)
            target = programme.best[0, 5:7] if programme.solved else (0, 0)
            wheels = reached_speeds(robot, target, predictor.motors.asked, dt)
            predictor.send(*body_velocity(robot, wheels))
            return body_velocity(robot, wheels)

        return law

    def _give_up(self, asked, t, status):
        """Raise, or warn that the robot brakes."""
        message = f"{asked} found no command at {t:.3f} s: {status}"
        if self.on_failure == "raise":
            remedy = "allow more iterations, choose another solver, or brake with"
            raise SolverFailed(f"{message}; {remedy} on_failure='brake'", t, status)
        # Of the law's caller.
        warnings.warn(f"{message}; braking", RuntimeWarning, stacklevel=3)


class _Programme:
    """The quadratic programme of a time step, in arrays that the solver reads and writes.

    A row of a plan is a time step: u, the z that it leads to and, with discs, the slack.
    """

    def __init__(self, tracker, robot, dt, circles):
        self.circles = circles
        self.discs = min(tracker.nearest, circles.shape[1])
        n, rows = tracker.horizon, (tracker.horizon, 5 + self.discs)
        # Variables: the plan linearised about, where the robot is and what is near, the best plan.
        shape = n, 8 if self.discs else 7
        self.plan, self.best, self.solved = np.zeros(shape), np.zeros(shape), False
        self.state, self.near = np.zeros(5), circles[:, : self.discs].copy()
        self.rolled = np.ones(2)
        # Objective: squares, and a gradient, of which only the slack's stays through a run.
        self.weights, self.gradient = _weights(tracker, shape), np.full(shape, tracker.keep_out)
        # Constraints: model and discs are linear about the plan; the wheels' limits are bounds.
        linearised = linearisation(motion(robot, dt), n, self.discs)
        sparsity = linearised.sparsity_out("a")
        a, lower, upper = np.zeros(sparsity.nnz()), np.zeros(rows), np.zeros(rows)
        least, most = _bounds(robot, shape)
        # Initial guess: of the multipliers too, of bounds (x) and constraints (a).
        self.lam_x0, self.lam_a0 = np.zeros(shape), np.zeros(rows)
        self.lam_x, self.lam_a = np.zeros(shape), np.zeros(rows)
        # Solve: both functions are bound to the arrays once, and then called without arguments.
        self.solver = tracker.solver or ("piqp" if self.discs else "qrqp")
        self.iterations = tracker.iterations
        self.structure = {"h": ca.Sparsity.diag(self.weights.size), "a": sparsity}
        about = {"plan": self.plan, "state": self.state, "near": self.near, "rolled": self.rolled}
        self.linearise = _bind(linearised, **about, a=a, lower=lower, upper=upper)
        objective = {"h": 2 * self.weights, "g": self.gradient}
        limits = {"a": a, "lba": lower, "uba": upper, "lbx": least, "ubx": most}
        guess = {"x0": self.plan, "lam_x0": self.lam_x0, "lam_a0": self.lam_a0}
        found = {"x": self.best, "lam_x": self.lam_x, "lam_a": self.lam_a}
        self.arrays = objective | limits | guess | found
        self.optimise = self._optimiser(self.solver)
        self.broken = np.zeros(1)
        self.count_broken = _bind(
            _constraints_broken(sparsity), **limits, x=self.best, broken=self.broken
        )

    def _optimiser(self, solver):
        """One of the solvers, bound to the arrays."""
        options = {"error_on_fail": False} | SOLVERS[solver](self.iterations)
        return _bind(ca.conic("programme", solver, self.structure, options), **self.arrays)

    @cached_property
    def rescue(self):
        """The solver that is asked where the other one fails, made when first needed."""
        return self.optimise if self.solver == RESCUE else self._optimiser(RESCUE)

    def set_objective(self, wanted):
        """Weigh what differs from the reference's rows of u and z, see `preview`."""
        self.gradient[:, :7] = -2 * self.weights[:, :7] * wanted

    def set_state(self, pose, wheels, rolled):
        """Let plans begin at a pose with wheel speeds (m/s), of which a share moves the robot."""
        self.state[:] = *pose, *wheels
        self.rolled[:] = rolled

    def solve(self):
        """Find the best plan; what the solver says of it.

        Standing still is a plan, so there is one: where the solver finds none, the
        same programme is solved again from there, by an interior-point method.
        """
        was_cold, self.asked = not self.solved, self.solver
        status = self._solve(self.optimise)
        # The rescue from a standstill, unless it is just what has failed.
        if not self.solved and not (was_cold and self.solver == RESCUE):
            self.asked = " and ".join(dict.fromkeys([self.solver, RESCUE]))
            status = self._solve(self.rescue)
            # Those of an interior-point method mislead one that looks for active bounds.
            self.lam_x[:] = self.lam_a[:] = 0
        return status

    def _solve(self, optimise):
        """Find the best plan by a solver, from the last prediction if there is one."""
        if self.solved:
            self._guess_from_prediction()
            programmes = 1
        else:
            self._guess_standing_still()
            programmes = FIRST_PROGRAMMES
        for _ in range(programmes):
            self._choose_discs()
            self.linearise()
            told = optimise().stats()
            self.solved, status = told["success"], told["return_status"]
            self.count_broken()
            # Thrown from bound to bound, qrqp calls plans a success that break them by far.
            if self.solved and self.broken[0]:
                self.solved, status = False, f"its plan breaks {self.broken[0]:.0f} constraints"
            if not self.solved:
                break
            self.plan[:] = self.best
        return status

    def _guess_from_prediction(self):
        """Move the best plan, and its multipliers, on by one step."""
        pairs = (self.plan, self.best), (self.lam_x0, self.lam_x), (self.lam_a0, self.lam_a)
        for now, last in pairs:
            now[:-1], now[-1] = last[1:], last[-1]

    def _guess_standing_still(self):
        """Without a prediction, stand still: a plan that enters no disc."""
        self.plan[:, :7] = 0, 0, *self.state[:3], 0, 0
        self.lam_x0[:] = self.lam_a0[:] = 0

    def _choose_discs(self):
        """Keep out of the discs nearest to the plan."""
        nearest = slice(None)
        if self.discs < self.circles.shape[1]:
            apart = np.linalg.norm(self.plan[:, None, 2:4] - self.circles[..., :2], axis=-1)
            clearance = (apart - self.circles[..., 2]).min(0)
            nearest = np.argpartition(clearance, self.discs)[: self.discs]
        self.near[:] = self.circles[:, nearest]


def _check_discs(scene):
    """`scene`; `InvalidParameter` unless all of its obstacles are discs."""
    movers = [mover.obstacle for mover in scene.movers]
    for index, obstacle in enumerate([*scene.world, *movers]):
        if not isinstance(obstacle, Disc):
            name = scene.name_of(index)
            raise InvalidParameter(
                f"{name} is a {type(obstacle).__name__}, and the MPC keeps out of discs only; "
                "give a disc round it"
            )
    return scene


def _foresight(obstacles, robot, ahead, dt, horizon):
    """``foresee(t)``: centres and radii (m) to keep out of at each step, (horizon, n, 3)."""
    later = ahead + dt * np.arange(1, horizon + 1)
    if callable(obstacles):
        return lambda t: _circles(_check_discs(check_scene(obstacles(t))), robot, later)
    scene = check_scene(obstacles or World([]))
    if scene.movers:
        return lambda t: _circles(scene, robot, t + later)
    circles = _circles(scene, robot, later)
    return lambda t: circles


def _circles(scene, robot, times):
    """Centres and radii (m) of what the robot's centre keeps out of at times (k,), (k, n, 3)."""
    fixed = [(*disc.center, disc.radius) for disc in scene.world]
    circles = np.empty((len(times), len(scene), 3))
    circles[:, : len(fixed)] = np.reshape(fixed, (-1, 3))
    for index, mover in enumerate(scene.movers, len(fixed)):
        circles[:, index, :2] = mover.obstacle.center + mover.shifts(times)
        circles[:, index, 2] = mover.obstacle.radius + mover.growth * times
    circles[..., 2] += robot.radius
    return circles


def _weights(tracker, shape):
    """Weights of the squares of a plan; none of the slack's."""
    weights = np.zeros(shape)
    weights[:, :2] = tracker.acceleration
    weights[:, 2:4] = 1
    weights[:, 4] = tracker.heading
    weights[-1, 2:5] *= tracker.terminal
    return weights


def _bounds(robot, shape):
    """Least and largest values of a plan: the limits of the wheels, and a slack that is no gain."""
    most = np.full(shape, np.inf)
    most[:, :2] = robot.max_wheel_acceleration
    most[:, 5:7] = robot.max_wheel_speed
    least = -most
    least[:, 7:] = 0
    return least, most


def _previewer(reference, robot, dt, horizon, ahead):
    """``look_ahead(t)``, the `preview` from t + ahead on: off a table at the steps of a run."""
    table = preview(reference, robot, dt, ahead, len(reference.steps(dt)) + horizon)

    def look_ahead(t):
        step = round(t / dt)
        if step * dt == t and 0 <= step <= len(table) - horizon:
            return table[step : step + horizon]
        return preview(reference, robot, dt, t + ahead, horizon)

    return look_ahead


def preview(reference: Reference, robot: Robot, dt: float, t: float, steps: int) -> np.ndarray:
    """What the reference asks for in time steps to come.

    Parameters
    ----------
    reference : Reference
        What to follow.
    robot : Robot
        Its wheel base counts.
    dt : float
        Time step (s).
    t : float
        When the first of them begins (s).
    steps : int
        How many.

    Returns
    -------
    ndarray, shape (steps, 7)
        Rows of u, z: the wheels' accelerations (m/s^2), and the state that
        each step leads to, see `motion`.
    """
    begins = t + dt * np.arange(-1, steps)
    # A command holds for dt: the velocities are those at the middle of it.
    middle = reference.at(begins + dt / 2)
    wheels = wheel_speeds(robot, middle.v, middle.omega)
    pose = reference.at(begins[1:] + dt).pose
    return np.concatenate([np.diff(wheels) / dt, pose, wheels[:, 1:]]).T


def motion(robot: Robot, dt: float) -> ca.Function:
    """Model of one time step, as `Robot.move`, in symbols.

    Parameters
    ----------
    robot : Robot
        Its wheel base counts.
    dt : float
        Time step (s).

    Returns
    -------
    casadi.Function
        ``(z, u) -> z`` after `dt`; z is x, y (m), heading (rad), right and
        left wheel speed (m/s), u their accelerations (m/s^2). The wheels
        have their new speeds from the beginning of the step on.
    """
    z, u = ca.SX.sym("z", 5), ca.SX.sym("u", 2)
    wheels = z[3:] + dt * u
    half_turn = dt * (wheels[0] - wheels[1]) / robot.wheel_base / 2
    # sin(h) / h, by its series where that is exact to the last digit, for its derivatives too.
    small = ca.fabs(half_turn) < 1e-2
    h = ca.if_else(small, 1, half_turn)
    sinc = ca.if_else(small, 1 - half_turn**2 / 6 + half_turn**4 / 120, ca.sin(h) / h)
    chord, middle = dt * (wheels[0] + wheels[1]) / 2 * sinc, z[2] + half_turn
    moved = z[0] + chord * ca.cos(middle), z[1] + chord * ca.sin(middle), z[2] + 2 * half_turn
    return ca.Function("motion", [z, u], [ca.vertcat(*moved, wheels)], ["z", "u"], ["after"])


def linearisation(motion: ca.Function, horizon: int, discs: int) -> ca.Function:
    """Constraints of the quadratic programme, linearised about a plan.

    Parameters
    ----------
    motion : casadi.Function
        Model of a time step.
    horizon, discs : int
        Count of steps, and of discs to keep out of.

    Returns
    -------
    casadi.Function
        ``(plan, state, near, rolled) -> (a, lower, upper)`` with ``lower <=
        a w <= upper`` for the new plan w. A plan has a column for each step:
        u, z and, with discs, the slack; near has one for each disc of each
        step: centre and radius (m). Rolled is the share of each wheel's travel that moves
        the robot.
    """
    plan = ca.SX.sym("plan", 8 if discs else 7, horizon)
    state, near = ca.SX.sym("state", 5), ca.SX.sym("near", 3, discs * horizon)
    rolled = ca.SX.sym("rolled", 2)
    # Over the ground, wheels that slip are slower wheels.
    ground = ca.vertcat(1, 1, 1, rolled)
    gaps = []
    for k, before in enumerate(ca.horzsplit(ca.horzcat(state, plan[2:7, :-1]))):
        after = motion(ground * before, rolled * plan[:2, k]) / ground
        gaps.append(plan[2:7, k] - after)
        for disc in ca.horzsplit(near[:, k * discs : (k + 1) * discs]):
            gaps.append(ca.norm_2(plan[2:4, k] - disc[:2]) - disc[2] + plan[7, k])
    rows, w = ca.vertcat(*gaps), ca.vec(plan)
    a = ca.jacobian(rows, w)
    lower = ca.mtimes(a, w) - rows
    upper = lower + ca.repmat(ca.DM([0] * 5 + [np.inf] * discs), horizon)
    return ca.Function(
        "linearisation",
        [plan, state, near, rolled],
        [a, lower, upper],
        ["plan", "state", "near", "rolled"],
        ["a", "lower", "upper"],
    )


def _constraints_broken(sparsity):
    """How many constraints and bounds of a programme a plan x breaks, as a CasADi function."""
    a, x = ca.MX.sym("a", sparsity), ca.MX.sym("x", sparsity.size2())
    limits = {name: ca.MX.sym(name, sparsity.size1()) for name in ("lba", "uba")}
    limits |= {name: ca.MX.sym(name, sparsity.size2()) for name in ("lbx", "ubx")}
    values = ca.vertcat(ca.mtimes(a, x), x)
    least, most = (ca.vertcat(limits[f"{end}a"], limits[f"{end}x"]) for end in ("lb", "ub"))
    # What is not a number is not within its limits either.
    leeway = LEEWAY + LEEWAY_SHARE * ca.norm_inf(values)
    kept = ca.logic_and(least - leeway <= values, values <= most + leeway)
    names = ["a", *limits, "x"]
    broken = ca.sum1(ca.logic_not(kept))
    return ca.Function("broken", [a, *limits.values(), x], [broken], names, ["broken"])


def _one_pose(pose):
    """`pose` as three floats, or `InvalidParameter`."""
    if getattr(pose, "ndim", 1) > 1:
        raise InvalidParameter(
            f"pose has shape {pose.shape}, and the MPC drives one robot; run them one by one"
        )
    return checks.numbers("pose", pose, 3)


def _bind(function, **arrays):
    """A CasADi function bound to arrays, which it reads and writes without a copy.

    Returns
    -------
    callable
        Without arguments: evaluates, and returns the buffer, for its ``stats()``.
    """
    buffer, evaluate = function.buffer()
    for argument, array in arrays.items():
        if argument in function.name_in():
            buffer.set_arg(function.index_in(argument), memoryview(array))
        else:
            buffer.set_res(function.index_out(argument), memoryview(array))

    def call():
        evaluate()
        return buffer

    # The buffer knows the arrays by their addresses only: they are to live as long as the call.
    call.arrays = arrays
    return call
