"""The observer as a target has it: the stored numbers are the nearest ones, they make a convergent observer, and the
running error stays within bounds.

The plant is `x+ = A x + B u`, `y = C x + v`. With the stored matrices (a tilde for each) the target computes
    joined        xhat+ = F xhat + B~ u + L~ y~,              F the exact A - L~ C rounded once
    innovation    xhat+ = A~ xhat + B~ u + L~ z,              z = y~ - C~ xhat
    accumulated   the same, each of the two sums without rounding and then rounded once
    cubic         xhat+ = A~ (xhat - N~ i) + B~ u + L~ j,     w i = (1 - r) z, j = r z,
                                                              r = 1/sqrt(1 + 2 w h max(z'theta z, 0)).
Everything is bounded entry by entry, by matrices that act on (1, |e_1|, .., |e_n|): here a `Matrix` of n + 1 columns. A
sum of k terms, in any order and with or without fused operations, errs by at most `gamma_k sum |terms| + 2 k (1 +
gamma_k) tiny` in floating point, and by half a unit for each product in fixed point, or for each sum if accumulated.
"""

import re
from fractions import Fraction

import words
from document import LARGEST_BINARY64
from labels import inequalities, inequality
from rational import INDEFINITE, Refuted, Matrix, NotShown, at_least, root_above, sign
from theorems import FALL, inverse, without_margin

LARGEST_ORDER = 32
TURNS = 8
REFINEMENTS = 4
MOST_POWERS = 4096
MOST_BITS = 8192


class Format:
    """A format of numbers; `unit` and `tiny` bound the relative and the absolute error of an operation."""

    def __init__(self, name, quantum, precision, largest, least, unit, tiny):
        self.name, self.quantum, self.precision = name, quantum, precision
        self.largest, self.least, self.unit, self.tiny = largest, least, unit, tiny
        self.is_fixed = precision is None

    @classmethod
    def read(cls, field):
        two = Fraction(2)
        name = field.text()
        if name == "binary32":
            largest = (2**24 - 1) * two**104
            return cls(name, -149, 24, largest, -largest, two**-24, two**-126)
        if name == "binary64":
            return cls(name, -1074, 53, LARGEST_BINARY64, -LARGEST_BINARY64, two**-53, two**-1022)
        found = re.fullmatch(r"Q([0-9]{1,2})\.([0-9]{1,2})", name)
        if not found or int(found[1]) == 0 or not 2 <= int(found[1]) + int(found[2]) <= 53:
            field.fail(f"{name[:80]!r} is no format: binary32, binary64, or Qm.n of 2 to 53 bits")
        whole, part = int(found[1]), int(found[2])
        largest = two ** (whole - 1)
        return cls(f"Q{whole}.{part}", -part, None, largest - two**-part, -largest, Fraction(0), two ** (-part - 1))

    def nearest(self, x):
        """The number of the format nearest to x, ties to even; `None` where x lies beyond the largest."""
        quantum = self.quantum
        if self.precision and x:
            top = abs(x).numerator.bit_length() - abs(x).denominator.bit_length()
            top -= abs(x) < Fraction(2) ** top
            quantum = max(quantum, top - self.precision + 1)
        unit = Fraction(2) ** quantum
        found = round(x / unit) * unit
        return found if self.least <= found <= self.largest else None

    def gamma(self, k):
        return k * self.unit / (1 - k * self.unit)


class Observer:
    """The data of the file."""

    def __init__(self, file):
        with file.object("plant") as plant:
            self.a = plant.take("A").square()
            self.b = plant.take("B").matrix_with_rows(self.a.rows)
            self.c = plant.take("C").matrix(None, self.a.rows)
        self.n, self.inputs, self.outputs = n, inputs, outputs = self.a.rows, self.b.columns, self.c.rows
        if max(n, inputs, outputs) > LARGEST_ORDER:
            file.take("plant").fail(f"is of an order above {LARGEST_ORDER}")
        with file.object("formats") as formats:
            self.stored_in, self.running_in = Format.read(formats.take("stored")), Format.read(formats.take("running"))
        self.step = file.take("step").word("joined", "innovation", "accumulated", "cubic")
        is_joined = self.step == "joined"
        with file.object("stored") as stored:
            self.sa = stored.take("F" if is_joined else "A").matrix(n, n)
            self.sb = stored.take("B").matrix(n, inputs)
            self.sc = self.c if is_joined else stored.take("C").matrix(outputs, n)
            self.l = stored.take("L").matrix(n, outputs)
            if self.step == "cubic":
                self.gain, self.theta = stored.take("N").matrix(n, outputs), stored.take("theta").matrix(
                    outputs, outputs
                )
                self.w, self.h = (stored.take(name).in_range(lambda x: x > 0, "positive") for name in ("w", "period"))
        with file.object("operation") as operation:
            lists = (("x", n), ("u", inputs), ("v", outputs), ("e(0)", n))
            self.x, self.u, self.v, self.first = (read_bounds(operation.take(name), length) for name, length in lists)
            deviation = operation.optional("dA")
            self.deviates = bool(deviation)
            if self.deviates:
                self.da = read_bound_matrix(deviation, n, n)
                self.db = read_bound_matrix(operation.take("dB"), n, inputs)
        with file.object("lyapunov") as proof:
            self.p = proof.take("P").symmetric(n)
        running = file.optional("running")
        self.claims = None
        if running:
            with running.object() as fields:
                self.claims = read_bound(fields.take("start")), read_bounds(fields.take("limsup"), n).entries()
        self.f = self.sa if is_joined else self.sa - self.l @ self.sc

    def check_stored(self):
        """Each stored number is the one of the format nearest to the plant's; the gains are numbers of the format."""
        exact = {"A": self.a, "B": self.b, "C": self.c}
        stored = {"A": self.sa, "B": self.sb, "C": self.sc}
        if self.step == "joined":
            exact["A"] = self.a - self.l @ self.c
            del exact["C"]
        gains = {"L": self.l}
        if self.step == "cubic":
            gains |= {"N": self.gain, "theta": self.theta, "w and h": Matrix.of([[self.w, self.h]], 2)}
        for name, m in (exact | gains).items():
            for x, found in zip(m.entries(), (stored | gains)[name].entries()):
                nearest = self.stored_in.nearest(x)
                if nearest is None:
                    raise Refuted(f"{name} has a number beyond the largest of {self.stored_in.name}")
                if nearest != found:
                    raise Refuted(f"in stored.{name} {words.hexadecimal(found)} is not the nearest number")


def read_bound(field):
    return field.in_range(lambda x: x >= 0, "0 or more")


def read_bounds(field, length):
    return Matrix.of([[read_bound(item)] for item in field.items(length)], 1)


def read_bound_matrix(field, rows, columns):
    found = field.matrix(rows, columns)
    if any(x < 0 for x in found.entries()):
        field.fail("has a negative bound")
    return found


class Step:
    """What one step adds to the error, and the largest numbers that it meets, while `|e_i|` is at most what it is asked
    for.
    """

    def __init__(self, o):
        self.o, self.format = o, o.running_in
        self.maps = [o.f]
        if o.step == "cubic":
            self.maps.append(o.sa @ (Matrix.scalar(o.n, 1) + o.gain @ o.sc * (1 / o.w)))

    def constant(self, column):
        return Matrix([row + [0] * self.o.n for row in column.num], column.den, self.o.n + 1)

    def same(self, rows, x):
        return self.constant(Matrix.of([[x]] * rows, 1))

    def sum_error(self, products, addends, terms):
        k = products + addends
        if self.format.is_fixed:
            roundings = 1 if self.o.step == "accumulated" else products
            return self.same(terms.rows, roundings * self.format.tiny)
        gamma = self.format.gamma(k)
        return terms * gamma + self.same(terms.rows, 2 * k * (1 + gamma) * self.format.tiny)

    def bounds(self, reach):
        """`(added, bend, stages)`: `|e+ - M e| <= added (1, |e|)`, `|M e - F e| <= bend (1, |e|)`; a stage is a name, a
        bound of a number, and what it must not exceed.
        """
        o, n = self.o, self.o.n
        largest = self.format.largest
        stages = [("u", self.constant(o.u), largest)]
        unit = Matrix([[0] + [int(i == j) for j in range(n)] for i in range(n)], 1, n + 1)
        x, noise, u = self.constant(o.x), self.constant(o.v), self.constant(o.u)
        xhat = x + unit
        y = abs(o.c) @ x + noise
        converted = y * self.format.unit + self.same(o.outputs, self.format.tiny)
        measured = y + converted
        stages += [("y", measured, largest), ("xhat", xhat, largest)]
        if not self.format.is_fixed:
            numbers = [o.sa, o.sb, o.sc, o.l] + (
                [o.gain, o.theta, Matrix.of([[o.w, o.h]], 2)] if o.step == "cubic" else []
            )
            most = max((abs(number) for m in numbers for number in m.entries()), default=Fraction(0))
            stages.append(("a stored number", self.same(1, most), largest))
        inputs = abs(o.sb) @ u
        added = abs(o.b - o.sb) @ u
        if o.deviates:
            # The plant moves by (A + dA) x + (B + dB) u, the observer by what it has stored.
            added += o.da @ x + o.db @ u
        bend = Matrix.zeros(n, n + 1)
        products = n + o.inputs + o.outputs
        if o.step == "joined":
            terms = abs(o.sa) @ xhat + inputs + abs(o.l) @ measured
            rounding = self.sum_error(products, 0, terms)
            stages.append(("F xhat + B u + L y", terms + rounding, largest))
            return added + abs(o.a - o.sa - o.l @ o.c) @ x + abs(o.l) @ (noise + converted) + rounding, bend, stages
        added += abs(o.a - o.sa) @ x
        terms = measured + abs(o.sc) @ xhat
        rounding = self.sum_error(n, 1, terms)
        stages.append(("y - C xhat", terms + rounding, largest))
        zeta = abs(o.c - o.sc) @ x + noise + converted + rounding
        z = abs(o.sc) @ unit + zeta
        moved, injected = xhat, z
        if o.step != "cubic":
            added += abs(o.l) @ zeta
        else:
            turned = o.sa @ o.gain
            size = max((z @ reach).entries())
            impulse, innovation, strength, more = self.flow(z, size)
            bend = abs((turned + o.l * o.w) @ o.sc) @ unit * strength
            # |g A N - r L|: it is 0 <= g = (1 - r)/w <= 1/w and 0 <= r <= 1.
            ends = zip(abs(turned).entries(), abs(o.l).entries())
            ends = [max(g / o.w, r) for g, r in ends]
            gain = Matrix.of([ends[i * o.outputs : (i + 1) * o.outputs] for i in range(n)], o.outputs)
            terms = xhat + abs(o.gain) @ (z + impulse) * (1 / o.w)
            rounding = self.sum_error(o.outputs, 1, terms)
            moved, injected = terms + rounding, z + innovation
            stages += [("xhat - N i", moved, largest), *more]
            added += gain @ zeta + abs(turned) @ impulse * (1 / o.w) + abs(o.l) @ innovation + abs(o.sa) @ rounding
        terms = abs(o.sa) @ moved + inputs + abs(o.l) @ injected
        rounding = self.sum_error(products, 0, terms)
        stages.append(("A xhat + B u + L z", terms + rounding, largest))
        return added + rounding, bend, stages

    def flow(self, z, size):
        """The errors of w i and of j against the exact flow of the computed innovation, the largest g, and the stages.

        The code computes, each operation rounded: `s = max |z_k|, d = z/s, q = max(d'theta d, 0), k = 2q h, b = sqrt(w
        k), c = b s, a = sqrt(1 + c c), p = s/a, p' = s/(1 + a)`, or `p = p' = 1/b` for `c > 1/(2u)`, and `j = p d, i =
        (((k p) p')s)d`. With `r = 1/sqrt(1 + c^2)` by definition, j has 5 factors 1 + delta and w i 17.
        """
        o, unit, tiny, largest = self.o, self.format.unit, self.format.tiny, self.format.largest
        w, h, outputs = o.w, o.h, o.outputs
        impulse = z * self.format.gamma(17) + self.same(outputs, 4 * tiny * (1 + w) * (1 + size) ** 3)
        innovation = z * self.format.gamma(5) + self.same(outputs, 4 * tiny * (1 + size))

        def rounded(x):
            return x * (1 + unit) + tiny

        def total(x):
            return outputs * (1 + self.format.gamma(outputs)) * (x + 2 * tiny)

        weighted = total(max(abs(o.theta).entries()))
        form = total(weighted)
        k = rounded(2 * form * h)
        wk = rounded(w * k)
        b = rounded(root_above(wk))
        c = rounded(b * size)
        squared = rounded(1 + rounded(min(c, 1 / (2 * unit)) ** 2))
        pulled = rounded(k * size)
        pulled_twice = min(rounded(pulled * size), 2 / w * (1 + tiny * size**2) + 64 * tiny)
        # Roots of at least half the largest number are not reached, where the code caps the impulse.
        cap = root_above(largest) / 2 * (1 - Fraction(1, 2**50))
        strength = min(1 / w, k * size**2 + tiny / w * (1 + size**2))
        found = {
            "theta d": weighted,
            "2 d'theta d": 2 * form,
            "2q h": k,
            "w k": wk,
            "sqrt(w k)": b,
            "b s": c,
            "1 + c c": squared,
        }
        found |= {
            "1 + a": rounded(1 + rounded(root_above(squared))),
            "s/a": size,
            "k p": pulled,
            "k p p'": pulled_twice,
        }
        stages = [(name, self.same(1, x), largest) for name, x in found.items()]
        return impulse, innovation, strength, stages + [("k p p' s", self.same(1, rounded(pulled_twice * size)), cap)]


class Ball:
    """The errors that `sqrt(e'Pe)` and the bounds of a step leave possible."""

    def __init__(self, o):
        self.o, self.step = o, Step(o)
        p = o.p
        self.rho = contraction(p, self.step.maps)
        spread = inverse(p)
        # |e_i| <= half_i sqrt(e'Pe).
        self.half = Matrix.of([[root_above(spread[i, i])] for i in range(o.n)], 1)

    def length(self, column):
        """A bound of sqrt(e'Pe) for |e| <= the column."""
        return root_above((column.T @ abs(self.o.p) @ column)[0, 0])

    def reach(self, radius):
        return Matrix.of([[Fraction(1)]] + [[x * radius] for x in self.half.entries()], 1)

    def ultimate(self, radius):
        """A bound of limsup sqrt(e'Pe) from errors within the radius, if none leaves it and no number leaves the
        format.
        """
        added, _, stages = self.step.bounds(self.reach(radius))
        n = self.o.n
        beta = self.length(added.block(range(n), range(1)))
        kappa = self.length(added.block(range(n), range(1, n + 1)) @ self.half)
        if self.rho + kappa >= 1:
            raise NotShown("contraction and rounding together do not shorten the error")
        found = beta / (1 - self.rho - kappa)
        if found <= radius:
            for name, size, limit in stages:
                if max((size @ self.reach(radius)).entries(), default=0) > limit:
                    raise NotShown(f"{name} may leave the format")
        return found

    def invariant(self, claimed):
        """A radius at most the one claimed that no error leaves, and the limit: the claim itself, or where that is
        generous a smaller one.
        """
        least = self.length(self.o.first)
        if claimed < least:
            raise NotShown("the first error may be larger than the bound claimed")
        try:
            found = self.ultimate(claimed)
            if found <= claimed:
                return claimed, found
        except NotShown:
            pass
        radius = least
        for _ in range(TURNS):
            found = self.ultimate(radius)
            if found <= radius:
                return radius, found
            radius = min(claimed, found * Fraction(101, 100))
        raise NotShown("no ball within the bound claimed is shown to be invariant")

    def entries(self, ultimate):
        """Bounds of limsup |e_i|: those of the ball, and `sum_{j<k} |F^j| d + half rho^k ultimate` for every k, d being
        what a step adds in the limit.
        """
        best = [x * ultimate for x in self.half.entries()]
        for _ in range(REFINEMENTS):
            reach = Matrix.of([[Fraction(1)]] + [[x] for x in best], 1)
            added, bend, _ = self.step.bounds(reach)
            d = (added + bend) @ reach
            best = self.series(d, ultimate, best)
        return best

    def series(self, d, ultimate, best):
        f, n = self.step.maps[0], self.o.n
        # An error of the powers grows by the sum of a column of |F| at most.
        norm = max(sum(map(abs, column)) for column in f.T.num) / Fraction(f.den)
        growth = max(0, norm.numerator.bit_length() - norm.denominator.bit_length() + 1)
        bits = min(MOST_BITS, 160 + growth * 400)
        power, error, total, rest = Matrix.scalar(n, 1), Fraction(0), Matrix.zeros(n, 1), ultimate
        weight = sum(d.entries(), Fraction(0))
        half, best = self.half.entries(), list(best)
        for _ in range(MOST_POWERS):
            total = cut(total + abs(power) @ d, bits + 64) + Matrix.of([[error * weight]] * n, 1)
            rest = cut_up(rest * self.rho, 256)
            bounds = [total[i, 0] + half[i] * rest for i in range(n)]
            best = [min(x, y) for x, y in zip(best, bounds)]
            if all(half[i] * rest <= total[i, 0] / 10**6 for i in range(n)) or error > 1:
                break
            power = cut(power @ f, bits)
            error = cut_up(error * norm + Fraction(2, 2**bits), 256)
        return best


def cut(m, bits):
    """The matrix with each entry rounded up to a multiple of 2^-bits."""
    return Matrix([[-((-x << bits) // m.den) for x in row] for row in m.num], 1 << bits, m.columns)


def cut_up(x, bits):
    """x >= 0 rounded up to about that many bits."""
    shift = max(0, bits - x.numerator.bit_length() + x.denominator.bit_length())
    return Fraction(-((-x.numerator << shift) // x.denominator), 1 << shift)


def contraction(p, maps, bits=56):
    """A rho with `M'PM <= rho^2 P` for every map, near the least."""
    images = [m.T @ p @ m for m in maps]

    def holds(rho):
        return all(sign(p * (rho * rho) - image) != INDEFINITE for image in images)

    low, high = Fraction(0), Fraction(1)
    if not holds(high):
        raise NotShown("P does not show a contraction")
    for _ in range(bits):
        middle = (low + high) / 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def deployed_observer(file):
    o = Observer(file)
    nearest = f"the stored numbers are those of {o.stored_in.name} nearest to the plant's"
    facts = [(nearest, without_margin(o.check_stored)), *inequalities({"P": o.p}, "P > 0")]
    if o.step == "joined":
        facts.append(inequality("F'PF - P < 0", {"F": o.f, "P": o.p}, " for the stored F"))
    else:
        names = {"A": o.sa, "C": o.sc, "L": o.l, "P": o.p}
        facts.append(inequality(FALL, names, " for the stored A, L and C"))
    if o.step == "cubic":
        names |= {"N": o.gain, "w": o.w}
        facts.append(inequality("(wA + ANC)'P(wA + ANC) - w^2 P < 0", names, " for the stored numbers"))
    if o.claims:
        start, limits = o.claims
        proved = []

        def ball():
            if o.step == "cubic" and o.running_in.is_fixed:
                raise NotShown("the root of the cubic observer is not specified in fixed point")
            at_least(o.p, 0, strict=True)
            found = Ball(o)
            proved.extend(found.entries(found.invariant(start)[1]))

        def entry(i):
            if not proved or proved[i] > limits[i]:
                raise NotShown("the limit of this entry is not shown to be as small")

        facts.append(("sqrt(e'Pe) <= running.start at all times", without_margin(ball)))
        for i in range(o.n):
            facts.append((f"limsup |e_{i + 1}| <= running.limsup[{i}]", without_margin(lambda i=i: entry(i))))
    return (
        words.deployed_observer(
            o.n,
            o.inputs,
            o.outputs,
            o.step,
            o.stored_in.name,
            o.running_in.name if o.claims else None,
            o.deviates,
        ),
        facts,
    )
