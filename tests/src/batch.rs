//! Sweeps of small edits for the tests of batches.

use crate::{Bench, Ran, box_scene};
use serde_json::Value;

/// A soft box under a finger, in a scene that is opened and run in a few milliseconds.
pub fn small_scene() -> String {
    let text = box_scene("", "", "[[probe]]\nname = \"deepest\"\nquantity = \"depth\"\ngreatest = true\n");
    let text = text.replace("duration = 0.05", "duration = 0.012").replace("level = 5", "level = 3");
    text.replace(
        "[[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001]",
        "[[0.0, 0.0, 0.0, 0.0045], [0.012, 0.0, 0.0, 0.001]",
    )
}

/// A sweep over stiffness and radius with so many edits: `stiff` times 3.
pub fn small_sweep(stiff: usize, rest: &str) -> String {
    format!(
        "format = 1\nscene = \"scene.toml\"\n\
         [[axis]]\npath = \"body.0.material.params.young\"\n\
         log-range = {{ from = \"5 kPa\", to = \"80 kPa\", count = {stiff} }}\n\
         [[axis]]\npath = \"tool.0.radius\"\nlist = [\"3 mm\", \"4 mm\", \"5 mm\"]\n{rest}"
    )
}

/// A folder with such a scene and sweep.
pub fn small_bench(stiff: usize, rest: &str) -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", small_scene());
    bench.write("sweep.toml", small_sweep(stiff, rest));
    bench
}

/// Runs `pliant batch sweep.toml --quiet` with more arguments.
pub fn run_batch(bench: &Bench, args: &[&str]) -> Ran {
    bench.pliant(&[&["batch", "sweep.toml", "--quiet"], args].concat())
}

/// The table of a folder as objects, one for each row, after collecting it to JSON lines.
///
/// # Panics
/// If a line is no JSON.
pub fn rows(bench: &Bench, folder: &str) -> Vec<Value> {
    bench.pliant(&["batch", "collect", folder, "--output", "rows.jsonl"]).expect(0);
    let text = String::from_utf8(bench.read("rows.jsonl")).expect("UTF-8");
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect()
}
