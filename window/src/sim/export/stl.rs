//! Binary STL.

use pliant_engine::body::Body;
use pliant_record::AtomicFile;
use pliant_solver::Vec3;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// mm in a metre: the unit that programs which read STL expect
const MILLIMETRES: f64 = 1e3;

/// Writes a body as binary STL: 80 bytes of text, the number of triangles, then for each its normal and corners as twelve floats, and two
/// bytes that mean nothing.
pub(super) fn write_stl(body: &Body, path: &Path) -> io::Result<()> {
    let surface = &body.model.surface;
    let seen: Vec<[Vec3; 3]> = (0..surface.triangles.len() as u32)
        .filter_map(|triangle| body.look(triangle))
        .map(|look| look.corners.map(|vertex| body.skin.x[vertex as usize]))
        .collect();
    let mut file = AtomicFile::create_and_clean(path)?;
    {
        let mut out = BufWriter::new(&mut file);
        let mut title = [b' '; 80];
        // Not "solid": that word begins an STL of text.
        title[..22].copy_from_slice(b"binary STL, millimetre");
        out.write_all(&title)?;
        out.write_all(&(seen.len() as u32).to_le_bytes())?;
        for [a, b, c] in seen {
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
            for vector in [normal, MILLIMETRES * a, MILLIMETRES * b, MILLIMETRES * c] {
                for number in vector.iter() {
                    out.write_all(&(*number as f32).to_le_bytes())?;
                }
            }
            out.write_all(&[0, 0])?;
        }
        out.flush()?;
    }
    file.finish()
}
