"""Study files: read, executed, and their results as arrays and tables."""

from __future__ import annotations

import difflib
import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from . import _html, _luenberger
from ._arrays import number
from .errors import InvalidArgument, StudyError
from .streams import Stream
from .trajectories import Trajectory, trajectory

__all__ = ["Results", "Study", "Tuned"]

# What `Study.run` executes.
STEPS = ("run", "observe", "design", "certify", "simulate", "compare", "sweep")

# progress(stage, item, done, total), called in the thread of the call.
Progress = Callable[[str, str, int, int], Any]


class Study:
    """A study file: a plant, observers, and the experiments with them.

    Parameters
    ----------
    path : path-like
        The file, TOML or JSON.

    Raises
    ------
    StudyFileError
        The file has mistakes; `diagnostics` lists all of them with line and column.

    Examples
    --------
    >>> import luenberger
    >>> study = luenberger.Study.from_text('''
    ... [plant]
    ... a = [[0, 1], [0, 0]]
    ... c = [[1, 0]]
    ... [simulation]
    ... x0 = [1, -1]
    ... duration = 8
    ... [[observer]]
    ... kind = "luenberger"
    ... poles = [-2, -5]
    ... ''')
    >>> results = study.run()
    >>> results.verdicts
    {'luenberger': 'proved'}
    >>> results["luenberger"].xhat.shape
    (2, 501)
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        inner, file = _luenberger.StudyFile(Path(path)), Path(path).absolute()
        self._open(inner, _content(file), (file, _digest(_content(file))))

    def _open(self, inner: _luenberger.StudyFile, text: str, source: tuple[Any, ...]) -> None:
        self._inner, self._text, self._source = inner, text, source
        summary = inner.summary()
        self.title: str = summary["title"]
        self.about: str = summary["about"]
        self.states: list[str] = summary["states"]
        self.inputs: list[str] = summary["inputs"]
        self.outputs: list[str] = summary["outputs"]
        self.observers: list[str] = summary["observers"]
        self._turns: list[float] | None = summary["turns"]

    @classmethod
    def from_text(cls, text: str, *, format: str = "toml", folder: str | PathLike[str] = ".") -> Study:
        """The study in a text; file names in it are relative to `folder`."""
        study = cls.__new__(cls)
        absolute = Path(folder).absolute()
        inner = _luenberger.StudyFile.from_text(text, format == "json", Path(folder))
        study._open(inner, text, (text, format, absolute))
        return study

    def __reduce__(self) -> Any:
        """A copy and a pickle are read again: from the text, or from the file, which has to be as it was."""
        return _read_again, (type(self), *self._source)

    def run(
        self,
        step: str = "run",
        *,
        output: str | PathLike[str] | None = None,
        force: bool = False,
        threads: int | None = None,
        time_limit: float | None = None,
        memory_limit: float | None = None,
        block_size: int | None = None,
        restart: bool = False,
        progress: Progress | bool | None = None,
    ) -> Results:
        """Execute the study, or one step of it with what it needs of the steps before.

        The interpreter's lock is released meanwhile, and Ctrl-C ends the execution.

        Parameters
        ----------
        step : {'run', 'observe', 'design', 'certify', 'simulate', 'compare', 'sweep'}, optional
            The step.
        output : path-like, optional
            The results folder; without it nothing is written.
        force : bool, optional
            Write into a folder that has other files.
        threads : int, optional
            Number of threads (default: that of the processors). Results do not depend on it.
        time_limit, memory_limit : float, optional
            Seconds and bytes (default 24 h and 4 GiB).
        block_size : int, optional
            Runs of a block of a sweep (default: a sixteenth of the ensemble, from 32 to 1000). With the step 'sweep'
            and an output folder the blocks stay there, and a sweep that was interrupted is resumed.
        restart : bool, optional
            Delete the blocks that are there.
        progress : callable or bool, optional
            `progress(stage, item, done, total)`, called in this thread; what it raises ends the execution and comes
            through. True shows a bar of tqdm, if it is installed.

        Returns
        -------
        Results

        Raises
        ------
        StudyError
            The study could not be executed. An observer that is not applicable is no error: see `Results.failures`.
        """
        if step not in STEPS:
            near = difflib.get_close_matches(str(step), STEPS, n=1)
            nearest = f"; the nearest is {near[0]!r}" if near else ""
            raise InvalidArgument(f"there is no step {step!r}{nearest}", hint=", ".join(STEPS))
        with _progress(progress) as callback:
            found = self._inner.execute(
                step,
                None if output is None else Path(output),
                force,
                threads,
                None if time_limit is None else number("time_limit", time_limit, positive=True),
                None if memory_limit is None else number("memory_limit", memory_limit, positive=True),
                block_size,
                restart,
                callback,
            )
        return results(found, self.states, self.inputs, self.outputs, self._turns)

    def tune(
        self,
        *,
        output: str | PathLike[str] | None = None,
        force: bool = False,
        write: bool = False,
        threads: int | None = None,
        progress: Progress | bool | None = None,
    ) -> Tuned:
        """Fit what the table [tune] names to the log, by the maximum likelihood of the innovations of a filter.

        The interpreter's lock is released meanwhile, and Ctrl-C ends the fit. Results do not depend on the threads.

        Parameters
        ----------
        output : path-like, optional
            A folder for report, figures and data; without it none is written.
        force : bool, optional
            Write into a folder that has other files, and over a tuned study that is there.
        write : bool, optional
            Write the tuned study beside the study, as `tuned.toml`.
        threads : int, optional
            Number of threads (default: that of the processors).
        progress : callable or bool, optional
            As in `run`.

        Returns
        -------
        Tuned

        Raises
        ------
        StudyError
            The log has no information on a parameter, the likelihood no maximum, a part of the log is too short, or the
            filter fails; with the numbers.
        """
        with _progress(progress) as callback:
            found = self._inner.tune(None if output is None else Path(output), force, threads, write, callback)
        return Tuned(json.loads(found["json"]), found["study"], found["text"])

    def stream(
        self,
        observer: str | None = None,
        *,
        dt: float | None = None,
        substeps: int | None = None,
        timed: bool = True,
        predicted: bool | None = None,
        state: str | None = None,
    ) -> Stream:
        """An observer of the study on rows that arrive one after the other; see `Stream`."""
        return Stream(self, observer, dt=dt, substeps=substeps, timed=timed, predicted=predicted, state=state)

    def __repr__(self) -> str:
        return f"<Study {self.title!r}: {', '.join(self.observers) or 'no observers'}>"


def _content(file: Path) -> str:
    # What is no file (a pipe) can be read once.
    return file.read_text(encoding="utf-8", errors="replace") if file.is_file() else ""


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _read_again(kind: type[Study], source: Any, *more: Any) -> Study:
    """A study from its file with a digest, or from its text with format and folder."""
    if len(more) == 2:
        return kind.from_text(source, format=more[0], folder=more[1])
    if _digest(_content(source)) != more[0]:
        raise StudyError(f"{source} has changed since the study was read from it, and its copy would be another study")
    return kind(source)


@contextmanager
def _progress(progress: Progress | bool | None) -> Iterator[Progress | None]:
    """The function that is told the progress: a bar of tqdm for True."""
    if progress is not True:
        yield None if isinstance(progress, bool) else progress
        return
    bar = _Bar()
    try:
        yield bar
    finally:
        bar.close()


def results(
    found: dict[str, Any],
    states: list[str],
    inputs: list[str],
    outputs: list[str],
    turns: list[float] | None = None,
) -> Results:
    """The results that the extension module returns."""
    runs = [trajectory(run, states, inputs, outputs, turns) for run in found["runs"]]
    on_log = [run["on_log"] for run in found["runs"]]
    return Results(json.loads(found["json"]), runs, on_log, found["failures"])


class _Bar:
    """A bar of tqdm for each stage; nothing without tqdm."""

    def __init__(self) -> None:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            tqdm = None
        self._tqdm: Any = tqdm
        self._stage = ""
        self._bar: Any = None

    def __call__(self, stage: str, item: str, done: int, total: int) -> None:
        if self._tqdm is None:
            return
        if stage != self._stage:
            self.close()
            self._stage, self._bar = stage, self._tqdm(total=total, desc=stage)
        self._bar.set_postfix_str(item, refresh=False)
        self._bar.update(max(done - self._bar.n, 0))

    def close(self) -> None:
        """Ends the bar."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


class Results(Mapping[str, Trajectory]):
    """What a study gives: a mapping from the names of observers to their trajectories.

    Attributes
    ----------
    data : dict
        All results, as the file `study.json` has them.
    runs : list of Trajectory
        The trajectories of the simulation.
    log_runs : list of Trajectory
        Those on the measured log.
    failures : list of str
        Observers without a design, conditions that are not verified, runs that ended early.

    Examples
    --------
    >>> import luenberger
    >>> text = '[plant]\\na = [[-1]]\\nc = [[1]]\\n[[observer]]\\nkind = "luenberger"\\npoles = [-2]\\n'
    >>> results = luenberger.Study.from_text(text).run("design")
    >>> results.designs["luenberger"]["L"]
    array([[1.]])
    """

    def __init__(self, data: dict[str, Any], runs: list[Trajectory], on_log: list[bool], failures: list[str]) -> None:
        self.data = data
        self.runs = [run for run, logged in zip(runs, on_log) if not logged]
        self.log_runs = [run for run, logged in zip(runs, on_log) if logged]
        self.failures = failures

    def __getitem__(self, observer: str) -> Trajectory:
        for run in [*self.runs, *self.log_runs]:
            if run.observer == observer:
                return run
        raise KeyError(observer)

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys(run.observer for run in [*self.runs, *self.log_runs]))

    def __len__(self) -> int:
        return len(list(iter(self)))

    @property
    def verdicts(self) -> dict[str, str]:
        """The verdict of each observer; 'not applicable' without a design."""
        return {
            entry["name"]: entry["design"]["verdict"] if "design" in entry else "not applicable"
            for entry in self.data.get("observers", [])
        }

    @property
    def designs(self) -> dict[str, dict[str, Any]]:
        """The matrices of each design by name, as arrays."""
        return {
            entry["name"]: {
                matrix["name"].split(" (")[0]: np.array(matrix["rows"], dtype=np.float64)
                for matrix in entry["design"]["matrices"]
            }
            for entry in self.data.get("observers", [])
            if "design" in entry
        }

    @property
    def scores(self) -> dict[str, list[Any]]:
        """The scores of the simulation, one row for each observer and state, as `pandas.DataFrame` takes them."""
        simulation = self.data.get("simulation")
        return _columns(_score_rows(simulation["rows"])) if simulation else {}

    @property
    def log_scores(self) -> dict[str, list[Any]]:
        """The innovations on the log, one row for each observer and output: samples, mean, rms, peak and the rest.

        `nis` of a filter is the mean normalised square of its innovations, `white` the p-value of a test of whiteness.
        """
        log = self.data.get("log")
        return _columns(_log_rows(log["rows"])) if log else {}

    def to_frame(self) -> Any:
        """The scores as a `pandas.DataFrame` (needs pandas): of the simulation; without one, those on the log."""
        import pandas

        return pandas.DataFrame(self.scores or self.log_scores)

    @property
    def sweep(self) -> dict[str, list[Any]]:
        """The sweep, one row for each value and observer, as `pandas.DataFrame` takes it."""
        sweep = self.data.get("sweep") or self.data.get("sweep_on_log")
        return _columns([_flat(row) for row in sweep["rows"]]) if sweep else {}

    def plot(self, states: Any = None, axes: Any = None) -> Any:
        """Draw the states and the estimates of all observers (needs matplotlib); returns the axes."""
        # An observer of functions has axes of its own.
        drawn: dict[tuple[str, ...], Any] = {}
        for run in self.runs or self.log_runs:
            names = tuple(run.estimated or run.states) if states is None else tuple(states)
            drawn[names] = run.plot(states, drawn.get(names, None if drawn else axes))
        return np.concatenate(list(drawn.values())) if drawn else axes

    def __repr__(self) -> str:
        verdicts = ", ".join(f"{name}: {verdict}" for name, verdict in self.verdicts.items())
        return f"<Results of {self.data['title']!r}: {verdicts or 'no observers'}>"

    def _repr_html_(self) -> str:
        parts = [f"<h3>{_html.text(self.data['title'])}</h3>"]
        rows = []
        for entry in self.data.get("observers", []):
            design = entry.get("design")
            said = design["statement"] if design else entry["failure"]["hypothesis"]
            rows.append([entry["name"], entry["kind"], design["verdict"] if design else "not applicable", said])
        if rows:
            parts.append(_html.table("observers", ["name", "kind", "verdict", "statement"], rows))
        for name, table in (("scores", self.scores), ("log", self.log_scores), ("sweep", self.sweep)):
            if table:
                cells = zip(*table.values())
                parts.append(_html.table(name, list(table), [[_html.number(cell) for cell in row] for row in cells]))
        parts += [_html.paragraph(text) for text in [*self.failures, *self.data.get("warnings", [])]]
        return "".join(parts)


class Tuned(Mapping[str, Any]):
    """What a filter assumes, fitted to a log: a mapping with all numbers, as the file `tune.json` has them.

    Made by `Study.tune`.

    Attributes
    ----------
    study : str
        The tuned study, the text of the study with other numbers and comments that say where they come from.
    fitted : dict of float
        The fitted values by the names of the parameters.

    Examples
    --------
    >>> import luenberger, math, pathlib, tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> rows = "".join(f"{k},{math.sin(3 * k * k)}\\n" for k in range(200))
    >>> _ = pathlib.Path(folder.name, "log.csv").write_text("t,y\\n" + rows)
    >>> study = luenberger.Study.from_text('''
    ... [plant]
    ... a = [[0.9]]
    ... c = [[1]]
    ... outputs = ["y"]
    ... dt = 1
    ... [log]
    ... file = "log.csv"
    ... [[observer]]
    ... name = "filter"
    ... kind = "extended-kalman"
    ... w = [0.001]
    ... v = [1]
    ... period = 1
    ... [tune]
    ... observer = "filter"
    ... parameters = ["v"]
    ... profile = 0
    ... ''', folder=folder.name)
    >>> tuned = study.tune()
    >>> folder.cleanup()
    >>> 0.4 < tuned.fitted["v[y]"] < 0.6
    True
    """

    def __init__(self, data: dict[str, Any], study: str, text: str) -> None:
        self._data = data
        self._text = text
        self.study = study
        self.fitted: dict[str, float] = {one["name"]: one["after"] for one in data["parameters"]}

    def __getitem__(self, key: str) -> Any:
        return self._data[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __len__(self) -> int:
        return len(self._data)

    @property
    def parameters(self) -> dict[str, list[Any]]:
        """The parameters with standard errors and intervals, one row for each, as `pandas.DataFrame` takes them."""
        return _columns([{"unit": None, **row} for row in self._data["parameters"]])

    def save(self, path: str | PathLike[str]) -> None:
        """Write the tuned study."""
        Path(path).write_text(self.study)

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        found = ", ".join(f"{name} = {value:g}" for name, value in self.fitted.items())
        return f"<Tuned {self._data['observer']!r}: {found}>"


def _score_rows(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    found = []
    for row in rows:
        merits = row.get("merits")
        if merits is None:
            found.append({"observer": row["observer"], "failure": row.get("failure")})
            continue
        for state in merits["states"]:
            found.append({"observer": row["observer"], **_flat(state)})
    return found


def _log_rows(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    found = []
    for row in rows:
        if row.get("failure") is not None:
            found.append({"observer": row["observer"], "failure": row["failure"]})
            continue
        nis = row.get("nis")
        of_all = {} if nis is None else {"nis": nis["mean"]}
        found += [{"observer": row["observer"], **_flat(output), **of_all} for output in row["outputs"]]
    return found


def _flat(row: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as columns `a.b`; lists of states, outputs, scores and percentiles as `STATE.b`, `percentile5.b`."""
    flat: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, dict):
            flat.update(_flat(value, f"{prefix}{key}."))
        elif isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
            for number, item in enumerate(value):
                named = next((name for name in ("state", "output", "score") if name in item), None)
                if named is not None:
                    name = item[named]
                elif "percent" in item:
                    named, name = "percent", f"{key[:-1]}{item['percent']}"
                else:
                    name = f"{key}{number + 1}"
                rest = {key: value for key, value in item.items() if key != named}
                flat.update(_flat(rest, f"{prefix}{name}."))
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _columns(rows: list[dict[str, Any]]) -> dict[str, list[Any]]:
    keys = list(dict.fromkeys(key for row in rows for key in row))
    return {key: [row.get(key) for row in rows] for key in keys}
