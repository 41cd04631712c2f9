"""This project's matrix equations beside scipy, slycot, python-control, nalgebra and deimos_numerics, on the same matrices.

    python run.py SERVER FOLDER [--largest N] [--mor FOLDER] [--routine NAME ..]

Interleaved: each sample is one call of ours and then one of the peer's (small orders: as many calls as fill a millisecond), and the ratio reported is the median
over the samples of theirs to ours. One thread for each program (set OPENBLAS_NUM_THREADS=1). The residuals of both are computed here, by the same code.
Writes linalg.json, linalg.md and, with a line for each matrix, linalg-summary.md into FOLDER.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import time
import warnings

import control
import numpy as np
import scipy.io
import scipy.linalg as sla
import scipy.signal
import slycot

ORDERS = [2, 4, 6, 10, 20, 50, 100, 200, 500, 1000]
# Kronecker products of order n^2, or n^4 for placement: beyond these the peer takes minutes.
LIMITS = {("deimos_numerics", "lyapunov"): 20, ("deimos_numerics", "dlyap"): 20, ("deimos_numerics", "care"): 100, ("nalgebra", "schur"): 500}
PLACE_LARGEST = 50
# Flops of the method, in n^3: what products at the machine's peak would take is the limit.
FLOPS = {"schur": 25, "lyapunov": 34, "dlyap": 39, "sylvester": 60, "care": 250}


class Ours:
    """The Rust side: a process that keeps the matrices and times itself."""

    def __init__(self, server, folder):
        self.process = subprocess.Popen([server], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.folder = folder

    def ask(self, **request):
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def load(self, name, matrix):
        file = self.folder / f"{name}.bin"
        file.write_bytes(np.asfortranarray(matrix, dtype=float).tobytes(order="F"))
        self.ask(do="load", name=name, rows=matrix.shape[0], cols=matrix.shape[1], file=str(file))

    def answer(self, who, routine):
        file = self.folder / "answer.bin"
        reply = self.ask(do="keep", who=who, routine=routine, file=str(file))
        if "error" in reply:
            return reply["error"]
        numbers, found = np.fromfile(file), []
        for rows, cols in reply["shapes"]:
            found.append(numbers[: rows * cols].reshape((rows, cols), order="F"))
            numbers = numbers[rows * cols :]
        return found


def stable(rng, n):
    """Dense, spectral abscissa -0.1: the common case."""
    a = rng.standard_normal((n, n)) / math.sqrt(n)
    return a - (np.linalg.eigvals(a).real.max() + 0.1) * np.eye(n)


def scaled(rng, n):
    """The same in units of the states eight decades apart."""
    d = np.exp2(np.round(rng.uniform(-13, 13, n)))
    return stable(rng, n) * d[:, None] / d[None, :]


def defective(rng, n):
    """Jordan blocks of order up to five, in orthogonal coordinates."""
    t = np.diag(-1.0 - np.arange(n) // 5 * 0.37) + np.diag(np.where(np.arange(1, n) % 5 == 0, 0.0, 1.0), 1)
    q, _ = np.linalg.qr(rng.standard_normal((n, n)))
    return q @ t @ q.T


def unstable(rng, n):
    """Spectral abscissa 0.5: with one input or two the solution of the Riccati equation is large in a few directions."""
    return stable(rng, n) + 0.6 * np.eye(n)


def problem(rng, kind, n, a=None, inputs=None):
    a = {"random": stable, "scaled": scaled, "defective": defective, "unstable": unstable}[kind](rng, n) if a is None else a
    inputs = max(1, min(3, n // 2)) if inputs is None else inputs
    g = rng.standard_normal((n, n)) / math.sqrt(n)
    b = rng.standard_normal((n, inputs))
    poles = np.column_stack([-1.0 - np.arange(n) / n, np.zeros(n)])
    return {"a": a, "q": g @ g.T + np.eye(n), "r": np.eye(inputs), "b": b, "c": rng.standard_normal((n, n)), "poles": poles}


def arguments(routine, d):
    """What each routine sees: Stein's A inside the unit circle, Sylvester's second coefficient of the order of the first."""
    d = dict(d)
    if routine == "dlyap":
        d["a"] = d["a"] * (0.95 / max(abs(np.linalg.eigvals(d["a"]))))
    if routine == "sylvester":
        d["b"] = np.ascontiguousarray(d["a"].T)
    if routine == "h-infinity-norm":
        # Three outputs.
        d["c"] = np.ascontiguousarray(d["c"][:3])
        d["d"] = np.zeros((3, d["b"].shape[1]))
    return d


def peers(routine, d):
    """The other tools' calls for the same answer, each with the matrices of the residual."""
    a, q, n = d["a"], d["q"], len(d["a"])
    at = np.ascontiguousarray(a.T)
    if routine == "schur":
        return {"scipy schur": lambda: tuple(reversed(sla.schur(a)))}
    if routine == "lyapunov":
        return {
            "scipy solve_continuous_lyapunov": lambda: (sla.solve_continuous_lyapunov(at, -q),),
            "slycot sb03md": lambda: (slycot.sb03md57(a.copy(order="F"), C=-q, dico="C")[2],),
            "python-control lyap": lambda: (np.asarray(control.lyap(at, q)),),
        }
    if routine == "dlyap":
        return {
            "scipy solve_discrete_lyapunov": lambda: (sla.solve_discrete_lyapunov(at, q),),
            "slycot sb03md": lambda: (slycot.sb03md57(a.copy(order="F"), C=-q, dico="D")[2],),
        }
    if routine == "sylvester":
        return {
            "scipy solve_sylvester": lambda: (sla.solve_sylvester(a, d["b"], d["c"]),),
            "slycot sb04md": lambda: (slycot.sb04md(n, n, a.copy(order="F"), d["b"].copy(order="F"), d["c"].copy(order="F")),),
        }
    if routine == "care":
        return {
            "scipy solve_continuous_are": lambda: (sla.solve_continuous_are(a, d["b"], q, d["r"]),),
            "slycot sb02md": lambda: (slycot.sb02md(n, a.copy(order="F"), d["b"] @ d["b"].T, q.copy(order="F"), "C")[0],),
        }
    if routine == "h-infinity-norm":
        return {"slycot ab13dd": lambda: (np.array([[peak_of(d, 1e-10)]]),)}
    specified = d["poles"][:, 0] + 1j * d["poles"][:, 1]
    m = d["b"].shape[1]
    w = specified.astype(complex)
    return {
        "scipy place_poles": lambda: (scipy.signal.place_poles(a, d["b"], specified).gain_matrix,),
        "slycot sb01bd": lambda: (-slycot.sb01bd(n, m, n, -1e300, a.copy(order="F"), d["b"].copy(order="F"), w.copy(), "C")[5],),
    }


def peak_of(d, tolerance):
    """The H-infinity norm of SLICOT, to a relative tolerance."""
    a, b, c = (np.asfortranarray(d[name]) for name in "abc")
    n, m, p = len(a), b.shape[1], len(c)
    return slycot.ab13dd("C", "I", "N", "Z", n, m, p, a, np.eye(n, order="F"), b, c, np.asfortranarray(d["d"]), tolerance)[0]


def residual(routine, d, found):
    """Relative, in the Frobenius norm; for placement the largest distance of a pole from its specified place, relative to the largest; of a norm its distance from that of SLICOT to fifteen digits."""
    a, q, norm = d["a"], d["q"], np.linalg.norm
    if routine == "schur":
        u, t = found
        return float(max(norm(u @ t @ u.T - a) / norm(a), norm(u.T @ u - np.eye(len(a)))))
    x = found[0]
    if routine == "h-infinity-norm":
        return float(abs(x[0, 0] / peak_of(d, 1e-15) - 1))
    if routine == "lyapunov":
        return float(norm(a.T @ x + x @ a + q) / (2 * norm(a) * norm(x) + norm(q)))
    if routine == "dlyap":
        return float(norm(a.T @ x @ a - x + q) / ((norm(a) ** 2 + 1) * norm(x) + norm(q)))
    if routine == "sylvester":
        return float(norm(a @ x + x @ d["b"] - d["c"]) / ((norm(a) + norm(d["b"])) * norm(x) + norm(d["c"])))
    if routine == "care":
        # By the gain: X G X, from the left, drowns in its rounding where X is large.
        k = d["b"].T @ x
        terms = 2 * norm(a) * norm(x) + norm(k.T @ k) + norm(q)
        return float(norm(a.T @ x + x @ a - k.T @ k + q) / terms)
    specified = np.sort_complex(d["poles"][:, 0] + 1j * d["poles"][:, 1])
    poles = np.sort_complex(np.linalg.eigvals(a - d["b"] @ x))
    return float(abs(poles - specified).max() / abs(specified).max())


def timed(call, times):
    start = time.perf_counter()
    for _ in range(times):
        call()
    return (time.perf_counter() - start) * 1e3 / times


def measure(ours, routine, n, matrix, d, peak):
    rows = []
    for name, m in d.items():
        ours.load(name, m)
    answer = ours.answer("luenberger", routine)
    if isinstance(answer, str):
        return [{"routine": routine, "n": n, "matrix": matrix, "error_ours": answer}]
    residual_ours = residual(routine, d, answer)
    contenders = [(name, call, None) for name, call in peers(routine, d).items()]
    for crate in ["nalgebra", "deimos_numerics"]:
        known = {"nalgebra": ["schur"], "deimos_numerics": ["lyapunov", "dlyap", "care", "place"]}[crate]
        if routine in known and n <= LIMITS.get((crate, routine), 10**9):
            contenders.append((crate, None, crate))
    for name, call, crate in contenders:
        row = {"routine": routine, "n": n, "matrix": matrix, "ours_ms": None, "peer": name, "peer_ms": None, "ratio": None}
        row |= {"residual_ours": residual_ours, "residual_peer": None, "limit_ms": None}
        if routine in FLOPS:
            row["limit_ms"] = FLOPS[routine] * n**3 / (peak * 1e6)
        rows.append(row)
        try:
            found = call() if crate is None else ours.answer(crate, routine)
        except Exception as why:  # a peer that gives up is a row, not the end
            found = str(why)
        if isinstance(found, str):
            row["error_peer"] = found.splitlines()[0][:120]
            row["ours_ms"] = ours.ask(do="run", who="luenberger", routine=routine, times=1)["ms"]
            continue
        row["residual_peer"] = residual(routine, d, found)
        once = ours.ask(do="run", who="luenberger", routine=routine, times=1)["ms"]
        times = max(1, min(1000, int(1.0 / max(once, 1e-4))))
        samples = []
        budget = time.perf_counter() + (6.0 if n < 1000 else 20.0)
        while len(samples) < (31 if n <= 100 else 9) and (len(samples) < 3 or time.perf_counter() < budget):
            mine = ours.ask(do="run", who="luenberger", routine=routine, times=times)["ms"]
            if crate is None:
                theirs = timed(call, times)
            else:
                theirs = ours.ask(do="run", who=crate, routine=routine, times=times)["ms"]
            samples.append((mine, theirs))
        row["ours_ms"] = statistics.median(s[0] for s in samples)
        row["peer_ms"] = statistics.median(s[1] for s in samples)
        row["ratio"] = statistics.median(s[1] / s[0] for s in samples)
    return rows


def table(rows, peak):
    def number(x, pattern):
        return "–" if x is None else format(x, pattern)

    text = f"Products of order 1000 run at {peak:.1f} Gflop/s here, one thread.\n\n"
    text += "| routine | n | matrix | ours ms | peer | peer ms | peer / ours | residual ours | residual peer | limit ms |\n"
    text += "|---|---:|---|---:|---|---:|---:|---:|---:|---:|\n"
    for r in rows:
        if "error_ours" in r:
            text += f"| {r['routine']} | {r['n']} | {r['matrix']} | {r['error_ours'].replace('|', '/')} | | | | | | |\n"
            continue
        peer_ms = number(r["peer_ms"], ".4g") if "error_peer" not in r else "fails"
        text += f"| {r['routine']} | {r['n']} | {r['matrix']} | {number(r['ours_ms'], '.4g')} | {r['peer']} | {peer_ms} | {number(r['ratio'], '.2f')} "
        text += f"| {number(r['residual_ours'], '.1e')} | {number(r['residual_peer'], '.1e')} | {number(r['limit_ms'], '.3g')} |\n"
    return text


def summary(rows, peak):
    """A table for each routine: a line for each matrix, a column for each peer."""
    text = f"Products of order 1000 ran at {peak:.1f} Gflop/s in the same process.\n"
    for routine in dict.fromkeys(r["routine"] for r in rows):
        mine = [r for r in rows if r["routine"] == routine]
        names = list(dict.fromkeys(r["peer"] for r in mine if "peer" in r))
        text += f"\n### {routine}\n\n| n | matrix | ours, ms | limit | " + " | ".join(names) + " | residual: ours | the best of theirs |\n"
        text += "|---:|---|---:|---:|" + "---:|" * len(names) + "---:|---:|\n"
        for n, matrix in dict.fromkeys((r["n"], r["matrix"]) for r in mine):
            here = [r for r in mine if (r["n"], r["matrix"]) == (n, matrix)]
            if "error_ours" in here[0]:
                text += f"| {n} | {matrix} | {here[0]['error_ours'].replace('|', '/')} |" + " |" * (len(names) + 3) + "\n"
                continue
            ours = statistics.median(r["ours_ms"] for r in here)
            limit = here[0]["limit_ms"]
            share = "–" if limit is None else f"{100 * limit / ours:.0f} %" if limit >= 0.01 * ours else f"{100 * limit / ours:.1f} %"
            by_peer = {r["peer"]: "fails" if "error_peer" in r else f"{r['ratio']:.2f}" for r in here}
            theirs = [r["residual_peer"] for r in here if r["residual_peer"] is not None and not math.isnan(r["residual_peer"])]
            best = f"{min(theirs):.1e}" if theirs else "–"
            ratios = " | ".join(by_peer.get(name, "–") for name in names)
            text += f"| {n} | {matrix} | {ours:.3g} | {share} | {ratios} | {here[0]['residual_ours']:.1e} | {best} |\n"
    return text


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("server")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--largest", type=int, default=1000)
    parser.add_argument("--mor", type=pathlib.Path)
    parser.add_argument("--routine", action="append")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    ours = Ours(options.server, options.folder)
    peak = ours.ask(do="peak", n=1000)["gigaflops"]
    rows = []

    def add(routines, n, matrix, d):
        for routine in routines if options.routine is None else [r for r in routines if r in options.routine]:
            new = measure(ours, routine, n, matrix, arguments(routine, d), peak)
            rows.extend(new)
            for r in new:
                shown = "fails" if r.get("ratio") is None else f"{r['ratio']:.2f}"
                print(f"{routine:10} n = {n:4} {matrix:10} {r.get('peer', ''):32} {shown}", file=sys.stderr)
            (options.folder / "linalg.json").write_text(json.dumps(rows, indent=1) + "\n")
            (options.folder / "linalg.md").write_text(table(rows, peak))
            (options.folder / "linalg-summary.md").write_text(summary(rows, peak))

    for n in [n for n in ORDERS if n <= options.largest]:
        for kind in ["random", "scaled", "defective"] if n >= 4 else ["random"]:
            routines = ["schur", "lyapunov", "sylvester", "care", "dlyap", "place"]
            if n > PLACE_LARGEST:
                routines.remove("place")
            if kind != "random":
                routines = ["schur", "lyapunov"]
            add(routines, n, kind, problem(np.random.default_rng(n), kind, n))
        if 4 <= n <= 200:
            add(["h-infinity-norm"], n, "random", problem(np.random.default_rng(n), "random", n))
        if 4 <= n <= PLACE_LARGEST:
            add(["place"], n, "one input", problem(np.random.default_rng(n), "random", n, inputs=1))
        for inputs in [1, 2] if n in (50, 100) else []:
            add(["care"], n, f"unstable, {inputs} in", problem(np.random.default_rng(n), "unstable", n, inputs=inputs))
    for file in sorted(options.mor.glob("*.mat")) if options.mor and options.mor.is_dir() else []:
        a = scipy.io.loadmat(file)["A"]
        a = np.array(a.todense() if hasattr(a, "todense") else a, dtype=float)
        if len(a) <= options.largest:
            add(["schur", "lyapunov"], len(a), file.stem, problem(np.random.default_rng(1), file.stem, len(a), a))


main()
