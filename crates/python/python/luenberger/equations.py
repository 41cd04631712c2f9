"""Matrix equations, placement and Gramians in the conventions of python-control and scipy, each with its evidence."""

from __future__ import annotations

from collections.abc import Iterable
from copy import deepcopy
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _luenberger
from ._arrays import Array, ComplexArray, matrix, poles as pole_list, square
from .errors import InvalidArgument, Unavailable
from .systems import linear

__all__ = ["Placement", "Riccati", "Solution", "care", "dare", "dlyap", "gram", "lyap", "place", "sylv"]


class _WithEvidence(np.ndarray):
    """An array with numbers that speak of it: copies and pickles have them, what is computed from it does not."""

    _evidence: ClassVar[tuple[str, ...]] = ()

    def __getattr__(self, name: str) -> Any:
        if name in self._evidence:
            raise Unavailable(f"`{name}` is known of the array that was returned, and this one was computed from it")
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        array = np.asarray(array)
        return array[()] if return_scalar else array

    def __getitem__(self, key: Any) -> Any:
        return np.asarray(self)[key]

    @property
    def T(self) -> Any:
        """The transpose, an ordinary array."""
        return np.asarray(self).T

    def copy(self, order: Any = "C") -> Any:
        """A copy with the evidence."""
        return _restored(type(self), np.array(self, order=order), self._known())

    def __copy__(self) -> Any:
        return self.copy("K")

    def __deepcopy__(self, memo: Any) -> Any:
        return _restored(type(self), np.array(self), deepcopy(self._known(), memo))

    def __reduce__(self) -> Any:
        return _restored, (type(self), np.asarray(self), self._known())

    def _known(self) -> dict[str, Any]:
        return {name: self.__dict__[name] for name in self._evidence if name in self.__dict__}


class Solution(_WithEvidence):
    """The solution of a matrix equation: an array, with the evidence for it.

    Copies and pickles have the evidence; what is computed from it, `X.T` and slices too, is an ordinary array.

    Attributes
    ----------
    residual : float
        What is left of the equation, relative to its terms.
    forward_error : float
        Bound of the relative error in the Frobenius norm, for the data as given; infinite where no digit is known.
    condition : float
        Relative change of the solution for a relative change of the data.
    separation : float
        Distance of the spectra that makes the equation solvable; NaN where it is not computed.

    Examples
    --------
    >>> import luenberger
    >>> X = luenberger.lyap([[0, 1], [-2, -3]], [[1, 0], [0, 1]])
    >>> X.residual < 1e-15, X.forward_error < 1e-12
    (True, True)
    """

    residual: float
    forward_error: float
    condition: float
    separation: float
    _evidence = ("residual", "forward_error", "condition", "separation")


class Placement(_WithEvidence):
    """The gain of a pole placement: an array, with the evidence for it.

    Copies and pickles have the evidence; what is computed from it, `K.T` and slices too, is an ordinary array.

    Attributes
    ----------
    poles : ndarray
        The eigenvalues of the closed loop with this very gain, in the order of the specified ones.
    errors : ndarray
        The distance of each from the specified one.
    deviation : float
        The largest of them, relative.
    sensitivities : ndarray
        The condition of each eigenvalue.
    condition : float
        The condition of the matrix of eigenvectors.

    Examples
    --------
    >>> import luenberger
    >>> K = luenberger.place([[0, 1], [0, 0]], [[0], [1]], [-1, -2])
    >>> K.deviation < 1e-14
    True
    """

    poles: ComplexArray
    errors: Array
    deviation: float
    sensitivities: Array
    condition: float
    _evidence = ("poles", "errors", "deviation", "sensitivities", "condition")


class Riccati(NamedTuple):
    """The stabilizing solution of a Riccati equation, as python-control returns it.

    Attributes
    ----------
    X : Solution
        The solution, with residual and forward error.
    L : ndarray
        The eigenvalues of the closed loop `A - B G`.
    G : ndarray
        The feedback gain.

    Examples
    --------
    >>> import luenberger
    >>> X, L, G = luenberger.care([[0.0]], [[1.0]], [[4.0]])
    >>> float(X[0, 0]), L.real, float(G[0, 0])
    (2.0, array([-2.]), 2.0)
    """

    X: Solution
    L: ComplexArray
    G: Array


def _restored(kind: Any, array: Array, evidence: dict[str, Any]) -> Any:
    solution = array.view(kind)
    for name, value in evidence.items():
        setattr(solution, name, value)
    return solution


def _solution(found: dict[str, Any]) -> Solution:
    evidence = {name: found.get(name, float("nan")) for name in Solution._evidence}
    solution: Solution = _restored(Solution, found["x"], evidence)
    return solution


def lyap(
    A: npt.ArrayLike, Q: npt.ArrayLike, C: npt.ArrayLike | None = None, E: npt.ArrayLike | None = None
) -> Solution:
    """Solve a Lyapunov or Sylvester equation in continuous time.

    `lyap(A, Q)` solves `A X + X A' + Q = 0`, `lyap(A, Q, C)` the Sylvester equation `A X + X Q + C = 0`, and
    `lyap(A, Q, None, E)` the equation `A X E' + E X A' + Q = 0`.

    Parameters
    ----------
    A : array_like, (n, n)
        Coefficient.
    Q : array_like
        (n, n), symmetric; for a Sylvester equation (m, m), of any kind.
    C : array_like, (n, m), optional
        Right-hand side of a Sylvester equation.
    E : array_like, (n, n), optional
        A regular matrix.

    Returns
    -------
    Solution
        X, an array with `residual`, `forward_error`, `condition` and `separation`.

    Raises
    ------
    SingularEquation
        There is no unique solution: two eigenvalues add to zero.

    Examples
    --------
    >>> import luenberger, numpy as np
    >>> A, Q = np.array([[0., 1.], [-2., -3.]]), np.eye(2)
    >>> X = luenberger.lyap(A, Q)
    >>> np.allclose(A @ X + X @ A.T + Q, 0), X.forward_error < 1e-12
    (True, True)
    """
    A = square("A", A)
    if C is not None:
        if E is not None:
            raise InvalidArgument("lyap takes C or E, not both")
        Q = square("Q", Q)
        return _solution(_luenberger.sylv(A, Q, -matrix("C", C, len(A), len(Q))))
    n = len(A)
    return _solution(_luenberger.lyap(A, matrix("Q", Q, n, n), None if E is None else matrix("E", E, n, n)))


def dlyap(
    A: npt.ArrayLike, Q: npt.ArrayLike, C: npt.ArrayLike | None = None, E: npt.ArrayLike | None = None
) -> Solution:
    """Solve a Lyapunov or Sylvester equation in discrete time.

    `dlyap(A, Q)` solves `A X A' - X + Q = 0`, `dlyap(A, Q, C)` the Sylvester equation `A X Q' - X + C = 0`, and
    `dlyap(A, Q, None, E)` the equation `A X A' - E X E' + Q = 0`.

    Parameters
    ----------
    A, Q, C, E : array_like
        As for `lyap`.

    Returns
    -------
    Solution
        X, with its evidence.

    Examples
    --------
    >>> import luenberger, numpy as np
    >>> X = luenberger.dlyap([[0.5]], [[3.0]])
    >>> float(X[0, 0])
    4.0
    """
    A = square("A", A)
    if C is not None:
        if E is not None:
            raise InvalidArgument("dlyap takes C or E, not both")
        Q = square("Q", Q)
        return _solution(_luenberger.dsylv(A, Q.T, matrix("C", C, len(A), len(Q))))
    n = len(A)
    return _solution(_luenberger.dlyap(A, matrix("Q", Q, n, n), None if E is None else matrix("E", E, n, n)))


def sylv(A: npt.ArrayLike, B: npt.ArrayLike, C: npt.ArrayLike) -> Solution:
    """Solve the Sylvester equation `A X + X B = C`, as `scipy.linalg.solve_sylvester`.

    Other functions have C on the left: `lyap(A, B, Q)` here, in python-control and in MATLAB, and the command
    `luenberger sylv`, solve `A X + X B + Q = 0`. `sylv(A, B, -Q)` is their X.

    Parameters
    ----------
    A : array_like, (n, n)
        Left coefficient.
    B : array_like, (m, m)
        Right coefficient.
    C : array_like, (n, m)
        Right-hand side.

    Returns
    -------
    Solution
        X, with its evidence.

    Examples
    --------
    >>> import luenberger
    >>> float(luenberger.sylv([[1.0]], [[2.0]], [[6.0]])[0, 0])
    2.0
    >>> float(luenberger.lyap([[1.0]], [[2.0]], [[6.0]])[0, 0])
    -2.0
    """
    A, B = square("A", A), square("B", B)
    return _solution(_luenberger.sylv(A, B, matrix("C", C, len(A), len(B))))


def _riccati(
    solve: Any,
    A: npt.ArrayLike,
    B: npt.ArrayLike,
    Q: npt.ArrayLike,
    R: npt.ArrayLike | None,
    S: npt.ArrayLike | None,
    E: npt.ArrayLike | None,
) -> Riccati:
    A = square("A", A)
    n = len(A)
    B = matrix("B", B, rows=n)
    m = B.shape[1]
    Q = matrix("Q", Q, n, n)
    R = np.eye(m) if R is None else matrix("R", R, m, m)
    if S is None and E is None:
        found = solve(A, B, Q, R)
    else:
        S = np.zeros((n, m)) if S is None else matrix("S", S, n, m)
        E = np.eye(n) if E is None else matrix("E", E, n, n)
        found = solve(A, B, Q, R, (S, E))
    return Riccati(_solution(found), found["poles"], found["k"])


def care(
    A: npt.ArrayLike,
    B: npt.ArrayLike,
    Q: npt.ArrayLike,
    R: npt.ArrayLike | None = None,
    S: npt.ArrayLike | None = None,
    E: npt.ArrayLike | None = None,
) -> Riccati:
    """Stabilizing solution of the algebraic Riccati equation in continuous time.

    `A'X E + E'X A - (E'X B + S) R^-1 (B'X E + S') + Q = 0`.

    Parameters
    ----------
    A, Q : array_like, (n, n)
        Dynamics and weight of the state, Q symmetric.
    B : array_like, (n, m)
        Inputs.
    R : array_like, (m, m), optional
        Weight of the input, symmetric and regular, also indefinite as in H-infinity equations (default the
        identity).
    S : array_like, (n, m), optional
        Cross term (default 0).
    E : array_like, (n, n), optional
        A regular matrix (default the identity).

    Returns
    -------
    Riccati
        `X, L, G`: the solution with its evidence, the eigenvalues of the closed loop, the gain.

    Raises
    ------
    NotStabilizable
        An unstable eigenvalue that the inputs do not move.

    Examples
    --------
    >>> import luenberger, numpy as np
    >>> X, L, G = luenberger.care([[0, 1], [0, 0]], [[0], [1]], np.eye(2))
    >>> np.round(G, 6), X.forward_error < 1e-12
    (array([[1.      , 1.732051]]), True)

    The H-infinity filter of an oscillator for gamma = 10, C = [1 0], H = I:

    >>> A, CH = [[0, 1], [-2, -0.3]], [[1, 0], [1, 0], [0, 1]]
    >>> P, L, G = luenberger.care(np.transpose(A), np.transpose(CH), [[0, 0], [0, 1]], np.diag([1, -100, -100]))
    >>> np.round(P, 6)
    array([[0.454431, 0.102169],
           [0.102169, 0.98447 ]])
    """
    return _riccati(_luenberger.care, A, B, Q, R, S, E)


def dare(
    A: npt.ArrayLike,
    B: npt.ArrayLike,
    Q: npt.ArrayLike,
    R: npt.ArrayLike | None = None,
    S: npt.ArrayLike | None = None,
    E: npt.ArrayLike | None = None,
) -> Riccati:
    """Stabilizing solution of the algebraic Riccati equation in discrete time.

    `A'X A - E'X E - (A'X B + S) (B'X B + R)^-1 (B'X A + S') + Q = 0`.

    Parameters
    ----------
    A, B, Q, R, S, E : array_like
        As for `care`.

    Returns
    -------
    Riccati
        `X, L, G`.

    Examples
    --------
    >>> import luenberger
    >>> X, L, G = luenberger.dare([[1.0]], [[1.0]], [[1.0]])
    >>> round(float(X[0, 0]), 12)
    1.61803398875
    """
    return _riccati(_luenberger.dare, A, B, Q, R, S, E)


def place(A: npt.ArrayLike, B: npt.ArrayLike, poles: Iterable[complex] | npt.ArrayLike) -> Placement:
    """Feedback gain K that places the eigenvalues of `A - B K`.

    The gain of an observer is `place(A.T, C.T, poles).T`, or that of `place_observer`.

    Parameters
    ----------
    A : array_like, (n, n)
        Dynamics.
    B : array_like, (n, m)
        Inputs.
    poles : sequence of complex
        n numbers closed under conjugation, each repeated at most rank(B) times.

    Returns
    -------
    Placement
        K, an array with `poles`, `errors`, `deviation`, `sensitivities` and `condition`.

    Raises
    ------
    Uncontrollable
        Names the eigenvalue that no gain moves.
    InvalidPole
        A list of poles that no real gain places.

    Examples
    --------
    >>> import luenberger, numpy as np
    >>> K = luenberger.place([[0, 1], [0, 0]], [[0], [1]], [-1, -2])
    >>> np.allclose(K, [[2, 3]])
    True
    """
    A = square("A", A)
    found = _luenberger.place(A, matrix("B", B, rows=len(A)), pole_list(poles))
    gain: Placement = _restored(Placement, found.pop("x"), found)
    return gain


def gram(sys: Any, type: str) -> Solution:
    """Gramian of a stable plant.

    Parameters
    ----------
    sys : StateSpace
        A plant of any of the accepted types.
    type : {'c', 'o'}
        The controllability or the observability Gramian.

    Returns
    -------
    Solution
        The Gramian, with its evidence.

    Raises
    ------
    NotStable
        The plant is not stable: the Gramian does not exist.

    Examples
    --------
    >>> import luenberger
    >>> float(luenberger.gram(([[-1.0]], [[2.0]], [[1.0]]), 'c')[0, 0])
    2.0
    """
    from .errors import NotStable

    plant = linear(sys)
    if type not in ("c", "o"):
        raise InvalidArgument(f"type is {type!r}", hint="'c' or 'o'")
    eigenvalues = np.linalg.eigvals(plant.A)
    worst = eigenvalues[np.argmax(eigenvalues.real if plant.dt is None else np.abs(eigenvalues))]
    if (worst.real >= 0.0) if plant.dt is None else (abs(worst) >= 1.0):
        raise NotStable(f"the plant is not stable: eigenvalue {worst:g}", eigenvalue=complex(worst))
    A, Q = (plant.A, plant.B @ plant.B.T) if type == "c" else (plant.A.T, plant.C.T @ plant.C)
    return lyap(A, Q) if plant.dt is None else dlyap(A, Q)
