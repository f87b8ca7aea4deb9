//! What `pliant plan --json` says has the keys and types that docs/outputs.md lists, for every scene of the repository: no key is missing there, none has gone.

use pliant_tests::{Bench, root};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Types by key: `[]` stands for the entries of an array.
type Types = BTreeMap<String, BTreeSet<&'static str>>;

/// Adds the leaves of a value: numbers, texts, truth values and nulls.
fn add(value: &Value, key: &str, types: &mut Types) {
    let of = match value {
        Value::Object(fields) => {
            let name = |field: &str| if key.is_empty() { field.to_owned() } else { format!("{key}.{field}") };
            fields.iter().for_each(|(field, value)| add(value, &name(field), types));
            return;
        }
        Value::Array(all) => {
            all.iter().for_each(|value| add(value, &format!("{key}[]"), types));
            return;
        }
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(number) if number.is_u64() => "integer",
        Value::Number(_) => "number",
        Value::String(_) => "string",
    };
    types.entry(key.to_owned()).or_default().insert(of);
}

/// The keys that the documentation lists, with their types, and whether each is there only where it applies.
fn documented() -> BTreeMap<String, (BTreeSet<String>, bool)> {
    let text = std::fs::read_to_string(root().join("docs/outputs.md")).unwrap();
    let section = text.split("## What a plan says").nth(1).unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    let of_row = |row: &str| {
        let cells: Vec<String> = row.split('|').map(|cell| cell.trim().to_owned()).collect();
        let types: BTreeSet<String> = cells[2].split(" or ").map(str::to_owned).collect();
        let keys: Vec<String> = cells[1].split(',').map(|key| key.trim().trim_matches('`').to_owned()).collect();
        keys.into_iter().map(move |key| {
            let name = key.trim_end_matches('?').to_owned();
            (name, (types.clone(), key.ends_with('?')))
        })
    };
    rows.flat_map(|row| of_row(row).collect::<Vec<_>>()).collect()
}

/// Scenes of the repository that need no hardware.
fn scenes() -> Vec<PathBuf> {
    let all = std::fs::read_dir(root().join("scenes")).unwrap().map(|entry| entry.unwrap().path());
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "toml");
    let needs_hardware = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        ["\"phantom\"", "\"exoskeleton\""].iter().any(|device| text.contains(device))
    };
    let mut scenes: Vec<PathBuf> = all.filter(is_scene).filter(|path| !needs_hardware(path)).collect();
    scenes.sort();
    scenes
}

/// A scene with what no scene of the repository has: a level and a subdivision that are chosen, and a warning.
const CHOSEN: &str = "format = 1\n[time]\nduration = 0.01\ndt = 1e-3\n[[body]]\nname = \"box\"\nshape = { kind = \"box\", size = [0.1, 0.1, 0.1], cells = 2 }\n\
    subdivide = \"auto\"\nmaterial = { plugin = \"mass-spring\", params = { young = 20000 } }\n[body.grid]\nlevel = \"auto\"\n[[device]]\nname = \"hand\"\n\
    plugin = \"scripted\"\nparams = { path = [[0, 9, 9, 9]] }\n[[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = 0.01\n[[tool]]\nname = \"unused\"\n\
    device = \"hand\"\nradius = 0.01\n[[edit]]\nkind = \"touch\"\ntool = \"finger\"\n[[body.fixed]]\nbox = [[-9, -9, -9], [-8, -8, -8]]\n";

#[test]
fn every_key_of_a_plan_is_documented_with_its_type() {
    let bench = Bench::new();
    let documented = documented();
    assert!(documented.len() > 40, "{}", documented.len());
    let mut all = Types::new();
    let chosen = bench.write("chosen.toml", CHOSEN);
    let scenes = scenes();
    assert!(scenes.len() > 25, "{scenes:?}");
    for scene in scenes.iter().chain([&chosen]) {
        let plan = bench.pliant(&["plan", scene.to_str().unwrap(), "--json"]).expect(0).json();
        let mut types = Types::new();
        add(&plan, "", &mut types);
        for (key, found) in &types {
            let Some((allowed, _)) = documented.get(key) else {
                panic!("{}: `{key}` is not documented", scene.display())
            };
            // A whole number is a number too.
            let is_allowed = |of: &&str| allowed.contains(*of) || (**of == *"integer" && allowed.contains("number"));
            assert!(found.iter().all(is_allowed), "{}: `{key}` is {found:?}; documented: {allowed:?}", scene.display());
        }
        for (key, (_, is_optional)) in documented.iter().filter(|(key, _)| !key.contains("[]")) {
            assert!(*is_optional || types.contains_key(key), "{}: no `{key}`", scene.display());
        }
        // Entries of an array have all of their keys, but for those that are there where they apply.
        for (key, (_, is_optional)) in documented.iter().filter(|(key, _)| key.contains("[]")) {
            let entry = &key[..key.rfind("[]").unwrap() + 2];
            let has_entry = types.keys().any(|other| other.starts_with(&format!("{entry}.")));
            assert!(
                *is_optional || !has_entry || types.contains_key(key),
                "{}: an entry has no `{key}`",
                scene.display()
            );
        }
        types.into_iter().for_each(|(key, found)| all.entry(key).or_default().extend(found));
    }
    let never: Vec<&String> = documented.keys().filter(|key| !all.contains_key(*key)).collect();
    assert!(never.is_empty(), "documented, and in no plan: {never:?}");
}
