#!/usr/bin/env python3
"""Builds the extension: a zip for Blender 4.2 and later with the package `pliant` inside, as the wheel it is.

    pip wheel ./python --no-deps -w dist
    python blender/build.py dist/pliant-*.whl -o dist
"""

from __future__ import annotations

import argparse
import re
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCE = HERE / "haptic_edit"


def platform_of(wheel: Path) -> str:
    """The platform of a wheel, as Blender calls it."""
    tag = wheel.stem.rsplit("-", 1)[-1]
    systems = [("linux", "linux"), ("macosx", "macos"), ("win", "windows")]
    for start, system in systems:
        if tag.startswith((start, "many" + start)):
            is_arm = "arm64" in tag or "aarch64" in tag
            return f"{system}-{'arm64' if is_arm else 'x64'}"
    raise SystemExit(f"{wheel}: the platform `{tag}` is not one of Blender's; allowed are wheels for Linux, macOS and Windows")


def build(wheels: list[Path], out: Path) -> Path:
    """Write the zip of `wheels` into the folder `out`; give its path."""
    manifest = (SOURCE / "blender_manifest.toml").read_text()
    version = re.search(r'^version = "(.+)"', manifest, re.MULTILINE).group(1)
    platforms = sorted({platform_of(wheel) for wheel in wheels})
    manifest = manifest.replace("platforms = []", f"platforms = {_list(platforms)}")
    manifest = manifest.replace("wheels = []", f"wheels = {_list([f'./wheels/{wheel.name}' for wheel in wheels])}")
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"haptic_edit-{version}-{'_'.join(platforms)}.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("blender_manifest.toml", manifest)
        for file in sorted(SOURCE.glob("*.py")):
            archive.write(file, file.name)
        for licence in ("LICENSE-MIT", "LICENSE-APACHE"):
            archive.write(HERE.parent / licence, licence)
        for wheel in wheels:
            # Unmodified, and compressed already.
            archive.write(wheel, f"wheels/{wheel.name}", zipfile.ZIP_STORED)
    return path


def _list(texts: list[str]) -> str:
    return "[" + ", ".join(f'"{text}"' for text in texts) + "]"


def main() -> None:
    """Build what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheels", nargs="+", type=Path, help="wheels of the package, one for each platform")
    parser.add_argument("-o", "--out", type=Path, default=Path("dist"), help="folder for the zip")
    args = parser.parse_args()
    print(build(args.wheels, args.out))


if __name__ == "__main__":
    main()
