"""What a step costs from Python beside what it costs the program, on the same scene: alternating runs, so that a busy machine is busy for both.

    python python/benches/against_program.py PROGRAM [MODEL.obj] [RUNS]
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import pliant

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "touch.toml"
SETTINGS = {"output.energy": "false"}


def of_program(program: str, mesh: list[str]) -> tuple[float, float]:
    """s, the median step that the program tells, and the mean of its whole loop, with what it writes."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", str(SCENE), "--threads", "1", "-q", "--out", f"{folder}/out"]
        command += [part for key, value in SETTINGS.items() for part in ("--set", f"{key}={value}")]
        command += [part for path in mesh for part in ("--mesh", path)]
        plugins = str(Path(pliant.__file__).parent / "plugins")
        subprocess.run(command, check=True, env=os.environ | {"PLIANT_PLUGIN_PATH": plugins})
        summary = json.loads(Path(folder, "out", "summary.json").read_text())
    return summary["step_seconds"]["p50"], (summary["wall_seconds"] - summary["open_seconds"]) / summary["steps"]


def of_python(mesh: list[str]) -> tuple[float, float]:
    """s, the median and the mean of a step called from Python."""
    with pliant.Session(SCENE, mesh=mesh[0] if mesh else None, set={"output.energy": False}, threads=1) as session:
        seconds = []
        for _ in range(session.planned_steps):
            began = time.perf_counter()
            session.step()
            seconds.append(time.perf_counter() - began)
    return float(np.median(seconds)), float(np.mean(seconds))


def main(program: str, mesh: list[str], runs: int) -> None:
    """Print ratios of Python to the program: of median steps and of whole loops."""
    rows = []
    for run in range(runs):
        both = [lambda: of_program(program, mesh), lambda: of_python(mesh)]
        first, second = (both[0](), both[1]()) if run % 2 == 0 else (both[1](), both[0]())[::-1]
        rows.append([*first, *second])
    program_median, program_mean, python_median, python_mean = np.array(rows).T
    for what, ours, theirs in (("median step", python_median, program_median), ("mean step", python_mean, program_mean)):
        ratio = ours / theirs
        print(f"{what}: {1e6 * ours.min():.1f} us from Python and {1e6 * theirs.min():.1f} us in the program at least,", end=" ")
        print(f"ratio of the least {ours.min() / theirs.min():.4f}, of {runs} pairs median {np.median(ratio):.4f}, {ratio.min():.4f} to {ratio.max():.4f}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:3], int(sys.argv[3]) if len(sys.argv) > 3 else 7)
