//! How a level is made coarser: by squares where its nodes lie about in a plane, by aggregates elsewhere.

use super::aggregate::aggregated;
use super::graph::{Graph, Weights};
use super::squares::{Doubled, Laid, laid};
use crate::algebra::Vec3;
use crate::elements::ElementSet;
use pliant_plugin_api::abi;

/// Which nodes of a level are joined, and where they are, if squares are laid over them.
#[derive(Debug)]
pub struct Layout {
    graph: Graph,
    laid: Option<Laid>,
}

/// A coarser level.
#[derive(Debug)]
pub struct Coarsened {
    pub layout: Layout,
    /// What carries it over.
    pub weights: Weights,
    /// Which ways it is coarser.
    pub doubled: Doubled,
}

/// A level that keeps more of the nodes than this is not worth it; and one that is coarser one way only.
const KEPT: f64 = 0.7;
const KEPT_ONE_WAY: f64 = 0.8;

impl Layout {
    /// Of nodes at rest, m (n x 3), and the elements that have stiffness; hinges reach further than their triangles and are left out.
    pub fn of_elements(rest: &[Vec3], sets: &[ElementSet]) -> Self {
        let mut pairs = Vec::new();
        for set in sets.iter().filter(|set| set.has(abi::HAS_FORCES) && set.request().kind != abi::HINGE) {
            for element in set.nodes().chunks_exact(set.corners) {
                for &a in element {
                    pairs.extend(element.iter().filter(|b| **b != a).map(|&b| [a, b]));
                }
            }
        }
        Self { graph: Graph::new(rest.len(), pairs), laid: laid(rest, sets) }
    }

    #[cfg(test)]
    pub fn of_triangles(laid: Option<Laid>, n: usize, triangles: &[[u32; 3]]) -> Self {
        let pairs = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *a], [*b, *c], [*c, *b], [*c, *a], [*a, *c]]);
        Self { graph: Graph::new(n, pairs.collect()), laid }
    }

    /// Where its nodes are, if squares are laid over it.
    pub fn laid(&self) -> Option<&Laid> {
        self.laid.as_ref()
    }

    /// Nodes there are.
    pub fn len(&self) -> usize {
        self.graph.len()
    }

    /// A coarser level, and what carries it over; `None` if it is hardly coarser.
    pub fn coarsen(&self) -> Option<Coarsened> {
        let is_worth = |nodes: usize, doubled| {
            let kept = if doubled == Doubled::Both { KEPT } else { KEPT_ONE_WAY };
            nodes as f64 <= kept * self.len() as f64
        };
        let Some(laid) = &self.laid else {
            let ((graph, weights), doubled) = (aggregated(&self.graph), Doubled::Both);
            let layout = Self { graph, laid: None };
            return is_worth(layout.len(), doubled).then_some(Coarsened { layout, weights, doubled });
        };
        laid.next().iter().find_map(|&doubled| {
            let (corners, graph, weights) = laid.coarsened(doubled, &self.graph);
            let layout = Self { graph, laid: Some(corners) };
            is_worth(layout.len(), doubled).then_some(Coarsened { layout, weights, doubled })
        })
    }
}
