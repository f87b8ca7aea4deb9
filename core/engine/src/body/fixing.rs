//! Fixings: nodes that are held or driven along a path (Dirichlet conditions).

use super::cell_corners::CellCorners;
use pliant_solver::Vec3;
use std::collections::HashSet;

/// A set of nodes, by rest position or number.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// Nodes within an axis-aligned box, faces included.
    Box {
        /// Corner with the least coordinates, m.
        min: Vec3,
        /// Corner with the greatest coordinates, m.
        max: Vec3,
    },
    /// Nodes within a ball.
    Ball {
        /// Centre of the ball in the scene, m.
        centre: Vec3,
        /// Radius of the ball, m.
        radius: f64,
    },
    /// Nodes with these numbers; for a sheet, numbers of vertices in the file.
    Nodes(Vec<u32>),
    /// Vertices of a sheet, or nodes of a tetrahedral mesh, by their numbers.
    Vertices(HashSet<u32>),
    /// Corners of the cells of a lattice that faces go through.
    Cells(CellCorners),
}

impl Place {
    /// Whether the set contains the node with this number and rest position (m).
    pub fn contains(&self, node: u32, rest: Vec3) -> bool {
        match self {
            Self::Box { min, max } => (0..3).all(|i| min[i] <= rest[i] && rest[i] <= max[i]),
            Self::Ball { centre, radius } => {
                (0..3).map(|i| (rest[i] - centre[i]).powi(2)).sum::<f64>() <= radius * radius
            }
            Self::Nodes(list) => list.contains(&node),
            Self::Vertices(all) => all.contains(&node),
            Self::Cells(corners) => corners.holds(rest),
        }
    }
}

/// A Dirichlet condition: nodes held at their rest positions, or driven along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixing {
    /// The nodes that are held.
    pub place: Place,
    /// Edges on the border of a sheet whose ends are both held keep the direction they have at rest.
    pub clamp: bool,
    /// Times (s, ascending) and displacements from rest (m); linear between, constant outside. Empty where the nodes are held.
    pub path: Vec<(f64, Vec3)>,
}

/// Displacement (m) at a time (s) along a path of times (s, ascending) and displacements (m): linear between, constant outside.
pub fn displacement_along(path: &[(f64, Vec3)], time: f64) -> Vec3 {
    let after = path.partition_point(|(t, _)| *t <= time);
    match (after.checked_sub(1).map(|i| path[i]), path.get(after)) {
        (None, None) => Vec3::zeros(),
        (Some((_, d)), None) | (None, Some(&(_, d))) => d,
        (Some((t0, d0)), Some(&(t1, d1))) => {
            let s = (time - t0) / (t1 - t0);
            d0 + s * (d1 - d0)
        }
    }
}

impl Fixing {
    /// Displacement from rest at a time (s), m.
    pub fn displacement(&self, time: f64) -> Vec3 {
        displacement_along(&self.path, time)
    }

    /// Whether the path has a displacement other than zero.
    pub fn moves(&self) -> bool {
        self.path.iter().any(|(_, d)| *d != Vec3::zeros())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacement_is_linear_between_and_constant_outside() {
        let x = |d| Vec3::new(d, 0.0, 0.0);
        let fixing = Fixing {
            place: Place::Nodes(vec![3]),
            clamp: false,
            path: vec![(1.0, x(0.0)), (2.0, x(4.0)), (3.0, x(2.0))],
        };
        for (t, d) in [(0.0, 0.0), (1.0, 0.0), (1.5, 2.0), (2.0, 4.0), (2.5, 3.0), (9.0, 2.0)] {
            assert_eq!(fixing.displacement(t), x(d), "{t}");
        }
        assert!(fixing.moves() && fixing.place.contains(3, Vec3::zeros()) && !fixing.place.contains(2, Vec3::zeros()));
    }
}
