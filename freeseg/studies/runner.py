"""The one place that starts processes: many independent cases on all cores."""

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from freeseg import checks
from freeseg.errors import InvalidParameter

#: No machine has more cores.
MOST_JOBS = 10_000

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

    Returns
    -------
    iterator
        Results, in the order of the cases.

    Raises
    ------
    InvalidParameter
        For what is no function of one case, are no cases, or is no number of
        processes.
    """
    checks.function("function", function, "function(case)", None)
    jobs = checks.whole("jobs", jobs, -1, "a whole number of processes, or -1 for all cores")
    if not (jobs == -1 or 0 < jobs <= MOST_JOBS):
        raise InvalidParameter(
            f"jobs is {checks.shown(jobs)}; give a number of processes up to {MOST_JOBS}, or -1 "
            "for all cores"
        )
    if isinstance(cases, str | bytes) or not isinstance(cases, Iterable):
        raise InvalidParameter(f"cases is {checks.shown(cases)}; give a list of them")
    if jobs == 1:
        return map(function, cases)
    # Imported here: few need many cores, and it comes with the extra [study] only.
    from joblib import Parallel, delayed

    return Parallel(jobs, return_as="generator")(delayed(function)(case) for case in cases)
