"""A material written in Python: soft tissue that stiffens with strain.

The energy density is a polynomial of the distortion I1 - 2 J - 1, as Yeoh (1990) has one of the first invariant, and of the change of volume. It
passes the conformance suite; a finger then presses a block of it, and a block of the built-in material with the same stiffness at small strains.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import pliant

Array = NDArray[np.float64]


def cofactors(F: Array) -> Array:
    """The derivative of det F by F (n x 3 x 3)."""
    return np.stack([np.cross(F[:, 1], F[:, 2]), np.cross(F[:, 2], F[:, 0]), np.cross(F[:, 0], F[:, 1])], axis=1)


def stiffening(shear: float, lame: float, coefficient: float, density: float = 1000.0) -> pliant.Hyperelastic:
    """A law with given Lame constants (Pa) at small strains, and a coefficient (Pa) of the squared distortion."""

    def parts(F: Array) -> tuple[Array, Array]:
        """The distortion, of second order in the strain, and the change of volume."""
        # Sums of few terms, written out: they do not depend on which elements come in one call.
        squares = F * F
        rows = squares[:, :, 0] + squares[:, :, 1] + squares[:, :, 2]
        products = F[:, 0] * np.cross(F[:, 1], F[:, 2])
        change = products[:, 0] + products[:, 1] + products[:, 2] - 1
        return rows[:, 0] + rows[:, 1] + rows[:, 2] - 3 - 2 * change, change

    def energy(F: Array) -> Array:
        distortion, change = parts(F)
        return shear / 2 * distortion + coefficient * distortion**2 + (lame + shear) / 2 * change**2

    def stress(F: Array) -> Array:
        distortion, change = parts(F)
        along = shear + 4 * coefficient * distortion
        across = (lame + shear) * change - along
        return along[:, None, None] * F + across[:, None, None] * cofactors(F)

    return pliant.Hyperelastic(energy, stress, density=density)


def press(material: pliant.Hyperelastic | pliant.Material, depths: list[float]) -> list[float]:
    """Forces (N) of a finger at rest at some depths (m) in a block of a material."""
    scene = pliant.Scene()
    scene.time(dt="2 ms", duration=1)
    fixed = [{"box": [[-1, -1, -0.051], [1, 1, -0.049]]}]
    shape = {"kind": "box", "size": [0.1, 0.1, 0.1], "cells": 8}
    scene.body("block", shape=shape, material=material, grid={"level": 3}, fixed=fixed)
    scene.hand("hand", peak_force=50, stiffness=5000)
    scene.tool("finger", radius="15 mm", stiffness="2 N/mm")
    scene.edit("touch", tool="finger")
    forces = []
    with pliant.Session(scene) as session:
        hand, height = session.hand("finger"), 0.066
        for depth in depths:
            for height in np.linspace(height, 0.065 - depth, 20):
                hand.go([0, 0, height])
                session.step()
            session.step(40)
            forces.append(float(session.force("finger")[2]))
    return forces


def main() -> tuple[list[pliant.Case], dict[str, list[float]]]:
    """Check the law and press blocks; give the cases of the suite and the forces (N) by material."""
    shear, lame = 7e3, 28e3
    law = stiffening(shear, lame, coefficient=200e3)
    cases = pliant.check(law)
    for case in cases:
        if case.verdict != "skipped":
            print(f"{case.verdict:8} {case.name} {case.reason}")
    young, poisson = shear * (3 * lame + 2 * shear) / (lame + shear), lame / (2 * (lame + shear))
    depths = [0.003, 0.012]
    forces = {
        "built in": press(pliant.Material("neo-hookean", young=young, poisson=poisson, density=1000), depths),
        "stiffening": press(law, depths),
    }
    for name, pair in forces.items():
        print(f"{name:12} {pair[0]:.3f} N at {1e3 * depths[0]:g} mm, {pair[1]:.3f} N at {1e3 * depths[1]:g} mm")
    return cases, forces


if __name__ == "__main__":
    main()
