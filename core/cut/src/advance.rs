//! One advance of the blade, whole or not at all.

use std::collections::HashMap;

use super::Vec3;
use super::blade::{Blade, Facet, Stroke};
use super::cap::{CapSurface, bodies};
use super::error::{Refusal, Refused};
use super::fans::{NewPoint, split_coincident_edges, split_fans};
use super::lines::{Half, Lines};
use super::mesh::CutMesh;
use super::record::{NONE, OPEN};
use super::snap::SnapTolerances;
use super::stitch::stitch_walls;
use super::subdivide;
use super::trace::Trace;

/// What an advance did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Advance {
    /// New cut surface inside of closed bodies, one wall of two, m^2.
    pub area: f64,
    /// New cut edge on the surface, one side of two, m.
    pub length: f64,
    /// Triangles there were before that are split, or have another vertex or neighbour, rising.
    pub changed: Vec<u32>,
    /// New triangles have this number and above.
    pub first_triangle: u32,
    /// The triangle there was before that each new one is a piece of; `u32::MAX` for one of a wall.
    pub pieces_of: Vec<u32>,
    /// New vertices have this number and above.
    pub first_vertex: u32,
    /// Vertices that came apart, each with the new one at the same place.
    pub parted: Vec<[u32; 2]>,
    /// What the blade swept: triangles in the rest shape, none to two.
    pub facets: Vec<[Vec3; 3]>,
}

impl Advance {
    /// Whether the mesh is other than before.
    pub fn has_cut(&self) -> bool {
        !self.changed.is_empty()
    }
}

/// What a facet did.
#[derive(Default)]
struct FacetCut {
    area: f64,
    length: f64,
    parted: Vec<[u32; 2]>,
    seam: Vec<u32>,
}

impl CutMesh {
    /// Cuts with the strip between the stroke's blade and `next`, and moves the stroke there. A blade that did not move
    /// across itself cuts nothing and leaves the stroke where it is.
    ///
    /// # Errors
    /// [`Refused`] when the cut cannot be made; mesh and stroke are what they were, so the next advance spans both. Where a
    /// blade keeps being refused, a new stroke from where it is now leaves the place behind, uncut.
    pub fn advance(&mut self, stroke: &mut Stroke, next: Blade) -> Result<Advance, Refused> {
        next.check()?;
        let facets = stroke.facets(&next);
        let first = [self.surface.triangles.len() as u32, self.surface.points.len() as u32];
        if facets.is_empty() {
            return Ok(Advance { first_triangle: first[0], first_vertex: first[1], ..Advance::default() });
        }
        let mut refused = None;
        for snap in self.snaps {
            self.begin_step();
            match self.sweep(&facets, &stroke.seam, snap) {
                Ok(done) => {
                    let after =
                        Stroke { blade: next, seam: done.seam, travel: stroke.travel + stroke.blade.way(&next) };
                    let changed = self.changed().0;
                    let pieces_of = self.pieces_of();
                    if changed.is_empty() {
                        self.revert_step();
                    } else {
                        self.commit_step([stroke.clone(), after.clone()]);
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
        Err(refused.unwrap_or(Refused { reason: Refusal::Broken, entity: "advance", value: 0.0 }))
    }

    fn sweep(&mut self, facets: &[Facet], seam: &[u32], snap: SnapTolerances) -> Result<FacetCut, Refused> {
        let mut all = FacetCut { seam: seam.to_vec(), ..FacetCut::default() };
        for facet in facets {
            let done = self.cut(facet, &all.seam, snap)?;
            all.area += done.area;
            all.length += done.length;
            all.parted.extend(done.parted);
            all.seam = done.seam;
        }
        self.verify()?;
        self.refit();
        Ok(all)
    }

    /// Cuts with one facet.
    fn cut(&mut self, facet: &Facet, seam: &[u32], snap: SnapTolerances) -> Result<FacetCut, Refused> {
        let near = self.triangles_near_facet(facet);
        let trace = Trace::new(self, &near, facet, seam, snap);
        let is_last = snap.on <= self.snaps[2].on;
        if let Some(node) = trace.beside_seam.filter(|_| !is_last) {
            return Err(Refused { reason: Refusal::Crossed, entity: "seam at node", value: f64::from(node) });
        }
        let first = self.surface.triangles.len();
        let split = subdivide::subdivide(self, &trace, &near, snap.sharpest)?;
        let first = self.index_triangles(first);
        let lines = Lines::new(self, &trace, &split, facet, snap);
        let mut done = FacetCut { length: self.cut_length(&trace, &lines), ..FacetCut::default() };
        // All caps first: hanging one in changes nothing that another asks for.
        let mut caps = Vec::new();
        for body in bodies(self, &trace, facet)? {
            caps.push((body, CapSurface::new(self, &trace, &lines, facet, body)?));
        }
        lines.open_sheets(self);
        let (mut point_of, mut new_points, mut triangles) = (HashMap::new(), Vec::new(), split.triangles.clone());
        let mut front = Vec::new(); // corners of walls where the strip goes on
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
        if let Some(triangle) = self.left_joined(&trace, &lines, facet).filter(|_| !is_last) {
            let value = f64::from(triangle);
            return Err(Refused { reason: Refusal::Broken, entity: "line at triangle", value });
        }
        let mut corners: Vec<u32> = point_of.keys().copied().collect();
        corners.extend(lines.halves.values().flatten().flat_map(|half| {
            let half = half.half;
            [half, half - half % 3 + (half % 3 + 1) % 3]
        }));
        corners.sort_unstable();
        done.parted = split_fans(self, &corners, &point_of, &new_points)?;
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

    /// A triangle whose side lies on a line of the facet, with the inside of a body to one side of it, and that is still joined
    /// to the one on the other side of the plane. At the front the next facet may have to open it, at the seam this one.
    fn left_joined(&self, trace: &Trace, lines: &Lines, facet: &Facet) -> Option<u32> {
        let open = trace.runs.iter().filter(|run| !run.is_open_already());
        open.filter(|run| run.members.iter().any(|member| member.flow != 0 && member.body != OPEN)).find_map(|run| {
            let [a, b] = run.piece?;
            let [from, to] = [a, b].map(|node| trace.nodes[node as usize].rim);
            let on_rim = |side: usize| from[side] == 0 && to[side] == 0;
            if (0..3).any(|side| on_rim(side) && !(side == 0 && facet.goes_on)) {
                return None;
            }
            let halves = lines.halves.get(&[a.min(b), a.max(b)])?;
            let joined = |below: &&Half| {
                let other = self.link_of(below.half);
                below.side == -1 && halves.iter().any(|above| above.side == 1 && above.half == other)
            };
            halves.iter().find(joined).map(|half| half.half / 3)
        })
    }

    /// Triangles a facet may meet, rising.
    fn triangles_near_facet(&self, facet: &Facet) -> Vec<u32> {
        let mut near = Vec::new();
        self.tree.near_facet(facet.corners, 0.0, |triangle| near.push(triangle));
        let longest = |t: &u32| {
            let [a, b, c] = self.corners_of(*t);
            (b - a).norm().max((c - b).norm()).max((a - c).norm())
        };
        let margin = 0.05 * near.iter().map(longest).fold(0.0, f64::max);
        if margin > 0.0 {
            near.clear();
            self.tree.near_facet(facet.corners, margin, |triangle| near.push(triangle));
        }
        near.sort_unstable();
        near.dedup();
        near
    }

    /// Length of the lines on the skin, m.
    fn cut_length(&self, trace: &Trace, lines: &Lines) -> f64 {
        let skin = |half: u32| !self.is_cap(half / 3) && !self.is_lid(half / 3);
        let mut sum = 0.0;
        for run in &trace.runs {
            let Some([a, b]) = run.piece else { continue };
            let halves = lines.halves.get(&[a.min(b), a.max(b)]).map_or(&[][..], |halves| halves);
            let sides = [-1, 1].map(|side| halves.iter().any(|half| half.side.signum() == side && skin(half.half)));
            if sides == [true; 2] && halves.iter().any(|half| skin(half.half) && self.link_of(half.half) != half.half) {
                let [a, b] = [a, b].map(|node| trace.nodes[node as usize].x);
                sum += (b - a).norm();
            }
        }
        sum
    }

    /// Takes the triangles from `first` on into the tree; gives their end. Those they were cut from keep their wider boxes
    /// until the advance is made.
    fn index_triangles(&mut self, first: usize) -> usize {
        for triangle in first as u32..self.surface.triangles.len() as u32 {
            self.tree.set(triangle, self.corners_of(triangle));
        }
        self.surface.triangles.len()
    }

    /// Fits the boxes of the old triangles that are smaller now.
    fn refit(&mut self) {
        for triangle in self.changed().0 {
            self.tree.set(triangle, self.corners_of(triangle));
        }
    }
}
