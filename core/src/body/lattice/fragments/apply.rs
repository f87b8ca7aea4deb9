//! Putting fragments in the place of the cut cells of a region.

use super::{CutCell, Fragments, NodeKey};
use crate::host::Region;
use pliant_plugin_api::abi;
use std::collections::HashMap;

/// Twice the coordinates of the middle of a link in its cell tell its family: corners that differ along one axis are joined
/// by an edge, along two by a face diagonal, along three by a body diagonal.
const FAMILIES: [(u32, f64); 4] = [(0, 0.0), (abi::STRUCTURAL, 0.25), (abi::SHEAR, 0.5), (abi::BODY_DIAGONAL, 1.0)];

/// Shares of links as they are found: family, ends, weight. Those of one link are summed in this order.
type Shares = Vec<((u32, u32, u32), f64)>;

/// Nodes and their copies, in order.
struct Places {
    /// Row of each in the region before, and which copy it is.
    keys: Vec<(u32, u32)>,
    /// Where the node itself now stands, by its row in the region before.
    own: Vec<u32>,
    /// Where copies stand, rising.
    copies: Vec<((u32, u32), u32)>,
}

impl Places {
    fn of(&self, row: u32, key: NodeKey) -> u32 {
        if key.1 == 0 {
            return self.own[row as usize];
        }
        let at = self.copies.partition_point(|(other, _)| *other < (row, key.1));
        self.copies[at].1
    }
}

impl Fragments {
    /// Copies nodes, parts cells and lists links anew where the region has cut cells.
    pub fn apply(&self, region: &mut Region, families: u32) {
        region.node_copy.clear();
        region.node_copy.resize(region.node_id.len(), 0);
        region.cell_fragment.clear();
        region.cell_fragment.resize(region.cell_id.len(), 0);
        let cut: Vec<Option<&CutCell>> = region.cell_id.iter().map(|id| self.cells.get(id)).collect();
        if cut.iter().all(Option::is_none) {
            return;
        }
        let touched = touched(region, &cut);
        let places = copy_nodes(region, &cut);
        // Links between nodes no cut cell stands on stay the grid's; all others follow from the fragments.
        let keep = |l: &usize| region.link_nodes[*l].iter().all(|n| !touched[*n as usize]);
        let mut links: Vec<([u32; 2], u32, f64)> = (0..region.link_family.len())
            .filter(keep)
            .map(|l| {
                let ends = region.link_nodes[l].map(|n| places.own[n as usize]);
                (ends, region.link_family[l], region.link_measure[l])
            })
            .collect();
        let shares = part_cells(region, &cut, &places);
        let touched: Vec<bool> = places.keys.iter().map(|(row, _)| touched[*row as usize]).collect();
        list_links(region, &touched, &shares, families, &mut links);
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

    fn finish_nodes(&self, region: &mut Region, places: &Places, shares: &[f64]) {
        let volume = self.edge.powi(3) / 8.0;
        let mut measure = vec![0.0; places.keys.len()];
        for (corners, share) in region.cell_corners.iter().zip(shares) {
            corners.iter().for_each(|n| measure[*n as usize] += share * volume);
        }
        let rows = || places.keys.iter().map(|(row, _)| *row as usize);
        region.node_rest = rows().map(|row| region.node_rest[row]).collect();
        region.node_border = rows().map(|row| region.node_border[row]).collect();
        region.node_id = rows().map(|row| region.node_id[row]).collect();
        region.node_copy = places.keys.iter().map(|(_, copy)| *copy).collect();
        region.node_measure = measure;
    }
}

/// Whether a cut cell stands on each node of the region.
fn touched(region: &Region, cut: &[Option<&CutCell>]) -> Vec<bool> {
    let mut touched = vec![false; region.node_id.len()];
    for (corners, _) in region.cell_corners.iter().zip(cut).filter(|(_, cut)| cut.is_some()) {
        corners.iter().for_each(|n| touched[*n as usize] = true);
    }
    touched
}

/// The place of every node and copy the region's cells stand on, in order of nodes.
fn copy_nodes(region: &Region, cut: &[Option<&CutCell>]) -> Places {
    let mut used = vec![false; region.node_id.len()];
    let mut copies: Vec<(u32, u32)> = Vec::new();
    for (corners, cut) in region.cell_corners.iter().zip(cut) {
        let Some(cut) = cut else {
            corners.iter().for_each(|n| used[*n as usize] = true);
            continue;
        };
        for (row, (_, copy)) in cut.fragments.iter().flat_map(|f| corners.iter().zip(f.nodes)) {
            if copy == 0 { used[*row as usize] = true } else { copies.push((*row, copy)) }
        }
    }
    copies.sort_unstable();
    copies.dedup();
    let mut places = Places { keys: Vec::new(), own: vec![u32::MAX; used.len()], copies: Vec::new() };
    let mut copies = copies.into_iter().peekable();
    for row in 0..used.len() as u32 {
        if used[row as usize] {
            places.own[row as usize] = places.keys.len() as u32;
            places.keys.push((row, 0));
        }
        while let Some(copy) = copies.next_if(|(of, _)| *of == row) {
            places.copies.push((copy, places.keys.len() as u32));
            places.keys.push(copy);
        }
    }
    places
}

/// Replaces each cut cell by its fragments. Gives the share of each cell.
fn part_cells(region: &mut Region, cut: &[Option<&CutCell>], places: &Places) -> Vec<f64> {
    let (mut ids, mut corners, mut points, mut states) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut fragments, mut shares) = (Vec::new(), Vec::new());
    for (cell, &id) in region.cell_id.iter().enumerate() {
        let rows = region.cell_corners[cell];
        let mut push = |nodes: [u32; 8], fragment: usize, share: f64| {
            ids.push(id);
            corners.push(nodes);
            points.push(region.cell_points[cell]);
            states.push(region.cell_state[cell]);
            fragments.push(fragment as u8);
            shares.push(share);
        };
        match cut[cell] {
            Some(cut) => cut.fragments.iter().enumerate().for_each(|(f, part)| {
                push(std::array::from_fn(|c| places.of(rows[c], part.nodes[c])), f, part.share);
            }),
            None => push(rows.map(|row| places.own[row as usize]), 0, 1.0),
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
fn list_links(region: &Region, touched: &[bool], shares: &[f64], families: u32, links: &mut Vec<([u32; 2], u32, f64)>) {
    let mut found: Shares = Vec::new();
    let near = |cell: &usize| region.cell_corners[*cell].iter().any(|n| touched[*n as usize]);
    let near: Vec<usize> = (0..region.cell_corners.len()).filter(near).collect();
    for &cell in &near {
        let corners = &region.cell_corners[cell];
        for a in 0..8_usize {
            for b in a + 1..8 {
                let (family, weight) = FAMILIES[(a ^ b).count_ones() as usize];
                let (i, j) = (corners[a].min(corners[b]), corners[a].max(corners[b]));
                if family & families != 0 && (touched[i as usize] || touched[j as usize]) {
                    found.push(((family, i, j), weight * shares[cell]));
                }
            }
        }
    }
    if families & abi::FLEXION != 0 {
        flexion(region, touched, &near, shares, &mut found);
    }
    found.sort_by_key(|(link, _)| *link);
    for link in found.chunk_by(|a, b| a.0 == b.0) {
        let (family, i, j) = link[0].0;
        links.push(([i, j], family, link.iter().fold(0.0, |sum, (_, share)| sum + share)));
    }
}

/// Links over two cells in a row: cells that share the four nodes of a face are joined through it. `near` are the cells
/// with a touched node; of two in a row one is among them.
fn flexion(region: &Region, touched: &[bool], near: &[usize], shares: &[f64], found: &mut Shares) {
    let mut beside = vec![false; touched.len()];
    near.iter().flat_map(|cell| region.cell_corners[*cell]).for_each(|n| beside[n as usize] = true);
    let asked = |cell: &usize| region.cell_corners[*cell].iter().any(|n| beside[*n as usize]);
    let cells: Vec<usize> = (0..region.cell_corners.len()).filter(asked).collect();
    let mut faces: HashMap<[u32; 4], usize> = HashMap::new();
    let face = |corners: &[u32; 8], axis: usize, far: bool| -> [u32; 4] {
        let mut nodes = (0..8).filter(|c| (c >> axis & 1 == 1) == far).map(|c| corners[c]);
        std::array::from_fn(|_| nodes.next().unwrap_or(0))
    };
    for axis in 0..3 {
        faces.clear();
        for &cell in &cells {
            faces.insert(face(&region.cell_corners[cell], axis, true), cell);
        }
        for &next in &cells {
            let corners = &region.cell_corners[next];
            let Some(&before) = faces.get(&face(corners, axis, false)) else { continue };
            let (near, far) = (face(&region.cell_corners[before], axis, false), face(corners, axis, true));
            for (a, b) in near.into_iter().zip(far) {
                if touched[a as usize] || touched[b as usize] {
                    let share = shares[before].min(shares[next]);
                    found.push(((abi::FLEXION, a.min(b), a.max(b)), 0.25 * share));
                }
            }
        }
    }
}
