//! Generators of closed surfaces.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_4, TAU};

use nalgebra::Vector3;

use super::{Model, need_cells, need_length};
use crate::geometry::Vec3;
use crate::{MeshError, ObjDocument};

/// A box of `size` (m) about the origin, each side `cells` x `cells` quads.
///
/// Vertices are the points of a (`cells` + 1)^3 lattice that lie on the outside, z slowest, x fastest. Faces go side
/// by side: -x, +x, -y, +y, -z, +z; each side has a tile of its own in the texture.
///
/// # Errors
/// [`MeshError::Parameter`] when cells are not 1 to 4096 or a size is not finite and above 0.
pub fn cuboid(cells: u32, size: [f64; 3]) -> Result<ObjDocument, MeshError> {
    need_cells("cells", cells, 1)?;
    for (parameter, length) in ["size x", "size y", "size z"].into_iter().zip(size) {
        need_length(parameter, length)?;
    }
    cube(cells, |place| 0.5 * Vec3::from(size).component_mul(&place)).into_document("box")
}

/// A sphere of `radius` (m) about the origin: a projected [`cuboid`] with the same vertices and faces, so that its quads are similar in size and there are no poles.
///
/// # Errors
/// [`MeshError::Parameter`] when cells are not 1 to 4096 or the radius is not finite and above 0.
pub fn sphere(cells: u32, radius: f64) -> Result<ObjDocument, MeshError> {
    need_cells("cells", cells, 1)?;
    need_length("radius", radius)?;
    let equal_angles = |place: Vec3| place.map(|at| libm::tan(FRAC_PI_4 * at));
    cube(cells, |place| radius * equal_angles(place).normalize()).into_document("sphere")
}

/// A cylinder of `radius` and `height` (m) about the z axis, the origin in its middle: `around` x `along` quads, and
/// a fan of triangles on either end.
///
/// Vertices go ring by ring from the bottom, each ring from +x towards +y; then the middle of the bottom and of the
/// top. Faces: the side ring by ring, the bottom, the top.
///
/// # Errors
/// [`MeshError::Parameter`] when `around` is not 3 to 4096, `along` not 1 to 4096, or a length not finite and above 0.
pub fn cylinder(around: u32, along: u32, radius: f64, height: f64) -> Result<ObjDocument, MeshError> {
    need_cells("around", around, 3)?;
    need_cells("along", along, 1)?;
    need_length("radius", radius)?;
    need_length("height", height)?;
    let mut model = Model::default();
    let direction = |step: u32| {
        let (sin, cos) = libm::sincos(TAU * f64::from(step) / f64::from(around));
        [cos, sin]
    };
    for ring in 0..=along {
        let up = f64::from(ring) / f64::from(along);
        let point = |step| direction(step).map(|part| radius * part);
        model.points.extend((0..around).map(point).map(|[x, y]| Vec3::new(x, y, height * (up - 0.5))));
        model.texcoords.extend((0..=around).map(|step| [f64::from(step) / f64::from(around), 0.5 * up]));
    }
    let vertex = |ring: u32, step: u32| [ring * around + step % around, ring * (around + 1) + step];
    for ring in 0..along {
        for step in 0..around {
            let corners = [(ring, step), (ring, step + 1), (ring + 1, step + 1), (ring + 1, step)];
            model.face(&corners.map(|(ring, step)| vertex(ring, step)));
        }
    }
    for (ring, sense) in [(0, -1.0), (along, 1.0)] {
        let disc = model.texcoords.len() as u32; // a disc of radius 1/4 in the upper half of the texture
        let centre = [0.5 + 0.25 * sense, 0.75];
        let rim = |step| [centre[0] + 0.25 * sense * direction(step)[0], centre[1] + 0.25 * direction(step)[1]];
        model.texcoords.extend((0..around).map(rim).chain([centre]));
        let middle = model.points.len() as u32;
        model.points.push(Vec3::new(0.0, 0.0, 0.5 * sense * height));
        for step in 0..around {
            let [this, next] = [step, (step + 1) % around].map(|step| [ring * around + step, disc + step]);
            let [a, b] = if sense > 0.0 { [this, next] } else { [next, this] };
            model.face(&[a, b, [middle, disc + around]]);
        }
    }
    model.into_document("cylinder")
}

/// The surface of a lattice cube with shared vertices, mapped by `point` from [-1, 1]^3.
fn cube(cells: u32, point: impl Fn(Vec3) -> Vec3) -> Model {
    let mut model = Model::default();
    let mut index = HashMap::new();
    let border = |at: u32| at == 0 || at == cells;
    for z in 0..=cells {
        for y in 0..=cells {
            let step = if border(y) || border(z) { 1 } else { cells };
            for x in (0..=cells).step_by(step as usize) {
                index.insert([x, y, z], model.points.len() as u32);
                model.points.push(point(Vector3::new(x, y, z).map(|at| 2.0 * f64::from(at) / f64::from(cells) - 1.0)));
            }
        }
    }
    for side in 0..6 {
        let (axis, high) = (side / 2, side % 2 == 1);
        let first = model.texcoords.len() as u32;
        for j in 0..=cells {
            for i in 0..=cells {
                let [u, v] = [if high { i } else { cells - i }, j].map(|at| f64::from(at) / f64::from(cells));
                model.texcoords.push([(f64::from(side / 2) + u) / 3.0, (f64::from(side % 2) + v) / 2.0]);
            }
        }
        let corner = |i: u32, j: u32| {
            let mut place = [0; 3];
            place[axis as usize] = if high { cells } else { 0 };
            place[(axis as usize + 1) % 3] = i;
            place[(axis as usize + 2) % 3] = j;
            [index[&place], first + j * (cells + 1) + i]
        };
        for j in 0..cells {
            for i in 0..cells {
                let mut quad = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                if !high {
                    quad.reverse();
                }
                model.face(&quad);
            }
        }
    }
    model
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::{Surface, check};

    /// Closed, outward, one piece, nothing to complain of, and of `volume` within `tolerance` of it.
    #[track_caller]
    fn closed(document: &ObjDocument, volume: f64, tolerance: f64) {
        let surface = Surface::from_document(document);
        assert_eq!(check(&surface, document), []);
        assert_eq!(surface.points.len() + surface.triangles.len(), surface.edges().len() + 2, "Euler number 2");
        assert!((surface.volume() / volume - 1.0).abs() < tolerance, "{} is not {volume}", surface.volume());
        assert!(document.texcoords().iter().flatten().all(|part| (0.0..=1.0).contains(part)));
        assert!(document.faces().all(|face| texture_area(document, face.corners) > 0.0), "a mirrored texture");
    }

    fn texture_area(document: &ObjDocument, corners: &[crate::Corner]) -> f64 {
        let at = |i: usize| document.texcoords()[corners[i % corners.len()].vt().unwrap() as usize];
        (0..corners.len()).map(|i| at(i)[0] * at(i + 1)[1] - at(i)[1] * at(i + 1)[0]).sum()
    }

    #[test]
    fn boxes() {
        for cells in [1, 2, 5] {
            let document = cuboid(cells, [0.1, 0.2, 0.3]).unwrap();
            assert_eq!(document.face_count(), 6 * (cells * cells) as usize);
            assert_eq!(document.positions()[0], Vec3::new(-0.05, -0.1, -0.15));
            closed(&document, 0.006, 1e-13);
        }
    }

    #[test]
    fn spheres_converge_to_second_order() {
        let volume = 4.0 / 3.0 * PI * 8.0;
        closed(&sphere(1, 2.0).unwrap(), volume, 0.7);
        let error = |cells| 1.0 - Surface::from_document(&sphere(cells, 2.0).unwrap()).volume() / volume;
        let order = (error(16) / error(32)).log2();
        assert!((order - 2.0).abs() < 0.02, "{order}");
        closed(&sphere(32, 2.0).unwrap(), volume, 2e-3);
    }

    #[test]
    fn cylinders() {
        for (around, along) in [(3, 1), (24, 7)] {
            let sides = f64::from(around);
            let prism = 0.5 * sides * (TAU / sides).sin() * 0.05 * 0.05 * 0.3;
            closed(&cylinder(around, along, 0.05, 0.3).unwrap(), prism, 1e-12);
        }
    }

    #[test]
    fn impossible_solids_are_refused() {
        assert!(cuboid(0, [1.0; 3]).is_err());
        assert!(cuboid(1, [1.0, -1.0, 1.0]).is_err());
        assert!(sphere(4, f64::NAN).is_err());
        assert_eq!(cylinder(2, 1, 1.0, 1.0).unwrap_err().to_string(), "around is 2; allowed: 3 to 4096");
    }
}
