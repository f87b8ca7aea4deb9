"""The pointer as a hand: a mouse or a pen moves in two dimensions, a hand in three.

A stroke begins where a ray through the pointer meets the mesh. From there the hand follows the pointer along the surface as it was when the stroke
began, pressed in by a depth, or in the plane that faces the viewer. No Blender here, and no forces: a place comes out, and the engine's coupling
does the rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

# s, in which a press reaches its depth.
PRESS_TIME = 0.2
# Radii of the tool above the surface at which a press begins.
CLEARANCE = 0.05


class Gesture(Enum):
    """How a two-dimensional pointer drives a tool."""

    PRESS = "along the surface, pressed in by a depth"
    DRAG = "in the plane through the point where the stroke began that faces the viewer"
    SLICE = "like DRAG, with a blade that points away from the viewer"


# Edit kinds whose hand does not touch as it goes along the surface.
GESTURES = {"cut": Gesture.SLICE} | dict.fromkeys(("pull", "grab", "pinch"), Gesture.DRAG)


def gesture_of(kind: str) -> Gesture:
    """The gesture of an edit kind of the engine."""
    return GESTURES.get(kind, Gesture.PRESS)


@dataclass(frozen=True)
class Ray:
    """A ray of the pointer: its origin (m) and its unit direction away from the viewer."""

    origin: np.ndarray
    direction: np.ndarray


@dataclass(frozen=True)
class Hit:
    """Where a ray meets the surface (m), and the unit normal out of it."""

    point: np.ndarray
    normal: np.ndarray


class Stroke:
    """A stroke of a pointer under way.

    Parameters
    ----------
    gesture : Gesture
        How the pointer drives the tool.
    ray : Ray
        The pointer.
    hit : Hit or None
        Where the ray meets the mesh; only a slice may begin beside it.
    back : ndarray
        Unit, towards the viewer.
    focus : ndarray
        m, a point at the depth that a slice beside the mesh takes.
    radius, depth : float
        m, radius of the tool, and how deep a press goes in or how far the tip of a blade is behind the point it began at.
    """

    def __init__(
        self, gesture: Gesture, ray: Ray, hit: Hit | None, back: np.ndarray, focus: np.ndarray, radius: float, depth: float
    ) -> None:
        if hit is None:
            if gesture is not Gesture.SLICE:
                raise ValueError("the stroke begins beside the mesh; begin it on the mesh")
            hit = Hit(_on_plane(ray, focus, back), back)
        self.gesture = gesture
        self.depth = depth
        self._ray, self._surface, self._anchor, self._back = ray, hit, hit.point, back
        self._radius = radius
        self._reached = -CLEARANCE * radius
        self._lift = 0.0

    def follow(self, ray: Ray, hit: Hit | None) -> None:
        """The pointer has moved; `hit` is where its ray meets the surface as it was when the stroke began."""
        self._ray = ray
        if hit is not None:
            self._surface = hit

    def lift(self, length: float) -> None:
        """Move the hand towards the viewer by a length (m); a press becomes less deep by it."""
        if self.gesture is Gesture.PRESS:
            self.depth -= length
        else:
            self._lift += length

    def advance(self, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Where the hand is `dt` (s) after the last call (m), and how it is turned: a quaternion (x, y, z, w) whose z points at the viewer."""
        if self.gesture is Gesture.PRESS:
            step = dt / PRESS_TIME * (abs(self.depth) + CLEARANCE * self._radius)
            self._reached += float(np.clip(self.depth - self._reached, -step, step))
            place = self._surface.point + (self._radius - self._reached) * self._surface.normal
            return place, turn_z_to(self._back)
        if self.gesture is Gesture.DRAG:
            return _on_plane(self._ray, self._anchor + self._lift * self._back, self._back), turn_z_to(self._back)
        # The tip is behind the plane the pointer moves in, along the ray.
        place = _on_plane(self._ray, self._anchor, self._back) + (self.depth - self._lift) * self._ray.direction
        return place, turn_z_to(-self._ray.direction)


def _on_plane(ray: Ray, through: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Where a ray meets a plane; the point given where it runs along it."""
    slope = float(ray.direction @ normal)
    if abs(slope) < 1e-6:
        return through
    return ray.origin + float((through - ray.origin) @ normal) / slope * ray.direction


def turn_z_to(direction: np.ndarray) -> np.ndarray:
    """The smallest turn that takes z to a unit direction, as (x, y, z, w); half a turn about x where that is -z."""
    x, y, z = direction
    quaternion = np.array([-y, x, 0.0, 1.0 + z])
    length = np.linalg.norm(quaternion)
    return quaternion / length if length > 1e-9 else np.array([1.0, 0.0, 0.0, 0.0])
