"""What passes between a judge and the answers that it judges: numbers, texts, lists, arrays.

Both sides write JSON. An answer can be nothing else, so that no code of a notebook runs in
the process that judges it; the judge's questions may also hold a world or a reference.
"""

import dataclasses
import json
from typing import Any

import numpy as np

from freeseg.reference import Reference
from freeseg.robot import KheperaIV, Robot
from freeseg.world import Disc, Polygon, World

#: What a question may hold besides plain data, rebuilt from its fields.
KINDS = {kind.__name__: kind for kind in (Disc, KheperaIV, Polygon, Reference, Robot, World)}

#: How deep lists may stand in lists.
DEEPEST = 8


class NotPlain(AssertionError):
    """A value that is none of numbers, texts, lists, dicts, arrays."""


def pack(value: Any) -> str:
    """Write a value as JSON.

    Parameters
    ----------
    value : object
        Numbers, texts, None, arrays, tuples and lists, dicts with texts as keys, and in a
        question those of `KINDS`.

    Raises
    ------
    NotPlain
        For anything else.

    Examples
    --------
    >>> pack((1, np.array([2.5, 3.0])))
    '[1, {"$array": [2.5, 3.0]}]'
    """
    return json.dumps(_plain(value, DEEPEST))


def unpack(text: str | bytes, question: bool = False) -> Any:
    """Read what `pack` wrote; tuples come back as lists.

    Parameters
    ----------
    text : str or bytes
        JSON.
    question : bool, optional
        Whether it may hold those of `KINDS`; an answer may not.

    Raises
    ------
    NotPlain
        For what is none.
    """
    try:
        return json.loads(text, object_hook=_rebuilt if question else _array)
    except (ValueError, TypeError, RecursionError) as error:
        raise NotPlain(f"this is no plain data ({error})") from None


def _plain(value: Any, depth: int) -> Any:
    if value is None or isinstance(value, bool):
        return value
    for kind in (int, float, str):
        # Of subclasses, such as NumPy's floats, what they are made of.
        if isinstance(value, kind):
            return kind(value)
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biuf":
        return value.item() if value.ndim == 0 else {"$array": value.tolist()}
    if depth and isinstance(value, tuple | list):
        return [_plain(one, depth - 1) for one in value]
    if depth and isinstance(value, dict) and all(isinstance(key, str) for key in value):
        return {key: _plain(one, depth - 1) for key, one in value.items()}
    if KINDS.get(type(value).__name__) is type(value):
        fields = {one.name: getattr(value, one.name) for one in dataclasses.fields(value)}
        return {f"${type(value).__name__}": _plain(fields, depth)}
    raise NotPlain(f"this is a {type(value).__name__}; give numbers, or lists or arrays of them")


def _array(found: dict[str, Any]) -> Any:
    return np.array(found["$array"]) if list(found) == ["$array"] else found


def _rebuilt(found: dict[str, Any]) -> Any:
    name = next(iter(found), "")
    if len(found) == 1 and name[1:] in KINDS and name.startswith("$"):
        return KINDS[name[1:]](**found[name])
    return _array(found)
