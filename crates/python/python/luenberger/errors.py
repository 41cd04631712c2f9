"""Exceptions, with the numbers that explain them as attributes.

Every exception is a `LuenbergerError`. Those of matrix computations are `numpy.linalg.LinAlgError` as well, and those
of arguments are `ValueError` or `TypeError`, so that code written for scipy catches them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = [
    "Cancelled",
    "DesignError",
    "DimensionMismatch",
    "ExportRefused",
    "Infeasible",
    "InvalidArgument",
    "InvalidPole",
    "LinAlgError",
    "LuenbergerError",
    "NotApplicable",
    "NotConverged",
    "NotDetectable",
    "NotFinite",
    "NotPositiveDefinite",
    "NotProved",
    "NotStabilizable",
    "NotStable",
    "NotSymmetric",
    "Rejected",
    "SimulationError",
    "SingularEquation",
    "StudyError",
    "StudyFileError",
    "Unavailable",
    "Uncontrollable",
    "Undecided",
    "Unobservable",
    "WrongDtype",
]


class LuenbergerError(Exception):
    """Base of all exceptions of this package.

    Parameters
    ----------
    message : str
        What is wrong, in a sentence.
    **numbers
        What explains it; each becomes an attribute.

    Examples
    --------
    >>> import luenberger
    >>> error = luenberger.NotDetectable("the pair (A, C) is not detectable", eigenvalue=2.0, margin=0.0)
    >>> error.eigenvalue, error.margin
    (2.0, 0.0)
    """

    def __init__(self, message: str = "", **numbers: Any) -> None:
        super().__init__(message)
        self.__dict__.update(numbers)


class InvalidArgument(LuenbergerError, ValueError):
    """An argument has a value that is not allowed; `hint` may say what is."""

    hint: str | None = None

    def __init__(self, message: str = "", **numbers: Any) -> None:
        hint = numbers.get("hint")
        super().__init__(f"{message}; expected {hint}" if hint else message, **numbers)


class DimensionMismatch(InvalidArgument):
    """An array does not have the shape that the other arguments ask for."""

    what: str
    expected: tuple[int, ...]
    found: tuple[int, ...]


class NotFinite(InvalidArgument):
    """An entry of an array is NaN or infinite."""

    what: str
    row: int
    column: int
    value: float


class WrongDtype(LuenbergerError, TypeError):
    """An array is not one of real numbers, or an argument is not of a type that is taken; `dtype` is what it is."""

    what: str
    dtype: str


class LinAlgError(LuenbergerError, np.linalg.LinAlgError):
    """A matrix computation has no answer."""


class NotSymmetric(LinAlgError):
    """A matrix that has to be symmetric is not."""

    what: str
    row: int
    column: int
    asymmetry: float
    allowed: float


class NotPositiveDefinite(LinAlgError):
    """A matrix that has to be positive (semi)definite is not."""

    what: str
    lambda_min: float


class SingularEquation(LinAlgError):
    """A matrix equation has no unique solution, or rounding decides it: `decided` says which."""

    equation: str
    first: complex
    second: complex
    gap: float
    decided: bool
    condition: float


class NotConverged(LinAlgError):
    """An iteration reached its limit."""

    method: str
    iterations: int
    remaining: float
    allowed: float


class NotStable(LinAlgError):
    """An eigenvalue that has to be stable is not."""

    eigenvalue: complex


class NotDetectable(LinAlgError):
    """An eigenvalue that does not decay is not seen by the outputs, exactly or to working precision, as the text says."""

    eigenvalue: complex
    margin: float


class NotStabilizable(LinAlgError):
    """An eigenvalue that does not decay is not moved by the inputs."""

    eigenvalue: complex
    margin: float


class Unobservable(LinAlgError):
    """A mode that no output sees, where all have to be seen."""

    eigenvalue: complex
    margin: float
    direction: npt.NDArray[np.complex128]


class Uncontrollable(LinAlgError):
    """A mode that no input moves, where all have to be moved."""

    eigenvalue: complex
    margin: float
    direction: npt.NDArray[np.complex128]


class InvalidPole(LinAlgError):
    """A list of poles that no real gain places, or for which an observer would not converge."""

    pole: complex
    expected: int
    found: int


class DesignError(LuenbergerError):
    """An observer has no design.

    `alternatives` lists observers that have one on this plant, `hints` what may help besides.
    """

    alternatives: tuple[str, ...] = ()
    hints: tuple[str, ...] = ()


class NotApplicable(DesignError):
    """The plant violates a hypothesis of the observer."""


class Unavailable(NotApplicable, AttributeError):
    """A property of an observer has no value: its kind has none, or it was not stepped yet; `hasattr` is False."""


class Infeasible(DesignError):
    """The matrix inequality of a design has no solution, which is proved."""


class Undecided(DesignError):
    """Neither a solution of a matrix inequality nor a proof that there is none was found."""

    best: float


class NotProved(LuenbergerError):
    """A certificate has an inequality that is not proved."""


class Rejected(LuenbergerError):
    """A certificate file does not prove what it says."""


class ExportRefused(LuenbergerError):
    """An observer cannot be exported. `alternatives` lists what is possible instead."""

    alternatives: tuple[str, ...] = ()


class SimulationError(LuenbergerError):
    """A simulation ended early."""


class StudyError(LuenbergerError):
    """A study could not be executed."""


class StudyFileError(StudyError, ValueError):
    """A study file has mistakes; each item of `diagnostics` has file, line, column, message, expected and help."""

    diagnostics: list[dict[str, Any]]


class Cancelled(StudyError):
    """A computation was ended before it had finished."""
