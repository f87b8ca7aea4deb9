"""A Gymnasium environment: touch a soft block with a given force.

An action moves the finger up or down; an observation is the force, its goal and the finger's height. Without gymnasium installed the class works
all the same, with spaces left out. Run as a program, a plain integral controller plays three episodes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import pliant

try:
    import gymnasium
    from gymnasium.spaces import Box

    Base = gymnasium.Env
except ImportError:
    Box = None
    Base = object

EDGE = 0.08  # m, of the block
RADIUS = 0.008  # m, of the finger
MAX_MOVE = 2e-4  # m, of an action
MAX_FORCE = 0.5  # N, the largest goal
STEPS_PER_ACTION = 10
ACTIONS = 120  # of an episode


def block_scene(young: float = 20e3) -> pliant.Scene:
    """Make a soft block that stands, with a finger that the environment moves."""
    scene = pliant.Scene()
    scene.time(dt="1 ms")
    material = pliant.Material("mass-spring", young=young, density=1000, damping_time="1 ms")
    shape = {"kind": "box", "cells": 8, "size": [EDGE, EDGE, EDGE]}
    table = {"box": [[-EDGE, -EDGE, -0.51 * EDGE], [EDGE, EDGE, -0.49 * EDGE]]}
    scene.body("block", shape=shape, material=material, grid={"level": 4}, fixed=[table])
    scene.hand("hand")
    scene.tool("finger", radius=RADIUS, stiffness="400 N/m")
    scene.edit("touch", tool="finger")
    scene.output(energy=False)
    return scene


class TouchEnv(Base):
    """Touch a soft block with a given force.

    Parameters
    ----------
    young : float
        Young's modulus of the block, Pa.
    """

    metadata = {"render_modes": []}

    def __init__(self, young: float = 20e3) -> None:
        self._session = pliant.Session(block_scene(young), threads=1)
        self._hand = self._session.hand("finger")
        self._start = self._session.snapshot()
        self._rng = np.random.default_rng()
        self._height = self._goal = 0.0
        self._left = 0
        if Box is not None:
            self.action_space = Box(-1.0, 1.0, (1,))
            low, high = np.array([-np.inf, 0.0, 0.0]), np.array([np.inf, MAX_FORCE, EDGE])
            self.observation_space = Box(low.astype(np.float32), high.astype(np.float32))

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode: the finger is just above the block, and there is a new goal."""
        if Box is not None:
            super().reset(seed=seed)
            self._rng = self.np_random
        elif seed is not None:
            self._rng = np.random.default_rng(seed)
        self._hand.leave()
        self._session.restore(self._start)
        self._session.step()
        self._goal = (options or {}).get("goal", self._rng.uniform(0.1, MAX_FORCE))
        self._height, self._left = EDGE / 2 + RADIUS + 1e-3, ACTIONS
        return self._observation(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Move the finger by up to 0.2 mm, and let 10 ms pass."""
        self._height += MAX_MOVE * float(np.clip(action[0], -1.0, 1.0))
        self._hand.go([0.0, 0.0, self._height])
        self._session.step(STEPS_PER_ACTION)
        self._left -= 1
        observation = self._observation()
        return observation, -abs(float(observation[0]) - self._goal), False, self._left == 0, {}

    def close(self) -> None:
        """End the session."""
        self._session.close()

    def _observation(self) -> np.ndarray:
        return np.array([self._session.force("finger")[2], self._goal, self._height], dtype=np.float32)


def play(env: TouchEnv, seed: int) -> tuple[float, float]:
    """Play an episode with an integral controller; give the goal and the last force, N."""
    observation, _ = env.reset(seed=seed)
    ended = False
    while not ended:
        error = observation[0] - observation[1]
        observation, _, _, ended, _ = env.step(np.array([12.0 * error]))
    return float(observation[1]), float(observation[0])


def main() -> list[tuple[float, float]]:
    """Play three episodes and print how close they come."""
    env = TouchEnv()
    played = [play(env, seed) for seed in range(3)]
    env.close()
    for goal, force in played:
        print(f"goal {goal:.3f} N, reached {force:.3f} N")
    return played


if __name__ == "__main__":
    main()
