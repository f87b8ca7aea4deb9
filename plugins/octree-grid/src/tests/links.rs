//! Counts, weights and order of the links of solid blocks.

use super::host::{ALL, Host, Region, WHOLE};
use super::shapes::{cuboid, sphere};
use pliant_plugin_api::abi::{BODY_DIAGONAL, FLEXION, SHEAR, STRUCTURAL};

/// Number of structural, shear, flexion and body diagonal links of a solid block at levels 1 to 6, by combinatorics.
const LINK_COUNTS: [[usize; 4]; 6] = [
    [12, 12, 0, 4],
    [54, 72, 27, 32],
    [300, 480, 225, 256],
    [1944, 3456, 1701, 2048],
    [13872, 26112, 13005, 16384],
    [104544, 202752, 101277, 131072],
];
const FAMILIES: [u32; 4] = [STRUCTURAL, SHEAR, FLEXION, BODY_DIAGONAL];

/// Indices of a node from its id, with `m` cells per axis.
fn node_index(id: u64, m: u64) -> [u64; 3] {
    [id % (m + 1), id / (m + 1) % (m + 1), id / (m + 1) / (m + 1)]
}

/// Indices of both nodes of each link.
fn ends(region: &Region, m: u64) -> Vec<[[u64; 3]; 2]> {
    let end = |node: u32| node_index(region.node_id[node as usize], m);
    region.link_nodes.iter().map(|link| link.map(end)).collect()
}

#[test]
fn a_solid_block_has_the_expected_number_of_links() {
    let host = Host::with(&cuboid([2.0; 3]), 6);
    for (level, counts) in (1..=6).zip(LINK_COUNTS) {
        let m = 1_usize << (level - 1);
        let whole = host.region(level, ALL, &[WHOLE], &[]).unwrap();
        assert_eq!((whole.cell_id.len(), whole.node_id.len()), (m.pow(3), (m + 1).pow(3)));
        for (family, count) in FAMILIES.into_iter().zip(counts) {
            let found = whole.link_family.iter().filter(|f| **f == family).count();
            assert_eq!(found, count, "family {family} of level {level}");
            let alone = host.region(level, family, &[WHOLE], &[]).unwrap();
            assert_eq!(alone.link_nodes.len(), count, "family {family} by itself");
        }
        assert!(host.region(level, 0, &[WHOLE], &[]).unwrap().link_nodes.is_empty());
    }
}

#[test]
fn weights_are_one_half_on_faces_and_one_quarter_on_edges() {
    let m = 8;
    let host = Host::with(&cuboid([1.0; 3]), 4);
    let whole = host.region(4, ALL, &[WHOLE], &[]).unwrap();
    for (i, [a, b]) in ends(&whole, m).into_iter().enumerate() {
        let outer = |axis: usize| a[axis] == b[axis] && (a[axis] == 0 || a[axis] == m);
        let outer = (0..3).filter(|&axis| outer(axis)).count();
        assert_eq!(whole.link_measure[i], 0.5_f64.powi(outer as i32), "link {i} from {a:?} to {b:?}");
        let mut steps = [0, 1, 2].map(|axis| a[axis].abs_diff(b[axis]));
        steps.sort_unstable();
        let family = [[0, 0, 1], [0, 1, 1], [0, 0, 2], [1, 1, 1]].iter().position(|s| *s == steps);
        assert_eq!(whole.link_family[i], FAMILIES[family.unwrap()]);
    }
}

#[test]
fn links_are_ordered_by_strip_direction_and_row() {
    let m = 16;
    let host = Host::with(&sphere(1.0, 3), 5);
    let whole = host.region(5, ALL, &[WHOLE], &[]).unwrap();
    let keys =
        ends(&whole, m).into_iter().zip(&whole.link_nodes).zip(&whole.link_family).map(|((ends, nodes), family)| {
            let [a, b] = ends.map(|end| end.map(|x| x as i64));
            assert!(nodes[0] < nodes[1], "the lower node is first");
            let step = [0, 1, 2].map(|axis| b[axis] - a[axis]);
            ([a[2], (a[1] + 1) / 2], *family, step, nodes[0])
        });
    let keys: Vec<_> = keys.collect();
    // Each strip (two rows of a layer, counted from the row below the first) and direction forms one run, within which nodes ascend.
    let mut runs: Vec<_> = keys.iter().map(|(strip, family, step, _)| (*strip, *family, *step)).collect();
    runs.dedup();
    assert_eq!(runs.iter().collect::<std::collections::BTreeSet<_>>().len(), runs.len());
    assert!(runs.is_sorted_by_key(|(strip, family, _)| (*strip, *family)));
    for pair in keys.windows(2).filter(|p| (p[0].0, p[0].1, p[0].2) == (p[1].0, p[1].1, p[1].2)) {
        assert!(pair[0].3 < pair[1].3);
    }
    let neighbours = whole.link_nodes.windows(2).filter(|w| w[1][0] == w[0][0] + 1 && w[1][1] == w[0][1] + 1).count();
    assert!(
        neighbours * 10 > whole.link_nodes.len() * 7,
        "{neighbours} of {} links follow their predecessor at both nodes",
        whole.link_nodes.len()
    );
}
