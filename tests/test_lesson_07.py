"""The lines of lesson 07 against the package, and against brute force without its geometry."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import shapely
from lessons import definitions
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.geometry import cross
from freeseg.path import taut_path
from freeseg.plan import turning_radius
from freeseg.planners.query import ask
from freeseg.plotting import plot_clearance, plot_round
from freeseg.segments import MARGIN

STEM = "07_find_the_shortest_path"
CASES = sorted(fs.load_cases())
ROBOT = fs.KheperaIV()
R_R, R_D = ROBOT.radius, turning_radius(ROBOT, MARGIN)


@pytest.fixture(scope="module")
def shown():
    """What the lesson defines, by name."""
    names = "queries", "plans", "best", "shortest_among", "exact_loop", "literal", "courtyard"
    names += "reshape", "solved_by", "shapes"
    return definitions(STEM, *names)


@pytest.fixture(autouse=True)
def close_figures():
    plt.switch_backend("Agg")
    yield
    plt.close("all")


# --- the exact loop ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES)
def test_the_loop_ends_with_the_optimum_and_only_climbs(shown, name):
    query, best = shown["queries"][name], shown["best"][name]
    rounds = shown["exact_loop"](*query)
    lengths = [path.length for path, _ in rounds]
    assert_allclose(lengths[-1], [best.path.length, best.lower_bound], rtol=0, atol=1e-12)
    assert (np.diff(lengths) >= -1e-12).all()
    assert rounds[-1][0].clearance(query[0]) >= R_D - 1e-9
    # No obstacle is met twice, and the last round is the only one without danger.
    assert all(len(set(met)) == len(met) for _, met in rounds)
    assert all(path.clearance(query[0]) < R_D - 1e-9 for path, _ in rounds[:-1])


def by_trying(world, start, goal):
    """Length and turns of the shortest path that uses each circle at most once.

    All orders and senses, as long as what has been driven and the straight rest are shorter than
    the best so far. Nothing of the package's geometry is used: points are complex numbers.
    """
    centers = np.array([complex(*disc.center) for disc in world.obstacles])
    keep, end, best = world.radii + R_D, complex(*goal), [np.inf, ()]

    def line_is_clear(a, b):
        share = np.clip(((centers - a) * np.conj(b - a)).real / abs(b - a) ** 2, 0, 1)
        return (abs(a + share * (b - a) - centers) > keep - 1e-9).all()

    def arc_is_clear(middle, first, sense, turned):
        beside = sense * np.angle((centers - middle) / (first - middle)) % (2 * np.pi) <= turned
        gap = abs(abs(centers - middle) - abs(first - middle))
        return (gap > keep - 1e-9)[beside].all()

    def extend(turns, middle, signed, first, length):
        unused = [k for k in range(len(keep)) if k not in [k for k, _ in turns]]
        targets = [(centers[k], s * keep[k], [*turns, (k, s)]) for k in unused for s in (1, -1)]
        for center, radius, more in [(end, 0.0, None), *targets]:
            sine = (radius - signed) / abs(center - middle)
            if abs(sine) > 1:
                continue  # no tangent
            normal = (center - middle) / abs(center - middle) * np.exp(1j * np.arccos(sine))
            leave, join = middle - signed * normal, center - radius * normal
            sense, turned = np.sign(signed), 0.0
            if signed:
                turned = sense * np.angle((leave - middle) / (first - middle)) % (2 * np.pi)
                turned = turned if turned < 2 * np.pi - 1e-9 else 0.0
            total = length + abs(signed) * turned + abs(join - leave)
            if total + abs(end - join) >= best[0] or not line_is_clear(leave, join):
                continue
            if turned and not arc_is_clear(middle, first, sense, turned):
                continue
            if more:
                extend(more, center, radius, join, total)
            else:
                best[:] = total, turns

    begin = complex(*start)
    extend([], begin, 0.0, begin, 0.0)
    return best


@pytest.mark.parametrize("name", CASES)
def test_trying_all_orders_finds_the_same(shown, name):
    length, turns = by_trying(*shown["queries"][name])
    best = shown["best"][name]
    assert length == pytest.approx(best.path.length, rel=0, abs=1e-9)
    assert turns == [(turn.obstacle, turn.sense) for turn in best.turning_points]


@pytest.mark.parametrize("gap", [0.18, 0.147, 0.146, 0.145, 0.10])
def test_the_courtyard_opens_at_twice_the_turning_radius(shown, gap):
    query = shown["courtyard"](gap), (0.40, 0.35), (0.02, 0.30)
    path, met = shown["exact_loop"](*query)[-1]
    if gap > 2 * R_D:
        plan = fs.shortest_path(*query, ROBOT, MARGIN)
        assert plan.path.length == pytest.approx(path.length, rel=0, abs=1e-12)
        return
    assert path is None
    with pytest.raises(fs.NoPath, match="leave no way") as no_path:
        fs.shortest_path(*query, ROBOT, MARGIN)
    assert f"obstacles {[k + 1 for k in sorted(met)]}" in str(no_path.value)


def test_what_is_never_met_has_no_part_in_the_proof(shown):
    star_reach = np.where(np.arange(10) % 2, 0.03, 0.08)
    angles = np.pi / 5 * np.arange(10) + np.pi / 2
    star = (0.05, 0.70) + star_reach[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    world = fs.World([*shown["courtyard"](0.10).obstacles, fs.Polygon(star)])
    path, met = shown["exact_loop"](world, (0.40, 0.35), (0.02, 0.30))[-1]
    assert path is None
    assert sorted(met) == [0, 1]
    with pytest.raises(fs.NoPath, match=r"obstacles \[1, 2\] leave no way"):
        fs.shortest_path(world, (0.40, 0.35), (0.02, 0.30), ROBOT, MARGIN)


# --- where the guess goes wrong ------------------------------------------------------------------


def test_in_15d_the_wrong_side_has_the_better_guess(shown):
    world, start, goal = shown["queries"]["15d"]
    plan, best = shown["plans"]["15d"], shown["best"]["15d"]
    first, repair = plan.steps[1:]
    turn_at_2 = (world.obstacles[1].center, first.chosen.sense * (world.radii[1] + R_D))

    def round_both(sense):
        turn_at_1 = (world.obstacles[0].center, sense * (world.radii[0] + R_D))
        return taut_path(start, [turn_at_1, turn_at_2], goal)[0].length

    taken, other = round_both(repair.chosen.sense), round_both(-repair.chosen.sense)
    assert taken == pytest.approx(plan.path.length, rel=0, abs=1e-12)
    assert other == pytest.approx(best.path.length, rel=0, abs=1e-12)
    ranked = [
        (one.detour, 1 if cross(repair.leg[1] - repair.leg[0], one.endpoint.outward) < 0 else -1)
        for one in repair.candidates
    ]
    least = {side: min(SD for SD, sense in ranked if sense == side) for side in (1, -1)}
    # A few millimetres apart; the paths are ten times as far apart, the other way round.
    gain = least[-repair.chosen.sense] - least[repair.chosen.sense]
    assert 0 < gain < 0.005
    assert taken - other > 8 * gain


# --- word by word --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES)
def test_the_literal_lines_are_literal_plan(shown, name):
    path, turns, why = shown["literal"](*shown["queries"][name])
    with pytest.raises(fs.Trapped) as trapped:
        fs.literal_plan(*shown["queries"][name], ROBOT, MARGIN)
    last = trapped.value.steps[-1]
    assert why is not None
    assert why[0] in str(trapped.value)
    assert f"obstacle {why[1] + 1}" in str(trapped.value)
    assert path.length == pytest.approx(last.path.length, rel=0, abs=1e-12)
    assert len(trapped.value.steps) == 1 + len(turns)


def test_the_literal_circle_cuts_into_its_obstacle(shown):
    own = []
    for name, query in shown["queries"].items():
        path, turns, _ = shown["literal"](*query)
        piece, blocking, d = ask(*query, ROBOT, MARGIN).danger(path)
        line, r = path.pieces[piece], query[0].radii[blocking]
        assert d < R_R
        for end, _ in turns:
            for point in (line.start, line.end):
                normal = (point - end.point) / R_D
                if end.obstacle == blocking and abs(np.hypot(*normal) - 1) < 1e-9:
                    # d = R_D - r (1 - cos phi), so phi is larger than it may be.
                    cosine = normal @ end.outward
                    assert d == pytest.approx(R_D - r * (1 - cosine), rel=0, abs=1e-9)
                    assert np.arccos(cosine) > np.arccos(1 - MARGIN / (2 * r))
                    own.append(name)
    assert len(own) == len(set(own)) == 13


def test_smaller_obstacles_help_the_words(shown):
    solved = {}
    for scale in (1, 0.2, 0.02):
        found = {}
        for name, (world, start, goal) in shown["queries"].items():
            small = fs.World([fs.Disc(o.center, scale * o.radius) for o in world.obstacles])
            found[name] = shown["literal"](small, start, goal)[2]
        solved[scale] = sum(why is None for why in found.values())
    assert solved[1] == 0 < solved[0.2] <= solved[0.02] == 15
    # 13c is left, whatever the size: obstacle 7 has no endpoint there.
    assert found["13c"] == ("no endpoint", 6)
    world = shown["queries"]["13c"][0].obstacles
    assert np.hypot(*(world[5].center - world[6].center)) < ROBOT.diameter + MARGIN


def test_a_larger_circle_helps_up_to_a_point(shown):
    solved = {}
    for radius in (R_D, 0.095, 0.145):
        paths = [shown["literal"](*query, radius) for query in shown["queries"].values()]
        queries = shown["queries"].values()
        for (path, _, why), query in zip(paths, queries, strict=True):
            assert why or path.clearance(query[0]) >= R_R - 1e-9
        solved[radius] = sum(why is None for _, _, why in paths)
    assert solved[R_D] == 0 < solved[0.145] < solved[0.095] == 10


def test_the_rules_solve_more_and_more(shown):
    solved_by, literal = shown["solved_by"], fs.literal_plan
    words, circles = list(solved_by(literal)), list(solved_by(literal, concentric=True))
    both = list(solved_by(literal, concentric=True, outer_endpoints=True))
    assert (len(words), len(circles), len(both)) == (0, 13, 11)
    assert len(list(solved_by(fs.plan))) == 16
    assert max(circles) == pytest.approx(1.659, abs=1e-3)


# --- other shapes --------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", ["triangle", "square", "hexagon", "star"])
def test_other_shapes(shown, shape):
    ratios = []
    for world, start, goal in shown["queries"].values():
        other = shown["reshape"](world, *shown["shapes"][shape])
        # The shapes stand inside of the discs and reach their circles.
        for polygon, disc in zip(other.obstacles, world.obstacles, strict=True):
            reach = np.hypot(*(polygon.vertices - disc.center).T)
            assert reach.max() == pytest.approx(disc.radius)
        plan, best = fs.plan(other, start, goal), fs.shortest_path(other, start, goal)
        line = shapely.LineString(plan.path.sample(0.001))
        assert other.distances(line).min() >= R_R - 2e-6
        ratios.append(plan.path.length / best.path.length)
    assert len(ratios) == 16
    assert max(ratios) <= 1.05
    rounds = shown["exact_loop"](other, start, goal)
    assert rounds[-1][0].length == pytest.approx(best.path.length, rel=0, abs=1e-12)


# --- pictures ------------------------------------------------------------------------------------


def labels(ax):
    return ax.get_legend_handles_labels()[1]


def test_a_round_shows_what_is_met_and_what_is_next(shown):
    world = shown["queries"]["15c"][0]
    rounds = shown["exact_loop"](*shown["queries"]["15c"])
    first = plot_round(world, *rounds[0], ROBOT, MARGIN)
    assert "in danger: met next" in labels(first)
    assert "obstacle met" not in labels(first)
    last = plot_round(world, *rounds[-1], ROBOT, MARGIN)
    assert "in danger: met next" not in labels(last)
    assert {"obstacle met", "$R_D$ from them", "shortest path among them"} <= set(labels(last))
    danger = rounds[1][1]
    assert len(first.patches) == len(danger) + 1  # and the band


def test_a_round_without_a_path(shown):
    ax = plot_round(shown["courtyard"](0.1), None, (0, 1), ROBOT, MARGIN)
    assert "shortest path among them" not in labels(ax)
    # Outside and inside of the ring.
    assert len(ax.lines) == 2


def test_the_line_d_is_as_long_as_the_distance(shown):
    for name in ("13a", "16d"):
        world = shown["queries"][name][0]
        path = shown["literal"](*shown["queries"][name])[0]
        _, blocking, d = ask(*shown["queries"][name], ROBOT, MARGIN).danger(path)
        (line,) = plot_clearance(world, path, blocking, plt.figure().add_subplot()).lines
        assert np.hypot(*np.diff(line.get_xydata(), axis=0)[0]) == pytest.approx(d, abs=1e-5)
