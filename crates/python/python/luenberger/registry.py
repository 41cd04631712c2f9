"""The kinds of observers that a study can ask for, and an observer of any of them."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _luenberger
from .errors import InvalidArgument
from .observers import Observer
from .plants import any_plant

__all__ = ["Kind", "kinds", "observer"]


@dataclass(frozen=True)
class Kind:
    """A kind of observers.

    Attributes
    ----------
    name : str
        Its name, as for `observer` and in study files.
    about : str
        What it is.
    source : str
        Where it is from: paper and equation.
    plants : str
        The plants that it is for.
    keys : dict of str to str
        What each of its keys says; those that have to be given are in `required`.
    required : tuple of str
        The keys without a default.

    Examples
    --------
    >>> import luenberger
    >>> luenberger.kinds()["reduced-order"].keys["poles"]
    'Eigenvalues of F: n - p numbers, complex ones as [re, im] with their conjugates.'
    """

    name: str
    about: str
    source: str
    plants: str
    keys: dict[str, str]
    required: tuple[str, ...]


def kinds() -> dict[str, Kind]:
    """All kinds of observers, by name.

    Returns
    -------
    dict of str to Kind

    Examples
    --------
    >>> import luenberger
    >>> kind = luenberger.kinds()["sliding-mode"]
    >>> kind.required
    ('bound', 'period')
    """
    found = {}
    for entry in json.loads(_luenberger.kinds()):
        keys = {key["name"]: key["about"] for key in entry["keys"]}
        required = tuple(key["name"] for key in entry["keys"] if key["required"])
        name = entry["name"]
        found[name] = Kind(name, entry["about"], entry["source"], entry["plants"], keys, required)
    return found


def observer(
    kind: str,
    plant: Any,
    keys: Mapping[str, Any] | None = None,
    *,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
    **more: Any,
) -> Observer:
    """Observer of any kind, by the keys that a study file has.

    The functions of their own (`place_observer`, `lqe`, ..) check shapes and units of their arguments first; this one
    takes the keys as they are, and every kind.

    Parameters
    ----------
    kind : str
        One of `kinds()`.
    plant : Plant or StateSpace
        The plant, of any of the accepted types.
    keys : dict, optional
        The keys, for names that are no names in Python, such as `lambda`.
    xhat0 : array_like, (n,), optional
        Initial estimate (default 0).
    name : str, optional
        Name of the observer.
    **more
        The keys; arrays become lists of rows.

    Returns
    -------
    Observer

    Raises
    ------
    InvalidArgument
        No kind of this name, a key that the kind does not have, or a value of the wrong type or size.
    NotApplicable
        A hypothesis of the kind that the plant does not have.

    Examples
    --------
    >>> import luenberger
    >>> sys = luenberger.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    >>> luenberger.observer("extended-state", sys, e=[[0], [1]], bandwidth=3).verdict
    'proved'
    """
    known = _luenberger.kinds()
    names = [entry["name"] for entry in json.loads(known)]
    if kind not in names:
        near = difflib.get_close_matches(str(kind), names, n=1)
        nearest = f"; the nearest is {near[0]!r}" if near else ""
        raise InvalidArgument(f"there is no kind of observers {kind!r}{nearest}")
    given = {**(keys or {}), **more}
    spec = {"kind": kind, **{key: _plain(key, value) for key, value in given.items()}}
    return Observer(any_plant(plant), spec, xhat0=xhat0, name=name)


def _plain(key: str, value: Any) -> Any:
    """A value as JSON has it."""
    if isinstance(value, Mapping):
        return {str(inner): _plain(f"{key}.{inner}", of) for inner, of in value.items()}
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "biuf":
            raise InvalidArgument(f"{key} is an array of {value.dtype}: numbers are expected")
        return _plain(key, value.tolist())
    if isinstance(value, np.generic):
        return _plain(key, value.item())
    if isinstance(value, list | tuple | set | frozenset | range | Iterator):
        return [_plain(key, entry) for entry in value]
    if isinstance(value, complex):
        return [value.real, value.imag] if value.imag else value.real
    if isinstance(value, float) and not np.isfinite(value):
        # JSON has no infinity, and a study has it as text.
        return "nan" if np.isnan(value) else "inf" if value > 0 else "-inf"
    return value
