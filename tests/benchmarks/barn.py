"""The shortest path in each world of BARN: ``python tests/benchmarks/barn.py SOURCE``.

BARN is the data set of the Benchmark Autonomous Robot Navigation challenge (D. Perille,
A. Truong, X. Xiao, P. Stone, "Benchmarking Metric Ground Navigation", *SSRR* 2020): 300
worlds of cylinders that touch, each for a Jackal to cross from the same start to the
same goal. The source is a folder of its ``world_N.world`` files, with or without the
folder ``path_files`` beside them, or an ``.npz`` with their numbers: arrays ``world``,
``x``, ``y`` (m) of a row a cylinder, ``radius`` (m) and ``reference_length`` (m) of a
row a world. The worlds themselves are no part of this collection.

Prints how many worlds are solved and how fast, and stores a row a world and radius in
``data/barn.csv``: the optimum, the lower bound that proves it, and the length of the path
that BARN's score measures a robot by. Worlds are new to the planner, so its time
includes the preparation.
"""

import re
import sys
import time
import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

import freeseg as fs
from freeseg.data import DATA, write_csv

FILE = DATA / "barn.csv"

#: Where BARN has a robot start, and its goal (m).
START, GOAL = (-2.25, 3.0), (-2.25, 13.0)

#: Radii (m) of the circle in a Jackal's outline of 0.43 m by 0.508 m, which it needs straight
#: ahead, and of the one round it, which clears whichever way it heads.
RADII = 0.215, float(np.ceil(1e4 * np.hypot(0.43, 0.508) / 2) / 1e4)

#: Cells of BARN's reference paths: their size (m), and where cell (0, 0) is (m).
CELL, CORNER = 0.15, (-4.575, 5.075)


def read(source):
    """Number, world and reference length (m, or NaN) of every world in a folder or an ``.npz``."""
    source = Path(source)
    if source.is_dir():
        return read_folder(source)
    if source.suffix == ".npz" and source.is_file():
        return read_arrays(source)
    raise fs.InvalidData(f"{source} is no folder of world files and no .npz; give one of them")


def read_folder(folder):
    """As `read`, from the files of the data set."""
    files = {}
    for file in folder.glob("world_*.world"):
        if match := re.fullmatch(r"world_(\d+)", file.stem):
            files[int(match[1])] = file
    if not files:
        raise fs.InvalidData(f"{folder} has no world_N.world; give the folder with BARN's files")
    for number, file in sorted(files.items()):
        reference = folder / "path_files" / f"path_{number}.npy"
        length = reference_length(np.load(reference)) if reference.is_file() else np.nan
        yield number, read_world(file), length


def read_world(file):
    """The cylinders of a Gazebo world as discs."""
    try:
        models = ET.parse(file).iter("model")
        discs = [disc for model in models if (disc := disc_of(model)) is not None]
    except (OSError, ValueError, ET.ParseError) as error:
        raise fs.InvalidData(f"{file} cannot be read ({error}); give a Gazebo world") from error
    if not discs:
        raise fs.InvalidData(f"{file} has no cylinder; give a world of BARN")
    return fs.World(discs)


def disc_of(model):
    """The disc that a model of a world stands on, or None where it is no cylinder."""
    radius = model.findtext("link/collision/geometry/cylinder/radius")
    if radius is None:
        return None
    x, y = (model.findtext("pose") or "").split()[:2]
    return fs.Disc((float(x), float(y)), float(radius))


def reference_length(cells):
    """Length (m) of BARN's reference path, from the start by the middles of cells to the goal."""
    points = np.vstack([START, CELL * np.asarray(cells, float) + CORNER, GOAL])
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def read_arrays(file):
    """As `read`, from arrays."""
    try:
        with np.load(file) as arrays:
            number, x, y, radius, lengths = (
                arrays[name] for name in ("world", "x", "y", "radius", "reference_length")
            )
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise fs.InvalidData(
            f"{file} cannot be read ({error}); give arrays world, x, y, radius, reference_length"
        ) from error
    # What was stored in single precision was given in millimetres.
    centers = np.round(np.column_stack([x, y]).astype(float), 4)
    radii = np.round(np.broadcast_to(radius, len(x)).astype(float), 4)
    for index, length in enumerate(lengths.tolist()):
        here = number == index
        pairs = zip(centers[here], radii[here], strict=True)
        yield index, fs.World([fs.Disc(center, size) for center, size in pairs]), length


def solve(number, world, reference, radius):
    """A row on one world for a disc of a radius (m), and the time that planning took (ms)."""
    robot = fs.KheperaIV(diameter=2 * radius)
    begin = time.perf_counter()
    try:
        plan = fs.shortest_path(world, START, GOAL, robot, 0.0)
    except fs.NoPath:
        plan = None
    duration = 1e3 * (time.perf_counter() - begin)
    row = {
        "world": number,
        "radius_m": radius,
        "discs": len(world),
        "length_m": plan.path.length if plan else np.nan,
        "lower_bound_m": plan.lower_bound if plan else np.nan,
        "clearance_m": plan.path.clearance(world) if plan else np.nan,
        "reference_m": reference,
    }
    return {name: round(x, 9) if isinstance(x, float) else x for name, x in row.items()}, duration


def main(source, file=FILE):
    """Solve, print, and write the rows to a file if one is given."""
    warm_up = fs.random_world(100, 1)
    fs.shortest_path(warm_up, *fs.random_query(warm_up, 1))
    found = [
        solve(number, fs.World(world.obstacles), reference, radius)
        for number, world, reference in read(source)
        for radius in RADII
    ]
    for radius in RADII:
        rows, times = zip(*(one for one in found if one[0]["radius_m"] == radius), strict=True)
        length, bound, reference = (
            np.array([row[name] for row in rows])
            for name in ("length_m", "lower_bound_m", "reference_m")
        )
        solved = np.isfinite(length)
        print(
            f"R = {radius:.4f} m: {solved.sum()} of {len(rows)} solved; "
            f"median {np.median(times):.1f} ms, p90 {np.quantile(times, 0.9):.1f} ms, "
            f"worst {max(times):.1f} ms"
        )
        if solved.any():
            longer = 100 * (reference / length - 1)[solved]
            print(
                f"    above the bound by at most {1e9 * (length - bound)[solved].max():.3g} nm; "
                f"BARN's reference is longer by {np.median(longer):.1f} % in the median, "
                f"{longer.min():.1f} to {longer.max():.1f} %"
            )
    if file:
        write_csv(file, [row for row, _ in found])


if __name__ == "__main__":
    main(*sys.argv[1:2]) if len(sys.argv) > 1 else sys.exit(__doc__)
