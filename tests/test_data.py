from freeseg.data import read_csv, write_csv


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
