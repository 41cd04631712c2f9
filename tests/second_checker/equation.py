"""The solution of `T(P) + Q = 0`, `T(X) = A'X + XA` or `A'XA - X`, for all A and Q between bounds: that there is one,
and where it lies.

*By comparison* with a W that is positive definite (or, for Lyapunov's equation, negative definite: then -A is stable)
and has `D = -T(W) > 0`. Let `R = T(P~) + Q`. `-r D <= R <= r D` implies `-r |W| <= P - P~ <= r |W|`, so that `|P -
P~|_ij^2 <= r^2 W_ii W_jj`. Here r is not sought: it is the largest for which the intervals claimed hold that, and the
two inequalities are checked for it.

*By elimination.* On the upper triangle T is a matrix M. Let G be any matrix, E = I - G M, `|E| v <= h v`, v > 0, h < 1.
Then M is nonsingular (the spectral radius of E is below 1), and M x = -R gives `x = -G R + E x`, so that `|x| <= y := v
max(|G R|/v)/(1 - h)` and `x in -G R + [-1, 1] |E| y`. G is an inverse in floating point, and P~ is first bettered by x
:= x - G R, rounded to 256 bits: what encloses the solution is then much narrower than the intervals claimed.
"""

from fractions import Fraction

from rational import Family, Refuted, Matrix, NotShown, root_above

LARGEST_ELIMINATED = 24
REFINEMENTS = 8


class Equation:
    """`T(P) + Q = 0` with A and Q in `middle +- radius`."""

    def __init__(self, is_stein, a, q):
        self.is_stein, (self.a, self.da), (self.q, self.dq) = is_stein, a, q

    @property
    def is_single(self):
        return self.da.is_zero() and self.dq.is_zero()

    def image(self, x):
        """The middle and the radius of T(x)."""
        if not self.is_stein:
            return (x @ self.a).plus_transpose(), (abs(x) @ self.da).plus_transpose()
        cross = self.da.T @ abs(x @ self.a)
        return self.a.T @ x @ self.a - x, cross.plus_transpose() + self.da.T @ abs(x) @ self.da

    def residual(self, x):
        middle, radius = self.image(x)
        return middle + self.q, radius + self.dq

    def operator(self):
        """M and its radius on upper triangles, by rows."""
        n = self.a.rows
        places = [(i, j) for i in range(n) for j in range(i, n)]
        number = {place: k for k, place in enumerate(places)} | {(j, i): k for k, (i, j) in enumerate(places)}
        zero = Fraction(0)
        a = [[self.a[i, j] for j in range(n)] for i in range(n)]
        da = [[self.da[i, j] for j in range(n)] for i in range(n)]
        middle, radius = ([[zero] * len(places) for _ in places] for _ in range(2))

        def add(row, k, l, value, doubt):
            middle[row][number[k, l]] += value
            radius[row][number[k, l]] += doubt

        for row, (i, j) in enumerate(places):
            if not self.is_stein:
                for k in range(n):
                    add(row, k, j, a[k][i], da[k][i])
                    add(row, i, k, a[k][j], da[k][j])
                continue
            for k in range(n):
                for l in range(n):
                    value = a[k][i] * a[l][j]
                    largest = (abs(a[k][i]) + da[k][i]) * (abs(a[l][j]) + da[l][j])
                    add(row, k, l, value, largest - abs(value))
            add(row, i, j, Fraction(-1), zero)
        return places, Matrix.of(middle, len(places)), Matrix.of(radius, len(places))


def by_comparison(equation, near, w, low, high):
    """Whether the claim follows from W."""
    n = near.rows
    image, doubt = equation.image(w)
    try:
        Family(-image, doubt).at_least(0, strict=True)
        size = w if w[0, 0] > 0 else -w
        if size is not w and equation.is_stein:
            return False
        Family(size, Matrix.zeros(n, n)).at_least(0, strict=True)
    except (Refuted, NotShown):
        return False
    room = [min(near[i, j] - low[i, j], high[i, j] - near[i, j]) for i in range(n) for j in range(n)]
    if min(room) < 0:
        return False
    square = min(x * x / (size[k // n, k // n] * size[k % n, k % n]) for k, x in enumerate(room))
    r = 1 / root_above(1 / square) if square else Fraction(0)
    residual, radius = equation.residual(near)
    try:
        for sign in (1, -1):
            Family(-image * r + residual * sign, doubt * r + radius).at_least(0, strict=False)
    except (Refuted, NotShown):
        return False
    return True


def floating_inverse(m):
    """The inverse in floating point, about which nothing is known; `None` where it breaks down."""
    n = m.rows
    work = [[float(m[i, j]) for j in range(n)] + [float(i == j) for j in range(n)] for i in range(n)]
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(work[i][k]))
        pivot = work[best][k]
        if pivot == 0 or pivot != pivot:
            return None
        work[k], work[best] = work[best], work[k]
        head = work[k] = [x / pivot for x in work[k]]
        for i, row in enumerate(work):
            factor = row[k]
            if i != k and factor:
                work[i] = [x - factor * y for x, y in zip(row, head)]
    try:
        return Matrix.of([[Fraction(x) for x in row[n:]] for row in work], n)
    except (OverflowError, ValueError):
        return None


def rounded(m, bits=256):
    """The matrix to about that many bits of its largest entry."""
    largest = max((abs(x) for row in m.num for x in row), default=0)
    shift = max(0, bits - (largest.bit_length() - m.den.bit_length()))
    return Matrix(
        [[((x << shift + 1) // m.den + 1) >> 1 for x in row] for row in m.num], 1 << shift, m.columns
    ).reduced()


def by_elimination(equation, near, low, high):
    n = near.rows
    places, m, dm = equation.operator()
    g = floating_inverse(m)
    if g is None:
        raise NotShown("the equation is singular, or nearly so")
    order = len(places)
    size = abs(g)
    defect = abs(Matrix.scalar(order, 1) - g @ m) + size @ dm
    v = Matrix.of([[sum((size[k, l] for l in range(order)), Fraction(0)) or Fraction(1)] for k in range(order)], 1)

    def largest_ratio(x):
        return max(x[k, 0] / v[k, 0] for k in range(order))

    h = largest_ratio(defect @ v)
    if h >= 1:
        raise NotShown("the equation is not shown to have one solution")

    def triangle(x):
        return Matrix.of([[x[place]] for place in places], 1)

    def full(x):
        entries = {place: x[k, 0] for k, place in enumerate(places)}
        return Matrix.of([[entries[min(i, j), max(i, j)] for j in range(n)] for i in range(n)], n)

    for _ in range(REFINEMENTS):
        near = rounded(near - full(g @ triangle(equation.residual(near)[0])))
    residual, radius = map(triangle, equation.residual(near))
    step, doubt = -(g @ residual), size @ radius
    reach = v * (largest_ratio(abs(step) + doubt) / (1 - h))
    doubt = doubt + defect @ reach
    for k, place in enumerate(places):
        middle = near[place] + step[k, 0]
        least, most = middle - doubt[k, 0], middle + doubt[k, 0]
        if equation.is_single and (most < low[place] or least > high[place]):
            raise Refuted(f"the entry {place} of the solution is about {float(middle)!r}, outside the interval claimed")
        if least < low[place] or most > high[place]:
            raise NotShown(f"the entry {place} of the solution is not shown to lie in the interval claimed")


def check(equation, near, w, low, high):
    if w is not None and by_comparison(equation, near, w, low, high):
        return
    if near.rows > LARGEST_ELIMINATED:
        raise NotShown("the solution is not shown to be unique and to lie in the intervals claimed")
    by_elimination(equation, near, low, high)
