"""Expressions of sympy in the language of plants. Imported where one is given: sympy is not needed otherwise."""

from __future__ import annotations

from typing import Any

from sympy.printing.str import StrPrinter

from .errors import InvalidArgument

__all__ = ["text"]

NAMES = {"log": "ln", "Abs": "abs", "Max": "max", "Min": "min", "Mod": "mod", "Heaviside": "step"}


class Printer(StrPrinter):  # type: ignore[misc]
    def _print_Function(self, part: Any) -> str:
        name = part.func.__name__
        # The second argument of a step is its value at 0.
        arguments = part.args[:1] if name == "Heaviside" else part.args
        return f"{NAMES.get(name, name)}({', '.join(map(self._print, arguments))})"

    _print_Max = _print_Min = _print_Abs = _print_Mod = _print_Heaviside = _print_Function

    def _print_Float(self, part: Any) -> str:
        return repr(float(part))

    def _print_Exp1(self, part: Any) -> str:
        return "e"

    def _print_Piecewise(self, part: Any) -> str:
        *conditional, (value, condition) = part.args
        if condition != True:  # noqa: E712, a boolean of sympy
            raise InvalidArgument(f"{part} has no value where none of its conditions holds")
        text = str(self._print(value))
        for value, condition in reversed(conditional):
            text = f"if({self._print(condition)}, {self._print(value)}, {text})"
        return text

    def _print_And(self, part: Any) -> str:
        return " && ".join(f"({self._print(argument)})" for argument in part.args)

    def _print_Or(self, part: Any) -> str:
        return " || ".join(f"({self._print(argument)})" for argument in part.args)

    def _print_Not(self, part: Any) -> str:
        return f"!({self._print(part.args[0])})"


def text(expression: Any) -> str:
    """An expression as a text."""
    return str(Printer().doprint(expression))
