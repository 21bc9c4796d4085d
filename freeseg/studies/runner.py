"""The one place that starts processes: many independent cases on all cores."""

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def run(
    function: Callable[[Item], Result], cases: Iterable[Item], jobs: int = 1
) -> Iterator[Result]:
    """Results of a function for many cases, as they come.

    Parameters
    ----------
    function : callable
        ``function(case)``; it and its results are sent between processes.
    cases : iterable
        What to call it with.
    jobs : int, optional
        Processes; -1 for all cores.

    Yields
    ------
    object
        Results, in the order of the cases.
    """
    if jobs == 1:
        yield from map(function, cases)
        return
    # Imported here: few need many cores, and it comes with the extra [study] only.
    from joblib import Parallel, delayed

    yield from Parallel(jobs, return_as="generator")(delayed(function)(case) for case in cases)
