//! The datagrams between a host and an exoskeleton, version 1: docs/exoskeleton-protocol.md, in code.
//!
//! Both sides use this one module. Nothing here allocates or panics, whatever the bytes are.

use crate::key::{Key, TAG};
use core::fmt;

/// What every datagram begins with.
pub const MAGIC: [u8; 4] = *b"PLXO";
/// Of the format.
pub const VERSION: u16 = 1;
/// Fingertips.
pub const EFFECTORS: usize = 2;
/// Most taxels of one fingertip: a command still fits into one Ethernet frame.
pub const MOST_TAXELS: usize = 160;
/// Bytes of the longest datagram.
pub const MOST_BYTES: usize = 1472;
/// Bytes before the content.
pub const HEADER: usize = 56;
/// Bytes of the checksum.
const CHECKSUM: usize = 4;
/// Bytes of one pose, and of one command without its taxels.
const POSE: usize = 120;
const FORCE: usize = 24;
/// us, longest a content holds; what says more is taken for this.
pub const MOST_VALID: u32 = 200_000;

const KEYED: u8 = 1;
const STOP: u8 = 2;
const LAST: u8 = 4;

/// Which way a datagram goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From the device: where the fingers are.
    Pose = 1,
    /// From the host: what to render.
    Command = 2,
}

/// Tactile arrays, the same on both fingertips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Along the finger.
    pub rows: u8,
    /// Across it.
    pub columns: u8,
}

impl Layout {
    /// Of one array.
    pub const fn taxels(self) -> usize {
        self.rows as usize * self.columns as usize
    }
}

/// What is in front of the content.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// Drawn anew by the sender for each conversation; never 0.
    pub from: u64,
    /// The receiver's own, as the sender last heard it; 0 before it has.
    pub to: u64,
    /// From 1 on in each conversation.
    pub sequence: u64,
    /// ns, on the sender's clock
    pub time: u64,
    /// us after `time`, how long the content holds
    pub valid: u32,
    /// Command: zero force at once.
    pub stop: bool,
    /// The sender goes.
    pub last: bool,
}

/// One finger, from the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finger {
    /// Bit 0: sensed, bit 1: so was the velocity.
    pub flags: u32,
    /// Bit i is button i.
    pub buttons: u32,
    /// m
    pub position: [f64; 3],
    /// Unit quaternion x y z w.
    pub orientation: [f64; 4],
    /// m/s
    pub velocity: [f64; 3],
    /// N, what is rendered now
    pub force: [f64; 3],
    /// N, sum of the taxels rendered now
    pub touch: f64,
}

impl Default for Finger {
    fn default() -> Self {
        Self {
            flags: 0,
            buttons: 0,
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            velocity: [0.0; 3],
            force: [0.0; 3],
            touch: 0.0,
        }
    }
}

/// What one finger is to feel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feel {
    /// N, on the hand
    pub force: [f64; 3],
    /// N (rows x columns), then zeros
    pub taxels: [f32; MOST_TAXELS],
}

impl Default for Feel {
    fn default() -> Self {
        Self { force: [0.0; 3], taxels: [0.0; MOST_TAXELS] }
    }
}

/// Why a datagram is not obeyed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// Shorter or longer than its kind.
    Length,
    /// Not one of ours.
    Magic,
    /// Another version.
    Version,
    /// Of the other direction, or bits that mean nothing.
    Kind,
    /// Another number of fingertips or taxels.
    Layout,
    /// Its bytes changed on the way.
    Checksum,
    /// Without the key, or with a key where there is none.
    Key,
    /// A number that is not finite, or an orientation that is none.
    Value,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Length => "length",
            Self::Magic => "magic",
            Self::Version => "version",
            Self::Kind => "kind",
            Self::Layout => "layout",
            Self::Checksum => "checksum",
            Self::Key => "key",
            Self::Value => "value",
        })
    }
}

/// A datagram as it is made.
struct Writer<'a> {
    bytes: &'a mut [u8; MOST_BYTES],
    at: usize,
}

impl Writer<'_> {
    fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        self.bytes[self.at..self.at + N].copy_from_slice(&bytes);
        self.at += N;
    }

    fn numbers(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|n| self.put(n.to_le_bytes()));
    }

    fn header(&mut self, kind: Kind, layout: Layout, header: &Header, key: Option<&Key>) {
        let flag = |on: bool, bit: u8| if on { bit } else { 0 };
        self.put(MAGIC);
        self.put(VERSION.to_le_bytes());
        let flags = flag(key.is_some(), KEYED) | flag(header.stop, STOP) | flag(header.last, LAST);
        self.put([kind as u8, flags, EFFECTORS as u8, layout.rows, layout.columns, 0]);
        self.put((length(kind, layout, key.is_some()) as u32).to_le_bytes());
        for word in [header.from, header.to, header.sequence, header.time] {
            self.put(word.to_le_bytes());
        }
        self.put(header.valid.to_le_bytes());
        self.put([0; 4]);
    }

    /// Checksum and tag; gives the length.
    fn seal(mut self, key: Option<&Key>) -> usize {
        let sum = crc32fast::hash(&self.bytes[..self.at]);
        self.put(sum.to_le_bytes());
        if let Some(key) = key {
            let tag = key.tag(&self.bytes[..self.at]);
            self.put(tag);
        }
        self.at
    }
}

/// Bytes of a datagram.
pub const fn length(kind: Kind, layout: Layout, keyed: bool) -> usize {
    let one = match kind {
        Kind::Pose => POSE,
        Kind::Command => FORCE + 4 * layout.taxels(),
    };
    HEADER + EFFECTORS * one + CHECKSUM + if keyed { TAG } else { 0 }
}

/// Writes poses; gives how many bytes.
pub fn write_pose(
    bytes: &mut [u8; MOST_BYTES],
    layout: Layout,
    header: &Header,
    fingers: &[Finger; EFFECTORS],
    key: Option<&Key>,
) -> usize {
    let mut w = Writer { bytes, at: 0 };
    w.header(Kind::Pose, layout, header, key);
    for finger in fingers {
        w.put(finger.flags.to_le_bytes());
        w.put(finger.buttons.to_le_bytes());
        w.numbers(&finger.position);
        w.numbers(&finger.orientation);
        w.numbers(&finger.velocity);
        w.numbers(&finger.force);
        w.numbers(&[finger.touch]);
    }
    w.seal(key)
}

/// Writes a command; gives how many bytes.
pub fn write_command(
    bytes: &mut [u8; MOST_BYTES],
    layout: Layout,
    header: &Header,
    feels: &[Feel; EFFECTORS],
    key: Option<&Key>,
) -> usize {
    let mut w = Writer { bytes, at: 0 };
    w.header(Kind::Command, layout, header, key);
    for feel in feels {
        w.numbers(&feel.force);
        feel.taxels[..layout.taxels().min(MOST_TAXELS)].iter().for_each(|t| w.put(t.to_le_bytes()));
    }
    w.seal(key)
}

/// Bytes that were checked to be there.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut out = [0; N];
        if let Some(bytes) = self.bytes.get(self.at..self.at + N) {
            out.copy_from_slice(bytes);
        }
        self.at += N;
        out
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn number(&mut self) -> Result<f64, Refused> {
        let number = f64::from_le_bytes(self.take());
        if number.is_finite() { Ok(number) } else { Err(Refused::Value) }
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], Refused> {
        let mut out = [0.0; N];
        for number in &mut out {
            *number = self.number()?;
        }
        Ok(out)
    }
}

/// Everything but the content: length, magic, version, kind, layout, checksum, key, in this order.
fn open<'a>(bytes: &'a [u8], kind: Kind, layout: Layout, key: Option<&Key>) -> Result<(Header, Reader<'a>), Refused> {
    if bytes.len() < HEADER + CHECKSUM || bytes.len() > MOST_BYTES {
        return Err(Refused::Length);
    }
    let mut r = Reader { bytes, at: 0 };
    if r.take() != MAGIC {
        return Err(Refused::Magic);
    }
    if u16::from_le_bytes(r.take()) != VERSION {
        return Err(Refused::Version);
    }
    let [found, flags, effectors, rows, columns, zero] = r.take();
    if found != kind as u8 || flags & !(KEYED | STOP | LAST) != 0 || zero != 0 {
        return Err(Refused::Kind);
    }
    if (effectors as usize, rows, columns) != (EFFECTORS, layout.rows, layout.columns) {
        return Err(Refused::Layout);
    }
    let keyed = flags & KEYED != 0;
    if r.u32() as usize != bytes.len() || bytes.len() != length(kind, layout, keyed) {
        return Err(Refused::Length);
    }
    let end = bytes.len() - CHECKSUM - if keyed { TAG } else { 0 };
    if crc32fast::hash(&bytes[..end]).to_le_bytes() != bytes[end..end + CHECKSUM] {
        return Err(Refused::Checksum);
    }
    match (keyed, key) {
        (false, None) => {}
        (true, Some(key)) if key.is_tag(&bytes[..end + CHECKSUM], &bytes[end + CHECKSUM..]) => {}
        _ => return Err(Refused::Key),
    }
    let header = Header {
        from: r.u64(),
        to: r.u64(),
        sequence: r.u64(),
        time: r.u64(),
        valid: r.u32().min(MOST_VALID),
        stop: flags & STOP != 0,
        last: flags & LAST != 0,
    };
    if r.u32() != 0 || header.from == 0 || header.sequence == 0 {
        return Err(Refused::Kind);
    }
    Ok((header, r))
}

/// Reads poses.
///
/// # Errors
/// Why it is not obeyed.
pub fn read_pose(bytes: &[u8], layout: Layout, key: Option<&Key>) -> Result<(Header, [Finger; EFFECTORS]), Refused> {
    let (header, mut r) = open(bytes, Kind::Pose, layout, key)?;
    let mut fingers = [Finger::default(); EFFECTORS];
    for finger in &mut fingers {
        (finger.flags, finger.buttons) = (r.u32(), r.u32());
        finger.position = r.numbers()?;
        finger.orientation = r.numbers()?;
        finger.velocity = r.numbers()?;
        finger.force = r.numbers()?;
        finger.touch = r.number()?;
        let size: f64 = finger.orientation.iter().map(|q| q * q).sum();
        if (size - 1.0).abs() > 1e-6 {
            return Err(Refused::Value);
        }
    }
    Ok((header, fingers))
}

/// Reads a command.
///
/// # Errors
/// Why it is not obeyed.
pub fn read_command(bytes: &[u8], layout: Layout, key: Option<&Key>) -> Result<(Header, [Feel; EFFECTORS]), Refused> {
    let (header, mut r) = open(bytes, Kind::Command, layout, key)?;
    let mut feels = [Feel::default(); EFFECTORS];
    for feel in &mut feels {
        feel.force = r.numbers()?;
        for taxel in &mut feel.taxels[..layout.taxels().min(MOST_TAXELS)] {
            *taxel = f32::from_le_bytes(r.take());
            if !taxel.is_finite() {
                return Err(Refused::Value);
            }
        }
    }
    Ok((header, feels))
}
