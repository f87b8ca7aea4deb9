//! Plastic flow: `F = Fe Fp`, and the energy is one of Fe alone (Lee 1969; Simo 1992).
//!
//! An element yields where its equivalent strain `q = sqrt(3/2) |dev ln Ue| / (1 + nu)`, the axial strain of a bar of the same von Mises
//! stress at small strains, exceeds `yield + hardening a`, with `a` the plastic strain accumulated so far. The flow is along `dev ln Ue`, so
//! it keeps the volume, and the return is radial and in closed form (Simo 1992). With a flow time it takes a step's share of the way, the
//! implicit step of Perzyna's (1966) overstress law. The stress of an isotropic law has the order of the strains, so its product
//! with the flow is never negative: flow takes elastic energy away.
//!
//! The host updates the history once after a step, so within a step forces are the gradient of an energy.

use pliant_plugin_api::lanes::Vec3;
use pliant_plugin_api::solids::matrix::{
    cofactors, determinant, norm_squared, product, product_transposed, transposed,
};
use pliant_plugin_api::solids::{Eigen, Mat3, symmetric_eigen};

/// Doubles of history per element: the inverse of Fp less the identity by rows, then the accumulated plastic strain.
pub(crate) const HISTORY: usize = 10;
/// Norm of Fp or of its inverse at which flow ends: an element that was drawn out tenfold is about as ill-shaped as the host allows one
/// at rest to be.
const MAX_STRETCH: f64 = 10.0;
/// Squared stretch below which an element counts as flat. It has no logarithmic strain, and does not flow.
const FLAT: f64 = 1e-8;

/// Yield condition and flow rule of a material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plasticity {
    /// Equivalent strain at which flow begins.
    yield_strain: f64,
    /// Increase of it per plastic strain.
    hardening: f64,
    /// Time in which strain beyond yield decays to 1/e at fixed deformation, s.
    flow_time: f64,
    /// Poisson's ratio.
    poisson: f64,
    /// Square of `|C - I|`, C the elastic right Cauchy-Green tensor, up to which nothing yields.
    certainly_elastic: f64,
}

/// The plastic state of an element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlasticState {
    /// Inverse of the plastic deformation gradient, `Fp^-1`.
    pub(crate) inverse: Mat3,
    /// Accumulated plastic strain.
    pub(crate) accumulated: f64,
}

impl Plasticity {
    /// The law with these constants: yield strain and hardening (1), flow time (s), Poisson's ratio.
    pub(crate) fn new(yield_strain: f64, hardening: f64, flow_time: f64, poisson: f64) -> Self {
        // With x = |C - I| < 1, |ln Ue| <= x / (2 (1 - x)).
        let bound = 2.0 * (1.0 + poisson) / 1.5_f64.sqrt() * yield_strain;
        let certainly_elastic = (bound / (1.0 + bound)).powi(2);
        Self { yield_strain, hardening, flow_time, poisson, certainly_elastic }
    }

    /// Square of `|Fe^T Fe - I|` up to which nothing yields.
    pub(crate) fn certainly_elastic(&self) -> f64 {
        self.certainly_elastic
    }

    /// The state after a step of `dt` (s) that ended with the elastic deformation gradient `fe`; `None` where nothing flows.
    pub(crate) fn flow(&self, fe: &Mat3, state: &PlasticState, dt: f64) -> Option<PlasticState> {
        let columns = transposed(fe);
        let Eigen { values, vectors } = symmetric_eigen(product_transposed(&columns, &columns));
        let is_flat = values.0.iter().any(|v| v.is_nan() || *v < FLAT) || determinant(fe) <= 0.0;
        if is_flat {
            return None;
        }
        let strain = values.0.map(|v| 0.5 * libm::log(v));
        let mean = (strain[0] + strain[1] + strain[2]) / 3.0;
        let deviator = strain.map(|e| e - mean);
        let norm = (deviator[0].powi(2) + deviator[1].powi(2) + deviator[2].powi(2)).sqrt();
        let root = 1.5_f64.sqrt();
        let excess = root * norm / (1.0 + self.poisson) - (self.yield_strain + self.hardening * state.accumulated);
        if excess <= 0.0 {
            return None;
        }
        let share = if self.flow_time > 0.0 { dt / (dt + self.flow_time) } else { 1.0 };
        let step = share * excess / (1.5 / (1.0 + self.poisson) + self.hardening);
        let back = deviator.map(|d| libm::exp(-root * step / norm * d));
        let scaled = vectors.map(|row| Vec3([row[0] * back[0], row[1] * back[1], row[2] * back[2]]));
        let mut inverse = product(&state.inverse, &product_transposed(&scaled, &vectors));
        // Keeps the determinant at 1 against rounding, over any number of steps.
        let volume = determinant(&inverse);
        inverse = inverse.map(|row| row * (1.0 - (volume - 1.0) / 3.0));
        let is_drawn_out = norm_squared(&inverse).max(norm_squared(&cofactors(&inverse))) > MAX_STRETCH * MAX_STRETCH;
        (!is_drawn_out).then_some(PlasticState { inverse, accumulated: state.accumulated + step })
    }
}

impl PlasticState {
    /// The state with an element's history.
    pub(crate) fn new(history: [f64; HISTORY]) -> Self {
        let row = |i: usize| {
            let one = |j: usize| if i == j { 1.0 } else { 0.0 };
            Vec3([0, 1, 2].map(|j| one(j) + history[3 * i + j]))
        };
        Self { inverse: [row(0), row(1), row(2)], accumulated: history[9] }
    }

    /// The history of an element in this state.
    pub(crate) fn history(&self) -> [f64; HISTORY] {
        std::array::from_fn(|s| match (s / 3, s % 3) {
            (3, _) => self.accumulated,
            (i, j) if i == j => self.inverse[i][j] - 1.0,
            (i, j) => self.inverse[i][j],
        })
    }
}
