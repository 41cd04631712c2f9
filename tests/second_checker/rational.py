"""Matrices of rational numbers, and whether a symmetric one is positive (semi)definite: exactly.

A matrix is an array of integers over one positive denominator, so that products and eliminations are arithmetic of
Python's integers.

Definiteness is decided by Bareiss' elimination with pivots on the diagonal. For orders at which that takes long, a
factorisation `L D L'` in fixed point is tried first: with D > 0 and the residual `M - e - L D L'` (e a small positive
diagonal) computed exactly, M is definite if e dominates the residual.
"""

from fractions import Fraction
from math import gcd, isqrt, lcm
from operator import mul


class Refuted(Exception):
    """A fact that is false."""


class NotShown(Exception):
    """A fact that this checker cannot show, and has not refuted."""


class Matrix:
    """`num / den`, `rows` x `columns`."""

    def __init__(self, num, den, columns):
        self.num, self.den, self.rows, self.columns = num, den, len(num), columns

    @classmethod
    def of(cls, entries, columns):
        den = lcm(*(x.denominator for row in entries for x in row))
        return cls([[x.numerator * (den // x.denominator) for x in row] for row in entries], den, columns)

    @classmethod
    def scalar(cls, order, x):
        return cls.diagonal([Fraction(x)] * order)

    @classmethod
    def diagonal(cls, entries):
        zero = Fraction(0)
        return cls.of(
            [[x if i == j else zero for j in range(len(entries))] for i, x in enumerate(entries)], len(entries)
        )

    @classmethod
    def zeros(cls, rows, columns):
        return cls([[0] * columns for _ in range(rows)], 1, columns)

    def reduced(self):
        """With the common factor of all integers removed."""
        common = gcd(self.den, *(x for row in self.num for x in row))
        return (
            self
            if common == 1
            else Matrix([[x // common for x in row] for row in self.num], self.den // common, self.columns)
        )

    def __getitem__(self, place):
        return Fraction(self.num[place[0]][place[1]], self.den)

    def entries(self):
        return [Fraction(x, self.den) for row in self.num for x in row]

    @property
    def T(self):
        return Matrix(
            [list(column) for column in zip(*self.num)] if self.rows else [[] for _ in range(self.columns)],
            self.den,
            self.rows,
        )

    def __matmul__(self, other):
        columns = other.T.num
        return Matrix(
            [[sum(map(mul, row, column)) for column in columns] for row in self.num],
            self.den * other.den,
            other.columns,
        ).reduced()

    def __mul__(self, x):
        x = Fraction(x)
        return Matrix([[y * x.numerator for y in row] for row in self.num], self.den * x.denominator, self.columns)

    def __neg__(self):
        return self * -1

    def __add__(self, other):
        den = lcm(self.den, other.den)
        a, b = den // self.den, den // other.den
        return Matrix([[a * x + b * y for x, y in zip(*rows)] for rows in zip(self.num, other.num)], den, self.columns)

    def __sub__(self, other):
        return self + -other

    def __abs__(self):
        return Matrix([[abs(x) for x in row] for row in self.num], self.den, self.columns)

    def plus_transpose(self):
        return self + self.T

    def is_zero(self):
        return not any(any(row) for row in self.num)

    def block(self, rows, columns):
        return Matrix([self.num[i][columns.start : columns.stop] for i in rows], self.den, len(columns))

    def frobenius_squared(self):
        return Fraction(sum(x * x for row in self.num for x in row), self.den**2)


def blocks(grid):
    """The matrix of blocks."""
    den = lcm(*(m.den for row in grid for m in row))
    num = []
    for row in grid:
        for i in range(row[0].rows):
            num.append([x * (den // m.den) for m in row for x in m.num[i]])
    return Matrix(num, den, sum(m.columns for m in grid[0]))


# Definiteness of a symmetric matrix of integers.

INDEFINITE, SEMIDEFINITE, DEFINITE = range(3)

# Words of 64 bits multiplied that one elimination may cost, about: a minute here.
BUDGET = 5e9


def eliminated(num):
    """Bareiss' elimination: the entries that remain after each pivot are minors, and have the signs of those of the
    Schur complement.
    """
    rest = [list(row) for row in num]
    previous, found = 1, DEFINITE
    while rest:
        n = len(rest)
        diagonal = [rest[i][i] for i in range(n)]
        if min(diagonal) < 0:
            return INDEFINITE
        null = {i for i in range(n) if diagonal[i] == 0}
        if any(any(rest[i]) for i in null):
            return INDEFINITE
        if null:
            found = SEMIDEFINITE
            rest = [[x for j, x in enumerate(row) if j not in null] for i, row in enumerate(rest) if i not in null]
            continue
        k = min(range(n), key=diagonal.__getitem__)
        pivot, head = diagonal[k], rest.pop(k)
        del head[k]
        for i, row in enumerate(rest):
            factor = row.pop(k)
            rest[i] = [(pivot * x - factor * y) // previous for x, y in zip(row, head)]
        previous = pivot
    return found


def factored(num, bits):
    """`(e, l, d, a)`: `L D L'` of the matrix in fixed point with this many bits, scaled to a diagonal near 1 by powers
    of two, less e; `None` where a pivot is not positive.
    """
    n = len(num)
    half = [num[i][i].bit_length() // 2 for i in range(n)]

    def scaled(x, shift):
        return x << shift if shift >= 0 else x >> -shift

    e = 1 << (bits // 2)
    a = [[scaled(num[i][j], bits - half[i] - half[j]) - (e if i == j else 0) for j in range(i + 1)] for i in range(n)]
    l, d = [], []
    for i in range(n):
        row, image = [], []
        for j in range(i):
            v = a[i][j] - (sum(map(mul, image, l[j])) >> bits)
            image.append(v)
            row.append((v << bits) // d[j])
        pivot = a[i][i] - (sum(map(mul, image, row)) >> bits)
        if pivot <= 0:
            return None
        l.append(row)
        d.append(pivot)
    return e, l, d, a


def is_certified(num, bits):
    """A sufficient condition of definiteness, whatever `factored` returned."""
    n = len(num)
    if any(num[i][i] <= 0 for i in range(n)):
        return False
    found = factored(num, bits)
    if found is None:
        return False
    e, l, d, a = found
    one = 1 << bits
    l = [row + [one] for row in l]
    # Each entry of the scaled matrix was cut off by less than one unit.
    sums = [n << (2 * bits)] * n
    for i in range(n):
        image = [x * y for x, y in zip(l[i], d)]
        for j in range(i + 1):
            residual = abs((a[i][j] << (2 * bits)) - sum(map(mul, image, l[j])))
            sums[i] += residual
            if j < i:
                sums[j] += residual
    return all(x < e << (2 * bits) for x in sums)


def sign(m):
    """Whether a symmetric matrix is positive definite, semidefinite, or not even that."""
    n, num = m.rows, m.reduced().num
    if n > 10:
        if any(num[i][i] < 0 for i in range(n)):
            return INDEFINITE
        for bits in (192, 768):
            if is_certified(num, bits):
                return DEFINITE
        words = 1 + n * max(abs(x) for row in num for x in row).bit_length() / 128
        if n**3 / 3 * words**1.6 > BUDGET:
            raise NotShown(f"the elimination of order {n} takes too long")
    return eliminated(num)


def at_least(m, margin, strict):
    """`M >= margin I`, and `M > 0` if so asked. A positive margin implies it."""
    found = sign(m - Matrix.scalar(m.rows, margin))
    if found == INDEFINITE:
        raise Refuted("an eigenvalue is below the margin claimed" if margin else "an eigenvalue has the wrong sign")
    if strict and not margin and found != DEFINITE:
        raise Refuted("an eigenvalue is 0")


# All matrices between bounds.

# The order up to which all corners of a family are taken.
CORNERS = 9


class Family:
    """All symmetric matrices that differ from the middle, one of them, by at most the radius, entry by entry."""

    def __init__(self, middle, radius):
        self.middle, self.radius = middle, radius

    def at_least(self, margin, strict):
        """`M >= margin I` for every M. The middle refutes; to show it, `|x'Ex| <= sum_i (sum_j R_ij s_j/s_i) x_i^2` for
        `|E| <= R` and any s > 0. Where that is not enough, the corners `middle - S R S` for all signs S are, which
        is necessary as well for a family without other structure (Rohn).
        """
        at_least(self.middle, margin, strict)
        if self.radius.is_zero():
            return
        low = self.middle - Matrix.scalar(self.middle.rows, margin)

        def holds(m):
            found = sign(m)
            return found == DEFINITE or (found == SEMIDEFINITE and (margin > 0 or not strict))

        if any(holds(low - Matrix.diagonal(rows)) for rows in self.diagonals(low)):
            return
        n = self.middle.rows
        if n > CORNERS:
            raise NotShown("not shown for all numbers between the bounds")
        for signs in range(1 << (n - 1)):
            s = [-1 if signs >> i & 1 else 1 for i in range(n)]
            corner = Matrix(
                [[x * s[i] * s[j] for j, x in enumerate(row)] for i, row in enumerate(self.radius.num)],
                self.radius.den,
                n,
            )
            if not holds(low - corner):
                raise NotShown("not shown for all numbers between the bounds")

    def diagonals(self, low):
        """Diagonal matrices above every x'Ex, for two scalings: none, and that of a diagonal near 1."""
        n, r = self.middle.rows, self.radius
        for power in (0, 1):
            s = [Fraction(1)] * n
            if power:
                least = [low[i, i] - r[i, i] for i in range(n)]
                if any(x <= 0 for x in least):
                    return
                s = [Fraction(2) ** -((x.numerator.bit_length() - x.denominator.bit_length()) // 2) for x in least]
            yield [sum((r[i, j] * s[j] for j in range(n)), Fraction(0)) / s[i] for i in range(n)]


def interval_matrix(data, columns):
    """The middle and the radius of a matrix of data."""
    middle = Matrix.of([[(x.low + x.high) / 2 for x in row] for row in data], columns)
    return middle, Matrix.of([[(x.high - x.low) / 2 for x in row] for row in data], columns)


# Roots and eigenvalues of rationals, to the safe side.


def root_above(x, bits=128):
    """A rational not below the square root of x >= 0, and within a relative 2^-bits or so; exact for squares of dyadic
    numbers where that is short.
    """
    if x == 0:
        return Fraction(0)
    shift = max(0, bits - (x.numerator.bit_length() - x.denominator.bit_length()) // 2)
    scaled = -(-(x.numerator << (2 * shift)) // x.denominator)
    root = isqrt(scaled)
    return Fraction(root if root * root == scaled else root + 1, 1 << shift)


def smallest_eigenvalue(m, bits=96):
    """A lower bound of the smallest eigenvalue of a positive semidefinite matrix, within a relative 2^-bits."""
    high = min((m[i, i] for i in range(m.rows)), default=Fraction(0))
    if high <= 0 or sign(m) != DEFINITE:
        return Fraction(0)
    low = high
    while sign(m - Matrix.scalar(m.rows, low)) == INDEFINITE:
        high, low = low, low / 2
    # high / 2 <= low < high, or low is the eigenvalue itself.
    for _ in range(bits if low < high else 0):
        middle = (low + high) / 2
        if sign(m - Matrix.scalar(m.rows, middle)) == INDEFINITE:
            high = middle
        else:
            low = middle
    return low


def largest_eigenvalue(m, bits=96):
    """An upper bound of the largest eigenvalue of a positive semidefinite matrix, within a relative 2^-bits of the
    trace.
    """
    trace = sum((m[i, i] for i in range(m.rows)), Fraction(0))
    return trace - smallest_eigenvalue(Matrix.scalar(m.rows, trace) - m, bits) if trace else trace
