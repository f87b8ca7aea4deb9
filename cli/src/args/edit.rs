//! Arguments of `pliant edit`.

use super::values::{setting, thread_count};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Arguments of `pliant edit`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant edit model.obj                    sculpt a model with the mouse
  pliant edit scenes/touch.toml            the bodies of a scene, under a hand of the window
  pliant edit model.obj --unit mm --level 5
  pliant edit model.obj --device phantom   sculpt it with an arm, which gives its force back
  pliant edit model.obj --measure 10       what the window costs the haptic loop and the simulation, as JSON

The window is the program `pliant-window`, beside `pliant` or on the path. docs/window.md shows the first ten minutes.")]
pub struct EditArgs {
    /// OBJ file of a model, or TOML file of a scene
    pub path: Option<PathBuf>,
    /// Length of a unit of the file [default: guessed from the size of the model]
    #[arg(long, value_name = "UNIT")]
    pub unit: Option<Unit>,
    /// Level of the grid in a solid: 2^(LEVEL - 1) cells along its longest edge [default: 6]
    #[arg(long, value_name = "LEVEL", value_parser = clap::value_parser!(u32).range(2..=10))]
    pub level: Option<u32>,
    /// Divide large faces of a model until a touch shows; the saved model has the divided faces
    #[arg(long)]
    pub subdivide: bool,
    /// Number of threads; 0 uses all processors
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = thread_count)]
    pub threads: usize,
    /// Device that has the hand in the place of the pointer, as `pliant device list` names it
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,
    /// Parameter of the device; may be given more than once
    #[arg(long, value_name = "KEY=VALUE", requires = "device", value_parser = setting)]
    pub device_set: Vec<(String, String)>,
    /// Samples of a pixel: 0, 2, 4 or 8; 0 is faster without a graphics card [default: 4]
    #[arg(long, value_name = "N", value_parser = ["0", "2", "4", "8"])]
    pub antialias: Option<String>,
    /// Write what happens in the window, a line of JSON for each event
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// Press and stroke the model for so many seconds, print the times of the loops as JSON, and end
    #[arg(long, value_name = "SECONDS", requires = "path", value_parser = clap::value_parser!(u32).range(1..=3600))]
    pub measure: Option<u32>,
    /// Print on the standard error how long the start took, and how soon the picture shows what the pointer does
    #[arg(long)]
    pub timings: bool,
    /// Make the same strokes without a window, to compare with
    #[arg(long, requires = "measure")]
    pub without_window: bool,
}

/// A unit of length of a file.
#[derive(Clone, Copy, ValueEnum)]
pub enum Unit {
    /// Metre
    M,
    /// Centimetre
    Cm,
    /// Millimetre
    Mm,
    /// Inch
    In,
}
