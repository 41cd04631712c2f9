"""Writes the golden files beside this script, with python-control (its slycot methods): pip install control slycot scipy."""

import json
from pathlib import Path

import control
import numpy as np
import scipy

OUT = Path(__file__).parent
SOURCE = f"python-control {control.__version__} with slycot, scipy {scipy.__version__}"


def plain(value):
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    value = np.asarray(value)
    if np.iscomplexobj(value):
        return [[float(z.real), float(z.imag)] for z in value]
    return value.tolist()


def write(name, command, given, answer):
    lines = [f'"source": {json.dumps(SOURCE)}', f'"command": {json.dumps(command)}']
    for what, values in (("input", given), ("answer", answer)):
        inner = ",\n".join(f'    "{key}": {json.dumps(value)}' for key, value in plain(values).items())
        lines.append(f'"{what}": {{\n{inner}\n  }}')
    (OUT / f"{name}.json").write_text("{\n  " + ",\n  ".join(lines) + "\n}\n")


def random(rng, rows, cols):
    return np.round(rng.uniform(-2, 2, (rows, cols)), 3)


def spread(values):
    """By real part, then imaginary part."""
    return np.array(sorted(np.asarray(values, complex), key=lambda z: (round(z.real, 9), z.imag)))


rng = np.random.default_rng(6)
for order in (1, 4, 7):
    # As it comes from the sensors of a flexible structure: not normal, stable and unstable modes.
    a = random(rng, order, order) - np.eye(order)
    half = random(rng, order, order)
    q = np.round(half @ half.T, 6)
    b, c = random(rng, order, 2), random(rng, 2, order)
    r = np.array([[2.0, 0.5], [0.5, 1.0]])
    write(f"lyap{order}", "lyap", {"a": a, "q": q}, {"x": control.lyap(a, q)})
    write(f"dlyap{order}", "dlyap", {"a": 0.3 * a, "q": q}, {"x": control.dlyap(0.3 * a, q)})
    other = random(rng, 3, 3) + 5 * np.eye(3)
    right = random(rng, order, 3)
    write(f"sylv{order}", "sylv", {"a": a, "b": other, "q": right}, {"x": control.lyap(a, other, right)})
    for command, solve in (("care", control.care), ("dare", control.dare)):
        x, _, k = solve(a, b, q, r)
        # The poles that come with X are those of the Hamiltonian matrix, and hold seven digits; those of A - B K hold fourteen.
        poles = np.linalg.eigvals(a - b @ k)
        write(f"{command}{order}", command, {"a": a, "b": b, "q": q, "r": r}, {"x": x, "k": k, "poles": spread(poles)})
    wished = np.array(([-3.0] if order % 2 else []) + [z for i in range(order // 2) for z in (-1 - i + 2j, -1 - i - 2j)], complex)
    # One input: the gain is unique.
    k = control.place_acker(a, b[:, :1], wished) if order < 7 else control.place(a, b[:, :1], wished)
    write(f"place{order}", "place", {"a": a, "b": b[:, :1], "poles": wished}, {"k": np.atleast_2d(k), "poles": wished})
    write(f"eig{order}", "eig", {"a": a}, {"eigenvalues": spread(np.linalg.eigvals(a))})
    # The last states are hidden: they drive nothing that is seen.
    hidden = a.copy()
    hidden[: order - order // 2, order - order // 2 :] = 0
    seen = c.copy()
    seen[:, order - order // 2 :] = 0
    rank = np.linalg.matrix_rank(control.obsv(hidden, seen))
    write(f"obsv{order}", "obsv", {"a": hidden, "c": seen}, {"rank": int(rank), "unobservable": spread(np.linalg.eigvals(hidden[order - order // 2 :, order - order // 2 :]))})
