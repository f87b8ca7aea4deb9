"""The active mesh of the mode: a session of it, and how strokes reach Blender's data."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np
import pliant

from . import bake, handover, mesh_io, painting, topology
from .device_strokes import DeviceChoice, DeviceStrokes, Wish
from .editing import MeshArrays, MeshEdit, Obstacle, Settings
from .gesture import Hit, Ray
from .panel_settings import settings_of


# Frames after which the poses of a device's hand are taken from the engine: ten seconds.
FRAMES_TAKEN = 600
# Way of a vertex over the size of the mesh that is not seen: the rest of a motion that has been felt.
FELT_SHARE = 1e-3
# What mends the cause of a warning in Blender, where the engine's own words name keys of a scene.
REMEDIES = {
    "coincident-borders": "vertices on borders lie exactly where others do and are not joined to them, so the mesh is in pieces there; "
    "in Edit Mode, Mesh > Merge > By Distance joins them",
}


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
        # The edit kind of the stroke of the pointer, and the vertices that strokes of this session have pinned so far.
        self._kind, self._stroke_pins = "", np.empty(0, dtype=np.int64)
        # Whether what Blender has may be other than what the session was opened with, though the coordinates are the same: after an undo, or pins that were freed.
        self.is_stale = False
        # Warnings to report, and those reported before.
        self._warnings: list[str] = []
        self._reported: set[str] = set()
        self.tool: pliant.ToolState | None = None
        # A device that has the hand, and folders from which its library may be named by its path.
        self.device: DeviceStrokes | None = None
        self.allowed: tuple[str, ...] = ()
        # Whether a session that is opened anew leaves the one before open, until it has given its device away; and that one.
        self._takes_over, self._replaced = False, None
        # Frames until the poses of a device's hand are taken.
        self._until_taken = FRAMES_TAKEN
        # Coordinates that were shown last while a device had the hand, and how far they were from those before, over the size of the mesh.
        self._shown, self._moved = self._frame, 0.0

    def object(self) -> bpy.types.Object | None:
        """The object, if it is still a mesh that is there."""
        obj = bpy.data.objects.get(self.name)
        return obj if obj is not None and obj.type == "MESH" else None

    @property
    def is_under_way(self) -> bool:
        """Whether a stroke is under way, or a device has the hand."""
        return self.device is not None or (self._edit is not None and self._edit.is_under_way)

    def warn(self, text: str) -> None:
        """Have a text among the next warnings."""
        self._warnings.append(text)

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
        # The session of a device is under way: it says no positions.
        self.is_stale = False
        is_same = known and not self._takes_over and np.array_equal(inverse, self._inverse) and self._has_places_of(mesh)
        # Sizes are relative to the mesh when its session was opened: a stroke may change it.
        settings = settings_of(obj, self._edit.mesh if is_same else mesh, self._is_open, self._warnings)
        obstacles = mesh_io.read_obstacles(self.name)
        if is_same and settings == self._settings and self._has_obstacles(obstacles):
            self._seen = self._edit.surface()
            return
        before = self._edit if self._takes_over else None
        if before is None:
            self.close()
        self._edit, self._replaced = MeshEdit(mesh, settings, obstacles, self.allowed), before
        handover.watch(self)
        self._warnings += [
            f"[{warning.code}] {REMEDIES.get(warning.code, warning.args[0])}" for warning in self._edit.warnings()
        ]
        self._settings, self._inverse = settings, inverse
        self._stroke_pins = np.empty(0, dtype=np.int64)
        self._seen = self._edit.surface()
        self._frame = np.empty((len(mesh.vertices), 3), dtype=np.float32)

    def _has_obstacles(self, obstacles: tuple[Obstacle, ...]) -> bool:
        """Whether the session has these obstacles."""
        known = self._edit.obstacles
        return len(known) == len(obstacles) and all(a.is_same(b) for a, b in zip(known, obstacles, strict=True))

    def _has_places_of(self, mesh: MeshArrays) -> bool:
        """Whether the vertices of the session are where those of a mesh are, which Blender rounds to single precision."""
        return bool(np.abs(self._edit.positions() - mesh.vertices).max() <= 2e-6 * max(1.0, mesh.size()))

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
        self._kind = kind
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

    def give_to(self, choice: DeviceChoice, wish: Wish) -> None:
        """Give the hand to a device, on the mesh as it is now."""
        if choice.allowed != self.allowed:
            self.close()
        self.allowed = choice.allowed
        self.prepare()
        obj = self._require()
        self._start, self._key = mesh_io.coordinates(obj), mesh_io.active_key(obj)
        self._shown, self._moved = self._start, 0.0
        self.device = DeviceStrokes(self._edit, wish, choice)

    def go_on_with_device(self, wish: Wish) -> str | None:
        """Have the device that has the hand go on with it on the mesh as it is now, without closing it. A stroke that is under way is given up if the mesh is
        another one, as after undo, and finished otherwise; give the edit kind of one that is finished and in the mesh.
        """
        obj, before = self._require(), self.device
        kind = None
        if not self.is_mesh_changed():
            kind = before.finish()
            if kind is not None:
                self._remember(False)
                self._keep_painting(kind)
            elif self._settings.fabric is None:
                # What was felt of a solid springs back.
                mesh_io.set_coordinates(obj, self._start)
        before.keep_poses()
        self._hand_over(wish)
        return kind

    def _hand_over(self, wish: Wish) -> None:
        """Open the session anew, and have the device that has the hand go on with it without closing it."""
        before, self._takes_over = self.device, True
        try:
            self.device = None
            self.prepare()
            self.device = DeviceStrokes(self._edit, wish, before)
        finally:
            self._takes_over = False
            replaced, self._replaced = self._replaced, None
            if replaced is not None:
                replaced.close()
        obj = self._require()
        self._start, self._key = mesh_io.coordinates(obj), mesh_io.active_key(obj)
        self._shown, self._moved = self._start, 0.0
        self.tool = None

    def show_device(self, wish: Wish) -> str | None:
        """Guide the device that has the hand, and copy the newest positions into the mesh: what the timer does. Give the edit kind of a stroke that has
        come to its end and is in the mesh. After one that has cut the mesh the device goes on with a session of what it has become.
        """
        obj, edit = self._require(), self._edit
        if not edit.is_alive:
            raise pliant.PliantError("the engine stopped; leave the mode and enter it again", "panic")
        kind = self.device.advance(wish, self._seen, self._moved)
        if edit.is_cut():
            # A cut, and what broke, is shown when its stroke has ended.
            if kind is not None:
                self._show_cut(wish)
            return kind
        tool = edit.read(self._frame, self._inverse)
        if tool is not None:
            self.tool = tool
            mesh_io.set_coordinates(obj, self._frame)
            before, self._shown = self._shown, mesh_io.coordinates(obj)
            size = float(np.ptp(before, axis=0).max())
            # All vertices may be at one place.
            self._moved = float(np.abs(self._shown - before).max()) / size if size > 0.0 else 0.0
        self._until_taken -= 1
        if kind is not None:
            self._remember(False)
            self._keep_painting(kind)
            self._start = self._shown
        elif self._until_taken <= 0:
            self.device.keep_poses()
        if self._until_taken <= 0:
            self._until_taken = FRAMES_TAKEN
        return kind

    def _show_cut(self, wish: Wish) -> None:
        """Put a mesh that a device has cut, and come to rest, into Blender, and have the device go on with it without closing it."""
        obj, edit = self._require(), self._edit
        edit.pause()
        self._warnings += edit.take_refusals()
        topology.take_cut(obj, edit.mesh, edit.session)
        self._remember(True)
        self._hand_over(wish)

    def is_mesh_changed(self) -> bool:
        """Whether something else than the device has changed the mesh, as undo does."""
        obj = self._require()
        return mesh_io.active_key(obj) != self._key or not np.array_equal(mesh_io.coordinates(obj), self._shown)

    def end(self) -> bool:
        """End the stroke, or close the device that has the hand, and write what the hand did. Give whether that is a step of its own for undo."""
        obj = self._require()
        edit = self._edit
        is_stroke = is_step = True
        kind = self._kind
        if self.device is not None:
            kind = self.device.kind
            start, self.device = self.device.take_stroke(), None
            is_cut = edit.rest()
            if start is not None:
                edit.keep_stroke(start, edit.session.time)
            is_stroke = is_cut or start is not None
            # What was felt of a solid springs back, whatever motion is left; cloth may stay where it was pushed.
            is_cloth = self._settings.fabric is not None
            is_step = is_stroke or (is_cloth and self._differs(mesh_io.to_object(obj, edit.positions())))
        else:
            is_cut = edit.end()
        self.tool = None
        self._warnings += edit.take_refusals()
        if is_cut:
            topology.take_cut(obj, edit.mesh, edit.session)
        elif is_step:
            mesh_io.set_coordinates(obj, mesh_io.to_object(obj, edit.positions()))
        else:
            mesh_io.set_coordinates(obj, self._start)
        if is_stroke:
            self._remember(is_cut)
        if is_stroke and not is_cut:
            self._keep_painting(kind)
        if is_cut:
            # The topology is another one: the next stroke begins with it.
            self.close()
        return is_step

    def _keep_painting(self, kind: str) -> None:
        """Put what a stroke has pinned, freed or painted into the vertex groups of the panel. The session has it already, so it goes on; where a group's pins
        were freed, which a session fixes from its opening on, it is opened anew by the next stroke.
        """
        if kind not in painting.KINDS:
            return
        obj, edit = self._require(), self._edit
        pinned, (vertices, factors) = edit.painting()
        if kind == "unpin":
            freed = np.setdiff1d(self._stroke_pins, pinned)
            fixed = np.array(edit.settings.pinned, dtype=np.int64)
            if len(fixed):
                freed = np.union1d(freed, np.intersect1d(fixed, self._touched(kind)))
            painting.remove_pins(obj, freed)
        elif kind == "pin":
            painting.add_pins(obj, pinned)
        else:
            total = np.array(edit.settings.factors) if edit.settings.factors else np.ones(len(edit.mesh.vertices))
            total[vertices] *= factors
            short = painting.set_factors(obj, total, vertices)
            if short is not None:
                self._warnings.append(short)
        self._stroke_pins = pinned
        now = settings_of(obj, edit.mesh, self._is_open, [])
        if set(edit.settings.pinned) <= set(now.pinned):
            self._settings = replace(self._settings, pinned=now.pinned, factors=now.factors)
        else:
            self.is_stale = True

    def _touched(self, kind: str) -> np.ndarray:
        """Vertices within the brush of the last stroke."""
        edit, settings = self._edit, self._edit.settings
        places = edit.last_places(kind)
        if places is None:
            self._warnings.append(
                "what was held from the beginning stays so: where the hand has been is no longer known after 20 minutes; allowed is to leave the mode and enter it again"
            )
            return np.empty(0, dtype=np.int64)
        brush = settings.brush_radius(edit.mesh.size())
        return painting.touched_vertices(self._require(), places, settings.radius, brush, settings.symmetry)

    def _differs(self, places: np.ndarray) -> bool:
        """Whether coordinates are seen to be others than after the last stroke."""
        return bool(np.abs(places - self._start).max() > FELT_SHARE * np.ptp(self._start, axis=0).max())

    def _remember(self, is_cut: bool) -> None:
        """Have the stroke that has just ended baked next."""
        recording = self._edit.recording()
        if recording is None:
            self._warnings.append(
                "Bake Stroke no longer knows the last strokes: the hand has been there for more than 20 minutes since the session was opened; allowed is to leave the mode and enter it again"
            )
            return
        end = mesh_io.coordinates(self._require())
        bake.remember(bake.Take(self.name, self._key, recording, self._edit.mesh, self._inverse, self._start, end, is_cut))

    def drop(self) -> None:
        """Close the device that has the hand, and forget what it did since its last stroke: the mesh is another one now."""
        self.close()
        self.tool = None

    def close(self) -> None:
        """End the session; a device that has the hand is closed first."""
        handover.forget(self)
        self.device = None
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
