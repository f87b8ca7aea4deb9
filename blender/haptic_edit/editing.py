"""A mesh under a hand: from arrays to a session of the engine, stroke by stroke, and back. No Blender here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pliant

from .gesture import Gesture, Hit, Ray, Stroke, gesture_of
from .recording import RecordedStroke, Recording, joined, poses_of, without_console

BODY = "mesh"
TOOL = "hand"
# Stiffness of the spring between hand and surface over that of a ball pressed into a half-space by its radius, about 2 E r: stiff
# enough that the surface goes where the hand goes, soft enough to be stable.
COUPLING_SHARE = 2.0
# Force at which the hand gives in, over what presses the spring together by the radius of the tool.
PEAK_SHARE = 4.0
# N/m, spring of a hand on a sheet.
SHEET_COUPLING = 200.0
# Pressure of an inflating stroke over Young's modulus of a solid, and on a sheet, Pa.
PRESSURE_SHARE = 0.15
SHEET_PRESSURE = 50.0
# Speed at which a hand is followed, sizes of the mesh in a second.
SPEED = 20.0
# Radius of the part of a solid that is simulated around a hand, over the size of the mesh, at most: what is outside holds it in place.
REGION_SHARE = 0.35
# The same in cells, where these are small.
REGION_CELLS = 5.0
# Cells around a pinned vertex whose nodes are held: the diagonal of a cell, so that all corners of the one the vertex is in are among them.
PIN_CELLS = 3.0**0.5
# Radius of a soft brush of the engine: in radii of the tool, and in edges of a cell at least.
BRUSH_RADII, BRUSH_EDGES = 3.0, 1.5
# Distance at which an obstacle is met that is not closed and has no inside, over the size of the mesh.
THICKNESS_SHARE = 5e-3
# Distance of the blade behind the hand in a cut as wide as the mesh, over the radius of the tool.
LAG_SHARE = 0.25
# s, in which a force may rise to its peak.
RISE = 5e-3
# s, the longest way of a hand in a frame, as time.
MAX_FRAME = 0.05
# s, that a mesh is given to come to rest after a stroke.
SETTLE = 0.05
# Steps of a session whose poses are kept to be made again, of all strokes and of what was felt: 20 minutes of 1 ms, 96 MB.
KEPT_STEPS = 1_200_000


@dataclass(frozen=True)
class Settings:
    """What a mesh is made of and what the hand holds.

    Attributes
    ----------
    young, density : float
        Pa and kg/m^3, of a solid.
    fabric : str or None
        The fabric of a sheet; None for a solid.
    plugin : str
        The material plugin of a solid.
    level : int
        Fineness of the grid of a solid: 2^(level - 1) cells along the mesh's longest edge.
    radius : float
        m, of the tool.
    pinned : tuple of int
        Vertices that are held.
    factors : tuple of float
        Factor of the stiffness at each vertex, 0.1 to 10; empty for 1 everywhere.
    symmetry : str
        Axes of the scene in which the hand is mirrored, such as ``"x"`` or ``"xz"``; empty for none.
    strength : float
        Pressure or rate of the edit kinds that have one, over what it is by default.
    paint_factor : float
        Factor of the stiffness that paint reaches, 0.1 to 10.
    """

    young: float = 20e3
    density: float = 1000.0
    fabric: str | None = None
    plugin: str = "mass-spring"
    level: int = 6
    radius: float = 0.05
    pinned: tuple[int, ...] = ()
    factors: tuple[float, ...] = ()
    symmetry: str = ""
    strength: float = 1.0
    paint_factor: float = 4.0

    def brush_radius(self, size: float) -> float:
        """m, within which a tool pins, frees and paints a mesh of a size (m)."""
        cells = 0.0 if self.fabric is not None else BRUSH_EDGES * size / 2 ** (self.level - 1)
        return max(BRUSH_RADII * self.radius, cells)


@dataclass(frozen=True)
class MeshArrays:
    """A mesh in metres of the scene: vertices (n x 3), all corners one after the other, and the corners of each face."""

    vertices: np.ndarray
    corners: np.ndarray
    counts: np.ndarray

    def faces(self) -> list[list[int]]:
        """Vertices of each face."""
        if len(self.counts) and (self.counts == self.counts[0]).all():
            return self.corners.reshape(-1, self.counts[0]).tolist()
        flat, ends = self.corners.tolist(), np.cumsum(self.counts).tolist()
        return [flat[start:end] for start, end in zip([0, *ends], ends)]

    def size(self) -> float:
        """m, the longest edge of the box around the vertices that faces use"""
        used = self.vertices[self.corners]
        return float(np.ptp(used, axis=0).max())

    def is_open(self) -> bool:
        """Whether a loop of border edges is longer than the mesh: then one sees that nothing is inside, and it is cloth."""
        low, high, _ = self._sides()
        edges, sides = np.unique(low * len(self.vertices) + high, return_counts=True)
        low, high = np.divmod(edges[sides == 1], len(self.vertices))
        lengths = np.linalg.norm(self.vertices[low] - self.vertices[high], axis=1)
        return any(length > self.size() for length in _loop_lengths(low.tolist(), high.tolist(), lengths.tolist()))

    def is_closed(self) -> bool:
        """Whether each edge has two faces, which are seen from the same side."""
        low, high, is_upward = self._sides()
        _, edge, sides = np.unique(low * len(self.vertices) + high, return_inverse=True, return_counts=True)
        return bool((sides == 2).all() and (np.bincount(edge, weights=is_upward) == 1).all())

    def _sides(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For each side of a face: the lower and the higher of its vertices, and whether it leads from the lower to the higher."""
        after = np.roll(self.corners, -1)
        last = np.cumsum(self.counts) - 1
        after[last] = self.corners[last - self.counts + 1]
        return np.minimum(self.corners, after), np.maximum(self.corners, after), self.corners < after

    def has_faces_of(self, other: MeshArrays) -> bool:
        """Whether both have the same faces of as many vertices."""
        return (
            len(self.vertices) == len(other.vertices)
            and np.array_equal(self.counts, other.counts)
            and np.array_equal(self.corners, other.corners)
        )

    def is_same(self, other: MeshArrays) -> bool:
        """Whether both have the same faces and places."""
        return self.has_faces_of(other) and np.array_equal(self.vertices, other.vertices)


@dataclass(frozen=True)
class Obstacle:
    """A mesh that the edited one meets and that does not move."""

    name: str
    mesh: MeshArrays

    def is_same(self, other: Obstacle) -> bool:
        """Whether both are the same mesh in the same place."""
        return self.name == other.name and self.mesh.is_same(other.mesh)


def _loop_lengths(starts: list[int], ends: list[int], lengths: list[float]) -> list[float]:
    """Lengths of loops of edges: of those that hang together by their vertices."""
    parent: dict[int, int] = {}

    def root(vertex: int) -> int:
        while parent.setdefault(vertex, vertex) != vertex:
            parent[vertex] = parent[parent[vertex]]
            vertex = parent[vertex]
        return vertex

    for start, end in zip(starts, ends, strict=True):
        parent[root(start)] = root(end)
    sums: dict[int, float] = {}
    for start, length in zip(starts, lengths, strict=True):
        sums[root(start)] = sums.get(root(start), 0.0) + length
    return list(sums.values())


def edit_kinds() -> dict[str, str]:
    """The edit kinds of the engine that are done with a tool, with a sentence each."""
    return {name: text for name, text in pliant.edit_kinds().items() if name not in ("undo", "redo")}


def button_of(kind: str) -> int:
    """The button of the scene that begins an edit kind whose shape is kept."""
    return list(edit_kinds()).index(kind)


def felt_button() -> int:
    """The button of the scene that feels the surface, which springs back."""
    return len(edit_kinds())


def device_button_of(kind: str) -> int:
    """The button of the scene that begins an edit kind for a device, whose hand feels what it does."""
    return felt_button() + 1 if kind == "cut" else button_of(kind)


def scene_of(mesh: MeshArrays, settings: Settings, obstacles: tuple[Obstacle, ...] = ()) -> pliant.Scene:
    """The scene of a mesh: one body and one hand, with a button for each edit kind, and obstacles."""
    size, radius = mesh.size(), settings.radius
    scene = pliant.Scene()
    scene.output(energy=False)
    faces = mesh.faces()
    fields = {"young": settings.factors} if settings.factors else {}
    is_sheet = settings.fabric is not None
    if is_sheet:
        scene.time(dt=1e-3, integrator="backward-euler")
        scene.solver(tolerance=1e-4)
        fixed = [{"nodes": list(settings.pinned)}] if settings.pinned else []
        scene.body(BODY, mesh=mesh.vertices, faces=faces, material=pliant.Fabric(settings.fabric), fixed=fixed, fields=fields)
        stiffness = SHEET_COUPLING
    else:
        scene.time(dt=1e-3)
        material = pliant.Material(settings.plugin, young=settings.young, density=settings.density, damping_time=5e-4)
        cell = size / 2 ** (settings.level - 1)
        held = _thinned(mesh.vertices[list(settings.pinned)], 0.5 * cell) if settings.pinned else []
        fixed = [{"ball": place.tolist(), "radius": PIN_CELLS * cell} for place in held]
        grid = {"level": settings.level, "radius": min(REGION_SHARE * size, REGION_CELLS * cell)}
        scene.body(BODY, mesh=mesh.vertices, faces=faces, material=material, grid=grid, fixed=fixed, fields=fields)
        stiffness = COUPLING_SHARE * 2.0 * settings.young * radius
    for obstacle in obstacles:
        keys = {} if obstacle.mesh.is_closed() else {"thickness": THICKNESS_SHARE * size}
        scene.obstacle(obstacle.name, mesh=obstacle.mesh.vertices, faces=obstacle.mesh.faces(), **keys)
    peak, strengths = PEAK_SHARE * stiffness * radius, pliant.edit_strengths()
    scene.hand(TOOL, peak_force=float(np.clip(peak, 1e-3, 1e4)), stiffness=float(np.clip(4 * stiffness, 1e-3, 1e6)))
    blade = {"length": 4.0 * size, "toughness": LAG_SHARE * stiffness * radius / size}
    tool = {"stiffness": stiffness, "speed": SPEED * size, "slew": peak / RISE, "blade": blade}
    if is_sheet:
        tool["mass"] = 0.01
    scene.tool(TOOL, hand=TOOL, radius=radius, **tool)
    for button, kind in enumerate(edit_kinds()):
        # A cut stays by itself; a pull never lets go because of its force.
        keys = {"sheet_layers": "all"} if kind == "cut" else {"release": "keep"}
        if kind == "pull":
            keys["limit"] = 10 * peak
        if kind == "paint":
            keys["strength"] = settings.paint_factor
        elif kind in ("inflate", "deflate"):
            keys["strength"] = settings.strength * (SHEET_PRESSURE if is_sheet else PRESSURE_SHARE * settings.young)
        elif kind in strengths:
            keys["strength"] = settings.strength * strengths[kind].default
        if settings.symmetry:
            keys["symmetry"] = settings.symmetry
        scene.edit(kind, tool=TOOL, button=button, **keys)
    mirrored = {"symmetry": settings.symmetry} if settings.symmetry else {}
    scene.edit("touch", tool=TOOL, button=felt_button(), release="spring-back", **mirrored)
    # A line over a picture goes through all layers of a sheet; a knife that is felt goes through the one that it meets.
    scene.edit("cut", tool=TOOL, button=device_button_of("cut"), **mirrored)
    return scene


def _thinned(places: np.ndarray, distance: float) -> np.ndarray:
    """One place of each cell of a grid."""
    _, first = np.unique(np.floor(places / distance).astype(np.int64), axis=0, return_index=True)
    return places[np.sort(first)]


class MeshEdit:
    """A mesh that a hand edits.

    Parameters
    ----------
    mesh : MeshArrays
        The mesh.
    settings : Settings
        What it is made of, and the tool.
    obstacles : tuple of Obstacle
        What it meets besides the tool.
    allowed : tuple of str
        Folders from which the library of a device may be named by its path.
    """

    def __init__(
        self, mesh: MeshArrays, settings: Settings, obstacles: tuple[Obstacle, ...] = (), allowed: tuple[str, ...] = ()
    ) -> None:
        self.mesh, self.settings, self.obstacles = mesh, settings, obstacles
        self.scene = scene_of(mesh, settings, obstacles)
        with without_console():
            self.session = pliant.Session(self.scene, history=True, allow_plugins=allowed)
        # s, which cannot be asked for while the session goes on by the clock
        self._dt = self.session.dt
        self._live: pliant.Live | None = None
        self._stroke: Stroke | None = None
        self._kind = ""
        self._start = 0
        self._strokes: list[RecordedStroke] = []
        # Poses of the hand since its last stroke.
        self._felt: list[pliant.Poses] = []
        # Number of all poses that are kept, and whether these are all since the session was opened.
        self._kept, self._is_kept = 0, True
        self._refusals = 0

    @property
    def is_under_way(self) -> bool:
        """Whether a stroke is under way."""
        return self._stroke is not None

    def begin(self, kind: str, ray: Ray, hit: Hit | None, back: np.ndarray, depth: float) -> None:
        """Begin a stroke; see :class:`Stroke`."""
        gesture = gesture_of(kind)
        focus = self.mesh.vertices[self.mesh.corners].mean(axis=0)
        if gesture is Gesture.SLICE:
            depth = self.mesh.size()
        self._stroke = Stroke(gesture, ray, hit, back, focus, self.settings.radius, depth)
        self._kind = kind
        self.triangles = len(self.session.triangles(BODY))
        self._start = self.session.steps
        self._live = self.session.play()
        # The hand is there, above the mesh, before it moves: one that appeared inside would press outwards.
        self.advance(0.0)
        self._arrive()

    def follow(self, ray: Ray, hit: Hit | None) -> None:
        """The pointer has moved."""
        if self._stroke is not None:
            self._stroke.follow(ray, hit)

    def lift(self, length: float) -> None:
        """Move the hand towards the viewer, m."""
        if self._stroke is not None:
            self._stroke.lift(length)

    def set_depth(self, depth: float) -> None:
        """How deep a press goes in, m: the pressure of a pen."""
        if self._stroke is not None and self._stroke.gesture is Gesture.PRESS:
            self._stroke.depth = depth

    def advance(self, dt: float) -> None:
        """Send the hand where it is `dt` (s) after the last call."""
        if self._stroke is None or self._live is None:
            return
        # A viewport that is slower than the hand slows the hand down.
        place, turn = self._stroke.advance(min(dt, MAX_FRAME))
        self._live.go(TOOL, place, turn, [button_of(self._kind)])

    def read(self, out: np.ndarray, matrix: np.ndarray | None = None) -> pliant.ToolState | None:
        """Copy the newest positions into `out` (n x 3, float32); give the tool, or None before the first step."""
        if self._live is None or self._live.read(BODY, out, matrix) == 0:
            return None
        return self._live.tool(TOOL)

    @property
    def is_alive(self) -> bool:
        """Whether the engine still steps, in a stroke."""
        return self._live is not None and self._live.is_alive

    def end(self) -> bool:
        """End the stroke: what it did stays. Give whether the mesh was cut or broke."""
        if self._live is None or self._stroke is None:
            return False
        self._arrive()
        self._stroke = None
        self._stop(self._live.stop)
        self._keep_steps(self._start, self.session.steps)
        return len(self.session.triangles(BODY)) != self.triangles

    def give_hand(self, plugin: str | pliant.DeviceHand, **keys: object) -> pliant.DeviceHand:
        """Give the hand to a device until :meth:`rest`; `plugin` and `keys` as for :meth:`pliant.Hand.follow`."""
        used = self.mesh.vertices[self.mesh.corners]
        middle = 0.5 * (used.min(axis=0) + used.max(axis=0))
        self.triangles = len(self.session.triangles(BODY))
        hand = self._live = self.session.hand(TOOL).follow(plugin, centre=middle, **keys)
        return hand

    def keep_poses(self, poses: pliant.Poses) -> None:
        """Keep poses of the hand, so that strokes can be made again. With more than :data:`KEPT_STEPS` since the session was opened none are kept any more:
        a stroke cannot be made again without those before it.
        """
        if not self._is_kept:
            return
        self._felt.append(poses)
        self._kept += len(poses)
        if self._kept > KEPT_STEPS:
            self._felt.clear()
            self._strokes.clear()
            self._is_kept = False

    def keep_stroke(self, start: float, rest: float) -> None:
        """Keep a stroke of a device that began and came to rest at times (s) of the session, with the poses that were kept since the last one."""
        self._keep_steps(round(start / self._dt), round(rest / self._dt))

    def _keep_steps(self, start: int, rest: int) -> None:
        """Keep a stroke that began and came to rest at steps of the session."""
        if self._is_kept:
            self._strokes.append(RecordedStroke(start, rest, joined(self._felt)))
            self._felt.clear()

    def rest(self) -> bool:
        """Take the hand from a device, which is closed, and let the mesh come to rest. Give whether the mesh was cut or broke."""
        if self._live is None:
            return False
        self._stop(self._live.stop)
        return len(self.session.triangles(BODY)) != self.triangles

    def pause(self) -> None:
        """Stop a session whose hand a device has, let the mesh come to rest, and leave the device open for another session."""
        hand = self._live
        if isinstance(hand, pliant.DeviceHand):
            self._stop(hand.pause)

    def is_cut(self) -> bool:
        """Whether a device has cut or broken the mesh."""
        return self._live is not None and self._live.triangle_count(BODY) not in (0, self.triangles)

    def _stop(self, stop: Callable[[], list[pliant.UsedPose]]) -> None:
        """Stop the clock as `stop` does, keep the poses of the hand, let it go, and give the mesh time to come to rest."""
        live, self._live = self._live, None
        self.keep_poses(live.take_poses())
        # Those of steps in between.
        self.keep_poses(poses_of(stop()))
        self.session.hand(TOOL).leave()
        self.session.step(max(1, round(SETTLE / self.session.dt)))

    def _arrive(self) -> None:
        """Wait until the hand is where it was sent last: a view may be of steps before, the one after it is not."""
        seen = self._live.wait(0, 1.0)
        seen = self._live.wait(seen, 1.0)
        self._live.wait(seen, 1.0)

    def take_refusals(self) -> list[str]:
        """Why parts of cuts were refused, what still holds together, or what was cut already, since the last call; between strokes."""
        events = self.session.events()
        kinds = ("cut-refused", "cut-held", "cut-again")
        count = sum(events["counts"].get(kind, 0) for kind in kinds)
        is_new, self._refusals = count > self._refusals, count
        texts = [event["text"] for event in events["described"] if event["kind"] in kinds]
        return texts[-1:] if is_new else []

    def painting(self) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
        """Vertices that strokes have pinned, and those whose stiffness they have painted with the factor of each; of a device those of the newest view."""
        source = self.session if self._live is None else self._live
        vertices, factors = source.painted(BODY)
        return source.pinned(BODY).astype(np.int64), (vertices.astype(np.int64), factors)

    def last_places(self, kind: str) -> np.ndarray | None:
        """m (k x 3), where the hand was in the last stroke with the button of an edit kind pressed; None if its poses are no longer kept."""
        if not self._strokes:
            return None
        poses = self._strokes[-1].poses
        pressed = np.uint32(1 << button_of(kind) | 1 << device_button_of(kind))
        return poses.position[poses.buttons & pressed != 0]

    def recording(self) -> Recording | None:
        """All strokes so far; between strokes, after the first. None if the hand has had more poses than are kept."""
        return Recording(self.scene, BODY, TOOL, tuple(self._strokes)) if self._is_kept else None

    def positions(self) -> np.ndarray:
        """m (n x 3), where the vertices are; between strokes"""
        return self.session.positions(BODY).copy()

    def surface(self) -> pliant.Mesh:
        """The mesh as it is between strokes, to be pointed at."""
        return self.session.mesh(BODY)

    def close(self) -> None:
        """End the session."""
        if self._live is not None:
            self._live.stop()
            self._live = None
        with without_console():
            self.session.close()

    def warnings(self) -> list[pliant.PliantWarning]:
        """What has no effect, or not the one it looks like; between strokes."""
        return self.session.warnings()
