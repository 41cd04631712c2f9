"""The expressions of a plant, from texts, sympy's expressions and Python functions.

A function is called once, with symbols in place of the numbers: what it computes with `+ - * / **`, numpy's functions
and comparisons inside `numpy.where` is written down. So a plant from a function has what one from texts has: Jacobians,
proofs, exports. The operations are those of the function, in its order, with no more parentheses than they need: a sum
of many terms is not nested.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from .errors import InvalidArgument

__all__ = ["texts", "traced"]

# Longer expressions come from a function that uses its results over and over.
LONGEST = 100_000

# What the reader of expressions takes, in bytes (`LIMITS` of the crate luenberger-expression).
READ = 8192

_LANGUAGE = "the operations of docs/expressions.md"

# How tightly an expression binds, as in docs/expressions.md.
_OR, _AND, _COMPARISON, _SUM, _PRODUCT, _SIGN, _POWER, _ATOM = 1, 2, 3, 5, 7, 8, 9, 10

# The text of an operation, how tightly it binds, and how tightly its operands have to.
Form = tuple[str, int, tuple[int, ...]]


def _call(text: str, operands: int = 1) -> Form:
    return text, _ATOM, (_OR,) * operands


_OPERATIONS: dict[str, Form] = {
    "add": ("{} + {}", _SUM, (_SUM, _SUM + 1)),
    "subtract": ("{} - {}", _SUM, (_SUM, _SUM + 1)),
    "multiply": ("{}*{}", _PRODUCT, (_PRODUCT, _POWER)),
    "divide": ("{}/{}", _PRODUCT, (_PRODUCT, _POWER)),
    "power": ("{}^{}", _POWER, (_ATOM, _ATOM)),
    "float_power": ("{}^{}", _POWER, (_ATOM, _ATOM)),
    "negative": ("-{}", _SIGN, (_POWER,)),
    "square": ("{}^2", _POWER, (_ATOM,)),
    "reciprocal": ("1/{}", _PRODUCT, (_POWER,)),
    "absolute": _call("abs({})"),
    "fabs": _call("abs({})"),
    "log": _call("ln({})"),
    "log2": ("ln({})/ln(2)", _PRODUCT, (_OR,)),
    "exp2": ("2^{}", _POWER, (_ATOM,)),
    "expm1": ("exp({}) - 1", _SUM, (_OR,)),
    "log1p": ("ln(1 + {})", _ATOM, (_SUM + 1,)),
    "cbrt": ("sign({0})*abs({0})^(1/3)", _PRODUCT, (_OR,)),
    "arcsin": _call("asin({})"),
    "arccos": _call("acos({})"),
    "arctan": _call("atan({})"),
    "arctan2": _call("atan2({}, {})", 2),
    "arcsinh": _call("asinh({})"),
    "arccosh": _call("acosh({})"),
    "arctanh": _call("atanh({})"),
    "hypot": ("sqrt({}^2 + {}^2)", _ATOM, (_ATOM, _ATOM)),
    "maximum": _call("max({}, {})", 2),
    "minimum": _call("min({}, {})", 2),
    "clip": _call("sat({}, {}, {})", 3),
    "remainder": _call("mod({}, {})", 2),
    "floor_divide": ("floor({}/{})", _ATOM, (_PRODUCT, _POWER)),
    "ceil": ("-floor(-{})", _SIGN, (_POWER,)),
    "trunc": ("sign({0})*floor(abs({0}))", _PRODUCT, (_OR,)),
    "heaviside": ("if({0} < 0, 0, if({0} > 0, 1, {1}))", _ATOM, (_SUM, _OR)),
    "deg2rad": ("{}*pi/180", _PRODUCT, (_PRODUCT,)),
    "radians": ("{}*pi/180", _PRODUCT, (_PRODUCT,)),
    "rad2deg": ("{}*180/pi", _PRODUCT, (_PRODUCT,)),
    "degrees": ("{}*180/pi", _PRODUCT, (_PRODUCT,)),
    **{
        name: _call(name + "({})")
        for name in ["sqrt", "exp", "log10", "sin", "cos", "tan", "sinh", "cosh", "tanh", "sign", "floor"]
    },
}

_CONDITIONS: dict[str, Form] = {
    **{
        name: (f"{{}} {sign} {{}}", _COMPARISON, (_SUM, _SUM))
        for name, sign in [
            ("less", "<"),
            ("less_equal", "<="),
            ("greater", ">"),
            ("greater_equal", ">="),
            ("equal", "=="),
            ("not_equal", "!="),
        ]
    },
    **dict.fromkeys(["logical_and", "bitwise_and"], ("{} && {}", _AND, (_AND, _COMPARISON))),
    **dict.fromkeys(["logical_or", "bitwise_or"], ("{} || {}", _OR, (_OR, _AND))),
    **dict.fromkeys(["logical_not", "invert"], ("!{}", _SIGN, (_ATOM,))),
}


class Symbol(np.lib.mixins.NDArrayOperatorsMixin):
    """A number of a plant that has no value yet: the expression of it, and how tightly that binds."""

    def __init__(self, text: str, binds: int = _ATOM) -> None:
        self.text = text
        self.binds = binds

    @property
    def is_condition(self) -> bool:
        return self.binds in (_OR, _AND, _COMPARISON) or self.text.startswith("!")

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> Any:
        return _computed(ufunc, method, inputs, keywords)

    def __array_function__(self, function: Any, types: Any, arguments: Any, keywords: Any) -> Any:
        return _called(function, arguments, keywords)

    def __getattr__(self, name: str) -> Any:
        # numpy calls the method `sin` of an object in an array for its function sin.
        ufunc = getattr(np, name, None)
        if isinstance(ufunc, np.ufunc) and name in _OPERATIONS:
            return lambda *others: ufunc(self, *others)
        raise AttributeError(f"a number of a plant has no .{name}: {self.text}")

    @property
    def real(self) -> Symbol:
        return self

    def clip(self, *bounds: Any, **keywords: Any) -> Any:
        return _clip(self, *bounds, **keywords)

    def __bool__(self) -> bool:
        raise InvalidArgument(
            f"the function decides by {self.text}, which has no value yet",
            hint="numpy.where(condition, a, b), numpy.maximum or numpy.clip in place of `if`; of an array that "
            "numpy.array has made, entry by entry",
        )

    def __float__(self) -> float:
        raise InvalidArgument(
            f"the function takes the value of {self.text}, which has none yet",
            hint="numpy's functions, numpy.sin(x) in place of math.sin(x), and a list or numpy.array([..]) in place of "
            "an array of numbers that is filled",
        )

    __int__ = __index__ = __float__

    def __repr__(self) -> str:
        return self.text


class Symbols(np.ndarray):
    """States or inputs: an array of symbols, of which comparisons, too, are arrays of symbols."""

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> Any:
        return _computed(ufunc, method, inputs, keywords)

    def __array_function__(self, function: Any, types: Any, arguments: Any, keywords: Any) -> Any:
        return _called(function, arguments, keywords)

    def clip(self, *bounds: Any, **keywords: Any) -> Any:
        return _clip(self, *bounds, **keywords)


def _symbols(names: Sequence[str]) -> Any:
    return _wrapped(np.array([Symbol(name) for name in names], dtype=object))


def _wrapped(value: Any) -> Any:
    """What numpy computed; arrays of symbols as such."""
    if isinstance(value, np.ndarray) and value.dtype == object:
        return value.view(Symbols) if value.ndim else value.item()
    if isinstance(value, (list, tuple)):
        return type(value)(map(_wrapped, value))
    return value


def _plain(value: Any) -> Any:
    """Symbols and arrays of them as numpy has objects."""
    if isinstance(value, Symbol):
        array = np.empty((), dtype=object)
        array[()] = value
        return array
    if isinstance(value, Symbols):
        return value.view(np.ndarray)
    if isinstance(value, (list, tuple)):
        return type(value)(map(_plain, value))
    return value


def _elementwise(compute: Callable[..., Any], operands: Sequence[Any]) -> Any:
    """A function of numbers, of arrays entry by entry."""
    arrays = [np.asarray(value, dtype=object) for value in map(_plain, operands)]
    shape = np.broadcast_shapes(*(array.shape for array in arrays))
    found = np.empty(shape, dtype=object)
    wide = [np.broadcast_to(array, shape) for array in arrays]
    for place in np.ndindex(shape):
        found[place] = compute(*(array[place] for array in wide))
    return _wrapped(found)


def _computed(ufunc: Any, method: str, inputs: Any, keywords: Any) -> Any:
    """A function of numpy that is one entry by entry."""
    name = ufunc.__name__
    form = _OPERATIONS.get(name) or _CONDITIONS.get(name)
    if name in ("matmul", "vecdot", "matvec", "vecmat") and method == "__call__":
        return _wrapped(ufunc(*_plain(inputs), **keywords))
    if name == "positive" and method == "__call__":
        return inputs[0]
    if form is not None and method in ("reduce", "accumulate", "outer"):
        return _many(name, method, inputs, keywords)
    if method != "__call__" or form is None or any(value is not None for value in keywords.values()):
        raise InvalidArgument(f"an expression of a plant has no numpy.{name}", hint=_LANGUAGE)
    return _elementwise(lambda *operands: _operation(name, *operands), inputs)


def _many(name: str, method: str, inputs: Any, keywords: Any) -> Any:
    """Sums, products and extremes of arrays, from the first entry to the last."""
    combine = np.frompyfunc(lambda a, b: _operation(name, a, b), 2, 1)
    plain = [np.asarray(value, dtype=object) for value in map(_plain, inputs)]
    if method == "outer":
        return _wrapped(combine.outer(*plain))
    given = {key: keywords[key] for key in ("axis", "keepdims") if key in keywords}
    options = {key: value for key, value in given.items() if value is not np._NoValue}
    if options.get("axis", 0) is None and not options.get("keepdims"):
        plain[0], options["axis"] = plain[0].ravel(), 0
    if method == "reduce" and not plain[0].size and name in ("add", "multiply"):
        options["initial"] = 0 if name == "add" else 1
    return _wrapped(getattr(combine, method)(plain[0], **options))


def _extreme(name: str) -> Callable[..., Any]:
    def of(a: Any, axis: Any = None) -> Any:
        return _many(name, "reduce", (a,), {"axis": axis})

    return of


def _operation(name: str, *operands: Any) -> Any:
    """An operation with numbers."""
    if not any(isinstance(operand, Symbol) for operand in operands):
        return getattr(np, name)(*operands)  # of constants
    if name in ("logical_and", "bitwise_and", "logical_or", "bitwise_or"):
        for known, other in (operands, operands[::-1]):
            if isinstance(known, (bool, np.bool_)):
                return other if known == name.endswith("and") else known
    texts = [_text(operand) for operand in operands]
    # What products with matrices are full of.
    if name == "add" and "0" in texts:
        return operands[1 - texts.index("0")]
    if name == "subtract" and texts[1] == "0":
        return operands[0]
    if name == "multiply" and "0" in texts:
        return Symbol("0")
    if name in ("multiply", "divide") and "1" in texts[name == "divide" :]:
        return operands[0 if texts[1] == "1" else 1]
    text, binds, needed = (_OPERATIONS.get(name) or _CONDITIONS[name])
    is_of_conditions = name in ("logical_and", "bitwise_and", "logical_or", "bitwise_or", "logical_not", "invert")
    for operand in operands:
        if isinstance(operand, Symbol) and operand.is_condition != is_of_conditions:
            said = "a condition in place of a number" if operand.is_condition else "a number in place of a condition"
            raise InvalidArgument(
                f"numpy.{name} of {operand.text} takes {said}", hint="numpy.where(condition, a, b), and x > 0"
            )
    if name in ("add", "subtract") and _PRODUCT <= _binds(operands[1]) <= _SIGN and texts[1].startswith("-"):
        # a + -b*c is a - b*c, to the last bit.
        name = "subtract" if name == "add" else "add"
        text, texts[1] = _OPERATIONS[name][0], texts[1][1:]
    else:
        texts[1:] = [_within(part, _binds(of), need) for part, of, need in zip(texts[1:], operands[1:], needed[1:])]
    texts[0] = _within(texts[0], _binds(operands[0]), needed[0])
    written = text.format(*texts)
    if len(written) > LONGEST:
        raise InvalidArgument(
            f"an expression of the plant has more than {LONGEST} characters, and at most {READ} are read",
            hint="a shorter one: what is used over and over is written down as often",
        )
    return Symbol(written, binds)


def _within(text: str, binds: int, needed: int) -> str:
    return text if binds >= needed else f"({text})"


def _binds(value: Any) -> int:
    if isinstance(value, Symbol):
        return value.binds
    return _SIGN if _text(value).startswith("-") else _ATOM


def _chosen(condition: Any, chosen: Any, other: Any) -> Any:
    if not isinstance(condition, Symbol):
        return chosen if condition else other
    if not condition.is_condition:
        raise InvalidArgument(f"numpy.where takes the number {condition.text} for a condition", hint="x != 0")
    return Symbol(f"if({condition.text}, {_text(chosen)}, {_text(other)})")


def _where(condition: Any, x: Any, y: Any) -> Any:
    return _elementwise(_chosen, (condition, x, y))


def _select(condlist: Sequence[Any], choicelist: Sequence[Any], default: Any = 0) -> Any:
    for condition, choice in reversed(list(zip(condlist, choicelist))):
        default = _where(condition, choice, default)
    return default


def _clip(a: Any, a_min: Any = None, a_max: Any = None, **keywords: Any) -> Any:
    low, high = keywords.pop("min", a_min), keywords.pop("max", a_max)
    if keywords:
        raise InvalidArgument(f"numpy.clip of a plant has no {next(iter(keywords))}", hint="numpy.clip(x, low, high)")
    if low is None or high is None:
        bound = high if low is None else low
        name = "minimum" if low is None else "maximum"
        return a if bound is None else _elementwise(lambda *operands: _operation(name, *operands), (a, bound))
    return _elementwise(lambda *operands: _operation("clip", *operands), (a, low, high))


_FUNCTIONS: dict[Any, Callable[..., Any]] = {
    np.where: _where,
    np.select: _select,
    np.clip: _clip,
    np.max: _extreme("maximum"),
    np.min: _extreme("minimum"),
}


def _called(function: Any, arguments: Any, keywords: Any) -> Any:
    """A function of numpy that is written in Python, or moves entries: with what it computes of objects."""
    own = _FUNCTIONS.get(function)
    try:
        if own is not None:
            return own(*arguments, **keywords)
        plain = {key: _plain(value) for key, value in keywords.items()}
        return _wrapped(function(*_plain(arguments), **plain))
    except InvalidArgument:
        raise
    except Exception as error:
        raise InvalidArgument(
            f"an expression of a plant has no numpy.{function.__name__}: {error}", hint=_LANGUAGE
        ) from error


def _text(value: Any) -> str:
    """An operand."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    if isinstance(value, Symbol):
        return value.text
    if isinstance(value, (int, float, np.integer, np.floating)):
        number = float(value)
        if not np.isfinite(number):
            raise InvalidArgument(f"a plant has the number {number}")
        return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
    hint = "numbers, states, inputs and what is computed"
    if isinstance(value, np.ndarray) and value.size == 1:
        hint = "its entry, u[0] in place of u"
    raise InvalidArgument(f"{value!r} is not a number of a plant", hint=hint)


def traced(
    what: str,
    function: Callable[..., Any],
    states: Sequence[str],
    inputs: Sequence[str],
    parameters: Sequence[str] = (),
    expected: int | None = None,
) -> list[str]:
    """The expressions of `function(x)`, `function(x, u)`, `function(t, x)` or `function(t, x, u)`, so many as expected.

    python-control's `function(t, x, u, params)` has the symbols of the parameters in a dictionary.
    """
    given = {"t": Symbol("t"), "x": _symbols(states), "u": _symbols(inputs)}
    named = {name: Symbol(name) for name in parameters}
    takes, keyword = _takes(what, function, bool(parameters))
    arguments = [given[name] for name in takes]
    try:
        found = function(*arguments, **({} if keyword is None else {keyword: named}))
    except InvalidArgument:
        raise
    except IndexError as error:
        raise InvalidArgument(
            f"{what}: {error}; x has {len(states)} entries and u has {len(inputs)}",
            hint="`states` and `inputs` with as many names, or their numbers",
        ) from error
    except (TypeError, AttributeError, KeyError, ValueError) as error:
        raise InvalidArgument(
            f"{what} cannot be called with symbols as {what}({', '.join(takes)}): {error}",
            hint="numpy's functions of the arrays x and u, numpy.sin(x) in place of math.sin(x)",
        ) from error
    found = _plain(found) if isinstance(found, Symbols) else found
    entries = np.atleast_1d(np.asarray(found, dtype=object)).ravel()
    for entry in entries:
        if isinstance(entry, Symbol) and entry.is_condition:
            raise InvalidArgument(f"{what} returns the condition {entry.text}", hint="numpy.where(condition, 1, 0)")
    if not entries.size or (expected is not None and entries.size != expected):
        number = "one for each state" if what == "f" else "one for each output"
        raise InvalidArgument(
            f"{what} returns {entries.size} {'value' if entries.size == 1 else 'values'}",
            hint=number if expected is None else f"{expected}, {number}",
        )
    rows = [_text(entry) for entry in entries]
    # Spaces mean nothing to the reader.
    rows = [row if len(row.encode()) <= READ else row.replace(" ", "") for row in rows]
    for i, row in enumerate(rows):
        if len(row.encode()) > READ:
            of = f"row {i + 1}" + (f" ({states[i]})" if what == "f" and i < len(states) else "")
            raise InvalidArgument(
                f"{what}: {of}: the expression has {len(row.encode())} bytes; at most {READ} are read",
                hint="fewer results that are used over and over, each of which is written down as often; in place of "
                "an integration of your own, the plant in continuous time",
            )
    return rows


def _takes(what: str, function: Callable[..., Any], has_parameters: bool) -> tuple[list[str], str | None]:
    """What the arguments of a function are, by those without a default: of t, x and u; and the keyword for params."""
    hint = f"{what}(x), {what}(x, u), {what}(t, x), {what}(t, x, u) or {what}(t, x, u, params)"
    try:
        parameters = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):
        message = f"the parameters of {what} are not known: {function!r}"
        raise InvalidArgument(message, hint=f"a function {hint}") from None
    keyword = None
    names: list[str] = []
    for one in parameters:
        is_required = one.default is one.empty
        if one.kind is one.VAR_KEYWORD or one.kind is one.VAR_POSITIONAL:
            continue
        if one.name in _PARAMS and one.kind is not one.POSITIONAL_ONLY:
            keyword = one.name if is_required or has_parameters else None
        elif is_required and one.kind is one.KEYWORD_ONLY:
            raise InvalidArgument(
                f"{what} needs the keyword {one.name}", hint=f"functools.partial({what}, {one.name}=..), or a default"
            )
        elif is_required:
            names.append(one.name)
    possible = [meaning for meaning in _MEANINGS.get(len(names), []) if _agrees(names, meaning)]
    if possible:
        return possible[0], keyword
    if not names and any(one.kind is one.VAR_POSITIONAL for one in parameters):
        raise InvalidArgument(f"{what} takes any number of arguments: which is not known", hint=f"a function {hint}")
    count = f"{len(names)} argument{'' if len(names) == 1 else 's'} without a default"
    raise InvalidArgument(f"{what} has {count}, ({', '.join(names)})", hint=hint)


# What the arguments without a default are.
_MEANINGS: dict[int, list[list[str]]] = {1: [["x"]], 2: [["x", "u"], ["t", "x"]], 3: [["t", "x", "u"]]}
_TIMES = ("t", "time")
_PARAMS = ("params", "parameters")


def _agrees(names: Sequence[str], meaning: Sequence[str]) -> bool:
    """Whether no name says another thing: only t and time are times, and x and u are where they are meant."""

    def fits(name: str, meant: str) -> bool:
        if name in _TIMES:
            return meant == "t"
        if name in ("x", "u"):
            return meant == name
        # A time is named as one where (x, u) is possible as well.
        return meant != "t" or len(meaning) > 2

    return all(map(fits, names, meaning))


def texts(what: str, values: Any, tables: Sequence[str] = ()) -> list[str]:
    """The expressions of a list of texts, numbers and sympy's expressions, or of a sympy matrix."""
    if isinstance(values, str):
        raise InvalidArgument(f"{what} is a list of strings", hint=f'{what}=["x2", "-x1"]')
    return [_expression(what, value, tables) for value in values]


def name_of(what: str, value: Any) -> str:
    """The name of a state, input or output: a text, or a symbol of sympy."""
    if isinstance(value, str):
        return value
    if getattr(value, "is_Symbol", False) or getattr(value, "is_Function", False):
        return str(getattr(value, "name", None) or value.func.__name__)
    raise InvalidArgument(f"{what} is a list of names, and has {value!r}", hint=f'{what}=["a", "b"]')


def _expression(what: str, value: Any, tables: Sequence[str]) -> str:
    if isinstance(value, str):
        return value
    if hasattr(value, "free_symbols"):
        from . import _sympy

        return _sympy.text(value, tables)
    if isinstance(value, (int, float, np.integer, np.floating)):
        return _text(value)
    raise InvalidArgument(f"{what} is a list of strings", hint=f'{what}=["x2", "-x1"]')
