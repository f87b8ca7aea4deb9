//! Factors of parameters in the elements of a sheet.

use super::Sheet;
use crate::body::fields::middle;
use pliant_plugin_api::abi;
use pliant_solver::{System, Vec3};

impl Sheet {
    /// Gives the elements that were listed last the factors of the fields, if there are any: those at the middle of a triangle, the mean of
    /// both triangles of a hinge, and those at a node or the middle of an edge.
    pub(super) fn list_fields(&self, system: &mut System) {
        let Some(fields) = &self.fields else { return };
        let rest = system.nodes.rest.clone();
        let own = self.vertex_of.len();
        let at = |node: u32| rest[node as usize];
        let mean = |places: &[Vec3]| -> Vec<f64> {
            let all: Vec<Vec<f64>> = places.iter().map(|place| fields.at(*place)).collect();
            (0..all[0].len()).map(|plane| all.iter().map(|f| f[plane]).sum::<f64>() / all.len() as f64).collect()
        };
        for set in &mut system.sets {
            let (kind, corners) = (set.request().kind, set.nodes().len() / set.count().max(1));
            let list = set.list_mut();
            let factors: Vec<Vec<f64>> = list
                .nodes
                .chunks_exact(corners.max(1))
                .map(|nodes| match (kind, nodes) {
                    (abi::TRIANGLE, &[a, b, c]) => mean(&[middle([a, b, c].map(at))]),
                    (abi::HINGE, &[a, b, left, right]) => {
                        // Beyond a clamped edge there is no triangle.
                        let sides = [left, right].into_iter().filter(|n| (*n as usize) < own);
                        mean(&sides.map(|n| middle([a, b, n].map(at))).collect::<Vec<_>>())
                    }
                    (_, nodes) => mean(&[nodes.iter().map(|n| at(*n)).sum::<Vec3>() / nodes.len() as f64]),
                })
                .collect();
            let planes = factors.first().map_or(0, Vec::len);
            list.fields = (0..planes).flat_map(|plane| factors.iter().map(move |f| f[plane])).collect();
        }
    }
}
