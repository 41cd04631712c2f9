"""The designs: from a plant to an observer with its certificate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import Array, count, frozen, matrix, number, poles as pole_list, symmetric, vector, weight
from .errors import InvalidArgument, InvalidPole
from .observers import Observer
from .plants import Plant, Region, any_plant, bounds, rows
from .systems import StateSpace, linear

__all__ = [
    "certify",
    "cubic_observer",
    "dlqe",
    "ekf",
    "high_gain_observer",
    "kkl_observer",
    "lipschitz_observer",
    "lmi_observer",
    "lpv_observer",
    "lqe",
    "mean_value_observer",
    "place_observer",
    "sampled_cubic_observer",
]


def _pairs(poles: Iterable[complex] | npt.ArrayLike, plant: StateSpace) -> list[Any]:
    """Stable poles as a study has them: real ones as numbers, complex ones as pairs."""
    pairs: list[Any] = []
    dt, given = plant.dt, pole_list(poles)
    if given.size != plant.nstates:
        message = f"a plant of order {plant.nstates} needs {plant.nstates} poles, and {given.size} are given"
        raise InvalidPole(message, expected=plant.nstates, found=int(given.size))
    for pole in map(complex, given):
        if (pole.real >= 0) if dt is None else (abs(pole) >= 1):
            where = "in the open left half plane" if dt is None else "inside the unit circle"
            raise InvalidPole(f"the observer pole {pole:g} is not {where}", pole=pole)
        pairs.append(pole.real if pole.imag == 0 else [pole.real, pole.imag])
    return pairs


def _weighted(rho: float | None, Q: npt.ArrayLike | None, n: int) -> dict[str, Any]:
    """The right-hand side of the certifying Lyapunov equation."""
    if rho is not None and Q is not None:
        raise InvalidArgument("rho or Q, not both")
    table: dict[str, Any] = {}
    if rho is not None:
        table["rho"] = number("rho", rho, positive=True)
    if Q is not None:
        table["q"] = rows(matrix("Q", Q, n, n))
    return table


def _gain(
    plant: StateSpace,
    poles: Any,
    L: Any,
    QN: Any,
    RN: Any,
    G: Any,
    decay_rate: Any,
    max_gain: Any = None,
    noise: Any = None,
) -> dict[str, Any]:
    """How the gain of a linear observer is computed; exactly one way."""
    n, p = plant.nstates, plant.noutputs
    ways = {"poles": poles is not None, "L": L is not None, "QN": QN is not None, "decay_rate": decay_rate is not None}
    given = [name for name, is_given in ways.items() if is_given]
    if len(given) != 1:
        found = " and ".join(given) if given else "none"
        raise InvalidArgument(f"one of poles, L, QN with RN, decay_rate is needed, and {found} is given")
    if (RN is None) != (QN is None):
        raise InvalidArgument("QN and RN are given together")
    if G is not None and QN is None:
        raise InvalidArgument("G is that of the process noise, and QN and RN are not given")
    table: dict[str, Any] = {}
    if poles is not None:
        table["poles"] = _pairs(poles, plant)
    elif L is not None:
        table["gain"] = rows(matrix("L", L, n, p))
    elif QN is not None:
        table["kalman"] = {"w": rows(_process(plant, QN, G)), "v": rows(weight("RN", RN, p))}
    else:
        rate = number("decay_rate", decay_rate)
        table.update({"decay_rate": rate} if rate > 0 else {"lmi": True} if rate == 0 else {"decay_rate": rate})
    table.update(_limits(max_gain, noise, p))
    return table


def _limits(max_gain: Any, noise: Any, p: int) -> dict[str, Any]:
    table: dict[str, Any] = {}
    if max_gain is not None:
        table["max_gain"] = number("max_gain", max_gain, positive=True)
    if noise is not None:
        table["noise"] = rows(weight("noise", noise, p))
    return table


def _process(plant: StateSpace, QN: npt.ArrayLike, G: npt.ArrayLike | None) -> Array:
    """`G QN G'`, exactly symmetric."""
    n = plant.nstates
    if G is None:
        G = plant.B
    G = matrix("G", G, rows=n)
    q = symmetric("QN", weight("QN", QN, G.shape[1]))
    if G.shape == (n, n) and np.array_equal(G, np.eye(n)):
        return q
    product = G @ q @ G.T
    return (product + product.T) / 2


def place_observer(
    sys: Any,
    poles: Iterable[complex] | npt.ArrayLike,
    *,
    rho: float | None = None,
    Q: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Observer with specified eigenvalues of `A - L C`.

    Parameters
    ----------
    sys : StateSpace
        A plant of any of the accepted types, in continuous or discrete time.
    poles : sequence of complex
        n numbers closed under conjugation, in the open left half plane or inside the unit circle.
    rho, Q : optional
        Right-hand side `rho I` (default 1) or Q of the Lyapunov equation `(A - L C)'P + P (A - L C) + Q = 0` that
        certifies the gain, in continuous time.
    xhat0 : array_like, (n,), optional
        Initial estimate (default 0).
    name : str, optional
        Name of the observer.

    Returns
    -------
    Observer
        With `L`, `P`, `Q`, `poles` and `certificate`.

    Raises
    ------
    Unobservable
        A mode that no output sees: its eigenvalue, direction and margin.
    InvalidPole
        Poles that no real gain places, or for which the observer would not converge.

    Examples
    --------
    >>> import luenberger, numpy as np
    >>> observer = luenberger.place_observer(([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), [-2, -5])
    >>> np.allclose(observer.L.ravel(), [7, 10]), observer.certificate.is_proved
    (True, True)
    """
    plant = linear(sys)
    spec = {"kind": "luenberger", "poles": _pairs(poles, plant), **_weighted(rho, Q, plant.nstates)}
    return Observer(plant, spec, xhat0=xhat0, name=name)


def certify(
    sys: Any,
    L: npt.ArrayLike,
    *,
    rho: float | None = None,
    Q: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """The observer with a gain that was computed elsewhere, and its proof.

    Parameters
    ----------
    sys : StateSpace
        A plant of any of the accepted types.
    L : array_like, (n, p)
        The gain, for example that of `control.lqe`.
    rho, Q, xhat0, name : optional
        As for `place_observer`.

    Returns
    -------
    Observer

    Raises
    ------
    NotStable
        `A - L C` is not stable.

    Examples
    --------
    >>> import luenberger
    >>> luenberger.certify(([[0, 1], [0, 0]], None, [[1, 0]]), [[3], [1]]).verdict
    'proved'
    """
    plant = linear(sys)
    spec = {"kind": "luenberger", "gain": rows(matrix("L", L, plant.nstates, plant.noutputs))}
    return Observer(plant, {**spec, **_weighted(rho, Q, plant.nstates)}, xhat0=xhat0, name=name)


def lmi_observer(
    sys: Any,
    decay_rate: float = 0.0,
    *,
    max_gain: float | None = None,
    noise: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Observer with a decay rate, by a linear matrix inequality.

    Parameters
    ----------
    sys : StateSpace
        A plant in continuous time.
    decay_rate : float, optional
        Every error decays at least as fast as `exp(-decay_rate t)`; 0 gives the gain with the largest margin.
    max_gain : float, optional
        Upper bound of the spectral norm of L.
    noise : array_like, (p, p), optional
        Intensity of the measurement noise; its effect is minimised among the gains that are allowed.
    xhat0, name : optional
        As for `place_observer`.

    Returns
    -------
    Observer

    Raises
    ------
    Infeasible
        No such gain exists, which is proved.

    Examples
    --------
    >>> import luenberger
    >>> observer = luenberger.lmi_observer(([[0, 1], [0, 0]], None, [[1, 0]]), decay_rate=1.0)
    >>> observer.verdict, bool(max(observer.poles.real) < -1.0)
    ('proved', True)
    """
    plant = linear(sys)
    spec = {"kind": "luenberger", **_gain(plant, None, None, None, None, None, decay_rate, max_gain, noise)}
    return Observer(plant, spec, xhat0=xhat0, name=name)


class _StationaryFilter(Observer):
    """The observer of `lqe` and `dlqe`, which is also what python-control returns: `L, P, E = lqe(..)`."""

    def __iter__(self) -> Iterator[Any]:
        return iter((self.L, self.P, self.poles))


def _lqe_arguments(
    what: str, args: tuple[Any, ...], G: npt.ArrayLike | None, dt: float | None
) -> tuple[StateSpace, dict[str, Any]]:
    """`(sys, QN, RN[, NN])` or `(A, G, C, QN, RN[, NN])`, as python-control takes them: the plant, and w, v and s."""
    if len(args) in (5, 6):
        if G is not None:
            raise InvalidArgument(f"{what}(A, G, C, QN, RN) has its G", hint=f"{what}(sys, QN, RN, G=G)")
        A, G, C, QN, RN, *cross = args
        plant = StateSpace(A, None, C, None, dt)
    elif len(args) in (3, 4):
        sys, QN, RN, *cross = args
        plant = linear(sys)
        if G is None and plant.ninputs == 0:
            raise InvalidArgument(f"{what} takes B for G, and this plant has none", hint="G")
    else:
        raise InvalidArgument(
            f"{what} takes (sys, QN, RN[, NN]) or (A, G, C, QN, RN[, NN]), and has {len(args)} arguments"
        )
    spec: dict[str, Any] = {
        "kind": "kalman",
        "w": rows(_process(plant, QN, G)),
        "v": rows(weight("RN", RN, plant.noutputs)),
    }
    for NN in cross:
        g = plant.B if G is None else matrix("G", G, rows=plant.nstates)
        spec["s"] = rows(g @ matrix("NN", NN, g.shape[1], plant.noutputs))
    return plant, spec


def lqe(
    *args: Any,
    G: npt.ArrayLike | None = None,
    rho: float | None = None,
    Q: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Stationary Kalman filter in continuous time.

    Called as in python-control: `lqe(sys, QN, RN)` or `lqe(A, G, C, QN, RN)`, for `x' = A x + B u + G w`,
    `y = C x + D u + v` with white noises w and v of the intensities QN and RN. With `sys`, G is its B unless it is
    given as `G=`.

    Parameters
    ----------
    sys : StateSpace
        A plant of any of the accepted types; of one in discrete time the result is that of `dlqe`.
    A, G, C : array_like
        Its matrices.
    QN : array_like
        Intensity of the process noise: a matrix, its diagonal, or a number times the identity.
    RN : array_like
        Intensity of the measurement noise, likewise. After it NN may follow, the cross-intensity `E w v'`, a matrix
        with a row for each of w and a column for each output.
    rho, Q, xhat0, name : optional
        As for `place_observer`.

    Returns
    -------
    Observer
        With the gain `L`, the stationary covariance `P` and the `poles`. It can be unpacked as what python-control
        returns: `L, P, E = lqe(..)`, E the poles.

    Raises
    ------
    NotDetectable
        An eigenvalue that does not decay is not seen by the outputs.

    Examples
    --------
    >>> import luenberger
    >>> observer = luenberger.lqe([[0.0]], [[1.0]], [[1.0]], 4.0, 1.0)
    >>> observer.L.round(12), observer.P.round(12)
    (array([[2.]]), array([[2.]]))
    >>> L, P, E = observer
    """
    plant, noises = _lqe_arguments("lqe", args, G, None)
    if plant.dt is not None:
        if rho is not None or Q is not None:
            raise InvalidArgument("rho and Q are for plants in continuous time, and this one is in discrete time")
        return dlqe(*args, G=G, xhat0=xhat0, name=name)
    spec = {**noises, **_weighted(rho, Q, plant.nstates)}
    return _StationaryFilter(plant, spec, xhat0=xhat0, name=name, covariances={"W": "QN", "V": "RN"})


def dlqe(
    *args: Any,
    G: npt.ArrayLike | None = None,
    dt: float | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Stationary Kalman filter in discrete time.

    Called as in python-control: `dlqe(sys, QN, RN)` or `dlqe(A, G, C, QN, RN)`, with NN as for `lqe`.

    Parameters
    ----------
    sys : StateSpace
        A plant of any of the accepted types, in discrete time.
    A, G, C : array_like
        Its matrices.
    QN, RN : array_like
        Covariances of the noises per sample: matrices, their diagonals, or numbers times the identity.
    dt : float, optional
        Sampling period of a plant given by its matrices (default 1).
    xhat0, name : optional
        As for `place_observer`.

    Returns
    -------
    Observer
        With the predictor gain `L` of `xhat[k+1|k] = A xhat[k|k-1] + B u[k] + L (y[k] - C xhat[k|k-1] - D u[k])`
        (that of python-control), the filter gain `M` of `xhat[k|k] = xhat[k|k-1] + M (..)` (that of MATLAB; without NN
        `L = A M`),
        and the stationary covariance `P` of the prediction error. `L, P, E = dlqe(..)` unpacks it, as of
        python-control.

    Raises
    ------
    NotDetectable
        An eigenvalue that does not decay is not seen by the outputs.

    Examples
    --------
    >>> import luenberger
    >>> observer = luenberger.dlqe([[2.0]], [[1.0]], [[1.0]], 1.0, 1.0)
    >>> observer.L.round(4), observer.M.round(4)
    (array([[1.618]]), array([[0.809]]))
    """
    plant, noises = _lqe_arguments("dlqe", args, G, 1.0 if dt is None else dt)
    if dt is not None and plant.dt not in (None, dt):
        raise InvalidArgument(f"dt is {dt}, and the plant has {plant.dt}", hint="dt of a plant given by its matrices")
    if plant.dt is None:
        raise InvalidArgument(
            "dlqe is for discrete time, and this plant has no dt", hint="lqe in continuous time, or a sampled plant"
        )
    observer = _StationaryFilter(plant, noises, xhat0=xhat0, name=name, covariances={"W": "QN", "V": "RN"})
    P, C = observer.P, plant.C
    observer._matrices["M"] = frozen(np.linalg.solve(C @ P @ C.T + np.array(noises["v"]), C @ P).T)
    return observer


def cubic_observer(
    sys: Any,
    poles: Iterable[complex] | npt.ArrayLike | None = None,
    *,
    L: npt.ArrayLike | None = None,
    QN: npt.ArrayLike | None = None,
    RN: npt.ArrayLike | None = None,
    G: npt.ArrayLike | None = None,
    decay_rate: float | None = None,
    gamma: float | None = None,
    radial: float | None = None,
    S: npt.ArrayLike | None = None,
    theta: npt.ArrayLike | None = None,
    rho: float | None = None,
    Q: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Cubic observer: a linear one with the term `(e_y' theta e_y) N e_y`, which preserves stability.

    `xhat' = A xhat + B u + L e_y - (e_y' theta e_y) N e_y`, with `e_y = y - C xhat - D u`.

    Parameters
    ----------
    sys : StateSpace
        A plant of any of the accepted types, in continuous time.
    poles, L, QN with RN (and G), decay_rate : optional
        The linear part: eigenvalues of `A - L C`, a given gain, noise intensities as for `lqe`, or a decay rate as
        for `lmi_observer`. Exactly one is given.
    gamma, radial, S : optional
        The cubic gain: `N = -gamma P^-1 C' theta`, `N = -radial P^-1 C'(C P^-1 C')^-1`, or `N = -P^-1 C'S` with
        `S + S' >= 0`. Exactly one is given.
    theta : array_like, (p, p), optional
        The weight of the cubic term (default the identity).
    rho, Q, xhat0, name : optional
        As for `place_observer`.

    Returns
    -------
    Observer
        With `L`, `N`, `P`, `Q`, `S` and `theta`.

    Examples
    --------
    >>> import luenberger
    >>> sys = ([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    >>> observer = luenberger.cubic_observer(sys, [-2, -5], gamma=2.0, rho=10.0, theta=10.0)
    >>> observer.N.round(3).ravel(), observer.verdict
    (array([ -9.882, -11.529]), 'proved')
    """
    plant = linear(sys)
    spec = {
        "kind": "cubic",
        **_gain(plant, poles, L, QN, RN, G, decay_rate),
        **_weighted(rho, Q, plant.nstates),
        **_cubic(plant, theta),
    }
    given = {"gamma": gamma, "radial": radial, "S": S}
    chosen = [key for key, value in given.items() if value is not None]
    if len(chosen) != 1:
        found = " and ".join(chosen) if chosen else "none"
        raise InvalidArgument(f"one of gamma, radial and S is needed, and {found} is given")
    if S is not None:
        spec["s"] = rows(matrix("S", S, plant.noutputs, plant.noutputs))
    else:
        spec[chosen[0]] = number(chosen[0], given[chosen[0]], positive=True)
    return Observer(plant, spec, xhat0=xhat0, name=name)


def _cubic(plant: StateSpace, theta: npt.ArrayLike | None) -> dict[str, Any]:
    return {} if theta is None else {"theta": rows(weight("theta", theta, plant.noutputs))}


def sampled_cubic_observer(
    sys: Any,
    poles: Iterable[complex] | npt.ArrayLike | None = None,
    *,
    gamma: float,
    dt: float | None = None,
    L: npt.ArrayLike | None = None,
    QN: npt.ArrayLike | None = None,
    RN: npt.ArrayLike | None = None,
    G: npt.ArrayLike | None = None,
    decay_rate: float | None = None,
    theta: npt.ArrayLike | None = None,
    jitter: Sequence[float] | None = None,
    misses: int | None = None,
    rho: float | None = None,
    Q: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Sampled cubic observer: one step for each sample, stable at every sampling period.

    Parameters
    ----------
    sys : StateSpace
        A plant of any of the accepted types, in continuous or discrete time.
    poles, L, QN with RN (and G), decay_rate : optional
        The linear part, as for `cubic_observer`: that of the plant in continuous time, which is then sampled, or of the
        plant in discrete time (poles inside the unit circle).
    gamma : float
        The strength w of the cubic term, `N = -w P^-1 C'(C P^-1 C')^-1`.
    dt : float, optional
        The sampling period; that of a plant in discrete time is its own.
    jitter : pair of float, optional
        The shortest and the longest real period: the proof covers all between, and `step` takes the time since the last
        sample.
    misses : int, optional
        How many samples may be missed in a row; covered by the proof.
    theta, rho, Q, xhat0, name : optional
        As for `cubic_observer`.

    Returns
    -------
    Observer

    Examples
    --------
    >>> import luenberger
    >>> sys = ([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    >>> observer = luenberger.sampled_cubic_observer(sys, [-2, -5], gamma=1.0, dt=0.1)
    >>> observer.dt, observer.verdict
    (0.1, 'proved')
    """
    plant = linear(sys)
    step = plant.dt if dt is None else number("dt", dt, positive=True)
    if step is None:
        raise InvalidArgument("dt is needed for a plant in continuous time")
    spec = {
        "kind": "sampled-cubic",
        **_gain(plant, poles, L, QN, RN, G, decay_rate),
        **_weighted(rho, Q, plant.nstates),
        **_cubic(plant, theta),
        "gamma": number("gamma", gamma, positive=True),
        "period": step,
        "jitter": None if jitter is None else vector("jitter", jitter, 2).tolist(),
        "misses": None if misses is None else count("misses", misses),
    }
    return Observer(plant, spec, xhat0=xhat0, name=name)


def _region(plant: Plant | StateSpace, region: Region | None) -> dict[str, Any]:
    if region is None and isinstance(plant, Plant):
        region = plant.region
    return {} if region is None else {"region": bounds(plant, region)}


def lpv_observer(
    plant: Any,
    decay_rate: float | None = None,
    *,
    fastest: float | None = None,
    L: npt.ArrayLike | None = None,
    region: Region | None = None,
    max_gain: float | None = None,
    noise: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Copy of a nonlinear plant with one gain for all its Jacobians over a region.

    Parameters
    ----------
    plant : Plant
        The plant, in continuous or discrete time.
    decay_rate : float, optional
        Decay rate to be certified (default 0).
    fastest : float, optional
        In place of `decay_rate`: the largest rate up to this bound is found and certified.
    L : array_like, (n, p), optional
        A given gain, which is analysed.
    region : dict or sequence, optional
        Bounds of states, inputs and t by their names (default: those of the plant).
    max_gain, noise, xhat0, name : optional
        As for `lmi_observer`.

    Returns
    -------
    Observer

    Raises
    ------
    Infeasible
        No gain has this rate for all Jacobians, which is proved.
    NotApplicable
        The Jacobians are not bounded over the region.

    Examples
    --------
    >>> import luenberger
    >>> pendulum = luenberger.plant(["w", "-sin(a) - 0.1*w"], ["a"], states=["a", "w"])
    >>> luenberger.lpv_observer(pendulum, decay_rate=0.5).verdict
    'proved'
    """
    plant = any_plant(plant)
    spec: dict[str, Any] = {"kind": "lpv", **_region(plant, region), **_limits(max_gain, noise, plant.noutputs)}
    for key, value in (("decay_rate", decay_rate), ("fastest", fastest)):
        if value is not None:
            spec[key] = number(key, value)
    if L is not None:
        spec["gain"] = rows(matrix("L", L, plant.nstates, plant.noutputs))
    return Observer(plant, spec, xhat0=xhat0, name=name)


def lipschitz_observer(
    plant: Any,
    decay_rate: float | None = None,
    *,
    L: npt.ArrayLike | None = None,
    A: npt.ArrayLike | None = None,
    sectors: Sequence[Mapping[str, Any]] | None = None,
    region: Region | None = None,
    max_gain: float | None = None,
    noise: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Copy of a nonlinear plant with a gain for all nonlinearities within sectors (Thau, Rajamani, circle criterion).

    Parameters
    ----------
    plant : Plant
        The plant, in continuous time.
    decay_rate : float, optional
        Decay rate to be certified (default 0).
    L : array_like, (n, p), optional
        A given gain, which is analysed.
    A : array_like, (n, n), optional
        The linear part; the sectors are the rest of f. Default: both are computed from the Jacobians over the region.
    sectors : sequence of dict, optional
        Nonlinearities `G phi(t, H x, u)`, each with `G`, `H`, `low` and `high`, the bounds of the slope.
    region, max_gain, noise, xhat0, name : optional
        As for `lpv_observer`.

    Returns
    -------
    Observer

    Examples
    --------
    >>> import luenberger
    >>> pendulum = luenberger.plant(["w", "-sin(a) - 0.1*w"], ["a"], states=["a", "w"])
    >>> luenberger.lipschitz_observer(pendulum, decay_rate=0.5).verdict
    'proved'
    """
    plant = any_plant(plant)
    spec: dict[str, Any] = {"kind": "lipschitz", **_region(plant, region), **_limits(max_gain, noise, plant.noutputs)}
    if decay_rate is not None:
        spec["decay_rate"] = number("decay_rate", decay_rate)
    if L is not None:
        spec["gain"] = rows(matrix("L", L, plant.nstates, plant.noutputs))
    if A is not None:
        spec["a"] = rows(matrix("A", A, plant.nstates, plant.nstates))
    if sectors is not None:
        spec["sectors"] = [_sector(sector, plant.nstates) for sector in sectors]
    return Observer(plant, spec, xhat0=xhat0, name=name)


def _sector(sector: Mapping[str, Any], n: int) -> dict[str, Any]:
    missing, unknown = {"G", "H", "low", "high"} - set(sector), set(sector) - {"G", "H", "low", "high"}
    if missing or unknown:
        said = f"needs {', '.join(sorted(missing))}" if missing else f"has no {', '.join(sorted(map(str, unknown)))}"
        raise InvalidArgument(f"a sector {said}", hint="G, H, low, high")
    return {
        "g": rows(matrix("G", sector["G"], rows=n)),
        "h": rows(matrix("H", sector["H"], columns=n, vector="row")),
        "low": number("low", sector["low"]),
        "high": number("high", sector["high"]),
    }


def mean_value_observer(
    plant: Any,
    decay_rate: float | None = None,
    *,
    eta: float | None = None,
    internal_error: npt.ArrayLike | None = None,
    region: Region | None = None,
    max_gain: float | None = None,
    noise: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Mean-value-theorem observer, with output injection, for plants whose outputs are their first states.

    Parameters
    ----------
    plant : Plant
        The plant, in continuous time.
    decay_rate : float, optional
        Decay rate to be certified (default 0).
    eta : float, optional
        Gain of the internal error (default 1).
    internal_error : array_like, (n,), optional
        Initial internal error, an estimate of x(0) - xhat(0) (default 0).
    region, max_gain, noise, xhat0, name : optional
        As for `lpv_observer`.

    Returns
    -------
    Observer

    Examples
    --------
    >>> import luenberger
    >>> pendulum = luenberger.plant(["w", "-sin(a) - 0.1*w"], ["a"], states=["a", "w"])
    >>> luenberger.mean_value_observer(pendulum, decay_rate=0.5).verdict
    'proved'
    """
    plant = any_plant(plant)
    spec: dict[str, Any] = {"kind": "mean-value", **_region(plant, region), **_limits(max_gain, noise, plant.noutputs)}
    for key, value in (("decay_rate", decay_rate), ("eta", eta)):
        if value is not None:
            spec[key] = number(key, value)
    if internal_error is not None:
        spec["internal_error"] = vector("internal_error", internal_error, plant.nstates).tolist()
    return Observer(plant, spec, xhat0=xhat0, name=name)


def high_gain_observer(
    plant: Any,
    r: float,
    *,
    chains: Sequence[int] | None = None,
    alpha: npt.ArrayLike | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Copy of a plant in triangular form with the gains `alpha_i / r^i` along chains that begin at the outputs.

    Parameters
    ----------
    plant : Plant
        The plant, in continuous time.
    r : float
        The high-gain parameter, small and positive.
    chains : sequence of int, optional
        Length of the chain of each output; they add to n (default with one output: n).
    alpha : array_like, (n,), optional
        Coefficients (default: those of `(s + 1)^length` for each chain).
    xhat0, name : optional
        As for `place_observer`.

    Returns
    -------
    Observer

    Examples
    --------
    >>> import luenberger
    >>> pendulum = luenberger.plant(["w", "-sin(a) - 0.1*w"], ["a"], states=["a", "w"])
    >>> run = luenberger.high_gain_observer(pendulum, r=0.1).simulate([1, 0], 5)
    >>> bool(abs(run.error[:, -1]).max() < 1e-6)
    True
    """
    plant = any_plant(plant)
    spec: dict[str, Any] = {"kind": "high-gain", "r": number("r", r, positive=True)}
    if chains is not None:
        spec["chains"] = [count("a length of chains", length) for length in chains]
    if alpha is not None:
        spec["alpha"] = vector("alpha", alpha, plant.nstates).tolist()
    return Observer(plant, spec, xhat0=xhat0, name=name)


def ekf(
    plant: Any,
    QN: npt.ArrayLike,
    RN: npt.ArrayLike,
    dt: float | None = None,
    *,
    P0: npt.ArrayLike | None = None,
    substeps: int | None = None,
    gate: float | None = None,
    iterations: int | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Extended Kalman filter with sampled measurements.

    Parameters
    ----------
    plant : Plant
        The plant, in continuous or discrete time.
    QN : array_like, (n, n)
        Process noise of the states: in continuous time its intensity, in discrete time its covariance per sample.
        A matrix, its diagonal, or a number times the identity.
    RN : array_like, (p, p)
        Covariance of the measurement noise at a sample, likewise.
    dt : float, optional
        The sampling period; that of a plant in discrete time is its own.
    P0 : array_like, (n, n), optional
        Covariance of the initial error, likewise (default the identity).
    substeps : int, optional
        Runge-Kutta steps per period (default 4).
    gate : float, optional
        Outputs whose innovation is beyond this many standard deviations are rejected (default none).
    iterations : int, optional
        The iterated filter: each measurement is linearised this many times, where its update leads (default once).
    xhat0, name : optional
        As for `place_observer`.

    Returns
    -------
    Observer

    Examples
    --------
    >>> import luenberger
    >>> pendulum = luenberger.plant(["w", "-sin(a) - 0.1*w"], ["a"], states=["a", "w"])
    >>> run = luenberger.ekf(pendulum, QN=1e-4, RN=1e-2, dt=0.05).simulate([1, 0], 10, noise=0.1)
    >>> bool(abs(run.error[:, -1]).max() < 0.3), run.deviation.shape
    (True, (2, 201))
    """
    plant = any_plant(plant)
    step = plant.dt if dt is None else number("dt", dt, positive=True)
    if step is None:
        raise InvalidArgument("dt is needed for a plant in continuous time")
    spec: dict[str, Any] = {
        "kind": "extended-kalman" if iterations is None else "iterated-extended-kalman",
        "w": rows(weight("QN", QN, plant.nstates)),
        "v": rows(weight("RN", RN, plant.noutputs)),
        "period": step,
    }
    if P0 is not None:
        spec["p0"] = rows(weight("P0", P0, plant.nstates))
    if substeps is not None:
        spec["substeps"] = count("substeps", substeps)
    if gate is not None:
        spec["gate"] = number("gate", gate, positive=True)
    if iterations is not None:
        spec["iterations"] = count("iterations", iterations)
    names = {"W": "QN", "V": "RN", "P(0)": "P0"}
    return Observer(plant, spec, xhat0=xhat0, name=name, covariances=names)


def kkl_observer(
    plant: Any,
    cutoff: float | None = None,
    domain: Region | None = None,
    *,
    escape: float | None = None,
    points: int | None = None,
    leaves: int | None = None,
    degree: int | None = None,
    samples: int | None = None,
    form: str | None = None,
    inputs: npt.ArrayLike | None = None,
    nodes: int | None = None,
    rank: int | None = None,
    xhat0: npt.ArrayLike | None = None,
    name: str | None = None,
) -> Observer:
    """Numerical Kazantzis-Kravaris-Luenberger observer, for plants with one output.

    The plant has 2 to 6 states, or 2 or 3 states and inputs that are held at constant values. The transformation is
    computed by simulation, which takes minutes for three states or more; Ctrl-C ends it. Its errors are measured, not
    proved.

    Parameters
    ----------
    plant : Plant
        The plant, in continuous time.
    cutoff : float, optional
        Cutoff frequency of the filter `z' = D z + B y` (default: the slowest of six that is accurate on a coarse
        table).
    domain : dict or sequence, optional
        Finite bounds of the states (default: the region of the plant).
    escape : float, optional
        Width of the layer around the domain in which the plant is slowed down, for plants that are unbounded backward
        in time (default: one half-width if a trajectory escapes, else none).
    points, leaves, degree, samples : int, optional
        Grid points per axis; leaves and degree of the tree of polynomials; samples of the fit.
    form : {'interpolated', 'embedded'}, optional
        The left inverse to run.
    inputs : array_like, optional
        Range of each input, pairs (lower, upper): needed for a plant with inputs.
    nodes : int, optional
        Values of each input for which there is a table (default 5).
    rank : int, optional
        Largest rank of the table for five or six states, up to 32 (default 24).
    xhat0, name : optional
        As for `place_observer`.

    Returns
    -------
    Observer

    Examples
    --------
    >>> import luenberger
    >>> duffing = luenberger.plant(["x2^3", "-x1"], ["x1"], region=[(-1, 1), (-1, 1)])
    >>> observer = luenberger.kkl_observer(duffing, cutoff=3.0, points=9, samples=400)
    >>> observer.verdict
    'measured'
    """
    plant = any_plant(plant)
    region = plant.region if domain is None and isinstance(plant, Plant) else domain
    if region is None:
        raise InvalidArgument("domain is needed: finite bounds of the states")
    spec: dict[str, Any] = {
        "kind": "kkl-numerical",
        "domain": bounds(plant, region)["states"],
        "form": form,
    }
    if cutoff is not None:
        spec["cutoff"] = number("cutoff", cutoff, positive=True)
    if escape is not None:
        spec["escape"] = number("escape", escape, positive=True)
    if inputs is not None:
        spec["inputs"] = rows(inputs)
    counts = {"points": points, "leaves": leaves, "degree": degree, "samples": samples, "nodes": nodes, "rank": rank}
    for key, value in counts.items():
        if value is not None:
            spec[key] = count(key, value)
    return Observer(plant, spec, xhat0=xhat0, name=name)
