"""A haptic shape-editing engine: touch, pull and cut meshes and cloth, and feel the force.

A :class:`Scene` says what there is, what a hand does to it and what is measured. :func:`run` runs one to its end and gives a
:class:`Result` of arrays; a :class:`Session` is stepped by the caller, who puts hands where they should be and reads forces and positions.

Quantities are in SI units (m, s, N, kg), arrays of points are (n x 3) and float64, quaternions are (x, y, z, w). Whatever goes wrong is a
:class:`PliantError` with a ``kind`` and a ``where``.

Examples
--------
>>> import pliant
>>> result = pliant.run("scenes/touch.toml", set={"body.0.material.params.young": "40 kPa"})  # doctest: +SKIP
>>> result.tools["finger"].force.shape  # doctest: +SKIP
(800, 3)
"""

from ._error import PliantError
from ._hand import Hand, ToolState
from ._live import Live, UsedPose
from ._positions import Positions
from ._result import Mesh, Probe, RayHit, Result, ToolTrace, Trace, run
from ._scene import Scene
from ._session import Frame, Session, Snapshot
from .catalogue import Fabric, Material, Param, Plugin, Preset, edit_kinds, plugins, quantities

__version__ = "0.1.0"

__all__ = [
    "Fabric",
    "Frame",
    "Hand",
    "Live",
    "Material",
    "Mesh",
    "Param",
    "PliantError",
    "Plugin",
    "Positions",
    "Preset",
    "Probe",
    "RayHit",
    "Result",
    "Scene",
    "Session",
    "Snapshot",
    "ToolState",
    "ToolTrace",
    "Trace",
    "UsedPose",
    "edit_kinds",
    "plugins",
    "quantities",
    "run",
]
