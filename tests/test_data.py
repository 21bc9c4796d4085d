import pytest

import freeseg as fs
from freeseg.data import DATA, read_csv, write_csv


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
