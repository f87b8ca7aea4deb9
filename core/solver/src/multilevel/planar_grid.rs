//! Geometric coarsening of a nearly planar sheet: coarse nodes are the corners of squares whose width doubles from level to level, along both axes
//! or one of them.
//!
//! Weights are bilinear in a square, also at the border, beyond which there are corners too, so the prolongation is as smooth as on a coarser
//! mesh. Bending energy scales with the fourth power of a length and needs that smoothness: aggregation takes up to twice as many iterations.
//! If the nodes around a corner are connected only through other nodes, as on the two sides of a cut or in two layers, each connected component
//! gets its own corner.
//!
//! For many nodes, squares are offset by a quarter of their width on every level. The nodes of a grid are then a quarter or three quarters of a
//! width from the corners, and the prolongation over many levels converges to quadratic splines (Chaikin 1974). This takes fewer iterations with
//! more terms; coarsening one axis at a time needs fewer terms for the same weights.

use super::graph::{Graph, Weights};
use crate::algebra::Vec3;
use crate::elements::ElementSet;
use CoarsenedAxes::{Across, Along, Both};
use pliant_plugin_api::abi;

/// Coordinates of a node in the plane, in mesh widths.
type PlaneCoordinates = [f64; 2];

/// A planar grid over the nodes of a level.
#[derive(Clone, Debug)]
pub struct PlanarGrid {
    /// Coordinates of each node.
    places: Vec<PlaneCoordinates>,
    /// Offset of the first square before the first node, in widths of a square.
    begin: f64,
    /// Coarsenings to try, best first. Coordinates are integers if one axis is coarsened at a time.
    next: &'static [CoarsenedAxes],
}

/// The axes along which the width of the squares is doubled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoarsenedAxes {
    /// The axis along rows and that across them.
    Both,
    /// Only the axis along rows.
    Along,
    /// Only the axis across rows.
    Across,
}

impl CoarsenedAxes {
    /// Whether the width is doubled along rows, and across rows.
    fn flags(self) -> [bool; 2] {
        [self != Self::Across, self != Self::Along]
    }
}

/// Number of nodes from which offset squares pay: fewer iterations with more terms each.
const MIN_OFFSET_NODES: usize = 8192;
/// Length of the shorter side, in mesh widths, from which offset squares pay.
const MIN_OFFSET_LENGTH: f64 = 48.0;
/// Offset of the squares of a large grid before its first node, in widths of a square.
const OFFSET: f64 = 0.25;
/// Smallest cosine of the angle between a triangle and the plane of a planar sheet.
const MIN_COSINE: f64 = 0.5;
/// Coordinates and cosines below this count as zero, because coordinates in files are rounded.
const ROUNDING: f64 = 1e-2;
/// Weights below this count as zero.
const MIN_WEIGHT: f64 = 1e-6;
/// Largest number of nodes in a square of two by two mesh widths; a mesh that is locally much finer uses aggregation.
const MAX_PER_SQUARE: usize = 16;

/// The planar grid of a sheet at rest; `None` for other bodies, and for a sheet that is not nearly planar or whose triangles differ much in size.
pub fn planar_grid(rest: &[Vec3], sets: &[ElementSet]) -> Option<PlanarGrid> {
    let with_forces = || sets.iter().filter(|set| set.has(abi::HAS_FORCES));
    let is_sheet = with_forces().all(|set| [abi::TRIANGLE, abi::HINGE].contains(&set.request().kind));
    let triangles = with_forces().filter(|set| set.corners == 3).flat_map(|set| set.nodes().as_chunks().0);
    if is_sheet { over(rest, &triangles.copied().collect::<Vec<_>>()) } else { None }
}

fn over(rest: &[Vec3], triangles: &[[u32; 3]]) -> Option<PlanarGrid> {
    let (mut places, is_grid) =
        Plane::of(triangles.iter().map(|corners| corners.map(|node| rest[node as usize])))?.places(rest);
    let steps = |c: usize| places.windows(2).map(|pair| (pair[1][c] - pair[0][c]).abs()).sum::<f64>();
    if steps(1) > steps(0) {
        // Rows of corners are parallel to rows of nodes.
        places.iter_mut().for_each(|place| place.reverse());
    }
    for c in 0..2 {
        let least = places.iter().map(|place| place[c]).fold(f64::INFINITY, f64::min);
        places.iter_mut().for_each(|place| place[c] -= least);
    }
    let mut squares: Vec<_> = places.iter().map(|place| place.map(|at| (at / 2.0 + MIN_WEIGHT) as i64)).collect();
    squares.sort_unstable();
    let is_even = squares.chunk_by(|a, b| a == b).all(|square| square.len() <= MAX_PER_SQUARE);
    let is_long = |c: usize| places.iter().any(|place| place[c] >= MIN_OFFSET_LENGTH);
    let is_large = places.len() >= MIN_OFFSET_NODES && is_long(0) && is_long(1);
    let next: &[CoarsenedAxes] = if is_large && is_grid { &[Across, Along] } else { &[Both] };
    is_even.then_some(PlanarGrid { places, begin: if is_large { OFFSET } else { 0.0 }, next })
}

/// The mean plane of a sheet.
struct Plane {
    /// Origin: the position of a node, m.
    origin: Vec3,
    /// Unit vectors in the plane.
    axes: [Vec3; 2],
    /// Legs of the largest triangle, if it is right-angled, m.
    sides: Option<[f64; 2]>,
    /// Width of a square as large as two average triangles, m.
    width: f64,
}

impl Plane {
    fn of(triangles: impl Iterator<Item = [Vec3; 3]> + Clone) -> Option<Self> {
        let twice_area = |[a, b, c]: [Vec3; 3]| (b - a).cross(&(c - a));
        let (sum, count) = triangles.clone().fold((Vec3::zeros(), 0), |(sum, n), t| (sum + twice_area(t), n + 1));
        let normal = sum.try_normalize(0.0)?;
        if !triangles.clone().map(twice_area).all(|area| area.dot(&normal) >= MIN_COSINE * area.norm()) {
            return None;
        }
        let largest = triangles.max_by(|a, b| twice_area(*a).norm().total_cmp(&twice_area(*b).norm()))?;
        let from = |k: usize| [largest[(k + 1) % 3] - largest[k], largest[(k + 2) % 3] - largest[k]];
        let cosine = |k: &usize| from(*k)[0].normalize().dot(&from(*k)[1].normalize()).abs();
        // The corner whose angle is closest to a right angle.
        let corner = (0..3).min_by(|a, b| cosine(a).total_cmp(&cosine(b)))?;
        let across = normal.cross(&from(corner)[0]).try_normalize(0.0)?;
        let sides = (cosine(&corner) <= ROUNDING).then(|| from(corner).map(|side| side.norm()));
        let width = (sum.norm() / f64::from(count)).sqrt();
        Some(Self { origin: largest[corner], axes: [across.cross(&normal), across], sides, width })
    }

    /// Coordinates of the nodes, and whether they are integers.
    fn places(&self, rest: &[Vec3]) -> (Vec<PlaneCoordinates>, bool) {
        let measured = |widths: [f64; 2]| -> Vec<PlaneCoordinates> {
            let place = |x: Vec3| [0, 1].map(|c| (x - self.origin).dot(&self.axes[c]) / widths[c]);
            rest.iter().map(|x| place(*x)).collect()
        };
        match self.sides.and_then(|sides| whole(measured(sides))) {
            Some(places) => (places, true),
            None => (measured([self.width; 2]), false),
        }
    }
}

/// Coordinates rounded to integers; `None` if some are not close to integers.
fn whole(mut places: Vec<PlaneCoordinates>) -> Option<Vec<PlaneCoordinates>> {
    for c in 0..2 {
        let [least, most] = [f64::min, f64::max].map(|of| places.iter().map(|place| place[c]).reduce(of));
        let (least, extent) = (least?, most? - least?);
        // The mesh width comes from one triangle with rounded coordinates; stretching the extent to an integer removes the accumulated error.
        let stretch = extent.round() / extent;
        for place in &mut places {
            let at = (place[c] - least) * stretch;
            let off = (at - at.round()).abs();
            if off.is_nan() || off > ROUNDING {
                return None;
            }
            place[c] = at.round();
        }
    }
    Some(places)
}

impl PlanarGrid {
    /// Coarsenings to try, best first.
    pub fn next(&self) -> &'static [CoarsenedAxes] {
        self.next
    }

    /// Whether squares are offset, which makes the prolongation over many levels smooth.
    pub fn is_smooth(&self) -> bool {
        self.begin > 0.0
    }

    /// The grid of the corners of squares with doubled width, its graph and its prolongation.
    pub fn coarsened(&self, axes: CoarsenedAxes, graph: &Graph) -> (Self, Graph, Weights) {
        let (places, weights) = self.given(axes.flags(), graph);
        let next: &[CoarsenedAxes] = match axes {
            Across => &[Along, Across],
            Along => &[Across, Along],
            Both => self.next,
        };
        let joined = joined(places.len(), graph, &weights, axes);
        (Self { places, next, ..*self }, joined, weights)
    }

    fn given(&self, ways: [bool; 2], graph: &Graph) -> (Vec<PlaneCoordinates>, Weights) {
        let places = &self.places;
        // Key: row, column and node.
        let mut shares: Vec<(i64, i64, u32, f64)> = Vec::with_capacity(4 * places.len());
        for (node, place) in (0_u32..).zip(places) {
            let [(i, u), (j, v)] = [0, 1].map(|c| {
                let at = if ways[c] { place[c] / 2.0 + self.begin } else { place[c] };
                let first = (at + MIN_WEIGHT).floor();
                (first as i64, (at - first).max(0.0))
            });
            let four = [
                (i, j, (1.0 - u) * (1.0 - v)),
                (i + 1, j, u * (1.0 - v)),
                (i, j + 1, (1.0 - u) * v),
                (i + 1, j + 1, u * v),
            ];
            shares.extend(four.into_iter().filter(|four| four.2 > MIN_WEIGHT).map(|(i, j, share)| (j, i, node, share)));
        }
        shares.sort_unstable_by_key(|(j, i, node, _)| (*j, *i, *node));
        let (mut corners, mut terms) = (Vec::new(), Vec::with_capacity(shares.len()));
        for around in shares.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let nodes: Vec<u32> = around.iter().map(|share| share.2).collect();
            let part = components(&nodes, graph);
            let first = corners.len() as u32;
            terms.extend(around.iter().zip(&part).map(|(share, part)| (share.2, first + part, share.3 as f32)));
            let count = part.iter().max().map_or(0, |last| last + 1);
            corners.extend((0..count).map(|_| [around[0].1 as f64, around[0].0 as f64]));
        }
        terms.sort_unstable_by_key(|(node, corner, _)| u64::from(*node) << 32 | u64::from(*corner));
        let ends = |node: u32| terms.partition_point(|term| term.0 < node) as u32;
        let weights = Weights {
            start: (0..=places.len() as u32).map(ends).collect(),
            coarse: terms.iter().map(|term| term.1).collect(),
            weight: terms.iter().map(|term| term.2).collect(),
        };
        (corners, weights)
    }
}

/// The graph of the corners: two corners are adjacent if nodes of theirs are.
fn joined(corners: usize, graph: &Graph, weights: &Weights, axes: CoarsenedAxes) -> Graph {
    let mut pairs = Vec::new();
    for node in 0..graph.len() {
        // If both axes are coarsened, corners of connected squares have a node in common.
        let around = if axes == Both { &[] } else { graph.of(node) };
        for near in around.iter().map(|near| *near as usize).chain([node]) {
            for (a, _) in weights.of(node) {
                pairs.extend(weights.of(near).filter(|(b, _)| *b != a).map(|(b, _)| [a, b]));
            }
        }
    }
    Graph::new(corners, pairs)
}

/// The connected component of each of some nodes, in the graph restricted to them.
fn components(nodes: &[u32], graph: &Graph) -> Vec<u32> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::multilevel::coarsen::{Coarsened, Layout};

    /// A triangulated sheet.
    struct Sheet {
        /// Positions at rest, m.
        rest: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
    }

    /// A sheet of `n` by `m` nodes at the positions `at` returns, with triangles of alternating diagonals.
    fn sheet(n: u32, m: u32, at: impl Fn(u32, u32) -> Vec3) -> Sheet {
        let rest = (0..m).flat_map(|j| (0..n).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect();
        let mut triangles = Vec::new();
        for (i, j) in (0..m - 1).flat_map(|j| (0..n - 1).map(move |i| (i, j))) {
            let [a, b, c, d] = [n * j + i, n * j + i + 1, n * (j + 1) + i, n * (j + 1) + i + 1];
            triangles.extend(if (i + j) % 2 == 0 { [[a, b, d], [a, d, c]] } else { [[a, b, c], [b, d, c]] });
        }
        Sheet { rest, triangles }
    }

    fn layout(Sheet { rest, triangles }: &Sheet) -> Layout {
        Layout::of_triangles(over(rest, triangles), rest.len(), triangles)
    }

    /// Numbers of corners of all levels, after a check of the weights.
    fn levels(mut layout: Layout) -> Vec<usize> {
        let mut counts = Vec::new();
        while let Some(Coarsened { layout: coarse, weights, axes }) =
            Some(&layout).filter(|layout| layout.len() > 12).and_then(Layout::coarsen)
        {
            let [fine, rough] = [&layout, &coarse].map(|layout| layout.planar_grid().expect("level"));
            for (node, place) in fine.places.iter().enumerate() {
                let mut sum = [0.0; 3];
                for (a, weight) in weights.of(node) {
                    let (corner, weight) = (rough.places[a as usize], f64::from(weight));
                    let at = |c: usize| if axes.flags()[c] { 2.0 * (corner[c] - rough.begin) } else { corner[c] };
                    sum = [sum[0] + weight, sum[1] + weight * at(0), sum[2] + weight * at(1)];
                }
                let linear = (0..2).all(|c| (sum[c + 1] - place[c]).abs() < 1e-4 * (1.0 + place[c]));
                assert!((sum[0] - 1.0).abs() < 1e-5 && linear, "{node}: {sum:?} {place:?}");
                assert!(weights.of(node).count() <= if axes == Both { 4 } else { 2 });
            }
            counts.push(coarse.len());
            layout = coarse;
        }
        counts
    }

    #[test]
    fn every_second_node_of_a_grid_is_a_corner_and_weights_are_linear() {
        // Cells of 2 by 3, in an inclined plane.
        let grid = sheet(33, 21, |i, j| {
            Vec3::new(2.0 * f64::from(i), 3.0 * 0.6 * f64::from(j), 3.0 * 0.8 * f64::from(j) + 7.0)
        });
        let layout = layout(&grid);
        let weights = layout.coarsen().expect("level").weights;
        let shares = |i: usize, j: usize| weights.of(33 * j + i).map(|term| term.1).collect::<Vec<_>>();
        assert_eq!((shares(6, 4), shares(7, 4), shares(7, 5)), (vec![1.0], vec![0.5; 2], vec![0.25; 4]));
        assert_eq!(levels(layout), [17 * 11, 9 * 6, 5 * 4, 3 * 3]);
    }

    #[test]
    fn a_large_grid_is_coarsened_one_axis_at_a_time_with_offset_squares() {
        let layout = layout(&sheet(100, 90, |i, j| Vec3::new(f64::from(i), 0.0, 2.0 * f64::from(j))));
        let weights = layout.coarsen().expect("level").weights;
        let shares =
            |node: usize| weights.of(node).map(|term| term.1).fold([1.0_f32, 0.0], |[a, b], c| [a.min(c), b.max(c)]);
        assert!((0..9000).all(|node| shares(node) == [0.25, 0.75]));
        let [a, b, c, d, e] = [[51, 46], [27, 24], [15, 13], [9, 8], [6, 5]].map(|[n, m]| n * m);
        assert_eq!(levels(layout), [100 * 46, a, 51 * 24, b, 27 * 13, c, 15 * 8, d, 9 * 5, e, 6 * 4, 4 * 4, 4 * 3]);
        // A strip is finally coarsened along its length only; one of a few rows takes fewer iterations without an offset.
        let strip = |n, m| self::layout(&sheet(n, m, |i, j| Vec3::new(f64::from(i), 0.0, f64::from(j))));
        assert!(levels(strip(400, 50)).ends_with(&[9 * 3, 6 * 3, 4 * 3]));
        assert_eq!(levels(strip(3000, 3))[..2], [1501 * 2, 751 * 2]);
    }

    #[test]
    fn a_grid_with_rounded_coordinates_is_recognised() {
        let rounded = |at: u32| (0.2 / 127.0 * f64::from(at) * 1e6).round() * 1e-6;
        let Sheet { rest, triangles } = sheet(128, 128, |i, j| Vec3::new(rounded(i), rounded(j), 0.0));
        let grid = over(&rest, &triangles).expect("level");
        let mut places: Vec<[i64; 2]> = grid.places.iter().map(|place| place.map(|at| at as i64)).collect();
        assert!(grid.places.as_flattened().iter().all(|at| *at == at.round()) && grid.next == [Across, Along]);
        places.sort_unstable();
        assert!(places.iter().copied().eq((0..128).flat_map(|i| (0..128).map(move |j| [i, j]))));
    }

    #[test]
    fn scattered_nodes_have_squares_of_about_the_mesh_width() {
        let wave = |i: u32, j: u32, k: f64| 0.3 * (k * f64::from(17 * i + 29 * j)).sin();
        let at =
            |i, j| Vec3::new(f64::from(i) + wave(i, j, 1.3), f64::from(j) + wave(i, j, 1.7), 0.2 * wave(i, j, 0.1));
        let found = levels(layout(&sheet(40, 40, at)));
        assert!((400..=484).contains(&found[0]) && (121..=150).contains(&found[1]), "{found:?}");
        let found = levels(layout(&sheet(96, 96, at)));
        assert!((2304..=2601).contains(&found[0]) && (625..=729).contains(&found[1]), "{found:?}");
    }

    #[test]
    fn components_around_a_corner_have_separate_corners() {
        // Two layers, and one layer that is cut from one side to its centre.
        for n in [16, 96] {
            let all = n * n;
            let Sheet { mut rest, mut triangles } = sheet(n, n, |i, j| Vec3::new(f64::from(i), f64::from(j), 0.0));
            let whole = levels(layout(&Sheet { rest: rest.clone(), triangles: triangles.clone() }))[0];
            rest.extend(rest.clone().iter().map(|x| Vec3::new(x[0], x[1], 0.01)));
            triangles.extend(triangles.clone().iter().map(|nodes| nodes.map(|node| node + all)));
            assert_eq!(levels(layout(&Sheet { rest, triangles }))[0], 2 * whole);
            let Sheet { mut rest, mut triangles } = sheet(n, n, |i, j| Vec3::new(f64::from(i), f64::from(j), 0.0));
            let row = n / 2 - 1;
            for i in 0..n / 2 {
                let (old, new) = (n * row + i, rest.len() as u32);
                rest.push(rest[old as usize]);
                let above = |nodes: &[u32; 3]| nodes.iter().any(|node| *node < all && *node / n > row);
                let there = triangles.iter_mut().filter(|nodes| above(nodes)).flatten();
                there.filter(|node| **node == old).for_each(|node| *node = new);
            }
            let weights = layout(&Sheet { rest, triangles }).coarsen().expect("level").weights;
            let shares = |a: u32, b: u32| {
                weights.of(a as usize).any(|(at, _)| weights.of(b as usize).any(|(other, _)| at == other))
            };
            let (before, after) = (n * (row - 1), n * (row + 1));
            assert!(!shares(n * row, all) && !shares(before + 2, after + 2) && shares(before + n - 4, after + n - 4));
        }
    }

    #[test]
    fn bent_or_locally_refined_sheets_use_aggregation() {
        let bent = |angle: f64| {
            sheet(30, 30, |i, j| {
                let turn = angle * (f64::from(i) / 29.0 - 0.5);
                Vec3::new(29.0 / angle * turn.sin(), f64::from(j), 29.0 / angle * turn.cos())
            })
        };
        assert!(layout(&bent(1.5)).planar_grid().is_some() && layout(&bent(3.0)).planar_grid().is_none());
        let fine = |i: u32| f64::from(i).powi(3) / 900.0;
        assert!(layout(&sheet(30, 30, |i, j| Vec3::new(fine(i), fine(j), 0.0))).planar_grid().is_none());
        assert!(
            layout(&sheet(30, 30, |i, j| Vec3::new(f64::from(i), f64::NAN * f64::from(j), 0.0)))
                .planar_grid()
                .is_none()
        );
    }
}
