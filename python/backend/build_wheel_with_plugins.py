"""Builds wheels: maturin's, with the built-in plugins inside.

Plugins are shared libraries of their own, which cargo builds from the workspace above; they go into ``pliant/plugins`` before maturin packs
the package. ``pip install ./python`` and ``pip wheel ./python`` come here.
"""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import manylinux
import maturin

HERE = Path(__file__).resolve().parent.parent
WORKSPACE = HERE.parent
PLUGINS = HERE / "pliant" / "plugins"

get_requires_for_build_wheel = maturin.get_requires_for_build_wheel
get_requires_for_build_editable = maturin.get_requires_for_build_editable
prepare_metadata_for_build_wheel = maturin.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = maturin.prepare_metadata_for_build_editable


def _target_folder() -> Path:
    return Path(os.environ.get("CARGO_TARGET_DIR") or HERE / "target").resolve()


def _build_plugins() -> None:
    """Build every plugin of the workspace and copy its library beside the module."""
    manifests = sorted((WORKSPACE / "plugins").glob("*/Cargo.toml"))
    if not manifests:
        raise SystemExit(f"{WORKSPACE / 'plugins'}: no plugins; the package is built from a checkout of the whole repository")
    names = [tomllib.loads(manifest.read_text())["package"]["name"] for manifest in manifests]
    environment = os.environ | {"CARGO_TARGET_DIR": str(_target_folder())}
    if sys.platform == "linux":
        # The plugin in C++ brings its library along: a wheel depends on libc alone.
        environment["CXXSTDLIB"] = "static:-bundle=stdc++"
    command = ["cargo", "build", "--release", "--lib", "--manifest-path", str(WORKSPACE / "Cargo.toml")]
    for name in names:
        command += ["--package", name]
    subprocess.run(command, check=True, env=environment)
    shutil.rmtree(PLUGINS, ignore_errors=True)
    PLUGINS.mkdir()
    for name in names:
        stem = name.replace("-", "_")
        built = [_target_folder() / "release" / file for file in (f"lib{stem}.so", f"lib{stem}.dylib", f"{stem}.dll")]
        found = [library for library in built if library.is_file()]
        if not found:
            raise SystemExit(f"{name}: cargo built no shared library in {_target_folder() / 'release'}")
        _strip(Path(shutil.copy2(found[0], PLUGINS)))


def _strip(library: Path) -> None:
    """Remove symbols, which are larger than the code; a system without the tool keeps them.

    A profile of cargo that strips would have all dependencies compiled again, which the workspace above has compiled already.
    """
    options = {"linux": ["--strip-all"], "darwin": ["-x"]}.get(sys.platform)
    if options and shutil.which("strip"):
        subprocess.run(["strip", *options, str(library)], check=True)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build the wheel, for the oldest Linux that it runs on."""
    _build_plugins()
    name = maturin.build_wheel(wheel_directory, config_settings, metadata_directory)
    return manylinux.retag(Path(wheel_directory) / name).name


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """Build an editable install: Python files are used where they are."""
    _build_plugins()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    """Refuse: a source distribution would lack the workspace the plugins are built from."""
    raise SystemExit("the package is built from a checkout of the whole repository; there is no source distribution")
