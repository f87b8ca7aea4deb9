//! Generated strips whose nodes differ in mass: rows of triangles of two heights, two and two.

use super::catalogue::StabilityCatalogue;
use pliant_record::AtomicFile;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Width of a strip, m.
const WIDTH: f64 = 0.025;
/// Height of its high rows, m.
const ROW_HEIGHT: f64 = 0.025;

/// Path of the mesh whose high and low rows have this ratio of heights.
pub(super) fn graded_mesh_path(folder: &Path, ratio: f64) -> PathBuf {
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    folder.join("meshes").join(format!("graded-{ratio:e}.obj"))
}

/// Writes the meshes that a catalogue needs into a folder.
pub(super) fn write_graded_meshes(catalogue: &StabilityCatalogue, folder: &Path) -> io::Result<()> {
    for point in catalogue.maps.iter().filter(|m| m.graded).flat_map(|m| &m.points) {
        let mut file = AtomicFile::create(&graded_mesh_path(folder, point.value))?;
        file.write_all(graded_mesh(point.value).as_bytes())?;
        file.finish()?;
    }
    Ok(())
}

/// The strip as OBJ text, from the top down: a node between two low rows has `1 / ratio` of the mass of one between two high ones.
fn graded_mesh(ratio: f64) -> String {
    let (mut y, mut text) = (0.0, String::new());
    let rows = [1.0, 1.0, 1.0 / ratio, 1.0 / ratio, 1.0, 1.0, 1.0 / ratio, 1.0 / ratio, 1.0, 1.0];
    let _ = write!(text, "v 0 0 0\nv {WIDTH} 0 0\n");
    for (row, height) in rows.iter().enumerate() {
        y -= ROW_HEIGHT * height;
        let a = 2 * row + 1;
        let _ = write!(text, "v 0 {y:e} 0\nv {WIDTH} {y:e} 0\n");
        let _ = write!(text, "f {} {} {}\nf {} {} {}\n", a + 2, a + 3, a, a + 3, a + 1, a);
    }
    text
}
