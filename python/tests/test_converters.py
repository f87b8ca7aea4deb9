"""Meshes in other libraries: the packages themselves where they are installed, otherwise skipped."""

import numpy as np
import pytest
from conftest import pressed

import pliant


@pytest.fixture(scope="module")
def mesh():
    """A cube that was pressed: not one of the shapes that any library makes by itself."""
    with pliant.Session(pressed()) as session:
        session.hand("finger").go([0.01, 0.0, 0.053])
        session.step(50)
        return session.mesh("cube")


def areas(vertices, triangles):
    a, b, c = (np.asarray(vertices)[np.asarray(triangles)[:, corner]] for corner in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def volume(mesh):
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]] for corner in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0


def test_a_mesh_of_trimesh_has_its_vertices_and_volume(mesh):
    pytest.importorskip("trimesh")
    made = mesh.to_trimesh()
    assert np.array_equal(made.vertices, mesh.vertices) and np.array_equal(made.faces, mesh.triangles)
    assert made.is_watertight and made.volume == pytest.approx(volume(mesh), rel=1e-12) and made.volume > 0


def test_a_mesh_of_meshio_is_the_same_after_a_file(mesh, tmp_path):
    meshio = pytest.importorskip("meshio")
    made = mesh.to_meshio()
    assert np.array_equal(made.points, mesh.vertices) and np.array_equal(made.cells_dict["triangle"], mesh.triangles)
    made.write(tmp_path / "pressed.vtu")
    read = meshio.read(tmp_path / "pressed.vtu")
    assert np.array_equal(read.points, mesh.vertices) and np.array_equal(read.cells_dict["triangle"], mesh.triangles)


def test_a_mesh_of_pyvista_has_its_vertices_and_area(mesh):
    pytest.importorskip("pyvista")
    made = mesh.to_pyvista()
    assert made.n_points == len(mesh.vertices) and made.n_cells == len(mesh.triangles)
    assert np.allclose(made.points, mesh.vertices, rtol=1e-7, atol=0) and np.array_equal(made.regular_faces, mesh.triangles)
    assert made.area == pytest.approx(areas(mesh.vertices, mesh.triangles).sum(), rel=1e-6)
    assert made.volume == pytest.approx(volume(mesh), rel=1e-5)
