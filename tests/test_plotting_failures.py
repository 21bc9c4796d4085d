"""Pictures of failures, by what they contain."""

import numpy as np
import pytest

import freeseg as fs
from freeseg.studies.splitting import Tail
from freeseg.studies.statistics import share

MISSING = np.nan
TAIL = Tail(
    levels=np.array([0.001, 0.002, 0.003]),
    share=np.array([0.5, 0.01, MISSING]),
    low=np.array([0.4, 0, MISSING]),
    high=np.array([0.6, 0.02, MISSING]),
    error=np.array([0.1, 0.5, np.inf]),
    runs=100,
)


def test_tails_are_drawn_against_the_whole_margin(ax):
    fs.plotting.plot_tails({"PID": [TAIL, TAIL]}, {"PID": "red"}, 1e-3, ax)
    first, second, aim = ax.get_lines()
    assert first.get_xdata() == pytest.approx([0.002, 0.004])
    assert first.get_ydata() == pytest.approx([0.5, 0.01])
    assert aim.get_ydata() == pytest.approx([1e-3, 1e-3])
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["PID"]
    assert first.get_color() == second.get_color() == "red"
    assert ax.get_yscale() == "log"


def test_failures_stand_beside_each_other(ax):
    found = [share(0, 10), share(5, 10)]
    fs.plotting.plot_failures({"PID": found, "MPC": found}, [1, 2], {"PID": "red"}, ax)
    lines = [container[0] for container in ax.containers]
    assert lines[0].get_ydata() == pytest.approx([0, 0.5])
    assert (lines[0].get_xdata() < lines[1].get_xdata()).all()
    assert [label.get_text() for label in ax.get_xticklabels()] == ["1×", "2×"]
    with pytest.raises(fs.InvalidParameter, match="shares of PID are 2; give 3"):
        fs.plotting.plot_failures({"PID": found}, [1, 2, 3])


def test_indices_name_their_causes(ax):
    fs.plotting.plot_indices(
        ["slip", "delay"], [[0.1, 0.5], [0, 0.4], [0.2, 0.6]], np.ones((3, 2)), ax
    )
    assert [label.get_text() for label in ax.get_yticklabels()] == ["slip", "delay"]
    assert ax.containers[0][0].get_xdata() == pytest.approx([0.1, 0.5])
    assert ax.yaxis_inverted()
