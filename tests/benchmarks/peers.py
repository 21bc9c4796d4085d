"""Compare freeseg with public planners on the same random worlds of discs.

The peers are no part of freeseg's environment; give them one of their own, with
Python 3.12 or 3.13 to have them all::

    pip install -r environment.txt -r tests/benchmarks/peers.txt
    python tests/benchmarks/peers.py            # some minutes
    python tests/benchmarks/peers.py --quick    # seconds, only to see that it runs

Every planner plans for the robot's centre, which keeps R_D from the discs. Peers
that need polygons are given regular 16-gons round the circles of radius R_D, merged
where they overlap, with enclosed pockets filled; this conversion is not timed.
The others are given the circles. Start and goal lie outside of these polygons, so
that every planner can find a way, and discs bar the straight one, so that it must.

All planners take turns on one world after the other, so that a slow moment of the
machine hits all of them alike. Each prepares the world and answers two different
queries; the time of the first path includes the preparation. freeseg prepares what
it needs when it is first asked.

A path is invalid if it does not lead from start to goal, or comes closer than R_r to
a disc. Valid ones have a length ratio: to the optimum, `freeseg.shortest_path`. No path
that keeps R_D has a ratio below one; a valid one that has, uses some of the margin.
"""

import argparse
import functools
import gc
import itertools
import platform
import statistics
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, fields
from importlib import metadata

import numpy as np
import shapely

import freeseg as fs
from freeseg.data import write_csv
from freeseg.geometry import cross, unit
from freeseg.segments import MARGIN
from freeseg.studies import runner

#: Clearance (m) that a legal path has at least, and that planners are to keep.
R_R = fs.KheperaIV().radius
R_D = R_R + MARGIN / 2

#: Corners of the polygon round a circle.
CORNERS = 16

#: Cell of the grid search (m).
CELL = 0.005

#: Free width (m) round the outermost centres of discs: every query is within.
BORDER = 0.4

#: Distance (m) below which lengths and clearances count as equal.
ROUND_OFF = 1e-6


@dataclass(frozen=True, eq=False)
class Task:
    """A world and two queries, in the formats of all planners.

    Parameters
    ----------
    world : World
        Discs.
    centers : ndarray, shape (n, 2)
        Centres of the discs (m).
    reach : ndarray, shape (n,)
        Distance that the robot's centre keeps from each of them (m).
    polygons : list of shapely.Polygon
        Disjoint, without holes, counter-clockwise.
    queries : list of (start, goal)
        Positions (m), outside of the polygons, no straight way between them.
    optima : list of float
        Length of the shortest path of each query (m).
    """

    world: fs.World
    centers: np.ndarray
    reach: np.ndarray
    polygons: list
    queries: list
    optima: list

    @property
    def box(self):
        """Corners (m) of a rectangle round everything: (xmin, ymin), (xmax, ymax)."""
        return self.centers.min(0) - BORDER, self.centers.max(0) + BORDER


def make_task(n, seed):
    """World number `seed` of n discs with two queries, or None where one has no path."""
    world = fs.random_world(n, seed)
    centers = np.array([disc.center for disc in world.obstacles])
    reach = world.radii + R_D
    polygons = merged_polygons(centers, reach)
    obstacle = shapely.multipolygons(polygons)
    shapely.prepare(obstacle)
    queries = (fs.random_query(world, seed) for seed in itertools.count(1000 * seed))
    posed = (query for query in queries if is_posed(query, world, obstacle))
    pair = list(itertools.islice(posed, 2))
    try:
        optima = [fs.shortest_path(world, *query).path.length for query in pair]
    except fs.NoPath:
        return None
    return Task(world, centers, reach, polygons, pair, optima)


def is_posed(query, world, obstacle):
    """Whether start and goal are outside of the polygons, and a disc bars the straight way."""
    outside = not shapely.intersects_xy(obstacle, query).any()
    return outside and (world.distances(shapely.LineString(query)) < R_D).any()


def merged_polygons(centers, radii):
    """Polygons round circles: merged, holes filled, counter-clockwise."""
    # Each polygon is rotated differently, as corners in line trouble some planners.
    turns = np.arange(CORNERS) + np.arange(len(centers))[:, None] * np.sqrt(2)
    corners = unit(2 * np.pi / CORNERS * turns) / np.cos(np.pi / CORNERS)
    parts = shapely.polygons(centers[:, None] + radii[:, None, None] * corners)
    # Rounded to 1 µm, as pyvisgraph's author advises against round-off.
    merged = shapely.union_all(parts, grid_size=1e-6)
    filled = shapely.polygons(shapely.get_exterior_ring(shapely.get_parts(merged)))
    outer = shapely.get_parts(shapely.union_all(filled))
    return shapely.orient_polygons(outer).tolist()


def outline(polygon):
    """Corners of a polygon (m), shape (n, 2), the first one not repeated."""
    return shapely.get_coordinates(polygon)[:-1]


# Planners: each prepares a task and returns a function from start and goal to a path.


def freeseg_plan(task):
    """freeseg's free-segment planner; what it prepares is in its first query."""
    world = fs.World(task.world.obstacles)
    planner = fs.with_fallback(fs.plan_rooms, fs.shortest_path)
    return lambda start, goal: planner(world, start, goal).path


def freeseg_shortest(task):
    """freeseg's exact planner."""
    world = fs.World(task.world.obstacles)
    return lambda start, goal: fs.shortest_path(world, start, goal).path


def extremitypathfinder(task):
    """A reduced visibility graph in Python, with Numba where installed."""
    from extremitypathfinder import PolygonEnvironment

    environment = PolygonEnvironment()
    around = outline(shapely.orient_polygons(shapely.box(*np.ravel(task.box))))
    # It wants the boundary counter-clockwise and the holes clockwise.
    environment.store(around, [outline(polygon)[::-1] for polygon in task.polygons])
    return lambda start, goal: environment.find_shortest_path(start, goal)[0]


def pyvisgraph(task):
    """A visibility graph by Lee's sweep, in pure Python."""
    from pyvisgraph import Point, VisGraph

    graph = VisGraph()
    graph.build([[Point(*xy) for xy in outline(one)] for one in task.polygons], status=False)

    def query(start, goal):
        return [(point.x, point.y) for point in graph.shortest_path(Point(*start), Point(*goal))]

    return query


def networkx_shapely(task):
    """A visibility graph of tangents only, written with NumPy, Shapely and networkx."""
    import networkx as nx

    outlines = [outline(polygon) for polygon in task.polygons]
    point = np.concatenate(outlines)
    back = np.concatenate([np.roll(one, 1, 0) for one in outlines]) - point
    on = np.concatenate([np.roll(one, -1, 0) for one in outlines]) - point
    convex = cross(on, back) > 0
    point, back, on = point[convex], back[convex], on[convex]
    # A segment may touch a polygon.
    tree = shapely.STRtree(shapely.buffer(task.polygons, -1e-7, join_style="mitre"))

    def touches(corner, direction):
        return cross(back[corner], direction) * cross(on[corner], direction) >= -1e-18

    def free(start, ends):
        """Which of the segments from one point to others meet no polygon."""
        segments = shapely.linestrings(np.stack([np.broadcast_to(start, ends.shape), ends], 1))
        seen = np.ones(len(ends), bool)
        seen[tree.query(segments, predicate="intersects")[0]] = False
        return seen

    def edges(node, start, corners):
        """Graph edges from a point to those corners that it sees and where it can go on."""
        corners = corners[touches(corners, point[corners] - start)]
        corners = corners[free(start, point[corners])]
        lengths = np.hypot(*(point[corners] - start).T)
        return zip(itertools.repeat(node), corners.tolist(), lengths.tolist())

    graph, every = nx.Graph(), np.arange(len(point))
    graph.add_nodes_from(every.tolist())
    for node, start in enumerate(point):
        later = every[node + 1 :]
        later = later[touches(node, point[later] - start)]
        graph.add_weighted_edges_from(edges(node, start, later))

    def query(start, goal):
        if free(start, goal[None]).all():
            return [start, goal]
        graph.add_weighted_edges_from(edges("start", start, every))
        graph.add_weighted_edges_from(edges("goal", goal, every))
        where = {"start": start, "goal": goal}
        way = nx.bidirectional_dijkstra(graph, "start", "goal")[1]
        graph.remove_nodes_from(where)
        return [where[node] if node in where else point[node] for node in way]

    return query


def skimage_grid(task):
    """The cheapest way over a grid of eight neighbours, as it comes: not smoothed."""
    from skimage.draw import disk
    from skimage.graph import MCP_Geometric

    low, high = task.box
    costs = np.ones(np.ceil((high - low) / CELL).astype(int) + 1)
    for center, reach in zip(task.centers, task.reach, strict=True):
        costs[disk((center - low) / CELL, reach / CELL, shape=costs.shape)] = np.inf

    def query(start, goal):
        # The cells of start and goal may be blocked although start and goal are not.
        cells = [tuple(np.rint((end - low) / CELL).astype(int).tolist()) for end in (start, goal)]
        opened = costs.copy()
        opened[tuple(np.transpose(cells))] = 1
        search = MCP_Geometric(opened)
        search.find_costs(cells[:1], cells[1:])
        way = low + CELL * np.array(search.traceback(cells[1]))
        return [start, *way[1:-1], goal]

    return query


@functools.cache
def quiet_ompl():
    """Switch OMPL's log off and seed it, which it allows once."""
    from ompl import util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(1)


def ompl(task, method, seconds, simplify=False):
    """One of OMPL's sampling planners, with an exact check of motions in NumPy."""
    from ompl import base, geometric

    quiet_ompl()
    space, bounds = base.RealVectorStateSpace(2), base.RealVectorBounds(2)
    for axis, (low, high) in enumerate(zip(*task.box, strict=True)):
        bounds.setLow(axis, low)
        bounds.setHigh(axis, high)
    space.setBounds(bounds)
    squares = task.reach**2

    def clear(start, end):
        """Whether a straight motion keeps away from all discs."""
        start = np.array([start[0], start[1]])
        motion = np.array([end[0], end[1]]) - start
        offset = task.centers - start
        along = np.clip(offset @ motion / max(motion @ motion, 1e-300), 0, 1)
        offset -= along[:, None] * motion
        return bool((np.einsum("ij,ij->i", offset, offset) >= squares).all())

    class Motions(base.MotionValidator):
        def checkMotion(self, start, end):  # noqa: N802 (OMPL's name)
            return clear(start, end)

    def state(position):
        result = space.allocState()
        result[0], result[1] = position.tolist()
        return result

    def query(start, goal):
        setup = geometric.SimpleSetup(space)
        information = setup.getSpaceInformation()
        setup.setStateValidityChecker(lambda one: clear(one, one))
        information.setMotionValidator(Motions(information))
        setup.setStartAndGoalStates(state(start), state(goal))
        setup.setPlanner(getattr(geometric, method)(information))
        setup.solve(seconds)
        if not setup.haveExactSolutionPath():
            return None
        if simplify:
            setup.simplifySolution()
        return [(one[0], one[1]) for one in setup.getSolutionPath().getStates()]

    return query


@dataclass(frozen=True)
class Planner:
    """What prepares, the package that it needs, and the most discs that it is given."""

    prepare: Callable
    package: str
    most: int = 10**9


#: All planners by name. A limit keeps the default run within minutes.
PLANNERS = {
    "freeseg plan": Planner(freeseg_plan, "freeseg"),
    "freeseg shortest_path": Planner(freeseg_shortest, "freeseg"),
    "extremitypathfinder": Planner(extremitypathfinder, "extremitypathfinder", 50),
    "pyvisgraph": Planner(pyvisgraph, "pyvisgraph", 20),
    "networkx + Shapely": Planner(networkx_shapely, "networkx", 200),
    "scikit-image grid": Planner(skimage_grid, "scikit-image", 200),
    "OMPL RRTConnect": Planner(
        functools.partial(ompl, method="RRTConnect", seconds=10, simplify=True), "ompl"
    ),
    "OMPL BIT* 0.1 s": Planner(functools.partial(ompl, method="BITstar", seconds=0.1), "ompl"),
    "OMPL BIT* 1 s": Planner(functools.partial(ompl, method="BITstar", seconds=1), "ompl"),
}


@dataclass
class Tally:
    """What one planner did on all worlds of one size."""

    prepare: list = field(default_factory=list)
    first: list = field(default_factory=list)
    following: list = field(default_factory=list)
    ratios: list = field(default_factory=list)
    wrong: Counter = field(default_factory=Counter)

    def row(self):
        """Medians and counts by name; "-" for what there is none of."""
        row = {
            name: f"{1e3 * statistics.median(times):.2f}" if times else "-"
            for name, times in (
                ("prepare ms", self.prepare),
                ("first ms", self.first),
                ("next ms", self.following),
            )
        }
        row |= {
            name: f"{statistic(self.ratios):.4f}" if self.ratios else "-"
            for name, statistic in (("ratio", statistics.median), ("worst", max))
        }
        row["paths"] = len(self.ratios)
        row["failed"] = sum(self.wrong.values()) - self.wrong["invalid"]
        row["invalid"] = self.wrong["invalid"]
        row["below 1"] = sum(ratio < 1 - ROUND_OFF for ratio in self.ratios)
        return row


def timed(action, *arguments):
    """What an action returns, and its time (s)."""
    begin = time.perf_counter()
    result = action(*arguments)
    return result, time.perf_counter() - begin


def measure(prepare, task, tally):
    """Let one planner prepare a task and answer its queries; add to its tally."""
    gc.collect()
    try:
        query, preparing = timed(prepare, task)
    except Exception as error:
        tally.wrong[f"{type(error).__name__} while preparing: {error}"] += len(task.queries)
        return
    tally.prepare.append(preparing)
    for number, ((start, goal), optimum) in enumerate(zip(task.queries, task.optima, strict=True)):
        try:
            path, seconds = timed(query, start, goal)
        except Exception as error:
            tally.wrong[f"{type(error).__name__}: {error}"] += 1
            continue
        if number == 0:
            tally.first.append(preparing + seconds)
        else:
            tally.following.append(seconds)
        verdict = judge(task, start, goal, path)
        if isinstance(verdict, str):
            tally.wrong[verdict] += 1
        else:
            tally.ratios.append(verdict / optimum)


def points_of(path):
    """Points (m) along a path: a freeseg one is sampled, any other is their list."""
    return np.asarray(path.sample(0.001) if isinstance(path, fs.Path) else path, float)


def judge(task, start, goal, path):
    """Length of a path (m), or what is wrong with it."""
    if path is None or len(points := points_of(path)) < 2:
        return "no path"
    line = shapely.LineString(points)
    clearance = (shapely.distance(shapely.points(task.centers), line) - task.world.radii).min()
    off = np.abs(points[[0, -1]] - [start, goal]).max()
    if off > ROUND_OFF or clearance < R_R - ROUND_OFF:
        return "invalid"
    return path.length if isinstance(path, fs.Path) else line.length


def installed(package):
    """Version of a package, or None."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def run(sizes, worlds):
    """Tally of every installed planner and size: dict of (n, name) to `Tally`."""
    present = [
        name
        for name, planner in PLANNERS.items()
        if planner.package == "freeseg" or installed(planner.package)
    ]
    warm_up = make_task(5, seed=0)
    for name in present:
        # Imports and Numba's compilation are not measured.
        measure(PLANNERS[name].prepare, warm_up, Tally())
    tallies = {(n, name): Tally() for n in sizes for name in present if n <= PLANNERS[name].most}
    cases = list(itertools.product(range(worlds), sizes))
    # One after the other: two at once would slow each other down.
    for row in runner.run(functools.partial(take_turns, present), cases, jobs=1, strict=True):
        tally = tallies[row["n"], row["planner"]]
        for one in fields(Tally):
            values = getattr(tally, one.name)
            (values.update if one.name == "wrong" else values.extend)(row[one.name])
    return tallies


def take_turns(present, case, _):
    """What every planner did on one world, the case (number, n): a row each."""
    number, n = case
    if (task := make_task(n, seed=number + 1)) is None:
        return
    for name in present[number % len(present) :] + present[: number % len(present)]:
        if n <= PLANNERS[name].most:
            measure(PLANNERS[name].prepare, task, tally := Tally())
            yield {"n": n, "planner": name} | asdict(tally) | {"wrong": [*tally.wrong.elements()]}


def show(tallies):
    """Print the table, what went wrong, and who took part."""
    print("Times are medians. Ratio: length to the optimum, median and worst.\n")
    for n, group in itertools.groupby(tallies.items(), lambda item: item[0][0]):
        for number, ((_, name), tally) in enumerate(group):
            row = tally.row()
            if number == 0:
                print(f"{n:4d} discs{'':14s}" + "".join(f"{key:>11s}" for key in row))
            print(f"  {name:22s}" + "".join(f"{value:>11}" for value in row.values()))
        print()
    for (n, name), tally in tallies.items():
        for what, times in tally.wrong.items():
            print(f"{name}, {n} discs, {times} times: {what}")
    largest = max(n for n, _ in tallies)
    for name, planner in PLANNERS.items():
        if planner.most < largest:
            print(f"{name} is asked up to {planner.most} discs only: it would take too long")
    needed = dict.fromkeys(planner.package for planner in PLANNERS.values())
    print(f"Python {platform.python_version()} on {platform.machine()}")
    for package in (*needed, "numba", "numpy", "scipy", "shapely"):
        print(f"{package} {installed(package) or 'not installed'}")


def main(arguments=None):
    """Run the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[7, 20, 50, 100], metavar="N")
    parser.add_argument("--worlds", type=int, default=10, help="worlds of each size")
    parser.add_argument("--quick", action="store_true", help="one world of 7 discs")
    parser.add_argument("--csv", metavar="FILE", help="write the table there, too")
    options = parser.parse_args(arguments)
    sizes, worlds = ([7], 1) if options.quick else (options.sizes, options.worlds)
    tallies = run(sizes, worlds)
    show(tallies)
    if options.csv:
        rows = [{"discs": n, "planner": name} | tally.row() for (n, name), tally in tallies.items()]
        write_csv(options.csv, rows)


if __name__ == "__main__":
    main()
