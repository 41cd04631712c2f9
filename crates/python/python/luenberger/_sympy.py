"""Expressions of sympy in the language of plants. Imported where one is given: sympy is not needed otherwise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sympy.core.function import AppliedUndef
from sympy.printing.str import StrPrinter

from .errors import InvalidArgument

__all__ = ["text"]

NAMES = {"log": "ln", "Abs": "abs", "Max": "max", "Min": "min", "Mod": "mod"}

# Functions that the language has by another name.
FORMS = {
    "cot": "(1/tan({}))",
    "sec": "(1/cos({}))",
    "csc": "(1/sin({}))",
    "coth": "(1/tanh({}))",
    "sech": "(1/cosh({}))",
    "csch": "(1/sinh({}))",
    "ceiling": "(-floor(-({})))",
}


class Printer(StrPrinter):  # type: ignore[misc]
    def __init__(self, tables: Sequence[str]) -> None:
        super().__init__()
        self.tables = tables

    def _print_Function(self, part: Any) -> str:
        name = part.func.__name__
        arguments = list(map(self._print, part.args))
        if name in FORMS and len(arguments) == 1:
            return FORMS[name].format(*arguments)
        # A state of dynamicsymbols is a function of time.
        if isinstance(part, AppliedUndef) and arguments == ["t"] and name not in self.tables:
            return str(name)
        return f"{NAMES.get(name, name)}({', '.join(arguments)})"

    _print_Max = _print_Min = _print_Abs = _print_Mod = _print_Function

    def _print_Heaviside(self, part: Any) -> str:
        x, at_zero = self._print(part.args[0]), part.args[1]
        return f"step({x})" if at_zero == 1 else f"if({x} < 0, 0, if({x} > 0, 1, {self._print(at_zero)}))"

    def _print_Derivative(self, part: Any) -> str:
        raise InvalidArgument(f"{part} is a derivative", hint="a state of its own in its place")

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

    def _print_Relational(self, part: Any) -> str:
        if part.rel_op in ("==", "!="):
            return f"({self._print(part.lhs)}) {part.rel_op} ({self._print(part.rhs)})"
        return str(super()._print_Relational(part))

    def _print_ITE(self, part: Any) -> str:
        condition, yes, no = map(self._print, part.args)
        return f"(({condition}) && ({yes})) || (!({condition}) && ({no}))"

    def _print_Xor(self, part: Any) -> str:
        text, *others = map(self._print, part.args)
        for other in others:
            text = f"(({text}) && !({other})) || (!({text}) && ({other}))"
        return str(text)

    def _print_BooleanTrue(self, _: Any) -> str:
        return "0 < 1"

    def _print_BooleanFalse(self, _: Any) -> str:
        return "1 < 0"

    def _print_And(self, part: Any) -> str:
        return " && ".join(f"({self._print(argument)})" for argument in part.args)

    def _print_Or(self, part: Any) -> str:
        return " || ".join(f"({self._print(argument)})" for argument in part.args)

    def _print_Not(self, part: Any) -> str:
        return f"!({self._print(part.args[0])})"


def text(expression: Any, tables: Sequence[str] = ()) -> str:
    """An expression as a text, with the names of lookup tables."""
    return str(Printer(tables).doprint(expression))
