//! The normals of a deformed document.
//!
//! An artist's normals say more than the faces do (smoothing, hard edges), so they are turned with the surface, not
//! made anew.

use std::iter::zip;

use nalgebra::UnitQuaternion;

use super::write::{same_bits, same_length};
use super::{Corner, ObjDocument, WriteError};
use crate::geometry::Vec3;

impl ObjDocument {
    /// The `vn` rows after the vertices went from `rest` to `deformed` (both n x 3, the same units) (k x 3).
    ///
    /// A normal turns by the smallest rotation that takes the area-weighted normal of the faces that name it from
    /// rest to deformed, and keeps its length. It stays bit for bit when none of those faces has a moved vertex. One
    /// `vn` shared by distant faces turns with their mean.
    ///
    /// # Errors
    /// [`WriteError::Length`] when an array has not n rows.
    pub fn deformed_normals(&self, rest: &[Vec3], deformed: &[Vec3]) -> Result<Vec<Vec3>, WriteError> {
        same_length("rest positions", rest, self.positions())?;
        same_length("deformed positions", deformed, self.positions())?;
        let mut around = vec![[Vec3::zeros(); 2]; self.normals().len()]; // rest and deformed, area-weighted (k x 2)
        let mut moved = vec![false; self.normals().len()];
        for face in 0..self.face_count() {
            let corners = self.corners(face);
            let face_moved = corners.iter().any(|c| !same_bits(&rest[c.v as usize], &deformed[c.v as usize]));
            let areas = [rest, deformed].map(|positions| vector_area(corners, positions));
            for vn in corners.iter().filter_map(Corner::vn) {
                moved[vn as usize] |= face_moved;
                around[vn as usize][0] += areas[0];
                around[vn as usize][1] += areas[1];
            }
        }
        let turned = zip(self.normals(), zip(around, moved))
            .map(|(normal, ([rest, deformed], moved))| if moved { turn(*normal, &rest, &deformed) } else { *normal });
        Ok(turned.collect())
    }
}

fn turn(normal: Vec3, from: &Vec3, to: &Vec3) -> Vec3 {
    match UnitQuaternion::rotation_between(from, to) {
        Some(rotation) => rotation * normal,
        None => normal.map(|value| -value), // turned right over: no smallest rotation, but the other side is sure
    }
}

/// Normal of a polygon with its area for length (Newell).
fn vector_area(corners: &[Corner], positions: &[Vec3]) -> Vec3 {
    let at = |corner: &Corner| positions[corner.v as usize];
    let origin = at(&corners[0]);
    let spokes = corners[1..].windows(2).map(|pair| (at(&pair[0]) - origin).cross(&(at(&pair[1]) - origin)));
    0.5 * spokes.sum::<Vec3>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::document;

    /// Two squares side by side in z = 0, each with a normal of its own, and one normal nobody names.
    const TILES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvn 0 0 2\nvn 0.6 0 0.8\nvn 1 1 1\n\
        f 1//1 2//1 3//1 4//1\nf 2//2 5//2 6//2 3//2\n";

    #[test]
    fn a_normal_turns_with_its_faces_and_keeps_its_length() {
        let document = document(TILES);
        let rest = document.positions();
        let mut deformed = rest.to_vec();
        for (vertex, x) in [(1, 0.0), (4, 0.0), (2, 0.0), (5, 0.0)] {
            deformed[vertex] = Vec3::new(x, rest[vertex][1], -rest[vertex][0]); // a quarter turn about y: z to x
        }
        let turned = document.deformed_normals(rest, &deformed).unwrap();
        let near = |a: Vec3, b: Vec3| (a - b).norm() < 1e-14;
        assert!(near(turned[0], Vec3::new(2.0, 0.0, 0.0)), "{turned:?}");
        assert!(near(turned[1], Vec3::new(0.8, 0.0, -0.6)), "{turned:?}");
        assert_eq!(turned[2], Vec3::repeat(1.0));
    }

    #[test]
    fn normals_of_untouched_faces_stay_bit_for_bit() {
        let document = document(TILES);
        let mut deformed = document.positions().to_vec();
        deformed[4][2] = 0.5;
        let turned = document.deformed_normals(document.positions(), &deformed).unwrap();
        assert_eq!(turned[0], document.normals()[0]);
        assert_ne!(turned[1], document.normals()[1]);
    }

    #[test]
    fn turned_over_or_crushed_faces_give_finite_normals() {
        let document = document(TILES);
        let rest = document.positions();
        let over: Vec<_> = rest.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
        assert_eq!(document.deformed_normals(rest, &over).unwrap()[0], Vec3::new(0.0, 0.0, -2.0));
        let crushed = vec![Vec3::zeros(); rest.len()];
        assert_eq!(document.deformed_normals(rest, &crushed).unwrap(), document.normals());
        assert!(document.deformed_normals(rest, &over[1..]).is_err());
    }
}
