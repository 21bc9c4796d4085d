"""The one place that starts processes: many independent cases, on all cores or on a cluster.

A study is a function and its cases. Without a store, `run` gives its rows. With one, a
folder, the rows are a Parquet data set that grows chunk by chunk, and a study that was
killed goes on where it stopped. The name of each file says which cases it holds, and
the hash of all its bytes: it is whole, or it is computed again. What is not of any use
to a reader of the rows begins with an underscore, and readers of Parquet pass over it.
"""

import json
import os
import pickle
import re
import sys
import threading
import time
import warnings
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sized
from concurrent.futures import BrokenExecutor, Future
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from functools import lru_cache, partial
from hashlib import blake2b
from importlib.util import find_spec
from inspect import isbuiltin, isclass, isfunction
from itertools import islice
from os import PathLike
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from freeseg import checks
from freeseg.errors import FreesegError, InvalidData, InvalidParameter

if TYPE_CHECKING:
    from pyarrow.dataset import Dataset

Row = dict[str, Any]

#: No machine has more cores.
MOST_JOBS = 10_000

#: About how long a worker is busy with one chunk (s): what a killed run loses of its work.
CHUNK_TIME = 10.0

#: More cases in a chunk would take much memory, and no less time.
MOST_CASES = 50_000

#: So often may the worker die that computes a chunk: its machine may be at fault, or the chunk.
MOST_DEATHS = 3

#: What every row has, before what the function found.
COLUMNS = ("case", "case_seed", "failure")

#: Name of a chunk: its first case, the one after its last, and the hash of its bytes.
NAME = re.compile(r"(\d{12})-(\d{12})-([0-9a-f]{32})\.parquet")

#: The function, for `replay`; and what is being written.
FUNCTION, UNFINISHED = "_function.pickle", "_unfinished"


def run(
    function: Callable[[Any, int], Mapping[str, Any] | Iterable[Mapping[str, Any]]],
    cases: Iterable[Any],
    store: str | PathLike[str] | None = None,
    seed: int = 0,
    *,
    jobs: int | None = None,
    chunk_time: float = CHUNK_TIME,
    strict: bool = False,
    progress: bool | None = None,
) -> Iterable[Row]:
    """Rows of a function for many independent cases.

    Parameters
    ----------
    function : callable
        ``function(case, seed)`` gives a row, a dict of name to number, text or
        list of them; or several rows, or none. It is to draw all its random
        numbers from the seed. What all cases share, its parameters, are given
        with `functools.partial`, for these are recorded.
    cases : iterable
        What to call it with; a generator, where they are too many for memory.
    store : path-like, optional
        Folder of the study, which is made. A study that has rows there goes
        on: with the same function, parameters, seed and cases, of which there
        may be more. One run at a time writes there.
    seed : int, optional
        Of the study; that of a case is `case_seed`.
    jobs : int, optional
        Processes; -1 for all cores. By default what the caller's
        ``joblib.parallel_config`` says, or else all cores. With 1, all runs
        in this process.
    chunk_time : float, optional
        About how long a worker computes before its rows are stored (s).
    strict : bool, optional
        Whether a case that raises an error ends the study with it. By default
        it is a row that says why.
    progress : bool, optional
        Whether to show a bar; by default where a terminal shows it.

    Returns
    -------
    iterable of dict
        Rows in the order of the cases: ``case``, its number from 0 on,
        ``case_seed`` and ``failure``, None unless the case failed; then what the
        function gave. They are equal for any number of workers.

    Raises
    ------
    InvalidParameter
        For what is no function of a case and a seed, are no cases, or is no
        number of processes; with a store, for what cannot be stored.
    InvalidData
        For a store that cannot be written, or that holds another study.
        What was written is kept.
    FreesegError
        Where a worker dies again and again.

    Examples
    --------
    >>> def square(case, seed):
    ...     return {"square": case**2}
    >>> [row["square"] for row in run(square, range(4), jobs=1)]
    [0, 1, 4, 9]
    """
    checks.function("function", function, "function(case, seed)", None, 0)
    if isinstance(cases, str | bytes) or not isinstance(cases, Iterable):
        raise InvalidParameter(f"cases is {checks.shown(cases)}; give a list of them")
    seed, jobs = checks.whole("seed", seed), _jobs(jobs)
    chunk_time = checks.positive("chunk_time", chunk_time)
    strict = checks.flag("strict", strict)
    if progress is not None:
        checks.flag("progress", progress)
    if store is None:
        chunks = _Chunks(cases, chunk_time)
        made = dict(_results(_Task(function, seed, strict), chunks, jobs, progress))
        rows = [row for first in sorted(made) for row in made[first]]
        names = dict.fromkeys(name for row in rows for name in row)
        # As stored: what a row has not is None.
        return [names | row for row in rows]
    folder, study = checks.file("store", store), _described(function, seed)
    chunks = _Chunks(cases, chunk_time, _resumed(folder, study))
    # A study that is complete writes nothing; any other one tries to, before it computes.
    if next(iter(chunks), None):
        import cloudpickle

        _write(folder / FUNCTION, cloudpickle.dumps(function))
        for first, content in _results(
            _Task(function, seed, strict, study), chunks, jobs, progress
        ):
            name = f"{first:012d}-{first + len(chunks.out[first]):012d}-{_hash(content)}.parquet"
            _write(folder / name, content)
    batches = load(folder).to_batches() if chunks.number else ()
    return (row for batch in batches for row in batch.to_pylist())


def case_seed(seed: int, case: int) -> int:
    """Seed of a case: 64 bits of the child with its number that ``SeedSequence(seed)`` spawns."""
    child = np.random.SeedSequence(
        checks.whole("seed", seed), spawn_key=(checks.whole("case", case),)
    )
    return int(child.generate_state(1, np.uint64)[0])


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
    chunks, damaged = _scan(folder)
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


def replay(store: str | PathLike[str], row: int | Mapping[str, Any]) -> Any:
    """Call the function of a stored study again, for one case alone.

    Parameters
    ----------
    store : path-like
        Folder of the study. Its function and cases are read with pickle, which
        runs what the file says: replay only what you trust.
    row : int or dict
        The case's number, or one of its rows.

    Returns
    -------
    object
        What the function returns; and what it raises comes through.

    Raises
    ------
    InvalidData
        For a store that has no such case, or cannot be read.
    InvalidParameter
        For what is no number of a case.
    """
    folder = checks.file("store", store)
    number = checks.whole("row", row.get("case") if isinstance(row, Mapping) else row)
    for chunk in _scan(folder)[0]:
        if chunk.first <= number < chunk.end:
            break
    else:
        raise InvalidData(f"{folder} has no case {number}; run its study as far as that")
    try:
        function = pickle.loads((folder / FUNCTION).read_bytes())
    except Exception as error:
        # Unpickling raises whatever the module that it imports does.
        raise InvalidData(
            f"{folder / FUNCTION} cannot be read ({error}); run the study again"
        ) from error
    told = chunk.schema.metadata
    case = pickle.loads(told[b"cases"])[number - chunk.first]
    return function(case, case_seed(json.loads(told[b"study"])["seed"], number))


def _jobs(jobs: Any) -> int | None:
    """`jobs`, or `InvalidParameter`."""
    if jobs is None:
        return None
    found = checks.whole("jobs", jobs, -1, "a whole number of processes, or -1 for all cores")
    if not (found == -1 or 0 < found <= MOST_JOBS):
        raise InvalidParameter(
            f"jobs is {checks.shown(jobs)}; give a number of processes up to {MOST_JOBS}, or -1 "
            "for all cores"
        )
    return found


@dataclass(frozen=True)
class _Task:
    """What a worker does with a chunk; with `study`, its metadata, it makes a Parquet file."""

    function: Callable[[Any, int], Any]
    seed: int
    strict: bool
    study: dict[str, str] | None = None

    def __call__(self, first: int, cases: list[Any]) -> tuple[int, Any, float]:
        """First case, result and duration (s)."""
        begin = time.perf_counter()
        found = [row for number, case in enumerate(cases, first) for row in self.rows(number, case)]
        made: Any = found if self.study is None else _parquet(found, self.study, cases)
        return first, made, time.perf_counter() - begin

    def rows(self, number: int, case: Any) -> list[Row]:
        """Rows of one case."""
        head: Row = {"case": number, "case_seed": case_seed(self.seed, number), "failure": None}
        try:
            found = self.function(case, head["case_seed"])
            found = [found] if isinstance(found, Mapping) else list(found)
            for row in found:
                if set(COLUMNS) & set(row) or not all(isinstance(name, str) for name in row):
                    raise InvalidParameter(
                        f"function gave {checks.shown(row)}; give a dict of texts to values, none "
                        f"of them called {', '.join(COLUMNS)}"
                    )
        except Exception as error:
            if self.strict:
                raise
            return [head | {"failure": f"{type(error).__name__}: {error}"[:1000]}]
        return [head | dict(row) for row in found]


class _Chunks:
    """Chunks of the cases that are not done; iterated again, first those that were not finished.

    Parameters
    ----------
    cases : iterable
        All cases.
    seconds : float
        How long a chunk is to take (s).
    done : list of _Chunk, optional
        What is stored.
    """

    def __init__(self, cases: Iterable[Any], seconds: float, done: Iterable["_Chunk"] = ()) -> None:
        self.total = len(cases) if isinstance(cases, Sized) else None
        self.cases, self.number, self.lock = iter(cases), 0, threading.Lock()
        self.seconds, self.size, self.workers = seconds, 1, 1
        self.done = list(done)
        self.stored = sum(chunk.end - chunk.first for chunk in self.done)
        self.out: dict[int, list[Any]] = {}

    def __iter__(self) -> Iterator[tuple[int, list[Any]]]:
        yield from tuple(self.out.items())
        while True:
            # joblib takes chunks in threads of its own.
            with self.lock:
                first, cases, stored = self.take()
                if cases and not stored:
                    self.out[first] = cases
            if stored:
                stored.check(cases)
            elif cases:
                yield first, cases
            elif self.done:
                self.done[0].check(cases)
            else:
                return

    def take(self) -> tuple[int, list[Any], "_Chunk | None"]:
        """The next chunk: its first case, its cases, and where they are stored."""
        first, stored, size = self.number, None, self.size
        if self.total is not None:
            # Towards the end, chunks get smaller, so that the workers end together.
            size = min(size, max(1, size // 10, (self.total - first) // (4 * self.workers)))
        if self.done:
            size = min(size, self.done[0].first - first)
            if not size:
                stored = self.done.pop(0)
                size = stored.end - first
        cases = list(islice(self.cases, size))
        self.number += len(cases)
        return first, cases, stored

    def finish(self, first: int, seconds: float) -> int:
        """Note that a chunk is done, and how many cases it had."""
        count = len(self.out.pop(first))
        size = min(4 * count, MOST_CASES, int(count * self.seconds / max(seconds, 1e-6)))
        self.size = max(1, size)
        return count


def _results(
    task: _Task, chunks: _Chunks, jobs: int | None, progress: bool | None
) -> Iterator[tuple[int, Any]]:
    """First case and result of every chunk, as they come."""
    deaths: Counter[int] = Counter()
    with _bar(chunks, progress) as advance:
        while True:
            try:
                for first, made, seconds in _computed(task, chunks, jobs):
                    yield first, made
                    advance(chunks.finish(first, seconds))
            except BrokenExecutor as error:
                deaths.update(chunks.out.keys())
                (first, times), *_ = deaths.most_common(1)
                if times > MOST_DEATHS:
                    raise FreesegError(
                        f"workers failed {times} times with the cases from {first} on ({error}); "
                        "give them memory and all that the function imports, or leave out the "
                        "case that ends them"
                    ) from error
            else:
                if not chunks.out:
                    return


def _computed(task: _Task, chunks: _Chunks, jobs: int | None) -> Iterable[tuple[int, Any, float]]:
    """What the task makes of the chunks: here, or where joblib is told to."""
    if jobs == 1:
        return (task(*chunk) for chunk in chunks)
    # Imported here: few need many cores, and it comes with the extra [study] only.
    from joblib import Parallel, delayed
    from joblib.parallel import get_active_backend

    backend, configured = get_active_backend()
    if hasattr(backend, "client"):
        _tell_of_losses(backend)
    parallel = Parallel(jobs or configured or -1, return_as="generator_unordered", batch_size=1)
    chunks.workers = parallel._effective_n_jobs()
    if getattr(backend, "supports_sharedmem", False):
        return parallel(delayed(task)(*chunk) for chunk in chunks)
    import cloudpickle

    # As bytes, for what a worker cannot import is then an error of the call, not of the cluster.
    packed = cloudpickle.dumps(task)
    return parallel(
        delayed(_call)(packed, first, cloudpickle.dumps(cases)) for first, cases in chunks
    )


def _call(task: bytes, first: int, cases: bytes) -> tuple[int, Any, float]:
    """What a task makes of a chunk, in a worker."""
    return _unpacked(task)(first, pickle.loads(cases))


@lru_cache(maxsize=2)
def _unpacked(task: bytes) -> _Task:
    """A study's task, which a worker unpacks once."""
    return pickle.loads(task)


def _tell_of_losses(backend: Any) -> None:
    """Make joblib's Dask backend tell when a task is lost: as it is, it waits for it for ever."""
    if "submit" in vars(backend):
        return
    submit, retrieve = backend.submit, backend.retrieve_result_callback

    def submit_and_tell(batch: Any, callback: Callable[[Any], object]) -> Any:
        def tell(done: Future[Any]) -> None:
            if error := done.exception():
                callback(BrokenExecutor(f"{type(error).__name__}: {error}"))

        future = submit(batch, callback)
        future.add_done_callback(tell)
        return future

    def retrieve_or_raise(made: Any) -> Any:
        if isinstance(made, BrokenExecutor):
            raise made
        return retrieve(made)

    backend.submit, backend.retrieve_result_callback = submit_and_tell, retrieve_or_raise


@contextmanager
def _bar(chunks: _Chunks, progress: bool | None) -> Iterator[Callable[[int], object]]:
    """What to call with the number of cases that were done: it may move a bar."""
    if progress is None:
        progress = sys.stderr.isatty() and find_spec("tqdm") is not None
    if not progress:
        yield int
        return
    from tqdm.auto import tqdm

    with tqdm(total=chunks.total, initial=chunks.stored, unit="case", smoothing=0.05) as bar:
        yield bar.update


class _Chunk(NamedTuple):
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


def _described(function: Callable[..., Any], seed: int) -> dict[str, str]:
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


def _parquet(rows: list[Row], study: dict[str, str], cases: list[Any]) -> bytes:
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


def _resumed(folder: Path, study: dict[str, str]) -> list[_Chunk]:
    """What is stored of a study; what is damaged is put aside, with a warning."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        chunks, damaged = _scan(folder)
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


def _scan(folder: Path) -> tuple[list[_Chunk], list[Path]]:
    """Chunks of a store, in order and none of a case twice; and the files that are damaged."""
    chunks: list[_Chunk] = []
    damaged: list[Path] = []
    for path in folder.glob("[!_]*.parquet"):
        if (match := NAME.fullmatch(path.name)) is None:
            raise InvalidData(f"{path} is no chunk of a study; give a folder of its own")
        try:
            whole = _hash(path.read_bytes()) == match[3]
        except OSError as error:
            raise InvalidData(f"{path} cannot be read ({error}); make it readable") from error
        if whole:
            chunks.append(_Chunk(int(match[1]), int(match[2]), path))
        else:
            damaged.append(path)
    return _apart(chunks), damaged


def _apart(chunks: list[_Chunk]) -> list[_Chunk]:
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


def _write(path: Path, content: bytes) -> None:
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


def _unwritable(folder: Path, error: OSError) -> InvalidData:
    return InvalidData(
        f"{folder} cannot be written ({error}); what is there is kept: make room, or the folder "
        "writable, and run the study again"
    )
