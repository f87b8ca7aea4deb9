//! Reading datagrams, after checking everything in them.

use super::{
    CHECKSUM_BYTES, DatagramKind, EFFECTOR_COUNT, FingerCommand, FingerState, HEADER_BYTES, Header, MAGIC,
    MAX_DATAGRAM_BYTES, MAX_TAXELS, MAX_VALID_US, Rejection, TaxelLayout, VERSION, datagram_bytes, flag,
};
use crate::key::{Key, TAG_BYTES};

/// Largest deviation of the squared norm of an orientation from 1.
const UNIT_TOLERANCE: f64 = 1e-6;

/// A datagram that is read from its start.
struct Reader<'a> {
    /// Bytes of the whole datagram.
    bytes: &'a [u8],
    /// Number of bytes read.
    offset: usize,
}

impl Reader<'_> {
    /// The next N bytes; zeros after the end.
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut out = [0; N];
        if let Some(bytes) = self.bytes.get(self.offset..self.offset + N) {
            out.copy_from_slice(bytes);
        }
        self.offset += N;
        out
    }

    /// The next number, little-endian.
    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    /// The next number, little-endian.
    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    /// The next number, which must be finite.
    fn number(&mut self) -> Result<f64, Rejection> {
        let number = f64::from_le_bytes(self.take());
        if number.is_finite() { Ok(number) } else { Err(Rejection::Value) }
    }

    /// The next N numbers, which must be finite.
    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], Rejection> {
        let mut out = [0.0; N];
        for number in &mut out {
            *number = self.number()?;
        }
        Ok(out)
    }
}

/// Checks everything but the content, and returns the header and a reader at the content.
fn read_header<'a>(
    bytes: &'a [u8],
    kind: DatagramKind,
    layout: TaxelLayout,
    key: Option<&Key>,
) -> Result<(Header, Reader<'a>), Rejection> {
    if bytes.len() < HEADER_BYTES + CHECKSUM_BYTES || bytes.len() > MAX_DATAGRAM_BYTES {
        return Err(Rejection::Length);
    }
    let mut reader = Reader { bytes, offset: 0 };
    if reader.take() != MAGIC {
        return Err(Rejection::Magic);
    }
    if u16::from_le_bytes(reader.take()) != VERSION {
        return Err(Rejection::Version);
    }
    let [kind_byte, flags, effectors, rows, columns, reserved] = reader.take();
    if kind_byte != kind as u8 || flags & !(flag::KEYED | flag::STOP | flag::LAST) != 0 || reserved != 0 {
        return Err(Rejection::Kind);
    }
    if (effectors as usize, rows, columns) != (EFFECTOR_COUNT, layout.rows, layout.columns) {
        return Err(Rejection::Layout);
    }
    let keyed = flags & flag::KEYED != 0;
    if reader.u32() as usize != bytes.len() || bytes.len() != datagram_bytes(kind, layout, keyed) {
        return Err(Rejection::Length);
    }
    let end = bytes.len() - CHECKSUM_BYTES - if keyed { TAG_BYTES } else { 0 };
    if crc32fast::hash(&bytes[..end]).to_le_bytes() != bytes[end..end + CHECKSUM_BYTES] {
        return Err(Rejection::Checksum);
    }
    let (tagged, tag) = bytes.split_at(end + CHECKSUM_BYTES);
    match (keyed, key) {
        (false, None) => {}
        (true, Some(key)) if key.verify(tagged, tag) => {}
        (false, Some(_)) | (true, None | Some(_)) => return Err(Rejection::Key),
    }
    let header = Header {
        sender_nonce: reader.u64(),
        receiver_nonce: reader.u64(),
        sequence: reader.u64(),
        time_ns: reader.u64(),
        valid_us: reader.u32().min(MAX_VALID_US),
        stop: flags & flag::STOP != 0,
        last: flags & flag::LAST != 0,
    };
    if reader.u32() != 0 || header.sender_nonce == 0 || header.sequence == 0 {
        return Err(Rejection::Kind);
    }
    Ok((header, reader))
}

/// Reads a pose datagram.
///
/// # Errors
/// The first check that fails.
pub fn read_pose(
    bytes: &[u8],
    layout: TaxelLayout,
    key: Option<&Key>,
) -> Result<(Header, [FingerState; EFFECTOR_COUNT]), Rejection> {
    let (header, mut reader) = read_header(bytes, DatagramKind::Pose, layout, key)?;
    let mut fingers = [FingerState::default(); EFFECTOR_COUNT];
    for finger in &mut fingers {
        finger.flags = reader.u32();
        finger.buttons = reader.u32();
        finger.position = reader.numbers()?;
        finger.orientation = reader.numbers()?;
        finger.velocity = reader.numbers()?;
        finger.force = reader.numbers()?;
        finger.taxel_force_sum = reader.number()?;
        let squared_norm: f64 = finger.orientation.iter().map(|q| q * q).sum();
        if (squared_norm - 1.0).abs() > UNIT_TOLERANCE {
            return Err(Rejection::Value);
        }
    }
    Ok((header, fingers))
}

/// Reads a command datagram.
///
/// # Errors
/// The first check that fails.
pub fn read_command(
    bytes: &[u8],
    layout: TaxelLayout,
    key: Option<&Key>,
) -> Result<(Header, [FingerCommand; EFFECTOR_COUNT]), Rejection> {
    let (header, mut reader) = read_header(bytes, DatagramKind::Command, layout, key)?;
    let mut fingers = [FingerCommand::default(); EFFECTOR_COUNT];
    for finger in &mut fingers {
        finger.force = reader.numbers()?;
        for taxel in &mut finger.taxels[..layout.taxel_count().min(MAX_TAXELS)] {
            *taxel = f32::from_le_bytes(reader.take());
            if !taxel.is_finite() {
                return Err(Rejection::Value);
            }
        }
    }
    Ok((header, fingers))
}
