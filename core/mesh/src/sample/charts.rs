//! Texture coordinates: each part seen from two sides, each view in a tile of its own.

use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::cage::Cage;
use crate::geometry::Vec3;

/// The axis a part is seen along, from either end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum View {
    /// From the left and the right.
    Sides,
    /// From ahead and behind.
    Ends,
}

/// Texture coordinates of a cage.
pub(super) struct Charts {
    pub(super) texcoords: Vec<[f64; 2]>, // in the unit square (t x 2)
    pub(super) corners: Vec<[u32; 4]>,   // texture coordinate of each corner of each quad (q x 4)
}

const MARGIN: f64 = 0.04; // of a tile, on every side

impl Charts {
    /// Charts for the parts of `cage`, of which part p is seen as `views[p]`.
    pub(super) fn new(cage: &Cage, views: &[View]) -> Self {
        let mut charts = Self { texcoords: Vec::new(), corners: vec![[0; 4]; cage.quads.len()] };
        let mut quads = vec![Vec::new(); 2 * views.len()]; // of each chart
        for (index, quad) in cage.quads.iter().enumerate() {
            let away = toward(views[quad.part]).dot(&cage.normal(index)) < 0.0;
            quads[2 * quad.part + usize::from(away)].push(index);
        }
        let columns = (quads.len() as f64).sqrt().ceil();
        for (number, quads) in quads.iter().enumerate() {
            let tile = Vector2::new(number as f64 % columns, (number as f64 / columns).floor());
            charts.add(cage, quads, |point| seen(views[number / 2], number % 2 == 1, point), tile, columns);
        }
        charts
    }

    fn add(
        &mut self,
        cage: &Cage,
        quads: &[usize],
        seen: impl Fn(&Vec3) -> Vector2<f64>,
        tile: Vector2<f64>,
        columns: f64,
    ) {
        let mut places = BTreeMap::new();
        for &corner in quads.iter().flat_map(|&quad| &cage.quads[quad].corners) {
            places.insert(corner, seen(&cage.points[corner as usize]));
        }
        let ends = (Vector2::repeat(f64::MAX), Vector2::repeat(f64::MIN));
        let (min, max) = places.values().fold(ends, |(min, max), place| (min.inf(place), max.sup(place)));
        let scale = (1.0 - 2.0 * MARGIN) / (max - min).max();
        let mut numbers = BTreeMap::new();
        for (corner, place) in places {
            let in_tile = (place - 0.5 * (min + max)) * scale + Vector2::repeat(0.5);
            numbers.insert(corner, self.texcoords.len() as u32);
            self.texcoords.push(((tile + in_tile) / columns).into());
        }
        for &quad in quads {
            self.corners[quad] = cage.quads[quad].corners.map(|corner| numbers[&corner]);
        }
    }
}

fn toward(view: View) -> Vec3 {
    match view {
        View::Sides => Vec3::x(),
        View::Ends => Vec3::z(),
    }
}

/// Right and up of a point as an onlooker at the positive, or if `away` the negative, end of the view has it.
fn seen(view: View, away: bool, point: &Vec3) -> Vector2<f64> {
    let right = Vec3::y().cross(&toward(view)).dot(point);
    Vector2::new(if away { -right } else { right }, point.y)
}
