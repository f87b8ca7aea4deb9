"""What the mode draws over the viewport: the force on the hand, and where the tool of a device is."""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import WeakSet

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

if TYPE_CHECKING:
    import pliant

    from .object_editing import Editing

COLOUR = (1.0, 0.55, 0.1, 1.0)
# Of the tool of a device that feels, that makes a stroke, and that touches nothing until it has come out of the mesh.
FEELS, WORKS, WAITS = (0.35, 0.75, 1.0, 1.0), (1.0, 0.85, 0.2, 1.0), (0.5, 0.5, 0.5, 1.0)
# Size of the mesh that an arrow of the largest force drawn so far takes.
ARROW_SHARE = 0.3
# Length and half width of the head of an arrow, shares of its length.
HEAD = (0.25, 0.1)
# Edges of a circle.
CIRCLE = 48

_overlays: WeakSet[Overlay] = WeakSet()


class Overlay:
    """Draws the force on the hand as an arrow that grows with it, and the tool of a device as a ball where the surface lets it be."""

    def __init__(self, editing: Editing) -> None:
        self._editing = editing
        self._largest = 0.0
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")
        _overlays.add(self)

    def remove(self) -> None:
        """Draw no more."""
        if self._handle is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
            self._handle = None

    def _draw(self) -> None:
        tool, edit, device = self._editing.tool, self._editing.edit, self._editing.device
        if tool is None or edit is None:
            return
        unit = bpy.context.scene.unit_settings.scale_length
        if device is not None and device.state.status == "ready":
            colour = WAITS if device.is_inside else WORKS if device.state.in_stroke else FEELS
            # Over the mesh: the ball is half inside of it.
            gpu.state.depth_test_set("NONE")
            _draw_lines(ball(tool.proxy, edit.settings.radius) / unit, colour, 1.5)
            _draw_lines(np.array([tool.hand, tool.proxy]) / unit, colour, 1.0)
        if bpy.context.scene.haptic_edit.show_force:
            self._draw_force(tool, edit.mesh.size(), unit)

    def _draw_force(self, tool: pliant.ToolState, size: float, unit: float) -> None:
        strength = float(np.linalg.norm(tool.force))
        self._largest = max(self._largest, strength)
        if strength <= 0.0:
            return
        along = ARROW_SHARE * size * tool.force / self._largest
        _draw_lines(arrow(tool.proxy, along) / unit, COLOUR, 3.0)


def remove_all() -> None:
    """Remove what is drawn: the extension is disabled."""
    for overlay in list(_overlays):
        overlay.remove()


def ball(centre: np.ndarray, radius: float) -> np.ndarray:
    """Three great circles as pairs of places (n x 3, m)."""
    angles = np.linspace(0.0, 2.0 * np.pi, CIRCLE + 1)
    circle = radius * np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    edges = np.stack([circle[:-1], circle[1:]], axis=1).reshape(-1, 3)
    return centre + np.concatenate([np.roll(edges, axis, axis=1) for axis in range(3)])


def arrow(start: np.ndarray, along: np.ndarray) -> np.ndarray:
    """An arrow as pairs of places (n x 3, m)."""
    tip, (length, width) = start + along, HEAD
    # Any two directions across it.
    first = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    second = np.cross(along, first) / np.linalg.norm(along)
    sides = [width * np.linalg.norm(along) * side / np.linalg.norm(side) for side in (first, -first, second, -second)]
    head = [place for side in sides for place in (tip, tip - length * along + side)]
    return np.array([start, tip, *head])


def _draw_lines(places: np.ndarray, colour: tuple[float, float, float, float], width: float) -> None:
    """Draw pairs of places (n x 3, in units of Blender)."""
    name = "UNIFORM_COLOR" if bpy.app.version >= (4, 0, 0) else "3D_UNIFORM_COLOR"
    shader = gpu.shader.from_builtin(name)
    batch = batch_for_shader(shader, "LINES", {"pos": [tuple(place) for place in places.tolist()]})
    gpu.state.line_width_set(width)
    shader.bind()
    shader.uniform_float("color", colour)
    batch.draw(shader)
    gpu.state.line_width_set(1.0)
