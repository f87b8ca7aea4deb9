//! Strips whose nodes differ in mass: rows high and low in turn, two and two.

use super::catalogue::StabilityCatalogue;
use pliant_record::AtomicFile;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// m
const WIDTH: f64 = 0.025;
const HIGH: f64 = 0.025;

/// Where the mesh of a ratio is.
pub(super) fn path(folder: &Path, ratio: f64) -> PathBuf {
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    folder.join("meshes").join(format!("graded-{ratio:e}.obj"))
}

/// Writes the meshes a catalogue needs.
pub(super) fn write(catalogue: &StabilityCatalogue, folder: &Path) -> io::Result<()> {
    for point in catalogue.map.iter().filter(|m| m.graded).flat_map(|m| &m.point) {
        let mut file = AtomicFile::create(&path(folder, point.value))?;
        file.write_all(mesh(point.value).as_bytes())?;
        file.finish()?;
    }
    Ok(())
}

/// OBJ, from the top down: the node between two low rows has `1 / ratio` of the mass of one between two high ones.
fn mesh(ratio: f64) -> String {
    let (mut y, mut text) = (0.0, String::new());
    let rows = [1.0, 1.0, 1.0 / ratio, 1.0 / ratio, 1.0, 1.0, 1.0 / ratio, 1.0 / ratio, 1.0, 1.0];
    let _ = write!(text, "v 0 0 0\nv {WIDTH} 0 0\n");
    for (row, high) in rows.iter().enumerate() {
        y -= HIGH * high;
        let a = 2 * row + 1;
        let _ = write!(text, "v 0 {y:e} 0\nv {WIDTH} {y:e} 0\n");
        let _ = write!(text, "f {} {} {}\nf {} {} {}\n", a + 2, a + 3, a, a + 3, a + 1, a);
    }
    text
}
