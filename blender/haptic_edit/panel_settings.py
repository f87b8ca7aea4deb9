"""What the panel says of a mesh, as settings of a session."""

from __future__ import annotations

import bpy
import numpy as np

from . import mesh_io
from .editing import MeshArrays, Settings
from .properties import FACTORS, HapticSettings


def settings_of(obj: bpy.types.Object, mesh: MeshArrays, is_open: bool, warnings: list[str]) -> Settings:
    """What the panel says of the mesh of an object, which is cloth if it is open; what has no effect is added to `warnings`."""
    given = bpy.context.scene.haptic_edit
    is_sheet = given.substance == "SHEET" or (given.substance == "AUTO" and is_open)
    return Settings(
        young=1e3 * given.young,
        density=given.density,
        fabric=given.fabric if is_sheet else None,
        plugin=given.plugin,
        level=given.level,
        radius=given.radius * mesh.size(),
        symmetry="".join(axis for axis, is_set in zip("xyz", given.symmetry, strict=True) if is_set),
        pinned=_pinned(obj, given.pin_group, warnings),
        factors=_factors(obj, given, warnings),
        strength=given.brush_strength,
        paint_factor=given.paint_factor,
    )


def _pinned(obj: bpy.types.Object, name: str, warnings: list[str]) -> tuple[int, ...]:
    """Vertices with a weight of a half or more in the group that is held."""
    weights = _weights(obj, name, warnings)
    if weights is None:
        return ()
    pinned = np.flatnonzero(weights >= 0.5)
    if not len(pinned):
        warnings.append(f"vertex group `{name}` pins nothing: no weight is 0.5 or more")
    return tuple(pinned.tolist())


def _factors(obj: bpy.types.Object, given: HapticSettings, warnings: list[str]) -> tuple[float, ...]:
    """Factors of the stiffness by the weights of a group, geometric between those at 0 and 1."""
    weights = _weights(obj, given.stiffness_group, warnings)
    if weights is None:
        return ()
    # Single precision of the panel and the power may leave the range by their rounding.
    at_zero, at_one = np.clip([given.factor_at_zero, given.factor_at_one], *FACTORS)
    factors = np.clip(at_zero * (at_one / at_zero) ** weights, *FACTORS)
    if (factors == 1.0).all():
        name = given.stiffness_group
        warnings.append(f"vertex group `{name}` makes nothing stiffer or softer: its factor is 1 at every vertex")
        return ()
    return tuple(factors.tolist())


def _weights(obj: bpy.types.Object, name: str, warnings: list[str]) -> np.ndarray | None:
    """Weights of a vertex group that the panel names; None without one."""
    if not name:
        return None
    weights = mesh_io.group_weights(obj, name)
    if weights is None:
        known = ", ".join(f"`{group.name}`" for group in obj.vertex_groups) or "nothing: it has no groups"
        warnings.append(f"object `{obj.name}` has no vertex group `{name}`; allowed is {known}")
    return weights
