//! Cubic Hermite interpolation in a cell.

use super::CellJets;
use pliant_solver::Vec3;

/// Weights of the jets of a cell's corners at a point of the cell: corner by corner, eight derivatives each.
pub(in super::super) type Weights = [f64; 64];

/// Coordinates in a cell, 0 to 1, from the trilinear weights of its corners.
pub(in super::super) fn local(trilinear: &[f64; 8]) -> [f64; 3] {
    [0, 1, 2].map(|axis| (0..8).filter(|corner| corner >> axis & 1 == 1).map(|corner| trilinear[corner]).sum())
}

/// Hermite weights at a point of a cell, from the trilinear weights of its corners there.
pub(in super::super) fn weights(trilinear: &[f64; 8]) -> Weights {
    // Along an axis: value and slope at the near end, value and slope at the far end.
    let [x, y, z] = local(trilinear).map(|t| {
        let (t2, t3) = (t * t, t * t * t);
        [1.0 - 3.0 * t2 + 2.0 * t3, t - 2.0 * t2 + t3, 3.0 * t2 - 2.0 * t3, t3 - t2]
    });
    let mut out = [0.0; 64];
    for corner in 0..8 {
        let (x, y, z) = (&x[2 * (corner & 1)..], &y[2 * (corner >> 1 & 1)..], &z[2 * (corner >> 2)..]);
        for d in 0..8 {
            out[8 * corner + d] = x[d & 1] * y[d >> 1 & 1] * z[d >> 2];
        }
    }
    out
}

/// Displacement at a point with these weights, m.
pub(in super::super) fn interpolate(weights: &Weights, jets: &CellJets) -> Vec3 {
    Vec3::from(jets.0.each_ref().map(|component| {
        // Eight sums side by side fill a vector register and are added in one order on every processor.
        let mut sums = [0.0; 8];
        for (weights, values) in weights.chunks_exact(8).zip(component.chunks_exact(8)) {
            for i in 0..8 {
                sums[i] += weights[i] * values[i];
            }
        }
        let [a, b, c, d, e, f, g, h] = sums;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }))
}
