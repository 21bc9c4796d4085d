"""The store of a study: a folder of Parquet files that are whole, or computed again.

Each file is a chunk, the rows of some cases in a row. Its name says which, and the hash of
all its bytes; its metadata, which study they belong to. A chunk is never changed. What is
of no use to a reader of the rows has a name with an underscore, which readers of Parquet
pass over.
"""

import json
import os
import re
import warnings
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import partial
from hashlib import blake2b
from inspect import isbuiltin, isclass, isfunction
from os import PathLike
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from freeseg import checks
from freeseg.errors import InvalidData, InvalidParameter

if TYPE_CHECKING:
    from pyarrow.dataset import Dataset

Row = dict[str, Any]

#: What every row has, before what the function found.
COLUMNS = ("case", "case_seed", "failure")

#: Name of a chunk: its first case, the one after its last, and the hash of its bytes.
NAME = re.compile(r"(\d{12})-(\d{12})-([0-9a-f]{32})\.parquet")

#: What is being written.
UNFINISHED = "_unfinished"


def load(store: str | PathLike[str]) -> "Dataset":
    """Rows of a stored study, for those who want columns, or have more rows than memory.

    Parameters
    ----------
    store : path-like
        Its folder.

    Returns
    -------
    pyarrow.dataset.Dataset
        ``load(store).to_table()`` gives all rows, ``.to_batches()`` some at a
        time, both in the order of the cases.

    Raises
    ------
    InvalidData
        For a folder without chunks of a study, or with one that is damaged.
    """
    import pyarrow as pa
    from pyarrow import dataset

    folder = checks.file("store", store)
    chunks, damaged = scan(folder)
    if damaged:
        raise InvalidData(f"{damaged[0]} is damaged; run its study again, which computes it again")
    if not chunks:
        raise InvalidData(f"{folder} holds no rows of a study; give the store of one")
    schemas = [chunk.schema.remove_metadata() for chunk in chunks]
    try:
        # A column may be whole numbers in one chunk and others in the next, or hold nothing.
        schema = pa.unify_schemas(schemas, promote_options="permissive")
    except pa.ArrowException as error:
        raise InvalidData(
            f"{folder} has a column of several kinds ({error}); let the function return one kind"
        ) from None
    return dataset.dataset([chunk.path for chunk in chunks], schema)


class Chunk(NamedTuple):
    """A file of a store: the rows of the cases from `first` on, up to before `end`."""

    first: int
    end: int
    path: Path

    @property
    def schema(self) -> Any:
        """Columns of the rows, and metadata; read anew, for many chunks' take much memory."""
        from pyarrow import parquet

        return parquet.read_schema(self.path)

    def check(self, cases: list[Any]) -> None:
        """Raise `InvalidData` where these are other cases than the stored ones, or fewer."""
        if len(cases) < self.end - self.first:
            raise InvalidData(
                f"{self.path} holds cases up to number {self.end - 1}, more than there are; give "
                "all that the study had, or a store of its own"
            )
        if self.schema.metadata[b"cases_hash"].decode() != _hash(_as_json("cases", cases)):
            raise InvalidData(
                f"{self.path} holds other cases than those from {self.first} to {self.end - 1}; "
                "give the study a store of its own"
            )


def _hash(content: bytes) -> str:
    return blake2b(content, digest_size=16).hexdigest()


def describe(function: Callable[..., Any], seed: int) -> dict[str, str]:
    """Metadata of a study: function and parameters and seed, and a hash of them."""
    text = _as_json("function", {"function": function, "seed": seed})
    return {"study": text.decode(), "study_hash": _hash(text)}


def _as_json(name: str, value: Any) -> bytes:
    """What describes a value, equally in every process; or `InvalidParameter`."""
    try:
        return json.dumps(value, default=_plain).encode()
    except (TypeError, ValueError) as error:
        raise InvalidParameter(
            f"{name} is {checks.shown(value)}, of which no record can be kept ({error}); give "
            "functions of a module, with functools.partial for their parameters, and numbers, "
            "texts, arrays, dataclasses, and lists and dicts of these"
        ) from None


def _plain(value: Any) -> Any:
    """What JSON has for a value that it does not know."""
    if isinstance(value, partial):
        return {"of": value.func, "arguments": value.args, "parameters": value.keywords}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, PurePath):
        return str(value)
    if isclass(value) or isfunction(value) or isbuiltin(value):
        name = f"{value.__module__}.{value.__qualname__}"
        # What was made inside of a function may know more than its name says.
        if "<" not in name:
            return name
    elif is_dataclass(value):
        return {"type": type(value)} | {
            field.name: getattr(value, field.name) for field in fields(value)
        }
    raise TypeError(f"{checks.shown(value)} is none of these")


def to_parquet(rows: list[Row], study: dict[str, str], cases: list[Any]) -> bytes:
    """A chunk's file."""
    import cloudpickle
    import pyarrow as pa
    from pyarrow import parquet

    kinds = dict(zip(COLUMNS, (pa.int64(), pa.uint64(), pa.string()), strict=True))
    columns = {}
    for name in dict.fromkeys((*COLUMNS, *(name for row in rows for name in row))):
        values = [row.get(name) for row in rows]
        try:
            columns[name] = pa.array(values, kinds.get(name))
        except (pa.ArrowException, TypeError, ValueError, OverflowError) as error:
            raise InvalidParameter(
                f"function gave values {name} that cannot be stored ({error}); let it give "
                "numbers, texts, or lists of them, of one kind"
            ) from None
    more = {"cases": cloudpickle.dumps(cases), "cases_hash": _hash(_as_json("cases", cases))}
    table, sink = pa.table(columns), pa.BufferOutputStream()
    with parquet.ParquetWriter(sink, table.schema, compression="zstd", store_schema=False) as file:
        file.write_table(table)
        file.add_key_value_metadata(study | more)
    content: bytes = sink.getvalue().to_pybytes()
    return content


def resume(folder: Path, study: dict[str, str]) -> list[Chunk]:
    """What is stored of a study; what is damaged is put aside, with a warning."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        chunks, damaged = scan(folder)
        for path in damaged:
            warnings.warn(f"{path} is damaged; its cases are computed again", stacklevel=3)
            path.replace(path.with_name(f"_damaged-{path.name}"))
    except OSError as error:
        raise _unwritable(folder, error) from error
    for chunk in chunks:
        held = chunk.schema.metadata
        if held[b"study_hash"].decode() != study["study_hash"]:
            raise InvalidData(
                f"{folder} holds another study, {held[b'study'][: checks.LONGEST].decode()}; give "
                f"{study['study'][: checks.LONGEST]} a store of its own"
            )
    return chunks


def scan(folder: Path) -> tuple[list[Chunk], list[Path]]:
    """Chunks of a store, in order and none of a case twice; and the files that are damaged."""
    chunks: list[Chunk] = []
    damaged: list[Path] = []
    for path in folder.glob("[!_]*.parquet"):
        if (match := NAME.fullmatch(path.name)) is None:
            raise InvalidData(f"{path} is no chunk of a study; give a folder of its own")
        try:
            whole = _hash(path.read_bytes()) == match[3]
        except OSError as error:
            raise InvalidData(f"{path} cannot be read ({error}); make it readable") from error
        if whole:
            chunks.append(Chunk(int(match[1]), int(match[2]), path))
        else:
            damaged.append(path)
    return _apart(chunks), damaged


def _apart(chunks: list[Chunk]) -> list[Chunk]:
    """Chunks in order, no two with the same case, that hold the most cases together.

    Two runs at once may have computed the same cases, and their rows are equal, but not
    their chunks. Weighted interval scheduling: J. Kleinberg, E. Tardos, "Algorithm
    Design", 2005, section 6.1.
    """
    chunks = sorted(chunks, key=lambda chunk: (chunk.end, chunk.path))
    ends, most = [chunk.end for chunk in chunks], [0]
    for first, end, _ in chunks:
        most.append(max(most[-1], most[bisect_right(ends, first)] + end - first))
    kept, left = [], len(chunks)
    while left:
        if most[left] > most[left - 1]:
            kept.append(chunks[left - 1])
            left = bisect_right(ends, kept[-1].first)
        else:
            left -= 1
    return kept[::-1]


def write(path: Path, content: bytes) -> None:
    """Write a file that is there whole or not at all, whenever the power fails."""
    unfinished = path.with_name(UNFINISHED)
    try:
        with unfinished.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
        if os.name == "posix":
            # Only then is the new name on the disk, too.
            folder = os.open(path.parent, os.O_RDONLY)
            os.fsync(folder)
            os.close(folder)
    except OSError as error:
        raise _unwritable(path.parent, error) from error


def write_chunk(folder: Path, first: int, end: int, content: bytes) -> None:
    """Write a chunk under its name."""
    write(folder / f"{first:012d}-{end:012d}-{_hash(content)}.parquet", content)


def _unwritable(folder: Path, error: OSError) -> InvalidData:
    return InvalidData(
        f"{folder} cannot be written ({error}); what is there is kept: make room, or the folder "
        "writable, and run the study again"
    )
