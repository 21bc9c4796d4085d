"""Appendix A2, its own lines: what is printed, what its search stores, and what that excludes."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from lessons import definitions, lesson
from test_benchmarks import load

import freeseg as fs
from freeseg import plotting
from freeseg.data import read_csv, write_csv

STEM = "A2_decode_the_figures"
NAMES = ["robot", "unlimited", "cases", "plans", "units", "error_axes", "wheel_axis", "lasts"]
NAMES += ["ticks", "accelerations", "last_as_long", "ManyGains", "draw", "fly", "numbers", "rows"]
NAMES += ["settings", "stored", "agree", "counts", "assumptions", "fitting", "in_degrees", "steep"]


@pytest.fixture(scope="module")
def own():
    """What the lesson defines."""
    return definitions(STEM, *NAMES)


def test_the_reference_lasts_as_long_as_the_axis(own):
    for name in own["cases"]:
        for acceleration in own["accelerations"]:
            reference = own["last_as_long"](name, acceleration)
            assert reference.duration == pytest.approx(own["lasts"][name], abs=0.2)
        # Figs 18 and 19 share no time axis, unless one of them counts steps.
        assert own["ticks"][name][1] > 1000 * own["lasts"][name]


def test_a_batch_of_gains_drives_as_each_of_them_alone(own):
    gains, start = (part[:, :3] for part in own["draw"](100))
    reference = fs.make_reference(fs.Path([fs.Line((0, 0), (0.1, 0))]), speed=0.05)
    batch = fs.simulate(own["ManyGains"](*gains), reference, own["robot"], 0.02, start)
    for k in range(3):
        alone = fs.simulate(
            fs.SlidingMode(*gains[:, k]), reference, own["robot"], 0.02, start[:, k]
        )
        np.testing.assert_allclose(batch.pose[:, k], alone.pose, rtol=0, atol=1e-9)


def test_what_is_drawn_is_within_its_ranges(own):
    gains, start = own["draw"](500, 200)
    rates = gains[:2] / gains[2:4]
    assert rates.min() >= 0.5
    assert rates.max() <= 200
    farthest, nearest = np.abs(start).max(1), np.abs(start).min(1)
    assert (farthest <= np.array([0.05, 0.05, np.pi])).all()
    assert (nearest >= np.array([5e-5, 5e-5, 0.02])).all()
    # Either side alike.
    assert np.abs(np.sign(start).mean(1)).max() < 0.01


def test_what_is_stored_is_what_the_script_keeps(own):
    """The first robots of the base search, driven again: calm ones are the same everywhere."""
    script = load("figures")
    setting = own["settings"]["base"]
    gains, start = (part[:, :60] for part in own["draw"](setting["tried"], setting["fastest"]))
    found = own["fly"]("16b", gains, start, np.arange(60), setting["dt"])
    calm = found[-1] < 1
    kept = np.flatnonzero(script.wanted("16b", found) & calm)
    there = [
        row["robot"]
        for row in own["rows"]
        if (row["setting"], row["case"]) == ("base", "16b") and row["robot"] < 60
    ]
    assert kept.tolist() == [robot for robot in there if calm[robot]]
    assert len(kept)


def test_the_script_keeps_all_that_a_condition_may_want(own):
    script = load("figures")
    for name in own["cases"]:
        for setting in own["settings"]:
            found = own["stored"](setting, name)
            slack = 1 + 1e-3  # rows are rounded
            inside = found[8:].copy()
            inside[0] /= slack
            assert script.WEAKEST[0] >= 0.02
            assert (inside[0] < script.WEAKEST[0]).all()
    for _, options in own["assumptions"].values():
        assert options.get("follow", 0) <= script.WEAKEST[0]
        assert options.get("end", 0) <= script.WEAKEST[1]
        assert options.get("fill", 1) >= script.WEAKEST[2]


def test_metres_are_excluded_by_arithmetic(own):
    limit = min(min(axes[:2]) for axes in own["error_axes"].values())
    assert 0.1 * limit > 0.02
    metres = [place for place, reading in enumerate(own["units"]) if reading.startswith("m,")]
    assert own["counts"][:, metres].sum() == 0


def test_centimetres_and_millimetres_fit_with_radians_under_most_assumptions(own):
    possible = (own["counts"] > 0).all(2).sum(0)
    share = dict(zip(own["units"], possible / len(own["counts"]), strict=True))
    assert share["cm, rad"] > 0.5
    assert share["mm, rad"] > 0.5


def test_degrees_are_possible_all_the_same(own):
    """Built on purpose; the same start turned by half as much does not fill the wheels' axis."""
    assert own["in_degrees"]("16b")
    gains, start = own["steep"]["16b"]
    own["steep"]["16b"] = gains, (*start[:2], start[2] / 2)
    assert not own["in_degrees"]("16b")
    own["steep"]["16b"] = gains, start


def test_each_condition_is_one(own):
    """Of a robot that agrees, each number beyond its bound makes it disagree."""
    for (reading, name), some in own["fitting"].items():
        unit, (axis, tick) = own["units"][reading], own["wheel_axis"][name]
        limit = np.array(own["error_axes"][name]) * unit
        worse = {8: 0.011, 15: axis + 1e-6, 16: -axis - 1e-6, 17: 21 * axis}
        worse |= {9 + k: 1.01 * limit[k] for k in range(3)}
        worse |= {12 + k: 0.06 * limit[k] for k in range(3)}
        for row, value in worse.items():
            other = some[:, :1].copy()
            assert own["agree"](name, other, unit).all()
            other[row] = value
            assert not own["agree"](name, other, unit).any()
        for row, value in {9: 0.09 * limit[0], 15: axis - 1.1 * tick}.items():
            other = some[:, :1].copy()
            other[row] = value
            assert not own["agree"](name, other, unit).any()


def test_whose_turn_does_not_ask_for_the_speed_has_a_short_length_scale(own):
    for (_, name), some in own["fitting"].items():
        (axis, tick), turned = own["wheel_axis"][name], np.abs(some[7])
        asked = own["robot"].wheel_base / 2 * some[1] * np.minimum(turned / some[3], 1)
        enough = asked > 0.85 * (axis - tick)
        assert enough.any()
        assert some[4, ~enough].max() < 0.01


def test_no_reading_fixes_the_gains(own):
    for some in own["fitting"].values():
        assert (some[:5].max(1) > 3 * some[:5].min(1)).all()


def test_switching_fills_the_axes_only_without_a_limit(own):
    switches = lesson(f"solutions/{STEM}", "switches")
    for name in own["cases"]:
        assert switches(name, own["unlimited"])
        assert not switches(name, own["robot"])


def test_pictures_have_the_axes_of_the_paper():
    reference = fs.make_reference(fs.Path([fs.Line((0, 0), (0.1, 0))]))
    run = fs.simulate(fs.SlidingMode(), reference, initial_offset=(0, 0.002, 0))
    axes = plotting.plot_on_axes(run, (0.5, 5, 2), 0.2, length="cm", angle="°", until=1)
    assert [ax.get_ylim() for ax in axes] == [(-0.5, 0.5), (-5, 5), (-2, 2), (-0.2, 0.2)]
    assert [ax.get_ylabel() for ax in axes[:3]] == ["$x_e$ (cm)", "$y_e$ (cm)", r"$\alpha_e$ (°)"]
    np.testing.assert_allclose(axes[1].lines[1].get_ydata()[0], -0.2)
    with pytest.raises(fs.InvalidParameter, match="length is 'km'"):
        plotting.plot_on_axes(run, (1, 1, 1), 0.2, length="km")
    counts = [[[3, 2], [1, 0]], [[0, 0], [4, 4]]]
    ax = plotting.plot_agreement(counts, ["a", "b"], ["c", "d"])
    assert [text.get_text() for text in ax.texts] == ["3 | 2", "1 | 0", "–", "4 | 4"]
    assert ax.collections[0].get_array().ravel().tolist() == [2, 1, 0, 2]
    plt.close("all")


def test_the_script_replaces_the_rows_of_a_setting_and_keeps_the_others(tmp_path, monkeypatch):
    script, file = load("figures"), tmp_path / "figures.csv"
    monkeypatch.setitem(script.OWN["settings"], "tiny", {"tried": 60, "dt": 0.1, "fastest": 5})
    head = ["setting", "case", "robot", *script.OWN["ROBOT"], *script.OWN["NUMBERS"]]
    before = [dict.fromkeys(head, "0") | {"setting": one} for one in ("other", "tiny", "tiny")]
    write_csv(file, before)
    script.main("tiny", file=file)
    after = read_csv(file, dict.fromkeys(head, str))
    assert [row["setting"] for row in after[:2]] == ["other", "tiny"]
    assert all(row["setting"] == "tiny" and row["case"] in ("15a", "16b") for row in after[1:])
