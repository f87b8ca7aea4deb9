//! Material presets by name.

use pliant_host::{ParamKind, PluginInfo};

/// A preset of a solid material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidPreset {
    /// Name, for display and lookup.
    pub name: &'static str,
    /// Young's modulus at small strains, Pa.
    pub young: f64,
    /// Poisson's ratio at small strains; ignored by materials without that parameter.
    pub poisson: f64,
    /// Mass per volume at rest, kg/m^3.
    pub density: f64,
    /// Damping time, the ratio of viscosity to stiffness, s.
    pub damping_time: f64,
    /// How it flows beyond a strain; `None`: it is elastic. Only a material with these parameters serves it.
    pub flow: Option<PlasticFlow>,
    /// Source of the numbers.
    pub source: &'static str,
}

/// Plastic flow: what is pressed stays pressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticFlow {
    /// Strain of a drawn bar beyond which the shape at rest flows.
    pub yield_strain: f64,
    /// Increase of the yield strain per plastic strain.
    pub hardening: f64,
    /// Time constant of the flow at fixed deformation, s.
    pub flow_time: f64,
}

/// Solid materials, soft to stiff, then those that flow. Where a source gives a range the middle is taken; damping times are assumptions: short enough that a
/// press does not lag, long enough that nothing rings.
pub const SOLIDS: &[SolidPreset] = &[
    SolidPreset {
        name: "jelly",
        young: 5e3,
        poisson: 0.45,
        density: 1000.0,
        damping_time: 0.5e-3,
        flow: None,
        source: "gelatin of 5 % (Hall et al. 1997: 1 to 10 kPa)",
    },
    SolidPreset {
        name: "flesh",
        young: 20e3,
        poisson: 0.45,
        density: 1060.0,
        damping_time: 0.5e-3,
        flow: None,
        source: "relaxed muscle across its fibres (McKee et al. 2011: 5 to 170 kPa, indentation in the tens)",
    },
    SolidPreset {
        name: "skin",
        young: 56e3,
        poisson: 0.48,
        density: 1100.0,
        damping_time: 0.5e-3,
        flow: None,
        source: "forearm under suction (Hendriks et al. 2003: 56 kPa)",
    },
    SolidPreset {
        name: "foam",
        young: 50e3,
        poisson: 0.1,
        density: 30.0,
        damping_time: 1e-3,
        flow: None,
        source: "flexible polyurethane foam (Gibson and Ashby 1997: 20 to 100 kPa)",
    },
    SolidPreset {
        name: "silicone",
        young: 125e3,
        poisson: 0.48,
        density: 1070.0,
        damping_time: 0.2e-3,
        flow: None,
        source: "platinum-cure silicone of Shore 00-30 (100 % modulus 69 kPa by its data sheet, and what follows at small strains)",
    },
    SolidPreset {
        name: "rubber",
        young: 1.1e6,
        poisson: 0.49,
        density: 1100.0,
        damping_time: 0.1e-3,
        flow: None,
        source: "Shore A 30 (Gent 1958)",
    },
    SolidPreset {
        name: "clay",
        young: 300e3,
        poisson: 0.45,
        density: 1700.0,
        damping_time: 2e-3,
        flow: Some(PlasticFlow { yield_strain: 0.03, hardening: 0.05, flow_time: 5e-3 }),
        source: "an assumption: soft modelling clay that yields at 9 kPa",
    },
    SolidPreset {
        name: "dough",
        young: 20e3,
        poisson: 0.45,
        density: 1150.0,
        damping_time: 5e-3,
        flow: Some(PlasticFlow { yield_strain: 0.05, hardening: 0.0, flow_time: 0.1 }),
        source: "an assumption: wheat dough that yields at 1 kPa and flows slowly",
    },
];

/// The solid preset with this name; `None` if there is none.
pub fn solid(name: &str) -> Option<&'static SolidPreset> {
    SOLIDS.iter().find(|preset| preset.name == name)
}

/// Names of the fabrics of a sheet material, from the choices of its plugin's parameter `fabric`.
pub fn fabrics(info: &PluginInfo) -> Vec<String> {
    let choices = info.params.iter().find(|param| param.key == "fabric").map(|param| &param.kind);
    match choices {
        Some(ParamKind::Choice { choices, .. }) => choices.clone(),
        _ => Vec::new(),
    }
}

/// A word for a Young's modulus (Pa), on a logarithmic scale from marshmallow to hard rubber.
pub fn stiffness_word(young: f64) -> &'static str {
    const WORDS: [(f64, &str); 7] = [
        (3e3, "very soft, like marshmallow"),
        (1e4, "soft, like jelly"),
        (4e4, "like flesh"),
        (2e5, "firm, like skin and foam"),
        (1e6, "tough, like a soft eraser"),
        (5e6, "like rubber"),
        (f64::INFINITY, "hard, like a tyre"),
    ];
    WORDS.iter().find(|(below, _)| young < *below).map_or(WORDS[WORDS.len() - 1].1, |(_, word)| word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_physical_and_found_by_name() {
        for preset in SOLIDS {
            assert!(preset.young > 0.0 && preset.density > 0.0 && preset.damping_time >= 0.0, "{}", preset.name);
            assert!((0.0..0.5).contains(&preset.poisson) && !preset.source.is_empty(), "{}", preset.name);
            let flows = |f: PlasticFlow| f.yield_strain > 0.0 && f.hardening >= 0.0 && f.flow_time >= 0.0;
            assert!(preset.flow.is_none_or(flows), "{}", preset.name);
            assert_eq!(solid(preset.name), Some(preset));
        }
        assert_eq!(solid("granite"), None);
        assert_eq!(stiffness_word(2e4), "like flesh");
        assert_eq!(stiffness_word(f64::INFINITY), "hard, like a tyre");
    }
}
