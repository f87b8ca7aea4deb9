"""Blender meshes to arrays and back. Nothing here keeps a reference to Blender's data."""

from __future__ import annotations

import bpy
import numpy as np

from .editing import MeshArrays, Obstacle


def to_scene_matrix(obj: bpy.types.Object) -> np.ndarray:
    """The map (4 x 4) from the axes of an object to metres of the scene."""
    unit = bpy.context.scene.unit_settings.scale_length
    scale = np.diag([unit, unit, unit, 1.0])
    return scale @ np.array(obj.matrix_world, dtype=np.float64)


def active_key(obj: bpy.types.Object) -> str | None:
    """Name of the shape key that is edited; None for a mesh without shape keys."""
    has_keys = obj.data.shape_keys is not None and obj.active_shape_key is not None
    return obj.active_shape_key.name if has_keys else None


def coordinates(obj: bpy.types.Object) -> np.ndarray:
    """Coordinates of the base mesh, or of its active shape key, in the object's axes (n x 3, float32)."""
    return key_coordinates(obj, active_key(obj))


def set_coordinates(obj: bpy.types.Object, values: np.ndarray) -> None:
    """Put coordinates (n x 3, float32, in the object's axes) into the base mesh or its active shape key."""
    set_key_coordinates(obj, active_key(obj), values)


def key_coordinates(obj: bpy.types.Object, key: str | None) -> np.ndarray:
    """Coordinates of a shape key, or with None of the base mesh, in the object's axes (n x 3, float32)."""
    flat = np.empty(3 * len(obj.data.vertices), dtype=np.float32)
    if key is None:
        _vertices(obj.data, "foreach_get", flat)
    else:
        obj.data.shape_keys.key_blocks[key].data.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def set_key_coordinates(obj: bpy.types.Object, key: str | None, values: np.ndarray) -> None:
    """Put coordinates (n x 3, float32, in the object's axes) into a shape key, or with None into the base mesh."""
    flat = np.ascontiguousarray(values, dtype=np.float32).reshape(-1)
    if key is not None:
        obj.data.shape_keys.key_blocks[key].data.foreach_set("co", flat)
    if key is None or obj.data.shape_keys.key_blocks.find(key) == 0:
        # The mesh has the coordinates of its first key too.
        _vertices(obj.data, "foreach_set", flat)
    obj.data.update()


def _vertices(mesh: bpy.types.Mesh, method: str, flat: np.ndarray) -> None:
    position = mesh.attributes.get("position")
    if position is not None:
        # One block of memory; `vertices` goes vertex by vertex, a hundred times as slow.
        getattr(position.data, method)("vector", flat)
    else:
        getattr(mesh.vertices, method)("co", flat)


def read_mesh(obj: bpy.types.Object) -> MeshArrays:
    """The base mesh of an object in metres of the scene."""
    return _arrays(obj.data, coordinates(obj), to_scene_matrix(obj))


def read_obstacles(name: str) -> tuple[Obstacle, ...]:
    """The selected mesh objects other than the one with this name, with their modifiers, in metres of the scene; those without faces are left out."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    obstacles: dict[str, Obstacle] = {}
    for obj in bpy.context.view_layer.objects.selected:
        if obj.type != "MESH" or obj.name == name:
            continue
        evaluated = obj.evaluated_get(depsgraph)
        mesh = evaluated.to_mesh()
        try:
            if len(mesh.polygons):
                flat = np.empty(3 * len(mesh.vertices), dtype=np.float32)
                _vertices(mesh, "foreach_get", flat)
                arrays = _arrays(mesh, flat.reshape(-1, 3), to_scene_matrix(obj))
                # A scene does not allow all the characters that Blender does.
                of_scene = "".join("_" if c in '/\\,"' or not c.isprintable() else c for c in obj.name)
                while of_scene in obstacles:
                    of_scene += "_"
                obstacles[of_scene] = Obstacle(of_scene, arrays)
        finally:
            evaluated.to_mesh_clear()
    return tuple(obstacles.values())


def _arrays(mesh: bpy.types.Mesh, places: np.ndarray, matrix: np.ndarray) -> MeshArrays:
    """A mesh with its vertices at `places` (n x 3) of its own axes, through a map (4 x 4) to the scene."""
    vertices = transformed(matrix, places.astype(np.float64))
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    counts = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    corners, counts = corners.astype(np.int64), counts.astype(np.int64)
    if np.linalg.det(matrix[:3, :3]) < 0:
        # A mirrored object: faces are seen from their other side.
        starts = np.repeat(np.cumsum(counts) - counts, counts)
        ends = np.repeat(np.cumsum(counts) - 1, counts)
        corners = corners[starts + ends - np.arange(len(corners))]
    return MeshArrays(vertices, corners, counts)


def group_weights(obj: bpy.types.Object, name: str) -> np.ndarray | None:
    """Weight of each vertex in a vertex group (n), 0 outside of the group; None where the object has no such group."""
    group = obj.vertex_groups.get(name)
    if group is None:
        return None
    index = group.index
    weights = np.zeros(len(obj.data.vertices))
    for vertex in obj.data.vertices:
        for element in vertex.groups:
            if element.group == index:
                weights[vertex.index] = element.weight
    return weights


def to_object(obj: bpy.types.Object, places: np.ndarray) -> np.ndarray:
    """Places in metres of the scene (n x 3) in the axes of an object, float32."""
    return transformed(np.linalg.inv(to_scene_matrix(obj)), places).astype(np.float32)


def transformed(matrix: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Places (n x 3) through an affine map (4 x 4)."""
    return places @ matrix[:3, :3].T + matrix[:3, 3]
