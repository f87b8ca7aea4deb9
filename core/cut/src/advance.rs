//! One advance of the blade, as a transaction: it succeeds as a whole or leaves the mesh unchanged.

use std::collections::HashMap;

use super::Vec3;
use super::blade::{Blade, Facet, Stroke, longest_side};
use super::cap::{CapSurface, bodies};
use super::cut_edges::{CutEdges, HalfEdgeRef};
use super::error::{Refusal, Refused};
use super::fans::{NewPoint, duplicate_vertices, split_coincident_edges};
use super::mesh::CutMesh;
use super::record::{NONE, OPEN};
use super::snap::SnapTolerances;
use super::stitch::stitch_walls;
use super::subdivide;
use super::trace::Trace;

/// Changes by an advance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Advance {
    /// Area of the new cut surface inside of closed bodies, of one of the two walls, m^2.
    pub area: f64,
    /// Length of the new cut edges on the surface, of one of the two sides, m.
    pub length: f64,
    /// Old triangles that are split or have another vertex or neighbour, ascending.
    pub changed: Vec<u32>,
    /// Index of the first new triangle.
    pub first_triangle: u32,
    /// The old triangle that each new one is a piece of; `u32::MAX` for a triangle of a wall.
    pub pieces_of: Vec<u32>,
    /// Index of the first new vertex.
    pub first_vertex: u32,
    /// Vertices that were separated, each with its copy at the same position.
    pub parted: Vec<[u32; 2]>,
    /// Surface swept by the blade: zero to two triangles in the rest shape, m.
    pub facets: Vec<[Vec3; 3]>,
}

impl Advance {
    /// Whether the mesh changed.
    pub fn has_cut(&self) -> bool {
        !self.changed.is_empty()
    }
}

/// What becomes of a strip that would leave a bridge of a sliver's width or a crumb, once every snapping has been tried.
#[derive(Clone, Copy, PartialEq)]
enum Leftovers {
    /// It is cut, and they stay.
    Allowed,
    /// It is refused. A crumb has less than this volume (m^3).
    Refused(f64),
}

/// Changes by one facet.
#[derive(Default)]
struct FacetCut {
    area: f64,
    length: f64,
    parted: Vec<[u32; 2]>,
    seam: Vec<u32>,
}

/// Distance from a facet up to which triangles are looked at, in longest sides of those that it intersects.
const NEAR: f64 = 0.05;

impl CutMesh {
    /// Cuts along the strip between the stroke's blade and `next`, and moves the stroke there. A blade that moves only along itself cuts nothing
    /// and leaves the stroke unchanged.
    ///
    /// # Errors
    /// [`Refused`] if the cut is impossible. Mesh and stroke are unchanged, so the next advance spans both. If a blade is refused again and again,
    /// a new stroke from its present position leaves the region between uncut.
    pub fn advance(&mut self, stroke: &mut Stroke, next: Blade) -> Result<Advance, Refused> {
        self.advance_with(stroke, next, Leftovers::Allowed)
    }

    /// As [`CutMesh::advance`], but refuses what would leave a bridge of a sliver's width across the cut: where no snapping lets the strip begin exactly
    /// at the end of the last one, or opens all triangles along it. And what would separate a crumb: a part of less than the volume `crumb` (m^3), and than a
    /// hundredth of its body.
    ///
    /// # Errors
    /// As for [`CutMesh::advance`].
    pub fn advance_cleanly(&mut self, stroke: &mut Stroke, next: Blade, crumb: f64) -> Result<Advance, Refused> {
        self.advance_with(stroke, next, Leftovers::Refused(crumb))
    }

    fn advance_with(&mut self, stroke: &mut Stroke, next: Blade, leftovers: Leftovers) -> Result<Advance, Refused> {
        next.check()?;
        let facets = stroke.facets(&next, self.swept_parts(stroke.blade, next));
        let first = [self.surface.triangles.len() as u32, self.surface.points.len() as u32];
        if facets.is_empty() {
            return Ok(Advance { first_triangle: first[0], first_vertex: first[1], ..Advance::default() });
        }
        let mut refused = None;
        for snap in self.snaps {
            self.begin_step();
            match self.sweep(&facets, &stroke.seam, snap, leftovers) {
                Ok(done) => {
                    let after =
                        Stroke { blade: next, seam: done.seam, travel: stroke.travel + stroke.blade.way(&next) };
                    let changed = self.changed().0;
                    let pieces_of = self.pieces_of();
                    if changed.is_empty() {
                        self.revert_step();
                    } else {
                        self.commit_step();
                    }
                    *stroke = after;
                    return Ok(Advance {
                        area: done.area,
                        length: done.length,
                        changed,
                        pieces_of,
                        first_triangle: first[0],
                        first_vertex: first[1],
                        parted: done.parted,
                        facets: facets.iter().map(|facet| facet.corners).collect(),
                    });
                }
                Err(reason) => {
                    self.revert_step();
                    refused = refused.or(Some(reason));
                }
            }
        }
        Err(refused.unwrap_or(Refused { reason: Refusal::Invalid, entity: "advance", value: 0.0 }))
    }

    fn sweep(
        &mut self,
        facets: &[Facet],
        seam: &[u32],
        snap: SnapTolerances,
        leftovers: Leftovers,
    ) -> Result<FacetCut, Refused> {
        let mut all = FacetCut { seam: seam.to_vec(), ..FacetCut::default() };
        for facet in facets {
            let done = self.cut(facet, &all.seam, snap, leftovers)?;
            all.area += done.area;
            all.length += done.length;
            all.parted.extend(done.parted);
            all.seam = done.seam;
        }
        self.verify()?;
        if let Leftovers::Refused(least) = leftovers
            && let Some(volume) = self.crumb(least)
        {
            return Err(Refused { reason: Refusal::Crumb, entity: "part", value: volume });
        }
        self.refit();
        Ok(all)
    }

    /// Cuts with one facet.
    fn cut(
        &mut self,
        facet: &Facet,
        seam: &[u32],
        snap: SnapTolerances,
        leftovers: Leftovers,
    ) -> Result<FacetCut, Refused> {
        let near = self.triangles_near_facet(facet, snap);
        let trace = Trace::new(self, &near, facet, seam, snap);
        let may_bridge = snap.on <= self.snaps[2].on && leftovers == Leftovers::Allowed;
        if let Some(node) = trace.beside_seam.filter(|_| !may_bridge) {
            return Err(Refused { reason: Refusal::Crossed, entity: "seam at node", value: f64::from(node) });
        }
        let first = self.surface.triangles.len();
        let split = subdivide::subdivide(self, &trace, &near, snap.sharpest)?;
        let first = self.index_triangles(first);
        let lines = CutEdges::new(self, &trace, &split, facet, snap);
        let mut done = FacetCut { length: self.cut_length(&trace, &lines), ..FacetCut::default() };
        // All caps are computed first; inserting one changes no input of another.
        let mut caps = Vec::new();
        for body in bodies(self, &trace, facet)? {
            caps.push((body, CapSurface::new(self, &trace, &lines, facet, body)?));
        }
        lines.open_sheets(self);
        let (mut point_of, mut new_points, mut triangles) = (HashMap::new(), Vec::new(), split.triangles.clone());
        let mut front = Vec::new(); // corners of walls on the side where the strip continues
        for (body, cap) in &caps {
            let walls = stitch_walls(self, cap, &lines, facet, *body);
            done.area += walls.area;
            for (triangle, points) in walls.triangles {
                triangles.push(triangle);
                for corner in 0..3 {
                    let point = points[corner as usize];
                    point_of.insert(3 * triangle + corner, new_points.len() as u32 + point);
                    let node = cap.points[point as usize].node;
                    let ends = [facet.front, (facet.front + 1) % 3].map(|corner| facet.corners[corner]);
                    let on_front = if node == NONE {
                        ends.contains(&cap.points[point as usize].x)
                    } else {
                        trace.nodes[node as usize].rim[facet.front] == 0
                    };
                    if on_front {
                        front.push(3 * triangle + corner);
                    }
                }
            }
            new_points
                .extend(cap.points.iter().map(|point| NewPoint { x: point.x, strip: facet.texture_at(point.flat) }));
        }
        if let Some(triangle) = self.left_joined(&trace, &lines, facet).filter(|_| !may_bridge) {
            let value = f64::from(triangle);
            return Err(Refused { reason: Refusal::Invalid, entity: "line at triangle", value });
        }
        let mut corners: Vec<u32> = point_of.keys().copied().collect();
        corners.extend(lines.halves.values().flatten().flat_map(|half| {
            let half = half.half_edge;
            [half, half - half % 3 + (half % 3 + 1) % 3]
        }));
        corners.sort_unstable();
        done.parted = duplicate_vertices(self, &corners, &point_of, &new_points)?;
        done.parted.extend(split_coincident_edges(self, &mut triangles)?);
        self.index_triangles(first);
        done.seam = front.iter().map(|&corner| self.tail(corner)).collect();
        for &triangle in &split.triangles {
            for vertex in self.surface.triangles[triangle as usize] {
                let node = split.node_of(self, &trace, vertex);
                if node != NONE
                    && trace.nodes[node as usize].rim[facet.front] == 0
                    && !trace.nodes[node as usize].rim.contains(&-1)
                {
                    done.seam.push(vertex);
                }
            }
        }
        done.seam.sort_unstable();
        done.seam.dedup();
        Ok(done)
    }

    /// A triangle with a side on a line of the facet, at which a body's interior begins or ends, that is still connected to its neighbour on the
    /// other side of the plane. At the front the next facet may have to open it, at the seam this one. There the two walls of the last facet must not stay connected
    /// to each other either.
    fn left_joined(&self, trace: &Trace, lines: &CutEdges, facet: &Facet) -> Option<u32> {
        if facet.continues
            && let Some(wall) = self.joined_walls(trace, lines)
        {
            return Some(wall);
        }
        let open = trace.runs.iter().filter(|run| !run.is_open_already());
        open.filter(|run| run.members.iter().any(|member| member.flow != 0 && member.body != OPEN)).find_map(|run| {
            let [a, b] = run.piece?;
            let [from, to] = [a, b].map(|node| trace.nodes[node as usize].rim);
            let on_rim = |side: usize| from[side] == 0 && to[side] == 0;
            if (0..3).any(|side| on_rim(side) && !(side == 0 && facet.continues)) {
                return None;
            }
            let halves = lines.halves.get(&[a.min(b), a.max(b)])?;
            let joined = |below: &&HalfEdgeRef| {
                let other = self.link_of(below.half_edge);
                below.side == -1 && halves.iter().any(|above| above.side == 1 && above.half_edge == other)
            };
            halves.iter().find(joined).map(|half| half.half_edge / 3)
        })
    }

    /// A triangle of a wall that is connected to the other wall at the end of the last facet.
    fn joined_walls(&self, trace: &Trace, lines: &CutEdges) -> Option<u32> {
        let on_seam = |node: &u32| trace.nodes[*node as usize].rim[0] == 0;
        let at_seam = trace.runs.iter().filter_map(|run| run.piece).filter(|piece| piece.iter().all(on_seam));
        let halves = at_seam.filter_map(|[a, b]| lines.halves.get(&[a.min(b), a.max(b)])).flatten();
        // New walls have no vertices yet.
        let is_old_wall =
            |half: u32| self.is_cap(half / 3) && !self.surface.triangles[half as usize / 3].contains(&NONE);
        let is_joined = |half: u32| is_old_wall(half) && self.link_of(half) != half && is_old_wall(self.link_of(half));
        halves.map(|half| half.half_edge).find(|half| is_joined(*half)).map(|half| half / 3)
    }

    /// Triangles a facet may intersect, or that have a vertex which may be snapped to it, ascending.
    fn triangles_near_facet(&self, facet: &Facet, snap: SnapTolerances) -> Vec<u32> {
        let mut near = Vec::new();
        self.tree.near_facet(facet.corners, 0.0, |triangle| near.push(triangle));
        let longest = near.iter().map(|t| longest_side(&self.corners_of(*t))).fold(0.0, f64::max);
        let margin = snap.ends.max(NEAR) * longest;
        if margin > 0.0 {
            near.clear();
            self.tree.near_facet(facet.corners, margin, |triangle| near.push(triangle));
        }
        near.sort_unstable();
        near.dedup();
        near
    }

    /// Length of the cut edges on the surface, m.
    fn cut_length(&self, trace: &Trace, lines: &CutEdges) -> f64 {
        let skin = |half: u32| !self.is_cap(half / 3) && !self.is_lid(half / 3);
        let mut sum = 0.0;
        for run in &trace.runs {
            let Some([a, b]) = run.piece else { continue };
            let halves = lines.halves.get(&[a.min(b), a.max(b)]).map_or(&[][..], |halves| halves);
            let sides =
                [-1, 1].map(|side| halves.iter().any(|half| half.side.signum() == side && skin(half.half_edge)));
            if sides == [true; 2]
                && halves.iter().any(|half| skin(half.half_edge) && self.link_of(half.half_edge) != half.half_edge)
            {
                let [a, b] = [a, b].map(|node| trace.nodes[node as usize].x);
                sum += (b - a).norm();
            }
        }
        sum
    }

    /// Inserts the triangles from `first` into the tree and returns their end. The triangles they are pieces of keep their larger boxes until the
    /// advance succeeds.
    pub(super) fn index_triangles(&mut self, first: usize) -> usize {
        for triangle in first as u32..self.surface.triangles.len() as u32 {
            self.tree.set(triangle, self.corners_of(triangle));
        }
        self.surface.triangles.len()
    }

    /// Shrinks the boxes of the old triangles that have become smaller.
    pub(super) fn refit(&mut self) {
        for triangle in self.changed().0 {
            self.tree.set(triangle, self.corners_of(triangle));
        }
    }
}
