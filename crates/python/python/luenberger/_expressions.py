"""The expressions of a plant, from texts, sympy's expressions and Python functions.

A function is called once, with symbols in place of the numbers: what it computes with `+ - * / **`, numpy's functions
and comparisons inside `numpy.where` is written down. So a plant from a function has what one from texts has: Jacobians,
proofs, exports.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .errors import InvalidArgument

__all__ = ["texts", "traced"]

# Longer expressions come from a function that uses its results over and over.
LONGEST = 100_000

_OPERATIONS = {
    "add": "({} + {})",
    "subtract": "({} - {})",
    "multiply": "({}*{})",
    "divide": "({}/{})",
    "power": "({}^{})",
    "float_power": "({}^{})",
    "negative": "(-{})",
    "positive": "{}",
    "square": "({}^2)",
    "reciprocal": "(1/{})",
    "absolute": "abs({})",
    "fabs": "abs({})",
    "log": "ln({})",
    "log2": "(ln({})/ln(2))",
    "expm1": "(exp({}) - 1)",
    "log1p": "ln(1 + {})",
    "arcsin": "asin({})",
    "arccos": "acos({})",
    "arctan": "atan({})",
    "arctan2": "atan2({}, {})",
    "arcsinh": "asinh({})",
    "arccosh": "acosh({})",
    "arctanh": "atanh({})",
    "hypot": "sqrt({}^2 + {}^2)",
    "maximum": "max({}, {})",
    "minimum": "min({}, {})",
    "remainder": "mod({}, {})",
    "floor_divide": "floor({}/{})",
    "deg2rad": "({}*pi/180)",
    "radians": "({}*pi/180)",
    "rad2deg": "({}*180/pi)",
    "degrees": "({}*180/pi)",
    **{name: name + "({})" for name in ["sqrt", "exp", "log10", "sin", "cos", "tan", "sinh", "cosh", "tanh"]},
    **{name: name + "({})" for name in ["sign", "floor"]},
}

_COMPARISONS = {
    "less": "{} < {}",
    "less_equal": "{} <= {}",
    "greater": "{} > {}",
    "greater_equal": "{} >= {}",
    "equal": "{} == {}",
    "not_equal": "{} != {}",
    "logical_and": "({}) && ({})",
    "bitwise_and": "({}) && ({})",
    "logical_or": "({}) || ({})",
    "bitwise_or": "({}) || ({})",
    "logical_not": "!({})",
    "invert": "!({})",
}


class Symbol(np.lib.mixins.NDArrayOperatorsMixin):
    """A number of a plant that has no value yet: the expression of it."""

    def __init__(self, text: str, *, condition: bool = False) -> None:
        self.text = text
        self.condition = condition

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> Any:
        name = ufunc.__name__
        form = _OPERATIONS.get(name) or _COMPARISONS.get(name)
        if method != "__call__" or form is None or any(value is not None for value in keywords.values()):
            raise InvalidArgument(f"an expression of a plant has no numpy.{name}", hint="see docs/expressions.md")
        arrays = [value for value in inputs if isinstance(value, np.ndarray) and value.ndim]
        if arrays:
            shape = np.broadcast_shapes(*(value.shape for value in arrays))
            wide = [np.broadcast_to(np.asarray(value, dtype=object), shape) for value in inputs]
            found = np.empty(shape, dtype=object)
            for place in np.ndindex(shape):
                found[place] = ufunc(*(array[place] for array in wide))
            return found
        operands = [_text(value) for value in inputs]
        # What products with matrices are full of.
        if name == "add" and "0" in operands:
            return _symbol(inputs[1 - operands.index("0")])
        if name == "multiply" and "0" in operands:
            return Symbol("0")
        if name == "multiply" and "1" in operands:
            return _symbol(inputs[1 - operands.index("1")])
        text = form.format(*operands)
        if len(text) > LONGEST:
            raise InvalidArgument(
                f"an expression of the plant has more than {LONGEST} characters",
                hint="write the equations as texts, with parameters",
            )
        return Symbol(text, condition=name in _COMPARISONS)

    def __array_function__(self, function: Any, types: Any, arguments: Any, keywords: Any) -> Any:
        if function is np.where and len(arguments) == 3 and not keywords:
            condition, chosen, other = arguments
            if isinstance(condition, Symbol):
                return Symbol(f"if({condition.text}, {_text(chosen)}, {_text(other)})")
            return chosen if condition else other
        if function is np.clip and len(arguments) == 3 and not keywords:
            return Symbol(f"sat({', '.join(map(_text, arguments))})")
        raise InvalidArgument(
            f"an expression of a plant has no numpy.{function.__name__}", hint="see docs/expressions.md"
        )

    def __getattr__(self, name: str) -> Any:
        # numpy calls the method `sin` of an object in an array for its function sin.
        ufunc = getattr(np, name, None)
        if isinstance(ufunc, np.ufunc) and name in _OPERATIONS:
            return lambda *others: ufunc(self, *others)
        raise AttributeError(name)

    def __bool__(self) -> bool:
        raise InvalidArgument(
            f"the function decides by {self.text}, which has no value yet",
            hint="numpy.where(condition, a, b), numpy.maximum or numpy.clip in place of `if`",
        )

    def __float__(self) -> float:
        raise InvalidArgument(
            f"the function takes the value of {self.text}, which has none yet",
            hint="numpy's functions, numpy.sin(x) in place of math.sin(x)",
        )

    __int__ = __index__ = __float__

    def __repr__(self) -> str:
        return self.text


def _symbol(value: Any) -> Symbol:
    return value if isinstance(value, Symbol) else Symbol(_text(value))


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
        digits = str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
        return f"({digits})" if number < 0 else digits
    raise InvalidArgument(f"{value!r} is not a number of a plant", hint="numbers, states, inputs and what is computed")


def traced(
    what: str, function: Callable[..., Any], states: Sequence[str], inputs: Sequence[str]
) -> list[str]:
    """The expressions of `function(x)`, `function(x, u)` or `function(t, x, u)`."""
    try:
        count = len(inspect.signature(function).parameters)
    except (TypeError, ValueError):
        count = 2
    x, u = (np.array([Symbol(name) for name in names], dtype=object) for names in (states, inputs))
    arguments = {1: (x,), 2: (x, u), 3: (Symbol("t"), x, u)}.get(count)
    if arguments is None:
        raise InvalidArgument(
            f"{what} is a function of {count} arguments", hint=f"{what}(x), {what}(x, u) or {what}(t, x, u)"
        )
    try:
        found = function(*arguments)
    except TypeError as error:
        raise InvalidArgument(
            f"{what} cannot be called with symbols: {error}",
            hint="numpy's functions, numpy.sin(x) in place of math.sin(x)",
        ) from error
    entries = np.atleast_1d(np.asarray(found, dtype=object)).ravel()
    for entry in entries:
        if isinstance(entry, Symbol) and entry.condition:
            raise InvalidArgument(f"{what} returns the condition {entry.text}", hint="numpy.where(condition, 1, 0)")
    return [_text(entry) for entry in entries]


def texts(what: str, values: Any) -> list[str]:
    """The expressions of a list of texts, numbers and sympy's expressions, or of a sympy matrix."""
    if isinstance(values, str):
        raise InvalidArgument(f"{what} is a list of strings", hint=f'{what}=["x2", "-x1"]')
    return [_expression(what, value) for value in values]


def _expression(what: str, value: Any) -> str:
    if isinstance(value, str):
        return value
    if hasattr(value, "free_symbols"):
        from . import _sympy

        return _sympy.text(value)
    if isinstance(value, (int, float, np.integer, np.floating)):
        return _text(value)
    raise InvalidArgument(f"{what} is a list of strings", hint=f'{what}=["x2", "-x1"]')
