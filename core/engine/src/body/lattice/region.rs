//! Moving the region with the hand.

use super::history::Histories;
use super::{Lattice, LatticeError, NO_WEIGHTS, kind_name};
use crate::body::fixing::Fixing;
use crate::body::lattice::fragments::NodeKey;
use crate::body::model::Model;
use crate::body::skin::{NOT_CARRIED, Skin};
use pliant_host::Region;
use pliant_plugin_api::CELL_TETRAHEDRA;
use pliant_plugin_api::abi::{self, Ball};
use pliant_solver::{Constraint, ElementList, Nodes, System, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// A contact may move by this share of the radius before the region follows.
const SLACK: f64 = 0.25;
/// Displacement, in edges of a cell, and speed, in edges a second, below which a node counts as back at rest.
const AT_REST: f64 = 1e-6;
/// The same displacement of a material with a history: an elastic field around what has flowed does not end. A cell that is given up moves
/// its surface by less.
const AT_REST_AFTER_FLOW: f64 = 1e-4;
const STILL: f64 = 1e-3;
/// Steps between two looks at whether what the hand has left is back at rest.
const PATIENCE: u32 = 32;

impl Lattice {
    /// Makes the cells around `wanted` contacts active, or the whole body. Gives whether anything changed.
    ///
    /// # Errors
    /// What grid or material say; the region is then as it was.
    pub fn follow(
        &mut self,
        wanted: &[Ball],
        model: &Model,
        fixings: &[Fixing],
        skin: &mut Skin,
        system: &mut System,
    ) -> Result<bool, LatticeError> {
        let whole = [Ball { centre: self.facts.origin, radius: f64::INFINITY }];
        let wanted = if self.is_whole() { &whole } else { wanted };
        self.steps += 1;
        let is_covered = self.is_covered(wanted);
        if !self.stale && is_covered {
            let waiting = !self.is_whole() && !self.region.cell_id.is_empty() && self.steps >= PATIENCE;
            if !(waiting && self.has_left_something(wanted, &system.nodes)) {
                return Ok(false);
            }
        }
        let only_cut = self.stale && is_covered && !self.uncut.cell_id.is_empty();
        (self.steps, self.stale) = (0, false);
        if !only_cut {
            self.ask(wanted, &system.nodes)?;
        }
        if self.has_cuts() {
            self.fragments.apply(&self.uncut, self.families, &mut self.spare);
        }
        self.exchange(model, fixings, skin, system)?;
        Ok(true)
    }

    /// Has the grid list the cells around contacts and those that are not yet back at rest: to be cut, if there are cuts.
    fn ask(&mut self, wanted: &[Ball], nodes: &Nodes) -> Result<(), LatticeError> {
        let keep: Vec<u64> = self.unfinished(nodes).collect();
        let region = if self.has_cuts() { &mut self.uncut } else { &mut self.spare };
        self.grid.region(self.settings.level, self.families, wanted, &keep, region)?;
        self.balls.clear();
        self.balls.extend_from_slice(wanted);
        if !wanted.is_empty() {
            self.last_balls.clone_from(&self.balls);
        }
        Ok(())
    }

    fn is_covered(&self, wanted: &[Ball]) -> bool {
        let near = |a: &Ball, b: &Ball| {
            let way = Vec3::from(a.centre) - Vec3::from(b.centre);
            // That of a blade follows what of it is inside.
            let moved = way.norm() + (a.radius - b.radius).abs();
            a.radius == f64::INFINITY && b.radius == f64::INFINITY || moved <= SLACK * a.radius.min(b.radius)
        };
        wanted.len() == self.balls.len() && wanted.iter().zip(&self.balls).all(|(a, b)| near(a, b))
    }

    /// Ids of cells with a node that is not at rest.
    fn unfinished(&self, nodes: &Nodes) -> impl Iterator<Item = u64> {
        let at_rest = if self.keeps_shape { AT_REST_AFTER_FLOW } else { AT_REST };
        let (far, fast) = (at_rest * self.facts.edge, STILL * self.facts.edge);
        let moving = move |i: usize| {
            let (u, v) = (nodes.x[i] - nodes.rest[i], nodes.v[i]);
            u.norm_squared() > far * far || v.norm_squared() > fast * fast
        };
        let cells = self.region.cell_id.iter().zip(&self.region.cell_corners);
        cells.filter(move |(_, corners)| corners.iter().any(|&n| moving(n as usize))).map(|(id, _)| *id)
    }

    /// Whether a cell outside the wanted balls has come to rest, and can be given up.
    fn has_left_something(&self, wanted: &[Ball], nodes: &Nodes) -> bool {
        let mut unfinished = self.unfinished(nodes).peekable();
        self.region.cell_id.iter().zip(&self.region.cell_corners).any(|(id, corners)| {
            while unfinished.peek().is_some_and(|u| u < id) {
                unfinished.next();
            }
            let outside = |ball: &Ball| {
                (self.grid_rest(corners[0]) - Vec3::from(ball.centre)).norm() > ball.radius + 2.0 * self.facts.edge
            };
            unfinished.peek() != Some(id) && wanted.iter().all(outside)
        })
    }

    /// Takes over the region in `spare`, with the state of the nodes that stay.
    pub(super) fn exchange(
        &mut self,
        model: &Model,
        fixings: &[Fixing],
        skin: &mut Skin,
        system: &mut System,
    ) -> Result<(), LatticeError> {
        let settled = |v: u32, skin: &mut Skin| {
            skin.cell[v as usize] = NOT_CARRIED;
            skin.x[v as usize] = skin.settled[v as usize];
            skin.pages.mark(v);
        };
        for cell in 0..self.region.cell_id.len() as u32 {
            self.points(cell)?.iter().for_each(|&v| settled(v, skin));
        }
        std::mem::swap(&mut self.region, &mut self.spare);
        let mut edge_of = std::mem::take(&mut self.edge_of);
        edge_of.clear();
        for cell in 0..self.region.cell_id.len() as u32 {
            let mut longest = 0.0_f64;
            for &v in self.points(cell)? {
                skin.cell[v as usize] = cell;
                longest = longest.max(model.longest_edge(v));
            }
            edge_of.push(longest);
        }
        self.edge_of = edge_of;
        // Outside of a local region its parts may hang together.
        if self.has_cuts() && self.is_whole() {
            self.rebind_strays(model, skin)?;
        }
        self.weights.clear();
        self.weights_of.clear();
        self.weights_of.resize(self.region.cell_id.len(), NO_WEIGHTS);
        self.keeps_shape = system.sets.iter().any(|set| set.has(abi::HAS_HISTORY));
        let histories = Histories::take(system);
        let old_node = self.exchange_nodes(&mut system.nodes);
        self.list_slopes()?;
        self.constrain(fixings, &mut system.nodes);
        self.list_elements(system)?;
        self.list_fields(system);
        system.prepare()?;
        histories.give(system, &old_node);
        super::check_mass(system)
    }

    /// The region before is in `spare`: both lists of keys rise, so one pass pairs them. A copy a cut has just made begins
    /// where what it was copied from is. Gives the number each node had, if it was there.
    fn exchange_nodes(&mut self, nodes: &mut Nodes) -> Vec<Option<usize>> {
        let n = self.region.node_id.len();
        let (mut x, mut v): (Vec<Vec3>, Vec<Vec3>) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let born: HashMap<NodeKey, NodeKey> = self.fragments.born.drain(..).collect();
        for (copy, from) in &born {
            if let Some(kept) = self.kept.get(from).copied() {
                self.kept.insert(*copy, kept);
            }
        }
        let key = |region: &Region, i: usize| (region.node_id[i], region.node_copy[i]);
        let old = |wanted: NodeKey| -> Option<usize> {
            let (mut low, mut high) = (0, self.spare.node_id.len());
            while low < high {
                let middle = low.midpoint(high);
                if key(&self.spare, middle) < wanted { low = middle + 1 } else { high = middle }
            }
            (low < self.spare.node_id.len() && key(&self.spare, low) == wanted).then_some(low)
        };
        nodes.rest.clear();
        let mut old_node = Vec::with_capacity(n);
        let mut at = 0;
        for i in 0..n {
            let wanted = key(&self.region, i);
            while at < self.spare.node_id.len() && key(&self.spare, at) < wanted {
                at += 1;
            }
            let stays = at < self.spare.node_id.len() && key(&self.spare, at) == wanted;
            let from = if stays { Some(at) } else { born.get(&wanted).and_then(|parent| old(*parent)) };
            let rest = self.grid_rest(i as u32);
            let rest = self.kept.get(&wanted).map_or(rest, |kept| rest + kept.moved);
            nodes.rest.push(rest);
            x.push(from.map_or(rest, |old| nodes.x[old]));
            v.push(from.map_or(Vec3::zeros(), |old| nodes.v[old]));
            old_node.push(from);
        }
        (nodes.x, nodes.v) = (x, v);
        old_node
    }

    /// Who is free, who is driven and who returns.
    fn constrain(&mut self, fixings: &[Fixing], nodes: &mut Nodes) {
        let n = nodes.x.len();
        nodes.constraint.clear();
        nodes.constraint.resize(n, Constraint::Free);
        nodes.prescribed.clear();
        nodes.prescribed.resize(n, Vec3::zeros());
        self.returning.clear();
        self.driven.clear();
        for i in 0..n {
            let rest = self.grid_rest(i as u32);
            let inside = |ball: &Ball| {
                (rest - Vec3::from(ball.centre)).norm_squared() <= (ball.radius + 2.0 * self.facts.edge).powi(2)
            };
            if let Some(fixing) = fixings.iter().position(|f| f.place.holds(i as u32, rest)) {
                nodes.constraint[i] = Constraint::Fixed;
                if fixings[fixing].moves() {
                    self.driven.push((i as u32, fixing as u32));
                }
            } else if self.region.node_border[i] != 0 {
                nodes.constraint[i] = Constraint::Fixed;
                if !self.keeps_shape {
                    self.returning.push(i as u32);
                }
            } else if !self.keeps_shape && !self.balls.iter().any(inside) {
                nodes.constraint[i] = Constraint::Fixed;
                self.returning.push(i as u32);
            }
        }
        let has_contact = if self.keeps_shape { !self.last_balls.is_empty() } else { !self.balls.is_empty() };
        if !self.is_whole() && has_contact {
            self.constrain_detached_parts(nodes);
        }
    }

    fn list_elements(&self, system: &mut System) -> Result<(), LatticeError> {
        let region = &self.region;
        for set in &mut system.sets {
            let request = *set.request();
            let list = set.list_mut();
            list.nodes.clear();
            list.family.clear();
            list.measure.clear();
            match request.kind {
                abi::POINT => {
                    list.nodes.extend(0..region.node_id.len() as u32);
                    list.measure.extend_from_slice(&region.node_measure);
                }
                abi::LINK => {
                    let wanted = |l: &usize| region.link_family[*l] & request.families != 0;
                    for l in (0..region.link_family.len()).filter(wanted) {
                        list.nodes.extend(region.link_nodes[l]);
                        list.family.push(region.link_family[l]);
                        list.measure.push(region.link_measure[l]);
                    }
                }
                abi::TETRAHEDRON => self.list_tetrahedra(list, request.flags & abi::INNER_TETRAHEDRON != 0),
                kind => {
                    let material = system.material.name().to_owned();
                    return Err(LatticeError::Unsupported {
                        material,
                        wanted: kind_name(kind),
                        discretization: "grid",
                    });
                }
            }
        }
        Ok(())
    }

    /// Lists the five tetrahedra of each cell or fragment of one, or only the inner one with three times the measure, in the order of
    /// the cells.
    fn list_tetrahedra(&self, list: &mut ElementList, inner_only: bool) {
        let region = &self.region;
        for (cell, corners) in region.cell_corners.iter().enumerate() {
            let parity = self.cell_parity(cell as u32);
            let share = self.fragments.share(region.cell_id[cell], region.cell_fragment[cell] as usize);
            let all = &CELL_TETRAHEDRA[parity];
            let (tetrahedra, measure) = if inner_only { (&all[4..], 3.0 * share) } else { (&all[..], share) };
            for tetrahedron in tetrahedra {
                list.nodes.extend(tetrahedron.map(|c| corners[c as usize]));
                list.measure.push(measure);
            }
        }
    }

    /// Which of the two mirrored divisions into tetrahedra an active cell has, 0 or 1: neighbours alternate, so that their faces match.
    pub(super) fn cell_parity(&self, cell: u32) -> usize {
        let least = self.region.node_rest[self.region.cell_corners[cell as usize][0] as usize];
        let index = |i: usize| ((least[i] - self.facts.origin[i]) / self.facts.edge).round() as i64;
        ((index(0) + index(1) + index(2)) & 1) as usize
    }

    /// Makes the present shape of the active nodes their rest shape, at rest. Gives the triangles that have moved.
    ///
    /// # Errors
    /// What the material says of the new rest shape.
    pub fn keep(&mut self, model: &Model, skin: &mut Skin, system: &mut System) -> Result<Vec<u32>, LatticeError> {
        let nodes = &mut system.nodes;
        self.keep_slopes(|n| nodes.x[n as usize] - nodes.rest[n as usize]);
        for i in 0..nodes.x.len() {
            let moved = nodes.x[i] - self.grid_rest(i as u32);
            self.keep_node(i as u32, moved);
            nodes.v[i] = Vec3::zeros();
        }
        let mut triangles = Vec::new();
        let (settled, x) = (Arc::make_mut(&mut skin.settled), &skin.x);
        for cell in 0..self.region.cell_id.len() as u32 {
            for &v in self.points(cell)? {
                if settled[v as usize] != x[v as usize] {
                    settled[v as usize] = x[v as usize];
                    skin.pages.mark(v);
                    triangles.extend_from_slice(model.around(v));
                }
            }
        }
        triangles.sort_unstable();
        triangles.dedup();
        Arc::make_mut(&mut skin.tree).refit(&skin.settled, &model.surface.triangles, &triangles);
        nodes.rest.copy_from_slice(&nodes.x);
        system.clear_history();
        system.rest()?;
        Ok(triangles)
    }
}
