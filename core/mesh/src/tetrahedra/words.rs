//! A cursor over the words of a text file, and over the numbers of text or binary parts of it.

use super::error::TetMeshProblem;

/// A problem, after the byte of the file at which it is.
pub(super) type Located = (usize, TetMeshProblem);

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Decimal numbers between blanks.
    Text,
    /// Numbers of 4 and 8 bytes, the least significant byte first.
    LittleEndian,
    /// Numbers of 4 and 8 bytes, the most significant byte first.
    BigEndian,
}

/// Types of the numbers of arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl NumberType {
    /// Size, bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number in bytes, of [`NumberType::size`] or more, the least significant first. Whole numbers of 8 bytes are rounded.
    pub(super) fn of_bytes(self, bytes: &[u8]) -> f64 {
        let mut all = [0; 8];
        all.iter_mut().zip(&bytes[..self.size().min(bytes.len())]).for_each(|(to, from)| *to = *from);
        let bits = u64::from_le_bytes(all);
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as i16),
            Self::U16 => f64::from(bits as u16),
            Self::I32 => f64::from(bits as i32),
            Self::U32 => f64::from(bits as u32),
            Self::I64 => bits as i64 as f64,
            Self::U64 => bits as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}

/// A position in the bytes of a file.
#[derive(Clone, Debug)]
pub(super) struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    /// How the numbers from here on are written.
    pub(super) encoding: Encoding,
}

/// Line, from 1, of the byte at `at`.
pub(super) fn line_at(bytes: &[u8], at: usize) -> u32 {
    1 + bytes[..at.min(bytes.len())].iter().filter(|byte| **byte == b'\n').count() as u32
}

/// A word for messages, truncated.
pub(super) fn shorten(word: &[u8]) -> String {
    const MOST: usize = 40; // characters
    let text = String::from_utf8_lossy(&word[..word.len().min(4 * MOST)]);
    let mut short: String = text.chars().take(MOST).collect();
    if text.chars().count() > MOST {
        short.push('…');
    }
    short
}

impl<'a> Words<'a> {
    /// A cursor at the first byte; numbers are text.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, encoding: Encoding::Text }
    }

    /// Position of the cursor, bytes from the start of the file.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// Number of bytes that are left.
    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next word with its place; `None` at the end of the file.
    pub(super) fn word(&mut self) -> Option<(&'a [u8], usize)> {
        let start = self.at + self.bytes[self.at..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let length = self.bytes[start..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        self.at = start + length;
        (length > 0).then(|| (&self.bytes[start..self.at], start))
    }

    /// The next word, which must be there.
    ///
    /// # Errors
    /// The end of the file.
    pub(super) fn expect(&mut self, entity: &str) -> Result<(&'a [u8], usize), Located> {
        let end = self.bytes.len();
        self.word().ok_or_else(|| (end, TetMeshProblem::Ends { entity: entity.into() }))
    }

    /// The rest of the line without its end; the cursor is at the next line after it.
    pub(super) fn line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        rest[..length].strip_suffix(b"\r").unwrap_or(&rest[..length])
    }

    /// Moves behind the next `text`. Returns whether there is one.
    pub(super) fn skip_past(&mut self, text: &[u8]) -> bool {
        let found = self.bytes[self.at..].windows(text.len()).position(|window| window == text);
        self.at = found.map_or(self.bytes.len(), |found| self.at + found + text.len());
        found.is_some()
    }

    /// The next `count` bytes.
    fn take(&mut self, count: usize, entity: &str) -> Result<&'a [u8], Located> {
        let rest = &self.bytes[self.at..];
        if rest.len() < count {
            return Err((self.bytes.len(), TetMeshProblem::Ends { entity: entity.into() }));
        }
        self.at += count;
        Ok(&rest[..count])
    }

    /// Skips `count` bytes of a binary part.
    ///
    /// # Errors
    /// The end of the file.
    pub(super) fn skip_bytes(&mut self, count: usize, entity: &str) -> Result<(), Located> {
        self.take(count, entity).map(drop)
    }

    /// The next eight bytes of a binary part as a number.
    fn eight(&mut self, entity: &str) -> Result<u64, Located> {
        let bytes = self.take(8, entity)?.try_into().unwrap_or_default();
        Ok(if self.encoding == Encoding::BigEndian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
    }

    /// The next four bytes of a binary part as a number.
    fn four(&mut self, entity: &str) -> Result<u32, Located> {
        let bytes = self.take(4, entity)?.try_into().unwrap_or_default();
        Ok(if self.encoding == Encoding::BigEndian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// The next word as a value that `parse` makes of it.
    fn parsed<T>(
        &mut self,
        entity: &str,
        allowed: &'static str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<T, Located> {
        let (word, at) = self.expect(entity)?;
        let value = std::str::from_utf8(word).ok().and_then(parse);
        value.ok_or_else(|| (at, TetMeshProblem::Word { entity: entity.into(), found: shorten(word), allowed }))
    }

    /// A whole number, 0 or more: 8 bytes in a binary part.
    ///
    /// # Errors
    /// The end of the file and another word.
    pub(super) fn size(&mut self, entity: &str) -> Result<u64, Located> {
        match self.encoding {
            Encoding::Text => self.parsed(entity, "a whole number, 0 or more", |word| word.parse().ok()),
            Encoding::LittleEndian | Encoding::BigEndian => self.eight(entity),
        }
    }

    /// A whole number: 4 bytes in a binary part.
    ///
    /// # Errors
    /// The end of the file and another word.
    pub(super) fn int(&mut self, entity: &str) -> Result<i32, Located> {
        match self.encoding {
            Encoding::Text => self.parsed(entity, "a whole number", |word| word.parse().ok()),
            Encoding::LittleEndian | Encoding::BigEndian => Ok(self.four(entity)? as i32),
        }
    }

    /// A whole number, 0 or more, of 4 bytes in a binary part.
    ///
    /// # Errors
    /// The end of the file and another word.
    pub(super) fn count(&mut self, entity: &str) -> Result<u64, Located> {
        let at = self.at;
        let number = match self.encoding {
            Encoding::Text => return self.size(entity),
            Encoding::LittleEndian | Encoding::BigEndian => self.int(entity)?,
        };
        u64::try_from(number).map_err(|_| {
            let (entity, found) = (entity.into(), number.to_string());
            (at, TetMeshProblem::Word { entity, found, allowed: "a whole number, 0 or more" })
        })
    }

    /// A finite number: 8 bytes in a binary part, or 4 if `is_single`.
    ///
    /// # Errors
    /// The end of the file, another word, and a number that is not finite.
    pub(super) fn real(&mut self, entity: &str, is_single: bool) -> Result<f64, Located> {
        const ALLOWED: &str = "a finite number";
        let at = self.at;
        let value = match (self.encoding, is_single) {
            (Encoding::Text, _) => {
                return self.parsed(entity, ALLOWED, |word| word.parse().ok().filter(|value: &f64| value.is_finite()));
            }
            (_, true) => f64::from(f32::from_bits(self.four(entity)?)),
            (_, false) => f64::from_bits(self.eight(entity)?),
        };
        let wrong = || (at, TetMeshProblem::Word { entity: entity.into(), found: value.to_string(), allowed: ALLOWED });
        if value.is_finite() { Ok(value) } else { Err(wrong()) }
    }

    /// A number of type `of`, which may be infinite or NaN: arrays are read before it is known whether a scene uses them.
    ///
    /// # Errors
    /// The end of the file and another word.
    pub(super) fn number(&mut self, entity: &str, of: NumberType) -> Result<f64, Located> {
        if self.encoding == Encoding::Text {
            return self.parsed(entity, "a number", |word| word.parse().ok());
        }
        let mut bytes = [0; 8];
        let taken = self.take(of.size(), entity)?;
        bytes.iter_mut().zip(taken).for_each(|(to, from)| *to = *from);
        if self.encoding == Encoding::BigEndian {
            bytes[..of.size()].reverse();
        }
        Ok(of.of_bytes(&bytes))
    }

    /// A text in quotes, on one line.
    ///
    /// # Errors
    /// The end of the file and another word.
    pub(super) fn quoted(&mut self, entity: &str) -> Result<String, Located> {
        let (word, at) = self.expect(entity)?;
        let rest = &self.bytes[at..];
        let length = rest.iter().skip(1).position(|byte| *byte == b'"' || *byte == b'\n');
        match length.filter(|length| rest[0] == b'"' && rest[length + 1] == b'"') {
            Some(length) => {
                self.at = at + length + 2;
                Ok(String::from_utf8_lossy(&rest[1..=length]).into_owned())
            }
            None => {
                let (entity, allowed) = (entity.into(), "a text in quotes on one line");
                Err((at, TetMeshProblem::Word { entity, found: shorten(word), allowed }))
            }
        }
    }

    /// Moves the cursor to a byte of the file.
    pub(super) fn go_to(&mut self, at: usize) {
        self.at = at.min(self.bytes.len());
    }

    /// Moves to the end of the file.
    pub(super) fn go_to_end(&mut self) {
        self.at = self.bytes.len();
    }

    /// Three finite numbers, as [`Words::real`].
    ///
    /// # Errors
    /// Those of [`Words::real`].
    pub(super) fn point(&mut self, entity: &str, is_single: bool) -> Result<[f64; 3], Located> {
        let mut point = [0.0; 3];
        for coordinate in &mut point {
            *coordinate = self.real(entity, is_single)?;
        }
        Ok(point)
    }

    /// `count` as a capacity, but no more than the bytes that are left can hold: a count in a file is a claim.
    pub(super) fn capacity(&self, count: u64) -> usize {
        usize::try_from(count).unwrap_or(usize::MAX).min(self.left() / 2)
    }
}
