//! `pliant sample`.

use crate::args::{Cli, SampleArgs};
use crate::outcome::{Failure, Outcome};
use crate::output::{note, print_json};
use pliant_mesh::sample::{sample as sample_model, sample_materials};
use pliant_record::{AtomicFile, check_replaceable};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a sample model and its materials.
pub fn sample(cli: &Cli, args: &SampleArgs) -> Result<Outcome, Failure> {
    let obj = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.obj", args.name)));
    let mtl = obj.with_file_name(format!("{}.mtl", args.name));
    let model = sample_model(&args.name, args.detail).map_err(Failure::input)?;
    let materials = sample_materials(&args.name).map_err(Failure::input)?;
    for path in [&obj, &mtl] {
        if path.exists() && !args.force {
            return Err(Failure::input(format!("{} exists already; --force overwrites it", path.display())));
        }
        check_replaceable(path)?;
    }
    write(&mtl, &materials)?;
    write(&obj, &model)?;
    if cli.json {
        print_json(&json!({ "model": obj, "materials": mtl, "bytes": model.len() }))?;
    } else {
        note(&format!("{} and {}", obj.display(), mtl.display()));
    }
    Ok(Outcome::Done)
}

/// Writes a file that appears whole or not at all.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let mut file = AtomicFile::create_and_clean(path)?;
    file.write_all(bytes)?;
    Ok(file.finish()?)
}
