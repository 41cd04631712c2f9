"""Times integrators on the same problems, interleaved, and checks what they return.

    python run.py SIM-BENCH RUNS FOLDER

Every row is a pair of a program and a problem; a round runs all of them once, and the least time of the rounds counts. The error is that of the final state
against a solution with tolerances near rounding, divided by the largest entry of that state. Writes sim.json and sim.md into the folder.
"""

import json
import math
import pathlib
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


def robertson(t, x):
    slow, fast, faster = 0.04 * x[0], 1e4 * x[1] * x[2], 3e7 * x[1] * x[1]
    return [fast - slow, slow - fast - faster, faster]


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
    "stiff-van-der-pol": (van_der_pol(1000), [2, 0], 2000, [1e-4, 1e-6, 1e-8], ["Radau", "LSODA", "diffsol"], 5),
    "stiff-robertson": (robertson, [1, 0, 0], 4e6, [1e-4, 1e-6, 1e-8], ["Radau", "LSODA", "diffsol"], 5),
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
ROUNDS = 11


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


# Whole runs: of the example study `cart-pole`, and of a linear observer with its input held.
M, MASS, B, I, G, LENGTH = 0.5, 0.2, 0.1, 0.006, 9.81, 0.3
FEEDBACK = np.array([-70.7107, -37.8345, 105.5298, 20.9238])
GAIN = np.array([23.7061, 0.0299409, 145.062, -1.65731, -0.0492469, 41.6805, -5.30579, 306.7]).reshape(4, 2)
H = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0]])
W, V = np.diag([1e-6, 1e-3, 1e-6, 1e-3]), np.diag([2.5e-7, 1e-6])


def cart_pole(x, u):
    _, v, phi, omega = x
    s, c = math.sin(phi), math.cos(phi)
    inertia, arm = I + MASS * LENGTH**2, MASS * LENGTH
    force, d = u - B * v - arm * omega**2 * s, (M + MASS) * inertia - arm**2 * c**2
    return np.array([v, (inertia * force + arm**2 * G * s * c) / d, omega, ((M + MASS) * arm * G * s + arm * c * force) / d])


def cart_pole_jacobian(x, u):
    _, v, phi, omega = x
    s, c = math.sin(phi), math.cos(phi)
    inertia, arm = I + MASS * LENGTH**2, MASS * LENGTH
    force, d = u - B * v - arm * omega**2 * s, (M + MASS) * inertia - arm**2 * c**2
    dd, df = 2 * arm**2 * c * s, -arm * omega**2 * c
    one, two = inertia * force + arm**2 * G * s * c, (M + MASS) * arm * G * s + arm * c * force
    one_phi = (inertia * df + arm**2 * G * (c * c - s * s)) / d - one * dd / d**2
    two_phi = ((M + MASS) * arm * G * c - arm * s * force + arm * c * df) / d - two * dd / d**2
    spin = -2 * arm * omega * s
    return np.array([[0, 1, 0, 0], [0, -inertia * B / d, one_phi, inertia * spin / d], [0, 0, 0, 1], [0, -arm * c * B / d, two_phi, arm * c * spin / d]])


def filter_step(xhat, p, u, y):
    gain = np.linalg.solve(H @ p @ H.T + V, H @ p).T
    keep = np.eye(4) - gain @ H
    xhat, p = xhat + gain @ (y - H @ xhat), keep @ p @ keep.T + gain @ V @ gain.T

    def slope(x, p):
        fp = cart_pole_jacobian(x, u) @ p
        return cart_pole(x, u), fp + fp.T + W

    h = 0.01 / 4
    for _ in range(4):
        k1, p1 = slope(xhat, p)
        k2, p2 = slope(xhat + h / 2 * k1, p + h / 2 * p1)
        k3, p3 = slope(xhat + h / 2 * k2, p + h / 2 * p2)
        k4, p4 = slope(xhat + h * k3, p + h * p3)
        xhat, p = xhat + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), p + h / 6 * (p1 + 2 * p2 + 2 * p3 + p4)
        p = (p + p.T) / 2
    return xhat, p


def cart_pole_run(lpv, noise):
    began = time.perf_counter()
    x, xhat, p, z = np.array([0, 0, 0.1, 0]), np.zeros(4), np.diag([1e-4, 0.01, 0.01, 0.1]), np.zeros(4)
    for k in range(400):
        u = float(-FEEDBACK @ xhat)
        xhat, p = filter_step(xhat, p, u, H @ x + noise[k])
        if lpv:
            f = lambda t, s: np.concatenate([cart_pole(s[:4], u), cart_pole(s[4:], u) + GAIN @ (H @ (s[:4] - s[4:]) + noise[k])])
            s = solve_ivp(f, (0, 0.01), np.concatenate([x, z]), method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
            x, z = s[:4], s[4:]
        else:
            x = solve_ivp(lambda t, x: cart_pole(x, u), (0, 0.01), x, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    return {"us": (time.perf_counter() - began) * 1e6, "end": [*x, *(z if lpv else xhat)]}


# Run: what it is, its name in the program, runs in a round there and rounds of it, the peer.
RUNS = {
    "ekf": ("cart-pole, EKF in the loop", 5, 10, "scipy DOP853 + numpy EKF", lambda noise, _: cart_pole_run(False, noise)),
    "lpv": ("cart-pole, EKF in the loop, LPV", 5, 10, "scipy DOP853 + numpy EKF", lambda noise, _: cart_pole_run(True, noise)),
    "held": ("linear, held input", 10, 20, "the same, integrated", lambda _, binary: program(binary, "integrated", 10, 20)),
}


def program(binary, name, count, rounds):
    return json.loads(subprocess.run([binary, name, str(count), str(rounds)], capture_output=True, check=True, text=True).stdout)


def runs(binary):
    """The table of runs: the difference of the two programs stands for the error of either."""
    noise = np.array(program(binary, "noise", 1, 1))
    lines = ["| run | program | us | runs/s | ratio | difference |", "|---|---|---:|---:|---:|---:|"]
    least = {(name, who): math.inf for name in RUNS for who in ("ours", "peer")}
    last = {}
    for _ in range(ROUNDS):
        for name, (_, count, rounds, _, peer) in RUNS.items():
            last[name, "ours"] = program(binary, name, count, rounds)
            last[name, "peer"] = peer(noise, binary)
            for who in ("ours", "peer"):
                least[name, who] = min(least[name, who], last[name, who]["us"])
    for name, (words, _, _, peer, _) in RUNS.items():
        one, other = (np.array(last[name, who]["end"]) for who in ("ours", "peer"))
        difference = float(np.max(np.abs(one - other)) / np.max(np.abs(other)))
        ours, theirs = least[name, "ours"], least[name, "peer"]
        lines.append(f"| {words} | luenberger | {ours:.4g} | {1e6 / ours:.3g} | 1 | {difference:.1e} |")
        lines.append(f"| {words} | {peer} | {theirs:.4g} | {1e6 / theirs:.3g} | {theirs / ours:.3g} | |")
    return lines


def main(binary, whole, folder):
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
        answer, ours = last[problem, rtol, who], min(times[problem, rtol, "luenberger"])
        if "error" in answer:
            lines.append(f"| {problem} | {rtol:g} | {WORDS[who]} | {answer['error']} | | | |")
            continue
        us = min(times[problem, rtol, who])
        error = float(np.max(np.abs(np.array(answer["end"]) - truth[problem])) / np.max(np.abs(truth[problem])))
        results.append({"problem": problem, "rtol": rtol, "program": WORDS[who], "us": us, "calls": answer["calls"], "error": error})
        lines.append(f"| {problem} | {rtol:g} | {WORDS[who]} | {us:.4g} | {us / ours:.2g} | {answer['calls'] or '–'} | {error:.1e} |")
    versions = f"scipy {scipy.__version__}, numpy {np.__version__}"
    (pathlib.Path(folder) / "sim.json").write_text(json.dumps({"versions": versions, "rows": results}, indent=1) + "\n")
    (pathlib.Path(folder) / "sim.md").write_text("\n".join([*lines, "", *runs(whole)]) + "\n")


main(*sys.argv[1:])
