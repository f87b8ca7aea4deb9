"""Pins and paint of strokes: kept in vertex groups, so they outlive the session, and one undo step takes them back."""

import bpy
import numpy as np
import pytest
from strokes import add_grid_cube, coordinates, set_group, stroke


def weights(obj, name):
    """Weight of each vertex in a group, 0 outside of it."""
    group = obj.vertex_groups.get(name)
    result = np.zeros(len(obj.data.vertices))
    if group is not None:
        for vertex in obj.data.vertices:
            result[vertex.index] = next((g.weight for g in vertex.groups if g.group == group.index), 0.0)
    return result


def add_sheet(cells=16, size=0.2):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=cells, y_subdivisions=cells, size=size)
    obj = bpy.context.active_object
    rim = np.abs(coordinates(obj)[:, :2]).max(axis=1) > 0.499 * size
    set_group(obj, "rim", rim.astype(float))
    bpy.context.scene.haptic_edit.radius = 0.06
    return obj


def start(kind):
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = add_grid_cube() if kind == "solid" else add_sheet()
    bpy.ops.ed.undo_push(message="start")
    return obj


def pressed(extension, editing, at):
    """How far each vertex moves by a press."""
    before = coordinates(editing.object())
    stroke(extension, editing, "touch", [at], frames=15)
    return np.linalg.norm(coordinates(editing.object()) - before, axis=1)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("kind", ["solid", "sheet"])
def test_pins_of_a_stroke_outlive_the_session_and_one_undo_takes_them_back(empty, kind, seed):
    obj, at = start(kind), tuple(np.random.default_rng(seed).uniform(-0.03, 0.03, 2))
    given, name = bpy.context.scene.haptic_edit, obj.name
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "pin", [at], frames=10)
    edit, pinned = editing.edit, editing.edit.session.pinned()
    assert len(pinned) >= 4 and given.pin_group == "Pin"
    assert np.array_equal(np.flatnonzero(weights(obj, "Pin")), pinned) and (weights(obj, "Pin")[pinned] == 1.0).all()
    # The session has the pins already and goes on.
    pressed(empty, editing, at)
    assert editing.edit is edit
    # One that is opened anew has them from the group.
    given.radius *= 0.8
    moved = pressed(empty, editing, at)
    assert editing.edit is not edit and set(pinned.tolist()) == set(editing.edit.settings.pinned)
    assert moved[pinned].max() < 2e-4 and editing.take_warnings() == []
    for _ in range(3):
        bpy.ops.ed.undo()
    obj = bpy.data.objects[name]
    assert obj.vertex_groups.get("Pin") is None and bpy.context.scene.haptic_edit.pin_group == ""
    assert np.array_equal(coordinates(obj), before)
    moved = pressed(empty, editing, at)
    assert editing.edit.settings.pinned == () and moved[pinned].max() > 1e-3
    editing.close()


@pytest.mark.parametrize("kind", ["solid", "sheet"])
def test_pins_of_a_group_are_freed_by_a_stroke_and_others_stay(empty, kind):
    obj = start(kind)
    given, before = bpy.context.scene.haptic_edit, coordinates(obj)
    top = before[:, 2] > (0.099 if kind == "solid" else -1.0)
    near = top & (np.linalg.norm(before[:, :2], axis=1) < 0.02)
    far = top & (np.linalg.norm(before[:, :2] - [0.09, 0.09], axis=1) < 0.02)
    set_group(obj, "held", (near | far).astype(float))
    given.pin_group = "held"
    editing = empty.mode.Editing(obj)
    # A stroke that pins beside it as well: what is freed was held from the opening, or since a stroke.
    stroke(empty, editing, "pin", [(-0.04, 0.0)], frames=8)
    both = weights(obj, "held") > 0.5
    assert both.sum() > (near | far).sum()
    stroke(empty, editing, "unpin", [(-0.04, 0.0), (0.0, 0.0)], frames=8)
    left = weights(obj, "held")
    assert not left[near].any() and (left[far] == 1.0).all()
    bpy.ops.ed.undo()
    assert np.array_equal(weights(editing.object(), "held") > 0.5, both)
    bpy.ops.ed.redo()
    assert np.array_equal(weights(editing.object(), "held"), left)
    moved = pressed(empty, editing, (0.0, 0.0))
    assert moved[near].max() > 1e-3 > 2e-4 > moved[far].max()
    editing.close()


@pytest.mark.parametrize("symmetry", ["", "x", "xy"])
def test_pins_of_a_group_are_freed_on_all_sides_of_a_symmetry(empty, symmetry):
    obj = start("solid")
    given, before = bpy.context.scene.haptic_edit, coordinates(obj)
    given.radius, given.pin_group = 0.04, "held"
    given.symmetry = [axis in symmetry for axis in "xyz"]
    corners = {(sx, sy): (before[:, 2] > 0.099) & (np.linalg.norm(before[:, :2] - [0.06 * sx, 0.06 * sy], axis=1) < 0.015) for sx in (-1, 1) for sy in (-1, 1)}
    set_group(obj, "held", np.any(list(corners.values()), axis=0).astype(float))
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "unpin", [(0.06, 0.06)], frames=8)
    left = weights(obj, "held")
    for (sx, sy), corner in corners.items():
        is_freed = (sx == 1 or "x" in symmetry) and (sy == 1 or "y" in symmetry)
        assert corner.sum() >= 1 and (left[corner] == (0.0 if is_freed else 1.0)).all(), (sx, sy)
    editing.close()


@pytest.mark.parametrize(("kind", "factor"), [("solid", 4.0), ("solid", 0.25), ("sheet", 3.0)])
@pytest.mark.parametrize("group", ["", "hard"])
def test_paint_outlives_the_session_and_one_undo_takes_it_back(empty, kind, factor, group):
    obj = start(kind)
    given, name = bpy.context.scene.haptic_edit, obj.name
    if kind == "sheet":
        given.pin_group = "rim"
    if group:
        set_group(obj, group, np.random.default_rng(3).uniform(0.0, 0.3, len(obj.data.vertices)))
        given.stiffness_group = group
        bpy.ops.ed.undo_push(message="group")
    given.paint_factor = factor
    editing = empty.mode.Editing(obj)
    editing.prepare()
    base = np.array(editing.edit.settings.factors or np.ones(len(obj.data.vertices)))
    range_before, weights_before = (given.factor_at_zero, given.factor_at_one), weights(obj, group or "Stiffness")
    stroke(empty, editing, "paint", [(-0.05, 0.0), (0.0, 0.0)], frames=15)
    edit = editing.edit
    vertices, factors = edit.session.painted()
    furthest = factors.max() if factor > 1 else factors.min()
    assert len(vertices) > 4 and np.isclose(furthest, factor, rtol=0.2)
    expected = base.copy()
    expected[vertices] *= factors
    assert given.stiffness_group == (group or "Stiffness")
    pressed(empty, editing, (0.05, 0.05))
    assert editing.edit is edit, "the session has the paint already and goes on"
    given.radius *= 0.99
    editing.prepare()
    assert editing.edit is not edit
    now = np.array(editing.edit.settings.factors)
    assert np.allclose(now, np.clip(expected, 0.1, 10.0), rtol=1e-5)
    bpy.ops.ed.undo()
    bpy.ops.ed.undo()
    obj = bpy.data.objects[name]
    given = bpy.context.scene.haptic_edit
    assert np.array_equal(weights(obj, group or "Stiffness"), weights_before)
    assert (given.factor_at_zero, given.factor_at_one) == range_before and given.stiffness_group == group
    editing.close()


def test_a_painted_place_stays_stiff_in_a_session_that_is_opened_anew(empty):
    depth = {}
    for painted in (False, True):
        obj = start("solid")
        given = bpy.context.scene.haptic_edit
        given.paint_factor = 8.0
        editing = empty.mode.Editing(obj)
        if painted:
            stroke(empty, editing, "paint", [(-0.03, 0.0), (0.03, 0.0)], frames=25)
            assert editing.take_warnings() == []
        given.radius *= 0.99
        depth[painted] = pressed(empty, editing, (0.0, 0.0)).max()
        editing.close()
    # In series with the spring of the hand, 2 (2 E r) against 2 E r times the factor: 2 / 3 of the depth, and 2 / (2 + 8).
    assert depth[True] < 0.6 * depth[False], depth


def test_factors_beyond_those_of_a_field_are_clipped_and_said(empty):
    obj = start("solid")
    given = bpy.context.scene.haptic_edit
    set_group(obj, "hard", np.ones(len(obj.data.vertices)))
    given.stiffness_group, given.factor_at_one, given.paint_factor = "hard", 8.0, 4.0
    editing = empty.mode.Editing(obj)
    stroke(empty, editing, "paint", [(0.0, 0.0)], frames=25)
    texts = editing.take_warnings()
    assert any("`hard`" in text and "10" in text for text in texts), texts
    assert weights(obj, "hard").max() == 1.0 and given.factor_at_one == 10.0
    editing.close()


def test_strengths_of_tools_reach_their_edits_and_act(empty):
    import pliant

    strengths = pliant.edit_strengths()
    assert {"smooth", "grow", "inflate", "paint"} <= set(strengths) and "cut" not in strengths
    rise = {}
    for share in (0.5, 2.0):
        obj = start("solid")
        given = bpy.context.scene.haptic_edit
        given.brush_strength, given.paint_factor = share, 0.5
        editing = empty.mode.Editing(obj)
        editing.prepare()
        edits = {edit["kind"]: edit for edit in editing.edit.scene.to_dict()["edit"]}
        for kind, strength in strengths.items():
            if kind == "paint":
                assert edits[kind]["strength"] == pytest.approx(0.5)
            elif strength.unit == "Pa":
                assert edits[kind]["strength"] == pytest.approx(share * 0.15 * 1e3 * given.young)
            else:
                assert edits[kind]["strength"] == pytest.approx(share * strength.default)
        before = coordinates(obj)
        stroke(empty, editing, "inflate", [(0.0, 0.0)], frames=15)
        rise[share] = (coordinates(obj) - before)[:, 2].max()
        editing.close()
    # Twice linear: four times the pressure, less what large strains take.
    assert rise[2.0] > 2.0 * rise[0.5] > 0, rise
