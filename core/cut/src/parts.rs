//! Connected components of a mesh.

use super::mesh::CutMesh;
use super::record::OPEN;

/// The connected components of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parts {
    /// Component of each triangle (m); components are numbered in the order of their first triangles.
    pub of: Vec<u32>,
    /// Properties of each component.
    pub all: Vec<Part>,
}

/// A connected component: triangles that are connected by shared edges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// Number of triangles.
    pub triangles: usize,
    /// Sum of the areas of its triangles, m^2.
    pub area: f64,
    /// Volume, m^3; meaningful for closed components alone.
    pub volume: f64,
    /// Whether it has no border edge.
    pub closed: bool,
}

/// A connected part of the surface of a closed body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BodyPart {
    /// Number of the body in the uncut mesh.
    pub body: u32,
    /// Number of the part, in [`CutMesh::parts`].
    pub part: u32,
}

impl BodyPart {
    /// Whether this and another one are different parts of one body.
    pub fn is_parted_from(self, other: Self) -> bool {
        self.body == other.body && self.part != other.part
    }
}

impl CutMesh {
    /// The connected components of the whole mesh. The cost is linear in the number of triangles.
    pub fn parts(&self) -> Parts {
        let count = self.surface.triangles.len();
        let mut parts = Parts { of: vec![u32::MAX; count], all: Vec::new() };
        let mut waiting = Vec::new();
        for seed in 0..count {
            if parts.of[seed] != u32::MAX {
                continue;
            }
            let number = parts.all.len() as u32;
            parts.of[seed] = number;
            waiting.push(seed as u32);
            let origin = self.point(self.surface.triangles[seed][0]);
            let mut part = Part { closed: true, ..Part::default() };
            while let Some(triangle) = waiting.pop() {
                let cross = self.cross(triangle);
                part.triangles += 1;
                part.area += 0.5 * cross.norm();
                part.volume += (self.corners_of(triangle)[0] - origin).dot(&cross) / 6.0;
                for side in 0..3 {
                    let half = 3 * triangle + side;
                    part.closed &= self.link_of(half) != half;
                    for other in self.around(half).skip(1) {
                        if parts.of[other as usize / 3] == u32::MAX {
                            parts.of[other as usize / 3] = number;
                            waiting.push(other / 3);
                        }
                    }
                }
            }
            parts.all.push(part);
        }
        parts
    }

    /// The part of a closed body that each triangle belongs to; `None` for triangles of open surfaces (m).
    pub fn body_parts(&self) -> Vec<Option<BodyPart>> {
        let parts = self.parts().of.into_iter().zip(&self.body);
        parts.map(|(part, body)| (*body != OPEN).then_some(BodyPart { body: *body, part })).collect()
    }
}
