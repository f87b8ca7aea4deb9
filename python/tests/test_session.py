"""Sessions: hands, forces, views without a copy, undo, snapshots, threads."""

import gc
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time

import numpy as np
import pytest
from conftest import block, pressed

import pliant


def press(session: pliant.Session, depth: float, steps: int = 300) -> float:
    """Press the top of the cube in, wait, and give the force out of it, N."""
    hand = session.hand("finger")
    for height in np.linspace(0.065, 0.06 - depth, steps):
        hand.go([0, 0.0, height])
        session.step()
    session.step(200)
    return session.force("finger")[2]


def test_a_hand_feels_what_it_presses_and_nothing_elsewhere():
    with pliant.Session(pressed()) as session:
        session.step(3)
        assert not session.force().any(), "no hand yet"
        light, deep = press(session, 0.003), press(session, 0.008, 100)
        assert 0.05 < light < deep
        state = session.tool("finger")
        assert state.contact == "cube" and state.depth > 0 and not state.holds
        # The spring between hand and surface is what the hand feels.
        assert state.force[2] == pytest.approx(300.0 * (state.proxy - state.hand)[2], rel=0.02)
        session.hand("finger").leave()
        session.step(2)
        assert not session.force("finger").any()


def test_hands_from_python_do_what_scripted_hands_do():
    path = [[0, 0, 0, 0.065], [0.2, 0, 0, 0.055]]
    scripted = pressed()
    data = scripted.to_dict()
    data["device"][0]["params"]["path"] = path
    one = pliant.Scene(data)
    one._meshes = scripted._meshes
    with pliant.Session(one) as first, pliant.Session(pressed()) as second:
        hand = second.hand("finger")
        for step in range(1, 201):
            share = step * 1e-3 / 0.2
            hand.go([0, 0, 0.065 + share * (0.055 - 0.065)])
            first.step()
            second.step()
            assert np.allclose(first.force("finger"), second.force("finger"), rtol=1e-6, atol=1e-9)
        assert first.force("finger")[2] > 0.05


def test_a_turned_hand_turns_its_blade():
    scene = knife()
    with pliant.Session(scene) as session:
        # Across x the blade lies along y; turned by 90 degrees about z it lies along x and does not reach the sides.
        turned = np.array([0, 0, np.sin(np.pi / 4), np.cos(np.pi / 4)])
        path = [[x, -0.08, 0.0] for x in np.linspace(-0.07, 0.07, 40)]
        assert session.cut(path, rotation=turned) == 0
        assert session.cut(path) == 1


def knife() -> pliant.Scene:
    vertices, faces = block(4)
    scene = pliant.Scene()
    scene.time(dt="1 ms", duration=1)
    material = pliant.Material("mass-spring", young="300 kPa", density=1000, damping_time="0.5 ms")
    scene.body("cube", mesh=vertices, faces=faces, material=material, grid={"level": 4})
    scene.hand("hand", peak_force=50)
    blade = {"length": "160 mm", "direction": [0, 1, 0], "toughness": "1 J/m^2"}
    scene.tool("knife", radius="1 mm", blade=blade, speed="20 m/s")
    scene.edit("cut", tool="knife", button=0)
    scene.probe("parts", "parts")
    return scene


def test_a_cut_parts_a_cube_and_is_taken_back_and_made_again():
    with pliant.Session(knife()) as session:
        before, triangles = session.positions().copy(), session.triangles()
        assert session.cut([[x, -0.08, 0.01] for x in np.linspace(-0.07, 0.07, 40)]) == 1
        mesh = session.mesh()
        assert len(mesh.triangles) > len(triangles)
        caps = mesh.face_of == mesh.face_of.max()
        assert mesh.face_of.max() == 96, "faces of the cube, then caps"
        areas = np.linalg.norm(
            np.cross(*(mesh.vertices[mesh.triangles[:, i]] - mesh.vertices[mesh.triangles[:, 0]] for i in (1, 2))), axis=1
        ).sum(where=caps) / 2
        assert areas == pytest.approx(2 * 0.1 * 0.1, rel=0.02), "two walls as large as the cube's section"
        assert session.undo() and session.history == (0, 1)
        assert np.array_equal(session.triangles(), triangles)
        assert np.allclose(session.positions(), before, atol=1e-6)
        assert session.redo()
        assert np.array_equal(session.triangles(), mesh.triangles)
        assert not session.redo()


def test_positions_are_a_view_without_a_copy():
    with pliant.Session(pressed()) as session:
        one, other = np.asarray(session.positions("cube")), np.asarray(session.positions("cube"))
        assert one.base is not None and np.shares_memory(one, other)
        assert not one.flags.writeable and one.flags.c_contiguous and one.dtype == np.float64
        with pytest.raises(ValueError):
            one[0] = 0
        with pytest.raises(ValueError):
            one.flags.writeable = True


def test_positions_are_where_the_engine_has_them():
    def address(session):
        return session.positions("cube").__array__().__array_interface__["data"][0]

    with pliant.Session(pressed()) as session:
        session.step()
        before = np.asarray(session.positions("cube"))
        places, kept = address(session), before.ctypes.data
        assert kept == places, "each view is of the same memory"
        del before
        hand = session.hand("finger")
        for height in np.linspace(0.06, 0.052, 40):
            hand.go([0, 0, height])
            session.step()
            assert address(session) == places, "a step writes where the array was"
        held = np.asarray(session.positions("cube"))
        session.step()
        # One that is held keeps its memory, and the engine goes on in another one.
        assert held.ctypes.data == places != address(session)


def test_positions_say_when_they_are_no_longer_valid():
    with pliant.Session(pressed()) as session:
        session.step()
        positions = session.positions("cube")
        assert positions.is_valid and len(positions) == positions.shape[0]
        assert np.array_equal(positions + 1.0, np.asarray(positions) + 1.0)
        assert np.mean(positions, axis=0).shape == (3,)
        kept = np.asarray(positions)
        values = kept.copy()
        press(session, 0.01)
        assert not positions.is_valid and "no longer valid" in repr(positions)
        for use in (lambda: positions[0], lambda: positions + 1, lambda: np.asarray(positions), lambda: len(positions)):
            with pytest.raises(pliant.PliantError) as caught:
                use()
            assert caught.value.kind == "stale"
        assert np.array_equal(kept, values), "an array that was kept stays as it was"
        assert not np.shares_memory(kept, session.positions("cube"))
        assert np.abs(np.asarray(session.positions("cube")) - values).max() > 1e-3
    assert np.array_equal(kept, values), "also after the session has ended"
    with pytest.raises(pliant.PliantError) as caught:
        session.positions("cube")
    assert caught.value.kind == "closed"
    del session
    gc.collect()
    assert np.array_equal(kept, values)


def test_slices_keep_their_memory_through_cuts():
    with pliant.Session(knife()) as session:
        part = session.positions()[3:7]
        values = part.copy()
        session.cut([[x, -0.08, 0.01] for x in np.linspace(-0.07, 0.07, 40)])
        assert len(session.positions()) > 98
        assert np.array_equal(part, values)


def test_a_snapshot_goes_back_to_the_same_motion():
    with pliant.Session(pressed()) as session:
        hand = session.hand("finger")
        hand.go([0, 0, 0.055])
        session.step(50)
        snapshot = session.snapshot()
        futures = []
        for _ in range(2):
            session.restore(snapshot)
            assert session.steps == 50
            session.step(40)
            futures.append((session.positions().copy(), session.force().copy()))
        assert np.array_equal(futures[0][0], futures[1][0]) and np.array_equal(futures[0][1], futures[1][1])
        with pliant.Session(pressed()) as other, pytest.raises(pliant.PliantError, match="another session"):
            other.restore(snapshot)


def test_a_snapshot_of_cuts_that_were_made_otherwise_is_refused():
    with pliant.Session(knife()) as session:
        whole = session.snapshot()
        path = np.array([[x, -0.08, 0.01] for x in np.linspace(-0.07, 0.07, 40)])
        session.cut(path)
        cut, triangles = session.snapshot(), session.triangles()
        session.restore(whole)
        assert len(session.triangles()) == 192
        session.restore(cut)
        assert np.array_equal(session.triangles(), triangles)
        session.restore(whole)
        session.cut(path - [0, 0, 0.03])
        with pytest.raises(pliant.PliantError, match="something else was cut"):
            session.restore(cut)
        session.restore(whole)
        assert len(session.triangles()) == 192


def test_names_that_are_none_are_told():
    with pliant.Session(pressed()) as session:
        for use in (lambda: session.positions("cub"), lambda: session.force("thumb"), lambda: session.hand("thumb").go([0, 0, 0])):
            with pytest.raises(pliant.PliantError, match="`(cube|finger)`"):
                use()
        for use in (
            lambda: session.hand().go([0, 0]),
            lambda: session.hand().go([0, 0, np.nan]),
            lambda: session.hand().go([0, 0, 0], rotation=[0, 0, 0, 0]),
            lambda: session.hand().go([0, 0, 0], buttons=[32]),
            lambda: session.step(-1),
        ):
            with pytest.raises(pliant.PliantError, match="allowed"):
                use()


def test_a_ray_meets_the_mesh_where_it_is():
    with pliant.Session(pressed()) as session:
        mesh = session.mesh()
    hit = mesh.cast([0.01, 0.013, 1.0], [0, 0, -2.0])
    assert np.allclose(hit.point, [0.01, 0.013, 0.05]) and np.allclose(hit.normal, [0, 0, 1])
    assert np.allclose(mesh.vertices[mesh.triangles[hit.triangle], 2], 0.05)
    assert mesh.cast([1.0, 0, 1.0], [0, 0, -1.0]) is None


def test_a_plan_says_what_the_program_says():
    with pliant.Session(pressed()) as session:
        plan = session.plan()
        assert plan["dt"] == session.dt and plan["steps"] == session.planned_steps == 1000
        assert plan["choices"]["step_limit"] > 0 and plan["step_cost"][0]["body"] == "cube"
        assert {loaded["id"] for loaded in plan["loaded"]} == {"mass-spring", "octree-grid", "scripted"}


def test_a_lost_limit_is_an_event():
    with pliant.Session(pressed(speed="0.01 m/s")) as session:
        hand = session.hand()
        hand.go([0, 0, 0.1])
        session.step()
        hand.go([0, 0, 0.2])
        session.step(10)
        assert session.events()["counts"]["speed-limit"] == 10


def test_a_panic_is_an_exception():
    with pytest.raises(pliant.PliantError) as caught:
        pliant._native.raise_panic("ouch")
    assert caught.value.kind == "panic" and "ouch" in str(caught.value) and "failure.rs" in caught.value.where


def test_errors_go_to_other_processes_whole():
    error = pickle.loads(pickle.dumps(pliant.PliantError("text", "scene", "a.toml:1:2")))
    assert (str(error), error.kind, error.where) == ("text", "scene", "a.toml:1:2")


def test_a_session_is_one_threads_at_a_time_and_steps_let_others_run():
    with pliant.Session(pressed()) as session:
        press(session, 0.005, 50)
        stop, errors, counted = threading.Event(), [], [0]

        def step():
            while not stop.is_set():
                try:
                    session.step(200)
                except pliant.PliantError as error:
                    errors.append(error.kind)

        threads = [threading.Thread(target=step) for _ in range(2)]
        for thread in threads:
            thread.start()
        end = time.monotonic() + 0.5
        while time.monotonic() < end:
            counted[0] += 1
        stop.set()
        for thread in threads:
            thread.join()
        assert set(errors) == {"busy"} and counted[0] > 1000


def test_two_sessions_on_two_threads_are_as_two_after_each_other():
    def run(results, index):
        with pliant.Session(pressed()) as session:
            press(session, 0.004)
            results[index] = session.positions().copy()

    alone, together = {}, {}
    run(alone, 0)
    threads = [threading.Thread(target=run, args=(together, index)) for index in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(alone[0], other) for other in together.values()) and len(together) == 2


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_fork_is_told_that_the_session_is_not_its_own():
    with pliant.Session(pressed()) as session:
        session.step(10)
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                session.step()
                answer = b"stepped"
            except pliant.PliantError as error:
                answer = error.kind.encode()
            os.write(write, answer)
            session.close()
            del session
            gc.collect()
            os._exit(0)
        _, status = os.waitpid(child, 0)
        assert status == 0 and os.read(read, 100) == b"closed"
        session.step()


def test_a_new_process_opens_sessions_of_its_own():
    context = multiprocessing.get_context("spawn")
    with context.Pool(1) as pool:
        assert pool.apply(_largest_force) == _largest_force() > 0.05


def _largest_force() -> float:
    with pliant.Session(pressed()) as session:
        return press(session, 0.005)


@pytest.mark.skipif(os.name == "nt", reason="signals are others there")
def test_ctrl_c_stops_between_steps():
    with pliant.Session(pressed()) as session:
        press(session, 0.005, 50)
        timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
        before, many = session.steps, 10_000_000
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            session.step(many)
        assert before < session.steps < before + many
        session.step()


# A body that falls on its fixed bottom, with years of substeps in one step.
ENDLESS = {
    "gravity": [0.0, 0.0, -9.81],
    "body.0.grid.region": "whole",
    "time.integrator": "symplectic-euler",
    "time.substeps": 4_000_000_000,
    "time.most-substeps": 4_294_967_295,
}


@pytest.mark.skipif(sys.platform != "linux", reason="noticed between steps elsewhere")
@pytest.mark.filterwarnings("ignore:hands without a path")
def test_ctrl_c_ends_the_step_under_way():
    with pliant.Session(pressed(), set=ENDLESS) as session:
        timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            session.step()
        assert session.steps == 0
    with pytest.raises(KeyboardInterrupt):
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        pliant.run(pressed(), set=ENDLESS)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_signal_that_raises_nothing_costs_no_step():
    def final(signals: int) -> np.ndarray:
        with pliant.Session(pressed()) as session:
            taken = []

            def more(*_) -> None:
                taken.append(session.steps)
                if len(taken) < signals:
                    threading.Timer(0.005, os.kill, (os.getpid(), signal.SIGINT)).start()

            before = signal.signal(signal.SIGINT, more)
            try:
                press(session, 0.005, 50)
                if signals:
                    os.kill(os.getpid(), signal.SIGINT)
                session.step(500)
                assert session.steps == 750
                surface = session.positions("cube").copy()
                # The rest of the signals, however fast the steps were.
                while len(taken) < signals:
                    session.step()
            finally:
                signal.signal(signal.SIGINT, before)
            return surface

    # The tool moves on in a step that is begun again: not the same bits, but the same place within a hundred-thousandth of the cube.
    assert np.allclose(final(0), final(20), rtol=0, atol=1e-6)


def test_ctrl_c_leaves_a_session_of_another_thread_alone():
    with pliant.Session(pressed()) as session:
        stop = threading.Event()

        def go_on() -> None:
            while not stop.is_set():
                session.step()

        other = threading.Thread(target=go_on)
        threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
        with pytest.raises(KeyboardInterrupt):
            other.start()
            while True:
                time.sleep(0.01)
        assert other.is_alive()
        stop.set()
        other.join()
        assert session.steps > 0


def test_a_thousand_sessions_leave_nothing():
    def resident() -> int:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    if not os.path.exists("/proc/self/statm"):
        pytest.skip("no /proc here")
    scene = pressed()

    def open_and_drop(count: int) -> None:
        for _ in range(count):
            session = pliant.Session(scene, set={"body.0.grid.level": 2})
            session.hand().go([0, 0, 0.055])
            session.step(2)
            del session

    open_and_drop(200)
    gc.collect()
    threads, memory = len(os.listdir("/proc/self/task")), resident()
    open_and_drop(1000)
    gc.collect()
    assert len(os.listdir("/proc/self/task")) <= threads
    # 4 kB for each would be 4 MB: less than the smallest part of a session.
    assert resident() - memory < 4 << 20


def two_blocks() -> pliant.Scene:
    """A body of two blocks of 100 mm, 50 mm apart, that a finger may touch."""
    vertices, faces = block()
    away = np.array([0.15, 0.0, 0.0])
    scene = pliant.Scene()
    both = np.vstack([vertices, vertices + away])
    material = pliant.Material("mass-spring", young=20e3)
    scene.body("two", mesh=both, faces=np.vstack([faces, faces + len(vertices)]), material=material, grid={"level": 5})
    scene.hand("finger")
    scene.tool("finger", hand="finger", radius=5e-3)
    scene.edit("touch", tool="finger")
    return scene


@pytest.mark.parametrize("triangle", [None, 0, -1])
def test_parts_become_bodies_and_one_again(triangle):
    with pliant.Session(two_blocks()) as session:
        session.step(2)
        whole, before = session.triangles("two").copy(), session.positions("two").copy()
        names = session.split("two", triangle=None if triangle is None else triangle % len(whole))
        assert names == ["two", "two-2"] == list(session.bodies)
        parts = [session.triangles(name) for name in names]
        assert sorted(map(tuple, np.vstack(parts))) == sorted(map(tuple, whole))
        assert not set(parts[0].ravel()) & set(parts[1].ravel()), "no vertex is of both"
        assert np.array_equal(session.positions("two-2")[parts[1]], before[parts[1]])
        session.step(2)
        assert session.undo()
        assert list(session.bodies) == ["two"]
        assert np.array_equal(session.triangles("two"), whole)


def test_what_cannot_be_split_is_refused():
    with pliant.Session(two_blocks()) as session:
        with pytest.raises(pliant.PliantError, match="no body `three`; allowed is `two`"):
            session.split("three")
        with pytest.raises(pliant.PliantError, match="allowed is a row of `triangles\\(\\)`"):
            session.split("two", triangle=10**6)
    with pliant.Session(pressed()) as session, pytest.raises(pliant.PliantError, match="it is in one part"):
        session.split("cube")
