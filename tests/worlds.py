"""Worlds and questions that several tests share."""

import numpy as np
import shapely

import freeseg as fs

#: From room to room, and by the exact planner where that fails.
rooms_first = fs.with_fallback(fs.plan_rooms, fs.shortest_path)


def crowded_question(seed, most=60):
    """World, start, goal and margin (m); in about every tenth one there is no path."""
    rng = np.random.default_rng(seed)
    n, margin = 1 + seed % most, rng.choice([0.005, 0.03, 0.06])
    shapes = [("disc",), ("polygon",), ("disc", "polygon")][seed % 3]
    for attempt in range(100):
        # A crowded square may leave no room for two ends.
        world = fs.random_world(n, 1000 * attempt + seed, shapes, rng.choice([0.02, 0.03, 0.1]))
        points = rng.uniform(0, world.edges.max(), (200, 2))
        clearance = world.distances(shapely.points(points)[:, None]).min(1)
        free = points[clearance > fs.KheperaIV().radius + margin / 2]
        if len(free) > 1:
            return world, free[0], free[1], margin
    raise AssertionError(f"seed {seed} leaves no room")


def transformed(world, matrix, shift=(0.0, 0.0)):
    """The world turned, mirrored or scaled by a matrix, then shifted; and the map of points."""
    matrix = np.asarray(matrix, float)
    scale = np.sqrt(abs(np.linalg.det(matrix)))

    def move(points):
        return np.asarray(points) @ matrix.T + shift

    obstacles = [
        fs.Disc(move(obstacle.center), scale * obstacle.radius)
        if isinstance(obstacle, fs.Disc)
        else fs.Polygon(move(obstacle.vertices))
        for obstacle in world.obstacles
    ]
    return fs.World(obstacles), move
