//! A body under a blade: its mesh is cut, and everything that hangs on the mesh takes the cut over.

use super::sheet::Before;
use super::{Body, Discretization, LatticeError};
use pliant_cut::{Advance, CutMesh, Origin};
use pliant_mesh::Surface;
use pliant_solver::Vec3;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// How far before a cut surface a vertex of it is looked for, in edges of a cell: enough to tell the side of a cut it is on.
const INSIDE: f64 = 1e-6;
/// How far along its skin one is that is not of the cut surface alone.
const BESIDE: f64 = 0.01;
/// The same where a surface has no inside, and vertices close to a cut may have been taken as on it.
const ASIDE: f64 = 0.1;
/// How far a cut goes on outside of the body, in edges of a cell: a straight line between two places inside may pass outside.
const CUT_MARGIN: f64 = 0.1;

/// Where the apron of a cut ends that begins at a place of the surface, by the bits of the place.
pub type CutMargins = HashMap<[u64; 3], Vec3>;

impl Body {
    /// Takes over what an advance of a blade has done to the mesh. Nodes of a lattice are copied with the next
    /// [`super::Lattice::follow`], those of a sheet at once.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn take_cut(&mut self, advance: &Advance) -> Result<(), LatticeError> {
        let Some(mesh) = &self.cut else { return Ok(()) };
        let mut settled = std::mem::take(&mut self.skin.settled);
        let list = Arc::make_mut(&mut settled);
        for vertex in advance.first_vertex..mesh.surface().points.len() as u32 {
            let place = mesh.surface().points[vertex as usize];
            let kept = |v: u32| list[v as usize] - mesh.surface().points[v as usize];
            let moved = match (mesh.origin(vertex), &self.discretization) {
                (Origin::Edge { ends, t }, _) => {
                    let [from, to] = ends.map(kept);
                    from + t * (to - from)
                }
                (Origin::Face { corners, weights }, _) => super::interpolate(corners.map(kept), weights),
                (Origin::Copy { of }, _) => kept(of),
                (Origin::Cap { .. }, Discretization::Lattice(lattice)) => lattice.kept_at(place)?,
                _ => Vec3::zeros(),
            };
            list.push(place + moved);
        }
        let triangles = &self.model.surface.triangles;
        let before: Before = advance.changed.iter().filter_map(|t| Some((*t, *triangles.get(*t as usize)?))).collect();
        Arc::make_mut(&mut self.model).take_cut(mesh.surface(), &advance.changed);
        let new = advance.first_triangle..mesh.surface().triangles.len() as u32;
        let moved: Vec<u32> = advance.changed.iter().copied().chain(new.clone()).collect();
        self.skin.take_cut(&self.model, settled, &moved, 0..0);
        let lattice = match &mut self.discretization {
            Discretization::Lattice(lattice) => lattice,
            Discretization::Sheet(sheet) => {
                sheet.take_cut(mesh, advance, &before, &mut self.system)?;
                sheet.embed(&self.system.nodes, &mut self.skin);
                return Ok(());
            }
        };
        let caps = caps(mesh, new, &advance.facets, CUT_MARGIN * lattice.edge(), &mut self.cut_margins);
        let closed = !caps.is_empty();
        let swept = if closed { &caps } else { &advance.facets };
        let (model, edge) = (&self.model, lattice.edge());
        let side = |vertex: u32| beside(mesh, model, vertex, closed, edge);
        let new = advance.first_vertex..mesh.surface().points.len() as u32;
        let neighbours = |vertex: u32| {
            let around = model.around(vertex).iter().flat_map(|t| model.surface.triangles[*t as usize]);
            around.filter(|other| *other != vertex).collect()
        };
        let cells = lattice.cut(swept, new, side, neighbours, mesh.as_ref())?;
        if !self.samples.is_empty() {
            Arc::make_mut(&mut self.samples).take_cut(&cells, &self.model, &self.skin, lattice)?;
        }
        Ok(())
    }
}

impl super::Inner for CutMesh {
    fn near(&self, centre: Vec3, reach: f64) -> Vec<[Vec3; 3]> {
        self.triangles_near(centre, reach)
    }

    fn has(&self, place: Vec3) -> bool {
        self.encloses(place)
    }
}

/// The new cut surface inside of the body, one wall of two, and cut_margins around it outside. It goes through the very vertices
/// of the mesh, so no vertex is on another side of the lattice's cut than of the mesh's.
fn caps(
    mesh: &CutMesh,
    new: std::ops::Range<u32>,
    facets: &[[Vec3; 3]],
    apron: f64,
    known: &mut CutMargins,
) -> Vec<[Vec3; 3]> {
    let Some(facet) = facets.first() else { return Vec::new() };
    let forward = cross(facet);
    let surface = mesh.surface();
    let corners = |t: u32| surface.triangles[t as usize].map(|v| surface.points[v as usize]);
    let wall: Vec<u32> = new.filter(|t| mesh.is_cap(*t) && cross(&corners(*t)).dot(&forward) > 0.0).collect();
    let mut rims: Vec<[u32; 2]> = Vec::new();
    let mut outward: BTreeMap<u32, Vec3> = BTreeMap::new();
    for &t in &wall {
        let vertices = surface.triangles[t as usize];
        for (side, other) in mesh.neighbours(t).into_iter().enumerate() {
            if mesh.is_cap(other) {
                continue;
            }
            let ends = [vertices[side], vertices[(side + 1) % 3]];
            let [from, to] = ends.map(|v| surface.points[v as usize]);
            let out = (to - from).cross(&cross(&corners(t))).try_normalize(0.0).unwrap_or_default();
            ends.iter().for_each(|v| *outward.entry(*v).or_default() += out);
            rims.push(ends);
        }
    }
    // Where an advance goes on, it hems on to the apron of the one before.
    let mut end = |v: u32| {
        let place = surface.points[v as usize];
        let out = outward[&v].try_normalize(0.0).unwrap_or_default();
        *known.entry(place.map(f64::to_bits).into()).or_insert_with(|| place + apron * out)
    };
    let mut swept: Vec<[Vec3; 3]> = wall.iter().map(|t| corners(*t)).collect();
    for [a, b] in rims {
        let [p, q] = [a, b].map(|v| surface.points[v as usize]);
        swept.extend([[p, end(a), end(b)], [p, end(b), q]]);
    }
    swept
}

fn cross([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a))
}

/// A rest place beside a vertex, on its own side of all cuts: towards its own triangles of the skin, which no cut passes; or
/// in front of the cut surface it lies on. Not along a mean normal: where the skin leans over the cut, that is on its other
/// side.
fn beside(mesh: &CutMesh, model: &super::Model, vertex: u32, closed: bool, edge: f64) -> Vec3 {
    let surface: &Surface = &model.surface;
    let place = surface.points[vertex as usize];
    let corners = |t: u32| surface.triangles[t as usize].map(|v| surface.points[v as usize]);
    let around = model.around(vertex).iter().copied();
    let (mut aside, mut count) = (Vec3::zeros(), 0.0);
    for t in around.clone().filter(|t| !mesh.is_cap(*t)) {
        aside = corners(t).iter().fold(aside, |sum, p| sum + 1.0 / 3.0 * (*p - place));
        count += 1.0;
    }
    if count == 0.0 {
        let normal: Vec3 = around.map(|t| cross(&corners(t)).try_normalize(0.0).unwrap_or_default()).sum();
        return place - INSIDE * edge * normal.try_normalize(1e-6).unwrap_or_default();
    }
    let length = aside.norm();
    let most = if closed { BESIDE } else { ASIDE } * edge;
    if length > most * count { place + most / length * aside } else { place + 1.0 / count * aside }
}
