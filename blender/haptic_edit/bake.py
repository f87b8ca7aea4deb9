"""Bakes the last stroke into shape keys that show it frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np
import pliant
from bpy.props import IntProperty

from . import mesh_io
from .editing import MeshArrays
from .recording import Recording


@dataclass(frozen=True)
class Take:
    """A stroke on an object, with what is needed to make it again.

    Attributes
    ----------
    name : str
        The object.
    key : str or None
        The shape key that was edited; None for a mesh without shape keys.
    recording : Recording
        The session up to the end of the stroke.
    mesh : MeshArrays
        The mesh when the session was opened.
    inverse : ndarray
        From metres of the scene to the axes of the object (4 x 4).
    start, end : ndarray
        Coordinates before and after, in the axes of the object (n x 3, float32).
    is_cut : bool
        Whether it changed the topology.
    """

    name: str
    key: str | None
    recording: Recording
    mesh: MeshArrays
    inverse: np.ndarray
    start: np.ndarray
    end: np.ndarray
    is_cut: bool


# The stroke that was made last, until Blender ends.
_last: Take | None = None


def remember(take: Take) -> None:
    """Make a stroke the last one."""
    global _last
    _last = take


def last_take() -> Take | None:
    """The stroke that was made last, if there was one."""
    return _last


def forget() -> None:
    """Have no stroke any more."""
    global _last
    _last = None


def check(obj: bpy.types.Object, take: Take) -> None:
    """Raise why a stroke cannot be baked into an object, if it cannot."""
    if obj.name != take.name:
        raise _refused(f"the last stroke was on the object `{take.name}`; allowed is to bake it with that object active, not `{obj.name}`")
    if take.is_cut:
        raise _refused("the last stroke cut or broke the mesh, and shape keys cannot change its topology; allowed is a stroke that leaves it whole")
    if not mesh_io.read_mesh(obj).has_faces_of(take.mesh):
        raise _refused(f"the faces of `{obj.name}` are not those of the last stroke; allowed is to undo what changed them")
    keys = obj.data.shape_keys
    known = [] if keys is None else [block.name for block in keys.key_blocks]
    if (take.key is None) != (keys is None) or (take.key is not None and take.key not in known):
        was = "no shape keys" if take.key is None else f"the shape key `{take.key}`"
        raise _refused(f"`{obj.name}` had {was} when the last stroke was made and has {known or 'none'} now; allowed is to undo what changed them")
    if keys is not None and not keys.use_relative:
        raise _refused(f"the shape keys of `{obj.name}` are absolute; allowed are relative ones")
    now = mesh_io.key_coordinates(obj, take.key)
    if not (np.array_equal(now, take.end) or np.array_equal(now, take.start)):
        raise _refused(f"`{obj.name}` was edited after the last stroke; allowed is to undo to the stroke, or to make one")


def bake(obj: bpy.types.Object, take: Take, start: int, spacing: int) -> list[int]:
    """Give an object back the shape it had before a stroke, and shape keys every `spacing` frames that show the stroke from the frame `start` on.
    Give their frames.
    """
    check(obj, take)
    render = bpy.context.scene.render
    interval = spacing * render.fps_base / render.fps
    # All of them before the object changes: a fault of the engine leaves it as it was.
    shapes = [mesh_io.transformed(take.inverse, places).astype(np.float32) for places in take.recording.shapes(interval)]
    frames = [start + spacing * number for number in range(1, len(shapes) + 1)]
    mesh_io.set_key_coordinates(obj, take.key, take.start)
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    blocks = obj.data.shape_keys.key_blocks
    base = blocks[take.key or 0].name
    added = []
    for frame, shape in zip(frames, shapes, strict=True):
        block = obj.shape_key_add(name=f"Stroke {frame}", from_mix=False)
        block.data.foreach_set("co", shape.reshape(-1))
        block.relative_key = blocks[base]
        added.append(block.name)
    _animate(obj.data.shape_keys, added, frames, spacing)
    # What is edited next is what was edited before; a pinned key would hide the others.
    obj.active_shape_key_index = blocks.find(base)
    obj.show_only_shape_key = False
    obj.data.update()
    return frames


def _animate(keys: bpy.types.Key, names: list[str], frames: list[int], spacing: int) -> None:
    """Give each key the value 1 at its frame and 0 at those of its neighbours, linear between; the last one stays."""
    for name, frame in zip(names, frames, strict=True):
        block = keys.key_blocks[name]
        rows = [(frame - spacing, 0.0), (frame, 1.0)]
        if frame != frames[-1]:
            rows.append((frame + spacing, 0.0))
        for at, value in rows:
            block.value = value
            block.keyframe_insert("value", frame=at)
    paths = {keys.key_blocks[name].path_from_id("value") for name in names}
    for curve in _curves(keys.animation_data):
        if curve.data_path in paths:
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
            curve.update()


def _curves(animation: bpy.types.AnimData) -> Iterator[bpy.types.FCurve]:
    """Curves of what is animated: of its slot in the action, or before there were slots (Blender 4.4), of the action."""
    action = animation.action
    if not hasattr(animation, "action_slot"):
        yield from action.fcurves
        return
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(animation.action_slot)
            if bag is not None:
                yield from bag.fcurves


def _refused(text: str) -> pliant.PliantError:
    return pliant.PliantError(text)


class HAPTIC_OT_bake(bpy.types.Operator):
    """Make the last stroke an animation: shape keys that show it from the current frame on"""

    bl_idname = "object.haptic_bake"
    bl_label = "Bake Stroke"
    bl_options = {"REGISTER", "UNDO"}

    spacing: IntProperty(name="Frames per Key", description="Frames from one shape key to the next", default=2, min=1, soft_max=25)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.active_object
        if obj is None or obj.type != "MESH" or context.mode != "OBJECT":
            cls.poll_message_set("A stroke is baked into the active mesh, in Object Mode")
            return False
        if _last is None:
            cls.poll_message_set("No stroke was made yet")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        try:
            frames = bake(context.active_object, _last, scene.frame_current, self.spacing)
        except pliant.PliantError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        scene.frame_set(scene.frame_current)
        self.report({"INFO"}, f"The stroke is in {len(frames)} shape keys, from frame {scene.frame_current} to {frames[-1]}")
        return {"FINISHED"}


CLASSES = (HAPTIC_OT_bake,)
