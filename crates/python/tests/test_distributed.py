"""Sweeps on a Dask cluster of processes: the same bytes as in one process, whatever happens to the workers."""

import os
import signal
import threading
import time

import pytest

import luenberger as lg

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
lgd = pytest.importorskip("luenberger.distributed")

STUDY = """
[plant]
a = [[0, 1], [-2, -3]]
c = [[1, 0]]
[simulation]
x0 = [1, -1]
duration = 20
samples = 101
noise = { amplitude = [0.01], period = 0.02, seed = 3 }
[[observer]]
name = "slow"
kind = "luenberger"
poles = [-3, -4]
[sweep]
parameter = "noise"
values = [1, 2]
ensemble = 240
seed = 7
"""
FILES = ("sweep.csv", "study.json")


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "study.toml"
    path.write_text(STUDY)
    return path


@pytest.fixture(scope="module")
def expected(study, tmp_path_factory):
    folder = tmp_path_factory.mktemp("single") / "results"
    lg.Study(study).run("sweep", output=folder, threads=1, block_size=10)
    return [(folder / name).read_bytes() for name in FILES]


@pytest.fixture(scope="module")
def cluster():
    workers = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with dask.config.set({"distributed.scheduler.allowed-failures": 1}), distributed.Client(**workers) as client:
        yield client


def found(folder):
    return [(folder / name).read_bytes() for name in FILES]


def test_the_same_bytes_as_in_one_process(study, expected, cluster, tmp_path):
    reported = []
    results = lgd.sweep(study, cluster, tmp_path, block_size=10, progress=lambda *now: reported.append(now))
    assert found(tmp_path) == expected
    assert reported[0] == (0, 48) and reported[-1] == (48, 48)
    assert results.sweep["finished"] == [240, 240]
    # Nothing is left to do.
    reported.clear()
    lgd.sweep(study, cluster, tmp_path, progress=lambda *now: reported.append(now))
    assert reported == [(48, 48)] and found(tmp_path) == expected


def test_workers_are_killed_and_nothing_is_lost_or_counted_twice(study, expected, cluster, tmp_path):
    def kill():
        time.sleep(0.3)
        for pid in list(cluster.run(os.getpid).values()):
            os.kill(pid, signal.SIGKILL)
            time.sleep(0.5)

    killer = threading.Thread(target=kill)
    killer.start()
    lgd.sweep(study, cluster, tmp_path, block_size=10)
    killer.join()
    assert found(tmp_path) == expected


def test_an_interrupted_sweep_is_resumed(study, expected, cluster, tmp_path):
    class Enough(Exception):
        pass

    def progress(done, total):
        if done >= 10:
            raise Enough

    with pytest.raises(Enough):
        lgd.sweep(study, cluster, tmp_path, block_size=10, progress=progress)
    assert 10 <= lgd.status(tmp_path)["done"] < 48
    with pytest.raises(lg.StudyError, match="missing"):
        lgd.reduce(tmp_path)
    # A block that is cut short is found and computed again.
    block = next((tmp_path / "blocks").glob("*.npz"))
    block.write_bytes(block.read_bytes()[:100])
    lgd.sweep(study, cluster, tmp_path)
    assert found(tmp_path) == expected and lgd.status(tmp_path, verify=True)["faults"] == []


def test_a_changed_study_begins_again_on_the_same_workers(study, expected, cluster, tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("seed = 7", "seed = 8"))
    lgd.sweep(path, cluster, tmp_path / "results", block_size=10)
    assert found(tmp_path / "results") != expected
    path.write_text(STUDY)
    lgd.sweep(path, cluster, tmp_path / "results", block_size=10, restart=True)
    assert found(tmp_path / "results") == expected


def test_mistakes_are_errors(study, cluster, tmp_path):
    lgd.sweep(study, cluster, tmp_path / "results", block_size=100)
    other = tmp_path / "other.toml"
    other.write_text(STUDY.replace("seed = 7", "seed = 8"))
    with pytest.raises(lg.StudyError, match="another sweep.*restart=True"):
        lgd.sweep(other, cluster, tmp_path / "results")
    without = tmp_path / "without.toml"
    without.write_text(STUDY.split("[sweep]")[0])
    with pytest.raises(lg.StudyError, match="sweep"):
        lgd.sweep(without, cluster, tmp_path / "none")
    with pytest.raises(lg.StudyError):
        lgd.status(tmp_path / "nowhere")
    with pytest.raises(lg.InvalidArgument):
        lgd.sweep(study, cluster, tmp_path / "results", retries=-1)
