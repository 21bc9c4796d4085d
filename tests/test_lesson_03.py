"""What lesson 03 shows, against the package and against what it says of it."""

import numpy as np
import pytest
from lessons import definitions

import freeseg as fs
from freeseg.geometry import tangents
from freeseg.plan import turning_radius
from freeseg.segments import MARGIN, find_endpoints

STEM = "03_choose_the_turning_point"


@pytest.fixture(scope="module")
def shown():
    """What the lesson calls by some names, one and the same run of it."""
    names = "world segments start goal case straight distances blocking detours endpoints points SD"
    names += " best name_of draw_case goals names R_D r phi_max distance verdict phis"
    names += " literal turned sense tangent_point center radius join leave length plan shortest"
    names += " compared excess found counts agrees searches describe"
    return definitions(STEM, *names.split())


def test_the_straight_line_is_blocked_by_obstacle_4_but_misses_it(shown, robot):
    assert shown["blocking"] + 1 == 4
    assert 0 < shown["distances"][shown["blocking"]] < robot.radius


def test_detours_are_those_that_the_package_ranks(shown, robot):
    found = shown["plan"].steps[1]
    assert found.kind == "turning point"
    everywhere = np.array([end.point for end in find_endpoints(shown["world"], shown["segments"])])
    ranked = np.sort(shown["detours"](everywhere, shown["start"], shown["goal"]))
    assert np.allclose([one.detour for one in found.candidates], ranked)
    assert np.array_equal(found.chosen.endpoint.point, shown["best"].point)
    # No endpoint lies inside of the winner's ellipse, not even an outer one.
    assert shown["SD"].min() == pytest.approx(ranked[0])


def test_names_are_those_of_the_segments_ends(shown):
    named = {shown["name_of"](end): end for end in shown["endpoints"]}
    assert sorted(named, key=lambda name: int(name[1:])) == [f"p{k}" for k in range(2, 14)]
    for name, end in named.items():
        # Obstacle i has the endpoints 2 i - 1 and 2 i.
        assert (int(name[1:]) + 1) // 2 == end.obstacle + 1


def test_the_turning_point_jumps_as_the_goal_moves(shown, robot):
    names = shown["names"]
    assert 1 < len(set(names)) < len(names)
    for goal, name in zip(shown["goals"], names, strict=True):
        label = shown["describe"](goal)
        assert label.startswith(f"goal at x = {1000 * goal[0]:.0f} mm: turn at {name} on")
        steps = fs.plan(shown["world"], shown["start"], goal, robot, MARGIN).steps
        assert ("clear" in label) == (len(steps) == 1)


def test_two_circles_just_fit_into_the_narrowest_safe_segment(shown, robot):
    assert turning_radius(robot, MARGIN) == shown["R_D"]
    assert 2 * shown["R_D"] == pytest.approx(robot.diameter + MARGIN)


def test_the_distance_is_that_of_the_tangent_lines(shown, robot):
    R_D, r, best = shown["R_D"], shown["r"], shown["best"]  # noqa: N806
    phi = np.radians(np.linspace(0, 90, 181))
    d = shown["distance"](phi)
    assert np.array_equal(d >= robot.radius, phi <= shown["phi_max"])
    # Measured on points of the tangent lines, 0.1 mm apart.
    towards = np.arctan2(*best.outward[::-1]) + phi
    normal = np.column_stack([np.cos(towards), np.sin(towards)])
    onwards = np.column_stack([-normal[:, 1], normal[:, 0]])
    along = np.arange(0, 2 * r, 1e-4)
    points = (best.point + R_D * normal)[:, None] + along[:, None] * onwards[:, None]
    away = np.hypot(*np.moveaxis(points - shown["center"], -1, 0)) - r
    assert np.allclose(away.min(axis=1), d, rtol=0, atol=1e-7)
    # Nearest a length r sin phi after the circle, where the sketch has the robot.
    assert np.allclose(along[away.argmin(axis=1)], r * np.sin(phi), rtol=0, atol=1e-4)
    # The end of the arc is nearer than R_D as well, but not as near.
    assert (d[1:] < away[1:, 0]).all()
    assert (away[1:, 0] < R_D).all()


def test_pages_of_the_flipbook_say_what_the_formula_says(shown, robot):
    for phi in shown["phis"]:
        assert ("too close" in shown["verdict"](phi)) == (phi > shown["phi_max"])
    assert shown["verdict"](0).endswith(f"clear by {500 * MARGIN:.1f} mm")


def test_the_literal_circle_scrapes_in_14b_as_the_formula_says(shown, robot):
    clearance = shown["literal"].clearance(shown["world"])
    assert clearance == pytest.approx(shown["distance"](shown["turned"]), abs=1e-9)
    assert clearance < robot.radius


def test_tangent_points_are_the_packages(shown):
    touch, center, radius = (shown[name] for name in ("tangent_point", "center", "radius"))
    for sense in (1, -1):
        _, join = tangents(shown["start"], 0, center, sense * radius)
        assert np.allclose(touch(shown["start"], center, radius, sense), join)
        # Backwards in time, the robot comes from the goal and goes round the other way.
        leave, _ = tangents(center, sense * radius, shown["goal"], 0)
        assert np.allclose(touch(shown["goal"], center, radius, -sense), leave)


def test_the_sense_leads_past_the_turning_point(shown):
    assert shown["plan"].steps[1].chosen.sense == shown["sense"] == 1
    arc = shown["plan"].path.pieces[1]
    halfway = arc.start_angle + arc.sweep / 2
    assert np.array([np.cos(halfway), np.sin(halfway)]) @ shown["best"].outward > 0


def test_the_path_is_the_packages_and_the_shortest(shown, robot):
    length, path = shown["length"], shown["plan"].path
    assert length == pytest.approx(path.length, rel=1e-12)
    assert length == pytest.approx(shown["shortest"], rel=0, abs=1e-12)
    assert path.clearance(shown["world"]) >= robot.radius
    assert shown["straight"].length < shown["SD"].min() < length
    # It swings wider than the turning point.
    along = (shown["goal"] - shown["start"]) / shown["straight"].length
    aside = [-along[1], along[0]]
    strays = [
        np.abs((points - shown["start"]) @ aside).max()
        for points in (path.sample(0.001), shown["best"].point)
    ]
    assert strays[0] > strays[1]


def test_plans_are_shorter_than_the_shortest_only_where_lines_keep_less_than_r_d(shown, robot):
    from freeseg.studies.sizes import make_tables, random_sizes

    case, found, counts = shown["case"], shown["found"], shown["counts"]
    assert sum(counts.values()) == len(found) == 100
    assert counts["equal"] > 80
    assert counts["longer"] > 0
    drawn = random_sizes(100, shape="disc", seed=1)
    shorter = np.flatnonzero(found < 0)
    assert len(shorter) == counts["shorter"] > 0
    for sizes in drawn[shorter]:
        world = make_tables(sizes, "disc")[case.table]
        clearance = fs.plan(world, case.start, case.goal, robot, MARGIN).path.clearance(world)
        assert robot.radius <= clearance < turning_radius(robot, MARGIN) - 1e-9


def test_the_papers_choice_holds_in_all_cases_of_table_1(shown):
    assert len(shown["searches"]) == 8
    assert all(shown["agrees"](step) for step in shown["searches"])
    assert {step.kind for step in shown["searches"]} == {"turning point"}


def test_a_smaller_robot_turns_at_the_same_point_until_it_needs_no_turn(shown, robot):
    passing = shown["distances"][shown["blocking"]]
    for diameter in (robot.diameter, 0.12, 1.99 * passing):
        small = fs.KheperaIV(0.5 * diameter, diameter)
        plan = fs.plan(shown["world"], shown["start"], shown["goal"], small, MARGIN)
        assert (not plan.turning_points) == (diameter / 2 < passing)
        for turn in plan.turning_points:
            assert np.array_equal(turn.point, shown["best"].point)
