"""Linear designs, against python-control, scipy and filterpy; runs, steps and certificates."""

import copy
import json
import pickle

import control
import filterpy.kalman
import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

import luenberger as lg

SYS = ([[0.0, 1.0], [-2.0, -3.0]], [[0.0], [1.0]], [[1.0, 0.0]])


def random_plant(seed, dt=None):
    rng = np.random.default_rng(seed)
    n, m, p = int(rng.integers(1, 6)), int(rng.integers(1, 3)), int(rng.integers(1, 3))
    A = rng.standard_normal((n, n))
    if dt is not None:
        A = 1.1 * A / np.abs(np.linalg.eigvals(A)).max()
    B, C, D = rng.standard_normal((n, m)), rng.standard_normal((p, n)), rng.standard_normal((p, m))
    return rng, control.ss(A, B, C, D, dt or 0)


def symmetric(product):
    """Python-control refuses `G QN G'` where rounding makes it asymmetric."""
    return (product + product.T) / 2


@pytest.mark.parametrize("seed", range(10))
def test_kalman_filters_in_continuous_time(seed):
    rng, sys = random_plant(seed)
    m, p = sys.ninputs, sys.noutputs
    QN, RN = np.diag(rng.uniform(0.5, 2.0, m)), np.diag(rng.uniform(0.5, 2.0, p))
    observer = lg.lqe(sys, QN, RN)
    L, P, E = control.lqe(sys.A, np.eye(sys.nstates), sys.C, symmetric(sys.B @ QN @ sys.B.T), RN)
    np.testing.assert_allclose(observer.L, L, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(observer.P, P, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(np.sort(observer.poles.real), np.sort(np.real(E)), rtol=1e-5, atol=1e-6)
    again = lg.lqe(sys.A, sys.B, sys.C, np.diag(QN), np.diag(RN))
    np.testing.assert_allclose(again.L, observer.L, rtol=1e-12)
    assert observer.certificate.is_proved


@pytest.mark.parametrize("seed", range(10))
def test_kalman_filters_in_discrete_time(seed):
    rng, sys = random_plant(seed, 0.1)
    m, p = sys.ninputs, sys.noutputs
    QN, RN = np.diag(rng.uniform(0.5, 2.0, m)), np.diag(rng.uniform(0.5, 2.0, p))
    observer = lg.dlqe(sys, QN, RN)
    L, P, _ = control.dlqe(sys.A, np.eye(sys.nstates), sys.C, symmetric(sys.B @ QN @ sys.B.T), RN)
    np.testing.assert_allclose(observer.L, L, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(observer.P, P, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(observer.L, sys.A @ observer.M, rtol=1e-9, atol=1e-10)
    assert observer.dt == 0.1 and observer.certificate.is_proved
    # The stationary filter of filterpy has the same gain.
    filtered = filterpy.kalman.KalmanFilter(dim_x=sys.nstates, dim_z=p)
    filtered.F, filtered.H, filtered.R = sys.A, sys.C, RN
    filtered.Q, filtered.P = sys.B @ QN @ sys.B.T, np.eye(sys.nstates)
    for _ in range(3000):
        filtered.predict()
        filtered.update(np.zeros(p))
    np.testing.assert_allclose(observer.M, filtered.K, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("seed", range(10))
def test_placed_observers(seed):
    _, sys = random_plant(seed)
    wanted = -1.0 - 2.0 * np.arange(sys.nstates) / max(sys.nstates - 1, 1)
    observer = lg.place_observer(sys, wanted)
    F = sys.A - observer.L @ sys.C
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(F).real), np.sort(wanted), rtol=0, atol=1e-6)
    residual = F.T @ observer.P + observer.P @ F + observer.Q
    assert np.linalg.norm(residual) <= 1e-9 * np.linalg.norm(observer.P)
    assert np.linalg.eigvalsh(observer.P).min() > 0
    assert observer.certificate.is_proved
    L = control.place(sys.A.T, sys.C.T, wanted).T if sys.noutputs > 1 else control.acker(sys.A.T, sys.C.T, wanted)
    again = lg.certify(sys, np.reshape(L, observer.L.shape) if sys.noutputs == 1 else L)
    assert again.certificate.is_proved
    if sys.noutputs == 1:
        np.testing.assert_allclose(again.L, observer.L, rtol=1e-5, atol=1e-6)


def test_the_cubic_observers_of_the_paper():
    observer = lg.cubic_observer(([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), [-2, -5], gamma=2.0, rho=10.0, theta=10.0)
    np.testing.assert_allclose(observer.L.ravel(), [7, 10])
    np.testing.assert_allclose(observer.N.ravel(), np.array([-168.0, -196.0]) / 17.0)
    assert observer.certificate.is_proved and "every" in observer.statement
    for more in ({"radial": 1.0}, {"S": [[2.0]]}):
        assert lg.cubic_observer(SYS, [-4, -5], **more).certificate.is_proved
    for linear in ({"L": [[3.0], [1.0]]}, {"QN": 1.0, "RN": 1.0}, {"decay_rate": 1.0}):
        assert lg.cubic_observer(SYS, gamma=1.0, **linear).certificate.is_proved
    sampled = lg.sampled_cubic_observer(SYS, [-4, -5], gamma=1.0, dt=0.2)
    assert sampled.dt == 0.2 and sampled.certificate.is_proved and sampled.L.shape == sampled.N.shape == (2, 1)
    discrete = lg.sampled_cubic_observer((*SYS, 0, 0.2), [0.1, 0.2], gamma=1.0)
    assert discrete.dt == 0.2 and discrete.certificate.is_proved


def test_decay_rates():
    observer = lg.lmi_observer(SYS, 3.0, max_gain=100.0, noise=0.01)
    assert observer.poles.real.max() <= -3.0 and np.linalg.norm(observer.L, 2) <= 100.0
    assert observer.certificate.is_proved
    with pytest.raises(lg.LuenbergerError):
        lg.lmi_observer(([[0, 1], [0, 0]], None, [[1, 0]]), 10.0, max_gain=1.0)


@pytest.mark.parametrize("noise", [None, 0.1])
def test_a_simulation_is_that_of_scipy(noise):
    observer = lg.place_observer(SYS, [-4, -5], xhat0=[0.5, 0.0], name="fast")
    run = observer.simulate([1, -1], 3, u=["sin(2*t)"], samples=301, noise=noise, noise_dt=0.01, seed=3)
    assert run.x.shape == run.xhat.shape == (2, 301) and run.u.shape == run.y.shape == (1, 301)
    A, B, C = map(np.array, SYS)

    def motion(t, z):
        x, xhat, u = z[:2], z[2:], np.array([np.sin(2 * t)])
        y = C @ x + (
            run.y[:, min(int(t / 0.01 + 1e-9), 300)] - C @ run.x[:, min(int(t / 0.01 + 1e-9), 300)] if noise else 0
        )
        return np.concatenate([A @ x + B @ u, A @ xhat + B @ u + observer.L @ (y - C @ xhat)])

    z = np.array([1, -1, 0.5, 0.0])
    for k in range(300):
        step = (run.t[k], run.t[k + 1])
        held = scipy.integrate.solve_ivp(motion, step, z, rtol=1e-11, atol=1e-12, max_step=0.00999) if noise else None
        if held is None:
            break
        z = held.y[:, -1]
        np.testing.assert_allclose(run.x[:, k + 1], z[:2], atol=1e-7)
    if not noise:
        found = scipy.integrate.solve_ivp(motion, (0, 3), z, t_eval=run.t, rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(np.vstack([run.x, run.xhat]), found.y, atol=1e-8)
    assert run.to_dict().keys() == {"t", "x1", "x2", "x1_hat", "x2_hat", "u1", "y1"}
    assert "fast" in run._repr_html_()


def test_inputs_of_every_form():
    observer = lg.place_observer(SYS, [-4, -5])
    constant = observer.simulate([0, 0], 1, u=2.0)
    np.testing.assert_array_equal(constant.u, np.full((1, 501), 2.0))
    t = np.linspace(0, 1, 11)
    held = observer.simulate([0, 0], 1, u=(t, np.where(t < 0.5, 0.0, 1.0)), samples=101)
    assert held.u[0, 10] == 0.0 and held.u[0, 90] == 1.0
    np.testing.assert_array_equal(observer.simulate([0, 0], 1, u="2").x, constant.x)
    for bad in ([1.0, 2.0], (t, np.zeros((2, 11))), (t, np.zeros(10))):
        with pytest.raises(lg.DimensionMismatch):
            observer.simulate([0, 0], 1, u=bad)
    with pytest.raises(lg.InvalidArgument, match="x"):
        observer.simulate([0, 0], 1, u="x")
    with pytest.raises(lg.DimensionMismatch):
        observer.simulate([0, 0, 0], 1)
    with pytest.raises(lg.InvalidArgument):
        observer.simulate([0, 0], -1)


def test_an_array_alone_is_an_input_at_the_times_of_the_run():
    observer = lg.place_observer(SYS, [-4, -5], xhat0=[0.5, 0.0])
    t = np.linspace(0, 2, 101)
    u = np.sin(3 * t)
    pair = observer.simulate([1, 0], 2, samples=101, u=(t, u[np.newaxis]))
    for alone in (u, u[np.newaxis], [u.tolist()]):
        run = observer.simulate([1, 0], 2, samples=101, u=alone)
        assert run.xhat.tolist() == pair.xhat.tolist() and run.u.tolist() == pair.u.tolist()
    two = lg.place_observer(([[0, 1], [0, 0]], [[0, 1], [1, 0]], [[1, 0]]), [-4, -5])
    # One number for each input is constant, whatever the number of samples is.
    constant = two.simulate([1, 0], 1, samples=2, u=[0.5, -0.25])
    assert constant.u.tolist() == [[0.5, 0.5], [-0.25, -0.25]]
    with pytest.raises(lg.DimensionMismatch, match="u must be 1 x 101"):
        observer.simulate([1, 0], 2, samples=101, u=u[np.newaxis, :50])


def test_smoothed_estimates_are_those_of_rauch_tung_and_striebel():
    A, B, C = np.array([[1, 0.1], [-0.2, 0.9]]), np.array([[0.0], [0.1]]), np.array([[1.0, 0.0]])
    Q, R = np.diag([1e-3, 2e-3]), np.array([[0.04]])
    plant = lg.plant(["x1 + 0.1*x2", "-0.2*x1 + 0.9*x2 + 0.1*u1"], ["x1"], inputs=["u1"], dt=0.1)
    observer = lg.ekf(plant, QN=[1e-3, 2e-3], RN=[0.04], P0=[0.5, 2.0], xhat0=[0.3, 0.0])
    rng = np.random.default_rng(7)
    t = 0.1 * np.arange(60)
    u, y = rng.standard_normal((1, 60)), 0.3 * rng.standard_normal((1, 60))
    y[0, 20:24] = np.nan
    run = observer.replay(t, y, u, smooth=True)
    x, P = np.array([0.3, 0.0]), np.diag([0.5, 2.0])
    filtered, predicted = [], []
    for k in range(60):
        if np.isfinite(y[0, k]):
            K = P @ C.T / (C @ P @ C.T + R)
            x, P = x + (K @ (y[:, k] - C @ x)), (np.eye(2) - K @ C) @ P
        filtered.append((x, P))
        x, P = A @ x + B @ u[:, k], A @ P @ A.T + Q
        predicted.append((x, P))
    smoothed = [filtered[-1]]
    for k in range(58, -1, -1):
        (xf, Pf), (xp, Pp), (xs, Ps) = filtered[k], predicted[k], smoothed[0]
        G = Pf @ A.T @ np.linalg.inv(Pp)
        smoothed.insert(0, (xf + G @ (xs - xp), Pf + G @ (Ps - Pp) @ G.T))
    np.testing.assert_allclose(run.smoothed, np.array([x for x, _ in smoothed]).T, rtol=1e-8, atol=1e-10)
    deviation = np.array([np.sqrt(np.diag(P)) for _, P in smoothed]).T
    np.testing.assert_allclose(run.smoothed_deviation, deviation, rtol=1e-8)
    assert observer.replay(t, y, u).smoothed is None
    assert "x1_smoothed" in run.to_dict()
    with pytest.raises(lg.NotApplicable, match="ukf"):
        lg.place_observer(SYS, [-4, -5]).replay(t, y, u, smooth=True)


def test_a_diverging_plant_is_an_error_with_the_time():
    plant = lg.plant(["x1^2"], ["x1"], region=[(-1, 1)])
    observer = lg.certify(lg.ss([[0.0]], None, [[1.0]]), [[1.0]])
    del observer
    with pytest.raises(lg.SimulationError):
        lg.high_gain_observer(plant, 0.1).simulate([1.0], 5.0)


def test_a_step_is_the_sampled_observer():
    dt = 0.05
    observer = lg.place_observer(SYS, [-4, -5], xhat0=[0.5, 0.0])
    sampled = scipy.signal.cont2discrete((*map(np.array, SYS), np.zeros((1, 1))), dt)
    Ad, Bd = sampled[0], sampled[1]
    rng = np.random.default_rng(0)
    u, y = rng.standard_normal((1, 50)), rng.standard_normal((1, 50))
    xhat = observer.xhat
    observer.reset(dt=dt)
    first = observer.step(u[:, 0], y[:, 0])
    L = (first - Ad @ xhat - Bd @ u[:, 0]).reshape(2, 1) / (y[:, 0] - xhat[0])
    np.testing.assert_allclose(
        np.sort(np.linalg.eigvals(Ad - L @ SYS[2])), np.sort(np.exp(dt * np.array([-5, -4]))), atol=1e-9
    )
    expected = [first]
    for k in range(1, 50):
        xhat = expected[-1]
        expected.append(Ad @ xhat + Bd @ u[:, k] + L @ (y[:, k] - xhat[:1]))
    found = observer.step(u[:, 1:], y[:, 1:])
    np.testing.assert_allclose(found, np.array(expected[1:]).T, atol=1e-10)
    np.testing.assert_array_equal(observer.xhat, found[:, -1])
    with pytest.raises(lg.InvalidArgument, match="reset"):
        observer.step(0.0, 0.0, dt=0.1)
    with pytest.raises(lg.InvalidArgument, match="dt is needed"):
        lg.place_observer(SYS, [-4, -5]).step(0.0, 0.0)
    with pytest.raises(lg.DimensionMismatch):
        observer.step([0.0, 1.0], 0.0)
    with pytest.raises(lg.NotFinite):
        observer.step(np.nan, 0.0)
    with pytest.raises(lg.NotFinite):
        observer.step(0.0, np.inf)


def test_a_discrete_observer_steps_as_its_equation():
    rng, sys = random_plant(4, 0.1)
    observer = lg.dlqe(sys, 1.0, 1.0)
    u, y = rng.standard_normal((sys.ninputs, 30)), rng.standard_normal((sys.noutputs, 30))
    xhat, expected = np.zeros(sys.nstates), []
    for k in range(30):
        xhat = sys.A @ xhat + sys.B @ u[:, k] + observer.L @ (y[:, k] - sys.C @ xhat - sys.D @ u[:, k])
        expected.append(xhat)
    np.testing.assert_allclose(observer.step(u, y), np.array(expected).T, rtol=1e-9, atol=1e-9)


def test_replay_of_measured_data_with_gaps():
    observer = lg.place_observer(SYS, [-4, -5])
    run = observer.simulate([1, -1], 5, u="sin(t)", samples=1001)
    y = run.y.copy()
    again = observer.replay(run.t, y, run.u)
    assert np.isnan(again.x).all() and again.xhat.shape == (2, 1001)
    assert np.abs(again.xhat[:, -1] - run.x[:, -1]).max() < 5e-3
    y[0, 100:110] = np.nan
    assert np.abs(observer.replay(run.t, y, run.u).xhat[:, -1] - run.x[:, -1]).max() < 5e-3
    y[0, 5] = np.inf
    with pytest.raises(lg.NotFinite):
        observer.replay(run.t, y, run.u)
    with pytest.raises(lg.DimensionMismatch):
        observer.replay(run.t, y[:, :-1])


def test_a_linear_observer_in_python_control():
    sys = control.ss(*SYS, 0, inputs=["u"], outputs=["y"], states=["q", "v"], name="plant")
    observer = lg.place_observer(sys, [-4, -5], name="observer")
    block = observer.to_control()
    assert isinstance(block, control.StateSpace)
    assert block.input_labels == ["u", "y"] and block.output_labels == ["q_hat", "v_hat"]
    both = control.interconnect([sys, block], inputs=["u"], outputs=["q_hat", "v_hat"])
    t = np.linspace(0, 3, 301)
    found = control.input_output_response(
        both, t, np.sin(t), X0=[1, -1, 0, 0], solve_ivp_kwargs={"rtol": 1e-9, "atol": 1e-10}
    )
    run = observer.simulate([1, -1], 3, u="sin(t)", samples=301)
    np.testing.assert_allclose(found.outputs, run.xhat, atol=2e-5)


def test_a_cubic_observer_in_python_control():
    observer = lg.cubic_observer(SYS, [-4, -5], gamma=1.0)
    block = observer.to_control()
    assert isinstance(block, control.NonlinearIOSystem)
    t = np.linspace(0, 2, 401)
    run = observer.simulate([2, -1], 2, samples=401)
    drive = np.vstack([run.u, run.y])
    found = control.input_output_response(block, t, drive, X0=observer.initial_state(), solve_ivp_kwargs={"rtol": 1e-9})
    np.testing.assert_allclose(found.outputs, run.xhat, atol=1e-4)
    sampled = lg.sampled_cubic_observer(SYS, [-4, -5], gamma=1.0, dt=0.1)
    t = 0.1 * np.arange(30)
    y = np.sin(t)
    found = control.input_output_response(sampled.to_control(), t, np.vstack([0 * y, y]), X0=[0.0, 0.0])
    expected = sampled.step(np.zeros((1, 29)), y[np.newaxis, :29])
    np.testing.assert_allclose(found.outputs[:, 1:], expected, rtol=1e-12, atol=1e-13)


def test_certificates(tmp_path):
    observer = lg.place_observer(SYS, [-4, -5], name="fast")
    certificate = observer.certificate
    assert certificate.verdict == "proved" and certificate.statements and certificate.margins
    path = certificate.save(tmp_path / "fast.json")
    proved = lg.verify(path)
    assert proved.title == "fast" and all(fact.verdict == "proved" for fact in proved.facts)
    assert certificate.verify() == proved
    document = json.loads(path.read_text())
    document["statement"] += " And more."
    path.write_text(json.dumps(document))
    with pytest.raises(lg.Rejected):
        lg.verify(path)
    path.write_bytes(b"\xff")
    with pytest.raises(lg.Rejected):
        lg.verify(path)
    for text in (observer._repr_html_(), certificate._repr_html_(), proved._repr_html_()):
        assert "proved" in text and "<table>" in text


def test_designs_that_do_not_exist_say_why():
    hidden = ([[1.0, 0.0], [0.0, -1.0]], None, [[0.0, 1.0]])
    with pytest.raises(lg.NotDetectable) as found:
        lg.lqe(hidden[0], np.eye(2), hidden[2], 1.0, 1.0)
    assert found.value.eigenvalue == 1.0 and found.value.margin == 0.0
    with pytest.raises(lg.Unobservable) as found:
        lg.place_observer(hidden, [-1, -2])
    assert found.value.eigenvalue == 1.0 and np.allclose(np.abs(found.value.direction), [1, 0])
    assert found.value.hints and not found.value.alternatives
    with pytest.raises(lg.InvalidPole) as found:
        lg.place_observer(SYS, [1, -2])
    assert found.value.pole == 1.0
    with pytest.raises(lg.InvalidPole) as found:
        lg.place_observer((*SYS, 0, 0.1), [1.5, 0.2])
    assert found.value.pole == 1.5
    with pytest.raises(lg.InvalidPole):
        lg.place_observer(SYS, [-1])
    with pytest.raises(lg.InvalidPole) as found:
        lg.place_observer(SYS, [-1, np.nan])
    assert found.value.index == 1
    with pytest.raises(lg.NotStable) as found:
        lg.certify(SYS, [[-30.0], [0.0]])
    assert found.value.abscissa > 0
    with pytest.raises(lg.DimensionMismatch) as found:
        lg.certify(SYS, np.zeros((3, 1)))
    assert (found.value.what, found.value.expected, found.value.found) == ("L", (2, 1), (3, 1))
    np.testing.assert_array_equal(lg.lqe((*SYS, 0, 0.1), 1.0, 1.0).M, lg.dlqe((*SYS, 0, 0.1), 1.0, 1.0).M)
    with pytest.raises(lg.InvalidArgument, match="lqe"):
        lg.dlqe(SYS, 1.0, 1.0)
    with pytest.raises(lg.InvalidArgument):
        lg.cubic_observer(SYS, [-4, -5])
    with pytest.raises(lg.InvalidArgument):
        lg.cubic_observer(SYS, [-4, -5], L=[[1.0], [1.0]], gamma=1.0)
    with pytest.raises(lg.NotPositiveDefinite):
        lg.lqe(SYS, 1.0, -1.0)
    with pytest.raises(AttributeError, match="luenberger"):
        lg.place_observer(SYS, [-4, -5]).N


def test_exports(tmp_path):
    observer = lg.place_observer(SYS, [-4, -5], name="fast")
    exported = observer.export(tmp_path / "c", dt=0.01)
    assert exported.proved and exported.period == 0.01 and (tmp_path / "c" / "certificate.json").is_file()
    assert lg.verify(tmp_path / "c" / "certificate.json").facts
    assert any(name.endswith(".c") for name in exported.files) and exported.operations > 0
    with pytest.raises(lg.ExportRefused):
        observer.export(tmp_path / "c", dt=0.01)
    # With the bounds of a run the proof covers rounding, and the step is compared with the observer along it.
    run = {"x0": [1, -1], "duration": 5, "u": "sin(t)", "noise": 0.01, "noise_dt": 0.01}
    bounded = observer.export(dt=0.01, format="f32", run=run)
    assert bounded.proved and len(bounded.statement) > len(exported.statement)
    with pytest.raises(TypeError):
        observer.export(dt=0.01, run={"x_0": [1, -1]})
    assert observer.export(tmp_path / "c", dt=0.01, force=True).files == exported.files
    assert "Cargo.toml" in observer.export(to="rust", dt=0.01, format="f32").files
    with pytest.raises(lg.InvalidArgument, match="dt is needed"):
        observer.export()
    with pytest.raises(lg.InvalidArgument):
        observer.export(to="pascal", dt=0.01)
    with pytest.raises(lg.InvalidArgument):
        observer.export(format="f16", dt=0.01)


def test_exports_have_the_options_of_the_command(tmp_path):
    observer = lg.place_observer(SYS, [-4, -5], name="fast")
    fixed = observer.export(dt=0.01, format="q12.20", gains="q4.28", run={"x0": [1, -1], "duration": 5})
    assert fixed.proved and any("Q12.20" in sentence for sentence in fixed.statement)
    assert all(late < largest for late, largest in zip(fixed.difference["second_half"], fixed.difference["largest"]))
    assert b"int32_t" in fixed.files["fast.h"] and fixed.substeps is None and len(fixed.digest) == 64
    # u = r - K xhat as one block, and the loop has a certificate of its own; in `run` u is r.
    loop = observer.export(tmp_path / "loop", dt=0.01, feedback=[4.0, 3.0], run={"x0": [1, 0], "duration": 2, "u": "1"})
    assert loop.proved and {"certificate.json", "certificate-feedback.json"} <= set(loop.files)
    assert lg.verify(tmp_path / "loop" / "certificate-feedback.json").facts
    with pytest.raises(lg.ExportRefused, match="its feedback has no stability certificate"):
        observer.export(dt=0.01, feedback=[[-40.0, 0.0]])
    with pytest.raises(lg.DimensionMismatch):
        observer.export(dt=0.01, feedback=[[4.0, 3.0, 2.0]])
    for version in (2, 3):
        unit = observer.export(to="fmu", fmi=version, dt=0.01, test_steps=8)
        # Without a C compiler the archive has its sources alone, and the notes say so.
        assert unit.binaries or unit.notes
        assert f"FMI {version}.0" in unit.files["README.md"].decode()
    for options, says in [
        ({"fmi": 3}, "fmi is for to="),
        ({"fmi": 4, "to": "fmu"}, "2 or 3"),
        ({"gains": "q4.28"}, "gains is for fixed point"),
        ({"format": "q0.16"}, "a format has 2 to 32 bits"),
        ({"format": "q16.16", "to": "rust"}, 'fixed point is for to="c"'),
        ({"format": "q16.16", "feedback": [[4.0, 3.0]]}, "feedback is for floating point"),
    ]:
        with pytest.raises(lg.InvalidArgument, match=says):
            observer.export(dt=0.01, **options)
    with pytest.raises(lg.ExportRefused, match="spectral radius") as refused:
        observer.export(dt=0.01, format="q12.2")
    assert any('format="f64"' in alternative for alternative in refused.value.alternatives)


def test_observers_at_varying_periods():
    observer = lg.sampled_cubic_observer(SYS, [-4, -5], gamma=1.0, dt=0.1, jitter=[0.05, 0.15], misses=1)
    exported = observer.export()
    assert exported.proved and exported.period == 0.1 and "dt" in exported.files["sampled_cubic.h"].decode()
    # Two samples of one time each, and one of twice the nominal period at once: the input is held.
    first = observer.step(0.0, 1.0, dt=0.05)
    observer.reset()
    np.testing.assert_array_equal(observer.step(np.zeros((1, 2)), np.ones((1, 2)), dt=[0.05, 0.15])[:, 0], first)
    observer.reset()
    nominal = observer.step(0.0, 1.0)
    observer.reset()
    np.testing.assert_array_equal(observer.step(0.0, 1.0, dt=0.1), nominal)
    assert not np.array_equal(first, nominal)
    assert observer.simulate([1, 0], 10, u="sin(t)").xhat.shape == (2, 501)
    with pytest.raises(lg.NotApplicable, match="varying periods"):
        observer.to_control()


def test_observers_are_used_from_several_threads():
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(6) as pool:
        gains = list(pool.map(lambda _: lg.place_observer(SYS, [-4, -5]).L, range(60)))
    assert all(np.array_equal(gain, gains[0]) for gain in gains)


def test_a_certificate_is_copied_and_pickled():
    proved = lg.place_observer(SYS, [-4, -5]).certificate
    for again in (copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(one))))):
        other = again(proved)
        assert other.verdict == "proved" and other.facts == proved.facts and other.statements == proved.statements
        assert other.to_json() == proved.to_json() and other.verify().facts == proved.verify().facts


def test_a_certificate_that_is_not_proved_stays_so_in_copies():
    class Undecided:
        def facts(self):
            return [{"inequality": "P > 0", "verdict": "undecided", "margin": None, "words": "not decided"}]

        def statements(self):
            return []

        def verdict(self):
            return "undecided"

        def to_json(self):
            raise lg.NotProved("P > 0 is not proved")

    other = pickle.loads(pickle.dumps(lg.Certificate(Undecided())))
    assert other.verdict == "undecided" and not other.is_proved and other.margins == {}
    with pytest.raises(lg.NotProved, match="P > 0 is not proved"):
        other.verify()
