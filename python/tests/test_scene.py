"""Scenes: files, dicts, arrays, and what is wrong with them."""

import subprocess
import sys

import numpy as np
import pytest
from conftest import block, pressed

import pliant


def test_the_same_scene_from_a_file_a_dict_and_text(scenes):
    path = scenes / "touch.toml"
    shortened = {"time.duration": 0.15}
    file = pliant.run(path, set=shortened)
    data = pliant.Scene(path).to_dict()
    for scene in (pliant.Scene(data, folder=scenes), pliant.Scene.from_toml(path.read_text(), folder=scenes)):
        again = pliant.run(scene, set=shortened)
        assert np.array_equal(file.tools["finger"].force, again.tools["finger"].force)


def test_a_file_stays_as_it_is(scenes):
    path = scenes / "touch.toml"
    assert pliant.Scene(path).to_toml() == path.read_text()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"body": [{"materiel": 1}]}, ["unknown field `materiel`", "expected one of", "material"]),
        ({"time": {"dt": "1 mm"}}, ["1 mm"]),
        ({"gravitas": [0, 0, 1]}, ["unknown field `gravitas`"]),
        ({"body": [{"mesh": "a.obj", "material": {"plugin": "cloth"}}], "edit": [{"kind": "hug"}]}, ["hug", "touch"]),
    ],
)
def test_what_a_scene_cannot_say_is_said_in_the_words_of_the_program(change, words):
    scene = pliant.Scene({"format": 1, **change})
    with pytest.raises(pliant.PliantError) as caught:
        scene.check()
    assert caught.value.kind == "scene"
    assert all(word in str(caught.value) for word in words), caught.value
    assert caught.value.where and ":" in caught.value.where


def test_a_parameter_out_of_range_names_its_line(scenes):
    with pytest.raises(pliant.PliantError) as caught:
        pliant.Session(scenes / "touch.toml", set={"body.0.material.params.young": "-3 kPa"})
    assert caught.value.kind == "scene" and "young" in str(caught.value)
    assert "touch.toml:" in caught.value.where


def test_a_missing_plugin_names_the_folders_and_the_argument(tmp_path):
    scene = pressed()
    with pytest.raises(pliant.PliantError) as caught:
        pliant.Session(scene, set={"body.0.material.plugin": "nothing-such"}, plugin_path=[tmp_path])
    text = str(caught.value)
    assert caught.value.kind == "plugin"
    assert f"{tmp_path} (plugin_path)" in text and "(inside the package)" in text and "--plugin-path" not in text


def test_a_scene_of_arrays_saved_and_read_is_the_same(tmp_path):
    vertices, faces = block()
    scene = pliant.Scene()
    scene.time(duration=0.1, dt=0.001)
    material = pliant.Material("neo-hookean", young=20e3, density=1000)
    scene.body("cube", mesh=vertices, faces=faces, material=material, grid={"level": 3, "region": "whole"})
    scene.gravity(0, -9.81, 0)
    scene.save(tmp_path / "cube.toml")
    one, other = pliant.run(scene), pliant.run(tmp_path / "cube.toml")
    assert np.array_equal(one.meshes["cube"].vertices, other.meshes["cube"].vertices)
    fallen = vertices[:, 1].mean() - one.meshes["cube"].vertices[:, 1].mean()
    # Free fall: all points by g t^2 / 2, up to the first order of the step.
    assert fallen == pytest.approx(0.5 * 9.81 * 0.1**2, rel=0.02)


def test_arrays_come_back_as_they_were_given():
    vertices, faces = block(3)
    vertices = vertices + np.random.default_rng(1).normal(size=vertices.shape) * 1e-4
    scene = pliant.Scene()
    scene.body("cube", mesh=vertices, faces=faces.tolist(), material="mass-spring")
    with pliant.Session(scene) as session:
        assert np.array_equal(session.rest_positions(), vertices)
        assert np.array_equal(session.positions(), vertices)
        triangles = session.triangles()
        assert len(triangles) == 2 * len(faces)
        assert np.array_equal(np.bincount(session.mesh().face_of), np.full(len(faces), 2))
        sides = vertices[triangles]
        cross = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
        assert (np.einsum("ij,ij->i", sides.mean(axis=1), cross) > 0).all(), "turned outwards"


def bar_with(fields, field=(), plugin="neo-hookean"):
    """A cube of arrays whose left and right sides are led apart, with fields."""
    vertices, faces = block()
    scene = pliant.Scene()
    scene.time(duration=0.01, dt=0.001)
    led = [
        {"box": [[-1, -1, -1], [-0.049, 1, 1]], "path": [[0, 0, 0, 0], [0.01, -1e-3, 0, 0]]},
        {"box": [[0.049, -1, -1], [1, 1, 1]], "path": [[0, 0, 0, 0], [0.01, 1e-3, 0, 0]]},
    ]
    scene.body("cube", mesh=vertices, faces=faces, material=pliant.Material(plugin, young=20e3), grid={"level": 4, "region": "whole"},
        fixed=led, fields=fields, field=list(field))
    scene.probe("energy", "elastic-energy")
    return scene


@pytest.mark.parametrize("plugin", ["mass-spring", "neo-hookean", "corotational"])
@pytest.mark.parametrize("factor", [0.1, 0.3, 2.5, 10.0])
def test_a_uniform_field_of_arrays_is_the_parameter_times_its_factor(plugin, factor):
    count = len(block()[0])
    field = pliant.run(bar_with({"young": np.full(count, factor)}, plugin=plugin), set={"body.0.material.params.young": 20e3 / factor})
    plain = pliant.run(bar_with({}, plugin=plugin))
    energies = [result.probes["energy"].value for result in (field, plain)]
    assert energies[0] > 0 and energies[0] == pytest.approx(energies[1], rel=1e-9)


@pytest.mark.parametrize("keys", [{}, {"weld": True}])
def test_a_mesh_in_pieces_saved_and_read_is_the_same(tmp_path, keys):
    vertices, faces = block()
    corners = np.asarray([vertices[corner] for face in faces for corner in face])
    ends = np.cumsum([len(face) for face in faces])
    apart = [list(range(end - len(face), end)) for face, end in zip(faces, ends, strict=True)]
    scene = pliant.Scene()
    scene.time(duration=0.02, dt=0.001)
    scene.body("cube", mesh=corners, faces=apart, material="neo-hookean", grid={"level": 3}, **keys)
    scene.hand("hand", path=[[0, 0, 0, 0.1], [0.02, 0, 0, 0.1]])
    scene.tool("tool", hand="hand", radius=0.005)
    scene.edit("touch", tool="tool")
    scene.save(tmp_path / "cube.toml")
    with pliant.Session(scene) as session, pliant.Session(tmp_path / "cube.toml") as read:
        assert len(np.unique(session.mesh("cube").triangles)) == (len(vertices) if keys else len(corners))
        assert np.array_equal(session.mesh("cube").triangles, read.mesh("cube").triangles)


@pytest.mark.parametrize("seed", range(4))
def test_fields_of_arrays_saved_and_read_are_the_same(tmp_path, seed):
    vertices, _ = block()
    random = np.random.default_rng(seed)
    fields = {"young": 10.0 ** random.uniform(-1, 1, len(vertices)), "density": (0.5 + 4 * (vertices[:, 0] > 0)).tolist()}
    scene = bar_with(fields, [{"param": "young", "ball": [0, 0, 0], "radius": "3 cm", "factor": 2.0}])
    scene.save(tmp_path / "cube.toml")
    assert {file.name for file in tmp_path.iterdir()} == {"cube.toml", "cube.obj", "cube-young.csv", "cube-density.csv"}
    one, other, plain = pliant.run(scene), pliant.run(tmp_path / "cube.toml"), pliant.run(bar_with({}))
    assert np.array_equal(one.meshes["cube"].vertices, other.meshes["cube"].vertices)
    assert np.abs(one.meshes["cube"].vertices - plain.meshes["cube"].vertices).max() > 1e-6, "the field has an effect"


def test_the_softer_half_of_a_block_gives_way():
    vertices, _ = block()
    result = pliant.run(bar_with({"young": np.where(vertices[:, 0] < 0, 0.2, 5.0)}))
    strained = result.meshes["cube"].vertices[:, 0] - vertices[:, 0]
    middle = np.abs(vertices[:, 0]) < 1e-9
    assert strained[middle].mean() > 2e-4, "the middle goes to the stiff side"


@pytest.mark.parametrize(
    ("fields", "kind", "words"),
    [
        ({"young": [1.0, 2.0]}, "argument", ["`young`", "(2,)", "(218,)"]),
        ({"young": 2.0}, "argument", ["`young`", "()", "(218,)"]),
        ({"young": np.ones((218, 1))}, "argument", ["(218, 1)"]),
        ({"young": ["stiff"] * 218}, "argument", ["`young`", "stiff"]),
        ({"young": np.where(np.arange(218) == 7, np.nan, 1.0)}, "scene", ["cube-young.csv", "vertex 7", "NaN", "0.1 to 10"]),
        ({"young": np.where(np.arange(218) == 9, 10.5, 1.0)}, "scene", ["vertex 9", "10.5"]),
        ({"poisson": np.ones(218)}, "scene", ["`poisson`", "young, density"]),
    ],
)
def test_fields_that_are_none_are_refused(fields, kind, words):
    with pytest.raises(pliant.PliantError) as caught:
        pliant.Session(bar_with(fields))
    assert caught.value.kind == kind and all(word in str(caught.value) for word in words), caught.value


def test_a_field_for_another_model_counts_its_vertices(scenes):
    with pytest.raises(pliant.PliantError, match="218 factors; expected one per vertex"):
        pliant.Session(bar_with({"young": np.ones(218)}), mesh=scenes / "elephant.obj")


@pytest.mark.parametrize(
    ("mesh", "faces", "words"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]], "allowed is 0 to 2"),
        ([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]], "vertex 1"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], "(n x 3)"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], None, "faces"),
        ([0, 1, 2], [[0, 1, 2]], "(n x 3)"),
    ],
)
def test_meshes_that_are_none_are_refused(mesh, faces, words):
    with pytest.raises(pliant.PliantError) as caught:
        pliant.Scene().body("odd", mesh=mesh, faces=faces)
    assert caught.value.kind == "argument" and words in str(caught.value) and "odd" in str(caught.value)


def test_settings_take_numbers_texts_lists_and_arrays(scenes):
    settings = {"gravity": np.array([0.0, -1.0, 0.0]), "time.duration": np.float64(0.002), "title": "3"}
    result = pliant.run(scenes / "touch.toml", set=settings)
    assert len(result.trace.time) == 2 and result.summary["settings"]["title"] == "3"


def test_a_scene_is_as_good_as_its_dict():
    scene = pressed()
    again = pliant.Scene(scene.to_dict())
    with pytest.raises(pliant.PliantError, match=r"cube\.obj"):
        pliant.Session(again)
    assert again.to_dict() == scene.to_dict()


def test_the_catalogue_lists_what_there_is():
    ids = {plugin.id for plugin in pliant.plugins()}
    assert {"mass-spring", "neo-hookean", "corotational", "cloth", "octree-grid", "scripted"} <= ids
    assert all(plugin.kind != "unusable" for plugin in pliant.plugins())
    young = next(p for p in pliant.plugins("material") if p.id == "mass-spring").param("young")
    assert young.unit == "Pa" and young.range[0] > 0
    fabrics = pliant.Fabric.presets()
    assert "denim" in fabrics and any(fabrics.values())
    assert "touch" in pliant.edit_kinds() and "force" in pliant.quantities()


def test_presets_are_materials_that_can_be_opened():
    presets = pliant.Material.presets()
    assert list(presets) and all(p.young > 0 and p.source for p in presets.values())
    for plugin in ("mass-spring", "neo-hookean"):
        material = pliant.Material.preset("flesh", plugin)
        assert material.params["young"] == presets["flesh"].young
        assert ("poisson" in material.params) == (plugin == "neo-hookean")
        scene = pliant.Scene()
        scene.body(shape={"kind": "box", "size": [0.1, 0.1, 0.1]}, material=material, grid={"region": "whole", "level": 3})
        scene.gravity(0, 0, -1)
        with pliant.Session(scene) as session:
            session.step(3)
    with pytest.raises(pliant.PliantError, match="flesh"):
        pliant.Material.preset("granite")


def test_a_fabric_makes_a_sheet():
    scene = pliant.Scene()
    scene.time(duration=0.02, integrator="backward-euler")
    scene.gravity(0, 0, -9.81)
    shape = {"kind": "sheet", "cells": 8, "size": [0.1, 0.1, 0]}
    scene.body("cloth", shape=shape, material=pliant.Fabric("denim"), fixed=[{"nodes": [0, 8]}])
    result = pliant.run(scene)
    assert "level" not in result.summary["bodies"][0]
    assert result.meshes["cloth"].vertices[:, 2].min() < -1e-4


def test_plugins_are_found_wherever_the_program_is(tmp_path):
    code = "import pliant; print(sorted({p.path.rsplit('/', 2)[0].rsplit('/', 1)[1] for p in pliant.plugins()}))"
    output = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert output.stdout.strip() == "['pliant']"


def test_an_obstacle_of_arrays_carries_a_block():
    vertices, faces = block()
    low = vertices[:, 2].min()
    scene = pliant.Scene()
    scene.gravity(0, 0, -9.81)
    scene.time(dt=1e-3, integrator="backward-euler", duration=0.3)
    scene.body("block", mesh=vertices, faces=faces, material=pliant.Material("neo-hookean", young="50 kPa", damping_time=0.01),
               grid={"level": 3, "region": "whole"})
    plate = np.array([[-1.0, -1, low - 1e-4], [1, -1, low - 1e-4], [1, 1, low - 1e-4], [-1, 1, low - 1e-4]])
    with pytest.raises(pliant.PliantError, match="obstacle `plate`: vertices without `faces`"):
        scene.obstacle("plate", mesh=plate)
    scene.obstacle("plate", mesh=plate, faces=[[0, 1, 2, 3]], thickness=1e-5, friction=[0.5, 0.4])
    scene.probe("carried", "obstacle-force", of="plate")
    result = pliant.run(scene)
    assert result.meshes["block"].vertices[:, 2].min() > low - 1e-4, "it did not fall through"
    assert result.probes["carried"].value > 0
    without = pliant.Scene(scene.to_dict())
    without._meshes = scene._meshes
    data = without.to_dict()
    del data["obstacle"], data["probe"]
    fallen = pliant.Scene(data)
    fallen._meshes = scene._meshes
    assert pliant.run(fallen).meshes["block"].vertices[:, 2].min() < low - 0.3, "without it, it falls"


def test_a_tool_of_another_shape_has_no_radius_and_presses():
    vertices, faces = block()
    scene = pliant.Scene()
    scene.time(duration=0.1, dt="1 ms")
    table = {"box": [[-1, -1, -0.051], [1, 1, -0.049]]}
    scene.body("cube", mesh=vertices, faces=faces, material="mass-spring", grid={"level": 4}, fixed=[table])
    scene.hand("hand", path=[[0.0, 0.0, 0.0, 0.056], [0.1, 0.0, 0.0, 0.048]])
    scene.tool("plate", shape={"kind": "box", "size": ["20 mm", "20 mm", "10 mm"]}, stiffness="300 N/m")
    scene.edit("touch", tool="plate")
    result = pliant.run(scene)
    assert result.tools["plate"].force[-1, 2] > 0.0


def test_a_device_repeats_a_recording_without_a_plugin():
    scene = pliant.Scene()
    scene.device("hand", recording="hand.rec")
    assert scene.to_dict()["device"] == [{"name": "hand", "recording": "hand.rec"}]
    assert "plugin" not in scene.to_toml()
