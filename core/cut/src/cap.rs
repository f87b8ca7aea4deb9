//! Cap surface: the part of a facet that is inside of a body.
//!
//! In the plane of the facet, its intersection lines with the body and its own sides are triangulated. The winding number of the body is computed
//! for one triangle by a ray and propagated across the lines. Where faces of the body lie in the plane, nothing is cut, on whichever side the
//! interior is, so repeating a cut changes nothing.

use std::collections::HashMap;

use super::Vec3;
use super::blade::{Facet, turn};
use super::cut_edges::CutEdges;
use super::error::{Refusal, Refused};
use super::mesh::CutMesh;
use super::plane::{PlaneTriangle, triangulate};
use super::record::NONE;
use super::trace::Trace;

/// A triangulated part of a facet.
pub(super) struct CapSurface {
    pub points: Vec<Point>,
    pub triangles: Vec<PlaneTriangle>,
    /// Winding number of the body around each triangle: 0 outside, 1 inside, 2 where the body overlaps itself.
    pub layers: Vec<u32>,
    /// Each line by its points, lower first.
    pub lines: HashMap<[u32; 2], Line>,
}

/// A point of a cap surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Node of the trace, or [`NONE`] at a corner of the facet inside of a body.
    pub node: u32,
    pub x: Vec3,
    pub flat: [f64; 2],
}

/// A constrained edge of the triangulation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    /// Winding number to its left, seen from its lower node, minus that to its right.
    pub flow: i32,
    /// Its nodes, lower first, if the mesh has edges on it.
    pub nodes: Option<[u32; 2]>,
    /// Whether it is part of a side of the facet.
    rim: bool,
}

const MAX_LAYERS: i32 = 8;

/// Bodies that a facet intersects or lies in.
pub(super) fn bodies(mesh: &CutMesh, trace: &Trace, facet: &Facet) -> Result<Vec<u32>, Refused> {
    let pieces = trace.runs.iter().filter(|run| run.piece.is_some());
    let mut bodies: Vec<u32> = pieces.flat_map(|run| &run.members).map(|member| member.body).collect();
    bodies.sort_unstable();
    bodies.dedup();
    bodies.retain(|&body| (body as usize) < mesh.bodies.len());
    if bodies.len() < mesh.bodies.len() {
        let [a, b, c] = facet.flat;
        let centroid = [0, 1].map(|i| (a[i] + b[i] + c[i]) / 3.0);
        // A ray without a result starts on a face, and the body of that face is intersected already.
        for (body, _) in mesh.bodies_around(facet.lift(centroid)).unwrap_or_default() {
            bodies.push(body);
        }
        bodies.sort_unstable();
        bodies.dedup();
    }
    Ok(bodies)
}

impl CapSurface {
    /// The part of the facet inside of `body`.
    pub fn new(mesh: &CutMesh, trace: &Trace, lines: &CutEdges, facet: &Facet, body: u32) -> Result<Self, Refused> {
        let crossed = |value: usize| Refused { reason: Refusal::Crossed, entity: "lines", value: value as f64 };
        let mut sheet = Self::outline(mesh, trace, facet, body);
        let flat: Vec<[f64; 2]> = sheet.points.iter().map(|point| point.flat).collect();
        let mut pairs: Vec<[u32; 2]> = sheet.lines.keys().copied().collect();
        pairs.sort_unstable();
        sheet.triangles = triangulate(&flat, pairs.iter().copied()).ok_or(crossed(pairs.len()))?;
        sheet.wind(mesh, lines, facet, body)?;
        Ok(sheet)
    }

    /// Points and constrained edges of the triangulation.
    fn outline(mesh: &CutMesh, trace: &Trace, facet: &Facet, body: u32) -> Self {
        let mut sheet = Self { points: Vec::new(), triangles: Vec::new(), layers: Vec::new(), lines: HashMap::new() };
        let mut point_of = HashMap::new();
        let sense = if mesh.bodies[body as usize].inverted { -1 } else { 1 };
        for run in &trace.runs {
            let Some([from, to]) = run.piece else { continue };
            let flows: Vec<i32> = run.members.iter().filter(|m| m.body == body).map(|m| i32::from(m.flow)).collect();
            if flows.is_empty() {
                continue;
            }
            let [a, b] = [from, to].map(|node| {
                *point_of.entry(node).or_insert_with(|| {
                    let at = &trace.nodes[node as usize];
                    sheet.points.push(Point { node, x: at.x, flat: at.flat });
                    sheet.points.len() as u32 - 1
                })
            });
            // The change of the winding number refers to the run from its lower node, a line starts at its lower point.
            let flow = sense * flows.iter().sum::<i32>() * if a < b { 1 } else { -1 };
            let line = sheet.lines.entry([a.min(b), a.max(b)]).or_default();
            line.flow += flow;
            line.nodes = Some([from.min(to), from.max(to)]);
        }
        sheet.add_rim(trace, facet);
        sheet
    }

    /// The facet's corners, and its sides from point to point.
    fn add_rim(&mut self, trace: &Trace, facet: &Facet) {
        let on_mesh = self.points.len();
        let rim_of = |point: &Point| trace.nodes[point.node as usize].rim;
        let corners: [u32; 3] = std::array::from_fn(|corner| {
            let at = |point: &Point| rim_of(point)[corner] == 0 && rim_of(point)[(corner + 2) % 3] == 0;
            self.points[..on_mesh].iter().position(at).unwrap_or_else(|| {
                self.points.push(Point { node: NONE, x: facet.corners[corner], flat: facet.flat[corner] });
                self.points.len() - 1
            }) as u32
        });
        for side in 0..3 {
            let [a, b] = facet.rim(side);
            let along = |point: &Point| (0..2).map(|i| (point.flat[i] - a[i]) * (b[i] - a[i])).sum::<f64>();
            let on_side = |at: &u32| {
                let rim = rim_of(&self.points[*at as usize]);
                rim[side] == 0 && !rim.contains(&-1) && !corners.contains(at)
            };
            let mut way: Vec<u32> = (0..on_mesh as u32).filter(on_side).collect();
            way.sort_by(|&a, &b| along(&self.points[a as usize]).total_cmp(&along(&self.points[b as usize])));
            way.insert(0, corners[side]);
            way.push(corners[(side + 1) % 3]);
            for pair in way.windows(2).filter(|pair| pair[0] != pair[1]) {
                self.lines.entry([pair[0].min(pair[1]), pair[0].max(pair[1])]).or_default().rim = true;
            }
        }
    }

    /// The line on a side of a triangle, and whether the side leads from the line's lower point to the higher; `None` if there is no line.
    pub fn line(&self, flat: usize, side: usize) -> Option<(&Line, bool)> {
        let [a, b] = [self.triangles[flat].corners[side], self.triangles[flat].corners[(side + 1) % 3]];
        Some((self.lines.get(&[a.min(b), a.max(b)])?, a < b))
    }

    /// Computes the winding number of the body around each triangle.
    fn wind(&mut self, mesh: &CutMesh, lines: &CutEdges, facet: &Facet, body: u32) -> Result<(), Refused> {
        let unclear = Refused { reason: Refusal::Undefined, entity: "body", value: f64::from(body) };
        let outside = self.outside();
        let patch = in_plane(mesh, lines, facet, body);
        let region = self.regions();
        let count = region.iter().map(|&r| r as usize + 1).max().unwrap_or(0);
        let mut largest = vec![(0.0, usize::MAX); count];
        for flat in 0..self.triangles.len() {
            let area = self.area(flat);
            let known = &mut largest[region[flat] as usize];
            if !outside[flat] && area > known.0 {
                *known = (area, flat);
            }
        }
        let covered: Vec<bool> = largest
            .iter()
            .map(|&(_, flat)| flat != usize::MAX && patch.iter().any(|corners| holds(corners, self.centroid(flat))))
            .collect();
        let free = (0..count).filter(|&r| largest[r].1 != usize::MAX && !covered[r]);
        let start = free.max_by(|&a, &b| largest[a].0.total_cmp(&largest[b].0)).map(|r| largest[r].1);
        self.layers = vec![0; self.triangles.len()];
        let Some(start) = start else { return Ok(()) };
        let around = mesh.bodies_around(facet.lift(self.centroid(start))).ok_or(unclear)?;
        let winding = around.iter().find(|(known, _)| *known == body).map_or(0, |(_, winding)| *winding);
        let winding = if mesh.bodies[body as usize].inverted { -winding } else { winding };
        let mut known: Vec<Option<i32>> = vec![None; self.triangles.len()];
        known[start] = Some(winding);
        let mut waiting = vec![start];
        while let Some(flat) = waiting.pop() {
            let here = known[flat].unwrap_or(0);
            for side in 0..3 {
                let neighbour = self.triangles[flat].neighbours[side];
                if neighbour == NONE || outside[neighbour as usize] {
                    continue;
                }
                let flow =
                    self.line(flat, side).map_or(0, |(line, upward)| if upward { line.flow } else { -line.flow });
                let there = here - flow;
                match known[neighbour as usize] {
                    None => {
                        known[neighbour as usize] = Some(there);
                        waiting.push(neighbour as usize);
                    }
                    Some(other) if other != there => return Err(unclear),
                    Some(_) => {}
                }
            }
        }
        for flat in 0..self.triangles.len() {
            let winding = known[flat].unwrap_or(0);
            if winding > MAX_LAYERS {
                return Err(unclear);
            }
            if !outside[flat] && !covered[region[flat] as usize] {
                self.layers[flat] = winding.max(0) as u32;
            }
        }
        Ok(())
    }

    /// Whether each triangle lies outside of the facet.
    fn outside(&self) -> Vec<bool> {
        let mut outside = vec![false; self.triangles.len()];
        let rim = |flat: usize, side: usize| self.line(flat, side).is_some_and(|(line, _)| line.rim);
        let on_hull =
            |flat: usize| (0..3).any(|side| self.triangles[flat].neighbours[side] == NONE && !rim(flat, side));
        let mut waiting: Vec<usize> = (0..self.triangles.len()).filter(|&flat| on_hull(flat)).collect();
        while let Some(flat) = waiting.pop() {
            if std::mem::replace(&mut outside[flat], true) {
                continue;
            }
            let sides = (0..3).filter(|&side| self.triangles[flat].neighbours[side] != NONE && !rim(flat, side));
            waiting.extend(sides.map(|side| self.triangles[flat].neighbours[side] as usize));
        }
        outside
    }

    /// Region of each triangle: triangles with no line between them share a region.
    fn regions(&self) -> Vec<u32> {
        let mut region = vec![NONE; self.triangles.len()];
        let mut count = 0;
        for seed in 0..self.triangles.len() {
            if region[seed] != NONE {
                continue;
            }
            let mut waiting = vec![seed];
            while let Some(flat) = waiting.pop() {
                if std::mem::replace(&mut region[flat], count) != NONE {
                    continue;
                }
                let sides = (0..3).filter(|&side| self.line(flat, side).is_none());
                let neighbour = sides.map(|side| self.triangles[flat].neighbours[side]);
                waiting.extend(
                    neighbour.filter(|&flat| flat != NONE && region[flat as usize] == NONE).map(|f| f as usize),
                );
            }
            count += 1;
        }
        region
    }

    pub fn area(&self, flat: usize) -> f64 {
        let [a, b, c] = self.triangles[flat].corners.map(|point| self.points[point as usize].flat);
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    }

    fn centroid(&self, flat: usize) -> [f64; 2] {
        let corners = self.triangles[flat].corners.map(|point| self.points[point as usize].flat);
        [0, 1].map(|i| corners.iter().map(|corner| corner[i]).sum::<f64>() / 3.0)
    }
}

/// Triangles of the body that lie in the plane, in the frame of the facet.
fn in_plane(mesh: &CutMesh, lines: &CutEdges, facet: &Facet, body: u32) -> Vec<[[f64; 2]; 3]> {
    let flat = |triangle: u32| mesh.corners_of(triangle).map(|corner| facet.flatten(corner));
    lines.flat.iter().filter(|&&triangle| mesh.body[triangle as usize] == body).map(|&t| flat(t)).collect()
}

fn holds([a, b, c]: &[[f64; 2]; 3], point: [f64; 2]) -> bool {
    let turns = [turn(*a, *b, point), turn(*b, *c, point), turn(*c, *a, point)];
    !(turns.contains(&1) && turns.contains(&-1))
}
