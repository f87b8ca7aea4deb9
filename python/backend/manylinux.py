"""The platform of a wheel for Linux, by the version of the C library that its own libraries need (PEP 600)."""

import platform
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

# Libraries of the system that every manylinux platform has.
OF_THE_SYSTEM = re.compile(r"(libc|libm|libdl|librt|libpthread|libutil|libgcc_s)\.so\.\d+|ld-linux-[\w-]+\.so\.\d+")
NEEDED = re.compile(r"\(NEEDED\).*\[(.+)\]")
GLIBC = re.compile(r"\bGLIBC_(\d+)\.(\d+)")


def _readelf(library, *options):
    return subprocess.run(["readelf", *options, library], check=True, capture_output=True, text=True).stdout


def needs(wheel):
    """What the libraries of a wheel need: for each, by its name in the wheel, the names of other libraries and the newest version of glibc."""
    found = {}
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
        for library in sorted(Path(folder).rglob("*.so")):
            versions = [(int(a), int(b)) for a, b in GLIBC.findall(_readelf(library, "--version-info", "--wide"))]
            others = NEEDED.findall(_readelf(library, "--dynamic", "--wide"))
            found[str(library.relative_to(folder))] = (others, max(versions, default=(0, 0)))
    return found


def retag(wheel):
    """Names a wheel by the oldest manylinux platform that it runs on, where it needs nothing else; give its path.

    A wheel of another system, and one that needs more than the C library, keeps its name, and so do all where `readelf` is missing.
    """
    tag = f"linux_{platform.machine()}"
    if sys.platform != "linux" or not wheel.stem.endswith(tag) or shutil.which("readelf") is None:
        return wheel
    found = needs(wheel)
    if not all(OF_THE_SYSTEM.fullmatch(other) for others, _ in found.values() for other in others):
        return wheel
    major, minor = max(version for _, version in found.values())
    command = [sys.executable, "-m", "wheel", "tags", "--remove", "--platform-tag", f"manylinux_{major}_{minor}_{platform.machine()}", str(wheel)]
    name = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()[-1]
    return wheel.with_name(name)
