"""`kkl-error-bound`: the estimation error of a KKL observer over a box. The theorem stands in docs/certificates.md."""

from fractions import Fraction

import words
from document import Field, Malformed
from expressions import Algebra, Value, parse
from rational import Family, Matrix, NotShown, Refuted, at_least, blocks, interval_matrix, root_above

LARGEST = 16


def texts(field, length=None):
    items = field.items(length)
    if not 1 <= len(items) <= LARGEST:
        field.fail(f"has {len(items)} entries; 1 to {LARGEST} are allowed")
    return [item.text() for item in items]


def ranges(field):
    items = field.items()
    if len(items) > LARGEST:
        field.fail(f"has {len(items)} entries; at most {LARGEST} are allowed")
    return [item.interval() for item in items]


def trees(field, texts, **vectors):
    names = {f"{letter}{k}" for letter, count in vectors.items() for k in range(1, count + 1)}
    try:
        return [parse(text, names) for text in texts]
    except Malformed as why:
        field.fail(why)


def named(letter, values):
    return {f"{letter}{k}": value for k, value in enumerate(values, 1)}


class Maps:
    """Plant and observer as values over (x, u, e)."""

    def __init__(self, f, h, phi, gain, b, inverse, z, inputs):
        n, q = len(f), len(phi)
        self.algebra = a = Algebra(n + inputs + q)
        variables = [a.variable(k) for k in range(n + inputs + q)]
        x, u, e = variables[:n], variables[n : n + inputs], variables[n + inputs :]

        def values(trees, **vectors):
            scope = {}
            for letter, entries in vectors.items():
                scope |= named(letter, entries)
            return [a.evaluate(tree, scope) for tree in trees]

        f, h, phi = values(f, x=x, u=u), values(h, x=x), values(phi, x=x)
        self.gain, b = values(gain, u=u, y=h), values(b, u=u, y=h)
        estimate = values(inverse, xi=[a.add(phi, e) for phi, e in zip(phi, e)], u=u, y=h)
        exact = values(inverse, xi=phi, u=u, y=h)
        self.jacobian = [value.slopes.get(j, Value({})) for value in [*phi, *h] for j in range(n)]
        self.defects = [a.raw_add(z, exact, -1) for z, exact in zip(values(z, x=x), exact)]
        none = Value({})
        self.slopes = [[value.slopes.get(n + inputs + j, none) for j in range(q)] for value in estimate]
        self.residual = []
        for i in range(q):
            total = b[i]
            for j in range(q):
                total = a.raw_add(total, a.raw_multiply(self.gain[i * q + j], phi[j]))
            for j in range(n):
                total = a.raw_add(total, a.raw_multiply(phi[i].slopes.get(j, none), f[j]), -1)
            self.residual.append(total)

    def squared(self, slope, w):
        total = Value({})
        for i, left in enumerate(slope):
            for j, right in enumerate(slope):
                product = self.algebra.raw_multiply(left, right)
                product = Value({m: x * w[i, j] for m, x in product.numerator.items() if w[i, j]}, product.denominators)
                total = self.algebra.raw_add(total, product)
        return total


def kkl_error_bound(file):
    with file.object("box") as region:
        field = region.take("x")
        x, u = ranges(field), ranges(region.take("u"))
    with file.object("plant") as plant:
        f_field, h_field = plant.take("f"), plant.take("h")
        f, h = texts(f_field), texts(h_field)
    if len(f) != len(x):
        field.fail(f"has {len(x)} elements instead of {len(f)}")
    with file.object("observer") as observer:
        fields = [observer.take(name) for name in ("phi", "Lambda", "B", "left_inverse", "estimated")]
        phi = texts(fields[0])
        q = len(phi)
        rows = [texts(row, q) for row in fields[1].items(q)]
        b, inverse = texts(fields[2], q), texts(fields[3])
        z = texts(fields[4], len(inverse))
    n, m, p = len(x), len(u), len(h)
    parsed = [
        trees(f_field, f, x=n, u=m),
        trees(h_field, h, x=n),
        trees(fields[0], phi, x=n),
        trees(fields[1], [text for row in rows for text in row], u=m, y=p),
        trees(fields[2], b, u=m, y=p),
        trees(fields[3], inverse, xi=q, u=m, y=p),
        trees(fields[4], z, x=n),
    ]
    with file.object("lyapunov") as lyapunov:
        between = lyapunov.take("Lambda").rows(Field.interval, (q, q))
        matrix, w = lyapunov.take("P").symmetric(q), lyapunov.take("W").symmetric(q)
        positive = lambda field: field.in_range(lambda x: x > 0, "positive")
        rate = positive(lyapunov.take("rate"))
    with file.object("bounds") as bounds:
        bound = lambda field: field.in_range(lambda x: x >= 0, "0 or more")
        several = lambda name, count: [bound(item) for item in bounds.take(name).items(count)]
        residual, start = several("residual", q), positive(bounds.take("start"))
        limit, k = bound(bounds.take("limit")), len(inverse)
        lipschitz, defect, eventual = several("lipschitz", k), several("defect", k), several("eventual", k)

    injectivity = file.optional("injectivity")
    if injectivity:
        with injectivity.object() as of:
            jacobian = of.take("Jacobian").rows(Field.interval, (q + p, n))
            combination = of.take("M").matrix(n, q + p)
            modulus, spread = positive(of.take("modulus")), bound(of.take("spread"))

    # Built by the first fact that needs it, so that what cannot be composed is "not shown".
    built = []

    def maps():
        if not built:
            built.append(Maps(*parsed, m))
        return built[0]

    def box(with_errors=False):
        reach = [root_above(max(w[i, i], Fraction(0))) * start if with_errors else Fraction(0) for i in range(q)]
        return dict(enumerate([*x, *u, *((-r, r) for r in reach)]))

    def within():
        for value, (low, high) in zip(maps().gain, [entry for row in between for entry in row]):
            maps().algebra.between(value, low, high, box())

    def decrease(margin):
        middle = Matrix.of([[(low + high) / 2 for low, high in row] for row in between], q)
        radius = Matrix.of([[(high - low) / 2 for low, high in row] for row in between], q)
        shifted = middle + Matrix.scalar(q, rate)
        family = Family(-(matrix @ shifted).plus_transpose(), (abs(matrix) @ radius).plus_transpose())
        family.at_least(margin, strict=True)

    def inverse_above(margin):
        one = Matrix.scalar(q, 1)
        at_least(blocks([[w, one], [one, matrix]]), margin, strict=False)

    def small(values, limits):
        for value, limit in zip(values(), limits):
            maps().algebra.between(value, -limit, limit, box())

    def slopes():
        for slope, limit in zip(maps().slopes, lipschitz):
            maps().algebra.at_most(maps().squared(slope, w), limit * limit, box(True))

    def limits():
        square = sum(abs(matrix[i, j]) * residual[i] * residual[j] for i in range(q) for j in range(q))
        if rate**2 * limit**2 < square or limit >= start:
            raise Refuted("the limit does not follow")

    def eventually():
        if any(e < l * limit + d for e, l, d in zip(eventual, lipschitz, defect)):
            raise Refuted("an eventual bound does not follow")

    def jacobian_within():
        for value, (low, high) in zip(maps().jacobian, [entry for row in jacobian for entry in row]):
            maps().algebra.between(value, low, high, box())

    def separates(margin):
        middle = Matrix.of([[(low + high) / 2 for low, high in row] for row in jacobian], n)
        radius = Matrix.of([[(high - low) / 2 for low, high in row] for row in jacobian], n)
        product = (combination @ middle).plus_transpose() - Matrix.scalar(n, 2 * modulus)
        Family(product, (abs(combination) @ radius).plus_transpose()).at_least(margin, strict=True)

    def spreads(margin):
        of_phi = combination.block(range(n), range(q))
        at_least(matrix * (spread * spread) - of_phi.T @ of_phi, margin, strict=False)

    def without_margin(test):
        def checked(margin):
            if margin:
                raise Refuted("this fact has no margin")
            test()

        return checked

    statement = words.kkl_error_bound(
        (n, m, p), f, h, z, rows, b, inverse, x, u, phi, rate, limit, start, lipschitz, defect, eventual
    )
    facts = [
        ("all maps are defined over the box", without_margin(lambda: maps().algebra.is_defined(box(True)))),
        ("Lambda lies between its bounds over the box", without_margin(within)),
        ("P > 0", lambda margin: at_least(matrix, margin, strict=True)),
        ("Lambda'P + P Lambda + 2 rate P < 0", decrease),
        ("[W, I; I, P] >= 0", inverse_above),
        (
            "|Dphi f - Lambda phi - B| <= residual over the box",
            without_margin(lambda: small(lambda: maps().residual, residual)),
        ),
        ("g'Wg <= lipschitz^2 for g = dphi^L/dxi over the box and V <= start", without_margin(slopes)),
        ("|z - phi^L(phi, h, u)| <= defect over the box", without_margin(lambda: small(lambda: maps().defects, defect))),
        ("rate^2 limit^2 >= residual'|P| residual and limit < start", without_margin(limits)),
        ("eventual >= lipschitz limit + defect", without_margin(eventually)),
    ]
    if injectivity:
        statement += words.kkl_injectivity(modulus, spread)
        facts += [
            ("the Jacobian of (phi, h) lies between its bounds over the box", without_margin(jacobian_within)),
            ("M J + J'M' - 2 modulus I > 0 for the Jacobian J of (phi, h)", separates),
            ("spread^2 P - M_phi'M_phi >= 0", spreads),
        ]
    return statement, facts
