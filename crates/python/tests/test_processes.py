"""A process that is forked from one that has computed, as multiprocessing on Linux does."""

import multiprocessing
import sys

import luenberger as lg
import pytest

TEXT = """
[plant]
a = [[0.9, 0.1], [0, 0.8]]
c = [[1, 0]]
dt = 0.1
[[observer]]
name = "fast"
kind = "luenberger"
poles = [0.3, 0.4]
[simulation]
x0 = [1, 1]
duration = 5
[sweep]
parameter = "initial"
values = [1, 2]
ensemble = 20
"""


def rows(step):
    results = lg.Study.from_text(TEXT).run(step)
    return results.sweep if step == "sweep" else results["fast"].xhat.tolist()


def answer(queue, step):
    queue.put(rows(step))


@pytest.mark.skipif(sys.platform == "win32", reason="there is no fork")
@pytest.mark.parametrize("before, step", [("sweep", "sweep"), ("simulate", "sweep"), ("sweep", "simulate")])
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_computes_as_its_parent(before, step):
    rows(before)
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=answer, args=(queue, step))
    child.start()
    try:
        found = queue.get(timeout=60)
        child.join(60)
        assert child.exitcode == 0
    finally:
        if child.is_alive():
            child.kill()
    assert found == rows(step)
