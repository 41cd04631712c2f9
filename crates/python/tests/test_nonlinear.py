"""Nonlinear plants from expressions, and the observers for them."""

import os
import signal
import threading
import time

import control
import numpy as np
import pytest
import scipy.integrate
from filterpy.kalman import ExtendedKalmanFilter

import luenberger as lg

PENDULUM = lg.plant(
    f=["w", "-k*sin(a) - 0.2*w + u"],
    h=["a"],
    states=["a", "w"],
    inputs=["u"],
    parameters={"k": 2.0},
    region={"a": (-3.2, 3.2), "w": (-5, 5)},
)


def test_a_plant_has_names_and_equations():
    assert (PENDULUM.states, PENDULUM.inputs, PENDULUM.outputs) == (["a", "w"], ["u"], ["y1"])
    assert lg.plant(["x2 + u2", "-x1"], ["x1"]).inputs == ["u1", "u2"]
    assert "a' = w" in repr(PENDULUM)


@pytest.mark.parametrize(
    ("design", "verdict"),
    [
        (lambda: lg.lpv_observer(PENDULUM, decay_rate=1.0), "proved"),
        (lambda: lg.lpv_observer(PENDULUM, fastest=4.0, max_gain=50.0), "proved"),
        (lambda: lg.lpv_observer(PENDULUM, L=[[10.0], [20.0]]), "proved"),
        (lambda: lg.lipschitz_observer(PENDULUM, decay_rate=1.0), "proved"),
        (
            lambda: lg.lipschitz_observer(
                PENDULUM,
                A=[[0, 1], [0, -0.2]],
                sectors=[{"G": [[0], [1]], "H": [[1, 0]], "low": -2.0, "high": 2.0}],
            ),
            "proved",
        ),
        (lambda: lg.mean_value_observer(PENDULUM, decay_rate=1.0), "proved"),
        (lambda: lg.high_gain_observer(PENDULUM, r=0.1), "none"),
        (lambda: lg.ekf(PENDULUM, QN=1e-4, RN=1e-2, dt=0.02), "none"),
        (lambda: lg.ekf(PENDULUM, QN=1e-4, RN=1e-2, dt=0.02, iterations=3), "none"),
    ],
)
def test_every_design_converges_and_runs_everywhere(design, verdict):
    observer = design()
    assert observer.verdict == verdict
    if verdict == "proved":
        assert observer.certificate.is_proved and observer.certificate.verify().facts
    else:
        with pytest.raises(AttributeError, match="no certificate"):
            observer.certificate
    # As the block has them, before the measurement of a sample.
    run = observer.simulate([1.0, -1.0], 12, u="0.5*sin(t)", samples=601, estimates="predicted")
    assert np.abs(run.error[:, -1]).max() < 2e-2

    def motion(t, x):
        return [x[1], -2 * np.sin(x[0]) - 0.2 * x[1] + 0.5 * np.sin(t)]

    if observer.dt is None:
        expected = scipy.integrate.solve_ivp(motion, (0, 12), [1, -1], t_eval=run.t, rtol=1e-10, atol=1e-11)
        np.testing.assert_allclose(run.x, expected.y, atol=1e-6)
    # As a block of python-control, from the outputs of the run.
    block = observer.to_control()
    t, drive = run.t, np.vstack([run.u, run.y])
    found = control.input_output_response(
        block, t, drive, X0=observer.initial_state(), solve_ivp_kwargs={"rtol": 1e-8} if observer.dt is None else {}
    )
    np.testing.assert_allclose(found.outputs, run.xhat, atol=5e-3)
    # And stepped.
    dt = observer.dt or 0.005
    fine = observer.simulate([1.0, -1.0], 12, u="0.5*sin(t)", samples=int(12 / dt) + 1)
    observer.reset(dt=None if observer.dt else dt)
    estimates = observer.step(fine.u[:, :-1], fine.y[:, :-1])
    assert np.abs(estimates[:, -1] - fine.x[:, -1]).max() < 2e-2


def test_the_copy_has_the_gain_it_says():
    observer = lg.lpv_observer(PENDULUM, decay_rate=1.0, xhat0=[0.1, 0.2])
    y, u, xhat = np.array([0.5]), np.array([0.3]), np.array([0.1, 0.2])
    found = observer._design.motion(0.0, xhat, u, y)
    plant = np.array([xhat[1], -2 * np.sin(xhat[0]) - 0.2 * xhat[1] + 0.3])
    np.testing.assert_allclose(found, plant + observer.L @ (y - xhat[:1]), rtol=1e-14)
    np.testing.assert_array_equal(observer.initial_state(), xhat)


def test_an_extended_kalman_filter_is_that_of_filterpy():
    dt = 0.05
    plant = lg.plant(["x1 + 0.05*x2", "x2 - 0.05*sin(x1)"], ["x1"], dt=dt)
    observer = lg.ekf(plant, QN=[1e-3, 2e-3], RN=0.01, P0=[0.5, 2.0], xhat0=[0.3, 0.0])
    rng = np.random.default_rng(2)
    y = np.cumsum(rng.standard_normal((1, 60)) * 0.1, axis=1)
    reference = ExtendedKalmanFilter(2, 1)
    reference.x, reference.P = np.array([[0.3], [0.0]]), np.diag([0.5, 2.0])
    reference.Q, reference.R = np.diag([1e-3, 2e-3]), np.array([[0.01]])
    expected = []
    for k in range(60):
        reference.update(y[:, k : k + 1], lambda x: np.array([[1.0, 0.0]]), lambda x: x[:1])
        x = reference.x.ravel()
        F = np.array([[1.0, dt], [-dt * np.cos(x[0]), 1.0]])
        reference.x = np.array([[x[0] + dt * x[1]], [x[1] - dt * np.sin(x[0])]])
        reference.P = F @ reference.P @ F.T + reference.Q
        expected.append(reference.x.ravel())
    np.testing.assert_allclose(observer.step(None, y), np.array(expected).T, rtol=1e-9, atol=1e-10)


def test_a_discrete_plant():
    plant = lg.plant(["x1 + 0.1*x2", "x2 - 0.1*sin(x1)"], ["x1"], dt=0.1, region=[(-2, 2), (-2, 2)])
    observer = lg.lpv_observer(plant)
    assert observer.dt == 0.1 and observer.certificate.is_proved
    run = observer.simulate([0.5, 0.0], 10)
    assert np.abs(run.error[:, -1]).max() < 1e-3
    with pytest.raises(lg.NotApplicable) as found:
        lg.mean_value_observer(plant)
    assert found.value.alternatives


def test_linear_observers_at_an_operating_point():
    plant = lg.plant(["w", "sin(a) - 0.5*w + u"], ["a", "w + a^2"], states=["a", "w"], inputs=["u"])
    point = plant.at([0.5, 0.0], [-0.4])
    a = np.arcsin(0.4)
    np.testing.assert_allclose(point.x, [a, 0.0], atol=1e-12)
    np.testing.assert_allclose(point.y, [a, a * a], atol=1e-12)
    np.testing.assert_allclose(point.A, [[0, 1], [np.cos(a), -0.5]], atol=1e-12)
    np.testing.assert_allclose(point.C, [[1, 0], [2 * a, 1]], atol=1e-12)
    assert lg.observability(point).is_observable
    observer = lg.place_observer(point, [-3, -4], xhat0=point.x)
    assert observer.certificate.is_proved
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(point.A - observer.L @ point.C)), [-4, -3], atol=1e-8)
    # xhat' is that of the linearisation in deviations from the point.
    xhat, u, y = point.x + [0.1, 0.2], point.u + [0.3], point.y + [0.05, -0.1]
    e = observer.initial_state(xhat)
    np.testing.assert_allclose(e, xhat - point.x, atol=1e-14)
    found = observer._design.motion(0.0, e, u, y)
    expected = point.A @ e + point.B @ (u - point.u) + observer.L @ (y - point.y - point.C @ e)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    run = observer.simulate(point.x + [1e-3, 0.0], 1.0, u=point.u)
    assert np.abs(run.error[:, -1]).max() < 1e-3
    block = observer.to_control()
    assert isinstance(block, control.NonlinearIOSystem)
    for design in (lg.lqe(point, 1.0, 1.0), lg.cubic_observer(point, [-3, -4], radial=1.0)):
        assert design.certificate.is_proved
    assert lg.place_observer(point, [-3, -4]).export(dt=0.01).proved
    with pytest.raises(lg.InvalidArgument):
        plant.at([0.5, 0.0], [-4.0])
    with pytest.raises(lg.DimensionMismatch):
        plant.at([0.5])


def test_a_numerical_kkl_observer_is_measured_and_control_c_ends_its_design():
    plant = lg.plant(["x2^3", "-x1"], ["x1"])
    box = {"x1": (-1, 1), "x2": (-1, 1)}
    observer = lg.kkl_observer(plant, 3.0, box, points=9, samples=400)
    assert observer.verdict == "measured"
    assert np.isfinite(observer.simulate([0.5, 0.2], 5).xhat).all()
    with pytest.raises(lg.InvalidArgument, match="domain"):
        lg.kkl_observer(plant, 3.0)
    forced = lg.plant(["x2^3", "u1 - x1"], ["x1"])
    held = lg.kkl_observer(forced, 3.0, [(-1, 1), (-1, 1)], points=9, samples=400, inputs=[(-0.2, 0.2)], nodes=2)
    assert held.verdict == "measured"
    with pytest.raises(lg.LuenbergerError, match="inputs"):
        lg.kkl_observer(forced, 3.0, [(-1, 1), (-1, 1)], points=9, samples=400)
    timer = threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        lg.kkl_observer(plant, 3.0, box, points=401, samples=100000)
    timer.join()
    assert time.monotonic() - start < 20


def test_what_is_wrong_with_a_plant_is_said():
    with pytest.raises(lg.InvalidArgument, match="sine"):
        lg.plant(["sine(x1)"], ["x1"])
    with pytest.raises(lg.InvalidArgument):
        lg.plant("x2", ["x1"])
    with pytest.raises(lg.InvalidArgument):
        lg.plant(["x1 +"], ["x1"])
    with pytest.raises(lg.InvalidArgument, match="z"):
        lg.plant(["-x1"], ["x1"], region={"z": (0, 1)})
    with pytest.raises(lg.InvalidArgument):
        lg.plant(["-x1"], ["x1"], region={"x1": (1, 0)})
    with pytest.raises(lg.DimensionMismatch):
        lg.plant(["-x1"], ["x1"], region=[(0, 1), (0, 1)])
    with pytest.raises(lg.NotFinite):
        lg.plant(["-p*x1"], ["x1"], parameters={"p": float("nan")})
    with pytest.raises(TypeError):
        lg.place_observer(PENDULUM, [-1, -2])
    cubic = lg.plant(["x2", "-x1^3"], ["x1"])
    with pytest.raises(lg.NotApplicable) as found:
        lg.lpv_observer(cubic)
    assert any("region" in text for text in found.value.hints)
    with pytest.raises(lg.InvalidArgument, match="dt"):
        lg.ekf(PENDULUM, 1.0, 1.0)
    with pytest.raises(lg.DesignError):
        lg.lpv_observer(PENDULUM, decay_rate=500.0, max_gain=1.0)


def test_export_of_a_nonlinear_observer():
    observer = lg.lpv_observer(PENDULUM, decay_rate=1.0)
    exported = observer.export(dt=0.01)
    assert exported.proved and any("sin" in content.decode() for content in exported.files.values())
    unproved = lg.high_gain_observer(PENDULUM, r=0.1)
    with pytest.raises(lg.ExportRefused, match="unproved=True"):
        unproved.export(dt=0.01)
    assert not unproved.export(dt=0.01, unproved=True).proved
