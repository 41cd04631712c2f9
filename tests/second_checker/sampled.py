"""Sampled observers beyond the closed form: the semi-implicit cubic step, and periods that vary."""

from fractions import Fraction

import words
from document import Malformed
from labels import inequalities
from rational import (
    INDEFINITE,
    Family,
    Matrix,
    NotShown,
    Refuted,
    sign,
)
from theorems import FALL, read_plant, without_margin


def semi_implicit(file):
    a, b, c = read_plant(file)
    with file.object("observer") as observer:
        l, n = observer.take("L").matrix(a.rows, c.rows), observer.take("N").matrix(a.rows, c.rows)
        observer.take("theta").matrix(c.rows, c.rows)
        period = observer.take("period").in_range(lambda x: x > 0, "positive")
    with file.object("lyapunov") as proof:
        p, s = proof.take("P").symmetric(a.rows), proof.take("S").matrix(c.rows, c.rows)
    return words.semi_implicit_cubic_observer(a.rows, b.columns, c.rows, period), inequalities(
        {"A": a, "C": c, "L": l, "N": n, "P": p, "S": s},
        "P > 0",
        FALL,
        "S + S' >= 0",
        "[(P - (A - LC)'P(A - LC))/2, PN + C'S; *, N'PN] >= 0",
    )


MOST_MISSES = 64
# States^3 times the spans of time of all maps.
MOST_MOTION = 1 << 22
MOST_CELLS = 4096
# States^3 times the cells of all spans.
MOST_WORK = 1 << 23
LARGEST_EXPONENT = 1024


def varying_periods(file):
    a, b, c = read_plant(file)
    n, outputs = a.rows, c.rows
    with file.object("observer") as observer:
        step = observer.take("step").word("linear", "radial", "semi-implicit")
        k = observer.take("K").matrix(n, outputs)
        if step != "linear":
            gain = observer.take("N").matrix(n, outputs)
            observer.take("theta").matrix(outputs, outputs)
        w = observer.take("w").in_range(lambda x: x > 0, "positive") if step == "radial" else None
    with file.object("periods") as periods:
        shortest = periods.take("shortest").in_range(lambda x: x > 0, "positive")
        longest = periods.take("longest").in_range(lambda x: x >= shortest, "not below the shortest")
        misses = periods.take("misses").count(MOST_MISSES)
        spans = (misses + 1) * (2 if step == "radial" else 1)
        if n**3 * spans > MOST_MOTION:
            raise Malformed(
                f"periods.misses: {n}^3 states times {spans} spans of time are {n**3 * spans}; "
                f"the checker goes up to {MOST_MOTION}"
            )
    with file.object("lyapunov") as proof:
        p = proof.take("P").symmetric(n)
        factor = proof.take("factor").in_range(lambda x: 0 < x < 1, "above 0 and below 1")
        s = proof.take("S").matrix(outputs, outputs) if step == "semi-implicit" else None
    identity = Matrix.scalar(n, 1)
    maps = [("I - KC", identity - k @ c)]
    if step == "radial":
        maps.append(("I + NC/w", identity + gain @ c * (1 / w)))
    facts = inequalities({"P": p}, "P > 0")
    effort = Effort()
    for name, after in maps:
        falls = Falls(a, after, p, factor, effort)
        for count in range(1, misses + 2):
            times = count * shortest, count * longest
            facts.append(
                (
                    f"factor^2 P - M'exp(At)'P exp(At)M > 0 with M = {name} "
                    f"for t from {count} shortest to {count} longest",
                    without_margin(lambda falls=falls, times=times: falls.over(*times)),
                )
            )
    if step == "semi-implicit":
        names = {"C": c, "N": gain, "P": p, "S": s, "factor": factor}
        facts += inequalities(names, "S + S' >= 0", "[(1 - factor^2)P/2, PN + C'S; *, N'PN] >= 0")
    size = n, b.columns, outputs
    return words.varying_periods(size, step, w, shortest, longest, misses, factor), facts


def rounded(m, bits):
    """Each entry rounded down to a multiple of 2^-bits."""
    return Matrix([[(x << bits) // m.den for x in row] for row in m.num], 1 << bits, m.columns)


def exponential(m):
    """exp(M) up to an error of each entry: the Taylor series with terms on a grid, and a majorant of its errors."""
    n = m.rows
    size = max((sum(map(abs, row)) for row in m.num), default=0) / Fraction(m.den) if n else Fraction(0)
    if size > LARGEST_EXPONENT:
        raise NotShown("the exponent is too large")
    bits = 256 + 4 * int(size)
    unit = 1 << bits
    # Errors and sizes of a term, in units of the grid, by rows.
    error, largest, errors, degree = 0, unit, 0, 0
    term = total = rounded(Matrix.scalar(n, 1), bits)
    while degree <= 2 * size + 1 or largest > 1:
        degree += 1
        share = size / degree
        term = rounded(m @ term * Fraction(1, degree), bits)
        error = -(-error * share.numerator // share.denominator) + n
        largest = -(-largest * share.numerator // share.denominator)
        errors += error
        total = total + term
    # The terms that are left are less than half of the ones before.
    return total, Fraction(errors + largest, unit)


class Effort:
    """The work that is left for all spans of times of a file."""

    def __init__(self):
        self.left = MOST_WORK

    def spend(self, work):
        self.left -= work
        if self.left < 0:
            raise NotShown("the times between corrections would have to be divided further than this checker does")


class Falls:
    """`W(t) = factor^2 P - X'P X > 0`, `X = exp(At) M`, for all t of an interval.

    On a cell of radius r around c, `W(c + s) = W(c) + s W'(c) + s^2/2 W''` with `W' = -X'HX`, `W'' = -X'GX` somewhere,
    `H = A'P + PA`, `G = A'H + HA`, and `|X| <= exp(r |A|) |X(c)|` entry by entry. The first two terms are affine in s:
    what holds at both ends for everything within the radius of the rest, holds between.
    """

    def __init__(self, a, after, p, factor, effort):
        self.a, self.after, self.p, self.effort = a, after, p, effort
        self.level = p * factor**2
        self.h = (p @ a).plus_transpose()
        self.g = abs((self.h @ a).plus_transpose())
        self.spread = {}

    def growth(self, radius):
        """`exp(r |A|)`, from above."""
        if radius not in self.spread:
            found, error = exponential(abs(self.a) * radius)
            n = self.a.rows
            self.spread[radius] = found + Matrix.of([[error] * n] * n, n)
        return self.spread[radius]

    def over(self, first, last):
        cells, seen = [(first, last)], 0
        while cells:
            low, high = cells.pop()
            seen += 1
            self.effort.spend(self.a.rows**3)
            if seen + len(cells) > MOST_CELLS:
                raise NotShown("not shown between two times, with as many cells as are tried")
            middle = (low + high) / 2
            if not self.holds(middle, (high - low) / 2):
                if high == low:
                    raise NotShown("not shown at a time")
                cells += [(middle, high), (low, middle)]

    def holds(self, middle, radius):
        n = self.a.rows
        found, error = exponential(self.a * middle)
        x = rounded(found @ self.after, found.den.bit_length())
        columns = [sum(map(abs, column), 0) for column in zip(*self.after.num)]
        # By how much an entry of X is off.
        off = error * Fraction(max(columns), self.after.den) + Fraction(2, x.den)
        d = Matrix.of([[off] * n] * n, n)

        def quadratic(m):
            """`X'mX`, and how far each entry may be off."""
            half = abs(x).T @ abs(m) @ d
            return x.T @ m @ x, half.plus_transpose() + d.T @ abs(m) @ d

        value, value_off = quadratic(self.p)
        value = self.level - value
        bound = max(sum(row, Fraction(0)) for row in rows_of(value_off))
        if sign(value + Matrix.scalar(n, bound)) == INDEFINITE:
            raise Refuted(f"false at the time {float(middle)}")
        slope, slope_off = quadratic(self.h)
        largest = self.growth(radius) @ (abs(x) + d)
        rest = value_off + slope_off * radius + largest.T @ self.g @ largest * (radius**2 / 2)
        for side in (-radius, radius) if radius else (radius,):
            try:
                Family(value - slope * side, rest).at_least(Fraction(0), strict=True)
            except (Refuted, NotShown):
                return False
        return True


def rows_of(m):
    return [[m[i, j] for j in range(m.columns)] for i in range(m.rows)]


KINDS = {
    "sampled-cubic-observer-semi-implicit": semi_implicit,
    "sampled-observer-at-varying-periods": varying_periods,
}
