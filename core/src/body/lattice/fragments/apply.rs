//! Putting fragments in the place of the cut cells of a region.

use super::{Fragments, NodeKey};
use crate::host::Region;
use pliant_plugin_api::abi;
use std::collections::{BTreeMap, BTreeSet};

/// Twice the coordinates of the middle of a link in its cell tell its family: corners that differ along one axis are joined
/// by an edge, along two by a face diagonal, along three by a body diagonal.
const FAMILIES: [(u32, f64); 4] = [(0, 0.0), (abi::STRUCTURAL, 0.25), (abi::SHEAR, 0.5), (abi::BODY_DIAGONAL, 1.0)];

impl Fragments {
    /// Copies nodes, parts cells and lists links anew where the region has cut cells.
    pub fn apply(&self, region: &mut Region, families: u32) {
        region.node_copy.clear();
        region.node_copy.resize(region.node_id.len(), 0);
        region.cell_fragment.clear();
        region.cell_fragment.resize(region.cell_id.len(), 0);
        if !region.cell_id.iter().any(|id| self.cells.contains_key(id)) {
            return;
        }
        let touched = self.touched(region);
        let places = self.copy_nodes(region, &touched);
        // Links between nodes no cut cell stands on stay the grid's; all others follow from the fragments.
        let keep = |l: &usize| region.link_nodes[*l].iter().all(|n| !touched[*n as usize]);
        let mut links: Vec<([u32; 2], u32, f64)> = (0..region.link_family.len())
            .filter(keep)
            .map(|l| {
                let ends = region.link_nodes[l].map(|n| places[&(region.node_id[n as usize], 0)]);
                (ends, region.link_family[l], region.link_measure[l])
            })
            .collect();
        let shares = self.part_cells(region, &places);
        self.list_links(region, &touched_places(region, &touched, &places), &shares, families, &mut links);
        self.finish_nodes(region, &places, &shares);
        region.link_nodes.clear();
        region.link_family.clear();
        region.link_measure.clear();
        for (ends, family, measure) in links {
            region.link_nodes.push(ends);
            region.link_family.push(family);
            region.link_measure.push(measure);
        }
    }

    /// Whether a cut cell stands on each node of the region.
    fn touched(&self, region: &Region) -> Vec<bool> {
        let mut touched = vec![false; region.node_id.len()];
        for (cell, id) in region.cell_id.iter().enumerate() {
            if self.cells.contains_key(id) {
                region.cell_corners[cell].iter().for_each(|n| touched[*n as usize] = true);
            }
        }
        touched
    }

    /// The place of every node and copy the region's cells stand on, in order of nodes.
    fn copy_nodes(&self, region: &Region, touched: &[bool]) -> BTreeMap<NodeKey, u32> {
        let mut keys: BTreeSet<NodeKey> = BTreeSet::new();
        for (cell, id) in region.cell_id.iter().enumerate() {
            match self.cells.get(id) {
                Some(cut) => cut.fragments.iter().for_each(|f| keys.extend(f.nodes)),
                None => keys.extend(region.cell_corners[cell].map(|n| (region.node_id[n as usize], 0))),
            }
        }
        debug_assert_eq!(touched.len(), region.node_id.len());
        keys.into_iter().enumerate().map(|(place, key)| (key, place as u32)).collect()
    }

    /// Replaces each cut cell by its fragments. Gives the share of each cell.
    fn part_cells(&self, region: &mut Region, places: &BTreeMap<NodeKey, u32>) -> Vec<f64> {
        let (mut ids, mut corners, mut points, mut states) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut fragments, mut shares) = (Vec::new(), Vec::new());
        for (cell, &id) in region.cell_id.iter().enumerate() {
            let mut push = |nodes: [NodeKey; 8], fragment: usize, share: f64| {
                ids.push(id);
                corners.push(nodes.map(|key| places[&key]));
                points.push(region.cell_points[cell]);
                states.push(region.cell_state[cell]);
                fragments.push(fragment as u8);
                shares.push(share);
            };
            match self.cells.get(&id) {
                Some(cut) => cut.fragments.iter().enumerate().for_each(|(f, part)| push(part.nodes, f, part.share)),
                None => push(region.cell_corners[cell].map(|n| (region.node_id[n as usize], 0)), 0, 1.0),
            }
        }
        region.cell_id = ids;
        region.cell_corners = corners;
        region.cell_points = points;
        region.cell_state = states;
        region.cell_fragment = fragments;
        shares
    }

    /// Adds the links of cells around touched nodes: each cell gives its share of every link along it.
    fn list_links(
        &self,
        region: &Region,
        touched: &[bool],
        shares: &[f64],
        families: u32,
        links: &mut Vec<([u32; 2], u32, f64)>,
    ) {
        let mut sums: BTreeMap<(u32, u32, u32), f64> = BTreeMap::new();
        for (cell, corners) in region.cell_corners.iter().enumerate() {
            if !corners.iter().any(|n| touched[*n as usize]) {
                continue;
            }
            for a in 0..8_usize {
                for b in a + 1..8 {
                    let (family, weight) = FAMILIES[(a ^ b).count_ones() as usize];
                    let (i, j) = (corners[a].min(corners[b]), corners[a].max(corners[b]));
                    if family & families != 0 && (touched[i as usize] || touched[j as usize]) {
                        *sums.entry((family, i, j)).or_default() += weight * shares[cell];
                    }
                }
            }
        }
        if families & abi::FLEXION != 0 {
            flexion(region, touched, shares, &mut sums);
        }
        links.extend(sums.into_iter().map(|((family, i, j), weight)| ([i, j], family, weight)));
    }

    fn finish_nodes(&self, region: &mut Region, places: &BTreeMap<NodeKey, u32>, shares: &[f64]) {
        let old = |id: u64| region.node_id.binary_search(&id).unwrap_or(0);
        let (mut ids, mut copies) = (Vec::with_capacity(places.len()), Vec::with_capacity(places.len()));
        let (mut rest, mut border) = (Vec::with_capacity(places.len()), Vec::with_capacity(places.len()));
        for &(id, copy) in places.keys() {
            ids.push(id);
            copies.push(copy);
            rest.push(region.node_rest[old(id)]);
            border.push(region.node_border[old(id)]);
        }
        let volume = self.edge.powi(3) / 8.0;
        let mut measure = vec![0.0; ids.len()];
        for (corners, share) in region.cell_corners.iter().zip(shares) {
            corners.iter().for_each(|n| measure[*n as usize] += share * volume);
        }
        region.node_id = ids;
        region.node_copy = copies;
        region.node_rest = rest;
        region.node_border = border;
        region.node_measure = measure;
    }
}

/// Which of the new places stand for touched nodes.
fn touched_places(region: &Region, touched: &[bool], places: &BTreeMap<NodeKey, u32>) -> Vec<bool> {
    let of = |key: &NodeKey| region.node_id.binary_search(&key.0).is_ok_and(|n| touched[n]);
    places.keys().map(of).collect()
}

/// Links over two cells in a row: cells that share the four nodes of a face are joined through it.
fn flexion(region: &Region, touched: &[bool], shares: &[f64], sums: &mut BTreeMap<(u32, u32, u32), f64>) {
    let mut faces: BTreeMap<[u32; 4], usize> = BTreeMap::new();
    let face = |corners: &[u32; 8], axis: usize, far: bool| -> [u32; 4] {
        let mut nodes = (0..8).filter(|c| (c >> axis & 1 == 1) == far).map(|c| corners[c]);
        std::array::from_fn(|_| nodes.next().unwrap_or(0))
    };
    for axis in 0..3 {
        faces.clear();
        for (cell, corners) in region.cell_corners.iter().enumerate() {
            faces.insert(face(corners, axis, true), cell);
        }
        for (next, corners) in region.cell_corners.iter().enumerate() {
            let Some(&before) = faces.get(&face(corners, axis, false)) else { continue };
            let (near, far) = (face(&region.cell_corners[before], axis, false), face(corners, axis, true));
            for (a, b) in near.into_iter().zip(far) {
                if touched[a as usize] || touched[b as usize] {
                    let share = shares[before].min(shares[next]);
                    *sums.entry((abi::FLEXION, a.min(b), a.max(b))).or_default() += 0.25 * share;
                }
            }
        }
    }
}
