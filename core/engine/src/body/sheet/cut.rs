//! A sheet under a blade: its nodes part with its mesh, and what is known of them goes with them.
//!
//! A new node takes place, velocity and rest place from what it was cut out of, and a piece of a triangle its part of the
//! fabric. All of them are linear there, so mass, momentum and the energy of the membrane stay what they were. The moment of
//! inertia of masses in the corners depends on the mesh: angular momentum changes by that, less the finer the mesh.

use super::{Edges, NONE, Sheet, places, sorted};
use crate::body::lattice::LatticeError;
use pliant_cut::{Advance, CutMesh, Origin};
use pliant_plugin_api::abi;
use pliant_solver::{Constraint, ElementSet, Nodes, System, Vec3};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Triangles a cut has changed, with their corners before.
pub type Before = HashMap<u32, [u32; 3]>;

/// Nodes and edges before a cut.
struct Old {
    nodes: usize,
    /// Beyond clamped edges, in their order.
    ghosts: Nodes,
    history: Vec<Vec<f64>>,
    /// Elements on edges, of each set.
    on_edge: Vec<HashMap<[u32; 2], usize>>,
}

impl Sheet {
    /// Takes over what an advance has done to the mesh.
    ///
    /// # Errors
    /// What the material says of a piece; the sheet is then to be restored.
    pub fn take_cut(
        &mut self,
        mesh: &CutMesh,
        advance: &Advance,
        before: &Before,
        system: &mut System,
    ) -> Result<(), LatticeError> {
        let surface = mesh.surface();
        let old = Old::take(self.vertex_of.len(), system);
        let fixing_of: HashMap<u32, u32> = self.driven.iter().copied().filter(|(n, _)| *n < old.nodes as u32).collect();
        self.driven.retain(|(node, _)| *node < old.nodes as u32);
        self.number(surface);
        let mut fixing_of = fixing_of;
        let mut lineage = Lineage { first: advance.first_vertex, of_new: Vec::new() };
        for vertex in advance.first_vertex..surface.points.len() as u32 {
            let of: Vec<(u32, f64)> =
                sources(mesh.origin(vertex)).into_iter().map(|(v, w)| (self.node_of[v as usize], w)).collect();
            let node = system.nodes.add_between(&of);
            let fixing = |(n, _): &(u32, f64)| fixing_of.get(n).copied();
            if let Some(driven) = fixing(&of[0]).filter(|driven| of.iter().all(|n| fixing(n) == Some(*driven))) {
                fixing_of.insert(node, driven);
                self.driven.push((node, driven));
            }
            lineage.add(mesh.origin(vertex));
        }
        self.material = Arc::new(self.pieces(mesh, advance, before));
        let triangles = self.triangles(surface);
        let clamped: HashMap<[u32; 2], usize> = self.clamped.iter().copied().zip(0..).collect();
        let own = system.nodes.len();
        let vertices = |ends: [u32; 2]| sorted(ends.map(|n| self.vertex_of[n as usize]));
        let descends = |ends: [u32; 2]| lineage.edge(vertices(ends)).and_then(|edge| clamped.get(&edge).copied());
        let edges = Edges::new(&triangles, |ends| descends(ends).is_some(), &mut system.nodes);
        for (ghost, &ends) in edges.clamped.iter().enumerate() {
            let of = descends(ends).unwrap_or(0);
            place_ghost(&mut system.nodes, (own + ghost) as u32, ends, OldGhost { ghosts: &old.ghosts, index: of });
            if let Some(driven) = fixing_of.get(&ends[0]) {
                self.driven.push(((own + ghost) as u32, *driven));
            }
        }
        self.clamped = Arc::new(edges.clamped.iter().map(|ends| vertices(*ends)).collect());
        self.list_elements(system, &triangles, edges)?;
        let number = |edge: [u32; 2]| sorted(edge.map(|v| self.node_of[v as usize]));
        let element_of = places(&self.triangle_of, self.triangle_of.len());
        for (set, (history, on_edge)) in system.sets.iter_mut().zip(old.history.iter().zip(&old.on_edge)) {
            let edge_of = |ends: &[u32]| lineage.edge(vertices([ends[0], ends[1]]));
            let from = |e: usize, nodes: &[u32]| match nodes.len() {
                1 => (nodes[0] < old.nodes as u32).then_some(e),
                3 => Some(element_of[parent(advance, self.triangle_of[e]) as usize] as usize),
                _ => edge_of(nodes).and_then(|edge| on_edge.get(&number(edge)).copied()),
            };
            carry_history(set, history, from);
        }
        self.cut = true;
        Ok(())
    }

    /// Places in the fabric of the corners of every triangle: a piece has its part of what it was cut from.
    fn pieces(&self, mesh: &CutMesh, advance: &Advance, before: &Before) -> Vec<f64> {
        let surface = mesh.surface();
        let element_of = places(&self.triangle_of, surface.triangles.len());
        let place = |t: u32| 6 * element_of[t as usize] as usize;
        let mut material = self.material.to_vec();
        material.resize(6 * surface.triangles.len(), 0.0);
        let point = |v: u32| surface.points[v as usize];
        for &t in
            advance.changed.iter().chain(&(advance.first_triangle..surface.triangles.len() as u32).collect::<Vec<_>>())
        {
            let of = parent(advance, t);
            let corners = before[&of].map(point);
            let u = &self.material[place(of)..][..6];
            for (corner, vertex) in surface.triangles[t as usize].into_iter().enumerate() {
                let weights = weights_in(corners, point(vertex));
                for i in 0..2 {
                    material[place(t) + 2 * corner + i] = (0..3).map(|c| weights[c] * u[2 * c + i]).sum();
                }
            }
        }
        material
    }
}

impl Old {
    /// Takes the nodes beyond clamped edges off, and notes what elements there are.
    fn take(nodes: usize, system: &mut System) -> Self {
        let on_edge = |set: &ElementSet| match set.request().kind {
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
            on_edge: system.sets.iter().map(on_edge).collect(),
            ghosts: system.nodes.split_off(nodes),
        }
    }
}

/// Which vertices there were before a cut a new one lies between.
struct Lineage {
    first: u32,
    of_new: Vec<BTreeSet<u32>>,
}

impl Lineage {
    fn of(&self, vertex: u32) -> BTreeSet<u32> {
        vertex.checked_sub(self.first).map_or_else(|| BTreeSet::from([vertex]), |new| self.of_new[new as usize].clone())
    }

    fn add(&mut self, origin: Origin) {
        let of = sources(origin).into_iter().flat_map(|(v, _)| self.of(v)).collect();
        self.of_new.push(of);
    }

    /// The edge there was that an edge between these two is a part of, if it is of one, lower end first.
    fn edge(&self, ends: [u32; 2]) -> Option<[u32; 2]> {
        let both: Vec<u32> = (&self.of(ends[0]) | &self.of(ends[1])).into_iter().collect();
        <[u32; 2]>::try_from(both).ok()
    }
}

/// The triangle a triangle was cut from.
fn parent(advance: &Advance, triangle: u32) -> u32 {
    let new = triangle.checked_sub(advance.first_triangle);
    new.map_or(triangle, |new| Some(advance.pieces_of[new as usize]).filter(|of| *of != NONE).unwrap_or(0))
}

/// What a new vertex was made from, with weights.
fn sources(origin: Origin) -> Vec<(u32, f64)> {
    match origin {
        Origin::Edge { ends: [a, b], t } => vec![(a, 1.0 - t), (b, t)],
        Origin::Face { corners, weights } => corners.into_iter().zip(weights.iter().copied()).collect(),
        Origin::Copy { of } => vec![(of, 1.0)],
        Origin::Original | Origin::Cap { .. } => Vec::new(), // a sheet has no inside
    }
}

/// Weights of the corners of a triangle at a place in it.
fn weights_in(corners: [Vec3; 3], place: Vec3) -> Vec3 {
    if let Some(at) = corners.iter().position(|corner| *corner == place) {
        return Vec3::from_fn(|i, _| if i == at { 1.0 } else { 0.0 });
    }
    let [a, b, c] = corners.map(|corner| corner - place);
    let normal = (b - a).cross(&(c - a));
    let areas = Vec3::from([b.cross(&c), c.cross(&a), a.cross(&b)].map(|cross| cross.dot(&normal)));
    areas / areas.sum()
}

/// The ghost node of a clamped edge before the cut.
struct OldGhost<'a> {
    ghosts: &'a Nodes,
    index: usize,
}

/// Places the ghost node of a part of a clamped edge: in the direction of the ghost node of the whole edge, as far from it as its
/// mirror image is.
fn place_ghost(nodes: &mut Nodes, ghost: u32, ends: [u32; 2], old: OldGhost<'_>) {
    let at = |n: u32| nodes.rest[n as usize];
    let (a, b, mirror) = (at(ends[0]), at(ends[1]), at(ghost));
    let along = (b - a).normalize();
    let across = |p: Vec3| (p - a) - (p - a).dot(&along) * along;
    let OldGhost { ghosts, index: of } = old;
    let was = ghosts.rest[of];
    let rest = mirror - across(mirror) + across(mirror).norm() * across(was).normalize();
    let i = ghost as usize;
    nodes.rest[i] = rest;
    nodes.x[i] = nodes.rest[i] + (ghosts.x[of] - ghosts.rest[of]);
    nodes.v[i] = ghosts.v[of];
    nodes.constraint[i] = Constraint::Fixed;
}

/// Gives every element the history of the one it came from; none where it came from none.
fn carry_history(set: &mut ElementSet, old: &[f64], from: impl Fn(usize, &[u32]) -> Option<usize>) {
    let (count, mut history) = (set.count(), set.history().to_vec());
    let stride = history.len() / count.max(1);
    if stride == 0 {
        return;
    }
    let before = old.len() / stride;
    let corners = set.nodes().len() / count;
    for e in 0..count {
        let Some(of) = from(e, &set.nodes()[corners * e..][..corners]) else { continue };
        (0..stride).for_each(|plane| history[plane * count + e] = old[plane * before + of]);
    }
    set.set_history(&history);
}
