#!/usr/bin/env python3
"""Drives the extension in a window of Blender with real events of pointer, keys and a device, and checks what comes of it.

    python blender/check_window.py dist/pliant-*.whl [-o OUT] [--blender PROGRAM]

Needs Blender, `xvfb-run` and `xdotool`. OUT, `target/blender-window` by default, gets the pictures of each drive and its `result.json`.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

TESTS = Path(__file__).resolve().parent / "tests"
DRIVES = ("gui", "gui_device")
# Longest time of a drive, s: on a quiet machine one takes a minute.
LONGEST = 600


def drive(name: str, blender: str, site: Path, out: Path) -> str | None:
    """Run a drive in Blender; what is wrong, if anything is."""
    out.mkdir(parents=True, exist_ok=True)
    result = out / "result.json"
    result.unlink(missing_ok=True)
    # Blender of a distribution takes the libraries of the first `python3` on the path.
    path = f"{Path(shutil.which(blender) or blender).parent}:{os.environ['PATH']}"
    screen = ["xvfb-run", "-a", "-s", "-screen 0 1280x800x24"]
    program = [blender, "--factory-startup", "--python-exit-code", "1", "--python", TESTS / f"{name}.py"]
    try:
        ended = subprocess.run([*screen, *program, "--", site, out], timeout=LONGEST, check=False, env={**os.environ, "PATH": path})
    except subprocess.TimeoutExpired:
        return f"it has not ended after {LONGEST} s"
    if not result.is_file():
        return f"Blender ended with code {ended.returncode} before the drive did"
    found = json.loads(result.read_text())
    return found.get("error")


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("wheel", type=Path)
    parser.add_argument("-o", "--out", type=Path, default=Path("target/blender-window"))
    parser.add_argument("--blender", default="blender", help="program of Blender; `blender` on the path by default")
    given = parser.parse_args()
    wrong = 0
    with tempfile.TemporaryDirectory() as site:
        zipfile.ZipFile(given.wheel).extractall(site)
        for name in DRIVES:
            error = drive(name, given.blender, Path(site), given.out.resolve() / name)
            print(f"{name}: {error or 'as expected'}", flush=True)
            wrong += error is not None
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
