"""Study files: results, progress, interruption, mistakes."""

import os
import signal
import threading
import time

import numpy as np
import pandas
import pytest

import luenberger as lg

TEXT = """
title = "two observers"
[plant]
a = [[0, 1], [-2, -3]]
b = [[0], [1]]
c = [[1, 0]]
[input]
expressions = ["sin(t)"]
[simulation]
x0 = [1, -1]
duration = 5
samples = 101
noise = { amplitude = [0.01], period = 0.05, seed = 3 }
[[observer]]
name = "slow"
kind = "luenberger"
poles = [-3, -4]
[[observer]]
name = "fast"
kind = "luenberger"
poles = [-8, -9]
"""
SWEEP = """
[sweep]
parameter = "noise"
values = [1, 2]
ensemble = 3
"""


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(TEXT)
    return lg.Study(path)


def test_results_are_arrays_and_tables(study, tmp_path):
    assert study.title == "two observers" and study.observers == ["slow", "fast"]
    calls = []
    results = study.run(progress=lambda *reported: calls.append((threading.current_thread(), reported)))
    assert results.verdicts == {"slow": "proved", "fast": "proved"} and not results.failures
    assert results["fast"].xhat.shape == (2, 101)
    np.testing.assert_allclose(
        np.linalg.eigvals(np.array([[0, 1], [-2, -3]]) - results.designs["slow"]["L"] @ [[1, 0]]), [-4, -3]
    )
    frame = pandas.DataFrame(results.scores)
    assert list(frame["observer"]) == ["slow", "slow", "fast", "fast"] and frame["rmse"].notna().all()
    assert pandas.DataFrame(results["slow"].to_dict()).shape == (101, 7)
    assert {reported[0] for _, reported in calls} >= {"design", "simulate"}
    assert all(thread is threading.main_thread() for thread, _ in calls)
    text = results._repr_html_()
    assert "two observers" in text and "proved" in text and "scores" in text
    # The same observer by itself gives the same estimates.
    alone = lg.place_observer(([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]]), [-3, -4])
    run = alone.simulate([1, -1], 5, u="sin(t)", samples=101, noise=0.01, noise_dt=0.05, seed=3)
    np.testing.assert_array_equal(run.xhat, results["slow"].xhat)
    with pytest.raises(KeyError):
        results["nobody"]


def test_results_folder(study, tmp_path):
    folder = tmp_path / "results"
    study.run(output=folder)
    assert (folder / "study.json").is_file() and (folder / "report.html").is_file()
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "letter.txt").write_text("dear")
    with pytest.raises(lg.StudyError, match="force=True"):
        study.run(output=tmp_path / "foreign")
    study.run("design", output=tmp_path / "foreign", force=True)
    assert (tmp_path / "foreign" / "letter.txt").read_text() == "dear"


def test_a_sweep_is_a_table():
    results = lg.Study.from_text(TEXT + SWEEP).run("sweep", threads=2)
    frame = pandas.DataFrame(results.sweep)
    assert len(frame) == 4 and set(frame["value"]) == {1.0, 2.0} and (frame["finished"] == 3).all()
    assert {"x1.rmse", "percentile95.x2.peak"} <= set(frame.columns)
    assert not any(isinstance(cell, (list, dict)) for column in results.sweep.values() for cell in column)
    one = lg.Study.from_text(TEXT + SWEEP).run("sweep", threads=1)
    assert one.sweep == results.sweep


def test_plots_are_axes():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    results = lg.Study.from_text(TEXT).run("simulate")
    axes = results.plot()
    assert len(axes) == 2 and len(axes[0].lines) == 4
    assert len(results["slow"].plot(["x2"])) == 1


def test_what_a_callback_raises_comes_through(study):
    class Mine(Exception):
        pass

    def raises(*_):
        raise Mine("enough")

    with pytest.raises(Mine, match="enough"):
        study.run(progress=raises)
    with pytest.raises(TypeError):
        study.run(progress=lambda: None)
    assert study.run("design").verdicts["slow"] == "proved"


def long_study():
    text = TEXT.replace("duration = 5", "duration = 2000").replace("samples = 101", "samples = 20001")
    return lg.Study.from_text(text + SWEEP.replace("ensemble = 3", "ensemble = 100000"))


def test_control_c_ends_an_execution():
    timer = threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        long_study().run("sweep", memory_limit=1e15, time_limit=1e9)
    timer.join()
    assert time.monotonic() - start < 30


def test_the_interpreter_runs_meanwhile():
    ticks = []
    done = threading.Event()

    def tick():
        while not done.wait(0.01):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    stop = time.monotonic() + 1.0

    def progress(*_):
        if time.monotonic() > stop:
            raise StopIteration

    with pytest.raises(StopIteration):
        long_study().run("sweep", progress=progress, memory_limit=1e15, time_limit=1e9)
    done.set()
    thread.join()
    assert len(ticks) > 20


def test_studies_run_in_several_threads(study):
    found = []

    def run():
        found.append(study.run("simulate")["slow"].xhat)

    threads = [threading.Thread(target=run) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4 and all(np.array_equal(xhat, found[0]) for xhat in found)


def test_mistakes_have_line_and_column(tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(TEXT.replace("poles = [-3, -4]", "pols = [-3, -4]"))
    with pytest.raises(lg.StudyFileError) as found:
        lg.Study(path)
    (mistake, *_) = [one for one in found.value.diagnostics if "pols" in one["message"]]
    assert mistake["line"] == 17 and mistake["column"] == 1 and "poles" in mistake["help"]
    with pytest.raises(FileNotFoundError):
        lg.Study(tmp_path / "none.toml")
    with pytest.raises(lg.InvalidArgument):
        lg.Study.from_text(TEXT).run("dance")
    with pytest.raises(lg.StudyError, match="sweep"):
        lg.Study.from_text(TEXT).run("sweep")


def test_an_observer_that_is_not_applicable_is_a_result():
    text = TEXT.replace("c = [[1, 0]]", "c = [[0, 0]]").replace("a = [[0, 1], [-2, -3]]", "a = [[1, 0], [0, 2]]")
    results = lg.Study.from_text(text).run("design")
    assert set(results.verdicts.values()) == {"not applicable"} and len(results.failures) == 2
    assert "not applicable" in results._repr_html_()


@pytest.mark.parametrize("is_file", [True, False])
def test_a_study_is_copied_and_pickled(is_file, tmp_path):
    import copy
    import pickle

    (tmp_path / "study.toml").write_text(TEXT)
    study = lg.Study(tmp_path / "study.toml") if is_file else lg.Study.from_text(TEXT, folder=tmp_path)
    expected = study.run("simulate")["slow"].xhat
    for again in (copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))):
        other = again(study)
        assert other.title == study.title and other.run("simulate")["slow"].xhat.tolist() == expected.tolist()
    kept = pickle.dumps(study)
    (tmp_path / "study.toml").write_text(TEXT.replace("-3, -4", "-3, -5"))
    if is_file:
        with pytest.raises(lg.StudyError, match="has changed"):
            pickle.loads(kept)
    else:
        assert pickle.loads(kept).run("simulate")["slow"].xhat.tolist() == expected.tolist()


def test_studies_run_in_other_processes():
    joblib = pytest.importorskip("joblib")
    study = lg.Study.from_text(TEXT)
    (found,) = joblib.Parallel(2)([joblib.delayed(lg.Study.run)(study, "simulate")])
    assert found["slow"].xhat.tolist() == study.run("simulate")["slow"].xhat.tolist()


def test_a_step_that_is_none_is_named_with_those_that_are():
    with pytest.raises(lg.InvalidArgument, match="the nearest is 'simulate'; expected run, observe, design"):
        lg.Study.from_text(TEXT).run("simulat")
