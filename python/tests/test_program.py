"""A session stepped by Python and the program do the same, byte for byte: press, grab, cut, undo and redo."""

import numpy as np
import pytest
from conftest import block
from program import Script, find_program, run_program

import pliant

EDITS = ("touch", "grab", "cut")
TOUCH, GRAB, CUT = (1 << button for button in range(3))


def solid(random) -> pliant.Scene:
    """A cube of 100 mm with a finger that is a blade too."""
    vertices, faces = block(5)
    scene = pliant.Scene()
    scene.time(dt="1 ms", duration=1)
    material = pliant.Material("mass-spring", young=float(random.uniform(20e3, 200e3)), density=1000, damping_time="0.5 ms")
    scene.body("body", mesh=vertices, faces=faces, material=material, grid={"level": 4}, fixed=[{"box": [[-1, -1, -0.051], [1, 1, -0.049]]}])
    return scene


def sheet(random) -> pliant.Scene:
    """A square of cloth of 100 mm, held at two of its sides."""
    cells = 9
    grid = np.linspace(-0.05, 0.05, cells + 1)
    vertices = np.array([[x, y, 0.05] for y in grid for x in grid])
    corner = lambda i, j: j * (cells + 1) + i
    faces = [[corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)] for j in range(cells) for i in range(cells)]
    scene = pliant.Scene()
    scene.time(dt="1 ms", duration=1, integrator="backward-euler")
    held = [v for v, place in enumerate(vertices) if abs(place[1]) > 0.049]
    scene.body("body", mesh=vertices, faces=faces, material=pliant.Fabric("denim"), fixed=[{"nodes": held}])
    return scene


def tooled(scene: pliant.Scene) -> pliant.Scene:
    scene.hand("hand", peak_force="50 N")
    scene.tool("finger", hand="hand", radius="8 mm", stiffness="300 N/m", speed="20 m/s", blade={"length": "160 mm", "direction": [0, 1, 0]})
    for button, kind in enumerate(EDITS):
        keys = {} if kind == "cut" else {"release": "keep"}
        scene.edit(kind, tool="finger", button=button, **keys)
    return scene


def line(start, end, steps):
    return [np.asarray(start) + share * (np.asarray(end) - np.asarray(start)) for share in np.linspace(0.0, 1.0, steps)]


def strokes(random, slice_at: tuple[float, float]) -> tuple[Script, dict[str, int]]:
    """A press, a grab, a cut by a blade along y between two heights (m), two undos and two redos, and the steps after each."""
    script, after = Script(1e-3), {}
    x, y = random.uniform(-0.02, 0.02, 2)
    script.go(line([x, y, 0.065], [x, y, 0.05 + random.uniform(-0.004, 0.004)], 60), TOUCH)
    script.go(line([x, y, 0.05], [x, y, 0.08], 30))
    after["press"] = script.steps
    x, y = random.uniform(-0.02, 0.02, 2)
    script.go(line([x, y, 0.07], [x, y, 0.052], 20))
    script.go(line([x, y, 0.052], [x + 0.01, y, 0.065], 60), GRAB)
    script.go(line([x, y, 0.08], [-0.075, -0.08, 0.055], 30))
    after["grab"] = script.steps
    low, high = np.array(slice_at) + random.uniform(-0.005, 0.005, 2)
    script.go(line([-0.075, -0.08, 0.08], [-0.075, -0.08, low], 20))
    script.go(line([-0.07, -0.08, low], [0.07, -0.08, high], 70), CUT)
    script.go(line([0.075, -0.08, high], [0.075, -0.08, 0.12], 30))
    after["cut"] = script.steps
    for name, kind in [("undo", "undo"), ("second undo", "undo"), ("redo", "redo"), ("second redo", "redo")]:
        script.step_back(kind)
        after[name] = script.steps
    return script, after


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", [solid, sheet])
def test_a_session_and_the_program_leave_the_same_bytes(kind, seed, tmp_path):
    find_program()
    random = np.random.default_rng(seed)
    # Across a solid; through a sheet, which lies at 50 mm.
    scene, (script, after) = tooled(kind(random)), strokes(random, (0.01, 0.0) if kind is solid else (0.09, 0.02))
    history = dict(script.history)
    shapes = {}
    with pliant.Session(scene) as session:
        hand, names = session.hand("finger"), {steps: name for name, steps in after.items()}
        for step, (place, buttons) in enumerate(zip(script.places, script.buttons, strict=True)):
            if step in history:
                assert getattr(session, history[step])(), history[step]
            hand.go(place, buttons=[button for button in range(3) if buttons >> button & 1])
            session.step()
            if (name := names.get(session.steps)) is not None:
                session.write(tmp_path / f"{name}.obj")
                shapes[name] = (tmp_path / f"{name}.obj").read_bytes()
    for name, steps in after.items():
        assert run_program(scene, script, steps, tmp_path).read_bytes() == shapes[name], name
    # Each did something, and undo took it back.
    assert len({shapes[name] for name in ("press", "grab", "cut")}) == 3
    assert len(shapes["cut"].splitlines()) > len(shapes["grab"].splitlines()), "it was cut"
    assert len(shapes["undo"].splitlines()) == len(shapes["grab"].splitlines())
    assert len(shapes["second redo"].splitlines()) == len(shapes["cut"].splitlines())
