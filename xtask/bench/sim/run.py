"""Times integrators on the same problems, interleaved, and checks what they return.

    python run.py SIM-BENCH FOLDER

Every row is a pair of a program and a problem; a round runs all of them once, and the median of the rounds counts. The error is that of the final state
against a solution with tolerances near rounding, divided by the largest entry of that state. Writes sim.json and sim.md into the folder.
"""

import json
import pathlib
import statistics
import subprocess
import sys
import time

import numpy as np
import scipy
from scipy.integrate import solve_ivp

L, N, THETA = (7.0, 10.0), (-168 / 17, -196 / 17), 10.0


def cubic(t, x):
    y = x[0] - x[2]
    pull = THETA * y**3
    return [x[1], 0.0, x[3] + L[0] * y - N[0] * pull, L[1] * y - N[1] * pull]


def van_der_pol(mu):
    return lambda t, x: [x[1], mu * (1 - x[0] * x[0]) * x[1] - x[0]]


def chain(t, x):
    n = len(x) // 2
    force = -2 * x[:n] - 0.1 * x[n:]
    force[1:] += x[: n - 1]
    force[:-1] += x[1:n]
    return np.concatenate([x[n:], force])


# Problem: right-hand side, start, end, relative tolerances, others than us, and how often a call is repeated within a measurement.
PROBLEMS = {
    "cubic": (cubic, [3, 3, 0, 0], 4, [1e-6, 1e-9], ["DOP853", "LSODA", "differential-equations", "scenario"], 200),
    "van-der-pol": (van_der_pol(5), [2, 0], 20, [1e-6, 1e-9], ["DOP853", "LSODA", "differential-equations"], 100),
    "chain": (chain, [1] + [0] * 39, 20, [1e-6, 1e-9], ["DOP853", "LSODA", "differential-equations"], 50),
    "stiff-van-der-pol": (van_der_pol(1000), [2, 0], 2000, [1e-6, 1e-9], ["Radau", "LSODA", "diffsol"], 5),
}
WORDS = {
    "luenberger": "luenberger, `solve`",
    "scenario": "luenberger, `Scenario`",
    "DOP853": "scipy DOP853",
    "LSODA": "scipy LSODA",
    "Radau": "scipy Radau",
    "differential-equations": "differential-equations, DOP853",
    "diffsol": "diffsol, BDF",
}
ROUNDS = 7


def scipys(method, problem, rtol):
    f, start, end, *_ = PROBLEMS[problem]
    began = time.perf_counter()
    solution = solve_ivp(f, (0, end), np.array(start, float), method=method, rtol=rtol, atol=rtol * 1e-3, dense_output=True)
    us = (time.perf_counter() - began) * 1e6
    return {"us": us, "end": list(solution.y[:, -1]), "calls": solution.nfev} if solution.success else {"error": solution.message}


def once(binary, who, problem, rtol):
    if who in ("DOP853", "LSODA", "Radau"):
        return scipys(who, problem, rtol)
    words = [binary, who, problem, repr(rtol), str(PROBLEMS[problem][5])]
    return json.loads(subprocess.run(words, capture_output=True, check=True, text=True).stdout)


def reference(problem):
    f, start, end, *_ = PROBLEMS[problem]
    method, rtol = ("Radau", 1e-12) if problem.startswith("stiff") else ("DOP853", 3e-14)
    solution = solve_ivp(f, (0, end), np.array(start, float), method=method, rtol=rtol, atol=1e-15)
    return solution.y[:, -1]


def main(binary, folder):
    rows = [(problem, rtol, who) for problem, (_, _, _, rtols, others, _) in PROBLEMS.items() for rtol in rtols for who in ["luenberger", *others]]
    times = {row: [] for row in rows}
    last = {}
    for _ in range(ROUNDS):
        for problem, rtol, who in rows:
            answer = once(binary, who, problem, rtol)
            last[problem, rtol, who] = answer
            if "us" in answer:
                times[problem, rtol, who].append(answer["us"])
    truth = {problem: reference(problem) for problem in PROBLEMS}
    results, lines = [], ["| problem | rtol | program | us | ratio | calls | error |", "|---|---:|---|---:|---:|---:|---:|"]
    for problem, rtol, who in rows:
        answer, ours = last[problem, rtol, who], statistics.median(times[problem, rtol, "luenberger"])
        if "error" in answer:
            lines.append(f"| {problem} | {rtol:g} | {WORDS[who]} | {answer['error']} | | | |")
            continue
        us = statistics.median(times[problem, rtol, who])
        error = float(np.max(np.abs(np.array(answer["end"]) - truth[problem])) / np.max(np.abs(truth[problem])))
        results.append({"problem": problem, "rtol": rtol, "program": WORDS[who], "us": us, "calls": answer["calls"], "error": error})
        lines.append(f"| {problem} | {rtol:g} | {WORDS[who]} | {us:.4g} | {us / ours:.2g} | {answer['calls'] or '–'} | {error:.1e} |")
    versions = f"scipy {scipy.__version__}, numpy {np.__version__}"
    (pathlib.Path(folder) / "sim.json").write_text(json.dumps({"versions": versions, "rows": results}, indent=1) + "\n")
    (pathlib.Path(folder) / "sim.md").write_text("\n".join(lines) + "\n")


main(*sys.argv[1:])
