//! One advance of the blade, whole or not at all.

use std::collections::HashMap;

use super::blade::Facet;
use super::cap::{Sheet, bodies};
use super::lines::{Half, Lines};
use super::mesh::{CutMesh, NONE, OPEN};
use super::part::{Fresh, part, tell_apart};
use super::trace::{Snap, Trace};
use super::{Advance, Blade, Refusal, Refused, Stroke, bind, subdivide};

/// How close is on: at first, when that was refused, and at last: next to nothing, with triangles as sharp as they come. A
/// blade that stuck for good in front of one triangle would be worse than a sharp one.
pub(super) const SNAPS: [Snap; 3] = [
    Snap { on: 2e-3, ends: 2e-3, reach: 0.1, sharpest: 0.1 },
    Snap { on: 0.02, ends: 0.05, reach: 0.1, sharpest: 0.1 },
    Snap { on: 1e-7, ends: 1e-7, reach: 0.1, sharpest: 1e-4 },
];

/// The same for a sheet, whose triangles are elements: what would be a splinter is a step of the cut instead.
pub(super) const SHEET_SNAPS: [Snap; 3] = [
    Snap { on: 0.05, ends: 0.1, reach: 0.2, sharpest: 2.0 },
    Snap { on: 0.02, ends: 0.05, reach: 0.1, sharpest: 1.0 },
    Snap { on: 2e-3, ends: 2e-3, reach: 0.1, sharpest: 0.1 },
];

/// What a facet did.
#[derive(Default)]
struct Done {
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
            self.open_step();
            match self.sweep(&facets, &stroke.seam, snap) {
                Ok(done) => {
                    let after =
                        Stroke { blade: next, seam: done.seam, travel: stroke.travel + stroke.blade.way(&next) };
                    let changed = self.changed().0;
                    let pieces_of = self.pieces_of();
                    if changed.is_empty() {
                        self.drop_step();
                    } else {
                        self.keep_step([stroke.clone(), after.clone()]);
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
                    self.drop_step();
                    refused = refused.or(Some(reason));
                }
            }
        }
        Err(refused.unwrap_or(Refused { reason: Refusal::Broken, entity: "advance", value: 0.0 }))
    }

    fn sweep(&mut self, facets: &[Facet], seam: &[u32], snap: Snap) -> Result<Done, Refused> {
        let mut all = Done { seam: seam.to_vec(), ..Done::default() };
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
    fn cut(&mut self, facet: &Facet, seam: &[u32], snap: Snap) -> Result<Done, Refused> {
        let near = self.near(facet);
        let trace = Trace::new(self, &near, facet, seam, snap);
        let is_last = snap.on <= self.snaps[2].on;
        if let Some(node) = trace.beside_seam.filter(|_| !is_last) {
            return Err(Refused { reason: Refusal::Crossed, entity: "seam at node", value: f64::from(node) });
        }
        let first = self.surface.triangles.len();
        let split = subdivide::subdivide(self, &trace, &near, snap.sharpest)?;
        let first = self.enter(first);
        let lines = Lines::new(self, &trace, &split, facet, snap);
        let mut done = Done { length: self.opened(&trace, &lines), ..Done::default() };
        // All sheets first: hanging one in changes nothing that another asks for.
        let mut sheets = Vec::new();
        for body in bodies(self, &trace, facet)? {
            sheets.push((body, Sheet::new(self, &trace, &lines, facet, body)?));
        }
        lines.open_sheets(self);
        let (mut point_of, mut fresh, mut triangles) = (HashMap::new(), Vec::new(), split.triangles.clone());
        let mut front = Vec::new(); // corners of walls where the strip goes on
        for (body, sheet) in &sheets {
            let walls = bind::hang(self, sheet, &lines, facet, *body);
            done.area += walls.area;
            for (triangle, points) in walls.triangles {
                triangles.push(triangle);
                for corner in 0..3 {
                    let point = points[corner as usize];
                    point_of.insert(3 * triangle + corner, fresh.len() as u32 + point);
                    let node = sheet.points[point as usize].node;
                    let ends = [facet.front, (facet.front + 1) % 3].map(|corner| facet.corners[corner]);
                    let on_front = if node == NONE {
                        ends.contains(&sheet.points[point as usize].x)
                    } else {
                        trace.nodes[node as usize].rim[facet.front] == 0
                    };
                    if on_front {
                        front.push(3 * triangle + corner);
                    }
                }
            }
            fresh.extend(sheet.points.iter().map(|point| Fresh { x: point.x, strip: facet.texture_at(point.flat) }));
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
        done.parted = part(self, &corners, &point_of, &fresh)?;
        done.parted.extend(tell_apart(self, &mut triangles)?);
        self.enter(first);
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
    fn near(&self, facet: &Facet) -> Vec<u32> {
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
    fn opened(&self, trace: &Trace, lines: &Lines) -> f64 {
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
    fn enter(&mut self, first: usize) -> usize {
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
