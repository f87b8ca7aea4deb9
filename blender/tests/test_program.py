"""What strokes leave in Blender is what the program makes of the same hand, to single precision: press, pull, cut, undo and redo."""

import bpy
import numpy as np
import pytest
from program import Script, find_program, run_program, vertices_of
from strokes import add_grid_cube, coordinates, stroke

# Steps after an undo or redo, in which nothing is to happen.
REST = 40
# m, of a mesh of 0.2 m in single precision.
ROUNDING = 2e-8


def rotation_vector(quaternion):
    """Degrees, of a quaternion (x, y, z, w)."""
    axis, w = np.array(quaternion[:3]), quaternion[3]
    sine = np.linalg.norm(axis)
    return np.zeros(3) if sine == 0.0 else np.degrees(2.0 * np.arctan2(sine, w)) * axis / sine


def script_of(recording, dt):
    """The hand of a session, step by step; where it was away it goes to where it comes back, without a button, which begins nothing."""
    script, poses = Script(dt), [pose for part in recording.strokes for pose in part.poses]
    at = {round(pose.time / dt): pose for pose in poses}
    steps = sorted(at)
    for step in range(1, recording.strokes[-1].rest + 1):
        shown = at[steps[min(np.searchsorted(steps, step), len(steps) - 1)]]
        script.go([shown.position], shown.buttons if step in at else 0, rotation_vector(shown.rotation))
    return script


def of_program(extension, obj, recording, dt, folder, history=()):
    """Coordinates that the program leaves, with undos and redos after the strokes, in the axes of an object."""
    script = script_of(recording, dt)
    for kind in history:
        script.step_back(kind, REST)
    name = folder / f"{len(recording.strokes)}-{len(history)}"
    name.mkdir()
    scene = recording.scene
    vertices = vertices_of(run_program(scene, script, script.steps, name))
    return extension.mesh_io.to_object(obj, vertices)


@pytest.mark.parametrize("seed", range(2))
def test_strokes_and_their_undo_and_redo_leave_what_the_program_does(empty, tmp_path, monkeypatch, seed):
    find_program()
    # The hand of the program is never away: it must be where the next stroke begins before the mesh has come to rest.
    monkeypatch.setattr(empty.editing, "SPEED", 500.0)
    random = np.random.default_rng(seed)
    obj = add_grid_cube()
    name = obj.name
    bpy.ops.ed.undo_push(message="start")
    editing = empty.mode.Editing(obj)
    dt = 1e-3

    def check(history=()):
        """Compare Blender's mesh with the program's."""
        here = bpy.data.objects[name]
        expected = of_program(empty, here, recording, dt, tmp_path, history)
        assert len(expected) == len(here.data.vertices)
        assert np.abs(coordinates(here) - expected).max() <= ROUNDING, (len(recording.strokes), history)

    x, y = random.uniform(-0.03, 0.03, 2)
    stroke(empty, editing, "touch", [(x, y), (x + 0.02, y)], frames=8)
    recording = editing.edit.recording()
    check()
    pressed = coordinates(obj)
    stroke(empty, editing, "pull", [(-x, -y), (-x + 0.03, -y + 0.01)], frames=10)
    recording = editing.edit.recording()
    check()
    pulled = coordinates(obj)
    assert np.abs(pulled - pressed).max() > 3e-3
    bpy.ops.ed.undo()
    assert np.array_equal(coordinates(bpy.data.objects[name]), pressed)
    check(["undo"])
    bpy.ops.ed.redo()
    assert np.array_equal(coordinates(bpy.data.objects[name]), pulled)
    check(["undo", "redo"])
    # The session has what Blender has and goes on; its cut is the third stroke.
    for attempt in range(5):
        stroke(empty, editing, "cut", [(-0.15 + 0.01 * i, 0.013 + 0.002 * attempt) for i in range(31)], frames=2)
        if not editing.take_warnings():
            break
        bpy.ops.ed.undo()
    recording = empty.bake.last_take().recording
    assert recording.strokes[-1].rest > 0 and len(bpy.data.objects[name].data.vertices) > len(pulled)
    check()
    bpy.ops.ed.undo()
    assert np.array_equal(coordinates(bpy.data.objects[name]), pulled)
    check(["undo"])
    editing.close()
