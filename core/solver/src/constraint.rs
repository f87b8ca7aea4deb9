//! Kinematic constraints of nodes.

use super::algebra::{Block, Vec3, symmetric_inverse};
use nalgebra::Matrix3;

/// The directions a node is free to move in; its velocity in the others is prescribed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Constraint {
    /// Free in all directions.
    #[default]
    Free,
    /// Free in no direction (Dirichlet).
    Fixed,
    /// Free in the plane with this unit normal.
    Plane(Vec3),
    /// Free along this unit vector.
    Line(Vec3),
}

impl Constraint {
    /// `S u`: the part of u in the free directions.
    #[inline(always)]
    pub fn filter(&self, u: Vec3) -> Vec3 {
        match self {
            Self::Free => u,
            Self::Fixed => Vec3::zeros(),
            Self::Plane(n) => u - u.dot(n) * *n,
            Self::Line(t) => u.dot(t) * *t,
        }
    }

    /// `S u + (I - S) z`: u in the free directions, z in the others.
    #[inline(always)]
    pub fn merge(&self, u: Vec3, z: Vec3) -> Vec3 {
        match self {
            Self::Free => u,
            Self::Fixed => z,
            Self::Plane(n) => u + (z - u).dot(n) * *n,
            Self::Line(t) => z + (u - z).dot(t) * *t,
        }
    }

    /// Whether the node is free in all directions.
    #[inline(always)]
    pub fn is_free(&self) -> bool {
        matches!(self, Self::Free)
    }
}

/// `S (S A S + I - S)^-1 S`: the inverse of a diagonal block on the free directions, zero on the others. A singular block is replaced by
/// the identity.
pub fn constrained_inverse(block: &Block, constraint: &Constraint) -> Block {
    match constraint {
        Constraint::Fixed => return [0.0; 9],
        Constraint::Free => {
            if let Some(inverse) = symmetric_inverse(block) {
                return inverse;
            }
        }
        Constraint::Plane(_) | Constraint::Line(_) => {}
    }
    let filter = |m: Matrix3<f64>| {
        Matrix3::from_columns(&[0, 1, 2].map(|c| {
            let column = m.column(c);
            constraint.filter(Vec3::new(column[0], column[1], column[2]))
        }))
    };
    let a = Matrix3::from_row_slice(block);
    let s = filter(Matrix3::identity());
    let inner = s * a * s + Matrix3::identity() - s;
    let inverse = inner.try_inverse().unwrap_or_else(Matrix3::identity);
    let out = s * inverse * s;
    std::array::from_fn(|e| out[(e / 3, e % 3)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filter_and_merge_are_projections() {
        let n = Vec3::new(0.6, 0.0, 0.8);
        for constraint in [Constraint::Free, Constraint::Fixed, Constraint::Plane(n), Constraint::Line(n)] {
            let (u, z) = (Vec3::new(1.0, -2.0, 3.0), Vec3::new(0.5, 0.25, -4.0));
            let free = constraint.filter(u);
            let twice = constraint.filter(free);
            let merged = constraint.merge(u, z);
            for c in 0..3 {
                assert!((free[c] - twice[c]).abs() < 1e-15);
                assert!((merged[c] - (free[c] + z[c] - constraint.filter(z)[c])).abs() < 1e-14, "{constraint:?}");
            }
        }
        assert_eq!(Constraint::Plane(Vec3::x()).filter(Vec3::new(3.0, 4.0, 5.0)), Vec3::new(0.0, 4.0, 5.0));
        assert_eq!(Constraint::Line(Vec3::x()).filter(Vec3::new(3.0, 4.0, 5.0)), Vec3::new(3.0, 0.0, 0.0));
    }
}
