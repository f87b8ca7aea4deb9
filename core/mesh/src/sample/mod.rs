//! Procedural sample models, to try every command without a model file.
//!
//! A cage of quads is smoothed by Catmull-Clark subdivision. The result resembles the export of a modeler: quads, smooth normals, a group and a material for
//! each part, and texture charts.

mod cage;
mod catmull_clark;
mod charts;
mod elephant;

use std::fmt::Write;
use std::iter::zip;

use cage::Cage;
use charts::{Charts, View};

use super::MeshError;
use crate::geometry::Vec3;

/// Names of the samples.
pub const NAMES: [&str; 1] = ["elephant"];

/// Value of `detail` where a scene gives none.
pub const DEFAULT_DETAIL: u32 = 2;

const LONGEST: f64 = 0.1; // m, longest edge of the box

/// A part of an animal.
struct Part {
    group: &'static str,
    material: &'static str,
    view: View,
}

/// The sample `name` as OBJ text in metres, its longest edge 0.1 m: closed, y up, standing on y = 0, looking along
/// +z. Each `detail`, 1 to 5, has four times the quads of the one before; 2 has 8320. Its `mtllib` is `name`
/// with the ending `mtl`: see [`sample_materials`].
///
/// # Errors
/// [`MeshError::Parameter`] for an unknown name or a detail that is not 1 to 5.
pub fn sample(name: &str, detail: u32) -> Result<Vec<u8>, MeshError> {
    need(name)?;
    if !(1..=5).contains(&detail) {
        return Err(MeshError::Parameter { parameter: "detail", found: detail.to_string(), allowed: "1 to 5" });
    }
    let mut cage = elephant::cage();
    for _ in 0..detail {
        cage = catmull_clark::subdivide(&cage);
    }
    stand(&mut cage);
    Ok(text(name, &cage, &elephant::PARTS).into_bytes())
}

/// The material library of the sample `name`, to be written beside it.
///
/// # Errors
/// [`MeshError::Parameter`] for an unknown name.
pub fn sample_materials(name: &str) -> Result<Vec<u8>, MeshError> {
    need(name)?;
    let colours =
        [("skin", "0.50 0.50 0.54"), ("ear", "0.58 0.50 0.52"), ("ivory", "0.93 0.90 0.80"), ("eye", "0.05 0.04 0.04")];
    let library = colours.map(|(material, colour)| format!("newmtl {material}\nKd {colour}\nKs 0.1 0.1 0.1\nNs 20\n"));
    Ok(library.join("\n").into_bytes())
}

fn need(name: &str) -> Result<(), MeshError> {
    if NAMES.contains(&name) {
        return Ok(());
    }
    Err(MeshError::Parameter { parameter: "sample", found: format!("`{name}`"), allowed: "elephant" })
}

/// Scales the cage to its size in metres and places it on the ground with its centre above the origin.
fn stand(cage: &mut Cage) {
    let start = (cage.points[0], cage.points[0]);
    let (min, max) = cage.points.iter().fold(start, |(min, max), point| (min.inf(point), max.sup(point)));
    let foot = Vec3::new(0.5 * (min.x + max.x), min.y, 0.5 * (min.z + max.z));
    let scale = LONGEST / (max - min).max();
    cage.points.iter_mut().for_each(|point| *point = scale * (*point - foot));
}

fn text(name: &str, cage: &Cage, parts: &[Part]) -> String {
    let charts = Charts::new(cage, &parts.iter().map(|part| part.view).collect::<Vec<_>>());
    let mut text = format!(
        "# {name}: a sample made by pliant, free for any use\n# {} vertices, {} quads, closed\n\
         # metres, y up, looking along +z\nmtllib {name}.mtl\no {name}\n",
        cage.points.len(),
        cage.quads.len(),
    );
    // Writing into a String cannot fail.
    for point in &cage.points {
        _ = writeln!(text, "v {:.7} {:.7} {:.7}", point.x, point.y, point.z);
    }
    for [u, v] in &charts.texcoords {
        _ = writeln!(text, "vt {u:.5} {v:.5}");
    }
    for normal in normals(cage) {
        _ = writeln!(text, "vn {:.4} {:.4} {:.4}", normal.x, normal.y, normal.z);
    }
    text.push_str("s 1\n");
    for (index, part) in parts.iter().enumerate() {
        _ = writeln!(text, "g {}\nusemtl {}", part.group, part.material);
        for (quad, texcoords) in zip(&cage.quads, &charts.corners).filter(|(quad, _)| quad.part == index) {
            text.push('f');
            for (v, vt) in zip(quad.corners, texcoords) {
                _ = write!(text, " {}/{}/{}", v + 1, vt + 1, v + 1);
            }
            text.push('\n');
        }
    }
    text
}

/// Unit normal of each point.
fn normals(cage: &Cage) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); cage.points.len()];
    for (index, quad) in cage.quads.iter().enumerate() {
        let normal = cage.normal(index);
        quad.corners.iter().for_each(|&corner| sums[corner as usize] += normal);
    }
    sums.iter().map(Vec3::normalize).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::find_materials;
    use crate::{ObjDocument, Surface, check};

    fn elephant(detail: u32) -> ObjDocument {
        ObjDocument::parse(sample("elephant", detail).unwrap(), "elephant.obj".as_ref()).unwrap()
    }

    #[test]
    fn a_closed_model_of_quads_with_nothing_to_complain_of() {
        for detail in 1..=3 {
            let document = elephant(detail);
            let surface = Surface::from_document(&document);
            assert_eq!(document.face_count(), 520 * 4_usize.pow(detail));
            assert!(document.faces().all(|face| face.corners.len() == 4));
            assert_eq!(check(&surface, &document), []);
            assert_eq!(surface.shells().iter().max(), Some(&0));
            assert_eq!(surface.points.len() + surface.triangles.len(), surface.edges().len() + 2, "Euler number 2");
            assert!(surface.volume() > 5e-5, "turned inside out");
            let bounds = surface.bounds();
            assert!((bounds.longest_edge() - LONGEST).abs() < 1e-6);
            assert_eq!(bounds.min[1], 0.0);
            assert!((bounds.min[0] + bounds.max[0]).abs() < 1e-6);
        }
    }

    #[test]
    fn every_corner_has_its_texture_and_normal() {
        let document = elephant(DEFAULT_DETAIL);
        let normals = Surface::from_document(&document).vertex_normals();
        for face in document.faces() {
            let uv = |i: usize| document.texcoords()[face.corners[i % 4].vt().unwrap() as usize];
            let area: f64 = (0..4).map(|i| uv(i)[0] * uv(i + 1)[1] - uv(i)[1] * uv(i + 1)[0]).sum();
            assert!(area > -1e-5, "line {}: a mirrored texture, {area}", face.line);
            for corner in face.corners {
                let (ours, normal) = (document.normals()[corner.vn().unwrap() as usize], normals[corner.v as usize]);
                assert!(ours.dot(&normal) > 0.9, "line {}", face.line);
            }
        }
        assert!(document.texcoords().iter().flatten().all(|part| (0.0..=1.0).contains(part)));
    }

    #[test]
    fn parts_are_groups_and_their_materials_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("elephant.obj");
        std::fs::write(&path, sample("elephant", 1).unwrap()).unwrap();
        std::fs::write(folder.path().join("elephant.mtl"), sample_materials("elephant").unwrap()).unwrap();
        let document = ObjDocument::read(&path).unwrap();
        assert_eq!(document.groups().len(), elephant::PARTS.len());
        let (uses, warnings) = find_materials(&document);
        assert_eq!((uses.len(), warnings), (4, Vec::new()));
    }

    #[test]
    fn what_there_is_not_is_refused() {
        let unknown = sample("dodo", 2).unwrap_err().to_string();
        assert_eq!(unknown, "sample is `dodo`; allowed: elephant");
        assert!(sample("elephant", 0).is_err() && sample("elephant", 6).is_err() && sample_materials("").is_err());
    }
}
