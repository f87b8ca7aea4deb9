"""What is it made of? Young's modulus from a measured indentation, by scipy.optimize.

A finger has pressed a block and its force was noted at some depths. The simulation does the same with other moduli, and a least-squares fit finds
the one whose forces are nearest. The "measurement" here is simulated with noise, so the true value is known.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

import pliant

RADIUS = 0.01  # m
EDGE = 0.08  # m


def forces(young: float, depths: np.ndarray) -> np.ndarray:
    """Press a block of `young` (Pa) to each of `depths` (m, of the hand), and give the forces when it is at rest, N."""
    scene = pliant.Scene()
    scene.time(dt="5 ms", integrator="backward-euler")
    material = pliant.Material("neo-hookean", young=young, poisson=0.4, density=1000, damping_time="20 ms")
    shape = {"kind": "box", "cells": 8, "size": [EDGE, EDGE, EDGE]}
    low = [[-EDGE, -EDGE, -0.51 * EDGE], [EDGE, EDGE, -0.49 * EDGE]]
    scene.body("block", shape=shape, material=material, grid={"level": 3, "region": "whole"}, fixed=[{"box": low}])
    scene.hand("hand", peak_force=100, stiffness=1e5)
    scene.tool("finger", radius=RADIUS, stiffness=2000)
    scene.edit("touch", tool="finger")
    scene.output(energy=False)
    with pliant.Session(scene, threads=1) as session:
        hand, felt = session.hand("finger"), []
        for depth in depths:
            hand.go([0.0, 0.0, EDGE / 2 + RADIUS - depth])
            session.step(20)
            felt.append(session.force("finger")[2])
    return np.array(felt)


def estimate(depths: np.ndarray, measured: np.ndarray) -> tuple[float, int]:
    """Give the modulus (Pa) whose forces fit the measured ones best, and how often the block was pressed for it."""
    # The logarithm keeps it positive and makes a factor of two the same step everywhere.
    fit = least_squares(lambda x: forces(np.exp(x[0]), depths) - measured, [np.log(10e3)], diff_step=1e-3, xtol=1e-4)
    return float(np.exp(fit.x[0])), fit.nfev


def main(true: float = 32e3) -> tuple[float, float]:
    """Estimate a modulus from a noisy measurement; give the true and the estimated one, Pa."""
    depths = np.array([1e-3, 2e-3, 3e-3, 4e-3])
    rng = np.random.default_rng(1)
    measured = forces(true, depths)
    measured *= 1 + 0.01 * rng.normal(size=depths.size)
    found, runs = estimate(depths, measured)
    print(f"true {true / 1e3:.2f} kPa, estimated {found / 1e3:.2f} kPa after {runs} evaluations")
    return true, found


if __name__ == "__main__":
    main()
