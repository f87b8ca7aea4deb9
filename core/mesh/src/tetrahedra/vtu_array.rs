//! How the XML formats of VTK write numbers: as text, as base64, or raw after the elements; the latter two whole or in blocks compressed with zlib.
//!
//! A size in a file is a claim: memory is taken for what is there, and what blocks unpack to is limited.

use super::error::TetMeshProblem;
use super::words::{Encoding, Located, NumberType, Words, shorten};
use crate::read::MODEL_LIMIT;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use roxmltree::Node;
use std::cell::Cell;
use std::io::Read;

/// Types of numbers by their names.
const TYPES: [(&str, NumberType); 10] = [
    ("Int8", NumberType::I8),
    ("UInt8", NumberType::U8),
    ("Int16", NumberType::I16),
    ("UInt16", NumberType::U16),
    ("Int32", NumberType::I32),
    ("UInt32", NumberType::U32),
    ("Int64", NumberType::I64),
    ("UInt64", NumberType::U64),
    ("Float32", NumberType::F32),
    ("Float64", NumberType::F64),
];

/// The arrays of a file.
pub(super) struct Arrays<'a> {
    bytes: &'a [u8],
    /// Numbers after the elements.
    appended: Option<Source<'a>>,
    is_big_endian: bool,
    /// Type of the sizes before numbers.
    size: NumberType,
    is_compressed: bool,
    /// Bytes that blocks may still unpack to.
    left: Cell<u64>,
}

/// What is asked of an array.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'a> {
    /// Name for messages.
    pub name: &'a str,
    /// Number of its numbers.
    pub count: usize,
}

/// Bytes as a file has them.
#[derive(Clone)]
enum Source<'a> {
    /// As they are.
    Raw(&'a [u8]),
    /// Base64, without blanks.
    Base64(std::borrow::Cow<'a, [u8]>),
}

impl Source<'_> {
    /// Characters or bytes that a stream of `bytes` takes.
    fn length(&self, bytes: usize) -> usize {
        match self {
            Self::Raw(_) => bytes,
            Self::Base64(_) => bytes.div_ceil(3).saturating_mul(4),
        }
    }

    /// The stream of `count` bytes that begins at a character or byte; `None` if the file ends before or it is no base64.
    fn stream(&self, from: usize, count: usize) -> Option<Vec<u8>> {
        let range = from..from.checked_add(self.length(count))?;
        match self {
            Self::Raw(bytes) => bytes.get(range).map(<[u8]>::to_vec),
            Self::Base64(text) => {
                // A stream that goes on after these bytes has no padding here.
                let mut bytes = STANDARD.decode(text.get(range)?).ok()?;
                bytes.truncate(count);
                (bytes.len() == count).then_some(bytes)
            }
        }
    }
}

impl<'a> Arrays<'a> {
    /// The arrays of a file with this root element, whose numbers after the elements are `raw` if they are.
    pub(super) fn new(bytes: &'a [u8], raw: Option<&'a [u8]>, root: Node<'_, '_>) -> Result<Self, Located> {
        let at = root.range().start;
        let one_of = |name: &str, default: &'static str, allowed: &'static [&'static str], list| {
            let found = root.attribute(name).unwrap_or(default);
            let known = allowed.iter().find(|known| **known == found);
            let problem =
                || TetMeshProblem::Word { entity: name.into(), found: shorten(found.as_bytes()), allowed: list };
            known.copied().ok_or_else(|| (at, problem()))
        };
        let order = one_of("byte_order", "LittleEndian", &["LittleEndian", "BigEndian"], "LittleEndian or BigEndian")?;
        let header = one_of("header_type", "UInt32", &["UInt32", "UInt64"], "UInt32 or UInt64")?;
        let allowed = "vtkZLibDataCompressor, or none";
        let compressor = one_of("compressor", "", &["", "vtkZLibDataCompressor"], allowed)?;
        let appended = match raw {
            Some(raw) => Some(Source::Raw(raw)),
            None => root.children().find(|node| node.has_tag_name("AppendedData")).map(|node| {
                let text = node.text().unwrap_or_default().trim_start().trim_start_matches('_');
                Source::Base64(text.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect())
            }),
        };
        Ok(Self {
            bytes,
            appended,
            is_big_endian: order == "BigEndian",
            size: if header == "UInt64" { NumberType::U64 } else { NumberType::U32 },
            is_compressed: !compressor.is_empty(),
            left: Cell::new(MODEL_LIMIT),
        })
    }

    /// Whether an array has numbers, of a type that is read.
    pub(super) fn has_numbers(array: Node<'_, '_>) -> bool {
        TYPES.iter().any(|(name, _)| Some(*name) == array.attribute("type"))
    }

    /// Reads as many numbers as are asked for.
    ///
    /// # Errors
    /// The byte and the problem: an unknown type or format, and other than as many numbers.
    pub(super) fn read(&self, array: Node<'_, '_>, wanted: Wanted<'_>) -> Result<Vec<f64>, Located> {
        let at = array.range().start;
        let name = shorten(wanted.name.as_bytes());
        let wrong = |what: &str, found: &str, allowed: &'static str| {
            let entity = format!("{what} of array `{name}`");
            (at, TetMeshProblem::Word { entity, found: shorten(found.as_bytes()), allowed })
        };
        let given = array.attribute("type").unwrap_or_default();
        let of = TYPES.iter().find(|(known, _)| *known == given).map(|(_, of)| *of);
        let of = of.ok_or_else(|| wrong("the type", given, "Int8 to UInt64, Float32 or Float64"))?;
        let inside = || array.first_child().map_or(at..at, |first| first.range());
        let format = array.attribute("format").unwrap_or("ascii");
        let (source, from) = match format {
            "ascii" => {
                let mut words = Words::new(&self.bytes[..inside().end]);
                words.go_to(inside().start);
                return text(&mut words, &name, wanted.count);
            }
            "binary" => {
                let text = &self.bytes[inside()];
                (Source::Base64(text.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).collect()), 0)
            }
            "appended" => {
                let offset = array.attribute("offset").unwrap_or_default();
                let from = offset.parse().map_err(|_| wrong("the offset", offset, "a whole number, 0 or more"))?;
                let none = || wrong("the numbers", "AppendedData is not there", "numbers after the elements");
                (self.appended.clone().ok_or_else(none)?, from)
            }
            _ => return Err(wrong("the format", format, "ascii, binary or appended")),
        };
        let expected = wanted.count.saturating_mul(of.size());
        let bytes =
            if self.is_compressed { self.unpack(&source, from, expected) } else { self.whole(&source, from, expected) };
        let bytes = bytes.map_err(|found| wrong("the numbers", &found, "as many bytes as its numbers have"))?;
        let number = |chunk: &[u8]| {
            let mut bytes = [0; 8];
            bytes.iter_mut().zip(chunk).for_each(|(to, from)| *to = *from);
            if self.is_big_endian {
                bytes[..of.size()].reverse();
            }
            of.of_bytes(&bytes)
        };
        Ok(bytes.chunks_exact(of.size()).map(number).collect())
    }

    /// A size in the bytes of a header.
    fn size_at(&self, header: &[u8], index: usize) -> usize {
        let width = self.size.size();
        let mut bytes = [0; 8];
        bytes.iter_mut().zip(&header[index * width..]).take(width).for_each(|(to, from)| *to = *from);
        if self.is_big_endian {
            bytes[..width].reverse();
        }
        usize::try_from(u64::from_le_bytes(bytes)).unwrap_or(usize::MAX)
    }

    /// Bytes that are not compressed: their number, then themselves.
    fn whole(&self, source: &Source<'_>, from: usize, expected: usize) -> Result<Vec<u8>, String> {
        let width = self.size.size();
        let header = source.stream(from, width).ok_or("the file ends in the size")?;
        let size = self.size_at(&header, 0);
        if size != expected {
            return Err(format!("{size} bytes, and {expected} are needed"));
        }
        let ends = || format!("it ends before {size} bytes");
        // Size and bytes are one stream of base64, unless padding comes between them.
        let is_padded = matches!(source, Source::Base64(text) if text.get(from..from + source.length(width)).is_some_and(|text| text.contains(&b'=')));
        if is_padded || matches!(source, Source::Raw(_)) {
            return source.stream(from + source.length(width), size).ok_or_else(ends);
        }
        let mut both = source.stream(from, width.saturating_add(size)).ok_or_else(ends)?;
        both.drain(..width);
        Ok(both)
    }

    /// Bytes in compressed blocks: the number of blocks, the size of a block and of the last one before compression, the sizes of all after it, then
    /// the blocks.
    fn unpack(&self, source: &Source<'_>, from: usize, expected: usize) -> Result<Vec<u8>, String> {
        let width = self.size.size();
        let first = source.stream(from, width).ok_or("it ends in the number of blocks")?;
        let blocks = self.size_at(&first, 0);
        let length = width.saturating_mul(blocks.saturating_add(3));
        let header = if blocks == 0 { None } else { source.stream(from, length) };
        let Some(header) = header else {
            return if blocks == 0 && expected == 0 {
                Ok(Vec::new())
            } else {
                Err(format!("it ends in the sizes of {blocks} blocks"))
            };
        };
        let (block, last) = (self.size_at(&header, 1), self.size_at(&header, 2));
        let size_of = |index: usize| if index + 1 == blocks && last != 0 { last } else { block };
        let total = block.saturating_mul(blocks - 1).saturating_add(size_of(blocks - 1));
        if total != expected {
            return Err(format!("{total} bytes, and {expected} are needed"));
        }
        let left = self
            .left
            .get()
            .checked_sub(total as u64)
            .ok_or_else(|| format!("more than {MODEL_LIMIT} bytes unpacked"))?;
        self.left.set(left);
        let packed: Vec<usize> = (0..blocks).map(|index| self.size_at(&header, 3 + index)).collect();
        let sum = packed.iter().fold(0_usize, |sum, size| sum.saturating_add(*size));
        let all = source.stream(from + source.length(length), sum).ok_or("it ends before its blocks do")?;
        let (mut bytes, mut begin) = (Vec::new(), 0);
        for (index, packed) in packed.into_iter().enumerate() {
            let before = bytes.len();
            // One more than allowed tells a block that goes on.
            let limit = size_of(index) as u64 + 1;
            let done = ZlibDecoder::new(&all[begin..begin + packed]).take(limit).read_to_end(&mut bytes);
            done.map_err(|error| format!("block {index}: {error}"))?;
            if bytes.len() - before != size_of(index) {
                return Err(format!("block {index} unpacks to other than {} bytes", size_of(index)));
            }
            begin += packed;
        }
        Ok(bytes)
    }
}

/// Numbers as text, no more and no fewer than asked for.
fn text(words: &mut Words<'_>, name: &str, count: usize) -> Result<Vec<f64>, Located> {
    words.encoding = Encoding::Text;
    let mut numbers = Vec::with_capacity(words.capacity(count as u64));
    let entity = format!("a number of array `{name}`");
    for _ in 0..count {
        numbers.push(words.number(&entity, NumberType::F64)?);
    }
    match words.word() {
        None => Ok(numbers),
        Some((more, at)) => {
            let entity = format!("array `{name}` after its {count} numbers");
            Err((at, TetMeshProblem::Word { entity, found: shorten(more), allowed: "its end" }))
        }
    }
}
