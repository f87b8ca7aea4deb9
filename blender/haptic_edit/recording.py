"""Strokes of a hand, recorded and made again. No Blender here."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain

import numpy as np
import pliant


@dataclass(frozen=True)
class RecordedStroke:
    """A stroke in the steps of its session.

    Attributes
    ----------
    start, rest : int
        Steps taken when it began, and when the mesh had come to rest.
    poses : Poses
        Where the hand was since the stroke before, step by step; in a step without a pose it was away.
    """

    start: int
    rest: int
    poses: pliant.Poses


@dataclass(frozen=True)
class Recording:
    """A session from its opening to its last stroke: making it again gives the same bytes.

    Attributes
    ----------
    scene : Scene
        What was opened.
    body, tool : str
        The mesh and the tool of the hand.
    strokes : tuple of RecordedStroke
        All strokes since the session was opened; a later one begins with what earlier ones left.
    """

    scene: pliant.Scene
    body: str
    tool: str
    strokes: tuple[RecordedStroke, ...]

    def shapes(self, interval: float) -> Iterator[np.ndarray]:
        """Make all strokes again, and give the vertices (n x 3, m) every `interval` (s) from the beginning of the last one.

        The first shape is one interval after the beginning. The last one is the shape at rest that the stroke left; its place in time is the
        first multiple of the interval that is not before the rest.
        """
        last = self.strokes[-1]
        with without_console(), pliant.Session(self.scene, history=True) as session:
            steps = sampled_steps(last, interval / session.dt)
            for _ in self._steps(session, last.rest):
                # Several in one step where frames are shorter than a step.
                while steps and session.steps == steps[0]:
                    yield session.positions(self.body).copy()
                    steps.pop(0)

    def _steps(self, session: pliant.Session, last: int) -> Iterator[None]:
        """Make all strokes up to a step, step by step."""
        hand, poses = session.hand(self.tool), chain.from_iterable(stroke.poses for stroke in self.strokes)
        pose = next(poses, None)
        while session.steps < last:
            if pose is not None and round(pose.time / session.dt) == session.steps + 1:
                hand.go(pose.position, pose.rotation, pose.buttons)
                pose = next(poses, None)
            else:
                hand.leave()
            session.step()
            yield


def sampled_steps(stroke: RecordedStroke, interval: float) -> list[int]:
    """Steps of a stroke at multiples of an interval (steps) after its beginning; the last is that of the rest."""
    count = max(1, math.ceil((stroke.rest - stroke.start) / interval))
    return [*(stroke.start + round(index * interval) for index in range(1, count)), stroke.rest]


def poses_of(used: list[pliant.UsedPose]) -> pliant.Poses:
    """Poses one by one as arrays."""
    return pliant.Poses(
        np.array([pose.time for pose in used]),
        np.array([pose.tool for pose in used], dtype=np.str_),
        np.array([pose.position for pose in used], dtype=np.float64).reshape(-1, 3),
        np.array([pose.rotation for pose in used], dtype=np.float64).reshape(-1, 4),
        np.array([pose.buttons for pose in used], dtype=np.uint32),
    )


def joined(parts: list[pliant.Poses]) -> pliant.Poses:
    """Poses one after the other; there is at least one part."""
    names = ("time", "tool", "position", "rotation", "buttons")
    return pliant.Poses(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@contextmanager
def without_console() -> Iterator[None]:
    """Keep warnings of a session from the console: the mode reports them."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pliant.PliantWarning)
        yield
