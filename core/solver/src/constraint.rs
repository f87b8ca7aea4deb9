//! What a node may still do.

use super::algebra::{Block, V3, axpy, dot, symmetric_inverse};
use nalgebra::Matrix3;

/// The directions a node is free in. What it does in the others is prescribed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Constraint {
    /// Everything.
    #[default]
    Free,
    /// Nothing.
    Fixed,
    /// Along the plane with this unit normal.
    Plane(V3),
    /// Along this unit direction.
    Line(V3),
}

impl Constraint {
    /// `S u`: the free part.
    #[inline(always)]
    pub fn filter(&self, u: V3) -> V3 {
        match self {
            Self::Free => u,
            Self::Fixed => [0.0; 3],
            Self::Plane(n) => axpy(u, -dot(u, *n), *n),
            Self::Line(t) => t.map(|c| c * dot(u, *t)),
        }
    }

    /// `S u + (I - S) z`: the free part of one, the prescribed part of another.
    #[inline(always)]
    pub fn merge(&self, u: V3, z: V3) -> V3 {
        match self {
            Self::Free => u,
            Self::Fixed => z,
            Self::Plane(n) => axpy(u, dot(axpy(z, -1.0, u), *n), *n),
            Self::Line(t) => axpy(z, dot(axpy(u, -1.0, z), *t), *t),
        }
    }

    /// Whether anything is prescribed.
    #[inline(always)]
    pub fn is_free(&self) -> bool {
        matches!(self, Self::Free)
    }
}

/// `S (S A S + I - S)^-1 S`
pub fn constrained_inverse(block: &Block, constraint: &Constraint) -> Block {
    match constraint {
        Constraint::Fixed => return [0.0; 9],
        Constraint::Free => {
            if let Some(inverse) = symmetric_inverse(block) {
                return inverse;
            }
        }
        _ => {}
    }
    let filter = |m: Matrix3<f64>| {
        Matrix3::from_columns(&[0, 1, 2].map(|c| {
            let column = m.column(c);
            constraint.filter([column[0], column[1], column[2]]).into()
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
        let n = [0.6, 0.0, 0.8];
        for constraint in [Constraint::Free, Constraint::Fixed, Constraint::Plane(n), Constraint::Line(n)] {
            let (u, z) = ([1.0, -2.0, 3.0], [0.5, 0.25, -4.0]);
            let free = constraint.filter(u);
            let twice = constraint.filter(free);
            let merged = constraint.merge(u, z);
            for c in 0..3 {
                assert!((free[c] - twice[c]).abs() < 1e-15);
                assert!((merged[c] - (free[c] + z[c] - constraint.filter(z)[c])).abs() < 1e-14, "{constraint:?}");
            }
        }
        assert_eq!(Constraint::Plane([1.0, 0.0, 0.0]).filter([3.0, 4.0, 5.0]), [0.0, 4.0, 5.0]);
        assert_eq!(Constraint::Line([1.0, 0.0, 0.0]).filter([3.0, 4.0, 5.0]), [3.0, 0.0, 0.0]);
    }
}
