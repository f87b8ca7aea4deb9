//! Fields of material parameters, given by the scene or painted by strokes, evaluated for the elements of a lattice.
//!
//! A cell has the factors at its centre, so an interface is resolved to one cell. An element that belongs to several cells, such as a point
//! or a link on an edge, has the mean of their factors.

use super::Lattice;
use crate::body::StiffnessFactor;
use pliant_mesh::tetrahedra::PARTS;
use pliant_plugin_api::abi;
use pliant_solver::{ElementList, System, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Mean of the factors of several cells.
#[derive(Clone, Default)]
struct Mean {
    /// Weighted sum of the factors of each parameter that varies (planes).
    sum: Vec<f64>,
    /// Sum of their weights.
    total: f64,
}

impl Mean {
    /// Adds the factors of a cell with a weight.
    fn add(&mut self, factors: &[f64], weight: f64) {
        self.sum.resize(factors.len(), 0.0);
        self.sum.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += weight * factor);
        self.total += weight;
    }

    /// The mean factor of one parameter; 1 if none was added.
    fn of(&self, plane: usize) -> f64 {
        self.sum.get(plane).map_or(1.0, |sum| sum / self.total)
    }
}

/// The cell of each tetrahedron of a list, as an index among `cells` active ones: a cell has several, or those of a quadratic tetrahedron are its parts in
/// which the elements that the material sees lie.
pub(super) fn cells_of_tetrahedra(list: &ElementList, cells: usize) -> impl Iterator<Item = usize> + use<> {
    let (stride, taken, each) = match list.weights {
        Some(weights) => (PARTS, weights.parts(), 1),
        None => (1, 1, list.nodes.len() / 4 / cells.max(1)),
    };
    let of_group = move |first: usize| (first..first + taken).flat_map(move |cell| std::iter::repeat_n(cell, each));
    (0..cells).step_by(stride).flat_map(of_group)
}

impl Lattice {
    /// Gives the elements listed last their factors: those of the body's fields, times those painted, times the factor of its stiffness.
    pub(super) fn list_fields(&mut self, system: &mut System) {
        system.sets.iter_mut().for_each(|set| set.list_mut().fields.clear());
        self.evaluate_fields(system);
        StiffnessFactor::apply(self.stiffness, system);
    }

    /// Gives the elements listed last their factors, if the body has fields or is painted.
    fn evaluate_fields(&mut self, system: &mut System) {
        if self.fields.is_none() && self.painted().is_empty() {
            return;
        }
        let (fields, painted) = (self.fields.clone(), Arc::clone(&self.paint.factors));
        let at = |centre: Vec3| fields.as_ref().map_or_else(|| vec![1.0; painted.planes()], |fields| fields.at(centre));
        let centres: Vec<Vec3> = (0..self.region.cell_id.len() as u32).map(|cell| self.cell_centre(cell)).collect();
        let known = &mut self.factors_of_cell;
        let cells: Vec<Arc<[f64]>> = self
            .region
            .cell_id
            .iter()
            .zip(centres)
            .map(|(id, centre)| {
                let of_scene = Arc::clone(known.entry(*id).or_insert_with(|| at(centre).into()));
                match painted.get(*id) {
                    Some(painted) => of_scene.iter().zip(painted).map(|(a, b)| a * b).collect(),
                    None => of_scene,
                }
            })
            .collect();
        let planes = cells.first().map_or(0, |factors| factors.len());
        let mut of_node = vec![Mean::default(); self.region.node_id.len()];
        for (cell, factors) in (0..self.region.cell_id.len() as u32).zip(&cells) {
            let weight = self.cell_share(cell);
            self.distinct_corners(cell).iter().for_each(|n| of_node[*n as usize].add(factors, weight));
        }
        let links = system.sets.iter().any(|set| set.request().kind == abi::LINK);
        let of_link = if links { self.factors_of_links(&cells) } else { HashMap::new() };
        for set in &mut system.sets {
            let kind = set.request().kind;
            let list = set.list_mut();
            list.fields.clear();
            for plane in 0..planes {
                match kind {
                    abi::POINT => list.fields.extend(list.nodes.iter().map(|n| of_node[*n as usize].of(plane))),
                    abi::LINK => list.fields.extend(list.nodes.as_chunks().0.iter().map(|&[a, b]| {
                        // A flexion link spans two cells and lies in none.
                        let ends = || 0.5 * (of_node[a as usize].of(plane) + of_node[b as usize].of(plane));
                        of_link.get(&[a.min(b), a.max(b)]).map_or_else(ends, |mean| mean.of(plane))
                    })),
                    abi::TETRAHEDRON => {
                        let of_elements = cells_of_tetrahedra(list, cells.len()).map(|cell| cells[cell][plane]);
                        list.fields.extend(of_elements);
                    }
                    kind => unreachable!("a lattice lists no elements of kind {kind}"),
                }
            }
        }
    }

    /// Corners of an active cell, each once.
    pub fn distinct_corners(&self, cell: u32) -> &[u32] {
        let corners = &self.region.cell_corners[cell as usize];
        if self.source.plugin().is_some() { corners } else { &corners[..4] }
    }

    /// Weight of an active cell among those around a node, so that masses are those of their parts: cubes are equal, fragments of a cut one have their share, and
    /// tetrahedra their volume.
    fn cell_share(&self, cell: u32) -> f64 {
        match self.source.tetrahedra() {
            Some(cells) => cells.mass_volume(self.region.cell_id[cell as usize] as u32),
            None => self.fragments.share(self.cell_fragment(cell)),
        }
    }

    /// Middle of an active cell in the undeformed grid, m.
    pub(super) fn cell_centre(&self, cell: u32) -> Vec3 {
        let corners = self.region.cell_corners[cell as usize];
        match self.source.plugin() {
            Some(_) => self.grid_rest(corners[0]) + Vec3::repeat(0.5 * self.facts.edge),
            None => 0.25 * corners[..4].iter().map(|n| self.grid_rest(*n)).sum::<Vec3>(),
        }
    }

    /// For each pair of corners of a cell, the mean factors of the cells that contain both.
    fn factors_of_links(&self, cells: &[Arc<[f64]>]) -> HashMap<[u32; 2], Mean> {
        let mut of_link: HashMap<[u32; 2], Mean> = HashMap::new();
        for (cell, (corners, factors)) in (0..).zip(self.region.cell_corners.iter().zip(cells)) {
            let weight = self.cell_share(cell);
            for (i, &a) in corners.iter().enumerate() {
                for &b in &corners[i + 1..] {
                    of_link.entry([a.min(b), a.max(b)]).or_default().add(factors, weight);
                }
            }
        }
        of_link
    }
}
