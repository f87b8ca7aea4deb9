"""A sweep: the force of a touch over stiffness, as a plot.

The finger of a scene presses an elephant of several stiffnesses. Runs go on threads at once: the interpreter's lock is released while steps are
taken.
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import pliant

SCENE = Path(__file__).resolve().parents[2] / "scenes" / "touch.toml"


def sweep(stiffnesses: list[float]) -> list[pliant.Result]:
    """Run the touch with each Young's modulus (Pa)."""

    def run(young: float) -> pliant.Result:
        return pliant.run(SCENE, set={"body.0.material.params.young": young, "output.energy": False}, threads=1)

    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(run, stiffnesses))


def plot(stiffnesses: list[float], results: list[pliant.Result], path: Path) -> None:
    """Draw the force of each run over time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    for young, result in zip(stiffnesses, results, strict=True):
        force = np.linalg.norm(result.tools["finger"].force, axis=1)
        axes.plot(result.trace.time, force, label=f"{young / 1e3:g} kPa")
    axes.set(xlabel="time (s)", ylabel="force (N)", title="A finger on the flank of an elephant")
    axes.legend(title="Young's modulus")
    figure.savefig(path, dpi=120)


def main(path: Path = Path("sweep.png")) -> tuple[list[float], list[float]]:
    """Sweep, plot into `path`; give the moduli (Pa) and the largest forces (N)."""
    stiffnesses = [5e3, 10e3, 20e3, 40e3]
    results = sweep(stiffnesses)
    plot(stiffnesses, results, path)
    largest = [result.probes["largest force"].value for result in results]
    for young, force in zip(stiffnesses, largest, strict=True):
        print(f"{young / 1e3:5g} kPa: {force:.4f} N at most")
    print(f"plot in {path}")
    return stiffnesses, largest


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("sweep.png"))
