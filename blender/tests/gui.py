"""Real events in a real window: run by Blender itself, under an X server, with xdotool.

    xvfb-run -s "-screen 0 1280x800x24" blender --factory-startup --python-exit-code 1 --python blender/tests/gui.py -- SITE OUT

SITE is a folder with the package `pliant` in it, OUT gets pictures and `result.json`.
"""

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from gui_window import OUT, RESULT, at, coordinates, expect, make_cube, picture, run, until, view, xdotool  # noqa: E402

import haptic_edit  # noqa: E402


def shown_at(frame: int):
    """Coordinates that Blender shows at a frame."""
    bpy.context.scene.frame_set(frame)
    shown = bpy.data.objects["cube"].evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(3 * len(shown.vertices), dtype=np.float32)
    shown.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def play():
    """One thing after another; each yield gives Blender that many seconds."""
    haptic_edit.register()
    make_cube(2.0, 0.12)
    bpy.context.scene.haptic_edit.strength = 1.0
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
    yield from until(lambda: np.array_equal(coordinates(), pressed))
    xdotool("key", "ctrl+shift+z")
    yield from until(lambda: np.array_equal(coordinates(), grabbed))
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
    yield from until(lambda: len(coordinates()) > len(start))
    mesh = bpy.data.objects["cube"].data
    RESULT["cut"] = [len(start), len(mesh.vertices), [slot.name for slot in bpy.data.objects["cube"].material_slots]]
    picture("cut")
    yield 0.3
    xdotool("key", "Escape")
    yield 0.5
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "edited.blend"))
    expect(
        {
            "the mode begins": RESULT["invoked"] == ["RUNNING_MODAL"],
            # Hundredths of the cube's 2 m.
            "a press goes in": RESULT["press"] > 0.02,
            "a key chooses the tool": RESULT["kind"] == "pull",
            "a pull draws out": RESULT["grab"] > 0.02,
            "strokes are baked": RESULT["baked"] == ["FINISHED"] and RESULT["frames"][2] > 1,
            "the last frame is the mesh": RESULT["baked end"] < 1e-6,
            "one undo takes the bake back": RESULT["bake undone"],
            "F makes the tool larger": RESULT["size"][1] > RESULT["size"][0],
            "walls of the cut have their material": RESULT["cut"][2] == ["", "Cut"],
        }
    )
    RESULT["done"] = True


run(play)
