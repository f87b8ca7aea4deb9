"""What a step costs from Python beside what the engine takes for it, and what a look at positions costs.

    python python/benches/overhead.py [MODEL.obj]
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import pliant

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "touch.toml"


def main(mesh: str | None) -> None:
    """Touch the model for half a second and print medians."""
    with pliant.Session(SCENE, mesh=mesh, set={"output.energy": False}, threads=1) as session:
        whole, inside, look, copy = [], [], [], []
        for _ in range(500):
            began = time.perf_counter()
            session.step()
            whole.append(time.perf_counter() - began)
            inside.append(session.frame.seconds)
        positions = session.positions()
        for _ in range(200):
            began = time.perf_counter()
            np.asarray(positions)
            look.append(time.perf_counter() - began)
            began = time.perf_counter()
            positions.copy()
            copy.append(time.perf_counter() - began)
        ratio = np.median(np.array(whole) / np.array(inside))
        print(f"{len(positions)} vertices, {session.frame.nodes} nodes, steps of {1e3 * session.dt:g} ms")
        print(f"step: median {1e6 * np.median(whole):.1f} us from Python, {1e6 * np.median(inside):.1f} us inside, ratio {ratio:.4f}")
        print(f"positions: {1e6 * np.median(look):.1f} us to look, {1e6 * np.median(copy):.1f} us to copy")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
