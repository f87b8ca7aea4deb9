"""Materials written in Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._error import PliantError

#: Step of central differences of the stress: the cube root of the rounding of a double, where truncation and rounding meet.
_STEP = float(np.cbrt(np.finfo(np.float64).eps))


class Hyperelastic:
    """A solid material given by an energy density in Python: for trying an idea, not for speed.

    The functions get the deformation gradients of many tetrahedra at once: an array (n x 3 x 3), entry ``[e, i, j]`` the derivative of place i by
    rest place j in element e. What they give must depend on that alone, element by element. They are called on threads of the engine, one
    call at a time. When the law is right, ``pliant plugin new`` begins a plugin, which is much faster.

    Parameters
    ----------
    energy : callable
        Energy densities (n), J/m^3; zero at rest.
    stress : callable
        First Piola-Kirchhoff stresses (n x 3 x 3), Pa: the derivative of the energy density by the deformation gradient.
    stiffness : callable, optional
        Derivatives of the stress (n x 3 x 3 x 3 x 3), Pa, entry ``[i, j, k, l]`` that of ``stress[i, j]`` by ``F[k, l]``. Central differences of the
        stress are taken where it is not given, eighteen more evaluations.
    density : float or str
        kg/m^3.
    damping_time : float or str
        s, viscous over elastic stress at rest; 0 for none.

    Examples
    --------
    The energy of Saint Venant and Kirchhoff:

    >>> import numpy as np, pliant
    >>> shear, lame = 5e3, 2e4
    >>> def strain(F):
    ...     return 0.5 * (np.swapaxes(F, 1, 2) @ F - np.eye(3))
    >>> def energy(F):
    ...     E = strain(F)
    ...     return shear * (E * E).sum((1, 2)) + 0.5 * lame * np.trace(E, axis1=1, axis2=2) ** 2
    >>> def stress(F):
    ...     E = strain(F)
    ...     return F @ (2 * shear * E + lame * np.trace(E, axis1=1, axis2=2)[:, None, None] * np.eye(3))
    >>> material = pliant.Hyperelastic(energy, stress)
    >>> [case.name for case in pliant.check(material) if case.verdict == "failed"]
    []
    """

    def __init__(
        self,
        energy: Callable[[NDArray[np.float64]], ArrayLike],
        stress: Callable[[NDArray[np.float64]], ArrayLike],
        stiffness: Callable[[NDArray[np.float64]], ArrayLike] | None = None,
        *,
        density: float | str = 1000.0,
        damping_time: float | str = 2e-4,
    ) -> None:
        self.density = density
        self.damping_time = damping_time

        def energies(gradients: NDArray[np.float64]) -> NDArray[np.float64]:
            return _checked("energy", energy(gradients), gradients.shape[:1])

        def stresses(gradients: NDArray[np.float64]) -> NDArray[np.float64]:
            return _checked("stress", stress(gradients), gradients.shape)

        def stiffnesses(gradients: NDArray[np.float64], project: bool) -> NDArray[np.float64]:
            if stiffness is None:
                matrices = _differences(stresses, gradients)
            else:
                shape = (*gradients.shape, 3, 3)
                matrices = _checked("stiffness", stiffness(gradients), shape).reshape(-1, 9, 9)
            return (_positive_part(matrices) if project else matrices).reshape(-1)

        # Only functions: a method would make a cycle of this object and its law.
        self._law = _native.Law(energies, stresses, stiffnesses, _native.__file__)

    def to_dict(self) -> dict[str, Any]:
        """Give it as a scene of this process writes it; no other process can read that.

        Returns
        -------
        dict
        """
        params = {"law": str(self._law.number), "density": self.density, "damping-time": self.damping_time}
        return {"plugin": f"{_native.__file__}#python-law", "params": params}

    def _raise_error(self) -> None:
        """Raise the first exception of a function since the last call."""
        error = self._law.take_error()
        if error is not None:
            text = f"a function of a material raised {type(error).__name__}: {error}; its body stands still from then on"
            raise PliantError(text, "plugin") from error


@dataclass(frozen=True)
class Case:
    """A case of the conformance suite.

    Attributes
    ----------
    name : str
        Its name, as in ``pliant plugin check``.
    promise : str
        What a material promises.
    verdict : str
        ``"passed"``, ``"failed"`` or ``"skipped"``.
    reason : str
        Why it failed or was skipped.
    """

    name: str
    promise: str
    verdict: str
    reason: str


def check(material: Hyperelastic) -> list[Case]:
    """Run the conformance suite on a material: that the stress is the derivative of the energy, that rotations change nothing, and so on.

    Parameters
    ----------
    material : Hyperelastic
        A material written in Python; ``pliant plugin check`` does the same for a plugin.

    Returns
    -------
    list of Case
        One for each promise that a material makes. Exceptions of its functions are reasons of cases that failed.
    """
    rows = _native.check_law(material._law)
    material._law.take_error()
    return [Case(*row) for row in rows]


def _checked(name: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """What a function gave as a flat array."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.shape != shape:
        raise PliantError(f"`{name}` of a material gave an array of the shape {array.shape}; allowed is {shape}")
    return array.reshape(-1)


def _differences(stress: Callable[[NDArray[np.float64]], NDArray[np.float64]], gradients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Central differences of the stress by the deformation gradient (n x 9 x 9), symmetric."""
    directions = np.eye(9).reshape(9, 1, 3, 3) * _STEP
    moved = np.stack([gradients + directions, gradients - directions]).reshape(-1, 3, 3)
    after, before = stress(moved).reshape(2, 9, -1, 9)
    matrices = np.moveaxis((after - before) / (2 * _STEP), 0, 2)
    return 0.5 * (matrices + np.swapaxes(matrices, 1, 2))


def _positive_part(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nearest positive semi-definite matrices to symmetric ones (n x 9 x 9). NaN stays NaN."""
    finite = np.asarray(np.isfinite(matrices).all(axis=(1, 2)))
    values, vectors = np.linalg.eigh(np.where(finite[:, None, None], matrices, 0.0))
    indefinite = finite & (values[:, 0] < 0.0)
    projected = (vectors * np.maximum(values, 0.0)[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    return np.where(indefinite[:, None, None], projected, matrices)


for _public in (Hyperelastic, Case, check):
    _public.__module__ = "pliant"
