"""Batches: many sessions at once, and sweeps of many edits, here and on a cluster."""

import gc
import threading

import numpy as np
import pytest
from conftest import block, pressed

import pliant
import pliant.batch

YOUNG = "body.0.material.params.young"


def scripted(depth: float = 0.005) -> pliant.Scene:
    vertices, faces = block()
    scene = pliant.Scene()
    scene.time(duration=0.06, dt="1 ms")
    material = pliant.Material("mass-spring", young="20 kPa", density=1000, damping_time="0.5 ms")
    fixed = [{"box": [[-1, -1, -0.051], [1, 1, -0.049]]}]
    scene.body("cube", mesh=vertices, faces=faces, material=material, grid={"level": 4}, fixed=fixed)
    scene.hand("hand", path=[[0, 0, 0, 0.062], [0.06, 0, 0, 0.06 - depth]])
    scene.tool("finger", radius="10 mm", stiffness="300 N/m")
    scene.edit("touch", tool="finger")
    scene.probe("largest force", "force", greatest=True)
    return scene


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_instances_do_what_sessions_of_their_own_do(jobs):
    young = np.geomspace(5e3, 80e3, 5)
    batch = pliant.Batch(scripted(), 5, set={"tool.0.stiffness": "200 N/m"}, each={YOUNG: young}, jobs=jobs)
    result = batch.run()
    assert result.failures == {} and result.tools["finger"].force.shape == (5, 60, 3)
    places = batch.positions("cube")
    for number, stiffness in enumerate(young):
        alone = pliant.run(scripted(), set={"tool.0.stiffness": "200 N/m", YOUNG: stiffness}, threads=1)
        assert np.array_equal(result.time, alone.trace.time)
        assert np.array_equal(result.tools["finger"].force[number], alone.tools["finger"].force)
        assert np.array_equal(result.tools["finger"].depth[number], alone.tools["finger"].depth)
        assert np.array_equal(places[number], alone.meshes["cube"].vertices)
        assert result.probes["largest force"][number] == alone.probes["largest force"].value
    assert (np.diff(result.probes["largest force"]) > 0).all(), "the stiffer, the larger"


def test_hands_of_a_batch_go_where_each_is_told():
    batch = pliant.Batch(pressed(), 4)
    heights = np.array([0.058, 0.056, 0.054, 0.07])
    for share in np.linspace(0, 1, 60):
        batch.go(np.column_stack([np.zeros(4), np.zeros(4), 0.065 + share * (heights - 0.065)]))
        batch.step()
    state = batch.tool("finger")
    assert np.allclose(state.hand[:, 2], heights)
    assert state.touches.tolist() == [True, True, True, False]
    assert (np.diff(batch.force()[:3, 2]) > 0).all() and not batch.force()[3].any()
    with pliant.Session(pressed(), threads=1) as session:
        hand = session.hand("finger")
        for share in np.linspace(0, 1, 60):
            hand.go([0, 0, 0.065 + share * (heights[1] - 0.065)])
            session.step()
        assert np.array_equal(session.force(), batch.force()[1])
    batch.leave()
    batch.step(2)
    assert not batch.force().any() and batch.steps.tolist() == [62] * 4


def test_what_is_wrong_with_a_batch_is_told():
    with pytest.raises(pliant.PliantError, match="3 values; allowed is 4"):
        pliant.Batch(scripted(), 4, each={YOUNG: [1e4, 2e4, 3e4]})
    with pytest.raises(pliant.PliantError, match="n is 0"):
        pliant.Batch(scripted(), 0)
    with pytest.raises(pliant.PliantError, match="instance 2: .*young"):
        pliant.Batch(scripted(), 3, each={YOUNG: [1e4, 2e4, -1.0]})
    batch = pliant.Batch(scripted(), 2)
    with pytest.raises(pliant.PliantError, match=r"shape \(3, 3\); allowed is \(2, 3\)"):
        batch.go(np.zeros((3, 3)))
    with pytest.raises(pliant.PliantError, match="no tool `fist`.*`finger`"):
        batch.force("fist")
    with pytest.raises(pliant.PliantError, match="no body `ball`"):
        batch.positions("ball")
    ragged = pliant.Batch(scripted(), 2, each={"time.duration": [0.01, 0.02]})
    with pytest.raises(pliant.PliantError, match="steps of their own"):
        ragged.run()


def test_an_instance_that_fails_leaves_the_others_alone():
    bad = threading.Event()

    def law(can_fail: bool) -> pliant.Hyperelastic:
        def stress(F):
            return np.full(F.shape, np.nan) if can_fail and bad.is_set() else 1e4 * (F - np.eye(3))

        return pliant.Hyperelastic(lambda F: 5e3 * ((F - np.eye(3)) ** 2).sum((1, 2)), stress, damping_time="1 ms")

    laws = [law(False), law(True), law(False)]
    scene = pliant.Scene()
    scene.time(duration=0.06, dt="1 ms")
    vertices, faces = block(4)
    fixed = [{"box": [[-1, -1, -0.051], [1, 1, -0.049]]}]
    scene.body("cube", mesh=vertices, faces=faces, material=laws[0], grid={"level": 2}, fixed=fixed)
    scene.hand("hand", path=[[0, 0, 0, 0.072], [0.06, 0, 0, 0.062]])
    scene.tool("finger", radius="20 mm", stiffness="300 N/m")
    scene.edit("touch", tool="finger")
    numbers = [each.to_dict()["params"]["law"] for each in laws]
    batch = pliant.Batch(scene, 3, each={"body.0.material.params.law": numbers})
    batch.step(10)
    bad.set()
    batch.step(50)
    assert list(batch.failures) == [1] and "quarantine" in batch.failures[1]
    force = batch.force()
    assert force[0].any() and np.array_equal(force[0], force[2])


def test_a_batch_is_used_by_one_thread_at_a_time():
    batch = pliant.Batch(scripted(), 4)
    thread = threading.Thread(target=batch.step, args=(300,))
    thread.start()
    kinds = set()
    while thread.is_alive():
        try:
            batch.force()
        except pliant.PliantError as error:
            kinds.add(error.kind)
    thread.join()
    assert kinds <= {"busy"} and batch.steps.tolist() == [300] * 4


def test_batches_leave_no_thread():
    before = threading.active_count(), _threads()
    for _ in range(3):
        pliant.Batch(scripted(), 3).step(3)
    gc.collect()
    assert (threading.active_count(), _threads()) == before


def _threads() -> int:
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("Threads:"))


@pytest.fixture
def sweep(tmp_path):
    """A sweep of twelve edits, one of which fails."""
    scripted().save(tmp_path / "scene.toml")
    (tmp_path / "sweep.toml").write_text(
        "format = 1\nscene = 'scene.toml'\n"
        "[[axis]]\npath = 'body.0.material.params.young'\nlist = ['5 kPa', '10 kPa', '20 kPa', '1e20 kPa']\n"
        "[[axis]]\npath = 'tool.0.radius'\nlist = ['8 mm', '10 mm', '12 mm']\n"
        "[keep]\nsummary = ['largest_force', 'steps', 'contact_steps']\ntrace = ['finger.force_z_N']\ntrace-every = 20\n"
    )
    return tmp_path / "sweep.toml"


def test_a_sweep_is_a_table_of_arrays(sweep, tmp_path):
    assert pliant.batch.size(sweep) == 12
    seen = []
    table = pliant.batch.run(sweep, tmp_path / "out", progress=lambda *counts: seen.append(counts))
    assert (table.rows, table.edits, table.failed, table.missing) == (12, 12, 3, {})
    assert seen[-1] == (12, 3, 12)
    assert table.units["largest_force"] == "N" and table.units["young"] == "kPa"
    ok = table["status"] == "done"
    assert ok.tolist() == [True] * 9 + [False] * 3 and table["steps"].dtype == np.float64
    assert np.isnan(table["largest_force"][~ok]).all() and (table["largest_force"][ok] > 0).all()
    assert table["finger.force_z"][0].shape == (4,)
    one = pliant.run(tmp_path / "scene.toml", set={YOUNG: "10 kPa", "tool.0.radius": "8 mm"}, threads=1)
    assert table["largest_force"][3] == one.summary["largest_force"]
    # What is there is not done again, and shards give the same table.
    assert pliant.batch.run_shard(sweep, tmp_path / "out")["new"] == 0
    for shard in ("1/3", "2/3", "3/3"):
        pliant.batch.run_shard(sweep, tmp_path / "shards", shard, isolate=shard == "2/3")
    files = [tmp_path / "one.csv", tmp_path / "shards.csv"]
    for file, folder in zip(files, ("out", "shards"), strict=True):
        pliant.batch.collect(tmp_path / folder, output=file)
    assert files[0].read_bytes() == files[1].read_bytes()


def test_an_exception_of_the_progress_ends_the_run_and_rows_stay(sweep, tmp_path):
    def stop(done: int, failed: int, edits: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        pliant.batch.run(sweep, tmp_path / "out", progress=stop)
    assert pliant.batch.run(sweep, tmp_path / "out").rows == 12


def test_what_is_wrong_with_a_sweep_is_told(sweep, tmp_path):
    with pytest.raises(pliant.PliantError) as raised:
        pliant.batch.run_shard(sweep, tmp_path / "out", "4/3")
    assert raised.value.kind == "argument" and "I from 1 to N" in str(raised.value)
    sweep.write_text(sweep.read_text().replace("list = ['8 mm'", "list = [8 mm"))
    with pytest.raises(pliant.PliantError) as raised:
        pliant.batch.size(sweep)
    assert raised.value.kind == "scene" and raised.value.where.endswith("sweep.toml:8:10") or ":8:" in raised.value.where


def test_a_cluster_of_dask_gives_the_table_of_one_process(sweep, tmp_path):
    distributed = pytest.importorskip("distributed")
    alone = pliant.batch.run(sweep, tmp_path / "alone")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            table = pliant.batch.map(client, sweep, tmp_path / "cluster", shards=5)
            assert len(list((tmp_path / "cluster").glob("*.journal"))) == 5
            # Begun with five shards, it goes on with five, and nothing is done again.
            stamps = {path: path.stat().st_size for path in (tmp_path / "cluster").glob("*.rows")}
            again = pliant.batch.map(client, sweep, tmp_path / "cluster")
            assert {path: path.stat().st_size for path in (tmp_path / "cluster").glob("*.rows")} == stamps
    for name in alone:
        for other in (table, again):
            assert repr(alone[name].tolist()) == repr(other[name].tolist()), name
