"""The extension as it is shipped: its zip and its manifest."""

import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import bpy
import pytest
from conftest import ROOT

# Blender's own tool for extensions, behind `blender --command extension`.
TOOL = next(Path(bpy.utils.resource_path("LOCAL")).rglob("bl_pkg/cli/blender_ext.py"), None)


def validated(path):
    return subprocess.run([sys.executable, TOOL, "validate", path], capture_output=True, text=True)


@pytest.mark.skipif(TOOL is None, reason="this Blender has no tool for extensions")
def test_the_zip_is_what_blender_takes_for_an_extension(built, tmp_path):
    assert validated(built).returncode == 0
    # A version that is none is found out.
    broken = tmp_path / "broken.zip"
    with zipfile.ZipFile(built) as source, zipfile.ZipFile(broken, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            is_manifest = name == "blender_manifest.toml"
            target.writestr(name, data.replace(b'version_max = "', b'version_max = "x') if is_manifest else data)
    assert validated(broken).returncode != 0


def test_this_release_is_one_the_manifest_allows():
    manifest = tomllib.loads((ROOT / "blender" / "haptic_edit" / "blender_manifest.toml").read_text())
    least, beyond = (tuple(map(int, manifest[f"blender_version_{end}"].split("."))) for end in ("min", "max"))
    assert least <= bpy.app.version < beyond


def test_the_extension_is_enabled(empty):
    assert bpy.ops.object.haptic_edit.idname() == "OBJECT_OT_haptic_edit"
    kinds = [item.identifier for item in empty.properties.kind_items(None, None) for item in [type("I", (), {"identifier": item[0]})]]
    assert {"touch", "pull", "cut"} <= set(kinds)
