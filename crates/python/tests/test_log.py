"""A filter on a log: its fit, its rows one by one, and angles."""

import json
import math

import numpy as np
import pandas
import pytest

import luenberger as lg

STUDY = """
[plant]
states = ["x"]
inputs = ["u"]
outputs = ["y"]
parameters = { a = 0.7 }
f = ["a*x + u"]
h = ["x"]
dt = 0.5
[log]
file = "log.csv"
[[observer]]
name = "filter"
kind = "extended-kalman"
initial = [0]
p0 = [1]
w = [0.3]
v = [0.5]
period = 0.5
[tune]
observer = "filter"
parameters = ["a", "v"]
profile = 0
"""


def measured(rows=200):
    random = np.random.default_rng(7)
    x, log = 0.0, []
    for k in range(rows):
        u = 1.0 if k % 14 < 7 else -1.0
        log.append((0.5 * k, u, x + random.normal()))
        x = 0.8 * x + u + math.sqrt(0.5) * random.normal()
    return log


@pytest.fixture
def study(tmp_path):
    lines = "".join(f"{t},{u},{y!r}\n" for t, u, y in measured())
    (tmp_path / "log.csv").write_text("t,u,y\n" + lines)
    (tmp_path / "study.toml").write_text(STUDY)
    return lg.Study(tmp_path / "study.toml")


def filtered(log, a, w, v):
    """The scalar Kalman filter by hand: estimates, their variances, and the log-likelihood."""
    x, p, likelihood, found = 0.0, 1.0, 0.0, []
    for _, u, y in log:
        if y is not None:
            s, nu = p + v, y - x
            likelihood -= 0.5 * (math.log(2 * math.pi * s) + nu * nu / s)
            x, p = x + p / s * nu, p - p * p / s
        found.append((x, p))
        x, p = a * x + u, a * a * p + w
    return found, likelihood


def test_a_fit_is_a_mapping_with_the_largest_likelihood(study, tmp_path):
    calls = []
    tuned = study.tune(progress=lambda *reported: calls.append(reported[0]))
    log = [(t, u, float(y)) for t, u, y in measured()][:140]
    fitted = tuned.fitted
    assert set(fitted) == {"a", "v[y]"} and "tune" in calls
    largest = filtered(log, fitted["a"], 0.3, fitted["v[y]"])[1]
    assert tuned["log_likelihood"] == pytest.approx(largest, rel=1e-9)
    assert tuned["log_likelihood_before"] == pytest.approx(filtered(log, 0.7, 0.3, 0.5)[1], rel=1e-9)
    for a, v in ((1.02, 1), (0.98, 1), (1, 1.05), (1, 0.95)):
        assert filtered(log, a * fitted["a"], 0.3, v * fitted["v[y]"])[1] < largest
    frame = pandas.DataFrame(tuned.parameters)
    assert list(frame["name"]) == ["a", "v[y]"] and frame["standard_error"].notna().all()
    assert tuned["held_out"]["after"]["nis"]["samples"] == 60
    assert {*tuned} == {*dict(tuned)} and len(tuned) == len(dict(tuned))
    assert "Parameters" in str(tuned) and "a = " in repr(tuned)
    tuned.save(tmp_path / "mine.toml")
    again = lg.Study(tmp_path / "mine.toml").tune()
    assert again["log_likelihood_before"] == pytest.approx(largest, rel=1e-6)
    assert json.dumps(study.tune(threads=1)["profiles"]) == json.dumps(tuned["profiles"])
    assert study.tune(threads=1).fitted == fitted


def test_a_tuned_study_is_written_once(study, tmp_path):
    study.tune(write=True, output=tmp_path / "fit")
    assert (tmp_path / "tuned.toml").is_file() and (tmp_path / "fit" / "tune.json").is_file()
    with pytest.raises(lg.StudyError, match="force=True"):
        study.tune(write=True)
    study.tune(write=True, force=True)


def test_fits_without_an_answer_are_study_errors(tmp_path):
    def refused(text, log):
        (tmp_path / "log.csv").write_text(log)
        with pytest.raises(lg.StudyError) as found:
            lg.Study.from_text(text, folder=tmp_path).tune()
        return str(found.value)

    log = "t,u,y\n" + "".join(f"{t},0,{y!r}\n" for t, _, y in measured())
    gain = STUDY.replace("a*x + u", "0.8*x + a*u")
    assert "no sign that the log depends on a" in refused(gain, log)
    short = "t,u,y\n" + "".join(f"{t},{u},{y!r}\n" for t, u, y in measured(40))
    assert "at least 20 are needed" in refused(STUDY, short)
    with pytest.raises(lg.StudyError, match=r"tune needs a table \[tune\]"):
        lg.Study.from_text(STUDY.split("[tune]")[0], folder=tmp_path).tune()


def test_a_stream_has_the_estimates_of_the_filter_and_its_bands(study):
    stream = study.stream("filter")
    assert stream.columns == ["t", "x_hat", "x_2sigma"]
    log = [(t, u, None if k in (5, 9, 10) else y) for k, (t, u, y) in enumerate(measured(60))]
    expected, _ = filtered(log, 0.7, 0.3, 0.5)
    for (t, u, y), (x, p) in zip(log, expected):
        found = stream.step({"t": t, "u": u, "y": math.nan if t == 2.5 else y})
        assert found["t"] == t
        np.testing.assert_allclose([found["x_hat"], found["x_2sigma"]], [x, 2 * math.sqrt(p)], rtol=1e-12, atol=1e-12)
    assert stream.samples == 60 and "60 samples" in repr(stream)
    # numpy's numbers, keywords, and a table of rows.
    stream = study.stream()
    found = [stream.step(t=np.float64(t), u=np.float32(u), y=y) for t, u, y in log]
    assert pandas.DataFrame(found).shape == (60, 3)


def test_a_saved_stream_goes_on_with_the_same_bits(study, tmp_path):
    stream, log = study.stream(), measured(40)
    first = [stream.step(t=t, u=u, y=y) for t, u, y in log[:20]]
    saved = stream.save()
    rest = [stream.step(t=t, u=u, y=y) for t, u, y in log[20:]]
    again = study.stream(state=saved)
    assert again.samples == 20 and [again.step(t=t, u=u, y=y) for t, u, y in log[20:]] == rest
    assert len(first) == 20
    for wrong, message in (("no state", "no saved state"), (saved.replace('"samples":20', '"samples":21'), "digest")):
        with pytest.raises(lg.InvalidArgument, match=message):
            study.stream(state=wrong)
    other = lg.Study.from_text(STUDY.replace("0.3", "0.4"), folder=tmp_path)
    with pytest.raises(lg.InvalidArgument, match="another study"):
        other.stream(state=saved)


def test_a_row_that_cannot_be_used_is_passed_over(study):
    stream = study.stream()
    stream.step(t=0, u=1, y=2)
    for row, message in (
        ({"t": 0.0, "u": 1, "y": 2}, "row 2: the time 0 is not after 0"),
        ({"t": 0.5, "u": 1, "y": math.inf}, "y is inf"),
        ({"t": 0.5, "u": 1, "y": [1]}, r"y is \[1\]"),
        ({"t": 0.5, "u": 1, "y": "2 V"}, "expected a number"),
        ({"u": 1, "y": 2}, "row"),
    ):
        with pytest.raises(lg.InvalidArgument, match=message):
            stream.step(row)
    alone = study.stream()
    alone.step(t=0, u=1, y=2)
    assert stream.step(t=0.5, u=1, y=2) == alone.step(t=0.5, u=1, y=2)
    with pytest.raises(lg.LuenbergerError, match="nobody"):
        study.stream("nobody")


def test_angles_are_taken_within_half_a_turn():
    car = lg.plant(
        ["heading + 0.1*rate"], ["heading"], ["heading"], ["rate"], ["compass"], dt=0.1,
        units={"heading": "deg", "compass": "deg"}, angles=["heading"],
    )
    observer = lg.ekf(car, [[0.01]], [[4.0]], dt=0.1, xhat0=[170], P0=[[100.0]])
    random = np.random.default_rng(3)
    t, rate = 0.1 * np.arange(400), np.full(400, 30.0)
    heading = 170 + 0.1 * np.concatenate([[0], np.cumsum(rate[:-1])])
    compass = (heading + 2 * random.normal(size=400) + 180) % 360 - 180
    run = observer.replay(t, compass[None, :], rate[None, :])
    # The filter by hand, its innovation within half a turn.
    x, p = 170.0, 100.0
    for k in range(400):
        gain = p / (p + 4)
        nu = (compass[k] - x + 180) % 360 - 180
        x, p = x + gain * nu, p - gain * p
        difference = (run.xhat[0, k] - x + 180) % 360 - 180
        assert abs(difference) < 1e-9, k
        x, p = x + 0.1 * rate[k], p + 0.01
    assert run.turns == [360.0]
    simulated = observer.simulate([-185.0], 10, u=30.0, noise=2.0, seed=1)
    assert abs(simulated.error).max() < 30
    with pytest.raises(lg.InvalidArgument, match="no state or output"):
        lg.plant(["x1"], ["x1"], dt=1, angles=["heading"])
    plain = lg.plant(["x1"], ["x1"], dt=1)
    assert lg.ekf(plain, [[0.01]], [[4.0]], dt=1).simulate([1.0], 5).turns is None


def test_a_name_that_the_study_does_not_have_is_refused(study):
    stream = study.stream()
    with pytest.raises(lg.InvalidArgument, match="'bogus' is no column of the log or the plant"):
        stream.step({"t": 0.0, "u": 0.0, "y": 1.0, "bogus": 1.0})
    assert stream.samples == 0
    first = stream.step({"t": 0.0, "u": 0.0, "y": 1.0})
    with pytest.raises(lg.InvalidArgument, match="no column"):
        stream.step({"t": 0.1, "u": 0.0, "Y": 1.0})
    assert first["t"] == 0.0 or stream.samples == 1
    with pytest.raises(lg.InvalidArgument, match="there is no observer 'filtr'; expected filter"):
        study.stream("filtr")


def test_a_row_of_pandas_and_its_missing_values(study):
    pandas = pytest.importorskip("pandas")
    pair = [study.stream(), study.stream()]
    frame = pandas.DataFrame({"t": [0.0, 0.5, 1.0], "u": [1.0, 1.0, 1.0], "y": [1.0, None, 2.0]}).convert_dtypes()
    for (_, row), y in zip(frame.iterrows(), [1.0, None, 2.0]):
        assert pair[0].step(row) == pair[1].step(t=float(row["t"]), u=1.0, y=y)
    masked = np.ma.array([5.0], mask=[True])[0]
    assert pair[0].step(t=1.5, u=1.0, y=masked) == pair[1].step(t=1.5, u=1.0, y=None)
