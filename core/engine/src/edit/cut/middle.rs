//! The place on a blade by which its motion through a body is told.

use crate::body::{Body, Discretization, Lattice};
use pliant_cut::Blade;
use pliant_plugin_api::abi::{Ball, Level};
use pliant_solver::Vec3;

/// The place on a blade that is nearest to the middle of a body in its rest shape. A blade may be far longer than the body is thick, and turn about a place on it that is outside, as one
/// that points to the eye of a viewer: its own midpoint may then stand still, or go back.
#[derive(Clone, Copy)]
pub struct Middle {
    /// The middle of a solid, m; `None` for a sheet, where the midpoint of the blade is taken.
    body: Option<Vec3>,
}

impl Middle {
    /// The middle of a body.
    pub fn of(body: &Body) -> Self {
        Self {
            body: match &body.discretization {
                Discretization::Lattice(lattice) => Some(ball_around(lattice).centre.into()),
                Discretization::Sheet(_) => None,
            },
        }
    }

    /// The place on a blade, m.
    pub fn on(self, blade: &Blade) -> Vec3 {
        let along = blade.heel - blade.tip;
        let share = self.body.map_or(0.5, |middle| (middle - blade.tip).dot(&along) / along.norm_squared());
        blade.tip.lerp(&blade.heel, share.clamp(0.0, 1.0))
    }

    /// Displacement of the place from one blade to another, m.
    pub fn way(self, from: &Blade, to: &Blade) -> Vec3 {
        self.on(to) - self.on(from)
    }
}

/// The ball around all cells of a lattice in its rest shape, m.
pub fn ball_around(lattice: &Lattice) -> Ball {
    let Level { origin, edge, cells_per_axis, .. } = lattice.facts;
    let half = 0.5 * edge * f64::from(cells_per_axis);
    Ball { centre: (Vec3::from(origin) + Vec3::repeat(half)).into(), radius: 3.0_f64.sqrt() * half }
}
