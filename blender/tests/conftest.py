"""Blender as a Python module, with the extension enabled from its built zip."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

bpy = pytest.importorskip("bpy")

ROOT = Path(__file__).resolve().parents[2]
# The user of a device that datagrams move.
sys.path.append(str(ROOT / "python" / "tests"))


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """The extension's zip."""
    wheels = os.environ.get("PLIANT_WHEEL", "").split()
    if not wheels:
        pytest.skip("PLIANT_WHEEL names no wheel to build the extension with")
    out = tmp_path_factory.mktemp("dist")
    command = [sys.executable, ROOT / "blender" / "build.py", *wheels, "-o", out]
    return Path(subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip())


@pytest.fixture(scope="session")
def extension(built):
    """The package of the enabled extension."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(filepath=str(built), repo="user_default", enable_on_install=True)
    return sys.modules["bl_ext.user_default.haptic_edit"]


@pytest.fixture
def empty(extension):
    """A file with nothing in it."""
    bpy.ops.wm.read_homefile(use_empty=True)
    if not hasattr(bpy.types.Scene, "haptic_edit"):
        extension.register()
    return extension
