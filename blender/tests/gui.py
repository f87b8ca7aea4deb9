"""Real events in a real window: run by Blender itself, under an X server, with xdotool.

    xvfb-run -s "-screen 0 1280x800x24" blender --factory-startup --python-exit-code 1 --python blender/tests/gui.py -- SITE OUT

SITE is a folder with the package `pliant` in it, OUT gets pictures and `result.json`.
"""

import json
import subprocess
import sys
import traceback
from pathlib import Path

import bpy
import numpy as np

SITE, OUT = (Path(argument) for argument in sys.argv[sys.argv.index("--") + 1 :][:2])
sys.path[:0] = [str(SITE), str(Path(__file__).resolve().parents[1])]

import haptic_edit  # noqa: E402

RESULT: dict = {}


def xdotool(*arguments) -> None:
    subprocess.run(["xdotool", *map(str, arguments)], check=True)


def coordinates():
    mesh = bpy.data.objects["cube"].data
    flat = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def shown_at(frame: int):
    """Coordinates that Blender shows at a frame."""
    bpy.context.scene.frame_set(frame)
    shown = bpy.data.objects["cube"].evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(3 * len(shown.vertices), dtype=np.float32)
    shown.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def prepare() -> None:
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.mesh.primitive_cube_add(size=2.0)
    obj = bpy.context.active_object
    obj.name = "cube"
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=20)
    bpy.ops.object.mode_set(mode="OBJECT")
    given = bpy.context.scene.haptic_edit
    given.level, given.radius, given.strength = 5, 0.12, 1.0
    bpy.ops.ed.undo_push(message="a cube")


def view():
    area = next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.window_manager.windows[0], area, region


def picture(name: str) -> None:
    window, area, region = view()
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.screen.screenshot(filepath=str(OUT / f"{name}.png"))


def at(x: float, y: float) -> tuple[int, int]:
    """A place of the 3D view, as shares of its width and height, on the screen of the X server."""
    window, _, region = view()
    return int(region.x + x * region.width), int(window.height - (region.y + y * region.height))


def play():
    """One thing after another; each yield gives Blender that many seconds."""
    prepare()
    window, area, region = view()
    space = area.spaces.active
    space.region_3d.view_perspective = "ORTHO"
    space.region_3d.view_rotation = (1.0, 0.0, 0.0, 0.0)
    space.region_3d.view_distance = 6.0
    space.shading.type = "SOLID"
    space.shading.show_cavity = True
    yield 1.0
    xdotool("mousemove", *at(0.5, 0.5))
    yield 0.3
    with bpy.context.temp_override(window=window, area=area, region=region):
        RESULT["invoked"] = sorted(bpy.ops.object.haptic_edit("INVOKE_DEFAULT"))
    yield 0.5
    start = coordinates()
    # Press.
    xdotool("mousemove", *at(0.5, 0.5), "mousedown", 1)
    yield 1.0
    xdotool("mousemove", *at(0.52, 0.52))
    yield 0.7
    picture("press")
    xdotool("mouseup", 1)
    yield 1.0
    pressed = coordinates()
    RESULT["press"] = float((start[:, 2] - pressed[:, 2]).max())
    # Grab.
    xdotool("key", "2")
    yield 0.3
    RESULT["kind"] = bpy.context.scene.haptic_edit.kind
    xdotool("mousemove", *at(0.42, 0.5), "mousedown", 1)
    yield 0.5
    for step in range(1, 11):
        xdotool("mousemove", *at(0.42 - 0.01 * step, 0.5))
        yield 0.1
    picture("grab")
    xdotool("mouseup", 1)
    yield 1.0
    grabbed = coordinates()
    RESULT["grab"] = float((pressed[:, 0] - grabbed[:, 0]).max())
    # Undo and redo, by the keys of Blender.
    xdotool("key", "ctrl+z")
    yield 1.0
    RESULT["undone"] = bool(np.array_equal(coordinates(), pressed))
    xdotool("key", "ctrl+shift+z")
    yield 1.0
    RESULT["redone"] = bool(np.array_equal(coordinates(), grabbed))
    # The last stroke as an animation, taken back in one step.
    with bpy.context.temp_override(window=window, area=area, region=region):
        RESULT["baked"] = sorted(bpy.ops.object.haptic_bake("INVOKE_DEFAULT", True))
    keys = bpy.data.objects["cube"].data.shape_keys.key_blocks
    frames = [int(key.name.split()[1]) for key in keys[1:]]
    RESULT["frames"] = [frames[0], frames[-1], len(frames)]
    RESULT["baked end"] = float(np.abs(shown_at(frames[-1]) - grabbed).max())
    for name, frame in (("start", frames[0] - 2), ("middle", frames[len(frames) // 2]), ("end", frames[-1])):
        bpy.context.scene.frame_set(frame)
        yield 0.5
        picture(f"baked-{name}")
    bpy.context.scene.frame_set(1)
    yield 0.3
    xdotool("key", "ctrl+z")
    yield 1.0
    mesh = bpy.data.objects["cube"].data
    RESULT["bake undone"] = mesh.shape_keys is None and bool(np.array_equal(coordinates(), grabbed))
    # Size by F.
    before = bpy.context.scene.haptic_edit.radius
    xdotool("mousemove", *at(0.5, 0.5), "key", "f")
    yield 0.3
    xdotool("mousemove", *at(0.5, 0.55))
    yield 0.3
    xdotool("click", 1)
    yield 0.3
    RESULT["size"] = [before, bpy.context.scene.haptic_edit.radius]
    # Knife, from beside the cube to beyond it.
    space.overlay.show_wireframes = True
    space.overlay.wireframe_threshold = 1.0
    xdotool("key", "k")
    yield 0.3
    xdotool("mousemove", *at(0.5, 0.15), "mousedown", 1)
    yield 0.3
    for step in range(1, 36):
        xdotool("mousemove", *at(0.5, 0.15 + 0.02 * step))
        yield 0.06
    xdotool("mouseup", 1)
    yield 2.5
    mesh = bpy.data.objects["cube"].data
    RESULT["cut"] = [len(start), len(mesh.vertices), [slot.name for slot in bpy.data.objects["cube"].material_slots]]
    picture("cut")
    yield 0.3
    xdotool("key", "Escape")
    yield 0.5
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "edited.blend"))
    RESULT["done"] = True


def run() -> None:
    haptic_edit.register()
    steps = play()

    def tick():
        try:
            wait = next(steps)
            print("gui:", {key: RESULT[key] for key in list(RESULT)[-1:]}, flush=True)
            return wait
        except StopIteration:
            pass
        except Exception:
            RESULT["error"] = traceback.format_exc()
        (OUT / "result.json").write_text(json.dumps(RESULT, indent=1))
        bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(tick, first_interval=1.0)


bpy.context.preferences.view.show_splash = False
OUT.mkdir(parents=True, exist_ok=True)
run()
