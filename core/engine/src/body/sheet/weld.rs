//! Welding of a sheet: two vertices on its border become one node, so that the triangles of both hang together and the edge between them bends as
//! any other. The mesh stays as it is.
//!
//! A welded node has the mass of both, and their mean position and velocity weighted by mass, so momentum is kept. Triangles keep their material
//! coordinates, so what was cut is as it was before.

use super::paint::sides;
use super::{Edges, NONE, Sheet, sorted};
use crate::body::lattice::{DrivenNode, LatticeError};
use crate::body::model::Model;
use pliant_plugin_api::abi;
use pliant_solver::{Constraint, ElementSet, Nodes, System, Vec3};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

/// Border edges face each other if the cosine of the angle between their conormals is at most this.
const FACING: f64 = -0.25;
/// Largest distance of two vertices at the same place at rest, in edges.
const SAME_PLACE: f64 = 1e-9;

/// Nodes and elements before a weld.
struct Before {
    /// Vertex of each node.
    vertex_of: Vec<u32>,
    /// Ghost nodes, in the order of the clamped edges.
    ghosts: Nodes,
    /// History of each element set.
    history: Vec<Vec<f64>>,
    /// Elements of each set by the vertices of their edge, or by their vertex.
    element: Vec<HashMap<[u32; 2], usize>>,
}

/// The border of a sheet in its present shape.
struct Border {
    /// For each border node, the conormals of its border edges: unit vectors in the plane of the triangle, normal to the edge, that point out of the sheet.
    outward: BTreeMap<u32, Vec<Vec3>>,
}

impl Border {
    /// The border of triangles (t x 3) with nodes at `x` (m, n x 3).
    fn new(triangles: &[[u32; 3]], x: &[Vec3]) -> Self {
        let mut border = Self { outward: BTreeMap::new() };
        let of_edge = sides(triangles);
        for (e, corners) in (0_u32..).zip(triangles) {
            for i in 0..3 {
                let [a, b, c] = [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]];
                if of_edge[&sorted([a, b])] != [e] {
                    continue;
                }
                let [along, away] = [b, c].map(|n| x[n as usize] - x[a as usize]);
                let out = away.dot(&along) / along.norm_squared() * along - away;
                // A degenerate triangle has no conormal; its nodes are on the border all the same.
                let out = out.try_normalize(0.0);
                [a, b].iter().for_each(|n| border.outward.entry(*n).or_default().extend(out));
            }
        }
        border
    }

    /// Whether the sheet lies on opposite sides of two nodes at `x` (m), and the two sides overlap by `join` (m) at most.
    fn faces(&self, x: &[Vec3], a: u32, b: u32, join: f64) -> bool {
        let gap = x[b as usize] - x[a as usize];
        let outward = |n: u32| self.outward.get(&n).into_iter().flatten();
        let is_gap = |u: &Vec3, w: &Vec3| gap.dot(u) >= -join && gap.dot(w) <= join;
        outward(a).any(|u| outward(b).any(|w| u.dot(w) <= FACING && is_gap(u, w)))
    }
}

impl Sheet {
    /// Welded vertices, each with the one whose node it has.
    pub fn welds(&self) -> &BTreeMap<u32, u32> {
        &self.welds
    }

    /// The vertex whose node a vertex has: itself if it is not welded.
    pub(super) fn representative(&self, vertex: u32) -> u32 {
        self.welds.get(&vertex).copied().unwrap_or(vertex)
    }

    /// Pairs of border nodes, the lower number first, within `radius` (m) of `centre` (m, present shape) and of each other. Each is the nearest candidate
    /// of the other; a copy across a cut comes before nearer nodes. Candidates are copies, nodes nearer than `join` (m), and nodes with the sheet on
    /// opposite sides whose sides overlap by `join` at most.
    pub(in crate::body) fn facing_nodes(
        &self,
        model: &Model,
        nodes: &Nodes,
        centre: Vec3,
        radius: f64,
        join: f64,
    ) -> Vec<[u32; 2]> {
        let distance = |a: u32, b: u32| (nodes.x[a as usize] - nodes.x[b as usize]).norm();
        let is_near = |n: &u32| (nodes.x[*n as usize] - centre).norm() <= radius;
        // All triangles at an edge of a near node are among them, so that what is a border there is known.
        let mut triangles = self.triangles(&model.surface);
        triangles.retain(|corners| corners.iter().any(is_near));
        let border = Border::new(&triangles, &nodes.x);
        let near: BTreeSet<u32> = border.outward.keys().copied().filter(is_near).collect();
        let mut joined: HashMap<u32, BTreeSet<u32>> = HashMap::new();
        for corners in &triangles {
            corners.iter().for_each(|n| joined.entry(*n).or_default().extend(corners));
        }
        let rest = |n: u32| nodes.rest[n as usize];
        let is_copy = |a: u32, b: u32| (rest(a) - rest(b)).norm() <= SAME_PLACE * self.edge;
        let may_join = |a: u32, b: u32| {
            let is_triangle = joined.get(&a).is_some_and(|joined| joined.contains(&b));
            let is_seam = is_copy(a, b) || distance(a, b) <= join || border.faces(&nodes.x, a, b, join);
            a != b && !is_triangle && self.may_weld([a, b], nodes) && is_seam
        };
        let partner_of = |a: u32| {
            let others = near.iter().copied().filter(|b| distance(a, *b) <= radius && may_join(a, *b));
            let copies_first = |b: u32, c: u32| is_copy(a, c).cmp(&is_copy(a, b));
            others.min_by(|b, c| copies_first(*b, *c).then(distance(a, *b).total_cmp(&distance(a, *c))))
        };
        let partner: BTreeMap<u32, u32> = near.iter().filter_map(|a| Some((*a, partner_of(*a)?))).collect();
        let is_mutual = |(a, b): &(&u32, &u32)| a < b && partner.get(*b) == Some(a);
        partner.iter().filter(is_mutual).map(|(a, b)| [*a, *b]).collect()
    }

    /// Whether two nodes may become one: at least one is free, and neither is the end of a clamped edge.
    pub(crate) fn may_weld(&self, pair: [u32; 2], nodes: &Nodes) -> bool {
        pair.iter().any(|n| nodes.constraint[*n as usize].is_free()) && !pair.iter().any(|n| self.is_clamped(*n))
    }

    /// Whether a node is the end of a clamped edge.
    fn is_clamped(&self, node: u32) -> bool {
        self.clamped.iter().flatten().any(|v| self.node_of[*v as usize] == node)
    }

    /// Makes each pair of nodes one node: the first, at the mean place of both.
    ///
    /// # Errors
    /// Returns the error of the material; the sheet must then be restored.
    pub(in crate::body) fn weld(
        &mut self,
        pairs: &[[u32; 2]],
        model: &Model,
        system: &mut System,
    ) -> Result<(), LatticeError> {
        let own = self.vertex_of.len();
        let before = Before {
            vertex_of: self.vertex_of.clone(),
            ghosts: system.nodes.split_off(own),
            history: system.sets.iter().map(|set| set.history().to_vec()).collect(),
            element: system.sets.iter().map(|set| elements_by_vertex(set, &self.vertex_of)).collect(),
        };
        let mut is_gone = vec![false; own];
        for &[a, b] in pairs {
            merge(&mut system.nodes, a, b);
            is_gone[b as usize] = true;
            self.join(self.vertex_of[a as usize], self.vertex_of[b as usize]);
        }
        let kept: Vec<u32> = (0..own as u32).filter(|n| !is_gone[*n as usize]).collect();
        system.nodes = system.nodes.select(&kept);
        self.number(&model.surface);
        let fixing_of: HashMap<u32, u32> = self.driven.iter().map(|driven| (driven.node, driven.fixing)).collect();
        let renumbered = |driven: &DrivenNode| {
            let vertex = before.vertex_of.get(driven.node as usize)?;
            Some(DrivenNode { node: self.node_of[*vertex as usize], ..*driven })
        };
        self.driven = self.driven.iter().filter_map(renumbered).collect();
        let triangles = self.triangles(&model.surface);
        let clamped: HashMap<[u32; 2], usize> =
            self.clamped.iter().map(|ends| sorted(ends.map(|v| self.representative(v)))).zip(0..).collect();
        let edges = Edges::new(&triangles, |ends| clamped.contains_key(&self.vertices(ends)), &mut system.nodes);
        for (i, ends) in edges.clamped.iter().enumerate() {
            let (ghost, old) = (kept.len() + i, clamped[&self.vertices(*ends)]);
            let (nodes, ghosts) = (&mut system.nodes, &before.ghosts);
            (nodes.rest[ghost], nodes.x[ghost], nodes.v[ghost]) = (ghosts.rest[old], ghosts.x[old], ghosts.v[old]);
            nodes.constraint[ghost] = Constraint::Fixed;
            if let Some(&fixing) = fixing_of.get(&((own + old) as u32)) {
                self.driven.push(DrivenNode { node: ghost as u32, fixing });
            }
        }
        self.clamped = Arc::new(edges.clamped.iter().map(|ends| self.vertices(*ends)).collect());
        self.list_elements(system, &triangles, edges)?;
        self.restore_history(&before, system);
        self.has_changed = true;
        Ok(())
    }

    /// Records that `vertex` and those welded to it have the node of `to` from now on.
    fn join(&mut self, to: u32, vertex: u32) {
        let welds = Arc::make_mut(&mut self.welds);
        welds.values_mut().filter(|of| **of == vertex).for_each(|of| *of = to);
        welds.insert(vertex, to);
        if self.paint.pins.contains(&vertex) {
            Arc::make_mut(&mut self.paint.pins).insert(to);
        }
    }

    /// Gives each element the history of the element with the same vertices before; of two edges that have become one, that of either.
    fn restore_history(&self, before: &Before, system: &mut System) {
        for (set, (old, element)) in system.sets.iter_mut().zip(before.history.iter().zip(&before.element)) {
            let (count, mut history) = (set.count(), set.history().to_vec());
            let (stride, old_count) = (history.len() / count.max(1), element_count(old, set));
            if stride == 0 {
                continue;
            }
            let element: HashMap<[u32; 2], usize> =
                element.iter().map(|(key, e)| (sorted(key.map(|v| self.representative(v))), *e)).collect();
            let corners = set.nodes().len() / count;
            for e in 0..count {
                let nodes = &set.nodes()[corners * e..][..corners];
                let from = match key_of(set, nodes, &self.vertex_of) {
                    Some(key) => element.get(&key).copied(),
                    None => Some(e),
                };
                let Some(from) = from else { continue };
                (0..stride).for_each(|plane| history[plane * count + e] = old[plane * old_count + from]);
            }
            set.set_history(&history);
        }
    }
}

/// Number of elements that a history of a set was of.
fn element_count(history: &[f64], set: &ElementSet) -> usize {
    history.len() / (set.request().history_stride as usize).max(1)
}

/// What identifies an element across a weld: the vertices of its edge, or twice its vertex; `None` for a triangle, which keeps its number.
fn key_of(set: &ElementSet, nodes: &[u32], vertex_of: &[u32]) -> Option<[u32; 2]> {
    let vertex = |n: u32| vertex_of.get(n as usize).copied().unwrap_or(NONE);
    match set.request().kind {
        abi::TRIANGLE => None,
        abi::POINT => Some([vertex(nodes[0]); 2]),
        abi::LINK | abi::HINGE => Some(sorted([vertex(nodes[0]), vertex(nodes[1])])),
        kind => unreachable!("a sheet lists no elements of kind {kind}"),
    }
}

fn elements_by_vertex(set: &ElementSet, vertex_of: &[u32]) -> HashMap<[u32; 2], usize> {
    if set.history().is_empty() {
        return HashMap::new();
    }
    let corners = set.nodes().len() / set.count().max(1);
    let elements = set.nodes().chunks_exact(corners.max(1)).enumerate();
    elements.filter_map(|(e, nodes)| Some((key_of(set, nodes, vertex_of)?, e))).collect()
}

/// Moves node `a` to the mean place and velocity of `a` and `b`, by mass; a node that is held stays where it is, and then both are.
fn merge(nodes: &mut Nodes, a: u32, b: u32) {
    let (i, j) = (a as usize, b as usize);
    let held = [i, j].into_iter().find(|n| !nodes.constraint[*n].is_free());
    let share = nodes.mass[j] / (nodes.mass[i] + nodes.mass[j]);
    let share = held.map_or(share, |held| if held == j { 1.0 } else { 0.0 });
    let mean = |field: &[Vec3]| field[i] + share * (field[j] - field[i]);
    let (rest, x, v) = (mean(&nodes.rest), mean(&nodes.x), mean(&nodes.v));
    (nodes.rest[i], nodes.x[i], nodes.v[i]) = (rest, x, v);
    if held == Some(j) {
        (nodes.constraint[i], nodes.prescribed[i]) = (nodes.constraint[j], nodes.prescribed[j]);
    }
}
