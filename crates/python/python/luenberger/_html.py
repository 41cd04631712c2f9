"""Tables for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np


def number(value: Any) -> str:
    """A number with five significant digits."""
    if value is None:
        return ""
    if isinstance(value, (bool, str)):
        return str(value)
    if isinstance(value, (complex, np.complexfloating)):
        if value.imag == 0:
            return number(value.real)
        return f"{value.real:.5g} {'-' if value.imag < 0 else '+'} {abs(value.imag):.5g}i"
    return f"{value:.5g}"


def direction(vector: Any, names: Sequence[str]) -> str:
    """A direction with the names of the states, its small components left out."""
    rounded = np.where(np.abs(np.imag(vector)) < 1e-6, np.real(vector), vector)
    parts = [f"{number(complex(x))} {name}" for x, name in zip(rounded, names) if abs(x) > 1e-6]
    return ", ".join(parts)


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """An HTML table; every cell is escaped."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><caption>{escape(caption)}</caption><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def matrices(named: Iterable[tuple[str, Any]]) -> str:
    """Matrices by name, as small tables."""
    parts = []
    for name, matrix in named:
        rows = [[number(x) for x in row] for row in np.atleast_2d(np.asarray(matrix))]
        parts.append(table(name, [], rows))
    return "".join(parts)


def paragraph(text: str) -> str:
    """A paragraph."""
    return f"<p>{escape(text)}</p>"


def text(value: Any) -> str:
    """An escaped text."""
    return escape(str(value))
