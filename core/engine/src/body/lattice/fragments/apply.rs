//! Putting fragments in the place of the cut cells of a region.

use super::{CutCell, Fragments, NodeKey};
use pliant_host::Region;
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
    /// The region `whole` of the grid with nodes copied, cells parted and links listed anew where it has cut cells.
    pub fn apply(&self, whole: &Region, families: u32, region: &mut Region) {
        region.clear();
        let mut cells = self.cells.iter().peekable();
        let cut = whole.cell_id.iter().map(|id| {
            while cells.next_if(|(other, _)| *other < id).is_some() {}
            cells.next_if(|(other, _)| *other == id).map(|(_, cell)| cell)
        });
        let cut: Vec<Option<&CutCell>> = cut.collect();
        let touched = touched(whole, &cut);
        let places = copy_nodes(whole, &cut);
        // Links between nodes no cut cell stands on stay the grid's; all others follow from the fragments.
        for (l, ends) in whole.link_nodes.iter().enumerate() {
            if ends.iter().all(|n| !touched[*n as usize]) {
                region.link_nodes.push(ends.map(|n| places.own[n as usize]));
                region.link_family.push(whole.link_family[l]);
                region.link_measure.push(whole.link_measure[l]);
            }
        }
        let shares = part_cells(whole, &cut, &places, region);
        let touched: Vec<bool> = places.keys.iter().map(|(row, _)| touched[*row as usize]).collect();
        list_links(region, &touched, &shares, families);
        self.list_nodes(whole, &places, &shares, region);
    }

    fn list_nodes(&self, whole: &Region, places: &Places, shares: &[f64], region: &mut Region) {
        let volume = self.edge.powi(3) / 8.0;
        region.node_measure.resize(places.keys.len(), 0.0);
        for (corners, share) in region.cell_corners.iter().zip(shares) {
            corners.iter().for_each(|n| region.node_measure[*n as usize] += share * volume);
        }
        let rows = || places.keys.iter().map(|(row, _)| *row as usize);
        region.node_rest.extend(rows().map(|row| whole.node_rest[row]));
        region.node_border.extend(rows().map(|row| whole.node_border[row]));
        region.node_id.extend(rows().map(|row| whole.node_id[row]));
        region.node_copy.extend(places.keys.iter().map(|(_, copy)| *copy));
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
fn part_cells(whole: &Region, cut: &[Option<&CutCell>], places: &Places, region: &mut Region) -> Vec<f64> {
    let mut shares = Vec::with_capacity(whole.cell_id.len());
    for (cell, &id) in whole.cell_id.iter().enumerate() {
        let rows = whole.cell_corners[cell];
        let mut push = |nodes: [u32; 8], fragment: usize, share: f64| {
            region.cell_id.push(id);
            region.cell_corners.push(nodes);
            region.cell_points.push(whole.cell_points[cell]);
            region.cell_state.push(whole.cell_state[cell]);
            region.cell_fragment.push(fragment as u8);
            shares.push(share);
        };
        match cut[cell] {
            Some(cut) => cut.fragments.iter().enumerate().for_each(|(f, part)| {
                push(std::array::from_fn(|c| places.of(rows[c], part.nodes[c])), f, part.share);
            }),
            None => push(rows.map(|row| places.own[row as usize]), 0, 1.0),
        }
    }
    shares
}

/// Adds the links of cells around touched nodes: each cell gives its share of every link along it.
fn list_links(region: &mut Region, touched: &[bool], shares: &[f64], families: u32) {
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
    let found = in_order(found, touched.len());
    for link in found.chunk_by(|a, b| a.0 == b.0) {
        let (family, i, j) = link[0].0;
        region.link_nodes.push([i, j]);
        region.link_family.push(family);
        region.link_measure.push(link.iter().fold(0.0, |sum, (_, share)| sum + share));
    }
}

/// Sorted by the lower of `nodes` first, which is a place in a list: most of the order costs one pass. Shares of one link stay in
/// the order they were found in.
fn in_order(found: Shares, nodes: usize) -> Shares {
    let mut next = vec![0_u32; nodes + 1];
    found.iter().for_each(|((_, i, _), _)| next[*i as usize + 1] += 1);
    (0..nodes).for_each(|i| next[i + 1] += next[i]);
    let mut sorted = vec![((0, 0, 0), 0.0); found.len()];
    for share in found {
        let place = &mut next[share.0.1 as usize];
        sorted[*place as usize] = share;
        *place += 1;
    }
    sorted.chunk_by_mut(|a, b| a.0.1 == b.0.1).for_each(|links| links.sort_by_key(|(link, _)| *link));
    sorted
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
