//! Values at points and cells of a legacy VTK file (`POINT_DATA` and `CELL_DATA`).

use super::data::{DataPlace, DataSection, RawData};
use super::error::TetMeshProblem;
use super::raw::RawMesh;
use super::words::{Encoding, Located, NumberType, Words, shorten};

/// Types of numbers of legacy files ("VTK file formats", "Dataset Attribute Format").
const TYPES: [(&str, NumberType); 17] = [
    ("unsigned_char", NumberType::U8),
    ("char", NumberType::I8),
    ("signed_char", NumberType::I8),
    ("unsigned_short", NumberType::U16),
    ("short", NumberType::I16),
    ("unsigned_int", NumberType::U32),
    ("int", NumberType::I32),
    ("vtktypeint32", NumberType::I32),
    ("vtktypeuint32", NumberType::U32),
    ("unsigned_long", NumberType::U64),
    ("long", NumberType::I64),
    ("vtktypeint64", NumberType::I64),
    ("vtktypeuint64", NumberType::U64),
    ("vtkIdType", NumberType::I32),
    ("vtkidtype", NumberType::I32),
    ("float", NumberType::F32),
    ("double", NumberType::F64),
];

/// The type of numbers of this name.
///
/// # Errors
/// A name that is not listed, at the byte `at`.
pub(super) fn number_type(found: &[u8], at: usize) -> Result<NumberType, Located> {
    let known = TYPES.iter().find(|(name, _)| name.as_bytes() == found).map(|(_, of)| *of);
    known.ok_or_else(|| {
        let (entity, allowed) = ("the type of an array".into(), "an integer or floating point type of VTK");
        (at, TetMeshProblem::Word { entity, found: shorten(found), allowed })
    })
}

impl DataSection {
    /// Its keyword in the format.
    fn keyword(self) -> &'static str {
        match self.place {
            DataPlace::Nodes => "POINT_DATA",
            DataPlace::Elements => "CELL_DATA",
        }
    }
}

/// An array that comes next.
struct Coming {
    name: String,
    at: usize,
    components: u64,
    of: NumberType,
}

/// Reads the values after `POINT_DATA` or `CELL_DATA` up to the next of both, which it leaves, or the end. Arrays of several components, and what follows
/// an attribute that the format does not define, are noted as not read.
///
/// # Errors
/// The byte and the problem of what is not allowed.
pub(super) fn read(
    words: &mut Words<'_>,
    encoding: Encoding,
    section: DataSection,
    mesh: &mut RawMesh,
) -> Result<(), Located> {
    let (keyword_of_section, rows) = (section.keyword(), section.rows);
    let at = words.at();
    let found = words.size("the number of values")?;
    if found != rows as u64 {
        let problem = TetMeshProblem::Word {
            entity: format!("the number of values of {keyword_of_section}, whose mesh has {rows}"),
            found: found.to_string(),
            allowed: "one for each",
        };
        return Err((at, problem));
    }
    loop {
        let before = words.clone();
        let Some((keyword, at)) = words.word() else { return Ok(()) };
        let known = match keyword {
            b"SCALARS" => Some(scalars(words, at)?),
            b"VECTORS" | b"NORMALS" => Some(attribute(words, at, 3)?),
            b"TENSORS" => Some(attribute(words, at, 9)?),
            b"TENSORS6" => Some(attribute(words, at, 6)?),
            b"GLOBAL_IDS" | b"PEDIGREE_IDS" => Some(attribute(words, at, 1)?),
            b"TEXTURE_COORDINATES" => {
                let (name, _) = name(words)?;
                let components = words.size("the dimension of texture coordinates")?;
                let of = type_of_numbers(words)?;
                Some(Coming { name, at, components, of })
            }
            b"FIELD" => {
                words.expect("the name of a field")?;
                let arrays = words.size("the number of arrays of a field")?;
                for _ in 0..arrays {
                    array(words, encoding, section, mesh)?;
                }
                None
            }
            b"METADATA" => {
                words.line();
                while !words.line().trim_ascii().is_empty() {}
                None
            }
            _ => {
                if !matches!(keyword, b"POINT_DATA" | b"CELL_DATA") {
                    mesh.sections.push(format!("{keyword_of_section} from `{}` on", shorten(keyword)));
                    words.go_to_end();
                    return Ok(());
                }
                *words = before;
                return Ok(());
            }
        };
        if let Some(coming) = known {
            values(words, encoding, coming, section, mesh)?;
        }
    }
}

/// The name of an array, with its byte, in which blanks and other characters are written as `%20`.
fn name(words: &mut Words<'_>) -> Result<(String, usize), Located> {
    let (found, at) = words.expect("the name of an array")?;
    let mut bytes = Vec::with_capacity(found.len());
    let mut rest = found;
    while let Some((&first, after)) = rest.split_first() {
        let code = after.get(..2).and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        match code {
            Some(code) if first == b'%' => {
                bytes.push(code);
                rest = &after[2..];
            }
            _ => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    Ok((String::from_utf8_lossy(&bytes).into_owned(), at))
}

/// The type of the numbers of an attribute, and the end of its line.
fn type_of_numbers(words: &mut Words<'_>) -> Result<NumberType, Located> {
    let (found, at) = words.expect("the type of an array")?;
    let of = number_type(found, at)?;
    words.line();
    Ok(of)
}

/// `SCALARS name type [components]`, with the line of its lookup table.
fn scalars(words: &mut Words<'_>, at: usize) -> Result<Coming, Located> {
    let (name, _) = name(words)?;
    let (found, type_at) = words.expect("the type of an array")?;
    let of = number_type(found, type_at)?;
    let rest = Words::new(words.line()).word().map(|(word, _)| word.to_vec());
    let components = match rest {
        None => 1,
        Some(word) => std::str::from_utf8(&word).ok().and_then(|word| word.parse().ok()).ok_or_else(|| {
            let (entity, allowed) = ("the components of SCALARS".into(), "1 to 4");
            (at, TetMeshProblem::Word { entity, found: shorten(&word), allowed })
        })?,
    };
    let before = words.clone();
    match words.word() {
        Some((b"LOOKUP_TABLE", _)) => drop(words.line()),
        _ => *words = before,
    }
    Ok(Coming { name, at, components, of })
}

/// `KEYWORD name type`.
fn attribute(words: &mut Words<'_>, at: usize, components: u64) -> Result<Coming, Located> {
    let (name, _) = name(words)?;
    Ok(Coming { name, at, components, of: type_of_numbers(words)? })
}

/// An array of a `FIELD`: `name components rows type`.
fn array(words: &mut Words<'_>, encoding: Encoding, section: DataSection, mesh: &mut RawMesh) -> Result<(), Located> {
    let (name, at) = name(words)?;
    let components = words.size("the components of an array")?;
    let found = words.size("the rows of an array")?;
    let of = type_of_numbers(words)?;
    if found != section.rows as u64 {
        let (keyword, rows) = (section.keyword(), section.rows);
        let problem = TetMeshProblem::Word {
            entity: format!("the rows of array `{}` of {keyword}, which has {rows}", shorten(name.as_bytes())),
            found: found.to_string(),
            allowed: "one for each",
        };
        return Err((at, problem));
    }
    values(words, encoding, Coming { name, at, components, of }, section, mesh)
}

/// Reads the numbers of an array.
fn values(
    words: &mut Words<'_>,
    encoding: Encoding,
    Coming { name, at, components, of }: Coming,
    section: DataSection,
    mesh: &mut RawMesh,
) -> Result<(), Located> {
    words.encoding = encoding;
    let total = components.saturating_mul(section.rows as u64);
    let mut all = Vec::with_capacity(words.capacity(total));
    let entity = format!("a number of array `{}`", shorten(name.as_bytes()));
    for _ in 0..total {
        all.push(words.number(&entity, of)?);
    }
    words.encoding = Encoding::Text;
    if components == 1 {
        let values = (0..).zip(all).collect();
        mesh.data.push(RawData { name, place: section.place, at, line: 0, values });
    } else {
        let (keyword, name) = (section.keyword(), shorten(name.as_bytes()));
        mesh.sections.push(format!("{keyword} `{name}` of {components} components"));
    }
    Ok(())
}
