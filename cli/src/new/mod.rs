//! `pliant plugin new`: writes a project outside of this tree that builds, passes its tests and runs a scene as it is.

mod templates;

use crate::args::{Cli, Language, NewArgs, NewKind};
use crate::outcome::{Failure, Outcome};
use crate::output::{note, print_json};
use serde_json::json;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::fs;
use std::path::{Path, PathBuf};

/// Folder that this program was built from.
const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Writes the project.
pub fn new(cli: &Cli, args: &NewArgs) -> Result<Outcome, Failure> {
    let placeholders = Placeholders::new(args)?;
    let folder = args.out.clone().unwrap_or_else(|| PathBuf::from(&args.name));
    if folder.exists() && folder.read_dir().map_or(true, |mut entries| entries.next().is_some()) {
        return Err(Failure::input(format!(
            "{} exists already and is not empty; --out gives another folder",
            folder.display()
        )));
    }
    let files = templates::files(args.kind, args.lang);
    for (path, template) in &files {
        let path = folder.join(placeholders.fill(path));
        fs::create_dir_all(path.parent().unwrap_or(&folder)).map_err(|e| write_failure(&path, &e))?;
        fs::write(&path, placeholders.fill(template)).map_err(|e| write_failure(&path, &e))?;
    }
    let build = if args.lang == Language::Rust { "cargo test && cargo build --release" } else { "make test" };
    if cli.json {
        let names: Vec<String> = files.iter().map(|(path, _)| placeholders.fill(path)).collect();
        print_json(&json!({ "folder": folder, "files": names, "build": build }))?;
        return Ok(Outcome::Done);
    }
    note(&format!("{}: read its README.md; next: cd {} && {build}", folder.display(), folder.display()));
    Ok(Outcome::Done)
}

/// A file that cannot be read or written.
fn write_failure(path: &Path, error: &std::io::Error) -> Failure {
    Failure::input(format!("{}: {error}", path.display()))
}

/// Placeholders of the templates and their values.
struct Placeholders(Vec<(&'static str, String)>);

impl Placeholders {
    /// The values for a project.
    fn new(args: &NewArgs) -> Result<Self, Failure> {
        let name = args.name.as_str();
        let is_word = |p: &str| !p.is_empty() && p.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
        if !name.split('-').all(is_word) || !name.starts_with(|c: char| c.is_ascii_lowercase()) {
            return Err(Failure::input(format!("name `{name}`; allowed is lower-case letters, digits and dashes")));
        }
        let snake = name.replace('-', "_");
        let capitalized = |p: &str| p[..1].to_uppercase() + &p[1..];
        let (kind, role) = match args.kind {
            NewKind::Material => ("material", "AsMaterial"),
            NewKind::Grid => ("grid", "AsGrid"),
            NewKind::Device => ("device", "AsDevice"),
            NewKind::ContactLaw => ("contact law", "AsContactLaw"),
        };
        // The scene uses the new plugin in its role, and plugins of this program in the others.
        let plugin_of =
            |kind: NewKind, otherwise: &str| if args.kind == kind { name.to_owned() } else { otherwise.to_owned() };
        let is_cpp = args.lang == Language::Cpp;
        let c_or_cpp = |c: &str, cpp: &str| if is_cpp { cpp.to_owned() } else { c.to_owned() };
        // Keyframes of `scripted`: time (s), then the position (m). The finger goes down and stays.
        let path = "params = { path = [[0.0, 0.0, 0.0, 0.006], [0.1, 0.0, 0.0, -0.002], [0.3, 0.0, 0.0, -0.002]] }\n";
        Ok(Self(vec![
            ("@NAME@", name.to_owned()),
            ("@SNAKE@", snake.clone()),
            ("@TYPE@", name.split('-').map(capitalized).collect()),
            ("@KIND@", kind.to_owned()),
            ("@ROLE@", role.to_owned()),
            ("@LIBRARY@", format!("{DLL_PREFIX}{snake}{DLL_SUFFIX}")),
            ("@PLIANT@", source(args)?),
            ("@FEATURES@", if args.kind == NewKind::Material { ", features = [\"lanes\"]" } else { "" }.into()),
            ("@NULL@", c_or_cpp("NULL", "nullptr")),
            ("@NOEXCEPT@", c_or_cpp("", " noexcept")),
            ("@EXT@", c_or_cpp("c", "cpp")),
            ("@COMPILER@", c_or_cpp("CC", "CXX")),
            ("@STANDARD@", c_or_cpp("c11", "c++17")),
            ("@LANGUAGE@", c_or_cpp("C", "C++")),
            ("@MATERIAL@", plugin_of(NewKind::Material, "mass-spring")),
            ("@GRID@", plugin_of(NewKind::Grid, "octree-grid")),
            ("@DEVICE@", plugin_of(NewKind::Device, "scripted")),
            (
                "@LAW@",
                if args.kind == NewKind::ContactLaw {
                    format!("contact-law = {{ plugin = \"{name}\" }}\n")
                } else {
                    String::new()
                },
            ),
            ("@PATH@", if args.kind == NewKind::Device { String::new() } else { path.to_owned() }),
        ]))
    }

    /// A template with all placeholders replaced.
    fn fill(&self, template: &str) -> String {
        self.0.iter().fold(template.to_owned(), |text, (placeholder, value)| text.replace(placeholder, value))
    }
}

/// The folder with `plugin-api/` in it, for a Rust project's dependency.
fn source(args: &NewArgs) -> Result<String, Failure> {
    let folder = args.pliant.clone().unwrap_or_else(|| PathBuf::from(SOURCE));
    if args.lang != Language::Rust {
        return Ok(String::new());
    }
    if !folder.join("plugin-api/Cargo.toml").is_file() {
        return Err(Failure::input(format!(
            "no plugin-api in {}: a Rust plugin is built with pliant's own source; --pliant DIR says where that is",
            folder.display()
        )));
    }
    let folder = folder.canonicalize().map_err(|e| write_failure(&folder, &e))?;
    Ok(folder.display().to_string().replace('\\', "/"))
}
