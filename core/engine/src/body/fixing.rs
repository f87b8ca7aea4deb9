//! Nodes that are held, and nodes that are led.

use super::cell_corners::CellCorners;
use pliant_solver::Vec3;
use std::collections::HashSet;

/// Which nodes, by where they rest.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// Within a box, m, faces included.
    Box {
        /// Least corner.
        min: Vec3,
        /// Greatest corner.
        max: Vec3,
    },
    /// Within a ball, m.
    Ball {
        /// Centre.
        centre: Vec3,
        /// Radius.
        radius: f64,
    },
    /// At these numbers.
    Nodes(Vec<u32>),
    /// Vertices of a sheet, by their numbers.
    Vertices(HashSet<u32>),
    /// Corners of the cells of a lattice that faces go through.
    Cells(CellCorners),
}

impl Place {
    /// Whether the node with this number and rest position is meant.
    pub fn holds(&self, node: u32, rest: Vec3) -> bool {
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

/// Nodes held where they rest, or led along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixing {
    /// The nodes that are held.
    pub place: Place,
    /// Edges on the border of a sheet whose ends are both held keep the direction they have at rest.
    pub clamp: bool,
    /// Displacement (m) at times (s), ascending; linear between, constant outside. Empty: held.
    pub path: Vec<(f64, Vec3)>,
}

impl Fixing {
    /// m, displacement at a time.
    pub fn displacement(&self, time: f64) -> Vec3 {
        let after = self.path.partition_point(|(t, _)| *t <= time);
        match (after.checked_sub(1).map(|i| self.path[i]), self.path.get(after)) {
            (None, None) => Vec3::zeros(),
            (Some((_, d)), None) | (None, Some(&(_, d))) => d,
            (Some((t0, d0)), Some(&(t1, d1))) => {
                let s = (time - t0) / (t1 - t0);
                d0 + s * (d1 - d0)
            }
        }
    }

    /// Whether it leads its nodes anywhere.
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
        assert!(fixing.moves() && fixing.place.holds(3, Vec3::zeros()) && !fixing.place.holds(2, Vec3::zeros()));
    }
}
