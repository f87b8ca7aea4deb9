//! Entities, nodes and elements of the Gmsh format, version 4.1.

use super::error::TetMeshProblem;
use super::msh::{kind, push};
use super::msh2::of_node;
use super::raw::{CellFacts, RawMesh};
use super::words::{Located, Words};
use std::collections::HashMap;

/// Physical tags of the geometric entities that elements belong to, by dimension and tag.
#[derive(Debug, Default)]
pub(super) struct Entities(HashMap<(i32, i32), Vec<i32>>);

/// Reads the section of the entities.
///
/// # Errors
/// What is not allowed, with its byte.
pub(super) fn entities(words: &mut Words<'_>) -> Result<Entities, Located> {
    let mut entities = Entities::default();
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = words.size("the number of entities")?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = words.int("the tag of an entity")?;
            // A point has its position, the others the corners of their boxes.
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                words.real("a coordinate of an entity", false)?;
            }
            let physical = words.size("the number of physical tags of an entity")?;
            let mut tags = Vec::new();
            for _ in 0..physical {
                // A negative tag turns the entity around.
                tags.push(words.int("a physical tag of an entity")?.saturating_abs());
            }
            if dimension > 0 {
                let bounding = words.size("the number of entities that bound an entity")?;
                for _ in 0..bounding {
                    words.int("the tag of an entity that bounds one")?;
                }
            }
            entities.0.insert((dimension as i32, tag), tags);
        }
    }
    Ok(entities)
}

/// Reads the section of the nodes: blocks of numbers and then coordinates.
///
/// # Errors
/// What is not allowed, with its byte.
pub(super) fn nodes(words: &mut Words<'_>, mesh: &mut RawMesh) -> Result<(), Located> {
    let blocks = words.size("the number of blocks of nodes")?;
    let count = words.size("the number of nodes")?;
    words.size("the least number of a node")?;
    words.size("the greatest number of a node")?;
    mesh.nodes.reserve(words.capacity(count) / 4);
    let mut numbers = Vec::new();
    for _ in 0..blocks {
        let dimension = words.int("the dimension of a block of nodes")?;
        words.int("the entity of a block of nodes")?;
        let is_parametric = words.int("whether nodes have parameters")? != 0;
        let nodes = words.size("the number of nodes of a block")?;
        numbers.clear();
        for _ in 0..nodes {
            numbers.push((words.size("the number of a node")?, words.at()));
        }
        for &(number, at) in &numbers {
            let point = words.point("a coordinate of a node", false).map_err(|error| of_node(error, number))?;
            if is_parametric {
                for _ in 0..dimension.clamp(0, 3) {
                    words.real("a parameter of a node", false)?;
                }
            }
            mesh.push_node(number, at, point);
        }
    }
    total(words, "nodes", count, mesh.nodes.len() as u64)
}

/// Reads the section of the elements: blocks of one entity and type.
///
/// # Errors
/// What is not allowed, with its byte.
pub(super) fn elements(words: &mut Words<'_>, entities: &Entities, mesh: &mut RawMesh) -> Result<(), Located> {
    let blocks = words.size("the number of blocks of elements")?;
    let count = words.size("the number of elements")?;
    words.size("the least number of an element")?;
    words.size("the greatest number of an element")?;
    let (mut nodes, mut read) = (Vec::new(), 0);
    for _ in 0..blocks {
        let dimension = words.int("the dimension of a block of elements")?;
        let entity = words.int("the entity of a block of elements")?;
        let at = words.at() + 1;
        let of_kind = words.int("the type of elements")?;
        let alike = words.size("the number of elements of a block")?;
        let kind = kind(of_kind, read + 1, at)?;
        let tags = mesh.tag_set(entities.0.get(&(dimension, entity)).map_or(&[], Vec::as_slice));
        for _ in 0..alike {
            let at = words.at() + 1;
            let number = words.size("the number of an element")?;
            nodes.clear();
            for _ in 0..kind.corners {
                nodes.push(words.size("a node of an element")?);
            }
            push(mesh, kind, &mut nodes, CellFacts { number, at, tags })?;
            read += 1;
        }
    }
    total(words, "elements", count, read)
}

/// Checks that blocks have as many entries as the section announces.
fn total(words: &Words<'_>, entity: &str, announced: u64, found: u64) -> Result<(), Located> {
    if announced == found {
        return Ok(());
    }
    let entity = format!("the blocks, of the {announced} {entity} announced,");
    let problem = TetMeshProblem::Word { entity, found: format!("{found} of them"), allowed: "the number announced" };
    Err((words.at(), problem))
}
