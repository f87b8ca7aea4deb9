"""A material of which only the energy is written: JAX makes its stress and its stiffness (needs `pip install jax`).

The law is that of `python_material.py`, whose stress is written by hand, so both can be compared. Tissue does not come this way into a product: it is for
finding out whether an idea is right.
"""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from python_material import cofactors, press, stiffening

import pliant

Array = NDArray[np.float64]

# The engine computes in double precision, and differences of stresses need it.
jax.config.update("jax_enable_x64", True)
# Lame constants and the coefficient of the squared distortion, Pa.
SHEAR, LAME, COEFFICIENT = 7e3, 28e3, 200e3
# Elements of a call of compiled code.
BLOCK = 256


def density_of_energy(F: jax.Array) -> jax.Array:
    """J/m^3, the energy of one element with a deformation gradient F (3 x 3)."""
    change = jnp.linalg.det(F) - 1.0
    distortion = jnp.sum(F * F) - 3.0 - 2.0 * change
    return SHEAR / 2 * distortion + COEFFICIENT * distortion**2 + (LAME + SHEAR) / 2 * change**2


def compiled(function: Callable[[jax.Array], jax.Array]) -> Callable[[Array], Array]:
    """A function of one deformation gradient (3 x 3) as one of many (n x 3 x 3), compiled."""
    batched = jax.jit(jax.vmap(function))

    def call(F: Array) -> Array:
        # Blocks of one size are compiled once, and what an element gets does not depend on how many others there are.
        count = -(-len(F) // BLOCK) * BLOCK
        padded = np.concatenate([F, np.broadcast_to(np.eye(3), (count - len(F), 3, 3))])
        return np.concatenate([batched(block) for block in padded.reshape(-1, BLOCK, 3, 3)])[: len(F)]

    return call


def stress_by_hand(F: Array) -> Array:
    """Pa (n x 3 x 3), the derivative of the energy as one writes it."""
    change = np.linalg.det(F) - 1.0
    along = SHEAR + 4 * COEFFICIENT * ((F * F).sum((1, 2)) - 3.0 - 2.0 * change)
    return along[:, None, None] * F + ((LAME + SHEAR) * change - along)[:, None, None] * cofactors(F)


def main() -> tuple[list[pliant.Case], float, dict[str, list[float]]]:
    """Check the law; give the cases of the suite, the largest difference to the stress by hand over its size, and forces (N) of a press by law."""
    stress, stiffness = compiled(jax.grad(density_of_energy)), compiled(jax.hessian(density_of_energy))
    law = pliant.Hyperelastic(compiled(density_of_energy), stress, stiffness, density=1000)
    cases = pliant.check(law)
    F = np.eye(3) + np.random.default_rng(1).uniform(-0.3, 0.3, (1000, 3, 3))
    exact = stress_by_hand(F)
    difference = float(np.abs(stress(F) - exact).max() / np.abs(exact).max())
    depths = [0.003, 0.012]
    forces = {"differentiated": press(law, depths), "by hand": press(stiffening(SHEAR, LAME, COEFFICIENT), depths)}
    for case in cases:
        if case.verdict != "skipped":
            print(f"{case.verdict:8} {case.name} {case.reason}")
    print(f"stresses differ by {difference:.1e}; forces {forces}")
    return cases, difference, forces


if __name__ == "__main__":
    main()
