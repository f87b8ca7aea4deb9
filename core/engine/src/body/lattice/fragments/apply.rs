//! Replaces the cut cells of a region by their fragments: nodes are copied, cells divided, links listed again.

use super::{CutCell, Fragments, NodeKey};
use pliant_host::Region;
use pliant_plugin_api::abi;
use std::collections::HashMap;

/// Family and measure of the link between two corners of a cell, by the number of axes along which they differ: an edge (1), a face diagonal
/// (2), a body diagonal (3). The measure is the share of one of the cells around the link.
const FAMILIES: [(u32, f64); 4] = [(0, 0.0), (abi::STRUCTURAL, 0.25), (abi::SHEAR, 0.5), (abi::BODY_DIAGONAL, 1.0)];

/// A link between two nodes of the new region, lower first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Link {
    family: u32,
    nodes: [u32; 2],
}

/// What one cell adds to the measure of a link.
#[derive(Clone, Copy)]
struct LinkShare {
    link: Link,
    measure: f64,
}

/// A node of the grid's region, or a copy of it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct NodeCopy {
    /// Index of the node in the grid's region.
    row: u32,
    /// Number of the copy; 0 for the node itself.
    copy: u32,
}

/// Numbers of the nodes of the new region: each node of the grid's region that is still used, followed by its copies.
struct NodeNumbering {
    /// Each node of the new region, by its number there.
    nodes: Vec<NodeCopy>,
    /// Number of the node itself, by row of the grid's region.
    own: Vec<u32>,
    /// Copies, ascending, and their numbers.
    copies: Vec<(NodeCopy, u32)>,
}

impl NodeNumbering {
    /// Number of the node `key`, which is in `row` of the grid's region or a copy of it.
    fn of(&self, row: u32, key: NodeKey) -> u32 {
        if key.copy == 0 {
            return self.own[row as usize];
        }
        let at = self.copies.partition_point(|(other, _)| *other < NodeCopy { row, copy: key.copy });
        self.copies[at].1
    }
}

impl Fragments {
    /// Writes to `region` the region `whole` of the grid, with nodes copied, cells divided and links listed again where it has cut cells.
    pub fn apply(&self, whole: &Region, families: u32, region: &mut Region) {
        region.clear();
        let mut cells = self.cells.iter().peekable();
        let cut = whole.cell_id.iter().map(|id| {
            while cells.next_if(|(other, _)| *other < id).is_some() {}
            cells.next_if(|(other, _)| *other == id).map(|(_, cell)| cell)
        });
        let cut: Vec<Option<&CutCell>> = cut.collect();
        let touched = corners_of_cut_cells(whole, &cut);
        let numbering = copy_nodes(whole, &cut);
        // Links between nodes that belong to no cut cell are the grid's; all others follow from the fragments.
        for (l, ends) in whole.link_nodes.iter().enumerate() {
            if ends.iter().all(|n| !touched[*n as usize]) {
                region.link_nodes.push(ends.map(|n| numbering.own[n as usize]));
                region.link_family.push(whole.link_family[l]);
                region.link_measure.push(whole.link_measure[l]);
            }
        }
        let shares = divide_cells(whole, &cut, &numbering, region);
        let touched: Vec<bool> = numbering.nodes.iter().map(|node| touched[node.row as usize]).collect();
        list_links(region, &touched, &shares, families);
        self.list_nodes(whole, &numbering, &shares, region);
    }

    fn list_nodes(&self, whole: &Region, numbering: &NodeNumbering, shares: &[f64], region: &mut Region) {
        let eighth = self.edge.powi(3) / 8.0;
        region.node_measure.resize(numbering.nodes.len(), 0.0);
        for (corners, share) in region.cell_corners.iter().zip(shares) {
            corners.iter().for_each(|n| region.node_measure[*n as usize] += share * eighth);
        }
        let rows = || numbering.nodes.iter().map(|node| node.row as usize);
        region.node_rest.extend(rows().map(|row| whole.node_rest[row]));
        region.node_border.extend(rows().map(|row| whole.node_border[row]));
        region.node_id.extend(rows().map(|row| whole.node_id[row]));
        region.node_copy.extend(numbering.nodes.iter().map(|node| node.copy));
    }
}

/// Whether each node of the region is a corner of a cut cell.
fn corners_of_cut_cells(region: &Region, cut: &[Option<&CutCell>]) -> Vec<bool> {
    let mut is_corner = vec![false; region.node_id.len()];
    for (corners, _) in region.cell_corners.iter().zip(cut).filter(|(_, cut)| cut.is_some()) {
        corners.iter().for_each(|n| is_corner[*n as usize] = true);
    }
    is_corner
}

/// Numbers every node and copy that is a corner of a cell or fragment.
fn copy_nodes(region: &Region, cut: &[Option<&CutCell>]) -> NodeNumbering {
    let mut used = vec![false; region.node_id.len()];
    let mut copies: Vec<NodeCopy> = Vec::new();
    for (corners, cut) in region.cell_corners.iter().zip(cut) {
        let Some(cut) = cut else {
            corners.iter().for_each(|n| used[*n as usize] = true);
            continue;
        };
        for (&row, NodeKey { copy, .. }) in cut.fragments.iter().flat_map(|f| corners.iter().zip(f.nodes)) {
            if copy == 0 { used[row as usize] = true } else { copies.push(NodeCopy { row, copy }) }
        }
    }
    copies.sort_unstable();
    copies.dedup();
    let mut numbering = NodeNumbering { nodes: Vec::new(), own: vec![u32::MAX; used.len()], copies: Vec::new() };
    let mut copies = copies.into_iter().peekable();
    for row in 0..used.len() as u32 {
        if used[row as usize] {
            numbering.own[row as usize] = numbering.nodes.len() as u32;
            numbering.nodes.push(NodeCopy { row, copy: 0 });
        }
        while let Some(copy) = copies.next_if(|copy| copy.row == row) {
            numbering.copies.push((copy, numbering.nodes.len() as u32));
            numbering.nodes.push(copy);
        }
    }
    numbering
}

/// Replaces each cut cell by its fragments. Returns the share of its cell's volume that each new cell has.
fn divide_cells(whole: &Region, cut: &[Option<&CutCell>], numbering: &NodeNumbering, region: &mut Region) -> Vec<f64> {
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
            Some(cut) => cut.fragments.iter().enumerate().for_each(|(f, fragment)| {
                push(std::array::from_fn(|c| numbering.of(rows[c], fragment.nodes[c])), f, fragment.share);
            }),
            None => push(rows.map(|row| numbering.own[row as usize]), 0, 1.0),
        }
    }
    shares
}

/// Lists the links with an end at a touched node: each cell or fragment adds its share to the measure of its links.
fn list_links(region: &mut Region, touched: &[bool], shares: &[f64], families: u32) {
    let mut found: Vec<LinkShare> = Vec::new();
    let near = |cell: &usize| region.cell_corners[*cell].iter().any(|n| touched[*n as usize]);
    let near: Vec<usize> = (0..region.cell_corners.len()).filter(near).collect();
    for &cell in &near {
        let corners = &region.cell_corners[cell];
        for a in 0..8_usize {
            for b in a + 1..8 {
                let (family, weight) = FAMILIES[(a ^ b).count_ones() as usize];
                let nodes = [corners[a].min(corners[b]), corners[a].max(corners[b])];
                if family & families != 0 && nodes.iter().any(|n| touched[*n as usize]) {
                    found.push(LinkShare { link: Link { family, nodes }, measure: weight * shares[cell] });
                }
            }
        }
    }
    if families & abi::FLEXION != 0 {
        list_flexion_links(region, touched, &near, shares, &mut found);
    }
    let found = sorted_by_link(found, touched.len());
    for shares in found.chunk_by(|a, b| a.link == b.link) {
        region.link_nodes.push(shares[0].link.nodes);
        region.link_family.push(shares[0].link.family);
        region.link_measure.push(shares.iter().fold(0.0, |sum, share| sum + share.measure));
    }
}

/// Sorts shares by their lower node (of `nodes`), then by link: a counting sort, then a stable sort of each node's shares, so that the
/// shares of one link are summed in the order in which they were found.
fn sorted_by_link(found: Vec<LinkShare>, nodes: usize) -> Vec<LinkShare> {
    let mut next = vec![0_u32; nodes + 1];
    found.iter().for_each(|share| next[share.link.nodes[0] as usize + 1] += 1);
    (0..nodes).for_each(|i| next[i + 1] += next[i]);
    let mut sorted = vec![LinkShare { link: Link { family: 0, nodes: [0; 2] }, measure: 0.0 }; found.len()];
    for share in found {
        let index = &mut next[share.link.nodes[0] as usize];
        sorted[*index as usize] = share;
        *index += 1;
    }
    let same_node = |a: &LinkShare, b: &LinkShare| a.link.nodes[0] == b.link.nodes[0];
    sorted.chunk_by_mut(same_node).for_each(|shares| shares.sort_by_key(|share| share.link));
    sorted
}

/// Lists flexion links, which span two cells in a row: cells that share the four nodes of a face. `near` are the cells with a touched node,
/// of which every such pair has at least one.
fn list_flexion_links(region: &Region, touched: &[bool], near: &[usize], shares: &[f64], found: &mut Vec<LinkShare>) {
    let mut is_near = vec![false; touched.len()];
    near.iter().flat_map(|cell| region.cell_corners[*cell]).for_each(|n| is_near[n as usize] = true);
    let has_near_node = |cell: &usize| region.cell_corners[*cell].iter().any(|n| is_near[*n as usize]);
    let cells: Vec<usize> = (0..region.cell_corners.len()).filter(has_near_node).collect();
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
        for &second in &cells {
            let corners = &region.cell_corners[second];
            let Some(&first) = faces.get(&face(corners, axis, false)) else { continue };
            let (near, far) = (face(&region.cell_corners[first], axis, false), face(corners, axis, true));
            for (a, b) in near.into_iter().zip(far) {
                if touched[a as usize] || touched[b as usize] {
                    let link = Link { family: abi::FLEXION, nodes: [a.min(b), a.max(b)] };
                    found.push(LinkShare { link, measure: 0.25 * shares[first].min(shares[second]) });
                }
            }
        }
    }
}
