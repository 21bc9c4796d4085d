"""Modules of plain loops, compiled by numba where that is installed."""

import logging
import sys
from functools import cache
from importlib.util import find_spec, module_from_spec
from types import FunctionType, ModuleType

#: Says, to those who listen, why the first plan takes longer.
LOGGER = logging.getLogger("freeseg")


@cache
def compiled(module: ModuleType) -> ModuleType:
    """A copy of a module of loops over arrays, compiled, or the module where numba is missing.

    Compiled once, it is stored beside its source and takes a third of a second to load.
    What it imports from other modules of this package is compiled too.
    """
    spec = find_spec(module.__name__)
    try:
        from numba import njit
    except ImportError:
        return module
    LOGGER.info(
        "loading %s for numba; the first time, it is compiled, which may take a minute",
        module.__name__,
    )
    assert spec is not None, "it is imported above"
    assert spec.loader is not None, "it is a file"
    copy = module_from_spec(spec)
    spec.loader.exec_module(copy)
    for name, thing in vars(copy).copy().items():
        if not isinstance(thing, FunctionType):
            continue
        if thing.__module__ == copy.__name__:
            # Divided by zero, numbers are as in NumPy: infinite or NaN.
            setattr(copy, name, njit(cache=True, error_model="numpy")(thing))
        elif thing.__module__.startswith(f"{__package__}."):
            setattr(copy, name, getattr(compiled(sys.modules[thing.__module__]), name))
    return copy
