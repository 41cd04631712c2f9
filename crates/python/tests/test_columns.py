"""The names and columns of trajectories and scores, of each kind of observer."""

import luenberger as lg
import numpy as np
import pytest

A, B, C = np.array([[0.9, 0.1], [0.0, 0.8]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
SYS = lg.ss(A, B, C, dt=0.1)


def functional(**keys):
    return lg.observer("functional", SYS, k=[[0, 1]], poles=[0.3], **keys)


def test_a_functional_observer_has_errors_of_its_functions():
    run = functional().simulate([1, 2], 1.0, u=1.0)
    assert run.estimated == ["z1"] and run.xhat.shape == (1, 11)
    assert np.allclose(run.functions, run.x[1:], rtol=0, atol=1e-12)
    # z of a sample with its measurement, w+ = F w + G y + H u, z = w + N y, by the matrices of the design.
    F, G, H, N = (functional().matrices[name] for name in "FGHN")
    x, w, errors = np.array([1.0, 2.0]), functional().matrices["T"] @ np.zeros(2), []
    for _ in range(11):
        y = C @ x
        errors.append(x[1] - (w + N @ y)[0])
        w, x = F @ w + G @ y + H @ [1.0], A @ x + B @ [1.0]
    assert np.allclose(run.error[0], errors, rtol=0, atol=1e-9)
    assert list(run.to_dict()) == ["t", "x1", "x2", "z1", "z1_hat", "u1", "y1"]
    assert np.array_equal(run.to_dict()["z1_hat"], run.xhat[0])


def test_more_functions_than_one_of_three_states_are_shown():
    plant = lg.ss(np.diag([-1.0, -2.0, -3.0]) + np.eye(3, k=1), None, [[1, 0, 0]])
    observer = lg.observer("functional", plant, k=[[0, 1, 0], [0, 0, 1]], poles=[-4, -5])
    run = observer.simulate([1, 2, 3], 5.0)
    assert run.error.shape == (2, 501)
    assert abs(run.error[:, -1]).max() < 1e-6
    assert "z2" in run._repr_html_() and "function" in run._repr_html_()


def test_a_functional_observer_is_drawn():
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    axes = functional().simulate([1, 2], 1.0).plot()
    assert [axis.get_ylabel() for axis in axes] == ["z1"]
    with pytest.raises(lg.InvalidArgument, match="x1, x2, z1"):
        functional().simulate([1, 2], 1.0).plot(["x3"])


def test_a_functional_observer_steps_and_blocks_as_it_simulates():
    run = functional().simulate([1, 2], 1.0, u=1.0)
    observer = functional()
    assert observer.xhat.tolist() == [0.0] and observer.estimated == ["z1"]
    stepped = [observer.step(1.0, y) for y in run.y[0]]
    assert np.allclose(np.ravel(stepped), run.xhat[0], rtol=0, atol=1e-12)
    assert functional().step(np.ones((1, 11)), run.y).shape == (1, 11)
    control = pytest.importorskip("control")
    block = observer.to_control()
    assert isinstance(block, control.NonlinearIOSystem) and block.output_labels == ["z1_hat"]
    z, found = functional().initial_state([0.0, 0.0]), []
    for y in run.y[0]:
        found.append(block.output(0, z, [1.0, y]))
        z = block.dynamics(0, z, [1.0, y])
    assert np.allclose(np.ravel(found), run.xhat[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind, more", [("extended-state", {"order": 1}), ("proportional-integral", {})])
def test_disturbances_are_columns(kind, more):
    observer = lg.observer(kind, SYS, e=[[0], [1]], poles=[0.3, 0.4, 0.5], **more)
    run = observer.simulate([1, 2], 10.0)
    assert run.disturbances == ["d1"] and run.dhat.shape == (1, run.t.size)
    # No disturbance acts.
    assert abs(run.dhat[0, -1]) < 1e-6 and abs(run.dhat).max() > 0.1
    assert "d1_hat" in run.to_dict()
    pytest.importorskip("control")
    block, z = observer.to_control(), observer.initial_state()
    assert block.output_labels == ["x1_hat", "x2_hat", "d1_hat"]
    for k in range(run.t.size):
        found = block.output(0, z, [0.0, run.y[0, k]])
        assert np.allclose(found, [*run.xhat[:, k], run.dhat[0, k]], rtol=0, atol=1e-9)
        z = block.dynamics(0, z, [0.0, run.y[0, k]])
    logged = observer.replay(run.t, run.y)
    assert np.allclose(logged.dhat, run.dhat, rtol=0, atol=1e-9)
    observer.reset()
    stepped = observer.step(np.zeros((1, run.t.size)), run.y)
    assert observer.estimated == ["x1", "x2", "d1"]
    assert np.allclose(stepped[2, :-1], run.dhat[0, 1:], rtol=0, atol=1e-9)


def test_bounds_are_columns():
    bounds = {"noise": [0.01], "disturbance": [0.01], "e": [[0], [1]]}
    observer = lg.observer("interval", SYS, initial_bounds=[2, 3], poles=[0.3, 0.4], bounds=bounds)
    run = observer.simulate([1, 2], 3.0)
    assert (run.lower <= run.x).all() and (run.x <= run.upper).all()
    columns = run.to_dict()
    assert np.array_equal(columns["x2_lower"], run.lower[1]) and np.array_equal(columns["x1_upper"], run.upper[0])
    logged = observer.replay(run.t, run.y)
    assert np.allclose(logged.lower, run.lower, rtol=0, atol=1e-9)


def imm():
    models = [{"name": "quiet", "v": [0.01]}, {"name": "loud", "v": [1.0]}]
    keys = {"w": 0.01, "v": 0.01, "period": 0.1, "transitions": [[0.9, 0.1], [0.1, 0.9]]}
    return lg.observer("imm", SYS, models=models, **keys)


def test_probabilities_of_models_are_columns():
    run = imm().simulate([1, 2], 3.0, noise=0.1, seed=1)
    assert run.models == ["quiet", "loud"]
    assert np.allclose(run.probability.sum(axis=0), 1.0)
    assert {"quiet_probability", "loud_probability", "x1_2sigma"} <= set(run.to_dict())
    logged = imm().replay(run.t, run.y)
    assert np.allclose(logged.probability, run.probability, rtol=0, atol=1e-6)


def test_two_standard_deviations_are_columns():
    observer = lg.ekf(SYS, 0.01, 0.1, 0.1)
    run = observer.replay(np.arange(20) * 0.1, np.sin(np.arange(20.0)), smooth=True)
    columns = run.to_dict()
    assert np.array_equal(columns["x2_2sigma"], 2 * run.deviation[1])
    assert np.array_equal(columns["x1_smoothed_2sigma"], 2 * run.smoothed_deviation[0])


STUDY = """
[plant]
a = [[0.9, 0.1], [0, 0.8]]
c = [[1, 0]]
dt = 0.1
[[observer]]
name = "fast"
kind = "luenberger"
poles = [0.3, 0.4]
"""


def test_the_columns_are_those_of_the_tables_of_a_study(tmp_path):
    text = STUDY + """
[[observer]]
name = "function"
kind = "functional"
k = [[0, 1]]
poles = [0.3]
[[observer]]
name = "filter"
kind = "extended-kalman"
w = 0.01
v = 0.01
period = 0.1
[[observer]]
name = "disturbance"
kind = "extended-state"
e = [[0], [1]]
order = 1
poles = [0.3, 0.4, 0.5]
[simulation]
x0 = [1, 1]
duration = 2
noise = { amplitude = [0.01], period = 0.1 }
"""
    results = lg.Study.from_text(text).run("simulate", output=tmp_path / "out")
    for name in results:
        heads = (tmp_path / "out" / "trajectories" / f"{name}.csv").read_text().splitlines()[0].split(",")
        columns = results[name].to_dict()
        assert sorted(heads) == sorted(columns), name
        table = np.genfromtxt(tmp_path / "out" / "trajectories" / f"{name}.csv", delimiter=",", names=True)
        for head in heads:
            assert np.allclose(table[head], columns[head], rtol=1e-9, atol=1e-12), (name, head)


def test_statistics_of_a_sweep_are_columns_by_their_scores(tmp_path):
    text = STUDY + """
[simulation]
x0 = [1, 1]
duration = 5
[sweep]
parameter = "initial"
values = [1, 2]
ensemble = 20
"""
    results = lg.Study.from_text(text).run("sweep", output=tmp_path / "out")
    sweep = results.sweep
    assert not [name for name in sweep if "None" in name]
    runs = np.genfromtxt(tmp_path / "out" / "sweep.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    for score in ("x1_rmse", "x2_peak"):
        for row, value in enumerate(sweep["value"]):
            own = runs[score][runs[runs.dtype.names[1]] == value] if score in runs.dtype.names else None
            assert own is not None and len(own) == sweep[f"{score}.count"][row] == 20
            assert np.isclose(sweep[f"{score}.mean"][row], own.mean(), rtol=1e-9)


def test_a_list_of_tables_without_names_keeps_all_of_them():
    from luenberger.studies import _flat

    assert _flat({"gaps": [{"a": 1}, {"a": 2}]}) == {"gaps1.a": 1, "gaps2.a": 2}


def test_scores_of_a_study_with_a_log_alone(tmp_path):
    rng = np.random.default_rng(4)
    y = rng.standard_normal(200)
    rows = "\n".join(f"{0.1 * k:.1f},{value!r}" for k, value in enumerate(y.tolist()))
    (tmp_path / "log.csv").write_text("t,y1\n" + rows + "\n")
    text = STUDY + """
[[observer]]
name = "filter"
kind = "extended-kalman"
w = 0.1
v = 1
period = 0.1
[log]
file = "log.csv"
"""
    results = lg.Study.from_text(text, folder=tmp_path).run("simulate")
    assert results.scores == {}
    scores = results.log_scores
    assert scores["observer"] == ["fast", "filter"] and scores["output"] == ["y1", "y1"]
    # Of the second half: the innovation before each measurement.
    x, nu = np.zeros(2), []
    L = lg.place_observer(lg.ss(A, None, C, dt=0.1), [0.3, 0.4]).L
    for value in y:
        nu.append(value - (C @ x)[0])
        x = A @ x + L[:, 0] * nu[-1]
    assert np.isclose(scores["rms"][0], np.sqrt(np.mean(np.square(nu[100:]))), rtol=1e-6)
    assert scores["nis"][0] is None and scores["nis"][1] > 0
    pandas = pytest.importorskip("pandas")
    assert isinstance(results.to_frame(), pandas.DataFrame) and len(results.to_frame()) == 2
    assert "<caption>log" in results._repr_html_() or "log" in results._repr_html_()
