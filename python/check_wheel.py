#!/usr/bin/env python3
"""Checks what a wheel for Linux carries: its size, which libraries its own need, and that its tag promises no older C library than they run on.

    python python/check_wheel.py dist/pliant-*.whl

Needs `readelf` of binutils.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "backend"))
from manylinux import OF_THE_SYSTEM, needs  # noqa: E402

# Bytes of a wheel at most.
LARGEST = 10_000_000
TAG = re.compile(r"manylinux_(\d+)_(\d+)_(\w+)|linux_(\w+)")


def check(wheel: Path) -> list[str]:
    """What is wrong with a wheel."""
    wrong = []
    if (size := wheel.stat().st_size) > LARGEST:
        wrong.append(f"it has {size} bytes; allowed is {LARGEST}")
    newest, found = (0, 0), needs(wheel)
    for name, (others, version) in found.items():
        wrong += [f"{name} needs {other}; allowed are libraries of the C library and libgcc_s" for other in others if not OF_THE_SYSTEM.fullmatch(other)]
        newest = max(newest, version)
    if len(found) < 2:
        wrong.append("it has no libraries of plugins")
    tags = wheel.stem.split("-")[-1].split(".")
    for tag in tags:
        known = TAG.fullmatch(tag)
        if known is None:
            wrong.append(f"the platform `{tag}` is none of Linux; allowed is manylinux_X_Y_ARCH or linux_ARCH")
        elif known[1] is not None and (int(known[1]), int(known[2])) < newest:
            wrong.append(f"the tag `{tag}` promises glibc {known[1]}.{known[2]}; its libraries need {newest[0]}.{newest[1]}")
    print(f"{wheel.name}: {size} bytes, {len(found)} libraries, glibc {newest[0]}.{newest[1]} or later")
    return wrong


def main() -> int:
    """Check the wheels of the command line."""
    if len(sys.argv) < 2:
        raise SystemExit(__doc__)
    wrong = [f"{wheel}: {text}" for wheel in sys.argv[1:] for text in check(Path(wheel))]
    print("\n".join(wrong), end="\n" if wrong else "", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
