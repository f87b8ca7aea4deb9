//! The datagrams between the host and an exoskeleton, version 1. docs/exoskeleton-protocol.md describes the format byte by byte.
//!
//! The plugin and its twin both use this module. Nothing here allocates, and nothing panics, whatever the bytes are.

mod read;
mod write;

pub use read::{read_command, read_pose};
pub use write::{write_command, write_pose};

use crate::key::TAG_BYTES;
use crate::receiver::ReceiveCounts;

/// First bytes of every datagram.
pub const MAGIC: [u8; 4] = *b"PLXO";
/// Version of the format.
pub const VERSION: u16 = 1;
/// Number of fingertips: index, then thumb.
pub const EFFECTOR_COUNT: usize = 2;
/// Most taxels of one fingertip: with them, two fingertips, a key and the checksum, a command still fits into one Ethernet frame.
pub const MAX_TAXELS: usize = 160;
/// Bytes of the longest datagram: the payload of an Ethernet frame less the IP and UDP headers.
pub const MAX_DATAGRAM_BYTES: usize = 1472;
/// Bytes of a datagram before its content.
pub const HEADER_BYTES: usize = 56;
/// Offset of the sequence number in a datagram, bytes.
pub const SEQUENCE_OFFSET: usize = 32;
/// Bytes of the checksum.
const CHECKSUM_BYTES: usize = 4;
/// Bytes of one finger in a pose datagram.
const POSE_BYTES: usize = 120;
/// Bytes of the force of one finger in a command datagram; its taxels follow, 4 bytes each.
const FORCE_BYTES: usize = 24;
/// Longest time a content is valid, us; a datagram that claims more counts as this.
pub const MAX_VALID_US: u32 = 200_000;

/// Bit of [`FingerState::flags`]: position and orientation were sensed.
pub const FINGER_SENSED: u32 = 1;
/// Bit of [`FingerState::flags`]: the velocity was sensed.
pub const FINGER_VELOCITY: u32 = 2;

/// Bits of the flags byte of a datagram.
mod flag {
    /// An authentication tag follows the checksum.
    pub const KEYED: u8 = 1;
    /// Bit of [`super::Header::stop`].
    pub const STOP: u8 = 2;
    /// Bit of [`super::Header::last`].
    pub const LAST: u8 = 4;
}

/// Kind of a datagram's content. The values are those of the kind byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DatagramKind {
    /// The state of the fingers, from the device.
    Pose = 1,
    /// What to render, from the host.
    Command = 2,
}

/// Size of the tactile arrays, the same on both fingertips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TaxelLayout {
    /// Taxels along the finger.
    pub rows: u8,
    /// Taxels across the finger.
    pub columns: u8,
}

impl TaxelLayout {
    /// Number of taxels of one array.
    pub const fn taxel_count(self) -> usize {
        self.rows as usize * self.columns as usize
    }
}

/// The fields of a datagram before its content that vary within a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// Random number the sender draws for each session; never 0.
    pub sender_nonce: u64,
    /// The nonce the sender last received from the other side; 0 before it has received one.
    pub receiver_nonce: u64,
    /// 1 for the first datagram of a session, then one more for each.
    pub sequence: u64,
    /// Time of sending on the sender's clock, ns.
    pub time_ns: u64,
    /// How long after `time_ns` the content is valid, us.
    pub valid_us: u32,
    /// In a command: render nothing, at once.
    pub stop: bool,
    /// The sender ends the session.
    pub last: bool,
}

/// The state of one finger, from the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerState {
    /// [`FINGER_SENSED`] and [`FINGER_VELOCITY`].
    pub flags: u32,
    /// Pressed buttons; bit i is button i.
    pub buttons: u32,
    /// Position of the fingertip, m; x right, y up, z towards the user.
    pub position: [f64; 3],
    /// Orientation of the fingertip, a unit quaternion x y z w.
    pub orientation: [f64; 4],
    /// Velocity of the fingertip, m/s.
    pub velocity: [f64; 3],
    /// Force the device renders now, N.
    pub force: [f64; 3],
    /// Sum of the forces of the taxels the device renders now, N.
    pub taxel_force_sum: f64,
}

impl Default for FingerState {
    fn default() -> Self {
        Self {
            flags: 0,
            buttons: 0,
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            velocity: [0.0; 3],
            force: [0.0; 3],
            taxel_force_sum: 0.0,
        }
    }
}

/// What the device renders on one finger, from the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerCommand {
    /// Force on the fingertip, N.
    pub force: [f64; 3],
    /// Force of each taxel, N, row by row; zeros after the last.
    pub taxels: [f32; MAX_TAXELS],
}

impl Default for FingerCommand {
    fn default() -> Self {
        Self { force: [0.0; 3], taxels: [0.0; MAX_TAXELS] }
    }
}

/// Why a datagram is rejected. The variants are in the order of the checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// It is shorter or longer than its header says or its kind requires.
    Length,
    /// It does not begin with [`MAGIC`].
    Magic,
    /// It has another version.
    Version,
    /// Its kind is that of the other direction, a reserved bit or field is not 0, or a field that must not be 0 is.
    Kind,
    /// It has another number of fingertips or taxels.
    Layout,
    /// Its checksum is wrong.
    Checksum,
    /// Its authentication tag is wrong, missing or unexpected.
    Key,
    /// A number is not finite, or an orientation is not a unit quaternion.
    Value,
}

impl Rejection {
    /// Counts the rejected datagram.
    pub fn count(self, counts: &mut ReceiveCounts) {
        match self {
            Self::Key => counts.unauthentic += 1,
            Self::Length | Self::Magic | Self::Version | Self::Kind | Self::Layout | Self::Checksum | Self::Value => {
                counts.malformed += 1
            }
        }
    }
}

/// Bytes of a datagram.
pub const fn datagram_bytes(kind: DatagramKind, layout: TaxelLayout, keyed: bool) -> usize {
    let finger_bytes = match kind {
        DatagramKind::Pose => POSE_BYTES,
        DatagramKind::Command => FORCE_BYTES + 4 * layout.taxel_count(),
    };
    HEADER_BYTES + EFFECTOR_COUNT * finger_bytes + CHECKSUM_BYTES + if keyed { TAG_BYTES } else { 0 }
}
