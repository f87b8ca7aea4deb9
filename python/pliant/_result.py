"""A scene from its start to its end, and what came out."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._scene import Scene, as_scene
from ._warning import warn
from .catalogue import open_options


@dataclass(frozen=True)
class RayHit:
    """Where a ray meets a mesh.

    Attributes
    ----------
    point : ndarray
        m (3).
    normal : ndarray
        Unit normal of the triangle (3), out of the mesh.
    triangle : int
        Its number.
    """

    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    triangle: int


@dataclass(frozen=True)
class Mesh:
    """The mesh of a body.

    Attributes
    ----------
    vertices : ndarray
        m (n x 3).
    triangles : ndarray
        Vertices (m x 3), counter-clockwise seen from outside.
    face_of : ndarray
        Face of the model that each triangle is a part of (m), from 0; the number of faces for a triangle that a cut has made inside.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.uint32]
    face_of: NDArray[np.uint32]

    def cast(self, origin: ArrayLike, direction: ArrayLike) -> RayHit | None:
        """Find where a ray meets the mesh first, from either side.

        Parameters
        ----------
        origin : array_like
            m (3).
        direction : array_like
            Of any length (3).

        Returns
        -------
        RayHit or None
        """
        start, way = (np.asarray(vector, dtype=np.float64).reshape(3) for vector in (origin, direction))
        found = _native.ray_cast(self.vertices, self.triangles, tuple(start.tolist()), tuple(way.tolist()))
        if found is None:
            return None
        time, triangle = found
        a, b, c = self.vertices[self.triangles[triangle]]
        normal = np.cross(b - a, c - a)
        return RayHit(start + time * way, normal / np.linalg.norm(normal), triangle)

    def to_trimesh(self) -> Any:
        """Make a ``trimesh.Trimesh`` of it; needs trimesh.

        Returns
        -------
        trimesh.Trimesh
        """
        import trimesh

        return trimesh.Trimesh(self.vertices, self.triangles.astype(np.int64), process=False)

    def to_meshio(self) -> Any:
        """Make a ``meshio.Mesh`` of it; needs meshio.

        Returns
        -------
        meshio.Mesh
        """
        import meshio

        return meshio.Mesh(self.vertices, [("triangle", self.triangles.astype(np.int64))])

    def to_pyvista(self) -> Any:
        """Make a ``pyvista.PolyData`` of it; needs pyvista.

        Returns
        -------
        pyvista.PolyData
        """
        import pyvista

        return pyvista.PolyData.from_regular_faces(self.vertices, self.triangles.astype(np.int64))


@dataclass(frozen=True)
class ToolTrace:
    """A tool in every step of a run.

    Attributes
    ----------
    hand, proxy : ndarray
        m (s x 3), where the hand was, and where the surface let the tool be.
    contact : ndarray
        Number of the body it touched or held (s); -1 for none.
    holds : ndarray
        Whether it held on (s).
    depth : ndarray
        m (s), how far the surface had gone in, or out.
    force : ndarray
        N (s x 3), on the hand, in the scene.
    device_force : ndarray
        N (s x 3), what the device was given, in its own axes.
    """

    hand: NDArray[np.float64]
    proxy: NDArray[np.float64]
    contact: NDArray[np.int64]
    holds: NDArray[np.bool_]
    depth: NDArray[np.float64]
    force: NDArray[np.float64]
    device_force: NDArray[np.float64]


@dataclass(frozen=True)
class Trace:
    """Every step of a run.

    Attributes
    ----------
    time : ndarray
        s (s), at the end of each step.
    nodes, elements : ndarray
        Active ones (s).
    kinetic_energy, elastic_energy : ndarray
        J (s).
    substeps, iterations : ndarray
        Substeps of each body, and iterations of all solves (s).
    residual : ndarray
        The largest final relative residual (s).
    seconds : ndarray
        s (s), wall clock.
    """

    time: NDArray[np.float64]
    nodes: NDArray[np.uint64]
    elements: NDArray[np.uint64]
    kinetic_energy: NDArray[np.float64]
    elastic_energy: NDArray[np.float64]
    substeps: NDArray[np.uint64]
    iterations: NDArray[np.uint64]
    residual: NDArray[np.float64]
    seconds: NDArray[np.float64]


@dataclass(frozen=True)
class Probe:
    """What a probe measured.

    Attributes
    ----------
    value : float
        SI units; not a number where the run gave none.
    time : float
        s, when it was measured.
    expected, error, tolerance : float or None
        What it should be, how far off it was, and how far it may be; of a probe with an expected value.
    passed : bool or None
        Whether the error is within the tolerance.
    """

    value: float
    time: float
    expected: float | None = None
    error: float | None = None
    tolerance: float | None = None
    passed: bool | None = None


class Result:
    """What a run came to.

    Attributes
    ----------
    trace : Trace
        Every step.
    tools : dict of str to ToolTrace
        Every step of each tool, by its name.
    probes : dict of str to Probe
        What was measured, by name.
    meshes : dict of str to Mesh
        Each body at the end, by its name.
    summary : dict
        Everything else: what ``summary.json`` of a run says; ``summary["warnings"]`` lists what had no effect, with codes.
    """

    trace: Trace
    tools: dict[str, ToolTrace]
    probes: dict[str, Probe]
    meshes: dict[str, Mesh]
    summary: dict[str, Any]

    def __init__(self, session: _native.Session, trace: dict[str, Any], summary: str) -> None:
        tools = trace.pop("tools")
        self.trace = Trace(**trace)
        self.tools = {name: ToolTrace(**tool) for name, tool in tools.items()}
        self.summary = json.loads(summary)
        self.probes = {row["name"]: _probe(row) for row in self.summary["probes"]}
        self.meshes = {
            name: Mesh(session.positions(name).copy(), session.triangles(name), session.face_of(name))
            for name in session.bodies
        }

    @property
    def passed(self) -> bool:
        """Whether every probe with an expected value is within its tolerance, and no body was frozen."""
        frozen = any("frozen" in body for body in self.summary["bodies"])
        return not frozen and all(probe.passed is not False for probe in self.probes.values())

    def __repr__(self) -> str:
        probes = "".join(f", {name}={probe.value:.6g}" for name, probe in self.probes.items())
        return f"<result of {len(self.trace.time)} steps{probes}>"


def run(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    set: Mapping[str, Any] | None = None,
    mesh: str | os.PathLike[str] | None = None,
    out: str | os.PathLike[str] | None = None,
    threads: int = 0,
    plugin_path: Iterable[str | os.PathLike[str]] = (),
    allow_plugins: Iterable[str | os.PathLike[str]] = (),
) -> Result:
    """Run a scene from its start to its end, as ``pliant run`` does.

    Parameters
    ----------
    scene : Scene, path or mapping
        What there is and what happens.
    set : mapping, optional
        Values by their path in the scene, such as ``{"body.0.material.params.young": "40 kPa"}``.
    mesh : path, optional
        Another model in the place of the first body's, scaled to fit.
    out : path, optional
        A folder for the files that ``pliant run`` leaves; nothing is written without it.
    threads : int
        Threads for its steps; 0 takes what the machine has. Results are the same bytes for any number.
    plugin_path : iterable of path
        Folders that are searched for plugins first.
    allow_plugins : iterable of path
        Folders from which the scene may name libraries by path, which runs their code; none by default.

    Returns
    -------
    Result

    Raises
    ------
    PliantError
        A scene, model or plugin that cannot be used.

    Warns
    -----
    PliantWarning
        A part of the scene had no effect, or not the one it looks like. ``warnings.simplefilter("error", pliant.PliantWarning)`` makes it an
        error.
    """
    scene = as_scene(scene)
    if scene._driven:
        names = ", ".join(f"`{name}`" for name in scene._driven)
        warnings.warn(f"hands without a path stay away in a run: {names}; give them a `path`, or open a Session", stacklevel=2)
    options = open_options(
        threads=threads, plugin_path=plugin_path, allow_plugins=allow_plugins, mesh=mesh, hands=scene._driven
    )
    folder = None if out is None else os.fspath(out)
    try:
        result = Result(*_native.run(scene._given(set or {}), options, folder))
    finally:
        for material in scene._materials:
            material._raise_error()
    warn(result.summary["warnings"], stacklevel=2)
    return result


def _probe(row: dict[str, Any]) -> Probe:
    value = row["value"]
    keys = ("expected", "error", "tolerance", "passed")
    return Probe(float("nan") if value is None else value, row["time"], **{key: row.get(key) for key in keys})


for _public in (RayHit, Mesh, ToolTrace, Trace, Probe, Result, run):
    _public.__module__ = "pliant"
