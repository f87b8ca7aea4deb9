"""A session that goes on by the clock, for user interfaces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._pose import ToolState, as_pose, tool_state


@dataclass(frozen=True)
class UsedPose:
    """A pose of a hand, as a step used it.

    Attributes
    ----------
    time : float
        s, the end of the step.
    tool : str
        The tool it holds.
    position : tuple of float
        m (3), in the scene.
    rotation : tuple of float
        Quaternion (x, y, z, w).
    buttons : int
        Bit i is button i.
    """

    time: float
    tool: str
    position: tuple[float, ...]
    rotation: tuple[float, ...]
    buttons: int


@dataclass(frozen=True)
class Poses:
    """Poses of hands in steps, as arrays; iterating gives them one by one.

    Attributes
    ----------
    time : ndarray
        s (n), the end of each step.
    tool : ndarray
        Name of the tool (n).
    position : ndarray
        m (n x 3), in the scene.
    rotation : ndarray
        Quaternions (n x 4): x, y, z, w.
    buttons : ndarray
        Bit i is button i (n).
    """

    time: NDArray[np.float64]
    tool: NDArray[np.str_]
    position: NDArray[np.float64]
    rotation: NDArray[np.float64]
    buttons: NDArray[np.uint32]

    def __len__(self) -> int:
        return len(self.time)

    def __iter__(self) -> Iterator[UsedPose]:
        rows = zip(
            self.time.tolist(),
            self.tool.tolist(),
            map(tuple, self.position.tolist()),
            map(tuple, self.rotation.tolist()),
            self.buttons.tolist(),
            strict=True,
        )
        return (UsedPose(*row) for row in rows)


class Live:
    """A session under way by the clock, on a native thread; :meth:`Session.play` makes one.

    Steps are taken without the interpreter: a user interface sends hands somewhere, and sixty times a second copies the newest positions. Until
    :meth:`stop`, the session itself is busy. As a context manager it is stopped at the end.
    """

    def __init__(self, live: _native.Live) -> None:
        self._native = live

    def go(self, tool: str, position: ArrayLike, rotation: Any = None, buttons: int | Iterable[int] = 0) -> None:
        """Send the hand of a tool somewhere; it glides there until the next frame.

        Parameters
        ----------
        tool : str
            The tool.
        position, rotation, buttons
            As of :meth:`Hand.go`.
        """
        self._native.place_hand(tool, *as_pose(position, rotation, buttons))

    def leave(self, tool: str) -> None:
        """Take the hand of a tool away.

        Parameters
        ----------
        tool : str
            The tool.
        """
        self._native.place_hand(tool, None, (0.0, 0.0, 0.0, 1.0), 0)

    def read(self, body: str, out: NDArray[np.float32], matrix: ArrayLike | None = None) -> int:
        """Copy the newest positions of a body.

        Parameters
        ----------
        body : str
            A body that moves.
        out : ndarray
            m (n x 3), float32 and contiguous; gets as many positions as it has rows.
        matrix : array_like, optional
            An affine map (3 x 4 or 4 x 4) of positions, such as into the axes of an object.

        Returns
        -------
        int
            Number of the view that was copied; 0 if there is none yet, and `out` stays as it is.
        """
        rows = None if matrix is None else np.asarray(matrix, dtype=np.float32)[:3].tolist()
        return self._native.read(body, out, rows)

    def tool(self, tool: str) -> ToolState:
        """Read a tool as it was in the newest view.

        Parameters
        ----------
        tool : str
            The tool.

        Returns
        -------
        ToolState
        """
        return tool_state(self._native.tool(tool))

    def triangle_count(self, body: str) -> int:
        """Count the triangles of a body in the newest view, as many as :meth:`Session.triangles` has.

        Another number than before says that the body was cut or broke, as elements of `quasi-brittle` and `tearing` that fail.

        Parameters
        ----------
        body : str
            A body that moves.

        Returns
        -------
        int
            0 before the first view.
        """
        return self._native.triangle_count(body)

    def pinned(self, body: str) -> NDArray[np.uint32]:
        """List the vertices that strokes hold in the newest view, as :meth:`Session.pinned`.

        Parameters
        ----------
        body : str
            A body that moves.

        Returns
        -------
        ndarray
            Vertices, ascending.
        """
        return self._native.pinned(body)

    def painted(self, body: str, param: str = "young") -> tuple[NDArray[np.uint32], NDArray[np.float64]]:
        """List the vertices whose parameter strokes have painted in the newest view, as :meth:`Session.painted`.

        Parameters
        ----------
        body : str
            A body that moves.
        param : str
            The parameter.

        Returns
        -------
        vertices : ndarray
            Vertices, ascending.
        factors : ndarray
            Factor of the parameter at each.
        """
        return self._native.painted(body, param)

    def wait(self, seen: int = 0, seconds: float = 1.0) -> int:
        """Wait for a view.

        Parameters
        ----------
        seen : int
            Number of the view that is known.
        seconds : float
            s, how long to wait at most.

        Returns
        -------
        int
            Number of the newest view; `seen` if no newer one came.
        """
        return self._native.wait(seen, seconds)

    @property
    def time(self) -> float:
        """s, simulated time of the newest view."""
        return self._native.state()[1]

    @property
    def lost_time(self) -> float:
        """s, simulated time that was given up because steps take longer than the time they simulate."""
        return self._native.state()[2]

    @property
    def is_alive(self) -> bool:
        """Whether it goes on; a fault of the program ends it."""
        return self._native.state()[3]

    def take_poses(self) -> Poses:
        """Take where hands were in every step since it began, or since the last call; they are kept until somebody takes them.

        Returns
        -------
        Poses
        """
        return self._poses(self._native.take_poses())

    def stop(self) -> list[UsedPose]:
        """Stop; the session goes on step by step.

        Returns
        -------
        list of UsedPose
            Where hands were in every step since it began, or since :meth:`take_poses`, for making the same again.
        """
        return list(self._poses(self._native.stop()))

    def _poses(self, arrays: _native._PoseArrays) -> Poses:
        """Poses of what the native half gives."""
        time, tool, position, rotation, buttons = arrays
        names = np.array(self._native.tools, dtype=np.str_)
        return Poses(time, names[tool], position, rotation, buttons)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()


for _public in (UsedPose, Poses, Live):
    _public.__module__ = "pliant"
