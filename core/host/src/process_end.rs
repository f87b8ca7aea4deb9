//! The end of a program that has opened plugins: a normal exit, an exit that a plugin causes, or an immediate one.

use crate::calls::{board, own_call};
use crate::device::stop_devices;
use std::sync::OnceLock;
use std::time::Duration;

/// Exit code of a program that a plugin has ended.
const PLUGIN_FAILED: u8 = 3;
/// Time that devices have to stop before the program ends at once.
const STOP_TIME: Duration = Duration::from_millis(200);

/// Reports that a plugin has ended the program.
static REPORT: OnceLock<fn(&str)> = OnceLock::new();

/// Detects plugins that end the program with `exit`: from now on such a program calls `report` with a message that names the call and ends
/// with exit code 3, whatever code the plugin gave. The program itself must call [`record_exit_code`] before it ends. An end that does not run
/// `atexit` functions, such as `_exit`, is not detected here; another process can detect it ([`CallBoard`](crate::CallBoard)).
pub fn detect_plugin_exit(report: fn(&str)) {
    if REPORT.set(report).is_ok() {
        register_at_exit();
    }
}

/// Records the exit code of a program that is about to end.
pub fn record_exit_code(code: u8) {
    board().record_exit_code(code);
}

/// Stops every open device (zero force) and ends the program at once, without running `atexit` functions or destructors.
pub fn end_at_once(code: u8) -> ! {
    stop_devices(STOP_TIME);
    end_now(code)
}

/// Asks the system to end this process when its parent process, with the id `parent`, ends. Ends the program if the parent has ended already.
/// Does nothing on systems other than Linux.
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

/// Runs when the process exits.
extern "C" fn at_exit() {
    if board().exit_code().is_some() {
        return;
    }
    let place = own_call().map_or_else(|| "a plugin".to_owned(), |call| call.to_string());
    if let Some(report) = REPORT.get() {
        report(&format!("{place} ended the program with `exit` before its work was done"));
    }
    record_exit_code(PLUGIN_FAILED);
    end_at_once(PLUGIN_FAILED);
}

/// Has [`at_exit`] called when the process exits.
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

/// Ends the process without `atexit` functions.
#[cfg(unix)]
#[allow(unsafe_code, reason = "calls the C library")]
fn end_now(code: u8) -> ! {
    // SAFETY: ends the process; nothing comes after it.
    unsafe { nix::libc::_exit(code.into()) }
}

/// Ends the process.
#[cfg(not(unix))]
fn end_now(code: u8) -> ! {
    std::process::exit(code.into())
}
