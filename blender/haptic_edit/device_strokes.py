"""The hand of a haptic device on a mesh: what is felt, and which strokes have been made. No Blender here.

Without a button the surface is felt and springs back. The first button of the device makes a stroke with the tool that is chosen, any other one with its
opposite. A stroke is finished once the hand has let go of the mesh and it is at rest, or when the next one begins.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
import pliant

from .editing import SETTLE, TOOL, MeshEdit, device_button_of, edit_kinds, felt_button


# Speed of a mesh, its sizes in a second of the session, at which it counts as at rest: a ten-thousandth of its size in a frame of 60 Hz.
REST_SPEED = 6e-3
# s, after which a stroke is finished although the mesh still moves.
LONGEST_REST = 2.0


@dataclass(frozen=True)
class DeviceChoice:
    """A device that shall have the hand.

    Attributes
    ----------
    plugin : str
        Its plugin, or the path of a library.
    params : tuple of (str, str)
        Keys and values of its parameters.
    allowed : tuple of str
        Folders from which libraries may be named by their path.
    """

    plugin: str
    params: tuple[tuple[str, str], ...] = ()
    allowed: tuple[str, ...] = ()


@dataclass(frozen=True)
class Wish:
    """What is asked of a device in a frame.

    Attributes
    ----------
    view : tuple of float
        Rotation from axes of the picture (right, up, towards the viewer) to those of the scene: a quaternion (x, y, z, w).
    kind : str
        Edit kind of the first button.
    force_share : float
        Share of the force that the device can render, 0 to 1.
    """

    view: tuple[float, float, float, float]
    kind: str
    force_share: float = 1.0


class _Phase(Enum):
    """What the hand is doing."""

    INSIDE = "inside of the mesh, where it begins to touch it only after it has come out"
    FREE = "feels"
    STROKE = "makes a stroke"
    TOUCHING = "has made a stroke and feels the mesh still"


class DeviceStrokes:
    """A device that has the hand on a mesh; opening it begins.

    Parameters
    ----------
    edit : MeshEdit
        The mesh.
    wish : Wish
        Where the user looks from, and the tool.
    device : DeviceChoice or DeviceStrokes
        The device to open, or one that has had the hand on another mesh until now: it stays open.
    """

    def __init__(self, edit: MeshEdit, wish: Wish, device: DeviceChoice | DeviceStrokes) -> None:
        self._edit = edit
        # Cloth has no inside.
        self._phase = _Phase.INSIDE if edit.settings.fabric is None else _Phase.FREE
        asked = {"view": wish.view, "force_share": wish.force_share}
        if isinstance(device, DeviceStrokes):
            # A tool that touched goes on touching from outside.
            self._phase = _Phase.INSIDE if device.is_inside and self._phase is _Phase.INSIDE else _Phase.FREE
            buttons = (0, 0, 0) if self._phase is _Phase.INSIDE else ([felt_button()],) * 3
            self._hand = edit.give_hand(device._hand, buttons=buttons, **asked)
        else:
            self._hand = edit.give_hand(device.plugin, params=dict(device.params), buttons=(0, 0, 0), **asked)
        self._strokes = device.state.strokes if isinstance(device, DeviceStrokes) else 0
        self._kind = ""
        self._start = 0.0
        # s, since when nothing has been touched after a stroke
        self._away: float | None = None
        # s, of the session at the frame before
        self._last = 0.0
        self.state = self._hand.state

    @property
    def in_stroke(self) -> bool:
        """Whether a stroke is under way, or made and not yet finished."""
        return self._phase in (_Phase.STROKE, _Phase.TOUCHING)

    @property
    def kind(self) -> str:
        """Edit kind of the stroke that is under way, or of the last one."""
        return self._kind

    @property
    def is_inside(self) -> bool:
        """Whether the hand began inside of the mesh and has not come out: it touches nothing."""
        return self._phase is _Phase.INSIDE

    def advance(self, wish: Wish, seen: pliant.Mesh, moved: float) -> str | None:
        """Guide the device for a frame. `seen` is the mesh as it was when the hand was given to it, `moved` how far it has moved since the frame before, over
        its size. Give the edit kind of a stroke that is finished: what the session shows now is what it left.
        """
        state = self.state = self._hand.state
        if self._phase is _Phase.INSIDE and state.position is not None and _is_clear(seen, state.position, self._edit.settings.radius):
            self._phase = _Phase.FREE
        first, other = device_button_of(wish.kind), device_button_of(pliant.opposite_kind(wish.kind) or wish.kind)
        buttons = (0, 0, 0) if self._phase is _Phase.INSIDE else ([felt_button()], [first], [other])
        self._hand.guide(view=wish.view, buttons=buttons, force_share=wish.force_share)
        return self._follow(state, wish, moved)

    def _follow(self, state: pliant.DeviceState, wish: Wish, moved: float) -> str | None:
        """Follow the strokes; give the kind of one that is finished."""
        finished = None
        if state.strokes > self._strokes:
            # The mesh as it is felt now is what the stroke before has left.
            finished = self.finish()
            self._strokes, self._phase, self._away = state.strokes, _Phase.STROKE, None
            self._kind = _kind_of(state.buttons) or wish.kind
            self._start = self._hand.time
        if self._phase is _Phase.STROKE and not state.in_stroke:
            self._phase = _Phase.TOUCHING
        if self._phase is _Phase.TOUCHING:
            now, touches = self._hand.time, self._hand.tool(TOOL).contact is not None
            # In slow motion a frame is a small part of one.
            is_at_rest = moved <= REST_SPEED * (now - self._last) and now > self._last
            self._last = now
            self._away = None if touches else now if self._away is None else self._away
            away = 0.0 if self._away is None else now - self._away
            if self._edit.is_cut() or away >= LONGEST_REST or (away >= SETTLE and is_at_rest):
                return self.finish()
        return finished

    def finish(self) -> str | None:
        """Finish a stroke that is under way with what the session shows now; give its kind, None if there is none."""
        start = self.take_stroke()
        if start is None:
            return None
        self.keep_poses()
        self._edit.keep_stroke(start, self._hand.time)
        return self._kind

    def take_stroke(self) -> float | None:
        """Have no stroke any more; give when (s, of the session) the one that is under way began, None if there is none."""
        if not self.in_stroke:
            return None
        self._phase, self._away = _Phase.FREE, None
        return self._start

    def keep_poses(self) -> None:
        """Take the poses of a hand that only feels, so that what it felt before a stroke can be made again too."""
        self._edit.keep_poses(self._hand.take_poses())


def _kind_of(buttons: int) -> str | None:
    """The edit kind of the buttons of the scene that are pressed; None for that which is felt or none."""
    pressed = [kind for kind in edit_kinds() if buttons >> device_button_of(kind) & 1]
    return pressed[0] if pressed else None


def _is_clear(mesh: pliant.Mesh, place: np.ndarray, radius: float) -> bool:
    """Whether a ball at a place is outside of a closed mesh: no vertex is in it, and the first face that is met from there is seen from its front."""
    if np.linalg.norm(mesh.vertices - place, axis=1).min() < radius:
        return False
    hit = mesh.cast(place, np.array([0.0, 0.0, 1.0]))
    return hit is None or bool(hit.normal[2] <= 0.0)
