"""The topology that cuts have made of a mesh, put into Blender's: layers of its faces, corners and vertices are kept or interpolated."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
import pliant

from .editing import BODY, MeshArrays
from .mesh_io import set_coordinates, to_object, to_scene_matrix
from .walls import Walls

# Material slot of the faces that a cut makes inside of a mesh.
CAP_MATERIAL = "Cut"


def take_cut(obj: bpy.types.Object, before: MeshArrays, session: pliant.Session) -> None:
    """Give an object the topology that cuts have made of it. Faces without a cut stay as they are, with all their layers; pieces of the
    others get texture coordinates, colours, weights and shape keys by interpolation in the face they are of. Walls of the cut have
    a material of their own, and what vertices have goes on over them from their border.
    """
    pieces = session.mesh(BODY)
    rest = session.rest_positions(BODY)
    is_wall = pieces.face_of >= len(before.counts)
    on_faces = np.zeros(len(rest), dtype=bool)
    on_faces[pieces.triangles[~is_wall]] = True
    slot = _cap_slot(obj) if is_wall.any() else 0
    mesh = bmesh.new()
    try:
        mesh.from_mesh(obj.data)
        is_mirrored = np.linalg.det(to_scene_matrix(obj)[:3, :3]) < 0
        triangles = pieces.triangles[:, ::-1] if is_mirrored else pieces.triangles
        triangles = triangles.astype(np.int64)
        _rebuild(mesh, before, (triangles, pieces.face_of), rest, slot)
        _extend_over_walls(mesh, Walls(triangles[is_wall], rest, on_faces), to_object(obj, rest))
        mesh.to_mesh(obj.data)
    finally:
        mesh.free()
    set_coordinates(obj, to_object(obj, pieces.vertices))


def _cap_slot(obj: bpy.types.Object) -> int:
    """The slot of the material of walls, made if there is none."""
    names = [slot.material.name if slot.material else "" for slot in obj.material_slots]
    if CAP_MATERIAL in names:
        return names.index(CAP_MATERIAL)
    if not obj.data.materials:
        # What was there before keeps looking as it did.
        obj.data.materials.append(None)
    obj.data.materials.append(bpy.data.materials.get(CAP_MATERIAL) or bpy.data.materials.new(CAP_MATERIAL))
    return len(obj.data.materials) - 1


def _rebuild(
    mesh: bmesh.types.BMesh, before: MeshArrays, pieces: tuple[np.ndarray, np.ndarray], rest: np.ndarray, slot: int
) -> None:
    mesh.verts.ensure_lookup_table()
    mesh.faces.ensure_lookup_table()
    known = len(mesh.verts)
    faces = before.faces()
    of_face: dict[int, list[np.ndarray]] = {}
    for triangle, face in zip(*pieces, strict=True):
        of_face.setdefault(int(face), []).append(triangle)
    cut = [face for face in range(len(faces)) if not _is_whole(faces[face], of_face.get(face, []))]
    weights = {face: [_weights(triangle, faces[face], rest) for triangle in of_face.get(face, [])] for face in cut}
    # New vertices are means of those of the face they are on.
    parents: dict[int, tuple[list[int], np.ndarray]] = {}
    for face in cut:
        for triangle, rows in zip(of_face.get(face, []), weights[face], strict=True):
            for vertex, row in zip(triangle, rows, strict=True):
                if vertex >= known:
                    parents.setdefault(int(vertex), (faces[face], row))
    vertices = list(mesh.verts)
    for vertex in range(known, len(rest)):
        _new_vertex(mesh, parents.get(vertex), vertices)
    mesh.verts.ensure_lookup_table()
    old = list(mesh.faces)
    turned = {face for face in cut if _is_turned(old[face], of_face.get(face, []), rest)}
    for face in cut:
        order = slice(None, None, -1) if face in turned else slice(None)
        for triangle, rows in zip(of_face.get(face, []), weights[face], strict=True):
            made = _new_face(mesh, triangle[order], old[face])
            if made is not None:
                _interpolate_loops(mesh, made, (old[face], faces[face]), rows[order])
    # Walls turn as what they meet does.
    order = slice(None, None, -1) if 2 * len(turned) > len(cut) else slice(None)
    for triangle in of_face.get(len(faces), []):
        made = _new_face(mesh, triangle[order], None)
        if made is not None:
            made.material_index = slot
    bmesh.ops.delete(mesh, geom=[old[face] for face in cut], context="FACES_ONLY")
    bmesh.ops.delete(mesh, geom=[edge for edge in mesh.edges if edge.is_wire], context="EDGES")


def _is_whole(face: list[int], triangles: list[np.ndarray]) -> bool:
    """Whether triangles are those of the face itself, with all its vertices and no other."""
    return len(triangles) == len(face) - 2 and set(np.concatenate(triangles).tolist()) == set(face)


def _is_turned(face: bmesh.types.BMFace, triangles: list[np.ndarray], rest: np.ndarray) -> bool:
    """Whether the triangles of a face run the other way round than it: the engine takes faces that are turned over the right way round."""
    own = _area_vector(rest[[vertex.index for vertex in face.verts]])
    return bool(sum((own @ _area_vector(rest[triangle]) for triangle in triangles), 0.0) < 0)


def _area_vector(places: np.ndarray) -> np.ndarray:
    """Twice the vector area of a polygon."""
    return np.cross(places, np.roll(places, -1, axis=0)).sum(axis=0)


def _weights(triangle: np.ndarray, face: list[int], rest: np.ndarray) -> np.ndarray:
    """Weights (3 x k) of the corners of a face in each corner of a piece of it, by where they are at rest."""
    corners = rest[face]
    fan = np.array([[0, i, i + 1] for i in range(1, len(face) - 1)])
    rows = np.zeros((3, len(face)))
    for row, place in zip(rows, rest[triangle], strict=True):
        best = None
        for three in fan:
            a, b, c = corners[three]
            solved, *_ = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), place - a, rcond=None)
            bary = np.array([1 - solved.sum(), *solved])
            if best is None or bary.min() > best[0].min():
                best = (bary, three)
        bary = np.clip(best[0], 0.0, 1.0)
        row[best[1]] = bary / bary.sum()
    return rows


def _new_vertex(
    mesh: bmesh.types.BMesh, parent: tuple[list[int], np.ndarray] | None, vertices: list[bmesh.types.BMVert]
) -> None:
    if parent is None:
        mesh.verts.new((0.0, 0.0, 0.0))
        return
    numbers, weights = parent
    parents = [vertices[int(number)] for number in numbers]
    vertex = mesh.verts.new((0.0, 0.0, 0.0), parents[int(weights.argmax())])
    deform = mesh.verts.layers.deform.active
    if deform is not None:
        groups: dict[int, float] = {}
        for other, weight in zip(parents, weights, strict=True):
            for group, value in other[deform].items():
                groups[group] = groups.get(group, 0.0) + weight * value
        vertex[deform].clear()
        for group, value in groups.items():
            vertex[deform][group] = value
    # Blender adds to every shape key what the basis differs by from the places of the vertices, so these have to fit.
    vertex.co = _mean([other.co for other in parents], weights)
    for layer in mesh.verts.layers.shape.values():
        vertex[layer] = _mean([other[layer] for other in parents], weights)
    for layer in _averaged_layers(mesh):
        vertex[layer] = _mean([other[layer] for other in parents], weights)


def _averaged_layers(mesh: bmesh.types.BMesh) -> list[bmesh.types.BMLayerItem]:
    """Layers of vertices whose values have means."""
    layers = mesh.verts.layers
    return [layer for kind in (layers.float, layers.float_color, layers.color, layers.float_vector) for layer in kind.values()]


def _extend_over_walls(mesh: bmesh.types.BMesh, walls: Walls, rest: np.ndarray) -> None:
    """Give vertices inside of walls what their borders have. A shape key is extended as its displacement from rest (n x 3, of the object)."""
    if not len(walls.inner):
        return
    mesh.verts.ensure_lookup_table()
    border, inner = ([mesh.verts[int(vertex)] for vertex in part] for part in (walls.border, walls.inner))
    deform = mesh.verts.layers.deform.active
    if deform is not None:
        groups = sorted({group for vertex in border for group in vertex[deform].keys()})
        weights = np.array([[vertex[deform].get(group, 0.0) for group in groups] for vertex in border])
        for vertex, row in zip(inner, walls.extend(weights.reshape(len(border), len(groups))), strict=True):
            for group, weight in zip(groups, row, strict=True):
                if weight > 0.0:
                    vertex[deform][group] = min(float(weight), 1.0)
    for vertex, place in zip(inner, _extended_places(walls, rest, [vertex.co for vertex in border]), strict=True):
        vertex.co = place
    for layer in mesh.verts.layers.shape.values():
        for vertex, place in zip(inner, _extended_places(walls, rest, [vertex[layer] for vertex in border]), strict=True):
            vertex[layer] = place
    for layer in _averaged_layers(mesh):
        values = np.array([_row(vertex[layer]) for vertex in border])
        for vertex, row in zip(inner, walls.extend(values), strict=True):
            vertex[layer] = float(row[0]) if isinstance(vertex[layer], float) else tuple(row)


def _extended_places(walls: Walls, rest: np.ndarray, border: list) -> np.ndarray:
    """Places of the vertices inside of walls for those of the border, by displacements from rest."""
    moved = np.array([tuple(place) for place in border]).reshape(-1, 3) - rest[walls.border]
    return rest[walls.inner] + walls.extend(moved)


def _row(value) -> tuple[float, ...]:
    return (value,) if isinstance(value, float) else tuple(value)


def _new_face(
    mesh: bmesh.types.BMesh, triangle: np.ndarray, example: bmesh.types.BMFace | None
) -> bmesh.types.BMFace | None:
    corners = [mesh.verts[int(vertex)] for vertex in triangle]
    try:
        return mesh.faces.new(corners, example) if example is not None else mesh.faces.new(corners)
    except ValueError:
        # A face of the same vertices is there: Blender has each once.
        return None


def _interpolate_loops(
    mesh: bmesh.types.BMesh, made: bmesh.types.BMFace, face: tuple[bmesh.types.BMFace, list[int]], rows: np.ndarray
) -> None:
    """Give the corners of a piece the means of what the corners of its face have; weights are in the order of the vertices given."""
    of_vertex = {loop.vert.index: loop for loop in face[0].loops}
    sources = [of_vertex[int(vertex)] for vertex in face[1]]
    layers = mesh.loops.layers
    # Not `BMLoop.copy_from`, which copies the references of Python too.
    for loop, weights in zip(made.loops, rows, strict=True):
        nearest = sources[int(weights.argmax())]
        for layer in layers.uv.values():
            loop[layer].uv = _mean([source[layer].uv for source in sources], weights)
        for values in (layers.float, layers.float_color, layers.color, layers.float_vector):
            for layer in values.values():
                loop[layer] = _mean([source[layer] for source in sources], weights)
        for values in (layers.int, layers.string):
            for layer in values.values():
                loop[layer] = nearest[layer]


def _mean(values: list, weights: np.ndarray):
    if isinstance(values[0], float):
        return float(sum(w * v for w, v in zip(weights, values, strict=True)))
    return tuple(float(c) for c in weights @ np.array([tuple(value) for value in values]))
