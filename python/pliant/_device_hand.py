"""Hands that a haptic device has."""

from __future__ import annotations

import atexit
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias, TypedDict
from weakref import WeakSet

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._error import PliantError
from ._live import Live, UsedPose
from ._pose import as_mask, as_place, as_rotation

# Buttons of the scene for none, the first and another of the device.
Buttons: TypeAlias = tuple[int | Iterable[int], int | Iterable[int], int | Iterable[int]]


class GivenWish(TypedDict):
    """What is asked of a device; None for what stays as it is, or for the default."""

    # m (3), what the middle of the device's workspace shows
    centre: tuple[float, ...] | None
    # From axes of the picture to those of the scene: a quaternion (x, y, z, w).
    rotation: tuple[float, ...] | None
    # Masks of buttons of the scene for none, the first and another of the device.
    buttons: tuple[int, int, int] | None
    # Share of the force, 0 to 1.
    force_share: float | None


@dataclass(frozen=True)
class DeviceState:
    """The hand of a device at its last tick.

    Attributes
    ----------
    status : str
        ``"ready"``: it gives poses. ``"waiting"``: it gives none now, as a pen out of reach, and the hand is away. ``"lost"``: it failed and gives none
        any more; the hand is the caller's again.
    reason : str or None
        Why it was lost.
    position : ndarray or None
        m (3), in the scene; None without a pose.
    rotation : ndarray or None
        Quaternion (x, y, z, w) in the scene; None without a pose.
    buttons : int
        Buttons of the scene that are pressed: bit i is button i.
    in_stroke : bool
        Whether a stroke is under way: buttons of the scene are pressed by one of the device. The view is followed again when it has ended.
    strokes : int
        How many strokes have begun.
    force : ndarray
        N (3), what the device was given, in its own axes.
    force_limit : float
        N, the most it may be given; a device that renders none states one too, for the stiffness it asks for.
    length_scale : float
        Displacement in the scene for one of the device.
    """

    status: str
    reason: str | None
    position: NDArray[np.float64] | None
    rotation: NDArray[np.float64] | None
    buttons: int
    in_stroke: bool
    strokes: int
    force: NDArray[np.float64]
    force_limit: float
    length_scale: float


class DeviceHand(Live):
    """A session under way in real time, one of whose hands a haptic device has; :meth:`Hand.follow` makes one.

    It is a :class:`Live`: positions and tools are read while native threads go on. Stopping it, closing its session, losing the last reference to it, leaving
    its ``with`` block and ending the interpreter close the device before anything else. A device that is lost gives the hand back: the session goes on, and
    :meth:`Live.go` moves the hand.
    """

    def __init__(self, session: _native.Session, live: _native.Live, device: str) -> None:
        super().__init__(live)
        self._session, self._device = session, device
        _running.add(self)

    def guide(
        self,
        *,
        view: Any = None,
        centre: ArrayLike | None = None,
        buttons: Buttons | None = None,
        force_share: float | None = None,
    ) -> None:
        """Change what was given to :meth:`Hand.follow`; what is not given stays as it is.

        View, centre and buttons are followed as soon as no stroke is under way, and the hand gets to a new view within a tenth of a second.

        Parameters
        ----------
        view, centre, buttons, force_share
            As of :meth:`Hand.follow`.
        """
        self._native.guide(as_wish(view, centre, buttons, force_share))

    @property
    def device(self) -> str:
        """Plugin of the device."""
        return self._device

    @property
    def state(self) -> DeviceState:
        """Hand, force and status of the device in the newest view."""
        given = self._native.hand()
        if not given:
            return DeviceState("waiting", None, None, None, 0, False, 0, np.zeros(3), 0.0, 0.0)
        reason = given.pop("lost")
        vectors = {key: None if given[key] is None else np.array(given[key]) for key in ("position", "rotation", "force")}
        status = "lost" if reason else "waiting" if vectors["position"] is None else "ready"
        return DeviceState(status=status, reason=reason, **(given | vectors))

    def pause(self) -> list[UsedPose]:
        """Stop, and leave the device open for another session.

        The haptic thread goes on and what the device feels fades within 150 ms, until :meth:`Hand.follow` of another session is given this hand. :meth:`stop`
        closes the device.

        Returns
        -------
        list of UsedPose
            As of :meth:`Live.stop`.
        """
        return list(self._poses(self._native.stop(keep_device=True)))

    def stop(self) -> list[UsedPose]:
        """Close the device and stop; the session goes on step by step, with the hand away.

        Returns
        -------
        list of UsedPose
            As of :meth:`Live.stop`.
        """
        _running.discard(self)
        poses = super().stop()
        self._native.close_kept()
        return poses


# Devices that are open.
_running: WeakSet[DeviceHand] = WeakSet()


def stop_devices_of(session: _native.Session) -> None:
    """Close the device that has a hand of a session, if one has."""
    for hand in list(_running):
        if hand._session is session:
            hand.stop()


def as_wish(view: Any, centre: ArrayLike | None, buttons: Buttons | None, force_share: float | None) -> GivenWish:
    """What is asked of a device, as the native half takes it."""
    return {
        "centre": None if centre is None else as_place("centre", centre),
        "rotation": None if view is None else as_rotation("view", view),
        "buttons": None if buttons is None else as_masks(buttons),
        "force_share": force_share,
    }


def as_masks(buttons: Buttons) -> tuple[int, int, int]:
    """Buttons of the scene as the native half takes them."""
    allowed = "allowed are 3 entries: without a button of the device, with its first, with another"
    try:
        given = tuple(buttons)
    except TypeError:
        raise PliantError(f"buttons is {buttons!r}; {allowed}") from None
    if len(given) != 3:
        raise PliantError(f"buttons has {len(given)} entries; {allowed}")
    none, first, other = map(as_mask, given)
    return none, first, other


@atexit.register
def _close_devices() -> None:
    for hand in list(_running):
        try:
            hand.stop()
        except PliantError:
            # Its device is closed all the same; or it is that of the process this one was forked from.
            pass


for _public in (DeviceState, DeviceHand):
    _public.__module__ = "pliant"
