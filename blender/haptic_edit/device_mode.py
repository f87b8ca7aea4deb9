"""A haptic device that has the hand in the mode: frame by frame, from where the viewport looks."""

from __future__ import annotations

import bpy
import numpy as np
import pliant

from . import handover
from .device_strokes import DeviceChoice, Wish
from .object_editing import Editing
from .preferences import preferences
from .properties import kind_label

# Frames for which settings stay as they are before the session is opened with them: a slider that is dragged must not open it sixty times a second.
STEADY_FRAMES = 20
# What of the settings a session has from its opening.
_OF_SESSION = ("substance", "preset", "plugin", "young", "density", "fabric", "level", "radius", "pin_group", "stiffness_group", "factor_at_zero", "factor_at_one")
_OF_SESSION += ("brush_strength", "paint_factor")


class DeviceControl:
    """Has a device lead the hand on a mesh, as long as the mode goes on.

    The session is opened anew when the mesh or the settings change by something else: undo, an operator, a slider. The device stays open meanwhile and goes on
    with the new session.
    """

    def __init__(self, editing: Editing, choice: DeviceChoice) -> None:
        self._editing, self._choice = editing, choice
        self._opened_with: tuple = ()
        self._steady = 0

    def start(self, context: bpy.types.Context) -> None:
        """Give the hand to the device, on the mesh as it is now."""
        obj = self._editing.object()
        self._opened_with, self._steady = _signature(context, obj), 0
        self._editing.give_to(self._choice, wish_of(context))

    def tick(self, context: bpy.types.Context) -> str | None:
        """Go on by a frame. Give why the device is lost, if it is: the pointer has the hand then."""
        editing = self._editing
        if editing.device is None:
            self.start(context)
        elif editing.is_stale or editing.is_mesh_changed() or self._are_settings_new(context):
            self._go_on(context)
        before = _signature(context, editing.object())
        kind = editing.show_device(wish_of(context))
        if kind is not None:
            # A stroke that pins or paints may choose its vertex group in the panel: the session has that already.
            self._settle(before, _signature(context, editing.object()))
            _push_undo(kind)
        lost = editing.device is not None and editing.device.state.status == "lost"
        if not lost:
            return None
        reason = editing.device.state.reason
        self.finish()
        return reason

    def _go_on(self, context: bpy.types.Context) -> None:
        """Have the device go on, on the mesh and with the settings as they are now; it is not closed."""
        obj = self._editing.object()
        self._opened_with, self._steady = _signature(context, obj), 0
        try:
            kind = self._editing.go_on_with_device(wish_of(context))
        except Exception:
            self._editing.drop()
            raise
        if kind is not None:
            _push_undo(kind)

    def finish(self) -> None:
        """Take the hand from the device; a stroke that is under way ends as if its button had been let go."""
        kind = self._editing.device.kind if self._editing.device is not None else ""
        if self._editing.is_under_way and self._editing.end():
            _push_undo(kind)

    def _settle(self, before: tuple, now: tuple) -> None:
        """Take settings that have just changed from one signature to another for those of the session, where they were so before."""
        if self._opened_with == before:
            self._opened_with = now

    def _are_settings_new(self, context: bpy.types.Context) -> bool:
        """Whether the settings are others than the session has, and have been so for a while."""
        obj = self._editing.object()
        self._steady = self._steady + 1 if _signature(context, obj) != self._opened_with else 0
        return self._steady >= STEADY_FRAMES


def wish_of(context: bpy.types.Context) -> Wish:
    """What is asked of the device now: the axes of the viewport, the tool and the share of the force."""
    given = preferences()
    w, x, y, z = context.area.spaces.active.region_3d.view_rotation
    return Wish((x, y, z, w), context.scene.haptic_edit.kind, 1.0 if given is None else given.force_share)


def _signature(context: bpy.types.Context, obj: bpy.types.Object) -> tuple:
    """What a session has from its opening, besides the mesh."""
    given = context.scene.haptic_edit
    selected = tuple(sorted(other.name for other in context.view_layer.objects.selected))
    matrix = np.array(obj.matrix_world).tobytes()
    return (*(getattr(given, name) for name in _OF_SESSION), tuple(given.symmetry), selected, matrix)


def _push_undo(kind: str) -> None:
    if bpy.ops.ed.undo_push.poll():
        bpy.ops.ed.undo_push(message=f"Haptic {kind_label(kind)}")


def give_hand(editing: Editing, choice: DeviceChoice, context: bpy.types.Context) -> DeviceControl:
    """Give the hand on a mesh to a device.

    Raises
    ------
    PliantError
        The device cannot be opened, or the extension is being disabled.
    """
    if not handover.is_enabled():
        raise pliant.PliantError("the extension is disabled", "closed")
    control = DeviceControl(editing, choice)
    control.start(context)
    return control
