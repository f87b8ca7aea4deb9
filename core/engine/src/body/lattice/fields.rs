//! Factors of parameters in the elements of a lattice.
//!
//! A cell has the factors at its middle, so an interface between two cells is as sharp as they are. An element that belongs to several cells,
//! a node's share of the volume or a spring on an edge or face, has the mean of theirs: what those cells would give it one by one.

use super::Lattice;
use pliant_plugin_api::abi;
use pliant_solver::{System, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// A sum of factors, by plane, and their number.
#[derive(Clone, Default)]
struct Mean {
    sum: Vec<f64>,
    count: f64,
}

impl Mean {
    fn add(&mut self, factors: &[f64]) {
        self.sum.resize(factors.len(), 0.0);
        self.sum.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += factor);
        self.count += 1.0;
    }

    /// The mean in a plane; 1 of nothing.
    fn of(&self, plane: usize) -> f64 {
        self.sum.get(plane).map_or(1.0, |sum| sum / self.count)
    }
}

impl Lattice {
    /// Gives the elements that were listed last the factors of the fields, if there are any.
    pub(super) fn list_fields(&mut self, system: &mut System) {
        let Some(fields) = self.fields.clone() else { return };
        let half = Vec3::repeat(0.5 * self.facts.edge);
        let middles: Vec<Vec3> = self.region.cell_corners.iter().map(|c| self.grid_rest(c[0]) + half).collect();
        let known = &mut self.factors_of_cell;
        let cells: Vec<Arc<[f64]>> = self
            .region
            .cell_id
            .iter()
            .zip(middles)
            .map(|(id, middle)| Arc::clone(known.entry(*id).or_insert_with(|| fields.at(middle).into())))
            .collect();
        let planes = cells.first().map_or(0, |factors| factors.len());
        let mut of_node = vec![Mean::default(); self.region.node_id.len()];
        for (corners, factors) in self.region.cell_corners.iter().zip(&cells) {
            corners.iter().for_each(|n| of_node[*n as usize].add(factors));
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
                        // A link over two edges lies in no cell.
                        let ends = || 0.5 * (of_node[a as usize].of(plane) + of_node[b as usize].of(plane));
                        of_link.get(&[a.min(b), a.max(b)]).map_or_else(ends, |mean| mean.of(plane))
                    })),
                    _ => {
                        let elements = list.nodes.len() / 4 / cells.len().max(1);
                        list.fields.extend(cells.iter().flat_map(|cell| std::iter::repeat_n(cell[plane], elements)));
                    }
                }
            }
        }
    }

    /// Means over the cells around each pair of corners of a cell.
    fn factors_of_links(&self, cells: &[Arc<[f64]>]) -> HashMap<[u32; 2], Mean> {
        let mut of_link: HashMap<[u32; 2], Mean> = HashMap::new();
        for (corners, factors) in self.region.cell_corners.iter().zip(cells) {
            for (i, &a) in corners.iter().enumerate() {
                for &b in &corners[i + 1..] {
                    of_link.entry([a.min(b), a.max(b)]).or_default().add(factors);
                }
            }
        }
        of_link
    }
}
