//! What the driver's errors mean, and what is done about each class.

/// A class of errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Motors too warm, too much force, impulse or velocity: output off until it has been quiet, then up again slowly.
    Force,
    /// The device is not there any more: no pose, no force, and a new try outside of the servo loop.
    Lost,
    /// Something was asked for that this device or state does not have: no force in that tick.
    Usage,
    /// A frame was begun or ended out of order: no force in that tick.
    Frame,
    /// The scheduler does not take the work.
    Scheduler,
    /// The driver wants a licence.
    Licence,
    /// A code of a later version: treated as `Lost`, the most careful.
    Unknown,
}

/// Every code of version 3.0: name and class.
pub const CODES: &[(u32, &str, Class)] = &[
    (0x0100, "HD_INVALID_ENUM", Class::Usage),
    (0x0101, "HD_INVALID_VALUE", Class::Usage),
    (0x0102, "HD_INVALID_OPERATION", Class::Usage),
    (0x0103, "HD_INVALID_INPUT_TYPE", Class::Usage),
    (0x0104, "HD_BAD_HANDLE", Class::Lost),
    (0x0200, "HD_WARM_MOTORS", Class::Force),
    (0x0201, "HD_EXCEEDED_MAX_FORCE", Class::Force),
    (0x0202, "HD_EXCEEDED_MAX_FORCE_IMPULSE", Class::Force),
    (0x0203, "HD_EXCEEDED_MAX_VELOCITY", Class::Force),
    (0x0204, "HD_FORCE_ERROR", Class::Force),
    (0x0300, "HD_DEVICE_FAULT", Class::Lost),
    (0x0301, "HD_DEVICE_ALREADY_INITIATED", Class::Usage),
    (0x0302, "HD_COMM_ERROR", Class::Lost),
    (0x0303, "HD_COMM_CONFIG_ERROR", Class::Lost),
    (0x0304, "HD_TIMER_ERROR", Class::Lost),
    (0x0400, "HD_ILLEGAL_BEGIN", Class::Frame),
    (0x0401, "HD_ILLEGAL_END", Class::Frame),
    (0x0402, "HD_FRAME_ERROR", Class::Frame),
    (0x0500, "HD_INVALID_PRIORITY", Class::Scheduler),
    (0x0501, "HD_SCHEDULER_FULL", Class::Scheduler),
    (0x0600, "HD_INVALID_LICENSE", Class::Licence),
];

/// The class of a code.
pub fn class(code: u32) -> Class {
    CODES.iter().find(|(c, ..)| *c == code).map_or(Class::Unknown, |(.., class)| *class)
}

/// The name of a code.
pub fn name(code: u32) -> &'static str {
    CODES.iter().find(|(c, ..)| *c == code).map_or("an error this plugin does not know", |(_, name, _)| name)
}
