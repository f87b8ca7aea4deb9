"""Preferences of the extension: the haptic device that has the hand in the mode."""

from __future__ import annotations

import zlib

import bpy
import pliant
from bpy.props import CollectionProperty, EnumProperty, FloatProperty, StringProperty

from .device_strokes import DeviceChoice

# Blender keeps no reference to texts of enumerations that a function gives; this does.
_devices: list[tuple[str, str, str, str, int]] = []
_MOUSE = ("MOUSE", "Mouse or Pen of Blender", "The pointer is the hand", "NONE", 0)
_LIBRARY = ("LIBRARY", "Library by its Path", "A device plugin that is not installed, from an allowed folder", "NONE", 1)


def _device_items(_self, _context) -> list[tuple[str, str, str, str, int]]:
    if not _devices:
        # Libraries are opened for it, so not before somebody looks.
        found = [(device.id, device.name, device.summary, "NONE", _number_of(device.id)) for device in pliant.devices()]
        _devices.extend([_MOUSE, *found, _LIBRARY])
    return _devices


def _number_of(name: str) -> int:
    """The number that Blender stores for a device: the same one whatever other devices there are."""
    return (zlib.crc32(name.encode()) >> 1) | 2


def _list_params(self, _context) -> None:
    """Have a row for each parameter of the device that is chosen; what was given stays where it still has a meaning."""
    given = {row.name: row.value for row in self.params}
    self.params.clear()
    for device in pliant.devices():
        if device.id != self.device:
            continue
        for param in device.params:
            if param.type == "table":
                continue
            row = self.params.add()
            row.name, row.value = param.key, given.get(param.key, "")
            allowed = f" ({', '.join(param.choices)})" if param.choices else f" ({param.unit})" if param.unit not in ("", "1") else ""
            default = "" if param.default is None else f"; by default {param.default:g}" if isinstance(param.default, float) else f"; by default {param.default}"
            row.summary, row.is_path = f"{param.summary}{allowed}{default}", param.type == "path"


class HapticDeviceParam(bpy.types.PropertyGroup):
    """A parameter of a device; its name is the key."""

    value: StringProperty(name="Value", description="A number in the unit of the parameter or with another one, or a text; empty for the default")
    summary: StringProperty(name="Summary", description="What the parameter is")
    is_path: bpy.props.BoolProperty(name="Path", description="Whether it names a file")


class HapticPreferences(bpy.types.AddonPreferences):
    """The device that has the hand."""

    bl_idname = __package__

    device: EnumProperty(name="Hand", description="What moves the hand in Haptic Edit", items=_device_items, update=_list_params)
    library: StringProperty(name="Library", description="Path of the library, with # and an id if it has several devices")
    allowed: StringProperty(
        name="Allowed Folder", description="Folder whose libraries may be opened by their path, which runs their code here; none without it", subtype="DIR_PATH"
    )
    params: CollectionProperty(type=HapticDeviceParam)
    text: StringProperty(name="Parameters", description="Parameters of the library: key=value, separated by semicolons")
    force_share: FloatProperty(
        name="Force", description="Share of the force that the device can render", default=1.0, min=0.0, max=1.0, subtype="FACTOR"
    )

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "device")
        if self.device == "MOUSE":
            return
        layout.prop(self, "force_share")
        if self.device == "LIBRARY":
            layout.prop(self, "library")
            layout.prop(self, "text")
        column = layout.column()
        for row in self.params:
            column.prop(row, "value", text=row.name)
            column.label(text=row.summary)
        if self.device == "LIBRARY" or any(row.is_path for row in self.params):
            layout.prop(self, "allowed")


def preferences() -> HapticPreferences | None:
    """The preferences; None where the extension is not enabled as one, as in a script."""
    addon = bpy.context.preferences.addons.get(__package__)
    return None if addon is None else addon.preferences


def device_choice() -> DeviceChoice | None:
    """The device that shall have the hand; None for the pointer."""
    given = preferences()
    if given is None or given.device == "MOUSE":
        return None
    params = [(row.name, _path(row.value) if row.is_path else row.value) for row in given.params if row.value]
    plugin = given.device
    if plugin == "LIBRARY":
        if not given.library:
            raise pliant.PliantError("no library is given in the preferences of Haptic Edit; allowed is the path of one, or another hand")
        path, mark, name = given.library.partition("#")
        plugin = _path(path) + mark + name
        params = _params_of(given.text)
    allowed = (_path(given.allowed),) if given.allowed else ()
    return DeviceChoice(plugin, tuple(params), allowed)


def _path(given: str) -> str:
    """A path as other programs know it: `//` is the folder of the file in Blender."""
    return bpy.path.abspath(given)


def _params_of(text: str) -> list[tuple[str, str]]:
    """Parameters as text: `key=value; key=value`."""
    params = []
    for part in filter(None, (part.strip() for part in text.split(";"))):
        key, is_given, value = part.partition("=")
        if not is_given:
            raise pliant.PliantError(f"parameters of the device: `{part}`; allowed is key=value, separated by semicolons")
        params.append((key.strip(), value.strip()))
    return params


CLASSES = (HapticDeviceParam, HapticPreferences)


def forget() -> None:
    """Forget the devices that were found."""
    _devices.clear()
