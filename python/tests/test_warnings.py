"""Warnings of the engine reach Python with their codes."""

import pickle
import warnings

import numpy as np
import pytest
from conftest import pressed

import pliant


def overlapping(distance: float) -> pliant.Scene:
    scene = pliant.Scene()
    scene.time(dt="1 ms", duration=0.003)
    for name, x in (("left", 0.0), ("right", distance)):
        shape = {"kind": "box", "size": [0.1, 0.1, 0.1], "cells": 3}
        scene.body(name, shape=shape, position=[x, 0, 0], grid={"level": 2}, material="mass-spring")
    return scene


def caught(work) -> dict[str, pliant.PliantWarning]:
    """What `work` warns of, by code."""
    with warnings.catch_warnings(record=True) as all_of_them:
        warnings.simplefilter("always")
        work()
    ours = [told for told in all_of_them if issubclass(told.category, pliant.PliantWarning)]
    assert all(told.filename == __file__ for told in ours), "they point to the caller"
    return {told.message.code: told.message for told in ours}


@pytest.mark.parametrize("distance", [0.05, 0.5])
def test_a_run_warns_and_its_summary_has_the_same(distance):
    results = []
    told = caught(lambda: results.append(pliant.run(overlapping(distance))))
    listed = results[0].summary["warnings"]
    assert [row["code"] for row in listed] == list(told)
    assert ("bodies-overlap" in told) == (distance < 0.1)
    for row in listed:
        warning = told[row["code"]]
        assert (warning.where, warning.args[0]) == (row["where"], row["message"])
        assert f"[{row['code']}]" in str(warning)


def test_a_session_warns_when_it_is_opened_and_when_it_is_closed():
    sessions = []
    assert "bodies-overlap" in caught(lambda: sessions.append(pliant.Session(overlapping(0.05))))
    assert [warning.code for warning in sessions[0].warnings()] == ["bodies-overlap"]
    assert caught(sessions[0].close) == {}, "not told twice"

    def touch(height: float) -> None:
        with pliant.Session(pressed()) as session:
            hand = session.hand("finger")
            for z in np.linspace(0.07, height, 100):
                hand.go([0, 0, z])
                session.step()

    assert "no-force" in caught(lambda: touch(0.065)), "the hand came near and touched nothing"
    assert "no-force" not in caught(lambda: touch(0.055))


def test_a_warning_can_be_an_error_or_silent_and_goes_to_other_processes():
    with warnings.catch_warnings():
        warnings.simplefilter("error", pliant.PliantWarning)
        with pytest.raises(pliant.PliantWarning) as raised:
            pliant.run(overlapping(0.05))
        assert raised.value.code == "bodies-overlap"
        warnings.simplefilter("ignore", pliant.PliantWarning)
        pliant.run(overlapping(0.05))
    again = pickle.loads(pickle.dumps(raised.value))
    assert (str(again), again.code, again.where) == (str(raised.value), raised.value.code, raised.value.where)
