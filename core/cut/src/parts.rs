//! What hangs together.

use super::mesh::CutMesh;

/// The connected parts of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parts {
    /// Part of each triangle; parts are numbered as triangles first meet them (m).
    pub of: Vec<u32>,
    /// Each part.
    pub all: Vec<Part>,
}

/// Triangles that are connected by edges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// How many.
    pub triangles: usize,
    /// Area, m^2.
    pub area: f64,
    /// m^3; meaningless when the part is not closed.
    pub volume: f64,
    /// Whether no edge is a border.
    pub closed: bool,
}

impl CutMesh {
    /// The connected parts: triangles that share an edge are connected. Looks at the whole mesh.
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
}
