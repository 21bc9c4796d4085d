"""What is stored of the comparison of trackers, and its pictures."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.errors import InvalidData, InvalidParameter
from freeseg.studies import comparing, statistics, tuning
from freeseg.studies.comparing import COMPARED, JUDGED, LAWS


@pytest.fixture(scope="module")
def stored():
    return comparing.load_comparison()


def test_every_law_has_all_runs(stored):
    assert list(LAWS) == list(tuning.RANGES)
    shape = JUDGED["courses"], JUDGED["robots"], tuning.REPLICATES
    for cell in COMPARED:
        for number in comparing.KEPT:
            assert list(stored[cell][number]) == list(LAWS.values())
            assert {values.shape for values in stored[cell][number].values()} == {shape}


@pytest.mark.parametrize("name", ["SlidingMode", "Pid", "PurePursuit"])
def test_stored_runs_are_what_the_stored_gains_drive(stored, name):
    for number, cell in enumerate(COMPARED):
        if cell.regime not in ("fast", "disturbed") and number > 2:
            continue
        tuned = "nominal" if cell.regime == "disturbed" else cell.regime
        found = tuning.load_gains(form=cell.form, regime=tuned, price=cell.price)[name][1]
        tracker = found.tracker
        if cell.told != 1:
            tracker = fs.Predicting(
                tracker.tracker, cell.told * 0.05, cell.told * 0.03, tracker.observer
            )
        again = comparing.judge(tracker, cell.regime, courses=1)
        for key in ("position_rms_m", "roughness_m_s2", "hit"):
            values = stored[cell][key][LAWS[name]][:1, :, 1]
            assert_allclose(values, again[key], rtol=1e-4, atol=1e-9)


def test_a_file_that_holds_another_study_is_refused(tmp_path):
    file = tmp_path / "comparison.npz"
    with pytest.raises(InvalidData, match="cannot be read"):
        comparing.load_comparison(file)
    np.savez(file, **dict.fromkeys(comparing.KEPT, np.zeros(3)))
    with pytest.raises(InvalidData, match="holds no study"):
        comparing.load_comparison(file)
    np.savez(file, position_rms_m=np.array([{}], dtype=object))
    with pytest.raises(InvalidData, match="cannot be read"):
        comparing.load_comparison(file)


def test_local_gains_are_those_of_the_law():
    gains = comparing.local_gains(fs.Kanayama(k_x=2, k_y=100, k_alpha=20), speed=0.1)
    found = [gains[one] for one in ("v_per_x", "omega_per_y", "omega_per_alpha")]
    assert_allclose(found, [2, 10, 2], rtol=1e-4)
    # A sliding mode within its boundary layers: k/phi, and gamma's slope turned into a rate.
    law = fs.SlidingMode(k1=0.4, k2=2, phi1=0.1, phi2=0.5, length_scale=0.045)
    gains = comparing.local_gains(law)
    assert gains["v_per_x"] == pytest.approx(4)
    assert gains["omega_per_y"] == pytest.approx(4 / 0.045, rel=1e-2)
    # An MPC answers like a linear law, too.
    assert 0 < comparing.local_gains(fs.Mpc())["omega_per_y"] < 200


def test_fronts_have_a_line_for_each_law_and_name_the_coloured_ones():
    rng = np.random.default_rng(0)
    fronts = {name: rng.uniform(0.001, 0.01, (4, 2)) for name in ("one", "two", "three")}
    ax = fs.plotting.plot_fronts(fronts, {"two": "red"})
    assert len(ax.lines) == 3
    # The coloured one lies on top; the errors rise along each line.
    assert ax.lines[-1].get_color() == "red"
    assert all((np.diff(line.get_xdata()) > 0).all() for line in ax.lines)
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["the other laws", "two"]
    with pytest.raises(InvalidParameter, match="a name in colors"):
        fs.plotting.plot_fronts(fronts, {"four": "red"})
    plt.close("all")


def test_intervals_stand_in_rows_from_above():
    found = {"plain": {"a": (1, 0.5, 2), "b": (3, 2, 4)}, "told": {"a": (0, -1, 1), "b": (1, 0, 2)}}
    ax = fs.plotting.plot_intervals(found, margin=0.1)
    assert [text.get_text() for text in ax.get_yticklabels()] == ["a", "b"]
    assert ax.yaxis_inverted()
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["plain", "told"]
    bars = [tuple(line.get_xdata()) for line in ax.lines if len(line.get_xdata()) == 2]
    assert bars == [(0.5, 2), (2, 4), (-1, 1), (0, 2)]
    plt.close("all")


@pytest.mark.parametrize(("lengths", "told"), [(True, 1000), (False, 1)])
def test_only_lengths_count_in_mm(lengths, told):
    ax = fs.plotting.plot_intervals({"share": {"a": (1, 0, 1)}}, lengths=lengths)
    ax.figure.canvas.draw()
    texts = [float(label.get_text().replace("−", "-")) for label in ax.get_xticklabels()]
    assert dict(zip(texts, ax.get_xticks(), strict=True))[told] == pytest.approx(1)
    plt.close("all")


def test_who_is_better_stands_higher():
    def pair(first, second, low, high):
        return statistics.Difference(first, second, (low + high) / 2, low, high)

    found = [
        pair("a", "b", -3, -2),
        pair("a", "c", -3, -2),
        pair("b", "c", -0.1, 0.1),
        pair("a", "d", -9, -8),
        pair("b", "d", -7, -6),
        pair("c", "d", -1, 1),
    ]
    order = statistics.order(found)
    ax = fs.plotting.plot_order(order, {"a": 0.001, "b": 0.003, "c": 0.0031, "d": 0.009})
    places = {text.get_text().split("\n")[0]: text.get_position() for text in ax.texts}
    assert places["a"][1] > places["b"][1] == places["c"][1] > places["d"][1]
    assert places["b"][0] < places["c"][0]
    assert len(ax.lines) == len(order.lines) == 3
    assert "1.00 mm" in ax.texts[0].get_text()
    with pytest.raises(InvalidParameter, match=r"means lacks \['b', 'c', 'd'\]"):
        fs.plotting.plot_order(order, {"a": 1.0})
    plt.close("all")
