//! The XML format of VTK for unstructured grids (`.vtu`) in one piece. XML is `roxmltree`'s, which refuses entities; how VTK puts numbers into it is in `vtu_array`.

use super::data::{DataPlace, DataSection, RawData};
use super::error::TetMeshProblem;
use super::raw::{CellFacts, NO_TAGS, RawMesh};
use super::vtk::push_cell;
use super::vtu_array::{Arrays, Wanted};
use super::words::{Located, shorten};
use roxmltree::{Document, Node, ParsingOptions};

/// Most elements, texts and comments of a file: a grid has dozens.
const NODES_LIMIT: u32 = 100_000;

/// Whether a file begins as XML does.
pub(super) fn is_xml(bytes: &[u8]) -> bool {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start().starts_with(b"<")
}

/// Parses a file.
///
/// # Errors
/// The byte and the problem of what is not allowed.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let (text, raw) = split(bytes)?;
    let options = ParsingOptions { nodes_limit: NODES_LIMIT, ..ParsingOptions::default() };
    let document = Document::parse_with_options(&text, options).map_err(|error| {
        let line_before = error.pos().row.saturating_sub(1) as usize;
        let mut ends = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1);
        let at = if line_before == 0 { 0 } else { ends.nth(line_before - 1).unwrap_or(bytes.len()) };
        (at, TetMeshProblem::Xml { problem: error.to_string() })
    })?;
    let root = document.root_element();
    let kind = root.attribute("type").unwrap_or(root.tag_name().name());
    if !root.has_tag_name("VTKFile") || kind != "UnstructuredGrid" {
        return Err((root.range().start, TetMeshProblem::DataSet { found: shorten(kind.as_bytes()) }));
    }
    let grid = child(root, "UnstructuredGrid")?;
    let pieces = grid.children().filter(|node| node.has_tag_name("Piece")).count();
    if pieces > 1 {
        let (entity, allowed) = ("the number of pieces".into(), "one: append them to one grid");
        let problem = TetMeshProblem::Word { entity, found: pieces.to_string(), allowed };
        return Err((grid.range().start, problem));
    }
    let piece = child(grid, "Piece")?;
    let arrays = Arrays::new(bytes, raw, root)?;
    let mut mesh = RawMesh { end: bytes.len(), ..RawMesh::default() };
    let nodes = count(piece, "NumberOfPoints")?;
    let cells = count(piece, "NumberOfCells")?;
    points(&arrays, piece, nodes, &mut mesh)?;
    read_cells(&arrays, piece, cells, &mut mesh)?;
    for (tag, section) in [
        ("PointData", DataSection { place: DataPlace::Nodes, rows: nodes }),
        ("CellData", DataSection { place: DataPlace::Elements, rows: cells }),
    ] {
        let Some(parent) = piece.children().find(|node| node.has_tag_name(tag)) else { continue };
        for array in parent.children().filter(|node| node.has_tag_name("DataArray") || node.has_tag_name("Array")) {
            data(&arrays, array, section, &mut mesh)?;
        }
    }
    // Lines are found in the order of the file, and cells may come first.
    mesh.data.sort_by_key(|data| data.at);
    Ok(mesh)
}

/// The text of the elements, and the numbers after them where these are raw: then the text ends at their beginning.
fn split(bytes: &[u8]) -> Result<(std::borrow::Cow<'_, str>, Option<&[u8]>), Located> {
    const OPENING: &[u8] = b"<AppendedData";
    const END: &str = "</AppendedData></VTKFile>";
    let appended = bytes.windows(OPENING.len()).position(|window| window == OPENING);
    let tag_end = appended.and_then(|at| Some(at + bytes[at..].iter().position(|byte| *byte == b'>')? + 1));
    let (text, raw) = match appended.zip(tag_end) {
        Some((at, end)) if is_raw(&bytes[at..end]) => {
            let begin = bytes[end..].iter().position(|byte| *byte == b'_').map_or(bytes.len(), |at| end + at + 1);
            (&bytes[..end], Some(&bytes[begin..]))
        }
        _ => (bytes, None),
    };
    let text = std::str::from_utf8(text).map_err(|error| {
        let problem = TetMeshProblem::Xml { problem: "a byte that is no UTF-8".into() };
        (error.valid_up_to(), problem)
    })?;
    Ok(match raw {
        Some(_) => (format!("{text}{END}").into(), raw),
        None => (text.into(), None),
    })
}

/// Whether a tag says that the numbers after it are raw.
fn is_raw(tag: &[u8]) -> bool {
    String::from_utf8_lossy(tag).split_whitespace().any(|word| {
        word.strip_prefix("encoding=")
            .is_some_and(|value| value.trim_end_matches('>').trim_matches(['"', '\'']) == "raw")
    })
}

/// The child element of this name.
fn child<'a, 'i>(parent: Node<'a, 'i>, name: &'static str) -> Result<Node<'a, 'i>, Located> {
    let found = parent.children().find(|node| node.has_tag_name(name));
    found.ok_or((parent.range().start, TetMeshProblem::NoSection { section: name }))
}

/// A number of points or cells.
fn count(piece: Node<'_, '_>, name: &'static str) -> Result<usize, Located> {
    let found = piece.attribute(name).unwrap_or_default();
    let problem = |allowed| TetMeshProblem::Word { entity: name.into(), found: shorten(found.as_bytes()), allowed };
    found.parse().map_err(|_| (piece.range().start, problem("a whole number, 0 or more")))
}

fn points(arrays: &Arrays<'_>, piece: Node<'_, '_>, count: usize, mesh: &mut RawMesh) -> Result<(), Located> {
    let array = child(child(piece, "Points")?, "DataArray")?;
    let at = array.range().start;
    let components = array.attribute("NumberOfComponents").unwrap_or("1");
    if components != "3" {
        let (entity, found) = ("NumberOfComponents of Points".into(), shorten(components.as_bytes()));
        return Err((at, TetMeshProblem::Word { entity, found, allowed: "3" }));
    }
    let coordinates = arrays.read(array, Wanted { name: "Points", count: count.saturating_mul(3) })?;
    for (number, point) in coordinates.as_chunks::<3>().0.iter().enumerate() {
        if let Some(wrong) = point.iter().find(|c| !c.is_finite()) {
            let (entity, found) = (format!("a coordinate of node {number}"), wrong.to_string());
            return Err((at, TetMeshProblem::Word { entity, found, allowed: "a finite number" }));
        }
        mesh.push_node(number as u64, at, *point);
    }
    Ok(())
}

fn read_cells(arrays: &Arrays<'_>, piece: Node<'_, '_>, count: usize, mesh: &mut RawMesh) -> Result<(), Located> {
    let cells = child(piece, "Cells")?;
    let named = |name: &'static str| {
        let found =
            cells.children().find(|node| node.has_tag_name("DataArray") && node.attribute("Name") == Some(name));
        found.ok_or((cells.range().start, TetMeshProblem::NoSection { section: name }))
    };
    let [connectivity, offsets, types] = [named("connectivity")?, named("offsets")?, named("types")?];
    let ends = whole(arrays.read(offsets, Wanted { name: "offsets", count })?, "an offset", offsets)?;
    let size = usize::try_from(ends.last().copied().unwrap_or(0)).unwrap_or(usize::MAX);
    let nodes = arrays.read(connectivity, Wanted { name: "connectivity", count: size })?;
    let nodes = whole(nodes, "a node of a cell", connectivity)?;
    let types_at = types.range().start;
    let kinds = whole(arrays.read(types, Wanted { name: "types", count })?, "the type of a cell", types)?;
    let (mut begin, at) = (0, connectivity.range().start);
    for (number, (end, kind)) in (0..).zip(ends.into_iter().zip(kinds)) {
        let range = usize::try_from(end).ok().filter(|end| (begin..=nodes.len()).contains(end)).map(|end| begin..end);
        let Some(range) = range else {
            let (entity, found) = (format!("the offset of cell {number}"), end.to_string());
            let problem = TetMeshProblem::Word { entity, found, allowed: "an ascending place in `connectivity`" };
            return Err((offsets.range().start, problem));
        };
        begin = range.end;
        push_cell(mesh, kind, types_at, &nodes[range], CellFacts { number, at, tags: NO_TAGS })?;
    }
    Ok(())
}

/// Numbers that are whole, 0 or more.
fn whole(numbers: Vec<f64>, entity: &str, array: Node<'_, '_>) -> Result<Vec<u64>, Located> {
    let whole = |(index, number): (usize, f64)| {
        let is_whole = number >= 0.0 && number.fract() == 0.0 && number < 9e15; // beyond which numbers of double precision are not exact
        let (entity, found) = (format!("{entity}, number {index} of its array"), number.to_string());
        let problem = TetMeshProblem::Word { entity, found, allowed: "a whole number, 0 or more" };
        if is_whole { Ok(number as u64) } else { Err((array.range().start, problem)) }
    };
    numbers.into_iter().enumerate().map(whole).collect()
}

/// Reads an array of values if it has one number at each node or cell, and notes another one as not read.
fn data(arrays: &Arrays<'_>, array: Node<'_, '_>, section: DataSection, mesh: &mut RawMesh) -> Result<(), Located> {
    let DataSection { place, rows } = section;
    let name = array.attribute("Name").unwrap_or_default();
    let components = array.attribute("NumberOfComponents").unwrap_or("1");
    if components != "1" || !Arrays::has_numbers(array) {
        let name = shorten(name.as_bytes());
        mesh.sections.push(match components {
            "1" => format!("`{name}` at {place}, which are no numbers"),
            _ => format!("`{name}` of {} components at {place}", shorten(components.as_bytes())),
        });
        return Ok(());
    }
    let values = arrays.read(array, Wanted { name, count: rows })?;
    let values = (0..).zip(values).collect();
    mesh.data.push(RawData { name: name.to_owned(), place, at: array.range().start, line: 0, values });
    Ok(())
}
