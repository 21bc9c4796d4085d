"""Notebook 18: margins close the doors that they should, and tolerances open no wall."""

import shapely
from lessons import lesson
from matplotlib.figure import Figure

STEM = "18_plan_in_your_own_map"
#: Widths of the meeting room's own door and of all others (m), as data/README.md gives them.
OWN_DOOR, OTHER_DOORS = 0.7, 0.9


def test_a_margin_closes_the_doors_that_are_narrower():
    world, ways, robot = lesson(STEM, "world", "ways", "robot")
    own_door = shapely.box(10.0, 3.6, 10.7, 3.8)
    assert {None} < set(ways.values())
    for margin, way in ways.items():
        gap = robot.diameter + margin
        assert (way is None) == (gap > OTHER_DOORS)
        if way:
            line = shapely.LineString(way.sample(0.01))
            assert line.intersects(own_door) == (gap <= OWN_DOOR)
            # Kept to half the margin on either side.
            assert way.clearance(world) >= robot.radius + margin / 2 - 1e-6
    lengths = [way.length for way in ways.values() if way]
    assert lengths == sorted(lengths)


def test_no_page_shows_a_way_where_there_is_none():
    draw, ways = lesson(STEM, "draw_way", "world", "ways")[::2]
    labels = {}
    for margin, way in ways.items():
        draw(figure := Figure(), margin)
        labels[way is None] = set(figure.axes[0].get_legend_handles_labels()[1])
    assert labels[True] < labels[False]


def test_tolerances_only_ever_add_rock():
    caves, crossings = lesson(STEM, "cave", "caves", "crossings", "dig_cave")[1:3]
    exact, *simpler = (shapely.union_all(cave.cores) for cave in caves.values())
    assert len(simpler) == 3
    for rock in simpler:
        assert exact.difference(rock).area < 1e-6
    corners = [sum(map(len, cave.corners)) for cave in caves.values()]
    assert corners == sorted(corners, reverse=True)
    lengths = [crossing.length for crossing in crossings.values()]
    assert min(lengths) == crossings[0].length
