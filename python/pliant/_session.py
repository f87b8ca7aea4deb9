"""A scene, opened and stepped by the caller."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._device_hand import stop_devices_of
from ._error import PliantError
from ._hand import Hand
from ._live import Live
from ._pose import ToolState, tool_state
from ._positions import Positions
from ._result import Mesh
from ._scene import Scene, as_scene
from ._stepped import Stepped
from ._warning import PliantWarning, warn
from .catalogue import open_options

Snapshot = _native.Snapshot


@dataclass(frozen=True)
class Frame:
    """Figures of a step.

    Attributes
    ----------
    time : float
        s, simulated.
    nodes, elements : int
        Nodes and elements that were active.
    kinetic_energy, elastic_energy : float
        J; 0 where neither the output nor a probe asks for them.
    substeps, iterations : int
        Substeps of each body, and iterations of all solves.
    residual : float
        The largest final relative residual.
    seconds : float
        s, wall clock, of the step.
    """

    time: float
    nodes: int
    elements: int
    kinetic_energy: float
    elastic_energy: float
    substeps: int
    iterations: int
    residual: float
    seconds: float


class Session(Stepped[_native.Session, ToolState]):
    """A scene, opened: bodies, tools and plugins, stepped by the caller.

    A session is used by one thread at a time; another one that tries gets a :class:`PliantError` of kind ``"busy"``. The interpreter's lock is
    released while steps are taken, so sessions on different threads run at once. As a context manager it is closed at the end.

    Parameters
    ----------
    scene : Scene, path or mapping
        What there is.
    set : mapping, optional
        Values by their path in the scene, such as ``{"body.0.material.params.young": "40 kPa"}``.
    mesh : path, optional
        Another model in the place of the first body's, scaled to fit.
    threads : int
        Threads for its steps; 0 takes what the machine has. Results are the same bytes for any number.
    history : bool
        Whether edits can be taken back with :meth:`undo`.
    plugin_path : iterable of path
        Folders that are searched for plugins first.
    allow_plugins : iterable of path
        Folders from which the scene may name libraries by path, which runs their code; none by default.

    Examples
    --------
    >>> with pliant.Session("scenes/touch.toml") as session:  # doctest: +SKIP
    ...     session.step(300)
    ...     print(session.force("finger"), session.positions("elephant").shape)
    """

    def __init__(
        self,
        scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
        *,
        set: Mapping[str, Any] | None = None,
        mesh: str | os.PathLike[str] | None = None,
        threads: int = 0,
        history: bool = True,
        plugin_path: Iterable[str | os.PathLike[str]] = (),
        allow_plugins: Iterable[str | os.PathLike[str]] = (),
    ) -> None:
        scene = as_scene(scene)
        options = open_options(
            threads=threads,
            plugin_path=plugin_path,
            allow_plugins=allow_plugins,
            mesh=mesh,
            hands=scene._driven,
            history=history,
        )
        self._warned = 0
        with self._opening(scene):
            self._native = _native.Session(scene._given(set or {}), options)
        rows = self._warning_rows()
        self._warned = len(rows)
        warn(rows, stacklevel=2)

    def play(self) -> Live:
        """Go on by the clock, on a native thread, until the result is stopped; until then the session itself is busy.

        Returns
        -------
        Live
        """
        return Live(self._native.play())

    def close(self) -> None:
        """End the session, and warn of edits that had no effect. A device that has a hand is closed first. Arrays made of its positions stay as they are."""
        self._end()

    def warnings(self) -> list[PliantWarning]:
        """List what in the scene has no effect, or not the one it looks like.

        Warnings of opening the scene are issued when it is opened, others when the session is closed.

        Returns
        -------
        list of PliantWarning
            Those of models and selections, then those of edits so far.
        """
        return [PliantWarning(row["message"], row["code"], row["where"]) for row in self._warning_rows()]

    def __enter__(self) -> Session:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    @property
    def time(self) -> float:
        """s, simulated time."""
        return self._native.time

    @property
    def dt(self) -> float:
        """s, one step."""
        return self._native.dt

    @property
    def steps(self) -> int:
        """Number of steps taken since the start."""
        return self._native.steps

    @property
    def planned_steps(self) -> int:
        """Steps of the scene's duration; a session may take more."""
        return self._native.planned_steps

    @property
    def frame(self) -> Frame:
        """Figures of the last step."""
        return Frame(**self._native.frame())

    def positions(self, body: str | None = None) -> Positions:
        """See where the vertices of a body are.

        Parameters
        ----------
        body : str, optional
            Its name; the first body by default.

        Returns
        -------
        Positions
            A read-only view (n x 3), m, without a copy, valid until the next step.
        """
        return Positions(self._native, self._body(body))

    def rest_positions(self, body: str | None = None) -> NDArray[np.float64]:
        """Copy where the vertices of a body are in the shape it was handed in.

        Parameters
        ----------
        body : str, optional
            Its name; the first body by default.

        Returns
        -------
        ndarray
            m (n x 3).
        """
        return self._native.rest_positions(self._body(body))

    def triangles(self, body: str | None = None) -> NDArray[np.uint32]:
        """Copy the visible triangles of a body; a cut and elements that fail change them.

        Parameters
        ----------
        body : str, optional
            Its name; the first body by default.

        Returns
        -------
        ndarray
            Vertices (m x 3), counter-clockwise seen from outside.
        """
        return self._native.triangles(self._body(body))

    def mesh(self, body: str | None = None) -> Mesh:
        """Copy the mesh of a body as it is now.

        Parameters
        ----------
        body : str, optional
            Its name; the first body by default.

        Returns
        -------
        Mesh
        """
        name = self._body(body)
        return Mesh(self._native.positions(name).copy(), self._native.triangles(name), self._native.face_of(name))

    def pinned(self, body: str | None = None) -> NDArray[np.uint32]:
        """List the vertices that strokes of ``pin`` hold, without those that the scene fixes.

        Parameters
        ----------
        body : str, optional
            Its name; the first body by default.

        Returns
        -------
        ndarray
            Vertices, ascending.
        """
        return self._native.pinned(self._body(body))

    def painted(self, body: str | None = None, param: str = "young") -> tuple[NDArray[np.uint32], NDArray[np.float64]]:
        """List the vertices where strokes of ``paint`` have changed a parameter of the material.

        Parameters
        ----------
        body : str, optional
            Its name; the first body by default.
        param : str
            The parameter.

        Returns
        -------
        vertices : ndarray
            Vertices, ascending.
        factors : ndarray
            Factor of the parameter at each, over what the scene gives: of a solid that of the cell there, of a sheet the geometric mean of the triangles around it.
        """
        return self._native.painted(self._body(body), param)

    def nodes(self, body: str | None = None) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Copy the simulated nodes of a body.

        Parameters
        ----------
        body : str, optional
            Its name; the first body by default.

        Returns
        -------
        places : ndarray
            m (k x 3).
        velocities : ndarray
            m/s (k x 3).
        masses : ndarray
            kg (k).
        """
        return self._native.nodes(self._body(body))

    def write(self, path: str | os.PathLike[str], body: str | None = None) -> None:
        """Write the model of a body as an OBJ file: moved vertices change, all else stays byte for byte.

        Parameters
        ----------
        path : path
            The file.
        body : str, optional
            Its name; the first body by default.
        """
        self._native.write(self._body(body), os.fspath(path))

    def hand(self, tool: str | None = None) -> Hand:
        """Take hold of the hand of a tool; from its first :meth:`Hand.go` on, its device no longer moves it.

        Parameters
        ----------
        tool : str, optional
            Name of the tool; the first tool by default.

        Returns
        -------
        Hand
        """
        return Hand(self._native, self._tool(tool))

    def cut(self, path: ArrayLike, *, tool: str | None = None, rotation: Any = None, button: int = 0) -> int:
        """Move the hand of a knife along a path, with a button pressed, and take it away.

        Parameters
        ----------
        path : array_like
            m (k x 3), places of the blade's tip, one for each step.
        tool : str, optional
            The tool with the blade; the first tool by default.
        rotation : array_like or Rotation, optional
            How the hand is turned, see :meth:`Hand.go`.
        button : int
            The button that is pressed.

        Returns
        -------
        int
            Edits that can be taken back now, more than before if something was cut.
        """
        places = np.asarray(path, dtype=np.float64)
        if places.ndim != 2 or places.shape[1] != 3:
            raise PliantError(f"path has the shape {places.shape}; allowed is (k x 3)")
        hand = self.hand(tool)
        for place in places:
            hand.go(place, rotation, [button])
            self.step()
        hand.go(places[-1], rotation)
        self.step()
        hand.leave()
        return self.history[0]

    def undo(self) -> bool:
        """Take back the last cut, or the last edit whose shape was kept.

        Returns
        -------
        bool
            Whether there was one.
        """
        return self._native.undo()

    def redo(self) -> bool:
        """Make again what was taken back last.

        Returns
        -------
        bool
            Whether there was anything.
        """
        return self._native.redo()

    def split(self, body: str, *, triangle: int | None = None) -> list[str]:
        """Make the parts of a body bodies of their own, as after a cut right through it.

        Each part keeps its shape, motion, rest shape, pins, paint, fields and history, and moves on alone; :meth:`undo` makes
        them one body again. The largest part keeps the name and what refers to it. ``positions()`` of a part has the rows of
        all vertices of the whole, of which ``triangles()`` uses those of the part; :meth:`write` writes the part alone.

        Parameters
        ----------
        body
            Name of a body that moves: a solid in a grid or a sheet, in several parts.
        triangle
            Row of ``triangles()`` in the part that leaves the body; the others stay together. Each part becomes a body without it.

        Returns
        -------
        list of str
            Names of the bodies that it is now, the largest part (or what is left) first.

        Raises
        ------
        PliantError
            For a body that is in one part, that stands still, whose elements have failed, or that is a tetrahedral mesh.
        """
        return self._native.split(body, triangle)

    @property
    def history(self) -> tuple[int, int]:
        """Edits that can be taken back, and that can be made again."""
        return self._native.history

    def snapshot(self) -> Snapshot:
        """Keep all bodies as they are now, with their motion and the time.

        Returns
        -------
        Snapshot
            For :meth:`restore`. What tools hold is not in it.
        """
        return self._native.snapshot()

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a snapshot of this session. Tools let go, and edits before can no longer be taken back.

        Parameters
        ----------
        snapshot : Snapshot
            What :meth:`snapshot` gave.
        """
        self._native.restore(snapshot)

    def plan(self) -> dict[str, Any]:
        """Say what a run will do: integrator and why, step limits, plugins, what is left out and why, costs.

        Returns
        -------
        dict
            What ``pliant plan --json`` prints.
        """
        plan: dict[str, Any] = json.loads(self._native.plan())
        return plan

    def events(self) -> dict[str, Any]:
        """Tell what happened besides what was asked for.

        Returns
        -------
        dict
            ``counts`` by kind, and ``described``: the first of each kind with kind, time and text.
        """
        events: dict[str, Any] = json.loads(self._native.events())
        return events

    def _tool_state(self, given: dict[str, Any]) -> ToolState:
        return tool_state(given)

    def _warning_rows(self) -> list[dict[str, Any]]:
        """Warnings so far, as the native half gives them."""
        rows: list[dict[str, Any]] = json.loads(self._native.warnings())
        return rows

    def _end(self) -> None:
        try:
            stop_devices_of(self._native)
        finally:
            self._close()

    def _close(self) -> None:
        try:
            # One that is closed, goes on elsewhere or belongs to another process tells nothing.
            rows = self._warning_rows()[self._warned :]
        except PliantError:
            rows = []
        self._native.close()
        self._warned += len(rows)
        warn(rows, stacklevel=4)

    def __repr__(self) -> str:
        if self._native.closed:
            return "<session, closed>"
        return f"<session of {', '.join(self.bodies)} at {self.time:.4g} s>"


for _public in (Frame, Session):
    _public.__module__ = "pliant"
