"""Devices with something behind them that is not in this process or not in the package: a stand-in of a driver, and a twin."""

import ctypes
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from device_user import free_address
from test_device_hand import model

import pliant


def built(name: str) -> Path:
    """What cargo has built for the tests of the workspace."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    for profile in ("release", "debug"):
        path = target / profile / name
        if path.exists():
            return path
    pytest.skip(f"{name} is not in {target}; `cargo build --release -p pliant-hd-stub -p pliant-twin-exoskeleton` builds it")


class Arm:
    """The stand-in of the driver of an arm, and the hand that holds the arm."""

    def __init__(self):
        self.path = built("libHD.so")
        self.library = ctypes.CDLL(str(self.path))
        self.library.pliant_stub_reset()

    def hold(self, place, stiffness=400.0, buttons=0):
        """Pull the stylus to a place (m) of the arm's axes, with these buttons pressed."""
        self.library.pliant_stub_set_hand(ctypes.c_uint32(0), *map(ctypes.c_double, (*place, stiffness)))
        self.library.pliant_stub_set_stylus(ctypes.c_uint32(0), ctypes.c_int(buttons), ctypes.c_uint8(0))

    def read(self):
        """Its tip (m), the force of its motors (N), and whether the driver's rules were broken."""
        numbers = (ctypes.c_double * 11)()
        self.library.pliant_stub_read_arm(ctypes.c_uint32(0), numbers)
        return np.array(numbers[:3]), np.array(numbers[3:6]), numbers[10]


    def calls(self):
        """How often the driver was asked to open and to close a device."""
        counts = (ctypes.c_uint64 * 2)()
        self.library.pliant_stub_read_calls(counts)
        return tuple(counts)


@pytest.fixture
def arm():
    """A driver with an arm behind it."""
    return Arm()


def wait_until(hand, is_true, views=3000):
    """Wait for something to be so in a view."""
    seen = hand.wait()
    for _ in range(views):
        if is_true():
            return
        seen = hand.wait(seen, 20.0)
    raise AssertionError(f"it does not come about: {hand.state}")


def follow(session, arm, **params):
    """Give the hand of a session to the arm, from the allowed folder of its driver."""
    return session.hand().follow("phantom", {"library": arm.path, "inkwell": "works"} | params, buttons=(0, [0], [0]))


def press(hand, arm, height, buttons):
    """Come onto the cube from above, down to a height (m); give where the arm is at the middle of the scene, m, and the scale of lengths."""
    wait_until(hand, lambda: hand.state.status == "ready")
    # What the arm has in its hand is where its tip is, but for the scale.
    scale = hand.state.length_scale
    middle = arm.read()[0] - hand.state.position / scale
    # Out of the cube first, where the arm was when the session began: from inside it would push the surface out.
    hand.guide(buttons=(0, 0, 0))
    arm.hold(middle + np.array([0, 0, 0.09]) / scale)
    wait_until(hand, lambda: hand.state.position[2] > 0.085)
    hand.guide(buttons=buttons)
    for above in np.linspace(0.09, height, 20):
        arm.hold(middle + np.array([0, 0, above]) / scale)
        hand.wait(hand.wait(), 20.0)
    wait_until(hand, lambda: hand.tool("finger").contact == "cube" and hand.state.force[2] > 0.2)
    return middle, scale


def test_an_arm_behind_a_driver_feels_and_sculpts(arm):
    with pliant.Session(model(), allow_plugins=[arm.path.parent]) as session:
        with follow(session, arm) as hand:
            middle, scale = press(hand, arm, 0.04, ([1], [0], [0]))
            tip, force, violations = arm.read()
            assert force[2] > 0.1 and np.linalg.norm(force) <= 3.3 + 1e-9 and violations == 0
            assert hand.state.strokes == 0
            arm.hold(middle + np.array([0, 0, 0.04]) / scale, buttons=1)
            wait_until(hand, lambda: hand.state.strokes == 1)
            arm.hold(middle + np.array([0, 0, 0.09]) / scale)
            wait_until(hand, lambda: not hand.state.in_stroke)
        assert session.history[0] == 1
        assert np.isnan(arm.read()[0]).all(), "the arm is closed"


@pytest.mark.parametrize("size", [0.1, 0.11])
def test_another_session_goes_on_with_an_arm_that_presses(arm, size):
    with pliant.Session(model(), allow_plugins=[arm.path.parent]) as session, pliant.Session(model(size)) as other:
        hand = follow(session, arm)
        press(hand, arm, 0.045, ([1], [1], [1]))
        felt = hand.state.force[2]
        following = other.hand("finger").follow(hand)
        assert arm.calls() == (1, 0), "neither closed nor opened"
        # The force of the motors, while the other session begins.
        least, seen = felt, 0
        for _ in range(30):
            seen = following.wait(seen, 20.0)
            least = min(least, arm.read()[1][2])
        assert least > 0.3 * felt, f"{least} N after {felt} N"
        assert following.tool("finger").contact == "cube"
        assert arm.read()[2] == 0, "the driver's rules hold"
        session.step()
        with pytest.raises(pliant.PliantError, match="one of this session"):
            session.hand("finger").follow(hand)
        with pliant.Session(model()) as third, pytest.raises(pliant.PliantError, match="no device"):
            third.hand("finger").follow(hand)
        with pytest.raises(pliant.PliantError, match="params has `library`"):
            session.hand("finger").follow(following, {"library": arm.path})
        following.stop()
        assert arm.calls() == (1, 1) and np.isnan(arm.read()[0]).all()


def test_a_paused_hand_keeps_its_device_until_it_is_stopped(arm):
    with pliant.Session(model(), allow_plugins=[arm.path.parent]) as session:
        hand = follow(session, arm)
        wait_until(hand, lambda: hand.state.status == "ready")
        hand.pause()
        session.step()
        assert arm.calls() == (1, 0)
        hand.stop()
        assert arm.calls() == (1, 1)


def test_an_arm_that_is_unplugged_is_lost_and_the_hand_is_the_callers(arm):
    with pliant.Session(model(), allow_plugins=[arm.path.parent]) as session:
        with follow(session, arm, lost_after="0.2 s") as hand:
            wait_until(hand, lambda: hand.state.status == "ready")
            arm.library.pliant_stub_set_plugged(ctypes.c_uint8(0))
            wait_until(hand, lambda: hand.state.status == "lost")
            state = hand.state
            assert "phantom" in state.reason and state.position is None and not state.force.any()
            assert hand.is_alive
            # The caller has the hand now.
            hand.go("finger", [0, 0, 0.06], buttons=[1])
            wait_until(hand, lambda: np.allclose(hand.tool("finger").hand, [0, 0, 0.06]))
            hand.go("finger", [0, 0, 0.05], buttons=[1])
            wait_until(hand, lambda: hand.tool("finger").contact == "cube")
            hand.stop()
        session.step()


def test_a_driver_from_a_folder_that_is_not_allowed_is_refused(arm):
    with pliant.Session(model()) as session, pytest.raises(pliant.PliantError, match="allow_plugins"):
        follow(session, arm)


def test_a_twin_that_ends_is_lost():
    address = free_address()
    program = built("pliant-twin-exoskeleton")
    twin = subprocess.Popen([program, "--address", address, "--hand", "keyframed"], stdout=subprocess.PIPE, text=True)
    try:
        assert "ready" in twin.stdout.readline()
        with pliant.Session(model()) as session:
            with session.hand().follow("exoskeleton", {"peer": address, "lost_after": 0.3}) as hand:
                wait_until(hand, lambda: hand.state.status == "ready")
                assert hand.state.force_limit > 0 and hand.state.position is not None
                twin.terminate()
                wait_until(hand, lambda: hand.state.status == "lost")
                assert "exoskeleton" in hand.state.reason
    finally:
        twin.kill()
        twin.wait()
        twin.stdout.close()


def test_a_device_that_is_not_there_says_what_to_do():
    with pliant.Session(model()) as session:
        with pytest.raises(pliant.PliantError, match="twin") as caught:
            session.hand().follow("exoskeleton", {"peer": free_address(), "patience": 0.1})
        assert caught.value.kind == "plugin"
        session.step()
