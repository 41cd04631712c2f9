"""Arguments as arrays of the shape and dtype that is asked for."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import DimensionMismatch, InvalidArgument, InvalidPole, NotFinite, NotSymmetric, WrongDtype

Array = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


def real(what: str, value: Any, *, missing: bool = False) -> Array:
    """`value` as an array of float64: integers and booleans are converted, complex numbers and objects refused.

    Masked entries, None and pandas' NA are NaN where a value may be missing, and refused elsewhere.
    """
    array: Any
    try:
        array = np.asanyarray(value)
    except ValueError as error:  # rows of different lengths
        raise InvalidArgument(f"{what} is not an array: {error}") from None
    if isinstance(array, np.ma.MaskedArray):
        array = _unmasked(what, array, missing)
    array = np.asarray(array)
    if array.dtype.kind == "O":
        array = _of_objects(what, value, array, missing)
    if array.dtype.kind not in "biuf":
        if array.dtype.kind == "c" and not np.any(array.imag):
            array = array.real
        else:
            raise WrongDtype(
                f"{what} has the dtype {array.dtype}, and real numbers are needed", what=what, dtype=str(array.dtype)
            )
    found: Array = array.astype(np.float64, copy=False)
    return found


def _unmasked(what: str, array: Any, missing: bool) -> Any:
    """A masked array with NaN for what is masked."""
    mask = np.ma.getmaskarray(array)
    if not mask.any():
        return array.data
    if not missing:
        place = ", ".join(str(int(i)) for i in np.argwhere(mask)[0])
        raise InvalidArgument(f"{what}[{place}] is masked" if place else f"{what} is masked", what=what)
    if array.dtype.kind == "c":
        return array.data  # refused as such
    return array.astype(np.float64).filled(np.nan)


def is_missing(value: Any) -> bool:
    """None, a masked entry, and pandas' NA and NaT."""
    return value is None or value is np.ma.masked or type(value).__name__ in ("NAType", "NaTType")


def _of_objects(what: str, value: Any, array: Any, missing: bool) -> Any:
    """Numbers among which some are missing: a list with None, and the nullable columns of pandas."""
    entries = [entry for entry in array.flat if not is_missing(entry)]
    is_complete = len(entries) == array.size
    if is_complete and not hasattr(value, "to_numpy"):
        return array
    if not all(isinstance(entry, (int, float, np.integer, np.floating, np.bool_)) for entry in entries):
        return array
    if not is_complete and not missing:
        raise InvalidArgument(f"{what} has a missing entry", what=what)
    numbers = [np.nan if is_missing(entry) else float(entry) for entry in array.flat]
    return np.array(numbers, dtype=np.float64).reshape(array.shape)


def finite(what: str, array: Array) -> Array:
    """The array, if no entry is NaN or infinite."""
    bad = ~np.isfinite(array)
    if bad.any():
        entry = tuple(int(i) for i in np.argwhere(bad)[0])
        row, column = (entry + (0, 0))[:2]
        value = float(array[entry])
        place = f"[{', '.join(map(str, entry))}]" if entry else ""
        raise NotFinite(f"{what}{place} is {value}", what=what, row=row, column=column, value=value)
    return array


def matrix(
    what: str, value: npt.ArrayLike, rows: int | None = None, columns: int | None = None, *, vector: str = "column"
) -> Array:
    """A finite matrix. A number is 1 x 1, and a one-dimensional array a column or a row."""
    array = real(what, value)
    if array.ndim < 2:
        array = array.reshape((-1, 1) if vector == "column" else (1, -1)) if array.ndim else array.reshape(1, 1)
    if array.ndim != 2:
        raise DimensionMismatch(
            f"{what} has {array.ndim} dimensions, and a matrix is needed", what=what, expected=(2,), found=(array.ndim,)
        )
    found = (int(array.shape[0]), int(array.shape[1]))
    expected = (found[0] if rows is None else rows, found[1] if columns is None else columns)
    if found != expected:
        raise DimensionMismatch(
            f"{what} must be {expected[0]} x {expected[1]}, found {found[0]} x {found[1]}",
            what=what,
            expected=expected,
            found=found,
        )
    return finite(what, array)


def square(what: str, value: npt.ArrayLike) -> Array:
    """A finite square matrix."""
    array = matrix(what, value)
    side = max(array.shape)
    return matrix(what, array, side, side)


def vector(what: str, value: npt.ArrayLike, length: int | None = None) -> Array:
    """A finite vector; a matrix with one row or column is taken as one."""
    array = real(what, value)
    if array.ndim == 2 and 1 in array.shape:
        array = array.ravel()
    array = np.atleast_1d(array)
    if array.ndim != 1 or (length is not None and array.shape[0] != length):
        expected = (int(array.size) if length is None else length,)
        raise DimensionMismatch(
            f"{what} must have {expected[0]} entries, and has the shape {array.shape}",
            what=what,
            expected=expected,
            found=tuple(int(n) for n in array.shape),
        )
    return finite(what, array)


def weight(what: str, value: npt.ArrayLike, order: int) -> Array:
    """A matrix of this order: a number times the identity, the diagonal, or the matrix."""
    array = real(what, value)
    if array.ndim == 0:
        return finite(what, array * np.eye(order))
    if array.ndim == 1:
        return np.diag(vector(what, array, order))
    return matrix(what, array, order, order)


def poles(value: Iterable[complex] | npt.ArrayLike) -> ComplexArray:
    """A list of poles."""
    given: Any = value
    if isinstance(given, Iterable) and not hasattr(given, "__array__") and not isinstance(given, (str, bytes)):
        given = list(given)  # a set or a generator
    array = np.atleast_1d(np.asarray(given))
    if array.dtype.kind not in "biufc":
        raise WrongDtype(
            f"poles has the dtype {array.dtype}, and numbers are needed", what="poles", dtype=str(array.dtype)
        )
    if array.ndim != 1:
        raise InvalidPole(f"poles is a list, and has the shape {array.shape}", found=array.size)
    bad = ~np.isfinite(array)
    if bad.any():
        k = int(np.argmax(bad))
        raise InvalidPole(f"pole {k} is {array[k]}", index=k, pole=complex(array[k]))
    return array.astype(np.complex128)


def number(what: str, value: Any, *, positive: bool = False) -> float:
    """A finite number."""
    array = real(what, value)
    if array.size != 1:
        raise DimensionMismatch(
            f"{what} is a number, and has the shape {array.shape}", what=what, expected=(1,), found=array.shape
        )
    x = float(finite(what, array).reshape(-1)[0])
    if positive and x <= 0.0:
        raise InvalidArgument(f"{what} must be positive, and is {x}", what=what, value=x)
    return x


def count(what: str, value: Any, least: int | None = None) -> int:
    """A whole number; one with a fraction is not cut."""
    try:
        found = operator.index(value)
    except TypeError:
        raise InvalidArgument(f"{what} is {value!r}", what=what, hint="a whole number") from None
    if least is not None and found < least:
        raise InvalidArgument(f"{what} is {found}", what=what, hint=f"a whole number of at least {least}")
    return found


def frozen(array: npt.ArrayLike) -> Array:
    """A copy that nothing changes: what is proved is proved of its numbers."""
    copy = np.array(array, dtype=np.float64)
    copy.setflags(write=False)
    return copy


def symmetric(what: str, array: Array) -> Array:
    """A square matrix that is symmetric up to rounding, by the tolerance of the designs."""
    differences = np.abs(array - array.T)
    allowed = 8.0 * len(array) * float(np.finfo(np.float64).eps) * float(np.abs(array).max(initial=0.0))
    worst = float(differences.max(initial=0.0))
    if worst > allowed:
        column, row = (int(i) for i in np.argwhere(np.triu(differences) == worst)[0])
        raise NotSymmetric(
            f"{what} is not symmetric: entries ({row + 1}, {column + 1}) and ({column + 1}, {row + 1}) differ by "
            f"{worst:.3g} (limit {allowed:.3g})",
            what=what,
            row=row,
            column=column,
            asymmetry=worst,
            allowed=allowed,
        )
    return array
