"""Observability of linear plants, with margins and directions."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from . import _html, _luenberger
from ._arrays import Array, ComplexArray
from .systems import StateSpace, linear

__all__ = ["Mode", "Observability", "observability"]


@dataclass(frozen=True)
class Mode:
    """An eigenvalue of the plant and how well the outputs see it.

    Attributes
    ----------
    eigenvalue : complex
        The eigenvalue.
    margin : float
        Smallest singular value of `[A - lambda I; C]` relative to `[A; C]`: 0 for a hidden mode.
    direction : ndarray
        The direction that is seen least, a unit vector.

    Examples
    --------
    >>> import luenberger
    >>> (mode,) = luenberger.observability(([[-1.0]], None, [[2.0]])).modes
    >>> mode.eigenvalue, mode.margin > 0.5
    ((-1+0j), True)
    """

    eigenvalue: complex
    margin: float
    direction: ComplexArray = field(repr=False)


@dataclass(frozen=True)
class Observability:
    """What the outputs see of the state.

    Attributes
    ----------
    order, rank : int
        Number of states, and of those that the outputs see.
    modes : list of Mode
        Every eigenvalue with its margin and direction.
    unobservable : list of Mode
        The modes that are hidden to working precision.
    undetectable_modes : list of Mode
        The hidden modes that do not decay, to working precision.
    subspace : ndarray, (n, n - rank)
        Orthonormal basis of the unobservable subspace.
    tolerance : float
        Relative tolerance of the rank decisions.

    Examples
    --------
    >>> import luenberger
    >>> seen = luenberger.observability(([[0, 1], [0, 0]], None, [[1, 0]]))
    >>> seen.is_observable, 0 < seen.margin < 1, seen.distance[0] <= seen.distance[1]
    (True, True, True)
    """

    order: int
    rank: int
    modes: list[Mode]
    unobservable: list[Mode]
    undetectable_modes: list[Mode]
    subspace: Array = field(repr=False)
    tolerance: float
    plant: StateSpace = field(repr=False)

    @property
    def is_observable(self) -> bool:
        """Whether the outputs see every state."""
        return self.rank == self.order

    @property
    def is_detectable(self) -> bool:
        """Whether every hidden mode decays, to working precision."""
        return not self.undetectable_modes

    @property
    def margin(self) -> float:
        """The smallest margin of a mode."""
        return min(mode.margin for mode in [*self.modes, *self.unobservable])

    @cached_property
    def distance(self) -> tuple[float, float]:
        """Lower and upper bound of the 2-norm of the smallest change of (A, C) that hides a mode."""
        found = _luenberger.unobservability_distance(self.plant.A, self.plant.C)
        return found["lower"], found["upper"]

    def _repr_html_(self) -> str:
        names = self.plant.states
        rows = [
            [_html.number(mode.eigenvalue), _html.number(mode.margin), _html.direction(mode.direction, names)]
            for mode in [*self.unobservable, *self.modes]
        ]
        verdict = "observable" if self.is_observable else "detectable" if self.is_detectable else "not detectable"
        caption = f"{verdict} to working precision: rank {self.rank} of {self.order}"
        return _html.table(caption, ["eigenvalue", "margin", "least visible direction"], rows)


def observability(sys: Any, tolerance: float | None = None) -> Observability:
    """Observability of a linear plant: rank, margins and directions.

    Parameters
    ----------
    sys : StateSpace
        A plant of any of the accepted types.
    tolerance : float, optional
        Relative size below which a quantity counts as zero (default 10 max(n, p) eps).

    Returns
    -------
    Observability

    Examples
    --------
    Two masses on springs; the difference of their positions is measured, and their common motion is hidden.

    >>> import luenberger
    >>> A = [[0, 0, 1, 0], [0, 0, 0, 1], [-2, 1, 0, 0], [1, -2, 0, 0]]
    >>> seen = luenberger.observability((A, None, [[1, -1, 0, 0]]))
    >>> seen.rank, seen.order, seen.is_detectable
    (2, 4, False)
    >>> [round(abs(mode.eigenvalue), 12) for mode in seen.unobservable]
    [1.0, 1.0]
    """
    plant = linear(sys)
    found = _luenberger.observability(plant.A, plant.C, plant.dt is not None, tolerance)
    modes = {key: [Mode(**mode) for mode in found[key]] for key in ("modes", "unobservable", "undetectable_modes")}
    return Observability(
        order=found["order"],
        rank=found["rank"],
        subspace=found["subspace"],
        tolerance=found["tolerance"],
        plant=plant,
        **modes,
    )
