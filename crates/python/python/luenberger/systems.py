"""Linear plants: this package's, python-control's and scipy's."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from ._arrays import Array, frozen, matrix, number, real, square
from .errors import DimensionMismatch, InvalidArgument, WrongDtype

__all__ = ["StateSpace", "ss"]

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")


@runtime_checkable
class HasMatrices(Protocol):
    """A linear system of another package."""

    A: Any
    B: Any
    C: Any
    D: Any


class StateSpace:
    """A linear plant, `x' = A x + B u` or `x[k+1] = A x[k] + B u[k]`, with `y = C x + D u`.

    Made by `ss`. Every function that takes a plant takes python-control's and scipy's `StateSpace` and tuples
    `(A, B, C[, D][, dt])` as well.

    Attributes
    ----------
    A, B, C, D : ndarray
        The matrices, copies that are read-only: what is proved is proved of these numbers.
    dt : float or None
        The sampling period; None in continuous time.
    states, inputs, outputs : list of str
        Names.

    Examples
    --------
    >>> import luenberger
    >>> sys = luenberger.ss([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
    >>> sys.nstates, sys.ninputs, sys.noutputs, sys.dt
    (2, 1, 1, None)
    """

    A: Array
    B: Array
    C: Array
    D: Array
    dt: float | None
    states: list[str]
    inputs: list[str]
    outputs: list[str]

    def __init__(
        self,
        A: npt.ArrayLike,
        B: npt.ArrayLike | None,
        C: npt.ArrayLike,
        D: npt.ArrayLike | None = None,
        dt: float | bool | None = None,
        *,
        states: Sequence[str] | None = None,
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
    ) -> None:
        self.A = frozen(square("A", A))
        n = self.A.shape[0]
        if n == 0:
            raise DimensionMismatch(
                "A is empty: a plant has at least one state", what="A", expected=(1, 1), found=(0, 0)
            )
        self.B = frozen(np.zeros((n, 0)) if B is None else matrix("B", B, rows=n))
        self.C = frozen(matrix("C", C, columns=n, vector="row"))
        p, m = self.C.shape[0], self.B.shape[1]
        zero = D is None or (np.ndim(D) == 0 and np.all(np.asarray(D) == 0)) or np.size(D) == 0
        vector = "column" if m == 1 else "row"
        self.D = frozen(np.zeros((p, m)) if zero or D is None else matrix("D", D, p, m, vector=vector))
        self.dt = period(dt)
        self.states = _names("states", states, n, "x")
        self.inputs = _names("inputs", inputs, m, "u")
        self.outputs = _names("outputs", outputs, p, "y")

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for value in state.values():  # neither a pickle nor a deep copy keeps this
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def nstates(self) -> int:
        """Number of states."""
        return int(self.A.shape[0])

    @property
    def ninputs(self) -> int:
        """Number of inputs."""
        return int(self.B.shape[1])

    @property
    def noutputs(self) -> int:
        """Number of outputs."""
        return int(self.C.shape[0])

    def __repr__(self) -> str:
        time = "continuous time" if self.dt is None else f"dt = {self.dt:g}"
        return f"<StateSpace: {self.nstates} states, {self.ninputs} inputs, {self.noutputs} outputs, {time}>"

    def _plant(self) -> dict[str, Any]:
        """The table `plant` of a study."""
        table: dict[str, Any] = {"a": self.A.tolist(), "c": self.C.tolist()}
        if self.ninputs:
            table["b"] = self.B.tolist()
            table["inputs"] = self.inputs
        if np.any(self.D):
            table["d"] = self.D.tolist()
        if self.dt is not None:
            table["dt"] = self.dt
        table["states"], table["outputs"] = self.states, self.outputs
        return table

    def _tables(self) -> dict[str, Any]:
        """Other tables of a study that belong to the plant."""
        return {}


def period(dt: Any) -> float | None:
    """The sampling period; None in continuous time. `dt=True`, a period left open, counts samples: 1."""
    if dt is None:
        return None
    if isinstance(dt, (bool, np.bool_)):
        return 1.0 if dt else None
    given = real("dt", dt)
    return None if given.size == 1 and not given.any() else number("dt", dt, positive=True)


def _names(what: str, names: Sequence[str] | None, count: int, letter: str) -> list[str]:
    default = [f"{letter}{i + 1}" for i in range(count)]
    if names is None:
        return default
    given = [str(name) for name in names]
    if len(given) != count:
        raise DimensionMismatch(
            f"{what} must have {count} names, and has {len(given)}", what=what, expected=(count,), found=(len(given),)
        )
    for name in given:
        if not _NAME.match(name):
            raise InvalidArgument(f"{what}: {name!r} is not a name", hint="letters, digits and underscores")
    return given


def ss(
    A: npt.ArrayLike,
    B: npt.ArrayLike | None,
    C: npt.ArrayLike,
    D: npt.ArrayLike | None = None,
    dt: float | bool | None = None,
    *,
    states: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
) -> StateSpace:
    """A linear plant from its matrices.

    Parameters
    ----------
    A : array_like, (n, n)
        Dynamics.
    B : array_like, (n, m), or None
        Inputs; None for a plant without inputs.
    C : array_like, (p, n)
        Outputs.
    D : array_like, (p, m), optional
        Feedthrough (default 0).
    dt : float, optional
        Sampling period of a plant in discrete time. None and 0 mean continuous time; True means discrete time of
        which the period is not specified, and 1 is used.
    states, inputs, outputs : sequence of str, optional
        Names (default x1, x2, ..; u1, ..; y1, ..).

    Returns
    -------
    StateSpace

    Examples
    --------
    >>> import luenberger
    >>> luenberger.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], dt=0.1)
    <StateSpace: 2 states, 1 inputs, 1 outputs, dt = 0.1>
    """
    return StateSpace(A, B, C, D, dt, states=states, inputs=inputs, outputs=outputs)


def linear(sys: Any) -> StateSpace:
    """The plant `sys` of any of the accepted types."""
    if isinstance(sys, StateSpace):
        return sys
    if isinstance(sys, (tuple, list)):
        if not 3 <= len(sys) <= 5:
            raise InvalidArgument(f"a plant is (A, B, C[, D][, dt]), and this one has {len(sys)} parts")
        return StateSpace(*sys)
    if not isinstance(sys, HasMatrices) and hasattr(sys, "to_ss"):
        try:
            sys = sys.to_ss()
        except ValueError as error:  # an improper transfer function
            raise InvalidArgument(f"{type(sys).__name__} has no matrices: {error}") from error
    if isinstance(sys, HasMatrices):
        return StateSpace(sys.A, sys.B, sys.C, sys.D, getattr(sys, "dt", None), **_labels(sys))
    kind = type(sys).__name__
    raise WrongDtype(
        f"{kind} is not a linear plant; luenberger.ss(A, B, C), a system of python-control or scipy, or a tuple "
        "(A, B, C[, D][, dt]) is",
        what="sys",
        dtype=kind,
    )


def _labels(sys: Any) -> dict[str, list[str] | None]:
    """The names of a python-control system, where they can be names in expressions."""
    labels = {key: list(getattr(sys, f"{key[:-1]}_labels", None) or []) for key in ("states", "inputs", "outputs")}
    every = [name for names in labels.values() for name in names]
    usable = len(set(every)) == len(every) and all(isinstance(name, str) and _NAME.match(name) for name in every)
    return {key: names if usable and names else None for key, names in labels.items()}
