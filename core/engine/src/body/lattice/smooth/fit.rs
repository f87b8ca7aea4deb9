//! Weighted least-squares fit of a trilinear function to the displacements around a node.

/// Coefficients of the displacements at the 27 positions around a node (x fastest) in the value and derivatives at the node (27 x 8).
pub(in super::super) type Fit = [[f64; 8]; 27];

/// Weights along one axis of the displacements one cell before, at and one cell after a node: the quadratic B-spline.
const SPLINE: [f64; 3] = [0.125, 0.75, 0.125];

/// Share of the fit in the value at a node; the rest is the node's own displacement. With one half, the weights of a point have the same mean
/// square as trilinear ones (2/3 along an axis), so a touch is equally stiff; with 1 it would be 5 % stiffer at three cells across a contact.
const SMOOTHING: f64 = 0.5;
/// Index of the node itself among the 27 positions around it.
const CENTRE: usize = 13;

/// Fits for each set of existing cells around a node, computed on first use.
#[derive(Default)]
pub(in super::super) struct Fits {
    by_cells: Vec<Option<Box<Fit>>>,
}

impl Fits {
    /// Computes the fit for a node with the given cells around it: bit k stands for the cell of which the node is corner k.
    pub fn prepare(&mut self, cells: u8) {
        self.by_cells.resize_with(256, || None);
        self.by_cells[usize::from(cells)].get_or_insert_with(|| Box::new(fit(cells)));
    }

    /// The fit for these cells, which [`Fits::prepare`] has computed.
    pub fn get(&self, cells: u8) -> &Fit {
        self.by_cells[usize::from(cells)].as_deref().expect("prepared with the adjacency")
    }
}

/// Index of corner `other` of a cell among the 27 positions around its corner `node`.
pub(super) fn position(node: usize, other: usize) -> usize {
    let along = |axis: usize| 1 + (other >> axis & 1) - (node >> axis & 1);
    along(0) + 3 * along(1) + 9 * along(2)
}

/// Weighted least squares by the normal equations. A single cell suffices to determine the eight terms.
fn fit(cells: u8) -> Fit {
    let mut has_node = [false; 27];
    for node in (0..8).filter(|node| cells >> node & 1 == 1) {
        (0..8).for_each(|other| has_node[position(node, other)] = true);
    }
    let mut normal = [[0.0; 8]; 8];
    let mut right = [[0.0; 27]; 8];
    for at in (0..27).filter(|at| has_node[*at]) {
        let index = [at % 3, at / 3 % 3, at / 9];
        let weight = index.iter().map(|i| SPLINE[*i]).product::<f64>();
        let terms = terms(index.map(|i| i as f64 - 1.0));
        for i in 0..8 {
            right[i][at] = weight * terms[i];
            for j in 0..8 {
                normal[i][j] += weight * terms[i] * terms[j];
            }
        }
    }
    eliminate(&mut normal, &mut right);
    let mut fit: Fit = std::array::from_fn(|at| std::array::from_fn(|term| right[term][at]));
    fit.iter_mut().for_each(|coefficients| coefficients[0] *= SMOOTHING);
    fit[CENTRE][0] += 1.0 - SMOOTHING;
    fit
}

/// The terms 1, x, y, xy, z, xz, yz, xyz of a trilinear function.
fn terms([x, y, z]: [f64; 3]) -> [f64; 8] {
    [1.0, x, y, x * y, z, x * z, y * z, x * y * z]
}

/// Solves for all right-hand sides by Gauss-Jordan elimination; the matrix is positive definite, so no pivoting is needed.
fn eliminate(matrix: &mut [[f64; 8]; 8], right: &mut [[f64; 27]; 8]) {
    for pivot in 0..8 {
        let inverse = 1.0 / matrix[pivot][pivot];
        matrix[pivot].iter_mut().for_each(|a| *a *= inverse);
        right[pivot].iter_mut().for_each(|b| *b *= inverse);
        let (row, by) = (matrix[pivot], right[pivot]);
        for other in (0..8).filter(|other| *other != pivot) {
            let factor = matrix[other][pivot];
            matrix[other].iter_mut().zip(&row).for_each(|(a, b)| *a -= factor * b);
            right[other].iter_mut().zip(&by).for_each(|(a, b)| *a -= factor * b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_of_cells_reproduces_trilinear_functions() {
        for cells in 1..=255_u8 {
            let fit = fit(cells);
            for term in 0..8 {
                let mut found = [0.0; 8];
                for at in 0..27 {
                    let value = terms([at % 3, at / 3 % 3, at / 9].map(|i| i as f64 - 1.0))[term];
                    (0..8).for_each(|d| found[d] += fit[at][d] * value);
                }
                for (d, found) in found.into_iter().enumerate() {
                    let wanted = if d == term { 1.0 } else { 0.0 };
                    assert!((found - wanted).abs() < 1e-12, "cells {cells:08b}, term {term}: {d} is {found}");
                }
            }
        }
    }

    #[test]
    fn inside_of_a_body_slopes_are_those_of_the_quadratic_spline_and_values_half_smoothed() {
        let (fit, slope) = (fit(255), [-0.5, 0.0, 0.5]);
        for at in 0..27 {
            let index = [at % 3, at / 3 % 3, at / 9];
            let mut spline: [f64; 8] = std::array::from_fn(|d| {
                (0..3).map(|axis| if d >> axis & 1 == 1 { slope[index[axis]] } else { SPLINE[index[axis]] }).product()
            });
            spline[0] = 0.5 * spline[0] + if at == CENTRE { 0.5 } else { 0.0 };
            (0..8).for_each(|d| assert!((fit[at][d] - spline[d]).abs() < 1e-14, "{at} {d}"));
        }
    }
}
