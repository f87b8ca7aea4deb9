"""The mode: a modal operator that turns a pointer into a hand on the active mesh."""

from __future__ import annotations

import bpy
import numpy as np
import pliant
from bpy_extras import view3d_utils
from mathutils import Vector

from . import handover
from .device_mode import DeviceControl, give_hand
from .draw import Overlay
from .editing import edit_kinds
from .gesture import Ray
from .object_editing import Editing
from .preferences import device_choice
from .properties import kind_items, kind_label, strength_name

# Hz, at which the newest positions are shown.
FRAME_RATE = 60.0
# Number of times that a size or strength doubles when the pointer moves up by the height of the view.
DOUBLINGS_PER_HEIGHT = 8.0


class HAPTIC_OT_edit(bpy.types.Operator):
    """Press, pull and cut the active mesh as if it were soft"""

    bl_idname = "object.haptic_edit"
    bl_label = "Haptic Edit"
    # Each stroke is a step of its own.
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.active_object
        return obj is not None and obj.type == "MESH" and context.mode == "OBJECT"

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, "Haptic Edit begins in a 3D viewport")
            return {"CANCELLED"}
        self._editing = Editing(context.active_object)
        try:
            self._editing.prepare()
        except pliant.PliantError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._control = self._give_hand(context)
        self._report_warnings()
        self._timer = context.window_manager.event_timer_add(1.0 / FRAME_RATE, window=context.window)
        self._overlay = Overlay(self._editing)
        self._adjusted: tuple[str, int, float] | None = None
        self._say(context)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def _give_hand(self, context: bpy.types.Context) -> DeviceControl | None:
        """Give the hand to the device of the preferences; the pointer has it where there is none, or it cannot be opened."""
        try:
            choice = device_choice()
            return None if choice is None else give_hand(self._editing, choice, context)
        except pliant.PliantError as error:
            self.report({"ERROR"}, f"{error}; the pointer has the hand")
            return None

    def _report_warnings(self) -> None:
        for text in self._editing.take_warnings():
            self.report({"WARNING"}, text)

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        try:
            return self._handle(context, event)
        except pliant.PliantError as error:
            self.report({"ERROR"}, str(error))
            return self._leave(context)

    def _handle(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        editing = self._editing
        if not handover.is_enabled():
            return self._leave(context)
        if editing.object() is None:
            self.report({"WARNING"}, f"Haptic Edit ends: the object {editing.name} is no longer there")
            return self._leave(context)
        if event.type == "TIMER":
            if self._control is not None:
                if self._adjusted is None:
                    self._lead(context)
                context.area.tag_redraw()
            elif editing.is_under_way:
                editing.show(self._timer.time_delta)
                context.area.tag_redraw()
            return {"PASS_THROUGH"}
        if self._adjusted is not None:
            return self._adjust(context, event)
        if self._control is None and editing.is_under_way:
            return self._in_stroke(context, event)
        return self._between_strokes(context, event)

    def _lead(self, context: bpy.types.Context) -> None:
        """Have the device lead for a frame. One that is lost, or cannot be opened again, gives the hand back."""
        try:
            lost = self._control.tick(context)
        except pliant.PliantError as error:
            if self._editing.object() is None or self._editing.device is not None:
                raise
            lost = str(error)
        self._report_warnings()
        if lost is not None:
            self.report({"WARNING"}, f"{lost}; the pointer has the hand")
            self._control = None
            self._say(context)

    def _in_stroke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        editing = self._editing
        if event.type == "MOUSEMOVE":
            editing.follow(pointer_ray(context, event), event.pressure)
        elif event.type in {"WHEELUPMOUSE", "WHEELDOWNMOUSE"}:
            step = 0.2 * context.scene.haptic_edit.radius * editing.edit.mesh.size()
            editing.lift(step if event.type == "WHEELUPMOUSE" else -step)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            editing.end()
            self._report_warnings()
            bpy.ops.ed.undo_push(message=f"Haptic {kind_label(context.scene.haptic_edit.kind)}")
            context.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def _between_strokes(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        given, editing = context.scene.haptic_edit, self._editing
        if event.type in {"ESC", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            return self._leave(context)
        if event.value != "PRESS" or not _is_over_view(context, event):
            return {"PASS_THROUGH"}
        if event.type == "LEFTMOUSE" and self._control is not None:
            # It would choose another object.
            return {"RUNNING_MODAL"}
        if event.type == "LEFTMOUSE" and not (event.alt or event.ctrl):
            ray = pointer_ray(context, event)
            is_on_mesh = editing.begin(given.kind, ray, view_back(context), event.pressure)
            self._report_warnings()
            if not is_on_mesh:
                return {"PASS_THROUGH"}
            return {"RUNNING_MODAL"}
        if event.type == "Z" and event.ctrl:
            if self._control is not None:
                self._control.finish()
            # What Blender has afterwards is read anew at the next stroke.
            (bpy.ops.ed.redo if event.shift else bpy.ops.ed.undo)()
            return {"RUNNING_MODAL"}
        if event.type == "F":
            name = strength_name(given.kind) if event.shift else "radius"
            self._adjusted = (name, event.mouse_y, getattr(given, name))
            context.workspace.status_text_set(f"Move the pointer up or down to set the {name.replace('_', ' ')}; click to take it, Esc to leave it")
            return {"RUNNING_MODAL"}
        kind = _kind_of_key(event)
        if kind is not None:
            given.kind = kind
            self._say(context)
            context.area.tag_redraw()
            return {"RUNNING_MODAL"}
        return {"PASS_THROUGH"}

    def _adjust(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        name, start, before = self._adjusted
        given = context.scene.haptic_edit
        if event.type == "MOUSEMOVE":
            # Doubled or halved by the same way anywhere.
            setattr(given, name, before * 2.0 ** (DOUBLINGS_PER_HEIGHT * (event.mouse_y - start) / context.area.height))
        elif event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            setattr(given, name, before)
            self._adjusted = None
        elif event.type in {"LEFTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            self._adjusted = None
        if self._adjusted is None:
            self._say(context)
        context.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def _say(self, context: bpy.types.Context) -> None:
        keys = dict(zip(edit_kinds(), "1234567890", strict=False)) | {"cut": "K"}
        kinds = ", ".join(f"{keys[kind]}: {name}" for kind, name, _ in kind_items(None, context) if kind in keys)
        hand = "wheel in a stroke: towards you" if self._control is None else "the device has the hand: first button the tool, another its opposite"
        context.workspace.status_text_set(f"Haptic Edit   {kinds}   F: size   Shift F: strength   {hand}   Ctrl Z: undo   Esc: leave")

    def _leave(self, context: bpy.types.Context) -> set[str]:
        if self._editing.is_under_way and self._editing.object() is not None:
            try:
                if self._control is not None:
                    self._control.finish()
                else:
                    self._editing.end()
            except pliant.PliantError as error:
                self.report({"ERROR"}, str(error))
        self._editing.close()
        self._overlay.remove()
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        if context.area is not None:
            context.area.tag_redraw()
        return {"FINISHED"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends or loads another file."""
        self._leave(context)


# Keys of the edit kinds, in the order of the engine; a knife has a key of its own.
NUMBER_KEYS = ("ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE", "ZERO")


def _kind_of_key(event: bpy.types.Event) -> str | None:
    """The edit kind that a key chooses."""
    kinds = list(edit_kinds())
    if event.ctrl or event.shift or event.alt:
        return None
    if event.type == "K" and "cut" in kinds:
        return "cut"
    if event.type in NUMBER_KEYS[: len(kinds)]:
        return kinds[NUMBER_KEYS.index(event.type)]
    return None


def _is_over_view(context: bpy.types.Context, event: bpy.types.Event) -> bool:
    """Whether the pointer is over the viewport itself and not over a panel of it."""
    is_over = False
    for region in context.area.regions:
        inside = (
            region.x <= event.mouse_x < region.x + region.width and region.y <= event.mouse_y < region.y + region.height
        )
        if inside and region.type != "WINDOW" and region.width > 1:
            return False
        if inside and region.type == "WINDOW":
            is_over = True
    return is_over


def _view(context: bpy.types.Context) -> tuple[bpy.types.Region, bpy.types.RegionView3D]:
    region = next(region for region in context.area.regions if region.type == "WINDOW")
    return region, context.area.spaces.active.region_3d


def pointer_ray(context: bpy.types.Context, event: bpy.types.Event) -> Ray:
    """The ray of the pointer, in metres of the scene."""
    region, view = _view(context)
    at = (event.mouse_x - region.x, event.mouse_y - region.y)
    unit = context.scene.unit_settings.scale_length
    origin = unit * np.array(view3d_utils.region_2d_to_origin_3d(region, view, at))
    direction = np.array(view3d_utils.region_2d_to_vector_3d(region, view, at))
    return Ray(origin, direction / np.linalg.norm(direction))


def view_back(context: bpy.types.Context) -> np.ndarray:
    """Unit, towards the viewer."""
    _, view = _view(context)
    return np.array(view.view_rotation @ Vector((0.0, 0.0, 1.0)))


CLASSES = (HAPTIC_OT_edit,)
