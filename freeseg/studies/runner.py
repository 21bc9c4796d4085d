"""The one place that starts processes: many independent cases, on all cores or on a cluster.

A study is a function and its cases. Without a store, `run` gives its rows. With one, they
are kept in a folder chunk by chunk, see `freeseg.studies.store`, and a study that was
killed goes on where it stopped.
"""

import json
import pickle
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sized
from concurrent.futures import BrokenExecutor, Future
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from itertools import islice
from os import PathLike
from typing import Any

import numpy as np

from freeseg import checks
from freeseg.errors import FreesegError, InvalidData, InvalidParameter
from freeseg.studies.store import (
    COLUMNS,
    Chunk,
    Row,
    describe,
    load,
    resume,
    scan,
    to_parquet,
    write,
    write_chunk,
)

#: No machine has more cores.
MOST_JOBS = 10_000

#: About how long a worker is busy with one chunk (s): what a killed run loses of its work.
CHUNK_TIME = 10.0

#: More cases in a chunk would take much memory, and no less time.
MOST_CASES = 50_000

#: So often may the worker die that computes a chunk: its machine may be at fault, or the chunk.
MOST_DEATHS = 3

#: File of a store with the function, for `replay`.
FUNCTION = "_function.pickle"


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
    folder, study = checks.file("store", store), describe(function, seed)
    chunks = _Chunks(cases, chunk_time, resume(folder, study))
    # A study that is complete writes nothing; any other one tries to, before it computes.
    if next(iter(chunks), None):
        import cloudpickle

        write(folder / FUNCTION, cloudpickle.dumps(function))
        for first, content in _results(
            _Task(function, seed, strict, study), chunks, jobs, progress
        ):
            write_chunk(folder, first, first + len(chunks.out[first]), content)
    batches = load(folder).to_batches() if chunks.number else ()
    return (row for batch in batches for row in batch.to_pylist())


def case_seed(seed: int, case: int) -> int:
    """Seed of a case: 64 bits of the child with its number that ``SeedSequence(seed)`` spawns."""
    child = np.random.SeedSequence(
        checks.whole("seed", seed), spawn_key=(checks.whole("case", case),)
    )
    return int(child.generate_state(1, np.uint64)[0])


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
    for chunk in scan(folder)[0]:
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
        made: Any = found if self.study is None else to_parquet(found, self.study, cases)
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
    done : list of Chunk, optional
        What is stored.
    """

    def __init__(self, cases: Iterable[Any], seconds: float, done: Iterable["Chunk"] = ()) -> None:
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

    def take(self) -> tuple[int, list[Any], "Chunk | None"]:
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
