//! Numbers with units. A scene may write a bare number, which is SI, or a text such as `"8 mm"` or `"10 kPa"`.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// A unit: its name, the SI unit of the same quantity, and its value in that unit.
struct Unit(&'static str, &'static str, f64);

/// All units that scenes may use, the SI unit of each quantity first.
const UNITS: &[Unit] = &[
    Unit("m", "m", 1.0),
    Unit("cm", "m", 1e-2),
    Unit("mm", "m", 1e-3),
    Unit("um", "m", 1e-6),
    Unit("s", "s", 1.0),
    Unit("ms", "s", 1e-3),
    Unit("us", "s", 1e-6),
    Unit("kg", "kg", 1.0),
    Unit("g", "kg", 1e-3),
    Unit("mg", "kg", 1e-6),
    Unit("N", "N", 1.0),
    Unit("mN", "N", 1e-3),
    Unit("kN", "N", 1e3),
    Unit("Pa", "Pa", 1.0),
    Unit("kPa", "Pa", 1e3),
    Unit("MPa", "Pa", 1e6),
    Unit("GPa", "Pa", 1e9),
    Unit("N/m", "N/m", 1.0),
    Unit("N/mm", "N/m", 1e3),
    Unit("N/s", "N/s", 1.0),
    Unit("N/ms", "N/s", 1e3),
    Unit("N s/m", "N s/m", 1.0),
    Unit("N m", "N m", 1.0),
    Unit("uN m", "N m", 1e-6),
    Unit("J", "J", 1.0),
    Unit("mJ", "J", 1e-3),
    Unit("uJ", "J", 1e-6),
    Unit("J/m^2", "J/m^2", 1.0),
    Unit("kJ/m^2", "J/m^2", 1e3),
    Unit("kg/m^3", "kg/m^3", 1.0),
    Unit("g/cm^3", "kg/m^3", 1e3),
    Unit("kg/m^2", "kg/m^2", 1.0),
    Unit("g/m^2", "kg/m^2", 1e-3),
    Unit("m/s", "m/s", 1.0),
    Unit("mm/s", "m/s", 1e-3),
    Unit("m/s^2", "m/s^2", 1.0),
    Unit("rad", "rad", 1.0),
    Unit("deg", "rad", std::f64::consts::PI / 180.0),
    Unit("Hz", "Hz", 1.0),
    Unit("kHz", "Hz", 1e3),
    Unit("1", "1", 1.0),
    Unit("%", "1", 1e-2),
];

/// The quantity of an SI unit, in words.
fn measured(si: &str) -> &str {
    match si {
        "m" => "a length",
        "s" => "a time",
        "kg" => "a mass",
        "N" => "a force",
        "Pa" => "a pressure",
        "N/m" => "a stiffness",
        "N/s" => "a force rate",
        "N s/m" => "a damping",
        "N m" => "a moment or bending rigidity",
        "J" => "an energy",
        "J/m^2" => "an energy of an area",
        "kg/m^3" => "a density",
        "kg/m^2" => "an areal density",
        "m/s" => "a speed",
        "m/s^2" => "an acceleration",
        "rad" => "an angle",
        "Hz" => "a frequency",
        "1" => "a plain number",
        other => other,
    }
}

/// Parses a number with a unit, such as `"8 mm"`, and returns its value in the SI unit `si`.
///
/// # Errors
/// Returns a message with the text found and what is allowed: no number, no unit, a unit of another quantity, a value that is not finite.
pub fn parse_quantity(text: &str, si: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, unit) = split(text);
    let unit = unit.trim();
    let units = || UNITS.iter().filter(|u| u.1 == si).map(|u| u.0).collect::<Vec<_>>().join(", ");
    let allowed = || {
        let list = units();
        let list = if list.is_empty() { si.to_owned() } else { list };
        format!("allowed is {}, a number in {si} or text such as \"2 {si}\" with one of {list}", measured(si))
    };
    let value: f64 = number.parse().map_err(|_| format!("`{text}` has no number before its unit; {}", allowed()))?;
    if !value.is_finite() {
        return Err(format!("`{text}` is not finite; {}", allowed()));
    }
    if unit.is_empty() {
        return Err(format!("`{text}` has no unit; {}", allowed()));
    }
    match UNITS.iter().find(|u| u.0 == unit) {
        Some(unit) if unit.1 == si => {
            let value = value * unit.2;
            if value.is_finite() { Ok(value) } else { Err(format!("`{text}` is too large; {}", allowed())) }
        }
        Some(other) => Err(format!("`{text}` is {}; {}", measured(other.1), allowed())),
        None if unit == si => Ok(value),
        None => Err(format!("`{unit}` is not a unit; {}", allowed())),
    }
}

/// Splits a text into number and unit, with or without a space between them.
fn split(text: &str) -> (&str, &str) {
    let digits = text.rfind(|c: char| c.is_ascii_digit()).map_or(0, |at| at + 1);
    let glued = (1..=digits).rev().find(|&at| text.is_char_boundary(at) && text[..at].parse::<f64>().is_ok());
    text.split_at(text.find(char::is_whitespace).or(glued).unwrap_or(text.len()))
}

/// The dimension of a [`Quantity`].
pub trait Dimension {
    /// Its SI unit, as for [`parse_quantity`].
    const SI: &'static str;
}

macro_rules! dimensions {
    ($($(#[$doc:meta])* $marker:ident $alias:ident $si:literal;)+) => {$(
        #[doc = concat!("The dimension with the SI unit ", $si, ".")]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $marker;
        impl Dimension for $marker {
            const SI: &'static str = $si;
        }
        $(#[$doc])*
        pub type $alias = Quantity<$marker>;
    )+};
}

dimensions! {
    /// A length, m.
    LengthUnit Length "m";
    /// A time, s.
    TimeUnit Time "s";
    /// A mass, kg.
    MassUnit Mass "kg";
    /// A force, N.
    ForceUnit Force "N";
    /// A stiffness, N/m.
    StiffnessUnit Stiffness "N/m";
    /// An energy per area, J/m^2.
    ToughnessUnit Toughness "J/m^2";
    /// A damping coefficient, N s/m.
    DampingUnit Damping "N s/m";
    /// A rate of change of a force, N/s.
    ForceRateUnit ForceRate "N/s";
    /// A speed, m/s.
    SpeedUnit Speed "m/s";
    /// An acceleration, m/s^2.
    AccelerationUnit Acceleration "m/s^2";
    /// An angle, rad.
    AngleUnit Angle "rad";
    /// A frequency, Hz.
    FrequencyUnit Frequency "Hz";
}

/// A finite number with a dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity<D> {
    /// Value in the SI unit.
    pub si: f64,
    dimension: PhantomData<D>,
}

impl<D> Quantity<D> {
    /// A quantity with this value in the SI unit.
    pub const fn new(si: f64) -> Self {
        Self { si, dimension: PhantomData }
    }
}

impl<'de, D: Dimension> Deserialize<'de> for Quantity<D> {
    fn deserialize<T: Deserializer<'de>>(from: T) -> Result<Self, T::Error> {
        struct Read<D>(PhantomData<D>);
        impl<D: Dimension> Visitor<'_> for Read<D> {
            type Value = Quantity<D>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}: a number in {} or text such as \"2 {}\"", measured(D::SI), D::SI, D::SI)
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
                if value.is_finite() {
                    Ok(Quantity::new(value))
                } else {
                    Err(E::custom(format!("{value} is not finite; allowed is {}", measured(D::SI))))
                }
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
                Ok(Quantity::new(value as f64))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
                parse_quantity(text, D::SI).map(Quantity::new).map_err(E::custom)
            }
        }
        from.deserialize_any(Read(PhantomData))
    }
}

impl<D: Dimension> JsonSchema for Quantity<D> {
    /// Inline, as names of units have spaces and slashes that a reference would have to escape.
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("Quantity in {}", D::SI).into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let text = format!("{}: a number in {}, or a text with a unit", measured(D::SI), D::SI);
        json_schema!({ "description": text, "type": ["number", "string"] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_units_of_the_right_kind() {
        for (text, si, value) in [
            ("8 mm", "m", 8e-3),
            ("2ms", "s", 2e-3),
            ("-1e-3N", "N", -1e-3),
            ("10m/s^2", "m/s^2", 10.0),
            (" 10  kPa ", "Pa", 1e4),
            ("1e-3 s", "s", 1e-3),
            ("0.2 N s/m", "N s/m", 0.2),
            ("90 deg", "rad", std::f64::consts::FRAC_PI_2),
            ("5 %", "1", 0.05),
            ("3 furlong/day", "furlong/day", 3.0),
        ] {
            let read = parse_quantity(text, si).unwrap();
            assert!((read - value).abs() <= 1e-15 * value.abs(), "{text}: {read}");
        }
    }

    #[test]
    fn says_what_was_found_and_what_is_allowed() {
        for (text, si, parts) in [
            ("5 kg", "m", vec!["5 kg", "a mass", "a length", "mm"]),
            ("5 furlong", "m", vec!["furlong", "not a unit", "cm"]),
            ("5", "m", vec!["no unit"]),
            ("mm", "m", vec!["no number"]),
            ("nan mm", "m", vec!["not finite"]),
            ("1e999 mm", "m", vec!["not finite"]),
            ("1e308 GPa", "Pa", vec!["too large"]),
        ] {
            let error = parse_quantity(text, si).unwrap_err();
            for part in parts {
                assert!(error.contains(part), "{part}: {error}");
            }
        }
    }
}
