"""Haptic Edit: press, pull and cut meshes as if they were soft matter, with the engine of pliant."""

bl_info = {
    "name": "Haptic Edit",
    "author": "The pliant authors",
    "version": (0, 1, 0),
    # Extensions begin with 4.2; this is for those that are installed as add-ons.
    "blender": (3, 4, 0),
    "location": "3D Viewport > Sidebar > Haptic",
    "description": "Press, pull and cut meshes as if they were soft matter",
    "category": "Mesh",
}

if "bpy" in locals():
    import importlib

    for _module in (gesture, recording, editing, device_strokes, preferences, properties, mesh_io, topology, bake, panel_settings, handover, object_editing, device_mode, draw, mode, ui):  # noqa: F821
        importlib.reload(_module)

import bpy

from . import (
    bake,
    device_mode,
    device_strokes,
    draw,
    editing,
    gesture,
    handover,
    mesh_io,
    mode,
    object_editing,
    panel_settings,
    preferences,
    properties,
    recording,
    topology,
    ui,
)

_CLASSES = (*preferences.CLASSES, *mode.CLASSES, *bake.CLASSES, *ui.CLASSES)


def _menu(self, _context) -> None:
    self.layout.operator("object.haptic_edit")
    self.layout.operator("object.haptic_bake")


def register() -> None:
    """Enable the extension."""
    properties.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.VIEW3D_MT_object.append(_menu)
    handover.register()


def unregister() -> None:
    """Disable it."""
    handover.unregister()
    draw.remove_all()
    bpy.types.VIEW3D_MT_object.remove(_menu)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    properties.unregister()
    bake.forget()
    preferences.forget()
