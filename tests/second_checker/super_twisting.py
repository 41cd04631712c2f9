"""The super-twisting observer: the matrix inequality of Moreno and Osorio."""

from fractions import Fraction

import words
from labels import inequalities
from rational import Matrix


def super_twisting_observer(file):
    def taken(fields, name):
        return fields.take(name).in_range(lambda x: x > 0, "positive")

    with file.object("observer") as observer:
        k1, k2 = taken(observer, "k1"), taken(observer, "k2")
    with file.object("bounds") as bounds:
        bound = taken(bounds, "F")
    with file.object("lyapunov") as proof:
        p = proof.take("P").symmetric(2)
        alpha, c = taken(proof, "alpha"), taken(proof, "c")
    one, zero = Fraction(1), Fraction(0)
    matrices = {"A": [[-k1, one], [-2 * k2, zero]], "B": [[zero], [one]], "C": [[one, zero]]}
    names = {name: Matrix.of(rows, len(rows[0])) for name, rows in matrices.items()}
    return words.super_twisting_observer(k1, k2, bound, alpha, c), inequalities(
        names | {"P": p, "alpha": alpha, "bound": bound, "c": c},
        "P > 0",
        "[A'P + PA + 2 alpha P + 2 bound^2 C'C, 2PB; *, -2] < 0",
        "c^2 P - C'C >= 0",
    )


KINDS = {"super-twisting-observer": super_twisting_observer}
