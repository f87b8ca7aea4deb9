"""A haptic device that has the hand, without a window: what the mode does with it between two frames."""

import time

import bpy
import numpy as np
import pytest
from device_user import DeviceUser, is_free, thread_ids, thread_names
from strokes import BACK, add_grid_cube, coordinates, ray_at, stroke, uv

HAPTIC_THREADS = {"haptic", "watchdog", "pliant-live"}
# The viewport looks down: right, up and towards the viewer are those of the scene.
DOWN = (0.0, 0.0, 0.0, 1.0)


class Hand:
    """Somebody with a device, and the mode that shows what it does."""

    def __init__(self, extension, editing, kind="touch", view=DOWN, **params):
        self.extension, self.editing = extension, editing
        self.user = DeviceUser(**params)
        self.kind, self.view, self.share = kind, view, 1.0
        self.choice = extension.device_strokes.DeviceChoice("pointer", tuple((key, str(value)) for key, value in self.user.params.items()))
        self.finished = []

    def wish(self):
        return self.extension.device_strokes.Wish(self.view, self.kind, self.share)

    def start(self):
        self.editing.give_to(self.choice, self.wish())

    def frame(self):
        """A frame of the viewport, and what the timer does in it."""
        live = self.editing.edit._live
        live.wait(live.wait(), 20.0)
        kind = self.editing.show_device(self.wish())
        self.user.force()
        if kind is not None:
            self.finished.append(kind)
            bpy.ops.ed.undo_push(message=f"Haptic {kind}")
        return kind

    def go(self, *places, buttons=0, frames=15):
        """Go through places (m, axes of the device), some frames from one to the next."""
        for start, end in zip(places, places[1:], strict=False):
            for share in np.linspace(0.0, 1.0, frames):
                self.user.send((1 - share) * np.asarray(start) + share * np.asarray(end), buttons)
                self.frame()

    def wait(self, is_true, frames=400):
        for _ in range(frames):
            if is_true():
                return
            if self.editing.device is None:
                raise AssertionError("the device has no hand any more")
            self.frame()
        raise AssertionError(f"it does not come about: {self.editing.device.state}")

    def come_out(self):
        """Be over the mesh, ready."""
        self.user.send([0, 0, 0.095])
        self.wait(lambda: self.editing.device.state.status == "ready" and self.editing.device.state.position[2] > 0.1)
        self.frame()

    def press(self, depth=0.072, buttons=1, over=(0.0, 0.0), aside=None):
        """Press a button down to a height (m, axes of the device), lift the hand, and go aside with it (x, y)."""
        x, y = over
        # Counted before: on a busy machine the device may be silent for longer than a pose holds, and the stroke ends on the way down.
        count = len(self.finished)
        self.go([x, y, 0.095], [x, y, depth], buttons=buttons)
        self.go([x, y, depth], [x, y, 0.095], [*(aside or over), 0.095])
        self.wait(lambda: len(self.finished) > count)


@pytest.fixture
def lead(empty):
    """Gives the hand on a mesh to a device."""
    hands = []

    def lead(editing, **keys):
        hand = Hand(empty, editing, **keys)
        hands.append(hand)
        hand.start()
        return hand

    yield lead
    for hand in hands:
        hand.editing.close()
        hand.user.close()
        assert is_free(hand.user.address), "the device is closed"
    wait_for_the_end_of_threads()


def wait_for_the_end_of_threads():
    """Wait until no thread of a session is left: the kernel lists one that was waited for a moment longer."""
    end = time.monotonic() + 20
    while HAPTIC_THREADS & set(thread_names()) and time.monotonic() < end:
        time.sleep(0.001)
    assert not HAPTIC_THREADS & set(thread_names())


def test_what_is_felt_springs_back_and_a_stroke_is_one_undo_step(empty, lead):
    obj = add_grid_cube()
    name, texture = obj.name, uv(obj)
    bpy.ops.ed.undo_push(message="start")
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    hand = lead(editing)
    hand.come_out()
    hand.go([0, 0, 0.095], [0, 0, 0.074])
    felt = before[:, 2] - coordinates(obj)[:, 2]
    assert felt.max() > 1e-3 and hand.editing.device.state.force[2] > 0.01
    assert 0 < hand.user.largest <= 3.3 + 2e-6
    hand.go([0, 0, 0.074], [0, 0, 0.095])
    for _ in range(30):
        hand.frame()
    assert np.abs(coordinates(obj) - before).max() < 0.02 * felt.max() and hand.finished == []
    hand.press()
    pressed = coordinates(obj)
    assert hand.finished == ["touch"] and (before - pressed)[:, 2].max() > 1e-3
    hand.kind = "pull"
    hand.go([0, 0, 0.095], [0.02, 0, 0.095])
    hand.press(depth=0.075, over=(0.02, 0.0))
    pulled = coordinates(obj)
    assert hand.finished == ["touch", "pull"] and not np.array_equal(pulled, pressed)
    editing.end()
    bpy.ops.ed.undo()
    assert np.abs(coordinates(bpy.data.objects[name]) - pressed).max() == 0.0
    bpy.ops.ed.undo()
    assert np.array_equal(coordinates(bpy.data.objects[name]), before)
    bpy.ops.ed.redo()
    obj = bpy.data.objects[name]
    assert np.array_equal(coordinates(obj), pressed)
    assert np.array_equal(uv(obj), texture) and [group.name for group in obj.vertex_groups] == ["low"]


@pytest.mark.parametrize(("kind", "buttons", "made"), [("inflate", 1, "inflate"), ("inflate", 2, "deflate"), ("deflate", 2, "inflate"), ("touch", 2, "touch")])
def test_the_second_button_does_the_opposite(empty, lead, kind, buttons, made):
    obj = add_grid_cube()
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    hand = lead(editing, kind=kind)
    hand.come_out()
    hand.go([0, 0, 0.095], [0, 0, 0.083])
    hand.user.send([0, 0, 0.083], buttons)
    for _ in range(40):
        hand.frame()
    hand.go([0, 0, 0.083], [0, 0, 0.095])
    hand.wait(lambda: hand.finished)
    editing.end()
    rise = (coordinates(obj) - before)[:, 2]
    assert hand.finished == [made]
    assert (rise[np.abs(rise).argmax()] > 0) == (made == "inflate")


def test_a_hand_that_begins_inside_touches_nothing_until_it_is_out(empty, lead):
    obj = add_grid_cube()
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    hand = lead(editing)
    hand.go([0, 0, 0.0], [0, 0, 0.095], buttons=1)
    assert np.abs(coordinates(obj) - before).max() < 1e-6
    hand.go([0, 0, 0.095], [0, 0, 0.095])
    hand.press()
    assert (before - coordinates(obj))[:, 2].max() > 1e-3


@pytest.mark.parametrize("seed", range(4))
def test_axes_follow_the_view_of_any_model(empty, lead, seed):
    random = np.random.default_rng(seed)
    size = [0.004, 0.2, 1.0, 3.0][seed]
    obj = add_grid_cube(size=size, cuts=5)
    obj.location = size * random.standard_normal(3)
    bpy.context.view_layer.update()
    middle = np.array(obj.matrix_world.translation)
    editing = empty.mode.Editing(obj)
    hand = lead(editing)
    scale = size / (0.7 * 0.2)
    for _ in range(3):
        view = random.standard_normal(4)
        hand.view = tuple((view / np.linalg.norm(view)).tolist())
        place = random.uniform(-0.09, 0.09, 3)
        hand.user.send(place)
        axis, w = np.array(hand.view[:3]), hand.view[3]
        turned = place + 2 * np.cross(axis, np.cross(axis, place) + w * place)
        expected = middle + scale * turned
        hand.wait(lambda: hand.editing.device.state.position is not None and np.allclose(hand.editing.device.state.position, expected, atol=1e-4 * size))
        assert np.isclose(hand.editing.device.state.length_scale, scale, rtol=1e-5)
        assert np.linalg.norm(hand.editing.device.state.force) <= hand.editing.device.state.force_limit * (1 + 1e-9)
    assert hand.user.largest <= 3.3 + 2e-6


def test_a_share_of_the_force_is_felt(empty, lead):
    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    hand = lead(editing)
    hand.come_out()
    hand.go([0, 0, 0.095], [0, 0, 0.075])
    for _ in range(30):
        hand.frame()
    full, limit = hand.editing.device.state.force[2], hand.editing.device.state.force_limit
    hand.share = 0.25
    for _ in range(30):
        hand.frame()
    state = hand.editing.device.state
    assert np.isclose(state.force[2], 0.25 * full, rtol=0.1) and np.isclose(state.force_limit, 0.25 * limit)


def test_a_cut_of_a_device_parts_the_mesh_and_the_device_stays_open(empty, lead):
    obj = add_grid_cube(cuts=6)
    bpy.ops.ed.undo_push(message="start")
    vertices = len(obj.data.vertices)
    editing = empty.mode.Editing(obj)
    hand = lead(editing, kind="cut")
    hand.come_out()
    haptic, first = thread_ids("haptic"), editing.edit
    # The blade points down from the hand; its tip goes through the cube from side to side.
    hand.go([0, 0, 0.095], [-0.093, 0.011, -0.09])
    hand.go([-0.093, 0.011, -0.09], [0.093, 0.013, -0.09], buttons=1, frames=60)
    hand.user.send([0.093, 0.013, -0.09])
    hand.wait(lambda: hand.finished)
    assert hand.finished == ["cut"] and editing.edit is not first and editing.device is not None
    assert len(obj.data.vertices) > vertices
    assert "Cut" in [slot.name for slot in obj.material_slots]
    assert thread_ids("haptic") == haptic, "the device was closed and opened"
    # What was cut is felt, and the next stroke is one like any other; the force never leaps.
    hand.kind, before = "touch", coordinates(obj)
    hand.come_out()
    hand.go([0, 0.04, 0.095], [0, 0.04, 0.075])
    hand.wait(lambda: editing.device.state.force[2] > 0.05)
    # The half is free and gives way: how deep a dent is left depends on how busy the machine is. It may rise after the hand.
    hand.press(over=(0.0, 0.04), aside=(0.0, 0.093))
    assert hand.finished == ["cut", "touch"] and np.abs(before - coordinates(obj)).max() > 1e-6
    assert thread_ids("haptic") == haptic
    editing.end()
    for _ in range(2):
        bpy.ops.ed.undo()
    assert len(editing.object().data.vertices) == vertices


def test_a_file_saved_in_mid_stroke_has_the_stroke_and_the_device_is_closed(empty, lead, tmp_path):
    obj = add_grid_cube()
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    hand = lead(editing)
    hand.come_out()
    hand.go([0, 0, 0.095], [0, 0, 0.072], buttons=1)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "pressed.blend"), copy=True)
    assert editing.device is None and is_free(hand.user.address)
    after = coordinates(obj)
    assert (before - after)[:, 2].max() > 1e-3
    with bpy.data.libraries.load(str(tmp_path / "pressed.blend")) as (_, into):
        into.meshes = [obj.data.name]
    flat = np.empty(3 * len(after), dtype=np.float32)
    into.meshes[0].vertices.foreach_get("co", flat)
    assert np.array_equal(flat.reshape(-1, 3), after)
    # The stroke is baked to the byte: what was felt before it is made again too.
    take = empty.bake.last_take()
    again = list(take.recording.shapes(1 / 24))[-1]
    assert np.abs(empty.mesh_io.transformed(take.inverse, again) - after).max() <= 2e-8
    # The mode goes on with the next frame, in the same session.
    session = editing.edit.session
    hand.start()
    hand.come_out()
    assert editing.edit.session is session


@pytest.mark.parametrize("pressed", [0, 1])
@pytest.mark.parametrize("ending", ["file", "disable", "object", "undo", "close"])
def test_nothing_is_left_of_a_device_whatever_ends_the_mode(empty, lead, ending, pressed):
    import pliant

    obj = add_grid_cube()
    bpy.ops.ed.undo_push(message="start")
    editing = empty.mode.Editing(obj)
    hand = lead(editing)
    hand.come_out()
    hand.go([0, 0, 0.095], [0, 0, 0.072], buttons=pressed)
    assert not is_free(hand.user.address) and HAPTIC_THREADS <= set(thread_names())
    if ending == "file":
        bpy.ops.wm.read_homefile(use_empty=True)
    elif ending == "disable":
        empty.unregister()
        try:
            assert not empty.handover.is_enabled()
            with pytest.raises(pliant.PliantError, match="disabled"):
                empty.device_mode.give_hand(editing, hand.choice, None)
        finally:
            empty.register()
    elif ending == "object":
        bpy.data.objects.remove(obj)
        with pytest.raises(pliant.PliantError, match="no longer there"):
            editing.show_device(hand.wish())
        editing.close()
    elif ending == "undo":
        assert editing.object() is not None
        bpy.ops.ed.undo_push(message="something else")
        bpy.ops.ed.undo()
        assert editing.object() is None or editing.is_mesh_changed()
        editing.drop()
    else:
        editing.close()
    assert is_free(hand.user.address) and editing.device is None
    wait_for_the_end_of_threads()


def test_pins_of_a_device_outlive_its_session_and_an_undo_takes_them_back(empty, lead):
    obj = add_grid_cube()
    name = obj.name
    bpy.ops.ed.undo_push(message="start")
    editing = empty.mode.Editing(obj)
    hand = lead(editing, kind="pin")
    hand.come_out()
    hand.press(depth=0.08)
    held = [v.index for v in obj.data.vertices if any(obj.vertex_groups[g.group].name == "Pin" for g in v.groups)]
    assert hand.finished == ["pin"] and len(held) >= 4 and bpy.context.scene.haptic_edit.pin_group == "Pin"
    first = editing.edit
    bpy.context.scene.haptic_edit.radius *= 0.9
    editing.go_on_with_device(hand.wish())
    assert editing.edit is not first and list(editing.edit.settings.pinned) == held
    editing.end()
    bpy.ops.ed.undo()
    assert bpy.data.objects[name].vertex_groups.get("Pin") is None and editing.is_stale
    hand.start()
    assert editing.edit.settings.pinned == () and not editing.is_stale


def test_a_mesh_that_something_else_changes_is_noticed(empty, lead):
    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    hand = lead(editing)
    hand.come_out()
    hand.go([0, 0, 0.095], [0, 0, 0.075])
    assert not editing.is_mesh_changed()
    obj.data.vertices[0].co.x += 0.01
    obj.data.update()
    assert editing.is_mesh_changed()
    editing.drop()
    assert is_free(hand.user.address)
    moved = coordinates(obj)[0]
    hand.start()
    hand.come_out()
    assert np.array_equal(coordinates(obj)[0], moved)


def test_a_device_that_ends_its_strokes_quickly_makes_one_undo_step_each(empty, lead):
    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    hand = lead(editing)
    hand.come_out()
    hand.go([0, 0, 0.095], [0, 0, 0.075])
    # Three strokes while the hand touches the mesh all the time.
    for _ in range(3):
        hand.user.send([0, 0, 0.074], 1)
        hand.wait(lambda: hand.editing.device.state.in_stroke)
        hand.user.send([0, 0, 0.074])
        hand.wait(lambda: not hand.editing.device.state.in_stroke)
    assert len(hand.finished) == 2
    hand.go([0, 0, 0.074], [0, 0, 0.095])
    hand.wait(lambda: len(hand.finished) == 3)
    assert len(editing.edit._strokes) == 3


def test_a_stroke_of_a_device_is_baked_with_what_was_felt_before(empty, lead):
    empty.bake.forget()
    obj = add_grid_cube()
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    hand = lead(editing)
    hand.come_out()
    hand.go([0, 0, 0.095], [0, 0, 0.075])
    hand.go([0, 0, 0.075], [0, 0, 0.095])
    hand.press()
    pressed = coordinates(obj)
    editing.end()
    editing.close()
    take = empty.bake.last_take()
    shapes = list(take.recording.shapes(1 / 24))
    last = empty.mesh_io.transformed(take.inverse, shapes[-1])
    assert np.abs(last - pressed).max() < 0.01 * np.abs(pressed - before).max()
    deepest = max((before - empty.mesh_io.transformed(take.inverse, shape))[:, 2].max() for shape in shapes)
    assert deepest > (before - pressed)[:, 2].max()
    assert bpy.ops.object.haptic_bake("EXEC_DEFAULT", True) == {"FINISHED"}
    assert len(obj.data.shape_keys.key_blocks) == 1 + len(list(take.recording.shapes(2 / 24)))


def test_a_device_that_cannot_be_opened_leaves_the_mesh_to_the_pointer(empty):
    import pliant

    obj = add_grid_cube()
    editing = empty.mode.Editing(obj)
    choice = empty.device_strokes.DeviceChoice("pointer", (("reach", "1 s"),))
    with pytest.raises(pliant.PliantError, match="reach"):
        editing.give_to(choice, empty.device_strokes.Wish(DOWN, "touch"))
    assert editing.device is None
    stroke(empty, editing, "touch", [(0.0, 0.0)], frames=5)
    editing.close()


def test_preferences_offer_devices_and_their_parameters(empty, tmp_path):
    import pliant

    given = empty.preferences.preferences()
    try:
        assert empty.preferences.device_choice() is None
        given.device = "pointer"
        assert [row.name for row in given.params][:2] == ["address", "hold"] and given.params["hold"].summary
        given.params["hold"].value = "3 s"
        choice = empty.preferences.device_choice()
        assert (choice.plugin, choice.params, choice.allowed) == ("pointer", (("hold", "3 s"),), ())
        given.device = "phantom"
        assert "library" in given.params and given.params["library"].is_path
        numbers = {item[0]: item[4] for item in empty.preferences._device_items(None, None)}
        assert len(set(numbers.values())) == len(numbers) and numbers["MOUSE"] == 0
        given.device = "LIBRARY"
        with pytest.raises(pliant.PliantError, match="no library"):
            empty.preferences.device_choice()
        # A library by its path is refused but for the allowed folder.
        pointer = next(device for device in pliant.devices() if device.id == "pointer")
        library = tmp_path / "mine.so"
        library.write_bytes(open(pointer.path, "rb").read())
        given.library, user = f"{library}#pointer", DeviceUser()
        given.text = f"address={user.address}; hold=60 s"
        editing = empty.mode.Editing(add_grid_cube())
        wish = empty.device_strokes.Wish(DOWN, "touch")
        with pytest.raises(pliant.PliantError, match="allow"):
            editing.give_to(empty.preferences.device_choice(), wish)
        given.allowed = str(tmp_path)
        editing.give_to(empty.preferences.device_choice(), wish)
        assert not is_free(user.address)
        editing.close()
        assert is_free(user.address)
        given.text = "hold"
        with pytest.raises(pliant.PliantError, match="key=value"):
            empty.preferences.device_choice()
        user.close()
    finally:
        given.device, given.library, given.text, given.allowed = "MOUSE", "", "", ""


def test_a_pointer_makes_strokes_as_before_beside_the_preferences(empty):
    obj = add_grid_cube()
    before = coordinates(obj)
    editing = empty.mode.Editing(obj)
    assert editing.begin("touch", ray_at(empty, 0.0, 0.0), BACK)
    assert editing.end() is True
    editing.close()
    assert np.abs(coordinates(obj) - before).max() < 0.02
