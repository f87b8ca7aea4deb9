"""Settings of the mode, kept in the scene, and preferences."""

from __future__ import annotations

import bpy
import pliant
from bpy.props import BoolProperty, BoolVectorProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .editing import edit_kinds

SOLIDS = pliant.Material.presets()
# Least and greatest factor of a parameter that the engine lets differ from place to place.
FACTORS = (0.1, 10.0)

# Blender keeps no reference to texts of enumerations that a function gives; this does.
_texts: dict[str, list[tuple[str, str, str]]] = {}


def _items(name: str, make) -> list[tuple[str, str, str]]:
    if name not in _texts:
        _texts[name] = make()
    return _texts[name]


def kind_items(_self, _context) -> list[tuple[str, str, str]]:
    words = {"touch": "Press", "cut": "Knife"}
    make = lambda: [(kind, words.get(kind, kind.replace("-", " ").title()), text) for kind, text in edit_kinds().items()]
    return _items("kinds", make)


def kind_label(kind: str) -> str:
    """What an edit kind is called."""
    return next((name for known, name, _ in kind_items(None, None) if known == kind), kind)


def strength_name(kind: str) -> str:
    """Name of the setting that says how strong the strokes of an edit kind are."""
    if kind == "paint":
        return "paint_factor"
    return "brush_strength" if kind in pliant.edit_strengths() else "strength"


def _fabrics(_self, _context) -> list[tuple[str, str, str]]:
    return _items("fabrics", lambda: [(name, name.replace("-", " ").title(), text) for name, text in pliant.Fabric.presets().items()])


def _plugins(_self, _context) -> list[tuple[str, str, str]]:
    def make():
        # The `young` of cloth is a factor.
        is_solid = lambda plugin: any(param.key == "young" and param.unit == "Pa" for param in plugin.params)
        # A mesh of Blender does not follow elements that fail.
        can_fail = lambda plugin: any(param.key == "fracture-energy" for param in plugin.params)
        solids = [plugin for plugin in pliant.plugins("material") if is_solid(plugin) and not can_fail(plugin)]
        return [(plugin.id, plugin.name, plugin.summary) for plugin in solids]

    return _items("plugins", make)


def _use_preset(self, _context) -> None:
    preset = SOLIDS.get(self.preset)
    if preset is not None:
        self.young, self.density = preset.young / 1e3, preset.density


class HapticSettings(bpy.types.PropertyGroup):
    """What a mesh is made of, and the brush."""

    kind: EnumProperty(name="Tool", description="What the hand does", items=kind_items)
    substance: EnumProperty(
        name="Substance",
        items=[
            ("AUTO", "Automatic", "Closed meshes are solid, open ones are cloth"),
            ("SOLID", "Solid", "Filled: a grid inside carries the surface"),
            ("SHEET", "Cloth", "As thin as cloth: its own vertices carry it"),
        ],
        default="AUTO",
    )
    preset: EnumProperty(
        name="Material",
        items=[(name, name.title(), preset.source) for name, preset in SOLIDS.items()] + [("custom", "Custom", "Own numbers")],
        default="flesh",
        update=_use_preset,
    )
    plugin: EnumProperty(name="Model", description="The law of elasticity of a solid", items=_plugins)
    young: FloatProperty(
        name="Stiffness", description="Young's modulus of a solid, kPa", default=20.0, min=0.1, max=1e6, soft_max=5e3, precision=1
    )
    density: FloatProperty(name="Density", description="Mass of a solid, kg/m^3", default=1060.0, min=1.0, max=2e4)
    fabric: EnumProperty(name="Fabric", description="A measured fabric", items=_fabrics)
    level: IntProperty(
        name="Fineness", description="A solid has 2 to this power, halved, cells along its longest edge", default=6, min=3, max=9, soft_max=7
    )
    radius: FloatProperty(
        name="Size", description="Radius of the tool over the size of the mesh", default=0.06, min=0.005, max=0.5, subtype="FACTOR"
    )
    strength: FloatProperty(
        name="Depth", description="Depth of a press, in radii of the tool", default=0.5, min=0.05, max=2.0, subtype="FACTOR"
    )
    brush_strength: FloatProperty(
        name="Strength", description="Pressure or rate of the tool, over what it is by default", default=1.0, min=0.05, max=20.0, soft_max=4.0
    )
    paint_factor: FloatProperty(
        name="Factor", description="Factor of the stiffness that paint reaches", default=4.0, min=FACTORS[0], max=FACTORS[1]
    )
    use_pressure: BoolProperty(name="Pen Pressure", description="The pressure of a pen sets the depth of a press", default=True)
    symmetry: BoolVectorProperty(
        name="Symmetry", description="Mirrors the hand in planes through the middle of the mesh, across axes of the world", subtype="XYZ"
    )
    pin_group: StringProperty(name="Pin", description="Vertex group that is held: vertices with a weight of 0.5 or more")
    stiffness_group: StringProperty(
        name="Stiffness Group", description="Vertex group whose weights multiply the stiffness; inside of a solid the nearest place of the surface counts"
    )
    factor_at_zero: FloatProperty(
        name="At Weight 0", description="Factor of the stiffness at weight 0 and outside of the group", default=1.0, min=FACTORS[0], max=FACTORS[1]
    )
    factor_at_one: FloatProperty(
        name="At Weight 1", description="Factor of the stiffness at weight 1", default=FACTORS[1], min=FACTORS[0], max=FACTORS[1]
    )
    show_force: BoolProperty(name="Show Force", description="Draw the force on the hand", default=True)


CLASSES = (HapticSettings,)


def register() -> None:
    """Register the settings."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.haptic_edit = PointerProperty(type=HapticSettings)


def unregister() -> None:
    """Take them away again."""
    del bpy.types.Scene.haptic_edit
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    _texts.clear()
