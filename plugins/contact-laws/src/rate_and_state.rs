//! Rate-and-state friction: `mu = mu0 + a ln(v/v0) + b ln(v0 theta/Dc)` with the ageing law `dtheta/dt = 1 - v theta/Dc` (Dieterich 1979, Ruina 1983).
//!
//! The logarithm of the speed is regularised at rest as a thermally activated process says (Rice, Lapusta and Ranjith 2001):
//! `mu = a asinh(v/(2 v0) exp((mu0 + b psi)/a))` with `psi = ln(v0 theta/Dc)`, which is the history of a point: zero, where a contact begins, is
//! the steady state at the speed v0.

use crate::normal::{DISSIPATION, EXPONENT, Normal, STIFFNESS};
use pliant_plugin_api::{ContactLaw, ContactPoint, Fault, Info, Param, Params, PointTraction};

/// Rate-and-state friction on a layer of Hunt and Crossley.
pub struct RateAndState {
    normal: Normal,
    /// Coefficient of steady friction at the reference speed, mu0.
    friction: f64,
    /// Direct effect a: friction rises by a with the logarithm of the speed.
    direct: f64,
    /// Evolution effect b: friction rises by b with the logarithm of the state.
    evolution: f64,
    /// Slip over which the state evolves, Dc, m.
    distance: f64,
    /// Reference speed v0, m/s.
    reference: f64,
}

/// Argument of asinh, as a logarithm, from which on it is a logarithm to the last bit.
const LARGE: f64 = 20.0;
/// Largest exponent in the slope of friction at rest, which is not reached by anything that moves.
const MOST_EXPONENT: f64 = 500.0;

impl ContactLaw for RateAndState {
    const INFO: Info = Info {
        id: c"rate-and-state",
        name: c"Rate-and-state friction",
        version: c"0.1.0",
        summary: c"friction of the speed of slip and of its past, ageing law, on a Hunt-Crossley layer (Dieterich 1979, Ruina 1983)",
        params: &[
            STIFFNESS,
            EXPONENT,
            DISSIPATION,
            Param::number(c"friction", c"1", 0.01..=2.0, 0.6, c"mu0: coefficient of steady friction at the reference speed"),
            Param::number(c"a", c"1", 1e-3..=1.0, 0.01, c"direct effect: friction rises by a with the logarithm of the speed"),
            Param::number(
                c"b",
                c"1",
                0.0..=1.0,
                0.015,
                c"evolution effect: friction rises by b with the logarithm of the state; above a, faster slip has less steady friction",
            ),
            Param::number(c"slip-distance", c"m", 1e-9..=1.0, 1e-5, c"Dc: slip over which the state evolves"),
            Param::number(c"reference-speed", c"m/s", 1e-12..=1.0, 1e-6, c"v0: speed at which steady friction is mu0"),
        ],
    };
    const HISTORY: usize = 1;

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        Ok(Self {
            normal: Normal::new(params),
            friction: params.number("friction"),
            direct: params.number("a"),
            evolution: params.number("b"),
            distance: params.number("slip-distance"),
            reference: params.number("reference-speed"),
        })
    }

    fn traction(&self, point: &ContactPoint, history: &[f64]) -> Result<PointTraction, Fault> {
        let normal = self.normal.traction(point);
        if normal.normal == 0.0 {
            return Ok(normal);
        }
        let [u, v] = point.slip_rate;
        let speed = (u * u + v * v).sqrt();
        let exponent = (self.friction + self.evolution * history[0]) / self.direct;
        let scale = self.direct * normal.normal;
        if speed == 0.0 {
            let slope = -scale * libm::exp(exponent.min(MOST_EXPONENT)) / (2.0 * self.reference);
            return Ok(PointTraction { tangential_by_slip_rate: [[slope, 0.0], [0.0, slope]], ..normal });
        }
        // The argument of asinh as a logarithm, for it may be larger than a number can be.
        let log = libm::log(speed / (2.0 * self.reference)) + exponent;
        let (value, slope) = if log > LARGE {
            (log + std::f64::consts::LN_2, 1.0 / speed)
        } else {
            let argument = libm::exp(log);
            (libm::asinh(argument), argument / (speed * (1.0 + argument * argument).sqrt()))
        };
        let (along, direction) = (scale * value, [u / speed, v / speed]);
        let across = along / speed;
        let by_rate = |i: usize, j: usize| {
            let projector = direction[i] * direction[j];
            let identity = if i == j { 1.0 } else { 0.0 };
            -scale * slope * projector - across * (identity - projector)
        };
        Ok(PointTraction {
            tangential: direction.map(|d| -along * d),
            tangential_by_slip_rate: [[by_rate(0, 0), by_rate(0, 1)], [by_rate(1, 0), by_rate(1, 1)]],
            ..normal
        })
    }

    /// The ageing law at the speed of the step's end, solved exactly over the step.
    fn advance(&self, point: &ContactPoint, history: &mut [f64]) -> Result<(), Fault> {
        let [u, v] = point.slip_rate;
        let slip = (u * u + v * v).sqrt() * point.dt / self.distance;
        let rested = self.reference * point.dt / self.distance;
        // (1 - exp(-slip)) / slip, which is 1 at rest.
        let share = if slip > 0.0 { -libm::expm1(-slip) / slip } else { 1.0 };
        history[0] = libm::log(libm::exp(history[0] - slip) + rested * share);
        Ok(())
    }
}
