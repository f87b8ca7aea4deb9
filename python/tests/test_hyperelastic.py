"""Materials written in Python: they are what their plugins would be, and say what is wrong with them."""

import signal
import threading
import time

import numpy as np
import pytest
from conftest import block

import pliant


def linear_strain_energy(shear: float, lame: float, scale: float = 1.0):
    """Energy and stress of Saint Venant and Kirchhoff; `scale` makes the stress wrong by a factor."""

    def strain(F):
        columns = [F[:, :, i] for i in range(3)]
        E = np.empty_like(F)
        for i in range(3):
            for j in range(3):
                products = columns[i] * columns[j]
                E[:, i, j] = 0.5 * (products[:, 0] + products[:, 1] + products[:, 2] - (i == j))
        return E, E[:, 0, 0] + E[:, 1, 1] + E[:, 2, 2]

    def energy(F):
        E, trace = strain(F)
        return shear * (E * E).sum((1, 2)) + 0.5 * lame * trace**2

    def stress(F):
        E, trace = strain(F)
        return scale * F @ (2 * shear * E + lame * trace[:, None, None] * np.eye(3))

    return energy, stress


def pressed(material, integrator: str | None = None) -> pliant.Scene:
    vertices, faces = block(4)
    scene = pliant.Scene()
    scene.time(dt="1 ms", duration=0.1, **({} if integrator is None else {"integrator": integrator}))
    fixed = [{"box": [[-1, -1, -0.051], [1, 1, -0.049]]}]
    scene.body("cube", mesh=vertices, faces=faces, material=material, grid={"level": 2}, fixed=fixed)
    scene.hand("hand")
    scene.tool("finger", radius="20 mm", stiffness="300 N/m")
    scene.edit("touch", tool="finger")
    return scene


def push(session: pliant.Session, steps: int = 40) -> float:
    hand = session.hand("finger")
    for height in np.linspace(0.072, 0.062, steps):
        hand.go([0, 0, height])
        session.step()
    return float(session.force("finger")[2])


@pytest.mark.parametrize("seed", range(3))
def test_laws_with_a_right_stress_conform(seed):
    rng = np.random.default_rng(seed)
    shear, lame = 10 ** rng.uniform(2, 6, 2)
    law = pliant.Hyperelastic(*linear_strain_energy(shear, lame), damping_time=float(10 ** rng.uniform(-5, -2)))
    cases = {case.name: case for case in pliant.check(law)}
    failed = {name: case.reason for name, case in cases.items() if case.verdict == "failed"}
    assert failed == {}
    for name in ("force-is-energy-gradient", "stiffness-is-force-gradient", "rotation-invariance", "damping-dissipates"):
        assert cases[name].verdict == "passed"


def test_laws_that_are_wrong_fail_the_case_of_what_is_wrong():
    def failed(law):
        return {case.name for case in pliant.check(law) if case.verdict == "failed"}

    energy, stress = linear_strain_energy(5e3, 2e4)
    assert "force-is-energy-gradient" in failed(pliant.Hyperelastic(energy, linear_strain_energy(5e3, 2e4, 1.01)[1]))

    def soft(F):
        exact = np.zeros((len(F), 3, 3, 3, 3))
        for i in range(3):
            for j in range(3):
                exact[:, i, j, i, j] = 100.0
        return exact

    assert "stiffness-is-force-gradient" in failed(pliant.Hyperelastic(energy, stress, soft))
    # One that sees where the axes are: its energy changes with a rotation.
    turned = failed(pliant.Hyperelastic(lambda F: 1e4 * (F[:, 0, 0] - 1) ** 2, lambda F: 2e4 * (F - np.eye(3)) * np.eye(3)[0] * np.eye(3)[0][:, None]))
    assert "rotation-invariance" in turned

    def raises(F):
        raise ZeroDivisionError("no such energy")

    reasons = [case.reason for case in pliant.check(pliant.Hyperelastic(raises, stress)) if case.verdict == "failed"]
    assert any("no such energy" in reason for reason in reasons)


def test_a_given_stiffness_and_differences_of_the_stress_agree():
    energy, stress = linear_strain_energy(5e3, 2e4)

    def stiffness(F):
        identity, count = np.eye(3), len(F)
        E = 0.5 * (np.swapaxes(F, 1, 2) @ F - identity)
        S = 2 * 5e3 * E + 2e4 * np.trace(E, axis1=1, axis2=2)[:, None, None] * identity
        out = np.einsum("ik,njl->nijkl", identity, S)
        out += 5e3 * (np.einsum("nil,nkj->nijkl", F, F) + np.einsum("nim,nkm,jl->nijkl", F, F, identity))
        return out + 2e4 * np.einsum("nij,nkl->nijkl", F, F).reshape(count, 3, 3, 3, 3)

    exact, differences = pliant.Hyperelastic(energy, stress, stiffness), pliant.Hyperelastic(energy, stress)
    assert [case.name for case in pliant.check(exact) if case.verdict == "failed"] == []
    forces = []
    for law in (exact, differences):
        with pliant.Session(pressed(law)) as session:
            forces.append(push(session))
    # The same equilibrium in every step, to the tolerance of the solver.
    assert forces[0] > 0.05 and forces[1] == pytest.approx(forces[0], rel=1e-4)


def test_small_strains_follow_hookes_law_as_the_built_in_material_does():
    shear, lame = 8e3, 20e3
    young, poisson = shear * (3 * lame + 2 * shear) / (lame + shear), lame / (2 * (lame + shear))
    law = pliant.Hyperelastic(*linear_strain_energy(shear, lame))
    built_in = pliant.Material("neo-hookean", young=young, poisson=poisson, density=1000, damping_time=2e-4)
    forces = []
    for material in (law, built_in):
        scene = pressed(material)
        scene._dict()["tool"][0]["stiffness"] = "20 N/m"
        with pliant.Session(scene) as session:
            forces.append(push(session))
    # A soft spring: strains are a few thousandths, where laws of one stiffness differ by as much.
    assert forces[0] > 0.05 and forces[0] == pytest.approx(forces[1], rel=0.02)


def test_results_do_not_depend_on_threads_and_a_session_outlives_its_law():
    places = []
    for threads in (1, 2):
        scene = pressed(pliant.Hyperelastic(*linear_strain_energy(5e3, 2e4)))
        with pliant.Session(scene, threads=threads) as session:
            del scene
            push(session, 20)
            places.append(np.array(session.positions("cube")))
    assert np.array_equal(places[0], places[1])


def test_an_exception_of_a_law_is_raised_with_its_cause_and_freezes_the_body():
    energy, stress = linear_strain_energy(5e3, 2e4)
    is_broken = threading.Event()

    def breaks(F):
        if is_broken.is_set():
            raise OverflowError("too much")
        return stress(F)

    with pliant.Session(pressed(pliant.Hyperelastic(energy, breaks))) as session:
        push(session)
        is_broken.set()
        with pytest.raises(pliant.PliantError, match="OverflowError: too much") as raised:
            session.step(3)
        assert raised.value.kind == "plugin" and isinstance(raised.value.__cause__, OverflowError)
        assert session.events()["counts"], "the body stands still, and the session says so"
        session.step(3)


@pytest.mark.parametrize(
    ("stress", "said"),
    [(lambda F: F[:1], "shape"), (lambda F: np.full(F.shape, np.nan), "nan|NaN"), (lambda F: "text", "convert")],
)
def test_values_that_make_no_sense_are_told(stress, said):
    law = pliant.Hyperelastic(lambda F: np.zeros(len(F)), stress)
    failed = [case.reason for case in pliant.check(law) if case.verdict == "failed"]
    assert failed
    with pytest.raises(pliant.PliantError, match=said), pliant.Session(pressed(law)) as session:
        push(session)
        raise pliant.PliantError(str(session.events()))


def test_ctrl_c_inside_of_a_law_ends_the_steps_and_the_session_goes_on():
    energy, stress = linear_strain_energy(5e3, 2e4)

    def slow(F):
        time.sleep(0.002)
        return stress(F)

    with pliant.Session(pressed(pliant.Hyperelastic(energy, slow)), threads=1) as session:
        session.hand("finger").go([0, 0, 0.065])
        session.step(2)
        timer = threading.Timer(0.2, signal.raise_signal, [signal.SIGINT])
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            session.step(100_000)
        timer.join()
        taken = session.steps
        session.step()
        assert session.steps == taken + 1


def test_scenes_with_a_law_run_and_are_not_saved(tmp_path):
    scene = pressed(pliant.Hyperelastic(*linear_strain_energy(5e3, 2e4)))
    scene._dict()["device"][0]["params"]["path"] = [[0, 0, 0, 0.07], [0.1, 0, 0, 0.062]]
    scene._driven.clear()
    result = pliant.run(scene)
    assert np.linalg.norm(result.tools["finger"].force, axis=1).max() > 0.05
    with pytest.raises(pliant.PliantError, match="cannot be saved"):
        scene.save(tmp_path / "scene.toml")


def test_a_law_that_is_gone_is_told():
    data = pressed(pliant.Hyperelastic(*linear_strain_energy(5e3, 2e4))).to_dict()
    data["body"][0].pop("mesh")
    data["body"][0]["shape"] = {"kind": "box", "size": [0.1, 0.1, 0.1], "cells": 4}
    with pytest.raises(pliant.PliantError, match="no such law"):
        pliant.Session(data)
