//! Writing datagrams.

use super::{
    DatagramKind, EFFECTOR_COUNT, FingerCommand, FingerState, Header, MAGIC, MAX_DATAGRAM_BYTES, MAX_TAXELS,
    TaxelLayout, VERSION, datagram_bytes, flag,
};
use crate::key::Key;

/// A datagram that is written from its start.
struct Writer<'a> {
    /// Buffer that receives the datagram.
    bytes: &'a mut [u8; MAX_DATAGRAM_BYTES],
    /// Number of bytes written.
    length: usize,
}

impl Writer<'_> {
    /// Appends N bytes to the datagram.
    fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        self.bytes[self.length..self.length + N].copy_from_slice(&bytes);
        self.length += N;
    }

    /// Appends numbers, little-endian.
    fn numbers(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|n| self.put(n.to_le_bytes()));
    }

    /// Appends the fields before the content.
    fn header(&mut self, kind: DatagramKind, layout: TaxelLayout, header: &Header, key: Option<&Key>) {
        let bit = |on: bool, bit: u8| if on { bit } else { 0 };
        self.put(MAGIC);
        self.put(VERSION.to_le_bytes());
        let flags = bit(key.is_some(), flag::KEYED) | bit(header.stop, flag::STOP) | bit(header.last, flag::LAST);
        self.put([kind as u8, flags, EFFECTOR_COUNT as u8, layout.rows, layout.columns, 0]);
        self.put((datagram_bytes(kind, layout, key.is_some()) as u32).to_le_bytes());
        for word in [header.sender_nonce, header.receiver_nonce, header.sequence, header.time_ns] {
            self.put(word.to_le_bytes());
        }
        self.put(header.valid_us.to_le_bytes());
        self.put([0; 4]);
    }

    /// Appends the checksum and the tag. Returns the length of the datagram.
    fn finish(mut self, key: Option<&Key>) -> usize {
        let checksum = crc32fast::hash(&self.bytes[..self.length]);
        self.put(checksum.to_le_bytes());
        if let Some(key) = key {
            let tag = key.tag(&self.bytes[..self.length]);
            self.put(tag);
        }
        self.length
    }
}

/// Writes a pose datagram. Returns its length.
pub fn write_pose(
    bytes: &mut [u8; MAX_DATAGRAM_BYTES],
    layout: TaxelLayout,
    header: &Header,
    fingers: &[FingerState; EFFECTOR_COUNT],
    key: Option<&Key>,
) -> usize {
    let mut writer = Writer { bytes, length: 0 };
    writer.header(DatagramKind::Pose, layout, header, key);
    for finger in fingers {
        writer.put(finger.flags.to_le_bytes());
        writer.put(finger.buttons.to_le_bytes());
        writer.numbers(&finger.position);
        writer.numbers(&finger.orientation);
        writer.numbers(&finger.velocity);
        writer.numbers(&finger.force);
        writer.numbers(&[finger.taxel_force_sum]);
    }
    writer.finish(key)
}

/// Writes a command datagram. Returns its length.
pub fn write_command(
    bytes: &mut [u8; MAX_DATAGRAM_BYTES],
    layout: TaxelLayout,
    header: &Header,
    fingers: &[FingerCommand; EFFECTOR_COUNT],
    key: Option<&Key>,
) -> usize {
    let mut writer = Writer { bytes, length: 0 };
    writer.header(DatagramKind::Command, layout, header, key);
    for finger in fingers {
        writer.numbers(&finger.force);
        finger.taxels[..layout.taxel_count().min(MAX_TAXELS)].iter().for_each(|t| writer.put(t.to_le_bytes()));
    }
    writer.finish(key)
}
