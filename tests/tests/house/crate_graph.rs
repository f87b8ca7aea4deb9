//! No crate of the workspace depends on another one that the table in `ARCHITECTURE.md` does not allow it, and what may stand in some places
//! alone stands nowhere else.

use pliant_tests::root;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Table;

/// Allowed dependencies of each crate: folders, or `folder/*` for every crate in a folder.
type Allowed = BTreeMap<String, Vec<String>>;

/// The manifest of a folder.
pub(crate) fn manifest(folder: &Path) -> Table {
    let path = folder.join("Cargo.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.parse().unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Folders of the workspace's crates by package name.
pub(crate) fn members() -> BTreeMap<String, String> {
    let workspace = manifest(&root());
    let members = workspace["workspace"]["members"].as_array().expect("a list of members").iter();
    let folders = members.map(|member| member.as_str().expect("a folder").to_owned());
    folders
        .map(|folder| {
            let package = manifest(&root().join(&folder));
            (package["package"]["name"].as_str().expect("a name").to_owned(), folder)
        })
        .collect()
}

/// The names in backticks in one cell of a Markdown table.
fn names(cell: &str) -> Vec<String> {
    cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The table under "Dependencies between crates".
fn table() -> Allowed {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let (_, section) = text.split_once("\n## Dependencies between crates\n").expect("the section");
    let rows = section.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let rows = rows.take_while(|line| line.starts_with('|'));
    rows.map(|row| {
        let cells: Vec<&str> = row.trim_matches('|').split('|').collect();
        let [of, allowed] = cells[..] else { panic!("two columns: {row}") };
        (names(of).pop().unwrap_or_else(|| panic!("a crate in {row}")), names(allowed))
    })
    .collect()
}

/// Whether `pattern` is `folder`, or `parent/*` with `folder` directly in `parent`.
fn covers(pattern: &str, folder: &str) -> bool {
    match pattern.strip_suffix("/*") {
        Some(parent) => folder.rsplit_once('/').is_some_and(|(of, _)| of == parent),
        None => pattern == folder,
    }
}

/// Packages a manifest names under `dependencies` and `build-dependencies`, for any target.
fn dependencies(manifest: &Table) -> Vec<String> {
    let targets = manifest.get("target").and_then(|targets| targets.as_table()).into_iter().flatten();
    let scopes = targets.filter_map(|(_, scope)| scope.as_table()).chain([manifest]);
    let tables = scopes.flat_map(|scope| ["dependencies", "build-dependencies"].map(|key| scope.get(key)));
    let entries = tables.flatten().filter_map(|table| table.as_table()).flatten();
    entries
        .map(|(key, value)| value.get("package").and_then(|package| package.as_str()).unwrap_or(key).to_owned())
        .collect()
}

/// What of the graph the table does not allow, a sentence each.
fn violations(
    manifests: &BTreeMap<String, Table>,
    members: &BTreeMap<String, String>,
    allowed: &Allowed,
) -> Vec<String> {
    let mut wrong = Vec::new();
    for (folder, manifest) in manifests {
        let Some((_, may)) = allowed.iter().find(|(pattern, _)| covers(pattern, folder)) else {
            wrong.push(format!("{folder} has no row in ARCHITECTURE.md"));
            continue;
        };
        for used in dependencies(manifest).iter().filter_map(|package| members.get(package)) {
            if !may.iter().any(|pattern| covers(pattern, used)) {
                wrong.push(format!("{folder} depends on {used}; ARCHITECTURE.md allows {may:?}"));
            }
        }
    }
    wrong
}

#[test]
fn crates_depend_on_what_the_architecture_allows() {
    let (members, allowed) = (members(), table());
    let manifests: BTreeMap<_, _> =
        members.values().map(|folder| (folder.clone(), manifest(&root().join(folder)))).collect();
    let wrong = violations(&manifests, &members, &allowed);
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
    for pattern in allowed.iter().flat_map(|(of, may)| may.iter().chain([of])) {
        assert!(members.values().any(|folder| covers(pattern, folder)), "{pattern} in ARCHITECTURE.md is no crate");
    }
}

/// A forbidden edge is found wherever a manifest can hold one; dev-dependencies are free.
#[test]
fn a_forbidden_edge_is_found() {
    let (members, allowed) = (members(), table());
    let judge = |text: &str| {
        let manifests = BTreeMap::from([("core/mesh".to_owned(), text.parse::<Table>().expect("TOML"))]);
        violations(&manifests, &members, &allowed)
    };
    let engine = "pliant-engine.workspace = true";
    for scope in ["dependencies", "build-dependencies", "target.'cfg(unix)'.dependencies"] {
        assert_eq!(judge(&format!("[{scope}]\n{engine}")).len(), 1, "{scope}");
    }
    assert_eq!(judge("[dependencies]\nother = { package = \"pliant-engine\", path = \"../engine\" }").len(), 1);
    assert!(judge(&format!("[dev-dependencies]\n{engine}")).is_empty());
    assert!(judge("[dependencies]\nnalgebra.workspace = true").is_empty());
}

/// Crates whose results are compared by bytes, the core without what is only shown (reports, windows) and all plugins, deny the functions `clippy.toml` lists.
#[test]
fn crates_deny_floats_that_depend_on_the_platform() {
    let is_shown = |folder: &str| ["core/report", "core/editor"].contains(&folder);
    let compared =
        |folder: &&String| (folder.starts_with("core/") && !is_shown(folder)) || folder.starts_with("plugins/");
    for folder in members().values().filter(compared) {
        let path = root().join(folder).join("src/lib.rs");
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let denies = "#![cfg_attr(not(test), deny(clippy::disallowed_methods))]";
        assert!(text.lines().any(|line| line == denies), "{folder}/src/lib.rs has no line `{denies}`");
    }
}

/// Where vector instructions of one processor may stand; everything else is written once, over these.
const LANES: [&str; 2] = ["plugin-api/src/lanes/", "core/solver/src/lanes/"];

/// Paths of the Rust sources in a folder, relative to the root.
pub(crate) fn sources(folder: &Path, all: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let path = entry.expect("an entry").path();
        if path.is_dir() && !path.ends_with("target") {
            sources(&path, all);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let relative = path.strip_prefix(root()).expect("a path under the root");
            all.push(relative.to_string_lossy().replace('\\', "/"));
        }
    }
}

/// The first line of a source that names instructions or registers of one processor.
fn processor_line(text: &str) -> Option<usize> {
    // Put together, so that this file is not found.
    let names = [["std::", "arch"], ["core::", "arch"], ["pulp::", "x86"], ["._", "mm"]].map(|parts| parts.concat());
    text.lines().position(|line| names.iter().any(|name| line.contains(name.as_str()))).map(|at| at + 1)
}

#[test]
fn vector_instructions_stand_in_lanes_alone() {
    let mut all = Vec::new();
    for folder in members().into_values().chain(["window", "python", "fuzz"].map(str::to_owned)) {
        sources(&root().join(folder), &mut all);
    }
    assert!(LANES.iter().all(|lanes| all.iter().any(|path| path.starts_with(lanes))), "{LANES:?}");
    for path in all.iter().filter(|path| !LANES.iter().any(|lanes| path.starts_with(lanes))) {
        let text = std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
        if let Some(line) = processor_line(&text) {
            panic!("{path}:{line} names one processor's instructions; they are allowed in {LANES:?} alone");
        }
    }
}
