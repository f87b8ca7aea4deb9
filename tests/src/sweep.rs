//! Cuts right through a body, without a hand.

use pliant_cut::{Blade, Stroke};
use pliant_engine::body::Body;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;

/// A blade swept across the whole body in `steps` advances, along a plane of random place and direction, or a little bent.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    at: Vec3,
    along: Vec3,
    way: Vec3,
    across: Vec3,
    bend: f64,
}

impl Sweep {
    /// One for each seed.
    pub fn random(seed: u64) -> Self {
        let random = &mut Random(seed);
        let along = random.direction();
        let d = random.direction();
        let across = along.cross(&d).normalize();
        let at = 0.02 * random.vector();
        Self { at, along, way: across.cross(&along), across, bend: 0.02 * random.signed() }
    }

    fn blade(&self, t: f64) -> Blade {
        let at = |s: f64| -> Vec3 {
            let bend = self.bend * (t * t - 0.3);
            self.at + s * self.along + 0.12 * t * self.way + bend * self.across
        };
        Blade { tip: at(-0.15), heel: at(0.15) }
    }
}

/// Cuts the body right through.
///
/// # Panics
/// If the body is not one that is cut, or cannot follow.
pub fn cut(body: &mut Body, sweep: &Sweep, steps: u32) {
    let mut stroke = Stroke::begin(sweep.blade(-1.0)).unwrap();
    for step in 1..=steps {
        let blade = sweep.blade(2.0 * f64::from(step) / f64::from(steps) - 1.0);
        let advance = body.cut.as_mut().unwrap().advance(&mut stroke, blade); // one refused is made with the next
        if let Some(advance) = advance.ok().filter(|advance| advance.has_cut()) {
            body.take_cut(&advance).unwrap();
        }
    }
    let Body { model, skin, system, discretization, fixings, .. } = body;
    discretization.follow(&[], model, fixings, skin, system).unwrap();
}
