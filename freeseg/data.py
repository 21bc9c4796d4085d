"""The one reader, and the one writer, of the files in ``data/``: CSV, and NumPy's arrays."""

import csv
import math
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

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


def read_arrays(
    path: str | PathLike[str], names: Iterable[str] | None = None, again: str = "make it again"
) -> dict[str, np.ndarray]:
    """Arrays of an ``.npz`` file, by their names.

    Parameters
    ----------
    path : path-like
        The file.
    names : iterable of str, optional
        Those that are wanted; all that there are by default.
    again : str, optional
        What is to be done about a file that is broken.

    Returns
    -------
    dict
        Name to ndarray; nothing in the file is run.

    Raises
    ------
    InvalidData
        For a file that cannot be read, or lacks a name.
    """
    path = checks.file("path", path)
    if names is not None:
        names = checks.instances("names", names, str, "names of arrays", InvalidData)
    checks.instance("again", again, str, "what to do about a broken file", InvalidData)
    try:
        with np.load(path, allow_pickle=False) as stored:
            return {name: stored[name] for name in (stored.files if names is None else names)}
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        wanted = "" if names is None else f" for names {checks.shown(names)}"
        raise InvalidData(f"{path} cannot be read{wanted} ({error}); {again}") from error


def write_arrays(path: str | PathLike[str], arrays: Mapping[str, np.ndarray]) -> None:
    """Write arrays to an ``.npz`` file, over what was there.

    Parameters
    ----------
    path : path-like
        The file.
    arrays : dict
        Name to array.

    Raises
    ------
    InvalidData
        For a file that cannot be written, and for what is no dict.
    """
    path = checks.file("path", path)
    checks.instance("arrays", arrays, Mapping, "a dict of name to array", InvalidData)  # type: ignore[type-abstract]
    try:
        with path.open("wb") as file:
            np.savez_compressed(file, **arrays)  # type: ignore[arg-type]
    except OSError as error:
        raise InvalidData(
            f"{path} cannot be written ({error}); give a file in a folder that exists"
        ) from error


def read_rows(
    path: str | PathLike[str], columns: Mapping[str, type], again: str = "make it again"
) -> list[dict[str, Any]]:
    """Rows that `write_rows` stored, with NaN where there is no number.

    Parameters
    ----------
    path, again
        As for `read_arrays`.
    columns : dict
        Column name to ``str``, ``bool``, ``int``, ``float`` or a type of NumPy.

    Returns
    -------
    list of dict

    Raises
    ------
    InvalidData
        As `read_arrays`, and for columns of other types or lengths.
    """
    arrays = read_arrays(path, list(_check_kinds(columns)), again)
    size = next(iter(arrays.values())).shape[:1]
    for name, kind in columns.items():
        if arrays[name].dtype.kind != np.dtype(kind).kind or arrays[name].shape != size:
            raise InvalidData(f"{path} holds no such {name} as are kept; {again}")
    values = zip(*(column.tolist() for column in arrays.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in values]


def write_rows(
    path: str | PathLike[str], rows: Sequence[Mapping[str, Any]], columns: Mapping[str, type]
) -> None:
    """Store rows as arrays, one a column: smaller than CSV, and numbers to the last digit.

    Parameters
    ----------
    path : path-like
        The file, an ``.npz``.
    rows : sequence of dict
        With all of the columns.
    columns : dict
        As for `read_rows`.

    Raises
    ------
    InvalidData
        As `write_arrays`.
    """
    columns = _check_kinds(columns)
    rows = checks.instances("rows", rows, Mapping, "one dict a row", InvalidData)
    if any(columns.keys() - row.keys() for row in rows):
        raise InvalidData(f"rows is {checks.shown(rows)}; give them all of {', '.join(columns)}")
    arrays: dict[str, np.ndarray] = {}
    for name, kind in columns.items():
        try:
            arrays[name] = np.array([row[name] for row in rows], kind)
        except (TypeError, ValueError, OverflowError) as error:
            raise InvalidData(f"rows has a {name} that is no {kind.__name__} ({error})") from error
    write_arrays(path, arrays)


def _check_kinds(columns: Mapping[str, type]) -> Mapping[str, type]:
    """`columns` of `read_rows`, or `InvalidData`."""
    remedy = "a dict of column name to str, bool, int, float or a type of NumPy"
    checks.instance("columns", columns, Mapping, remedy, InvalidData)  # type: ignore[type-abstract]
    if not columns or not all(isinstance(kind, type) for kind in columns.values()):
        raise InvalidData(f"columns is {checks.shown(columns)}; give {remedy}")
    return columns
