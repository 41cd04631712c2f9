"""Ctrl-C in long computations, and other threads beside them."""

import subprocess
import sys
import textwrap
import threading
import time

import luenberger as lg
import numpy as np
import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no signals")

HEAD = """
import os, signal, threading, time
import luenberger as lg, numpy as np
plant = lg.ss([[0.9, 0.1], [0.0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1)

def interrupted(work):
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    try:
        work()
    except KeyboardInterrupt:
        print("took", time.monotonic() - began)
    burnt = time.process_time()
    time.sleep(1.0)
    print("burnt", time.process_time() - burnt)
"""

LONG = {
    "step": """
observer = lg.observer("mhe", plant, w=0.1, v=0.1, period=0.1, window=32)
y = np.random.default_rng(1).standard_normal((1, 1_000_000))
observer.step(0.0, 1.0)
before = observer.xhat
interrupted(lambda: observer.step(np.zeros_like(y), y))
assert observer.xhat.tolist() == before.tolist()
""",
    "simulate": """
van_der_pol = lg.plant(["x2", "1000*(1 - x1^2)*x2 - x1"], ["x1"])
observer = lg.high_gain_observer(van_der_pol, 1000.0)
interrupted(lambda: observer.simulate([2.0, 0.0], 1e5, samples=200_000, noise=1e-6, noise_dt=1e-3))
""",
    "replay": """
observer = lg.observer("particle", plant, w=0.1, v=0.1, period=0.1, particles=200_000)
y = np.random.default_rng(1).standard_normal(3_000)
interrupted(lambda: observer.replay(np.arange(y.size) * 0.1, y))
""",
}


@pytest.mark.parametrize("what", LONG)
def test_ctrl_c_ends_a_call(what):
    code = textwrap.dedent(HEAD) + LONG[what]
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=False)
    assert found.returncode == 0, found.stderr
    numbers = dict(line.split() for line in found.stdout.splitlines())
    # At a second; the times are of a busy machine.
    assert float(numbers["took"]) < 4.0
    # Nothing goes on in the background.
    assert float(numbers["burnt"]) < 0.3


def test_other_threads_go_on_while_one_has_the_observer():
    plant = lg.ss([[0.9, 0.1], [0.0, 0.8]], [[0], [1]], [[1, 0]], dt=0.1)
    observer = lg.observer("mhe", plant, w=0.1, v=0.1, period=0.1, window=16)
    observer.step(0.0, 1.0)
    y = np.random.default_rng(1).standard_normal((1, 40_000))
    stepper = threading.Thread(target=observer.step, args=(np.zeros_like(y), y))
    reader = threading.Thread(target=lambda: observer.xhat)
    stepper.start()
    time.sleep(0.1)
    reader.start()
    gaps, last = [], time.monotonic()
    while stepper.is_alive():
        time.sleep(0.005)
        now = time.monotonic()
        gaps.append(now - last)
        last = now
    reader.join()
    stepper.join()
    assert len(gaps) > 20, "the steps were too short to say anything"
    assert max(gaps) < 0.5, max(gaps)
