//! Fabrics as measured by others, and only what they measured: what is not known stays `None` and has to be given.

use core::ffi::CStr;
use pliant_plugin_api::Source;

/// One fabric. SI units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fabric {
    /// As in the choice `fabric`.
    pub(crate) name: &'static str,
    /// kg/m^2
    pub(crate) density: Option<f64>,
    pub(crate) membrane: Stretch,
    /// N/m
    pub(crate) shear: Option<f64>,
    /// N m, along warp, at 45 degrees, along weft
    pub(crate) bending: Option<(f64, Option<f64>, f64)>,
    /// N, width of the moment's loop, 2HB
    pub(crate) hysteresis: Option<f64>,
    /// Who measured what, and when.
    pub(crate) source: &'static CStr,
    /// What the source leaves open, or what of it is doubtful.
    pub(crate) unknown: &'static CStr,
}

/// Resistance to stretch, N/m.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stretch {
    /// Of C11, C12, C22.
    Tensor(f64, f64, f64),
    /// Of Young's modulus along warp and weft, and Poisson's ratio.
    Moduli(f64, f64),
}

/// The tensor is twice the files' numbers and D a quarter of their `ke`, which is what the force law of that program makes of
/// them. Axis 1 of the files is taken as warp.
const fn wang(name: &'static str, density: f64, c: (f64, f64, f64), shear: f64, d: (f64, f64, f64)) -> Fabric {
    Fabric {
        name,
        density: Some(density),
        membrane: Stretch::Tensor(c.0, c.1, c.2),
        shear: Some(shear),
        bending: Some((d.0 * 1e-6, Some(d.1 * 1e-6), d.2 * 1e-6)),
        hysteresis: None,
        source: c"Wang, O'Brien and Ramamoorthi 2011, material files of ARCSim: small strain, least curvature",
        unknown: c"thickness, friction, which axis is the warp",
    }
}

/// The table's weight, 93.9 to 109.3 "mg/cm2", cannot be.
const fn denim(name: &'static str, young: f64, shear: f64, d: f64, loops: f64) -> Fabric {
    Fabric {
        name,
        density: None,
        membrane: Stretch::Moduli(young, 0.0),
        shear: Some(shear),
        bending: Some((d * 1e-6, None, d * 1e-6)),
        hysteresis: Some(loops * 1e-3),
        source:
            c"KES-FB, Journal of Textiles 2016, article 4614168, table 5; modulus: secant at 1 % strain by EMT and LT",
        unknown: c"weight, Poisson's ratio (0 here), bias; presumably means of warp and weft",
    }
}

/// E is the file's modulus times its thickness.
const fn penava(name: &'static str, density: f64, young: f64, poisson: f64) -> Fabric {
    Fabric {
        name,
        density: Some(density),
        membrane: Stretch::Moduli(young, poisson),
        shear: None,
        bending: None,
        hysteresis: None,
        source: c"Penava et al. 2014, plain weaves, second hand from a public code file: an order of magnitude",
        unknown: c"shear, bending; E is called a combination, and where Poisson's ratio comes from is open",
    }
}

/// The choices of `fabric`, in the order of [`FABRICS`].
pub(crate) const CHOICES: &core::ffi::CStr =
    c"none|rib-knit|blanket|tablecloth|sweater|ponte-roma|interlock|denim|swimsuit|\
jacket|pants|kes-denim-a|kes-denim-b|kes-denim-c|kes-denim-d|kes-denim-e|kes-denim-f|\
cotton|wool|wool-lycra|polyester";

/// `none`, then the tables.
pub(crate) const FABRICS: [Fabric; 21] = [
    Fabric {
        name: "none",
        density: Some(0.15),
        membrane: Stretch::Moduli(500.0, 0.3),
        shear: None,
        bending: Some((10e-6, None, 10e-6)),
        hysteresis: None,
        source: c"nobody's: a light cloth of 0.15 kg/m^2, 500 N/m, ratio 0.3, 10 uN m",
        unknown: c"all of it",
    },
    wang("rib-knit", 0.276, (85.7, -0.5, 130.3), 83.2, (8.06, 7.50, 11.56)),
    wang("blanket", 0.228, (303.0, 212.1, 489.7), 30.3, (14.94, 21.88, 29.27)),
    wang("tablecloth", 0.128, (4004.0, 0.7, 4055.0), 19.2, (7.82, 10.16, 12.93)),
    Fabric {
        unknown: c"thickness, friction, which axis is the warp; C12, -39.8 N/m in the files, is not positive definite: 0 here",
        ..wang("sweater", 0.224, (25.0, 0.0, 6.54), 17.6, (11.41, 10.02, 14.87))
    },
    wang("ponte-roma", 0.284, (62.3, -25.6, 88.1), 31.9, (9.29, 8.25, 9.09)),
    wang("interlock", 0.187, (33.2, -29.4, 69.0), 36.9, (3.57, 6.19, 5.80)),
    wang("denim", 0.324, (410.7, 20.5, 2027.8), 53.4, (24.24, 18.35, 16.05)),
    wang("swimsuit", 0.204, (95.9, 13.7, 209.2), 60.8, (12.75, 14.70, 15.06)),
    wang("jacket", 0.113, (86.1, 108.7, 342.8), 14.3, (5.09, 5.49, 3.57)),
    wang("pants", 0.220, (4033.0, 18.3, 4070.0), 104.8, (31.35, 27.00, 31.35)),
    denim("kes-denim-a", 2234.0, 122.5, 16.87, 1.36),
    denim("kes-denim-b", 1358.0, 86.4, 14.12, 1.39),
    denim("kes-denim-c", 4365.0, 190.9, 22.26, 1.03),
    denim("kes-denim-d", 1990.0, 90.6, 14.42, 1.38),
    denim("kes-denim-e", 3119.0, 86.4, 20.30, 2.10),
    denim("kes-denim-f", 1529.0, 84.3, 14.51, 1.56),
    penava("cotton", 0.1503, 261.0, 0.243),
    penava("wool", 0.2348, 96.6, 0.277),
    penava("wool-lycra", 0.1782, 24.9, 0.071),
    penava("polyester", 0.1646, 120.0, 0.381),
];

/// What a file of one's own is measured against: nothing. Poisson's ratio, which is rarely measured, is 0.
pub(crate) const OWN: Fabric = Fabric {
    name: "own",
    density: None,
    membrane: Stretch::Moduli(0.0, 0.0),
    shear: None,
    bending: None,
    hysteresis: None,
    source: c"",
    unknown: c"",
};

/// Where the numbers of each come from, in the order of [`FABRICS`].
pub(crate) const SOURCES: &[Source] = &{
    let mut list = [Source { param: c"fabric", choice: 0, citation: c"", limitations: c"" }; FABRICS.len()];
    let mut i = 0;
    while i < list.len() {
        list[i].choice = i as u32;
        (list[i].citation, list[i].limitations) = (FABRICS[i].source, FABRICS[i].unknown);
        i += 1;
    }
    list
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kes;

    #[test]
    fn choices_are_the_table() {
        let choices: Vec<&str> = CHOICES.to_str().unwrap().split('|').collect();
        assert_eq!(choices, FABRICS.map(|f| f.name));
        for (i, source) in SOURCES.iter().enumerate() {
            assert_eq!((source.choice, source.citation), (i as u32, FABRICS[i].source));
            assert!(!source.citation.is_empty() && !source.limitations.is_empty(), "{}", choices[i]);
        }
    }

    #[test]
    fn denims_are_what_the_conversions_make_of_the_measurements() {
        // B gf cm^2/cm, G gf/(cm deg), EMT %, LT of the table.
        let measured = [
            (0.172, 2.180, 5.515, 0.712),
            (0.144, 1.538, 5.735, 0.655),
            (0.227, 3.398, 4.695, 0.780),
            (0.147, 1.613, 5.135, 0.676),
            (0.207, 1.538, 4.710, 0.720),
            (0.148, 1.500, 5.455, 0.657),
        ];
        for (fabric, (b, g, emt, lt)) in FABRICS[11..17].iter().zip(measured) {
            let Stretch::Moduli(young, _) = fabric.membrane else { panic!("{}", fabric.name) };
            let bending = fabric.bending.map_or(0.0, |b| b.0);
            let pairs = [
                (young, kes::secant(emt, lt, 0.01)),
                (fabric.shear.unwrap_or(0.0), kes::shear(g)),
                (bending, kes::bending(b)),
            ];
            for (shipped, converted) in pairs {
                assert!((shipped / converted - 1.0).abs() < 1.5e-3, "{}: {shipped} {converted}", fabric.name);
            }
        }
    }
}
