//! The normal traction of Hunt and Crossley (1975): `p = k d^n (1 + 3/2 c d')`, with the depth d of the overlap. It never attracts.

use pliant_plugin_api::{ContactPoint, Param, Params, PointTraction};

/// Parameters of the normal traction.
pub struct Normal {
    /// Traction at an overlap of 1 m, Pa/m^n.
    stiffness: f64,
    /// Exponent n of the depth.
    exponent: f64,
    /// Dissipation c, s/m.
    dissipation: f64,
}

/// Declaration of `stiffness`.
pub const STIFFNESS: Param =
    Param::number(c"stiffness", c"Pa/m^n", 1.0..=1e20, 1e7, c"normal traction over the n-th power of the overlap");
/// Declaration of `exponent`.
pub const EXPONENT: Param =
    Param::number(c"exponent", c"1", 1.0..=3.0, 1.0, c"exponent n of the overlap; 1: a layer of springs (Winkler)");
/// Declaration of `dissipation`.
pub const DISSIPATION: Param = Param::number(
    c"dissipation",
    c"s/m",
    0.0..=1e3,
    0.5,
    c"c in k d^n (1 + 3/2 c d'): two surfaces that meet slowly at speed v part at about (1 - c v) v",
);

impl Normal {
    /// Reads the parameters that are declared in this module.
    pub fn new(params: &Params<'_>) -> Self {
        Self {
            stiffness: params.number("stiffness"),
            exponent: params.number("exponent"),
            dissipation: params.number("dissipation"),
        }
    }

    /// Normal traction and its derivatives; nothing where the surfaces are apart.
    pub fn traction(&self, point: &ContactPoint) -> PointTraction {
        // NaN goes on, so that the host sees it.
        if point.gap >= 0.0 {
            return PointTraction::default();
        }
        let depth = -point.gap;
        let slope = self.stiffness * libm::pow(depth, self.exponent - 1.0);
        let elastic = slope * depth;
        let factor = 1.0 - 1.5 * self.dissipation * point.gap_rate;
        if factor <= 0.0 {
            // The surfaces part faster than the layer springs back.
            return PointTraction::default();
        }
        PointTraction {
            normal: elastic * factor,
            normal_by_gap: -self.exponent * slope * factor,
            normal_by_gap_rate: -1.5 * self.dissipation * elastic,
            ..PointTraction::default()
        }
    }
}
