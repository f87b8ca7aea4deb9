//! Hunt and Crossley (1975) with Coulomb friction, which is a damper below a small speed.

use crate::normal::{DISSIPATION, EXPONENT, Normal, STIFFNESS};
use pliant_plugin_api::{ContactLaw, ContactPoint, Fault, Info, Param, Params, PointTraction};

/// The law of Hunt and Crossley: surfaces that meet faster bounce less.
pub struct HuntCrossley {
    normal: Normal,
    /// Coefficient of friction.
    friction: f64,
    /// Speed below which friction is a damper, m/s.
    stick_speed: f64,
}

impl ContactLaw for HuntCrossley {
    const INFO: Info = Info {
        id: c"hunt-crossley",
        name: c"Hunt-Crossley",
        version: c"0.1.0",
        summary: c"k d^n (1 + 3/2 c d') with Coulomb friction: never attracts, and what meets faster bounces less (Hunt and Crossley 1975)",
        params: &[
            STIFFNESS,
            EXPONENT,
            DISSIPATION,
            Param::number(c"friction", c"1", 0.0..=10.0, 0.3, c"coefficient of Coulomb friction"),
            Param::number(
                c"stick-speed",
                c"m/s",
                1e-6..=1.0,
                1e-3,
                c"speed of slip at which friction is 1/sqrt(2) of Coulomb's; what sticks creeps more slowly",
            ),
        ],
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let (friction, stick_speed) = (params.number("friction"), params.number("stick-speed"));
        Ok(Self { normal: Normal::new(params), friction, stick_speed })
    }

    fn traction(&self, point: &ContactPoint, _history: &[f64]) -> Result<PointTraction, Fault> {
        let normal = self.normal.traction(point);
        let [u, v] = point.slip_rate;
        let speed = (u * u + v * v + self.stick_speed * self.stick_speed).sqrt();
        let most = self.friction * normal.normal / speed;
        let across = |a: f64, b: f64| most * a * b / (speed * speed);
        Ok(PointTraction {
            tangential: [0.0 - most * u, 0.0 - most * v],
            tangential_by_slip_rate: [[across(u, u) - most, across(u, v)], [across(v, u), across(v, v) - most]],
            ..normal
        })
    }
}
