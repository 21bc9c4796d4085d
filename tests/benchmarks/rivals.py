"""Rivals from elsewhere beside freeseg's planners: ``python tests/benchmarks/rivals.py``.

One question after another is put to all of them: the paper's 16 cases, random worlds of 30
discs and polygons at three densities, and with ``--barn SOURCE`` the 300 worlds of BARN, see
``barn.py``. A row a question and rival is stored in ``data/rivals.npz``, and the table,
`freeseg.studies.rivals.summarise`, is printed; with ``--store FOLDER`` what is done is kept,
and a run that was stopped goes on. The packages that it compares with are in ``peers.txt``;
what is not installed is left out. ``--quick`` asks few questions and stores nothing.
``--grow`` instead asks the exact planner and the triangulation in ever larger worlds of discs,
and stores what they need in ``data/growth.csv``.

All are told the map and the distance that the robot's centre has to keep, R_D:

* Lazy Theta* (A. Nash, S. Koenig, C. Tovey, *AAAI* 2010) on a grid with cells of R_D / 10: a
  path of any angle. Written here, compiled, with an exact check of lines instead of one by cells.
* OMPL's RRT-Connect and BIT*, both with the same exact check, compiled, which OMPL calls back
  in Python for each motion, and both with OMPL's simplification after. BIT* has a budget of
  processor time, RRT-Connect stops at its first path.
* A constrained triangulation: obstacles as polygons of 16 corners round each circle, Shewchuk's
  Triangle, then A* over triangles and a funnel, by cdt_path in Python.

The reactive laws of `freeseg.studies.reacting`, with the gains that were found for them, drive a
robot in the same worlds. They are told what each of them knows, which is less than the map but
for the potential field, and no distance to keep.

Times are of the processor and include all preparation. numba, the packages, and what they
compile are loaded before.
"""

import argparse
import functools
import math
import time
from heapq import heappop, heappush
from importlib import metadata
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import shapely
from numba import njit
from scipy.stats import theilslopes

import freeseg as fs
from freeseg.data import DATA, write_csv
from freeseg.planners.query import ask
from freeseg.studies import reacting, rivals

FILE = DATA / "growth.csv"

#: So many discs have the ever larger worlds, and so many there are of each size.
SIZES, EACH = (10, 30, 100, 300, 1000, 3000, 10000), 5

#: Cells of the grid search, as a share of R_D, and how far beyond the world it looks, in R_D.
CELL, AROUND = 0.1, 3

#: Corners of the polygon round a circle.
CORNERS = 16

#: So many worlds has BARN.
BARN = 300

#: Budgets of BIT* (s), and how long RRT-Connect may look.
BUDGETS, PATIENCE = (0.01, 0.05), 10.0


@njit
def is_clear(px, py, qx, qy, edge, keep):
    """Whether the line from p to q keeps its distance from all edges."""
    dx, dy = qx - px, qy - py
    for e in range(len(edge)):
        ax, ay, bx, by = edge[e]
        near = keep[e]
        if (
            min(px, qx) - near >= max(ax, bx)
            or max(px, qx) + near <= min(ax, bx)
            or min(py, qy) - near >= max(ay, by)
            or max(py, qy) + near <= min(ay, by)
        ):
            continue
        squared = near * near
        if squared_distance(ax, ay, px, py, qx, qy) < squared:
            return False
        if ax == bx and ay == by:
            continue
        if (
            squared_distance(bx, by, px, py, qx, qy) < squared
            or squared_distance(px, py, ax, ay, bx, by) < squared
            or squared_distance(qx, qy, ax, ay, bx, by) < squared
        ):
            return False
        ex, ey = bx - ax, by - ay
        if (dx * (ay - py) > dy * (ax - px)) != (dx * (by - py) > dy * (bx - px)) and (
            ex * (py - ay) > ey * (px - ax)
        ) != (ex * (qy - ay) > ey * (qx - ax)):
            return False
    return True


@njit
def squared_distance(x, y, ax, ay, bx, by):
    """Square of the distance of a point from a segment."""
    ex, ey = bx - ax, by - ay
    length = ex * ex + ey * ey
    share = 0.0
    if length > 0:
        share = min(max(((x - ax) * ex + (y - ay) * ey) / length, 0.0), 1.0)
    px, py = ax + share * ex - x, ay + share * ey - y
    return px * px + py * py


@njit
def lazy_theta_star(x0, y0, cell, nx, ny, gx, gy, sx, sy, edge, keep):
    """Points from the start, the middle of a cell, to the goal; empty where there is no path.

    Every cell is a node, and so is the goal, beside the cells around it.
    """
    goal, count = nx * ny, nx * ny + 1
    px, py = np.empty(count), np.empty(count)
    for k in range(goal):
        px[k], py[k] = x0 + (k % nx) * cell, y0 + (k // nx) * cell
    px[goal], py[goal] = gx, gy
    start = round((sy - y0) / cell) * nx + round((sx - x0) / cell)
    px[start], py[start] = sx, sy
    length, parent = np.full(count, np.inf), np.full(count, -1)
    closed, free = np.zeros(count, np.bool_), np.zeros(count, np.int8)
    length[start], parent[start] = 0.0, start
    heap = [(math.hypot(gx - sx, gy - sy), start)]
    around = np.empty(9, np.int64)
    while heap:
        _, k = heappop(heap)
        if closed[k]:
            continue
        beside = neighbours(k, nx, ny, px, py, goal, cell, around)
        p = parent[k]
        if p != k and not is_clear(px[p], py[p], px[k], py[k], edge, keep):
            # Its parent does not see it: it comes from the best neighbour that does.
            length[k] = np.inf
            for n in around[:beside]:
                new = length[n] + math.hypot(px[n] - px[k], py[n] - py[k])
                shorter = closed[n] and new < length[k]
                if shorter and is_clear(px[n], py[n], px[k], py[k], edge, keep):
                    length[k], parent[k] = new, n
            if length[k] == np.inf:
                continue
        closed[k] = True
        if k == goal:
            break
        p = parent[k]
        for n in around[:beside]:
            if closed[n]:
                continue
            if free[n] == 0:
                free[n] = 1 if is_clear(px[n], py[n], px[n], py[n], edge, keep) else -1
            new = length[p] + math.hypot(px[n] - px[p], py[n] - py[p])
            if free[n] > 0 and new < length[n]:
                length[n], parent[n] = new, p
                heappush(heap, (new + math.hypot(gx - px[n], gy - py[n]), n))
    if not closed[goal]:
        return np.empty((0, 2))
    track, k = [(gx, gy)], goal
    while k != start:
        k = parent[k]
        track.append((px[k], py[k]))
    return np.array(track[::-1])


@njit
def neighbours(k, nx, ny, px, py, goal, cell, around):
    """Note the nodes beside one; how many there are."""
    found = 0
    if k == goal:
        column = round((px[goal] - px[0]) / cell)
        row = round((py[goal] - py[0]) / cell)
        reach = 2
    else:
        column, row, reach = k % nx, k // nx, 1
        if max(abs(px[k] - px[goal]), abs(py[k] - py[goal])) < 1.6 * cell:
            around[0], found = goal, 1
    for j in range(max(row - 1, 0), min(row + 1, ny - 1) + 1):
        for i in range(max(column - 1, 0), min(column + 1, nx - 1) + 1):
            if (i != column or j != row or reach == 2) and found < 9:
                around[found] = j * nx + i
                found += 1
    return found


def kept(world, start, goal, robot, margin):
    """Edges (k, 4), the distance to keep from each, and a box round all (m)."""
    query = ask(world, start, goal, robot, margin)
    edge = world.edges.reshape(-1, 4)
    keep = np.repeat(query.turning_radii, world.edge_counts)
    points = np.concatenate([edge.reshape(-1, 2), [query.start, query.goal]])
    around = AROUND * keep.max(initial=query.robot.radius)
    return query, edge, keep - query.round_off, points.min(0) - around, points.max(0) + around


def theta_star(world, start, goal, robot, margin):
    """Lazy Theta* on a grid on which the start is."""
    query, edge, keep, low, high = kept(world, start, goal, robot, margin)
    cell = CELL * (query.robot.radius + query.margin / 2)
    corner = query.start - np.ceil((query.start - low) / cell) * cell
    nx, ny = (np.ceil((high - corner) / cell).astype(int) + 1).tolist()
    ends = *query.goal.tolist(), *query.start.tolist()
    track = lazy_theta_star(*corner.tolist(), cell, nx, ny, *ends, edge, keep)
    return track if len(track) else None


@functools.cache
def quiet_ompl():
    """Switch OMPL's log off and seed it, which it allows once."""
    from ompl import util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(1)


def ompl(world, start, goal, robot, margin, method, seconds):
    """One of OMPL's sampling planners, simplified."""
    from ompl import base, geometric

    quiet_ompl()
    query, edge, keep, low, high = kept(world, start, goal, robot, margin)
    space, bounds = base.RealVectorStateSpace(2), base.RealVectorBounds(2)
    for axis in (0, 1):
        bounds.setLow(axis, float(low[axis]))
        bounds.setHigh(axis, float(high[axis]))
    space.setBounds(bounds)

    class Motions(base.MotionValidator):
        def checkMotion(self, one, other):  # noqa: N802 (OMPL's name)
            return is_clear(one[0], one[1], other[0], other[1], edge, keep)

    setup = geometric.SimpleSetup(space)
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(lambda one: is_clear(one[0], one[1], one[0], one[1], edge, keep))
    setup.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    setup.getSpaceInformation().setMotionValidator(Motions(information))
    states = [space.allocState(), space.allocState()]
    for state, position in zip(states, (query.start, query.goal), strict=True):
        state[0], state[1] = position.tolist()
    setup.setStartAndGoalStates(*states)
    setup.setPlanner(getattr(geometric, method)(information))
    end = time.process_time() + seconds
    setup.solve(base.PlannerTerminationCondition(lambda: time.process_time() > end))
    if not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution()
    return [(one[0], one[1]) for one in setup.getSolutionPath().getStates()]


def triangulation(world, start, goal, robot, margin):
    """A* over the triangles between polygons round the obstacles, and a funnel."""
    from cdt_path import Triangulation
    from cdt_path.pathplan import a_star_search_G, funnel, tri_to_funnel_plus

    query, _, _, low, high = kept(world, start, goal, robot, margin)
    # Round a polygon's corner GEOS makes steps that are up to half as wide again.
    step = np.where(world.radii > 0, 1.0, 1.5) * math.pi / CORNERS
    grown = query.turning_radii / np.cos(step)
    parts = shapely.buffer(world.cores, grown, quad_segs=CORNERS // 4)
    merged = shapely.get_parts(shapely.union_all(parts, grid_size=1e-7))
    filled = shapely.get_parts(shapely.union_all(shapely.polygons([p.exterior for p in merged])))
    rings = [shapely.get_coordinates(part.exterior)[:-1] for part in filled]
    outer = [low, (high[0], low[1]), high, (low[0], high[1])]
    sizes = np.array([4, *map(len, rings)])
    first = np.cumsum(sizes) - sizes
    here = np.arange(sizes.sum())
    # Each corner is joined to the next of its ring, the last one to the first.
    after = here + 1
    after[first + sizes - 1] = first
    holes = [one.point_on_surface().coords[0] for one in filled]
    plane = {"vertices": np.concatenate([outer, *rings]), "segments": np.c_[here, after]}
    triangles = Triangulation(plane | ({"holes": holes} if holes else {}))
    find = triangles.get_trifinder()
    begin, end = int(find(*query.start)), int(find(*query.goal))
    if min(begin, end) < 0:
        return None
    if begin == end:
        return [query.start, query.goal]
    before, _ = a_star_search_G(triangles, begin, end)
    if end not in before:
        return None
    passed, k = [end], before[end]
    while k != begin:
        passed.append(k)
        k = before[k]
    left, right, sides = tri_to_funnel_plus(triangles, begin, passed)
    corners = np.column_stack([triangles.x, triangles.y])
    walls = [np.concatenate([corners[side], [query.goal]]) for side in (left, right)]
    return np.array([query.start, *funnel(query.start, *walls, sides), query.goal])


#: The rivals from elsewhere by name, and the package that each needs.
ELSEWHERE = {
    "grid, Lazy Theta*": (theta_star, "numba"),
    "OMPL RRT-Connect": (functools.partial(ompl, method="RRTConnect", seconds=PATIENCE), "ompl"),
    **{
        f"OMPL BIT* {budget:g} s": (
            functools.partial(ompl, method="BITstar", seconds=budget),
            "ompl",
        )
        for budget in BUDGETS
    },
    "triangulation": (triangulation, "cdt_path"),
}


def installed():
    """All planners whose packages are there, by name."""
    found = dict(rivals.OF_FREESEG)
    for name, (rival, package) in ELSEWHERE.items():
        try:
            metadata.version(package)
        except metadata.PackageNotFoundError:
            print(f"{name} is left out: {package} is not installed")
        else:
            found[name] = rival
    return found


def pose(case, source=None):
    """As `rivals.pose_question`, and ``("barn", number)``."""
    if case[0] != "barn":
        return rivals.pose_question(case)
    script = barn()
    robot = fs.KheperaIV(diameter=2 * script.RADII[0])
    world = barn_world(source, case[1])
    return rivals.Question(world, script.START, script.GOAL, robot, 0.0)


@functools.cache
def barn():
    """The script on BARN."""
    spec = spec_from_file_location("barn", Path(__file__).with_name("barn.py"))
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@functools.cache
def reading(source):
    """BARN's worlds as they are read, and those that have been, by number."""
    return barn().read(source), {}


def barn_world(source, number):
    """One of BARN's worlds; only as many are read as are asked for."""
    worlds, known = reading(source)
    while number not in known:
        found, world, _ = next(worlds)
        known[found] = world
    return known[number]


def warm_up(present):
    """Have all rivals import and compile what they need."""
    world = fs.random_world(100, 1)
    start, goal = fs.random_query(world, 1)
    for rival in present.values():
        try:
            rival(world, start, goal, fs.KheperaIV(), 0.005)
        except fs.Trapped:
            continue


def pose_grown(case):
    """A world of so many discs, at the density of the sparse ones, and a query."""
    n, seed = case
    world = fs.random_world(n, seed)
    return rivals.Question(world, *fs.random_query(world, seed))


def grow(sizes=SIZES, each=EACH, file=FILE):
    """Time against the number of obstacles: print medians and the exponent, and store rows."""
    asked = {rivals.EXACT: fs.shortest_path, "triangulation": triangulation}
    warm_up(asked)
    rows = [
        {"n": row["set"], "seed": row["question"]}
        | {name: row[name] for name in ("rival", "outcome")}
        | {name: round(row[name], 6) for name in ("length_m", "optimum_m", "ms")}
        for row in rivals.compare(
            [(n, seed) for seed in range(each) for n in sizes], asked, pose_grown
        )
    ]
    for name in asked:
        some = [row for row in rows if row["rival"] == name]
        n, ms = (np.array([row[key] for row in some], float) for key in ("n", "ms"))
        medians = ", ".join(f"{size}: {np.median(ms[n == size]):.1f} ms" for size in sizes)
        large = n >= 1000
        if large.any():
            k, _, low, high = theilslopes(np.log(ms[large]), np.log(n[large]))
            medians += f"; exponent from 1000 on {k:.2f} [{low:.2f}, {high:.2f}]"
        print(f"{name:15s}{medians}")
    if file:
        write_csv(file, rows)


def show(rows):
    """Print a table for each set."""
    last = None
    for row in rows:
        kind, rival, questions, solvable, *_ = row.values()
        if kind != last:
            last = kind
            print(f"\n{kind}: {questions} questions, {solvable} with a path")
            print(" " * 24 + "".join(f"{name:>13s}" for name in list(row)[4:]))
        values = (f"{v:13.4g}" if isinstance(v, float) else f"{v:13d}" for v in [*row.values()][4:])
        print(f"{rival:24s}" + "".join(values))


def main(arguments=None):
    """Compare, print and store."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--worlds", type=int, default=667, help="of each density and of BARN, at most"
    )
    parser.add_argument("--barn", help="folder of BARN's files, or its arrays")
    parser.add_argument("--store", help="folder where what is done is kept")
    parser.add_argument("--quick", action="store_true", help="few questions, nothing stored")
    parser.add_argument("--grow", action="store_true", help="ever larger worlds instead")
    options = parser.parse_args(arguments)
    if options.grow:
        grow()
        return
    worlds = 1 if options.quick else options.worlds
    cases = [("paper", name) for name in fs.load_cases()][: 2 if options.quick else None]
    # Of all sets in turn, so that a run in the same store may ask for more.
    barns = BARN if options.barn else 0
    for number in range(worlds):
        cases += [(name, number) for name in rivals.DENSITIES]
        cases += [("barn", number)] if number < barns else []
    present = installed()
    warm_up(present)
    where = functools.partial(pose, source=options.barn)
    # One after the other: two at once would slow each other down.
    present |= reacting.reactive_rivals()
    asked = rivals.compare(cases, present, where, jobs=1, store=options.store)
    rows = rivals.summarise(asked)
    show(rows)
    if not options.quick:
        rivals.save_rivals(asked)


if __name__ == "__main__":
    main()
