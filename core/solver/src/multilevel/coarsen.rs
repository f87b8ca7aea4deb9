//! Coarsening of a level: by a planar grid if its nodes lie nearly in a plane, otherwise by aggregation.

use super::aggregate::aggregated;
use super::graph::{Graph, Weights};
use super::planar_grid::{CoarsenedAxes, PlanarGrid, planar_grid};
use crate::algebra::Vec3;
use crate::elements::ElementSet;
use crate::elements::corner_weights::CornerWeights;
use pliant_plugin_api::abi;

/// The graph of a level, with its planar grid if there is one.
#[derive(Debug)]
pub struct Layout {
    graph: Graph,
    grid: Option<PlanarGrid>,
}

/// A coarser level.
#[derive(Debug)]
pub struct Coarsened {
    pub layout: Layout,
    /// Weights of the prolongation to the finer level.
    pub weights: Weights,
    /// Axes of the planar grid that were coarsened.
    pub axes: CoarsenedAxes,
}

/// Largest fraction of the nodes that a coarser level may keep; above it the level costs more than it saves.
const MAX_KEPT: f64 = 0.7;
/// [`MAX_KEPT`] of a level that is coarsened along one axis only.
const MAX_KEPT_ONE_AXIS: f64 = 0.8;

impl Layout {
    /// The finest level of a body with rest positions `rest`, m (n x 3). Its graph connects the nodes of elements with stiffness other than hinges,
    /// which extend beyond their triangles. Of the ten nodes of a quadratic tetrahedron those are connected that share an edge of its eight parts, so that
    /// aggregates are as large as those of linear ones.
    pub fn of_elements(rest: &[Vec3], sets: &[ElementSet]) -> Self {
        let mut pairs = Vec::new();
        for set in sets.iter().filter(|set| set.has(abi::HAS_FORCES) && set.request().kind != abi::HINGE) {
            let near: Vec<[usize; 2]> = match set.parts() {
                1 => (0..set.stencil()).flat_map(|a| (0..set.stencil()).map(move |b| [a, b])).collect(),
                _ => CornerWeights::near_pairs().collect(),
            };
            for element in set.nodes().chunks_exact(set.stencil()) {
                pairs.extend(near.iter().map(|pair| pair.map(|place| element[place])).filter(|[a, b]| a != b));
            }
        }
        Self { graph: Graph::new(rest.len(), pairs), grid: planar_grid(rest, sets) }
    }

    #[cfg(test)]
    pub fn of_triangles(grid: Option<PlanarGrid>, n: usize, triangles: &[[u32; 3]]) -> Self {
        let pairs = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *a], [*b, *c], [*c, *b], [*c, *a], [*a, *c]]);
        Self { graph: Graph::new(n, pairs.collect()), grid }
    }

    /// The planar grid, if there is one.
    pub fn planar_grid(&self) -> Option<&PlanarGrid> {
        self.grid.as_ref()
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.graph.len()
    }

    /// The next coarser level; `None` if it would keep too many nodes.
    pub fn coarsen(&self) -> Option<Coarsened> {
        let is_worth = |nodes: usize, axes| {
            let kept = if axes == CoarsenedAxes::Both { MAX_KEPT } else { MAX_KEPT_ONE_AXIS };
            nodes as f64 <= kept * self.len() as f64
        };
        let Some(grid) = &self.grid else {
            let ((graph, weights), axes) = (aggregated(&self.graph), CoarsenedAxes::Both);
            let layout = Self { graph, grid: None };
            return is_worth(layout.len(), axes).then_some(Coarsened { layout, weights, axes });
        };
        grid.next().iter().find_map(|&axes| {
            let (corners, graph, weights) = grid.coarsened(axes, &self.graph);
            let layout = Self { graph, grid: Some(corners) };
            is_worth(layout.len(), axes).then_some(Coarsened { layout, weights, axes })
        })
    }
}
