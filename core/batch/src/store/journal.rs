//! Format of journals: append-only files of checksummed records, one on each line.
//!
//! A line is the CRC-32 of the record's JSON in eight hexadecimal digits, a space, and the JSON. Reading stops at the first line that is truncated
//! or does not match its checksum; the rest of the file is ignored.

use super::records::Record;
use std::io;

/// The line of a record.
pub(super) fn line(record: &Record) -> io::Result<Vec<u8>> {
    let json = serde_json::to_string(record)?;
    Ok(format!("{:08x} {json}\n", crc32fast::hash(json.as_bytes())).into_bytes())
}

/// The valid part of a journal.
pub(crate) struct ParsedJournal {
    /// Records in the order they were written.
    pub(crate) records: Vec<Record>,
    /// Its length, bytes.
    pub(crate) length: u64,
}

/// Parses a journal.
pub(crate) fn parse_journal(bytes: &[u8]) -> ParsedJournal {
    let mut records = Vec::new();
    let mut length = 0;
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        let Some(record) = parse_line(line) else { break };
        records.push(record);
        length += line.len() as u64;
    }
    ParsedJournal { records, length }
}

/// The record of a line; `None` if the line is invalid.
fn parse_line(line: &[u8]) -> Option<Record> {
    let line = line.strip_suffix(b"\n")?;
    let (crc, json) = (line.get(..8)?, line.get(9..)?);
    let crc = u32::from_str_radix(std::str::from_utf8(crc).ok()?, 16).ok()?;
    if line[8] != b' ' || crc32fast::hash(json) != crc {
        return None;
    }
    serde_json::from_slice(json).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_journal_cut_anywhere_gives_the_records_that_are_whole() {
        let begin = |edit| Record::Begin { edit, attempt: 1 };
        let lines: Vec<Vec<u8>> = (0..5).map(|edit| line(&begin(edit)).unwrap()).collect();
        let whole = lines.concat();
        for cut in 0..=whole.len() {
            let ParsedJournal { records: found, length: valid } = parse_journal(&whole[..cut]);
            let ends = lines.iter().scan(0, |end, line| {
                *end += line.len();
                Some(*end)
            });
            let expected = ends.take_while(|end| *end <= cut).last().unwrap_or(0);
            assert_eq!(valid as usize, expected, "cut at {cut}");
            assert_eq!(found.len(), valid as usize / lines[0].len());
        }
    }

    #[test]
    fn a_flipped_bit_ends_a_journal() {
        let lines: Vec<u8> = (0..3).flat_map(|edit| line(&Record::Begin { edit, attempt: 1 }).unwrap()).collect();
        let one = lines.len() / 3;
        for at in one..2 * one {
            let mut broken = lines.clone();
            broken[at] ^= 1;
            assert_eq!(parse_journal(&broken).length as usize, one, "byte {at}");
        }
    }
}
