"""An observer on rows that arrive one after the other."""

from __future__ import annotations

import difflib
import json
import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _luenberger
from ._arrays import is_missing, number
from .errors import InvalidArgument

if TYPE_CHECKING:
    from .studies import Study

__all__ = ["Stream"]


class Stream:
    """An observer of a study on rows as they arrive, with the bits of the step that is exported for the target.

    A row is a mapping from the names of columns to numbers: those of the table [log] of the study, or of the plant's
    inputs and outputs, and `t`. An absent key, None and NaN are a missing value; a name that the study does not have
    is refused. Each row is one sample; with the times of the rows, the samples that were missed in between are known.

    Parameters
    ----------
    study : Study
        The study.
    observer : str, optional
        The name of the observer (default: the only one).
    dt, substeps : optional
        The step of an observer in continuous time, as for `Observer.export`.
    timed : bool, optional
        Whether the rows have times; otherwise each is the next sample.
    predicted : bool, optional
        Whether filters, too, give the estimate for the next sample (default: as `estimates` of [log] says).
    state : str, optional
        A state that `save` returned, to go on from.

    Raises
    ------
    ExportRefused
        The observer has no step.
    InvalidArgument
        The state is damaged, or of another study, observer or period.

    Examples
    --------
    >>> import luenberger
    >>> study = luenberger.Study.from_text('''
    ... [plant]
    ... states = ["level"]
    ... outputs = ["gauge"]
    ... a = [[1]]
    ... c = [[1]]
    ... dt = 0.5
    ... [[observer]]
    ... kind = "luenberger"
    ... poles = [0.5]
    ... ''')
    >>> stream = study.stream()
    >>> stream.step({"t": 0, "gauge": 2})
    {'t': 0.5, 'level_hat': 1.0}
    >>> saved = stream.save()
    >>> stream.step(t=0.5, gauge=2) == study.stream(state=saved).step(t=0.5, gauge=2)
    True
    """

    def __init__(
        self,
        study: Study,
        observer: str | None = None,
        *,
        dt: float | None = None,
        substeps: int | None = None,
        timed: bool = True,
        predicted: bool | None = None,
        state: str | None = None,
    ) -> None:
        period = None if dt is None else number("dt", dt, positive=True)
        if observer is not None and observer not in study.observers:
            raise InvalidArgument(f"there is no observer {observer!r}", hint=", ".join(study.observers))
        self._study = study
        # The names that rows may have; those of [log] are found in the text when they occur.
        self._names = {"t", *study.states, *study.inputs, *study.outputs}
        self._inner = _luenberger.RowStream(study._inner, observer, period, substeps, timed, predicted)
        if state is not None:
            self.resume(state)

    @property
    def columns(self) -> list[str]:
        """The names of the results: `t`, for which the estimates hold, `NAME_hat`, and bands.

        Bands are `NAME_2sigma` of a filter, two standard deviations, and `NAME_lower`, `NAME_upper` of an interval
        observer.
        """
        return self._inner.columns()

    @property
    def samples(self) -> int:
        """Samples so far, missed ones included."""
        return self._inner.samples()

    def step(self, row: Mapping[str, Any] | None = None, /, **values: Any) -> dict[str, float | None]:
        """The estimates for a row; a band that is not known is None.

        Parameters
        ----------
        row : mapping, optional
            The values by the names of columns.
        **values
            The same as keywords.

        Raises
        ------
        InvalidArgument
            The row cannot be used: a value that is not finite, a time that is not after that of the row before, a name
            that the study does not have. It is passed over, and the next row goes on.
        SimulationError
            The estimate is no longer finite.
        """
        given = {**({} if row is None else row), **values}
        for name in given:
            if name not in self._names:
                self._check(str(name))
        text = json.dumps({name: _value(name, value) for name, value in given.items()})
        found: dict[str, float | None] = json.loads(self._inner.step(text), parse_int=float)
        return found

    def _check(self, name: str) -> None:
        """A column whose name is nowhere in the study is one that it does not use, perhaps misspelt."""
        if re.search(rf"(?<!\w){re.escape(name)}(?!\w)", self._study._text) is None:
            near = difflib.get_close_matches(name, self._names, n=1)
            nearest = f"; did you mean {near[0]!r}?" if near else ""
            raise InvalidArgument(
                f"{name!r} is no column of the log or the plant{nearest}",
                hint="only names of columns that the study has",
            )
        self._names.add(name)

    def save(self) -> str:
        """The state after the last row, with all bits; `resume` goes on from it."""
        return self._inner.saved()

    def resume(self, state: str) -> None:
        """Go on from a saved state; one that is damaged, or of another study or observer, is refused."""
        self._inner.resume(state)

    def __repr__(self) -> str:
        return f"<Stream: {', '.join(self.columns)} after {self.samples} samples>"


def _value(name: str, value: Any) -> float | str | None:
    """A number, a date or time as text, or None for a missing value."""
    if isinstance(value, str):
        return value
    if is_missing(value):
        return None
    try:
        found = float(value)
    except (TypeError, ValueError):
        raise InvalidArgument(f"{name} is {value!r}", hint="a number, a date as text, or None") from None
    if math.isnan(found):
        return None
    if math.isinf(found):
        raise InvalidArgument(f"{name} is {value!r}", hint="a finite number")
    return found
