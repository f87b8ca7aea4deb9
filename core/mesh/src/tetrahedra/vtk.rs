//! The legacy VTK format: unstructured grids, as text or binary, with cells in one list (versions 2 to 4.2) or as offsets and connectivity (5.1).

use super::data::{DataPlace, DataSection};
use super::error::TetMeshProblem;
use super::raw::{CellFacts, CellKind, NO_TAGS, RawMesh};
use super::vtk_data;
use super::words::{Encoding, Located, Words, shorten};

/// Kinds of cells: type, name, dimension and number of nodes (VTK file formats, "vtkCellType.h"); 0 for a kind of any number of nodes.
const KINDS: [(u64, &str, u32, usize); 22] = [
    (1, "point", 0, 1),
    (2, "set of points", 0, 0),
    (3, "line", 1, 2),
    (4, "polyline", 1, 0),
    (5, "triangle", 2, 3),
    (6, "triangle strip", 2, 0),
    (7, "polygon", 2, 0),
    (8, "pixel", 2, 4),
    (9, "quadrangle", 2, 4),
    (10, "tetrahedron", 3, 4),
    (11, "voxel", 3, 8),
    (12, "hexahedron", 3, 8),
    (13, "prism", 3, 6),
    (14, "pyramid", 3, 5),
    (21, "line of 3 nodes", 1, 3),
    (22, "triangle of 6 nodes", 2, 6),
    (23, "quadrangle of 8 nodes", 2, 8),
    (24, "tetrahedron of 10 nodes", 3, 10),
    (25, "hexahedron of 20 nodes", 3, 20),
    (26, "prism of 15 nodes", 3, 15),
    (27, "pyramid of 13 nodes", 3, 13),
    (42, "polyhedron", 3, 0),
];

/// Cells of a file: nodes of cell i are `connectivity[offsets[i]..offsets[i + 1]]`.
#[derive(Default)]
struct Cells {
    offsets: Vec<usize>,
    connectivity: Vec<u64>,
    /// Byte of each cell.
    at: Vec<usize>,
}

/// Parses a file.
///
/// # Errors
/// The byte and the problem of what is not allowed.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let mut words = Words::new(bytes);
    let mut mesh = RawMesh { end: bytes.len(), ..RawMesh::default() };
    let first = words.line();
    let version = first.strip_prefix(b"# vtk DataFile Version ").unwrap_or_default().trim_ascii();
    let is_known = version.first().is_some_and(|digit| (b'2'..=b'5').contains(digit));
    if !is_known {
        let found = shorten(version);
        return Err((0, TetMeshProblem::Version { format: "VTK", found, allowed: "2.0 to 5.1" }));
    }
    words.line(); // the title
    let (kind, at) = words.expect("`ASCII` or `BINARY`")?;
    let encoding = match kind {
        b"ASCII" => Encoding::Text,
        b"BINARY" => Encoding::BigEndian,
        _ => return Err(word(at, "the kind of the file", kind, "`ASCII` or `BINARY`")),
    };
    let (mut cells, mut has_points, mut types) = (None, false, None);
    while let Some((keyword, at)) = words.word() {
        let is_second = match keyword {
            b"POINTS" => has_points,
            b"CELLS" => cells.is_some(),
            b"CELL_TYPES" => types.is_some(),
            _ => false,
        };
        if is_second {
            return Err((at, TetMeshProblem::Twice { section: shorten(keyword) }));
        }
        match keyword {
            b"DATASET" => {
                let (found, at) = words.expect("the kind of the data set")?;
                if found != b"UNSTRUCTURED_GRID" {
                    return Err((at, TetMeshProblem::DataSet { found: shorten(found) }));
                }
            }
            b"POINTS" => {
                points(&mut words, encoding, &mut mesh)?;
                has_points = true;
            }
            b"CELLS" => cells = Some(read_cells(&mut words, encoding, version[0] == b'5')?),
            b"CELL_TYPES" => types = Some(read_types(&mut words, encoding)?),
            b"METADATA" => {
                words.line();
                while !words.line().trim_ascii().is_empty() {}
            }
            b"FIELD" => fields(&mut words, encoding)?,
            b"POINT_DATA" => {
                let section = DataSection { place: DataPlace::Nodes, rows: mesh.nodes.len() };
                vtk_data::read(&mut words, encoding, section, &mut mesh)?;
            }
            b"CELL_DATA" => {
                let rows = cells.as_ref().map_or(0, |cells: &Cells| cells.offsets.len().saturating_sub(1));
                let section = DataSection { place: DataPlace::Elements, rows };
                vtk_data::read(&mut words, encoding, section, &mut mesh)?;
            }
            _ => {
                let allowed = "DATASET, FIELD, POINTS, CELLS, CELL_TYPES, METADATA, POINT_DATA or CELL_DATA";
                return Err(word(at, "a section", keyword, allowed));
            }
        }
    }
    let missing = |section| (bytes.len(), TetMeshProblem::NoSection { section });
    if !has_points {
        return Err(missing("POINTS"));
    }
    let (cells, (types, types_at)) =
        (cells.ok_or_else(|| missing("CELLS"))?, types.ok_or_else(|| missing("CELL_TYPES"))?);
    push_cells(&cells, &types, types_at, &mut mesh)?;
    Ok(mesh)
}

/// The problem of a word.
fn word(at: usize, entity: &str, found: &[u8], allowed: &'static str) -> Located {
    (at, TetMeshProblem::Word { entity: entity.into(), found: shorten(found), allowed })
}

/// Reads a type of numbers, and ends the line in a binary file. Returns the size in bytes.
fn number_type(words: &mut Words<'_>, allowed: &'static str, known: &[(&str, usize)]) -> Result<usize, Located> {
    let (found, at) = words.expect("a type of numbers")?;
    let size = known.iter().find(|(name, _)| name.as_bytes() == found).map(|(_, size)| *size);
    size.ok_or_else(|| word(at, "a type of numbers", found, allowed))
}

fn points(words: &mut Words<'_>, encoding: Encoding, mesh: &mut RawMesh) -> Result<(), Located> {
    let count = words.size("the number of points")?;
    let size = number_type(words, "float or double", &[("float", 4), ("double", 8)])?;
    words.line();
    words.encoding = encoding;
    mesh.nodes.reserve(words.capacity(count) / 3);
    for number in 0..count {
        let at = words.at() + 1;
        let point = words.point("a coordinate", size == 4).map_err(|error| super::msh2::of_node(error, number))?;
        mesh.push_node(number, at, point);
    }
    words.encoding = Encoding::Text;
    Ok(())
}

fn read_cells(words: &mut Words<'_>, encoding: Encoding, has_offsets: bool) -> Result<Cells, Located> {
    let (count, size) = (words.size("the number of cells")?, words.size("the size of the list of cells")?);
    words.line();
    let mut cells = Cells { offsets: vec![0], ..Cells::default() };
    if has_offsets {
        // The number of offsets is one more than that of cells.
        let offsets = integers(words, encoding, b"OFFSETS", count)?;
        cells.connectivity = integers(words, encoding, b"CONNECTIVITY", size)?.into_iter().map(|(of, _)| of).collect();
        cells.offsets.clear();
        for (offset, at) in offsets {
            let end = usize::try_from(offset)
                .ok()
                .filter(|end| *end <= cells.connectivity.len() && cells.offsets.last().is_none_or(|last| last <= end));
            let found = offset.to_string();
            cells.offsets.push(
                end.ok_or_else(|| word(at, "an offset", found.as_bytes(), "an ascending place in CONNECTIVITY"))?,
            );
            cells.at.push(at);
        }
        return Ok(cells);
    }
    words.encoding = encoding;
    for _ in 0..count {
        let at = words.at() + 1;
        let corners = words.count("the number of nodes of a cell")?;
        cells.at.push(at);
        for _ in 0..corners {
            cells.connectivity.push(words.count("a node of a cell")?);
        }
        cells.offsets.push(cells.connectivity.len());
    }
    words.encoding = Encoding::Text;
    Ok(cells)
}

/// Reads `count` whole numbers, 0 or more, under a keyword and a type, each with its byte.
fn integers(
    words: &mut Words<'_>,
    encoding: Encoding,
    keyword: &'static [u8],
    count: u64,
) -> Result<Vec<(u64, usize)>, Located> {
    let entity = shorten(keyword);
    let (found, at) = words.expect(&entity)?;
    if found != keyword {
        return Err(word(at, "the list of cells", found, "OFFSETS and then CONNECTIVITY"));
    }
    let known = [("vtktypeint64", 8), ("vtktypeint32", 4), ("long", 8), ("int", 4)];
    let size = number_type(words, "vtktypeint64 or vtktypeint32", &known)?;
    words.line();
    words.encoding = encoding;
    let mut all = Vec::with_capacity(words.capacity(count) / 4);
    for _ in 0..count {
        let number = if size == 8 { words.size(&entity)? } else { words.count(&entity)? };
        all.push((number, words.at()));
    }
    words.encoding = Encoding::Text;
    Ok(all)
}

/// Types of the cells, and the byte of their list.
fn read_types(words: &mut Words<'_>, encoding: Encoding) -> Result<(Vec<u64>, usize), Located> {
    let count = words.size("the number of types of cells")?;
    words.line();
    let at = words.at();
    words.encoding = encoding;
    let mut types = Vec::with_capacity(words.capacity(count));
    for _ in 0..count {
        types.push(words.count("the type of a cell")?);
    }
    words.encoding = Encoding::Text;
    Ok((types, at))
}

/// Skips fields: a name, the number of arrays, and each array with its name, its shape, its type and its numbers.
fn fields(words: &mut Words<'_>, encoding: Encoding) -> Result<(), Located> {
    words.expect("the name of a field")?;
    let arrays = words.size("the number of arrays of a field")?;
    for _ in 0..arrays {
        words.expect("the name of an array")?;
        let numbers = words.size("the components of an array")?.saturating_mul(words.size("the rows of an array")?);
        let (of, at) = words.expect("the type of an array")?;
        words.line();
        if encoding == Encoding::Text {
            for _ in 0..numbers {
                words.expect("a number of an array")?;
            }
            continue;
        }
        let size = vtk_data::number_type(of, at)?.size() as u64;
        let bytes = usize::try_from(numbers.saturating_mul(size)).unwrap_or(usize::MAX);
        words.skip_bytes(bytes, "the numbers of an array")?;
    }
    Ok(())
}

/// Gives the cells to the mesh by their types.
fn push_cells(cells: &Cells, types: &[u64], types_at: usize, mesh: &mut RawMesh) -> Result<(), Located> {
    let count = cells.offsets.len().saturating_sub(1);
    if types.len() != count {
        let found = format!("{} types", types.len());
        let problem = TetMeshProblem::Word {
            entity: format!("CELL_TYPES of {count} cells"),
            found,
            allowed: "one type for each cell",
        };
        return Err((types_at, problem));
    }
    for (cell, &of) in types.iter().enumerate() {
        let facts = CellFacts { number: cell as u64, at: cells.at[cell], tags: NO_TAGS };
        let nodes = &cells.connectivity[cells.offsets[cell]..cells.offsets[cell + 1]];
        push_cell(mesh, of, types_at, nodes, facts)?;
    }
    Ok(())
}

/// Gives a cell to the mesh by its type, which is at the byte `type_at`.
///
/// # Errors
/// A type that the format does not define or that has another number of nodes, and those of [`RawMesh::push`].
pub(super) fn push_cell(
    mesh: &mut RawMesh,
    of: u64,
    type_at: usize,
    nodes: &[u64],
    facts: CellFacts,
) -> Result<(), Located> {
    let CellFacts { number, at, .. } = facts;
    let Some(&(_, name, dimension, corners)) = KINDS.iter().find(|(kind, ..)| *kind == of) else {
        return Err((type_at, TetMeshProblem::Kind { number, found: of.cast_signed() }));
    };
    if corners != 0 && corners != nodes.len() {
        let entity = format!("cell {number}, a {name}");
        let found = format!("{} nodes", nodes.len());
        return Err((at, TetMeshProblem::Word { entity, found, allowed: "as many nodes as its type has" }));
    }
    // A set of one point, or a polygon of three, is no cell that groups or faces are made of.
    let nodes = if corners == 0 { &[][..] } else { nodes };
    mesh.push(CellKind { name, dimension, corners }, nodes, facts)
}
