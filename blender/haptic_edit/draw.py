"""What the mode draws over the viewport: the force on the hand."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

if TYPE_CHECKING:
    from .object_editing import Editing

COLOUR = (1.0, 0.55, 0.1, 1.0)
# Size of the mesh that an arrow of the largest force drawn so far takes.
ARROW_SHARE = 0.3


class Overlay:
    """Draws the force on the hand as an arrow that grows with it."""

    def __init__(self, editing: Editing) -> None:
        self._editing = editing
        self._largest = 0.0
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")

    def remove(self) -> None:
        """Draw no more."""
        if self._handle is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
            self._handle = None

    def _draw(self) -> None:
        tool, edit = self._editing.tool, self._editing.edit
        if tool is None or edit is None or not bpy.context.scene.haptic_edit.show_force:
            return
        size = float(np.linalg.norm(tool.force))
        self._largest = max(self._largest, size)
        if size <= 0.0:
            return
        unit = bpy.context.scene.unit_settings.scale_length
        tip = tool.proxy + ARROW_SHARE * edit.mesh.size() * tool.force / self._largest
        places = [tuple(tool.proxy / unit), tuple(tip / unit)]
        name = "UNIFORM_COLOR" if bpy.app.version >= (4, 0, 0) else "3D_UNIFORM_COLOR"
        shader = gpu.shader.from_builtin(name)
        batch = batch_for_shader(shader, "LINES", {"pos": places})
        gpu.state.line_width_set(3.0)
        shader.bind()
        shader.uniform_float("color", COLOUR)
        batch.draw(shader)
        gpu.state.line_width_set(1.0)
