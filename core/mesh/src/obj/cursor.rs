//! Cursor over the bytes of an OBJ file, by lines and tokens.
//!
//! A `\` at the end of a line continues it, except in a comment, where it is more likely the end of a Windows path. In files without line feeds, lines end with a
//! carriage return.

use super::number;

/// A position in the bytes, with its line.
#[derive(Clone, Debug)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize, // byte offset
    line: u32, // from 1
    line_end: u8,
}

impl<'a> Cursor<'a> {
    /// A cursor at the first line, after the byte order mark if there is one.
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

    /// The line of the byte at `at`.
    pub(super) fn line_at(&self, at: usize) -> u32 {
        1 + self.bytes[..at].iter().filter(|&&byte| byte == self.line_end).count() as u32
    }

    /// A cursor of the same file at the byte `at`, whose line count starts at 1.
    pub(super) fn moved_to(&self, at: usize) -> Self {
        Self { at, line: 1, ..self.clone() }
    }

    /// Moves to the next line that is not empty. Returns false at the end of the file.
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

    /// Skips blanks and continued line ends. Returns false at the end of the line.
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

    /// Like [`Self::skip_blanks`], but a comment also ends the data of a line.
    pub(super) fn skip_to_data(&mut self) -> bool {
        self.skip_blanks() && self.bytes[self.at] != b'#'
    }

    /// Reads the next token, which may be empty.
    pub(super) fn token(&mut self) -> &'a [u8] {
        let start = self.at;
        while !self.at_boundary() {
            self.at += 1;
        }
        &self.bytes[start..self.at]
    }

    /// Reads a finite number; returns the token as the error if it is none.
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

    /// Reads the rest of the line including its continuations.
    pub(super) fn rest(&mut self) -> &'a [u8] {
        let start = self.at;
        while self.skip_blanks() {
            self.token();
        }
        &self.bytes[start..self.at]
    }

    /// Skips to the end of the line, ignoring a `\` before it.
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

    /// Length of a `\` with the line end it continues; 0 if there is none here.
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
