"""Trajectories of a plant and its observer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import _html
from ._arrays import Array
from .errors import InvalidArgument

__all__ = ["LogWarning", "Trajectory"]


class LogWarning(UserWarning):
    """What the report of a study warns of on a log, such as rows that are not used; also in `Trajectory.warnings`."""


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
        The estimates; None for a plant alone. Of an observer of functions z = K x they are those of z.
    estimated : list of str
        Names of the rows of `xhat`: the states, or the functions.
    functions : ndarray or None
        The functions K x of the states, of an observer of functions.
    deviation : ndarray or None, (n, T)
        The standard deviations of the estimates, of a Kalman filter with a covariance.
    lower, upper : ndarray or None, (n, T)
        Bounds of the states, of an interval observer.
    dhat : ndarray or None, (q, T)
        The estimates of disturbances, of an observer that has some; `disturbances` has their names.
    probability : ndarray or None, (r, T)
        The probabilities of the models, of a filter that has several; `models` has their names.
    smoothed, smoothed_deviation : ndarray or None, (n, T)
        The estimates with the whole log, and their standard deviations, of `Observer.replay` with `smooth`.
    observer : str
        The name of the observer.
    states, inputs, outputs : list of str
        Names.
    warnings : list of str
        What limits the use of a log: rows that lie on no sample of the observer, values that the logger repeats, gaps,
        and what else the report of a study warns of; and that a run left the region of the design.
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
    estimated: list[str] = field(default_factory=list)
    functions: Array | None = None
    lower: Array | None = None
    upper: Array | None = None
    dhat: Array | None = None
    disturbances: list[str] = field(default_factory=list)
    probability: Array | None = None
    models: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    @property
    def _truth(self) -> Array:
        """What is estimated, as far as it is known."""
        return self.x if self.functions is None else self.functions

    @property
    def error(self) -> Array:
        """The estimation error, x - xhat, of angles within half a turn; of an observer of functions K x - zhat."""
        if self.xhat is None:
            return np.full_like(self.x, np.nan)
        if self.functions is not None:
            return self.functions - self.xhat
        error: Array = self.x - self.xhat
        for i, turn in enumerate(self.turns or []):
            if turn > 0:
                error[i] += turn * np.floor(0.5 - error[i] / turn)
        return error

    def to_dict(self) -> dict[str, Array]:
        """Columns by name, as `pandas.DataFrame` takes them and the tables of a study have them.

        t, states, `x_hat`, `x_2sigma` (two standard deviations), `x_lower` and `x_upper`, `x_smoothed`,
        `x_smoothed_2sigma`, functions `z1` and `z1_hat`, disturbances `d1_hat`, models `NAME_probability`, inputs and
        outputs; as far as the observer has them.
        """
        columns: dict[str, Array] = {"t": self.t}

        def add(names: Sequence[str], suffix: str, rows: Array | None, factor: float = 1.0) -> None:
            for name, row in zip(names, () if rows is None else rows):
                title = f"{name}{suffix}"
                while title in columns:
                    title += "'"
                columns[title] = row if factor == 1.0 else factor * row

        add(self.states, "", self.x)
        if self.functions is None:
            add(self.states, "_hat", self.xhat)
        add(self.states, "_2sigma", self.deviation, 2.0)
        add(self.states, "_lower", self.lower)
        add(self.states, "_upper", self.upper)
        add(self.states, "_smoothed", self.smoothed)
        add(self.states, "_smoothed_2sigma", self.smoothed_deviation, 2.0)
        if self.functions is not None:
            add(self.estimated, "", self.functions)
            add(self.estimated, "_hat", self.xhat)
        add(self.disturbances, "_hat", self.dhat)
        add(self.models, "_probability", self.probability)
        add(self.inputs, "", self.u)
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

        Of an observer of functions these are drawn.

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
        estimated = self.estimated or self.states
        known = {**dict(zip(self.states, self.x)), **dict(zip(estimated, self._truth))}
        estimates = {} if self.xhat is None else dict(zip(estimated, self.xhat))
        names = list(estimated if states is None else states)
        for name in names:
            if name not in known:
                raise InvalidArgument(f"there is no {name!r} to draw", hint=f"some of {', '.join(known)}")
        if axes is None:
            from matplotlib import pyplot

            _, axes = pyplot.subplots(len(names), 1, sharex=True, squeeze=False)
        axes = np.asarray(axes).ravel()
        for axis, name in zip(axes, names):
            axis.plot(self.t, known[name], label=name)
            if name in estimates:
                axis.plot(self.t, estimates[name], "--", label=f"estimate, {self.observer}")
            axis.set_ylabel(name)
            axis.legend()
        axes[-1].set_xlabel("t")
        return axes

    def _repr_html_(self) -> str:
        error = self.error
        last = error[:, -1] if self.t.size else np.full(len(error), np.nan)
        rows = [
            [name, _html.number(float(np.nanmax(np.abs(row), initial=0.0))), _html.number(float(end))]
            for name, row, end in zip(self.estimated or self.states, error, last)
        ]
        caption = f"{self.observer}: {self.t.size} times"
        head = "state" if self.functions is None else "function"
        table = _html.table(caption, [head, "largest |error|", "last error"], rows)
        return table + "".join(_html.paragraph(text) for text in self.warnings)


def trajectory(
    found: dict[str, Any], states: list[str], inputs: list[str], outputs: list[str], turns: list[float] | None
) -> Trajectory:
    """The trajectory that the extension module returns."""
    t, x, xhat, half = found["t"], found["x"], found["xhat"], found["half_width"]
    names, functions = found["functions"] or (states, None)
    disturbances, dhat = found["disturbances"] or ([], None)
    models, probability = found["models"] or ([], None)
    return Trajectory(
        t=t,
        x=x if x.shape[0] else np.full((len(states), t.size), np.nan),
        u=found["u"],
        y=found["y"],
        xhat=xhat,
        deviation=found["deviation"],
        observer=found["observer"],
        states=states,
        inputs=inputs,
        outputs=outputs,
        turns=turns,
        smoothed=found["smoothed"],
        smoothed_deviation=found["smoothed_deviation"],
        estimated=list(names),
        functions=functions,
        lower=None if half is None else xhat - half,
        upper=None if half is None else xhat + half,
        dhat=dhat,
        disturbances=disturbances,
        probability=probability,
        models=models,
        warnings=found["warnings"],
    )
