//! Constants of the HDAPI, with the names of its headers less the prefix `HD_`.

/// Error codes.
pub(crate) mod error {
    pub(crate) const INVALID_ENUM: u32 = 0x0100;
    pub(crate) const INVALID_VALUE: u32 = 0x0101;
    pub(crate) const INVALID_OPERATION: u32 = 0x0102;
    pub(crate) const BAD_HANDLE: u32 = 0x0104;
    pub(crate) const EXCEEDED_MAX_FORCE: u32 = 0x0201;
    pub(crate) const DEVICE_ALREADY_INITIATED: u32 = 0x0301;
    pub(crate) const COMM_ERROR: u32 = 0x0302;
    pub(crate) const COMM_CONFIG_ERROR: u32 = 0x0303;
    pub(crate) const ILLEGAL_BEGIN: u32 = 0x0400;
    pub(crate) const ILLEGAL_END: u32 = 0x0401;
}

/// Parameters that can be read or set.
pub(crate) mod parameter {
    pub(crate) const CURRENT_BUTTONS: u32 = 0x2000;
    pub(crate) const CURRENT_INKWELL_SWITCH: u32 = 0x2002;
    pub(crate) const CURRENT_POSITION: u32 = 0x2050;
    pub(crate) const CURRENT_VELOCITY: u32 = 0x2051;
    pub(crate) const CURRENT_TRANSFORM: u32 = 0x2052;
    pub(crate) const DEVICE_MODEL_TYPE: u32 = 0x2501;
    pub(crate) const DEVICE_SERIAL_NUMBER: u32 = 0x2504;
    pub(crate) const USABLE_WORKSPACE_DIMENSIONS: u32 = 0x2551;
    pub(crate) const OUTPUT_DOF: u32 = 0x2554;
    pub(crate) const CALIBRATION_STYLE: u32 = 0x2555;
    pub(crate) const UPDATE_RATE: u32 = 0x2600;
    pub(crate) const NOMINAL_MAX_STIFFNESS: u32 = 0x2602;
    pub(crate) const NOMINAL_MAX_FORCE: u32 = 0x2603;
    pub(crate) const NOMINAL_MAX_CONTINUOUS_FORCE: u32 = 0x2604;
    pub(crate) const NOMINAL_MAX_DAMPING: u32 = 0x2609;
    pub(crate) const CURRENT_FORCE: u32 = 0x2700;
}

/// Capabilities.
pub(crate) mod capability {
    pub(crate) const FORCE_OUTPUT: u32 = 0x4000;
    pub(crate) const MAX_FORCE_CLAMPING: u32 = 0x4001;
}

/// States of the calibration, and one of its styles.
pub(crate) mod calibration {
    pub(crate) const OK: u32 = 0x5000;
    pub(crate) const NEEDS_UPDATE: u32 = 0x5001;
    pub(crate) const NEEDS_MANUAL_INPUT: u32 = 0x5002;
    pub(crate) const STYLE_AUTO: i32 = 2;
}

pub(crate) const INVALID_HANDLE: u32 = 0xffff_ffff;
