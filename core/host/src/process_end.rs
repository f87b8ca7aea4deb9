//! How a program that has opened plugins ends: by itself, inside of a plugin, or at once.

use crate::calls::{board, own_call};
use crate::device::stop_devices;
use std::sync::OnceLock;
use std::time::Duration;

/// Exit code of a program that a plugin has ended.
const PLUGIN_FAILED: u8 = 3;
/// Time that devices have to stop before the program ends at once.
const STOP_TIME: Duration = Duration::from_millis(200);

/// What tells people that a plugin has ended the program.
static TELL: OnceLock<fn(&str)> = OnceLock::new();

/// From now on a program that a plugin ends with `exit` calls `tell` with a sentence on it and ends with exit code 3, whatever code
/// the plugin gave. What ends without the functions that `atexit` has registered, such as `_exit`, is not noticed: only another
/// process can tell ([`CallBoard`](crate::CallBoard)). The program says with [`end_by_itself`] that it comes to its end.
pub fn guard_exit(tell: fn(&str)) {
    if TELL.set(tell).is_ok() {
        register_at_exit();
    }
}

/// Notes that the program comes to its end by itself, with an exit code.
pub fn end_by_itself(code: u8) {
    board().end(code);
}

/// Stops every open device and ends the program at once, without running anything else of it or of a plugin.
pub fn end_at_once(code: u8) -> ! {
    stop_devices(STOP_TIME);
    end_now(code)
}

/// Asks the system to end this process when the process that started it, `parent`, has ended. Ends the program where that is so
/// already. Does nothing on systems other than Linux.
pub fn end_with_parent(parent: u32) {
    #[cfg(target_os = "linux")]
    {
        let _ = nix::sys::prctl::set_pdeathsig(nix::sys::signal::Signal::SIGKILL);
        if nix::unistd::getppid().as_raw() as u32 != parent {
            end_now(PLUGIN_FAILED);
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = parent;
}

/// Runs when the process ends.
extern "C" fn at_exit() {
    if board().ended().is_some() {
        return;
    }
    let place = own_call().map_or_else(|| "a plugin".to_owned(), |call| call.to_string());
    if let Some(tell) = TELL.get() {
        tell(&format!("{place} ended the program with `exit` before its work was done"));
    }
    end_by_itself(PLUGIN_FAILED);
    end_at_once(PLUGIN_FAILED);
}

#[cfg(unix)]
#[allow(unsafe_code, reason = "calls the C library")]
fn register_at_exit() {
    // SAFETY: a function that lives as long as the program.
    let _ = unsafe { nix::libc::atexit(at_exit) };
}

/// Not possible on this system.
#[cfg(not(unix))]
fn register_at_exit() {
    let _ = at_exit;
}

#[cfg(unix)]
#[allow(unsafe_code, reason = "calls the C library")]
fn end_now(code: u8) -> ! {
    // SAFETY: ends the process; nothing comes after it.
    unsafe { nix::libc::_exit(code.into()) }
}

/// Ends the program.
#[cfg(not(unix))]
fn end_now(code: u8) -> ! {
    std::process::exit(code.into())
}
