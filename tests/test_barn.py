"""BARN's worlds: how they are read, and what is stored of them."""

import numpy as np
import pytest
from test_benchmarks import load

import freeseg as fs
from freeseg.data import DATA, read_csv

COLUMNS = {
    "world": int,
    "radius_m": float,
    "discs": int,
    "length_m": float,
    "lower_bound_m": float,
    "clearance_m": float,
    "reference_m": float,
}

#: One cylinder on the straight way, one far away.
CYLINDERS = [(-2.25, 8.0), (3.0, 8.0)]

MODEL = """<model name='unit_cylinder_{k}'><static>1</static>
<pose frame=''>{x:f} {y:f} 0.000000 0.000000 0.000000 0.000000</pose>
<link name='link'><collision name='collision'><geometry><cylinder><radius>0.075000</radius>
<length>1</length></cylinder></geometry></collision></link></model>"""

SURROUNDINGS = """<sdf version='1.6'><world name='default'>
<light name='sun' type='directional'><pose frame=''>0 0 10 0 -0 0</pose></light>
<model name='ground_plane'><link name='link'><collision name='collision'><geometry>
<plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
{models}</world></sdf>"""


@pytest.fixture(scope="module")
def script():
    return load("barn")


@pytest.fixture
def folder(tmp_path):
    models = "".join(MODEL.format(k=k, x=x, y=y) for k, (x, y) in enumerate(CYLINDERS))
    (tmp_path / "world_3.world").write_text(SURROUNDINGS.format(models=models))
    (tmp_path / "path_files").mkdir()
    np.save(tmp_path / "path_files" / "path_3.npy", [(15, 0), (15, 20)])
    return tmp_path


def test_world_files_are_read(script, folder):
    ((number, world, reference),) = script.read(folder)
    assert number == 3
    assert [tuple(disc.center) for disc in world] == CYLINDERS
    assert world.radii.tolist() == [0.075, 0.075]
    # From the start to the middles of cells 0.15 m wide at (-2.325, 5.075) and (-2.325, 8.075).
    assert reference == pytest.approx(np.hypot(0.075, 2.075) + 3 + np.hypot(0.075, 4.925))


def test_arrays_in_single_precision_are_the_same_worlds(script, folder, tmp_path):
    x, y = np.array(CYLINDERS, np.float32).T
    file = tmp_path / "barn.npz"
    np.savez(
        file, world=[0, 0], x=x, y=y, radius=np.float32(0.075), reference_length=np.array([11.0])
    )
    ((number, world, reference),) = script.read(file)
    ((_, same, _),) = script.read(folder)
    assert (number, reference) == (0, 11.0)
    assert (world.edges == same.edges).all()
    assert (world.radii == same.radii).all()


def test_a_world_is_solved_at_both_radii(script, folder, tmp_path, capsys):
    file = tmp_path / "barn.csv"
    script.main(folder, file)
    rows = read_csv(file, COLUMNS)
    assert "1 of 1 solved" in capsys.readouterr().out
    for row, radius in zip(rows, script.RADII, strict=True):
        # Two tangents and an arc round one disc half way between start and goal.
        around, half = radius + 0.075, 5.0
        straight = np.sqrt(half**2 - around**2)
        optimum = 2 * straight + around * 2 * np.arcsin(around / half)
        assert row["length_m"] == pytest.approx(optimum, abs=1e-8)
        assert row["lower_bound_m"] == row["length_m"]
        assert row["clearance_m"] == pytest.approx(radius, abs=1e-8)


def test_what_is_no_source_is_refused(script, tmp_path):
    for source, what in ((tmp_path / "none", "no folder"), (tmp_path, "has no world_N.world")):
        with pytest.raises(fs.InvalidData, match=what):
            list(script.read(source))
    (tmp_path / "broken.npz").write_text("no archive")
    with pytest.raises(fs.InvalidData, match="give arrays world, x, y"):
        list(script.read(tmp_path / "broken.npz"))
    for text, what in (("no xml", "cannot be read"), (SURROUNDINGS.format(models=""), "cylinder")):
        (tmp_path / "world_0.world").write_text(text)
        with pytest.raises(fs.InvalidData, match=what):
            list(script.read(tmp_path))


def test_what_is_stored_is_proved_and_within_the_reference(script):
    rows = read_csv(DATA / "barn.csv", COLUMNS)
    by_radius = [[row for row in rows if row["radius_m"] == radius] for radius in script.RADII]
    for some in by_radius:
        assert [row["world"] for row in some] == list(range(300))
        for row in some:
            assert row["length_m"] == pytest.approx(row["lower_bound_m"], abs=1e-8)
            assert row["clearance_m"] >= row["radius_m"] - 1e-8
            # What BARN measures robots by is a path, and no path is shorter than the optimum.
            assert 10 <= row["length_m"] < row["reference_m"]
    for narrow, wide in zip(*by_radius, strict=True):
        assert narrow["length_m"] <= wide["length_m"]
