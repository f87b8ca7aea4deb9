"""Hands and the tools they hold."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._error import PliantError


@dataclass(frozen=True)
class ToolState:
    """A tool at the end of a step.

    Attributes
    ----------
    hand : ndarray
        m (3), where the hand is.
    proxy : ndarray
        m (3), where the surface lets the tool be.
    contact : str or None
        The body it touches or holds.
    holds : bool
        Whether it holds on.
    depth : float
        m, how far the surface has gone in, or out.
    force : ndarray
        N (3), on the hand, in the scene.
    device_force : ndarray
        N (3), what the device was given, in its own axes.
    """

    hand: NDArray[np.float64]
    proxy: NDArray[np.float64]
    contact: str | None
    holds: bool
    depth: float
    force: NDArray[np.float64]
    device_force: NDArray[np.float64]


class Hand:
    """The hand that holds a tool, to be moved by the caller; see :meth:`Session.hand`."""

    def __init__(self, session: _native.Session, tool: str) -> None:
        self._session = session
        self._tool = tool

    def go(self, position: ArrayLike, rotation: Any = None, buttons: int | Iterable[int] = 0) -> None:
        """Put the hand somewhere, from the next step on.

        A tool is followed at its ``speed`` at most, 2 m/s by default, so a long way takes several steps.

        Parameters
        ----------
        position : array_like
            m (3), in the scene.
        rotation : array_like or Rotation, optional
            How the hand is turned: a quaternion (x, y, z, w), or what has ``as_quat()``, as scipy's ``Rotation``. Not turned by default.
        buttons : int or iterable of int
            The buttons that are pressed: their numbers from 0, or one number of which bit i is button i.
        """
        self._session.place_hand(self._tool, *as_pose(position, rotation, buttons))

    def leave(self) -> None:
        """Take the hand away: its tool lets go of everything."""
        self._session.place_hand(self._tool, None, (0.0, 0.0, 0.0, 1.0), 0)

    def __repr__(self) -> str:
        return f"<hand of tool `{self._tool}`>"


def as_pose(
    position: ArrayLike, rotation: Any, buttons: int | Iterable[int]
) -> tuple[tuple[float, ...], tuple[float, ...], int]:
    """A place, a turn and buttons as the native half takes them."""
    place = np.asarray(position, dtype=np.float64)
    if place.shape != (3,):
        raise PliantError(f"position has the shape {place.shape}; allowed is (3,)")
    turn: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)
    if rotation is not None:
        quaternion = np.asarray(rotation.as_quat() if hasattr(rotation, "as_quat") else rotation, dtype=np.float64)
        if quaternion.shape != (4,):
            raise PliantError(f"rotation has the shape {quaternion.shape}; allowed is (4,), a quaternion (x, y, z, w)")
        turn = tuple(quaternion.tolist())
    if isinstance(buttons, (int, np.integer)):
        mask = int(buttons)
    else:
        numbers = set(buttons)
        mask = sum(1 << button for button in numbers) if min(numbers, default=0) >= 0 else -1
    if not 0 <= mask < 1 << 32:
        raise PliantError(f"buttons {buttons!r}; allowed are buttons 0 to 31")
    return tuple(place.tolist()), turn, mask


def tool_state(state: dict[str, Any]) -> ToolState:
    """A tool of what the native half says of it."""
    vectors = {key: np.array(state[key]) for key in ("hand", "proxy", "force", "device_force")}
    return ToolState(**(state | vectors))


for _public in (ToolState, Hand):
    _public.__module__ = "pliant"
