"""Meshes and strokes that several tests use."""

import time

import bpy
import numpy as np

BACK = np.array([0.0, 0.0, 1.0])


def add_grid_cube(cuts: int = 10, size: float = 0.2):
    """A cube of quads with texture coordinates, a material and vertex groups."""
    bpy.ops.mesh.primitive_cube_add(size=size, calc_uvs=True)
    obj = bpy.context.active_object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=cuts)
    bpy.ops.object.mode_set(mode="OBJECT")
    group = obj.vertex_groups.new(name="low")
    group.add([v.index for v in obj.data.vertices if v.co.z < 0], 1.0, "REPLACE")
    obj.data.materials.append(bpy.data.materials.new("skin"))
    bpy.context.scene.haptic_edit.level = 4
    bpy.context.scene.haptic_edit.radius = 0.12
    return obj


def coordinates(obj):
    flat = np.empty(3 * len(obj.data.vertices), dtype=np.float32)
    obj.data.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def uv(obj):
    layer = obj.data.uv_layers.active.data
    flat = np.empty(2 * len(layer), dtype=np.float32)
    layer.foreach_get("uv", flat)
    return flat.reshape(-1, 2)


def ray_at(extension, x, y):
    return extension.gesture.Ray(np.array([x, y, 1.0]), np.array([0.0, 0.0, -1.0]))


def wait_for(editing, seconds):
    """Wait until the session of a stroke has gone on by a time (s)."""
    live = editing.edit._live
    goal, given_up = live.time + seconds, time.monotonic() + 120
    while live.time < goal:
        assert time.monotonic() < given_up, "the session goes on"
        time.sleep(0.002)


def stroke(extension, editing, kind, path, frames=20):
    """Press at the first place of a path, move along it, and let go. A frame is a 60th of a second of the session, however long a busy machine takes."""
    assert editing.begin(kind, ray_at(extension, *path[0]), BACK)
    for x, y in path:
        for _ in range(frames):
            editing.follow(ray_at(extension, x, y))
            editing.show(1 / 60)
            wait_for(editing, 1 / 60)
    editing.end()
    bpy.ops.ed.undo_push(message=f"Haptic {kind}")


def set_group(obj, name, weights):
    """A vertex group with a weight for each vertex; those of 0 are left out of it."""
    group = obj.vertex_groups.new(name=name)
    for vertex in np.flatnonzero(weights):
        group.add([int(vertex)], float(weights[vertex]), "REPLACE")
