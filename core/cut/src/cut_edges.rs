//! The edges of the mesh along which a facet opens it.

use std::collections::HashMap;

use super::blade::Facet;
use super::mesh::CutMesh;
use super::record::{NONE, OPEN};
use super::snap::SnapTolerances;
use super::subdivide::Split;
use super::trace::Trace;

/// Edges along which the mesh is opened.
pub(super) struct CutEdges {
    /// Half-edges on each piece of an intersection line, by its nodes, lower first.
    pub halves: HashMap<[u32; 2], Vec<HalfEdgeRef>>,
    /// Triangles in the plane.
    pub flat: Vec<u32>,
}

/// A half-edge on an intersection line.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfEdgeRef {
    pub half_edge: u32,
    /// Whether it leads from the lower node to the higher.
    pub upward: bool,
    /// Side of the plane its triangle is on: 1 left, -1 right, 0 in the plane.
    pub side: i8,
}

impl CutEdges {
    pub fn new(mesh: &CutMesh, trace: &Trace, split: &Split, facet: &Facet, snap: SnapTolerances) -> Self {
        let mut halves: HashMap<[u32; 2], Vec<HalfEdgeRef>> =
            trace.runs.iter().filter_map(|run| run.piece).map(|[a, b]| ([a.min(b), a.max(b)], Vec::new())).collect();
        let mut flat = Vec::new();
        if halves.is_empty() {
            return Self { halves, flat };
        }
        for &triangle in &split.triangles {
            let nodes = mesh.surface.triangles[triangle as usize].map(|vertex| split.node_of(mesh, trace, vertex));
            if !nodes.contains(&NONE) {
                flat.push(triangle);
            }
            for side in 0..3 {
                let [from, to] = [nodes[side], nodes[(side + 1) % 3]];
                if from == NONE || to == NONE {
                    continue;
                }
                let Some(known) = halves.get_mut(&[from.min(to), from.max(to)]) else { continue };
                let half = 3 * triangle + side as u32;
                let third = nodes[(side + 2) % 3];
                let side = if third == NONE { trace.third_side(mesh, half, facet, snap) } else { 0 };
                known.push(HalfEdgeRef { half_edge: half, upward: from < to, side });
            }
        }
        Self { halves, flat }
    }

    /// Opens the edges of sheets: separates the triangles below the plane from the others.
    pub fn open_sheets(&self, mesh: &mut CutMesh) {
        let mut all: Vec<_> = self.halves.iter().collect();
        all.sort_unstable_by_key(|(nodes, _)| **nodes);
        for (_, halves) in all {
            let mut open = classes(mesh, halves);
            open.retain(|class| is_open(mesh, class));
            for class in open {
                let (below, above): (Vec<HalfEdgeRef>, Vec<HalfEdgeRef>) =
                    class.iter().partition(|half| half.side == -1);
                if below.is_empty() || above.is_empty() {
                    continue;
                }
                for part in [below, above] {
                    mesh.link_around_edge(&part.iter().map(|half| half.half_edge).collect::<Vec<_>>());
                }
            }
        }
    }
}

/// Half-edges in groups that are linked around one edge.
pub(super) fn classes(mesh: &CutMesh, halves: &[HalfEdgeRef]) -> Vec<Vec<HalfEdgeRef>> {
    let first = |half: &HalfEdgeRef| mesh.around(half.half_edge).min().unwrap_or(half.half_edge);
    let mut keyed: Vec<(u32, HalfEdgeRef)> = halves.iter().map(|half| (first(half), *half)).collect();
    keyed.sort_by_key(|(first, half)| (*first, half.half_edge));
    keyed.chunk_by(|a, b| a.0 == b.0).map(|class| class.iter().map(|(_, half)| *half).collect()).collect()
}

fn is_open(mesh: &CutMesh, class: &[HalfEdgeRef]) -> bool {
    class.first().is_some_and(|half| mesh.body[half.half_edge as usize / 3] == OPEN)
}
