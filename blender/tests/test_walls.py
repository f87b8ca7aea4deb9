"""What goes on over the walls of a cut from their border."""

import numpy as np
import pytest


def disc(rings, around, random):
    """A disc of rings of vertices about a centre, shaken: triangles, places and which vertices are on its border."""
    angles = 2 * np.pi * np.arange(around) / around
    places, triangles = [np.zeros(3)], []
    for ring in range(1, rings + 1):
        shaken = angles + random.uniform(-0.2, 0.2, around) * 2 * np.pi / around
        radius = ring + random.uniform(-0.3, 0.3, around)
        places += list(np.stack([radius * np.cos(shaken), radius * np.sin(shaken), random.uniform(-0.2, 0.2, around)], axis=1))
    number = lambda ring, i: 1 + (ring - 1) * around + i % around
    triangles += [[0, number(1, i), number(1, i + 1)] for i in range(around)]
    for ring in range(1, rings):
        for i in range(around):
            a, b, c, d = number(ring, i), number(ring, i + 1), number(ring + 1, i), number(ring + 1, i + 1)
            triangles += [[a, c, d], [a, d, b]]
    on_border = np.zeros(len(places), dtype=bool)
    on_border[number(rings, 0) :] = True
    return np.array(triangles), np.array(places), on_border


@pytest.mark.parametrize("seed", range(12))
def test_each_inner_vertex_is_the_mean_of_its_neighbours(empty, seed):
    random = np.random.default_rng(seed)
    triangles, places, on_border = disc(int(random.integers(1, 12)), int(random.integers(3, 30)), random)
    walls = empty.walls.Walls(triangles, places, on_border)
    values = random.uniform(0.0, 1.0, (len(walls.border), 3))
    values[:, 1] = 0.25
    all_values = np.zeros((len(places), 3))
    all_values[walls.border], all_values[walls.inner] = values, walls.extend(values)
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    sums, total = np.zeros((len(places), 3)), np.zeros((len(places), 1))
    for a, b in {tuple(pair) for pair in ends.tolist()}:
        weight = 1.0 / np.linalg.norm(places[a] - places[b])
        sums[a] += weight * all_values[b]
        sums[b] += weight * all_values[a]
        total[[a, b]] += weight
    assert np.abs(sums / total - all_values)[walls.inner].max() < 1e-6
    assert np.abs(all_values[:, 1] - 0.25).max() < 1e-6


def test_walls_without_a_border_or_an_inside_are_left(empty):
    triangles, places = np.array([[0, 1, 2], [0, 2, 3]]), np.eye(4, 3)
    closed = empty.walls.Walls(triangles, places, np.zeros(4, dtype=bool))
    assert (closed.extend(np.zeros((0, 2))) == 0.0).all() and len(closed.inner) == 4
    assert len(empty.walls.Walls(triangles, places, np.ones(4, dtype=bool)).extend(np.ones((4, 1)))) == 0
    nothing = empty.walls.Walls(np.zeros((0, 3), dtype=np.int64), places, np.ones(4, dtype=bool))
    assert len(nothing.inner) == len(nothing.border) == 0
