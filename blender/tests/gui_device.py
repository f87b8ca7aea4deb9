"""A haptic device in a real window, with real events: run by Blender itself, under an X server, with xdotool.

    xvfb-run -s "-screen 0 1280x800x24" blender --factory-startup --python-exit-code 1 --python blender/tests/gui_device.py -- SITE OUT

SITE is a folder with the package `pliant` in it, OUT gets pictures and `result.json`. The device is `pointer`, which datagrams move.
"""

import math
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from gui_window import OUT, RESULT, at, coordinates, expect, make_cube, picture, run, until, view, xdotool  # noqa: E402

import addon_utils  # noqa: E402
from device_user import DeviceUser, is_free, thread_names  # noqa: E402

# Coordinates of a cube of 0.2 m that are the same but for the last motion of what was felt, m.
NEAR = 2e-4
HAPTIC_THREADS = {"haptic", "watchdog", "pliant-live"}


def prepare(user) -> None:
    """Enable the extension with the device of a user, on a cube."""
    addon_utils.enable("haptic_edit", default_set=True)
    given = bpy.context.preferences.addons["haptic_edit"].preferences
    given.device = "pointer"
    given.params["address"].value, given.params["hold"].value = user.address, "3600"
    make_cube(0.2, 0.1)


def play():
    """One thing after another; each yield gives Blender that many seconds."""
    user = DeviceUser()

    def go(*places, buttons=0, count=20):
        """Move the device through places (m)."""
        for start, end in zip(places, places[1:], strict=False):
            for share in np.linspace(0.0, 1.0, count):
                user.send((1 - share) * np.asarray(start) + share * np.asarray(end), buttons)
                user.force()
                yield 0.05

    def device():
        """What the mode knows of the device; None while it has no hand."""
        opened = list(sys.modules["haptic_edit"].handover._open)
        return opened[0].device if opened else None

    def is_finished():
        return device() is not None and not device().in_stroke

    prepare(user)
    window, area, region = view()
    space = area.spaces.active
    space.region_3d.view_perspective = "ORTHO"
    # From above and a little in front, so that the arrow is seen.
    space.region_3d.view_rotation = (math.cos(0.125), math.sin(0.125), 0.0, 0.0)
    space.region_3d.view_distance = 0.6
    space.shading.type = "SOLID"
    space.shading.show_cavity = True
    user.send([0, 0, 0.0])
    yield 1.0
    start = coordinates()
    xdotool("mousemove", *at(0.5, 0.5))
    yield 0.3
    with bpy.context.temp_override(window=window, area=area, region=region):
        RESULT["invoked"] = sorted(bpy.ops.object.haptic_edit("INVOKE_DEFAULT"))
    yield 1.0
    RESULT["threads"] = sorted(HAPTIC_THREADS & set(thread_names()))
    picture("inside")
    # Out towards the viewer, whose axes the device has, and back onto the mesh: felt.
    yield from go([0, 0, 0], [0, 0.02, 0.095])
    yield from go([0, 0.02, 0.095], [0, 0.02, 0.07])
    yield 1.0
    picture("felt")
    RESULT["felt"] = float(np.abs(coordinates() - start).max())
    RESULT["largest force"] = user.largest
    yield from go([0, 0.02, 0.07], [0, 0.02, 0.095])
    yield 1.0
    RESULT["sprung back"] = float(np.abs(coordinates() - start).max())
    # A stroke with the first button.
    yield from go([0, 0.02, 0.095], [0, 0.02, 0.065], buttons=1)
    picture("stroke")
    yield from go([0, 0.02, 0.065], [0, 0.02, 0.095])
    yield from until(is_finished)
    pressed = coordinates()
    RESULT["stroke"] = float(np.abs(pressed - start).max())
    picture("after stroke")
    # The tool by its key, its opposite by the second button.
    kinds = [item[0] for item in sys.modules["haptic_edit"].properties.kind_items(None, None)]
    xdotool("key", "1234567890"[kinds.index("inflate")])
    yield 0.5
    RESULT["kind"] = bpy.context.scene.haptic_edit.kind
    yield from go([0.02, -0.01, 0.095], [0.02, -0.01, 0.075])
    yield from go([0.02, -0.01, 0.075], [0.02, -0.01, 0.075], buttons=2)
    yield from go([0.02, -0.01, 0.075], [0.02, -0.01, 0.095])
    yield from until(is_finished)
    deflated = coordinates()
    RESULT["opposite"] = float(np.abs(deflated - pressed).max())
    # The view turns, and the hand with it.
    space.region_3d.view_rotation = (1.0, 0.0, 0.0, 0.0)
    yield 1.0
    picture("turned")
    # Undo by the key of Blender: the session is opened anew, and the device stays open.
    xdotool("key", "ctrl+z")
    yield from until(lambda: np.abs(coordinates() - pressed).max() < NEAR)
    xdotool("key", "ctrl+shift+z")
    yield from until(lambda: np.abs(coordinates() - deflated).max() < NEAR)
    yield from until(is_finished)
    RESULT["open again"] = not is_free(user.address)
    # Undo in the middle of a stroke takes it back.
    xdotool("key", "1")
    user.send([0, 0, 0.095])
    yield 1.0
    yield from go([0, 0, 0.095], [0, 0, 0.065], buttons=1)
    RESULT["in a stroke"] = [device().in_stroke, float(np.abs(coordinates() - deflated).max())]
    user.send([0, 0, 0.095])
    xdotool("key", "ctrl+z")
    yield from until(lambda: np.abs(coordinates() - deflated).max() < NEAR)
    yield from until(is_finished)
    # Saving ends the stroke under way, and the mode goes on.
    yield from go([0, 0, 0.095], [0, 0, 0.07], buttons=1)
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "edited.blend"), copy=True)
    saved = coordinates()
    RESULT["saved"] = float(np.abs(saved - deflated).max())
    yield from go([0, 0, 0.095], [0, 0, 0.07])
    yield 1.0
    picture("after save")
    RESULT["goes on"] = bool(not np.array_equal(coordinates(), saved))
    # Leaving closes the device.
    xdotool("key", "Escape")
    yield 1.0
    RESULT["left"] = [is_free(user.address), sorted(HAPTIC_THREADS & set(thread_names()))]
    # Disabling in the middle of a stroke does so too.
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.object.haptic_edit("INVOKE_DEFAULT")
    yield 0.5
    yield from go([0, 0, 0.095], [0, 0, 0.07], buttons=1)
    RESULT["second mode"] = not is_free(user.address)
    addon_utils.disable("haptic_edit")
    yield 1.0
    RESULT["disabled"] = [is_free(user.address), sorted(HAPTIC_THREADS & set(thread_names()))]
    picture("disabled")
    expect(
        {
            "the mode begins": RESULT["invoked"] == ["RUNNING_MODAL"],
            "the device has its threads": RESULT["threads"] == sorted(HAPTIC_THREADS),
            "what is felt is shown": RESULT["felt"] > NEAR and RESULT["largest force"] > 0.0,
            "what is felt springs back": RESULT["sprung back"] < NEAR,
            "a stroke stays": RESULT["stroke"] > NEAR,
            "a key chooses the tool": RESULT["kind"] == "inflate",
            "the second button does the opposite": RESULT["opposite"] > NEAR,
            "undo keeps the device open": RESULT["open again"],
            "a stroke is under way": RESULT["in a stroke"][0] and RESULT["in a stroke"][1] > NEAR,
            "saving keeps the stroke": RESULT["saved"] > NEAR,
            "the mode goes on after saving": RESULT["goes on"],
            "leaving closes the device": RESULT["left"] == [True, []],
            "the mode begins again": RESULT["second mode"],
            "disabling closes the device": RESULT["disabled"] == [True, []],
        }
    )
    RESULT["done"] = True


run(play)
