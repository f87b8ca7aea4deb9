//! Coarser levels of a sheet that lies about in a plane: the corners of squares, twice as wide from level to level.
//!
//! Weights are linear along both sides of a square, also at the border, beyond which there are corners too. What is carried over
//! is then as smooth as on a coarser mesh. Bending, which goes with the fourth power of a length, asks for it: averages over
//! aggregates take up to twice as many iterations. Nodes around a corner that hang together elsewhere only, on both sides of a cut
//! or one above the other, have a corner for each part of them.

use super::V3;
use super::aggregate::{Graph, Weights};
use super::elements::ElementSet;
use nalgebra::Vector3;
use pliant_plugin_api::abi;

/// Of a node, in widths of the finest mesh.
pub type Place = [f64; 2];

/// Cosine of the angle between a triangle and the plane of the sheet, at least.
const LEVEL: f64 = 0.5;
/// Of a place, what is none beside a width.
const ROUGH: f64 = 1e-3;
/// Of a weight, what is none.
const NOTHING: f64 = 1e-6;
/// Nodes in a square of two by two widths, at most: a mesh that is much finer somewhere is left to aggregates.
const CROWD: usize = 16;

/// Where nodes at rest are in a sheet; `None` for anything else, and where it is not level or not of one fineness.
pub fn places(rest: &[V3], sets: &[ElementSet]) -> Option<Vec<Place>> {
    let with_forces = || sets.iter().filter(|set| set.has(abi::HAS_FORCES));
    if with_forces().any(|set| ![abi::TRIANGLE, abi::HINGE].contains(&set.request().kind)) {
        return None;
    }
    let of = |node: u32| Vector3::from(rest[node as usize]);
    let triangles = || with_forces().filter(|set| set.corners == 3).flat_map(|set| set.nodes().as_chunks().0);
    let twice_area = |[a, b, c]: &[u32; 3]| (of(*b) - of(*a)).cross(&(of(*c) - of(*a)));
    let (sum, count) = triangles().fold((Vector3::zeros(), 0), |(sum, count), t| (sum + twice_area(t), count + 1));
    let normal = sum.try_normalize(0.0)?;
    if !triangles().map(twice_area).all(|area| area.dot(&normal) >= LEVEL * area.norm()) {
        return None;
    }
    let axes =
        Axes::of_triangle(triangles().max_by(|a, b| twice_area(a).norm().total_cmp(&twice_area(b).norm()))?.map(of));
    let mean = (sum.norm() / f64::from(count)).sqrt();
    let across = normal.cross(&axes.along).try_normalize(0.0)?;
    let along = across.cross(&normal);
    let measured = |widths: [f64; 2]| -> Vec<Place> {
        let place = |x: &V3| Vector3::from(*x) - axes.origin;
        rest.iter().map(|x| [place(x).dot(&along) / widths[0], place(x).dot(&across) / widths[1]]).collect()
    };
    let is_grid = |places: &[Place]| places.as_flattened().iter().all(|at| (at - at.round()).abs() <= ROUGH);
    let mut places = axes.widths.map(measured).filter(|places| is_grid(places)).unwrap_or_else(|| measured([mean; 2]));
    let steps = |c: usize| places.windows(2).map(|pair| (pair[1][c] - pair[0][c]).abs()).sum::<f64>();
    if steps(1) > steps(0) {
        // Rows of corners as those of nodes.
        places.iter_mut().for_each(|place| place.reverse());
    }
    for c in 0..2 {
        let least = places.iter().map(|place| place[c]).fold(f64::INFINITY, f64::min);
        places.iter_mut().for_each(|place| place[c] -= least);
    }
    let mut squares: Vec<_> = places.iter().map(|place| place.map(|at| (at / 2.0 + NOTHING) as i64)).collect();
    squares.sort_unstable();
    squares.chunk_by(|a, b| a == b).all(|square| square.len() <= CROWD).then_some(places)
}

/// Where the corner of a triangle that is next to square is, one of its sides, and how long both are if it is square.
struct Axes {
    origin: Vector3<f64>,
    along: Vector3<f64>,
    widths: Option<[f64; 2]>,
}

impl Axes {
    fn of_triangle(corners: [Vector3<f64>; 3]) -> Self {
        let sides = |k: usize| [corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]];
        let cosine = |k: &usize| sides(*k)[0].normalize().dot(&sides(*k)[1].normalize()).abs();
        let at = (0..3).min_by(|a, b| cosine(a).total_cmp(&cosine(b))).unwrap_or(0);
        let ([along, other], is_square) = (sides(at), cosine(&at) <= ROUGH);
        Self { origin: corners[at], along, widths: is_square.then(|| [along.norm(), other.norm()]) }
    }
}

/// The corners of squares of two widths: where they are, in those, and what they give to nodes.
pub fn corners(places: &[Place], graph: &Graph) -> (Vec<Place>, Weights) {
    // By row, place in it and node.
    let mut shares: Vec<(i64, i64, u32, f64)> = Vec::with_capacity(4 * places.len());
    for (node, place) in (0_u32..).zip(places) {
        let [(i, u), (j, v)] = place.map(|at| {
            let first = (at / 2.0 + NOTHING).floor();
            (first as i64, (at / 2.0 - first).max(0.0))
        });
        let four = [
            (i, j, (1.0 - u) * (1.0 - v)),
            (i + 1, j, u * (1.0 - v)),
            (i, j + 1, (1.0 - u) * v),
            (i + 1, j + 1, u * v),
        ];
        shares.extend(four.into_iter().filter(|four| four.2 > NOTHING).map(|(i, j, share)| (j, i, node, share)));
    }
    shares.sort_unstable_by_key(|(j, i, node, _)| (*j, *i, *node));
    let (mut corners, mut terms) = (Vec::new(), Vec::with_capacity(shares.len()));
    for around in shares.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let nodes: Vec<u32> = around.iter().map(|share| share.2).collect();
        let part = parts(&nodes, graph);
        let first = corners.len() as u32;
        terms.extend(around.iter().zip(&part).map(|(share, part)| (share.2, first + part, share.3 as f32)));
        let count = part.iter().max().map_or(0, |last| last + 1);
        corners.extend((0..count).map(|_| [around[0].1 as f64, around[0].0 as f64]));
    }
    terms.sort_unstable_by_key(|(node, corner, _)| (*node, *corner));
    let ends = |node: u32| terms.partition_point(|term| term.0 < node) as u32;
    let weights = Weights {
        start: (0..=places.len() as u32).map(ends).collect(),
        coarse: terms.iter().map(|term| term.1).collect(),
        weight: terms.iter().map(|term| term.2).collect(),
    };
    (corners, weights)
}

/// Of some nodes, in their order, which part of them each hangs together with.
fn parts(nodes: &[u32], graph: &Graph) -> Vec<u32> {
    let (mut part, mut count, mut open) = (vec![u32::MAX; nodes.len()], 0, Vec::new());
    for first in 0..nodes.len() {
        if part[first] != u32::MAX {
            continue;
        }
        open.push(first);
        while let Some(at) = open.pop() {
            part[at] = count;
            let joined = graph.of(nodes[at] as usize).iter().filter_map(|node| nodes.binary_search(node).ok());
            open.extend(joined.filter(|at| part[*at] == u32::MAX));
        }
        count += 1;
    }
    part
}
