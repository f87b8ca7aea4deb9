//! Length of a file unit: OBJ files do not specify it, so it is guessed and can be changed.

use serde::{Deserialize, Serialize};

/// A unit of length of model files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LengthUnit {
    /// 1 m
    Metre,
    /// 10 mm
    Centimetre,
    /// 1 mm
    Millimetre,
    /// 25.4 mm
    Inch,
}

/// Usual sizes of models, from a ring to a person, m.
const USUAL_SIZES: std::ops::RangeInclusive<f64> = 0.02..=2.5;

impl LengthUnit {
    /// All units, the most common ones in OBJ files first.
    pub const ALL: [Self; 4] = [Self::Metre, Self::Centimetre, Self::Millimetre, Self::Inch];

    /// Length of the unit, m.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 1e-2,
            Self::Millimetre => 1e-3,
            Self::Inch => 25.4e-3,
        }
    }

    /// Units with which a model with this longest edge (file units) has a usual size: the guess is certain only if there is one.
    pub fn plausible(extent: f64) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |unit| USUAL_SIZES.contains(&(extent * unit.metres())))
    }

    /// Guesses the unit of a model with this longest edge (file units): the first one of [`LengthUnit::ALL`] with which it has a usual size, or the one that
    /// comes closest.
    pub fn guess(extent: f64) -> Self {
        let usual = Self::plausible(extent).next();
        let middle = (USUAL_SIZES.start() * USUAL_SIZES.end()).sqrt();
        let away = |unit: &Self| (extent * unit.metres() / middle).ln().abs();
        usual.unwrap_or_else(|| {
            let nearest = Self::ALL.into_iter().min_by(|a, b| away(a).total_cmp(&away(b)));
            nearest.unwrap_or(Self::Metre)
        })
    }
}

/// Formats a length (m) with three digits in a suitable unit.
pub fn format_length(metres: f64) -> String {
    let size = metres.abs();
    let (value, unit) = match size {
        _ if size >= 1.0 => (metres, "m"),
        _ if size >= 1e-2 => (metres * 1e2, "cm"),
        _ if size >= 1e-3 || size == 0.0 => (metres * 1e3, "mm"),
        _ => (metres * 1e6, "\u{b5}m"),
    };
    let digits = if value.abs() >= 100.0 {
        0
    } else if value.abs() >= 10.0 {
        1
    } else {
        2
    };
    format!("{value:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_get_the_size_of_things_people_hold() {
        // Extents of the bunny, a cow, a monkey's head, a teapot, a figure in centimetres, a print in millimetres.
        for (extent, unit) in [
            (0.156, LengthUnit::Metre),
            (1.72, LengthUnit::Metre),
            (6.43, LengthUnit::Centimetre),
            (170.0, LengthUnit::Centimetre),
            (800.0, LengthUnit::Millimetre),
            (1e-6, LengthUnit::Metre),
            (1e9, LengthUnit::Millimetre),
        ] {
            assert_eq!(LengthUnit::guess(extent), unit, "{extent}");
        }
        let plausible = |extent| LengthUnit::plausible(extent).collect::<Vec<_>>();
        assert_eq!(plausible(0.156), [LengthUnit::Metre]);
        assert_eq!(plausible(1.72), [LengthUnit::Metre, LengthUnit::Inch]);
        assert_eq!(plausible(1e9), []);
    }

    #[test]
    fn lengths_read_well() {
        for (metres, text) in [
            (1.8, "1.80 m"),
            (0.15, "15.0 cm"),
            (0.005, "5.00 mm"),
            (0.0, "0.00 mm"),
            (2e-5, "20.0 \u{b5}m"),
            (123.0, "123 m"),
        ] {
            assert_eq!(format_length(metres), text);
        }
    }
}
