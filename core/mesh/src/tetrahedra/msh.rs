//! The Gmsh format: its sections, and what versions 2 and 4.1 have in common.

use super::data::{DataPlace, RawData};
use super::error::TetMeshProblem;
use super::raw::{CellFacts, CellKind, RawMesh};
use super::words::{Encoding, Located, NumberType, Words, shorten};
use super::{msh2, msh4};

/// A version of the format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    /// Versions 2 to 2.2.
    Two,
    /// Version 4.1.
    FourOne,
}

/// Kinds of elements by their type, from 1: name, dimension and number of nodes (Gmsh reference manual, "MSH file format").
const KINDS: [(&str, u32, usize); 31] = [
    ("line", 1, 2),
    ("triangle", 2, 3),
    ("quadrangle", 2, 4),
    ("tetrahedron", 3, 4),
    ("hexahedron", 3, 8),
    ("prism", 3, 6),
    ("pyramid", 3, 5),
    ("line of 3 nodes", 1, 3),
    ("triangle of 6 nodes", 2, 6),
    ("quadrangle of 9 nodes", 2, 9),
    ("tetrahedron of 10 nodes", 3, 10),
    ("hexahedron of 27 nodes", 3, 27),
    ("prism of 18 nodes", 3, 18),
    ("pyramid of 14 nodes", 3, 14),
    ("point", 0, 1),
    ("quadrangle of 8 nodes", 2, 8),
    ("hexahedron of 20 nodes", 3, 20),
    ("prism of 15 nodes", 3, 15),
    ("pyramid of 13 nodes", 3, 13),
    ("triangle of 9 nodes", 2, 9),
    ("triangle of 10 nodes", 2, 10),
    ("triangle of 12 nodes", 2, 12),
    ("triangle of 15 nodes", 2, 15),
    ("triangle of 15 nodes", 2, 15),
    ("triangle of 21 nodes", 2, 21),
    ("line of 4 nodes", 1, 4),
    ("line of 5 nodes", 1, 5),
    ("line of 6 nodes", 1, 6),
    ("tetrahedron of 20 nodes", 3, 20),
    ("tetrahedron of 35 nodes", 3, 35),
    ("tetrahedron of 56 nodes", 3, 56),
];

/// The kind of elements of a type.
///
/// # Errors
/// A type that is not listed, of the element `number` at the byte `at`.
pub(super) fn kind(kind: i32, number: u64, at: usize) -> Result<CellKind, Located> {
    let found = usize::try_from(kind).ok().and_then(|kind| KINDS.get(kind.wrapping_sub(1)));
    let &(name, dimension, corners) = found.ok_or((at, TetMeshProblem::Kind { number, found: kind.into() }))?;
    Ok(CellKind { name, dimension, corners })
}

/// Gives an element to the mesh. Gmsh lists the middles of edges 23 and 13 of a quadratic tetrahedron in this order, VTK in the other one.
///
/// # Errors
/// As [`RawMesh::push`].
pub(super) fn push(mesh: &mut RawMesh, kind: CellKind, nodes: &mut [u64], facts: CellFacts) -> Result<(), Located> {
    if kind.dimension == 3 && nodes.len() == 10 {
        nodes.swap(8, 9);
    }
    mesh.push(kind, nodes, facts)
}

/// Parses a file.
///
/// # Errors
/// The byte and the problem of what is not allowed.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let mut words = Words::new(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let (first, at) = words.expect("`$MeshFormat`")?;
    if first != b"$MeshFormat" {
        return Err((at, TetMeshProblem::Format { found: shorten(first) }));
    }
    let (version, encoding) = header(&mut words)?;
    let mut mesh = RawMesh { end: bytes.len(), ..RawMesh::default() };
    let mut entities = msh4::Entities::default();
    let mut seen: Vec<&[u8]> = Vec::new();
    while let Some((section, at)) = words.word() {
        let wrong = |allowed| {
            let problem = TetMeshProblem::Word { entity: "a section".into(), found: shorten(section), allowed };
            Err((at, problem))
        };
        let Some(name) = section.strip_prefix(b"$") else { return wrong("`$` and a name, as `$Nodes`") };
        if seen.contains(&name) && [&b"Nodes"[..], b"Elements", b"Entities"].contains(&name) {
            return Err((at, TetMeshProblem::Twice { section: shorten(section) }));
        }
        seen.push(name);
        words.line(); // binary numbers begin after the end of the line
        words.encoding = encoding;
        match (name, version) {
            (b"PhysicalNames", _) => physical_names(&mut words, &mut mesh)?,
            (b"Nodes", Version::Two) => msh2::nodes(&mut words, &mut mesh)?,
            (b"Elements", Version::Two) => msh2::elements(&mut words, &mut mesh)?,
            (b"Entities", Version::FourOne) => entities = msh4::entities(&mut words)?,
            (b"Nodes", Version::FourOne) => msh4::nodes(&mut words, &mut mesh)?,
            (b"Elements", Version::FourOne) => msh4::elements(&mut words, &entities, &mut mesh)?,
            (b"NodeData", _) => data(&mut words, encoding, DataPlace::Nodes, at, &mut mesh)?,
            (b"ElementData", _) => data(&mut words, encoding, DataPlace::Elements, at, &mut mesh)?,
            _ => {
                if name != b"Comments" {
                    mesh.sections.push(shorten(section));
                }
                let end = [b"$End", name].concat();
                if !words.skip_past(&end) {
                    let entity = format!("`{}`", shorten(&end));
                    return Err((bytes.len(), TetMeshProblem::Ends { entity }));
                }
                continue;
            }
        }
        words.encoding = Encoding::Text;
        let end = format!("$End{}", shorten(name));
        let (found, at) = words.expect(&format!("`{end}`"))?;
        if found != end.as_bytes() {
            let entity = format!("the end of `{}`", shorten(section));
            let allowed = "the `$End` of the section, after as many entries as it announces";
            return Err((at, TetMeshProblem::Word { entity, found: shorten(found), allowed }));
        }
    }
    for section in ["$Nodes", "$Elements"] {
        if !seen.contains(&&section.as_bytes()[1..]) {
            return Err((bytes.len(), TetMeshProblem::NoSection { section }));
        }
    }
    Ok(mesh)
}

/// Reads the version and the encoding.
fn header(words: &mut Words<'_>) -> Result<(Version, Encoding), Located> {
    let (found, at) = words.expect("the version of the format")?;
    let version = match found {
        b"2" | b"2.0" | b"2.1" | b"2.2" => Version::Two,
        b"4.1" => Version::FourOne,
        _ => {
            let allowed = "2 to 2.2, and 4.1 (with Gmsh: `-format msh41`)";
            return Err((at, TetMeshProblem::Version { format: "Gmsh", found: shorten(found), allowed }));
        }
    };
    let is_binary = words.int("the file type")? != 0;
    let at = words.at();
    let size = words.int("the size of numbers")?;
    if size != 8 {
        let entity = "the size of numbers in bytes".into();
        return Err((at, TetMeshProblem::Word { entity, found: size.to_string(), allowed: "8" }));
    }
    words.line();
    let mut encoding = Encoding::Text;
    if is_binary {
        words.encoding = Encoding::LittleEndian;
        let one = words.int("the number 1, which tells the order of bytes")?;
        encoding = if one == 1 { Encoding::LittleEndian } else { Encoding::BigEndian };
        words.encoding = Encoding::Text;
    }
    let (end, at) = words.expect("`$EndMeshFormat`")?;
    if end != b"$EndMeshFormat" {
        let entity = "the end of `$MeshFormat`".into();
        return Err((at, TetMeshProblem::Word { entity, found: shorten(end), allowed: "`$EndMeshFormat`" }));
    }
    Ok((version, encoding))
}

/// Reads names of physical groups, which are text in binary files too.
fn physical_names(words: &mut Words<'_>, mesh: &mut RawMesh) -> Result<(), Located> {
    words.encoding = Encoding::Text;
    let count = words.size("the number of physical names")?;
    for _ in 0..count {
        let dimension = words.int("the dimension of a physical name")?.unsigned_abs();
        let tag = words.int("the tag of a physical name")?;
        let at = words.at();
        let rest = String::from_utf8_lossy(words.line()).trim().to_owned();
        let name = rest.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
        let Some(name) = name.filter(|name| !name.is_empty() && !name.contains(char::is_control)) else {
            let entity = "a physical name".into();
            let allowed = "a text in quotes on the line of its tag";
            return Err((at, TetMeshProblem::Word { entity, found: shorten(rest.as_bytes()), allowed }));
        };
        mesh.names.insert((dimension, tag), name.to_owned());
    }
    Ok(())
}

/// Reads `$NodeData` or `$ElementData`, whose tags are text in binary files too: the first text is the name, the second and third whole number are those of components and of
/// entries. The section begins at the byte `at`.
fn data(
    words: &mut Words<'_>,
    encoding: Encoding,
    place: DataPlace,
    at: usize,
    mesh: &mut RawMesh,
) -> Result<(), Located> {
    words.encoding = Encoding::Text;
    let texts = words.size("the number of texts of an array")?;
    let mut name = String::new();
    for number in 0..texts {
        let text = words.quoted("the name of an array")?;
        if number == 0 {
            name = text;
        }
    }
    for _ in 0..words.size("the number of real tags of an array")? {
        words.real("a real tag of an array", false)?;
    }
    let whole = words.size("the number of whole tags of an array")?;
    let (mut components, mut count) = (0, 0);
    for number in 0..whole {
        let value = words.size("a whole tag of an array")?;
        match number {
            1 => components = value,
            2 => count = value,
            _ => {}
        }
    }
    words.line(); // binary numbers begin after the end of the line
    words.encoding = encoding;
    let shown = shorten(name.as_bytes());
    let (tag, entity) = (format!("the tag of a value of array `{shown}`"), format!("a value of array `{shown}`"));
    let mut values = Vec::with_capacity(words.capacity(count) / 4);
    for _ in 0..count {
        let number = words.count(&tag)?;
        for component in 0..components {
            let value = words.number(&entity, NumberType::F64)?;
            if component == 0 {
                values.push((number, value));
            }
        }
    }
    if components == 1 {
        mesh.data.push(RawData { name, place, at, line: 0, values });
    } else {
        mesh.sections.push(format!("`{shown}` of {components} components at {place}"));
    }
    Ok(())
}
