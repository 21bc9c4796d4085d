"""The one reader, and the one writer, of the CSV files in ``data/``."""

import csv
import math
from collections.abc import Mapping, Sequence
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

from freeseg import checks
from freeseg.errors import InvalidData

#: Where the files are: ``data/`` of the collection, which is installed with the package.
DATA = Path(str(files("freeseg._data")))

#: What a column of each type has in its rows.
WANTED = {str: "some text", int: "a whole number", float: "a finite number"}


def read_csv(path: str | PathLike[str], columns: Mapping[str, type]) -> list[dict[str, Any]]:
    """Rows of a CSV file, with every value checked and converted.

    Parameters
    ----------
    path : path-like
        The file; its first line names the columns.
    columns : dict
        Column name to ``str``, ``int`` or ``float``. Further columns in the
        file are ignored.

    Returns
    -------
    list of dict
        One dict a row, with the columns asked for and ``"row"``, its
        line in the file.

    Raises
    ------
    InvalidData
        Where the file or a column is missing, the file has no row, or a value
        is absent or not a finite number; file, row and value are named.
    """
    path = checks.file("path", path)
    checks.instance("columns", columns, Mapping, "a dict of column name to type", InvalidData)  # type: ignore[type-abstract]
    for name, kind in columns.items():
        if kind not in WANTED:
            raise InvalidData(
                f"columns has {checks.shown(kind)} for {checks.shown(name)}; give str, int or float"
            )
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            found = reader.fieldnames or []
            lines = [(reader.line_num, line) for line in reader]
    except (OSError, ValueError, csv.Error) as error:
        raise InvalidData(
            f"{path.name} cannot be read ({error}); expected a CSV file at {path}"
        ) from error
    missing = [name for name in columns if name not in found]
    if missing:
        raise InvalidData(f"{path.name} has no column {missing[0]!r}; its columns are {found}")
    if not lines:
        raise InvalidData(f"{path.name} has no rows below its header; add at least one")

    def convert(row: int, name: str, kind: type, text: str | None) -> Any:
        try:
            value = kind(text or "")
            if not (value.strip() if kind is str else math.isfinite(value)):
                raise ValueError
        except (TypeError, ValueError, OverflowError):
            raise InvalidData(
                f"{path.name}, row {row}, column {name!r}: {text!r} is not {WANTED[kind]}"
            ) from None
        return value

    return [
        {"row": row}
        | {name: convert(row, name, kind, line[name]) for name, kind in columns.items()}
        for row, line in lines
    ]


def write_csv(path: str | PathLike[str], rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows to a CSV file, over what was there.

    Parameters
    ----------
    path : path-like
        The file.
    rows : sequence of dict
        One dict a row, all with the same columns.

    Raises
    ------
    InvalidData
        For a file that cannot be written, and for no rows, or rows of
        different columns.
    """
    path = checks.file("path", path)
    rows = checks.instances("rows", rows, Mapping, "one dict a row", InvalidData)
    if not rows or any(row.keys() != rows[0].keys() for row in rows):
        raise InvalidData(
            f"rows is {checks.shown(rows)}; give one or more, all with the same columns"
        )
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)
    except (OSError, ValueError, csv.Error) as error:
        raise InvalidData(
            f"{path} cannot be written ({error}); give a file in a folder that exists"
        ) from error
