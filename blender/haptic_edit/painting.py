"""What strokes have pinned, freed and painted, kept in the vertex groups of the panel: so it outlives the session, and one undo step takes it back."""

from __future__ import annotations

import itertools

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from . import mesh_io
from .properties import FACTORS, HapticSettings

# Names of groups that are made where the panel names none.
PIN_GROUP, STIFFNESS_GROUP = "Pin", "Stiffness"
# Edit kinds whose strokes are kept here.
KINDS = ("pin", "unpin", "paint")
# Way of the hand between two places that are looked at, in radii of the tool.
WAY_SHARE = 0.5
# Rounding of a factor by the single precision of weights and settings.
ROUNDING = 1e-6


def add_pins(obj: bpy.types.Object, vertices: np.ndarray) -> None:
    """Add vertices to the group that is held; it is made if there is none."""
    if len(vertices):
        given = bpy.context.scene.haptic_edit
        group = _group(obj, given, "pin_group", PIN_GROUP)
        group.add(vertices.tolist(), 1.0, "REPLACE")


def remove_pins(obj: bpy.types.Object, vertices: np.ndarray) -> None:
    """Take vertices out of the group that is held."""
    group = obj.vertex_groups.get(bpy.context.scene.haptic_edit.pin_group)
    if group is not None and len(vertices):
        group.remove(vertices.tolist())


def set_factors(obj: bpy.types.Object, factors: np.ndarray, painted: np.ndarray) -> str | None:
    """Have the stiffness group give these factors of the stiffness (n), which strokes have painted at the vertices `painted`; it is made if there is none. The
    factors at its weights of 0 and 1 become 0.1 and 10 if a factor is beyond them, and all its weights follow. Give what falls short, if anything does.
    """
    if not len(painted):
        return None
    given = bpy.context.scene.haptic_edit
    group = _group(obj, given, "stiffness_group", STIFFNESS_GROUP)
    allowed = np.clip(factors, *FACTORS)
    low, high = sorted((given.factor_at_zero, given.factor_at_one))
    if low == high or allowed.min() < low * (1.0 - ROUNDING) or allowed.max() > high * (1.0 + ROUNDING):
        given.factor_at_zero, given.factor_at_one = FACTORS
        painted = np.arange(len(factors))
    at_zero, at_one = given.factor_at_zero, given.factor_at_one
    weights = np.clip(np.log(allowed / at_zero) / np.log(at_one / at_zero), 0.0, 1.0)
    order = painted[np.argsort(weights[painted], kind="stable")]
    for weight, same in itertools.groupby(order.tolist(), key=lambda vertex: float(weights[vertex])):
        group.add(list(same), weight, "REPLACE")
    beyond = int((np.abs(factors / allowed - 1.0) > ROUNDING).sum())
    if beyond == 0:
        return None
    return (
        f"the stiffness at {beyond} vertices is up to {factors.max():.3g} and down to {factors.min():.3g} times that of the material; "
        f"vertex group `{group.name}` keeps {FACTORS[0]} to {FACTORS[1]} times"
    )


def _group(obj: bpy.types.Object, given: HapticSettings, setting: str, name: str) -> bpy.types.VertexGroup:
    """The vertex group of the object that a setting names; made if there is none."""
    group = obj.vertex_groups.get(getattr(given, setting))
    if group is None:
        group = obj.vertex_groups.new(name=getattr(given, setting) or name)
        setattr(given, setting, group.name)
    return group


def touched_vertices(obj: bpy.types.Object, places: np.ndarray, radius: float, brush: float, symmetry: str) -> np.ndarray:
    """Vertices (n, ascending) within a `brush` (m) of where a ball of a radius (m) has touched the mesh with its centre at `places` (k x 3, m), and of their
    mirror images across axes through the middle of the mesh.
    """
    mesh = mesh_io.read_mesh(obj)
    tree = BVHTree.FromPolygons(mesh.vertices.tolist(), mesh.faces())
    used = mesh.vertices[mesh.corners]
    middle = 0.5 * (used.min(axis=0) + used.max(axis=0))
    is_touched = np.zeros(len(mesh.vertices), dtype=bool)
    for place in _thinned(places, WAY_SHARE * radius):
        contact, _, _, distance = tree.find_nearest(Vector(place))
        if contact is None or distance > radius:
            continue
        for mirrored in _images(np.array(contact), middle, symmetry):
            is_touched |= np.linalg.norm(mesh.vertices - mirrored, axis=1) <= brush
    return np.flatnonzero(is_touched)


def _thinned(places: np.ndarray, way: float) -> list[np.ndarray]:
    """Places along a path that are a way (m) or more from the one before, and the last."""
    kept: list[np.ndarray] = []
    for place in places:
        if not kept or np.linalg.norm(place - kept[-1]) >= way:
            kept.append(place)
    return [*kept, places[-1]] if kept else kept


def _images(place: np.ndarray, middle: np.ndarray, symmetry: str) -> list[np.ndarray]:
    """A place and its mirror images."""
    images = [place]
    for axis in symmetry:
        index = "xyz".index(axis)
        images += [np.where(np.arange(3) == index, 2.0 * middle - image, image) for image in images]
    return images
