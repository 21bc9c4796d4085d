import re
import shutil

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.data import DATA


@pytest.fixture
def folder(tmp_path):
    """A copy of the data that a test may break."""
    for file in DATA.glob("*.csv"):
        shutil.copy(file, tmp_path)
    return tmp_path


def edit(file, old, new):
    """Replace a piece of a file that is there exactly once."""
    text = file.read_text(encoding="utf-8")
    assert text.count(old) == 1
    file.write_text(text.replace(old, new), encoding="utf-8")


def row_of(file, line):
    """Number of a line in a file, the header being row 1."""
    return 1 + file.read_text(encoding="utf-8").splitlines().index(line)


# --- the paper's tables and figures -------------------------------------------------------------


@pytest.mark.parametrize(
    ("table", "obstacle", "center_mm"),
    [
        (1, 1, (550, 100)),
        (1, 3, (640, 600)),
        (1, 7, (150, 130)),
        (2, 4, (400, 500)),
        (2, 5, (200, 550)),
        (2, 7, (150, 300)),
        (3, 5, (240, 550)),
        (3, 6, (100, 420)),
        (4, 1, (550, 230)),
        (4, 3, (540, 500)),
        (4, 6, (160, 400)),
        (5, 2, (550, 400)),
        (5, 5, (200, 560)),
        (5, 7, (150, 260)),
    ],
)
def test_tables_have_the_papers_centres(tables, table, obstacle, center_mm):
    assert_allclose(1000 * tables[table].obstacles[obstacle - 1].center, center_mm, atol=1e-9)


@pytest.mark.parametrize("table", range(1, 6))
def test_tables_are_seven_discs_with_the_sizes_of_the_file(tables, table):
    world = tables[table]
    assert len(world) == 7
    assert all(isinstance(obstacle, fs.Disc) for obstacle in world.obstacles)
    lines = (DATA / "obstacles.csv").read_text(encoding="utf-8").splitlines()[1:]
    radii = [float(line.split(",")[2]) / 1000 for line in lines]
    assert_allclose(world.radii, radii)


@pytest.mark.parametrize(
    ("name", "table", "start_mm", "goal_mm"),
    [
        ("13a", 1, (0, 0), (250, 750)),
        ("13d", 2, (400, 0), (250, 750)),
        ("14b", 1, (400, 0), (500, 750)),
        ("14c", 3, (0, 0), (500, 750)),
        ("15a", 1, (0, 0), (750, 750)),
        ("15d", 4, (400, 0), (750, 750)),
        ("16b", 1, (400, 0), (800, 500)),
        ("16c", 5, (0, 0), (800, 500)),
    ],
)
def test_cases_are_the_panels_of_figs_13_to_16(cases, name, table, start_mm, goal_mm):
    case = cases[name]
    assert (case.name, case.table) == (name, table)
    assert_allclose(case.start, np.divide(start_mm, 1000))
    assert_allclose(case.goal, np.divide(goal_mm, 1000))


def test_there_are_16_cases(cases):
    assert sorted(cases) == [f"{figure}{panel}" for figure in range(13, 17) for panel in "abcd"]
    assert all(case.caption for case in cases.values())


# --- broken files --------------------------------------------------------------------------------


def test_copied_data_is_read(folder):
    assert_array_equal(fs.load_table(3, folder).edges, fs.load_table(3).edges)
    assert fs.load_cases(folder) == fs.load_cases()


@pytest.mark.parametrize("file", ["tables.csv", "obstacles.csv"])
def test_missing_file(folder, file):
    (folder / file).unlink()
    with pytest.raises(fs.InvalidData, match=f"{file} cannot be read"):
        fs.load_table(1, folder)


def test_missing_cases(folder):
    (folder / "cases.csv").unlink()
    with pytest.raises(fs.InvalidData, match=r"cases\.csv cannot be read"):
        fs.load_cases(folder)


def test_file_that_is_no_text(folder):
    (folder / "tables.csv").write_bytes(b"\xff\xfe\x00table")
    with pytest.raises(fs.InvalidData, match=r"tables\.csv cannot be read"):
        fs.load_table(1, folder)


@pytest.mark.parametrize(
    ("file", "column"),
    [("tables.csv", "x_mm"), ("tables.csv", "obstacle"), ("obstacles.csv", "radius_mm")],
)
def test_missing_column(folder, file, column):
    edit(folder / file, column, "unknown")
    with pytest.raises(fs.InvalidData, match=f"{file} has no column '{column}'.*'unknown'"):
        fs.load_table(1, folder)


@pytest.mark.parametrize(
    ("file", "left", "message"),
    [
        ("tables.csv", 0, "tables.csv has no column 'table'"),
        ("tables.csv", 1, "tables.csv has no rows"),
        ("obstacles.csv", 0, "obstacles.csv has no column 'obstacle'"),
        ("obstacles.csv", 1, "obstacles.csv has no rows"),
    ],
)
def test_empty_file(folder, file, left, message):
    lines = (folder / file).read_text(encoding="utf-8").splitlines(keepends=True)
    (folder / file).write_text("".join(lines[:left]), encoding="utf-8")
    with pytest.raises(fs.InvalidData, match=message):
        fs.load_table(1, folder)


@pytest.mark.parametrize(
    ("line", "broken", "column", "value"),
    [
        ("1,4,400,500", "1,4,400,south", "y_mm", "'south'"),
        ("1,4,400,500", "1,4,nan,500", "x_mm", "'nan'"),
        ("1,4,400,500", "1,4,400,inf", "y_mm", "'inf'"),
        ("1,4,400,500", "1,4,400,-inf", "y_mm", "'-inf'"),
        ("1,4,400,500", "1,4,,500", "x_mm", "''"),
        ("1,4,400,500", "1,4,400", "y_mm", "None"),
        ("1,4,400,500", "1,4.5,400,500", "obstacle", "'4.5'"),
        ("1,4,400,500", "one,4,400,500", "table", "'one'"),
        # A value of another table is checked too: the file as a whole is broken.
        ("5,7,150,260", "5,7,150,?", "y_mm", "'?'"),
    ],
)
def test_value_in_tables_that_is_no_number(folder, line, broken, column, value):
    row = row_of(folder / "tables.csv", line)
    edit(folder / "tables.csv", line, broken)
    message = f"tables.csv, row {row}, column '{column}': {value} is not"
    with pytest.raises(fs.InvalidData, match=re.escape(message)):
        fs.load_table(1, folder)


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        ("1,3,400,500", "obstacle 3 is there twice"),
        ("1,8,400,500", "obstacle 8 is out of range"),
        ("1,0,400,500", "obstacle 0 is out of range"),
        ("1,4,901,500", "x_mm is 901, off the map"),
        ("1,4,-1,500", "x_mm is -1, off the map"),
        ("1,4,400,901", "y_mm is 901, off the map"),
        ("1,4,400,-101", "y_mm is -101, off the map"),
    ],
)
def test_tables_that_make_no_sense(folder, broken, message):
    row = row_of(folder / "tables.csv", "1,4,400,500")
    edit(folder / "tables.csv", "1,4,400,500", broken)
    with pytest.raises(fs.InvalidData, match=re.escape(f"tables.csv, row {row}: {message}")):
        fs.load_table(1, folder)


def test_obstacle_left_out(folder):
    edit(folder / "tables.csv", "1,4,400,500\n", "")
    with pytest.raises(fs.InvalidData, match=r"row 7: obstacle 7 is out of range; .* 6 obstacles"):
        fs.load_table(1, folder)


@pytest.mark.parametrize("edge_mm", [(0, 500), (900, 500), (400, -100), (400, 900)])
def test_centre_on_the_border_of_the_map_is_on_the_map(folder, edge_mm):
    edit(folder / "tables.csv", "1,4,400,500", f"1,4,{edge_mm[0]},{edge_mm[1]}")
    assert_allclose(1000 * fs.load_table(1, folder).obstacles[3].center, edge_mm)


SOURCE = "assumption: not published; linear programme of notebook A1_rebuild_the_worlds, whole mm"
SIZE = f"4,disc,39,{SOURCE}"


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        ("4,disc,0,none", "obstacles.csv, row 5: radius_mm is 0"),
        ("4,disc,-25,none", "obstacles.csv, row 5: radius_mm is -25"),
        ("4,disc,big,none", "obstacles.csv, row 5, column 'radius_mm': 'big'"),
        ("4,disc,nan,none", "obstacles.csv, row 5, column 'radius_mm': 'nan'"),
        ("4,disc", "obstacles.csv, row 5, column 'radius_mm': None"),
        ("3,disc,25,none", "obstacles.csv, row 5: obstacle 3 is there twice"),
        ("9,disc,25,none", "obstacles.csv, row 5: obstacle 9 is out of range"),
    ],
)
def test_sizes_that_make_no_sense(folder, broken, message):
    edit(folder / "obstacles.csv", SIZE, broken)
    with pytest.raises(fs.InvalidData, match=re.escape(message)):
        fs.load_table(1, folder)


def test_sizes_that_overlap(folder):
    edit(folder / "obstacles.csv", SIZE, "4,disc,300,none")
    with pytest.raises(fs.InvalidWorld, match="touch"):
        fs.load_table(1, folder)


def test_size_left_out(folder):
    edit(folder / "obstacles.csv", f"7,disc,24,{SOURCE}\n", "")
    with pytest.raises(fs.InvalidData, match=r"obstacles\.csv has 6 sizes for the 7 obstacles"):
        fs.load_table(1, folder)


@pytest.mark.parametrize("number", [0, 6, -1, None, "one"])
def test_unknown_table(number):
    with pytest.raises(fs.InvalidParameter, match=rf"table is '?{number}'?;.* \[1, 2, 3, 4, 5\]"):
        fs.load_table(number)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("13b,13,b", "13a,13,b", "cases.csv, row 3: case '13a' is there twice"),
        ("13b,13,b,1,400,0", "13b,13,b,1,far,0", "cases.csv, row 3, column 'start_x_mm': 'far'"),
        ("13b,13,b,1,400,0", ",13,b,1,400,0", "cases.csv, row 3, column 'case': ''"),
        ("goal_y_mm", "goal", "cases.csv has no column 'goal_y_mm'"),
    ],
)
def test_cases_that_make_no_sense(folder, old, new, message):
    edit(folder / "cases.csv", old, new)
    with pytest.raises(fs.InvalidData, match=re.escape(message)):
        fs.load_cases(folder)
