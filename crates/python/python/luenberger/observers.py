"""The designed observer: its gains, its certificate, its runs, its step and its code."""

from __future__ import annotations

import json
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _html, _luenberger
from ._arrays import Array, ComplexArray, count, finite, frozen, matrix, number, real, vector
from .certificates import Certificate
from .errors import (
    DimensionMismatch,
    ExportRefused,
    InvalidArgument,
    LinAlgError,
    NotApplicable,
    NotPositiveDefinite,
    NotSymmetric,
    SimulationError,
    Unavailable,
)
from .plants import Plant, as_json
from .systems import StateSpace
from .trajectories import LogWarning, Trajectory, trajectory

# Samples of a simulation: with a gigabyte or so for their results.
MOST_SAMPLES = 10**7

__all__ = ["Export", "Observer"]


@dataclass(frozen=True)
class Export:
    """An exported observer.

    Attributes
    ----------
    folder : Path or None
        Where the files are; None if they were not written.
    files : dict of str to bytes
        The files.
    statement : list of str
        What is proved of the stored numbers, and what is not covered.
    proved : bool
        Whether stability is proved; with feedback, that of the loop too.
    period : float
        The sampling period of the step; the nominal one of an observer at varying periods.
    operations, bytes : int
        Operations of a step, floating-point ones or in fixed point products of integers; bytes of constants and state.
    operations_within_bounds : int or None
        The most operations of a step without active bounds, of a moving-horizon estimator with bounds.
    substeps : int or None
        Runge-Kutta steps per period, where there are any.
    difference : dict or None
        With `run`: how far the exported estimates are from those of this observer along it, for each state: `largest`,
        `second_half`, and `own_error_in_second_half` of this observer itself.
    binaries : list of str
        The binaries in the archive of an FMU.
    notes : list of str
        Why the archive of an FMU lacks binaries.
    digest : str
        SHA-256 of the exported numbers.

    Examples
    --------
    >>> import luenberger
    >>> observer = luenberger.place_observer(([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), [-2, -5])
    >>> exported = observer.export(dt=0.01, format="f32")
    >>> exported.proved, exported.period, exported.operations
    (True, 0.01, 18)
    """

    folder: Path | None
    files: dict[str, bytes] = field(repr=False)
    statement: list[str]
    proved: bool
    period: float
    operations: int
    bytes: int
    operations_within_bounds: int | None
    substeps: int | None
    difference: dict[str, Array] | None
    binaries: list[str]
    notes: list[str]
    digest: str


class Observer:
    """A designed observer.

    Made by `place_observer`, `lqe`, `cubic_observer` and the other designs.

    Attributes
    ----------
    name, kind : str
        Its name and its kind.
    plant : StateSpace or Plant
        The plant.
    dt : float or None
        The sampling period; None for an observer in continuous time.

    Examples
    --------
    >>> import luenberger, numpy as np
    >>> sys = luenberger.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    >>> observer = luenberger.place_observer(sys, [-2, -5])
    >>> np.allclose(observer.L, [[7], [10]]), observer.verdict
    (True, 'proved')
    """

    def __init__(
        self,
        plant: StateSpace | Plant,
        spec: Mapping[str, Any],
        *,
        xhat0: npt.ArrayLike | None = None,
        name: str | None = None,
        covariances: Mapping[str, str] | None = None,
    ) -> None:
        self.plant = plant
        self._spec: dict[str, Any] = {key: value for key, value in spec.items() if value is not None}
        if name is not None:
            self._spec["name"] = str(name)  # by default the kind
        if xhat0 is not None:
            self._spec["initial"] = vector("xhat0", xhat0, plant.nstates).tolist()
        try:
            self._design = _luenberger.Design(as_json(self._study()), ".")
        except (NotPositiveDefinite, NotSymmetric) as error:
            raise _of_argument(error, self._spec, covariances or {}) from None
        summary = self._design.summary()
        self.name: str = summary["name"]
        self.kind: str = summary["kind"]
        self.dt: float | None = summary["period"]
        self._is_at_varying_periods = "jitter" in self._spec or "misses" in self._spec
        self._turns: list[float] | None = summary["turns"]
        self._functions: list[str] | None = summary["functions"]
        self._disturbances: list[str] = summary["disturbances"]
        self._order: int = summary["order"]
        self._initial: Array = frozen(summary["initial"])
        self._report: dict[str, Any] = json.loads(self._design.report())
        self._matrices: dict[str, Array] = {
            _short(entry["name"]): frozen(entry["rows"]) for entry in self._report["matrices"]
        }
        self._started_with: tuple[Array | None, dict[str, Any]] = (None, {})
        self._stepper: _luenberger.Stepper | None = None

    def __getstate__(self) -> dict[str, Any]:
        state = {name: value for name, value in self.__dict__.items() if name not in ("_design", "_stepper")}
        return {**state, "_at": None if self._stepper is None else self._stepper.position()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        state = dict(state)
        at = state.pop("_at")
        self.__dict__.update(state)
        for array in [self._initial, *self._matrices.values()]:
            array.setflags(write=False)  # neither a pickle nor a deep copy keeps this
        self._design = _luenberger.Design(as_json(self._study()), ".")
        self._stepper = None if at is None else self._start()
        if self._stepper is not None:
            self._stepper.resume(*at)

    def _study(self, **tables: Any) -> dict[str, Any]:
        return {
            "title": "study",
            "plant": self.plant._plant(),
            "observer": [self._spec],
            **self.plant._tables(),
            **tables,
        }

    # ------------------------------------------------------------------ the design

    @property
    def matrices(self) -> dict[str, Array]:
        """All matrices of the design by name."""
        return dict(self._matrices)

    def _matrix(self, name: str) -> Array:
        if name not in self._matrices:
            raise Unavailable(f"an observer of the kind {self.kind} has no {name}; it has {', '.join(self._matrices)}")
        return self._matrices[name]

    @property
    def L(self) -> Array:
        """The observer gain, (n, p): `xhat' = A xhat + B u + L (y - C xhat - D u)`.

        Of a Kalman filter in discrete time it is the predictor gain, `xhat[k+1|k] = A xhat[k|k-1] + B u + L (..)`.
        """
        return self._matrix("L")

    @property
    def M(self) -> Array:
        """The filter gain of a Kalman filter in discrete time, `xhat[k|k] = xhat[k|k-1] + M (..)`; `L = A M`."""
        return self._matrix("M")

    @property
    def N(self) -> Array:
        """The gain of the cubic term."""
        return self._matrix("N")

    @property
    def P(self) -> Array:
        """The Lyapunov matrix of the certificate; of a stationary Kalman filter the covariance of its error.

        Of an extended or unscented Kalman filter: the covariance of the error of `xhat`, at first that of the initial
        estimate.
        """
        if self._stepper is None:
            return self._matrix("P(0)" if "P" not in self._matrices and self.kind in _FILTERS else "P")
        covariance = self._stepper.covariance()
        return self._matrix("P") if covariance is None else covariance

    @property
    def Q(self) -> Array:
        """The right-hand side of the Lyapunov equation."""
        return self._matrix("Q")

    @property
    def S(self) -> Array:
        """S of the cubic gain `N = -P^-1 C'S`; of a filter that is stepped, the covariance of `innovation`."""
        if "S" in self._matrices:
            return self._matrix("S")
        covariance: Array = self._of_measurement("covariance", "covariance of the innovation that is kept")
        return covariance

    @property
    def theta(self) -> Array:
        """The weight of the cubic term."""
        return self._matrix("theta")

    @property
    def poles(self) -> ComplexArray:
        """The eigenvalues of the linear error dynamics."""
        return np.array([complex(*pole) for pole in self._report["poles"]], dtype=np.complex128)

    @property
    def numbers(self) -> dict[str, float]:
        """Scalars of the design by name; infinite where there is no finite value."""
        return {
            entry["name"]: float("inf") if entry["value"] is None else entry["value"]
            for entry in self._report["numbers"]
        }

    @property
    def statement(self) -> str:
        """What the design claims, in a sentence."""
        return str(self._report["statement"])

    @property
    def verdict(self) -> str:
        """'proved', 'undecided'; 'measured' or 'none' for observers without a proof."""
        return str(self._report["verdict"])

    @property
    def certificate(self) -> Certificate:
        """What is proved.

        Raises
        ------
        Unavailable
            The observer has no proof: its evidence is measured, or it has none.
        """
        inner = self._design.certificate()
        if inner is None:
            raise Unavailable(f"an observer of the kind {self.kind} has no certificate: {self.statement}")
        return Certificate(inner)

    # ------------------------------------------------------------------ runs

    def simulate(
        self,
        x0: npt.ArrayLike,
        duration: float,
        *,
        u: Any = None,
        samples: int = 501,
        noise: npt.ArrayLike | None = None,
        noise_dt: float | None = None,
        seed: int = 0,
        hold: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        estimates: str = "filtered",
    ) -> Trajectory:
        """Simulate the plant with this observer.

        Parameters
        ----------
        x0 : array_like, (n,)
            The initial state; the initial estimate is that of the design (`xhat0`).
        duration : float
            The end time.
        u : optional
            The input (default 0): numbers, expressions of t, an array (m, samples) with a column for each of the
            `samples` times from 0 to `duration`, or a pair `(t, U)` of times and an array (m, T); both are held
            from one time to the next. An array (m,) is constant, also where `samples` is m.
        samples : int, optional
            Number of output times, at most 1e7.
        noise : float or array_like, (p,), optional
            Standard deviation of Gaussian noise on the outputs.
        noise_dt : float, optional
            How long each value of the noise is held (default: the sampling period, or a thousandth of the duration).
        seed : int, optional
            Seed of the noise.
        hold : float, optional
            Period of a zero-order hold of the input.
        rtol, atol : float, optional
            Tolerances of the integration (default 1e-9, 1e-10).
        estimates : {"filtered", "predicted"}, optional
            The estimates of a Kalman filter at its samples: after the measurement, `xhat[k|k]`, or before it,
            `xhat[k|k-1]`, as `step` and the block of `to_control` have them. Other observers have one estimate.

        Returns
        -------
        Trajectory

        Raises
        ------
        SimulationError
            The run ended early, for example because the plant diverges.

        Examples
        --------
        >>> import luenberger
        >>> observer = luenberger.place_observer(([[0, 1], [-1, -1]], [[0], [1]], [[1, 0]]), [-4, -5])
        >>> run = observer.simulate([1, 0], 5, u=["sin(2*t)"], noise=0.01, seed=7)
        >>> run.xhat.shape
        (2, 501)
        """
        with tempfile.TemporaryDirectory() as folder:
            study = self._simulation(
                folder, x0, duration, u, samples, noise, noise_dt, seed, hold, rtol, atol, estimates
            )
            return self._run(study, folder, on_log=False)

    def _simulation(
        self,
        folder: str,
        x0: npt.ArrayLike,
        duration: float,
        u: Any = None,
        samples: int = 501,
        noise: npt.ArrayLike | None = None,
        noise_dt: float | None = None,
        seed: int = 0,
        hold: float | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        estimates: str = "filtered",
    ) -> dict[str, Any]:
        """The study with a simulation, whose tables are in the folder."""
        duration, samples = number("duration", duration, positive=True), count("samples", samples, 2)
        if samples > MOST_SAMPLES:
            raise InvalidArgument(
                f"samples is {samples}", what="samples", hint=f"at most {MOST_SAMPLES}: results are kept in memory"
            )
        simulation: dict[str, Any] = {
            "x0": vector("x0", x0, self.plant.nstates).tolist(),
            "duration": duration,
            "samples": samples,
            "estimates": estimates,
        }
        for key, value in (("hold", hold), ("rtol", rtol), ("atol", atol)):
            if value is not None:
                simulation[key] = number(key, value, positive=True)
        if noise is not None:
            p = self.plant.noutputs
            amplitude = np.full(p, number("noise", noise)) if np.size(noise) == 1 else vector("noise", noise, p)
            held = self.dt if noise_dt is None else number("noise_dt", noise_dt, positive=True)
            simulation["noise"] = {
                "amplitude": amplitude.tolist(),
                "period": duration / 1000 if held is None else held,
                "seed": count("seed", seed, 0),
            }
        study = self._study(simulation=simulation)
        drive = self._input(u, Path(folder), np.linspace(0.0, duration, samples))
        if drive is not None:
            study["input"] = drive
        return study

    def replay(
        self,
        t: npt.ArrayLike,
        y: npt.ArrayLike,
        u: npt.ArrayLike | None = None,
        *,
        smooth: bool = False,
        repeats: str = "once",
        interpolation: str = "predicted",
    ) -> Trajectory:
        """Run the observer on measured data.

        An observer in discrete time has its estimates at its own samples, from the first time on. A row corrects it if
        it lies on a sample, within a hundredth of the period; other rows are not used, and a sample without a row is
        predicted. One in continuous time, and a filter of a plant in continuous time, has them at the times of the rows.

        Parameters
        ----------
        t : array_like, (T,)
            The times, increasing.
        y : array_like, (p, T)
            The measured outputs; NaN where nothing was measured.
        u : array_like, (m, T), optional
            The inputs (default 0).
        smooth : bool, optional
            Also give the estimates with the whole log, those after each time as well (Rauch, Tung and Striebel), of an
            extended, iterated or unscented Kalman filter: `smoothed` and `smoothed_deviation` of the trajectory.
        repeats : {"once", "measured"}, optional
            What an output is that repeats its values in a rhythm: a value that the logger repeats until the next
            measurement, which counts once, or a measurement in every row.
        interpolation : {"predicted", "held", "linear"}, optional
            What an observer in continuous time sees of the outputs between the rows: the measurement moves with the
            model until the next one, it is held, or there are straight lines, which use later measurements. One in
            discrete time predicts at samples without a row, or sees the straight lines.

        Returns
        -------
        Trajectory
            The estimates; the states are NaN. `warnings` has what limits the use of the data.

        Warns
        -----
        LogWarning
            For each of these `warnings`: rows that are not used, repeated values, gaps, outputs that never change.

        Raises
        ------
        NotApplicable
            `smooth` of an observer without a covariance.

        Examples
        --------
        >>> import luenberger, numpy as np
        >>> observer = luenberger.place_observer(([[0, 1], [0, 0]], None, [[1, 0]]), [-2, -5])
        >>> t = np.linspace(0, 8, 801)
        >>> run = observer.replay(t, 3 * t[np.newaxis])
        >>> bool(abs(run.xhat[1, -1] - 3) < 0.01)
        True
        """
        if smooth:
            known = json.loads(_luenberger.kinds())
            smoothed = [kind["name"] for kind in known if any(key["name"] == "smooth" for key in kind["keys"])]
            if self.kind not in smoothed:
                raise NotApplicable(f"{self.name} is of the kind {self.kind}; smoothed are {', '.join(smoothed)}")
        times = vector("t", t)
        if times.size < 2:
            raise InvalidArgument(f"t has {times.size} entries", hint="two or more")
        _increasing("t", times)
        outputs = _signal("y", y, self.plant.noutputs, times.size, missing=True)
        count = self.plant.ninputs
        inputs = np.zeros((count, times.size)) if u is None else _signal("u", u, count, times.size)
        with tempfile.TemporaryDirectory() as folder:
            heads = _heads(self.plant)
            _table(Path(folder) / "log.csv", heads, [times, *inputs, *outputs])
            log: dict[str, Any] = {"file": "log.csv", "time": heads[0], "outputs": heads[1 + count :]}
            for key, value, known in (
                ("repeats", repeats, ("once", "measured")),
                ("interpolation", interpolation, ("predicted", "held", "linear")),
            ):
                if value not in known:
                    raise InvalidArgument(f"{key} is {value!r}", hint=" or ".join(map(repr, known)))
                log[key] = value
            if count:
                log["inputs"] = heads[1 : 1 + count]
            study = self._study(log=log)
            if smooth:
                study["observer"] = [{**self._spec, "smooth": True}]
            run = self._run(study, folder, on_log=True)
        for text in run.warnings:
            warnings.warn(text, LogWarning, stacklevel=2)
        return run

    def _run(self, study: dict[str, Any], folder: str, *, on_log: bool) -> Trajectory:
        found = self._design.run(as_json(study), folder, on_log)
        return trajectory(found, self.plant.states, self.plant.inputs, self.plant.outputs, self._turns)

    def _input(self, u: Any, folder: Path, at: Array) -> dict[str, Any] | None:
        """The input of a study; of an array with a column for each of the times `at`, its table."""
        m = self.plant.ninputs
        if u is None:
            return None
        if isinstance(u, str):
            u = [u]
        if isinstance(u, (list, tuple)) and u and all(isinstance(row, str) for row in u):
            return {"expressions": list(u)}
        if not isinstance(u, tuple):
            # A row alone is that of a single input, unless it has one entry for each input.
            shape = np.shape(u)
            if (len(shape) == 2 and shape != (m, 1)) or (m == 1 and shape == (at.size,) and at.size != 1):
                u = (at, u)
        if isinstance(u, tuple) and len(u) == 2 and np.ndim(u[0]) == 1 and np.size(u[0]) > 1:
            times = vector("the times of u", u[0])
            _increasing("the times of u", times)
            values = _signal("u", u[1], m, times.size)
            _table(folder / "input.csv", ["t", *self.plant.inputs], [times, *values])
            return {"table": "input.csv"}
        constant = vector("u", u, m)
        return {"expressions": [repr(float(x)) for x in constant]}

    def _period(self, dt: float | None) -> float | None:
        """The period of a step."""
        if dt is None and self.dt is None:
            raise InvalidArgument(f"dt is needed: {self.name} is an observer in continuous time")
        return None if dt is None else number("dt", dt, positive=True)

    # ------------------------------------------------------------------ the step

    def reset(
        self,
        xhat: npt.ArrayLike | None = None,
        *,
        dt: float | None = None,
        substeps: int | None = None,
        format: str = "f64",
    ) -> None:
        """Start stepping from an estimate.

        Parameters
        ----------
        xhat : array_like, (n,), optional
            The estimate (default: that of the design).
        dt : float, optional
            The sampling period, for an observer in continuous time: the input is held over it, and the gain of a
            linear observer becomes that for the sampled plant.
        substeps : int, optional
            Runge-Kutta steps per period, of a nonlinear plant.
        format : {'f64', 'f32'}, optional
            Numbers of the target.
        """
        start = None if xhat is None else frozen(vector("xhat", xhat, self.plant.nstates))
        period = self._period(dt)
        if format not in ("f32", "f64"):
            raise InvalidArgument(f"format is {format!r}", hint="'f32' or 'f64'")
        self._started_with = (start, {"format": format, "period": period, "substeps": substeps})
        self._stepper = self._start()

    def _start(self) -> _luenberger.Stepper:
        """A stepper at the estimate that was given."""
        start, request = self._started_with
        if start is None or self._functions is None:
            return self._design.stepper(start, request)
        # The state of an observer of functions begins with T xhat, which its design has.
        spec = {**self._spec, "initial": start.tolist()}
        return _luenberger.Design(as_json({**self._study(), "observer": [spec]}), ".").stepper(None, request)

    def step(
        self, u: npt.ArrayLike | None, y: npt.ArrayLike | None, dt: npt.ArrayLike | None = None
    ) -> Array:
        """One step, the one that exported code computes.

        A filter without exported code (particle, imm, and those whose fixed Runge-Kutta steps have no bounded error,
        of a stiff plant for example) is stepped as `simulate` and `replay` do, with error control. Ctrl-C ends a call
        with many columns, and the observer is then where it was before.

        Parameters
        ----------
        u : array_like, (m,) or (m, T), or None
            The input of this sample; several samples in columns.
        y : array_like, (p,) or (p, T), or None
            The output of this sample; NaN, and None for all of it, where it was not measured. A filter with a
            covariance and an observer with a constant gain then take the other outputs, and only predict without any;
            other observers take what they predict.
        dt : float, optional
            The sampling period of an observer in continuous time, needed at its first step. Of an observer at varying
            periods the time since the last sample, one or (T,) (default: the nominal period); u was held over it.

        Returns
        -------
        ndarray, (n,) or (n, T)
            The estimate for the next sample; at varying periods that at this one. `estimated` has the names of its
            entries: besides the states those of estimated disturbances. Of an observer of functions z = K x they are
            the functions at this sample.

        Examples
        --------
        >>> import luenberger
        >>> observer = luenberger.place_observer(([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), [-2, -5])
        >>> observer.step(u=0.0, y=1.0, dt=0.1).round(4)
        array([0.5747, 0.7132])
        """
        stepper = self._stepper
        if dt is None and stepper is not None and not self._is_at_varying_periods:
            estimate = stepper.step(u, y)  # None of an array with a mask, whose numbers are not to be read
            if estimate is not None:
                return self._own(estimate)
        is_varying = self._is_at_varying_periods
        stepper = self._started(None if is_varying else dt)
        m, p = self.plant.ninputs, self.plant.noutputs
        outputs = np.full(p, np.nan) if y is None else real("y", y, missing=stepper.can_miss)
        several = outputs.ndim == 2
        columns = outputs.shape[1] if several else 1
        outputs = _sample("y", outputs, p, columns, missing=stepper.can_miss)
        inputs = np.zeros((m, columns)) if u is None else _sample("u", real("u", u), m, columns)
        if is_varying:
            times = real("dt", stepper.period if dt is None else dt)
            times = vector("dt", np.broadcast_to(times, columns) if times.size == 1 else times, columns)
            inputs = np.vstack([inputs, times])
        estimates: Array = self._own(stepper.steps_of(inputs, outputs))
        return estimates if several else estimates[:, 0]

    def _started(self, dt: npt.ArrayLike | None) -> _luenberger.Stepper:
        """The stepper, which begins at the initial estimate if it has not begun."""
        if self._stepper is None:
            self.reset(dt=None if dt is None else number("dt", dt, positive=True))
        stepper = self._stepper
        assert stepper is not None
        if dt is not None and dt != stepper.period:
            raise InvalidArgument(
                f"dt is {dt}, and the observer is stepped with {stepper.period}",
                hint="the same, or reset(dt=..) before",
            )
        return stepper

    @property
    def _is_filter(self) -> bool:
        return self._stepper is not None and self._stepper.is_filter

    def _halves(self, dt: float | None) -> _luenberger.Stepper:
        """The stepper of a filter."""
        stepper = self._started(dt)
        if not stepper.is_filter:
            raise NotApplicable(
                "update and predict are of filters with a covariance, as extended-kalman and ukf are, and this is an "
                f"observer of the kind {self.kind}",
                hint="step",
            )
        return stepper

    def update(self, y: npt.ArrayLike | None, u: npt.ArrayLike | None = None, dt: float | None = None) -> Array:
        """The first half of a step of a filter: the measurement of this sample.

        Parameters
        ----------
        y : array_like, (p,), or None
            The output; NaN, and None for all of it, where it was not measured. Repeated, the outputs of further sensors
            at the same time.
        u : array_like, (m,), optional
            The input, which matters where an output depends on it (default 0).
        dt : float, optional
            The sampling period of an observer in continuous time, if this is how it starts.

        Returns
        -------
        ndarray, (n,)
            The estimate with this measurement; `xhat` and `P` are those, too.

        Raises
        ------
        NotApplicable
            The observer has no covariance.

        Examples
        --------
        >>> import luenberger
        >>> plant = luenberger.plant(f=["x1"], h=["x1"], dt=1)
        >>> filter = luenberger.ekf(plant, 0.0, 1.0, P0=3.0)
        >>> filter.update(2.0), filter.P, filter.S
        (array([1.5]), array([[0.75]]), array([[4.]]))
        >>> filter.predict(), filter.innovation, filter.nis
        (array([1.5]), array([2.]), 1.0)
        """
        stepper = self._halves(dt)
        p = self.plant.noutputs
        outputs = np.full(p, np.nan) if y is None else real("y", y, missing=True)
        if outputs.ndim == 2 and outputs.shape[1] != 1:
            outputs = outputs.ravel()
        stepper.update(self._column("u", u), _sample("y", outputs, p, 1, missing=True)[:, 0])
        return stepper.estimate()

    def predict(self, u: npt.ArrayLike | None = None, dt: float | None = None) -> Array:
        """The second half of a step of a filter: the estimate for the next sample.

        Parameters
        ----------
        u : array_like, (m,), optional
            The input that is held until then (default 0).
        dt : float, optional
            The sampling period of an observer in continuous time, if this is how it starts.

        Returns
        -------
        ndarray, (n,)
            The estimate; `xhat` and `P` are those of the next sample, too.

        Raises
        ------
        NotApplicable
            The observer has no covariance.
        SimulationError
            The prediction is not finite; the estimate stays as it was.
        """
        stepper = self._halves(dt)
        if not stepper.predict(self._column("u", u)):
            raise SimulationError("the prediction is not finite; the estimate stays as it was")
        return stepper.estimate()

    def _column(self, what: str, value: npt.ArrayLike | None) -> Array:
        rows = self.plant.ninputs
        return np.zeros(rows) if value is None else vector(what, value, rows)

    def _measurement(self) -> dict[str, Any]:
        """Of a filter that is stepped, the innovation of the last measurement; NaN where there was none."""
        if self._stepper is None or not self._stepper.is_filter:
            is_filter = self.kind in _FILTERS
            of = "this one is not stepped yet" if is_filter else f"this is an observer of the kind {self.kind}"
            raise Unavailable(
                "innovation, S, nis and log_likelihood are of filters with a covariance, as extended-kalman and ukf "
                f"are, after a step or an update, and {of}",
                hint="step",
            )
        found = self._stepper.innovation()
        if found is None:
            p, nan = self.plant.noutputs, float("nan")
            return {
                "value": np.full(p, nan),
                "covariance": np.full((p, p), nan),
                "square": nan,
                "log_determinant": nan,
                "used": 0,
            }
        return found

    def _of_measurement(self, name: str, what: str) -> Any:
        found = self._measurement()[name]
        if found is None:
            raise Unavailable(f"{self.name} is of the kind {self.kind}, whose update has no {what}")
        return found

    @property
    def innovation(self) -> Array:
        """Of a filter, `y - h(xhat)` of the last step or update; 0 for an output that was not measured.

        NaN without a measurement, as are `S`, `nis` and `log_likelihood`: before the first, and where a sample was
        passed over.
        """
        found: Array = self._measurement()["value"]
        return found

    @property
    def nis(self) -> float:
        """The normalised square of the innovation, `y~' S^-1 y~`: chi-squared with as many degrees as outputs."""
        return float(self._measurement()["square"])

    @property
    def log_likelihood(self) -> float:
        """Of the last measurement given those before: `-(p ln(2 pi) + ln det S + y~' S^-1 y~)/2`, p outputs measured."""
        found = self._measurement()
        determinant = self._of_measurement("log_determinant", "likelihood")
        return float(-0.5 * (found["used"] * np.log(2.0 * np.pi) + determinant + found["square"]))

    @property
    def xhat(self) -> Array:
        """The estimate for the next sample, after `update` that with its measurement; at first the initial estimate."""
        if self._stepper is not None:
            return self._own(self._stepper.estimate())
        return self._initial.copy() if self._functions is None else self._matrix("K") @ self._initial

    @property
    def estimated(self) -> list[str]:
        """Names of the entries of `xhat` and of what `step` returns.

        The states; behind them, once the observer is stepped, the disturbances that it estimates and the half-widths
        of the bounds of an interval observer. Of an observer of functions z = K x the functions.
        """
        if self._functions is not None:
            return list(self._functions)
        return list(self.plant.states) if self._stepper is None else self._stepper.names

    def _own(self, estimate: Array) -> Array:
        """Of an observer of functions these, of which the first entries are; the others are its state."""
        return estimate if self._functions is None else estimate[: len(self._functions)]

    # ------------------------------------------------------------------ other programs

    def to_control(self) -> Any:
        """The observer as a system of python-control, with inputs (u, y) and the estimate as output.

        Returns
        -------
        control.StateSpace or control.NonlinearIOSystem
            A StateSpace of a linear observer; an observer at varying periods has none (`NotApplicable`). The inputs
            have the names of the plant's inputs and outputs, the outputs are named `x_hat`, so that
            `control.interconnect` joins them; behind them those of estimated disturbances `d1_hat`. Those of an observer
            of functions are `z1_hat`.

        Examples
        --------
        >>> import luenberger
        >>> observer = luenberger.place_observer(([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), [-2, -5])
        >>> observer.to_control().input_labels
        ['u1', 'y1']
        """
        import control

        if self._is_at_varying_periods:
            raise NotApplicable(f"{self.name} has samples at varying periods, and a block has one period")
        plant = self.plant
        hats = [f"{name}_hat" for name in [*(self._functions or plant.states), *self._disturbances]]
        names: dict[str, Any] = {"inputs": [*plant.inputs, *plant.outputs], "outputs": hats, "name": self.name}
        m = plant.ninputs
        if type(plant) is StateSpace and self.kind in ("luenberger", "kalman"):
            A = plant.A - self.L @ plant.C
            B = np.hstack([plant.B - self.L @ plant.D, self.L])
            n = plant.nstates
            return control.ss(A, B, np.eye(n), np.zeros((n, B.shape[1])), self.dt or 0, states=hats, **names)

        def update(t: float, z: Array, w: Array, _: Any) -> Array:
            return self._design.motion(float(t), _entries(z), _entries(w[:m]), _entries(w[m:]))

        def output(t: float, z: Array, w: Array, _: Any) -> Array:
            # That of functions uses the measurement of its sample.
            of = self._design.estimate if self._functions is None else self._design.estimate_at
            estimate = of(float(t), _entries(z), _entries(w[:m]), _entries(w[m:]))
            # The estimates of disturbances are the last entries of the state.
            return np.append(estimate, _entries(z)[self._order - len(self._disturbances) :])

        states = hats if self._order == len(hats) and self._functions is None else [f"z{i + 1}" for i in range(self._order)]
        return control.NonlinearIOSystem(update, output, states=states, dt=self.dt or 0, **names)

    def initial_state(self, xhat: npt.ArrayLike | None = None, u: Any = None, y: Any = None, t: float = 0.0) -> Array:
        """The state of `to_control()` that has the estimate `xhat` (default: that of the design)."""
        start = self._initial if xhat is None else vector("xhat", xhat, self.plant.nstates)
        if self._functions is not None:
            start = self._matrix("K") @ start
        inputs = np.zeros(self.plant.ninputs) if u is None else vector("u", u, self.plant.ninputs)
        outputs = np.zeros(self.plant.noutputs) if y is None else vector("y", y, self.plant.noutputs)
        return self._design.initial(float(t), start, inputs, outputs)

    def export(
        self,
        folder: str | PathLike[str] | None = None,
        to: str = "c",
        *,
        dt: float | None = None,
        format: str = "f64",
        gains: str | None = None,
        fmi: int | None = None,
        layout: str | None = None,
        libm: str = "own",
        feedback: npt.ArrayLike | None = None,
        substeps: int | None = None,
        test_steps: int = 64,
        run: Mapping[str, Any] | None = None,
        unproved: bool = False,
        force: bool = False,
    ) -> Export:
        """Write the observer as source code for its target.

        Parameters
        ----------
        folder : path-like, optional
            Where to write; without it the files are only returned.
        to : {'c', 'rust', 'fmu'}, optional
            C99, a `no_std` crate, or a Functional Mock-up Unit.
        dt : float, optional
            The sampling period, for an observer in continuous time.
        format : str, optional
            Numbers of the target: 'f64', 'f32', or fixed point such as 'q16.16' (2 to 32 bits, the sign among those
            before the point), of a linear observer in C.
        gains : str, optional
            Fixed-point format of the gains (default: that of `format`).
        fmi : {2, 3}, optional
            Version of the standard of an FMU (default 2).
        layout : {'arduino', 'zephyr', 'esp-idf', 'ros2'}, optional
            The build system that the files in C are for, with a program to be filled in (default CMake).
        libm : {'own', 'target'}, optional
            Whose elementary functions the code in C calls: those of the design, written out, or those of the target's
            C library, whose bits may differ.
        feedback : array_like, (m, n), optional
            The gain K of `u = r - K xhat`: the step takes r and y, and returns u as well. The input of `run` is then r.
        substeps : int, optional
            Runge-Kutta steps per period, of a nonlinear plant (default: a quarter of the fastest time constant of the
            error each; those of an extended Kalman filter in its design).
        test_steps : int, optional
            Steps of the golden test.
        run : dict, optional
            Arguments of `simulate`. The bounds of states, inputs and noise in that run are those of the proof, which
            then covers rounding on the target: the ball to which the error shrinks. The exported step is compared with
            this observer along the run.
        unproved : bool, optional
            Export an observer without a stability certificate, too.
        force : bool, optional
            Write into a folder that has files.

        Returns
        -------
        Export

        Raises
        ------
        ExportRefused
            With the reason.
        InvalidArgument
            Options that do not go together.

        Examples
        --------
        >>> import luenberger
        >>> observer = luenberger.place_observer(([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), [-2, -5])
        >>> sorted(observer.export(dt=0.01).files)[:2]
        ['CMakeLists.txt', 'README.md']
        >>> observer.export(dt=0.01, format="q12.20", gains="q4.28").proved
        True
        """
        period = self._period(dt)
        root = None if folder is None else Path(folder)
        if root is not None and root.is_dir() and any(root.iterdir()) and not force:
            raise ExportRefused(f"{root} has files", alternatives=("another folder, or force=True",))
        with tempfile.TemporaryDirectory() as scratch:
            study = self._study() if run is None else self._simulation(scratch, **run)
            if feedback is not None:
                k = matrix("feedback", feedback, self.plant.ninputs, self.plant.nstates, vector="row")
                study.setdefault("input", {})["feedback"] = {"k": k.tolist(), "observer": self.name}
            request = {
                "to": to,
                "fmi": fmi,
                "layout": layout,
                "libm": libm,
                "feedback": feedback is not None,
                "format": format,
                "gains": gains,
                "period": period,
                "substeps": substeps,
                "test_steps": test_steps,
                "unproved": unproved,
            }
            given = None if run is None and feedback is None else as_json(study)
            found = self._design.export(given, scratch, request)
        if root is not None:
            for name, content in found["files"].items():
                path = root / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
        return Export(folder=root, **found)

    # ------------------------------------------------------------------ notebooks

    def __repr__(self) -> str:
        return f"<Observer {self.name}: {self.kind}, {self.verdict}>"

    def _repr_html_(self) -> str:
        head = _html.paragraph(f"{self.name} ({self.kind}): {self.statement}")
        numbers = _html.table("numbers", [], [[name, _html.number(value)] for name, value in self.numbers.items()])
        inner = self._design.certificate()
        facts = "" if inner is None else Certificate(inner)._repr_html_()
        return head + _html.matrices(self._matrices.items()) + numbers + facts


def _of_argument(
    error: NotPositiveDefinite | NotSymmetric, spec: Mapping[str, Any], names: Mapping[str, str]
) -> LinAlgError:
    """The same of the argument that the matrix was, with its least eigenvalue."""
    what = error.what
    name, text, numbers = names.get(what, what), str(error), dict(error.__dict__)
    if isinstance(error, NotPositiveDefinite) and "lambda_min" not in numbers:
        numbers["lambda_min"] = float("nan")
        given = np.asarray(spec.get({"W": "w", "V": "v", "P(0)": "p0"}.get(what, ""), np.nan), dtype=np.float64)
        # A number and a list stand for a multiple of the identity and the diagonal.
        if given.ndim < 2:
            given = np.diag(np.atleast_1d(given))
        if given.shape[0] == given.shape[1] and np.isfinite(given).all():
            least = numbers["lambda_min"] = float(np.linalg.eigvalsh((given + given.T) / 2)[0])
            sign = "positive definite" if what == "V" else "positive semidefinite"
            text = f"{what} is not {sign}: its smallest eigenvalue is {least:g}"
    if text.startswith(f"{what} "):
        text = name + text[len(what) :]
    return type(error)(text, **{**numbers, "what": name})


def _short(name: str) -> str:
    """Of `P (stationary error covariance)` the P."""
    return name.split(" (")[0]


# Filters whose step has a covariance, P(0) at first.
_FILTERS = ("extended-kalman", "iterated-extended-kalman", "error-state-kalman", "ukf", "particle", "imm")


def _sample(what: str, array: Array, rows: int, columns: int, *, missing: bool = False) -> Array:
    """One sample, or several in columns."""
    if array.ndim < 2 and columns == 1:
        if array.size != rows:
            shape = tuple(int(n) for n in array.shape)
            raise DimensionMismatch(
                f"{what} must have {rows} {'entry' if rows == 1 else 'entries'}, and has the shape {shape}",
                what=what,
                expected=(rows,),
                found=shape,
            )
        array = array.reshape(rows, 1)
    return _signal(what, array, rows, columns, missing=missing)


def _entries(value: Any) -> Array:
    return np.ascontiguousarray(np.asarray(value, dtype=np.float64).ravel())


def _signal(what: str, value: npt.ArrayLike, rows: int, columns: int, *, missing: bool = False) -> Array:
    """An array (rows, columns); one row may be a vector."""
    array = real(what, value, missing=missing)
    if array.ndim == 1 and rows == 1:
        array = array.reshape(1, -1)
    if array.ndim != 2 or array.shape != (rows, columns):
        raise DimensionMismatch(
            f"{what} must be {rows} x {columns}, one column for each time, and has the shape {array.shape}",
            what=what,
            expected=(rows, columns),
            found=tuple(int(n) for n in array.shape),
        )
    if missing:
        finite(what, np.where(np.isnan(array), 0.0, array))
        return array
    return matrix(what, array)


def _increasing(what: str, times: Array) -> None:
    """Raises where a time is not later than the one before it."""
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if late.size:
        k = int(late[0]) + 1
        raise InvalidArgument(f"{what} must increase, and entry {k} is {times[k]:g} after {times[k - 1]:g}")


def _heads(plant: StateSpace | Plant) -> list[str]:
    """Names of the columns of a log: the time, the inputs and the outputs, those of the plant where they differ."""
    given = [*plant.inputs, *plant.outputs]
    kinds = [*("in" for _ in plant.inputs), *("out" for _ in plant.outputs)]
    taken = set(given)

    def free(name: str) -> str:
        while name in taken:
            name += "_"
        taken.add(name)
        return name

    time = free("t")
    is_own = [name.isidentifier() and given.count(name) == 1 for name in given]
    return [time, *(name if own else free(f"{kind}{k}") for k, (name, kind, own) in enumerate(zip(given, kinds, is_own)))]


def _table(path: Path, heads: Sequence[str], columns: Sequence[Array]) -> None:
    """A CSV file; NaN is a blank cell."""
    with path.open("w", encoding="utf-8") as file:
        file.write(",".join(heads) + "\n")
        for row in zip(*columns):
            file.write(",".join("" if np.isnan(x) else repr(float(x)) for x in row) + "\n")
