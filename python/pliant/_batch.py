"""Many sessions of one scene, stepped together."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._error import PliantError
from ._pose import as_pose
from ._scene import Scene, as_scene
from ._stepped import Stepped
from .catalogue import open_options


@dataclass(frozen=True)
class BatchTools:
    """A tool in every instance at the end of a step; NaN where an instance was lost.

    Attributes
    ----------
    hand, proxy : ndarray
        m (n x 3), where the hands are, and where the surfaces let the tools be.
    force : ndarray
        N (n x 3), on the hands.
    depth : ndarray
        m (n), how far the surfaces have gone in, or out.
    touches, holds : ndarray
        Whether a body is touched or held, and whether it is held on to (n).
    """

    hand: NDArray[np.float64]
    proxy: NDArray[np.float64]
    force: NDArray[np.float64]
    depth: NDArray[np.float64]
    touches: NDArray[np.bool_]
    holds: NDArray[np.bool_]


@dataclass(frozen=True)
class BatchTrace:
    """A tool in every instance and every step of a run.

    Attributes
    ----------
    hand : ndarray
        m (n x s x 3), where the hand was.
    depth : ndarray
        m (n x s), how far the surface had gone in, or out.
    force : ndarray
        N (n x s x 3), on the hand.
    """

    hand: NDArray[np.float64]
    depth: NDArray[np.float64]
    force: NDArray[np.float64]


@dataclass(frozen=True)
class BatchResult:
    """What a run of a batch came to; NaN where an instance was lost.

    Attributes
    ----------
    time : ndarray
        s (s), the end of each step.
    tools : dict of str to BatchTrace
        Every step of each tool, by its name.
    probes : dict of str to ndarray
        What was measured (n), by name.
    failures : dict of int to str
        What went wrong, by instance.
    """

    time: NDArray[np.float64]
    tools: dict[str, BatchTrace]
    probes: dict[str, NDArray[np.float64]]
    failures: dict[int, str]


class Batch(Stepped[_native.SessionBatch, BatchTools]):
    """Many sessions of one scene, each with parameters of its own, stepped together on all processors.

    Instances share their models, and each steps on one thread, so `n` should be several times the number of processors. Every instance does
    what a :class:`Session` of its own would, to the byte. The interpreter's lock is released while steps are taken.

    Parameters
    ----------
    scene : Scene, path or mapping
        What there is.
    n : int
        Number of instances.
    set : mapping, optional
        Values that all instances have, by their path in the scene, such as ``{"time.dt": "1 ms"}``.
    each : mapping, optional
        Values of each instance (n), by their path in the scene.
    jobs : int
        Instances that are stepped at a time; 0 takes what the machine has.
    plugin_path : iterable of path
        Folders that are searched for plugins first.
    allow_plugins : iterable of path
        Folders from which the scene may name libraries by path, which runs their code; none by default.

    Examples
    --------
    >>> import numpy as np, pliant
    >>> young = np.geomspace(5e3, 80e3, 64)
    >>> batch = pliant.Batch("scenes/touch.toml", 64, each={"body.0.material.params.young": young})  # doctest: +SKIP
    >>> result = batch.run()  # doctest: +SKIP
    >>> result.probes["largest force"].shape, result.tools["finger"].force.shape  # doctest: +SKIP
    ((64,), (64, 800, 3))
    """

    def __init__(
        self,
        scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
        n: int,
        *,
        set: Mapping[str, Any] | None = None,
        each: Mapping[str, Sequence[Any] | NDArray[Any]] | None = None,
        jobs: int = 0,
        plugin_path: Iterable[str | os.PathLike[str]] = (),
        allow_plugins: Iterable[str | os.PathLike[str]] = (),
    ) -> None:
        if n < 1 or jobs < 0:
            raise PliantError(f"n is {n} and jobs is {jobs}; allowed is 1 or more instances, and 0 or more at a time")
        given = {path: list(values) for path, values in (each or {}).items()}
        for path, values in given.items():
            if len(values) != n:
                raise PliantError(f"`{path}` has {len(values)} values; allowed is {n}, one for each instance")
        scene = as_scene(scene)
        self._count = n
        scenes = [
            scene._given({**(set or {}), **{path: values[number] for path, values in given.items()}})
            for number in range(n)
        ]
        options = open_options(
            threads=1, plugin_path=plugin_path, allow_plugins=allow_plugins, hands=scene._driven
        )
        with self._opening(scene):
            self._native = _native.SessionBatch(scenes, options, jobs)

    def __len__(self) -> int:
        return self._count

    @property
    def time(self) -> NDArray[np.float64]:
        """s (n), simulated time of each instance."""
        return self._native.times()[0]

    @property
    def steps(self) -> NDArray[np.uint64]:
        """Steps that each instance has taken (n)."""
        return self._native.times()[1]

    @property
    def failures(self) -> dict[int, str]:
        """What went wrong, by instance: a body that was frozen, a device that was lost, or a fault that ended the instance."""
        return {number: f"{kind}: {text}" for number, kind, text in self._native.failures()}

    def run(self) -> BatchResult:
        """Step every instance to the end of its scene.

        Returns
        -------
        BatchResult
            All instances must take as many steps, of the same length.
        """
        runs = self._native.run()
        self._raise_errors()
        times = [run["time"] for run in runs if len(run["time"])]
        time = times[0] if times else np.empty(0)
        if any(len(other) != len(time) or not np.array_equal(other, time) for other in times):
            raise PliantError("instances have steps of their own; allowed is one `time` for all, or Batch.step")
        names = next((list(run["tools"]) for run in runs if run["tools"]), [])
        probes = next((list(run["probes"]) for run in runs if run["probes"]), [])
        return BatchResult(
            time=time,
            tools={name: _stacked([run["tools"].get(name) for run in runs], len(time)) for name in names},
            probes={name: np.array([run["probes"].get(name, np.nan) for run in runs]) for name in probes},
            failures=self.failures,
        )

    def go(self, positions: ArrayLike, rotations: Any = None, buttons: int | Iterable[int] = 0, *, tool: str | None = None) -> None:
        """Put the hand of every instance somewhere, from the next step on.

        Parameters
        ----------
        positions : array_like
            m (n x 3), or (3) for all instances.
        rotations : array_like or Rotation, optional
            How the hands are turned: quaternions (x, y, z, w) as (n x 4), or (4) for all, or what has ``as_quat()``. Not turned by default.
        buttons : int or iterable of int
            The buttons that are pressed, of all instances, see :meth:`Hand.go`.
        tool : str, optional
            Name of their tool; the first tool by default.
        """
        places = np.asarray(positions, dtype=np.float64)
        if places.shape not in ((3,), (self._count, 3)):
            raise PliantError(f"positions have the shape {places.shape}; allowed is ({self._count}, 3), or (3,) for all")
        turns = np.array([0.0, 0.0, 0.0, 1.0])
        if rotations is not None:
            turns = np.asarray(rotations.as_quat() if hasattr(rotations, "as_quat") else rotations, dtype=np.float64)
        if turns.shape not in ((4,), (self._count, 4)):
            raise PliantError(f"rotations have the shape {turns.shape}; allowed is ({self._count}, 4), or (4,) for all")
        mask = as_pose(np.zeros(3), None, buttons)[2]
        count = self._count
        rows = np.broadcast_to(places, (count, 3)).tolist()
        self._native.place_hands(self._tool(tool), rows, np.broadcast_to(turns, (count, 4)).tolist(), [mask] * count)

    def leave(self, tool: str | None = None) -> None:
        """Take the hand of every instance away.

        Parameters
        ----------
        tool : str, optional
            Name of their tool; the first tool by default.
        """
        count = self._count
        self._native.place_hands(self._tool(tool), [None] * count, [(0.0, 0.0, 0.0, 1.0)] * count, [0] * count)

    def positions(self, body: str | None = None) -> NDArray[np.float64]:
        """Copy where the vertices of a body of every instance are.

        Parameters
        ----------
        body : str, optional
            Its name; the first body by default.

        Returns
        -------
        ndarray
            m (n x v x 3); NaN where an instance was lost. After cuts instances may differ in their vertices, which is an error.
        """
        body = self._body(body)
        arrays = self._native.positions(body)
        shapes = {array.shape for array in arrays if array is not None}
        if len(shapes) != 1:
            counts = sorted(shape[0] for shape in shapes)
            raise PliantError(f"body `{body}` has {counts} vertices in different instances; allowed is one number")
        lost = np.full(shapes.pop(), np.nan)
        return np.stack([lost if array is None else array for array in arrays])

    def _tool_state(self, given: dict[str, Any]) -> BatchTools:
        return BatchTools(**given)

    def __repr__(self) -> str:
        return f"<batch of {self._count} sessions>"


def _stacked(traces: list[Any], steps: int) -> BatchTrace:
    lost = {"hand": np.full((steps, 3), np.nan), "depth": np.full(steps, np.nan), "force": np.full((steps, 3), np.nan)}
    return BatchTrace(**{key: np.stack([(trace or lost)[key] for trace in traces]) for key in lost})


for _public in (BatchTools, BatchTrace, BatchResult, Batch):
    _public.__module__ = "pliant"
