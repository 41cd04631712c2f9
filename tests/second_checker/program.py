"""Semidefinite programs: (P) min c'x, X = x_1 F_1 + ... + x_m F_m - F_0 >= 0, and (D) max tr(F_0 Y), tr(F_i Y) = c_i, Y
>= 0.

A feasible x bounds the optimum from above by c'x, a feasible Y from below by tr(F_0 Y). No Y of binary64 numbers
satisfies the equations; one near it does. Let `r_i = c_i - tr(F_i Y)` and `G_ij = tr(F_i F_j)`. For u near `G^-1 r` the
matrix `Y1 = Y + sum u_i F_i` has tiny residuals e, and `Y1 + sum (G^-1 e)_i F_i` satisfies the equations, at the
Frobenius distance `sqrt(e'G^-1 e) <= |S e|/sqrt(lambda) =: delta` from Y1, where `S G S >= lambda I` with S a diagonal
of powers of two. Hence `Y1 >= delta I` shows that a feasible Y* exists, and `tr(F_0 Y*) >= tr(F_0 Y1) - delta |F_0|`.
Entries that are bounds stand for all programs within.
"""

from fractions import Fraction

from rational import Family, Refuted, Matrix, NotShown, at_least, factored, is_certified, root_above

MOST_UNKNOWNS = 400
MOST_PRODUCTS = 5_000_000


class Entry:
    """An entry of the upper triangle; `weight` is what it counts for in a trace."""

    def __init__(self, row, column, datum):
        first, last = datum.written
        last = first if last is None else last
        self.row, self.column = row, column
        self.middle, self.radius = (first + last) / 2, abs(last - first) / 2
        self.weight = 1 if row == column else 2


class Program:
    """`orders` is a list of (order, is diagonal); `matrices[k]` maps (block, row, column) to an `Entry`."""

    def __init__(self, orders, costs, matrices):
        self.orders, self.matrices = orders, matrices
        self.costs = [Entry(0, 0, cost) for cost in costs]
        self.is_single = all(x.radius == 0 for x in self.costs) and all(
            x.radius == 0 for f in matrices for x in f.values()
        )

    def combination(self, factors):
        """`sum factors_k F_k`, a `Family` for each block (of order 1 for each entry of a diagonal one)."""
        sums = {}
        for factor, entries in zip(factors, self.matrices):
            for place, entry in entries.items() if factor else ():
                middle, radius = sums.get(place, (Fraction(0), Fraction(0)))
                sums[place] = (middle + factor * entry.middle, radius + abs(factor) * entry.radius)
        zero = (Fraction(0), Fraction(0))
        for block, (order, is_diagonal) in enumerate(self.orders):
            groups = [[k] for k in range(order)] if is_diagonal else [range(order)]
            for group in groups:
                at = [[sums.get((block, min(i, j), max(i, j)), zero) for j in group] for i in group]
                yield Family(*(Matrix.of([[x[part] for x in row] for row in at], len(group)) for part in (0, 1)))

    def cost_at_most(self, x):
        return sum((c.middle * value + c.radius * abs(value) for c, value in zip(self.costs, x)), Fraction(0))

    def feasible(self, x, margin):
        """`X(x) >= margin I`."""
        for family in self.combination([Fraction(-1), *x]):
            family.at_least(margin, strict=False)

    def ray(self, x):
        for family in self.combination([Fraction(0), *x]):
            family.at_least(0, strict=False)

    def lower_bound(self, y):
        return self.dual_value(y, [(c.middle, c.radius) for c in self.costs])

    def ray_value(self, y):
        return self.dual_value(y, [(Fraction(0), Fraction(0))] * len(self.costs))

    def trace(self, k, y):
        """The middle and the radius of tr(F_k Y)."""
        middle = radius = Fraction(0)
        for place, entry in self.matrices[k].items():
            value = y.get(place, Fraction(0))
            middle += entry.weight * entry.middle * value
            radius += entry.weight * entry.radius * abs(value)
        return middle, radius

    def gram(self):
        """G and a bound of how far that of a program within the bounds is from it."""
        m = len(self.costs)
        at = {}
        for i, f in enumerate(self.matrices[1:]):
            for place, entry in f.items():
                at.setdefault(place, []).append((i, entry))
        if sum(len(here) ** 2 for here in at.values()) > MOST_PRODUCTS:
            raise NotShown("the products of the constraints take too long")
        middle, radius = ([[Fraction(0)] * m for _ in range(m)] for _ in range(2))
        for here in at.values():
            for i, x in here:
                for j, y in here:
                    middle[i][j] += x.weight * x.middle * y.middle
                    if not self.is_single:
                        most = (abs(x.middle) + x.radius) * (abs(y.middle) + y.radius)
                        radius[i][j] += x.weight * (most - abs(x.middle * y.middle))
        return Matrix.of(middle, m), Matrix.of(radius, m)

    def dual_value(self, y, right_sides):
        """A lower bound of tr(F_0 Y*) for a Y* >= 0 that satisfies the equations, if there is one near Y. A right side
        is its middle and its radius.
        """
        m = len(self.costs)
        if m > MOST_UNKNOWNS:
            raise NotShown(f"{m} unknowns, and this checker goes up to {MOST_UNKNOWNS}")
        g, dg = self.gram()
        if any(g[i, i] <= 0 for i in range(m)):
            raise NotShown("the constraints are dependent")
        scales = [
            Fraction(2) ** -((g[i, i].numerator.bit_length() - g[i, i].denominator.bit_length()) // 2) for i in range(m)
        ]
        s = Matrix.diagonal(scales)
        scaled = s @ g @ s
        spread = s @ dg @ s
        lowered = scaled - Matrix.diagonal([sum((spread[i, j] for j in range(m)), Fraction(0)) for i in range(m)])
        powers = (Fraction(1, 2**k) for k in (0, 1, 2, 3, 5, 8, 12, 20, 40, 60))
        smallest = next((x for x in powers if is_certified((lowered - Matrix.scalar(m, x)).num, 192)), None)
        if smallest is None:
            raise NotShown("the constraints are dependent, or nearly so")
        y = dict(y)
        for _ in range(3):
            residual = [c - self.trace(k + 1, y)[0] for k, (c, _) in enumerate(right_sides)]
            step = solved(scaled, [x * scale for x, scale in zip(residual, scales)])
            for x, scale, f in zip(step, scales, self.matrices[1:]):
                for place, entry in f.items() if x else ():
                    y[place] = y.get(place, Fraction(0)) + x * scale * entry.middle
        square = Fraction(0)
        for k, (c, doubt) in enumerate(right_sides):
            middle, radius = self.trace(k + 1, y)
            square += ((abs(c - middle) + radius + doubt) * scales[k]) ** 2
        delta = root_above(square / smallest)
        for block, (order, is_diagonal) in enumerate(self.orders):
            if is_diagonal:
                if any(y.get((block, k, k), 0) < delta for k in range(order)):
                    raise NotShown("Y is not positive enough for a feasible point to be near")
                continue
            entries = [[y.get((block, min(i, j), max(i, j)), Fraction(0)) for j in range(order)] for i in range(order)]
            try:
                at_least(Matrix.of(entries, order), delta, strict=False)
            except Refuted:
                raise NotShown("Y is not positive enough for a feasible point to be near") from None
        middle, radius = self.trace(0, y)
        norm = sum((x.weight * (abs(x.middle) + x.radius) ** 2 for x in self.matrices[0].values()), Fraction(0))
        return middle - radius - delta * root_above(norm)


def solved(g, right_side, bits=256):
    """`g^-1 right_side` by the factorisation in fixed point: to many digits, about which nothing is known."""
    found = factored(g.num, bits)
    if found is None:
        raise NotShown("the constraints are dependent, or nearly so")
    _, l, d, _ = found
    half = [g.num[i][i].bit_length() // 2 for i in range(g.rows)]
    one = 1 << bits
    # S (num) S = L D L' 2^-bits with S = diag(2^-half).
    z = []
    for i, x in enumerate(right_side):
        x = x * g.den
        t = (x.numerator << (2 * bits)) // (x.denominator << half[i])
        z.append(t - (sum(a * b for a, b in zip(l[i], z)) >> bits))
    z = [(x << bits) // p for x, p in zip(z, d)]
    for i in reversed(range(len(z))):
        for j in range(i):
            z[j] -= (l[i][j] * z[i]) >> bits
    return [Fraction(x, one * one << half[i]) for i, x in enumerate(z)]
