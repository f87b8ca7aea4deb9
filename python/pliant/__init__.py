"""A haptic shape-editing engine: touch, pull and cut meshes and cloth, and feel the force.

A :class:`Scene` says what there is, what a hand does to it and what is measured. :func:`run` runs one to its end and gives a
:class:`Result` of arrays; a :class:`Session` is stepped by the caller, who puts hands where they should be and reads forces and positions.

Quantities are in SI units (m, s, N, kg), arrays of points are (n x 3) and float64, quaternions are (x, y, z, w). Whatever goes wrong is a
:class:`PliantError` with a ``kind`` and a ``where``; what has no effect is a :class:`PliantWarning` with a ``code``.

A :class:`Batch` steps many sessions at once, :mod:`pliant.batch` runs sweeps of thousands of edits, and :class:`Hyperelastic` is a material
written in Python.

Examples
--------
>>> import pliant
>>> result = pliant.run("scenes/touch.toml", set={"body.0.material.params.young": "40 kPa"})  # doctest: +SKIP
>>> result.tools["finger"].force.shape  # doctest: +SKIP
(800, 3)
"""

from . import batch
from ._batch import Batch, BatchResult, BatchTools, BatchTrace
from ._device_hand import DeviceHand, DeviceState
from ._error import PliantError
from ._hand import Hand
from ._hyperelastic import Case, Hyperelastic, check
from ._live import Live, Poses, UsedPose
from ._pose import ToolState
from ._positions import Positions
from ._result import Mesh, Probe, RayHit, Result, ToolTrace, Trace, run
from ._scene import Scene
from ._session import Frame, Session, Snapshot
from ._warning import PliantWarning
from .catalogue import (
    Fabric,
    Material,
    Param,
    Plugin,
    Preset,
    Strength,
    devices,
    edit_kinds,
    edit_strengths,
    opposite_kind,
    plugins,
    quantities,
)

__version__ = "0.1.0"

__all__ = [
    "Batch",
    "BatchResult",
    "BatchTools",
    "BatchTrace",
    "Case",
    "DeviceHand",
    "DeviceState",
    "Fabric",
    "Frame",
    "Hand",
    "Hyperelastic",
    "Live",
    "Material",
    "Mesh",
    "Param",
    "PliantError",
    "PliantWarning",
    "Plugin",
    "Poses",
    "Positions",
    "Preset",
    "Probe",
    "RayHit",
    "Result",
    "Scene",
    "Session",
    "Snapshot",
    "Strength",
    "ToolState",
    "ToolTrace",
    "Trace",
    "UsedPose",
    "batch",
    "check",
    "devices",
    "edit_kinds",
    "edit_strengths",
    "opposite_kind",
    "plugins",
    "quantities",
    "run",
]
