//! Cutting of a sheet: nodes and elements follow the cut mesh, with their state.
//!
//! A new node interpolates position, velocity and rest position linearly in the edge or triangle it was cut out of, and a piece of a
//! triangle the material coordinates. So mass, momentum and membrane energy are conserved. Angular momentum is not exactly: the moment of
//! inertia of lumped masses depends on the mesh; the change vanishes under refinement.

use super::{Edges, NONE, Sheet, inverse, sorted};
use crate::body::lattice::{DrivenNode, LatticeError};
use pliant_cut::{Advance, CutMesh, Origin};
use pliant_plugin_api::abi;
use pliant_solver::{Constraint, ElementSet, Nodes, System, Vec3};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Corners, before the cut, of the triangles that it has changed.
pub type OldCorners = HashMap<u32, [u32; 3]>;

/// Nodes and elements before a cut.
struct OldElements {
    /// Number of nodes that are vertices.
    nodes: usize,
    /// Ghost nodes, in the order of the clamped edges.
    ghosts: Nodes,
    /// History of each element set.
    history: Vec<Vec<f64>>,
    /// Links and hinges of each set by the ends of their edge, lower node first.
    element_of_edge: Vec<HashMap<[u32; 2], usize>>,
}

impl Sheet {
    /// Adopts the changes that an advance of a blade has made to the mesh.
    ///
    /// # Errors
    /// Returns the error of the material, if it refuses a piece; the sheet must then be restored.
    pub fn take_cut(
        &mut self,
        mesh: &CutMesh,
        advance: &Advance,
        old_corners: &OldCorners,
        system: &mut System,
    ) -> Result<(), LatticeError> {
        let surface = mesh.surface();
        let old = OldElements::take(self.vertex_of.len(), system);
        self.driven.retain(|driven| driven.node < old.nodes as u32);
        let mut fixing_of: HashMap<u32, u32> = self.driven.iter().map(|driven| (driven.node, driven.fixing)).collect();
        self.number(surface);
        let mut origins = VertexOrigins { first: advance.first_vertex, of_new: Vec::new() };
        for vertex in advance.first_vertex..surface.points.len() as u32 {
            let sources: Vec<(u32, f64)> =
                sources(mesh.origin(vertex)).into_iter().map(|(v, w)| (self.node_of[v as usize], w)).collect();
            let node = system.nodes.add_between(&sources);
            let fixing = |(n, _): &(u32, f64)| fixing_of.get(n).copied();
            if let Some(common) = fixing(&sources[0]).filter(|f| sources.iter().all(|n| fixing(n) == Some(*f))) {
                fixing_of.insert(node, common);
                self.driven.push(DrivenNode { node, fixing: common });
            }
            origins.add(mesh.origin(vertex));
            self.inherit_pin(vertex, node, &sources, &system.nodes);
        }
        self.inherit_factors(advance, surface.triangles.len() as u32);
        self.material = Arc::new(self.cut_material_coordinates(mesh, advance, old_corners));
        let triangles = self.triangles(surface);
        let clamped: HashMap<[u32; 2], usize> = self.clamped.iter().copied().zip(0..).collect();
        let own = system.nodes.len();
        let vertices = |ends: [u32; 2]| sorted(ends.map(|n| self.vertex_of[n as usize]));
        let old_ghost = |ends: [u32; 2]| origins.edge(vertices(ends)).and_then(|edge| clamped.get(&edge).copied());
        let edges = Edges::new(&triangles, |ends| old_ghost(ends).is_some(), &mut system.nodes);
        for (i, &ends) in edges.clamped.iter().enumerate() {
            let (ghost, index) = ((own + i) as u32, old_ghost(ends).unwrap_or(0));
            place_ghost(&mut system.nodes, ghost, ends, OldGhost { ghosts: &old.ghosts, index });
            if let Some(&fixing) = fixing_of.get(&ends[0]) {
                self.driven.push(DrivenNode { node: ghost, fixing });
            }
        }
        self.clamped = Arc::new(edges.clamped.iter().map(|ends| vertices(*ends)).collect());
        self.list_elements(system, &triangles, edges)?;
        let number = |edge: [u32; 2]| sorted(edge.map(|v| self.node_of[v as usize]));
        let element_of = inverse(&self.triangle_of, self.triangle_of.len());
        for (set, (history, of_edge)) in system.sets.iter_mut().zip(old.history.iter().zip(&old.element_of_edge)) {
            let edge_of = |ends: &[u32]| origins.edge(vertices([ends[0], ends[1]]));
            let old_element = |e: usize, nodes: &[u32]| match nodes.len() {
                1 => (nodes[0] < old.nodes as u32).then_some(e),
                3 => Some(element_of[old_triangle(advance, self.triangle_of[e]) as usize] as usize),
                _ => edge_of(nodes).and_then(|edge| of_edge.get(&number(edge)).copied()),
            };
            copy_history(set, history, old_element);
        }
        self.has_changed = true;
        Ok(())
    }

    /// Pins a new vertex if its node is held, and one of the nodes it lies between is pinned.
    fn inherit_pin(&mut self, vertex: u32, node: u32, sources: &[(u32, f64)], nodes: &Nodes) {
        let is_pinned = |(n, _): &(u32, f64)| self.vertex_of(*n).is_some_and(|v| self.is_pinned(v));
        if nodes.constraint[node as usize] == Constraint::Fixed && sources.iter().any(is_pinned) {
            Arc::make_mut(&mut self.paint.pins).insert(vertex);
        }
    }

    /// Gives new triangles, of `count` in all, the painted factors of those they were cut from.
    fn inherit_factors(&mut self, advance: &Advance, count: u32) {
        if !self.painted().is_empty() {
            let pieces = (advance.first_triangle..count).map(|t| (u64::from(t), u64::from(old_triangle(advance, t))));
            Arc::make_mut(&mut self.paint.factors).inherit(pieces);
        }
    }

    /// Material coordinates of every triangle after the cut, m (m x 3 x 2): those of a piece are interpolated in the triangle it was cut
    /// from.
    fn cut_material_coordinates(&self, mesh: &CutMesh, advance: &Advance, old_corners: &OldCorners) -> Vec<f64> {
        let surface = mesh.surface();
        let element_of = inverse(&self.triangle_of, surface.triangles.len());
        let row = |t: u32| 6 * element_of[t as usize] as usize;
        let mut material = self.material.to_vec();
        material.resize(6 * surface.triangles.len(), 0.0);
        let point = |v: u32| surface.points[v as usize];
        for &t in
            advance.changed.iter().chain(&(advance.first_triangle..surface.triangles.len() as u32).collect::<Vec<_>>())
        {
            let old = old_triangle(advance, t);
            let corners = old_corners[&old].map(point);
            let u = &self.material[row(old)..][..6];
            for (corner, vertex) in surface.triangles[t as usize].into_iter().enumerate() {
                let bary = barycentric(corners, point(vertex));
                for i in 0..2 {
                    material[row(t) + 2 * corner + i] = (0..3).map(|c| bary[c] * u[2 * c + i]).sum();
                }
            }
        }
        material
    }
}

impl OldElements {
    /// Removes the ghost nodes from the system, which has `nodes` others, and records the elements and their history.
    fn take(nodes: usize, system: &mut System) -> Self {
        let element_of_edge = |set: &ElementSet| match set.request().kind {
            abi::LINK | abi::HINGE if !set.history().is_empty() => {
                let corners = if set.request().kind == abi::LINK { 2 } else { 4 };
                let edges = set.nodes().chunks_exact(corners).enumerate();
                edges.map(|(e, nodes)| (sorted([nodes[0], nodes[1]]), e)).collect()
            }
            _ => HashMap::new(),
        };
        Self {
            nodes,
            history: system.sets.iter().map(|set| set.history().to_vec()).collect(),
            element_of_edge: system.sets.iter().map(element_of_edge).collect(),
            ghosts: system.nodes.split_off(nodes),
        }
    }
}

/// The old vertices between which each new vertex lies: one, two or three.
struct VertexOrigins {
    /// The first new vertex.
    first: u32,
    of_new: Vec<BTreeSet<u32>>,
}

impl VertexOrigins {
    /// Old vertices between which a vertex lies; an old vertex alone.
    fn of(&self, vertex: u32) -> BTreeSet<u32> {
        vertex.checked_sub(self.first).map_or_else(|| BTreeSet::from([vertex]), |new| self.of_new[new as usize].clone())
    }

    /// Adds the next new vertex.
    fn add(&mut self, origin: Origin) {
        let of = sources(origin).into_iter().flat_map(|(v, _)| self.of(v)).collect();
        self.of_new.push(of);
    }

    /// The old edge, lower end first, that contains the edge between two vertices; `None` where that edge crosses an old triangle.
    fn edge(&self, ends: [u32; 2]) -> Option<[u32; 2]> {
        let both: Vec<u32> = (&self.of(ends[0]) | &self.of(ends[1])).into_iter().collect();
        <[u32; 2]>::try_from(both).ok()
    }
}

/// The old triangle that a triangle was cut from, which is itself if it is old.
fn old_triangle(advance: &Advance, triangle: u32) -> u32 {
    let new = triangle.checked_sub(advance.first_triangle);
    new.map_or(triangle, |new| Some(advance.pieces_of[new as usize]).filter(|of| *of != NONE).unwrap_or(0))
}

/// Vertices from which a new vertex is interpolated, with weights.
fn sources(origin: Origin) -> Vec<(u32, f64)> {
    match origin {
        Origin::Edge { ends: [a, b], t } => vec![(a, 1.0 - t), (b, t)],
        Origin::Face { corners, weights } => corners.into_iter().zip(weights.iter().copied()).collect(),
        Origin::Copy { of } => vec![(of, 1.0)],
        Origin::Original | Origin::Cap { .. } => Vec::new(), // a sheet has no caps
    }
}

/// Barycentric coordinates of a point in the plane of a triangle; exact at the corners.
fn barycentric(corners: [Vec3; 3], point: Vec3) -> Vec3 {
    if let Some(at) = corners.iter().position(|corner| *corner == point) {
        return Vec3::from_fn(|i, _| if i == at { 1.0 } else { 0.0 });
    }
    let [a, b, c] = corners.map(|corner| corner - point);
    let normal = (b - a).cross(&(c - a));
    let areas = Vec3::from([b.cross(&c), c.cross(&a), a.cross(&b)].map(|cross| cross.dot(&normal)));
    areas / areas.sum()
}

/// The ghost node of a clamped edge before the cut.
struct OldGhost<'a> {
    ghosts: &'a Nodes,
    index: usize,
}

/// Moves the ghost node of a part of a clamped edge into the plane of the whole edge's ghost node, at the distance of its own mirror
/// image, and gives it that node's displacement and velocity.
fn place_ghost(nodes: &mut Nodes, ghost: u32, ends: [u32; 2], old: OldGhost<'_>) {
    let at = |n: u32| nodes.rest[n as usize];
    let (a, b, mirror) = (at(ends[0]), at(ends[1]), at(ghost));
    let along = (b - a).normalize();
    let across = |p: Vec3| (p - a) - (p - a).dot(&along) * along;
    let OldGhost { ghosts, index: old } = old;
    let rest = mirror - across(mirror) + across(mirror).norm() * across(ghosts.rest[old]).normalize();
    let i = ghost as usize;
    nodes.rest[i] = rest;
    nodes.x[i] = nodes.rest[i] + (ghosts.x[old] - ghosts.rest[old]);
    nodes.v[i] = ghosts.v[old];
    nodes.constraint[i] = Constraint::Fixed;
}

/// Copies to every element the history of the old element `from(element, nodes)`; an element without one keeps its initial history.
fn copy_history(set: &mut ElementSet, old: &[f64], from: impl Fn(usize, &[u32]) -> Option<usize>) {
    let (count, mut history) = (set.count(), set.history().to_vec());
    let stride = history.len() / count.max(1);
    if stride == 0 {
        return;
    }
    let old_count = old.len() / stride;
    let corners = set.nodes().len() / count;
    for e in 0..count {
        let Some(from) = from(e, &set.nodes()[corners * e..][..corners]) else { continue };
        (0..stride).for_each(|plane| history[plane * count + e] = old[plane * old_count + from]);
    }
    set.set_history(&history);
}
