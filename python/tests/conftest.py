"""Scenes that several tests use."""

import signal
from pathlib import Path

import numpy as np
import pytest

import pliant

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True, scope="session")
def interruptible():
    """Ctrl-C raises KeyboardInterrupt, also where a shell has started the tests in the background and with that signal ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def scenes() -> Path:
    """The scenes of the repository."""
    return ROOT / "scenes"


def block(cells: int = 6, edge: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n x 3, m) and quads (f x 4) of a closed cube around the origin."""
    index: dict[tuple[int, ...], int] = {}
    faces = []
    for axis in range(3):
        for side in (0, cells):
            for i in range(cells):
                for j in range(cells):
                    corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                    if side == 0:
                        corners.reverse()
                    face = []
                    for a, b in corners:
                        place = [0, 0, 0]
                        place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = side, a, b
                        face.append(index.setdefault(tuple(place), len(index)))
                    faces.append(face)
    vertices = np.array(list(index)) * edge / cells - edge / 2
    return vertices, np.array(faces)


def pressed(**tool) -> pliant.Scene:
    """A soft cube of arrays that stands on its bottom, with a hand that the test moves."""
    vertices, faces = block()
    scene = pliant.Scene()
    scene.time(duration=1.0, dt="1 ms")
    material = pliant.Material("mass-spring", young="20 kPa", density=1000, damping_time="0.5 ms")
    table = {"box": [[-1, -1, -0.051], [1, 1, -0.049]]}
    scene.body("cube", mesh=vertices, faces=faces, material=material, grid={"level": 4}, fixed=[table])
    scene.hand("hand")
    scene.tool("finger", radius="10 mm", stiffness="300 N/m", **tool)
    scene.edit("touch", tool="finger")
    return scene
