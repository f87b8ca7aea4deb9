"""What vertices inside of the walls of a cut have: weights, colours and shape keys go on over a wall from its border, as harmonic functions. No Blender here."""

from __future__ import annotations

import numpy as np

# Residual over that of the beginning at which the iteration ends: beyond what single precision keeps.
TOLERANCE = 1e-8


class Walls:
    """The walls of a cut as a graph of their edges, weighted by the inverse of their lengths.

    Attributes
    ----------
    border, inner : ndarray of int
        Vertices of the walls that are on a face of the mesh, and those that are not, ascending.
    """

    def __init__(self, triangles: np.ndarray, places: np.ndarray, on_faces: np.ndarray) -> None:
        """Triangles (k x 3) index `places` (n x 3, m, at rest); `on_faces` (n) says which vertices a face of the mesh has."""
        vertices, corners = np.unique(triangles, return_inverse=True)
        corners = corners.reshape(-1, 3)
        ends = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        self._from, self._to = np.unique(ends, axis=0).T
        lengths = np.linalg.norm(places[vertices[self._from]] - places[vertices[self._to]], axis=1)
        # Corners of the two sides of a slit may be at one place.
        self._weights = 1.0 / np.maximum(lengths, 1e-6 * lengths.max(initial=1e-300))[:, None]
        self._is_inner = ~on_faces[vertices]
        self.border, self.inner = vertices[~self._is_inner], vertices[self._is_inner]

    def extend(self, values: np.ndarray) -> np.ndarray:
        """Values of the inner vertices (their number x c) for those of the border (their number x c): each is the mean of its neighbours, and so within
        the range of the border's. Walls without a border have 0.
        """
        x = np.zeros((len(self._is_inner), values.shape[1]))
        x[~self._is_inner] = values
        residual = -self._differences(x)
        diagonal = np.zeros((len(x), 1))
        np.add.at(diagonal, self._from, self._weights)
        np.add.at(diagonal, self._to, self._weights)
        # Conjugate gradients, a column on its own; more steps than unknowns are of no use.
        scaled = residual / diagonal
        direction, product = scaled.copy(), (residual * scaled).sum(axis=0)
        goal = TOLERANCE**2 * product
        for _ in range(len(self.inner)):
            if (product <= goal).all():
                break
            image = self._differences(direction)
            step = _quotient(product, (direction * image).sum(axis=0))
            x += step * direction
            residual -= step * image
            scaled = residual / diagonal
            before, product = product, (residual * scaled).sum(axis=0)
            direction = scaled + _quotient(product, before) * direction
        return x[self._is_inner]

    def _differences(self, x: np.ndarray) -> np.ndarray:
        """Weighted sum of the differences of each inner vertex from its neighbours, 0 on the border."""
        flow = self._weights * (x[self._from] - x[self._to])
        sums = np.zeros_like(x)
        np.add.at(sums, self._from, flow)
        np.subtract.at(sums, self._to, flow)
        sums[~self._is_inner] = 0.0
        return sums


def _quotient(numerator: np.ndarray, denominator: np.ndarray) -> np.ndarray:
    """A quotient of each column, 0 where it has converged."""
    return np.divide(numerator, denominator, out=np.zeros_like(numerator), where=denominator > 0.0)
