"""Sessions that go on by the clock."""

import gc
import os
import time

import numpy as np
import pytest
from conftest import block, pressed

import pliant


def test_a_live_session_follows_its_hand_and_gives_the_session_back():
    with pliant.Session(pressed()) as session:
        rest = session.rest_positions()
        frame = np.empty(rest.shape, dtype=np.float32)
        live = session.play()
        with pytest.raises(pliant.PliantError) as caught:
            session.step()
        assert caught.value.kind == "busy" and "clock" in str(caught.value)
        live.go("finger", [0, 0, 0.061])
        seen = live.wait(0, 5.0)
        live.go("finger", [0, 0, 0.052])
        for _ in range(20):
            seen = live.wait(seen, 5.0)
        assert live.read("cube", frame) >= seen > 0
        assert live.tool("finger").contact == "cube" and live.tool("finger").force[2] > 0.05
        assert live.is_alive and live.time > 0 and live.lost_time >= 0
        used = live.stop()
        assert session.steps == round(used[-1].time / session.dt) and used[-1].position == (0, 0, 0.052)
        assert np.abs(frame - rest).max() > 1e-3
        assert live.stop() == []
        with pytest.raises(pliant.PliantError, match="stopped"):
            live.read("cube", frame)
        session.step()


def test_what_a_live_session_did_can_be_made_again():
    with pliant.Session(pressed()) as session, pliant.Session(pressed()) as again:
        with session.play() as live:
            live.go("finger", [0, 0, 0.061])
            for height in (0.058, 0.055, 0.053):
                live.wait(live.wait(), 5.0)
                live.go("finger", [0.001, 0, height], buttons=[1])
            for _ in range(5):
                live.wait(live.wait(), 5.0)
            used = live.stop()
        hand, poses = again.hand("finger"), {round(pose.time / again.dt): pose for pose in used}
        for step in range(1, session.steps + 1):
            if step in poses:
                pose = poses[step]
                hand.go(pose.position, pose.rotation, pose.buttons)
            again.step()
        assert np.array_equal(session.positions(), again.positions())
        assert not np.array_equal(session.positions(), session.rest_positions())


def test_positions_go_through_a_matrix_and_into_arrays_that_fit():
    matrix = np.array([[0, -2, 0, 1], [2, 0, 0, 0], [0, 0, 2, -1], [0, 0, 0, 1]])
    with pliant.Session(pressed()) as session:
        rest = session.rest_positions()
        with session.play() as live:
            live.wait(0, 5.0)
            out = np.empty(rest.shape, dtype=np.float32)
            live.read("cube", out, matrix)
            assert np.allclose(out, rest @ matrix[:3, :3].T + matrix[:3, 3], atol=1e-6)
            part = np.empty((5, 3), dtype=np.float32)
            live.read("cube", part)
            assert np.allclose(part, rest[:5], atol=1e-7)
            for wrong in (np.empty((len(rest) + 1, 3), dtype=np.float32), np.empty((4, 6), dtype=np.float32)[:, ::2]):
                with pytest.raises(pliant.PliantError, match="allowed"):
                    live.read("cube", wrong)
            with pytest.raises(pliant.PliantError, match="`cube`"):
                live.read("cub", part)
            with pytest.raises(pliant.PliantError, match="`finger`"):
                live.go("thumb", [0, 0, 0])


def test_positions_that_were_kept_stay_as_they_are_while_the_session_goes_on():
    with pliant.Session(pressed()) as session:
        kept = np.asarray(session.positions())
        values = kept.copy()
        with session.play() as live:
            live.go("finger", [0, 0, 0.061])
            live.wait(live.wait(), 5.0)
            live.go("finger", [0, 0, 0.05])
            for _ in range(10):
                live.wait(live.wait(), 5.0)
        assert np.array_equal(kept, values) and not np.array_equal(session.positions(), values)


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="no /proc here")
def test_a_live_session_that_is_dropped_ends_its_thread():
    def names():
        return [open(f"/proc/self/task/{task}/comm").read().strip() for task in os.listdir("/proc/self/task")]

    session = pliant.Session(pressed())
    live = session.play()
    live.wait(0, 5.0)
    assert "pliant-live" in names()
    del live
    gc.collect()
    end = time.monotonic() + 5
    while "pliant-live" in names() and time.monotonic() < end:
        time.sleep(0.01)
    assert "pliant-live" not in names()


def test_lids_over_holes_are_not_counted():
    vertices, faces = block(4)
    scene = pliant.Scene()
    scene.time(dt="1 ms")
    material = pliant.Material("mass-spring", young="300 kPa", density=1000, damping_time="0.5 ms")
    # One face is missing: a cut closes the hole by a lid, which is not seen.
    scene.body("cube", mesh=vertices, faces=faces[1:], material=material, grid={"level": 4})
    scene.hand("hand", peak_force=50)
    blade = {"length": "160 mm", "direction": [0, 1, 0], "toughness": "1 J/m^2"}
    scene.tool("knife", radius="1 mm", blade=blade, speed="20 m/s")
    scene.edit("cut", tool="knife")
    with pliant.Session(scene) as session:
        whole = len(session.triangles())
        assert session.cut([[x, -0.08, 0.01] for x in np.linspace(-0.07, 0.07, 40)]) == 1
        with session.play() as live:
            live.wait(0, 20.0)
            count = live.triangle_count("cube")
        assert count == len(session.triangles()) > whole


def test_triangles_that_have_torn_are_not_counted(scenes):
    with pliant.Session(scenes / "tear.toml") as session:
        whole = len(session.triangles())
        torn = whole
        while torn == whole and session.steps < session.planned_steps:
            session.step(10)
            torn = len(session.triangles())
        with session.play() as live:
            live.wait(0, 60.0)
            count = live.triangle_count("membrane")
        # More may tear while it goes on.
        assert len(session.triangles()) <= count <= torn < whole
