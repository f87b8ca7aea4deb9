//! Cutting of a body: after its mesh was cut, model, skin, discretization and samples adopt the cut.

use super::lattice::VoxelParts;
use super::sheet::OldCorners;
use super::stitch::Stitched;
use super::{Body, Discretization, LatticeError};
use pliant_cut::{Advance, CutMesh, Origin};
use pliant_mesh::Surface;
use pliant_solver::Vec3;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Distance from a cap, in edges of a cell, at which the side of one of its vertices is evaluated.
const CAP_OFFSET: f64 = 1e-6;
/// The same for a vertex inside of a cap: the cap may have moved off the path of the blade by up to 0.75 of that when it was refined.
const INNER_CAP_OFFSET: f64 = 0.05;
/// Longest edge inside of a cut surface, in edges of a cell: dents are not finer, as they are those of the cells.
const LONGEST_CAP_EDGE: f64 = 0.75;
/// Largest distance along the surface, in edges of a cell, at which the side of any other vertex is evaluated.
const SURFACE_OFFSET: f64 = 0.01;
/// [`SURFACE_OFFSET`] of an open surface, where vertices close to a cut may have been snapped onto it.
const OPEN_SURFACE_OFFSET: f64 = 0.1;
/// Width of the margin of a cut outside of the body, in edges of a cell: a segment between two points inside may pass outside.
const CUT_MARGIN: f64 = 0.1;

/// Outer end of the margin of a cut (m) for each vertex on its border, by the bits of the vertex's rest position. Advances of one stroke
/// share it, so that their margins meet.
pub type CutMargins = HashMap<[u64; 3], Vec3>;

impl Body {
    /// Adopts the changes that an advance of a blade has made to the mesh. Nodes of a lattice are copied with the next
    /// [`super::Lattice::follow`], those of a sheet at once.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn take_cut(&mut self, advance: &Advance) -> Result<(), LatticeError> {
        self.withdraw_exposed_faces();
        let Some(mesh) = &self.cut else { return Ok(()) };
        let mut settled = std::mem::take(&mut self.skin.settled);
        let list = Arc::make_mut(&mut settled);
        for vertex in advance.first_vertex..mesh.surface().points.len() as u32 {
            let place = mesh.surface().points[vertex as usize];
            // Displacement of the present rest shape from that of the file.
            let offset = |v: u32| list[v as usize] - mesh.surface().points[v as usize];
            let offset = match (mesh.origin(vertex), &self.discretization) {
                (Origin::Edge { ends, t }, _) => {
                    let [from, to] = ends.map(offset);
                    from + t * (to - from)
                }
                (Origin::Face { corners, weights }, _) => super::interpolate(corners.map(offset), weights),
                (Origin::Copy { of }, _) => offset(of),
                (Origin::Cap { .. }, Discretization::Lattice(lattice)) => lattice.rest_offset_at(place)?,
                (Origin::Original, _) | (Origin::Cap { .. }, Discretization::Sheet(_)) => Vec3::zeros(),
            };
            list.push(place + offset);
        }
        let triangles = &self.model.surface.triangles;
        let old_corners: OldCorners =
            advance.changed.iter().filter_map(|t| Some((*t, *triangles.get(*t as usize)?))).collect();
        Arc::make_mut(&mut self.model).take_cut(mesh.surface(), &advance.changed);
        let new = advance.first_triangle..mesh.surface().triangles.len() as u32;
        let moved: Vec<u32> = advance.changed.iter().copied().chain(new.clone()).collect();
        self.skin.take_cut(&self.model, settled, &moved, 0..0);
        let lattice = match &mut self.discretization {
            Discretization::Lattice(lattice) => lattice,
            Discretization::Sheet(sheet) => {
                sheet.take_cut(mesh, advance, &old_corners, &mut self.system)?;
                sheet.embed(&self.system.nodes, &mut self.skin);
                return self.update_tints();
            }
        };
        let caps = caps(mesh, new, &advance.facets, CUT_MARGIN * lattice.edge(), &mut self.cut_margins);
        let closed = !caps.is_empty();
        // Caps are inside of closed parts of the model. Cells of an open part that stands out from these, as an eye does, are swept by the blade alone.
        let has_cut_open = advance.changed.iter().any(|triangle| mesh.is_open(*triangle));
        let mut swept = caps;
        if !closed || has_cut_open {
            swept.extend_from_slice(&advance.facets);
        }
        let (model, edge) = (&self.model, lattice.edge());
        let side = |vertex: u32| side_point(mesh, model, vertex, closed, edge);
        let new = advance.first_vertex..mesh.surface().points.len() as u32;
        let neighbours = |vertex: u32| neighbours(model, vertex);
        let cells = lattice.cut(&swept, new, side, neighbours, mesh.as_ref())?;
        // A refinement sweeps nothing, and leaves the surface where it was.
        if !swept.is_empty() && !self.samples.is_empty() {
            Arc::make_mut(&mut self.samples).take_cut(&cells, &self.model, &self.skin, lattice)?;
        }
        self.update_tints()
    }
}

impl Body {
    /// After a cut: gives the cut surfaces of a solid vertices inside, so that they can be deformed like the surface around them.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub(crate) fn refine_cut_surfaces(&mut self) -> Result<(), LatticeError> {
        let (Some(mesh), Discretization::Lattice(lattice)) = (&mut self.cut, &self.discretization) else {
            return Ok(());
        };
        if let Some(refined) = mesh.refine_cut_surfaces(LONGEST_CAP_EDGE * lattice.edge()) {
            self.take_cut(&refined)?;
            Arc::make_mut(&mut self.skin.tree).regroup();
        }
        Ok(())
    }

    /// After a cut: has the grid carry each part of a closed surface by a part of its own, where it can. What the blade has missed between voxels is parted by
    /// where they are, first in cells that it has cut and then in others where parts lie side by side, and points follow their part.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(crate) fn part_by_surface(&mut self) -> Result<(), LatticeError> {
        let Self { cut: Some(mesh), discretization: Discretization::Lattice(lattice), model, .. } = self else {
            return Ok(());
        };
        if !lattice.has_cuts() {
            return Ok(());
        }
        let (part_of, edge) = (mesh.body_parts(), lattice.edge());
        let around = |points: &[Vec3]| mesh.parts_around(points, &part_of);
        let near = |centre: Vec3| mesh.parts_near(centre, 0.5 * edge, &part_of);
        let side = |vertex: u32| side_point(mesh, model, vertex, true, edge);
        let neighbours = |vertex: u32| neighbours(model, vertex);
        let (mut between, mut known) = (Vec::new(), VoxelParts::default());
        while lattice.joins_parts(mesh.surface(), &part_of)? {
            let cells = lattice.part_by_surface(&between, &mut known, around, side, neighbours, mesh.as_ref())?;
            if !cells.is_empty() && !self.samples.is_empty() {
                Arc::make_mut(&mut self.samples).take_cut(&cells, model, &self.skin, lattice)?;
            }
            between = lattice.cells_between_parts(mesh.surface(), &part_of, around, near)?;
            if between.is_empty() {
                break;
            }
        }
        // A body that is simulated as a whole sees to that with every change of its nodes.
        if !lattice.is_whole() {
            lattice.rebind_torn_shells(model)?;
        }
        Ok(())
    }

    /// Joins the parts of a cut lattice within `radius` (m) of a rest position (m), where they are within `join` (m) of each other.
    pub(super) fn heal(&mut self, point: Vec3, radius: f64, join: f64) -> Result<Stitched, LatticeError> {
        let Self { cut: Some(mesh), discretization: Discretization::Lattice(lattice), model, system, .. } = self else {
            return Ok(Stitched::default());
        };
        let parted = lattice.parted_cells(point, radius, join, &system.nodes);
        let edge = lattice.edge();
        let side = |vertex: u32| side_point(mesh, model, vertex, true, edge);
        let neighbours = |vertex: u32| neighbours(model, vertex);
        let cells = lattice.heal(&parted.near, point, radius, side, neighbours, &mut system.nodes)?;
        if cells.is_empty() {
            return Ok(Stitched { has_joined: false, apart: parted.apart });
        }
        if !self.samples.is_empty() {
            Arc::make_mut(&mut self.samples).take_cut(&cells, model, &self.skin, lattice)?;
        }
        Ok(Stitched { has_joined: true, apart: Vec::new() })
    }
}

/// Vertices that share a triangle with a vertex.
fn neighbours(model: &super::Model, vertex: u32) -> Vec<u32> {
    let around = model.around(vertex).iter().flat_map(|t| model.surface.triangles[*t as usize]);
    around.filter(|other| *other != vertex).collect()
}

impl super::BodyInterior for CutMesh {
    fn triangles_near(&self, centre: Vec3, half_size: f64) -> Vec<[Vec3; 3]> {
        self.triangles_near(centre, half_size)
    }

    fn contains(&self, point: Vec3) -> bool {
        self.encloses(point)
    }
}

/// Triangles (m) by which the lattice is cut: of the two coincident caps among the `new` triangles the one that faces along the blade's
/// first facet, and a strip of `margin` (m) around it outside of the body. They have the vertices of the mesh, so that every vertex is on
/// the same side of the cut in lattice and mesh. `ends` gets the outer ends of the strip.
fn caps(
    mesh: &CutMesh,
    new: std::ops::Range<u32>,
    facets: &[[Vec3; 3]],
    margin: f64,
    ends: &mut CutMargins,
) -> Vec<[Vec3; 3]> {
    let Some(facet) = facets.first() else { return Vec::new() };
    let forward = cross(facet);
    let surface = mesh.surface();
    let corners = |t: u32| surface.triangles[t as usize].map(|v| surface.points[v as usize]);
    let cap: Vec<u32> = new.filter(|t| mesh.is_cap(*t) && cross(&corners(*t)).dot(&forward) > 0.0).collect();
    let mut border: Vec<[u32; 2]> = Vec::new();
    let mut outward: BTreeMap<u32, Vec3> = BTreeMap::new();
    for &t in &cap {
        let vertices = surface.triangles[t as usize];
        for (side, other) in mesh.neighbours(t).into_iter().enumerate() {
            if mesh.is_cap(other) {
                continue;
            }
            let edge = [vertices[side], vertices[(side + 1) % 3]];
            let [from, to] = edge.map(|v| surface.points[v as usize]);
            let out = (to - from).cross(&cross(&corners(t))).try_normalize(0.0).unwrap_or_default();
            edge.iter().for_each(|v| *outward.entry(*v).or_default() += out);
            border.push(edge);
        }
    }
    // A vertex that an earlier advance has given an end keeps it: the margins of both meet there.
    let mut end = |v: u32| {
        let place = surface.points[v as usize];
        let out = outward[&v].try_normalize(0.0).unwrap_or_default();
        *ends.entry(place.map(f64::to_bits).into()).or_insert_with(|| place + margin * out)
    };
    let mut swept: Vec<[Vec3; 3]> = cap.iter().map(|t| corners(*t)).collect();
    for [a, b] in border {
        let [p, q] = [a, b].map(|v| surface.points[v as usize]);
        swept.extend([[p, end(a), end(b)], [p, end(b), q]]);
    }
    swept
}

/// Twice the area vector of a triangle, m^2.
fn cross([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a))
}

/// A point of the rest shape (m) close to a vertex and on the same side of all cuts. It lies towards the mean centroid of the triangles
/// around the vertex that are no caps, as no cut passes through these; for a vertex of caps alone it lies inside of them. The mean normal
/// would not do: where the surface leans over the cut, it points to the other side.
fn side_point(mesh: &CutMesh, model: &super::Model, vertex: u32, closed: bool, edge: f64) -> Vec3 {
    let surface: &Surface = &model.surface;
    let place = surface.points[vertex as usize];
    let corners = |t: u32| surface.triangles[t as usize].map(|v| surface.points[v as usize]);
    let around = model.around(vertex).iter().copied();
    let (mut sum, mut count) = (Vec3::zeros(), 0.0);
    for t in around.clone().filter(|t| !mesh.is_cap(*t)) {
        sum = corners(t).iter().fold(sum, |sum, p| sum + 1.0 / 3.0 * (*p - place));
        count += 1.0;
    }
    if count == 0.0 {
        let normal: Vec3 = around.map(|t| cross(&corners(t)).try_normalize(0.0).unwrap_or_default()).sum();
        let is_inner = matches!(mesh.origin(vertex), Origin::Edge { .. });
        let offset = if is_inner { INNER_CAP_OFFSET } else { CAP_OFFSET };
        return place - offset * edge * normal.try_normalize(1e-6).unwrap_or_default();
    }
    let length = sum.norm();
    let limit = if closed { SURFACE_OFFSET } else { OPEN_SURFACE_OFFSET } * edge;
    if length > limit * count { place + limit / length * sum } else { place + 1.0 / count * sum }
}
