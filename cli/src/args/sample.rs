//! Arguments of `pliant sample`.

use clap::Args;
use std::path::PathBuf;

/// Arguments of `pliant sample`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant sample elephant -o elephant.obj
  pliant sample elephant --detail 5 --force")]
pub struct SampleArgs {
    /// Name of the model
    #[arg(default_value = pliant_mesh::sample::NAMES[0], value_parser = pliant_mesh::sample::NAMES.to_vec())]
    pub name: String,
    /// OBJ file to write [default: NAME.obj]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Subdivisions: each quarters the faces
    #[arg(long, default_value_t = pliant_mesh::sample::DEFAULT_DETAIL)]
    pub detail: u32,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}
