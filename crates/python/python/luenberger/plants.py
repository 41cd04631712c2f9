"""Nonlinear plants from expressions and functions."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy.typing as npt

from . import _luenberger
from ._arrays import Array, count, frozen, number, real, vector
from ._expressions import name_of, texts, traced
from .errors import DimensionMismatch, InvalidArgument
from .systems import StateSpace, linear, period

__all__ = ["OperatingPoint", "Plant", "plant"]

Region = Mapping[str, Sequence[float]] | Sequence[Sequence[float]]


def as_json(table: Any) -> str:
    """A study as text; infinite bounds are written as the reader of studies takes them."""

    def plain(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {str(key): plain(item) for key, item in value.items()}
        if isinstance(value, (list, tuple)):
            return [plain(item) for item in value]
        if isinstance(value, float) and value in (float("inf"), float("-inf")):
            return "inf" if value > 0 else "-inf"
        return value

    try:
        return json.dumps(plain(table), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InvalidArgument(f"an argument is neither a number nor a text, a list or a dictionary: {error}") from None


def _checked(table: dict[str, Any]) -> dict[str, Any]:
    """The names of a plant that can be read; a mistake with the row that it is in."""
    try:
        found: dict[str, Any] = _luenberger.check(as_json({"plant": table}))
        return found
    except InvalidArgument as error:
        said = [f"{key}: {row}" for key in ("f", "h") for row in _mistakes(table, key)]
        if not said or _mistakes({**table, "f": ["0"] * len(table["f"]), "h": ["0"]}, "h"):
            raise  # not of a row
        raise InvalidArgument("\n".join(dict.fromkeys(said))) from error


def _mistakes(table: dict[str, Any], key: str) -> list[str]:
    """What is wrong with each row of f or h where the others are 0."""
    said = []
    names = table.get({"f": "states", "h": "outputs"}[key]) or []
    zeros = {"f": ["0"] * len(table["f"]), "h": ["0"] * len(table["h"])}
    for i, row in enumerate(table[key]):
        alone = {**table, **zeros, key: [row if k == i else "0" for k in range(len(table[key]))]}
        try:
            _luenberger.check(as_json({"plant": alone}))
        except InvalidArgument as error:
            of = f"row {i + 1}" + (f" ({names[i]})" if i < len(names) else "")
            said.append(f"{of}: {error}")
    return said


class Plant:
    """A plant `x' = f(t, x, u)` or `x[k+1] = f(t, x[k], u[k])`, `y = h(t, x, u)`, from expressions.

    Made by `plant`.

    Attributes
    ----------
    f, h : list of str
        The equations.
    states, inputs, outputs : list of str
        Names.
    dt : float or None
        The sampling period; None in continuous time.
    region : dict or list or None
        Where designs have to hold, if they are not given another region.

    Examples
    --------
    >>> import luenberger
    >>> pendulum = luenberger.plant(f=["w", "-sin(a) - 0.1*w + u"], h=["a"], states=["a", "w"], inputs=["u"])
    >>> pendulum.nstates, pendulum.noutputs
    (2, 1)
    """

    def __init__(self, table: dict[str, Any], region: Region | None) -> None:
        found = _checked(table)
        self._table = table
        self.f: list[str] = list(table["f"])
        self.h: list[str] = list(table["h"])
        self.states: list[str] = found["states"]
        self.inputs: list[str] = found["inputs"]
        self.outputs: list[str] = found["outputs"]
        self.dt: float | None = table.get("dt")
        self.region = deepcopy(region)
        if region is not None:
            bounds(self, region)

    @property
    def nstates(self) -> int:
        """Number of states."""
        return len(self.states)

    @property
    def ninputs(self) -> int:
        """Number of inputs."""
        return len(self.inputs)

    @property
    def noutputs(self) -> int:
        """Number of outputs."""
        return len(self.outputs)

    def _plant(self) -> dict[str, Any]:
        return self._table

    def _tables(self) -> dict[str, Any]:
        return {}

    def at(self, x: npt.ArrayLike | None = None, u: npt.ArrayLike | None = None) -> OperatingPoint:
        """The equilibrium near a guess, with the linearisation there.

        Parameters
        ----------
        x : array_like, (n,), optional
            Guess of the state (default 0), from which Newton's method starts.
        u : array_like, (m,), optional
            The constant input (default 0).

        Returns
        -------
        OperatingPoint
            A plant for `place_observer`, `lqe`, `cubic_observer`, `observability` and all that takes a linear one. Its
            observers run on the nonlinear plant, in deviations from the point.

        Raises
        ------
        InvalidArgument
            There is no equilibrium near the guess.
        """
        return OperatingPoint(self, x, u)

    def __repr__(self) -> str:
        mark = "'" if self.dt is None else "+"
        rows = [f"{name}{mark} = {row}" for name, row in zip(self.states, self.f)]
        rows += [f"{name} = {row}" for name, row in zip(self.outputs, self.h)]
        return f"<Plant: {'; '.join(rows)}>"


class OperatingPoint(StateSpace):
    """An equilibrium of a nonlinear plant, with the linearisation there.

    Made by `Plant.at`.

    Attributes
    ----------
    x, u, y : ndarray
        State, input and output at rest.
    residual : float
        The largest `|f(x, u)|` that is left.
    A, B, C, D : ndarray
        The linearisation: the plant of the deviations.
    nonlinear : Plant
        The plant.

    Examples
    --------
    >>> import luenberger
    >>> pendulum = luenberger.plant(["w", "sin(a) - 0.1*w + u"], ["a"], states=["a", "w"], inputs=["u"])
    >>> upright = pendulum.at([0.1, 0])
    >>> upright.x.round(12).tolist(), upright.A.round(12).tolist()
    ([0.0, 0.0], [[0.0, 1.0], [1.0, -0.1]])
    >>> observer = luenberger.place_observer(upright, [-3, -4])
    >>> run = observer.simulate([0.1, 0], 3, u=0.0)
    """

    def __init__(self, nonlinear: Plant, x: npt.ArrayLike | None, u: npt.ArrayLike | None) -> None:
        self._guess: dict[str, Any] = {}
        if x is not None:
            self._guess["x"] = vector("x", x, nonlinear.nstates).tolist()
        if u is not None and nonlinear.ninputs:
            self._guess["u"] = vector("u", u, nonlinear.ninputs).tolist()
        self.nonlinear = nonlinear
        point = _luenberger.check(as_json({"plant": nonlinear._plant(), **self._tables()}))["at"]
        self.x: Array = frozen(point["x"])
        self.u: Array = frozen(point["u"])
        self.y: Array = frozen(point["y"])
        self.residual: float = point["residual"]
        super().__init__(
            point["A"],
            point["B"],
            point["C"],
            point["D"],
            states=nonlinear.states,
            inputs=nonlinear.inputs,
            outputs=nonlinear.outputs,
        )

    def _plant(self) -> dict[str, Any]:
        return self.nonlinear._plant()

    def _tables(self) -> dict[str, Any]:
        return {"operating_point": self._guess}

    def __repr__(self) -> str:
        return f"<OperatingPoint: x = {self.x.tolist()}, u = {self.u.tolist()} of {self.nonlinear!r}>"


def plant(
    f: Sequence[Any] | Callable[..., Any],
    h: Sequence[Any] | Callable[..., Any],
    states: Sequence[Any] | int | None = None,
    inputs: Sequence[Any] | int | None = None,
    outputs: Sequence[Any] | None = None,
    parameters: Mapping[str, float | str] | None = None,
    region: Region | None = None,
    dt: float | None = None,
    tables: Mapping[str, Any] | None = None,
    units: Sequence[str] | Mapping[str, str] | None = None,
    time_unit: str | None = None,
    angles: Sequence[str] | None = None,
) -> Plant:
    """A nonlinear plant from its equations.

    Parameters
    ----------
    f : sequence of str, or function
        The right-hand sides, one for each state; with `dt` the next states. Texts, expressions of sympy, or a function
        f(x), f(x, u), f(t, x), f(t, x, u) or, as python-control has it, f(t, x, u, params), which is called once, with
        symbols: numpy's functions, `numpy.where` and `numpy.clip` become expressions, a branch by a value is an error.
        Arguments with a default keep it; `params` is a dictionary of `parameters`.
    h : sequence of str, or function
        The outputs, likewise.
    states, inputs, outputs : sequence of str, optional
        Names (default x1, x2, ..; u1, .. as many as are used; y1, ..), or symbols of sympy. Of states and inputs of
        functions the number is enough, and without inputs there are none.
    parameters : dict, optional
        Named constants: numbers, or expressions of other parameters.
    region : dict or sequence, optional
        Bounds `(lower, upper)` by the names of states, inputs and `t`, or one pair for each state: where the
        designs for this plant have to hold.
    dt : float, optional
        Sampling period of a plant in discrete time.
    tables : dict, optional
        Lookup tables, used as functions: a dictionary with `x` and `y`, and `method` and `extrapolation`.
    units : dict or sequence of str, optional
        Units of states, inputs, outputs and parameters by their names, or of the states as a list, for axes and
        tables.
    time_unit : str, optional
        Unit of the time.
    angles : sequence of str, optional
        States and outputs that are angles, in their units (default rad): filters take their differences within half a
        turn, and so are errors.

    Returns
    -------
    Plant

    Raises
    ------
    InvalidArgument
        An expression that cannot be read, or a name that is not known.

    Examples
    --------
    >>> import luenberger, numpy as np
    >>> luenberger.plant(f=["x2", "-x1 + (1 - x1^2)*x2"], h=["x1"])
    <Plant: x1' = x2; x2' = -x1 + (1 - x1^2)*x2; y1 = x1>
    >>> luenberger.plant(f=lambda x, u: [x[1], u[0] - np.sin(x[0])], h=lambda x: x[0], states=2, inputs=1)
    <Plant: x1' = x2; x2' = u1 - sin(x1); y1 = x1>
    """
    named = {
        "states": _names("states", "x", states),
        "inputs": _names("inputs", "u", inputs),
        "outputs": None if outputs is None else _names("outputs", "y", outputs),
    }
    if callable(f) or callable(h):
        if named["states"] is None and isinstance(f, Sequence):
            named["states"] = _names("states", "x", len(f))
        if named["states"] is None:
            raise InvalidArgument("the states of a plant from a function are not known", hint="states=2, or their names")
    table: dict[str, Any] = {}
    for key, given in (("f", f), ("h", h)):
        names = named[{"f": "states", "h": "outputs"}[key]]
        expected = None if names is None else len(names)
        if callable(given):
            of_states, of_inputs = named["states"] or [], named["inputs"] or []
            table[key] = traced(key, given, of_states, of_inputs, list(parameters or ()), expected)
        else:
            table[key] = texts(key, given, list(tables or ()))
            if expected not in (None, len(table[key])):
                raise DimensionMismatch(
                    f"{key} has {len(table[key])} rows, and there are {expected} names: {', '.join(names or [])}",
                    what=key,
                    expected=(expected,),
                    found=(len(table[key]),),
                )
    for key, names in named.items():
        if names is not None:
            table[key] = names
    if parameters:
        table["parameters"] = {
            name: value if isinstance(value, str) else number(f"parameters[{name!r}]", value)
            for name, value in parameters.items()
        }
    if tables:
        table["tables"] = {
            name: {key: value if isinstance(value, str) else real(key, value).tolist() for key, value in entry.items()}
            for name, entry in tables.items()
        }
    step = period(dt)
    if step is not None:
        table["dt"] = step
    if units is not None:
        table["units"] = dict(units) if isinstance(units, Mapping) else _texts("units", units)
    if time_unit is not None:
        table["time_unit"] = time_unit
    if angles is not None:
        table["angles"] = _texts("angles", angles)
    return Plant(table, region)


def _names(what: str, letter: str, given: Sequence[Any] | int | None) -> list[str] | None:
    """Names, or so many of them."""
    if given is None:
        return None
    if isinstance(given, str):
        raise InvalidArgument(f"{what} is a list of names", hint=f"{what}=[{given!r}]")
    if not isinstance(given, Iterable):
        return [f"{letter}{k + 1}" for k in range(count(what, given, 0))]
    return [name_of(what, name) for name in given]


def _texts(what: str, values: Sequence[str]) -> list[str]:
    if isinstance(values, str) or not all(isinstance(value, str) for value in values):
        raise InvalidArgument(f"{what} is a list of strings", hint=f'{what}=["x2", "-x1"]')
    return list(values)


def bounds(plant: Plant | StateSpace, region: Region) -> dict[str, Any]:
    """The table `region` of an observer."""

    def pair(name: str, value: Any) -> list[float]:
        array = real(f"region of {name}", value).ravel()
        if array.size != 2 or not array[0] <= array[1]:
            raise InvalidArgument(f"the region of {name} is {value!r}", hint="a pair (lower, upper)")
        return [float(array[0]), float(array[1])]

    if not isinstance(region, Mapping):
        if len(region) != plant.nstates:
            raise DimensionMismatch(
                f"region must have {plant.nstates} pairs, one for each state, and has {len(region)}",
                what="region",
                expected=(plant.nstates, 2),
                found=(len(region),),
            )
        return {"states": [pair(name, value) for name, value in zip(plant.states, region)]}
    unknown = [name for name in region if name not in {*plant.states, *plant.inputs, "t"}]
    if unknown:
        raise InvalidArgument(
            f"region: {unknown[0]!r} is not a state, an input or t", hint=", ".join([*plant.states, *plant.inputs, "t"])
        )
    free = (float("-inf"), float("inf"))
    table: dict[str, Any] = {"states": [pair(name, region.get(name, free)) for name in plant.states]}
    if any(name in region for name in plant.inputs):
        table["inputs"] = [pair(name, region.get(name, free)) for name in plant.inputs]
    if "t" in region:
        table["time"] = pair("t", region["t"])
    return table


def any_plant(sys: Any) -> Plant | StateSpace:
    """A plant of any of the accepted types, nonlinear ones included."""
    return sys if isinstance(sys, Plant) else linear(sys)


def rows(array: npt.ArrayLike) -> list[list[float]]:
    """A matrix as a study has it."""
    table: list[list[float]] = real("a matrix", array).tolist()
    return table
