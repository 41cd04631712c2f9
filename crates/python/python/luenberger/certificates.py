"""Certificates: what is proved of an observer, and files that others can check."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from . import _html, _luenberger
from .errors import NotProved

__all__ = ["Certificate", "Fact", "Proved", "verify"]


@dataclass(frozen=True)
class Fact:
    """One inequality of a theorem, and what is known of it.

    Attributes
    ----------
    inequality : str
        The inequality, as the theory writes it.
    verdict : {'proved', 'refuted', 'undecided'}
        The verdict.
    margin : float or None
        The verified margin; 0 for an equation, None if it is not proved.
    words : str
        The verdict in words.

    Examples
    --------
    >>> import luenberger
    >>> luenberger.certify(([[-1.0]], None, [[1.0]]), [[1.0]]).certificate.facts[0].inequality
    'P > 0'
    """

    inequality: str
    verdict: str
    margin: float | None
    words: str


@dataclass(frozen=True)
class Proved:
    """What a certificate file proves.

    Attributes
    ----------
    title : str
        The title of the file; it carries no claim.
    statement : str
        The statement, generated from the data.
    facts : list of Fact
        Its inequalities, each proved.

    Examples
    --------
    >>> import luenberger
    >>> proved = luenberger.certify(([[-1.0]], None, [[1.0]]), [[1.0]], name="first order").certificate.verify()
    >>> proved.title, len(proved.facts)
    ('first order', 2)
    """

    title: str
    statement: str
    facts: list[Fact]

    def _repr_html_(self) -> str:
        return _html.paragraph(self.statement) + _facts(self.title, self.facts)


@dataclass(frozen=True)
class _Kept:
    """What a certificate said, of a copy or a pickle of it."""

    all_facts: list[dict[str, Any]]
    all_statements: list[str]
    word: str
    file: str | NotProved

    def facts(self) -> list[dict[str, Any]]:
        return self.all_facts

    def statements(self) -> list[str]:
        return self.all_statements

    def verdict(self) -> str:
        return self.word

    def to_json(self) -> str:
        if isinstance(self.file, NotProved):
            raise self.file
        return self.file


class Certificate:
    """The theorems of a design, each decided in exact or interval arithmetic.

    A copy and a pickle say what it said; `verify` derives it again from its file.

    Examples
    --------
    >>> import luenberger
    >>> sys = luenberger.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    >>> certificate = luenberger.place_observer(sys, [-2, -5]).certificate
    >>> certificate.verdict, certificate.is_proved
    ('proved', True)
    >>> all(fact.margin >= 0 for fact in certificate.facts)
    True
    >>> certificate.verify().title
    'luenberger'
    """

    def __init__(self, inner: _luenberger.Certificate | _Kept) -> None:
        self._inner = inner

    def __getstate__(self) -> dict[str, Any]:
        inner = self._inner
        file: str | NotProved
        try:
            file = inner.to_json()
        except NotProved as error:
            file = NotProved(str(error))
        return {"_inner": _Kept(inner.facts(), inner.statements(), inner.verdict(), file)}

    @property
    def verdict(self) -> str:
        """'proved' or 'undecided'; a fact that is refuted is one of its matrices, and refutes no observer."""
        return self._inner.verdict()

    @property
    def is_proved(self) -> bool:
        """Whether every inequality of every theorem is proved."""
        return self.verdict == "proved"

    @property
    def facts(self) -> list[Fact]:
        """The inequalities, each with its verdict."""
        return [Fact(**fact) for fact in self._inner.facts()]

    @property
    def margins(self) -> dict[str, float]:
        """The verified margins by their inequalities."""
        return {fact.inequality: fact.margin for fact in self.facts if fact.margin is not None}

    @property
    def statements(self) -> list[str]:
        """What each proved theorem states, in words generated from its data."""
        return self._inner.statements()

    def to_json(self) -> str:
        """The certificate file, which `luenberger-verify` and `luenberger.verify` check.

        Raises
        ------
        NotProved
            Names the inequality that is not proved.
        """
        return self._inner.to_json()

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the certificate file, and return its path."""
        target = Path(path)
        target.write_text(self.to_json(), encoding="utf-8")
        return target

    def verify(self) -> Proved:
        """Check the certificate file as a stranger would: everything is derived again from its data.

        Raises
        ------
        Rejected
            The file does not prove what it says.
        """
        return _verified(self.to_json().encode())

    def __repr__(self) -> str:
        margins = [margin for margin in self.margins.values() if margin > 0]
        least = f", least margin {min(margins):.4g}" if margins else ""
        return f"<Certificate: {self.verdict}, {len(self.facts)} inequalities{least}>"

    def _repr_html_(self) -> str:
        statements = "".join(_html.paragraph(statement) for statement in self.statements)
        return statements + _facts(self.verdict, self.facts)


def _facts(caption: str, facts: list[Fact]) -> str:
    rows = [[fact.inequality, fact.verdict, _html.number(fact.margin)] for fact in facts]
    return _html.table(caption, ["inequality", "verdict", "margin"], rows)


def _verified(data: bytes) -> Proved:
    found = _luenberger.verify(data)
    return Proved(found["title"], found["statement"], [Fact(**fact) for fact in found["facts"]])


def verify(path: str | PathLike[str]) -> Proved:
    """Check a certificate file.

    Parameters
    ----------
    path : path-like
        The file.

    Returns
    -------
    Proved
        Statement and inequalities.

    Raises
    ------
    Rejected
        The file does not prove what it says.

    Examples
    --------
    >>> import luenberger, tempfile, pathlib
    >>> observer = luenberger.place_observer(([[0, 1], [0, 0]], None, [[1, 0]]), [-2, -5])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = observer.certificate.save(pathlib.Path(folder) / "observer.json")
    ...     proved = luenberger.verify(file)
    >>> all(fact.verdict == "proved" for fact in proved.facts)
    True
    """
    return _verified(Path(path).read_bytes())
