"""What the mode does with a device frame by frame, with a viewport that the tests turn."""

import os
import subprocess
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from conftest import ROOT
from device_user import DeviceUser, free_address, is_free, thread_ids
from strokes import add_grid_cube, coordinates, stroke


def viewport():
    """A context whose viewport looks down."""
    region = SimpleNamespace(view_rotation=(1.0, 0.0, 0.0, 0.0))
    area = SimpleNamespace(spaces=SimpleNamespace(active=SimpleNamespace(region_3d=region)))
    return SimpleNamespace(area=area, scene=bpy.context.scene, view_layer=bpy.context.view_layer), region


def choice_of(extension, plugin, **params):
    return extension.device_strokes.DeviceChoice(plugin, tuple((key, str(value)) for key, value in params.items()))


def frames(editing, control, context, is_true, most=2000):
    """Go on frame by frame until something is so; give why the device was lost, if it was."""
    for _ in range(most):
        if editing.device is not None:
            live = editing.edit._live
            live.wait(live.wait(), 20.0)
        lost = control.tick(context)
        if lost is not None or is_true():
            return lost
    raise AssertionError(f"it does not come about: {editing.device and editing.device.state}")


@pytest.fixture
def mode(empty):
    """Gives the hand on a cube to a device, and closes it at the end."""
    opened = []

    def mode(plugin, **params):
        editing = empty.mode.Editing(add_grid_cube())
        context, region = viewport()
        opened.append(editing)
        return editing, empty.device_mode.give_hand(editing, choice_of(empty, plugin, **params), context), context, region

    yield mode
    for editing in opened:
        editing.close()


@pytest.mark.parametrize("seed", range(3))
def test_the_axes_of_the_device_are_those_of_the_viewport(mode, seed):
    user = DeviceUser()
    editing, control, context, region = mode("pointer", **user.params)
    random = np.random.default_rng(seed)
    for _ in range(3):
        w, x, y, z = turn = random.standard_normal(4) / 2
        turn = turn / np.linalg.norm(turn)
        region.view_rotation = tuple(turn)
        w, axis = turn[0], turn[1:]
        user.send([0.05, 0, 0])
        right = np.array([1.0, 0, 0]) + 2 * np.cross(axis, np.cross(axis, [1.0, 0, 0]) + w * np.array([1.0, 0, 0]))
        expected = 0.05 * 0.2 / 0.14 * right
        at = lambda: editing.device.state.position
        frames(editing, control, context, lambda: at() is not None and np.allclose(at(), expected, atol=1e-5))
    user.close()


def test_settings_that_hold_open_the_session_anew(mode):
    user = DeviceUser()
    editing, control, context, _ = mode("pointer", **user.params)
    user.send([0, 0, 0.095])
    frames(editing, control, context, lambda: editing.device.state.status == "ready")
    first = editing.edit
    context.scene.haptic_edit.radius = 0.2
    control.tick(context)
    assert editing.edit is first, "a slider that moves does not open it sixty times a second"
    frames(editing, control, context, lambda: editing.edit is not first)
    assert np.isclose(editing.edit.settings.radius, 0.2 * 0.2)
    user.close()


def test_undo_and_other_changes_of_the_mesh_open_the_session_anew(mode):
    user = DeviceUser()
    editing, control, context, _ = mode("pointer", **user.params)
    user.send([0, 0, 0.095])
    frames(editing, control, context, lambda: editing.device.state.status == "ready")
    first, obj = editing.edit, editing.object()
    obj.data.vertices[0].co.x -= 0.02
    obj.data.update()
    moved = coordinates(obj)
    control.tick(context)
    assert editing.edit is not first and editing.device is not None
    assert np.abs(coordinates(obj) - moved).max() < 1e-6
    user.close()


@pytest.mark.parametrize("change", ["settings", "mesh"])
def test_the_device_stays_open_and_is_felt_while_the_session_is_opened_anew(mode, change):
    user = DeviceUser()
    editing, control, context, _ = mode("pointer", **user.params)
    user.send([0, 0, 0.095])
    frames(editing, control, context, lambda: editing.device.state.status == "ready" and not editing.device.is_inside)
    for height in np.linspace(0.095, 0.06, 20):
        user.send([0, 0, height])
        frames(editing, control, context, lambda: True)
    frames(editing, control, context, lambda: editing.device.state.force[2] > 0.05)
    first, haptic, felt = editing.edit, thread_ids("haptic"), editing.device.state.force[2]
    if change == "settings":
        context.scene.haptic_edit.young *= 1.5
    else:
        obj = editing.object()
        obj.data.vertices[0].co.x -= 0.01
        obj.data.update()
    least = []
    user.force()

    def is_new():
        user.send([0, 0, 0.06])
        force = user.force()
        least.extend([] if force is None else [force[2]])
        return editing.edit is not first and len(least) > 60

    frames(editing, control, context, is_new)
    assert thread_ids("haptic") == haptic, "the device was closed and opened"
    assert min(least) > 0.4 * felt, f"{min(least)} N after {felt} N"
    assert not editing.device.is_inside
    user.send([0, 0, 0.095])
    frames(editing, control, context, lambda: not editing.device.state.force.any())
    user.close()


def test_a_device_that_is_lost_gives_the_hand_to_the_pointer(empty, mode):
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    programs = [target / profile / "pliant-twin-exoskeleton" for profile in ("release", "debug")]
    program = next((program for program in programs if program.exists()), None)
    if program is None:
        pytest.skip(f"no twin in {target}; `cargo build --release -p pliant-twin-exoskeleton` builds it")
    address = free_address()
    twin = subprocess.Popen([program, "--address", address, "--hand", "keyframed"], stdout=subprocess.PIPE, text=True)
    try:
        assert "ready" in twin.stdout.readline()
        editing, control, context, _ = mode("exoskeleton", peer=address, **{"lost-after": "0.3"})
        frames(editing, control, context, lambda: editing.device.state.status == "ready")
        before = coordinates(editing.object())
        twin.terminate()
        lost = frames(editing, control, context, lambda: False)
        assert "exoskeleton" in lost and editing.device is None
        assert np.abs(coordinates(editing.object()) - before).max() < 0.02
        # The pointer makes strokes in the same mode.
        before = coordinates(editing.object())
        stroke(empty, editing, "touch", [(0.0, 0.0)], frames=15)
        assert (before - coordinates(editing.object()))[:, 2].max() > 1e-3
    finally:
        twin.kill()
        twin.wait()
        twin.stdout.close()


def test_leaving_ends_a_stroke_as_if_the_button_had_been_let_go(mode):
    user = DeviceUser()
    editing, control, context, _ = mode("pointer", **user.params)
    obj = editing.object()
    before = coordinates(obj)
    user.send([0, 0, 0.095])
    frames(editing, control, context, lambda: editing.device.state.status == "ready" and not editing.device.is_inside)
    for height in np.linspace(0.095, 0.072, 15):
        user.send([0, 0, height], 1)
        frames(editing, control, context, lambda: True)
    frames(editing, control, context, lambda: editing.device.state.in_stroke and (before - coordinates(obj))[:, 2].max() > 2e-3)
    control.finish()
    assert editing.device is None and is_free(user.address)
    assert (before - coordinates(obj))[:, 2].max() > 1e-3
    user.close()
