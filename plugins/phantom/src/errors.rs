//! The error codes of the driver, and the class of each, which decides what the plugin does about it.

/// A class of errors, by what the plugin does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorClass {
    /// Motors too warm; force, impulse or velocity too large. The force output is switched off until there has been no such error for a
    /// while; then the force rises slowly.
    Force,
    /// The device is gone: no pose and no force; the plugin opens it again outside of the servo loop.
    Lost,
    /// The device or its state does not allow the call. The sample of that tick is dropped.
    Usage,
    /// A frame was begun or ended out of order. The sample of that tick is dropped.
    Frame,
    /// The scheduler does not accept the servo loop. Opening fails.
    Scheduler,
    /// The driver has no licence. Opening fails; in the servo loop it counts as [`ErrorClass::Lost`].
    Licence,
    /// A code of a later version. Counts as [`ErrorClass::Lost`], the most careful class.
    Unknown,
}

/// An error code of the driver.
#[derive(Clone, Copy, Debug)]
pub struct ErrorCode {
    /// The number in an error record.
    pub code: u32,
    /// The name in the driver's headers.
    pub name: &'static str,
    /// What the plugin does about it.
    pub class: ErrorClass,
}

const fn error(code: u32, name: &'static str, class: ErrorClass) -> ErrorCode {
    ErrorCode { code, name, class }
}

/// All error codes of version 3.0.
pub const ERROR_CODES: &[ErrorCode] = &[
    error(0x0100, "HD_INVALID_ENUM", ErrorClass::Usage),
    error(0x0101, "HD_INVALID_VALUE", ErrorClass::Usage),
    error(0x0102, "HD_INVALID_OPERATION", ErrorClass::Usage),
    error(0x0103, "HD_INVALID_INPUT_TYPE", ErrorClass::Usage),
    error(0x0104, "HD_BAD_HANDLE", ErrorClass::Lost),
    error(0x0200, "HD_WARM_MOTORS", ErrorClass::Force),
    error(0x0201, "HD_EXCEEDED_MAX_FORCE", ErrorClass::Force),
    error(0x0202, "HD_EXCEEDED_MAX_FORCE_IMPULSE", ErrorClass::Force),
    error(0x0203, "HD_EXCEEDED_MAX_VELOCITY", ErrorClass::Force),
    error(0x0204, "HD_FORCE_ERROR", ErrorClass::Force),
    error(0x0300, "HD_DEVICE_FAULT", ErrorClass::Lost),
    error(0x0301, "HD_DEVICE_ALREADY_INITIATED", ErrorClass::Usage),
    error(0x0302, "HD_COMM_ERROR", ErrorClass::Lost),
    error(0x0303, "HD_COMM_CONFIG_ERROR", ErrorClass::Lost),
    error(0x0304, "HD_TIMER_ERROR", ErrorClass::Lost),
    error(0x0400, "HD_ILLEGAL_BEGIN", ErrorClass::Frame),
    error(0x0401, "HD_ILLEGAL_END", ErrorClass::Frame),
    error(0x0402, "HD_FRAME_ERROR", ErrorClass::Frame),
    error(0x0500, "HD_INVALID_PRIORITY", ErrorClass::Scheduler),
    error(0x0501, "HD_SCHEDULER_FULL", ErrorClass::Scheduler),
    error(0x0600, "HD_INVALID_LICENSE", ErrorClass::Licence),
];

fn find(code: u32) -> Option<&'static ErrorCode> {
    ERROR_CODES.iter().find(|known| known.code == code)
}

/// The class of a code.
pub fn class(code: u32) -> ErrorClass {
    find(code).map_or(ErrorClass::Unknown, |known| known.class)
}

/// The name of a code.
pub fn name(code: u32) -> &'static str {
    find(code).map_or("an error code unknown to this plugin", |known| known.name)
}
