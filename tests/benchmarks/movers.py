"""Does anything arrive earlier than `freeseg.time_minimal_plan`? And how long does it take?

Two rivals that share none of its geometry look for an earlier arrival in random scenes of
one to ten movers, some with static discs or polygons, in all of which something bars the
straight way (casadi and numba are needed)::

    python tests/benchmarks/movers.py STORE      # 45 minutes; goes on where it was stopped
    python tests/benchmarks/movers.py --quick    # seconds, only to see that it runs
    python tests/benchmarks/movers.py --times    # times with 10, 50 and 100 movers

*The grid* is a search in space and time: safe-interval path planning (M. Phillips,
M. Likhachev, *ICRA* 2011) on a square grid with moves in 80 directions at full speed, which
may wait wherever it is free. When a move may begin is computed, not sampled: in the frame of
a disc a move is a segment, and the times at which it must not begin are one interval.

*The programme* moves the corners of a polyline and the durations of its parts until the arrival
is least (ipopt), from several guesses: our path, our path bent at random, the grid's path, and
the straight line bent at random. A part keeps its distance from discs all along, exactly.

An answer counts only if it starts and ends where it is to, is nowhere faster than the robot,
and keeps R_D at all of many times, but for round-off. Store rows in ``data/movers_optimal.csv``.
"""

import argparse
import functools
import math
import statistics
import time
from heapq import heappop, heappush

import casadi as ca
import numpy as np
from numba import njit

import freeseg as fs
from freeseg.data import DATA, write_csv
from freeseg.geometry import unit
from freeseg.studies import crossings, runner

FILE = DATA / "movers_optimal.csv"

#: The scenes, from `freeseg.studies.crossings`.
SPEED, R_D = crossings.CROSSING_SPEED, crossings.CROSSING_KEEP
START, GOAL = crossings.CROSSING_START, crossings.CROSSING_GOAL
SCENES, FAR = 3950, GOAL[0]

#: The programme is slow: it answers some of the scenes only, one in so many.
EVERY = 4

#: Cell of the grid (m), and how far it reaches beyond start and goal (m).
CELL, AROUND = 1 / 32, 1.0

#: Parts of the polyline, and ipopt's first barrier, so low that it stays near the guess.
PARTS, BARRIER = 32, 1e-3

#: Length (m) below which a part is a point, and how much (1/s) the programme wants even parts.
TINY, EVEN = 1e-5, 1e-3

#: Area of the square that a mover has to itself in the scenes that are timed (m^2).
AREA = 0.25

#: What counts as round-off: in the distance kept (m), and in speed, relative.
ROUND_OFF = 1e-6

#: How long the grid may take at most (s), and what a ratio is at least: 0 says that there is none.
LONGEST, LEAST = 60.0, 1e-6

#: Times at which an answer is checked.
CHECKS = 4000


def as_arrays(scene):
    """Discs as rows of centre, velocity and radius with R_D (m, m/s), and edges as both ends."""
    discs = [
        (*mover.obstacle.center, *mover.velocity, mover.obstacle.radius + R_D)
        for mover in (*scene.movers, *map(fs.Mover, scene.world))
        if isinstance(mover.obstacle, fs.Disc)
    ]
    is_edge = (scene.world.edges[:, 0] != scene.world.edges[:, 1]).any(1)
    return np.array(discs).reshape(-1, 5), scene.world.edges[is_edge].reshape(-1, 4)


# The grid.


@njit
def ray_in_disc(zx, zy, u, w, r):
    """From when until when a point z + (u, w) t is in a disc about the origin."""
    a, b, c = u * u + w * w, zx * u + zy * w, zx * zx + zy * zy - r * r
    if a == 0:
        return (-math.inf, math.inf) if c < 0 else (math.inf, -math.inf)
    root = b * b - a * c
    if root <= 0:
        return math.inf, -math.inf
    root = math.sqrt(root)
    return (-b - root) / a, (-b + root) / a


@njit
def within(low, high, z, u, begin, end):
    """The part of a time interval in which low < z + u t < high."""
    if u == 0:
        return (begin, end) if low < z < high else (math.inf, -math.inf)
    one, other = (low - z) / u, (high - z) / u
    return max(begin, min(one, other)), min(end, max(one, other))


@njit
def barred_departures(ax, ay, vx, vy, lasts, disc):
    """From when until when a move that takes so long must not begin, for one disc."""
    cx, cy, u, w, r = disc
    zx, zy, qx, qy = cx - ax, cy - ay, vx - u, vy - w
    begin, end = ray_in_disc(zx, zy, u, w, r)
    later = ray_in_disc(zx - qx * lasts, zy - qy * lasts, u, w, r)
    begin, end = min(begin, later[0]), max(end, later[1])
    pace = math.hypot(qx, qy)
    if pace > 0:
        ex, ey = qx / pace, qy / pace
        one, other = within(
            0, pace * lasts, zx * ex + zy * ey, u * ex + w * ey, -math.inf, math.inf
        )
        one, other = within(-r, r, ex * zy - ey * zx, ex * w - ey * u, one, other)
        if one < other:
            begin, end = min(begin, one), max(end, other)
    return begin, end


@njit
def point_to_segment(px, py, ax, ay, bx, by):
    """Distance of a point from a segment."""
    ex, ey = bx - ax, by - ay
    share = ((px - ax) * ex + (py - ay) * ey) / max(ex * ex + ey * ey, 1e-300)
    share = min(max(share, 0.0), 1.0)
    return math.hypot(px - ax - share * ex, py - ay - share * ey)


@njit
def is_barred(ax, ay, bx, by, edges):
    """Whether a segment comes closer than R_D to an edge."""
    for k in range(len(edges)):
        cx, cy, dx, dy = edges[k]
        near = min(
            point_to_segment(ax, ay, cx, cy, dx, dy), point_to_segment(bx, by, cx, cy, dx, dy)
        )
        near = min(near, point_to_segment(cx, cy, ax, ay, bx, by))
        near = min(near, point_to_segment(dx, dy, ax, ay, bx, by))
        one = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        other = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
        this = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
        that = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
        if near < R_D or (one * other < 0 and this * that < 0):
            return True
    return False


@njit
def gaps_between(begins, ends, gaps):
    """Fill in the gaps that intervals leave from time zero on; how many there are."""
    count, free = 0, 0.0
    for k in np.argsort(begins):
        if begins[k] > free and ends[k] > begins[k]:
            gaps[count, 0], gaps[count, 1] = free, begins[k]
            count += 1
        if ends[k] > begins[k]:
            free = max(free, ends[k])
    if free < math.inf:
        gaps[count, 0], gaps[count, 1] = free, math.inf
        count += 1
    return count


@njit
def search_grid(discs, edges, moves, cells, across, goal, most):
    """Places and times of the earliest arrival on the grid; no row where there is none."""
    n = len(discs)
    ever = n + 1
    safe, counts = np.empty((cells * across, ever, 2)), np.zeros(cells * across, np.int64)
    begins, ends, gaps = np.empty(n), np.empty(n), np.empty((ever, 2))
    offset = AROUND / CELL
    for cell in range(cells * across):
        x, y = (cell // across - offset) * CELL, (cell % across - across // 2) * CELL
        for k in range(n):
            cx, cy, u, w, r = discs[k]
            begins[k], ends[k] = ray_in_disc(cx - x, cy - y, u, w, r)
        counts[cell] = gaps_between(begins, ends, safe[cell])
    best = np.full(cells * across * ever, math.inf)
    left, parent = np.zeros(len(best)), np.full(len(best), -1)
    done = np.zeros(len(best), np.bool_)
    first = int(offset) * across + across // 2
    best[first * ever] = 0.0
    heap = [(0.0, first * ever)]
    last = -1
    while heap:
        _, state = heappop(heap)
        if done[state]:
            continue
        done[state] = True
        cell = state // ever
        if cell == goal:
            last = state
            break
        i, j = cell // across, cell % across
        x, y = (i - offset) * CELL, (j - across // 2) * CELL
        until = safe[cell, state % ever, 1]
        for m in range(len(moves)):
            to_i, to_j = i + moves[m, 0], j + moves[m, 1]
            if to_i < 0 or to_j < 0 or to_i >= cells or to_j >= across:
                continue
            to = to_i * across + to_j
            length = CELL * math.hypot(moves[m, 0], moves[m, 1])
            lasts = length / SPEED
            vx, vy = CELL * moves[m, 0] / lasts, CELL * moves[m, 1] / lasts
            if len(edges) and is_barred(x, y, x + vx * lasts, y + vy * lasts, edges):
                continue
            for k in range(n):
                begins[k], ends[k] = barred_departures(x, y, vx, vy, lasts, discs[k])
            for g in range(gaps_between(begins, ends, gaps)):
                depart = max(gaps[g, 0], best[state])
                if depart > min(gaps[g, 1], until) or depart + lasts > most:
                    continue
                for s in range(counts[to]):
                    if safe[to, s, 0] <= depart + lasts <= safe[to, s, 1]:
                        then = to * ever + s
                        if depart + lasts < best[then]:
                            best[then], left[then], parent[then] = depart + lasts, depart, state
                            dx, dy = to_i - goal // across, to_j - goal % across
                            promise = depart + lasts + CELL * math.hypot(dx, dy) / SPEED
                            heappush(heap, (promise, then))
    rows = []
    while last >= 0:
        cell = last // ever
        x, y = (cell // across - offset) * CELL, (cell % across - across // 2) * CELL
        rows.append((x, y, best[last]))
        if parent[last] >= 0:
            before = parent[last] // ever
            x, y = (before // across - offset) * CELL, (before % across - across // 2) * CELL
            rows.append((x, y, left[last]))
        last = parent[last]
    return rows


#: Moves of the grid, in 80 directions.
NEIGHBOURS = np.array([(i, j) for i in range(-5, 6) for j in range(-5, 6) if math.gcd(i, j) == 1])


def grid_path(discs, edges, most):
    """Places and times (k, 3) of the grid's path that arrives before a time, or None."""
    cells, across = round((FAR + 2 * AROUND) / CELL) + 1, 2 * round(AROUND / CELL) + 1
    goal = round((FAR + AROUND) / CELL) * across + across // 2
    rows = search_grid(discs, edges, NEIGHBOURS, cells, across, goal, most)
    return np.array(rows[::-1]) if len(rows) else None


# The programme.


def nearest_square(a, b):
    """Squared distance of the origin from the segment between two points."""
    d = b - a
    share = ca.fmin(ca.fmax(-ca.dot(a, d) / (ca.dot(d, d) + TINY**2), 0), 1)
    return ca.sumsqr(a + share * d)


@functools.cache
def make_solver(discs, edges):
    """Solver for so many discs and edges, and the bounds of its constraints."""
    points, lasts = ca.SX.sym("points", 2, PARTS + 1), ca.SX.sym("lasts", PARTS)
    disc, edge = ca.SX.sym("disc", 5, discs), ca.SX.sym("edge", 4, edges)
    g = [points[:, 0] - ca.DM(START), points[:, -1] - ca.DM(GOAL)]
    t = 0
    for k in range(PARTS):
        a, b, then = points[:, k], points[:, k + 1], t + lasts[k]
        g.append(ca.sqrt(ca.sumsqr(b - a) + TINY**2) - SPEED * lasts[k])
        for j in range(discs):
            center, velocity, radius = disc[:2, j], disc[2:4, j], disc[4, j]
            before, after = a - center - velocity * t, b - center - velocity * then
            g.append(radius**2 - nearest_square(before, after))
        for e in range(edges):
            # Where both ends are so far off, all that is between them is far enough.
            half = ca.sumsqr(b - a) / 4
            for end in (a, b):
                gap = nearest_square(edge[:2, e] - end, edge[2:, e] - end)
                g.append(R_D**2 + half - gap)
        t = then
    g = ca.vertcat(*g)
    problem = {
        "x": ca.vertcat(ca.vec(points), lasts),
        "p": ca.vertcat(ca.vec(disc), ca.vec(edge)),
        # Where on a straight line its corners are makes no difference: evenly, then.
        "f": t + EVEN * ca.sumsqr(lasts - t / PARTS),
        "g": g,
    }
    ipopt = {"print_level": 0, "sb": "yes", "max_iter": 150, "tol": 1e-7, "mu_init": BARRIER}
    solver = ca.nlpsol("solver", "ipopt", problem, {"print_time": False, "ipopt": ipopt})
    low = np.full(g.numel(), -np.inf)
    low[:4] = 0
    return solver, low


def improve(discs, edges, points, t):
    """Corners (m) and times (s) that the programme makes of a guess."""
    # Solvers are made for even numbers of discs and for edges in sixes; what is far off fills up.
    far = np.tile([50.0, 50, 0, 0, 0.1], (len(discs) % 2, 1))
    away = np.tile([50.0, 50, 51, 50], (-len(edges) % 6, 1))
    solver, low = make_solver(len(discs) + len(far), len(edges) + len(away))
    given = np.concatenate([discs, far]).ravel(), np.concatenate([edges, away]).ravel()
    shortest = np.concatenate([np.full(points.size, -np.inf), np.full(PARTS, 1e-4)])
    found = solver(
        x0=np.concatenate([points.ravel(), np.diff(t)]),
        p=np.concatenate(given),
        lbx=shortest,
        lbg=low,
        ubg=0,
    )
    x = np.array(found["x"]).ravel()
    return x[: points.size].reshape(-1, 2), np.concatenate([[0.0], np.cumsum(x[points.size :])])


def is_answer(scene, points, t):
    """Whether a polyline in time leads from start to goal, not too fast, and is free."""
    if not np.allclose(points[[0, -1]], [START, GOAL], atol=ROUND_OFF) or np.diff(t).min() < 0:
        return False
    if (np.hypot(*np.diff(points, axis=0).T) > SPEED * np.diff(t) * (1 + ROUND_OFF) + 1e-9).any():
        return False
    times = np.union1d(np.linspace(0, t[-1], CHECKS), t)
    places = np.column_stack([np.interp(times, t, column) for column in points.T])
    return scene.distances(places, times).min() >= R_D - ROUND_OFF


def corners_of(path_t, path_points, joints):
    """A path as a polyline of the programme: its joints, and even times between them."""
    even = np.linspace(0, path_t[-1], PARTS + 1)
    # Each joint takes the place of the even time next to it.
    for joint in joints:
        even[1 + np.argmin(np.abs(even[1:-1] - joint))] = joint
    even = np.sort(even)
    return np.column_stack([np.interp(even, path_t, column) for column in path_points.T]), even


def bent(rng, points, t):
    """A polyline bent sideways at random, and slower."""
    share = (t / t[-1])[:, None]
    for wave in (1, 2, 3):
        points = points + rng.normal(0, 0.25 / wave, 2) * np.sin(wave * np.pi * share)
    return points, t * rng.uniform(1, 1.3)


def guesses(seed, plan, found):
    """Names of guesses, and polylines."""
    rng = np.random.default_rng([seed, 1])
    straight = np.linspace(START, GOAL, PARTS + 1), np.linspace(0, FAR / SPEED, PARTS + 1)
    if plan is not None:
        ours = corners_of(plan.path.t, plan.path.pose[:2].T, plan.path.joints[1:-1])
        yield "ours", bent(rng, *ours)
    yield "random", bent(rng, *straight)
    if found is not None:
        yield "grid", corners_of(found[:, 2], found[:, :2], ())


def judge(seed, _=0):
    """Row of a scene: our arrival, and those of the rivals as multiples of it."""
    scene = crossings.random_crossing(seed)
    try:
        plan = crossings.plan_crossing(seed)
    except fs.Trapped:
        # Then any answer of a rival is earlier.
        plan = None
    arrival = plan.arrival if plan else math.inf
    discs, edges = as_arrays(scene)
    row = {
        "seed": seed,
        "kind": crossings.CROSSING_KINDS[seed % len(crossings.CROSSING_KINDS)],
        "movers": len(scene.movers),
        "still": len(scene.world),
        "proved": int(plan is not None and plan.proved),
        "arrival_s": arrival if plan else 0.0,
    }
    found = grid_path(discs, edges, min(2 * arrival, LONGEST))
    if found is not None and is_answer(scene, found[:, :2], found[:, 2]):
        row["grid"] = max(found[-1, 2] / arrival, LEAST)
    for name, guess in guesses(seed, plan, found) if seed % EVERY == 0 else ():
        points, t = improve(discs, edges, *guess)
        if is_answer(scene, points, t):
            row[f"from_{name}"] = max(t[-1] / arrival, LEAST)
    return row


def as_row(found):
    """A row as it is stored: a rival without an answer has 0."""
    if found["failure"]:
        raise SystemExit(f"scene {found['case']}: {found['failure']}")
    row = {key: found[key] for key in ("seed", "kind", "movers", "still", "proved")}
    row["arrival_s"] = round(found["arrival_s"], 9)
    return row | {name: round(found.get(name) or 0.0, 6) for name in crossings.RIVAL_NAMES}


def print_verdict(rows):
    """Print how near the rivals came, and the scenes in which one arrived before us."""
    for name in crossings.RIVAL_NAMES:
        print(name, crossings.judge_rivals(rows, [name]))
    print("best", crossings.judge_rivals(rows, crossings.RIVAL_NAMES))
    for row in rows:
        if crossings.judge_rivals([row], crossings.RIVAL_NAMES)["earlier"]:
            print("beaten in", row)


def crowd(seed, count):
    """Scene of many movers all over a square, and the goal on the other side of it."""
    rng, side = np.random.default_rng([seed, count]), math.sqrt(AREA * count)
    found = []
    while len(found) < count:
        disc = fs.Disc(rng.uniform((0, -side / 2), (side, side / 2)), rng.uniform(0.05, 0.15))
        velocity = rng.uniform(0, 0.9 * SPEED) * unit(rng.uniform(-np.pi, np.pi))
        if math.dist(disc.center, START) > disc.radius + R_D + 0.01:
            found.append(fs.Mover(disc, velocity))
    return fs.Scene(fs.World([]), found), (side, 0.0)


def times(sizes, scenes, repeats=3):
    """Print processor times of planning among so many movers: least of some for each scene."""
    for count in sizes:
        found = []
        for seed in range(scenes):
            scene, goal = crowd(seed, count)
            spent = []
            for _ in range(repeats):
                begin = time.process_time()
                fs.time_minimal_plan(scene, START, goal, SPEED)
                spent.append(1e3 * (time.process_time() - begin))
            found.append(min(spent))
        print(
            f"{count:4d} movers, {scenes} scenes: median {statistics.median(found):.1f} ms, "
            f"worst {max(found):.1f} ms"
        )


def main(arguments=None):
    """Run what the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("store", nargs="?")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--times", action="store_true")
    given = parser.parse_args(arguments)
    if given.times:
        times((10, 50, 100), 200)
        return
    seeds = range(2) if given.quick else range(SCENES)
    rows = [as_row(row) for row in runner.run(judge, seeds, given.store, jobs=1)]
    print_verdict(rows)
    if given.store:
        write_csv(FILE, rows)


if __name__ == "__main__":
    main()
