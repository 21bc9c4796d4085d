"""Benchmarks assert no times, but they must run and print what they promise."""

import importlib.util
import re
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbformat.v4 import new_code_cell, new_notebook
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.path import Arc
from freeseg.studies import comparing, crossings, tuning

FOLDER = Path(__file__).parent / "benchmarks"


def load(name):
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_first_path(capsys):
    load("first_path").main(repeats=1)
    printed = capsys.readouterr().out
    for line in ("import freeseg", "plan case 16b", "plan, median of 8 cases", "simulate"):
        assert line in printed


def test_dragging(capsys):
    load("dragging").main(drags=3)
    assert len(re.findall(r"median +[\d.]+ ms", capsys.readouterr().out)) == 5


def test_batch(capsys):
    load("batch").main(robots=20, repeats=1)
    printed = capsys.readouterr().out
    for line in ("20 undisturbed", "1 disturbed", "batch over single, disturbed"):
        assert line in printed
    assert printed.count("True") == 2
    assert "False" not in printed


def test_drawing(capsys):
    load("drawing").main(discs=20)
    lines = capsys.readouterr().out.splitlines()
    assert [line.rsplit(maxsplit=2)[0].rstrip() for line in lines] == [
        "draw 20 discs",
        "save them as PNG",
        "both",
    ]
    *parts, both = [float(line.split()[-2]) for line in lines]
    assert both == pytest.approx(sum(parts), abs=0.02)


def test_notebooks(tmp_path, capsys):
    file = tmp_path / "tiny.ipynb"
    nbformat.write(new_notebook(cells=[new_code_cell("1 + 1")]), file)
    load("notebooks").main([file])
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["tiny", "all"]


def test_grading(capsys):
    load("grading").main(students=2)
    lines = capsys.readouterr().out.splitlines()
    # Between what is timed, grading says what it wrote.
    timed = [line.split()[0] for line in lines if line[0] in "r 0123456789"]
    assert timed == ["release", "2", "1"]


def test_peers(capsys):
    # Without the peers installed, freeseg's own rows.
    load("peers").main(["--quick"])
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    rows = {" ".join(row[:2]): row for row in rows if row[:1] == ["freeseg"] and len(row) > 2}
    assert set(rows) == {"freeseg plan", "freeseg shortest_path"}
    for row in rows.values():
        # The benchmark goes on where a planner raises: it counts.
        paths, failed, invalid = row[-4:-1]
        assert (int(paths), int(failed), int(invalid)) == (2, 0, 0)


def test_loops(capsys):
    # A short bend, one setting and few robots: what is printed, not how fast it is.
    path = fs.Path([Arc((0, 0.1), 0.1, -np.pi / 2, 0.3)])
    load("loops").main(fs.make_reference(path), 5, 1, [(0.01, "RK45", 1e-5)])
    printed = capsys.readouterr().out
    for line in ("a call a hold", "simulate, 5 at once", "simulate, step 50 ms", "within 1 mm"):
        assert printed.count(line) >= 2  # on the path and beside it
    # Both solve the held loop alike.
    for apart in re.findall(r"differ by at most (\S+) mm", printed):
        assert float(apart) < 1e-6


def test_mpc(capsys):
    # Without do-mpc installed, its row is missing.
    load("mpc").main(["--quick"])
    printed = capsys.readouterr().out
    rows = [line.split() for line in printed.splitlines()]
    *_, rms, violation = next(row for row in rows if row[:4] == ["7", "active", "discs", "Mpc"])
    assert 0 < float(rms) < 15
    assert float(violation) < 1
    differs = re.search(r"Opti with ipopt over Mpc: .* differs by (.*) %", printed)
    assert float(differs[1]) < 2


def test_compare_trackers(tmp_path, monkeypatch):
    # One law of two, one replicate and one cell, in place of hours.
    script = load("compare_trackers")
    monkeypatch.setattr(script, "LAWS", ("PurePursuit",))
    monkeypatch.setattr(script.tuning, "REPLICATES", 1)
    monkeypatch.setattr(script.tuning, "RANGES", {"PurePursuit": tuning.RANGES["PurePursuit"]})
    cells = (comparing.Cell("observed", "fast"),)
    monkeypatch.setattr(script.comparing, "COMPARED", cells)
    monkeypatch.setattr(script.tuning, "GENERATIONS", 1)
    judged = comparing.JUDGED | {"courses": 2, "robots": 3}
    monkeypatch.setattr(script.comparing, "JUDGED", judged)
    script.main(jobs=1, folder=tmp_path)
    (one,) = tuning.load_gains(tmp_path / "gains.csv", "observed", "fast")["PurePursuit"]
    assert 0 < one.score < 0.1
    with np.load(tmp_path / "comparison.npz") as stored:
        assert stored["position_rms_m"].shape == (1, 1, 2, 3, 1)
        again = comparing.judge(one.tracker, "fast")["position_rms_m"]
        assert_allclose(stored["position_rms_m"][0, 0, ..., 0], again, rtol=1e-6)


def test_tracker_steps(capsys):
    load("tracker_steps").main(repeats=1, file=None)
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert len(rows) == 10
    assert {"SlidingMode", "Mpc"} < {row[0] for row in rows}


def test_reactive(capsys):
    load("reactive").main((8,), 20)
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [row[2] for row in rows] == ["PotentialField", "VectorFieldHistogram", "DynamicWindow"]
    for row in rows:
        assert 0 < float(row[4]) <= float(row[7])


def test_runner(capsys, tmp_path):
    script = load("runner")
    page = tmp_path / "page.md"
    page.write_text(script.PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    script.main(1000, 1000, 4, page)
    printed = capsys.readouterr().out
    for line in ("robot-steps, SlidingMode", "robot-steps, Pid", "times as fast", "1,000 rows"):
        assert line in printed
    before, after = (file.read_text(encoding="utf-8") for file in (script.PAGE, page))
    # Only the table is another one, and its numbers belong together.
    assert before.partition(script.BEGIN)[0] == after.partition(script.BEGIN)[0]
    assert before.partition(script.END)[2] == after.partition(script.END)[2]
    rows = [line.split("|")[2:-1] for line in after.splitlines() if line.startswith("| robots")]
    assert len(rows) == 2
    for row in rows:
        rate, hours, on_two, _, euros = (float(number.replace(",", "")) for number in row)
        assert hours == pytest.approx(1e6 / rate / 3600, rel=0.1)
        assert on_two == pytest.approx(hours / 2, rel=0.1)
        assert euros == pytest.approx(script.CORE_HOUR * hours, rel=0.1)


def test_maps(capsys):
    load("maps").main(["--quick"])
    rows = capsys.readouterr().out.splitlines()
    assert [row.split("first")[0].strip() for row in rows] == ["7 discs", "5 x 5 squares"]


def test_movers(capsys):
    load("movers").main(["--quick"])
    printed = capsys.readouterr().out
    assert [line.split()[0] for line in printed.splitlines()] == [*crossings.RIVAL_NAMES, "best"]
    assert "'earlier': 0" in printed.splitlines()[-1]


def test_avoid_movers(capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["avoid_movers.py", "--quick"])
    load("avoid_movers").main()
    printed = capsys.readouterr().out
    assert printed.count("10 movers, reach") == 2
    assert "nothing" in printed
