"""The document: strict JSON, its canonical form and digest, exact numbers, and fields with their shapes.

Nothing here knows a theorem. `Unreadable` is raised for what is no JSON document within the limits, `Malformed` for a
document that is no certificate.
"""

import hashlib
import math
import re
from fractions import Fraction

from rational import Matrix

LARGEST_FILE = 8 << 20
DEEPEST = 16
MOST_MEMBERS = 64
MOST_VALUES = 1 << 21
LONGEST_NUMBER = 20_000
MOST_HEXADECIMAL_DIGITS = 64
LARGEST_ORDER = 512
MOST_ENTRIES = 1 << 20
LARGEST_BINARY64 = (2**53 - 1) * Fraction(2) ** 971


class Unreadable(Exception):
    """No JSON document."""


class Malformed(Exception):
    """A JSON document that is no certificate."""


class Literal(str):
    """A JSON number, or `true`, `false`, `null`, as it was written."""


STRING = re.compile(r'"((?:[^"\\\x00-\x1f\x7f-\x9f]|\\["\\/]|\\u[0-9a-fA-F]{4})*)"')
ESCAPE = re.compile(r"\\(?:u([0-9a-fA-F]{4})|(.))")
LITERAL = re.compile(r"-?(?:0|[1-9][0-9]*)(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?|true|false|null")
SPACE = re.compile(r"[ \t\r\n]*")


def parse(data):
    """The tree of a document: dicts, lists, strings, `Literal`s."""
    if len(data) > LARGEST_FILE:
        raise Unreadable(f"more than {LARGEST_FILE} bytes")
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise Unreadable(f"not UTF-8 at byte {error.start}") from None

    def fail(at, expected):
        line = text.count("\n", 0, at) + 1
        raise Unreadable(f"line {line}: {expected} expected" + (", the file ends" if at >= len(text) else ""))

    def skip(at):
        return SPACE.match(text, at).end()

    def string(at):
        found = STRING.match(text, at)
        if not found:
            fail(at, "a string without control characters")

        def unescape(escape):
            if escape[1] is None:
                return escape[2]
            code = int(escape[1], 16)
            if code < 0x20 or 0x7F <= code < 0xA0 or 0xD800 <= code < 0xE000:
                fail(at, "an escape that is neither a control character nor half of a pair")
            return chr(code)

        return ESCAPE.sub(unescape, found[1]), found.end()

    values = 0

    def value(at, depth):
        nonlocal values
        at, values = skip(at), values + 1
        if depth > DEEPEST:
            raise Unreadable(f"nested deeper than {DEEPEST}")
        if values > MOST_VALUES:
            raise Unreadable(f"more than {MOST_VALUES} values")
        if text.startswith("{", at):
            return members(at + 1, depth)
        if text.startswith("[", at):
            return items(at + 1, depth)
        if text.startswith('"', at):
            return string(at)
        found = LITERAL.match(text, at)
        if not found:
            fail(at, "a value")
        return Literal(found[0]), found.end()

    def items(at, depth):
        found = []
        at = skip(at)
        if text.startswith("]", at):
            return found, at + 1
        while True:
            item, at = value(at, depth + 1)
            found.append(item)
            at = skip(at)
            if text.startswith("]", at):
                return found, at + 1
            if not text.startswith(",", at):
                fail(at, "',' or ']'")
            at += 1

    def members(at, depth):
        found = {}
        at = skip(at)
        if text.startswith("}", at):
            return found, at + 1
        while True:
            at = skip(at)
            name, at = string(at)
            if len(found) >= MOST_MEMBERS:
                raise Unreadable(f"an object with more than {MOST_MEMBERS} members")
            if name in found:
                raise Unreadable(f"the field {name[:80]!r} twice in one object")
            at = skip(at)
            if not text.startswith(":", at):
                fail(at, "':'")
            found[name], at = value(at + 1, depth + 1)
            at = skip(at)
            if text.startswith("}", at):
                return found, at + 1
            if not text.startswith(",", at):
                fail(at, "',' or '}'")
            at += 1

    tree, at = value(0, 0)
    if skip(at) < len(text):
        fail(skip(at), "the end of the file")
    return tree


def canonical(tree, left_out=None):
    """No white space between tokens, members in the order of their names, in strings no escapes but those of quote and
    backslash.
    """
    if isinstance(tree, Literal):
        return str(tree)
    if isinstance(tree, str):
        return '"' + tree.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(tree, list):
        return "[" + ",".join(map(canonical, tree)) + "]"
    names = sorted(name for name in tree if name != left_out)
    return "{" + ",".join(canonical(name) + ":" + canonical(tree[name]) for name in names) + "}"


def digest(tree):
    return hashlib.sha256(canonical(tree, "sha256").encode()).hexdigest()


# Numbers.

HEXADECIMAL = re.compile(r"(-?)0x([0-9a-fA-F]+)(?:\.([0-9a-fA-F]*))?p([+-]?[0-9]{1,6})")
RATIONAL = re.compile(r"-?[0-9]+(?:/[0-9]+)?")


def below(x):
    """The largest binary64 number that is at most the rational x, as a fraction; `None` where x lies beyond them."""
    if abs(x) > LARGEST_BINARY64:
        return None
    near = x.numerator / x.denominator  # Correctly rounded, by the language's definition.
    return Fraction(near if Fraction(near) <= x else math.nextafter(near, -math.inf))


def is_binary64(x):
    return below(x) == x


def number(text):
    """The rational number that a text of a certificate writes."""
    if len(text) > LONGEST_NUMBER:
        raise Malformed(f"a number of {len(text)} characters")
    if not text.isascii():
        raise Malformed(f"{text[:80]!r} is no number")
    found = HEXADECIMAL.fullmatch(text)
    if found:
        sign, whole, part, exponent = found[1], found[2], found[3] or "", int(found[4])
        if len(whole + part) > MOST_HEXADECIMAL_DIGITS:
            raise Malformed("a hexadecimal number with too many digits")
        mantissa = int(sign + whole + part, 16)
        if mantissa == 0:
            return Fraction(0)
        x = mantissa * Fraction(2) ** (exponent - 4 * len(part))
        if not is_binary64(x):
            raise Malformed(f"{text[:80]} is no binary64 number")
        return x
    if not RATIONAL.fullmatch(text):
        raise Malformed(f"{text[:80]!r} is no number of a certificate")
    numerator, _, denominator = text.partition("/")
    if denominator and int(denominator) == 0:
        raise Malformed(f"{text[:80]} has the denominator 0")
    return Fraction(int(numerator), int(denominator or "1"))


class Datum:
    """An entry of the data: one number, or all numbers between two. `low` and `high` are binary64 numbers around it."""

    def __init__(self, first, last=None):
        if abs(first) > LARGEST_BINARY64 or (last is not None and abs(last) > LARGEST_BINARY64):
            raise Malformed("beyond the largest binary64 number")
        self.written = (first, last)
        self.low, self.high = below(first), -below(-(first if last is None else last))
        self.is_single = last is None and self.low == self.high
        if self.low > self.high:
            raise Malformed(f"the lower bound {float(first)} lies above the upper bound {float(last)}")

    def __eq__(self, other):
        return self.written == other.written


# Fields.


class Field:
    """A value and its path."""

    def __init__(self, tree, path):
        self.tree, self.path = tree, path

    def fail(self, why):
        raise Malformed(f"{self.path}: {why}")

    def text(self):
        if not isinstance(self.tree, str) or isinstance(self.tree, Literal):
            self.fail("should be a string")
        return self.tree

    def word(self, *known):
        if self.text() not in known:
            self.fail(f"{self.tree[:80]!r} is none of {', '.join(known)}")
        return self.tree

    def name(self):
        if not self.text().strip():
            self.fail("is empty")
        return self.tree

    def count(self, limit=2**32 - 1):
        if not isinstance(self.tree, Literal) or not re.fullmatch(r"0|[1-9][0-9]{0,9}", self.tree):
            self.fail("should be a whole number")
        if int(self.tree) > limit:
            self.fail(f"is larger than {limit}")
        return int(self.tree)

    def items(self, length=None):
        if not isinstance(self.tree, list):
            self.fail("should be an array")
        if length is not None and len(self.tree) != length:
            self.fail(f"has {len(self.tree)} elements instead of {length}")
        return [Field(item, f"{self.path}[{k}]") for k, item in enumerate(self.tree)]

    def object(self):
        if not isinstance(self.tree, dict):
            self.fail("should be an object")
        return Fields(self.tree, self.path)

    def number(self):
        try:
            return number(self.text())
        except Malformed as error:
            self.fail(error)

    def binary64(self):
        x = self.number()
        if not is_binary64(x):
            self.fail("is no binary64 number")
        return x

    def in_range(self, holds, requirement):
        x = self.binary64()
        if not holds(x):
            self.fail(f"is {float(x)}, and should be {requirement}")
        return x

    def datum(self):
        try:
            if isinstance(self.tree, list):
                first, last = (item.number() for item in self.items(2))
                return Datum(first, last)
            return Datum(self.number())
        except Malformed as error:
            self.fail(error)

    def interval(self):
        """Two binary64 numbers in order: a claim, which is not widened."""
        datum = self.datum()
        if any(x is not None and not is_binary64(x) for x in datum.written):
            self.fail("has an end that is no binary64 number")
        return datum.low, datum.high

    def rows(self, entry, shape, symmetric=False):
        """The entries of a matrix as a list of rows; `shape` has `None` where any number will do that is not 0."""
        found = []
        rows = self.items()
        for row in rows:
            items = row.items(None if not found else len(found[0]))
            if max(len(rows), len(items)) > LARGEST_ORDER:
                self.fail(f"is of an order above {LARGEST_ORDER}")
            found.append([entry(item) for item in items])
        size = (len(found), len(found[0]) if found else 0)
        if None in shape and 0 in size:
            self.fail("is empty")
        if any(wanted not in (None, has) for wanted, has in zip(shape, size)):
            self.fail(f"is {size[0]} x {size[1]} instead of {shape[0]} x {shape[1]}")
        if symmetric and any(found[i][j] != found[j][i] for i in range(size[0]) for j in range(i)):
            self.fail("is not symmetric")
        return found

    def matrix(self, rows, columns, symmetric=False):
        entries = self.rows(Field.binary64, (rows, columns), symmetric)
        return Matrix.of(entries, columns if columns is not None else len(entries[0]))

    def matrix_with_rows(self, rows):
        """Perhaps without columns."""
        width = len(self.tree[0]) if isinstance(self.tree, list) and self.tree and isinstance(self.tree[0], list) else 0
        return self.matrix(rows, width)

    def square(self):
        return self.matrix(*2 * (len(self.items()) or None,))

    def symmetric(self, order):
        return self.matrix(order, order, symmetric=True)


class Fields:
    """An object whose members are taken one by one; one that is left over does not belong there."""

    def __init__(self, tree, path=""):
        self.tree, self.path, self.left = tree, path, set(tree)

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if kind is None and self.left:
            raise Malformed(f"{self.path or 'the document'}: the field {min(self.left)[:80]!r} does not belong here")

    def optional(self, name):
        if name not in self.tree:
            return None
        self.left.discard(name)
        return Field(self.tree[name], f"{self.path}.{name}" if self.path else name)

    def take(self, name):
        field = self.optional(name)
        if field is None:
            raise Malformed(f"{self.path or 'the document'}: the field {name!r} is missing")
        return field

    def object(self, name):
        return self.take(name).object()

    def rate(self):
        return self.take("rate").in_range(lambda x: x >= 0, "0 or more")
