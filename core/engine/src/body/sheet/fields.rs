//! Fields of material parameters, given by the scene or painted by strokes, evaluated for the elements of a sheet.

use super::paint::sides;
use super::{Sheet, sorted};
use crate::body::StiffnessFactor;
use crate::body::skin::centroid;
use pliant_plugin_api::abi;
use pliant_solver::{System, Vec3};

/// A part of an element: where its field is evaluated, m, and the triangles, as elements, whose painted factors it has the mean of.
type Part = (Vec3, Vec<u32>);

impl Sheet {
    /// Gives the elements listed last their factors: those of the body's fields, times those painted, times the factor of its stiffness. `triangles` has
    /// the nodes of the triangle of each element.
    pub(super) fn list_fields(&self, system: &mut System, triangles: &[[u32; 3]]) {
        system.sets.iter_mut().for_each(|set| set.list_mut().fields.clear());
        self.evaluate_fields(system, triangles);
        StiffnessFactor::apply(self.stiffness, system);
    }

    /// Gives the elements listed last their factors, if the body has fields or is painted: a triangle those at its centroid, a hinge the mean of its two
    /// triangles, a node or an edge those at its midpoint, with the painted ones of the triangles around it.
    fn evaluate_fields(&self, system: &mut System, triangles: &[[u32; 3]]) {
        let is_painted = !self.painted().is_empty();
        if self.fields.is_none() && !is_painted {
            return;
        }
        let rest = system.nodes.rest.clone();
        let own = self.vertex_of.len();
        let at = |node: u32| rest[node as usize];
        let (mut of_edge, mut of_node) = (super::paint::Sides::new(), vec![Vec::new(); own]);
        if is_painted {
            of_edge = sides(triangles);
            for (e, corners) in (0..).zip(triangles) {
                corners.iter().for_each(|n| of_node[*n as usize].push(e));
            }
        }
        let beside = |a: u32, b: u32| of_edge.get(&sorted([a, b])).cloned().unwrap_or_default();
        let beside_with = |a: u32, b: u32, third: u32| {
            beside(a, b).into_iter().filter(|e| triangles[*e as usize].contains(&third)).collect()
        };
        for set in &mut system.sets {
            let (kind, corners) = (set.request().kind, set.nodes().len() / set.count().max(1));
            let list = set.list_mut();
            let parts = |(e, nodes): (u32, &[u32])| -> Vec<Part> {
                match (kind, nodes) {
                    (abi::TRIANGLE, &[a, b, c]) => vec![(centroid([a, b, c].map(at)), vec![e])],
                    (abi::HINGE, &[a, b, left, right]) => {
                        // A ghost node belongs to no triangle.
                        let sides = [left, right].into_iter().filter(|n| (*n as usize) < own);
                        sides.map(|n| (centroid([a, b, n].map(at)), beside_with(a, b, n))).collect()
                    }
                    (_, &[a, b]) => vec![(0.5 * (at(a) + at(b)), beside(a, b))],
                    (_, nodes) => {
                        let middle = nodes.iter().map(|n| at(*n)).sum::<Vec3>() / nodes.len() as f64;
                        vec![(middle, nodes.first().map(|n| of_node[*n as usize].clone()).unwrap_or_default())]
                    }
                }
            };
            let factors: Vec<Vec<f64>> = (0..)
                .zip(list.nodes.chunks_exact(corners.max(1)))
                .map(parts)
                .map(|parts| self.mean_factors(&parts))
                .collect();
            let planes = factors.first().map_or(0, Vec::len);
            list.fields = (0..planes).flat_map(|plane| factors.iter().map(move |f| f[plane])).collect();
        }
    }

    /// Mean over the parts of an element of the field there times the painted factor, by parameter.
    fn mean_factors(&self, parts: &[Part]) -> Vec<f64> {
        let of_part = |(point, triangles): &Part| -> Vec<f64> {
            let mut factors = match &self.fields {
                Some(fields) => fields.at(*point),
                None => vec![1.0; self.painted().planes()],
            };
            if !self.painted().is_empty() && !triangles.is_empty() {
                for (plane, factor) in factors.iter_mut().enumerate() {
                    let painted = |e: &u32| self.painted_at(*e).get(plane).copied().unwrap_or(1.0);
                    *factor *= triangles.iter().map(painted).sum::<f64>() / triangles.len() as f64;
                }
            }
            factors
        };
        let all: Vec<Vec<f64>> = parts.iter().map(of_part).collect();
        let planes = all.first().map_or(0, Vec::len);
        (0..planes).map(|plane| all.iter().map(|f| f[plane]).sum::<f64>() / all.len() as f64).collect()
    }
}
