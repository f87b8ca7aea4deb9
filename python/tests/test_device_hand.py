"""Hands that a haptic device has, on a haptic thread of its own."""

import gc
import os
import struct
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import block, pressed
from device_user import DeviceUser, is_free, thread_names

import pliant

HAPTIC_THREADS = {"haptic", "watchdog", "pliant-live"}


@pytest.fixture
def user():
    """Somebody with the device `pointer`."""
    user = DeviceUser()
    yield user
    user.close()


def model(size=0.1, **edit):
    """A cube of this size (m) with a hand of which button 0 keeps and no button springs back."""
    vertices, faces = block(edge=size)
    scene = pliant.Scene()
    scene.time(dt="1 ms")
    scene.output(energy=False)
    material = pliant.Material("mass-spring", young="20 kPa", density=1000, damping_time="0.5 ms")
    scene.body("cube", mesh=vertices, faces=faces, material=material, grid={"level": 4})
    radius = 0.04 * size
    stiffness = 4 * 20e3 * radius
    peak = 4 * stiffness * radius
    scene.hand("hand", peak_force=peak, stiffness=4 * stiffness)
    scene.tool("finger", radius=radius, stiffness=stiffness, speed=100 * size, slew=peak / 5e-3)
    scene.edit("touch", tool="finger", button=0, release="keep")
    scene.edit("touch", tool="finger", button=1, release="spring-back")
    return scene


def rotated(rotation, vector):
    """A vector (3) turned by a quaternion (x, y, z, w)."""
    axis, w = np.asarray(rotation[:3]), rotation[3]
    vector = np.asarray(vector)
    return vector + 2 * np.cross(axis, np.cross(axis, vector) + w * vector)


def random_rotation(random):
    quaternion = random.standard_normal(4)
    return quaternion / np.linalg.norm(quaternion)


def settled(hand, user, views=30):
    """The states of device and tool once the body has come to rest."""
    seen = hand.wait()
    for _ in range(views):
        seen = hand.wait(seen, 20.0)
        user.force()
    return hand.state, hand.tool("finger")


def wait_for_the_end_of_threads():
    """Wait until no thread of a session is left: the kernel lists one that was waited for a moment longer."""
    end = time.monotonic() + 20
    while HAPTIC_THREADS & set(thread_names()) and time.monotonic() < end:
        time.sleep(0.001)
    assert not HAPTIC_THREADS & set(thread_names())


def test_devices_are_listed_with_their_parameters():
    devices = {device.id: device for device in pliant.devices()}
    assert {"phantom", "exoskeleton", "pen", "pointer"} <= set(devices) and "scripted" not in devices
    assert devices["pointer"].param("address").type == "text" and devices["pen"].param("depth").unit == "m"
    assert all(device.kind == "device" and device.summary for device in devices.values())


def test_kinds_that_undo_each_other():
    kinds = pliant.edit_kinds()
    pairs = {kind: pliant.opposite_kind(kind) for kind in kinds}
    assert pairs["inflate"] == "deflate" and pairs["touch"] is None
    assert all(pairs[other] == kind for kind, other in pairs.items() if other)


def test_a_device_feels_and_makes_strokes_that_can_be_taken_back(user):
    with pliant.Session(model()) as session:
        rest = session.rest_positions().copy()
        with session.hand("finger").follow("pointer", user.params, buttons=([1], [0], [0])) as hand:
            with pytest.raises(pliant.PliantError, match="clock"):
                session.step()
            user.go(hand, [0, 0, 0.09])
            assert hand.state.status == "ready" and hand.state.strokes == 0
            user.glide(hand, [0, 0, 0.09], [0, 0, 0.06])
            felt = user.force()
            state, tool = settled(hand, user)
            assert state.force[2] > 0.05 and tool.contact == "cube" and state.buttons == 2 and not state.in_stroke
            assert np.linalg.norm(state.force) <= state.force_limit <= 3.3 + 1e-9
            assert felt is None or felt[2] > 0
            user.glide(hand, [0, 0, 0.06], [0, 0, 0.09])
            assert hand.state.strokes == 0, "to feel is no stroke"
            user.glide(hand, [0, 0, 0.09], [0, 0, 0.06], buttons=1)
            assert hand.state.in_stroke and hand.state.strokes == 1 and hand.state.buttons == 1
            user.glide(hand, [0, 0, 0.06], [0, 0, 0.09])
            assert not hand.state.in_stroke
            poses = hand.take_poses()
            assert set(poses.tool) == {"finger"} and set(poses.buttons.tolist()) >= {1, 2}
            assert len(hand.take_poses()) < len(poses)
        assert session.history == (1, 0)
        dent = np.abs(session.positions() - rest).max()
        assert dent > 1e-3 and session.undo()
        session.step(100)
        # What was felt before has pushed the cube, which nothing holds, a little.
        assert np.abs(session.positions() - rest).max() < 0.1 * dent
    assert is_free(user.address)


@pytest.mark.parametrize("depth", [0.068, 0.064, 0.06, 0.055])
@pytest.mark.parametrize("size", [0.004, 0.1, 3.0])
def test_a_hand_that_presses_stays_outside_when_a_stroke_begins_and_ends(user, depth, size):
    with pliant.Session(model(size)) as session:
        with session.hand().follow("pointer", user.params, buttons=([1], [0], [0])) as hand:
            # Feel, make a stroke without letting go, feel, and lift.
            user.glide(hand, [0, 0, 0.09], [0, 0, depth + 0.002])
            felt = hand.tool("finger").force[2]
            for buttons in (1, 0, 1, 0):
                user.go(hand, [0, 0, depth + 0.002 - 0.002 * buttons], buttons, views=8)
                force = hand.tool("finger").force[2]
                assert force > -0.05 * felt, f"buttons {buttons}: the surface draws the hand in: {force} N after {felt} N"
            user.glide(hand, [0, 0, depth + 0.002], [0, 0, 0.09])
            tool = hand.tool("finger")
            assert tool.contact is None and hand.state.strokes == 2, "it comes out"


def test_what_a_device_did_can_be_made_again(user):
    with pliant.Session(model()) as session, pliant.Session(model()) as again:
        with session.hand().follow("pointer", user.params, buttons=([1], [0], [0])) as hand:
            user.glide(hand, [0, 0, 0.09], [0.01, 0, 0.06], buttons=1)
            user.glide(hand, [0.01, 0, 0.06], [0, 0.01, 0.09], count=10)
            used = hand.stop()
        poses, other = {round(pose.time / again.dt): pose for pose in used}, again.hand()
        for step in range(1, session.steps + 1):
            if step in poses:
                other.go(poses[step].position, poses[step].rotation, poses[step].buttons)
            else:
                other.leave()
            again.step()
        assert np.array_equal(session.positions(), again.positions())
        assert np.abs(session.positions() - session.rest_positions()).max() > 1e-3


@pytest.mark.parametrize("seed", range(6))
def test_power_has_one_scale_and_no_force_is_over_the_limit(user, seed):
    random = np.random.default_rng(seed)
    size = [0.004, 0.02, 0.1, 0.5, 1.0, 3.0][seed]
    peak = 10 ** random.uniform(-0.5, 1.0)
    user.params |= {"peak-force": peak, "stiffness": 10 ** random.uniform(2, 3.5)}
    share, view, centre = random.uniform(0.2, 1.0), random_rotation(random), 0.05 * size * random.standard_normal(3)
    with pliant.Session(model(size)) as session:
        masks = ([1], [1], [1])
        with session.hand().follow("pointer", user.params, view=view, centre=centre, buttons=masks, force_share=share) as hand:
            # Onto a side of the cube, from outside, in axes of the device.
            inverse = np.array([*-view[:3], view[3]])
            outward = rotated(inverse, np.array([0, 0, 1.0]))
            scale = size / (0.7 * 0.2)

            def device_place(height):
                return rotated(inverse, np.array([0, 0, height * size]) - centre) / scale

            place = device_place(0.56)
            user.go(hand, place)
            assert np.allclose(hand.state.position, [0, 0, 0.56 * size], atol=1e-9 * size)
            assert np.isclose(hand.state.length_scale, scale)
            for height in np.linspace(0.56, 0.52, 20):
                user.go(hand, device_place(height), views=0)
            state, tool = settled(hand, user, 60)
            assert tool.contact == "cube" and state.force @ outward > 0
            # The same displacement does the same work on both sides, but for one scale: it is that of the force over that of the length.
            ratios = []
            for axis in np.eye(3):
                work = state.force @ axis
                in_scene = tool.device_force @ rotated(view, axis)
                if abs(work) > 0.1 * np.linalg.norm(state.force):
                    ratios.append(work / in_scene)
            assert np.ptp(ratios) <= 0.02 * np.mean(ratios), ratios
            peak_in_scene = 4 * (4 * 20e3 * 0.04 * size) * 0.04 * size
            assert np.isclose(np.mean(ratios), state.force_limit / peak_in_scene, rtol=0.02)
            # As deep as the hand goes, and as quickly.
            for height in (0.4, 0.2, 0.0, 0.56, 0.1):
                user.go(hand, device_place(height))
                assert np.linalg.norm(hand.state.force) <= hand.state.force_limit * (1 + 1e-9)
            assert state.force_limit <= share * peak * (1 + 1e-9)
    # Datagrams have six decimals.
    assert 0.0 < user.largest <= share * peak + 2e-6


def test_a_view_that_turns_takes_the_hand_along_but_not_in_a_stroke(user):
    with pliant.Session(model()) as session:
        with session.hand().follow("pointer", user.params, buttons=([1], [0], [0])) as hand:
            user.go(hand, [0.09, 0, 0])
            start = hand.state.position
            quarter = [0, 0, np.sqrt(0.5), np.sqrt(0.5)]
            hand.guide(view=quarter)
            state, _ = settled(hand, user, 40)
            assert np.allclose(state.position, rotated(quarter, start), atol=1e-4 * 0.1)
            user.go(hand, [0.09, 0, 0], buttons=1)
            held = hand.state.position
            hand.guide(view=[0, 0, 0, 1], centre=[0, 0, 0.02])
            assert np.allclose(settled(hand, user)[0].position, held, atol=1e-5)
            user.go(hand, [0.09, 0, 0])
            assert np.allclose(settled(hand, user, 40)[0].position, start + [0, 0, 0.02], atol=1e-4)


def test_a_path_is_a_device_too_and_has_no_force(tmp_path):
    path = tmp_path / "path.csv"
    path.write_text("0,0,0,0.09\n0.3,0.05,0.1,0.05\n3600,0.05,0.1,0.05\n")
    with pliant.Session(model()) as session:
        with session.hand().follow("scripted", {"recording": path}) as hand:
            seen = hand.wait()
            while hand.time < 0.4:
                seen = hand.wait(seen, 20.0)
            assert hand.state.status == "ready" and hand.device == "scripted"
            assert hand.tool("finger").hand[2] != 0


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_a_pen_out_of_reach_waits_and_one_that_is_unplugged_is_lost(tmp_path):
    pipe = tmp_path / "pen"
    os.mkfifo(pipe)
    # An event of the kernel: time, type, code, value; a tablet says that a pen is there, where it is and how hard it presses.
    event = lambda kind, code, value: struct.pack("qqHHi", 0, 0, kind, code, value)
    tool_pen, x, y, sync = (1, 0x140), (3, 0), (3, 1), (0, 0)
    opened = {}
    # Opening a pipe waits for the other end.
    writer = threading.Thread(target=lambda: opened.setdefault("file", open(pipe, "wb", buffering=0)))
    writer.start()
    with pliant.Session(model()) as session:
        params = {"device": pipe, "x_max": 1000, "y_max": 1000, "pressure_max": 1000}
        with session.hand().follow("pen", params) as hand:
            writer.join(20)
            hand.wait(hand.wait(0, 20.0), 20.0)
            assert hand.state.status == "waiting" and hand.state.position is None
            events = event(*tool_pen, 1) + event(*x, 500) + event(*y, 500) + event(*sync, 0)
            opened["file"].write(events)
            seen = hand.wait()
            for _ in range(200):
                seen = hand.wait(seen, 20.0)
                if hand.state.status == "ready":
                    break
            assert hand.state.status == "ready", hand.state
            opened["file"].close()
            for _ in range(200):
                seen = hand.wait(seen, 20.0)
                if hand.state.status != "ready":
                    break
            assert hand.state.status in {"waiting", "lost"}
            assert hand.is_alive


def test_the_caller_cannot_move_a_hand_that_a_device_has(user):
    with pliant.Session(model()) as session:
        with session.hand().follow("pointer", user.params, buttons=([1], [0], [0])) as hand:
            user.go(hand, [0, 0, 0.09])
            with pytest.raises(pliant.PliantError, match="`pointer` has this hand") as caught:
                hand.go("finger", [0, 0, 0.1])
            assert caught.value.kind == "busy"


def test_the_caller_cannot_move_it_before_the_first_view_either(user):
    with pliant.Session(model()) as session:
        for _ in range(10):
            with session.hand().follow("pointer", user.params) as hand:
                with pytest.raises(pliant.PliantError, match="`pointer` has this hand") as caught:
                    hand.go("finger", [0, 0, 0.1])
                assert caught.value.kind == "busy"
                hand.wait(0, 20.0)
                assert hand.state.status == "waiting" and not len(hand.take_poses())


@pytest.mark.parametrize("ending", ["stop", "close", "drop", "error"])
def test_whatever_ends_it_closes_the_device_and_leaves_no_thread(user, ending):
    wait_for_the_end_of_threads()
    session = pliant.Session(model())
    hand = session.hand().follow("pointer", user.params, buttons=([1], [0], [0]))
    user.glide(hand, [0, 0, 0.09], [0, 0, 0.06], buttons=1, count=5)
    assert not is_free(user.address) and HAPTIC_THREADS <= set(thread_names())
    if ending == "stop":
        hand.stop()
        session.step()
        assert hand.stop() == []
        with pytest.raises(pliant.PliantError, match="stopped"):
            hand.state  # noqa: B018 - it raises
    elif ending == "close":
        session.close()
    elif ending == "drop":
        del hand
        gc.collect()
    else:
        with pytest.raises(ZeroDivisionError), session:
            1 / 0  # noqa: B018 - it raises
    assert is_free(user.address)
    wait_for_the_end_of_threads()


def test_the_end_of_the_interpreter_closes_the_device(user):
    program = f"""
import sys
sys.path.insert(0, {os.path.dirname(__file__)!r})
import pliant
from test_device_hand import model
session = pliant.Session(model())
hand = session.hand().follow("pointer", {user.params!r})
hand.wait(0, 20.0)
print(hand.state.status)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and done.stdout.strip() == "waiting", done
    assert not done.stderr and is_free(user.address)


@pytest.mark.parametrize(
    ("device", "params", "kind", "says"),
    [
        ("no-such", {}, "plugin", "no-such"),
        ("mass-spring", {}, "plugin", "no device"),
        ("pointer", {"reach": "1 s"}, "plugin", "reach"),
        ("pointer", {"reach": 1e9}, "plugin", "allowed is"),
        ("pointer", {"typo": 1}, "plugin", "address"),
        ("pointer", {"address": [1]}, "argument", "address"),
        ("scripted", {"path": "0"}, "plugin", "tables are for scenes"),
    ],
)
def test_a_device_that_cannot_be_opened_is_named_and_the_session_goes_on(device, params, kind, says):
    with pliant.Session(model()) as session:
        with pytest.raises(pliant.PliantError, match=says) as caught:
            session.hand().follow(device, params)
        assert caught.value.kind == kind, caught.value
        session.step()


def test_a_library_by_its_path_is_only_opened_from_an_allowed_folder(tmp_path):
    found = next(device for device in pliant.devices() if device.id == "pointer")
    library = tmp_path / os.path.basename(found.path)
    library.write_bytes(open(found.path, "rb").read())
    user = DeviceUser()
    with pliant.Session(model()) as session, pytest.raises(pliant.PliantError, match="allow_plugins"):
        session.hand().follow(str(library), user.params)
    with pliant.Session(model(), allow_plugins=[tmp_path]) as session:
        with session.hand().follow(f"{library}#pointer", user.params) as hand:
            user.go(hand, [0, 0, 0.09])
            assert hand.state.status == "ready"
    user.close()


def test_arguments_that_are_not_allowed(user):
    with pliant.Session(model()) as session:
        hand = session.hand()
        for arguments in (
            {"view": [0, 0, 0]},
            {"view": [0, 0, 0, 0]},
            {"centre": [0, np.nan, 0]},
            {"buttons": (0, 1)},
            {"buttons": 1},
            {"buttons": (0, None, 0)},
            {"buttons": (0, "ab", 0)},
            {"buttons": (0, [40], 0)},
            {"force_share": 1.5},
            {"force_share": np.nan},
        ):
            with pytest.raises(pliant.PliantError, match="allowed"):
                hand.follow("pointer", user.params, **arguments)
        assert is_free(user.address)
        with hand.follow("pointer", user.params) as led:
            with pytest.raises(pliant.PliantError, match="allowed"):
                led.guide(force_share=-1)
            led.guide(force_share=0.5)


def test_tools_that_share_a_device_cannot_be_given_to_another(user):
    scene = model()
    scene.tool("thumb", hand="hand", radius="4 mm")
    scene.edit("touch", tool="thumb")
    with pliant.Session(scene) as session, pytest.raises(pliant.PliantError, match="shares its device with tool `thumb`"):
        session.hand("finger").follow("pointer", user.params)


def test_other_tools_that_share_a_device_are_refused(user):
    scene = model()
    scene.hand("second")
    for name in ("other", "third"):
        scene.tool(name, hand="second", radius="4 mm")
        scene.edit("touch", tool=name)
    with pliant.Session(scene) as session:
        with pytest.raises(pliant.PliantError, match="tools `other` and `third` share a device.*allowed is") as caught:
            session.hand("finger").follow("pointer", user.params)
        assert caught.value.kind == "argument" and is_free(user.address)
        session.step()


def test_other_hands_are_moved_by_the_caller(user):
    scene = model()
    scene.hand("second")
    scene.tool("other", hand="second", radius="4 mm")
    scene.edit("touch", tool="other")
    with pliant.Session(scene) as session:
        with session.hand("finger").follow("pointer", user.params) as hand:
            user.go(hand, [0, 0, 0.09])
            hand.go("other", [0.06, 0, 0])
            seen = hand.wait()
            for _ in range(10):
                seen = hand.wait(seen, 20.0)
            assert np.allclose(hand.tool("other").hand, [0.06, 0, 0], atol=1e-9)
            hand.go("other", [0.05, 0, 0])
            for _ in range(20):
                seen = hand.wait(seen, 20.0)
            assert hand.tool("other").contact == "cube"
            assert set(hand.take_poses().tool) == {"finger", "other"}


def test_a_device_opened_and_dropped_many_times_leaves_nothing():
    user = DeviceUser()
    descriptors = lambda: len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0
    with pliant.Session(model()) as session:
        session.hand().follow("pointer", user.params).stop()
        before, threads = descriptors(), len(thread_names())
        for _ in range(20):
            session.hand().follow("pointer", user.params).stop()
        assert descriptors() == before and len(thread_names()) == threads
    user.close()


def test_a_session_that_a_device_leads_steps_without_the_interpreter(user):
    with pliant.Session(pressed()) as session:
        with session.hand().follow("pointer", user.params) as hand:
            hand.wait(0, 20.0)
            start, began = hand.time, time.perf_counter()
            # Nothing of Python runs in between: this call holds the interpreter's lock.
            while time.perf_counter() - began < 0.2:
                sum(range(20000))
            hand.wait(hand.wait(), 20.0)
            assert hand.time > start


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_fork_leaves_the_device_to_its_parent(user):
    with pliant.Session(model()) as session:
        with session.hand().follow("pointer", user.params) as hand:
            user.go(hand, [0, 0, 0.09])
            child = os.fork()
            if child == 0:
                try:
                    hand.stop()
                except pliant.PliantError as error:
                    os._exit(0 if error.kind == "closed" and "fork" in str(error) else 1)
                os._exit(2)
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
            user.go(hand, [0, 0, 0.08])
            assert hand.is_alive and hand.state.status == "ready"
