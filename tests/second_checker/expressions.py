"""Expressions of a certificate: text, rational functions of atoms with derivatives, and bounds over a box.

A value is a quotient N/D of polynomials with rational coefficients, D a product of factors. Its variables are atoms:
those of the box, and elementary functions of other values. Derivatives are carried along (forward mode). So an identity
between expressions leaves N = 0, and `N/D <= c` is `+-(N - c D) <= 0` for a D of known sign.

A polynomial is bounded on a part of the box by its expansion around the middle: with `x = m + r d`, `|d| <= 1`, it is a
polynomial in the d, whose coefficients are added up. An elementary function is a further variable there, within its
bounds. Parts are halved until the inequality holds on each.
"""

import re
from collections import defaultdict
from fractions import Fraction
from math import comb

import functions
from document import Malformed, is_binary64, number
from rational import NotShown, Refuted

LONGEST, DEEPEST, LARGEST_EXPONENT = 16_384, 48, 64

# Terms that the polynomials of one certificate may have together as they are computed, digits counted, and terms of
# the expansions of all parts.
WORK, EXPANDED = 1 << 19, 1 << 20
PARTS = 1 << 13
DEGREE, BITS, ATOMS = 256, 1 << 13, 256

TOKEN = re.compile(r" *(?:(0x[0-9a-fA-F.]*(?:p[+-]?[0-9]*)?|[0-9]+(?:\.[0-9]+)?)|([a-z][a-zA-Z0-9]*)|([-+*/^()]))")


# Text.


def parse(text, names):
    """The tree of an expression in these variables."""
    if len(text) > LONGEST or not text.isascii():
        raise Malformed("an expression that is too long, or has characters that none has")
    tokens, at = [], 0
    stripped = text.rstrip(" ")
    while at < len(stripped):
        found = TOKEN.match(stripped, at)
        if not found:
            raise Malformed(f"{stripped[at : at + 20]!r} does not belong in an expression")
        tokens.append(next((kind, found[kind]) for kind in (1, 2, 3) if found[kind] is not None))
        at = found.end()
    tokens.append((0, ""))
    place, depth = 0, 0

    def peek():
        return tokens[place]

    def accept(*symbols):
        nonlocal place
        if peek()[0] == 3 and peek()[1] in symbols:
            place += 1
            return tokens[place - 1][1]
        return None

    def expect(symbol):
        if not accept(symbol):
            raise Malformed(f"{symbol!r} should stand before {peek()[1]!r} in an expression")

    def nested(read):
        nonlocal depth
        if depth >= DEEPEST:
            raise Malformed(f"an expression that is nested deeper than {DEEPEST}")
        depth += 1
        found = read()
        depth -= 1
        return found

    def chain(kind, read, symbols):
        items = [(symbols[0], read())]
        while symbol := accept(*symbols):
            items.append((symbol, read()))
        return items[0][1] if len(items) == 1 else (kind, items)

    def total():
        return chain("sum", lambda: chain("product", factor, "*/"), "+-")

    def factor():
        nonlocal place
        if accept("-"):
            return ("negative", nested(factor))
        found = base()
        if not accept("^"):
            return found
        sign = -1 if accept("-") else 1
        kind, digits = peek()
        if kind != 1 or not digits.isdigit() or len(digits) > 9 or int(digits) > LARGEST_EXPONENT:
            raise Malformed(f"{digits[:20]!r} is no exponent: an integer of magnitude {LARGEST_EXPONENT} at most")
        place += 1
        return ("power", found, sign * int(digits))

    def base():
        nonlocal place
        kind, token = peek()
        place += 1
        if kind == 3 and token == "(":
            found = nested(total)
            expect(")")
            return found
        if kind == 1:
            return ("number", literal(token))
        if kind == 2 and token in functions.NAMES:
            expect("(")
            found = nested(total)
            expect(")")
            return ("function", token, found)
        if kind == 2 and token in names:
            return ("variable", token)
        raise Malformed(f"{token[:40]!r} is no number and no variable here")

    found = total()
    if peek()[0]:
        raise Malformed(f"an operator should stand before {peek()[1]!r}")
    return found


def literal(token):
    if token.startswith("0x"):
        return number(token)
    whole, _, part = token.partition(".")
    x = Fraction(int(whole + part), 10 ** len(part))
    if not is_binary64(x):
        raise Malformed(f"the number {token[:40]} is none of binary64")
    return x


# Polynomials: dictionaries from monomials, sorted tuples of (atom, power), to fractions.


def multiplied(m, n):
    powers = defaultdict(int, m)
    for atom, power in n:
        powers[atom] += power
    return tuple(sorted(powers.items()))


def added(p, q, factor=1):
    found = dict(p)
    for monomial, x in q.items():
        x = found.get(monomial, 0) + factor * x
        if x:
            found[monomial] = x
        else:
            found.pop(monomial, None)
    return found


def frozen(p):
    return tuple(sorted(p.items()))


ONE = {(): Fraction(1)}


class Value:
    """`numerator` over the product of the `denominators`, frozen polynomials with powers; and the derivatives by the
    variables, values without derivatives of their own.
    """

    def __init__(self, numerator, denominators=None, slopes=None):
        self.numerator, self.denominators, self.slopes = numerator, denominators or {}, slopes or {}


class Algebra:
    """Values over the variables 0 .. count - 1, which are the first atoms."""

    def __init__(self, count):
        self.count, self.atoms, self.work = count, [None] * count, 0
        self.numbers = {}
        # Conditions that all functions are defined: values that are positive, polynomials that are not 0.
        self.positive, self.not_zero = {}, {}
        self.signs = {}
        self.expanded = 0

    def variable(self, k):
        return Value({((k, 1),): Fraction(1)}, None, {k: Value(dict(ONE))})

    def constant(self, x):
        return Value({(): x} if x else {})

    # Polynomials.

    def count_terms(self, p):
        for monomial, x in p.items():
            bits = max(x.numerator.bit_length(), x.denominator.bit_length())
            self.work += 1 + bits // 256
            if bits > BITS or sum(power for _, power in monomial) > DEGREE:
                raise NotShown("a polynomial of too high a degree, or with too many digits")
        if self.work > WORK:
            raise NotShown("the polynomials of the expressions have too many terms")
        return p

    def times(self, p, q):
        self.work += len(p) * len(q)
        if self.work > WORK:
            raise NotShown("the polynomials of the expressions have too many terms")
        found = {}
        for m, x in p.items():
            for n, y in q.items():
                key = multiplied(m, n)
                found[key] = found.get(key, 0) + x * y
        return self.count_terms(self.reduced({m: x for m, x in found.items() if x}))

    def power_of(self, p, n):
        found = ONE
        for _ in range(n):
            found = self.times(found, p)
        return found

    def reduced(self, p):
        """Without even powers of cosines and roots: cos^2 = 1 - sin^2, sqrt(p)^2 = p, where p has been recorded as
        positive."""
        for monomial in list(p):
            for atom, power in monomial:
                if power >= 2 and self.atoms[atom] and self.atoms[atom][0] == "sqrt" and not self.atoms[atom][2]:
                    x = p.pop(monomial)
                    rest = tuple(item for item in monomial if item[0] != atom)
                    rest = multiplied(rest, ((atom, power - 2),)) if power > 2 else rest
                    for inner, factor in self.atoms[atom][1]:
                        p = added(p, {multiplied(rest, inner): x * factor})
                    self.work += len(p)
                    return self.reduced(p) if self.work < WORK else p
                if power >= 2 and self.atoms[atom] and self.atoms[atom][0] == "cos":
                    sine = self.numbers.get(("sin", *self.atoms[atom][1:]))
                    if sine is None:
                        continue
                    x = p.pop(monomial)
                    rest = tuple(item for item in monomial if item[0] != atom)
                    rest = multiplied(rest, ((atom, power - 2),)) if power > 2 else rest
                    p = added(p, {rest: x})
                    p = added(p, {multiplied(rest, ((sine, 2),)): -x})
                    self.work += len(p)
                    return self.reduced(p) if self.work < WORK else p
        return p

    def product_of(self, factors):
        found = ONE
        for p, power in factors.items():
            found = self.times(found, self.power_of(dict(p), power))
        return found

    # Values. The rules of differentiation are in `add`, `multiply`, `divide` and `function`.

    def raw_add(self, a, b, factor=1):
        common = {p: max(a.denominators.get(p, 0), b.denominators.get(p, 0)) for p in {*a.denominators, *b.denominators}}
        left = self.product_of({p: n - a.denominators.get(p, 0) for p, n in common.items()})
        right = self.product_of({p: n - b.denominators.get(p, 0) for p, n in common.items()})
        numerator = added(self.times(a.numerator, left), self.times(b.numerator, right), factor)
        return Value(self.count_terms(numerator), common if numerator else {})

    def raw_multiply(self, a, b):
        numerator = self.times(a.numerator, b.numerator)
        powers = defaultdict(int, a.denominators)
        for p, n in b.denominators.items():
            powers[p] += n
        return Value(numerator, dict(powers) if numerator else {})

    def add(self, a, b, factor=1):
        found = self.raw_add(a, b, factor)
        for k in {*a.slopes, *b.slopes}:
            found.slopes[k] = self.raw_add(a.slopes.get(k, Value({})), b.slopes.get(k, Value({})), factor)
        return found

    def multiply(self, a, b):
        found = self.raw_multiply(a, b)
        for k in {*a.slopes, *b.slopes}:
            left = self.raw_multiply(a.slopes.get(k, Value({})), b)
            found.slopes[k] = self.raw_add(left, self.raw_multiply(a, b.slopes.get(k, Value({}))))
        return found

    def divide(self, a, b):
        if not b.numerator:
            raise NotShown("a denominator is 0 everywhere")
        inverse = Value(self.product_of(b.denominators))
        if set(b.numerator) == {()}:
            inverse.numerator = {m: x / b.numerator[()] for m, x in inverse.numerator.items()}
        else:
            key = frozen(b.numerator)
            self.not_zero[key] = None
            inverse.denominators = {key: 1}
        found = self.raw_multiply(a, inverse)
        # (a/b)' = (a' - (a/b) b')/b
        for k in {*a.slopes, *b.slopes}:
            change = self.raw_multiply(found, b.slopes.get(k, Value({})))
            found.slopes[k] = self.raw_multiply(self.raw_add(a.slopes.get(k, Value({})), change, -1), inverse)
        return found

    def function(self, name, a):
        if name in ("ln", "sqrt"):
            self.positive[frozen(a.numerator), frozen(a.denominators)] = a
        found = self.atom(name, a)
        bare = Value(a.numerator, a.denominators)
        if name == "sin":
            outer = self.atom("cos", bare)
        elif name == "cos":
            outer = self.raw_add(Value({}), self.atom("sin", bare), -1)
        elif name == "exp":
            outer = found
        elif name == "ln":
            outer = self.divide(self.constant(Fraction(1)), bare)
        elif name == "sqrt":
            outer = self.divide(self.constant(Fraction(1, 2)), Value(found.numerator))
        elif name == "tanh":
            outer = self.raw_add(Value(ONE), self.raw_multiply(found, found), -1)
        else:
            outer = self.divide(Value(ONE), self.raw_add(Value(ONE), self.raw_multiply(bare, bare)))
        for k, slope in a.slopes.items():
            found.slopes[k] = self.raw_multiply(outer, slope)
        return found

    def atom(self, name, a):
        if not a.numerator and name not in ("ln", "sqrt"):
            return Value(dict(ONE) if name in ("cos", "exp") else {})
        # ln exp p = p, and exp ln p = p, where p has been recorded as positive.
        if not a.denominators and len(a.numerator) == 1:
            ((monomial, x),) = a.numerator.items()
            if x == 1 and len(monomial) == 1 and monomial[0][1] == 1:
                inner = self.atoms[monomial[0][0]]
                if inner and (name, inner[0]) in (("ln", "exp"), ("exp", "ln")):
                    return Value(dict(inner[1]), dict(inner[2]))
        key = (name, frozen(a.numerator), frozen(a.denominators))
        if key not in self.numbers:
            if len(self.atoms) >= ATOMS:
                raise NotShown("too many elementary functions")
            self.numbers[key] = len(self.atoms)
            self.atoms.append(key)
        return Value({((self.numbers[key], 1),): Fraction(1)})

    def evaluate(self, tree, scope):
        kind = tree[0]
        if kind == "number":
            return self.constant(tree[1])
        if kind == "variable":
            return scope[tree[1]]
        if kind == "negative":
            return self.add(Value({}), self.evaluate(tree[1], scope), -1)
        if kind == "function":
            return self.function(tree[1], self.evaluate(tree[2], scope))
        if kind == "power":
            base, found = self.evaluate(tree[1], scope), self.constant(Fraction(1))
            for _ in range(abs(tree[2])):
                found = self.multiply(found, base)
            return found if tree[2] >= 0 else self.divide(self.constant(Fraction(1)), found)
        found = self.evaluate(tree[1][0][1], scope)
        for symbol, item in tree[1][1:]:
            item = self.evaluate(item, scope)
            if symbol in "+-":
                found = self.add(found, item, 1 if symbol == "+" else -1)
            else:
                found = self.multiply(found, item) if symbol == "*" else self.divide(found, item)
        return found

    # Bounds.

    def depends_on(self, p):
        """The variables of a polynomial."""
        found, left, seen = set(), [p], set()
        while left:
            for atom in {atom for monomial in left.pop() for atom, _ in monomial} - seen:
                seen.add(atom)
                if self.atoms[atom] is None:
                    found.add(atom)
                else:
                    left += [dict(self.atoms[atom][1])] + [dict(q) for q, _ in self.atoms[atom][2]]
        return found

    def expansion(self, p, box):
        """The constant, and the other terms, in deviations of magnitude 1 of the atoms; `None` where an atom is not
        defined.
        """
        found = defaultdict(Fraction)
        for monomial, x in p.items():
            terms = {(): x}
            for atom, power in monomial:
                bounds = self.atom_over(atom, box)
                if bounds is None:
                    return None
                middle, radius = (bounds[0] + bounds[1]) / 2, (bounds[1] - bounds[0]) / 2
                powers = [(k, comb(power, k) * middle ** (power - k) * radius**k) for k in range(power + 1)]
                powers = [(k, y) for k, y in powers if y]
                terms = {m + ((atom, k),) if k else m: x * y for m, x in terms.items() for k, y in powers}
                self.expanded += len(terms)
            if self.expanded > EXPANDED:
                raise NotShown("the bounds over the box take too long")
            for m, x in terms.items():
                found[m] += x
        return found.pop((), Fraction(0)), found

    def over(self, p, box):
        """Bounds of a polynomial on a part, and the weight of each atom in them."""
        expansion = self.expansion(p, box)
        if expansion is None:
            return None, None, {}
        low = high = expansion[0]
        weights = defaultdict(Fraction)
        for monomial, x in expansion[1].items():
            if all(power % 2 == 0 for _, power in monomial):
                low, high = low + min(x, 0), high + max(x, 0)
            else:
                low, high = low - abs(x), high + abs(x)
            for atom, _ in monomial:
                weights[atom] += abs(x)
        return low, high, weights

    def atom_over(self, atom, box):
        if atom in box:
            return box[atom]
        name, numerator, denominators = self.atoms[atom]
        low, high, _ = self.over(dict(numerator), box)
        for p, power in denominators:
            below, above, _ = self.over(dict(p), box)
            for _ in range(power):
                if low is None or below is None or below <= 0 <= above:
                    low = high = None
                    break
                ends = [x / y for x in (low, high) for y in (below, above)]
                low, high = min(ends), max(ends)
        box[atom] = None if low is None else functions.over(name, low, high)
        return box[atom]

    def holds(self, p, box, strict=False):
        """`p <= 0` over a box, or `p < 0`: shown, or an error."""
        if not p:
            if strict:
                raise Refuted("a quantity that should not be 0 is 0")
            return
        variables = self.depends_on(p)
        parts, count = [box], 0
        while parts:
            part = parts.pop()
            count += 1
            if count > PARTS:
                raise NotShown("not shown over the box")
            inner = dict(part)
            low, high, weights = self.over(p, inner)
            if high is not None and (high < 0 or (high == 0 and not strict)):
                continue
            if low is not None and low > 0:
                raise Refuted("an inequality is false in a part of the box")
            weight = defaultdict(Fraction)
            for atom, x in weights.items():
                of = [atom] if self.atoms[atom] is None else self.depends_on({((atom, 1),): 1})
                for k in of:
                    weight[k] += x
            wide = [k for k in variables if part[k][0] < part[k][1]]
            if not wide:
                raise NotShown("not shown over the box")
            cut = max(wide, key=lambda k: (weight[k], part[k][1] - part[k][0]))
            middle = (part[cut][0] + part[cut][1]) / 2
            parts += [part | {cut: (part[cut][0], middle)}, part | {cut: (middle, part[cut][1])}]

    def sign(self, key, box):
        """1 or -1: the sign of a polynomial over the box, which is shown not to be 0."""
        place = key, tuple(sorted(box.items()))
        if place not in self.signs:
            p = dict(key)
            inner = {k: (bounds[0] + bounds[1],) * 2 for k, bounds in box.items()}
            low, _, _ = self.over(p, {k: (x / 2, y / 2) for k, (x, y) in inner.items()})
            sign = 1 if low is not None and low > 0 else -1
            self.holds({m: -sign * x for m, x in p.items()}, box, strict=True)
            self.signs[place] = sign
        return self.signs[place]

    def at_most(self, value, bound, box):
        """`value <= bound` over the box."""
        sign = 1
        for key, power in value.denominators.items():
            sign *= self.sign(key, box) ** power
        denominator = self.product_of(value.denominators)
        p = added(value.numerator, denominator, -bound)
        self.holds({m: sign * x for m, x in p.items()}, box)

    def between(self, value, low, high, box):
        self.at_most(value, high, box)
        self.at_most(Value({m: -x for m, x in value.numerator.items()}, value.denominators), -low, box)

    def is_defined(self, box):
        """All functions that have occurred are, over the box."""
        for key in list(self.not_zero):
            self.sign(key, box)
        for value in list(self.positive.values()):
            sign = -1
            for key, power in value.denominators.items():
                sign *= self.sign(key, box) ** power
            self.holds({m: sign * x for m, x in value.numerator.items()}, box, strict=True)
