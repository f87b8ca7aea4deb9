"""Runs: what Python gives is what the program writes."""

import csv
import json
import warnings

import numpy as np
import pytest

import pliant


def test_a_run_gives_what_its_files_say(scenes, tmp_path):
    result = pliant.run(scenes / "touch.toml", set={"time.duration": "0.25 s"}, out=tmp_path)
    with open(tmp_path / "trace.csv") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(result.trace.time) == 250
    finger = result.tools["finger"]
    for axis, name in enumerate("xyz"):
        for array, column in ((finger.hand, "hand_{}_m"), (finger.proxy, "proxy_{}_m"), (finger.force, "force_{}_N")):
            written = np.array([float(row[f"finger.{column.format(name)}"]) for row in rows])
            assert np.array_equal(array[:, axis], written)
    assert np.array_equal(finger.depth, [float(row["finger.depth_m"]) for row in rows])
    assert np.array_equal(finger.contact >= 0, [row["finger.contact"] != "" for row in rows])
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["probes"][0]["value"] == result.probes["largest force"].value
    assert summary["largest_force"] == np.linalg.norm(finger.force, axis=1).max() > 0.05
    lines = (tmp_path / "final.obj").read_text().splitlines()
    written = np.array([[float(c) for c in line.split()[1:4]] for line in lines if line.startswith("v ")])
    mesh = result.meshes["elephant"]
    # The file has units of its own: the same up to a similarity.
    scale = np.ptp(mesh.vertices, axis=0) / np.ptp(written, axis=0)
    assert np.allclose(scale, scale[0], rtol=1e-9)


def test_nothing_is_written_without_a_folder(scenes, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pliant.run(scenes / "touch.toml", set={"time.duration": 0.01})
    assert list(tmp_path.iterdir()) == []


def test_a_run_is_repeatable_for_any_number_of_threads(scenes):
    runs = [pliant.run(scenes / "touch.toml", set={"time.duration": 0.2}, threads=n) for n in (1, 2)]
    assert np.array_equal(runs[0].tools["finger"].force, runs[1].tools["finger"].force)
    assert np.array_equal(runs[0].meshes["elephant"].vertices, runs[1].meshes["elephant"].vertices)


def test_probes_with_an_expected_value_pass_or_fail(scenes):
    settings = {"time.duration": 0.05, "probe": []}
    with pytest.raises(pliant.PliantError, match="list"):
        pliant.run(scenes / "touch.toml", set={"probe.name": "x"})
    scene = pliant.Scene(scenes / "touch.toml")
    scene.probe("impossible", "force", expected=1e3, tolerance=0.01)
    result = pliant.run(scene, set={"time.duration": settings["time.duration"]})
    assert result.probes["impossible"].passed is False and not result.passed


def test_another_model_takes_the_place_of_the_first(scenes, tmp_path):
    first = pliant.run(scenes / "touch.toml", set={"time.duration": 0.001}).meshes["elephant"]
    scene = pliant.Scene()
    scene.body("ball", shape={"kind": "sphere", "size": [1, 1, 1], "cells": 6}, material="mass-spring")
    ball = pliant.run(scene)
    path = tmp_path / "ball.obj"
    with pliant.Session(scene) as session:
        session.write(path)
    other = pliant.run(scenes / "touch.toml", set={"time.duration": 0.001}, mesh=path).meshes["elephant"]
    assert len(other.vertices) == len(ball.meshes["ball"].vertices) != len(first.vertices)
    assert np.isclose(np.ptp(other.vertices, axis=0).max(), np.ptp(first.vertices, axis=0).max())


def test_a_hand_that_nobody_moves_is_warned_of():
    scene = pliant.Scene()
    scene.body(shape={"kind": "box", "size": [0.1, 0.1, 0.1]}, material="mass-spring")
    scene.hand()
    scene.tool("finger", radius=0.01)
    scene.edit("touch", tool="finger")
    scene.time(duration=0.01)
    with pytest.warns(UserWarning, match="without a path"):
        result = pliant.run(scene)
    assert not result.tools["finger"].force.any()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", pliant.PliantWarning)  # the touch meets nothing, which is another matter
        pliant.run({**scene.to_dict()})
