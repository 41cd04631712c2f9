"""Solves the joint designs written by `bench_joint --write DIR` with cvxpy, by Clarabel and by SCS; one JSON line each.

    python lmi.py DIR [--largest N]

Needs cvxpy (which brings clarabel and scs) and numpy. The same problem as the Rust example poses: P > 0, P < I,
A'P + PA - YC - C'Y' < 0, S + S' > 0, solved for the largest common margin t with all unknowns in the unit ball, since a solver that is not asked for a
margin returns a point on the boundary. "margin" is the smallest eigenvalue that numpy sees over all constraints at the returned
values, which proves nothing; a margin that is not positive is a design that does not work. "ms" includes building and compiling the problem, as in the Rust
example; "solver_ms" is what the solver reports.
"""

import json
import pathlib
import sys
import time

import cvxpy as cp
import numpy as np


def joint_design(a, c):
    n, p = a.shape[0], c.shape[0]
    P = cp.Variable((n, n), symmetric=True)
    Y = cp.Variable((n, p))
    S = cp.Variable((p, p))
    t = cp.Variable()
    decrease = a.T @ P + P @ a - Y @ c - c.T @ Y.T
    constraints = [
        P >> t * np.eye(n),
        np.eye(n) - P >> t * np.eye(n),
        -(decrease + decrease.T) / 2 >> t * np.eye(n),
        S + S.T >> t * np.eye(p),
        cp.norm(cp.hstack([cp.vec(P, order="F"), cp.vec(Y, order="F"), cp.vec(S, order="F")])) <= np.sqrt(n),
    ]
    return cp.Problem(cp.Maximize(t), constraints), P, Y, S


def margin(a, c, P, Y, S):
    """The smallest eigenvalue over the four constraints."""
    decrease = a.T @ P + P @ a - Y @ c - c.T @ Y.T
    blocks = [P, np.eye(len(a)) - P, -decrease, S + S.T]
    return min(float(np.linalg.eigvalsh((m + m.T) / 2)[0]) for m in blocks)


def main(arguments):
    if not arguments:
        sys.exit(__doc__)
    largest = int(arguments[arguments.index("--largest") + 1]) if "--largest" in arguments else 10**9
    plants = [json.loads(path.read_text()) for path in pathlib.Path(arguments[0]).glob("plant-*.json")]
    for plant in sorted(plants, key=lambda plant: plant["n"]):
        if plant["n"] > largest:
            continue
        a, c = np.array(plant["a"]), np.array(plant["c"])
        for solver in (cp.CLARABEL, cp.SCS):
            line = {"tool": f"cvxpy+{solver}", "n": plant["n"], "p": plant["p"]}
            runs = 5 if plant["n"] <= 10 else 1
            fastest, solver_ms, seen, status = float("inf"), None, None, None
            for _ in range(runs):
                start = time.perf_counter()
                try:
                    problem, P, Y, S = joint_design(a, c)
                    problem.solve(solver=solver)
                    status = problem.status
                except cp.error.SolverError as error:
                    status = f"error: {error}"
                fastest = min(fastest, 1e3 * (time.perf_counter() - start))
                if not status.startswith("error") and P.value is not None:
                    seen = margin(a, c, P.value, Y.value, S.value)
                    solver_ms = 1e3 * (problem.solver_stats.solve_time or 0.0)
            line |= {"ms": round(fastest, 3), "solver_ms": solver_ms, "status": status, "margin": seen}
            print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
