"""Arguments as users of numpy, pandas and python-control give them, and what becomes of their arrays."""

import copy
import inspect
import math
import pickle

import control
import numpy as np
import pytest
import scipy.linalg

import luenberger as lg

SYS = lg.ss([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
DISCRETE = lg.ss([[0.9, 0.1], [0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1)
COPIES = [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))]


def test_a_plant_is_not_changed_by_the_array_that_it_was_made_from():
    A, B = np.array([[0.0, 1.0], [-2.0, -3.0]]), np.array([[0.0], [1.0]])
    C, D = np.array([[1.0, 0.0]]), np.zeros((1, 1))
    observer = lg.place_observer(lg.ss(A, B, C, D), [-4, -5])
    before = observer.certificate.to_json()
    A[1, 0], B[0, 0], C[0, 1], D[0, 0] = -200.0, 7.0, 7.0, 7.0
    other = copy.copy(observer)
    assert other.certificate.to_json() == before and other.poles.tolist() == observer.poles.tolist()
    assert observer.step(1.0, 1.0, dt=0.1).tolist() == other.step(1.0, 1.0, dt=0.1).tolist()
    with pytest.raises(ValueError, match="read-only"):
        observer.plant.A[0, 0] = 1.0
    # A copy of a system of another package, too.
    theirs = control.ss([[-1.0]], [[1.0]], [[1.0]], [[0.0]])
    mine = lg.certify(theirs, [[1.0]])
    theirs.A[0, 0] = 5.0
    assert mine.plant.A.tolist() == [[-1.0]]


def test_a_start_and_a_region_are_copies():
    observer, start = lg.place_observer(DISCRETE, [0.1, 0.2]), np.array([1.0, 2.0])
    observer.reset(start)
    start[:] = 0.0
    assert copy.copy(observer).xhat.tolist() == observer.xhat.tolist() == [1.0, 2.0]
    region = {"x1": [-1.0, 1.0]}
    plant = lg.plant(["-x1^3"], ["x1"], region=region)
    region["x1"][1] = 9.0
    assert plant.region == {"x1": [-1.0, 1.0]}


@pytest.mark.parametrize("again", [lambda one: one, *COPIES])
def test_what_is_proved_cannot_be_changed_in_copies(again):
    nonlinear = lg.plant(["x2", "-sin(x1) + u1"], ["x1"], inputs=1)
    for one in [
        lg.place_observer(SYS, [-4, -5]),
        lg.dlqe(DISCRETE, 1.0, 1.0),
        lg.ekf(DISCRETE, 1.0, 1.0),
        lg.place_observer(nonlinear.at([0, 0]), [-4, -5]),
    ]:
        other = again(one)
        arrays = [value for value in vars(other.plant).values() if isinstance(value, np.ndarray)]
        for array in [*other.matrices.values(), *arrays]:
            assert not array.flags.writeable
        assert {"A", "B", "C", "D"} <= set(vars(other.plant)) and other.matrices
        other.xhat[0] = 3.0
        assert other.xhat.tolist() == one.xhat.tolist()


def test_a_masked_entry_is_a_missing_measurement():
    masked = np.ma.array([1e6], mask=[True])
    pair = [lg.ekf(DISCRETE, 0.1, 0.1) for _ in range(2)]
    for observer, y in zip(pair, [masked, np.nan]):
        observer.step(0.0, 1.0)
        observer.step(0.3, y)
        observer.update(y)
    assert pair[0].xhat.tolist() == pair[1].xhat.tolist()
    t = np.arange(20) * 0.1
    y = np.ma.array(np.sin(t)[None], mask=False)
    y.mask[0, 5:8] = True
    y.data[0, 5:8] = 1e6
    found = pair[0].replay(t, y).xhat
    assert found.tolist() == pair[0].replay(t, np.where(y.mask, np.nan, y.data)).xhat.tolist() and abs(found).max() < 10
    for wrong in (lambda: pair[0].step(masked, 1.0), lambda: lg.ss(np.ma.array([[1.0]], mask=[[True]]), None, [[1]])):
        with pytest.raises(lg.InvalidArgument, match="masked"):
            wrong()
    assert lg.ss(np.ma.array([[-1.0]]), None, [[1]]).A.tolist() == [[-1.0]]
    fixed = lg.place_observer(SYS, [-4, -5])
    fixed.reset(dt=0.1)
    with pytest.raises(lg.InvalidArgument, match="masked"):
        fixed.step(masked, 1.0)


def test_a_missing_value_of_pandas_is_a_missing_measurement():
    pandas = pytest.importorskip("pandas")
    t = np.arange(20) * 0.1
    y = pandas.Series(np.sin(t), dtype="Float64")
    y[4] = pandas.NA
    observer = lg.ekf(DISCRETE, 0.1, 0.1)
    expected = np.sin(t)
    expected[4] = np.nan
    assert observer.replay(t, y).xhat.tolist() == observer.replay(t, expected).xhat.tolist()
    pair = [lg.ekf(lg.ss(DISCRETE.A, None, np.eye(2), dt=0.1), 0.1, 0.1) for _ in range(2)]
    for given, same in [([1.0, None], [1.0, np.nan]), ([pandas.NA, 2.0], [np.nan, 2.0])]:
        assert pair[0].step(None, given).tolist() == pair[1].step(None, same).tolist()
    with pytest.raises(lg.InvalidArgument, match="nan|missing"):
        observer.replay(t, np.sin(t), u=y)
    with pytest.raises(lg.InvalidArgument, match="u has a missing entry"):
        observer.step([pandas.NA], 1.0)
    with pytest.raises(lg.WrongDtype):
        observer.replay(t, np.array([object()] * 20))


def test_weights_of_continuous_time_are_refused_in_discrete_time():
    for more in ({"rho": 3.0}, {"Q": np.eye(2)}):
        with pytest.raises(lg.InvalidArgument, match="continuous time"):
            lg.lqe(DISCRETE, 1.0, 1.0, **more)


def test_an_intensity_is_symmetric_whatever_enters_with_it():
    A, C = -np.eye(3), np.eye(3)[:1]
    for G in (np.ones((3, 2)), [[1, 0], [0, 1], [0, 0]]):
        with pytest.raises(lg.NotSymmetric, match="QN") as found:
            lg.lqe(A, G, C, [[1, 5], [0, 1]], 1)
    # The numbers of the message of the designs themselves, for the same matrix.
    with pytest.raises(lg.NotSymmetric) as of_design:
        lg.observer("kalman", lg.ss(-np.eye(2), None, [[1, 0]]), w=[[1, 5], [0, 1]], v=1)
    names = ("row", "column", "asymmetry", "allowed")
    assert [getattr(found.value, name) for name in names] == [getattr(of_design.value, name) for name in names]
    assert str(found.value).startswith("QN is not symmetric: entries (2, 1) and (1, 2) differ by 5 (limit 1.78e-14)")


@pytest.mark.parametrize(
    "call",
    [
        lambda n: lg.place_observer(SYS, [-4, -5]).simulate([1, 0], 1, samples=n),
        lambda n: lg.place_observer(SYS, [-4, -5]).simulate([1, 0], 1, noise=0.1, seed=n),
        lambda n: lg.ekf(SYS, 1, 1, 0.1, substeps=n),
        lambda n: lg.ekf(SYS, 1, 1, 0.1, iterations=n),
        lambda n: lg.sampled_cubic_observer(SYS, [-1, -2], gamma=0.1, dt=0.1, misses=n),
        lambda n: lg.high_gain_observer(SYS, 0.1, chains=[n]),
        lambda n: lg.kkl_observer(lg.plant(["x2", "-x1"], ["x1"]), 3.0, [(-1, 1)] * 2, points=n),
    ],
)
def test_a_count_is_not_cut(call):
    with pytest.raises(lg.InvalidArgument, match="whole number"):
        call(2.9)


def test_counts_of_numpy_are_counts():
    run = lg.place_observer(SYS, [-4, -5]).simulate([1, 0], 1, samples=np.int64(7), noise=0.1, seed=np.uint8(3))
    assert run.t.size == 7
    assert lg.sampled_cubic_observer(SYS, [-1, -2], gamma=0.1, dt=0.1, misses=np.int32(1)).dt == 0.1


def test_poles_in_any_collection():
    expected = lg.place_observer(SYS, [-4, -5]).L
    for poles in ({-4, -5}, (p for p in (-4, -5)), map(float, ["-4", "-5"]), np.array([-4, -5]), range(-5, -3)):
        np.testing.assert_allclose(lg.place_observer(SYS, poles).L, expected, rtol=1e-12, atol=1e-14)


def test_zero_of_any_type_is_continuous_time():
    for dt in (0, 0.0, np.int64(0), np.float32(0), np.array(0.0), None, np.False_):
        assert lg.ss([[-1]], None, [[1]], dt=dt).dt is None


@pytest.mark.parametrize(
    "call, said",
    [
        (lambda o: o.step([0, 0], 1.0), r"u must have 1 entry, and has the shape \(2,\)"),
        (lambda o: o.step(0.0, [1.0, 2.0]), r"y must have 1 entry, and has the shape \(2,\)"),
        (lambda o: o.step(0.0, np.ones((1, 1, 1))), r"y must be 1 x 1"),
        (lambda o: o.simulate([1, 0], 1, noise=[0.1, 0.2]), "noise must have 1"),
        (lambda o: o.simulate([1, 0], 1, noise=0.1, noise_dt=0), "noise_dt must be positive"),
        (lambda o: o.simulate([1, 0], 1, samples=-3), "samples is -3"),
        (lambda o: lg.ss([[-1]], None, [[1]], dt=math.nan), "^dt is nan"),
        (lambda o: lg.place_observer(object(), [-1]), "object is not a linear plant"),
        (lambda o: lg.place_observer(control.tf([1, 0, 0], [1, 1]), [-1]), "no matrices"),
    ],
)
def test_messages_name_the_argument(call, said):
    with pytest.raises(lg.LuenbergerError, match=said):
        call(lg.place_observer(DISCRETE, [0.1, 0.2]))


def test_the_name_of_a_design_is_its_kind():
    for observer in (lg.place_observer(SYS, [-4, -5]), lg.ekf(SYS, 1, 1, 0.1), lg.lqe(SYS, 1, 1)):
        assert observer.name == observer.kind
    assert sorted(lg.lqe(SYS, 1, 1).export(dt=0.1).files)[-2:] == ["kalman.h", "test_kalman.c"]


def test_filters_unpack_as_those_of_python_control():
    A, G, C = [[0.0, 1.0], [-2.0, -3.0]], [[0.0], [1.0]], [[1.0, 0.0]]
    for mine, theirs in [(lg.lqe, control.lqe), (lg.dlqe, control.dlqe)]:
        scaled = np.multiply(A, 0.2)
        L, P, E = mine(scaled, G, C, 2.0, 0.5)
        for found, expected in zip((L, P), theirs(scaled, G, C, 2.0, 0.5)):
            np.testing.assert_allclose(found, expected, rtol=1e-9)
        np.testing.assert_allclose(np.poly(E), np.poly(scaled - L @ C), rtol=1e-9)
        assert pickle.loads(pickle.dumps(mine(scaled, G, C, 2.0, 0.5))).L.tolist() == L.tolist()
    with pytest.raises(TypeError, match="unpack"):
        L, P, E = lg.place_observer(SYS, [-4, -5])


def test_what_an_observer_does_not_have_is_no_attribute():
    window = lg.observer("mhe", SYS, w=1, v=1, period=0.1, window=5)
    for observer in (lg.place_observer(SYS, [-4, -5]), lg.ekf(SYS, 1, 1, 0.1), window):
        for name in ("nis", "innovation", "log_likelihood", "S", "M", "theta"):
            assert not hasattr(observer, name)
            with pytest.raises(lg.Unavailable):
                getattr(observer, name)
        assert getattr(observer, "nis", None) is None and inspect.getmembers(observer)
        assert observer._stepper is None  # reading has not begun to step it
    assert not hasattr(lg.ekf(SYS, 1, 1, 0.1), "certificate")


def test_a_filter_has_its_first_covariance_before_its_first_step():
    observer = lg.ekf(DISCRETE, 0.1, 0.1, P0=[[2.0, 0.1], [0.1, 3.0]])
    assert observer.P.tolist() == [[2.0, 0.1], [0.1, 3.0]]
    observer.reset()
    assert observer.P.tolist() == [[2.0, 0.1], [0.1, 3.0]]
    observer.step(0.0, None)
    assert math.isnan(observer.nis) and math.isnan(observer.log_likelihood)
    observer.step(0.0, 1.0)
    assert math.isfinite(observer.nis) and math.isfinite(observer.log_likelihood)


def test_noises_that_are_correlated():
    A, G, C = np.array([[-0.2, 0.1], [-0.4, -0.6]]), np.array([[0.5], [1.0]]), np.array([[1.0, 0.0]])
    QN, RN, NN = np.array([[2.0]]), np.array([[0.5]]), np.array([[0.3]])
    W, S = G @ QN @ G.T, G @ NN
    P = scipy.linalg.solve_continuous_are(A.T, C.T, W, RN, s=S)
    expected = (P @ C.T + S) / RN
    for observer in (lg.lqe(A, G, C, QN, RN, NN), lg.lqe(lg.ss(A, G, C), QN, RN, NN)):
        np.testing.assert_allclose(observer.L, expected, rtol=1e-9)
        np.testing.assert_allclose(observer.P, P, rtol=1e-9)
    P = scipy.linalg.solve_discrete_are(A.T, C.T, W, RN, s=S)
    expected = (A @ P @ C.T + S) / (C @ P @ C.T + RN)
    observer = lg.dlqe(A, G, C, QN, RN, NN)
    np.testing.assert_allclose(observer.L, expected, rtol=1e-9)
    np.testing.assert_allclose(observer.M, P @ C.T / (C @ P @ C.T + RN), rtol=1e-9)
    with pytest.raises(lg.DimensionMismatch, match="NN"):
        lg.lqe(A, G, C, QN, RN, [[1.0, 2.0]])


@pytest.mark.parametrize(
    "call, said",
    [
        (lambda: lg.cubic_observer(SYS, [-1, -2], G=np.eye(2), gamma=1.0), "G is that of the process noise"),
        (lambda: lg.dlqe(DISCRETE, 1, 1, dt=0.5), "dt is 0.5, and the plant has 0.1"),
        (
            lambda: lg.lipschitz_observer(SYS, 1.0, sectors=[{"G": 1, "H": 1, "low": 0, "high": 1, "lo": 2}]),
            "a sector has no lo",
        ),
    ],
)
def test_no_argument_is_dropped(call, said):
    with pytest.raises(lg.InvalidArgument, match=said):
        call()
    assert lg.dlqe(DISCRETE, 1, 1, dt=0.1).dt == 0.1


def test_results_that_no_memory_holds_are_refused() -> None:
    """The process would end without an exception where an allocation fails."""
    observer = lg.place_observer(lg.ss([[0, 1], [0, 0]], None, [[1, 0]]), [-1, -2])
    with pytest.raises(lg.InvalidArgument, match="samples is 1000000000.*at most 10000000"):
        observer.simulate([1, 0], 1, samples=10**9)
