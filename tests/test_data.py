import numpy as np
import pytest

import freeseg as fs
from freeseg.data import DATA, read_arrays, read_csv, read_rows, write_arrays, write_csv, write_rows


def test_what_is_written_is_read(tmp_path):
    file = tmp_path / "rows.csv"
    rows = [
        {"name": "Fuzzy, tuned", "steps": 3, "time": 0.1},
        {"name": "é", "steps": 0, "time": -2.0},
    ]
    # The first rows are more, and nothing of them is to be left.
    write_csv(file, rows * 3)
    write_csv(file, rows)
    found = read_csv(file, {"name": str, "steps": int, "time": float})
    assert found == [{"row": number} | row for number, row in enumerate(rows, 2)]


def test_what_cannot_be_written_is_named(tmp_path):
    rows = [{"name": 1}]
    for file, given, named in (
        (tmp_path / "rows.csv", [], r"rows is .* give one or more"),
        (tmp_path / "rows.csv", [{"name": 1}, {"other": 2}], "all with the same columns"),
        (tmp_path / "rows.csv", ["name"], "rows is .* one dict a row"),
        (tmp_path / "missing" / "rows.csv", rows, "cannot be written .* folder that exists"),
        (5, rows, "path is 5; give the path of a file"),
    ):
        with pytest.raises(fs.InvalidData, match=named):
            write_csv(file, given)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(fs.InvalidData, match=r"columns has .* give str, int or float"):
        read_csv(DATA / "khepera4.csv", {"value": list})


def test_rows_come_back_to_the_last_digit(tmp_path):
    file = tmp_path / "rows.npz"
    rows = [
        {"name": "é", "steps": 3, "hit": True, "time": 1 / 3},
        {"name": "", "steps": -1, "hit": False, "time": float("inf")},
    ]
    columns = {"name": str, "steps": int, "hit": bool, "time": float}
    write_rows(file, [row | {"more": 1} for row in rows], columns)
    assert read_rows(file, columns) == rows
    assert read_arrays(file, ["time"])["time"].tolist() == [1 / 3, float("inf")]
    assert set(read_arrays(file)) == set(columns)


def test_broken_arrays_are_named(tmp_path):
    file = tmp_path / "rows.npz"
    with pytest.raises(fs.InvalidData, match=r"rows\.npz cannot be read .*; try again"):
        read_arrays(file, again="try again")
    for content in (b"", b"PK", b"text"):
        file.write_bytes(content)
        with pytest.raises(fs.InvalidData, match="cannot be read"):
            read_arrays(file)
    write_arrays(file, {"x": np.array([1, 2]), "y": np.array([1.0])})
    with pytest.raises(fs.InvalidData, match="cannot be read for names"):
        read_arrays(file, ["z"])
    with pytest.raises(fs.InvalidData, match="holds no such x"):
        read_rows(file, {"x": float})
    with pytest.raises(fs.InvalidData, match="holds no such y"):
        read_rows(file, {"x": int, "y": float})
    with pytest.raises(fs.InvalidData, match="give them all of x, y"):
        write_rows(file, [{"x": 1}], {"x": int, "y": float})
    with pytest.raises(fs.InvalidData, match="rows has a x that is no int"):
        write_rows(file, [{"x": "one"}], {"x": int})
    with pytest.raises(fs.InvalidData, match="cannot be written"):
        write_arrays(tmp_path / "missing" / "rows.npz", {"x": np.ones(1)})
