"""The super-twisting observer: the matrix inequality of Moreno and Osorio."""

import words
from rational import Matrix, blocks
from theorems import nonnegative, positive


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
    a = Matrix.of([[-k1, 1 + 0 * k1], [-2 * k2, 0 * k2]], 2)
    seen = Matrix.diagonal([1 + 0 * k1, 0 * k1])
    corner = p.block(range(2), range(1, 2)) * 2
    flow = (p @ (a + Matrix.scalar(2, alpha))).plus_transpose() + seen * (2 * bound**2)
    whole = blocks([[flow, corner], [corner.T, Matrix.scalar(1, -2)]])
    return words.super_twisting_observer(k1, k2, bound, alpha, c), [
        ("P > 0", positive(p)),
        ("[A'P + PA + 2 alpha P + 2 bound^2 C'C, 2PB; *, -2] < 0", positive(-whole)),
        ("c^2 P - C'C >= 0", nonnegative(p * c**2 - seen)),
    ]


KINDS = {"super-twisting-observer": super_twisting_observer}
