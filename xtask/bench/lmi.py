"""Solves the joint designs written by `bench_joint --write DIR` with cvxpy, by Clarabel and by SCS; one JSON line each.

    python lmi.py DIR [--largest N]

Needs cvxpy (which brings clarabel and scs) and numpy. Each plant is posed three times:

- "literal", as the paper writes them: P >= I, A'P + PA - YC - C'Y' <= -I, Z C + C'Z' <= 0, which has no interior;
- "plain", with Z = -C'S put in: P >= I, A'P + PA - YC - C'Y' <= -I, S + S' >= I, no objective;
- "margin", as the Rust example poses them: P >= tI, P <= (1 - t)I, ... for the largest t, with the norm of the unknowns bounded.

"margin" is the smallest eigenvalue that numpy sees over all strict inequalities at the returned values, divided by the largest eigenvalue of P so
that the two ways compare. It proves nothing; a margin that is not positive is a design that does not work. "ms" includes building and
compiling the problem, as in the Rust example; "solver_ms" is what the solver reports.
"""

import json
import pathlib
import sys
import time

import cvxpy as cp
import numpy as np

LIMIT = 300.0  # s, after which Clarabel returns what it has


def joint_design(a, c, posed):
    n, p = a.shape[0], c.shape[0]
    P = cp.Variable((n, n), symmetric=True)
    Y = cp.Variable((n, p))
    S = cp.Variable((p, p))
    decrease = a.T @ P + P @ a - Y @ c - c.T @ Y.T
    decrease = (decrease + decrease.T) / 2
    if posed == "literal":
        Z = cp.Variable((n, p))
        dissipation = Z @ c + c.T @ Z.T
        constraints = [P >> np.eye(n), decrease << -np.eye(n), (dissipation + dissipation.T) / 2 << 0]
        return cp.Problem(cp.Minimize(0), constraints), P, Y, Z
    if posed == "plain":
        constraints = [P >> np.eye(n), decrease << -np.eye(n), S + S.T >> np.eye(p)]
        return cp.Problem(cp.Minimize(0), constraints), P, Y, S
    t = cp.Variable()
    unknowns = cp.hstack([cp.vec(P, order="F"), cp.vec(Y, order="F"), cp.vec(S, order="F")])
    constraints = [
        P >> t * np.eye(n),
        np.eye(n) - P >> t * np.eye(n),
        -decrease >> t * np.eye(n),
        S + S.T >> t * np.eye(p),
        cp.norm(unknowns) <= np.sqrt(n),
    ]
    return cp.Problem(cp.Maximize(t), constraints), P, Y, S


def margin(a, c, P, Y, S, posed):
    """The smallest eigenvalue over the strict inequalities (over all, if posed literally), for the largest eigenvalue of P scaled to 1."""
    decrease = a.T @ P + P @ a - Y @ c - c.T @ Y.T
    last = -(S @ c + c.T @ S.T) if posed == "literal" else S + S.T
    smallest = min(float(np.linalg.eigvalsh((m + m.T) / 2)[0]) for m in (P, -decrease, last))
    return smallest / float(np.linalg.eigvalsh((P + P.T) / 2)[-1])


def main(arguments):
    if not arguments:
        sys.exit(__doc__)
    largest = int(arguments[arguments.index("--largest") + 1]) if "--largest" in arguments else 10**9
    plants = [json.loads(path.read_text()) for path in pathlib.Path(arguments[0]).glob("plant-*.json")]
    for plant in sorted(plants, key=lambda plant: plant["n"]):
        if plant["n"] > largest:
            continue
        a, c = np.array(plant["a"]), np.array(plant["c"])
        ways = [(posed, solver) for posed in ("literal", "plain", "margin") for solver in (cp.CLARABEL, cp.SCS)]
        # Minutes each: what ours solves, by the faster of the two.
        ways = ways if plant["n"] <= 20 else [("margin", cp.CLARABEL)]
        for posed, solver in ways:
            line = {"tool": f"cvxpy+{solver}", "posed": posed, "n": plant["n"], "p": plant["p"]}
            runs = 5 if plant["n"] <= 10 else 1
            fastest, solver_ms, seen, status = float("inf"), None, None, None
            for _ in range(runs):
                start = time.perf_counter()
                try:
                    problem, P, Y, S = joint_design(a, c, posed)
                    problem.solve(solver=solver, **({"time_limit": LIMIT} if solver == cp.CLARABEL else {}))
                    status = problem.status
                except cp.error.SolverError as error:
                    status = f"error: {error}"
                fastest = min(fastest, 1e3 * (time.perf_counter() - start))
                if not status.startswith("error") and P.value is not None:
                    seen = margin(a, c, P.value, Y.value, S.value, posed)
                    solver_ms = 1e3 * (problem.solver_stats.solve_time or 0.0)
            line |= {"ms": round(fastest, 3), "solver_ms": solver_ms, "status": status, "margin": seen}
            print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
