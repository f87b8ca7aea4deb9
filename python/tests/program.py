"""The program beside the package: the same scene and the same hand through both."""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    import pliant

ROOT = Path(__file__).resolve().parents[2]


def find_program() -> Path:
    """The program, named by PLIANT_PROGRAM or built in this checkout; the test is skipped without it."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    named = [Path(os.environ["PLIANT_PROGRAM"])] if "PLIANT_PROGRAM" in os.environ else []
    for program in [*named, *(target / profile / "pliant" for profile in ("release", "debug"))]:
        if program.is_file():
            return program
    pytest.skip(f"no program in {target}; `cargo build --release -p pliant` builds it")


@dataclass
class Script:
    """A hand step by step: where it is at the end of each step (m), how it is turned (rotation vector, degrees) and its buttons, and undos and redos before steps."""

    dt: float
    places: list[np.ndarray] = field(default_factory=list)
    turns: list[np.ndarray] = field(default_factory=list)
    buttons: list[int] = field(default_factory=list)
    # Steps taken before, and "undo" or "redo".
    history: list[tuple[int, str]] = field(default_factory=list)

    @property
    def steps(self) -> int:
        """Number of steps so far."""
        return len(self.places)

    def go(self, places, buttons=0, turn=(0.0, 0.0, 0.0)) -> None:
        """Go through places, one a step."""
        self.places += [np.asarray(place, dtype=np.float64) for place in places]
        self.turns += [np.asarray(turn, dtype=np.float64)] * len(places)
        self.buttons += [buttons] * len(places)

    def step_back(self, kind: str, rest: int = 40) -> None:
        """Undo or redo, and let the body rest where the hand is."""
        self.history.append((self.steps, kind))
        self.go([self.places[-1]] * rest)

    def steer(self, scene: pliant.Scene, steps: int) -> dict:
        """The settings of a scene by which the program does the same up to a step."""
        dt, path, turns, buttons = self.dt, [], [], []
        for step, (place, turn) in enumerate(zip(self.places[:steps], self.turns, strict=False), start=1):
            # Twice the same place around the end of the step: between both no interpolation rounds it.
            path += [[(step + at) * dt, *place.tolist()] for at in (-0.25, 0.25)]
            turns += [[(step + at) * dt, *turn.tolist()] for at in (-0.25, 0.25)]
            buttons.append([(step - 0.5) * dt, self.buttons[step - 1]])
        data = scene.to_dict()
        data["device"][0]["params"] |= {"path": path, "rotation": turns, "buttons": buttons}
        data["time"]["duration"] = steps * dt
        data["edit"] += [{"kind": kind, "start": (before - 0.5) * dt} for before, kind in self.history if before < steps]
        return data


def run_program(scene: pliant.Scene, script: Script, steps: int, folder: Path) -> Path:
    """What the program leaves of a body after some steps of a script."""
    # In Blender the package comes with the extension, after tests have been collected.
    import pliant

    given = pliant.Scene(script.steer(scene, steps))
    given._meshes = scene._meshes
    file, out = folder / f"scene{steps}.toml", folder / f"out{steps}"
    given.save(file)
    plugins = Path(pliant.__file__).parent / "plugins"
    environment = os.environ | {"PLIANT_PLUGIN_PATH": str(plugins)}
    command = [find_program(), "run", file, "--out", out, "-q"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out / "final.obj"


def vertices_of(path: Path) -> np.ndarray:
    """Vertices of an OBJ file (n x 3), in its units."""
    rows = [line.split()[1:4] for line in path.read_text().splitlines() if line.startswith("v ")]
    return np.array(rows, dtype=np.float64)
