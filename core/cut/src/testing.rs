//! The line of a cut on the skin of a solid, for tests: it ends nowhere if the cut was drawn right through.

use super::CutMesh;
use pliant_mesh::geometry::Vec3;
use std::collections::BTreeMap;

/// Least angle of the skin around a vertex of the line at which the line ends there, rad: almost all around. Beside a line it is half of that.
const LEAST_END_ANGLE: f64 = 1.7 * std::f64::consts::PI;

/// Places of the rest shape where a line of a cut ends on the skin, m.
pub fn line_ends(mesh: &CutMesh) -> Vec<Vec3> {
    let surface = mesh.surface();
    let (mut skin_angles, mut is_cut) = (BTreeMap::<u32, f64>::new(), vec![false; surface.points.len()]);
    for (index, corners) in surface.triangles.iter().enumerate() {
        if mesh.is_cap(index as u32) {
            corners.iter().for_each(|v| is_cut[*v as usize] = true);
            continue;
        }
        let points = corners.map(|v| surface.points[v as usize]);
        for (i, v) in corners.iter().enumerate() {
            let [a, b] = [1, 2].map(|j| points[(i + j) % 3] - points[i]);
            *skin_angles.entry(*v).or_default() += a.angle(&b);
        }
    }
    let is_end = |(v, angle): &(u32, f64)| is_cut[*v as usize] && *angle > LEAST_END_ANGLE;
    skin_angles.into_iter().filter(is_end).map(|(v, _)| surface.points[v as usize]).collect()
}

/// Vertices of the skin that a cut has made or parted.
pub fn line_vertices(mesh: &CutMesh) -> Vec<u32> {
    let surface = mesh.surface();
    let (mut is_cap, mut is_skin) = (vec![false; surface.points.len()], vec![false; surface.points.len()]);
    for (index, corners) in surface.triangles.iter().enumerate() {
        let marks = if mesh.is_cap(index as u32) { &mut is_cap } else { &mut is_skin };
        corners.iter().for_each(|v| marks[*v as usize] = true);
    }
    (0..surface.points.len() as u32).filter(|v| is_cap[*v as usize] && is_skin[*v as usize]).collect()
}
