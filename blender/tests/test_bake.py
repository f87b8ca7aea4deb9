"""A stroke as shape keys: what Blender shows at each frame is what the session was then."""

import math

import bpy
import numpy as np
import pytest
from strokes import add_grid_cube, coordinates, set_group, stroke


@pytest.fixture(autouse=True)
def no_stroke(extension):
    """No stroke of another test is left."""
    extension.bake.forget()


def evaluated(obj, frame):
    """Coordinates that Blender shows at a frame, in the object's axes, without modifiers that add vertices."""
    bpy.context.scene.frame_set(frame)
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    flat = np.empty(3 * len(shown.vertices), dtype=np.float32)
    shown.vertices.foreach_get("co", flat)
    obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh_clear()
    return flat.reshape(-1, 3)


def played_again(edit, seconds):
    """Positions (m) of a session of the mesh whose hand is scripted like that of all strokes, at times of the session."""
    import pliant

    scene = pliant.Scene(edit.scene.to_dict())
    scene._meshes, scene._factors = edit.scene._meshes, edit.scene._factors
    data = scene.to_dict()
    dt, strokes = edit.session.dt, edit.recording().strokes
    assert len(strokes) == 1, "a scripted hand cannot leave"
    poses = list(strokes[0].poses)
    params = data["device"][0]["params"]
    params["path"] = [[p.time, *p.position] for p in poses]
    # Half a step early, so that no rounding of the time makes it a step late; then the hand lets go.
    params["buttons"] = [[p.time - dt / 2, p.buttons] for p in poses] + [[poses[-1].time + dt / 2, 0]]
    again = pliant.Scene(data)
    again._meshes, again._factors = scene._meshes, scene._factors
    shapes = []
    with pliant.Session(again) as session:
        for second in seconds:
            session.step(round(second / dt) - session.steps)
            shapes.append(session.positions().copy())
    return shapes


def bake(**keys):
    return bpy.ops.object.haptic_bake("EXEC_DEFAULT", True, **keys)


@pytest.mark.parametrize(("fps", "spacing", "start"), [(24, 1, 1), (24, 3, -7), (30, 2, 100), (60, 5, 0)])
def test_a_baked_frame_is_the_session_at_that_time(empty, fps, spacing, start):
    scene = bpy.context.scene
    scene.render.fps = fps
    scene.frame_set(start)
    obj = add_grid_cube(cuts=7)
    obj.scale, obj.rotation_euler, obj.location = (1.0, 0.9, 1.1), (0.1, 0.0, 0.2), (0.01, 0.0, 0.02)
    bpy.context.view_layer.update()
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0), (0.03, 0.01)], frames=15)
    after, edit = coordinates(obj), editing.edit
    assert bake(spacing=spacing) == {"FINISHED"}
    keys = obj.data.shape_keys.key_blocks
    recorded = edit.recording().strokes[0]
    dt, interval = edit.session.dt, spacing / fps
    count = math.ceil((recorded.rest - recorded.start) * dt / interval)
    assert count >= 2 and [key.name for key in keys] == ["Basis"] + [f"Stroke {start + spacing * n}" for n in range(1, count + 1)]
    assert np.array_equal(evaluated(obj, start), before) and np.array_equal(evaluated(obj, start - 9), before)
    seconds = [recorded.start * dt + n * interval for n in range(1, count)] + [edit.session.steps * dt]
    # A scripted hand stays where it was when a live one leaves: the shape at rest is compared with the stroke's own.
    shapes = played_again(edit, seconds[:-1])
    expected = [empty.mesh_io.to_object(obj, shape) for shape in shapes] + [after]
    moved = 0.0
    for number, shape in enumerate(expected, 1):
        shown = evaluated(obj, start + spacing * number)
        # The rounding of float32 in basis + 1 (key - basis) at 0.2 m.
        assert np.abs(shown - shape).max() <= 2e-8, number
        moved = max(moved, float(np.abs(shown - before).max()))
    assert moved > 2e-3, "it was pressed"
    assert np.array_equal(evaluated(obj, start + spacing * (count + 50)), evaluated(obj, start + spacing * count)), "the last stays"
    editing.close()


def test_between_two_keys_the_shape_is_linear(empty):
    obj = add_grid_cube(cuts=5)
    bpy.context.scene.frame_set(1)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "pull", [(0.0, 0.0), (0.04, 0.0)], frames=20)
    bake(spacing=4)
    last = int(obj.data.shape_keys.key_blocks[-1].name.split()[1])
    for frame in range(5, last, 4):
        one, other = evaluated(obj, frame), evaluated(obj, frame + 4)
        for share in (1, 2, 3):
            assert np.abs(evaluated(obj, frame + share) - (one + share / 4 * (other - one))).max() < 5e-8
    assert last > 5 and np.abs(evaluated(obj, 5) - evaluated(obj, last)).max() > 1e-4
    editing.close()


def test_a_bake_is_one_step_of_undo(empty):
    obj = add_grid_cube(cuts=5)
    name = obj.name
    bpy.ops.ed.undo_push(message="start")
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=20)
    after = coordinates(obj)
    bake()
    count = len(obj.data.shape_keys.key_blocks)
    assert count > 3
    bpy.ops.ed.undo()
    obj = bpy.data.objects[name]
    assert obj.data.shape_keys is None and np.array_equal(coordinates(obj), after)
    bpy.ops.ed.redo()
    obj = bpy.data.objects[name]
    assert len(obj.data.shape_keys.key_blocks) == count
    last = max(int(key.name.split()[1]) for key in obj.data.shape_keys.key_blocks[1:])
    assert np.abs(evaluated(obj, last) - after).max() <= 2e-8
    editing.close()


def test_a_later_stroke_begins_with_what_earlier_ones_left(empty):
    obj = add_grid_cube(cuts=5)
    weights = (coordinates(obj)[:, 0] > 0).astype(float)
    set_group(obj, "right", weights)
    bpy.context.scene.haptic_edit.stiffness_group = "right"
    bpy.context.scene.frame_set(1)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=15)
    middle = coordinates(obj)
    stroke(empty, editing, "pull", [(0.05, 0.0), (0.08, 0.0)], frames=15)
    after = coordinates(obj)
    assert len(editing.edit.recording().strokes) == 2
    editing.close()
    bake(spacing=3)
    last = 1 + 3 * (len(obj.data.shape_keys.key_blocks) - 1)
    assert np.array_equal(evaluated(obj, 1), middle) and np.abs(evaluated(obj, last) - after).max() <= 2e-8


def test_a_stroke_on_a_shape_key_is_baked_on_top_of_it(empty):
    obj = add_grid_cube(cuts=5)
    for name in ("Basis", "wide", "high"):
        obj.shape_key_add(name=name)
    keys = obj.data.shape_keys.key_blocks
    wide = (coordinates(obj) * [1.2, 1.0, 1.0]).astype(np.float32)
    keys["wide"].data.foreach_set("co", wide.reshape(-1))
    keys["wide"].value = 1.0
    obj.active_shape_key_index = 1
    basis = empty.mesh_io.key_coordinates(obj, "Basis")
    bpy.context.scene.frame_set(1)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=15)
    after = empty.mesh_io.coordinates(obj)
    assert np.abs(after - wide).max() > 1e-3
    bake()
    names = [key.name for key in keys]
    assert names[:3] == ["Basis", "wide", "high"] and keys[3].relative_key == keys["wide"]
    assert np.array_equal(empty.mesh_io.key_coordinates(obj, "Basis"), basis) and obj.active_shape_key.name == "wide"
    last = int(names[-1].split()[1])
    assert np.abs(evaluated(obj, last) - after).max() <= 5e-8
    assert np.abs(evaluated(obj, 1) - wide).max() <= 5e-8
    editing.close()


def refused(*words):
    with pytest.raises(RuntimeError) as caught:
        bake()
    assert all(word in str(caught.value) for word in words), caught.value


def test_a_cut_is_refused(empty):
    obj = add_grid_cube(cuts=5)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "cut", [(-0.15 + 0.01 * i, 0.013) for i in range(31)], frames=2)
    vertices = len(obj.data.vertices)
    refused("cut or broke the mesh", "topology")
    assert obj.data.shape_keys is None and len(obj.data.vertices) == vertices
    editing.close()


def test_what_has_changed_since_the_stroke_is_refused(empty):
    obj = add_grid_cube(cuts=4)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=10)
    editing.close()
    after = coordinates(obj)
    # Another object.
    bpy.ops.mesh.primitive_cube_add()
    refused(f"`{obj.name}`", bpy.context.active_object.name)
    bpy.context.view_layer.objects.active = obj
    # Another shape.
    empty.mesh_io.set_coordinates(obj, after * np.float32(1.01))
    refused("edited after")
    empty.mesh_io.set_coordinates(obj, after)
    # Other keys.
    obj.shape_key_add(name="Basis")
    refused("no shape keys", "Basis")
    obj.shape_key_clear()
    # Other faces.
    bpy.ops.object.select_all(action="DESELECT")
    obj.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    refused("faces")


def test_without_a_stroke_there_is_nothing_to_bake(empty):
    add_grid_cube(cuts=2)
    assert not bpy.ops.object.haptic_bake.poll()
