"""The mode: a modal operator that turns a pointer into a hand on the active mesh."""

from __future__ import annotations

import bpy
import numpy as np
import pliant
from bpy_extras import view3d_utils
from mathutils import Vector

from . import bake, mesh_io
from .draw import Overlay
from .editing import MeshArrays, MeshEdit, Settings, edit_kinds
from .gesture import Hit, Ray
from .properties import FACTORS, HapticSettings, _kinds

# Hz, at which the newest positions are shown.
FRAME_RATE = 60.0
# Share of the window's height that the pointer moves for a size or strength of one.
DRAG_SHARE = 0.5


class Editing:
    """The active mesh of the mode: the engine's session of it, and how strokes reach Blender's data. It keeps the name of the object and
    nothing else of Blender's, so undo may replace whatever it likes.
    """

    def __init__(self, obj: bpy.types.Object) -> None:
        self.name = obj.name
        self._edit: MeshEdit | None = None
        self._settings: Settings | None = None
        self._inverse = np.eye(4)
        self._frame = np.empty((0, 3), dtype=np.float32)
        self._seen: pliant.Mesh | None = None
        self._is_open = False
        # Coordinates when the stroke began, and the shape key it edits.
        self._start = self._frame
        self._key: str | None = None
        # Warnings to report, and those reported before.
        self._warnings: list[str] = []
        self._reported: set[str] = set()
        self.tool: pliant.ToolState | None = None

    def object(self) -> bpy.types.Object | None:
        """The object, if it is still a mesh that is there."""
        obj = bpy.data.objects.get(self.name)
        return obj if obj is not None and obj.type == "MESH" else None

    @property
    def is_under_way(self) -> bool:
        """Whether a stroke is under way."""
        return self._edit is not None and self._edit.is_under_way

    def take_warnings(self) -> list[str]:
        """What has no effect, or not the one it looks like; each text once."""
        new = [text for text in dict.fromkeys(self._warnings) if text not in self._reported]
        self._warnings.clear()
        self._reported.update(new)
        return new

    def prepare(self) -> None:
        """Have a session of the mesh as it is now; it is opened anew if the mesh or the settings are others than before."""
        obj = self._require()
        mesh = mesh_io.read_mesh(obj)
        if not len(mesh.counts):
            raise pliant.PliantError(f"mesh `{obj.name}` has no faces; allowed is one with some", "model")
        known = self._edit is not None and mesh.has_faces_of(self._edit.mesh)
        self._is_open = self._is_open if known else mesh.is_open()
        inverse = np.linalg.inv(mesh_io.to_scene_matrix(obj))
        is_same = known and np.array_equal(inverse, self._inverse) and self._has_places_of(mesh)
        # Sizes are relative to the mesh when its session was opened: a stroke may change it.
        settings = self._settings_of(obj, self._edit.mesh if is_same else mesh)
        if is_same and settings == self._settings:
            self._seen = self._edit.surface()
            return
        self.close()
        self._edit = MeshEdit(mesh, settings)
        self._warnings += [f"[{warning.code}] {warning.args[0]}" for warning in self._edit.warnings()]
        self._settings, self._inverse = settings, inverse
        self._seen = self._edit.surface()
        self._frame = np.empty((len(mesh.vertices), 3), dtype=np.float32)

    def _has_places_of(self, mesh: MeshArrays) -> bool:
        """Whether the vertices of the session are where those of a mesh are, which Blender rounds to single precision."""
        return bool(np.abs(self._edit.positions() - mesh.vertices).max() <= 2e-6 * max(1.0, mesh.size()))

    def _settings_of(self, obj: bpy.types.Object, mesh: MeshArrays) -> Settings:
        """What the panel says of a mesh."""
        given = bpy.context.scene.haptic_edit
        is_sheet = given.substance == "SHEET" or (given.substance == "AUTO" and self._is_open)
        return Settings(
            young=1e3 * given.young,
            density=given.density,
            fabric=given.fabric if is_sheet else None,
            plugin=given.plugin,
            level=given.level,
            radius=given.radius * mesh.size(),
            symmetry="".join(axis for axis, is_set in zip("xyz", given.symmetry, strict=True) if is_set),
            pinned=self._pinned(obj, given.pin_group),
            factors=self._factors(obj, given),
        )

    def _pinned(self, obj: bpy.types.Object, name: str) -> tuple[int, ...]:
        """Vertices with a weight of a half or more in the group that is held."""
        weights = self._weights(obj, name)
        if weights is None:
            return ()
        pinned = np.flatnonzero(weights >= 0.5)
        if not len(pinned):
            self._warnings.append(f"vertex group `{name}` pins nothing: no weight is 0.5 or more")
        return tuple(pinned.tolist())

    def _factors(self, obj: bpy.types.Object, given: HapticSettings) -> tuple[float, ...]:
        """Factors of the stiffness by the weights of a group, geometric between those at 0 and 1."""
        weights = self._weights(obj, given.stiffness_group)
        if weights is None:
            return ()
        low, high = FACTORS
        at_zero, at_one = (min(max(factor, low), high) for factor in (given.factor_at_zero, given.factor_at_one))
        factors = at_zero * (at_one / at_zero) ** weights
        if (factors == 1.0).all():
            self._warnings.append(f"vertex group `{given.stiffness_group}` makes nothing stiffer or softer: its factor is 1 at every vertex")
            return ()
        # A power may leave the range by its rounding.
        return tuple(np.clip(factors, low, high).tolist())

    def _weights(self, obj: bpy.types.Object, name: str) -> np.ndarray | None:
        """Weights of a vertex group that the panel names; None without one."""
        if not name:
            return None
        weights = mesh_io.group_weights(obj, name)
        if weights is None:
            known = ", ".join(f"`{group.name}`" for group in obj.vertex_groups) or "nothing: it has no groups"
            self._warnings.append(f"object `{obj.name}` has no vertex group `{name}`; allowed is {known}")
        return weights

    def hit(self, ray: Ray) -> Hit | None:
        """Where a ray meets the mesh as it was when it was last prepared."""
        hit = self._seen.cast(ray.origin, ray.direction) if self._seen is not None else None
        if hit is None:
            return None
        # Of an open mesh the side that is seen.
        return Hit(hit.point, hit.normal if hit.normal @ ray.direction <= 0 else -hit.normal)

    def begin(self, kind: str, ray: Ray, back: np.ndarray, pressure: float = 1.0) -> bool:
        """Begin a stroke; give whether it meets the mesh."""
        self.prepare()
        hit = self.hit(ray)
        if hit is None and kind != "cut":
            return False
        self._start, self._key = mesh_io.coordinates(self._require()), mesh_io.active_key(self._require())
        self._edit.begin(kind, ray, hit, back, self.depth(pressure))
        return True

    def depth(self, pressure: float) -> float:
        """m, how deep a press goes in"""
        given = bpy.context.scene.haptic_edit
        share = pressure if given.use_pressure else 1.0
        return given.strength * share * self._settings.radius

    def follow(self, ray: Ray, pressure: float = 1.0) -> None:
        """The pointer has moved."""
        if self._edit is not None:
            self._edit.follow(ray, self.hit(ray))
            self._edit.set_depth(self.depth(pressure))

    def lift(self, length: float) -> None:
        """Move the hand towards the viewer, m."""
        if self._edit is not None:
            self._edit.lift(length)

    def show(self, dt: float) -> None:
        """Send the hand on, and copy the newest positions into the mesh: what the timer does."""
        obj = self._require()
        self._edit.advance(dt)
        if not self._edit.is_alive:
            raise pliant.PliantError("the engine stopped; leave the mode and enter it again", "panic")
        tool = self._edit.read(self._frame, self._inverse)
        if tool is not None:
            self.tool = tool
            if len(obj.data.vertices) == len(self._frame):
                mesh_io.set_coordinates(obj, self._frame)

    def end(self) -> None:
        """End the stroke and write what it did."""
        obj = self._require()
        edit = self._edit
        is_cut = edit.end()
        self.tool = None
        self._warnings += edit.take_refusals()
        recording, inverse = edit.recording(), self._inverse
        if is_cut:
            mesh_io.take_cut(obj, edit.mesh, edit.session)
            # The topology is another one: the next stroke begins with it.
            self.close()
        else:
            mesh_io.set_coordinates(obj, mesh_io.to_object(obj, edit.positions()))
        end = mesh_io.coordinates(obj)
        bake.remember(bake.Take(self.name, self._key, recording, edit.mesh, inverse, self._start, end, is_cut))

    def close(self) -> None:
        """End the session."""
        if self._edit is not None:
            self._edit.close()
        self._edit = self._settings = None

    @property
    def edit(self) -> MeshEdit | None:
        """The mesh under the hand, if a session is open."""
        return self._edit

    def _require(self) -> bpy.types.Object:
        obj = self.object()
        if obj is None:
            raise pliant.PliantError(f"the object `{self.name}` is no longer there", "closed")
        return obj


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
        self._report_warnings()
        self._timer = context.window_manager.event_timer_add(1.0 / FRAME_RATE, window=context.window)
        self._overlay = Overlay(self._editing)
        self._adjusted: tuple[str, int, float] | None = None
        self._say(context)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

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
        if editing.object() is None:
            self.report({"WARNING"}, f"Haptic Edit ends: the object {editing.name} is no longer there")
            return self._leave(context)
        if event.type == "TIMER":
            if editing.is_under_way:
                editing.show(self._timer.time_delta)
                context.area.tag_redraw()
            return {"PASS_THROUGH"}
        if self._adjusted is not None:
            return self._adjust(context, event)
        if editing.is_under_way:
            return self._in_stroke(context, event)
        return self._between_strokes(context, event)

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
            label = dict((kind, name) for kind, name, _ in _kind_names(context))[context.scene.haptic_edit.kind]
            bpy.ops.ed.undo_push(message=f"Haptic {label}")
            context.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def _between_strokes(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        given, editing = context.scene.haptic_edit, self._editing
        if event.type in {"ESC", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            return self._leave(context)
        if event.value != "PRESS" or not _is_over_view(context, event):
            return {"PASS_THROUGH"}
        if event.type == "LEFTMOUSE" and not (event.alt or event.ctrl):
            ray = pointer_ray(context, event)
            is_on_mesh = editing.begin(given.kind, ray, view_back(context), event.pressure)
            self._report_warnings()
            if not is_on_mesh:
                return {"PASS_THROUGH"}
            return {"RUNNING_MODAL"}
        if event.type == "Z" and event.ctrl:
            # What Blender has afterwards is read anew at the next stroke.
            (bpy.ops.ed.redo if event.shift else bpy.ops.ed.undo)()
            return {"RUNNING_MODAL"}
        if event.type == "F":
            name = "strength" if event.shift else "radius"
            self._adjusted = (name, event.mouse_y, getattr(given, name))
            context.workspace.status_text_set(f"Move the pointer up or down to set the {name}; click to take it, Esc to leave it")
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
            setattr(given, name, before * 2.0 ** ((event.mouse_y - start) / (DRAG_SHARE * context.area.height) * 4.0))
        elif event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            setattr(given, name, before)
            self._adjusted = None
        elif event.type in {"LEFTMOUSE", "RET"} and event.value == "PRESS":
            self._adjusted = None
        if self._adjusted is None:
            self._say(context)
        context.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def _say(self, context: bpy.types.Context) -> None:
        keys = dict(zip(edit_kinds(), "1234567890", strict=False)) | {"cut": "K"}
        kinds = ", ".join(f"{keys[kind]}: {name}" for kind, name, _ in _kind_names(context) if kind in keys)
        context.workspace.status_text_set(
            f"Haptic Edit   {kinds}   F: size   Shift F: strength   wheel in a stroke: towards you   Ctrl Z: undo   Esc: leave"
        )

    def _leave(self, context: bpy.types.Context) -> set[str]:
        if self._editing.is_under_way and self._editing.object() is not None:
            try:
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


def _kind_names(context: bpy.types.Context) -> list[tuple[str, str, str]]:
    return _kinds(context.scene.haptic_edit, context)


def _is_over_view(context: bpy.types.Context, event: bpy.types.Event) -> bool:
    """Whether the pointer is over the viewport itself and not over a panel of it."""
    for region in context.area.regions:
        inside = (
            region.x <= event.mouse_x < region.x + region.width and region.y <= event.mouse_y < region.y + region.height
        )
        if inside and region.type != "WINDOW" and region.width > 1:
            return False
        if inside and region.type == "WINDOW":
            found = True
    return locals().get("found", False)


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
