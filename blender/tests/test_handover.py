"""Strokes that are under way when a file is saved or closed, or when the extension is disabled."""

import threading

import bpy
import numpy as np
from strokes import BACK, add_grid_cube, coordinates, ray_at, wait_for


def press(extension, editing, frames=20):
    """Begin a press and keep on."""
    assert editing.begin("touch", ray_at(extension, 0.0, 0.0), BACK)
    for _ in range(frames):
        editing.follow(ray_at(extension, 0.0, 0.0))
        editing.show(1 / 60)
        wait_for(editing, 1 / 60)


def saved(path, name):
    """Coordinates of a mesh in a file."""
    with bpy.data.libraries.load(str(path)) as (_, into):
        into.meshes = [name]
    flat = np.empty(3 * len(into.meshes[0].vertices), dtype=np.float32)
    into.meshes[0].vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def test_a_file_saved_in_mid_stroke_has_what_the_hand_has_done(empty, tmp_path):
    obj = add_grid_cube()
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    press(empty, editing)
    path = tmp_path / "pressed.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    assert not editing.is_under_way, "the stroke has ended"
    after = coordinates(obj)
    assert (before - after)[:, 2].max() > 3e-3, "it was pressed"
    assert np.array_equal(saved(path, obj.data.name), after), "the file has the mesh of Blender"
    # At rest: what the engine has at the end of the stroke, and not a frame of it.
    expected = empty.mesh_io.to_object(obj, editing.edit.positions())
    assert np.abs(after - expected).max() <= 2e-8
    # The next stroke is one like any other.
    press(empty, editing, frames=5)
    editing.end()
    assert (after - coordinates(obj))[:, 2].max() > 0.0
    editing.close()


def test_a_stroke_ends_with_its_file(empty):
    threads = threading.active_count()
    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    press(empty, editing, frames=5)
    bpy.ops.wm.read_homefile(use_empty=True)
    assert not editing.is_under_way and editing.edit is None and editing.object() is None
    assert threading.active_count() == threads
    # The handlers outlive the file.
    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    press(empty, editing, frames=5)
    bpy.ops.wm.read_homefile(use_empty=True)
    assert editing.edit is None


def test_a_stroke_ends_when_the_extension_is_disabled(empty):
    obj = add_grid_cube()
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    press(empty, editing)
    saves = len(bpy.app.handlers.save_pre)
    empty.unregister()
    try:
        assert editing.edit is None and (before - coordinates(obj))[:, 2].max() > 3e-3
        assert len(bpy.app.handlers.save_pre) == saves - 1
    finally:
        empty.register()
