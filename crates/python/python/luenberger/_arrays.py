"""Arguments as arrays of the shape and dtype that is asked for."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import DimensionMismatch, InvalidArgument, InvalidPole, NotFinite, WrongDtype

Array = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


def real(what: str, value: npt.ArrayLike) -> Array:
    """`value` as an array of float64: integers and booleans are converted, complex numbers and objects refused."""
    try:
        array = np.asarray(value)
    except ValueError as error:  # rows of different lengths
        raise InvalidArgument(f"{what} is not an array: {error}") from None
    if array.dtype.kind not in "biuf":
        if array.dtype.kind == "c" and not np.any(array.imag):
            array = array.real
        else:
            raise WrongDtype(
                f"{what} has the dtype {array.dtype}, and real numbers are needed", what=what, dtype=str(array.dtype)
            )
    return array.astype(np.float64, copy=False)


def finite(what: str, array: Array) -> Array:
    """The array, if no entry is NaN or infinite."""
    bad = ~np.isfinite(array)
    if bad.any():
        entry = tuple(int(i) for i in np.argwhere(bad)[0])
        row, column = (entry + (0, 0))[:2]
        value = float(array[entry])
        text = ", ".join(map(str, entry))
        raise NotFinite(f"{what}[{text}] is {value}", what=what, row=row, column=column, value=value)
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
    array = np.atleast_1d(np.asarray(value))
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
