//! A body carried by its own mesh: every vertex is a node, triangles, edges and hinges are the elements. For cloth and other
//! thin shells.

use super::fields::Fields;
use super::fixing::Fixing;
use super::lattice::{LatticeError, check_mass, constrain_fixed, drive_fixed};
use super::model::Model;
use super::skin::Skin;
use pliant_mesh::geometry::closest_point;
use pliant_mesh::{ObjDocument, Surface};
use pliant_plugin_api::abi;
use pliant_solver::{Constraint, ElementList, Nodes, StepTime, System, Vec3};
use std::sync::Arc;

mod cut;
mod fields;
mod order;
mod state;

pub use cut::Before;
pub use state::SheetState;

use order::{Order, places};

/// Where the warp of a fabric runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Warp {
    /// Along this direction of the rest shape, in the plane of each triangle.
    Axis(Vec3),
    /// Along u of the texture coordinates.
    Texture,
}

/// A mesh as the discretization of itself.
pub struct Sheet {
    warp: Warp,
    /// Vertices and triangles as they became nodes and elements.
    order: Arc<Order>,
    /// Node of each vertex, or `NONE` where no triangle uses it.
    node_of: Vec<u32>,
    vertex_of: Vec<u32>,
    /// Triangle of each element.
    triangle_of: Vec<u32>,
    /// m, mean
    edge: f64,
    /// m, corners of each triangle at rest in its own plane, warp first, by element (m x 3 x 2)
    material: Arc<Vec<f64>>,
    /// Clamped edges by their vertices, lower first: beyond each a node behind all others, in the same order, lends it a direction.
    clamped: Arc<Vec<[u32; 2]>>,
    driven: Vec<(u32, u32)>,
    active: bool,
    /// A blade has changed nodes and elements since they were last asked for.
    cut: bool,
    /// Parameters of the material that differ from place to place. A sheet that is cut after its shape was kept takes them where the kept
    /// shape is.
    pub fields: Option<Arc<Fields>>,
}

/// Stands for the absence of a node.
pub const NONE: u32 = u32::MAX;
/// Mass of nodes that only lend a direction and never move, kg: too small to count in any weight, reaction or energy.
const WEIGHTLESS: f64 = 1e-30;

impl Sheet {
    /// Of a model. No node is active yet.
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
            cut: false,
            fields: None,
        }
    }

    /// m, mean length of an edge
    pub fn edge(&self) -> f64 {
        self.edge
    }

    /// Nodes that are vertices; behind them come those that lend clamped edges a direction.
    pub fn vertex_count(&self) -> usize {
        self.vertex_of.len()
    }

    /// Vertex of a node, if it is one.
    pub fn vertex_of(&self, node: u32) -> Option<u32> {
        self.vertex_of.get(node as usize).copied()
    }

    /// Node of a vertex, or `u32::MAX`.
    pub fn node_of(&self, vertex: u32) -> u32 {
        self.node_of[vertex as usize]
    }

    /// Makes nodes and elements, if there are none yet. Returns whether there are others than before.
    ///
    /// # Errors
    /// What the material says; a vertex without mass.
    pub fn activate(&mut self, model: &Model, fixings: &[Fixing], system: &mut System) -> Result<bool, LatticeError> {
        if self.active {
            return Ok(std::mem::take(&mut self.cut));
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
            if let Some((_, fixing)) = self.driven.iter().find(|(node, _)| *node == edges.clamped[ghost - own][0]) {
                let fixing = *fixing;
                self.driven.push((ghost as u32, fixing));
            }
        }
        self.list_elements(system, &triangles, edges)?;
        Ok(true)
    }

    /// A node for each vertex that a triangle uses, and an element for each triangle.
    fn number(&mut self, surface: &Surface) {
        let Order { vertices, triangles, .. } = self.order.and_more(surface);
        (self.vertex_of, self.triangle_of) = (vertices, triangles);
        self.node_of = places(&self.vertex_of, surface.points.len());
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
                _ => {
                    let material = system.material.name().to_owned();
                    return Err(LatticeError::Unsupported { material, wanted: "tetrahedra", discretization: "sheet" });
                }
            }
        }
        self.list_fields(system);
        system.set_sides(edges.hinge_of);
        self.prepare(system)
    }

    fn prepare(&self, system: &mut System) -> Result<(), LatticeError> {
        system.prepare()?;
        system.nodes.mass[self.vertex_of.len()..].fill(WEIGHTLESS);
        check_mass(system)
    }

    /// Corners of each triangle in its own plane, warp first, m (m x 3 x 2). Lengths and angles are those of the rest shape.
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

    /// Sets what driven nodes do in the step from `time` of `dt` (s).
    pub fn prescribe(&self, nodes: &mut Nodes, fixings: &[Fixing], time: StepTime) {
        drive_fixed(&self.driven, nodes, fixings, time);
    }

    /// Puts the surface where the nodes are.
    pub fn embed(&self, nodes: &Nodes, skin: &mut Skin) {
        for (&vertex, x) in self.vertex_of.iter().zip(&nodes.x) {
            skin.x[vertex as usize] = *x;
        }
        skin.pages.mark_all(skin.x.len());
    }

    /// Makes the present shape the rest shape: every triangle is laid out as it is now, its warp where it has gone.
    ///
    /// # Errors
    /// What the material says of it.
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

    /// Takes the rest positions of the nodes as the rest shape: every triangle is laid out as it is there, its warp where it has gone.
    ///
    /// # Errors
    /// What the material says of it.
    pub fn flatten_rest(&mut self, model: &Model, system: &mut System) -> Result<(), LatticeError> {
        let triangles = self.triangles(&model.surface);
        let before = self.material.chunks_exact(6).zip(&triangles);
        let laid_out = before.flat_map(|(u, t)| flatten(u, t.map(|n| system.nodes.rest[n as usize])));
        self.material = Arc::new(laid_out.collect());
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

    /// The triangle of the settled surface closest to a place, and the weights of its corners.
    pub fn seat(&self, place: Vec3, model: &Model, skin: &Skin) -> Option<(u32, Vec3)> {
        let mut reach = self.edge;
        loop {
            let mut best: Option<(f64, u32, Vec3)> = None;
            skin.tree.near(place, reach, |t| {
                let corners = model.surface.triangles[t as usize].map(|v| skin.settled[v as usize]);
                let closest = closest_point(place, corners);
                let away = (closest.point - place).norm();
                if away <= reach && best.is_none_or(|(least, of, _)| (away, t) < (least, of)) {
                    best = Some((away, t, closest.bary));
                }
            });
            match best {
                Some((_, t, bary)) => return Some((t, bary)),
                None if reach > 1e6 * self.edge => return None,
                None => reach *= 4.0,
            }
        }
    }

    /// Nodes of a triangle.
    pub fn nodes_of(&self, model: &Model, triangle: u32) -> [u32; 3] {
        model.surface.triangles[triangle as usize].map(|v| self.node_of[v as usize])
    }

    /// Where the nodes carry a settled place, and the place.
    pub fn embed_point(&self, place: Vec3, model: &Model, skin: &Skin, nodes: &Nodes) -> (Vec3, Vec3) {
        let Some((triangle, bary)) = self.seat(place, model, skin).filter(|_| self.active) else {
            return (place, place);
        };
        let at = self.nodes_of(model, triangle);
        let now: Vec3 = (0..3).map(|i| bary[i] * nodes.x[at[i] as usize]).sum();
        (now, place)
    }

    /// Bytes of the largest parts.
    pub fn bytes(&self) -> usize {
        4 * (self.node_of.len() + self.vertex_of.len())
    }
}

/// The two ends of an edge, the lower number first.
fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Places in the plane of a triangle, from its first corner, warp first, m.
fn in_plane_of([a, b, c]: [Vec3; 3], normal: &Vec3, warp: &Vec3) -> [f64; 6] {
    let weft = normal.cross(warp);
    let [b, c] = [b - a, c - a].map(|p| [p.dot(warp), p.dot(&weft)]);
    [0.0, 0.0, b[0], b[1], c[0], c[1]]
}

/// The same of a triangle that was at `u` in its plane and has been deformed; its warp is what has become of the warp.
fn flatten(u: &[f64], now: [Vec3; 3]) -> [f64; 6] {
    let [p, q] = [[u[2] - u[0], u[3] - u[1]], [u[4] - u[0], u[5] - u[1]]];
    let (b, c) = (now[1] - now[0], now[2] - now[0]);
    // The sides that make one step along the warp, times twice the area.
    let warp = (b * q[1] - c * p[1]).normalize();
    in_plane_of(now, &b.cross(&c).normalize(), &warp)
}

/// A third of the area of its triangles for each node, m^2.
fn points(rest: &[Vec3], triangles: &[[u32; 3]], list: &mut ElementList) {
    list.nodes = (0..rest.len() as u32).collect();
    list.measure = vec![0.0; rest.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|n| rest[n as usize]);
        let third = (b - a).cross(&(c - a)).norm() / 6.0;
        triangle.iter().for_each(|n| list.measure[*n as usize] += third);
    }
}

/// Edges of a mesh.
struct Edges {
    all: Vec<[u32; 2]>,
    /// Edges with two sides: from, to, the vertex left of it and the vertex right of it.
    hinges: Vec<[u32; 4]>,
    /// Hinge of each triangle's sides 01, 12, 20, or `NONE`.
    hinge_of: Vec<[u32; 3]>,
    /// Clamped edges: each has a node added behind the others.
    clamped: Vec<[u32; 2]>,
}

/// Nodes held by fixings that clamp.
fn clamped(fixings: &[Fixing], nodes: &Nodes, number: impl Fn(u32) -> u32) -> Vec<bool> {
    let held = |i: usize| fixings.iter().any(|f| f.clamp && f.place.holds(number(i as u32), nodes.rest[i]));
    (0..nodes.len()).map(held).collect()
}

impl Edges {
    /// A clamped edge is a hinge too: beyond it lies the mirror image of its triangle, held for good by a node of its own.
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

/// A node where `third` is seen in the mirror of an edge, in the plane of both.
fn add_mirror(nodes: &mut Nodes, ends: [u32; 2], third: u32) -> u32 {
    let [a, b, c] = [ends[0], ends[1], third].map(|n| nodes.rest[n as usize]);
    let along = (b - a).normalize();
    let foot = a + (c - a).dot(&along) * along;
    nodes.add(2.0 * foot - c)
}

/// Direction of increasing u in a triangle of the rest shape.
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
