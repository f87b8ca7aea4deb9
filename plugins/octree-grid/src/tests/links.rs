//! Links of solid blocks against R21 and the weights of `lattice()` in the project's reference values.

use super::host::{ALL, Host, Region, WHOLE};
use super::shapes::{cuboid, sphere};
use pliant_plugin_api::abi::{BODY_DIAGONAL, FLEXION, SHEAR, STRUCTURAL};

/// R21: structural, shear, flexion and body diagonal links of levels 1 to 6.
const R21: [[usize; 4]; 6] = [
    [12, 12, 0, 4],
    [54, 72, 27, 32],
    [300, 480, 225, 256],
    [1944, 3456, 1701, 2048],
    [13872, 26112, 13005, 16384],
    [104544, 202752, 101277, 131072],
];
const FAMILIES: [u32; 4] = [STRUCTURAL, SHEAR, FLEXION, BODY_DIAGONAL];

fn lattice_index(id: u64, m: u64) -> [u64; 3] {
    [id % (m + 1), id / (m + 1) % (m + 1), id / (m + 1) / (m + 1)]
}

/// The two ends of each link as lattice indices.
fn ends(region: &Region, m: u64) -> Vec<[[u64; 3]; 2]> {
    let end = |place: u32| lattice_index(region.node_id[place as usize], m);
    region.link_nodes.iter().map(|link| link.map(end)).collect()
}

#[test]
fn a_solid_block_has_the_counts_of_r21() {
    let host = Host::with(&cuboid([2.0; 3]), 6);
    for (level, counts) in (1..=6).zip(R21) {
        let m = 1_usize << (level - 1);
        let whole = host.region(level, ALL, &[WHOLE], &[]).unwrap();
        assert_eq!((whole.cell_id.len(), whole.node_id.len()), (m.pow(3), (m + 1).pow(3)));
        for (family, count) in FAMILIES.into_iter().zip(counts) {
            let found = whole.link_family.iter().filter(|f| **f == family).count();
            assert_eq!(found, count, "family {family} of level {level}");
            let alone = host.region(level, family, &[WHOLE], &[]).unwrap();
            assert_eq!(alone.link_nodes.len(), count, "asked for family {family} alone");
        }
        assert!(host.region(level, 0, &[WHOLE], &[]).unwrap().link_nodes.is_empty());
    }
}

#[test]
fn weights_are_halved_on_faces_and_quartered_on_edges() {
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
fn links_come_strip_by_strip_and_row_by_row() {
    let m = 16;
    let host = Host::with(&sphere(1.0, 3), 5);
    let whole = host.region(5, ALL, &[WHOLE], &[]).unwrap();
    let keys =
        ends(&whole, m).into_iter().zip(&whole.link_nodes).zip(&whole.link_family).map(|((ends, places), family)| {
            let [a, b] = ends.map(|end| end.map(|x| x as i64));
            assert!(places[0] < places[1], "the first place is lower");
            let step = [0, 1, 2].map(|axis| b[axis] - a[axis]);
            ([a[2], (a[1] + 1) / 2], *family, step, places[0])
        });
    let keys: Vec<_> = keys.collect();
    // Runs of one strip, two rows of a layer from the one before the first on, and direction never come back, and places rise inside
    // of a run.
    let mut runs: Vec<_> = keys.iter().map(|(strip, family, step, _)| (*strip, *family, *step)).collect();
    runs.dedup();
    assert_eq!(runs.iter().collect::<std::collections::BTreeSet<_>>().len(), runs.len());
    assert!(runs.is_sorted_by_key(|(strip, family, _)| (*strip, *family)));
    for pair in keys.windows(2).filter(|p| (p[0].0, p[0].1, p[0].2) == (p[1].0, p[1].1, p[1].2)) {
        assert!(pair[0].3 < pair[1].3);
    }
    let neighbours = whole.link_nodes.windows(2).filter(|w| w[1][0] == w[0][0] + 1 && w[1][1] == w[0][1] + 1).count();
    assert!(neighbours * 10 > whole.link_nodes.len() * 7, "{neighbours} of {} are neighbours", whole.link_nodes.len());
}
