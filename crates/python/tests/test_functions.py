"""Plants from Python functions and from sympy's expressions."""

import math

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
    assert repr(plant) == "<Plant: angle' = rate; rate' = ((-sin(angle)) + torque); y1 = angle>"
    texts = lg.plant(["rate", "-sin(angle) + torque"], ["angle"], states=["angle", "rate"], inputs=["torque"])
    region = {"angle": (-1, 1), "rate": (-1, 1)}
    pair = [lg.lpv_observer(one, 0.5, region=region) for one in (plant, texts)]
    assert pair[0].verdict == "proved"
    np.testing.assert_allclose(pair[0].L, pair[1].L, rtol=1e-9)


def test_matrices_leave_no_zeros():
    A, B = np.array([[0, 1], [-2, -3]]), np.array([[0], [1]])
    plant = lg.plant(lambda x, u: A @ x + B @ u, lambda x: x[:1], states=2, inputs=1)
    assert plant.f == ["x2", "((((-2)*x1) + ((-3)*x2)) + u1)"] and plant.h == ["x1"]


def test_a_choice_is_where():
    plant = lg.plant(lambda x: [np.where((x[0] > 1) & ~(x[0] >= 3), -x[0], 2)], lambda x: x[0], states=1)
    assert plant.f == ["if((x1 > 1) && (!(x1 >= 3)), (-x1), 2)"]


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
