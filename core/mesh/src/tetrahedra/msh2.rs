//! Nodes and elements of the Gmsh format, version 2.

use super::msh::{kind, push};
use super::raw::{CellFacts, RawMesh};
use super::words::{Encoding, Located, Words};

/// Reads the section of the nodes: a number and three coordinates each.
///
/// # Errors
/// What is not allowed, with its byte.
pub(super) fn nodes(words: &mut Words<'_>, mesh: &mut RawMesh) -> Result<(), Located> {
    let encoding = std::mem::replace(&mut words.encoding, Encoding::Text);
    let count = words.size("the number of nodes")?;
    words.line();
    words.encoding = encoding;
    mesh.nodes.reserve(words.capacity(count) / 4);
    for _ in 0..count {
        let at = words.at();
        let number = words.count("the number of a node")?;
        let point = words.point("a coordinate of a node", false).map_err(|error| of_node(error, number))?;
        mesh.push_node(number, at + 1, point);
    }
    Ok(())
}

/// Names the node in an error.
pub(super) fn of_node((at, problem): Located, number: u64) -> Located {
    use super::error::TetMeshProblem::{Ends, Word};
    let entity = format!("a coordinate of node {number}");
    if let Word { found, allowed, .. } = problem {
        return (at, Word { entity, found, allowed });
    }
    (at, if let Ends { .. } = problem { Ends { entity } } else { problem })
}

/// Reads the section of the elements. Each has its number, type, tags (the first one is that of its physical group) and nodes; in a binary file elements of one
/// type have a common header.
///
/// # Errors
/// What is not allowed, with its byte.
pub(super) fn elements(words: &mut Words<'_>, mesh: &mut RawMesh) -> Result<(), Located> {
    let encoding = std::mem::replace(&mut words.encoding, Encoding::Text);
    let count = words.size("the number of elements")?;
    words.line();
    words.encoding = encoding;
    let (mut nodes, mut read) = (Vec::new(), 0);
    while read < count {
        let (alike, of_kind, tags);
        let mut at = words.at() + 1;
        let mut number = None;
        if encoding == Encoding::Text {
            number = Some(words.size("the number of an element")?);
            of_kind = words.int("the type of an element")?;
            (alike, tags) = (1, words.count("the number of tags of an element")?);
        } else {
            of_kind = words.int("the type of elements")?;
            alike = words.count("the number of elements of a type")?;
            tags = words.count("the number of tags of elements")?;
        }
        let kind = kind(of_kind, number.unwrap_or(read + 1), at)?;
        for _ in 0..alike.min(count - read) {
            let number = match number {
                Some(number) => number,
                None => {
                    at = words.at();
                    words.count("the number of an element")?
                }
            };
            let mut physical = 0;
            for tag in 0..tags {
                let value = words.int("a tag of an element")?;
                physical = if tag == 0 { value } else { physical };
            }
            nodes.clear();
            for _ in 0..kind.corners {
                nodes.push(words.count("a node of an element")?);
            }
            let tags = mesh.tag_set(if physical == 0 { &[] } else { std::slice::from_ref(&physical) });
            push(mesh, kind, &mut nodes, CellFacts { number, at, tags })?;
            read += 1;
        }
        if alike == 0 {
            read += 1; // an empty block would otherwise never end
        }
    }
    Ok(())
}
