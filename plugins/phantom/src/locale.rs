//! Numbers with a point while the driver reads its configuration: it takes the decimal sign from the process, and a host that
//! has set a locale with a comma would have it read wrong numbers.
#![allow(unsafe_code, reason = "the locale belongs to the C library")]

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr::null;

#[cfg(target_os = "linux")]
const LC_NUMERIC: c_int = 1;
#[cfg(not(target_os = "linux"))]
const LC_NUMERIC: c_int = 4;

unsafe extern "C" {
    fn setlocale(category: c_int, locale: *const c_char) -> *const c_char;
}

/// The locale of numbers is "C" until this is dropped.
pub struct Numeric(CString);

impl Numeric {
    /// Sets it. Called from `main` only.
    pub fn c() -> Self {
        // SAFETY: asking gives a C string that lives until the next call, so it is copied first.
        unsafe {
            let before = setlocale(LC_NUMERIC, null());
            let before = if before.is_null() { c"C".to_owned() } else { CStr::from_ptr(before).to_owned() };
            setlocale(LC_NUMERIC, c"C".as_ptr());
            Self(before)
        }
    }
}

impl Drop for Numeric {
    fn drop(&mut self) {
        // SAFETY: a C string.
        unsafe { setlocale(LC_NUMERIC, self.0.as_ptr()) };
    }
}
