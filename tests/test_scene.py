import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose

import freeseg as fs

SQUARE = fs.Polygon([(0, 0), (0.2, 0), (0.2, 0.2), (0, 0.2)])


def circling(t):
    return np.stack([np.cos(t) - 1, np.sin(t)], -1)


def make_scene(*movers):
    boundary = [(-3, -3), (3, -3), (3, 3), (-3, 3)]
    return fs.Scene(fs.World([fs.Disc((1, 1), 0.1), SQUARE], boundary), movers)


MOVERS = (
    fs.Mover(fs.Disc((0, -1), 0.2), velocity=(0.1, -0.2)),
    fs.Mover(fs.Disc((-1, 0), 0.1), growth=0.05),
    fs.Mover(SQUARE, velocity=(-0.3, 0)),
    fs.Mover(fs.Disc((1, 0), 0.3), shift=circling),
)


def test_a_scene_at_a_time_is_a_world_with_the_frame_last():
    world = make_scene(*MOVERS).at(2.0)
    assert len(world) == 7
    assert world.frame == 6
    assert_allclose(world[2].center, (0.2, -1.4))
    assert world[3].radius == pytest.approx(0.2)


@pytest.mark.parametrize("movers", [(), MOVERS[:2], MOVERS])
def test_distances_are_those_of_the_world_at_each_time(movers):
    scene, rng = make_scene(*movers), np.random.default_rng(1)
    points, times = rng.uniform(-2, 2, (40, 2)), rng.uniform(0, 5, 40)
    found = scene.distances(points, times)
    assert found.shape == (40, len(scene))
    # A world puts its frame last, a scene its movers.
    order = [0, 1, *range(3, len(scene)), 2]
    for point, t, row in zip(points, times, found, strict=True):
        assert_allclose(row[order], scene.at(t).distances(shapely.Point(point)), atol=1e-12)


def test_distances_broadcast():
    scene = make_scene(*MOVERS[:2])
    many = scene.distances(np.zeros((5, 4, 2)), np.arange(4.0))
    assert many.shape == (5, 4, 5)
    assert_allclose(many[2, 3], scene.distances((0, 0), 3.0))


def test_movers_may_pass_through_each_other():
    head_on = [fs.Mover(fs.Disc((s, 0), 0.2), velocity=(-s, 0)) for s in (-1, 1)]
    assert_allclose(fs.Scene(fs.World([]), head_on).distances((0, 0), 1.0), -0.2)


def test_clearance_of_a_run_is_that_of_the_time():
    reference = fs.make_reference(fs.Path([fs.Line((0, 0), (1, 0))]))
    run = fs.simulate(fs.SlidingMode(), reference)
    # It keeps beside the robot, 0.5 m off, and starts and ends elsewhere.
    mover = fs.Mover(
        fs.Disc((0, 0.6), 0.1),
        shift=lambda t: np.stack([np.interp(t, run.t, run.pose[0]) - run.pose[0, 0], 0 * t], -1),
    )
    scene = fs.Scene(fs.World([fs.Disc((3, 0), 0.1)]), [mover])
    numbers = fs.metrics.tracking(run, scene)
    assert numbers["clearance_m"] == pytest.approx(0.5, abs=1e-9)
    assert numbers["clearance_m"] == scene.clearance(run)
    standing = fs.Scene(scene.world, [fs.Mover(mover.obstacle)])
    assert fs.metrics.tracking(run, standing)["clearance_m"] == pytest.approx(
        fs.metrics.tracking(run, standing.at(0))["clearance_m"], abs=1e-12
    )


def test_a_world_serves_as_a_scene():
    reference = fs.make_reference(fs.Path([fs.Line((0, 0), (1, 0))]))
    run, world = fs.simulate(fs.SlidingMode(), reference), fs.World([fs.Disc((0.5, 0.5), 0.1)])
    assert fs.metrics.tracking(run, world) == fs.metrics.tracking(run, fs.Scene(world))


@pytest.mark.parametrize(
    ("parts", "named"),
    [
        ({"obstacle": 3}, "obstacle"),
        ({"velocity": (1, 2, 3)}, "velocity"),
        ({"velocity": (np.nan, 0)}, "velocity"),
        ({"growth": -1}, "growth"),
        ({"obstacle": SQUARE, "growth": 0.1}, "growth"),
        ({"shift": 3}, "shift"),
        ({"shift": circling, "velocity": (1, 0)}, "shift"),
        ({"shift": np.sin}, "shift"),
        ({"shift": lambda t: circling(t) + 1}, "time zero"),
    ],
)
def test_what_is_no_mover_is_refused(parts, named):
    with pytest.raises(fs.InvalidWorld, match=named):
        fs.Mover(**{"obstacle": fs.Disc((0, 0), 1)} | parts)


def test_the_frame_of_a_boundary_does_not_move():
    world = fs.World([], [(0, 0), (1, 0), (1, 1)])
    with pytest.raises(fs.InvalidWorld, match="boundary"):
        fs.Mover(world[0], velocity=(1, 0))
