"""Sweeps on a Dask cluster: blocks on disk, computed by its workers."""

from __future__ import annotations

import importlib
import json
import threading
import uuid
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any

from . import _luenberger
from .errors import InvalidArgument, StudyError
from .studies import Results, results

__all__ = ["reduce", "status", "sweep"]

# Batches for each thread of a worker: a worker that is lost loses a small part of the work.
_BATCHES = 8

# The sweep that this process, a worker, computes blocks of, by the call that it belongs to.
_opened: dict[str, _luenberger.Blocks] = {}
_lock = threading.Lock()


def _compute(blocks: list[int], call: str, path: str, output: str, threads: int) -> tuple[int, int]:
    """On a worker: computes blocks. The study is read, and its observers are designed, once for each call of `sweep`."""
    with _lock:
        if call not in _opened:
            _opened.clear()
            _opened[call] = _luenberger.Blocks(_luenberger.StudyFile(path), output, None, False, True)
        opened = _opened[call]
    return opened.compute(blocks, threads, None)


def sweep(
    study: str | PathLike[str],
    client: Any,
    output: str | PathLike[str],
    *,
    block_size: int | None = None,
    threads: int = 1,
    retries: int = 10,
    restart: bool = False,
    progress: Callable[[int, int], Any] | None = None,
) -> Results:
    """Compute the sweep of a study on a Dask cluster.

    The workers write blocks of trajectories into the folder `output`, which they share with this process, as they do
    the study file. Blocks that are there are not computed again: after an interruption, call it again. The results are
    the same bytes as those of `luenberger sweep` in one process.

    Parameters
    ----------
    study : path-like
        The study file.
    client : distributed.Client
        The cluster.
    output : path-like
        The results folder.
    block_size : int, optional
        Runs of a block (default: a sixteenth of the ensemble, from 32 to 1000).
    threads : int, optional
        Threads of a task; 1 where a worker has a thread for each task.
    retries : int, optional
        How often a batch is submitted again after its worker has died.
    restart : bool, optional
        Delete the blocks that are there.
    progress : callable, optional
        `progress(done, total)`, the numbers of blocks; what it raises ends the sweep and comes through.

    Returns
    -------
    Results

    Raises
    ------
    StudyError
        The folder has the blocks of another study, or a batch could not be computed.

    Examples
    --------
    >>> import luenberger.distributed
    >>> from dask.distributed import Client, LocalCluster  # doctest: +SKIP
    >>> with LocalCluster(n_workers=2) as cluster, Client(cluster) as client:  # doctest: +SKIP
    ...     results = luenberger.distributed.sweep("study.toml", client, "results")
    """
    path, folder = str(Path(study).resolve()), str(Path(output).resolve())
    if retries < 0 or threads < 1:
        raise InvalidArgument(f"retries is {retries} and threads {threads}", hint="retries >= 0 and threads >= 1")
    opened = _luenberger.Blocks(_luenberger.StudyFile(path), folder, block_size, restart, False)
    total = opened.count()[0]
    missing = status(folder, verify=True)["missing"]
    del opened
    _run(client, missing, total, path, folder, threads, retries, progress)
    return reduce(folder)


def _run(
    client: Any,
    missing: list[int],
    total: int,
    path: str,
    folder: str,
    threads: int,
    retries: int,
    progress: Callable[[int, int], Any] | None,
) -> None:
    """Submits the blocks in batches until all are done."""
    dask: Any = importlib.import_module("distributed")
    lost = (dask.KilledWorker, importlib.import_module("distributed.client").FutureCancelledError)

    workers = max(sum(client.ncores().values()), 1)
    size = max(-(-len(missing) // (_BATCHES * workers)), 1)
    batches = [missing[k : k + size] for k in range(0, len(missing), size)]

    call = uuid.uuid4().hex

    def submit(batch: list[int]) -> Any:
        return client.submit(_compute, batch, call, path, folder, threads, pure=False, retries=0)

    open_batches: dict[Any, tuple[list[int], int]] = {submit(batch): (batch, 0) for batch in batches}
    done = total - len(missing)
    if progress is not None:
        progress(done, total)
    try:
        completed = dask.as_completed(list(open_batches))
        for future in completed:
            batch, deaths = open_batches.pop(future)
            error = future.exception() if future.status in ("error", "cancelled", "lost") else None
            if future.status == "finished":
                done += len(batch)
                if progress is not None:
                    progress(done, total)
            elif isinstance(error, lost) and deaths < retries:
                again = submit(batch)
                open_batches[again] = (batch, deaths + 1)
                completed.add(again)
            elif error is not None:
                raise StudyError(f"blocks {batch[0]} to {batch[-1]}: {error}") from error
            future.release()
    finally:
        client.cancel(list(open_batches))


def status(output: str | PathLike[str], *, verify: bool = False) -> dict[str, Any]:
    """How far the sweep in a results folder is.

    Parameters
    ----------
    output : path-like
        The results folder.
    verify : bool, optional
        Read each block; a faulty one counts as missing.

    Returns
    -------
    dict
        With `blocks`, `done`, `missing`, `running`, `faults`, `runs`, `done_runs`, `rate` and `remaining`.

    Examples
    --------
    >>> import luenberger.distributed
    >>> luenberger.distributed.status("results")["missing"]  # doctest: +SKIP
    []
    """
    found: dict[str, Any] = json.loads(_luenberger.status(Path(output), verify))
    return found


def reduce(output: str | PathLike[str], *, threads: int | None = None, force: bool = False) -> Results:
    """Reduce the blocks in a results folder to the results of the sweep, and write these beside them.

    Parameters
    ----------
    output : path-like
        The results folder.
    threads : int, optional
        Number of threads (default: that of the processors).
    force : bool, optional
        Use a folder that has other files.

    Returns
    -------
    Results

    Raises
    ------
    StudyError
        Blocks are missing or damaged.

    Examples
    --------
    >>> import luenberger.distributed
    >>> luenberger.distributed.reduce("results").sweep  # doctest: +SKIP
    """
    return results(_luenberger.reduce(Path(output), threads, force, None), [], [], [])
