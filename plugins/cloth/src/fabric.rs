//! Presets of fabrics: an assumed light cloth, `none`, and fabrics with published measurements.
//!
//! Unmeasured values are `None`; the scene must give those that the sheet needs: density, shear stiffness and bending rigidities along warp and
//! weft. Poisson's ratio is 0 if unmeasured.

use core::ffi::CStr;
use pliant_plugin_api::Source;

/// One fabric, in SI units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fabric {
    /// Choice of the parameter `fabric`.
    pub(crate) name: &'static str,
    /// Mass per area, kg/m^2.
    pub(crate) density: Option<f64>,
    pub(crate) membrane: MembraneModuli,
    /// Shear stiffness, N/m.
    pub(crate) shear: Option<f64>,
    pub(crate) bending: Option<BendingRigidities>,
    /// Width of the hysteresis loop of the bending moment, 2HB, N.
    pub(crate) hysteresis: Option<f64>,
    /// Publication and table.
    pub(crate) citation: &'static CStr,
    /// Quantities that the source did not measure, and doubts about those it did.
    pub(crate) limitations: &'static CStr,
}

/// In-plane stiffness.
#[derive(Clone, Copy, Debug)]
pub(crate) enum MembraneModuli {
    /// Components of the elasticity tensor, N/m.
    Tensor { c11: f64, c12: f64, c22: f64 },
    /// Young's modulus, N/m, the same along warp and weft, and Poisson's ratio. The shear stiffness is independent of both.
    EqualModuli { young: f64, poisson: f64 },
}

/// Bending rigidity of strips cut along warp, at 45 degrees, and along weft, N m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BendingRigidities {
    pub(crate) warp: f64,
    pub(crate) bias: Option<f64>,
    pub(crate) weft: f64,
}

/// One micronewton metre in N m.
const MICRO: f64 = 1e-6;

/// A fabric of Wang et al. (2011): density, kg/m^2; [C11, C12, C22] and shear, N/m; rigidity along warp, bias and weft, uN m.
///
/// C is twice the file's values, bending rigidity a quarter of its `ke`, to match ARCSim's force law. Axis 1 of the files is taken as the
/// warp.
const fn wang_2011(name: &'static str, density: f64, c: [f64; 3], shear: f64, rigidity: [f64; 3]) -> Fabric {
    Fabric {
        name,
        density: Some(density),
        membrane: MembraneModuli::Tensor { c11: c[0], c12: c[1], c22: c[2] },
        shear: Some(shear),
        bending: Some(BendingRigidities {
            warp: rigidity[0] * MICRO,
            bias: Some(rigidity[1] * MICRO),
            weft: rigidity[2] * MICRO,
        }),
        hysteresis: None,
        citation: c"Wang, O'Brien and Ramamoorthi 2011, material files of ARCSim, row of smallest strain and curvature",
        limitations: c"thickness, friction, which axis is the warp",
    }
}

/// A denim of the KES-FB table: Young's modulus and shear, N/m; rigidity, uN m; 2HB, mN.
///
/// The table's areal masses (93.9 to 109.3 mg/cm2, about 1 kg/m^2) are too high for denim and are not used.
const fn kes_denim(name: &'static str, young: f64, shear: f64, rigidity: f64, hysteresis: f64) -> Fabric {
    Fabric {
        name,
        density: None,
        membrane: MembraneModuli::EqualModuli { young, poisson: 0.0 },
        shear: Some(shear),
        bending: Some(BendingRigidities { warp: rigidity * MICRO, bias: None, weft: rigidity * MICRO }),
        hysteresis: Some(hysteresis * 1e-3),
        citation:
            c"KES-FB, Journal of Textiles 2016, article 4614168, table 5; secant modulus at 1 % strain, computed from EMT and LT",
        limitations: c"weight, Poisson's ratio (0 here), bias bending; values are presumably means of warp and weft",
    }
}

/// A plain weave of Penava et al. (2014): density, kg/m^2; Young's modulus, N/m (the file's modulus in Pa times its thickness); Poisson's ratio.
const fn penava_2014(name: &'static str, density: f64, young: f64, poisson: f64) -> Fabric {
    Fabric {
        name,
        density: Some(density),
        membrane: MembraneModuli::EqualModuli { young, poisson },
        shear: None,
        bending: None,
        hysteresis: None,
        citation: c"Penava et al. 2014, plain weaves; values from a public code file, not the paper; order of magnitude only",
        limitations: c"shear, bending; E is described as a combination of warp and weft; the source of Poisson's ratio is unknown",
    }
}

/// The choices of the parameter `fabric`, in the order of [`FABRICS`].
pub(crate) const CHOICES: &CStr = c"none|rib-knit|blanket|tablecloth|sweater|ponte-roma|interlock|denim|swimsuit|\
jacket|pants|kes-denim-a|kes-denim-b|kes-denim-c|kes-denim-d|kes-denim-e|kes-denim-f|\
cotton|wool|wool-lycra|polyester";

/// `none`, an assumed light cloth, then the measured fabrics.
pub(crate) const FABRICS: [Fabric; 21] = [
    Fabric {
        name: "none",
        density: Some(0.15),
        membrane: MembraneModuli::EqualModuli { young: 500.0, poisson: 0.3 },
        shear: None,
        bending: Some(BendingRigidities { warp: 10e-6, bias: None, weft: 10e-6 }),
        hysteresis: None,
        citation: c"assumed, not measured: a light cloth of 0.15 kg/m^2, 500 N/m, ratio 0.3, 10 uN m",
        limitations: c"all of it",
    },
    wang_2011("rib-knit", 0.276, [85.7, -0.5, 130.3], 83.2, [8.06, 7.50, 11.56]),
    wang_2011("blanket", 0.228, [303.0, 212.1, 489.7], 30.3, [14.94, 21.88, 29.27]),
    wang_2011("tablecloth", 0.128, [4004.0, 0.7, 4055.0], 19.2, [7.82, 10.16, 12.93]),
    Fabric {
        limitations:
            c"thickness, friction, which axis is the warp; C12 = -39.8 N/m makes the tensor indefinite; 0 is used",
        ..wang_2011("sweater", 0.224, [25.0, 0.0, 6.54], 17.6, [11.41, 10.02, 14.87])
    },
    wang_2011("ponte-roma", 0.284, [62.3, -25.6, 88.1], 31.9, [9.29, 8.25, 9.09]),
    wang_2011("interlock", 0.187, [33.2, -29.4, 69.0], 36.9, [3.57, 6.19, 5.80]),
    wang_2011("denim", 0.324, [410.7, 20.5, 2027.8], 53.4, [24.24, 18.35, 16.05]),
    wang_2011("swimsuit", 0.204, [95.9, 13.7, 209.2], 60.8, [12.75, 14.70, 15.06]),
    wang_2011("jacket", 0.113, [86.1, 108.7, 342.8], 14.3, [5.09, 5.49, 3.57]),
    wang_2011("pants", 0.220, [4033.0, 18.3, 4070.0], 104.8, [31.35, 27.00, 31.35]),
    kes_denim("kes-denim-a", 2234.0, 122.5, 16.87, 1.36),
    kes_denim("kes-denim-b", 1358.0, 86.4, 14.12, 1.39),
    kes_denim("kes-denim-c", 4365.0, 190.9, 22.26, 1.03),
    kes_denim("kes-denim-d", 1990.0, 90.6, 14.42, 1.38),
    kes_denim("kes-denim-e", 3119.0, 86.4, 20.30, 2.10),
    kes_denim("kes-denim-f", 1529.0, 84.3, 14.51, 1.56),
    penava_2014("cotton", 0.1503, 261.0, 0.243),
    penava_2014("wool", 0.2348, 96.6, 0.277),
    penava_2014("wool-lycra", 0.1782, 24.9, 0.071),
    penava_2014("polyester", 0.1646, 120.0, 0.381),
];

/// Values under those of a fabric file: none, except Poisson's ratio, which is rarely measured and is 0. The modulus of 0 is never used: without
/// `young-warp` the file is refused.
pub(crate) const FROM_FILE: Fabric = Fabric {
    name: "own",
    density: None,
    membrane: MembraneModuli::EqualModuli { young: 0.0, poisson: 0.0 },
    shear: None,
    bending: None,
    hysteresis: None,
    citation: c"",
    limitations: c"",
};

/// The sources of all choices, in the order of [`FABRICS`].
pub(crate) const SOURCES: &[Source] = &{
    let mut list = [Source { param: c"fabric", choice: 0, citation: c"", limitations: c"" }; FABRICS.len()];
    let mut i = 0;
    while i < list.len() {
        list[i].choice = i as u32;
        (list[i].citation, list[i].limitations) = (FABRICS[i].citation, FABRICS[i].limitations);
        i += 1;
    }
    list
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kes;

    #[test]
    fn choices_and_sources_follow_the_table() {
        let choices: Vec<&str> = CHOICES.to_str().unwrap().split('|').collect();
        assert_eq!(choices, FABRICS.map(|f| f.name));
        for (i, source) in SOURCES.iter().enumerate() {
            assert_eq!((source.choice, source.citation), (i as u32, FABRICS[i].citation));
            assert!(!source.citation.is_empty() && !source.limitations.is_empty(), "{}", choices[i]);
        }
    }

    #[test]
    fn denim_presets_are_the_converted_measurements() {
        // B in gf cm^2/cm, G in gf/(cm deg), EMT in %, LT.
        let measured = [
            (0.172, 2.180, 5.515, 0.712),
            (0.144, 1.538, 5.735, 0.655),
            (0.227, 3.398, 4.695, 0.780),
            (0.147, 1.613, 5.135, 0.676),
            (0.207, 1.538, 4.710, 0.720),
            (0.148, 1.500, 5.455, 0.657),
        ];
        for (fabric, (b, g, emt, lt)) in FABRICS[11..17].iter().zip(measured) {
            let MembraneModuli::EqualModuli { young, .. } = fabric.membrane else { panic!("{}", fabric.name) };
            let bending = fabric.bending.map_or(0.0, |b| b.warp);
            let pairs = [
                (young, kes::secant_modulus(emt, lt, 0.01)),
                (fabric.shear.unwrap_or(0.0), kes::shear_stiffness(g)),
                (bending, kes::bending_rigidity(b)),
            ];
            for (shipped, converted) in pairs {
                // The table is rounded; the relative rounding error is largest for 84.3 N/m, 0.05 / 84.3.
                assert!((shipped / converted - 1.0).abs() < 6e-4, "{}: {shipped} {converted}", fabric.name);
            }
        }
    }
}
