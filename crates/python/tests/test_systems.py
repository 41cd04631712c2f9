"""Plants of this package, of python-control and of scipy; observability."""

import control
import numpy as np
import pytest
import scipy.signal

import luenberger as lg

A, B, C = np.array([[0.0, 1.0], [-2.0, -3.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])


@pytest.mark.parametrize(
    ("sys", "dt"),
    [
        (lg.ss(A, B, C), None),
        (lg.ss(A, B, C, dt=0), None),
        (lg.ss(A, B, C, dt=0.5), 0.5),
        (lg.ss(A, B, C, dt=True), 1.0),
        (control.ss(A, B, C, 0), None),
        (control.ss(A, B, C, 0, 0.5), 0.5),
        (control.ss(A, B, C, 0, True), 1.0),
        (scipy.signal.StateSpace(A, B, C, [[0.0]]), None),
        (scipy.signal.StateSpace(A, B, C, [[0.0]], dt=0.5), 0.5),
        (scipy.signal.ZerosPolesGain([], [-1.0, -2.0], 1.0), None),
        (control.tf([1], [1, 3, 2]), None),
        ((A, B, C), None),
        ((A, B, C, 0), None),
        ((A, B, C, [[0.0]], 0.5), 0.5),
        ([A, [0, 1], [1, 0]], None),
    ],
)
def test_a_plant_of_every_accepted_type(sys, dt):
    seen = lg.observability(sys)
    assert seen.plant.dt == dt
    assert (seen.rank, seen.order, seen.plant.ninputs, seen.plant.noutputs) == (2, 2, 1, 1)
    assert seen.is_observable and seen.is_detectable
    if not isinstance(sys, (scipy.signal.ZerosPolesGain, control.TransferFunction)):
        np.testing.assert_array_equal(seen.plant.A, A)
        assert seen.plant.B.shape == (2, 1) and seen.plant.C.shape == (1, 2) and seen.plant.D.shape == (1, 1)


def test_names_of_python_control_are_kept_where_they_are_names():
    sys = control.ss(A, B, C, 0, states=["angle", "rate"], inputs=["torque"], outputs=["encoder"])
    plant = lg.observability(sys).plant
    assert (plant.states, plant.inputs, plant.outputs) == (["angle", "rate"], ["torque"], ["encoder"])
    assert lg.observability(control.ss(A, B, C, 0)).plant.states == ["x1", "x2"]
    sys = control.ss(A, B, C, 0, states=["a b", "c"], inputs=["u"], outputs=["y"])
    assert lg.observability(sys).plant.states == ["x1", "x2"]


def test_what_is_no_plant_is_refused():
    with pytest.raises(TypeError):
        lg.observability(control.frd([1.0, 2.0], [1.0, 2.0]))
    with pytest.raises(lg.InvalidArgument):
        lg.observability((A, B))
    with pytest.raises(TypeError, match="luenberger.ss"):
        lg.observability(3.0)
    with pytest.raises(lg.DimensionMismatch) as found:
        lg.ss(A, B, np.eye(3))
    assert (found.value.what, found.value.expected, found.value.found) == ("C", (3, 2), (3, 3))
    with pytest.raises(lg.DimensionMismatch):
        lg.ss(A, B, C, states=["a"])
    with pytest.raises(lg.InvalidArgument):
        lg.ss(A, B, C, dt=-1.0)
    with pytest.raises(lg.NotFinite):
        lg.ss(A, B, C, dt=np.inf)
    with pytest.raises(lg.InvalidArgument):
        lg.ss(A, B, C, states=["1", "b"])


@pytest.mark.parametrize("seed", range(10))
def test_rank_and_hidden_modes_of_random_plants(seed):
    rng = np.random.default_rng(seed)
    n, hidden = int(rng.integers(2, 8)), int(rng.integers(0, 2))
    seen = n - hidden
    A = np.zeros((n, n))
    A[:seen, :seen] = rng.standard_normal((seen, seen))
    A[seen:, :] = rng.standard_normal((hidden, n))
    if hidden:
        A[seen:, seen:] = -1.5
    C = np.zeros((1, n))
    C[:, :seen] = rng.standard_normal((1, seen))
    T = np.linalg.qr(rng.standard_normal((n, n)))[0]
    A, C = T @ A @ T.T, C @ T.T
    found = lg.observability((A, None, C))
    assert found.rank == np.linalg.matrix_rank(control.obsv(A, C), tol=1e-9 * np.linalg.norm(control.obsv(A, C)))
    assert found.rank == seen and found.is_detectable
    if hidden:
        (mode,) = found.unobservable
        assert abs(mode.eigenvalue + 1.5) < 1e-8
        assert np.linalg.norm(C @ mode.direction) < 1e-10
        assert found.distance[0] == 0.0 and found.distance[1] < 1e-12
        assert found.subspace.shape == (n, 1)
    else:
        low, high = found.distance
        svd = [np.linalg.svd(np.vstack([A - s * np.eye(n), C]))[1][-1] for s in np.linalg.eigvals(A)]
        assert 0 < low <= high <= min(svd) * (1 + 1e-9)


def test_a_hidden_unstable_mode_and_its_table():
    found = lg.observability((np.diag([1.0, -1.0]), None, [[0.0, 1.0]]))
    assert not found.is_detectable and found.undetectable_modes[0].eigenvalue == 1.0
    assert found.margin == 0.0
    text = found._repr_html_()
    assert "not detectable" in text and "x1" in text and text.count("<tr>") == 4
