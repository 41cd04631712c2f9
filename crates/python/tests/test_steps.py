"""One sample at a time: what a step takes, its two halves, and copies of an observer on its way."""

import copy
import math
import pickle

import luenberger as lg
import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from scipy.stats import multivariate_normal

SYS = ([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])


def of_two_outputs():
    """An extended filter of a swinging mass, whose angle and rate are measured."""
    plant = lg.plant(["x1 + 0.1*x2", "x2 - 0.1*sin(x1) + 0.1*u1"], ["x1", "x2"], inputs=["u1"], dt=0.1)
    return lg.ekf(plant, QN=[1e-3, 2e-3], RN=[0.01, 0.04], P0=[0.5, 2.0], xhat0=[0.3, 0.0])


@pytest.mark.parametrize(
    "u, y",
    [
        (0.5, [1.0, -2.0]),
        ([0.5], (1.0, -2.0)),
        (np.array([0.5]), np.array([1.0, -2.0])),
        (np.float32(0.5), np.array([1, -2])),
        (np.array([[0.5]]), np.array([[1.0], [-2.0]])),
        (np.array([0.5, 7.0])[::2], np.array([1.0, 7.0, -2.0])[::2]),
    ],
)
def test_columns_of_all_kinds_give_the_same_bits(u, y):
    observer, reference = of_two_outputs(), of_two_outputs()
    for _ in range(3):
        found = np.ravel(observer.step(u, y))
        expected = reference.step(np.array([[0.5]]), np.array([[1.0], [-2.0]]))[:, 0]
        assert found.tolist() == expected.tolist()


@pytest.mark.parametrize("y", ["a", [1.0], [1.0, 2.0, 3.0], None, [[1.0, 2.0]], [1.0, "a"], [1.0, 1j]])
def test_a_column_that_is_none_is_an_error_or_missing(y):
    observer = of_two_outputs()
    observer.step(0.0, [0.0, 0.0])
    if y is None:
        assert np.isfinite(observer.step(0.0, y)).all()
        return
    before = observer.xhat
    with pytest.raises((lg.DimensionMismatch, lg.WrongDtype, lg.InvalidArgument)):
        observer.step(0.0, y)
    with pytest.raises(lg.NotFinite):
        observer.step(math.nan, [0.0, 0.0])
    assert observer.xhat.tolist() == before.tolist()


def test_a_missing_output_is_not_used_by_a_filter():
    observer = of_two_outputs()
    x, P = np.array([0.3, 0.0]), np.diag([0.5, 2.0])
    Q, R = np.diag([1e-3, 2e-3]), np.diag([0.01, 0.04])
    rng = np.random.default_rng(5)
    for k in range(40):
        u, y = rng.standard_normal(), 0.3 * rng.standard_normal(2)
        used = [[0, 1], [0], [1], []][k % 4]
        given = np.full(2, np.nan)
        given[used] = y[used]
        found = observer.step(u, given if used else None)
        H = np.eye(2)[used]
        S = H @ P @ H.T + R[np.ix_(used, used)]
        K = P @ H.T @ np.linalg.inv(S)
        x, P = x + K @ (y[used] - H @ x), P - K @ H @ P
        F = np.array([[1, 0.1], [-0.1 * np.cos(x[0]), 1]])
        x, P = np.array([x[0] + 0.1 * x[1], x[1] - 0.1 * np.sin(x[0]) + 0.1 * u]), F @ P @ F.T + Q
        np.testing.assert_allclose(found, x, rtol=1e-9, atol=1e-11)
        np.testing.assert_allclose(observer.P, P, rtol=1e-9, atol=1e-12)


def test_a_constant_gain_leaves_a_missing_output_out():
    observer = lg.place_observer(SYS, [-4, -5], xhat0=[0.5, 0.2])
    observer.reset(dt=0.1)
    A, B = np.array([[1, 0.1], [0, 1]]), np.array([0.005, 0.1])
    xhat = observer.xhat
    L = (observer.step(0.0, 1.5) - A @ xhat) / (1.5 - xhat[0])
    xhat = observer.xhat
    for k, y in enumerate([0.3, math.nan, math.nan, -0.2, math.nan]):
        xhat = A @ xhat + B * k + L * (0.0 if math.isnan(y) else y - xhat[0])
        np.testing.assert_allclose(observer.step(float(k), y), xhat, rtol=1e-12, atol=1e-14)
    together = lg.place_observer(SYS, [-4, -5], xhat0=[0.5, 0.2])
    together.reset(dt=0.1)
    y = np.array([[1.5, 0.3, math.nan, math.nan, -0.2, math.nan]])
    found = together.step(np.array([[0.0, 0.0, 1.0, 2.0, 3.0, 4.0]]), y)
    assert found[:, -1].tolist() == observer.xhat.tolist()


def test_one_of_two_outputs_corrects_with_its_column_of_the_gain():
    A, C = np.array([[0.9, 0.1], [-0.1, 0.8]]), np.array([[1.0, 0.2], [0.0, 1.0]])
    observer = lg.place_observer((A, [[0.0], [0.0]], C, None, 0.1), [0.3, 0.4], xhat0=[0.5, 0.2])
    L = np.asarray(observer.L)
    xhat = observer.xhat
    for y in ([math.nan, 0.3], [0.1, math.nan], [math.nan, math.nan], [0.2, 0.1]):
        nu = np.nan_to_num(np.asarray(y) - C @ xhat, nan=0.0)
        xhat = A @ xhat + L @ nu
        np.testing.assert_allclose(observer.step(0.0, y), xhat, rtol=1e-12, atol=1e-14)


def test_without_an_output_a_step_at_varying_periods_is_a_prediction():
    observer = lg.sampled_cubic_observer(SYS, [-1, -2], gamma=0.1, dt=0.1, jitter=[0.08, 0.12])
    x = observer.step(0.0, 1.0, dt=0.1)
    expected = [x[0] + 0.1 * x[1] + 0.5 * 0.1**2 * 2.0, x[1] + 0.1 * 2.0]
    np.testing.assert_allclose(observer.step(2.0, math.nan, dt=0.1), expected, rtol=1e-12)


def test_update_and_prediction_are_those_of_filterpy():
    observer = of_two_outputs()
    reference = ExtendedKalmanFilter(2, 2, 1)
    reference.x, reference.P = np.array([[0.3], [0.0]]), np.diag([0.5, 2.0])
    reference.Q, reference.R = np.diag([1e-3, 2e-3]), np.diag([0.01, 0.04])
    rng = np.random.default_rng(3)
    for _ in range(20):
        u, y = rng.standard_normal(1), 0.3 * rng.standard_normal(2)
        before, S = reference.x.ravel(), reference.P + reference.R
        reference.update(y.reshape(2, 1), lambda x: np.eye(2), lambda x: x)
        np.testing.assert_allclose(observer.update(y, u), reference.x.ravel(), rtol=1e-9)
        np.testing.assert_allclose(observer.xhat, reference.x.ravel(), rtol=1e-9)
        np.testing.assert_allclose(observer.P, reference.P, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(observer.innovation, y - before, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(observer.S, S, rtol=1e-9)
        assert math.isclose(observer.nis, (y - before) @ np.linalg.solve(S, y - before), rel_tol=1e-9)
        logarithm = multivariate_normal(before, S).logpdf(y)
        assert math.isclose(observer.log_likelihood, logarithm, rel_tol=1e-9)
        x = reference.x.ravel()
        F = np.array([[1, 0.1], [-0.1 * np.cos(x[0]), 1]])
        reference.x = np.array([[x[0] + 0.1 * x[1]], [x[1] - 0.1 * np.sin(x[0]) + 0.1 * u[0]]])
        reference.P = F @ reference.P @ F.T + reference.Q
        np.testing.assert_allclose(observer.predict(u), reference.x.ravel(), rtol=1e-9)
        np.testing.assert_allclose(observer.P, reference.P, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("kind", ["extended-kalman", "ukf"])
def test_the_halves_are_the_step(kind):
    plant = lg.plant(["x2", "-sin(x1) + u1"], ["x1"], inputs=["u1"])
    pair = [lg.observer(kind, plant, w=[1e-3, 1e-3], v=[0.01], period=0.1) for _ in range(2)]
    for k in range(10):
        y, u = math.sin(k), math.cos(k)
        whole = pair[0].step(u, y)
        pair[1].update(y, u)
        # Two sensors at one time: the second one has nothing.
        pair[1].update(None, u)
        assert pair[1].predict(u).tolist() == whole.tolist()
        assert pair[0].P.tolist() == pair[1].P.tolist()


def test_the_likelihood_counts_the_outputs_that_were_used():
    observer = of_two_outputs()
    with pytest.raises(lg.Unavailable, match="not stepped yet"):
        _ = observer.innovation
    observer.update([math.nan, 0.5])
    assert math.isclose(observer.log_likelihood, multivariate_normal(0.0, 2.04).logpdf(0.5), rel_tol=1e-12)
    assert observer.innovation.tolist() == [0.0, 0.5]
    observer.update(None)
    assert math.isnan(observer.nis) and math.isnan(observer.log_likelihood)
    assert np.isnan(observer.innovation).tolist() == [True, True] and np.isnan(observer.S).all()


def test_only_filters_have_halves():
    observer = lg.place_observer(SYS, [-4, -5])
    observer.reset(dt=0.1)
    for of in (lambda: observer.update(1.0), lambda: observer.predict(), lambda: observer.nis):
        with pytest.raises(lg.NotApplicable, match="as extended-kalman and ukf are"):
            of()
    np.testing.assert_array_equal(observer.P, observer.matrices["P"])


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
@pytest.mark.parametrize("make", [of_two_outputs, lambda: lg.place_observer(SYS, [-4, -5], name="servo")])
def test_a_copy_goes_on_from_where_the_observer_is(make, again):
    observer = make()
    fresh = again(observer)
    assert fresh.name == observer.name and fresh.statement == observer.statement
    outputs = observer.plant.noutputs
    observer.reset(dt=0.1)
    for k in range(5):
        observer.step(0.1 * k, np.full(outputs, 0.3 * k))
    other = again(observer)
    assert other.xhat.tolist() == observer.xhat.tolist()
    expected = [observer.step(1.0, np.full(outputs, 0.1 * k)).tolist() for k in range(5)]
    assert [other.step(1.0, np.full(outputs, 0.1 * k)).tolist() for k in range(5)] == expected


def test_what_is_proved_cannot_be_changed_in_place():
    observer = lg.place_observer(SYS, [-4, -5])
    with pytest.raises(ValueError, match="read-only"):
        observer.L[0, 0] = 1.0
    assert not any(matrix.flags.writeable for matrix in observer.matrices.values())


def models_alike():
    keys = {"w": 0.01, "v": 0.01, "period": 0.1, "transitions": [[0.9, 0.1], [0.1, 0.9]]}
    return lg.observer("imm", lg.ss([[0.9, 0.1], [0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1), models=[{}, {}], **keys)


def stiff():
    """A sensor with a time constant of half a millisecond: a period of 1 would be thousands of Runge-Kutta steps."""
    return lg.ekf(lg.plant(["-2000*(x1 - sin(x2))", "-0.1*x2"], ["x1"]), QN=1e-4, RN=1e-4, dt=1.0, xhat0=[0.8, 1.0])


def cloud():
    plant = lg.ss([[0.9, 0.1], [0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1)
    return lg.observer("particle", plant, w=0.01, v=0.01, period=0.1, particles=50)


@pytest.mark.parametrize("make", [models_alike, stiff, cloud])
def test_a_filter_without_exported_code_steps_as_it_replays(make):
    y = 0.9 + 0.1 * np.random.default_rng(8).standard_normal(12)
    t = np.arange(y.size) * make().dt
    run = make().replay(t, y)
    observer, half = make(), make()
    updated = []
    for value in y:
        updated.append(half.update(value))
        assert half.P.shape == (observer.plant.nstates,) * 2
        half.predict()
        observer.step(None, value)
        assert np.isfinite(observer.nis)
        assert observer.xhat.tolist() == half.xhat.tolist()
    assert np.allclose(np.array(updated).T, run.xhat, rtol=1e-6, atol=1e-9)
    again = pickle.loads(pickle.dumps(observer))
    assert again.step(None, 1.0).tolist() == observer.step(None, 1.0).tolist()
    with pytest.raises(lg.NotApplicable, match="covariance of the innovation"):
        observer.S
    with pytest.raises(lg.ExportRefused, match="cannot be exported"):
        make().export(dt=observer.dt)


def test_a_missing_measurement_of_such_a_filter_is_a_prediction():
    missing, predicted = models_alike(), models_alike()
    for observer in (missing, predicted):
        observer.step(None, 1.0)
    assert missing.step(None, None).tolist() == predicted.predict().tolist()


def test_a_disturbance_observer_starts_at_an_estimate():
    plant = lg.ss([[0.9, 0.1], [0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1)
    observer = lg.observer("extended-state", plant, e=[[0], [1]], order=1, poles=[0.3, 0.4, 0.5])
    observer.reset([1.0, 2.0])
    assert observer.xhat.tolist() == [1.0, 2.0, 0.0]


def test_a_functional_observer_starts_at_an_estimate():
    plant = lg.ss([[0.9, 0.1], [0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1)
    keys = {"k": [[0, 1]], "poles": [0.3]}
    started, designed = lg.observer("functional", plant, **keys), lg.observer("functional", plant, xhat0=[1, 2], **keys)
    started.reset([1.0, 2.0])
    assert started.xhat.tolist() == designed.xhat.tolist() == [2.0]
    again = pickle.loads(pickle.dumps(started))
    for y in (1.0, 0.5):
        expected = designed.step(1.0, y).tolist()
        assert started.step(1.0, y).tolist() == expected
        assert again.step(1.0, y).tolist() == expected
    # It knows the state: T x is the state of the observer, and z is exact.
    exact = lg.observer("functional", plant, xhat0=[1, 2], **keys)
    assert abs(exact.step(0.0, 1.0)[0] - 2.0) < 1e-12


def test_an_observer_without_a_step_says_so():
    observer = lg.observer("functional", SYS, k=[[0, 1]], poles=[-3])
    with pytest.raises(lg.ExportRefused, match="cannot be stepped") as found:
        observer.step(0.0, 1.0, dt=0.1)
    assert "exported" not in str(found.value).split(":")[0]


@pytest.mark.parametrize(
    "u, y",
    [
        (1, [1, -2]),
        (True, [True, False]),
        (np.array([1]), np.array([1, -2])),
        (np.float32([0.5]), np.float32([1.0, -2.0])),
        (0, [1.0, math.nan]),
        (0, np.array([math.nan, 1.0])),
        (0, None),
    ],
)
def test_whole_numbers_float32_and_missing_samples_take_the_short_way(u, y):
    observer, reference = of_two_outputs(), of_two_outputs()
    observer.step(0.0, [0.0, 0.0])
    reference.step(0.0, [0.0, 0.0])
    found = observer._stepper.step(u, y)
    assert found is not None
    values = [math.nan, math.nan] if y is None else np.asarray(y, dtype=float)
    expected = reference.step(np.float64(np.ravel(u)).reshape(1, 1), np.reshape(values, (2, 1)))[:, 0]
    assert found.tolist() == expected.tolist()


def test_a_masked_array_does_not_take_the_short_way():
    observer = of_two_outputs()
    observer.step(0.0, [0.0, 0.0])
    assert observer._stepper.step(0.0, np.ma.array([1.0, 2.0], mask=[True, False])) is None
