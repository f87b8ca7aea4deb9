//! Fields of material parameters, evaluated for the elements of a sheet.

use super::Sheet;
use crate::body::StiffnessFactor;
use crate::body::skin::centroid;
use pliant_plugin_api::abi;
use pliant_solver::{System, Vec3};

impl Sheet {
    /// Gives the elements listed last their factors: those of the body's fields, times the factor of its stiffness.
    pub(super) fn list_fields(&self, system: &mut System) {
        system.sets.iter_mut().for_each(|set| set.list_mut().fields.clear());
        self.evaluate_fields(system);
        StiffnessFactor::apply(self.stiffness, system);
    }

    /// Gives the elements listed last their factors, if the body has fields: a triangle those at its centroid, a hinge the mean of its two
    /// triangles, a node or an edge those at its midpoint.
    fn evaluate_fields(&self, system: &mut System) {
        let Some(fields) = &self.fields else { return };
        let rest = system.nodes.rest.clone();
        let own = self.vertex_of.len();
        let at = |node: u32| rest[node as usize];
        let mean = |points: &[Vec3]| -> Vec<f64> {
            let all: Vec<Vec<f64>> = points.iter().map(|point| fields.at(*point)).collect();
            (0..all[0].len()).map(|plane| all.iter().map(|f| f[plane]).sum::<f64>() / all.len() as f64).collect()
        };
        for set in &mut system.sets {
            let (kind, corners) = (set.request().kind, set.nodes().len() / set.count().max(1));
            let list = set.list_mut();
            let factors: Vec<Vec<f64>> = list
                .nodes
                .chunks_exact(corners.max(1))
                .map(|nodes| match (kind, nodes) {
                    (abi::TRIANGLE, &[a, b, c]) => mean(&[centroid([a, b, c].map(at))]),
                    (abi::HINGE, &[a, b, left, right]) => {
                        // A ghost node belongs to no triangle.
                        let sides = [left, right].into_iter().filter(|n| (*n as usize) < own);
                        mean(&sides.map(|n| centroid([a, b, n].map(at))).collect::<Vec<_>>())
                    }
                    (_, nodes) => mean(&[nodes.iter().map(|n| at(*n)).sum::<Vec3>() / nodes.len() as f64]),
                })
                .collect();
            let planes = factors.first().map_or(0, Vec::len);
            list.fields = (0..planes).flat_map(|plane| factors.iter().map(move |f| f[plane])).collect();
        }
    }
}
