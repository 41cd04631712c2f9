"""Elementary functions of rational numbers and intervals, to the safe side, in arithmetic of integers.

Numbers are fractions; a bound is a dyadic number of `BITS` binary places. Series are summed in fixed point, each term
with an error below one unit. Sine and cosine are bounded over an interval by their value in the middle and the slope
there: |sin(m + d) - sin m| <= |cos m| |d| + d^2/2.
"""

import math
from fractions import Fraction
from math import isqrt

from rational import NotShown

BITS = 256
ONE = 1 << BITS

# Beyond, exp has too many digits, and sine and cosine are only known to lie within 1.
LARGEST_EXPONENT = 600
LARGEST_ANGLE = 64


def down(x):
    """A dyadic number not above x, with about 96 significant digits."""
    return _rounded(x, False)


def up(x):
    """A dyadic number not below x."""
    return _rounded(x, True)


def _rounded(x, upwards):
    if x == 0:
        return x
    shift = 96 - (x.numerator.bit_length() - x.denominator.bit_length())
    scaled = (x.numerator << shift, x.denominator) if shift >= 0 else (x.numerator, x.denominator << -shift)
    digits = -(-scaled[0] // scaled[1]) if upwards else scaled[0] // scaled[1]
    return Fraction(digits) / Fraction(2) ** shift


def exp_bounds(x):
    if abs(x) > LARGEST_EXPONENT:
        raise NotShown("an exponential of a large number")
    halvings = 8 + math.ceil(abs(x)).bit_length()
    y = (x.numerator << BITS) // (x.denominator << halvings)
    bounds = []
    for y in (y, y + 1):
        term, total, terms = ONE, ONE, 1
        while term not in (0, -1):
            term = term * y // (terms << BITS)
            total += term
            terms += 1
        bounds.append((total, 2 * terms + 4))
    low, high = bounds[0][0] - bounds[0][1], bounds[1][0] + bounds[1][1]
    for _ in range(halvings):
        low, high = low * low >> BITS, (high * high >> BITS) + 1
    return Fraction(low, ONE), Fraction(high, ONE)


def sine_and_cosine(x):
    """Bounds of both at a number."""
    if abs(x) > LARGEST_ANGLE:
        return (Fraction(-1), Fraction(1)), (Fraction(-1), Fraction(1))
    y = (x.numerator << BITS) // x.denominator
    sums, term, terms = [0, 0, 0, 0], ONE, 0
    while abs(term) > 1 or terms < 2 * LARGEST_ANGLE:
        sums[terms % 4] += term
        terms += 1
        term = term * y // (terms << BITS)
    # y is below x by less than a unit, and each term has the error of the ones before it, times at most e^64.
    error = Fraction((terms + 4) << 100, ONE)
    cosine, sine = Fraction(sums[0] - sums[2], ONE), Fraction(sums[1] - sums[3], ONE)
    clip = lambda z: max(Fraction(-1), min(Fraction(1), z))
    return (clip(sine - error), clip(sine + error)), (clip(cosine - error), clip(cosine + error))


def wave(which, low, high):
    middle, radius = (low + high) / 2, (high - low) / 2
    values = sine_and_cosine(middle)
    here, slope = values[which], max(map(abs, values[1 - which]))
    reach = slope * radius + radius * radius / 2
    return max(Fraction(-1), down(here[0] - reach)), min(Fraction(1), up(here[1] + reach))


def ln_bounds(x):
    if not 0 < x < 2**900 or x < Fraction(1, 2**900):
        raise NotShown("a logarithm of a very large or small number")
    near = Fraction(math.log(x))
    low, high = exp_bounds(-near)
    bounds = []
    for w in (x * low, x * high):
        z = (w - 1) / (w + 1)
        rest = abs(z) ** 5
        bounds.append((near + 2 * z + 2 * z**3 / 3 - rest, near + 2 * z + 2 * z**3 / 3 + rest))
    return bounds[0][0], bounds[1][1]


def sqrt_bounds(x):
    shift = 2 * max(0, 128 - x.numerator.bit_length() + x.denominator.bit_length())
    root = isqrt((x.numerator << shift) // x.denominator)
    return Fraction(root, 1 << (shift // 2)), Fraction(root + 1, 1 << (shift // 2))


def tanh_bounds(x):
    if x > 200:
        return 1 - Fraction(1, 2**200), Fraction(1)
    if x < -200:
        return Fraction(-1), Fraction(1, 2**200) - 1
    low, high = exp_bounds(2 * x)
    return 1 - 2 / (low + 1), 1 - 2 / (high + 1)


def atan_bounds(x):
    if x < 0:
        low, high = atan_bounds(-x)
        return -high, -low
    low = high = x
    for _ in range(4):
        low = down(low / (1 + sqrt_bounds(1 + low * low)[1]))
        high = up(high / (1 + sqrt_bounds(1 + high * high)[0]))
    # atan is monotonic; both are below 1/8, and the series alternates.
    series = lambda z, terms: sum((-1) ** k * z ** (2 * k + 1) / (2 * k + 1) for k in range(terms))
    return 16 * series(low, 20), 16 * series(high, 21)


MONOTONIC = {"exp": exp_bounds, "ln": ln_bounds, "sqrt": sqrt_bounds, "tanh": tanh_bounds, "atan": atan_bounds}
NAMES = ("sin", "cos", *MONOTONIC)


def over(name, low, high):
    """Bounds over an interval; `None` where the function or its derivative is not defined in all of it."""
    if name in ("sin", "cos"):
        return wave(("sin", "cos").index(name), low, high)
    if name in ("ln", "sqrt") and low <= 0:
        return None
    bounds = MONOTONIC[name]
    return down(bounds(down(low))[0]), up(bounds(up(high))[1])
