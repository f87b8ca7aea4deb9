//! Regions against a brute-force reference: cells selected one by one, links assembled cell by cell.

use super::host::{ALL, Host, Region, WHOLE};
use super::shapes::{Mesh, cuboid, sheet, sphere};
use pliant_plugin_api::Grid;
use pliant_plugin_api::abi::{BODY_DIAGONAL, Ball, CELL_EMPTY, Cell, FLEXION, SHEAR, STRUCTURAL};
use std::collections::{BTreeMap, BTreeSet};

/// Indices of a node as z, y, x, so that they sort in the order of ids.
type Node = [u32; 3];

/// Whether a ball touches a cell.
fn touches(cell: &Cell, ball: &Ball) -> bool {
    let gap = |axis: usize| {
        let nearest = ball.centre[axis].clamp(cell.reference[axis], cell.reference[axis] + cell.edge);
        nearest - ball.centre[axis]
    };
    (0..3).map(|axis| gap(axis).powi(2)).sum::<f64>() <= ball.radius.powi(2)
}

/// Node at a corner of a cell.
fn corner([i, j, k]: [u32; 3], c: u32) -> Node {
    [k + (c >> 2 & 1), j + (c >> 1 & 1), i + (c & 1)]
}

/// The four corners of a face perpendicular to an axis, as bits.
fn face_corners(axis: u32) -> [u32; 4] {
    let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    [0, u, v, u | v]
}

/// Weights of all links of `cells`, summed over the cells that share a link.
fn link_weights(cells: &BTreeMap<u64, Cell>, by_index: &BTreeSet<[u32; 3]>) -> BTreeMap<(u32, Node, Node), f64> {
    let mut links = BTreeMap::new();
    let mut add = |family: u32, a: Node, b: Node, share: f64| {
        *links.entry((family, a.min(b), a.max(b))).or_insert(0.0) += share;
    };
    for cell in cells.values() {
        let at = |c: u32| corner(cell.index, c);
        for axis in 0..3 {
            let step = 1 << axis;
            for c in face_corners(axis) {
                add(STRUCTURAL, at(c), at(c | step), 0.25);
                let mut next = cell.index;
                next[axis as usize] += 1;
                if by_index.contains(&next) {
                    add(FLEXION, at(c), corner(next, c | step), 0.25);
                }
            }
            for side in [0, step] {
                let [a, b, c, d] = face_corners(axis).map(|c| at(c | side));
                add(SHEAR, a, d, 0.5);
                add(SHEAR, b, c, 0.5);
            }
        }
        (0..4).for_each(|c| add(BODY_DIAGONAL, at(c), at(7 - c), 1.0));
    }
    links
}

/// Compares the region of `balls` and `listed` cells with the reference, and returns it.
fn check(mesh: &Mesh, level: u32, balls: &[Ball], listed: &[u64]) -> Region {
    let region = Host::with(mesh, level).region(level, ALL, balls, listed).unwrap();
    let grid = mesh.grid(level);
    let info = grid.level(level).unwrap();
    let (m, h) = (info.cells_per_axis, info.edge);
    let occupied = (0..u64::from(m).pow(3)).map(|id| grid.cell(level, id).unwrap()).filter(|c| c.state != CELL_EMPTY);
    let (inside, outside): (BTreeMap<u64, Cell>, BTreeMap<u64, Cell>) = occupied
        .map(|cell| (cell.id, cell))
        .partition(|(id, cell)| listed.contains(id) || balls.iter().any(|ball| touches(cell, ball)));

    let mut around: BTreeMap<Node, u32> = BTreeMap::new();
    inside.values().for_each(|cell| (0..8).for_each(|c| *around.entry(corner(cell.index, c)).or_default() += 1));
    let beyond: BTreeSet<Node> = outside.values().flat_map(|cell| (0..8).map(|c| corner(cell.index, c))).collect();
    let place: BTreeMap<Node, u32> = around.keys().zip(0..).map(|(node, at)| (*node, at)).collect();
    assert_eq!(region.node_id.len(), around.len());
    for (at, (node, count)) in around.iter().enumerate() {
        let [k, j, i] = node.map(u64::from);
        let n = u64::from(m) + 1;
        assert_eq!(region.node_id[at], i + n * (j + n * k));
        assert_eq!(region.node_rest[at], [i, j, k].zip_with(info.origin, |x, o| o + h * x as f64));
        assert!((region.node_measure[at] / (f64::from(*count) * h.powi(3) / 8.0) - 1.0).abs() < 1e-14);
        assert_eq!(region.node_border[at] == 1, beyond.contains(node), "border of {node:?}");
    }

    assert_eq!(region.cell_id, inside.keys().copied().collect::<Vec<_>>());
    for (at, cell) in inside.values().enumerate() {
        assert_eq!(region.cell_corners[at], [0, 1, 2, 3, 4, 5, 6, 7].map(|c| place[&corner(cell.index, c)]));
        assert_eq!(region.cell_points[at].map(|p| p as usize), [cell.point_begin, cell.point_end]);
        assert_eq!(u32::from(region.cell_state[at]), cell.state);
    }

    let mut links = link_weights(&inside, &inside.values().map(|c| c.index).collect());
    links.retain(|(_, a, b), _| !(beyond.contains(a) && beyond.contains(b)));
    let expected = links.into_iter().map(|((family, a, b), share)| (family, place[&a], place[&b], share.to_bits()));
    let found = region.link_nodes.iter().zip(&region.link_family).zip(&region.link_measure);
    let found: BTreeSet<_> = found.map(|(([a, b], family), share)| (*family, *a, *b, share.to_bits())).collect();
    assert_eq!(found.len(), region.link_nodes.len(), "no link twice");
    assert_eq!(found, expected.collect::<BTreeSet<_>>());
    region
}

trait ZipWith {
    fn zip_with(self, other: [f64; 3], with: impl Fn(u64, f64) -> f64) -> [f64; 3];
}

impl ZipWith for [u64; 3] {
    fn zip_with(self, other: [f64; 3], with: impl Fn(u64, f64) -> f64) -> [f64; 3] {
        [0, 1, 2].map(|i| with(self[i], other[i]))
    }
}

fn ball(centre: [f64; 3], radius: f64) -> Ball {
    Ball { centre, radius }
}

#[test]
fn balls_on_dense_and_sparse_levels() {
    let mesh = sphere(1.0, 4);
    for (level, radius) in [(1, 0.1), (2, 0.3), (4, 0.4), (6, 0.3), (7, 0.2)] {
        let region = check(&mesh, level, &[ball([0.6, 0.7, 0.31], radius)], &[]);
        assert_eq!(region.node_border.contains(&1), level > 1, "level {level} has cells outside the ball");
        assert!(region.node_border.contains(&0));
    }
}

#[test]
fn two_balls_listed_cells_and_the_whole_body() {
    let mesh = sphere(1.0, 4).and(cuboid([0.3; 3]).moved([1.4, 0.0, 0.0]));
    let two = [ball([1.0, 0.0, 0.0], 0.2), ball([-0.6, -0.7, 0.3], 0.1)];
    let region = check(&mesh, 6, &two, &[]);
    let listed = [region.cell_id[3], region.cell_id[3], region.cell_id[40], region.cell_id[39]];
    assert_eq!(check(&mesh, 6, &[], &listed).cell_id.len(), 3, "a cell listed twice appears once");
    let block = cuboid([1.0; 3]);
    let middle = check(&block, 4, &[], &[3 + 8 * (4 + 8 * 3)]);
    assert_eq!(middle.node_border, [1; 8], "all its neighbours are outside the region");
    assert!(middle.link_nodes.is_empty());
    let kept = check(&mesh, 6, &two[..1], &listed);
    assert!(kept.cell_id.contains(&region.cell_id[40]));
    let whole = check(&mesh, 6, &[WHOLE], &[]);
    let info = mesh.grid(6).level(6).unwrap();
    assert_eq!(whole.cell_id.len() as u64, info.surface_cells + info.inside_cells);
    assert_eq!(whole.node_id.len() as u64, info.nodes);
    assert!(!whole.node_border.contains(&1), "no cell is outside the region of the whole body");
    let volume = whole.node_measure.iter().sum::<f64>() / (whole.cell_id.len() as f64 * info.edge.powi(3));
    assert!((volume - 1.0).abs() < 1e-12, "the nodes' volumes sum to that of the cells");
}

#[test]
fn open_and_flat_surfaces() {
    check(&sheet(12, |x, y| 0.3 * x * y), 6, &[ball([0.5, 0.5, 0.1], 0.2)], &[]);
    check(&sheet(12, |_, _| 0.0), 5, &[ball([0.0; 3], 0.3)], &[]);
}

#[test]
fn selections_outside_the_body_are_empty() {
    let mesh = sphere(1.0, 3);
    let host = Host::with(&mesh, 5);
    assert_eq!(host.region(5, ALL, &[], &[]).unwrap(), Region::default());
    assert_eq!(host.region(5, ALL, &[ball([9.0; 3], 1.0), ball([-1e300; 3], 1.0)], &[]).unwrap(), Region::default());
    let empty = mesh.grid(5).locate(5, [-1.0; 3]).unwrap().cell;
    assert_eq!(host.region(5, ALL, &[], &[empty, 16 * 16 * 16, u64::MAX]).unwrap(), Region::default());
    let there = mesh.grid(5).locate(5, [0.0, 0.0, 0.9]).unwrap().cell;
    assert_eq!(host.region(5, ALL, &[], &[there, empty, u64::MAX]).unwrap().cell_id, [there]);
    let all = host.region(5, ALL, &[ball([0.0; 3], 1e300)], &[]).unwrap();
    assert_eq!(all, host.region(5, ALL, &[WHOLE], &[]).unwrap());
}

#[test]
fn a_growing_region_keeps_its_cells_and_node_ids() {
    let host = Host::with(&sphere(1.0, 4), 7);
    let mut last = Region::default();
    for step in 1..8 {
        let radius = 0.05 * f64::from(step);
        let next = host.region(7, ALL, &[ball([0.2, 0.1, 0.97], radius)], &[]).unwrap();
        assert!(last.cell_id.len() < next.cell_id.len() && last.cell_id.iter().all(|c| next.cell_id.contains(c)));
        for (id, rest) in last.node_id.iter().zip(&last.node_rest) {
            let index = next.node_id.binary_search(id).expect("ids ascend and persist");
            assert_eq!(next.node_rest[index], *rest);
        }
        last = next;
    }
    let moved = host.region(7, ALL, &[ball([0.25, 0.1, 0.95], 0.35)], &[]).unwrap();
    let shared = last.node_id.iter().filter(|id| moved.node_id.binary_search(id).is_ok()).count();
    assert!(shared * 10 > last.node_id.len() * 7, "{shared} nodes have the same id after the hand has moved");
}
