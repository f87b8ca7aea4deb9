//! The active region: it follows the contacts, and state moves with it.

use super::history::Histories;
use super::{DrivenNode, Lattice, LatticeError, NO_WEIGHTS, kind_name};
use crate::body::fixing::Fixing;
use crate::body::lattice::fragments::{NewCopy, NodeKey};
use crate::body::model::Model;
use crate::body::skin::{NOT_EMBEDDED, Skin};
use pliant_host::Region;
use pliant_mesh::tetrahedra::PARTS;
use pliant_plugin_api::abi::{self, Ball};
use pliant_solver::{Constraint, ElementList, ElementSet, Nodes, System, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Share of the radius by which a contact may move before the region follows.
const FOLLOW_DISTANCE: f64 = 0.25;
/// Largest displacement of a node at rest, in edges of a cell.
const REST_DISPLACEMENT: f64 = 1e-6;
/// [`REST_DISPLACEMENT`] for a material with a history, whose elastic field around plastic deformation extends over the whole body. The release of
/// a cell moves its surface by less.
const REST_DISPLACEMENT_WITH_HISTORY: f64 = 1e-4;
/// Largest speed of a node at rest, in edges of a cell per second.
const REST_SPEED: f64 = 1e-3;
/// Share of the cells of a body from which on a region takes in all of them if the material has a history, or two hands grip the body: the few left
/// would hold it like a hinge that flows, or that hinders the hands.
const NEARLY_WHOLE: f64 = 0.9;
/// Steps between two checks whether cells that contacts have left are back at rest.
const RELEASE_INTERVAL: u32 = 32;

impl Lattice {
    /// Activates the cells within the `wanted` balls around contacts, or the whole body. Returns whether the region changed.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin; the region is then the one before.
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
        if !self.needs_rebuild && !self.has_new_grips && is_covered {
            let is_due = !self.is_whole() && !self.region.cell_id.is_empty() && self.steps >= RELEASE_INTERVAL;
            if !(is_due && self.can_release_cells(wanted, system)) {
                return Ok(false);
            }
        }
        let only_cut = self.needs_rebuild && is_covered && !self.grid_region.cell_id.is_empty();
        (self.steps, self.needs_rebuild, self.has_new_grips) = (0, false, false);
        if !only_cut {
            self.request_region(wanted, system)?;
        }
        if self.has_cuts() {
            self.fragments.apply(&self.grid_region, self.families, &mut self.spare);
        }
        self.replace_region(model, fixings, skin, system)?;
        Ok(true)
    }

    /// Has the grid list the cells around contacts and those not yet back at rest: in `grid_region` for a body with cuts, else in `spare`.
    fn request_region(&mut self, wanted: &[Ball], system: &System) -> Result<(), LatticeError> {
        let keep: Vec<u64> = self.lasting_cells(system).collect();
        let region = if self.has_cuts() { &mut self.grid_region } else { &mut self.spare };
        self.source.region(self.settings.level, self.families, wanted, &keep, region)?;
        let all = (self.facts.surface_cells + self.facts.inside_cells) as usize;
        let flows = system.sets.iter().any(|set| set.has(abi::HAS_HISTORY));
        let is_free = flows || !self.grips.is_empty();
        let has_room = is_free && !wanted.is_empty() && all <= self.most_cells;
        self.is_nearly_whole = has_room && region.cell_id.len() as f64 >= NEARLY_WHOLE * all as f64;
        if self.is_nearly_whole && region.cell_id.len() < all {
            let whole = [Ball { centre: self.facts.origin, radius: f64::INFINITY }];
            self.source.region(self.settings.level, self.families, &whole, &keep, region)?;
        }
        if region.cell_id.len() > self.most_cells {
            return Err(LatticeError::Memory { cells: region.cell_id.len(), most: self.most_cells });
        }
        if self.fragments.is_part() {
            let present: Vec<bool> = region.cell_id.iter().map(|id| !self.fragments.is_absent(*id)).collect();
            region.retain_cells(|cell| present[cell]);
        }
        self.contact_balls.clear();
        self.contact_balls.extend_from_slice(wanted);
        if !wanted.is_empty() {
            self.last_contact_balls.clone_from(&self.contact_balls);
        }
        Ok(())
    }

    /// Whether the region still serves the wanted balls: none is new and none has moved or grown much.
    fn is_covered(&self, wanted: &[Ball]) -> bool {
        let near = |a: &Ball, b: &Ball| {
            let way = Vec3::from(a.centre) - Vec3::from(b.centre);
            // The ball around a blade changes its radius.
            let moved = way.norm() + (a.radius - b.radius).abs();
            a.radius == f64::INFINITY && b.radius == f64::INFINITY || moved <= FOLLOW_DISTANCE * a.radius.min(b.radius)
        };
        wanted.len() == self.contact_balls.len() && wanted.iter().zip(&self.contact_balls).all(|(a, b)| near(a, b))
    }

    /// Ids, ascending, of active cells that must stay so: with a node that is not at rest, or with the history of an element that can fail, which would be whole
    /// again without it.
    fn lasting_cells(&self, system: &System) -> impl Iterator<Item = u64> {
        let (nodes, is_damaged) = (&system.nodes, self.damaged_cells(system));
        let displacement = if self.keeps_displaced { REST_DISPLACEMENT_WITH_HISTORY } else { REST_DISPLACEMENT };
        let (far, fast) = (displacement * self.facts.edge, REST_SPEED * self.facts.edge);
        let moving = move |i: usize| {
            if self.keeps_displaced && self.holds(i) {
                return true;
            }
            let (u, v) = (nodes.x[i] - nodes.rest[i], nodes.v[i]);
            u.norm_squared() > far * far || v.norm_squared() > fast * fast
        };
        let cells = self.region.cell_id.iter().zip(&self.region.cell_corners).enumerate();
        let lasts = move |cell: usize, corners: &[u32; 8]| {
            is_damaged.get(cell).copied().unwrap_or(false) || corners.iter().any(|&n| moving(n as usize))
        };
        cells.filter(move |(cell, (_, corners))| lasts(*cell, corners)).map(|(_, (id, _))| *id)
    }

    /// Whether each active cell has a tetrahedron that can fail and has a history (c); empty where none can fail.
    fn damaged_cells(&self, system: &System) -> Vec<bool> {
        let of_cells = |set: &&ElementSet| set.has(abi::CAN_FAIL) && self.lists_all_tetrahedra(set.nodes());
        let Some(set) = system.sets.iter().find(of_cells) else { return Vec::new() };
        let per_cell = self.tetrahedra_per_cell();
        let mut is_damaged = vec![false; self.region.cell_id.len()];
        for plane in set.history().chunks_exact(set.count().max(1)) {
            let cells = plane.chunks_exact(per_cell).zip(&mut is_damaged);
            cells.for_each(|(values, is_damaged)| *is_damaged |= values.iter().any(|value| *value != 0.0));
        }
        is_damaged
    }

    /// Whether a cell outside the wanted balls is back at rest.
    fn can_release_cells(&self, wanted: &[Ball], system: &System) -> bool {
        if self.is_nearly_whole {
            return false;
        }
        let mut moving = self.lasting_cells(system).peekable();
        self.region.cell_id.iter().zip(&self.region.cell_corners).any(|(id, corners)| {
            while moving.peek().is_some_and(|u| u < id) {
                moving.next();
            }
            let outside = |ball: &Ball| {
                (self.grid_rest(corners[0]) - Vec3::from(ball.centre)).norm() > ball.radius + 2.0 * self.facts.edge
            };
            moving.peek() != Some(id) && wanted.iter().all(outside)
        })
    }

    /// Makes `spare` the active region: updates the embedding of the surface, transfers the state of nodes and elements that stay, and lists
    /// constraints and elements.
    pub(super) fn replace_region(
        &mut self,
        model: &Model,
        fixings: &[Fixing],
        skin: &mut Skin,
        system: &mut System,
    ) -> Result<(), LatticeError> {
        let momenta = self.copy_momenta(&system.nodes);
        let settle = |v: u32, skin: &mut Skin| {
            skin.cell[v as usize] = NOT_EMBEDDED;
            skin.x[v as usize] = skin.settled[v as usize];
            skin.pages.mark(v);
        };
        for cell in 0..self.region.cell_id.len() as u32 {
            self.points(cell)?.iter().for_each(|&v| settle(v, skin));
        }
        self.forget_failed_cells();
        std::mem::swap(&mut self.region, &mut self.spare);
        for cell in 0..self.region.cell_id.len() as u32 {
            self.points(cell)?.iter().for_each(|v| skin.cell[*v as usize] = cell);
        }
        self.measure_longest_edges(model)?;
        // Parts of a local region may be connected outside of it.
        if self.has_cuts() && self.is_whole() {
            self.rebind_torn_triangles(model, skin)?;
        }
        self.weights.clear();
        self.weights_of.clear();
        self.weights_of.resize(self.region.cell_id.len(), NO_WEIGHTS);
        self.has_history = system.sets.iter().any(|set| set.has(abi::HAS_HISTORY));
        let histories = Histories::take(system);
        let old_node = self.transfer_nodes(&mut system.nodes);
        self.update_smooth_embedding()?;
        self.find_pinned(&system.nodes);
        self.constrain(fixings, &mut system.nodes)?;
        self.list_elements(system)?;
        self.list_fields(system);
        self.list_directions(system);
        system.prepare()?;
        histories.restore(system, &old_node);
        self.keep_momenta(&momenta, &mut system.nodes);
        super::check_mass(system)
    }

    /// Finds the longest edge at the surface points of each active cell.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn measure_longest_edges(&mut self, model: &Model) -> Result<(), LatticeError> {
        let mut longest_edge_of = std::mem::take(&mut self.longest_edge_of);
        longest_edge_of.clear();
        for cell in 0..self.region.cell_id.len() as u32 {
            let edges = self.points(cell)?.iter().map(|v| model.longest_edge(*v));
            longest_edge_of.push(edges.fold(0.0, f64::max));
        }
        self.longest_edge_of = longest_edge_of;
        Ok(())
    }

    /// Moves the state of the nodes from the region before, which is in `spare`, to the active one. Nodes of both are sorted by key, so one
    /// pass pairs them. A new copy starts with the state of its original. Returns the number of each node in the region before, if it was there.
    fn transfer_nodes(&mut self, nodes: &mut Nodes) -> Vec<Option<usize>> {
        let n = self.region.node_id.len();
        let (mut x, mut v): (Vec<Vec3>, Vec<Vec3>) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut original_of: HashMap<NodeKey, NodeKey> = HashMap::new();
        for NewCopy { key, original } in self.fragments.new_copies.drain(..) {
            // A copy of a copy has the state of the first one, which alone has been active.
            let first = original_of.get(&original).copied().unwrap_or(original);
            original_of.insert(key, first);
        }
        self.paint.pin_copies(original_of.iter());
        for (copy, original) in &original_of {
            if let Some(offset) = self.rest_offsets.get(original).copied() {
                self.rest_offsets.insert(*copy, offset);
            }
        }
        let key = |region: &Region, i: usize| NodeKey { node: region.node_id[i], copy: region.node_copy[i] };
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
            let from = if stays { Some(at) } else { original_of.get(&wanted).and_then(|original| old(*original)) };
            let rest = self.grid_rest(i as u32);
            let rest = self.rest_offsets.get(&wanted).map_or(rest, |offset| rest + offset.displacement);
            nodes.rest.push(rest);
            x.push(from.map_or(rest, |old| nodes.x[old]));
            v.push(from.map_or(Vec3::zeros(), |old| nodes.v[old]));
            old_node.push(from);
        }
        (nodes.x, nodes.v) = (x, v);
        old_node
    }

    /// Sets the points of the rest shape that hands grip, m. From two on they hold what they grip, each other's reactions included.
    pub fn set_grips(&mut self, grips: &[Vec3]) {
        let grips = if grips.len() < 2 { &[] } else { grips };
        if self.grips != grips {
            self.grips.clear();
            self.grips.extend_from_slice(grips);
            self.has_new_grips = true;
        }
    }

    /// Constrains nodes: those of fixings, pinned ones, those on the border of the region, and those outside of all contact balls.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn constrain(&mut self, fixings: &[Fixing], nodes: &mut Nodes) -> Result<(), LatticeError> {
        let n = nodes.x.len();
        nodes.constraint.clear();
        nodes.constraint.resize(n, Constraint::Free);
        nodes.prescribed.clear();
        nodes.prescribed.resize(n, Vec3::zeros());
        self.returning.clear();
        self.driven.clear();
        self.grips_apart = None;
        for i in 0..n {
            let rest = self.grid_rest(i as u32);
            let inside = |ball: &Ball| {
                (rest - Vec3::from(ball.centre)).norm_squared() <= (ball.radius + 2.0 * self.facts.edge).powi(2)
            };
            if let Some(fixing) = fixings.iter().position(|f| f.place.contains(i as u32, rest)) {
                nodes.constraint[i] = Constraint::Fixed;
                if fixings[fixing].moves() {
                    self.driven.push(DrivenNode { node: i as u32, fixing: fixing as u32 });
                }
            } else if self.holds(i) {
                nodes.constraint[i] = Constraint::Fixed;
                nodes.v[i] = Vec3::zeros();
            } else if self.region.node_border[i] != 0 {
                nodes.constraint[i] = Constraint::Fixed;
                if !self.keeps_displaced {
                    self.returning.push(i as u32);
                }
            } else if !self.keeps_displaced && !self.is_nearly_whole && !self.contact_balls.iter().any(inside) {
                nodes.constraint[i] = Constraint::Fixed;
                self.returning.push(i as u32);
            }
        }
        let balls = if self.keeps_displaced { &self.last_contact_balls } else { &self.contact_balls };
        let has_contact = !balls.is_empty();
        if !self.is_whole() && has_contact {
            self.constrain_detached_parts(nodes)?;
        }
        Ok(())
    }

    /// Lists the elements of every kind that the material asks for.
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
                // Families of links are those of cubes.
                abi::LINK if self.source.plugin().is_some() => {
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
                        discretization: self.source.kind(),
                    });
                }
            }
        }
        Ok(())
    }

    /// Lists the tetrahedra of each active cell in turn, or of a cube only the inner one with three times the measure: its volume is a third of the cube's.
    /// Quadratic tetrahedra are listed as stencils of their nodes.
    fn list_tetrahedra(&self, list: &mut ElementList, inner_only: bool) {
        let region = &self.region;
        list.weights = self.source.tetrahedra().and_then(|cells| cells.corner_weights());
        if let Some(weights) = list.weights {
            for [a, b, c, d, ..] in region.cell_corners.as_chunks::<PARTS>().0 {
                // The part at each corner has this corner and the middles of three edges.
                list.nodes.extend([a[0], b[1], c[2], d[3], a[1], b[2], a[2], a[3], b[3], c[3]]);
            }
            list.measure.resize(region.cell_corners.len() / PARTS * weights.parts(), 1.0);
            return;
        }
        for (cell, corners) in region.cell_corners.iter().enumerate() {
            let share = self.fragments.share(self.cell_fragment(cell as u32));
            let (tetrahedra, measure) = match self.source.tetrahedra_of(region, &self.facts, cell as u32) {
                [.., inner] if inner_only && self.source.plugin().is_some() => {
                    (std::slice::from_ref(inner), 3.0 * share)
                }
                all => (all, share),
            };
            for tetrahedron in tetrahedra {
                list.nodes.extend(tetrahedron.map(|c| corners[c as usize]));
                list.measure.push(measure);
            }
        }
    }

    /// Makes the present shape of the active nodes their rest shape, with zero velocity and history. Returns the triangles whose position
    /// at rest has changed.
    ///
    /// # Errors
    /// Returns the error of the material, if it refuses the new rest shape.
    pub fn keep(&mut self, model: &Model, skin: &mut Skin, system: &mut System) -> Result<Vec<u32>, LatticeError> {
        let nodes = &mut system.nodes;
        self.add_rest_jets(|n| nodes.x[n as usize] - nodes.rest[n as usize]);
        for i in 0..nodes.x.len() {
            let displacement = nodes.x[i] - self.grid_rest(i as u32);
            self.store_rest_offset(i as u32, displacement);
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
        self.list_directions(system);
        system.rest()?;
        Ok(triangles)
    }
}
