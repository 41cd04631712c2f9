"""Interval observers: norms of the blocks of matrices in coordinates z = T e, compared with what a file claims.

T is inverted exactly. A norm is a root of a rational, or half the sum of two; it is bounded from above by a rational
within 2^-128.
"""

from fractions import Fraction

import words
from document import Field
from rational import Matrix, NotShown, Refuted, interval_matrix, root_above
from theorems import inverse, read_data, read_order, without_margin


def hypotenuse(x, y):
    return root_above(x * x + y * y)


class Coordinates:
    """T with its blocks, and the norms of blocks of other matrices."""

    def __init__(self, file, n):
        with file.object("coordinates") as fields:
            self.t = fields.take("T").matrix(n, n)
            field = fields.take("blocks")
            self.sizes = []
            for item in field.items():
                size = item.count()
                if size not in (1, 2):
                    item.fail("a block has one or two entries")
                self.sizes.append(size)
            if sum(self.sizes) != n:
                field.fail(f"adds up to {sum(self.sizes)} instead of {n}")
        starts = [sum(self.sizes[:k]) for k in range(len(self.sizes))]
        self.blocks = [range(start, start + size) for start, size in zip(starts, self.sizes)]
        self.n, self.q = n, len(self.blocks)
        self.known = None

    @property
    def inverse(self):
        if self.known is None:
            self.known = inverse(self.t)
        return self.known

    def regular(self):
        return self.inverse

    @staticmethod
    def norm(m, rows, columns):
        """Not below the spectral norm of at most two rows and columns of m."""
        x = [[m[i, j] for j in columns] for i in rows]
        if len(x) == 1 and len(x[0]) == 1:
            return abs(x[0][0])
        if len(x) == 1 or len(x[0]) == 1:
            return hypotenuse(*(entry for row in x for entry in row))
        (a, b), (c, d) = x
        # Both singular values have the squared sum a^2 + .. + d^2 and the product |ad - bc|.
        return root_above((a * a + b * b + c * c + d * d + discriminant(a, b, c, d)) / 2)

    @staticmethod
    def measure(m, block):
        """Not below the largest eigenvalue of the symmetric part of a diagonal block."""
        if len(block) == 1:
            return m[block[0], block[0]]
        i, j = block
        mean = (m[i, i] + m[j, j]) / 2
        return mean + hypotenuse((m[i, i] - m[j, j]) / 2, (m[i, j] + m[j, i]) / 2)

    def transformed(self, f):
        return self.t @ f @ self.inverse

    def norms(self, f, logarithmic=False):
        m = self.transformed(f)
        return [
            [
                self.measure(m, row) if logarithmic and j == k else self.norm(m, row, column)
                for j, column in enumerate(self.blocks)
            ]
            for k, row in enumerate(self.blocks)
        ]

    def of_columns(self, g):
        m = self.t @ g
        return [[self.norm(m, block, [j]) for j in range(g.columns)] for block in self.blocks]

    def of_states(self):
        return [[self.norm(self.t, block, [i]) for i in range(self.n)] for block in self.blocks]

    def widths(self):
        return [[self.norm(self.inverse, [i], block) for block in self.blocks] for i in range(self.n)]


def discriminant(a, b, c, d):
    """Not below `sqrt((a^2 + b^2 + c^2 + d^2)^2 - 4 (ad - bc)^2)`."""
    square = ((a + d) ** 2 + (b - c) ** 2) * ((a - d) ** 2 + (b + c) ** 2)
    return root_above(square)


def times(m, v):
    return [sum((x * y for x, y in zip(row, v)), Fraction(0)) for row in m]


def product(m, other):
    return [[sum((x * y for x, y in zip(row, column)), Fraction(0)) for column in zip(*other)] for row in m]


def rows_of(m):
    return [[m[i, j] for j in range(m.columns)] for i in range(m.rows)]


def not_below(stored, needed, factor=1):
    """A fact: every entry of `stored`, times `factor`, is at least the one of `needed()`."""

    def test():
        for claimed, least in zip(stored, needed(), strict=True):
            for x, y in zip(claimed, least, strict=True):
                if x * factor < y:
                    raise NotShown(f"{float(x)} is claimed where {float(y / factor)} is shown")

    return without_margin(test)


def column(entries):
    return [[x] for x in entries]


def holds(entries, test):
    def check():
        if not all(map(test, entries)):
            raise Refuted("an entry has the wrong sign")

    return without_margin(check)


def numbers(field, length):
    return [item.binary64() for item in field.items(length)]


def bounds_of(field, length):
    return [item.in_range(lambda x: x >= 0, "0 or more") for item in field.items(length)]


def interval_observer(file):
    with file.object("plant") as plant:
        a = plant.take("A").square()
        n = a.rows
        c = plant.take("C").matrix(None, n)
        field = plant.take("E")
        e = field.matrix_with_rows(n)
        if not e.columns:
            field.fail("is empty")
        d = plant.take("D").matrix(c.rows, e.columns)
    with file.object("observer") as observer:
        l = observer.take("L").matrix(n, c.rows)
    z = Coordinates(file, n)
    with file.object("comparison") as fields:
        k = fields.take("K").matrix(z.q, z.q)
        g = numbers(fields.take("g"), z.q)
        h = fields.take("H").matrix(n, z.q)
        s = numbers(fields.take("s"), z.q)
        rate = fields.take("rate").in_range(lambda x: x > 0, "positive")
    with file.object("bounds") as fields:
        w = bounds_of(fields.take("w"), e.columns)
        limit = bounds_of(fields.take("limit"), z.q)
        widths = bounds_of(fields.take("widths"), n)
    k_rows = rows_of(k)
    off = [k[i, j] for i in range(z.q) for j in range(z.q) if i != j]
    falls = [x + rate * y for x, y in zip(times(k_rows, s), s)]
    kept = [x + y for x, y in zip(times(k_rows, limit), g)]
    facts = [
        ("T is invertible", without_margin(z.regular)),
        ("K is Metzler", holds(off, lambda x: x >= 0)),
        ("K >= norms of the blocks of T(A - LC)T^-1", not_below(k_rows, lambda: z.norms(a - l @ c, True))),
        (
            "g >= norms of the blocks of T(E - LD)w",
            not_below(column(g), lambda: column(times(z.of_columns(e - l @ d), w))),
        ),
        ("H >= norms of the rows of T^-1", not_below(rows_of(h), z.widths)),
        ("s > 0", holds(s, lambda x: x > 0)),
        ("K s + rate s <= 0", holds(falls, lambda x: x <= 0)),
        ("K limit + g <= 0", holds(kept, lambda x: x <= 0)),
        ("H limit <= widths", not_below(column(widths), lambda: column(times(rows_of(h), limit)))),
    ]
    return words.interval_observer(n, c.rows, w, z.sizes, rate, widths), facts


FORMATS = {"binary32": (24, -149, -110), "binary64": (53, -1074, -1000)}


def fits(x, digits, smallest):
    """Whether x is a number of a format with so many digits."""
    if not x:
        return True
    numerator, shift = abs(x.numerator), x.denominator.bit_length() - 1
    odd = numerator >> ((numerator & -numerator).bit_length() - 1)
    top = numerator.bit_length() - shift
    largest = 128 if digits == 24 else 1024
    return odd.bit_length() <= digits and shift <= -smallest and top <= largest


def sampled_interval_observer(file):
    with file.object("plant") as plant:
        field = plant.take("A")
        a_data = read_data(field, *2 * (read_order(field),))
        n = len(a_data)
        field = plant.take("B")
        b_data = field.rows(Field.datum, (n, len(field.items()[0].items()) if field.items() else 0))
        c = plant.take("C").matrix(None, n)
        e = plant.take("E").matrix_with_rows(n)
    m, p = len(b_data[0]), c.rows
    with file.object("observer") as observer:
        f, g_in = observer.take("F").matrix(n, n), observer.take("G").matrix(n, m)
        l = observer.take("L").matrix(n, p)
    z = Coordinates(file, n)
    with file.object("step") as step:
        name = step.take("format").word(*FORMATS)
        digits, smallest, least = FORMATS[name]
        nn = step.take("N").matrix(z.q, z.q)
        g = numbers(step.take("g"), z.q)
        q = step.take("Q").matrix(z.q, n)
        u = step.take("U").matrix(z.q, m)
        h = step.take("H").matrix(n, z.q)
        outward = step.take("outward").in_range(lambda x: 0 <= x < 1, "0 or more and below 1")
    with file.object("comparison") as fields:
        s = numbers(fields.take("s"), z.q)
        factor = fields.take("factor").in_range(lambda x: 0 < x < 1, "above 0 and below 1")
    with file.object("bounds") as fields:
        w = bounds_of(fields.take("w"), e.columns)
        v = bounds_of(fields.take("v"), p)
        xhat = bounds_of(fields.take("xhat"), n)
        inputs = bounds_of(fields.take("u"), m)
        limit = bounds_of(fields.take("limit"), z.q)
        widths = bounds_of(fields.take("widths"), n)
    a, da = interval_matrix(a_data, n)
    b, db = interval_matrix(b_data, m)
    count = 2 * (n + m + p) + z.q + 8
    eps = Fraction(4 * count, 2**digits)
    eta, least = Fraction(1, 2**-smallest), Fraction(1, 2**-least)
    fed = abs(l) @ abs(c)

    def of_states(vectors):
        return product(z.of_states(), vectors)

    def added(x, y):
        return [[s + t for s, t in zip(*rows)] for rows in zip(x, y)]

    def of_error():
        # The radius of A in coordinates, entry by entry at most the norms of its rows and columns.
        spread = product(of_states(rows_of(da)), z.widths())
        return added(added(z.norms(a - l @ c), spread), of_states(product(rows_of(fed * eps), z.widths())))

    def constant():
        forced = [x + y for x, y in zip(times(z.of_columns(e), w), times(z.of_columns(l), v))]
        rounded = times(z.of_states(), [eps * x for x in times(rows_of(abs(l)), v)])
        small = times(z.of_states(), [1 + sum(row) for row in rows_of(abs(l))])
        return column([x + y + least * count * (1 + t) for x, y, t in zip(forced, rounded, small)])

    def of_estimate():
        return of_states(rows_of(abs(a - f) + da + (abs(f) + fed) * eps))

    def of_input():
        return of_states(rows_of(abs(b - g_in) + db + abs(g_in) * eps)) if m else [[] for _ in range(z.q)]

    stored = [x for matrix in (f, g_in, c, l, nn, q, u, h) for x in matrix.entries()] + g + [outward]

    def of_format():
        if not all(fits(x, digits, smallest) for x in stored):
            raise Refuted("a number is none of the format")

    n_rows, h_rows = rows_of(nn), rows_of(h)
    next_s = [(1 + eps) * x for x in times(n_rows, s)]
    terms = zip(times(n_rows, limit), g, times(rows_of(q), xhat), times(rows_of(u), inputs))
    rho = [(1 + eps) * sum(each) + least for each in terms]
    ends = [(1 + eps) * (x + 2 * outward * y) + least for x, y in zip(times(h_rows, limit), xhat)]
    facts = [
        ("the numbers of the step are those of the format", without_margin(of_format)),
        ("T is invertible", without_margin(z.regular)),
        (
            "(1 - eps) N >= norms of the blocks of T(A - LC)T^-1, rounding included",
            not_below(n_rows, of_error, 1 - eps),
        ),
        (
            "(1 - eps) g >= norms of the blocks of T(Ew - Lv), rounding included",
            not_below(column(g), constant, 1 - eps),
        ),
        ("(1 - eps) Q >= errors of F and rounding", not_below(rows_of(q), of_estimate, 1 - eps)),
        ("(1 - eps) U >= errors of G and rounding", not_below(rows_of(u), of_input, 1 - eps)),
        ("(1 - eps) H >= norms of the rows of T^-1", not_below(h_rows, z.widths, 1 - eps)),
        ("eps H g >= 2 c eta", holds(times(h_rows, g), lambda x: eps * x >= 2 * count * eta)),
        ("outward >= eps", holds([outward], lambda x: x >= eps)),
        ("s > 0", holds(s, lambda x: x > 0)),
        ("(1 + eps) N s <= factor s", holds(list(zip(next_s, s)), lambda x: x[0] <= factor * x[1])),
        (
            "(1 + eps)(N limit + g + Q xhat + U u) + least <= limit",
            holds(list(zip(rho, limit)), lambda x: x[0] <= x[1]),
        ),
        (
            "(1 + eps)(H limit + 2 outward xhat) + least <= widths",
            holds(list(zip(ends, widths)), lambda x: x[0] <= x[1]),
        ),
    ]
    single = all(x.is_single for matrix in (a_data, b_data) for row in matrix for x in row)
    size = n, m, e.columns, p
    return words.sampled_interval_observer(size, name, w, v, z.sizes, xhat, inputs, factor, widths, single), facts


KINDS = {"interval-observer": interval_observer, "sampled-interval-observer": sampled_interval_observer}
