"""Measures a sweep beside the same study in scipy, interleaved, and the plan for 1e9 runs that follows.

    python run.py LUENBERGER STUDY FOLDER LARGEST

LARGEST is the number of runs of the largest sweep, at which memory is measured. Writes sweep.json and sweep.md into FOLDER.
"""

import json
import os
import pathlib
import platform
import shutil
import statistics
import subprocess
import sys
import time

import numpy as np
import scipy
from scipy.integrate import solve_ivp

L, AMPLITUDE, PERIOD, DURATION, RTOL, ATOL = (4.0, 6.0), 0.05, 0.1, 10.0, 1e-6, 1e-9
PIECES, POINTS = round(DURATION / PERIOD), 5
ROUNDS = 3
# Runs of a measurement: of the command, of scipy one by one, and of scipy with all of them in one state vector.
OURS, SINGLE, TOGETHER = 20_000, 10, 2000


def started(rng, count):
    """Plants at x(0), estimates with an error of norm 1 in a random direction."""
    e = rng.standard_normal((2, count))
    x = np.array([[1.0], [0.0]]) * np.ones(count)
    return np.concatenate([x, x - e / np.linalg.norm(e, axis=0)])


def rates(t, x, noise):
    torque, innovation = 0.5 * np.sin(t), x[0] + noise - x[2]
    return np.array([
        x[1],
        -np.sin(x[0]) - 0.2 * x[1] + torque,
        x[3] + L[0] * innovation,
        -np.sin(x[2]) - 0.2 * x[3] + torque + L[1] * innovation,
    ])


def scipys(method, count, seed):
    """Seconds of the processor, and the root mean square of |e| of each run. The noise jumps, so that the integrator starts anew at each jump."""
    rng = np.random.default_rng(seed)
    began = time.process_time()
    x, squares = started(rng, count), np.zeros(count)
    for k in range(PIECES):
        noise, t0 = rng.uniform(-AMPLITUDE, AMPLITUDE, count), k * PERIOD
        f = lambda t, flat: rates(t, flat.reshape(4, count), noise).ravel()
        times = np.linspace(t0, t0 + PERIOD, POINTS)
        solution = solve_ivp(f, (t0, t0 + PERIOD), x.ravel(), method=method, rtol=RTOL, atol=ATOL, t_eval=times)
        if not solution.success:
            raise SystemExit(f"scipy {method}: {solution.message}")
        states = solution.y.reshape(4, count, POINTS)
        squares += np.trapezoid(((states[:2] - states[2:]) ** 2).sum(axis=0), times, axis=1)
        x = states[:, :, -1]
    return time.process_time() - began, np.sqrt(squares / DURATION)


def command(words):
    """Seconds of wall time, seconds of processors, and the largest resident memory in bytes."""
    began = time.perf_counter()
    peak = 0
    with subprocess.Popen([str(word) for word in words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as child:
        # What wait4 says of the memory includes that of this process, from which the child was forked.
        while not (ended := os.wait4(child.pid, os.WNOHANG))[0]:
            lines = pathlib.Path(f"/proc/{child.pid}/status").read_text().splitlines()
            peak = max([peak] + [1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM:")])
            time.sleep(0.002)
        _, status, usage = ended
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            raise SystemExit(f"{words}: {child.stderr.read()}")
    return time.perf_counter() - began, usage.ru_utime + usage.ru_stime, peak


def size(folder):
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def short(x, digits=3):
    return f"{x:.{digits}g}" if abs(x) < 10**digits else f"{round(x, digits - 1 - int(np.log10(abs(x)))):.0f}"


def main(binary, study, folder, largest):
    folder = pathlib.Path(folder)
    work = folder / "sweep-work"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    text = pathlib.Path(study).read_text()

    def ours(runs, threads):
        """A sweep of so many runs without its reduction."""
        path, out = work / f"study-{runs}.toml", work / f"out-{runs}"
        path.write_text(text.replace("ensemble = 1000", f"ensemble = {runs}"))
        shutil.rmtree(out, ignore_errors=True)
        measured = command([binary, "sweep", path, "-o", out, "--shard", "1/1", "--threads", threads])
        return measured, out

    times = {"threads-1": [], "threads-2": [], "cpu-1": [], "cpu-2": [], "single": [], "together": []}
    rms = []
    for number in range(ROUNDS):
        for threads in (1, 2):
            (seconds, cpu, _), out = ours(OURS, threads)
            times[f"threads-{threads}"].append(seconds / OURS)
            times[f"cpu-{threads}"].append(cpu / OURS)
        single = [scipys("LSODA", 1, 1000 * number + k) for k in range(SINGLE)]
        times["single"].append(sum(seconds for seconds, _ in single) / SINGLE)
        seconds, scores = scipys("DOP853", TOGETHER, number)
        times["together"].append(seconds / TOGETHER)
        rms.append(scores)
    command([binary, "sweep", "reduce", out])
    row = json.loads((out / "study.json").read_text())["sweep"]["rows"][0]
    found = next(entry for entry in row["statistics"] if entry["score"] == "norm_rms")
    rms = np.concatenate(rms)
    error = np.hypot(found["deviation"] / found["count"] ** 0.5, rms.std(ddof=1) / len(rms) ** 0.5)
    if abs(found["mean"] - rms.mean()) > 4 * error:
        raise SystemExit(f"the mean rms of |e| is {found['mean']}, and in scipy {rms.mean()}, with the standard error {error}")

    memory = []
    runs = 1000
    while runs <= largest:
        (_, _, shard), out = ours(runs, 2)
        reduce, cpu, peak = command([binary, "sweep", "reduce", out])
        bare, bare_cpu, _ = command([binary, "sweep", "reduce", out, "--csv", "none"])
        blocks = out / "blocks"
        memory.append({
            "runs": runs, "shard": shard, "peak": peak, "reduce": cpu / runs, "bare": bare_cpu / runs,
            "disk": size(blocks) / runs, "files": len(list(blocks.glob("*.npz"))),
        })
        shutil.rmtree(out)
        runs *= 10
    best = {name: min(values) for name, values in times.items()}
    best["load"] = os.getloadavg()[1]
    result = {"machine": platform.processor() or platform.machine(), "cores": os.cpu_count(), "scipy": scipy.__version__,
              "times": times, "memory": memory, "mean": [found["mean"], rms.mean(), error]}
    (folder / "sweep.json").write_text(json.dumps(result, indent=1) + "\n")
    (folder / "sweep.md").write_text(summary(best, memory, found, rms, error))
    shutil.rmtree(work)


def summary(best, memory, found, rms, error):
    names = {
        "cpu-1": "luenberger",
        "together": f"scipy DOP853, {TOGETHER} runs in one state vector",
        "single": "scipy LSODA, one run after the other",
    }
    lines = ["| program | ms of a core per run | runs/s and core | ratio |", "|---|---:|---:|---:|"]
    for name, words in names.items():
        t = best[name]
        lines.append(f"| {words} | {short(1e3 * t)} | {short(1 / t)} | {short(t / best['cpu-1'])} |")
    one, two = best["threads-1"], best["threads-2"]
    lines += [
        "",
        f"By the clock {short(1 / one)} runs/s with 1 thread and {short(1 / two)} with 2 on {os.cpu_count()} cores: parallel efficiency "
        f"{one / (2 * two):.0%}; a run takes {short(1e3 * best['cpu-2'])} ms of a core with 2 threads. Best of {ROUNDS} rounds; the load "
        f"average of the machine was {best['load']:.1f}, its other programs included.",
        "",
        f"The mean rms of the error norm is {short(found['mean'], 5)} here and {short(rms.mean(), 5)} in scipy, with other random "
        f"numbers; the standard error of the difference is {short(error, 2)}.",
        "",
        "| runs | blocks | memory of a shard, MB | memory of the reduction, MB | bytes per run on disk | reduction, us per run | without CSV |",
        "|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in memory:
        lines.append(
            f"| {row['runs']:.0e} | {row['files']} | {row['shard'] / 1e6:.0f} | {row['peak'] / 1e6:.0f} | {row['disk']:.0f} "
            f"| {short(1e6 * row['reduce'])} | {short(1e6 * row['bare'])} |".replace("e+0", "e")
        )
    last, runs = memory[-1], 1e9
    hours = runs * best["cpu-1"] / 3600
    size, scores = 100_000, 21
    lines += [
        "",
        "The plan for 1e9 runs of this study, at one value, from these numbers:",
        "",
        "| | |",
        "|---|---|",
        f"| processor time | {short(hours)} core hours: {short(hours / 1000)} hours on 1000 cores |",
        f"| blocks of {size} runs | {runs / size:.0f} files of {last['disk'] * size / 1e6:.0f} MB, {runs * last['disk'] / 1e9:.0f} GB |",
        f"| time of a block on one core | {short(size * best['cpu-1'] / 60)} min: the most that a killed shard loses |",
        f"| reduction, one process | 4 passes: {short(runs * (last['reduce'] + 3 * last['bare']) / 3600)} core hours, "
        f"{short(4 * runs * last['bare'] / 3600)} with `--csv none` |",
        f"| memory of the reduction | {1.5 * scores:.0f} MiB for the percentiles, and the blocks and lines in progress |",
    ]
    return "\n".join(lines) + "\n"


main(sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4]))
