from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

import freeseg as fs
from freeseg.disturbance import BLOCK, normals
from freeseg.path import Arc, Line

DT = 0.05
#: 5 m at 0.1 m/s; to a law that only looks at the time, just how long a run lasts.
STRAIGHT = fs.make_reference(fs.Path([Line((0, 0), (5, 0))]))
BEND = fs.make_reference(fs.Path([Arc((0, 0.3), 0.3, -np.pi / 2, 2.5)]))
#: A robot whose motors reach any speed within a step.
AGILE = fs.KheperaIV(max_wheel_rate_change=1e6)
#: 1 mm, 0.5 degrees, 5 % and 2 % of slip, 3 % of wheel base, 30 ms of lag and a late sample.
ALL = fs.Disturbance(
    position_noise=0.001,
    heading_noise=np.radians(0.5),
    slip=0.05,
    slip_fluctuation=0.02,
    slip_time=0.5,
    wheel_base_error=0.03,
    wheel_radius_error=(0.01, -0.01),
    lag=0.03,
    delay=DT,
)


class Feed:
    """Commands a velocity that depends on the time only."""

    def __init__(self, command):
        self.command = command

    def start(self, reference, robot, dt):
        return lambda t, pose: self.command(t)


def drive(v, omega, robot=AGILE, offset=(0, 0, 0), **disturbance):
    """A run with one command throughout: from the origin eastwards, unless offset."""
    feed = Feed(lambda t: (v, omega))
    disturbance = fs.Disturbance(**disturbance)
    return fs.simulate(
        feed, STRAIGHT, robot, DT, initial_offset=offset, disturbance=disturbance, seed=71
    )


def many(n, scale=(0.05, 0.05, 0.4), seed=72):
    """Offsets of n robots."""
    return np.random.default_rng(seed).normal(0, np.reshape(scale, (3, 1)), (3, n))


def assert_same_run(one, other):
    for name in ("t", "pose", "reference", "error", "wheels", "measured"):
        assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


# --- none ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [(-0.02, 0.03, 0.3), many(5)], ids=["one", "batch"])
def test_no_disturbance_is_none_at_all(robot, offset):
    plain = fs.simulate(fs.SlidingMode(), BEND, robot, initial_offset=offset)
    calm = fs.Disturbance()
    run = fs.simulate(
        fs.SlidingMode(), BEND, robot, initial_offset=offset, disturbance=calm, seed=5
    )
    assert_same_run(run, plain)
    assert run.measured is run.pose


def test_one_command_for_a_whole_batch():
    # Two robots above all: their number is that of the wheels.
    for n in (1, 2, 5):
        run = drive(0.1, 0.2, offset=np.zeros((3, n)))
        for number in range(n):
            assert_array_equal(run.pose[:, number], drive(0.1, 0.2).pose)


# --- wheels and ground ---------------------------------------------------------------------------


def test_slip_of_both_wheels_shortens_the_way():
    run = drive(0.2, 0, slip=0.1)
    assert_allclose(run.pose[0], 0.9 * 0.2 * run.t, rtol=1e-12)
    assert_allclose(run.pose[1:], 0, atol=1e-12)
    # The wheels themselves turn as they are told, and know of no slip.
    assert_allclose(run.wheels, 0.2)


def test_slip_of_one_wheel_bends_the_way():
    # The right wheel makes good 0.9 of 0.2 m/s: w = -0.02 / L and v = 0.19 m/s, to the right.
    run = drive(0.2, 0, slip=(0.1, 0))
    omega = -0.02 / AGILE.wheel_base
    assert_allclose(run.pose[2], omega * run.t, rtol=1e-10)
    radius = 0.19 / omega
    assert_allclose(run.pose[0], radius * np.sin(omega * run.t), atol=1e-9)
    assert_allclose(run.pose[1], radius * (1 - np.cos(omega * run.t)), atol=1e-9)
    assert_allclose(drive(0.2, 0, slip=(0, 0.1)).pose[1], -run.pose[1], atol=1e-12)


def test_a_wider_wheel_base_turns_slower():
    run = drive(0.1, 0.5, wheel_base_error=0.03)
    assert_allclose(run.pose[2], 0.5 / 1.03 * run.t, rtol=1e-10)
    assert_allclose(np.hypot(run.pose[0], run.pose[1] - 0.206), 0.206, rtol=1e-9)
    # The robot and its tracker believe in their own wheel base.
    assert run.robot == AGILE
    assert_allclose(run.wheels[:, 0], AGILE.to_wheels(0.1, 0.5))


def test_a_larger_wheel_goes_further():
    run = drive(0.2, 0, wheel_radius_error=0.02)
    assert_allclose(run.pose[0], 1.02 * 0.2 * run.t, rtol=1e-12)
    assert_allclose(run.wheels, 0.2)
    # Unequal wheels bend the way: w = (1.02 - 1) 0.2 / L to the left.
    run = drive(0.2, 0, wheel_radius_error=(0.02, 0))
    assert_allclose(run.pose[2], 0.004 / AGILE.wheel_base * run.t, rtol=1e-10)


def test_the_law_is_told_the_robot_and_not_the_plant():
    seen = []

    class Spy(Feed):
        def start(self, reference, robot, dt):
            seen.append(robot)
            return super().start(reference, robot, dt)

    spy = Spy(lambda t: (0.1, 0))
    fs.simulate(spy, BEND, AGILE, disturbance=fs.Disturbance(wheel_base_error=0.1))
    assert seen == [AGILE]


# --- lag -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("lag", [0.005, 0.03, 0.2])
def test_a_step_command_is_reached_as_the_lag_says(lag):
    run = drive(0.2, 0, lag=lag)
    # Way of the wheels under v (1 - exp(-t / tau)), and its mean over each step.
    way = 0.2 * (run.t + lag * np.expm1(-run.t / lag))
    assert_allclose(run.pose[0], way, atol=1e-12)
    assert_allclose(run.wheels[0, :-1], np.diff(way) / DT, rtol=1e-9)


def test_no_lag_is_the_limit_of_a_short_one():
    for lag in (1e-320, 1e-9):
        assert_allclose(drive(0.2, 0.3, lag=lag).pose, drive(0.2, 0.3).pose, atol=1e-9)


def test_with_lag_the_end_of_a_step_is_where_the_model_ends(robot):
    # At 0.1 m/s, wheels that change as fast as they can in opposite senses, and random ones.
    rng = np.random.default_rng(73)
    worst, lag = 0, 0.03
    fastest = robot.max_wheel_acceleration * DT * np.array([[0, 1, 2, 3], [0, -1, -2, -3]])
    for commands in 0.1 + np.concatenate([[fastest], rng.normal(0, 0.1, (20, 2, 4))]):
        feed = Feed(lambda t, c=commands: robot.to_body(c[:, min(round(t / DT), 3)]))
        run = fs.simulate(feed, STRAIGHT, robot, DT, disturbance=fs.Disturbance(lag=lag))
        state, asked = np.zeros(5), np.zeros(2)
        for step in range(4):
            asked = robot.saturate(commands[:, step], asked, DT)
            state[:3] = run.pose[:, step]

            def model(t, state, asked=asked):
                v, omega = robot.to_body(state[3:])
                rates = v * np.cos(state[2]), v * np.sin(state[2]), omega
                return *rates, *((asked - state[3:]) / lag)

            solution = solve_ivp(model, (0, DT), state, method="DOP853", rtol=1e-11, atol=1e-12)
            state = solution.y[:, -1]
            # Way and turn are exact, the position nearly.
            assert run.pose[2, step + 1] == pytest.approx(state[2], abs=1e-9)
            worst = max(worst, np.hypot(*(run.pose[:2, step + 1] - state[:2])))
    assert 1e-6 < worst < 1e-4


# --- delay ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("late", [1, 3, 40])
def test_a_delay_shifts_the_commands(robot, late):
    feed = Feed(lambda t: (0.2 + 0.1 * np.sin(t), np.cos(t)))
    prompt = fs.simulate(feed, STRAIGHT, robot, DT)
    run = fs.simulate(feed, STRAIGHT, robot, DT, disturbance=fs.Disturbance(delay=late * DT))
    # Bit for bit: the same commands, to motors at rest.
    assert_array_equal(run.wheels[:, :late], 0)
    assert_array_equal(run.wheels[:, late:-1], prompt.wheels[:, : -late - 1])
    assert_array_equal(run.pose[:, late:], prompt.pose[:, :-late])


def test_a_delay_beyond_the_end_leaves_the_robot_at_rest():
    for delay in (10_000, 1e300):
        run = drive(0.2, 0.1, delay=delay)
        assert_array_equal(run.pose, 0)
        assert_array_equal(run.wheels, 0)


@pytest.mark.parametrize("delay", [0.01, 0.049, 0.051, 0.125, 1e-3])
def test_a_delay_between_two_samples(delay):
    with pytest.raises(fs.InvalidParameter, match=r"delay is .* no whole number of time steps"):
        drive(0.1, 0, delay=delay)


def test_a_whole_number_of_steps_up_to_round_off():
    # 0.3 / 0.1 is 2.9999999999999996.
    feed = Feed(lambda t: (0.2, 0))
    run = fs.simulate(feed, STRAIGHT, AGILE, dt=0.1, disturbance=fs.Disturbance(delay=0.3))
    assert_allclose(run.wheels[0, :5], [0, 0, 0, 0.2, 0.2])


# --- noise ---------------------------------------------------------------------------------------


def test_measurement_noise_has_its_deviation_and_is_white(robot):
    run = drive(0.1, 0.2, robot, many(200), position_noise=0.002, heading_noise=0.01)
    noise = (run.measured - run.pose) / np.reshape([0.002, 0.002, 0.01], (3, 1, 1))
    count = noise[0].size  # 200 robots times 1 011 samples
    # Five standard deviations of each estimate.
    assert_allclose(noise.mean((1, 2)), 0, atol=5 / np.sqrt(count))
    assert_allclose(noise.std((1, 2)), 1, atol=5 / np.sqrt(2 * count))
    assert_allclose((noise[:, :, 1:] * noise[:, :, :-1]).mean((1, 2)), 0, atol=5 / np.sqrt(count))
    assert_allclose((noise[:, 1:] * noise[:, :-1]).mean((1, 2)), 0, atol=5 / np.sqrt(count))
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert abs((noise[one] * noise[other]).mean()) < 5 / np.sqrt(count)
    assert_allclose((noise**4).mean((1, 2)), 3, atol=5 * np.sqrt(96 / count))


def test_noise_is_seen_by_the_tracker_only():
    # A feed-forward law does not look: it drives as without noise.
    noisy = drive(0.1, 0.2, position_noise=0.01, heading_noise=0.1)
    assert_array_equal(noisy.pose, drive(0.1, 0.2).pose)
    assert_array_equal(noisy.error, drive(0.1, 0.2).error)
    seen = []

    class Spy:
        def start(self, reference, robot, dt):
            return lambda t, pose: seen.append(pose.copy()) or (0.1, 0.2)

    disturbance = fs.Disturbance(position_noise=0.01)
    run = fs.simulate(Spy(), BEND, AGILE, disturbance=disturbance)
    assert_array_equal(np.transpose(seen), run.measured[:, :-1])
    assert_array_equal(run.measured[2], run.pose[2])
    assert (run.measured[:2] != run.pose[:2]).all()


def fluctuation(run, robot=AGILE):
    """Slip of both wheels, from what they did and where the robot went."""
    rates = np.diff(run.pose[2]) / DT
    moved = np.diff(run.pose[:2], axis=-1)
    middle = (run.pose[2, ..., 1:] + run.pose[2, ..., :-1]) / 2
    chord = moved[0] * np.cos(middle) + moved[1] * np.sin(middle)
    v = chord / DT / np.sinc(rates * DT / 2 / np.pi)
    return 1 - robot.to_wheels(v, rates) / run.wheels[..., :-1]


def test_slip_fluctuates_with_its_deviation_and_correlation_time():
    deviation, time = 0.03, 0.25
    run = drive(
        0.2, 0, AGILE, np.zeros((3, 400)), slip=0.05, slip_fluctuation=deviation, slip_time=time
    )
    slip = (fluctuation(run) - 0.05) / deviation
    samples = slip.shape[-1]
    # A process of correlation time T is worth one free sample in 2 T, 400 robots at a time.
    free = 2 * 400 * samples * DT / (2 * time)
    assert abs(slip.mean()) < 5 / np.sqrt(free)
    assert (slip**2).mean() == pytest.approx(1, abs=5 * np.sqrt(2 / free))
    # Stationary from the first sample on.
    assert (slip[..., 0] ** 2).mean() == pytest.approx(1, abs=5 * np.sqrt(2 / 800))
    for shift in (1, 5, 20):
        correlation = (slip[..., shift:] * slip[..., :-shift]).mean()
        assert correlation == pytest.approx(np.exp(-shift * DT / time), abs=5 * np.sqrt(2 / free))
    assert abs((slip[0] * slip[1]).mean()) < 5 / np.sqrt(free)


def test_a_long_and_a_short_correlation_time():
    # So long that the share stays, and so short that it is new at every sample.
    slow = fluctuation(drive(0.2, 0, slip_fluctuation=0.1, slip_time=1e9))
    assert_allclose(slow, np.repeat(slow[:, :1], slow.shape[-1], -1), atol=1e-4)
    assert np.abs(slow[:, 0]).min() > 1e-3
    fast = fluctuation(drive(0.2, 0, slip_fluctuation=0.1, slip_time=1e-9))
    assert abs(np.corrcoef(fast[0, 1:], fast[0, :-1])[0, 1]) < 5 / np.sqrt(len(fast[0]))


def test_a_wheel_never_slips_by_more_than_its_way():
    slip = fluctuation(drive(0.2, 0, AGILE, np.zeros((3, 50)), slip=0.9, slip_fluctuation=0.9))
    assert slip.max() == pytest.approx(1, abs=1e-9)
    assert slip.min() == pytest.approx(-1, abs=1e-9)


# --- random numbers ------------------------------------------------------------------------------


def test_a_batch_with_all_disturbances_is_bit_for_bit_its_single_runs(robot):
    offsets = many(6)
    batch = fs.simulate(
        fs.SlidingMode(), BEND, robot, initial_offset=offsets, disturbance=ALL, seed=9
    )
    assert batch.measured.shape == (3, 6, len(batch.t))
    assert len(batch.t) > 4 * BLOCK
    for number, offset in enumerate(offsets.T):
        single = fs.simulate(
            fs.SlidingMode(), BEND, robot, initial_offset=offset, disturbance=ALL, seed=(9, number)
        )
        assert_array_equal(batch.reference, single.reference)
        for name in ("pose", "error", "wheels", "measured"):
            assert_array_equal(getattr(batch, name)[:, number], getattr(single, name))


def test_part_of_a_batch_is_simulated_alike(robot):
    offsets = many(5)
    runs = [
        fs.simulate(fs.SlidingMode(), BEND, robot, initial_offset=some, disturbance=ALL, seed=seed)
        for some, seed in ((offsets, 4), (offsets[:, 2:], (4, 2)))
    ]
    assert_array_equal(runs[0].pose[:, 2:], runs[1].pose)


def test_a_seed_gives_the_same_again_and_another_seed_another(robot):
    runs = [
        fs.simulate(fs.SlidingMode(), BEND, robot, disturbance=ALL, seed=seed)
        for seed in (0, 0, (0, 0), np.int64(0), 1, (0, 1))
    ]
    for again in runs[1:4]:
        assert_same_run(again, runs[0])
    noises = [run.measured - run.pose for run in (runs[0], *runs[4:])]
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert (noises[one] != noises[other]).all()


def test_robots_of_a_batch_have_their_own_numbers(robot):
    run = fs.simulate(
        fs.SlidingMode(), BEND, robot, initial_offset=np.zeros((3, 20)), disturbance=ALL
    )
    noise = (run.measured - run.pose).reshape(3, 20, -1)
    for row in noise:
        correlation = np.corrcoef(row) - np.eye(20)
        assert np.abs(correlation).max() < 5 / np.sqrt(row.shape[-1])


def test_switching_one_disturbance_on_leaves_the_numbers_of_the_others():
    alone = drive(0.1, 0.2, position_noise=0.001)
    both = drive(0.1, 0.2, position_noise=0.001, slip_fluctuation=0.02, lag=0.05)
    assert_allclose(alone.measured - alone.pose, both.measured - both.pose, atol=1e-12)


def test_random_numbers_do_not_depend_on_how_many_are_drawn():
    long = np.stack(list(normals((3, 1), (4,), 3 * BLOCK + 5)))
    assert long.shape == (3 * BLOCK + 5, 5, 4)
    for samples in (1, BLOCK - 1, BLOCK, BLOCK + 1):
        assert_array_equal(np.stack(list(normals((3, 1), (4,), samples))), long[:samples])
    assert_array_equal(np.stack(list(normals((3, 3), (), BLOCK + 1))), long[: BLOCK + 1, :, 2])


# --- limits --------------------------------------------------------------------------------------


def test_wheels_keep_the_limits_under_any_disturbance(robot):
    rng = np.random.default_rng(74)
    for number in range(40):
        names = ("k1", "k2", "phi1", "phi2", "length_scale")
        gains = dict(zip(names, 10 ** rng.uniform(-2, 1, len(names)), strict=True))
        dt = float(rng.choice([0.02, 0.05, 0.1]))
        disturbance = fs.Disturbance(
            position_noise=rng.uniform(0, 0.05),
            heading_noise=rng.uniform(0, 0.5),
            slip=rng.uniform(-0.3, 0.3, 2),
            slip_fluctuation=rng.uniform(0, 0.3),
            slip_time=10 ** rng.uniform(-2, 1),
            wheel_base_error=rng.uniform(-0.2, 0.2),
            wheel_radius_error=rng.uniform(-0.2, 0.2, 2),
            lag=10 ** rng.uniform(-3, 0),
            delay=dt * int(rng.integers(0, 5)),
        )
        tracker = fs.SlidingMode(**gains, switching=str(rng.choice(["sat", "sign", "tanh"])))
        run = fs.simulate(
            tracker, BEND, robot, dt, many(100, (0.3, 0.3, 1.5), number), disturbance, number
        )
        assert np.isfinite(run.pose).all()
        changes = np.diff(run.wheels, axis=-1, prepend=0.0)
        assert np.abs(run.wheels).max() <= robot.max_wheel_speed + 1e-12
        assert np.abs(changes).max() <= robot.max_wheel_acceleration * dt + 1e-12


# --- sliding mode --------------------------------------------------------------------------------


def test_sliding_mode_keeps_clear_of_the_obstacles_under_all_disturbances(cases, tables, robot):
    case = cases["15a"]
    world = tables[case.table]
    reference = fs.make_reference(fs.plan(world, case.start, case.goal).path)
    disturbance = replace(ALL, wheel_radius_error=0.0)
    # On the path, a little beside it on either side, and far off on the free side; 25 of each.
    offsets = [(0, 0, 0), (-0.005, 0.005, 0.09), (-0.005, -0.005, -0.09), (-0.02, 0.03, 0.35)]
    run = fs.simulate(
        fs.SlidingMode(),
        reference,
        robot,
        initial_offset=np.repeat(np.transpose(offsets), 25, axis=1),
        disturbance=disturbance,
    )
    numbers = fs.metrics.tracking(run, world)
    assert numbers["clearance_m"].min() > robot.radius
    assert numbers["position_final_m"].max() < 0.01
    assert np.isfinite(numbers["settling_time_s"]).all()


# --- what is refused -----------------------------------------------------------------------------


class Untouched:
    """A tracker that must not even be started."""

    def start(self, reference, robot, dt):
        raise AssertionError("started")


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("position_noise", [-0.001, (0.001, 0.001)]),
        ("heading_noise", [-0.1, [0.1]]),
        ("slip", [1, 1.5, -1, (0, 1), (0.1, 0.1, 0.1), (0.1,), [[0.1, 0.1]], (0, np.nan)]),
        ("slip_fluctuation", [-0.1, 1, (0.1, 0.1)]),
        ("slip_time", [0, -1, (1, 1)]),
        ("wheel_base_error", [-1, -2, (0.1, 0.1)]),
        ("wheel_radius_error", [-1, (0.1, -1), (0.1, 0.1, 0.1), (0.1, np.inf)]),
        ("lag", [-0.01, (0.1, 0.1)]),
        ("delay", [-0.05, (0.05, 0.05)]),
    ],
)
def test_invalid_disturbance(name, values):
    for value in [*values, np.nan, np.inf, -np.inf, None, "some", 1j, [], {}, object()]:
        with pytest.raises(fs.InvalidParameter, match=f"disturbance.{name} is .*; give "):
            fs.Disturbance(**{name: value})


def test_numbers_are_kept_as_floats_and_pairs():
    disturbance = fs.Disturbance(
        slip=np.array([0.1, 0]), wheel_radius_error=0.02, lag=np.float32(1)
    )
    assert disturbance == fs.Disturbance(slip=(0.1, 0.0), wheel_radius_error=(0.02, 0.02), lag=1.0)
    assert replace(disturbance, lag=0).slip == (0.1, 0.0)
    assert type(disturbance.lag) is float
    assert hash(disturbance) == hash(replace(disturbance))


@pytest.mark.parametrize(
    "disturbance", [0.1, "noise", {"lag": 0.1}, fs.Disturbance, [fs.Disturbance()]]
)
def test_what_is_no_disturbance(disturbance):
    with pytest.raises(fs.InvalidParameter, match="give a Disturbance"):
        fs.simulate(Untouched(), BEND, disturbance=disturbance)


@pytest.mark.parametrize(
    "seed", [-1, 0.5, None, "7", np.nan, (1, -1), (1, 2, 0), (1,), (1, 0.5), [[1, 2]], np.arange(2)]
)
def test_invalid_seed(seed):
    with pytest.raises(fs.InvalidParameter, match="seed is "):
        fs.simulate(Untouched(), BEND, seed=seed)


def test_a_delay_is_refused_before_the_tracker_starts():
    with pytest.raises(fs.InvalidParameter, match=r"delay is 0.07 s.* give 0.05 or 0.1 s"):
        fs.simulate(Untouched(), BEND, disturbance=fs.Disturbance(delay=0.07))
