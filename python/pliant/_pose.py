"""Poses of hands and states of tools, between Python and the native half."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

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


def as_pose(
    position: ArrayLike, rotation: Any, buttons: int | Iterable[int]
) -> tuple[tuple[float, ...], tuple[float, ...], int]:
    """A place, a turn and buttons as the native half takes them."""
    return as_place("position", position), as_rotation("rotation", rotation), as_mask(buttons)


def as_place(name: str, place: ArrayLike) -> tuple[float, ...]:
    """A place as the native half takes it; `name` is that of the argument."""
    given = np.asarray(place, dtype=np.float64)
    if given.shape != (3,):
        raise PliantError(f"{name} has the shape {given.shape}; allowed is (3,)")
    return tuple(given.tolist())


def as_rotation(name: str, rotation: Any) -> tuple[float, ...]:
    """A quaternion (x, y, z, w) of an argument called `name`; None is no turn."""
    if rotation is None:
        return (0.0, 0.0, 0.0, 1.0)
    quaternion = np.asarray(rotation.as_quat() if hasattr(rotation, "as_quat") else rotation, dtype=np.float64)
    if quaternion.shape != (4,):
        raise PliantError(f"{name} has the shape {quaternion.shape}; allowed is (4,), a quaternion (x, y, z, w)")
    return tuple(quaternion.tolist())


def as_mask(buttons: int | Iterable[int]) -> int:
    """Buttons as a number of which bit i is button i."""
    try:
        if isinstance(buttons, (int, np.integer)):
            mask = int(buttons)
        else:
            numbers = set(buttons)
            mask = sum(1 << button for button in numbers) if min(numbers, default=0) >= 0 else -1
    except TypeError:
        # Neither a number nor numbers.
        mask = -1
    if not 0 <= mask < 1 << 32:
        raise PliantError(f"buttons {buttons!r}; allowed are buttons 0 to 31")
    return mask


def tool_state(state: dict[str, Any]) -> ToolState:
    """A tool of what the native half says of it."""
    vectors = {key: np.array(state[key]) for key in ("hand", "proxy", "force", "device_force")}
    return ToolState(**(state | vectors))


ToolState.__module__ = "pliant"
