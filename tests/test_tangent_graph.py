import numpy as np
import pytest
import shapely
from numpy.testing import assert_array_equal

from freeseg.planners import tangent_graph
from freeseg.planners.tangent_graph import TangentGraph, unblocked


@pytest.mark.parametrize("lines_at_once", [7, 1024])
def test_unblocked_lines_against_shapely(monkeypatch, lines_at_once):
    monkeypatch.setattr(tangent_graph, "LINES", lines_at_once)
    monkeypatch.setattr(tangent_graph, "EDGES", 3)
    rng = np.random.default_rng(11)
    lines = rng.uniform(0, 1, (60, 2, 2))
    lines[::9, 1] = lines[::9, 0]  # of length zero
    edges = rng.uniform(0, 1, (20, 2, 2))
    edges[:, 1] = edges[:, 0] + 0.3 * (edges[:, 1] - edges[:, 0])
    edges[::2, 1] = edges[::2, 0]  # discs
    reach = rng.uniform(0.005, 0.04, 20)
    distance = shapely.distance(shapely.linestrings(lines)[:, None], shapely.linestrings(edges))
    expected = np.flatnonzero((distance >= reach).all(1))
    assert 10 < len(expected) < 50
    assert_array_equal(unblocked(lines, edges, reach), expected)
    assert_array_equal(unblocked(lines, edges[:0], reach[:0]), np.arange(60))


def test_a_graph_that_grew_has_the_tangents_of_one_made_at_once():
    rng = np.random.default_rng(12)
    centers = rng.uniform(0, 1, (12, 2))
    edges, radii = np.stack([centers, centers], axis=1), rng.uniform(0.02, 0.12, 12)
    whole, grown = TangentGraph((-0.5, 0), (1.5, 1)), TangentGraph((-0.5, 0), (1.5, 1))
    whole.add(centers, radii, edges, radii)
    for part in (slice(0, 1), slice(1, 5), slice(5, 12)):
        grown.add(centers[part], radii[part], edges[part], radii[part])

    def rows(graph):
        return sorted(map(tuple, np.round(graph.lines.reshape(-1, 4), 12).tolist()))

    assert rows(grown) == rows(whole)
    assert sorted(grown.closed_angle) == pytest.approx(sorted(whole.closed_angle))
    assert len(whole.closed_angle) > 5
    assert grown.shortest() == whole.shortest()
