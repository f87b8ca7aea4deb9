"""The panel in the sidebar."""

from __future__ import annotations

import bpy

from .gesture import Gesture, gesture_of
from .preferences import preferences
from .properties import SOLIDS, strength_name


class HAPTIC_PT_panel(bpy.types.Panel):
    """What a mesh is made of, and the brush."""

    bl_label = "Haptic Edit"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Haptic"

    def draw(self, context: bpy.types.Context) -> None:
        layout, given = self.layout, context.scene.haptic_edit
        layout.use_property_split = True
        layout.operator("object.haptic_edit")
        layout.operator("object.haptic_bake")
        chosen = preferences()
        if chosen is not None:
            layout.prop(chosen, "device")
            if chosen.device != "MOUSE":
                layout.prop(chosen, "force_share")
        column = layout.column()
        column.prop(given, "kind")
        column.prop(given, "radius")
        if gesture_of(given.kind) is Gesture.PRESS:
            column.prop(given, "strength")
        if strength_name(given.kind) != "strength":
            column.prop(given, strength_name(given.kind))
        column.prop(given, "use_pressure")
        row = column.row(heading="Symmetry", align=True)
        for index, axis in enumerate("XYZ"):
            row.prop(given, "symmetry", index=index, text=axis, toggle=True)
        column.prop(given, "show_force")
        column = layout.column(heading="Material")
        column.prop(given, "substance")
        if given.substance != "SHEET":
            column.prop(given, "preset")
            row = column.column()
            row.enabled = given.preset not in SOLIDS
            row.prop(given, "young", text="Stiffness (kPa)")
            row.prop(given, "density", text="Density (kg/m³)")
            column.prop(given, "plugin")
            column.prop(given, "level")
        if given.substance != "SOLID":
            column.prop(given, "fabric")
        if context.active_object is not None and context.active_object.type == "MESH":
            column = layout.column()
            column.prop_search(given, "pin_group", context.active_object, "vertex_groups")
            column.prop_search(given, "stiffness_group", context.active_object, "vertex_groups", text="Stiffness")
            factors = column.column(align=True)
            factors.enabled = bool(given.stiffness_group)
            factors.prop(given, "factor_at_zero", text="Factor at 0")
            factors.prop(given, "factor_at_one", text="at 1")


CLASSES = (HAPTIC_PT_panel,)
