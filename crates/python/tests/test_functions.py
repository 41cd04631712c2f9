"""Plants from Python functions and from sympy's expressions."""

import functools
import math
import operator

import luenberger as lg
import numpy as np
import pytest

NAMES = {name: getattr(np, name) for name in ["sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "sqrt", "floor", "sign"]}
NAMES.update(
    {
        "ln": np.log, "log10": np.log10, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2,
        "asinh": np.arcsinh, "acosh": np.arccosh, "atanh": np.arctanh, "abs": abs, "min": min, "max": max,
        "mod": lambda x, m: x - m * math.floor(x / m), "sat": lambda x, low, high: min(max(x, low), high),
        "step": lambda x: float(x >= 0), "pi": math.pi, "e": math.e,
    }
)  # fmt: skip


def value(text, names):
    """An expression without conditions, by Python's own evaluator."""
    return eval(text.replace("^", "**"), {"__builtins__": {}}, {**NAMES, **names})  # noqa: S307


def several(t, x, u):
    return [
        x[1] * np.sin(x[0]) - x[0] ** 2 / (1 + x[1] ** 2) + np.exp(-t) * u[0],
        np.arctan2(x[1], x[0]) + np.hypot(x[0], 2) - np.log1p(x[0] ** 2) + 3 % (2 + x[1] ** 2),
        np.maximum(x[0], np.minimum(u[0], -1.5)) + np.clip(x[1], -1, 0.5) + abs(x[0]) - np.sqrt(2 + np.cos(x[2])),
        np.array([[1, 2], [0, -1]])[0] @ x[:2] - np.square(x[2]) + np.tanh(x[1]) * np.float32(0.5) + np.rad2deg(x[0]),
    ][:3] + [np.dot([0.5, -2.0, 1.0, 0.0], x) + x[3] // 2 + (-x[0]) ** 3 + 2 ** x[1] + 1 / x[3]]


def test_a_function_becomes_the_expressions_of_its_values():
    plant = lg.plant(several, lambda x: np.array([x[0] - x[3], -x[1]]), states=4, inputs=1)
    assert plant.states == ["x1", "x2", "x3", "x4"] and plant.inputs == ["u1"] and plant.noutputs == 2
    rng = np.random.default_rng(1)
    for _ in range(100):
        t, x, u = rng.random(), rng.standard_normal(4), rng.standard_normal(1)
        names = {"t": t, "u1": u[0], **{f"x{k + 1}": x[k] for k in range(4)}}
        found = [value(text, names) for text in plant.f]
        np.testing.assert_allclose(found, np.array(several(t, x, u), dtype=float), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose([value(text, names) for text in plant.h], [x[0] - x[3], -x[1]])


def test_a_plant_from_a_function_has_proofs():
    plant = lg.plant(
        lambda x, u: [x[1], -np.sin(x[0]) + u[0]], lambda x: x[0], states=["angle", "rate"], inputs=["torque"]
    )
    assert repr(plant) == "<Plant: angle' = rate; rate' = -sin(angle) + torque; y1 = angle>"
    texts = lg.plant(["rate", "-sin(angle) + torque"], ["angle"], states=["angle", "rate"], inputs=["torque"])
    region = {"angle": (-1, 1), "rate": (-1, 1)}
    pair = [lg.lpv_observer(one, 0.5, region=region) for one in (plant, texts)]
    assert pair[0].verdict == "proved"
    np.testing.assert_allclose(pair[0].L, pair[1].L, rtol=1e-9)


def test_matrices_leave_no_zeros():
    A, B = np.array([[0, 1], [-2, -3]]), np.array([[0], [1]])
    plant = lg.plant(lambda x, u: A @ x + B @ u, lambda x: x[:1], states=2, inputs=1)
    assert plant.f == ["x2", "-2*x1 - 3*x2 + u1"] and plant.h == ["x1"]


def test_a_choice_is_where():
    plant = lg.plant(lambda x: [np.where((x[0] > 1) & ~(x[0] >= 3), -x[0], 2)], lambda x: x[0], states=1)
    assert plant.f == ["if(x1 > 1 && !(x1 >= 3), -x1, 2)"]


def branches(x):
    return [x[0] if x[0] > 0 else -x[0]]


@pytest.mark.parametrize(
    "function, said",
    [
        (branches, "numpy.where"),
        (lambda x: [math.sin(x[0])], r"numpy\.sin\(x\) in place of math"),
        (lambda x: [np.isnan(x[0])], "no numpy.isnan"),
        (lambda x: [x[0] > 1], "condition"),
        (lambda x: ["x1"], "not a number"),
        (lambda x: [x[0] * math.inf], "number inf"),
        (lambda a, b, c, d: [a], "4 arguments"),
        (lambda x: [x[0] + "a"], "not a number"),
        (lambda x: [np.fft.fft(x[0])], "numpy|symbols"),
    ],
)
def test_what_is_no_expression_says_so(function, said):
    with pytest.raises(lg.InvalidArgument, match=said):
        lg.plant(function, ["x1"], states=1)


def test_a_function_that_doubles_its_result_ends():
    def f(x):
        y = x[0]
        for _ in range(60):
            y = np.sin(y) * y
        return [y]

    with pytest.raises(lg.InvalidArgument, match="more than 100000 characters"):
        lg.plant(f, ["x1"], states=1)


def test_the_states_of_a_function_have_to_be_known():
    with pytest.raises(lg.InvalidArgument, match="states"):
        lg.plant(lambda x: x, ["x1"])
    assert lg.plant(["-x1"], lambda x: x[0]).h == ["x1"]
    with pytest.raises(lg.InvalidArgument):
        lg.plant("-x1", ["x1"])
    with pytest.raises(lg.InvalidArgument):
        lg.plant([None], ["x1"])
    assert lg.plant(["-x1", 0], ["x1"]).f == ["-x1", "0"]


def test_sympy():
    sympy = pytest.importorskip("sympy")
    a, b, u = sympy.symbols("a b u")
    f = sympy.Matrix(
        [
            b**2 * sympy.log(1 + a**2) + sympy.Abs(a) - sympy.Rational(1, 3) * b + sympy.E,
            sympy.Max(a, b, 2) - sympy.Min(a, u) + sympy.atan2(b, 2) + sympy.sign(a) * sympy.sqrt(1 + b**2) + sympy.pi,
            sympy.Mod(a, 3) + sympy.Float("0.1") * a + sympy.exp(-a) * sympy.tanh(b) + sympy.floor(a) + 1 / (1 + a**4),
        ]
    )
    plant = lg.plant(f, [a], states=["a", "b", "c"], inputs=["u"])
    numeric = sympy.lambdify((a, b, u), list(f))
    rng = np.random.default_rng(2)
    for _ in range(50):
        x = rng.standard_normal(3)
        names = dict(zip("abu", x))
        np.testing.assert_allclose([value(text, names) for text in plant.f], numeric(*x), rtol=1e-12, atol=1e-12)
    piecewise = sympy.Piecewise((a, (a > 0) & (b < 1)), (-a, a > -1), (b, True))
    plant = lg.plant([piecewise, 0], [a], states=["a", "b"])
    assert plant.f[0] == "if((a > 0) && (b < 1), a, if(a > -1, -a, b))"
    with pytest.raises(lg.InvalidArgument, match="no value"):
        lg.plant([sympy.Piecewise((a, a > 0))], [a], states=["a"])
    with pytest.raises(lg.InvalidArgument):
        lg.plant([sympy.gamma(a)], [a], states=["a"])
    assert lg.plant([-u * a], [a], states=["a"], inputs=["u"]).f == ["-a*u"]


def next_states(plant, x, u=()):
    """The next states of a plant in discrete time, by a simulation of one sample."""
    run = lg.ekf(plant, 1.0, 1.0, xhat0=x).simulate(x, 1.0, u=None if not len(u) else list(u), samples=2)
    return run.x[:, 1]


WEIGHT = np.array([[0.5, -1.5, 2.0], [1.0, 0.0, -0.25], [3.0, 1.0, -2.0]])


@pytest.mark.parametrize(
    "f",
    [
        lambda x: np.where(x > 0, x, -2 * x),
        lambda x: np.where((x > -1) & (x <= 1) | (x == 3), x, np.sign(x)),
        lambda x: np.clip(x, -1, 1),
        lambda x: np.clip(x, a_min=-1, a_max=0.5),
        lambda x: x.clip(-0.5, 1),
        lambda x: [np.clip(x[0], 0, None), np.clip(x[1], None, 0), x[2].clip(-1, 1)],
        lambda x: [np.clip(x[0], a_min=-1, a_max=1), np.clip(x[1], a_min=-0.2, a_max=None), x[2].real],
        lambda x: np.maximum(x, 0.1) + np.minimum(x, [0, 1, 2]),
        lambda x: np.select([x > 1, x > 0], [x, 2 * x], default=-1),
        lambda x: [np.heaviside(x[0], 0.5), np.heaviside(x[1], 1), np.heaviside(0 * x[2], 0.25)],
        lambda x: [np.ceil(x[0]), np.trunc(x[1]), np.floor(x[2])],
        lambda x: [np.exp2(x[0]), np.cbrt(x[1]), np.log2(2 + np.abs(x[2]))],
        lambda x: np.hstack([x[1], x[2] - x[0], x[0] ** 2]),
        lambda x: np.concatenate([x[1:], [x.sum()]]),
        lambda x: np.stack([np.sum(x), np.prod(x), np.mean(x)]),
        lambda x: [np.max(x), np.min(x), np.linalg.norm(x)],
        lambda x: np.cross(x, [1.0, 2.0, 3.0]),
        lambda x: WEIGHT @ np.tanh(WEIGHT @ x) - np.dot(x, x) * np.roll(x, 1),
        lambda x: np.outer(x, x) @ np.ones(3) + np.inner(WEIGHT, x) + np.diff(x).sum(),
        lambda x: np.array([x[0], -x[1], x[0] - (x[1] - x[2])]) / (1 + x[::-1] ** 2),
        lambda x: x * -1 - -x / (-x - 4) - (-x) ** 2 + -(x**2) - (x - (x + 1)),
    ],
)
def test_numpy_of_arrays_is_numpy_of_their_entries(f):
    plant = lg.plant(f, lambda x: x[0], states=3, dt=1)
    rng = np.random.default_rng(5)
    for _ in range(5):
        x = 2 * rng.standard_normal(3)
        np.testing.assert_allclose(next_states(plant, x), np.array(f(x), dtype=float), rtol=1e-12, atol=1e-13)


def test_a_tree_of_operations_has_their_order():
    """Texts with as few parentheses as they need have the value of the function to the last bit."""
    rng = np.random.default_rng(7)
    operations = [operator.add, operator.sub, operator.mul, operator.truediv]

    def tree(depth):
        if depth == 0:
            k = int(rng.integers(5))
            number = float(rng.integers(-3, 4)) + 0.5
            return (lambda x: x[k]) if k < 3 else (lambda x: number)
        a, b, k = tree(depth - 1), tree(int(rng.integers(depth))), int(rng.integers(5))
        if k == 4:
            return lambda x: -a(x)
        return lambda x: operations[k](a(x), b(x))

    for depth in (1, 2, 3, 5, 8):
        for _ in range(40):
            f = tree(depth)
            text = lg.plant(lambda x, f=f: [f(x), 0, 0], lambda x: x[0], states=3).f[0]
            x = rng.standard_normal(3)
            names = {"x1": x[0], "x2": x[1], "x3": x[2]}
            with np.errstate(all="ignore"):
                assert np.array_equal(value(text, names), f(x), equal_nan=True), text


def test_sums_and_products_with_matrices_of_many_terms():
    n = 70
    x = np.linspace(-1, 1, n)
    f = lambda x: [sum((x[0] - k) ** 2 for k in range(n)) / 1e5]  # noqa: E731
    np.testing.assert_allclose(next_states(lg.plant(f, lambda x: x[0], states=1, dt=1), x[:1]), f(x), rtol=1e-12)
    A = np.random.default_rng(8).standard_normal((n, n)) / n
    plant = lg.plant(lambda x: A @ x, lambda x: x[:1], states=n, dt=1)
    np.testing.assert_allclose(next_states(plant, x), A @ x, rtol=1e-12, atol=1e-14)


def test_the_limits_of_expressions_name_the_row():
    with pytest.raises(lg.InvalidArgument, match=r"f: row 2 \(b\): the expression has \d+ bytes; at most 8192"):
        lg.plant(lambda x: [x[0], sum(np.sin(x[1] + k) for k in range(1000))], ["a"], states=["a", "b"])

    def nested(x):
        y = x[0]
        for _ in range(70):
            y = np.sin(y)
        return [y, x[0]]

    with pytest.raises(lg.InvalidArgument, match=r"f: row 1 \(a\): .*64 operations") as found:
        lg.plant(nested, ["a"], states=["a", "b"])
    assert len(str(found.value).splitlines()) == 1
    with pytest.raises(lg.InvalidArgument, match="f: row 2: .*`sinn`"):
        lg.plant(["x2", "sinn(x1)"], ["x1"])
    with pytest.raises(lg.InvalidArgument, match="h: row 1 .y.: .*`sinn`"):
        lg.plant(["x2", "x1"], ["sinn(x1)"], outputs=["y"])
    with pytest.raises(lg.InvalidArgument) as found:
        lg.plant(["p*x2", "x1"], ["x1"], parameters={"p": "q"})
    assert "row" not in str(found.value)


def of_gravity(x, u, g):
    return [x[1], u[0] - g * x[0]]


class Model:
    def f(self, x, u):
        return [x[1], u[0] - 2.0 * x[0]]


@pytest.mark.parametrize(
    "f",
    [
        lambda x, u: [x[1], u[0] - 2.0 * x[0]],
        lambda x, u, a=2.0: [x[1], u[0] - a * x[0]],
        lambda x, u, *, a=2.0: [x[1], u[0] - a * x[0]],
        lambda x, u, *rest, **more: [x[1], u[0] - 2.0 * x[0]],
        lambda t, x, u: [x[1], u[0] - 2.0 * x[0]],
        lambda t, x, u, a=2.0: [x[1], u[0] - a * x[0]],
        lambda t, x, u, params: [x[1], u[0] - params["a"] * x[0]],
        lambda t, x, u, params={"a": 3.0}: [x[1], u[0] - params["a"] * x[0]],
        lambda x, u, params=None: [x[1], u[0] - params.get("a", 9.0) * x[0]],
        lambda state, torque: [state[1], torque[0] - 2.0 * state[0]],
        lambda time, state, torque: [state[1], torque[0] - 2.0 * state[0]],
        functools.partial(of_gravity, g=2.0),
        Model().f,
    ],
)
def test_arguments_with_a_default_are_no_signals(f):
    plant = lg.plant(f, lambda x, c=1.0: c * x[0], states=2, inputs=["u1"], parameters={"a": 2.0}, dt=1)
    assert plant.h == ["x1"] and plant.f[0] == "x2"
    assert next_states(plant, [0.25, 3.0], ["0.5"]).tolist() == [3.0, 0.0]


def test_one_input_does_not_become_a_constant():
    assert lg.plant(lambda x, u, a=2.0: -a * x + u, lambda x: x, states=1, inputs=1).f == ["-2*x1 + u1"]
    assert lg.plant(lambda x: -x, lambda x, c=3.0: c * x[0], states=1, inputs=["u"]).h == ["3*x1"]
    assert lg.plant(lambda t, x: -x * t, lambda t, x: x, states=1, inputs=1).f == ["-x1*t"]


@pytest.mark.parametrize(
    "f, said",
    [
        (lambda t: [t], r"\(t\); expected f\(x\)"),
        (lambda u: [u[0]], r"\(u\); expected"),
        (lambda u, x: [x[0]], r"\(u, x\); expected"),
        (lambda x, t: [x[0]], r"\(x, t\); expected"),
        (lambda x, u, g: [x[0]], r"3 arguments without a default, \(x, u, g\)"),
        (lambda x, u, t: [x[0]], r"\(x, u, t\); expected .*f\(t, x, u\)"),
        (lambda *signals: [signals[0]], "any number of arguments"),
        (lambda x, u, *, g: [g * x[0]], "needs the keyword g; expected functools.partial"),
        (lambda: [0], "0 arguments"),
        (lambda x, u: [u[1]], "u has 1"),
        (lambda x: [x[0], x[0]], "f returns 2 values; expected 1, one for each state"),
        (lambda x: [], "f returns 0 values"),
        (lambda x: [x[0].shape_of], "no .shape_of"),
        (lambda x: [x[0][0]], r"called with symbols as f\(x\)"),
        (lambda x: [np.where(x[0], 1, 2)], "takes the number x1 for a condition"),
        (lambda x: [np.sin(x[0] > 0)], "a condition in place of a number"),
        (lambda x: np.array([x[0] if np.array([x[0]]) > 0 else 0]), "entry by entry"),
    ],
)
def test_a_function_whose_arguments_are_not_known_is_refused(f, said):
    with pytest.raises(lg.InvalidArgument, match=said):
        lg.plant(f, ["x1"], states=1, inputs=1)


def test_counts_and_names_of_states():
    assert lg.plant(lambda x: -x, lambda x: x[0], states=np.int64(2), inputs=np.int8(0)).states == ["x1", "x2"]
    with pytest.raises(lg.InvalidArgument, match="u has 0"):
        lg.plant(lambda x, u: [u[0]], ["x1"], states=1)
    with pytest.raises(lg.InvalidArgument, match="f has 1 rows, and there are 2 names: a, b"):
        lg.plant(["-a"], ["a"], states=["a", "b"])
    with pytest.raises(lg.InvalidArgument, match="whole number"):
        lg.plant(lambda x: -x, ["x1"], states=1.5)
    with pytest.raises(lg.InvalidArgument, match="list of names"):
        lg.plant(["-a"], ["a"], states="a")


def test_functions_of_sympy_by_other_names():
    sympy = pytest.importorskip("sympy")
    a, b, t = sympy.symbols("a b t")
    half = sympy.Rational(1, 2)
    rows = [
        sympy.cot(a) + sympy.sec(b) * sympy.csc(a) ** 2,
        sympy.coth(a) - sympy.sech(b) / sympy.csch(a),
        sympy.ceiling(3 * a) - 2 * sympy.ceiling(-b),
        sympy.Piecewise((1, sympy.Eq(sympy.floor(a), 1)), (2, sympy.Ne(sympy.floor(b), 0)), (3, True)),
        sympy.Piecewise((a, sympy.ITE(a > 0, b > 0, b < -1)), (b, True)),
        sympy.Piecewise((a, sympy.Xor(a > 0, b > 0, a > b)), (b, True)),
        sympy.Heaviside(a) + 3 * sympy.Heaviside(b, 1) + 5 * sympy.Heaviside(a - b, 0),
    ]
    numeric = sympy.lambdify((a, b), rows, modules=[{"Heaviside": np.heaviside}, "numpy"])
    others = sympy.symbols("c:7")
    plant = lg.plant([a, b, *rows], [a], states=[a, b, *others], dt=1)
    assert plant.states[:3] == ["a", "b", "c0"]
    rng = np.random.default_rng(9)
    for point in [*rng.uniform(-2, 2, (20, 2)), (1.0, 1.0), (0.5, -0.5)]:
        found = next_states(plant, [*point, *np.zeros(7)])[2:]
        np.testing.assert_allclose(found, np.array(numeric(*point), dtype=float), rtol=1e-12, atol=1e-12)
    assert lg.plant([sympy.Heaviside(a, half)], [a], states=[a]).f == ["if(a < 0, 0, if(a > 0, 1, 1/2))"]
    dynamic = sympy.Function("q")(t)
    assert lg.plant([-sympy.sin(dynamic)], [dynamic], states=[dynamic]).f == ["-sin(q)"]
    tables = {"q": {"x": [0, 1], "y": [0, 1]}}
    assert lg.plant([-a * dynamic], [a], states=[a], tables=tables).f == ["-a*q(t)"]
    with pytest.raises(lg.InvalidArgument, match="derivative"):
        lg.plant([sympy.Derivative(dynamic, t)], [dynamic], states=[dynamic])


def test_a_text_that_is_too_long_is_written_without_spaces():
    f = lambda x: [sum(np.sin(x[0] + k) for k in range(620)), x[1]]  # noqa: E731
    plant = lg.plant(f, lambda x: x[1], states=2, dt=1)
    assert " " not in plant.f[0] and len(plant.f[0].replace("+", " + ")) > 8192
    np.testing.assert_allclose(next_states(plant, [0.3, 1.0])[0], f([0.3, 1.0])[0], rtol=1e-9, atol=1e-12)
