"""Trajectories of a plant and its observer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _html
from ._arrays import Array

__all__ = ["Trajectory"]


@dataclass(frozen=True, repr=False)
class Trajectory:
    """A run: one column for each time, as python-control has it.

    Attributes
    ----------
    t : ndarray, (T,)
        The times.
    x, u, y : ndarray, (n, T), (m, T), (p, T)
        States, inputs and measured outputs. What is not known is NaN; without known states x is NaN.
    xhat : ndarray or None, (n, T)
        The estimates; None for a plant alone.
    deviation : ndarray or None, (n, T)
        The standard deviations of the estimates, of a Kalman filter with a covariance.
    smoothed, smoothed_deviation : ndarray or None, (n, T)
        The estimates with the whole log, and their standard deviations, of `Observer.replay` with `smooth`.
    observer : str
        The name of the observer.
    states, inputs, outputs : list of str
        Names.
    turns : list of float or None
        The full turn of each state that is an angle, in its unit, and 0 of the others; None without angles.

    Examples
    --------
    >>> import luenberger
    >>> observer = luenberger.place_observer(([[0, 1], [0, 0]], None, [[1, 0]]), [-2, -5])
    >>> run = observer.simulate(x0=[1, -1], duration=10)
    >>> run.x.shape, bool(abs(run.error[:, -1]).max() < 1e-6)
    ((2, 501), True)
    """

    t: Array
    x: Array
    u: Array
    y: Array
    xhat: Array | None
    deviation: Array | None
    observer: str
    states: list[str]
    inputs: list[str]
    outputs: list[str]
    turns: list[float] | None = None
    smoothed: Array | None = None
    smoothed_deviation: Array | None = None

    @property
    def error(self) -> Array:
        """The estimation error, x - xhat, of angles within half a turn."""
        if self.xhat is None:
            return np.full_like(self.x, np.nan)
        error: Array = self.x - self.xhat
        for i, turn in enumerate(self.turns or []):
            if turn > 0:
                error[i] += turn * np.floor(0.5 - error[i] / turn)
        return error

    def to_dict(self) -> dict[str, Array]:
        """Columns by name, as `pandas.DataFrame` takes them: t, states, `x_hat`, `x_smoothed`, inputs, outputs."""
        columns: dict[str, Array] = {"t": self.t}
        columns.update(zip(self.states, self.x))
        if self.xhat is not None:
            columns.update(zip((f"{name}_hat" for name in self.states), self.xhat))
        if self.smoothed is not None:
            columns.update(zip((f"{name}_smoothed" for name in self.states), self.smoothed))
        columns.update(zip(self.inputs, self.u))
        for name, row in zip(self.outputs, self.y):
            columns[name if name not in columns else f"{name}_measured"] = row
        return columns

    def to_frame(self) -> Any:
        """The same as a `pandas.DataFrame` (needs pandas)."""
        import pandas

        return pandas.DataFrame(self.to_dict())

    def __repr__(self) -> str:
        span = f"t = {self.t[0]:g} .. {self.t[-1]:g}, " if self.t.size else ""
        return f"<Trajectory of {self.observer!r}: {span}{self.t.size} times, states {', '.join(self.states)}>"

    def plot(self, states: Sequence[str] | None = None, axes: Any = None) -> Any:
        """Draw the states with their estimates, one pair of axes for each (needs matplotlib).

        Parameters
        ----------
        states : sequence of str, optional
            Only these.
        axes : sequence of matplotlib axes, optional
            Where to draw (default: a new figure).

        Returns
        -------
        ndarray of matplotlib axes
        """
        names = list(self.states if states is None else states)
        if axes is None:
            from matplotlib import pyplot

            _, axes = pyplot.subplots(len(names), 1, sharex=True, squeeze=False)
        axes = np.asarray(axes).ravel()
        for axis, name in zip(axes, names):
            i = self.states.index(name)
            axis.plot(self.t, self.x[i], label=name)
            if self.xhat is not None:
                axis.plot(self.t, self.xhat[i], "--", label=f"estimate, {self.observer}")
            axis.set_ylabel(name)
            axis.legend()
        axes[-1].set_xlabel("t")
        return axes

    def _repr_html_(self) -> str:
        last = self.error[:, -1] if self.t.size else np.full(len(self.states), np.nan)
        rows = [
            [name, _html.number(float(np.nanmax(np.abs(row), initial=0.0))), _html.number(float(end))]
            for name, row, end in zip(self.states, self.error, last)
        ]
        caption = f"{self.observer}: {self.t.size} times"
        return _html.table(caption, ["state", "largest |error|", "last error"], rows)


def trajectory(
    found: dict[str, Any], states: list[str], inputs: list[str], outputs: list[str], turns: list[float] | None
) -> Trajectory:
    """The trajectory that the extension module returns."""
    t, x = found["t"], found["x"]
    return Trajectory(
        t=t,
        x=x if x.shape[0] else np.full((len(states), t.size), np.nan),
        u=found["u"],
        y=found["y"],
        xhat=found["xhat"],
        deviation=found["deviation"],
        observer=found["observer"],
        states=states,
        inputs=inputs,
        outputs=outputs,
        turns=turns,
        smoothed=found["smoothed"],
        smoothed_deviation=found["smoothed_deviation"],
    )
