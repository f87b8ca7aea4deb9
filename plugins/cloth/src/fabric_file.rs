//! A user's fabric: a TOML file with the numbers of a preset, by the keys of the parameters.

use pliant_plugin_api::Fault;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::{Spanned, Value};

/// A number a fabric file may have, with its allowed range in the unit of the parameter of that name.
struct Key {
    name: &'static str,
    min: f64,
    max: f64,
}

const fn key(name: &'static str, min: f64, max: f64) -> Key {
    Key { name, min, max }
}

const KEYS: [Key; 12] = [
    key("density", 1e-9, 1e4),
    key("young-warp", 1e-9, 1e12),
    key("young-weft", 1e-9, 1e12),
    key("poisson", -1.0, 10.0),
    key("shear", 1e-9, 1e12),
    key("c11", 1e-9, 1e12),
    key("c12", -1e12, 1e12),
    key("c22", 1e-9, 1e12),
    key("bending-warp", 1e-15, 1e3),
    key("bending-weft", 1e-15, 1e3),
    key("bending-bias", 1e-15, 1e3),
    key("bending-hysteresis", 0.0, 1e3),
];

/// The numbers of a fabric file.
#[derive(Clone, Debug)]
pub(crate) struct FabricFile {
    pub(crate) path: String,
    /// Values by their keys, in the unit of each key.
    numbers: BTreeMap<String, f64>,
}

impl FabricFile {
    /// Reads a file. It has numbers, the required text `source`, and the optional text `unknown`.
    pub(crate) fn read(path: &str) -> Result<Self, Fault> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Fault::bad_argument(format!("`fabric-file`: {path} cannot be read: {error}")))?;
        Self::parse(path, &text)
    }

    /// Parses the text of a file; `path` is for messages, which also name the line.
    fn parse(path: &str, text: &str) -> Result<Self, Fault> {
        let wrong = |span: Range<usize>, what: String| {
            let line = text[..span.start.min(text.len())].matches('\n').count() + 1;
            Fault::bad_argument(format!("`fabric-file`: {path}:{line}: {what}"))
        };
        let table: BTreeMap<Spanned<String>, Spanned<Value>> = toml::from_str(text)
            .map_err(|error| wrong(error.span().unwrap_or(0..0), error.message().trim().replace('\n', " ")))?;
        let (mut numbers, mut has_source) = (BTreeMap::new(), false);
        for (key, value) in &table {
            let name = key.get_ref().as_str();
            if ["source", "unknown"].contains(&name) {
                let is_text = value.get_ref().as_str().is_some_and(|text| !text.trim().is_empty());
                if !is_text {
                    return Err(wrong(value.span(), format!("`{name}` is {}; allowed is a text", value.get_ref())));
                }
                has_source |= name == "source";
                continue;
            }
            let Some(Key { min, max, .. }) = KEYS.iter().find(|key| key.name == name) else {
                let known: Vec<&str> = KEYS.iter().map(|key| key.name).collect();
                let text = format!("no number `{name}`; allowed is source, unknown, {}", known.join(", "));
                return Err(wrong(key.span(), text));
            };
            let number = value.get_ref();
            let number = number.as_float().or_else(|| number.as_integer().map(|number| number as f64));
            let Some(number) = number.filter(|number| (*min..=*max).contains(number)) else {
                let text = format!("`{name}` is {}; allowed is a number from {min:e} to {max:e}", value.get_ref());
                return Err(wrong(value.span(), text));
            };
            numbers.insert(name.to_owned(), number);
        }
        if !has_source {
            return Err(wrong(0..0, "no `source`; allowed is a text that says where the numbers come from".into()));
        }
        Ok(Self { path: path.into(), numbers })
    }

    /// The number of a key, in the unit of the parameter of that name.
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
    fn a_damaged_file_is_read_or_its_error_names_the_line() {
        let text = "source = \"a lab\"\nunknown = \"thickness\"\ndensity = 0.2\nyoung-warp = 5e2\npoisson = 0\n";
        let mut random = pliant_plugin_api::kit::Random(1);
        let mut below = |limit: usize| (random.next_u64() % limit as u64) as usize;
        for _ in 0..2000 {
            let mut bytes = text.as_bytes()[..below(text.len() + 1)].to_vec();
            for _ in 0..below(4).min(bytes.len()) {
                let at = below(bytes.len());
                bytes[at] = b"=\"[]{}\n#-e. 9\0\xff"[below(15)];
            }
            let text = String::from_utf8_lossy(&bytes);
            if let Err(fault) = FabricFile::parse("wool.toml", &text) {
                assert!(fault.reason.contains("wool.toml:"), "{text:?}: {fault}");
            }
        }
    }

    #[test]
    fn errors_name_the_line() {
        for (text, expected) in [
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
            assert!(fault.reason.contains(expected), "{text}: {fault}");
        }
    }
}
