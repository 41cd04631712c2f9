"""Errors in the words and classes of Python."""

import luenberger as lg
import numpy as np
import pytest

SYS = lg.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])


@pytest.mark.parametrize(
    "name, value",
    [
        ("test_steps", -1),
        ("test_steps", 1.5),
        ("fmi", 300),
        ("fmi", "3"),
        ("layout", 3),
        ("gains", 7),
        ("substeps", -1),
        ("substeps", 1.5),
        ("to", 5),
        ("unproved", "yes"),
    ],
)
def test_an_option_of_the_wrong_type_is_named(name, value):
    observer = lg.place_observer(SYS, [-2, -5])
    with pytest.raises(lg.InvalidArgument) as found:
        observer.export(dt=0.1, **{name: value})
    assert str(found.value).startswith(f"{name} is {value!r}; expected ")
    assert found.value.what == name


@pytest.mark.parametrize("value", [-1, 1.5, "many"])
def test_a_count_of_the_wrong_type_is_named(value, tmp_path):
    text = '[plant]\na = [[-1]]\nc = [[1]]\n[[observer]]\nkind = "luenberger"\npoles = [-2]\n'
    study = lg.Study.from_text(text)
    for name in ("threads", "block_size"):
        with pytest.raises(lg.InvalidArgument, match=f"^{name} is .*; expected a whole number from 0 on$"):
            study.run("design", **{name: value})
    with pytest.raises(lg.InvalidArgument, match="^substeps is "):
        study.stream(dt=0.1, substeps=value)
    with pytest.raises(lg.InvalidArgument, match="^substeps is "):
        lg.place_observer(SYS, [-2, -5]).reset(dt=0.1, substeps=value)


def test_a_file_that_is_missing_is_said_once(tmp_path):
    with pytest.raises(FileNotFoundError) as found:
        lg.Study(tmp_path / "none.toml")
    assert "os error" not in str(found.value) and found.value.errno == 2
    with pytest.raises(OSError) as found:
        lg.Study(tmp_path)
    assert "os error" not in str(found.value)


def test_alternatives_are_arguments():
    unstable = lg.ss([[1.0, 0.0], [0.0, 2.0]], None, [[1, 0]])
    with pytest.raises(lg.LuenbergerError) as found:
        lg.place_observer(lg.ss([[0, 1], [0, 0]], None, [[1, 0]]), [1, -2])
    assert "[[observer]]" not in str(found.value)
    with pytest.raises(lg.LuenbergerError) as found:
        lg.observer("unknown-input", lg.ss([[0.9, 0.1], [0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1), e=[[1], [0]], poles=[0.3, 0.4])
    text = str(found.value)
    assert found.value.alternatives and "Instead, of luenberger.observer: " in text
    assert "lmi=True" in text and 'kalman={"w": 1, "v": 1}' in text
    assert " = true" not in text
    # What is said there is what Python reads.
    plant = lg.ss([[0.9, 0.1], [0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1)
    assert lg.observer("unknown-input", plant, e=[[1], [0]], kalman={"w": 1, "v": 1}).kind == "unknown-input"
    with pytest.raises(lg.LuenbergerError):
        lg.place_observer(unstable, [-1, -2])


def test_a_missing_key_is_one_of_the_call():
    with pytest.raises(lg.InvalidArgument) as found:
        lg.observer("kalman", SYS, v=1)
    assert "[[observer]]" not in str(found.value) and "an observer of the kind kalman has no `w`" in str(found.value)


def test_a_functional_observer_on_data_is_refused_in_its_words():
    observer = lg.observer("functional", SYS, k=[[0, 1]], poles=[-3])
    with pytest.raises(lg.LuenbergerError, match="replay compares estimates of the state") as found:
        observer.replay([0.0, 1.0], [0.0, 1.0])
    assert "[log]" not in str(found.value)


def test_a_limit_is_an_argument_of_run():
    text = """
[plant]
a = [[-1]]
c = [[1]]
[[observer]]
kind = "luenberger"
poles = [-2]
[simulation]
x0 = [1]
duration = 1000
samples = 1000000
"""
    with pytest.raises(lg.StudyError) as found:
        lg.Study.from_text(text).run(memory_limit=1e6)
    assert "--limit" not in str(found.value) and "memory_limit=" in str(found.value)
    with pytest.raises(lg.Cancelled) as found:
        lg.Study.from_text(text).run(time_limit=1e-3)
    assert "--limit" not in str(found.value) and "time_limit=172800" in str(found.value)


INDEFINITE = np.array([[1.0, 2.0], [2.0, 1.0]])
ASYMMETRIC = np.array([[1.0, 0.5], [0.0, 1.0]])


@pytest.mark.parametrize("name, value", [("QN", -1.0), ("QN", INDEFINITE), ("RN", -1.0), ("RN", 0.0), ("P0", INDEFINITE)])
def test_a_covariance_of_a_filter_that_is_none_is_named(name, value):
    plant = lg.plant(["x2", "-sin(x1)"], ["x1"])
    arguments = {"QN": 0.1, "RN": 0.1, "P0": 1.0, name: value}
    with pytest.raises(lg.NotPositiveDefinite) as found:
        lg.ekf(plant, dt=0.1, **arguments)
    assert isinstance(found.value, np.linalg.LinAlgError)
    assert found.value.what == name and str(found.value).startswith(name)
    # By hand: -1 and 3 are the eigenvalues of INDEFINITE.
    assert found.value.lambda_min == pytest.approx(0.0 if name == "RN" and value == 0.0 else -1.0)


@pytest.mark.parametrize("given, least", [(-1, -1.0), ([1.0, -2.0], -2.0), (INDEFINITE.tolist(), -1.0)])
def test_a_covariance_of_a_kind_has_the_name_of_its_key(given, least):
    plant = lg.plant(["x2", "-sin(x1)"], ["x1"])
    with pytest.raises(lg.NotPositiveDefinite) as found:
        lg.observer("ukf", plant, w=given, v=1, period=0.1)
    assert found.value.what == "W" and found.value.lambda_min == pytest.approx(least)


@pytest.mark.parametrize("name, arguments", [("QN", (-1.0, 1.0)), ("RN", (1.0, -1.0))])
def test_a_covariance_of_a_stationary_filter_is_named(name, arguments):
    with pytest.raises(lg.NotPositiveDefinite) as found:
        lg.lqe(SYS, *arguments)
    assert found.value.what == name and str(found.value).startswith(name)


@pytest.mark.parametrize("name", ["QN", "P0"])
def test_an_asymmetric_covariance_of_a_filter_is_named(name):
    plant = lg.plant(["x2", "-sin(x1)"], ["x1"])
    with pytest.raises(lg.NotSymmetric) as found:
        lg.ekf(plant, dt=0.1, **{"QN": 0.1, "RN": 0.1, name: ASYMMETRIC})
    assert found.value.what == name
