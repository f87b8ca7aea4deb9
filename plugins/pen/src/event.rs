//! Events of the kernel (`linux/input.h`): their bytes and the codes that a pen sends.

/// Kind of an event that ends a frame or reports lost events.
pub(crate) const EV_SYN: u16 = 0;
/// Kind of an event of a button.
pub(crate) const EV_KEY: u16 = 1;
/// Kind of an event of an axis.
pub(crate) const EV_ABS: u16 = 3;

/// End of a frame: the events before it belong together.
pub(crate) const SYN_REPORT: u16 = 0;
/// The reader was too slow and events are missing up to the end of the frame.
pub(crate) const SYN_DROPPED: u16 = 3;

/// Code of the axis to the right, in an [`EV_ABS`] event.
pub(crate) const ABS_X: u16 = 0x00;
/// Code of the axis towards the user.
pub(crate) const ABS_Y: u16 = 0x01;
/// Code of the pressure of the tip.
pub(crate) const ABS_PRESSURE: u16 = 0x18;
/// Code of the distance of the tip above the tablet.
pub(crate) const ABS_DISTANCE: u16 = 0x19;
/// Code of the tilt to the right.
pub(crate) const ABS_TILT_X: u16 = 0x1a;
/// Code of the tilt towards the user.
pub(crate) const ABS_TILT_Y: u16 = 0x1b;

/// The pen is near, its tip first.
pub(crate) const BTN_TOOL_PEN: u16 = 0x140;
/// The pen is near, its eraser first.
pub(crate) const BTN_TOOL_RUBBER: u16 = 0x141;
/// It touches the tablet.
pub(crate) const BTN_TOUCH: u16 = 0x14a;
/// The lower button of its barrel.
pub(crate) const BTN_STYLUS: u16 = 0x14b;
/// The upper button of its barrel.
pub(crate) const BTN_STYLUS2: u16 = 0x14c;

/// A `struct input_event` of the kernel: one value of an axis or key, or the end of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Event {
    /// ns, on the clock of the kernel
    pub time_ns: u64,
    /// [`EV_SYN`], [`EV_KEY`] or [`EV_ABS`]; others are passed over.
    pub kind: u16,
    /// What it is about, within the kind.
    pub code: u16,
    /// The value of an axis, or 1 and 0 for keys.
    pub value: i32,
}

/// Bytes of each of the two words of an event's time: those of the processor.
const WORD: usize = size_of::<usize>();
/// Bytes of an event.
pub(crate) const BYTES: usize = 2 * WORD + 8;

impl Event {
    /// Reads an event from its bytes in the order of this processor.
    pub fn read(bytes: &[u8; BYTES]) -> Self {
        let word = |at: usize| {
            let mut word = [0; WORD];
            word.copy_from_slice(&bytes[at..at + WORD]);
            usize::from_ne_bytes(word) as u64
        };
        let (seconds, microseconds) = (word(0), word(WORD));
        let half = |at: usize| u16::from_ne_bytes([bytes[at], bytes[at + 1]]);
        let at = 2 * WORD;
        Self {
            time_ns: seconds.saturating_mul(1_000_000_000).saturating_add(microseconds.saturating_mul(1000)),
            kind: half(at),
            code: half(at + 2),
            value: i32::from_ne_bytes([bytes[at + 4], bytes[at + 5], bytes[at + 6], bytes[at + 7]]),
        }
    }
}
