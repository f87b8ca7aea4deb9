//! Physical groups: named parts of a mesh.

use super::index::NodeIndex;
use super::raw::{NO_TAGS, RawCell, RawMesh};
use std::collections::BTreeMap;

/// A named part of a mesh. A group without a name in the file has its number for one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Name in the file.
    pub name: String,
    /// Dimension: 0 for points, 1 for lines, 2 for faces, 3 for tetrahedra.
    pub dimension: u32,
    /// Its nodes, ascending.
    pub nodes: Vec<u32>,
    /// For a group of faces: their corners, each ascending, the list as well (t x 3).
    pub faces: Vec<[u32; 3]>,
    /// For a group of tetrahedra: their indices, ascending.
    pub tetrahedra: Vec<u32>,
}

impl Group {
    /// What the group is made of, for messages.
    pub fn kind(&self) -> &'static str {
        ["points", "lines", "faces", "tetrahedra"][self.dimension.min(3) as usize]
    }
}

/// Groups while they are collected, by dimension and tag.
type Collected = BTreeMap<(u32, i32), Group>;

/// The groups of a mesh. Nodes of points, lines and faces that no tetrahedron has are left out; groups without a node are kept, for their names.
pub(super) fn collect(raw: &RawMesh, index: &NodeIndex) -> Vec<Group> {
    let mut groups = Collected::new();
    for (dimension, tag) in raw.names.keys() {
        group_of(&mut groups, raw, *dimension, *tag);
    }
    of_cells(&mut groups, raw, index, 0, &raw.points, |_, _, _| {});
    of_cells(&mut groups, raw, index, 1, &raw.lines, |_, _, _| {});
    of_cells(&mut groups, raw, index, 2, &raw.triangles, |group, _, mut nodes| {
        nodes.sort_unstable();
        group.faces.push(nodes);
    });
    of_cells(&mut groups, raw, index, 3, &raw.tetrahedra, |group, cell, _| group.tetrahedra.push(cell));
    for group in groups.values_mut() {
        group.nodes.sort_unstable();
        group.nodes.dedup();
        group.faces.sort_unstable();
        group.faces.dedup();
    }
    groups.into_values().collect()
}

/// Adds cells of one dimension to their groups.
fn of_cells<const CORNERS: usize>(
    groups: &mut Collected,
    raw: &RawMesh,
    index: &NodeIndex,
    dimension: u32,
    cells: &[RawCell<CORNERS>],
    add: impl Fn(&mut Group, u32, [u32; CORNERS]),
) {
    for (number, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.tags != NO_TAGS) {
        let nodes = cell.nodes.map(|node| index.used(node));
        for &tag in &raw.tag_sets[cell.tags as usize] {
            let group = group_of(groups, raw, dimension, tag);
            group.nodes.extend(nodes.iter().flatten());
            if nodes.iter().all(Option::is_some) {
                add(group, number as u32, nodes.map(Option::unwrap_or_default));
            }
        }
    }
}

/// The group with a dimension and a tag.
fn group_of<'a>(groups: &'a mut Collected, raw: &RawMesh, dimension: u32, tag: i32) -> &'a mut Group {
    groups.entry((dimension, tag)).or_insert_with(|| Group {
        name: raw.names.get(&(dimension, tag)).cloned().unwrap_or_else(|| tag.to_string()),
        dimension,
        nodes: Vec::new(),
        faces: Vec::new(),
        tetrahedra: Vec::new(),
    })
}
