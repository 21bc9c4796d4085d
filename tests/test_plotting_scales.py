"""Pictures of what planning costs: medians, the slowest, what was met."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import freeseg as fs


def test_growth_shows_medians_and_the_slowest():
    ax = fs.plotting.plot_growth([7, 7, 7, 20, 20], [0.1, 0.2, 0.9, 0.3, 0.5], label="exact")
    each, median, slowest = ax.lines
    assert len(each.get_xdata()) == 5
    assert_allclose(median.get_xydata(), [(7, 200), (20, 400)])
    assert_allclose(slowest.get_xydata(), [(7, 900), (20, 500)])
    assert ax.get_xscale() == ax.get_yscale() == "log"
    assert ax.get_legend_handles_labels()[1] == ["exact"]
    with pytest.raises(fs.InvalidParameter, match="all positive"):
        fs.plotting.plot_growth([7, 0], [0.1, 0.2])


def test_met_discs_have_a_colour_of_their_own():
    world = fs.random_world(20, 0)
    ax = fs.plotting.plot_met(world, [3, 5])
    assert [len(discs.get_offsets()) for discs in ax.collections] == [18, 2]
    assert_allclose(ax.collections[1].get_offsets(), [world[3].center, world[5].center])
    with pytest.raises(fs.InvalidParameter, match="of discs only"):
        fs.plotting.plot_met(fs.random_world(3, 0, ("polygon",)), [0])


def test_bars_carry_their_numbers():
    ax = fs.plotting.plot_bars([2.5, 40.0], ["a", "b"])
    assert_allclose([bar.get_width() for bar in ax.patches], [2.5, 40])
    assert [text.get_text() for text in ax.texts] == ["2.5", "40"]
    assert [text.get_text() for text in ax.get_yticklabels()] == ["a", "b"]
    with pytest.raises(fs.InvalidParameter, match="one for each of 1 labels"):
        fs.plotting.plot_bars(np.ones(2), ["a"])
