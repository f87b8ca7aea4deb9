//! Values that a file gives at its nodes or elements, such as a modulus of elasticity from a scan.

use super::TetMesh;
use super::index::NodeIndex;
use super::raw::RawMesh;
use std::collections::HashMap;
use std::fmt;

/// Where an array has its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataPlace {
    /// One number for each node of the mesh.
    Nodes,
    /// One number for each tetrahedron of the mesh.
    Elements,
}

impl fmt::Display for DataPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nodes => "nodes",
            Self::Elements => "elements",
        })
    }
}

/// An array of numbers, one at each node or element.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshData {
    /// Name in the file.
    pub name: String,
    /// Where the values are.
    pub place: DataPlace,
    /// Line of the file at which the array begins, from 1.
    pub line: u32,
    /// Value of each node of [`TetMesh::points`], or of each element; NaN where the file gives none (n or m).
    pub values: Vec<f64>,
}

/// An array as the file has it.
#[derive(Clone, Debug)]
pub(super) struct RawData {
    pub name: String,
    pub place: DataPlace,
    /// Byte at which it begins, and the line of that once [`RawData::find_lines`] has found it.
    pub at: usize,
    pub line: u32,
    /// Numbers of nodes or cells in the file, each with its value.
    pub values: Vec<(u64, f64)>,
}

/// A section of a file whose arrays have one row for each node, or for each cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct DataSection {
    /// Where its values are.
    pub place: DataPlace,
    /// Number of rows of each array: the number of nodes or of cells of the file.
    pub rows: usize,
}

impl TetMesh {
    /// Names of all arrays of values with their places, for messages.
    pub fn list_data(&self) -> String {
        let all: Vec<String> = self.data.iter().map(|data| format!("`{}` (at {})", data.name, data.place)).collect();
        if all.is_empty() { "none: the file has no numbers at nodes or elements".into() } else { all.join(", ") }
    }
}

impl RawData {
    /// Finds the lines of arrays in the file that they are of, in the order in which they are there.
    pub(super) fn find_lines(all: &mut [Self], bytes: &[u8]) {
        let (mut line, mut counted) = (1, 0);
        for data in all {
            let at = data.at.clamp(counted, bytes.len());
            line += bytes[counted..at].iter().filter(|byte| **byte == b'\n').count() as u32;
            (data.line, counted) = (line, at);
        }
    }
}

/// Arrays by the nodes and elements of a mesh. Values at cells that are no tetrahedra are left out.
pub(super) fn collect(raw: &RawMesh, index: &NodeIndex, nodes: usize, elements: &[u64]) -> Vec<MeshData> {
    let has_cells = raw.data.iter().any(|data| data.place == DataPlace::Elements);
    let place_of: HashMap<u64, usize> = if has_cells {
        elements.iter().enumerate().map(|(element, number)| (*number, element)).collect()
    } else {
        HashMap::new()
    };
    let collected = raw.data.iter().map(|data| {
        let (count, place): (_, &dyn Fn(u64) -> Option<usize>) = match data.place {
            DataPlace::Nodes => (nodes, &|number| index.used(number).map(|node| node as usize)),
            DataPlace::Elements => (elements.len(), &|number| place_of.get(&number).copied()),
        };
        let mut values = vec![f64::NAN; count];
        for (number, value) in &data.values {
            if let Some(at) = place(*number) {
                values[at] = *value;
            }
        }
        MeshData { name: data.name.clone(), place: data.place, line: data.line, values }
    });
    collected.collect()
}
