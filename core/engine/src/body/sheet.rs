//! A sheet: a body simulated on its own mesh. Vertices are the nodes; triangles, edges and hinges are the elements. For cloth and other
//! thin shells.

use super::failed_triangles::FailedTriangles;
use super::fields::Fields;
use super::fixing::Fixing;
use super::lattice::{DrivenNode, LatticeError, check_mass, constrain_fixed, drive_fixed, kind_name};
use super::model::Model;
use super::skin::{EmbeddedPoint, NearestTriangle, Skin, nearest_triangle};
use super::stiffness::StiffnessFactor;
use pliant_mesh::{ObjDocument, Surface};
use pliant_plugin_api::abi;
use pliant_solver::{Constraint, ElementList, Nodes, StepTime, System, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;

mod cut;
mod fields;
mod order;
mod paint;
mod part;
mod state;
mod weld;

pub use cut::OldCorners;
pub(in crate::body) use part::SheetPart;
pub use state::SheetState;

use order::{Order, inverse};
use paint::SheetPaint;

/// Direction of the warp threads of a fabric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Warp {
    /// The projection of this direction of the rest shape onto the plane of each triangle.
    Axis(Vec3),
    /// The direction of increasing u of the texture coordinates.
    Texture,
}

/// The discretization of a sheet.
pub struct Sheet {
    warp: Warp,
    /// Order in which vertices and triangles are numbered as nodes and elements.
    order: Arc<Order>,
    /// Node of each vertex, or [`NONE`] where no triangle uses it.
    node_of: Vec<u32>,
    /// Vertex of each node; ghost nodes follow and have none.
    vertex_of: Vec<u32>,
    /// Triangle of each element.
    triangle_of: Vec<u32>,
    /// Mean length of an edge at rest, m.
    edge: f64,
    /// Material coordinates, m: corners of each triangle at rest in its own plane, warp first, by element (m x 3 x 2).
    material: Arc<Vec<f64>>,
    /// Vertices of each clamped edge, lower first. Each has a ghost node (see [`Edges::new`]); ghost nodes have the last numbers, in this
    /// order.
    clamped: Arc<Vec<[u32; 2]>>,
    driven: Vec<DrivenNode>,
    /// Whether nodes and elements have been made.
    active: bool,
    /// A blade has changed nodes and elements, or a stroke pins, since [`Sheet::activate`] last reported a change.
    has_changed: bool,
    /// Pins and painted factors.
    paint: SheetPaint,
    /// Welded vertices, each with the one whose node it has.
    welds: Arc<BTreeMap<u32, u32>>,
    /// Fields of parameters of the material. After an edit that changed the rest shape, a cut evaluates them at the new rest positions.
    pub fields: Option<Arc<Fields>>,
    /// Factor of the material's stiffness; `None` if the material has none that may change.
    pub stiffness: Option<StiffnessFactor>,
}

/// Value of an absent node, hinge or triangle.
pub const NONE: u32 = u32::MAX;
/// Mass of ghost nodes, kg: small enough to change no sum over masses. They never move.
const GHOST_MASS: f64 = 1e-30;

impl Sheet {
    /// The sheet of a model, without nodes until [`Sheet::activate`].
    pub fn new(model: &Model, warp: Warp) -> Self {
        let surface = &model.surface;
        let (mut sum, mut count) = (0.0, 0);
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|v| surface.points[v as usize]);
            sum += (b - a).norm() + (c - b).norm() + (a - c).norm();
            count += 3;
        }
        let edge = sum / f64::from(count.max(1));
        Self {
            warp,
            order: Arc::default(),
            node_of: Vec::new(),
            vertex_of: Vec::new(),
            triangle_of: Vec::new(),
            edge,
            material: Arc::default(),
            clamped: Arc::default(),
            driven: Vec::new(),
            active: false,
            has_changed: false,
            paint: SheetPaint::default(),
            welds: Arc::default(),
            fields: None,
            stiffness: None,
        }
    }

    /// Mean length of an edge at rest, m.
    pub fn edge(&self) -> f64 {
        self.edge
    }

    /// Number of nodes that are vertices; ghost nodes of clamped edges follow them.
    pub fn vertex_count(&self) -> usize {
        self.vertex_of.len()
    }

    /// Vertex of a node; `None` for a ghost node.
    pub fn vertex_of(&self, node: u32) -> Option<u32> {
        self.vertex_of.get(node as usize).copied()
    }

    /// Node of a vertex; `u32::MAX` if it has none.
    pub fn node_of(&self, vertex: u32) -> u32 {
        self.node_of[vertex as usize]
    }

    /// Present position of a vertex, m; `None` if it has no node.
    pub fn position(&self, vertex: u32, nodes: &Nodes) -> Option<Vec3> {
        nodes.x.get(self.node_of(vertex) as usize).copied()
    }

    /// Triangle of an element.
    pub(crate) fn triangle_of(&self, element: usize) -> u32 {
        self.triangle_of[element]
    }

    /// Makes nodes and elements, if there are none yet. Returns whether nodes or elements have changed since the last call.
    ///
    /// # Errors
    /// Returns the error of the material; [`LatticeError::Massless`] for a vertex without mass.
    pub fn activate(&mut self, model: &Model, fixings: &[Fixing], system: &mut System) -> Result<bool, LatticeError> {
        if self.active {
            return Ok(std::mem::take(&mut self.has_changed));
        }
        self.active = true;
        self.order = Arc::new(Order::of(&model.surface));
        self.number(&model.surface);
        system.nodes = Nodes::at_rest(self.vertex_of.iter().map(|v| model.surface.points[*v as usize]).collect());
        self.material = Arc::new(self.material_coordinates(model));
        let numbers = &self.vertex_of;
        let (nodes, own) = (&mut system.nodes, numbers.len());
        let clamped = clamped(fixings, nodes, |node| numbers[node as usize]);
        let triangles = self.triangles(&model.surface);
        let edges = Edges::new(&triangles, |ends| ends.iter().all(|n| clamped[*n as usize]), nodes);
        self.clamped = Arc::new(edges.clamped.iter().map(|ends| self.vertices(*ends)).collect());
        self.driven = constrain_fixed(fixings, nodes, |node| numbers.get(node as usize).copied().unwrap_or(NONE));
        for ghost in own..nodes.len() {
            nodes.constraint[ghost] = Constraint::Fixed;
            if let Some(driven) = self.driven.iter().find(|driven| driven.node == edges.clamped[ghost - own][0]) {
                self.driven.push(DrivenNode { node: ghost as u32, fixing: driven.fixing });
            }
        }
        self.list_elements(system, &triangles, edges)?;
        Ok(true)
    }

    /// Numbers the nodes, one for each vertex that a triangle uses, and the elements, one for each triangle.
    fn number(&mut self, surface: &Surface) {
        let Order { vertices, triangles, .. } = self.order.extended(surface);
        self.vertex_of = vertices;
        self.vertex_of.retain(|vertex| !self.welds.contains_key(vertex));
        self.triangle_of = triangles;
        self.node_of = inverse(&self.vertex_of, surface.points.len());
        for (vertex, of) in self.welds.iter() {
            self.node_of[*vertex as usize] = self.node_of[*of as usize];
        }
    }

    /// Nodes of the triangle of each element.
    fn triangles(&self, surface: &Surface) -> Vec<[u32; 3]> {
        let nodes = |t: &u32| surface.triangles[*t as usize].map(|v| self.node_of[v as usize]);
        self.triangle_of.iter().map(nodes).collect()
    }

    /// Vertices of the ends of an edge, lower first.
    fn vertices(&self, ends: [u32; 2]) -> [u32; 2] {
        sorted(ends.map(|n| self.vertex_of[n as usize]))
    }

    /// Lists the elements of every kind that the material asks for, and prepares the system for them.
    fn list_elements(&self, system: &mut System, triangles: &[[u32; 3]], edges: Edges) -> Result<(), LatticeError> {
        let rest = &system.nodes.rest[..self.vertex_of.len()];
        for set in &mut system.sets {
            let kind = set.request().kind;
            let list = set.list_mut();
            *list = ElementList::default();
            match kind {
                abi::POINT => points(rest, triangles, list),
                abi::LINK => {
                    list.nodes = edges.all.iter().flatten().copied().collect();
                    list.family = vec![abi::STRUCTURAL; edges.all.len()];
                    list.measure = vec![1.0; edges.all.len()];
                }
                abi::TRIANGLE => {
                    list.nodes = triangles.iter().flatten().copied().collect();
                    list.measure = vec![1.0; triangles.len()];
                    list.material.clone_from(&self.material);
                }
                abi::HINGE => {
                    list.nodes = edges.hinges.iter().flatten().copied().collect();
                    list.measure = vec![1.0; edges.hinges.len()];
                }
                kind => {
                    let (material, wanted) = (system.material.name().to_owned(), kind_name(kind));
                    return Err(LatticeError::Unsupported { material, wanted, discretization: "sheet" });
                }
            }
        }
        self.list_fields(system, triangles);
        system.set_sides(edges.hinge_of);
        self.prepare(system)
    }

    /// Has the material compute rest data and masses.
    fn prepare(&self, system: &mut System) -> Result<(), LatticeError> {
        system.prepare()?;
        system.nodes.mass[self.vertex_of.len()..].fill(GHOST_MASS);
        check_mass(system)
    }

    /// Material coordinates of the model as placed, m (m x 3 x 2): an isometric flattening of each triangle, warp first.
    fn material_coordinates(&self, model: &Model) -> Vec<f64> {
        let mut out = Vec::with_capacity(6 * model.surface.triangles.len());
        for t in self.triangle_of.iter().map(|t| *t as usize) {
            let [a, b, c] = model.surface.triangles[t].map(|v| model.surface.points[v as usize]);
            let normal = (b - a).cross(&(c - a)).normalize();
            let wanted = match self.warp {
                Warp::Axis(axis) => axis,
                Warp::Texture => texture_direction(&model.document, &model.surface, t).unwrap_or_else(Vec3::x),
            };
            let in_plane = |d: Vec3| (d - d.dot(&normal) * normal).try_normalize(1e-6 * d.norm());
            let warp = in_plane(wanted).or_else(|| in_plane(Vec3::ith(normal.iamin(), 1.0))).unwrap_or_else(Vec3::x);
            out.extend(in_plane_of([a, b, c], &normal, &warp));
        }
        out
    }

    /// Prescribes the velocity of driven nodes for a step.
    pub fn prescribe(&self, nodes: &mut Nodes, fixings: &[Fixing], time: StepTime) {
        drive_fixed(&self.driven, nodes, fixings, time);
    }

    /// Copies the positions of the nodes to the vertices.
    pub fn embed(&self, nodes: &Nodes, skin: &mut Skin) {
        for (&vertex, x) in self.vertex_of.iter().zip(&nodes.x) {
            skin.place(vertex, *x);
        }
        for (vertex, of) in self.welds.iter() {
            skin.place(*vertex, skin.x[*of as usize]);
        }
    }

    /// Makes the present shape the rest shape, with zero velocity; the warp of each triangle is deformed with it.
    ///
    /// # Errors
    /// Returns the error of the material, if it refuses the new rest shape.
    pub fn keep(&mut self, model: &Model, skin: &mut Skin, system: &mut System) -> Result<(), LatticeError> {
        system.nodes.rest.clone_from(&system.nodes.x);
        system.nodes.v.fill(Vec3::zeros());
        let settled = Arc::make_mut(&mut skin.settled);
        settled.copy_from_slice(&skin.x);
        skin.pages.mark_all(skin.x.len());
        let all: Vec<u32> = (0..model.surface.triangles.len() as u32).collect();
        Arc::make_mut(&mut skin.tree).refit(&skin.settled, &model.surface.triangles, &all);
        self.flatten_rest(model, system)
    }

    /// Recomputes material coordinates and rest data from the rest positions of the nodes; the warp of each triangle is deformed with
    /// these.
    ///
    /// # Errors
    /// Returns the error of the material, if it refuses the new rest shape.
    pub fn flatten_rest(&mut self, model: &Model, system: &mut System) -> Result<(), LatticeError> {
        let triangles = self.triangles(&model.surface);
        let old = self.material.chunks_exact(6).zip(&triangles);
        let flattened = old.flat_map(|(u, t)| flatten(u, t.map(|n| system.nodes.rest[n as usize])));
        self.material = Arc::new(flattened.collect());
        for set in &mut system.sets {
            match set.request().kind {
                abi::POINT => {
                    let list = set.list_mut();
                    *list = ElementList { fields: std::mem::take(&mut list.fields), ..ElementList::default() };
                    points(&system.nodes.rest[..self.vertex_of.len()], &triangles, list);
                }
                abi::TRIANGLE => set.list_mut().material.clone_from(&self.material),
                _ => {}
            }
        }
        self.prepare(system)
    }

    /// The point of the surface at rest nearest to `point` (m); `None` where it is a million edges away.
    pub(crate) fn nearest_triangle(&self, point: Vec3, model: &Model, skin: &Skin) -> Option<NearestTriangle> {
        nearest_triangle(&skin.tree, model, &skin.settled, point, self.edge, 1e6 * self.edge)
    }

    /// Adds a third of the area at rest of each triangle that has not failed to each of its nodes, m^2 (n).
    pub fn add_node_areas(&self, model: &Model, failed: &FailedTriangles, areas: &mut [f64]) {
        let triangles = model.surface.triangles.iter().enumerate();
        for (triangle, vertices) in triangles.filter(|(triangle, _)| !failed.contains(*triangle as u32)) {
            let [a, b, c] = vertices.map(|v| model.surface.points[v as usize]);
            let third = (b - a).cross(&(c - a)).norm() / 6.0;
            self.nodes_of(model, triangle as u32).into_iter().for_each(|node| areas[node as usize] += third);
        }
    }

    /// Nodes of the corners of a triangle.
    pub fn nodes_of(&self, model: &Model, triangle: u32) -> [u32; 3] {
        model.surface.triangles[triangle as usize].map(|v| self.node_of[v as usize])
    }

    /// Position of a point of the surface at rest (m) in the present shape: the nearest point of the surface, moved by the nodes.
    pub fn embed_point(&self, point: Vec3, model: &Model, skin: &Skin, nodes: &Nodes) -> EmbeddedPoint {
        let Some(nearest) = self.nearest_triangle(point, model, skin).filter(|_| self.active) else {
            return EmbeddedPoint { now: point, settled: point };
        };
        let corners = self.nodes_of(model, nearest.triangle);
        let now: Vec3 = (0..3).map(|i| nearest.bary[i] * nodes.x[corners[i] as usize]).sum();
        EmbeddedPoint { now, settled: point }
    }

    /// Estimate of the memory, bytes: the largest arrays.
    pub fn bytes(&self) -> usize {
        4 * (self.node_of.len() + self.vertex_of.len())
    }
}

/// The ends of an edge, the lower number first.
fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Coordinates of the corners of a triangle along warp and weft, from its first corner, m (3 x 2).
fn in_plane_of([a, b, c]: [Vec3; 3], normal: &Vec3, warp: &Vec3) -> [f64; 6] {
    let weft = normal.cross(warp);
    let [b, c] = [b - a, c - a].map(|p| [p.dot(warp), p.dot(&weft)]);
    [0.0, 0.0, b[0], b[1], c[0], c[1]]
}

/// Material coordinates, m (3 x 2), of a triangle that was deformed from material coordinates `u` to corners `now` (m): its warp is the
/// image of the old warp under the deformation.
fn flatten(u: &[f64], now: [Vec3; 3]) -> [f64; 6] {
    let [p, q] = [[u[2] - u[0], u[3] - u[1]], [u[4] - u[0], u[5] - u[1]]];
    let (b, c) = (now[1] - now[0], now[2] - now[0]);
    // The first column of the deformation gradient, times twice the area at rest.
    let warp = (b * q[1] - c * p[1]).normalize();
    in_plane_of(now, &b.cross(&c).normalize(), &warp)
}

/// Lists point elements: one for each node, whose measure is a third of the area of the triangles around it, m^2.
fn points(rest: &[Vec3], triangles: &[[u32; 3]], list: &mut ElementList) {
    list.nodes = (0..rest.len() as u32).collect();
    list.measure = vec![0.0; rest.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|n| rest[n as usize]);
        let third = (b - a).cross(&(c - a)).norm() / 6.0;
        triangle.iter().for_each(|n| list.measure[*n as usize] += third);
    }
}

/// Edges and hinges of a mesh, by node.
struct Edges {
    all: Vec<[u32; 2]>,
    /// Hinges: both ends of the edge, then the opposite corner of the triangle to its left and of that to its right.
    hinges: Vec<[u32; 4]>,
    /// Hinge of the sides 01, 12 and 20 of each triangle, or [`NONE`].
    hinge_of: Vec<[u32; 3]>,
    /// Clamped edges, in the order of their ghost nodes.
    clamped: Vec<[u32; 2]>,
}

/// Whether each node is held by a fixing that clamps (n). `number` gives the number by which fixings know a node.
fn clamped(fixings: &[Fixing], nodes: &Nodes, number: impl Fn(u32) -> u32) -> Vec<bool> {
    let is_held = |i: usize| fixings.iter().any(|f| f.clamp && f.place.contains(number(i as u32), nodes.rest[i]));
    (0..nodes.len()).map(is_held).collect()
}

impl Edges {
    /// Lists edges and hinges. A clamped edge on the border is a hinge as well: a ghost node is added at the mirror image of its triangle's
    /// third corner and never moves relative to the fixing, so the edge keeps its direction.
    fn new(triangles: &[[u32; 3]], is_clamped: impl Fn([u32; 2]) -> bool, nodes: &mut Nodes) -> Self {
        let surface = Surface { triangles: triangles.to_vec(), ..Surface::default() };
        let (mut all, mut hinges) = (Vec::new(), Vec::new());
        let mut hinge_of = vec![[NONE; 3]; triangles.len()];
        let mut clamped = Vec::new();
        for (ends, sides) in surface.edges().iter() {
            all.push(ends);
            if let [side] = sides
                && is_clamped(ends)
            {
                let third = triangles[side.triangle as usize][(usize::from(side.corner) + 2) % 3];
                let ghost = add_mirror(nodes, ends, third);
                clamped.push(ends);
                hinge_of[side.triangle as usize][usize::from(side.corner)] = hinges.len() as u32;
                let [left, right] = if side.upward { [third, ghost] } else { [ghost, third] };
                hinges.push([ends[0], ends[1], left, right]);
            }
            let [one, two] = sides else { continue };
            let (left, right) = if one.upward { (one, two) } else { (two, one) };
            let opposite =
                |side: &pliant_mesh::Side| triangles[side.triangle as usize][(usize::from(side.corner) + 2) % 3];
            for side in [left, right] {
                hinge_of[side.triangle as usize][usize::from(side.corner)] = hinges.len() as u32;
            }
            hinges.push([ends[0], ends[1], opposite(left), opposite(right)]);
        }
        Self { all, hinges, hinge_of, clamped }
    }
}

/// Adds a node at the reflection of the node `third` about an edge, in the plane of the triangle. Returns its number.
fn add_mirror(nodes: &mut Nodes, ends: [u32; 2], third: u32) -> u32 {
    let [a, b, c] = [ends[0], ends[1], third].map(|n| nodes.rest[n as usize]);
    let along = (b - a).normalize();
    let foot = a + (c - a).dot(&along) * along;
    nodes.add(2.0 * foot - c)
}

/// Direction of increasing u in a triangle at rest, not normalised; `None` without texture coordinates or with degenerate ones.
fn texture_direction(document: &ObjDocument, surface: &Surface, triangle: usize) -> Option<Vec3> {
    let vertices = surface.triangles[triangle];
    let texcoord = |vertex: u32| document.texcoord_at(surface.face_of[triangle], vertex);
    let [s, t, r] = [texcoord(vertices[0])?, texcoord(vertices[1])?, texcoord(vertices[2])?];
    let [a, b, c] = vertices.map(|v| surface.points[v as usize]);
    let (du, dv) = ([t[0] - s[0], r[0] - s[0]], [t[1] - s[1], r[1] - s[1]]);
    let area = du[0] * dv[1] - du[1] * dv[0];
    let direction = ((b - a) * dv[1] - (c - a) * dv[0]) / area;
    direction.iter().all(|c| c.is_finite()).then_some(direction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_of_two_triangles_has_one_hinge_that_knows_left_from_right() {
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let flat = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from);
        let mut nodes = Nodes::at_rest(flat.to_vec());
        let edges = Edges::new(&triangles, |_| false, &mut nodes);
        assert_eq!(edges.all.len(), 5);
        // From 0 to 2: vertex 3 is to the left, 1 to the right.
        assert_eq!(edges.hinges, [[0, 2, 3, 1]]);
        assert_eq!(edges.hinge_of, [[NONE, NONE, 0], [0, NONE, NONE]]);
        let edges = Edges::new(&triangles, |ends| ends == [0, 3], &mut nodes);
        assert_eq!(edges.hinges[1], [0, 3, 4, 2], "beyond the clamped edge from 0 to 3 its mirror image");
        assert_eq!((nodes.rest[4], edges.clamped), (Vec3::new(-1.0, 1.0, 0.0), vec![[0, 3]]));
    }
}
