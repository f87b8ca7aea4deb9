"""Sweeps: many runs of scripted scenes into one table, on this machine or on a cluster of Dask.

A sweep is a file in TOML that says what varies, see ``docs/batch.md``; ``pliant batch`` does the same. What was done is in a folder, and is not
done again: a run that was stopped goes on where it was.

Examples
--------
>>> import pliant.batch
>>> table = pliant.batch.run("scenes/sweeps/touch.toml", "out/sweep")  # doctest: +SKIP
>>> table["young"], table["largest_force"]  # doctest: +SKIP
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._error import PliantError
from .catalogue import _PLUGINS

__all__ = ["Table", "collect", "map", "run", "run_shard", "size"]

_Path = str | os.PathLike[str]
#: Shards for each thread of a cluster: few enough that each has many runs to share its models, enough that the last ones end together.
_SHARDS_PER_THREAD = 4


class Table(Mapping[str, NDArray[Any]]):
    """Results of a sweep: an array for each column, a row for each run, in the order of the sweep.

    Numbers are float64, with NaN in empty cells; columns without empty cells of whole numbers or truths are int64 or bool; texts and lists are
    objects, with None in empty cells.

    Attributes
    ----------
    units : dict of str to str
        The unit of each column, empty where there is none.
    edits : int
        Number of runs of the sweep.
    failed : int
        Number of rows that say that their run failed.
    missing : dict of str to int
        Edits without a row, by shard.
    """

    units: dict[str, str]
    edits: int
    failed: int
    missing: dict[str, int]

    def __init__(self, collected: Mapping[str, Any]) -> None:
        self.edits = collected["edits"]
        self.failed = collected["failed"]
        self.missing = collected["missing"]
        self.units = {column["name"]: column["unit"] for column in collected["columns"]}
        rows = collected["rows"]
        self._length = len(rows)
        self._columns = {
            column["name"]: _array([row[place] for row in rows], column["kind"])
            for place, column in enumerate(collected["columns"])
        }

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self._length

    def __repr__(self) -> str:
        return f"<table of {self._length} of {self.edits} runs, {self.failed} failed: {', '.join(self)}>"


def size(sweep: _Path) -> int:
    """Count the runs of a sweep.

    Parameters
    ----------
    sweep : path
        The sweep file.

    Returns
    -------
    int
    """
    return _native.batch_size(os.fspath(sweep))


def run_shard(
    sweep: _Path,
    out: _Path,
    shard: str = "1/1",
    *,
    jobs: int = 0,
    retry_failed: bool = False,
    isolate: bool = False,
    plugin_path: Iterable[_Path] = (),
    allow_plugins: Iterable[_Path] = (),
    progress: Callable[[int, int, int], object] | None = None,
) -> dict[str, Any]:
    """Do what is missing of a shard of a sweep.

    Parameters
    ----------
    sweep : path
        The sweep file.
    out : path
        The folder of the results.
    shard : str
        ``"I/N"``: runs whose place in the sweep, modulo N, is I - 1.
    jobs : int
        Edits at a time; 0 takes what the machine has. No more run than there are processors, and than fit into three quarters of the machine's memory.
    retry_failed : bool
        Whether failed runs are done again.
    isolate : bool
        Whether each run has a child process; those with a limit of memory always do.
    plugin_path : iterable of path
        Folders that are searched for plugins first.
    allow_plugins : iterable of path
        Folders from which scenes may name libraries by path, which runs their code; none by default.
    progress : callable, optional
        Gets the number of runs that are done, of those that failed, and of all, several times a second.

    Returns
    -------
    dict
        How it went: ``edits``, ``done``, ``failed``, ``new``, ``elapsed`` (s), and so on.
    """
    if jobs < 0:
        raise PliantError(f"jobs is {jobs}; allowed is 0 for what the machine has, or more")
    folders = [[os.fspath(folder) for folder in given] for given in (plugin_path, allow_plugins)]
    options = _options(shard, jobs, *folders) | {"retry_failed": retry_failed, "isolate": isolate}
    words = json.dumps([os.fspath(sweep), os.fspath(out), shard, *folders])
    options["child"] = [sys.executable, "-c", "import sys, pliant.batch; pliant.batch._serve(sys.argv[1])", words]
    end: dict[str, Any] = json.loads(_native.batch_run(os.fspath(sweep), os.fspath(out), options, progress))
    return end


def run(sweep: _Path, out: _Path | None = None, **options: Any) -> Table:
    """Do what is missing of a sweep on this machine.

    Parameters
    ----------
    sweep : path
        The sweep file.
    out : path, optional
        The folder of the results; by default ``out`` with the name of the sweep below it.
    **options
        Those of :func:`run_shard` but for the shard.

    Returns
    -------
    Table
    """
    folder = _folder(sweep, out)
    run_shard(sweep, folder, **options)
    return collect(folder)


def map(
    client: Any,
    sweep: _Path,
    out: _Path | None = None,
    *,
    shards: int | None = None,
    retries: int = 3,
    plugin_path: Iterable[_Path] = (),
    allow_plugins: Iterable[_Path] = (),
) -> Table:
    """Do what is missing of a sweep on a cluster of Dask.

    Each task is a shard, on one thread. All workers see the same folders. A task whose worker dies goes on where it was on another one.

    Parameters
    ----------
    client : dask.distributed.Client
        The cluster.
    sweep : path
        The sweep file.
    out : path, optional
        The folder of the results; by default ``out`` with the name of the sweep below it.
    shards : int, optional
        Into how many parts the sweep is cut: by default as many as the folder has already, or four for each thread of the cluster.
    retries : int
        How often a shard is tried again whose worker raised an exception.
    plugin_path : iterable of path
        Folders that are searched for plugins first.
    allow_plugins : iterable of path
        Folders from which scenes may name libraries by path, which runs their code; none by default.

    Returns
    -------
    Table
    """
    folder = Path(_folder(sweep, out)).absolute()
    edits = size(sweep)
    if shards is None:
        threads = sum(client.nthreads().values())
        shards = _shards_in(folder) or max(1, min(edits, _SHARDS_PER_THREAD * max(1, threads)))
    if shards < 1:
        raise PliantError(f"shards is {shards}; allowed is 1 or more")
    given = {
        "jobs": 1,
        "plugin_path": [os.path.abspath(folder) for folder in plugin_path],
        "allow_plugins": [os.path.abspath(folder) for folder in allow_plugins],
    }
    names = [f"{number}/{shards}" for number in range(1, shards + 1)]
    path = os.path.abspath(sweep)
    # Not pure: what a shard does depends on the folder, so a task of before must not stand for it.
    tasks = [
        client.submit(run_shard, path, str(folder), name, key=f"pliant-{name}-{os.urandom(8).hex()}", retries=retries, pure=False, **given)
        for name in names
    ]
    client.gather(tasks)
    return collect(folder)


def collect(*folders: _Path, output: _Path | None = None, mixed: bool = False, timings: bool = False) -> Table:
    """Merge shards to one table.

    Parameters
    ----------
    *folders : path
        Folders with shards of one sweep.
    output : path, optional
        A file for the table: ``.csv`` or ``.jsonl``.
    mixed : bool
        Whether shards of different versions may come together; a column then says which.
    timings : bool
        Whether there are columns of where the time went.

    Returns
    -------
    Table
    """
    file = None if output is None else os.fspath(output)
    return Table(json.loads(_native.batch_collect([os.fspath(folder) for folder in folders], file, mixed, timings)))


def _folder(sweep: _Path, out: _Path | None) -> str:
    return os.fspath(out) if out is not None else os.path.join("out", Path(sweep).stem)


def _shards_in(folder: Path) -> int | None:
    """Number of shards that a folder was begun with; `None` for a new one."""
    found = {int(match[1]) for path in folder.glob("*.journal") if (match := re.fullmatch(r"shard-\d+-of-(\d+)", path.stem))}
    return found.pop() if len(found) == 1 else None


def _options(shard: str, jobs: int, plugin_path: list[str], allow_plugins: list[str]) -> dict[str, Any]:
    """How a shard is run, as the native half takes it."""
    return {
        "shard": shard,
        "jobs": jobs,
        "resume": True,
        "retry_failed": False,
        "isolate": False,
        "plugin_path": plugin_path,
        "allow_plugins": allow_plugins,
        "package_plugins": _PLUGINS,
        "child": [],
    }


def _array(cells: list[Any], kind: str) -> NDArray[Any]:
    """The cells of a column as an array."""
    whole = {"integer": np.int64, "flag": np.bool_}.get(kind)
    if whole is not None and None not in cells:
        return np.array(cells, dtype=whole)
    if kind in ("number", "integer", "flag"):
        return np.array([np.nan if cell is None else cell for cell in cells], dtype=np.float64)
    array = np.empty(len(cells), dtype=object)
    for place, cell in enumerate(cells):
        array[place] = np.asarray(cell, dtype=np.float64) if isinstance(cell, list) else cell
    return array


def _serve(words: str) -> None:
    """Execute runs as the child process of a batch."""
    sweep, out, shard, plugin_path, allow_plugins = json.loads(words)
    _native.batch_serve(sweep, out, _options(shard, 1, plugin_path, allow_plugins))
