//! Walks the bytes of an OBJ file by lines and tokens.
//!
//! A line may go on over a `\` at its end, except a comment: a comment that ends in a Windows path is more common than
//! one that means to go on. Files without a single line feed are taken to end their lines with a carriage return.

use super::number;

/// A place in the bytes, and the line it is on.
#[derive(Clone, Debug)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize, // byte offset
    line: u32, // from 1
    line_end: u8,
}

impl<'a> Cursor<'a> {
    /// At the first line, behind the byte order mark if there is one.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let line_end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
        Self { bytes, at, line: 1, line_end }
    }

    pub(super) fn at(&self) -> usize {
        self.at
    }

    pub(super) fn line(&self) -> u32 {
        self.line
    }

    /// The line that holds byte `at`.
    pub(super) fn line_at(&self, at: usize) -> u32 {
        1 + self.bytes[..at].iter().filter(|&&byte| byte == self.line_end).count() as u32
    }

    /// The same file at byte `at`. Its line number starts anew.
    pub(super) fn moved_to(&self, at: usize) -> Self {
        Self { at, line: 1, ..self.clone() }
    }

    /// Goes to the first byte of the next line that has one; `false` at the end of the file.
    pub(super) fn next_line(&mut self) -> bool {
        while !self.skip_blanks() {
            if self.at == self.bytes.len() {
                return false;
            }
            self.at += 1;
            self.line += 1;
        }
        true
    }

    /// Goes past blanks and continued line ends; `false` when the line ends there.
    pub(super) fn skip_blanks(&mut self) -> bool {
        while let Some(&byte) = self.bytes.get(self.at) {
            if byte == self.line_end {
                return false;
            } else if is_blank(byte) {
                self.at += 1;
            } else if byte == b'\\' && self.continuation() > 0 {
                self.at += self.continuation();
                self.line += 1;
            } else {
                return true;
            }
        }
        false
    }

    /// As [`Self::skip_blanks`], and a comment ends the data of a line too.
    pub(super) fn skip_to_data(&mut self) -> bool {
        self.skip_blanks() && self.bytes[self.at] != b'#'
    }

    /// The token here, which may be empty; goes past it.
    pub(super) fn token(&mut self) -> &'a [u8] {
        let start = self.at;
        while !self.at_boundary() {
            self.at += 1;
        }
        &self.bytes[start..self.at]
    }

    /// The finite number here, or the token that is none; goes past it.
    pub(super) fn number(&mut self) -> Result<f64, &'a [u8]> {
        let start = self.at;
        if let Some((value, length)) = number::exact_prefix(&self.bytes[start..]) {
            self.at += length;
            if self.at_boundary() {
                return Ok(value);
            }
            self.at = start;
        }
        let token = self.token();
        number::parse(token).ok_or(token)
    }

    /// The rest of the line with its continuations; goes to the line end.
    pub(super) fn rest(&mut self) -> &'a [u8] {
        let start = self.at;
        while self.skip_blanks() {
            self.token();
        }
        &self.bytes[start..self.at]
    }

    /// Goes to the line end and takes a `\` before it for text.
    pub(super) fn skip_comment(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|&byte| byte == self.line_end).unwrap_or(rest.len());
    }

    #[inline]
    fn at_boundary(&self) -> bool {
        match self.bytes.get(self.at) {
            None => true,
            Some(b'\\') => self.continuation() > 0,
            Some(&byte) => byte == self.line_end || is_blank(byte),
        }
    }

    /// Length of the `\` here with the line end it hides; 0 when it hides none.
    fn continuation(&self) -> usize {
        match self.bytes[self.at + 1..] {
            [byte, ..] if byte == self.line_end => 2,
            [b'\r', b'\n', ..] => 3,
            _ => 0,
        }
    }
}

#[inline]
fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | 0x0b | 0x0c)
}
