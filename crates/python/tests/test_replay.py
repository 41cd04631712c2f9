"""What a run on a log uses of it, and says of what it does not use."""

import warnings

import luenberger as lg
import numpy as np
import pytest

SYS = lg.ss([[0.9, 0.1], [0.0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1)


def kalman(rows, q, r, p0=1.0):
    """The predictions of a Kalman filter of SYS by these rows, written out."""
    A, C = np.asarray(SYS.A), np.asarray(SYS.C)
    x, P = np.zeros(2), p0 * np.eye(2)
    found = []
    for y in rows:
        K = P @ C.T / (C @ P @ C.T + r)
        x, P = x + K[:, 0] * (y - C @ x), (np.eye(2) - K @ C) @ P
        found.append(x)
        x, P = A @ x, A @ P @ A.T + q * np.eye(2)
    return np.array(found).T


def test_rows_off_the_samples_are_said_to_be_unused():
    plant = lg.ss([[0.98]], None, [[1]], dt=0.1)
    observer = lg.ekf(plant, 0.1, 0.1, 0.1)
    t = np.arange(100) * 0.1
    t[1::2] += 0.004
    y = np.random.default_rng(1).standard_normal(100)
    with pytest.warns(lg.LogWarning, match="Only 50 of 100 rows lie on the observer's samples"):
        run = observer.replay(t, y)
    assert np.isfinite(run.y).sum() == 50
    assert any("Only 50 of 100 rows" in text for text in run.warnings)
    assert "Only 50 of 100 rows" in run._repr_html_()


def test_rows_at_twice_the_rate_are_said_to_be_unused():
    observer = lg.place_observer(SYS, [0.3, 0.4])
    y = np.random.default_rng(2).standard_normal(300)
    with pytest.warns(lg.LogWarning, match="Only 150 of 300 rows"):
        observer.replay(np.arange(300) * 0.05, y)


def repeated():
    values = np.cumsum(np.random.default_rng(3).standard_normal(30) * 0.1)
    return np.arange(300) * 0.1, np.repeat(values, 10)


def test_repeated_values_count_once_and_are_said_to():
    t, y = repeated()
    observer = lg.ekf(SYS, 0.001, 0.01, 0.1)
    with pytest.warns(lg.LogWarning, match=r'30 measurements that the logger repeats.*repeats="measured"'):
        run = observer.replay(t, y)
    assert np.isfinite(run.y).sum() == 30


def test_every_row_is_a_measurement_where_that_is_said():
    t, y = repeated()
    observer = lg.ekf(SYS, 0.001, 0.01, 0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lg.LogWarning)
        run = observer.replay(t, y, repeats="measured")
    assert np.isfinite(run.y).all()
    assert not any("repeats" in text for text in run.warnings)
    w = 0.001 if SYS.dt is None else float(observer.matrices["W"][0, 0])
    assert abs(run.xhat - kalman(y, w, 0.01)).max() < 1e-12


def test_between_rows_a_measurement_is_held_or_moves():
    observer = lg.place_observer(([[0, 1], [0, 0]], None, [[1, 0]]), [-2, -5])
    t = np.linspace(0, 8, 81)
    runs = {way: observer.replay(t, 3 * t, interpolation=way) for way in ("predicted", "held")}
    with pytest.warns(lg.LogWarning, match="later measurements"):
        runs["linear"] = observer.replay(t, 3 * t, interpolation="linear")
    error = {way: abs(run.xhat[0, -1] - 24.0) for way, run in runs.items()}
    # Held by 0.1 s a ramp of slope 3 is late by 0.15 on average.
    assert error["predicted"] < 0.01 and error["linear"] < 0.01 and 0.1 < error["held"] < 0.2


def test_data_without_fault_has_no_warning():
    observer = lg.ekf(SYS, 0.001, 0.01, 0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = observer.replay(np.arange(50) * 0.1, 1 + np.sin(0.3 * np.arange(50.0)))
    assert run.warnings == []


@pytest.mark.parametrize("key, value", [("repeats", "twice"), ("interpolation", "spline"), ("repeats", None)])
def test_an_unknown_choice_is_an_error(key, value):
    observer = lg.place_observer(SYS, [0.3, 0.4])
    with pytest.raises(lg.InvalidArgument, match=key):
        observer.replay([0.0, 0.1], [0.0, 1.0], **{key: value})


def test_times_that_do_not_increase_are_named_by_the_argument():
    observer = lg.place_observer(SYS, [0.3, 0.4])
    with pytest.raises(lg.InvalidArgument, match=r"^t must increase, and entry 2 is 0.1 after 0.1$"):
        observer.replay([0.0, 0.1, 0.1], [0.0, 1.0, 2.0])
    with pytest.raises(lg.InvalidArgument, match="the times of u must increase"):
        observer.simulate([1, 0], 1, u=([0.0, 0.5, 0.4], np.zeros((1, 3))))


def test_names_of_columns_may_be_those_of_other_columns():
    plant = lg.plant(["-x1 + u1"], ["x1", "2*x1"], states=["x1"], inputs=["u1"], outputs=["x1", "y"])
    observer = lg.ekf(plant, 0.1, 0.1, 0.1)
    rng = np.random.default_rng(5)
    run = observer.replay(np.arange(20) * 0.1, rng.standard_normal((2, 20)), u=np.zeros((1, 20)))
    assert np.isfinite(run.xhat).all()
