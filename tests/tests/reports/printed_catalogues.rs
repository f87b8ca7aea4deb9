//! `pliant report KIND --print-catalogue` prints a catalogue that the report takes back, with every key explained above it.

use pliant_tests::Bench;
use std::collections::BTreeSet;

/// The comment lines at the beginning of a catalogue.
fn head(catalogue: &str) -> Vec<&str> {
    catalogue.lines().take_while(|line| line.starts_with('#')).collect()
}

/// Names and keys of all entries, as `[[map]]` and `along`.
fn names_and_keys(catalogue: &str) -> BTreeSet<(String, String)> {
    let table: toml::Table = catalogue.parse().expect("a catalogue");
    let entries = |value: &toml::Value| value.as_array().expect("entries").clone();
    let keys_of = |(name, value): (&String, &toml::Value)| {
        let keys = entries(value)
            .into_iter()
            .flat_map(|e| e.as_table().expect("keys").clone().into_iter().map(|(key, _)| key));
        let name = format!("[[{name}]]");
        keys.map(|key| (name.clone(), key)).collect::<Vec<_>>()
    };
    table.iter().flat_map(keys_of).collect()
}

#[test]
fn a_printed_catalogue_explains_its_keys_and_is_taken_back() {
    let bench = Bench::new();
    for kind in ["accuracy", "stability", "performance"] {
        let printed = bench.pliant(&["report", kind, "--print-catalogue"]).expect(0).out;
        let head = head(&printed);
        for (name, key) in names_and_keys(&printed) {
            let begin = head.iter().position(|line| line.contains(&name));
            let begin = begin.unwrap_or_else(|| panic!("{kind}: {name} is not explained"));
            let section: Vec<&str> = head[begin..]
                .iter()
                .enumerate()
                .take_while(|(i, l)| *i == 0 || !l.contains("[["))
                .map(|(_, l)| *l)
                .collect();
            let is_word = |line: &&str| line.split(|c: char| !c.is_alphanumeric() && c != '-').any(|word| word == key);
            assert!(section.iter().any(is_word), "{kind}: `{key}` of {name} is not explained");
        }
        bench.write("own/catalogue.toml", &printed);
        // The catalogue is read before the case is looked for.
        let args =
            ["report", kind, "--catalogue", "own/catalogue.toml", "--case", "no-such-case", "-q", "--out", "out"];
        bench.pliant(&args).expect(2).says(&["no-such-case", "allowed is a part of"]);
    }
}
