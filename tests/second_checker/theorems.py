"""The theorems: one function for each kind, which reads the data and returns the statement with the facts that imply
it.

A fact is a label and a test. The test takes the margin that the file claims, and raises `Refuted` or `NotShown`.
"""

from fractions import Fraction
from functools import cache, partial
from math import isqrt

import words
from document import LARGEST_ORDER, MOST_ENTRIES, Field
from equation import Equation
from equation import check as check_solution
from program import Entry, Program
from labels import inequalities, inequality
from rational import (
    DEFINITE,
    INDEFINITE,
    Family,
    Refuted,
    Matrix,
    NotShown,
    at_least,
    blocks,
    interval_matrix,
    largest_eigenvalue,
    sign,
    smallest_eigenvalue,
)


def without_margin(test):
    """A fact that is an equation, or has no measure of room."""

    def checked(margin):
        if margin:
            raise Refuted("this fact has no margin")
        test()

    return checked


def positive(m):
    return lambda margin: at_least(m, margin, strict=True)


def nonnegative(m):
    return lambda margin: at_least(m, margin, strict=False)


def read_plant(file):
    with file.object("plant") as plant:
        a = plant.take("A").square()
        b = plant.take("B").matrix_with_rows(a.rows)
        c = plant.take("C").matrix(None, a.rows)
    return a, b, c


def read_data(field, rows, columns, symmetric=False):
    return field.rows(Field.datum, (rows, columns), symmetric)


def read_order(field):
    return len(field.items()) or None


class Within:
    """A and C between bounds, and what the words need to know of them."""

    def __init__(self, a, c, others=()):
        self.order, self.outputs = len(a), len(c)
        self.a, self.da = interval_matrix(a, self.order)
        self.c, self.dc = interval_matrix(c, self.order)
        self.is_single = all(x.is_single for rows in (a, c, others) for row in rows for x in row)

    def names(self, **others):
        return {"A": Family(self.a, self.da), "C": Family(self.c, self.dc), **others}


def lyapunov(f, p, rate=0):
    return -(p @ (f + Matrix.scalar(f.rows, rate))).plus_transpose()


DECREASE = "(A - LC)'P + P(A - LC){} < 0 (12)"
FALL = "(A - LC)'P(A - LC) - P < 0"
FALL_BY = "(A - LC)'P(A - LC) - factor^2 P < 0"


def linear_observer(file):
    with file.object("plant") as plant:
        field = plant.take("A")
        a = read_data(field, *2 * (read_order(field),))
        n = len(a)
        field = plant.take("B")
        b = field.rows(Field.datum, (n, len(field.items()[0].items()) if field.items() else 0))
        c = read_data(plant.take("C"), None, n)
    pairs = Within(a, c, b)
    with file.object("observer") as observer:
        l = observer.take("L").matrix(n, len(c))
    with file.object("lyapunov") as proof:
        p, rate = proof.take("P").symmetric(n), proof.rate()
    decrease = DECREASE.format(words.rate_term(rate, "P"))
    facts = inequalities(pairs.names(L=l, P=p, rate=rate), "P > 0", decrease)
    return words.linear_observer(n, len(b[0]), len(c), rate, pairs.is_single), facts


def discrete_observer(file):
    a, b, c = read_plant(file)
    with file.object("observer") as observer:
        l = observer.take("L").matrix(a.rows, c.rows)
    with file.object("lyapunov") as proof:
        p, factor = proof.take("P").symmetric(a.rows), proof.optional("factor")
    names, fall = {"A": a, "C": c, "L": l, "P": p}, FALL
    if factor is not None:
        factor = factor.in_range(lambda x: 0 < x < 1, "above 0 and below 1")
        names, fall = names | {"factor": factor}, FALL_BY
    facts = inequalities(names, "P > 0", fall)
    return words.discrete_observer(a.rows, b.columns, c.rows, factor), facts


def hurwitz(file):
    field = file.take("A")
    a = read_data(field, *2 * (read_order(field),))
    n = len(a)
    with file.object("lyapunov") as proof:
        p = proof.take("P").symmetric(n)
    middle, radius = interval_matrix(a, n)
    facts = inequalities({"A": Family(middle, radius), "P": p}, "P > 0", "A'P + PA < 0")
    if radius.is_zero():

        def abscissa(margin):
            # A'P + PA + 2 m P <= 0 and P > 0: no real part is above -m.
            at_least(p, 0, strict=True)
            at_least(lyapunov(middle, p, margin), 0, strict=not margin)

        facts.append(("the largest real part of an eigenvalue < 0", abscissa))
    return words.hurwitz(n, all(x.is_single for row in a for x in row)), facts


def schur(file):
    a = file.take("A").square()
    with file.object("lyapunov") as proof:
        p = proof.take("P").symmetric(a.rows)
    return words.schur(a.rows), inequalities({"A": a, "P": p}, "P > 0", "A'PA - P < 0")


class Cubic:
    """The data that the cubic observers have in common."""

    def __init__(self, file, third):
        self.a, self.b, self.c = read_plant(file)
        n, outputs = self.a.rows, self.c.rows
        self.sizes = n, self.b.columns, outputs
        with file.object("observer") as observer:
            self.l = observer.take("L").matrix(n, outputs)
            if third == "N":
                self.n = observer.take("N").matrix(n, outputs)
            self.theta = observer.take("theta").symmetric(outputs)
            if third == "S":
                self.s = observer.take("S").matrix(outputs, outputs)
        self.f = self.a - self.l @ self.c

    def facts(self, *labels, **others):
        return inequalities({"A": self.a, "C": self.c, "L": self.l, "theta": self.theta, **others}, *labels)


def cubic_observer(file):
    return words.cubic_observer(*(read := read_cubic(file))[1:]), read[0]


def read_cubic(file):
    """The facts, and what the words take."""
    o = Cubic(file, "N")
    with file.object("lyapunov") as proof:
        p, s = proof.take("P").symmetric(o.a.rows), proof.take("S").matrix(o.c.rows, o.c.rows)
        rate = proof.rate()
        field = proof.take("converges_from")
        level = None if field.text() == "everywhere" else field.in_range(lambda x: x > 0, "positive")
    decrease = DECREASE.format(words.rate_term(rate, "P"))
    region = "everywhere" if level is None else f"e'Pe < {words.hexadecimal(level)}"
    return (
        [
            *o.facts("P > 0", decrease, "theta >= 0", "S + S' >= 0", P=p, S=s, rate=rate),
            (f"convergence with N as stored, {region}", without_margin(lambda: converges(o, p, s, level))),
        ],
        o.sizes,
        rate,
        level,
        o,
        p,
    )


def converges(o, p, s, level):
    """Convergence with the stored N, from everywhere or from `e'Pe < level`.

    `e' = F e + (y'theta y) N y`, y = Ce. With `R = P N + C'S`: where `R = 0`, theta = 0, or C = 0, V = e'Pe does it.
    Else another V~ = e'P~e, for which the stored N is exact: with T the orthogonal projector on the range of N, `P~ =
    C'XC + (I - T)(P - C'XC)(I - T)` has `P~ N = C'X C N`, so that `P~ > 0`, `F'P~ + P~F < 0` and `-(X C N + N'C'X) >=
    0` imply convergence from everywhere, for any symmetric X; it is taken near `(C P^-1 C')^-1`. Else, with `F'P + PF
    <= -q I`, `S + S' >= mu I`, `theta <= t I`, `|R| <= rho`, `|C| <= kappa`, V' < 0 for `0 < |e| < r`, `r^2 = max(16 q
    mu^3/(27 t rho^4), q/(2 t rho kappa^3))`: see docs/certificates.md.
    """
    residual = p @ o.n + o.c.T @ s
    decrease = lyapunov(o.f, p)
    if sign(decrease) != DEFINITE or residual.is_zero() or o.theta.is_zero() or o.c.is_zero():
        at_least(decrease, 0, strict=True)
        return
    if is_exact_elsewhere(o, p):
        return
    if level is None:
        raise NotShown("convergence from everywhere is not shown")
    q, mu = smallest_eigenvalue(decrease), smallest_eigenvalue(s.plus_transpose())
    t, rho, kappa = largest_eigenvalue(o.theta), residual.frobenius_squared(), o.c.frobenius_squared()
    # Squares of r, and of r^2; rho and kappa are squares.
    by_accretion = 16 * q * mu**3 / (27 * t * rho**2)
    by_output = q**2 / (4 * t**2 * rho * kappa**3)
    share = level / smallest_eigenvalue(p)
    if share > by_accretion and share**2 > by_output:
        raise NotShown("convergence from an ellipsoid as large is not shown")


def is_exact_elsewhere(o, p):
    gram = o.n.T @ o.n
    if sign(gram) != DEFINITE:
        return False
    try:
        metric = symmetric_part(approximate_inverse(o.c @ approximate_inverse(p) @ o.c.T))
    except (NotShown, OverflowError):
        return False
    if sign(-(metric @ o.c @ o.n).plus_transpose()) == INDEFINITE:
        return False
    rest = Matrix.scalar(p.rows, 1) - o.n @ inverse(gram) @ o.n.T
    metric = o.c.T @ metric @ o.c
    other = metric + rest @ (p - metric) @ rest
    return sign(other) == DEFINITE and sign(lyapunov(o.f, other)) == DEFINITE


def part(m, first, count):
    """The columns from `first` on."""
    return Matrix.of([row[first : first + count] for row in fractions(m)], count)


def symmetric_part(m):
    return m.plus_transpose() * Fraction(1, 2)


def inverse(m):
    """By elimination on integers (Bareiss), exactly."""
    n = m.rows
    work = [row + [m.den * (i == j) for j in range(n)] for i, row in enumerate(m.num)]
    previous = 1
    for k in range(n):
        found = next((i for i in range(k, n) if work[i][k]), None)
        if found is None:
            raise NotShown("a matrix to be inverted is singular")
        work[k], work[found] = work[found], work[k]
        head = work[k]
        for i, row in enumerate(work):
            if i != k:
                work[i] = [(head[k] * x - row[k] * y) // previous for x, y in zip(row, head)]
        previous = head[k]
    den = work[-1][n - 1]
    return Matrix([[x if den > 0 else -x for x in row[n:]] for row in work], abs(den), n).reduced()


def approximate_inverse(m):
    """The inverse, each entry rounded to binary64."""
    return Matrix.of([[Fraction(float(x)) for x in row] for row in fractions(inverse(m))], m.columns)


def fractions(m):
    return [[m[i, j] for j in range(m.columns)] for i in range(m.rows)]


def structured_cubic_observer(file):
    o = Cubic(file, "S")
    with file.object("lyapunov") as proof:
        p, rate = proof.take("P").symmetric(o.a.rows), proof.rate()

    def dissipation(margin):
        # P N C + C'N'P = -C'(S + S')C; the margin is one of S + S' on the outputs: y'(S + S')y >= margin
        # |y|^2 for y = Ce.
        at_least(p, 0, strict=True)
        gain = o.s.plus_transpose() - Matrix.scalar(o.c.rows, margin)
        at_least(o.c.T @ gain @ o.c, 0, strict=False)

    decrease = DECREASE.format(words.rate_term(rate, "P"))
    return words.structured_cubic_observer(*o.sizes, rate), [
        *o.facts("P > 0", decrease, "theta >= 0", P=p, rate=rate),
        ("P N C + C'N'P <= 0 for N = -P^-1 C'S (13')", dissipation),
    ]


def cubic_theorem_1(file):
    o = Cubic(file, "N")
    with file.object("lyapunov") as proof:
        p = proof.take("P").symmetric(o.a.rows)
    labels = "P > 0", DECREASE.format(""), "theta >= 0", "P N C + C'N'P <= 0 (13')"
    return words.cubic_theorem_1(*o.sizes), o.facts(*labels, P=p, N=o.n)


def sampled_cubic_observer(file):
    a, b, c = read_plant(file)
    with file.object("observer") as observer:
        l, n = observer.take("L").matrix(a.rows, c.rows), observer.take("N").matrix(a.rows, c.rows)
        observer.take("theta").matrix(c.rows, c.rows)
        w, period = (observer.take(name).in_range(lambda x: x > 0, "positive") for name in ("w", "period"))
    with file.object("lyapunov") as proof:
        p = proof.take("P").symmetric(a.rows)
    names = {"A": a, "C": c, "L": l, "N": n, "w": w, "P": p}
    return words.sampled_cubic_observer(a.rows, b.columns, c.rows, w, period), inequalities(
        names, "P > 0", FALL, "(wA + ANC)'P(wA + ANC) - w^2 P < 0"
    )


def feedback_loop(file):
    facts, sizes, rate, level, o, p = read_cubic(file)
    n, inputs, _ = sizes
    with file.object("feedback") as feedback:
        if inputs == 0:
            feedback.take("K").fail("a plant without inputs has no feedback")
        k, p1 = feedback.take("K").matrix(inputs, n), feedback.take("P1").symmetric(n)
    block = "[(A - BK)'P1 + P1(A - BK), P1 B K; *, (A - LC)'P + P(A - LC)] < 0 (25)"
    facts += o.facts("P1 > 0", block, B=o.b, K=k, P=p, P1=p1)
    return words.feedback_loop(sizes, rate, level), facts


def read_vertices(file):
    vertices = []
    for item in file.take("vertices").items():
        with item.object() as fields:
            n, outputs = (vertices[0].order, vertices[0].outputs) if vertices else (None, None)
            field = fields.take("A")
            a = read_data(field, *2 * (n or read_order(field),))
            vertices.append(Within(a, read_data(fields.take("C"), outputs, len(a))))
    if not vertices:
        file.take("vertices").fail("is empty")
    return vertices


def polytope(statement, file):
    vertices = read_vertices(file)
    n, outputs = vertices[0].order, vertices[0].outputs
    with file.object("observer") as observer:
        l = observer.take("L").matrix(n, outputs)
    with file.object("lyapunov") as proof:
        p, rate = proof.take("P").symmetric(n), proof.rate()
    decrease = f"(A - LC)'P + P(A - LC){words.rate_term(rate, 'P')} < 0"
    facts = inequalities({"P": p}, "P > 0")
    for k, vertex in enumerate(vertices):
        facts.append(inequality(decrease, vertex.names(L=l, P=p, rate=rate), f" at vertex {k + 1}"))
    return statement(len(vertices), n, outputs, rate, all(vertex.is_single for vertex in vertices)), facts


def discrete_polytope(file):
    vertices = read_vertices(file)
    n, outputs = vertices[0].order, vertices[0].outputs
    with file.object("observer") as observer:
        l = observer.take("L").matrix(n, outputs)
    with file.object("lyapunov") as proof:
        p = proof.take("P").symmetric(n)
        factor = proof.take("factor").in_range(lambda x: 0 < x <= 1, "above 0 and at most 1")
    facts = inequalities({"P": p}, "P > 0")
    for k, vertex in enumerate(vertices):
        names = vertex.names(L=l, P=p, factor=factor)
        facts.append(inequality("[factor^2 P, (A - LC)'P; *, P] > 0", names, f" at vertex {k + 1}"))
    single = all(vertex.is_single for vertex in vertices)
    return words.discrete_polytope_of_jacobians(len(vertices), n, outputs, factor, single), facts


def sector_observer(file):
    sectors = []
    with file.object("plant") as plant:
        field = plant.take("A")
        a = read_data(field, *2 * (read_order(field),))
        n = len(a)
        pairs = Within(a, read_data(plant.take("C"), None, n))
        for item in plant.take("sectors").items():
            with item.object() as fields:
                field = fields.take("G")
                if not field.items():
                    field.fail("is empty")
                g = field.matrix(n, len(field.items()[0].items()))
                if not g.columns:
                    field.fail("is empty")
                h = fields.take("H").matrix(None, n)
                low = fields.take("low").binary64()
                high = fields.take("high").in_range(lambda x: low <= x, "not below low")
                if low != -high and h.rows != g.columns:
                    fields.take("H").fail(f"has {h.rows} rows, and a sector that is not symmetric asks for {g.columns}")
                sectors.append((g, h, low, high, fields.take("tau").binary64()))
        if not sectors or n + sum(g.columns for g, *_ in sectors) > LARGEST_ORDER:
            plant.take("sectors").fail(f"should not be empty, nor have more than {LARGEST_ORDER} columns with A")
    with file.object("observer") as observer:
        l = observer.take("L").matrix(n, pairs.outputs)
    with file.object("lyapunov") as proof:
        p, rate = proof.take("P").symmetric(n), proof.rate()

    def skew(g, h, low, high, tau):
        return Matrix.zeros(n, g.columns) if low == -high else h.T * (tau * (low + high) / 2)

    names = pairs.names(L=l, P=p, rate=rate, G=blocks([[g for g, *_ in sectors]])) | {
        "sum tau low high H'H": sum((h.T @ h * (tau * low * high) for _, h, low, high, tau in sectors), Matrix.zeros(n, n)),
        "tau (low + high)/2 H'": blocks([[skew(*sector) for sector in sectors]]),
        "tau I": Matrix.diagonal([tau for g, *_, tau in sectors for _ in range(g.columns)]),
    }
    term = words.rate_term(rate, "P")
    label = f"[F'P + PF{term} - sum tau low high H'H, PG + tau (low + high)/2 H'; *, -tau I] < 0 for F = A - LC"
    slopes = [(low, high) for _, _, low, high, _ in sectors]
    statement = words.sector_observer(n, pairs.outputs, slopes, rate, pairs.is_single)
    return statement, inequalities(names, "P > 0", label)


def read_disturbed(file):
    """The pairs (A, E) with their sizes, C and D."""
    vertices = []
    with file.object("plant") as plant:
        for item in plant.take("vertices").items():
            with item.object() as fields:
                n, m = vertices[0][2:] if vertices else (None, None)
                field = fields.take("A")
                a = read_data(field, *2 * (n or read_order(field),))
                field = fields.take("E")
                e = read_data(field, len(a), m)
                if len(a) + len(e[0]) > LARGEST_ORDER:
                    field.fail(f"has with A more than {LARGEST_ORDER} columns")
                vertices.append((a, e, len(a), len(e[0])))
        if not vertices:
            plant.take("vertices").fail("is empty")
        n, m = vertices[0][2:]
        c = plant.take("C").matrix(None, n)
        return vertices, c, read_data(plant.take("D"), c.rows, m)


def read_error_bounds(file, n, m):
    with file.object("bounds") as bounds:
        return (
            [item.in_range(lambda x: x >= 0, "0 or more") for item in bounds.take("w").items(m)],
            bounds.take("level").in_range(lambda x: x > 0, "positive"),
            [item.in_range(lambda x: x > 0, "positive") for item in bounds.take("limsup").items(n)],
        )


def discrete_input_to_state_stability(file):
    """`e+ = F e + G w`, F = A - LC, G = E - LD, |w_i| <= W_i: `V(Fe + Gw) < factor^2 V + sum lambda_i w_i^2` by the Schur
    complement of an inequality that is linear in (A, E, D).
    """
    vertices, c, d_data = read_disturbed(file)
    n, m = vertices[0][2:]
    with file.object("observer") as observer:
        l = observer.take("L").matrix(n, c.rows)
    with file.object("lyapunov") as proof:
        p = proof.take("P").symmetric(n)
        factor = proof.take("factor").in_range(lambda x: 0 < x < 1, "above 0 and below 1")
        lam = [item.binary64() for item in proof.take("lambda").items(m)]
    w, level, limsup = read_error_bounds(file, n, m)
    names = {"C": c, "D": Family(*interval_matrix(d_data, m)), "L": l, "P": p, "factor": factor, "lambda": lam}
    facts = inequalities(names, "P > 0")
    label = "[factor^2 P, 0, (A - LC)'P; *, diag(lambda), (E - LD)'P; *, *, P] > 0"
    for k, (a, e, *_) in enumerate(vertices):
        here = {"A": Family(*interval_matrix(a, n)), "E": Family(*interval_matrix(e, m))}
        facts.append(inequality(label, names | here, f" at vertex {k + 1}"))
    left = (1 - factor * factor) * level - sum(x * y * y for x, y in zip(lam, w))
    facts.append(("sum lambda_i w_i^2 <= (1 - factor^2) level", nonnegative(Matrix.diagonal([left]))))
    for i in range(n):
        unit = Matrix.diagonal([Fraction(level if j == i else 0) for j in range(n)])
        facts.append((f"limsup |e_{i + 1}| <= limsup[{i}]", positive(p * limsup[i] ** 2 - unit)))
    single = all(x.is_single for a, e, *_ in vertices for rows in (a, e) for row in rows for x in row)
    single = single and all(x.is_single for row in d_data for x in row)
    statement = words.discrete_input_to_state_stability
    return statement(n, c.rows, len(vertices), factor, w, level, limsup, single), facts


def input_to_state_stability(file):
    """`e' = (A - LC)e + (E - LD)w + (r'theta r) N r`, r = Ce + Dw, |w_i| <= W_i.

    With `P~N = -C'S~` the cubic term adds to V', V = e'P~e, `-2 q r'S~r + 2 q (Dw)'S~r`, q = r'theta r. With `a^2 =
    r'S~r`, `s^2 = sum mu_i w_i^2`: `|(Dw)'S~r| <= s a` by the block inequality, so that it adds at most `2 q a (s -
    a)`, and `q <= kappa a^2`: at most `27/128 kappa s^4`. P~ is rational here, and exact.
    """
    vertices, c, d_data = read_disturbed(file)
    n, m = vertices[0][2:]
    with file.object("observer") as observer:
        l = observer.take("L").matrix(n, c.rows)
    field = file.optional("cubic")
    if field:
        with field.object() as fields:
            gain = fields.take("N").matrix(n, c.rows)
            theta, x = (fields.take(name).symmetric(c.rows) for name in ("theta", "X"))
            kappa = fields.take("kappa").in_range(lambda x: x >= 0, "0 or more")
            mu = [item.binary64() for item in fields.take("mu").items(m)]
    with file.object("lyapunov") as proof:
        p = proof.take("P").symmetric(n)
        rate = proof.take("rate").in_range(lambda x: x > 0, "positive")
        lam = [item.binary64() for item in proof.take("lambda").items(m)]
    w, level, limsup = read_error_bounds(file, n, m)
    spent, name, metric = sum(x * y * y for x, y in zip(lam, w)), "P", lambda: p
    if field:
        square = sum(x * y * y for x, y in zip(mu, w))
        spent += Fraction(27, 128) * kappa * square**2
        name, metric = "P~", structured_metric(p, c, x, gain)

    names = {"C": c, "D": Family(*interval_matrix(d_data, m)), "L": l, name: metric, "rate": rate, "lambda": lam}

    def component(i):
        unit = Matrix.diagonal([Fraction(level if j == i else 0) for j in range(n)])
        return lambda margin: at_least(metric() * limsup[i] ** 2 - unit, margin, strict=True)

    facts = inequalities(names, f"{name} > 0")
    label = f"[(A - LC)'{name} + {name}(A - LC) + 2 rate {name}, {name}(E - LD); *, -diag(lambda)] < 0"
    for k, (a, e, *_) in enumerate(vertices):
        here = {"A": Family(*interval_matrix(a, n)), "E": Family(*interval_matrix(e, m))}
        facts.append(inequality(label, names | here, f" at vertex {k + 1}"))
    total = "sum lambda_i w_i^2"
    if field:
        names |= {"theta": theta, "kappa": kappa, "mu": mu, "S~": -(x @ c @ gain)}
        labels = "theta >= 0", "kappa (S~ + S~') - 2 theta >= 0", "[2 diag(mu), 2 D'S~; *, S~ + S~'] >= 0"
        facts += inequalities(names, *labels)
        total += " + 27/128 kappa (sum mu_i w_i^2)^2"
    facts.append((f"{total} <= 2 rate level", nonnegative(Matrix.diagonal([128 * (2 * rate * level - spent)]))))
    facts += [(f"limsup |e_{i + 1}| <= limsup[{i}]", component(i)) for i in range(n)]
    pairs = [matrix for a, e, *_ in vertices for matrix in (a, e)] + [d_data]
    single = all(x.is_single for matrix in pairs for row in matrix for x in row)
    size = n, c.rows, len(vertices), bool(field)
    return words.input_to_state_stability(*size, rate, w, level, limsup, single), facts


def unknown_input_observer(file):
    """`e' = (TA - LC)e + (y'theta y) N y`, y = Ce, with the rational T = I - E((CE)'CE)^-1(CE)'C, for which TE = 0."""
    a, b, c = read_plant(file)
    n = a.rows
    e = file.take("E").matrix_with_rows(n)
    if not e.columns:
        file.take("E").fail("is empty")
    with file.object("observer") as observer:
        l = observer.take("L").matrix(n, c.rows)
    field = file.optional("cubic")
    if field:
        with field.object() as fields:
            gain = fields.take("N").matrix(n, c.rows)
            theta, x = (fields.take(name).symmetric(c.rows) for name in ("theta", "X"))
    with file.object("lyapunov") as proof:
        p, rate = proof.take("P").symmetric(n), proof.rate()
    image = c @ e
    gram = image.T @ image
    name, metric = ("P~", structured_metric(p, c, x, gain)) if field else ("P", lambda: p)

    def decoupler():
        if sign(gram) != DEFINITE:
            raise NotShown("there is no T")
        return Matrix.scalar(n, 1) - e @ inverse(gram) @ image.T @ c

    names = {"A": a, "C": c, "E": e, "L": l, "T": decoupler, name: metric, "rate": rate}
    decrease = f"(TA - LC)'{name} + {name}(TA - LC){words.rate_term(rate, name)} < 0"
    facts = inequalities(names, "(CE)'CE > 0", f"{name} > 0", decrease)
    if field:
        facts += inequalities({"theta": theta, "S~": -(x @ c @ gain)}, "theta >= 0", "S~ + S~' >= 0")
    return words.unknown_input_observer(n, b.columns, e.columns, c.rows, bool(field), rate), facts


def decoupling_observer(file):
    """`e' = (TA - JC)e` or e+, HF = 0 and TE = JF for `[H G] = [E - LF, 0] (S'S)^-1 S'`, J = L + G, S = [CE F1; F 0]."""
    is_discrete = file.take("time").word("continuous", "discrete") == "discrete"
    a, b, c = read_plant(file)
    n, p = a.rows, c.rows
    e = file.take("E").matrix_with_rows(n)
    if not e.columns:
        file.take("E").fail("is empty")
    f = file.take("F").matrix(p, e.columns)
    with file.object("observer") as observer:
        l = observer.take("L").matrix(n, p)
    with file.object("lyapunov") as proof:
        lyapunov_matrix = proof.take("P").symmetric(n)
    fed = [j for j in range(f.columns) if any(f[i, j] for i in range(p))]
    fed = Matrix.of([[f[i, j] for j in fed] for i in range(p)], len(fed))
    s = blocks([[c @ e, fed], [f, Matrix.zeros(p, fed.columns)]])
    gram = s.T @ s

    @cache
    def both():
        if sign(gram) != DEFINITE:
            raise NotShown("there is no H")
        return blocks([[e - l @ f, Matrix.zeros(n, fed.columns)]]) @ inverse(gram) @ s.T

    def decoupler():
        return Matrix.scalar(n, 1) - part(both(), 0, p) @ c

    def injection():
        return l + part(both(), p, p)

    decrease = "(TA - JC)'P(TA - JC) - P < 0" if is_discrete else "(TA - JC)'P + P(TA - JC) < 0"
    names = {"A": a, "C": c, "S": s, "T": decoupler, "J": injection, "P": lyapunov_matrix}
    facts = inequalities(names, "S'S > 0", "P > 0", decrease)
    return words.decoupling_observer(is_discrete, n, b.columns, e.columns, p), facts


def reduced_order_observer(file):
    """`v' = Fv`, v = w - Tx, with the rational F = T A (C'C + T'T)^-1 T'."""
    a, b, c = read_plant(file)
    n = a.rows
    with file.object("observer") as observer:
        t = observer.take("T").matrix(None, n)
    with file.object("lyapunov") as proof:
        p, rate = proof.take("P").symmetric(t.rows), proof.rate()
    gram = c.T @ c + t.T @ t

    def flow():
        if sign(gram) != DEFINITE:
            raise NotShown("there is no M")
        return t @ a @ inverse(gram) @ t.T

    return words.reduced_order_observer(n, b.columns, c.rows, t.rows, rate), inequalities(
        {"C": c, "T": t, "F": flow, "P": p, "rate": rate},
        "C'C + T'T > 0",
        "P > 0",
        f"F'P + PF{words.rate_term(rate, 'P')} < 0",
    )


class FilterProblem:
    """A plant with disturbances w, a linear observer, and the errors z = He that count, in continuous or discrete time:
    e' = Fe + Gw or e+ = Fe + Gw.
    """

    def __init__(self, file):
        self.is_discrete = file.take("time").word("continuous", "discrete") == "discrete"
        a, b, c = read_plant(file)
        n, outputs = a.rows, c.rows
        e = file.take("E").matrix_with_rows(n)
        if not e.columns:
            file.take("E").fail("is empty")
        if n + e.columns > LARGEST_ORDER:
            file.take("E").fail(f"makes an inequality of more than {LARGEST_ORDER} rows")
        d = file.take("D").matrix(outputs, e.columns)
        h = file.take("H").matrix(None, n)
        with file.object("observer") as observer:
            l = observer.take("L").matrix(n, outputs)
        with file.object("lyapunov") as proof:
            self.p = proof.take("P").symmetric(n)
        self.gamma = file.take("gamma").in_range(lambda x: x > 0, "positive")
        self.names = {"A": a, "C": c, "E": e, "D": d, "H": h, "L": l, "P": self.p, "gamma": self.gamma}
        self.sizes = n, b.columns, e.columns, outputs, h.rows
        self.decrease = "(A - LC)'P(A - LC) - P + H'H" if self.is_discrete else "(A - LC)'P + P(A - LC) + H'H"

    def words(self, norm):
        return words.filter_bound(norm, self.is_discrete, *self.sizes, self.gamma)


def h_infinity_filter(file):
    of = FilterProblem(file)
    if of.is_discrete:
        rest = "(A - LC)'P(E - LD); *, (E - LD)'P(E - LD) - gamma^2 I"
    else:
        rest = "P(E - LD); *, -gamma^2 I"
    return words.h_infinity_filter(of.words("H-infinity"), of.is_discrete), inequalities(
        of.names, "P > 0", f"[{of.decrease}, {rest}] < 0"
    )


def h2_filter(file):
    of = FilterProblem(file)
    return words.h2_filter(of.words("H2"), of.is_discrete), inequalities(
        of.names, "P > 0", f"{of.decrease} < 0", "tr (E - LD)'P(E - LD) < gamma^2"
    )


def structured_metric(p, c, x, gain):
    """`P~ = C'XC + (I - T)(P - C'XC)(I - T)`, T the orthogonal projector on the range of N, computed once."""
    found = []

    def metric():
        if not found:
            gram = gain.T @ gain
            if sign(gram) != DEFINITE:
                raise NotShown("N has dependent columns")
            rest = Matrix.scalar(p.rows, 1) - gain @ inverse(gram) @ gain.T
            seen = c.T @ x @ c
            found.append((seen + rest @ (p - seen) @ rest).reduced())
        return found[0]

    return metric


def contracting_coordinates(file):
    with file.object("coordinates") as coordinates:
        k = coordinates.take("K").matrix(None, None)
    unmeasured, measured = k.rows, k.columns
    n = unmeasured + measured
    vertices = [item.matrix(n, n) for item in file.take("vertices").items()]
    if not vertices:
        file.take("vertices").fail("is empty")
    with file.object("observer") as observer:
        injection = observer.take("injection").binary64()
    with file.object("lyapunov") as proof:
        q, rate = proof.take("Q").symmetric(unmeasured), proof.rate()
    one, zero = Matrix.scalar(measured, 1), Matrix.zeros(measured, unmeasured)
    back, there = (blocks([[one, zero], [k * sign_, Matrix.scalar(unmeasured, 1)]]) for sign_ in (-1, 1))
    g = Matrix.diagonal([injection] * measured + [Fraction(0)] * unmeasured)
    names = {"Q": q, "K": k, "rate": rate, "T": there, "T^-1": back, "[g I 0; 0 0]": g}
    names["P"] = blocks([[one, zero], [zero.T, q]])
    facts = inequalities(names, "Q > 0")
    for number, j in enumerate(vertices):
        left, right = range(measured), range(measured, n)
        of = names | {"J": j, "J_uu": j.block(right, right), "J_mu": j.block(left, right)}
        for label in (
            f"He(Q(J_uu - K J_mu)){words.rate_term(rate, 'Q')} < 0",
            f"He(P(T^-1 J T - [g I 0; 0 0])){words.rate_term(rate, 'P')} < 0",
        ):
            facts.append(inequality(label, of, f" at vertex {number + 1}"))
    return words.contracting_coordinates(len(vertices), measured, unmeasured, injection, rate), facts


SENSES = {
    "positive definite": ("M > 0", 1, True),
    "positive semidefinite": ("M >= 0", 1, False),
    "negative definite": ("M < 0", -1, True),
    "negative semidefinite": ("M <= 0", -1, False),
}


def definiteness(file):
    field = file.take("M")
    m = read_data(field, *2 * (read_order(field),), symmetric=True)
    sense = file.take("is").word(*SENSES)
    label, sign_, strict = SENSES[sense]
    n = len(m)
    entries = [x for row in m for x in row]
    middle, radius = interval_matrix(m, n)
    family = Family(middle * sign_, radius)
    statement = words.definiteness(n, sense, all(x.is_single for x in entries))
    return statement, [(label, lambda margin: family.at_least(margin, strict))]


def is_dyadic(x):
    return x.denominator & (x.denominator - 1) == 0


EQUATIONS = {"A'P + PA + Q = 0": False, "A'PA - P + Q = 0": True}


def solution_within(file):
    text = file.take("equation").word(*EQUATIONS)
    field = file.take("A")
    a = read_data(field, *2 * (read_order(field),))
    n = len(a)
    q = read_data(file.take("Q"), n, n, symmetric=True)
    with file.object("proposal") as proposal:
        near = sum((item.symmetric(n) for item in proposal.take("P").items()), Matrix.zeros(n, n))
        w = proposal.optional("W")
        w = w.symmetric(n) if w else None
    p = file.take("P").rows(Field.interval, (n, n), symmetric=True)
    low, high = (Matrix.of([[x[end] for x in row] for row in p], n) for end in (0, 1))
    equation = Equation(EQUATIONS[text], interval_matrix(a, n), interval_matrix(q, n))
    test = without_margin(lambda: check_solution(equation, near, w, low, high))
    is_single = all(x.is_single for rows in (a, q) for row in rows for x in row)
    return words.solution_within(text, n, is_single), [(f"{text} has one solution, and it lies in P", test)]


# Linear matrix inequalities.

MOST_UNKNOWNS = 1 << 20


def read_inequalities(file):
    with file.object("inequalities") as fields:
        unknowns = fields.take("unknowns").count(MOST_UNKNOWNS)
        relation = fields.take("relation").word(">", ">=")
        constraints = []
        for item in fields.take("constraints").items():
            with item.object() as parts:
                name, order = parts.take("name").name(), parts.take("order").count(LARGEST_ORDER)
                if order == 0:
                    item.fail("is of order 0")
                entries = []
                for entry in parts.take("entries").items():
                    unknown, row, column, value = entry.items(4)
                    column = column.count(order - 1)
                    entries.append((unknown.count(unknowns), row.count(column), column, value.number()))
            constraints.append((name, order, entries))
        if not constraints:
            fields.take("constraints").fail("is empty")
        if sum(order**2 for _, order, _ in constraints) > MOST_ENTRIES:
            fields.take("constraints").fail(f"the matrices have more than {MOST_ENTRIES} entries together")
    return unknowns, relation, constraints


def matrix_inequality_holds(file):
    unknowns, relation, constraints = read_inequalities(file)
    x = [Fraction(1)] + [item.binary64() for item in file.take("x").items(unknowns)]
    facts = []
    for name, order, entries in constraints:
        sums = [[Fraction(0)] * order for _ in range(order)]
        for unknown, row, column, value in entries:
            sums[row][column] += value * x[unknown]
        m = Matrix.of([[sums[min(i, j)][max(i, j)] for j in range(order)] for i in range(order)], order)
        facts.append((words.inequality_label(relation, name), partial(at_least, m, strict=relation == ">")))
    return words.matrix_inequality_holds(unknowns, relation, [name for name, _, _ in constraints]), facts


def matrix_inequality_refuted(file):
    unknowns, relation, constraints = read_inequalities(file)
    multipliers = []
    for item, (_, order, entries) in zip(file.take("multipliers").items(len(constraints)), constraints):
        z = item.rows(Field.number, (order, order), symmetric=True)
        if not all(map(is_dyadic, [x for row in z for x in row] + [value for _, _, _, value in entries])):
            item.fail("multipliers and coefficients should be dyadic")
        multipliers.append(z)
    traces = [Fraction(0)] * (unknowns + 1)
    facts = []
    for (name, order, entries), z in zip(constraints, multipliers):
        facts.append((words.multiplier_label(name), nonnegative(Matrix.of(z, order))))
        for unknown, row, column, value in entries:
            traces[unknown] += value * z[row][column] * (1 if row == column else 2)

    def equations():
        if any(traces[1:]):
            raise Refuted("the trace of an unknown does not vanish")

    def not_all_zero():
        if not any(x for z in multipliers for row in z for x in row):
            raise Refuted("all multipliers are 0")

    def constant(margin):
        if traces[0] > -margin or (relation == ">=" and traces[0] == 0):
            raise Refuted("the constant has the wrong sign, or less margin than claimed")

    facts += [
        ("sum_k tr(F_ki Z_k) = 0 for every unknown x_i", without_margin(equations)),
        ("the Z_k are not all zero", without_margin(not_all_zero)),
        (f"sum_k tr(F_k0 Z_k) {'<=' if relation == '>' else '<'} 0", constant),
    ]
    return words.matrix_inequality_refuted(unknowns, relation, [name for name, _, _ in constraints]), facts


# Semidefinite programs.


def read_program(file):
    with file.object("program") as fields:
        orders = []
        for item in fields.take("blocks").items():
            with item.object() as parts:
                dense, diagonal = parts.optional("dense"), parts.optional("diagonal")
                if (dense is None) == (diagonal is None):
                    item.fail("should be dense or diagonal")
                orders.append((dense.count(LARGEST_ORDER), False) if dense else (diagonal.count(MOST_ENTRIES), True))
        if sum((isqrt(n) + 1 if is_diagonal else n) ** 2 for n, is_diagonal in orders) > MOST_ENTRIES:
            fields.take("blocks").fail(f"the matrices have more than {MOST_ENTRIES} entries together")
        costs = [item.datum() for item in fields.take("costs").items()]
        if not costs or not orders or not all(n for n, _ in orders):
            fields.take("blocks").fail("a program needs an unknown, a block, and a row in every block")
        matrices = [{} for _ in range(len(costs) + 1)]
        for item in fields.take("entries").items():
            matrix, block, row, column, value = item.items(5)
            matrix, block = matrix.count(len(costs)), block.count(len(orders) - 1)
            order, is_diagonal = orders[block]
            column = column.count(order - 1)
            row = row.count(column)
            if is_diagonal and row != column:
                item.fail("lies off the diagonal of a diagonal block")
            if (block, row, column) in matrices[matrix]:
                item.fail("stands at a place that was given before")
            matrices[matrix][block, row, column] = Entry(row, column, value.datum())
    return Program(orders, costs, matrices)


def read_dual(field, program):
    """The entries of the upper triangles that are not 0."""
    y = {}
    for block, (item, (order, is_diagonal)) in enumerate(zip(field.items(len(program.orders)), program.orders)):
        with item.object() as fields:
            if is_diagonal:
                found = {(k, k): entry.binary64() for k, entry in enumerate(fields.take("diagonal").items(order))}
            else:
                m = fields.take("dense").symmetric(order)
                found = {(i, j): m[i, j] for i in range(order) for j in range(i, order)}
        y.update({(block, i, j): x for (i, j), x in found.items() if x})
    return y


def semidefinite_program(file):
    program = read_program(file)
    unknowns = len(program.costs)
    claim = file.take("claim").word("bounds", "primal infeasible", "dual infeasible")
    facts, bounds = [], [None, None]
    if claim == "bounds":
        lower, upper = file.optional("lower"), file.optional("upper")
        if lower is None and upper is None:
            file.take("claim").fail("needs lower or upper")
        if lower:
            with lower.object() as fields:
                bounds[0], y = fields.take("bound").binary64(), read_dual(fields.take("Y"), program)

            def at_most():
                if program.lower_bound(y) < bounds[0]:
                    raise NotShown("Y does not show a bound as large")

            facts.append((f"the optimum >= {words.hexadecimal(bounds[0])} by Y", without_margin(at_most)))
        if upper:
            with upper.object() as fields:
                bounds[1], x = fields.take("bound").binary64(), [
                    item.binary64() for item in fields.take("x").items(unknowns)
                ]

            def feasible(margin):
                if program.cost_at_most(x) > bounds[1]:
                    raise Refuted("c'x is larger")
                program.feasible(x, margin)

            facts.append((f"X(x) >= 0 and c'x <= {words.hexadecimal(bounds[1])}", feasible))
    elif claim == "primal infeasible":
        y = read_dual(file.take("Y"), program)

        def primal_ray(margin):
            value = program.ray_value(y)
            if value <= 0 or value < margin:
                raise NotShown("Y does not show a value of tr(F_0 Y) as large")

        facts.append(("tr(F_i Y) = 0, tr(F_0 Y) > 0, Y >= 0 near Y", primal_ray))
    else:
        x = [item.binary64() for item in file.take("x").items(unknowns)]

        def dual_ray(margin):
            value = -program.cost_at_most(x)
            if value <= 0 or value < margin:
                raise Refuted("c'x is not as far below 0")
            program.ray(x)

        facts.append(("x_1 F_1 + ... + x_m F_m >= 0 and c'x < 0", dual_ray))
    return words.semidefinite_program(unknowns, len(program.orders), claim, *bounds), facts


KINDS = {
    "linear-observer": linear_observer,
    "discrete-observer": discrete_observer,
    "hurwitz": hurwitz,
    "schur": schur,
    "cubic-observer": cubic_observer,
    "cubic-observer-with-structured-gain": structured_cubic_observer,
    "cubic-observer-theorem-1": cubic_theorem_1,
    "sampled-cubic-observer": sampled_cubic_observer,
    "feedback-loop": feedback_loop,
    "polytope-of-plants": partial(polytope, words.polytope_of_plants),
    "polytope-of-jacobians": partial(polytope, words.polytope_of_jacobians),
    "discrete-polytope-of-jacobians": discrete_polytope,
    "sector-observer": sector_observer,
    "unknown-input-observer": unknown_input_observer,
    "input-to-state-stability": input_to_state_stability,
    "discrete-input-to-state-stability": discrete_input_to_state_stability,
    "decoupling-observer": decoupling_observer,
    "reduced-order-observer": reduced_order_observer,
    "h-infinity-filter": h_infinity_filter,
    "h2-filter": h2_filter,
    "contracting-coordinates": contracting_coordinates,
    "definiteness": definiteness,
    "solution-within": solution_within,
    "matrix-inequality-holds": matrix_inequality_holds,
    "matrix-inequality-refuted": matrix_inequality_refuted,
    "semidefinite-program": semidefinite_program,
}
