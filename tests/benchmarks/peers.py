"""Compare freeseg with public planners on the same random worlds, of discs and of polygons.

The peers are no part of freeseg's environment; give them one of their own, with
Python 3.12 or 3.13 to have them all::

    pip install -r environment.txt -r tests/benchmarks/peers.txt
    python tests/benchmarks/peers.py            # some minutes
    python tests/benchmarks/peers.py --quick    # seconds, only to see that it runs

Every planner plans for the robot's centre, which keeps R_D from the obstacles. Peers
that need polygons are given regular 16-gons round the circles of radius R_D (of a
polygon: the hull of those round its corners), merged where they overlap, with enclosed
pockets filled; this conversion is not timed. The others are given the obstacles. Start
and goal lie outside of these polygons, so that every planner can find a way, and
obstacles bar the straight one, so that it must.

All planners take turns on one world after the other, so that a slow moment of the
machine hits all of them alike. Each prepares the world and answers two different
queries; the time of the first path includes the preparation. freeseg prepares what
it needs when it is first asked.

A path is invalid if it does not lead from start to goal, or comes closer than R_r to
an obstacle. Valid ones have a length ratio: to the optimum, `freeseg.shortest_path`. No path
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
from shapely.affinity import rotate

import freeseg as fs
from freeseg.data import write_csv
from freeseg.geometry import cross
from freeseg.segments import MARGIN
from freeseg.studies import runner

#: Clearance (m) that a legal path has at least, and that planners are to keep.
R_R = fs.KheperaIV().radius
R_D = R_R + MARGIN / 2

#: Corners of the polygon round a circle.
CORNERS = 16

#: Cell of the grid search (m).
CELL = 0.005

#: Free width (m) round the outermost centres and corners: every query is within.
BORDER = 0.4

SHAPES = "disc", "polygon"

#: Distance (m) below which lengths and clearances count as equal.
ROUND_OFF = 1e-6


@dataclass(frozen=True, eq=False)
class Task:
    """A world and two queries, in the formats of all planners.

    Parameters
    ----------
    world : World
        Discs, or polygons.
    polygons : list of shapely.Polygon
        Disjoint, without holes, counter-clockwise.
    queries : list of (start, goal)
        Positions (m), outside of the polygons, no straight way between them.
    optima : list of float
        Length of the shortest path of each query (m).
    """

    world: fs.World
    polygons: list
    queries: list
    optima: list

    @property
    def box(self):
        """Corners (m) of a rectangle round everything: (xmin, ymin), (xmax, ymax)."""
        return self.world.edges.min((0, 1)) - BORDER, self.world.edges.max((0, 1)) + BORDER

    @property
    def reach(self):
        """Distance (m) that the robot's centre keeps from the core of each obstacle."""
        return self.world.radii + R_D


def make_task(n, seed, shape):
    """World number `seed` of n obstacles with two queries, or None where one has no path."""
    world = fs.random_world(n, seed, (shape,))
    polygons = merged_polygons(world)
    obstacle = shapely.multipolygons(polygons)
    shapely.prepare(obstacle)
    queries = (fs.random_query(world, seed) for seed in itertools.count(1000 * seed))
    posed = (query for query in queries if is_posed(query, world, obstacle))
    pair = list(itertools.islice(posed, 2))
    try:
        optima = [fs.shortest_path(world, *query).path.length for query in pair]
    except fs.NoPath:
        return None
    return Task(world, polygons, pair, optima)


def is_posed(query, world, obstacle):
    """Whether start and goal are outside of the polygons, and something bars the straight way."""
    outside = not shapely.intersects_xy(obstacle, query).any()
    return outside and (world.distances(shapely.LineString(query)) < R_D).any()


def merged_polygons(world):
    """Polygons round obstacles grown by R_D: merged, holes filled, counter-clockwise."""
    reach = (world.radii + R_D) / np.cos(np.pi / CORNERS)
    parts = shapely.buffer(world.cores, reach, quad_segs=CORNERS // 4)
    # Each disc's is rotated differently, as corners in line trouble some planners.
    turn = 360 / CORNERS * np.sqrt(2)
    parts = [rotate(part, k * turn) if world.radii[k] else part for k, part in enumerate(parts)]
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
    from skimage.draw import polygon as fill
    from skimage.graph import MCP_Geometric

    low, high = task.box
    costs = np.ones(np.ceil((high - low) / CELL).astype(int) + 1)
    for grown in shapely.buffer(task.world.cores, task.reach, quad_segs=32):
        corners = (shapely.get_coordinates(grown.exterior) - low) / CELL
        costs[fill(*corners.T, shape=costs.shape)] = np.inf

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


def clear_of_discs(task):
    """Exact check of a straight motion among discs, in NumPy."""
    centers, squares = task.world.edges[:, 0], task.reach**2

    def clear(start, end):
        start = np.array([start[0], start[1]])
        motion = np.array([end[0], end[1]]) - start
        offset = centers - start
        along = np.clip(offset @ motion / max(motion @ motion, 1e-300), 0, 1)
        offset = offset - along[:, None] * motion
        return bool((np.einsum("ij,ij->i", offset, offset) >= squares).all())

    return clear


def clear_of_polygons(world):
    """Exact check of a straight motion among polygons, with Shapely's tree."""
    tree = shapely.STRtree(world.cores)

    def clear(start, end):
        motion = shapely.linestrings([[start[0], start[1]], [end[0], end[1]]])
        return len(tree.query(motion, "dwithin", distance=R_D)) == 0

    return clear


def ompl(task, method, seconds, simplify=False):
    """One of OMPL's sampling planners, with an exact check of motions."""
    from ompl import base, geometric

    quiet_ompl()
    space, bounds = base.RealVectorStateSpace(2), base.RealVectorBounds(2)
    for axis, (low, high) in enumerate(zip(*task.box, strict=True)):
        bounds.setLow(axis, low)
        bounds.setHigh(axis, high)
    space.setBounds(bounds)
    clear = clear_of_polygons(task.world) if task.world.radii[0] == 0 else clear_of_discs(task)

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
    """What prepares, the package that it needs, and the most obstacles that it is given."""

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
        # The slowest first path stands beside the median.
        row["slowest ms"] = f"{1e3 * max(self.first):.2f}" if self.first else "-"
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
    clearance = task.world.distances(line).min()
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
    """Tally of every installed planner, shape and size: dict of (shape, n, name) to `Tally`."""
    present = [
        name
        for name, planner in PLANNERS.items()
        if planner.package == "freeseg" or installed(planner.package)
    ]
    warm_up = make_task(5, 0, "disc")
    for name in present:
        # Imports and Numba's compilation are not measured.
        measure(PLANNERS[name].prepare, warm_up, Tally())
    tallies = {
        (shape, n, name): Tally()
        for shape, n in itertools.product(SHAPES, sizes)
        for name in present
        if n <= PLANNERS[name].most
    }
    cases = list(itertools.product(range(worlds), SHAPES, sizes))
    # One after the other: two at once would slow each other down.
    for row in runner.run(functools.partial(take_turns, present), cases, jobs=1, strict=True):
        tally = tallies[row["shape"], row["n"], row["planner"]]
        for one in fields(Tally):
            values = getattr(tally, one.name)
            (values.update if one.name == "wrong" else values.extend)(row[one.name])
    return tallies


def take_turns(present, case, _):
    """What every planner did on one world, the case (number, shape, n): a row each."""
    number, shape, n = case
    if (task := make_task(n, number + 1, shape)) is None:
        return
    for name in present[number % len(present) :] + present[: number % len(present)]:
        if n <= PLANNERS[name].most:
            measure(PLANNERS[name].prepare, task, tally := Tally())
            found = asdict(tally) | {"wrong": [*tally.wrong.elements()]}
            yield {"shape": shape, "n": n, "planner": name} | found


def show(tallies):
    """Print the table, what went wrong, and who took part."""
    print("Times are medians. Ratio: length to the optimum, median and worst.\n")
    for (shape, n), group in itertools.groupby(tallies.items(), lambda item: item[0][:2]):
        for number, ((_, _, name), tally) in enumerate(group):
            row = tally.row()
            if number == 0:
                print(f"{n:4d} {shape + 's':19s}" + "".join(f"{key:>11s}" for key in row))
            print(f"  {name:22s}" + "".join(f"{value:>11}" for value in row.values()))
        print()
    for (shape, n, name), tally in tallies.items():
        for what, times in tally.wrong.items():
            print(f"{name}, {n} {shape}s, {times} times: {what}")
    largest = max(n for _, n, _ in tallies)
    for name, planner in PLANNERS.items():
        if planner.most < largest:
            print(f"{name} is asked up to {planner.most} obstacles only: it would take too long")
    needed = dict.fromkeys(planner.package for planner in PLANNERS.values())
    print(f"Python {platform.python_version()} on {platform.machine()}")
    for package in (*needed, "numba", "numpy", "scipy", "shapely"):
        print(f"{package} {installed(package) or 'not installed'}")


def main(arguments=None):
    """Run the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[7, 20, 50, 100], metavar="N")
    parser.add_argument("--worlds", type=int, default=10, help="worlds of each size")
    parser.add_argument("--quick", action="store_true", help="one world of 7 of each shape")
    parser.add_argument("--csv", metavar="FILE", help="write the table there, too")
    options = parser.parse_args(arguments)
    sizes, worlds = ([7], 1) if options.quick else (options.sizes, options.worlds)
    tallies = run(sizes, worlds)
    show(tallies)
    if options.csv:
        rows = [
            {"shape": shape, "n": n, "planner": name} | tally.row()
            for (shape, n, name), tally in tallies.items()
        ]
        write_csv(options.csv, rows)


if __name__ == "__main__":
    main()
