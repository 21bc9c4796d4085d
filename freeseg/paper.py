"""The paper's worlds and questions: Tables 1 to 5, and the panels of Figs 13 to 16."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from freeseg import checks
from freeseg.data import DATA, read_csv
from freeseg.errors import InvalidData, InvalidParameter, InvalidWorld
from freeseg.world import Disc, World

#: The map of the paper's Fig. 12: x and y from ... to ... (mm).
MAP_MM = ((0, 900), (-100, 900))


def load_table(table: int, folder: str | PathLike[str] = DATA) -> World:
    """One of the paper's Tables 1 to 5 as a world.

    The paper gives the centres only. Shapes and sizes are an assumption:
    discs, with the radii in ``obstacles.csv``, which make all true that the
    paper says of safe and danger segments (notebook A1).

    Parameters
    ----------
    table : int
        Which one, 1 to 5.
    folder : path-like
        Where ``tables.csv`` and ``obstacles.csv`` are.

    Returns
    -------
    World
        Seven discs (m), in the paper's order.

    Raises
    ------
    InvalidParameter
        For a table that is not there.
    InvalidData
        For a missing file or column, a value that is no number, an obstacle
        that is repeated, left out or without a size, or a centre off the map of Fig. 12.
    InvalidWorld
        For sizes with which two obstacles meet: in the paper none do.

    Examples
    --------
    >>> [round(1000 * radius) for radius in load_table(1).radii]
    [18, 18, 18, 39, 39, 18, 24]
    """
    centers_mm, radii_mm = _centers_mm(folder), _radii_mm(folder)
    tables = sorted({known for known, _ in centers_mm})
    remedy = f"one of {tables}, which tables.csv has"
    table = checks.whole("table", table, remedy=remedy)
    if table not in tables:
        raise InvalidParameter(f"table is {table}; give {remedy}")
    obstacles = sorted(obstacle for known, obstacle in centers_mm if known == table)
    if len(obstacles) != len(radii_mm):
        raise InvalidData(
            f"obstacles.csv has {len(radii_mm)} sizes for the {len(obstacles)} obstacles of "
            f"table {table}; give each one"
        )
    world = World(
        [
            Disc(np.divide(centers_mm[table, obstacle], 1000), radii_mm[obstacle] / 1000)
            for obstacle in obstacles
        ]
    )
    first, second = world.close_pairs(world.round_off)
    if len(first):
        raise InvalidWorld(
            f"obstacles {first[0] + 1} and {second[0] + 1} of table {table} touch or overlap, "
            "unlike the paper's; give smaller sizes in obstacles.csv"
        )
    return world


def _centers_mm(folder: str | PathLike[str]) -> dict[tuple[int, int], tuple[float, float]]:
    """Centres (mm) in ``tables.csv``, by table and obstacle."""
    columns = {"table": int, "obstacle": int, "x_mm": float, "y_mm": float}
    rows = read_csv(f"{folder}/tables.csv", columns)
    for table in {row["table"] for row in rows}:
        _check_numbering("tables.csv", [row for row in rows if row["table"] == table])
    for row in rows:
        for axis, (low, high) in zip(("x_mm", "y_mm"), MAP_MM, strict=True):
            if not low <= row[axis] <= high:
                raise InvalidData(
                    f"tables.csv, row {row['row']}: {axis} is {row[axis]:g}, "
                    f"off the map of Fig. 12 ({low} to {high} mm)"
                )
    return {(row["table"], row["obstacle"]): (row["x_mm"], row["y_mm"]) for row in rows}


def _radii_mm(folder: str | PathLike[str]) -> dict[int, float]:
    """Radii (mm) in ``obstacles.csv``, by obstacle."""
    rows = read_csv(f"{folder}/obstacles.csv", {"obstacle": int, "shape": str, "radius_mm": float})
    _check_numbering("obstacles.csv", rows)
    for row in rows:
        if row["shape"] != "disc":
            raise InvalidData(
                f"obstacles.csv, row {row['row']}: shape {row['shape']!r} is not known; give disc"
            )
        if row["radius_mm"] <= 0:
            raise InvalidData(
                f"obstacles.csv, row {row['row']}: radius_mm is {row['radius_mm']:g}; "
                "give a positive one"
            )
    return {row["obstacle"]: row["radius_mm"] for row in rows}


def _check_numbering(file: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """Obstacles must be numbered 1 to n, each once."""
    seen: set[int] = set()
    for row in rows:
        obstacle = row["obstacle"]
        if obstacle in seen:
            raise InvalidData(
                f"{file}, row {row['row']}: obstacle {obstacle} is there twice; keep one"
            )
        if not 1 <= obstacle <= len(rows):
            raise InvalidData(
                f"{file}, row {row['row']}: obstacle {obstacle} is out of range; "
                f"number the {len(rows)} obstacles 1 to {len(rows)}"
            )
        seen.add(obstacle)


@dataclass(frozen=True)
class Case:
    """One panel of the paper's Figs 13 to 16."""

    name: str
    table: int
    start: tuple[float, float]
    goal: tuple[float, float]
    caption: str


def load_cases(folder: str | PathLike[str] = DATA) -> dict[str, Case]:
    """The 16 panels of Figs 13 to 16: name to `Case`, positions in m.

    Raises
    ------
    InvalidData
        For a missing file or column, a value that is no number, or a case
        that is there twice.

    Examples
    --------
    >>> load_cases()["16b"].start
    (0.4, 0.0)
    """
    rows = read_csv(
        f"{folder}/cases.csv",
        {"case": str, "table": int, "caption": str}
        | dict.fromkeys(("start_x_mm", "start_y_mm", "goal_x_mm", "goal_y_mm"), float),
    )
    cases = {}
    for row in rows:
        if row["case"] in cases:
            raise InvalidData(
                f"cases.csv, row {row['row']}: case {row['case']!r} is there twice; keep one"
            )
        cases[row["case"]] = Case(
            row["case"],
            row["table"],
            (row["start_x_mm"] / 1000, row["start_y_mm"] / 1000),
            (row["goal_x_mm"] / 1000, row["goal_y_mm"] / 1000),
            row["caption"],
        )
    return cases
