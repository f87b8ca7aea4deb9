//! A fabric of one's own: a TOML file with the numbers of a preset, by the same keys.

use pliant_plugin_api::Fault;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::{Spanned, Value};

/// Numbers a fabric may have: key, and the range that is allowed, in the unit of the parameter of that name.
const KEYS: [(&str, f64, f64); 12] = [
    ("density", 1e-9, 1e4),
    ("young-warp", 1e-9, 1e12),
    ("young-weft", 1e-9, 1e12),
    ("poisson", -1.0, 10.0),
    ("shear", 1e-9, 1e12),
    ("c11", 1e-9, 1e12),
    ("c12", -1e12, 1e12),
    ("c22", 1e-9, 1e12),
    ("bending-warp", 1e-15, 1e3),
    ("bending-weft", 1e-15, 1e3),
    ("bending-bias", 1e-15, 1e3),
    ("bending-hysteresis", 0.0, 1e3),
];

/// A fabric file.
#[derive(Clone, Debug)]
pub(crate) struct FabricFile {
    pub(crate) path: String,
    numbers: BTreeMap<String, f64>,
}

impl FabricFile {
    /// Reads a file: numbers, `source`, a text that says where they come from, and if wanted `unknown`, what was not measured.
    pub(crate) fn read(path: &str) -> Result<Self, Fault> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Fault::bad_argument(format!("`fabric-file`: {path} cannot be read: {error}")))?;
        Self::parse(path, &text)
    }

    fn parse(path: &str, text: &str) -> Result<Self, Fault> {
        let wrong = |at: Range<usize>, what: String| {
            let line = text[..at.start.min(text.len())].matches('\n').count() + 1;
            Fault::bad_argument(format!("`fabric-file`: {path}:{line}: {what}"))
        };
        let table: BTreeMap<Spanned<String>, Spanned<Value>> = toml::from_str(text)
            .map_err(|error| wrong(error.span().unwrap_or(0..0), error.message().trim().replace('\n', " ")))?;
        let (mut numbers, mut has_source) = (BTreeMap::new(), false);
        for (key, value) in &table {
            let name = key.get_ref().as_str();
            if ["source", "unknown"].contains(&name) {
                let said = value.get_ref().as_str().is_some_and(|text| !text.trim().is_empty());
                if !said {
                    return Err(wrong(value.span(), format!("`{name}` is {}; allowed is a text", value.get_ref())));
                }
                has_source |= name == "source";
                continue;
            }
            let Some((_, least, most)) = KEYS.iter().find(|(known, _, _)| *known == name) else {
                let known: Vec<&str> = KEYS.iter().map(|(known, _, _)| *known).collect();
                let text = format!("no number `{name}`; allowed is source, unknown, {}", known.join(", "));
                return Err(wrong(key.span(), text));
            };
            let number = match value.get_ref() {
                Value::Integer(number) => Some(*number as f64),
                Value::Float(number) => Some(*number),
                _ => None,
            };
            let Some(number) = number.filter(|number| (*least..=*most).contains(number)) else {
                let text = format!("`{name}` is {}; allowed is a number from {least:e} to {most:e}", value.get_ref());
                return Err(wrong(value.span(), text));
            };
            numbers.insert(name.to_owned(), number);
        }
        if !has_source {
            return Err(wrong(0..0, "no `source`; allowed is a text that says where the numbers come from".into()));
        }
        Ok(Self { path: path.into(), numbers })
    }

    pub(crate) fn number(&self, key: &str) -> Option<f64> {
        self.numbers.get(key).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_by_key() {
        let text = "source = \"a lab, 2026\"\nunknown = \"thickness\"\ndensity = 0.2\nyoung-warp = 500\npoisson = 0\n";
        let file = FabricFile::parse("wool.toml", text).unwrap();
        assert_eq!(
            (file.number("young-warp"), file.number("poisson"), file.number("shear")),
            (Some(500.0), Some(0.0), None)
        );
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, said) in [
            ("source = \"x\"\ndensity = -1\n", "wool.toml:2: `density` is -1; allowed is a number from"),
            ("source = \"x\"\n\nweight = 1\n", "wool.toml:3: no number `weight`; allowed is source"),
            ("source = \"x\"\nshear = \"stiff\"\n", "wool.toml:2: `shear` is \"stiff\""),
            ("source = \"x\"\nshear = nan\n", "wool.toml:2: `shear` is nan"),
            ("source = \"x\"\nshear = 1\nshear = 2\n", "wool.toml:3: "),
            ("source = \"x\"\nshear 1\n", "wool.toml:2: "),
            ("density = 0.2\n", "wool.toml:1: no `source`"),
            ("source = 3\n", "wool.toml:1: `source` is 3"),
            ("", "no `source`"),
        ] {
            let fault = FabricFile::parse("wool.toml", text).unwrap_err();
            assert!(fault.reason.contains(said), "{text}: {fault}");
        }
    }
}
