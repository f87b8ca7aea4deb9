//! Factors of a material's parameters that strokes have painted, by cell of a lattice or triangle of a sheet.

use super::surface_layer::SurfaceLayer;
use crate::edit::Falloff;
use pliant_solver::Vec3;
use std::collections::HashMap;

/// A change of the painted factor of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorChange {
    /// Index of the parameter in [`super::Body::params`].
    pub plane: usize,
    /// Factor to reach, above 0.
    pub goal: f64,
    /// How far a factor moves at a weight of 1 at most: the binary logarithm of its ratio.
    pub octaves: f64,
}

/// Factors of the material's parameters by element, as strokes have left them.
#[derive(Clone, Debug, Default)]
pub struct PaintedFactors {
    /// Factors of all parameters by cell or triangle; elsewhere they are 1.
    of: HashMap<u64, Box<[f64]>>,
    /// Least and greatest factor of each parameter, 1 included; empty while nothing is painted.
    bounds: Vec<[f64; 2]>,
}

impl PaintedFactors {
    /// Whether nothing is painted.
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }

    /// Number of parameters; 0 while nothing is painted.
    pub fn planes(&self) -> usize {
        self.bounds.len()
    }

    /// Factors of all parameters of a cell or triangle; `None` where nothing is painted.
    pub fn get(&self, element: u64) -> Option<&[f64]> {
        self.of.get(&element).map(|factors| &**factors)
    }

    /// Cells or triangles that are painted with the factors of all parameters, in any order.
    pub fn elements(&self) -> impl Iterator<Item = (u64, &[f64])> {
        self.of.iter().map(|(element, factors)| (*element, &**factors))
    }

    /// The factors of the elements that have a new number, under it.
    pub fn renumbered(&self, number: impl Fn(u64) -> Option<u64>) -> Self {
        let of = self.of.iter().filter_map(|(element, factors)| Some((number(*element)?, factors.clone())));
        Self { of: of.collect(), bounds: self.bounds.clone() }
    }

    /// Gives the elements `pieces` the factors of the element they were cut from.
    pub fn inherit(&mut self, pieces: impl Iterator<Item = (u64, u64)>) {
        for (piece, of) in pieces {
            if let Some(factors) = self.of.get(&of).cloned() {
                self.of.insert(piece, factors);
            }
        }
    }

    /// Moves the factors of one of `planes` parameters, of elements with weights from 0 to 1. Returns whether any has changed.
    pub fn approach(
        &mut self,
        elements: impl Iterator<Item = (u64, f64)>,
        planes: usize,
        change: FactorChange,
    ) -> bool {
        let FactorChange { plane, goal, octaves } = change;
        let mut has_changed = false;
        for (element, weight) in elements {
            let old = self.get(element).map_or(1.0, |factors| factors[plane]);
            let (left, allowed) = (libm::log2(goal / old), weight * octaves);
            let new = if left.abs() <= allowed { goal } else { old * libm::exp2(allowed.copysign(left)) };
            if new != old {
                has_changed = true;
                self.of.entry(element).or_insert_with(|| vec![1.0; planes].into())[plane] = new;
            }
        }
        if has_changed {
            self.bounds = vec![[1.0; 2]; planes];
            for factors in self.of.values() {
                for ([low, high], factor) in self.bounds.iter_mut().zip(factors) {
                    (*low, *high) = (low.min(*factor), high.max(*factor));
                }
            }
        }
        has_changed
    }

    /// Upper bound of the ratio by which the factors raise stiffness over mass of any part, 1 or more; `keys` are those of the parameters.
    pub fn stiffening(&self, keys: &[String]) -> f64 {
        keys.iter().zip(&self.bounds).map(|(key, bounds)| stiffening(key, *bounds)).product()
    }

    /// The goal of a change, taken so far towards 1 that [`PaintedFactors::stiffening`] stays below `most`.
    pub fn allowed_goal(&self, keys: &[String], change: FactorChange, most: f64) -> f64 {
        let FactorChange { plane, goal, .. } = change;
        let others = keys.iter().zip(&self.bounds).enumerate().filter(|(other, _)| *other != plane);
        let others: f64 = others.map(|(_, (key, bounds))| stiffening(key, *bounds)).product();
        let is_allowed = |goal: f64| others * stiffening(&keys[plane], [goal.min(1.0), goal.max(1.0)]) <= most;
        let steps = (0..=GOALS).map(|step| libm::pow(goal, 1.0 - f64::from(step) / f64::from(GOALS)));
        std::iter::once(goal).chain(steps).find(|goal| is_allowed(*goal)).unwrap_or(1.0)
    }
}

/// Number of goals that are tried between the one asked for and 1.
const GOALS: u32 = 32;

/// Upper bound of the ratio by which factors of a parameter between these bounds, 1 included, raise stiffness over mass.
fn stiffening(key: &str, [low, high]: [f64; 2]) -> f64 {
    match key {
        "young" => high,
        "density" => 1.0 / low,
        // Bending goes with the cube of the thickness and mass with itself.
        "thickness" => high * high,
        // Unknown parameters of other plugins, by the most a power of one can do.
        _ => high.max(1.0 / low),
    }
}

/// A ball of the rest shape in which a stroke acts.
#[derive(Clone, Copy)]
pub(super) struct PaintBall<'a> {
    /// Centre in the present rest shape, m.
    pub centre: Vec3,
    /// Radius in the present rest shape, m.
    pub radius: f64,
    /// Nodes inside that hang together with the centre, ascending.
    pub nodes: &'a [u32],
}

impl PaintBall<'_> {
    /// The elements that have a corner in the ball and for which `place` gives a point, with the `weight` of the distance (m) of that point from the
    /// ball's centre. `elements` has the id and the corners of each, `rest` the rest positions of all nodes, m; `place` is given the id and the middle of
    /// the corners, m.
    pub fn weights<const CORNERS: usize>(
        self,
        elements: impl Iterator<Item = (u64, [u32; CORNERS])>,
        rest: &[Vec3],
        place: impl Fn(u64, Vec3) -> Option<Vec3>,
        weight: impl Fn(f64) -> f64,
    ) -> Vec<(u64, f64)> {
        let near = elements.filter(|(_, corners)| corners.iter().any(|n| self.nodes.binary_search(n).is_ok()));
        near.filter_map(|(id, corners)| {
            let centre = corners.iter().map(|n| rest[*n as usize]).sum::<Vec3>() / CORNERS as f64;
            Some((id, weight((place(id, centre)? - self.centre).norm())))
        })
        .collect()
    }
}

/// What a stroke paints in a step.
pub(super) struct PaintStroke<'a> {
    /// Where it acts.
    pub ball: PaintBall<'a>,
    /// The layer of the body that it is limited to; `None` through the depth.
    pub layer: Option<SurfaceLayer<'a>>,
    /// Weight by distance from the centre of the ball over its radius.
    pub falloff: Falloff,
    /// The change of factors at a weight of 1.
    pub change: FactorChange,
}

impl PaintStroke<'_> {
    /// Weights of the elements that it reaches; arguments and result are those of [`PaintBall::weights`].
    pub fn weights<const CORNERS: usize>(
        &self,
        elements: impl Iterator<Item = (u64, [u32; CORNERS])>,
        rest: &[Vec3],
        place: impl Fn(u64, Vec3) -> Option<Vec3>,
    ) -> Vec<(u64, f64)> {
        self.ball.weights(elements, rest, place, |distance| self.falloff.weight(distance / self.ball.radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(goal: f64, octaves: f64) -> FactorChange {
        FactorChange { plane: 0, goal, octaves }
    }

    #[test]
    fn a_factor_reaches_its_goal_exactly_and_no_faster_than_allowed() {
        let mut factors = PaintedFactors::default();
        assert!(factors.approach([(7, 0.5)].into_iter(), 2, change(4.0, 2.0)));
        assert!((factors.get(7).unwrap()[0] - 2.0).abs() < 1e-15 && factors.get(7).unwrap()[1] == 1.0);
        assert!(factors.approach([(7, 1.0)].into_iter(), 2, change(4.0, 2.0)));
        assert_eq!(factors.get(7), Some(&[4.0, 1.0][..]));
        assert!(!factors.approach([(7, 1.0)].into_iter(), 2, change(4.0, 2.0)), "nothing is left to change");
        factors.inherit([(9, 7)].into_iter());
        assert_eq!(factors.get(9), Some(&[4.0, 1.0][..]));
    }

    #[test]
    fn a_goal_stays_within_what_the_step_follows() {
        let keys = ["young".to_owned(), "density".to_owned()];
        let mut factors = PaintedFactors::default();
        factors.approach([(1, 1.0)].into_iter(), 2, FactorChange { plane: 1, goal: 0.5, octaves: 9.0 });
        assert_eq!(factors.stiffening(&keys), 2.0);
        let goal = factors.allowed_goal(&keys, change(10.0, 1.0), 8.0);
        assert!(goal <= 4.0 && goal > 3.5, "{goal}");
        assert_eq!(factors.allowed_goal(&keys, change(0.1, 1.0), 8.0), 0.1, "softer is always allowed");
        assert_eq!(factors.allowed_goal(&keys, change(10.0, 1.0), 1.0), 1.0);
    }
}
