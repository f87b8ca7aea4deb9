"""Strokes on Blender's meshes, without a window: what the modal operator does between two events."""

import time

import bmesh
import bpy
import numpy as np
import pytest
from conftest import ROOT
from strokes import BACK, add_grid_cube, coordinates, ray_at, set_group, stroke, uv, wait_for


def test_models_of_solids_are_the_materials_with_a_modulus(empty):
    plugins = {name for name, *_ in empty.properties._plugins(None, None)}
    assert not plugins & {"quasi-brittle", "tearing"}, "elements of these fail"
    assert {"mass-spring", "neo-hookean", "corotational"} <= plugins and "cloth" not in plugins


def test_a_press_goes_in_and_stays_and_all_else_is_kept(empty):
    obj = add_grid_cube()
    before, texture = coordinates(obj), uv(obj)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=30)
    after = coordinates(obj)
    sunk = before[:, 2] - after[:, 2]
    centre = np.linalg.norm(before - [0, 0, 0.1], axis=1) < 0.02
    depth = 0.5 * 0.12 * 0.2
    assert 0.3 * depth < sunk[centre].max() < depth, "the surface and the spring to the hand share the depth"
    assert np.abs(after - before)[before[:, 2] < 0].max() < 0.05 * depth, "what is far away stays"
    assert np.array_equal(uv(obj), texture) and all(len(p.vertices) == 4 for p in obj.data.polygons)
    assert [g.name for g in obj.vertex_groups] == ["low"] and obj.data.materials[0].name == "skin"
    editing.close()


def test_a_slow_viewport_presses_in_as_well(empty):
    obj = add_grid_cube()
    # As deep as the tool is thick: a hand that is there at once is inside of the mesh.
    bpy.context.scene.haptic_edit.strength = 1.2
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    assert editing.begin("touch", ray_at(empty, 0.0, 0.0), BACK)
    for _ in range(8):
        editing.show(0.7)
        wait_for(editing, 0.1)
    editing.end()
    editing.close()
    rise = coordinates(obj)[:, 2] - before[:, 2]
    depth = 1.2 * 0.12 * 0.2
    assert rise.min() < -0.3 * depth and rise.max() < 0.1 * depth


def test_a_stroke_is_what_the_program_makes_of_the_same_hand(empty):
    import pliant

    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0), (0.03, 0.01)], frames=15)
    edit = editing.edit
    used = list(edit.recording().strokes[0].poses)
    scene = pliant.Scene(edit.scene.to_dict())
    scene._meshes = edit.scene._meshes
    data = scene.to_dict()
    params = data["device"][0]["params"]
    params["path"] = [[p.time, *p.position] for p in used]
    # Half a step early, so that no rounding of the time makes it a step late; then the hand lets go.
    dt = edit.session.dt
    params["buttons"] = [[p.time - dt / 2, p.buttons] for p in used] + [[used[-1].time + dt / 2, 0]]
    again = pliant.Scene(data)
    again._meshes = edit.scene._meshes
    again.time(duration=edit.session.steps * edit.session.dt)
    result = pliant.run(again)
    expected = empty.mesh_io.to_object(obj, result.meshes["mesh"].vertices)
    assert np.abs(coordinates(obj) - expected).max() <= 2e-8, "to the rounding of float32 at 0.2 m"
    assert np.abs(expected[:, 2] - 0.1)[np.abs(expected[:, 2] - 0.1) < 0.02].max() > 2e-3, "it was pressed"
    editing.close()


def test_a_grab_pulls_out_and_undo_takes_it_back(empty):
    obj = add_grid_cube()
    name = obj.name
    bpy.ops.ed.undo_push(message="start")
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "pull", [(0.0, 0.0), (0.03, 0.0), (0.05, 0.0)], frames=15)
    pulled = coordinates(obj)
    moved = np.linalg.norm(pulled - before, axis=1)
    assert moved.max() > 0.01 and (pulled - before)[moved.argmax(), 0] > 0
    bpy.ops.ed.undo()
    obj = bpy.data.objects[name]
    assert np.array_equal(coordinates(obj), before)
    bpy.ops.ed.redo()
    obj = bpy.data.objects[name]
    assert np.array_equal(coordinates(obj), pulled)
    # The mode goes on with what Blender has.
    stroke(empty, editing, "touch", [(-0.05, -0.05)], frames=15)
    assert not np.array_equal(coordinates(bpy.data.objects[name]), pulled)
    editing.close()


def test_a_cut_parts_a_cube_and_keeps_what_it_had(empty):
    obj = add_grid_cube(cuts=6)
    name = obj.name
    obj.shape_key_add(name="Basis")
    for point in obj.shape_key_add(name="large").data:
        point.co *= 2.0
    bpy.ops.ed.undo_push(message="start")
    faces, vertices = len(obj.data.polygons), len(obj.data.vertices)
    editing = empty.mode.Editing(obj)
    bpy.context.scene.haptic_edit.plugin = "mass-spring"
    # Where the blade is at each step depends on how busy the machine is, and it can meet the mesh so that a splinter would be left.
    for _ in range(5):
        stroke(empty, editing, "cut", [(-0.15 + 0.01 * i, 0.013) for i in range(31)], frames=2)
        if not editing.take_warnings():
            break
        bpy.ops.ed.undo()
        obj = bpy.data.objects[name]
    mesh = obj.data
    assert len(mesh.vertices) > vertices and len(mesh.polygons) > faces
    names = [slot.material.name for slot in obj.material_slots]
    assert names == ["skin", "Cut"]
    caps = [p for p in mesh.polygons if p.material_index == 1]
    # The blade bends what it goes through, and vertices inside of the walls show it: 0.080 to 0.091, and 0.937 and more of it as flat as the path of the
    # blade, in 40 cuts on a machine with five others waiting. A wall that is missing, twice there or torn is half or twice as large, or not flat.
    assert sum(p.area for p in caps) == pytest.approx(2 * 0.2**2, rel=0.2)
    assert sum(abs(p.normal.y) * p.area for p in caps) > 0.9 * sum(p.area for p in caps)
    quads = [p for p in mesh.polygons if len(p.vertices) == 4]
    assert len(quads) > 0.7 * faces, "faces without a cut are still quads"
    # Texture coordinates are a function of the place on each side of the cube, as before.
    assert len(mesh.uv_layers) == 1
    inner = lambda p: all(max(abs(c) for c in mesh.vertices[v].co.xy) < 0.095 for v in p.vertices)
    top = [p for p in mesh.polygons if p.center.z > 0.09 and p.material_index == 0 and inner(p)]
    rows = [(1.0, *mesh.vertices[mesh.loops[i].vertex_index].co.xy, *mesh.uv_layers[0].data[i].uv) for p in top for i in p.loop_indices]
    rows = np.array(rows)
    fit, *_ = np.linalg.lstsq(rows[:, :3], rows[:, 3:], rcond=None)
    # A side is a quarter of the texture; the blade has moved what is near it by up to a hundredth of the side.
    assert np.abs(rows[:, :3] @ fit - rows[:, 3:]).max() < 0.01 * 0.25
    weights = empty.mesh_io.group_weights(obj, "low")
    on_faces = {v for p in mesh.polygons if p.material_index == 0 for v in p.vertices}
    for vertex in on_faces:
        z = mesh.vertices[vertex].co.z
        assert abs(z) < 0.05 or weights[vertex] == pytest.approx(float(z < 0))
    # What vertices have goes on over a wall, which has some inside.
    inner = np.array([v.index for v in mesh.vertices if v.index not in on_faces])
    heights = coordinates(obj)[inner, 2]
    assert len(inner) > 20 and (weights[inner] >= 0.0).all() and (weights[inner] <= 1.0).all()
    assert weights[inner[heights < -0.04]].min() > 0.5 > weights[inner[heights > 0.04]].max()
    # Twice the size, to twice what the blade has moved and what the extension does not give back of a linear function. The key of a vertex that has the place
    # of the basis there is off by as much as it is from the middle, 0.07 in the median.
    large = np.array([point.co for point in mesh.shape_keys.key_blocks["large"].data])
    assert np.median(np.linalg.norm(large - 2.0 * coordinates(obj), axis=1)[inner]) < 0.02
    # No face is left without its neighbour.
    assert mesh.validate() is False
    whole = bmesh.new()
    whole.from_mesh(mesh)
    assert all(edge.is_manifold for edge in whole.edges)
    whole.free()
    cut = len(mesh.vertices)
    bpy.ops.ed.undo()
    assert len(bpy.data.objects[name].data.vertices) == vertices
    bpy.ops.ed.redo()
    assert len(bpy.data.objects[name].data.vertices) == cut
    stroke(empty, editing, "touch", [(0.0, 0.06)], frames=10)
    editing.close()


def test_objects_are_edited_in_world_units_whatever_their_transform(empty):
    obj = add_grid_cube()
    obj.scale, obj.rotation_euler, obj.location = (2.0, 1.0, 0.5), (0.3, 0.0, 0.2), (0.0, 0.05, 0.1)
    bpy.context.view_layer.update()
    obj.modifiers.new("smooth", "SUBSURF")
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.05)], frames=20)
    moved = (coordinates(obj) - before) @ np.array(obj.matrix_world.to_3x3()).T
    assert moved[:, 2].min() < -2e-3 and len(coordinates(obj)) == len(before)
    editing.close()


def test_every_edit_kind_of_the_engine_changes_the_mesh_and_keeps_it_finite(empty):
    for kind in empty.editing.edit_kinds():
        bpy.ops.wm.read_homefile(use_empty=True)
        obj = add_grid_cube()
        before = coordinates(obj)
        # Something to smooth: a ridge.
        before[(before[:, 2] > 0.09) & (np.abs(before[:, 0]) < 0.01), 2] += 0.01
        empty.mesh_io.set_coordinates(obj, before)
        editing = empty.mode.Editing(obj)
        stroke(empty, editing, kind, [(-0.02 + 0.004 * i, 0.013) for i in range(11)], frames=3)
        after = coordinates(obj)
        assert np.isfinite(after).all(), kind
        # Far more than the rounding of a coordinate of 0.1 m; how much depends on the time that the machine had for the stroke.
        assert len(after) != len(before) or np.abs(after - before).max() > 1e-6, kind
        editing.close()


def test_symmetry_does_the_same_on_both_sides(empty):
    obj = add_grid_cube()
    bpy.context.scene.haptic_edit.symmetry = (True, False, False)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.05, 0.0)], frames=20)
    after = coordinates(obj)
    mirrored = after * [-1, 1, 1]
    distance = np.linalg.norm(after[:, None] - mirrored[None], axis=2).min(axis=1)
    assert distance.max() < 1e-5 and (0.1 - after[after[:, 2] > 0.05][:, 2]).max() > 2e-3
    editing.close()


def test_shape_keys_take_the_stroke_of_their_own(empty):
    obj = add_grid_cube()
    obj.shape_key_add(name="Basis")
    obj.shape_key_add(name="pressed")
    obj.active_shape_key_index = 1
    basis = coordinates(obj)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=20)
    keys = obj.data.shape_keys.key_blocks
    flat = np.empty(basis.size, dtype=np.float32)
    keys["Basis"].data.foreach_get("co", flat)
    assert np.array_equal(flat.reshape(-1, 3), basis)
    keys["pressed"].data.foreach_get("co", flat)
    assert np.abs(flat.reshape(-1, 3) - basis).max() > 2e-3
    editing.close()


def test_open_meshes_are_cloth_and_pins_hold(empty):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=16, y_subdivisions=16, size=0.2)
    obj = bpy.context.active_object
    group = obj.vertex_groups.new(name="pin")
    held = [v.index for v in obj.data.vertices if abs(v.co.x) > 0.099]
    group.add(held, 1.0, "REPLACE")
    given = bpy.context.scene.haptic_edit
    given.pin_group, given.radius = "pin", 0.1
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=20)
    assert editing.edit.settings.fabric is not None
    moved = np.linalg.norm(coordinates(obj) - before, axis=1)
    assert moved.max() > 2e-3 and moved[held].max() < 1e-7
    editing.close()


def test_pins_hold_a_part_of_a_solid(empty):
    moved = {}
    for pin in ("", "patch"):
        bpy.ops.wm.read_homefile(use_empty=True)
        obj = add_grid_cube()
        before = coordinates(obj)
        patch = np.linalg.norm(before - [0.03, 0.0, 0.1], axis=1) < 0.02
        set_group(obj, "patch", np.where(patch, 0.8, 0.3))
        bpy.context.scene.haptic_edit.pin_group = pin
        editing = empty.mode.Editing(obj)
        stroke(empty, editing, "touch", [(-0.02, 0.0)], frames=20)
        assert editing.take_warnings() == []
        moved[pin] = np.linalg.norm(coordinates(obj) - before, axis=1)
        editing.close()
    assert patch.sum() >= 3 and moved[""][patch].max() > 1e-4
    # All corners of a pinned vertex's cell are held; the smooth surface follows their neighbours a little too.
    assert moved["patch"][patch].max() < 0.05 * moved[""][patch].max()
    assert moved["patch"].max() > 1e-3, "what is not held gives way"


@pytest.mark.parametrize("seed", range(3))
def test_stiffness_is_geometric_between_the_factors_at_weights_of_zero_and_one(empty, seed):
    random = np.random.default_rng(seed)
    obj = add_grid_cube(cuts=3)
    weights = np.clip(random.uniform(-0.2, 1.2, len(obj.data.vertices)), 0.0, 1.0).astype(np.float32)
    set_group(obj, "hard", weights)
    given = bpy.context.scene.haptic_edit
    given.stiffness_group = "hard"
    given.factor_at_zero, given.factor_at_one = (10.0 ** random.uniform(-1, 1, 2)).tolist() if seed else (0.1, 10.0)
    editing = empty.mode.Editing(obj)
    editing.prepare()
    factors = np.array(editing.edit.settings.factors)
    expected = np.exp(np.log(given.factor_at_zero) * (1.0 - weights) + np.log(given.factor_at_one) * weights.astype(np.float64))
    assert np.allclose(factors, expected, rtol=1e-6) and factors.min() >= 0.1 and factors.max() <= 10.0
    assert editing.take_warnings() == []
    editing.close()


def test_a_solid_gives_way_less_where_its_group_is_stiff(empty):
    depth = {}
    for x in (-0.05, 0.05):
        bpy.ops.wm.read_homefile(use_empty=True)
        obj = add_grid_cube()
        before = coordinates(obj)
        set_group(obj, "right", (before[:, 0] > 0).astype(float))
        given = bpy.context.scene.haptic_edit
        given.stiffness_group, given.factor_at_zero, given.factor_at_one = "right", 0.2, 5.0
        editing = empty.mode.Editing(obj)
        stroke(empty, editing, "touch", [(x, 0.0)], frames=20)
        depth[x] = (before[:, 2] - coordinates(obj)[:, 2]).max()
        editing.close()
    # Hand and surface are in series: the spring of the hand is that of a ball pressed into the panel's stiffness, 2 (2 E r), and the surface has
    # about 2 E r times its factor at most: the shares of the depth are 2 / (2 + 0.2) and 2 / (2 + 5).
    assert depth[-0.05] > 1.5 * depth[0.05] > 0, depth


def test_cloth_stretches_less_where_its_group_is_stiff(empty):
    stretch = {}
    for factor in (0.1, 1.0, 10.0):
        bpy.ops.wm.read_homefile(use_empty=True)
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=16, y_subdivisions=16, size=0.2)
        obj = bpy.context.active_object
        before = coordinates(obj)
        set_group(obj, "rim", (np.abs(before[:, :2]).max(axis=1) > 0.099).astype(float))
        set_group(obj, "all", np.ones(len(before)))
        given = bpy.context.scene.haptic_edit
        given.pin_group, given.radius, given.strength = "rim", 0.1, 1.0
        if factor != 1.0:
            given.stiffness_group, given.factor_at_one = "all", factor
        editing = empty.mode.Editing(obj)
        stroke(empty, editing, "touch", [(0.0, 0.0)], frames=20)
        stretch[factor] = np.linalg.norm(coordinates(obj) - before, axis=1).max()
        editing.close()
    assert stretch[0.1] > stretch[1.0] > stretch[10.0] > 0, stretch


def test_a_mesh_that_is_inside_out_is_parted_and_stays_inside_out(empty):
    obj = add_grid_cube(cuts=6)
    obj.data.flip_normals()
    name = obj.name
    bpy.ops.ed.undo_push(message="start")
    editing = empty.mode.Editing(obj)
    bpy.context.scene.haptic_edit.plugin = "mass-spring"
    for _ in range(5):
        stroke(empty, editing, "cut", [(-0.15 + 0.01 * i, 0.013) for i in range(31)], frames=2)
        if not editing.take_warnings():
            break
        bpy.ops.ed.undo()
        obj = bpy.data.objects[name]
    editing.close()
    whole = bmesh.new()
    whole.from_mesh(obj.data)
    assert any(face.material_index == 1 for face in whole.faces), "it has walls"
    assert all(edge.is_contiguous for edge in whole.edges), "neighbours run the same way round"
    assert whole.calc_volume(signed=True) == pytest.approx(-(0.2**3), rel=0.02)
    whole.free()


def test_a_mesh_in_pieces_is_reported_with_what_joins_them(empty):
    obj = add_grid_cube(cuts=3)
    editing = empty.mode.Editing(obj)
    editing.prepare()
    assert editing.take_warnings() == []
    editing.close()
    mesh = bmesh.new()
    mesh.from_mesh(obj.data)
    bmesh.ops.split_edges(mesh, edges=mesh.edges)
    mesh.to_mesh(obj.data)
    mesh.free()
    editing = empty.mode.Editing(obj)
    editing.prepare()
    texts = editing.take_warnings()
    assert any("[coincident-borders]" in text and "Merge > By Distance" in text for text in texts), texts
    editing.close()


def test_groups_without_an_effect_are_reported_once(empty):
    obj = add_grid_cube(cuts=3)
    set_group(obj, "faint", np.full(len(obj.data.vertices), 0.4))
    given = bpy.context.scene.haptic_edit
    given.pin_group, given.stiffness_group = "faint", "typo"
    editing = empty.mode.Editing(obj)
    editing.prepare()
    texts = editing.take_warnings()
    assert len(texts) == 2 and any("`faint`" in text and "0.5" in text for text in texts)
    assert any("`typo`" in text and "`low`" in text and obj.name in text for text in texts)
    editing.prepare()
    assert editing.take_warnings() == []
    given.pin_group, given.stiffness_group, given.factor_at_one = "", "faint", 1.0
    editing.prepare()
    assert len(editing.take_warnings()) == 1
    given.stiffness_group = "low"
    given.factor_at_one = 2.0
    editing.prepare()
    assert editing.take_warnings() == []
    editing.close()


@pytest.mark.parametrize("seed", range(4))
def test_a_mesh_with_small_holes_is_a_solid_and_one_with_a_large_one_is_cloth(empty, seed):
    mesh = empty.mesh_io.read_mesh(add_grid_cube())
    assert not mesh.is_open()
    places = mesh.vertices[mesh.corners].reshape(-1, 4, 3).mean(axis=1)
    rows = mesh.corners.reshape(-1, 4)

    def without(faces):
        kept = np.delete(rows, faces, axis=0)
        return empty.editing.MeshArrays(mesh.vertices, kept.reshape(-1), np.full(len(kept), 4))

    # Holes of a face each, which do not touch: their borders are 0.073 m long, ten of them more than the edge of 0.2 m.
    random, holes = np.random.default_rng(seed), []
    for face in random.permutation(len(rows)):
        if all(not set(rows[face]) & set(rows[other]) for other in holes):
            holes.append(face)
        if len(holes) == 10:
            break
    assert not without(holes).is_open()
    # One of four by four faces, with a border of 0.29 m.
    centre = places[(places[:, 2] > 0.0999) & (np.abs(places[:, :2]).max(axis=1) < 0.05)][seed]
    near = (places[:, 2] > 0.0999) & (np.abs(places[:, :2] - centre[:2] - 0.5 * 0.2 / 11).max(axis=1) < 2.0 * 0.2 / 11)
    assert near.sum() == 16 and without(np.flatnonzero(near)).is_open()


def test_a_lost_object_is_told(empty):
    import pliant

    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    assert editing.begin("touch", ray_at(empty, 0, 0), BACK)
    bpy.data.objects.remove(obj)
    with pytest.raises(pliant.PliantError, match="no longer there"):
        editing.show(1 / 60)
    editing.close()


def test_a_stroke_beside_the_mesh_does_nothing(empty):
    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    assert not editing.begin("touch", ray_at(empty, 0.5, 0.5), BACK)
    editing.close()


def test_what_was_edited_is_saved(empty, tmp_path):
    obj = add_grid_cube()
    name = obj.name
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=15)
    editing.close()
    after = coordinates(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "edited.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "edited.blend"))
    assert np.array_equal(coordinates(bpy.data.objects[name]), after)


def test_a_frame_of_a_large_mesh_is_copied_in_two_milliseconds(empty):
    path = ROOT.parent / "shared" / "meshes" / "stanford-bunny.obj"
    if not path.exists():
        pytest.skip(f"{path} is not there")
    bpy.ops.wm.obj_import(filepath=str(path))
    obj = bpy.context.selected_objects[0]
    editing = empty.mode.Editing(obj)
    editing.prepare()
    box = np.array(obj.bound_box)
    x, y = (np.array(obj.matrix_world)[:3, :3] @ box.mean(axis=0))[:2]
    assert editing.begin("touch", ray_at(empty, x, y), BACK)
    assert editing.edit.settings.fabric is None, "its holes are small"
    editing.edit._live.wait(0, 5.0)
    seconds = []
    for _ in range(60):
        began = time.perf_counter()
        editing.show(1 / 60)
        seconds.append(time.perf_counter() - began)
        time.sleep(1 / 60)
    editing.end()
    editing.close()
    print(f"copy of {len(obj.data.vertices)} vertices: median {1e3 * np.median(seconds):.2f} ms")
    assert min(seconds) < 2e-3


def test_a_stroke_that_changes_the_size_of_the_mesh_is_followed_by_another_in_the_same_session(empty):
    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "pull", [(0.09, 0.0), (0.14, 0.0)], frames=15)
    assert np.ptp(coordinates(obj)[:, 0]) > 0.205
    stroke(empty, editing, "touch", [(-0.05, 0.0)], frames=10)
    assert len(editing.edit.recording().strokes) == 2
    editing.close()


def test_poses_are_kept_up_to_a_number_of_steps_and_a_warning_says_when_they_are_not(empty, monkeypatch):
    editing = empty.mode.Editing(add_grid_cube(cuts=5))
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=5)
    edit = editing.edit
    kept = len(edit.recording().strokes[0].poses)
    monkeypatch.setattr(empty.editing, "KEPT_STEPS", kept + 1)
    stroke(empty, editing, "touch", [(0.02, 0.0)], frames=5)
    assert editing.edit is edit and edit.recording() is None
    assert any("no longer knows the last strokes" in text for text in editing.take_warnings())
    stroke(empty, editing, "touch", [(-0.02, 0.0)], frames=5)
    assert edit.recording() is None and not edit._strokes and not edit._felt
    editing.close()


def test_selected_objects_are_obstacles_and_hold_what_is_pulled(empty):
    obj = add_grid_cube()
    # A plate beside the cube, 10 mm from its side: scaled and turned, with a modifier that makes it solid.
    bpy.ops.mesh.primitive_plane_add(size=1.0, location=(0.11, 0.0, 0.0), rotation=(0.0, np.pi / 2, 0.0), scale=(0.4, 0.4, 1.0))
    plate = bpy.context.active_object
    plate.name = "plate, /the"
    plate.modifiers.new("thick", "SOLIDIFY").thickness = 0.004
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    bpy.context.view_layer.objects.active = obj

    def pulled(is_selected):
        plate.select_set(is_selected)
        obj.select_set(True)
        before = coordinates(obj)
        editing = empty.mode.Editing(obj)
        stroke(empty, editing, "pull", [(0.08, 0.0), (0.12, 0.0), (0.16, 0.0)], frames=15)
        names = [obstacle.name for obstacle in editing.edit.obstacles]
        closed = [obstacle.mesh.is_closed() for obstacle in editing.edit.obstacles]
        after = coordinates(obj)
        editing.close()
        empty.mesh_io.set_coordinates(obj, before)
        return after, names, closed

    free, names, _ = pulled(False)
    assert not names
    held, names, closed = pulled(True)
    assert names == ["plate_ _the"] and closed == [True]
    assert free[:, 0].max() > 0.112, "without the obstacle the side is drawn out"
    assert held[:, 0].max() < 0.112, "with it, it stays before the plate"
