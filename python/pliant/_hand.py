"""Hands, to be moved by the caller or given to a device."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

from numpy.typing import ArrayLike

from . import _native
from ._device_hand import Buttons, DeviceHand, GivenWish, as_masks, as_wish
from ._error import PliantError
from ._pose import as_pose


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

    def follow(
        self,
        device: str | DeviceHand,
        params: Mapping[str, Any] | None = None,
        *,
        view: Any = None,
        centre: ArrayLike | None = None,
        buttons: Buttons | None = None,
        force_share: float | None = None,
    ) -> DeviceHand:
        """Give the hand to a haptic device, in real time, until the result is stopped; until then the session itself is busy.

        The device is read and given its force by a native thread at its own rate, steps are taken by another; neither needs the interpreter. The bodies take
        seven tenths of the device's workspace, and its force is scaled so that it can render what the tool's hand may feel at most.

        All other hands are the caller's from then on, as after :meth:`go`, and away until :meth:`Live.go` sends them somewhere.

        Parameters
        ----------
        device : str or DeviceHand
            One of :func:`devices`, or the path of a library in a folder of the session's `allow_plugins`, with ``#`` and an id if it has several devices. Or the hand
            of another session: its device goes on with this one. It stays open and its force never changes faster than the slew of the hand; tools begin where
            those of the same name touch. The other session is stopped as by :meth:`DeviceHand.stop`; poses that nobody has taken of it are lost.
        params : mapping, optional
            Parameters of the device, with ``_`` for ``-``: numbers in SI units or texts with a unit such as ``"10 mm"``.
        view : array_like or Rotation, optional
            Rotation from axes of the user's picture (right, up, towards the user) to those of the scene: right on the device is right in the picture. The axes
            of the scene by default.
        centre : array_like, optional
            m (3), where the middle of the device's workspace is; the middle of the bodies by default.
        buttons : tuple
            Buttons of the scene that are pressed while no button of the device is, while its first is, and while only another is; each as for
            :meth:`go`. By default none, button 0 and button 1; with a hand of another session all stay as they were asked for there, and `params` are not
            allowed.
        force_share : float, optional
            Share of the force that the device can render, 0 to 1, by default 1.

        Returns
        -------
        DeviceHand

        Raises
        ------
        PliantError
            Of kind ``"plugin"``: there is no such device, it cannot be opened, or a parameter or library is not allowed. Of kind ``"argument"``: the tool
            shares the device of its hand with another, or an argument is not allowed.
        """
        texts = [(key.replace("_", "-"), _text(key, value)) for key, value in (params or {}).items()]
        if isinstance(device, DeviceHand):
            return self._follow_on(device, texts, as_wish(view, centre, None, force_share), buttons)
        wish = as_wish(view, centre, buttons, force_share)
        return DeviceHand(self._session, self._session.follow(self._tool, device, texts, wish), device)

    def _follow_on(
        self,
        hand: DeviceHand,
        params: list[tuple[str, str]],
        wish: GivenWish,
        buttons: Buttons | None,
    ) -> DeviceHand:
        """Give the hand to the device that has one of another session; `buttons` are part of the wish."""
        if params:
            raise PliantError(f"params has `{params[0][0]}`, and the device is open; allowed are none")
        if hand._session is self._session:
            raise PliantError("the hand is one of this session; allowed is that of another session, or DeviceHand.guide")
        hand.pause()
        try:
            wish["buttons"] = None if buttons is None else as_masks(buttons)
            live = self._session.follow_on(self._tool, hand._native, wish)
        finally:
            hand.stop()
        return DeviceHand(self._session, live, hand.device)

    def leave(self) -> None:
        """Take the hand away: its tool lets go of everything."""
        self._session.place_hand(self._tool, None, (0.0, 0.0, 0.0, 1.0), 0)

    def __repr__(self) -> str:
        return f"<hand of tool `{self._tool}`>"


def _text(key: str, value: Any) -> str:
    """The value of a parameter as the native half takes it."""
    if isinstance(value, bool) or not isinstance(value, (str, int, float, os.PathLike)):
        raise PliantError(f"parameter `{key}` is {value!r}; allowed is a number, a text or a path")
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


Hand.__module__ = "pliant"
