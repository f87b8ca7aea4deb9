"""What tests in a real window of Blender share: its folders, real events, pictures, and steps one after another. Run by Blender itself."""

import json
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path

import bpy
import numpy as np

# The folder with the package `pliant`, and the one of the results.
SITE, OUT = (Path(argument) for argument in sys.argv[sys.argv.index("--") + 1 :][:2])
ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(SITE), str(ROOT / "blender"), str(ROOT / "python" / "tests")]

# What a test has found, for `result.json`.
RESULT: dict = {}


def xdotool(*arguments) -> None:
    """Make real events."""
    subprocess.run(["xdotool", *map(str, arguments)], check=True)


def coordinates() -> np.ndarray:
    """Vertices of the cube (n x 3), in axes of the object."""
    mesh = bpy.data.objects["cube"].data
    flat = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def make_cube(size: float, radius: float) -> None:
    """Have a divided cube of this size as the only object, and a tool of this radius."""
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.mesh.primitive_cube_add(size=size)
    bpy.context.active_object.name = "cube"
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=20)
    bpy.ops.object.mode_set(mode="OBJECT")
    given = bpy.context.scene.haptic_edit
    given.level, given.radius = 5, radius
    bpy.ops.ed.undo_push(message="a cube")


def view():
    """The window, and area and region of its 3D view."""
    area = next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.window_manager.windows[0], area, region


def at(x: float, y: float) -> tuple[int, int]:
    """A place of the 3D view, as shares of its width and height, on the screen of the X server."""
    window, _, region = view()
    return int(region.x + x * region.width), int(window.height - (region.y + y * region.height))


def picture(name: str) -> None:
    """Write what the window shows."""
    window, area, region = view()
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.screen.screenshot(filepath=str(OUT / f"{name}.png"))


def until(is_true: Callable[[], bool]) -> Iterator[float]:
    """Wait until something is so, half a minute at most: a busy machine is slow."""
    for _ in range(300):
        if is_true():
            return
        yield 0.1
    raise AssertionError("it does not come about")


def expect(claims: dict[str, bool]) -> None:
    """Fail with the claims that are not true."""
    if wrong := [claim for claim, is_true in claims.items() if not is_true]:
        raise AssertionError(f"not so: {', '.join(wrong)}; found was {RESULT}")


def run(play: Callable[[], Iterator[float]]) -> None:
    """Do one thing after another, each yield gives Blender that many seconds; then write what was found and quit."""
    bpy.context.preferences.view.show_splash = False
    OUT.mkdir(parents=True, exist_ok=True)
    steps = play()

    def tick() -> float | None:
        try:
            wait = next(steps)
            return wait
        except StopIteration:
            pass
        except Exception:
            RESULT["error"] = traceback.format_exc()
        (OUT / "result.json").write_text(json.dumps(RESULT, indent=1))
        bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(tick, first_interval=1.0)
