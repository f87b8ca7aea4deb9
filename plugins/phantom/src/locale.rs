//! The locale of numbers while the driver reads its configuration. The driver parses numbers with the C library, so under a locale with a
//! decimal comma it would read wrong values.
#![allow(unsafe_code, reason = "the locale belongs to the C library")]

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr::null;

/// The category of number formats; its value depends on the C library.
#[cfg(target_os = "linux")]
const LC_NUMERIC: c_int = 1;
#[cfg(not(target_os = "linux"))]
const LC_NUMERIC: c_int = 4;

unsafe extern "C" {
    fn setlocale(category: c_int, locale: *const c_char) -> *const c_char;
}

/// Sets the process's locale of numbers to "C" and restores the previous one when dropped.
pub struct NumericLocale {
    previous: CString,
}

impl NumericLocale {
    /// Sets the locale to "C", for the whole process.
    pub fn set_c() -> Self {
        // SAFETY: a query returns a C string that lives until the next call, so it is copied first.
        unsafe {
            let previous = setlocale(LC_NUMERIC, null());
            let previous = if previous.is_null() { c"C".to_owned() } else { CStr::from_ptr(previous).to_owned() };
            setlocale(LC_NUMERIC, c"C".as_ptr());
            Self { previous }
        }
    }
}

impl Drop for NumericLocale {
    fn drop(&mut self) {
        // SAFETY: a C string.
        unsafe { setlocale(LC_NUMERIC, self.previous.as_ptr()) };
    }
}
