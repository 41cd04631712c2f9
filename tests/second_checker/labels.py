"""The labels of facts, `(A - LC)'P + P(A - LC) + 2 rate P < 0 (12)`, read as the inequalities that they are.

Tokens are evaluated as they are read, in rational arithmetic. A value is a `Fraction`, a `Multiple` of the identity,
whose size is that of what it is added to, or a `Family` of matrices: a datum between bounds is its middle and its
radius, and `|(A + E)(B + F) - AB| <= |A| |F| + |E| |B| + |E| |F|`. `'` is the transpose, `He(X)` is `X + X'`, `*` in a block matrix
the transpose of the block opposite. Where two names begin alike the longer one is meant; `for F = A - LC` behind an
inequality defines a name in it.
"""

import re
from fractions import Fraction

from rational import Family, Matrix, NotShown, blocks

LABEL = re.compile(r"(.*?) (<=|>=|<|>) (.*?)(?: \(\d+'?\))?")
WORDS = r"He\(|diag\(|tr |"
SIGNS = r"|I|\d+|\^2|/2|['()\[\],;*+-]"


class Multiple:
    """`x I`."""

    def __init__(self, x):
        self.x = x


def family(m):
    return m if isinstance(m, Family) else Family(m, Matrix.zeros(m.rows, m.columns))


def transposed(value):
    return Family(value.middle.T, value.radius.T) if isinstance(value, Family) else value


def negative(value):
    if isinstance(value, Family):
        return Family(-value.middle, value.radius)
    return Multiple(-value.x) if isinstance(value, Multiple) else -value


def plus(a, b):
    if isinstance(a, Multiple) and isinstance(b, Multiple):
        return Multiple(a.x + b.x)
    if isinstance(a, Multiple):
        a, b = b, a
    if isinstance(b, Multiple):
        return Family(a.middle + Matrix.scalar(a.middle.rows, b.x), a.radius)
    if isinstance(a, Family):
        if (a.middle.rows, a.middle.columns) != (b.middle.rows, b.middle.columns):
            raise ValueError("a sum of matrices of two shapes")
        return Family(a.middle + b.middle, a.radius + b.radius)
    return a + b


def times(a, b):
    for x, y in ((a, b), (b, a)):
        if isinstance(x, Multiple):
            x = x.x
            if isinstance(y, Multiple):
                return Multiple(x * y.x)
            if isinstance(y, Fraction):
                return Multiple(x * y)
        if isinstance(x, Fraction):
            if isinstance(y, Family):
                return Family(y.middle * x, y.radius * abs(x))
            return Multiple(x * y.x) if isinstance(y, Multiple) else x * y
    if a.middle.columns != b.middle.rows:
        raise ValueError("a product of matrices that do not fit")
    middle = a.middle @ b.middle
    radius = Matrix.zeros(middle.rows, middle.columns)
    for x, y in ((a.radius, abs(b.middle)), (abs(a.middle), b.radius), (a.radius, b.radius)):
        if not (x.is_zero() or y.is_zero()):
            radius += x @ y
    return Family(middle, radius)


class Reader:
    """`names` maps names to values, or to functions of none that return or refuse them."""

    def __init__(self, text, names):
        self.names = names
        longest_first = "|".join(map(re.escape, sorted(names, key=len, reverse=True)))
        tokens = re.compile(f"{WORDS}{longest_first}{SIGNS}")
        self.tokens, at = [], 0
        while at < len(text):
            found = tokens.match(text, at)
            if found:
                self.tokens.append(found.group())
            elif text[at] != " ":
                raise ValueError(f"{text[at:]} in the label {text}")
            at = found.end() if found else at + 1
        self.tokens.append("")
        self.tokens.reverse()

    def next_is(self, *tokens):
        return self.tokens[-1] in tokens

    def take(self, *tokens):
        if self.next_is(*tokens):
            return self.tokens.pop()
        return None

    def sum(self):
        total = None
        sign = self.take("-")
        while True:
            value = self.product()
            value = negative(value) if sign == "-" else value
            total = value if total is None else plus(total, value)
            sign = self.take("+", "-")
            if sign is None:
                return total

    def product(self):
        value = self.factor()
        while True:
            if self.take("/2"):
                value = times(value, Fraction(1, 2))
            elif self.next_is("", "+", "-", ")", "]", ",", ";"):
                return value
            else:
                value = times(value, self.factor())

    def factor(self):
        value = self.atom()
        while True:
            if self.take("'"):
                value = transposed(value)
            elif self.take("^2"):
                value = times(value, value)
            else:
                return value

    def atom(self):
        token = self.tokens.pop()
        if token in self.names:
            value = self.names[token]
            value = value() if callable(value) else value
            return family(value) if isinstance(value, (Matrix, Family)) else value
        if token == "(" or token == "He(":
            value = self.sum()
            self.tokens.pop()
            return value if token == "(" else plus(value, transposed(value))
        if token == "diag(":
            value = self.names[self.tokens.pop()]
            self.tokens.pop()
            return family(Matrix.diagonal(value))
        if token == "tr ":
            value = self.product().middle
            return sum((value[i, i] for i in range(value.rows)), Fraction(0))
        if token == "[":
            return self.blocks()
        return Multiple(Fraction(1)) if token == "I" else Fraction(int(token))

    def blocks(self):
        rows = [[]]
        while True:
            rows[-1].append(None if self.take("*") else self.sum())
            end = self.tokens.pop()
            if end == ";":
                rows.append([])
            elif end == "]":
                break
        grid = [
            [transposed(rows[j][i]) if entry is None else entry for j, entry in enumerate(row)] for i, row in enumerate(rows)
        ]
        heights = [next((x.middle.rows for x in row if isinstance(x, Family)), None) for row in grid]
        widths = [next((x.middle.columns for x in column if isinstance(x, Family)), None) for column in zip(*grid)]
        for k in range(min(len(heights), len(widths))):
            heights[k] = heights[k] or widths[k] or 1
            widths[k] = widths[k] or heights[k]

        def sized(value, rows, columns):
            if isinstance(value, Family):
                return value
            x = value.x if isinstance(value, Multiple) else value
            if x and rows != columns:
                raise ValueError("a number in the place of a block")
            return family(Matrix.scalar(rows, x) if rows == columns else Matrix.zeros(rows, columns))

        grid = [[sized(x, height, width) for x, width in zip(row, widths)] for row, height in zip(grid, heights)]
        return Family(*(blocks([[getattr(x, part) for x in row] for row in grid]) for part in ("middle", "radius")))


def inequality(label, names, where=""):
    """The fact of a label, with what is said behind it: its test takes the margin that is claimed."""
    left, relation, right = LABEL.fullmatch(label).groups()
    right, _, definition = right.partition(" for ")

    def test(margin):
        name, _, expression = definition.partition(" = ")
        known = names | {name: Reader(expression, names).sum()} if name else names
        less, more = (left, right) if relation.startswith("<") else (right, left)
        sides = [negative(Reader(less, known).sum())] if less != "0" else []
        sides += [Reader(more, known).sum()] if more != "0" else []
        difference = sides[0] if len(sides) == 1 else plus(*sides)
        if isinstance(difference, Fraction):
            difference = family(Matrix.diagonal([difference]))
        for part in (difference.middle, difference.radius):
            if not (part - part.T).is_zero():
                raise NotShown("the sides of the inequality are not symmetric")
        difference.at_least(margin, strict=len(relation) == 1)

    return label + where, test


def inequalities(names, *labels):
    return [inequality(label, names) for label in labels]
