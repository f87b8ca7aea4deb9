//! Ctrl-C within a step: the signal ends the step under way, and Python's own handler is called as ever.
//!
//! Python's handler only notes the signal until the interpreter runs again, which a long step does not let it do. While the main thread takes steps,
//! a handler before Python's cancels them; [`check_signals`](super::law::check_signals) then raises what Python raises. On Linux; elsewhere Ctrl-C is
//! noticed between steps.

use pliant_engine::session::CancelToken;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

/// Set by the signal. One for the process, for only its main thread watches.
static PRESSED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// While it lives, Ctrl-C cancels [`CtrlC::token`].
pub struct CtrlC {
    #[cfg(target_os = "linux")]
    installed: Option<handler::Installed>,
}

impl CtrlC {
    /// Watches on the main thread of a Python that handles the signal, and nowhere else: Python raises on that thread alone.
    pub fn watch() -> Self {
        let watch = Self {
            #[cfg(target_os = "linux")]
            installed: {
                pressed();
                handler::Installed::new()
            },
        };
        watch.clear();
        watch
    }

    /// What steps of this thread are cancelled by.
    pub fn token(&self) -> CancelToken {
        #[cfg(target_os = "linux")]
        if self.installed.is_some() {
            return CancelToken::of(Arc::clone(pressed()));
        }
        CancelToken::default()
    }

    /// Forgets a signal that raised nothing, so that steps go on.
    pub fn clear(&self) {
        #[cfg(target_os = "linux")]
        if self.installed.is_some() {
            pressed().store(false, std::sync::atomic::Ordering::Relaxed);
        }
    }
}

fn pressed() -> &'static Arc<AtomicBool> {
    PRESSED.get_or_init(Arc::default)
}

#[cfg(target_os = "linux")]
mod handler {
    #![allow(unsafe_code, reason = "handlers of signals are C")]

    use std::ffi::c_int;
    use std::mem::{MaybeUninit, transmute};
    use std::ptr;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Address of Python's handler.
    static PYTHON: AtomicUsize = AtomicUsize::new(0);

    /// Sets the flag and calls Python's handler. Nothing in it allocates or locks.
    extern "C" fn note(signal: c_int) {
        if let Some(pressed) = super::PRESSED.get() {
            pressed.store(true, Ordering::Relaxed);
        }
        // SAFETY: `Installed::new` stored the address of a handler with this signature before it installed this one.
        let python: extern "C" fn(c_int) = unsafe { transmute(PYTHON.load(Ordering::Acquire)) };
        python(signal);
    }

    /// The handler in place of Python's, which comes back when this is dropped.
    pub(super) struct Installed {
        python: libc::sigaction,
    }

    impl Installed {
        /// `None` on other threads than the main one, inside of another watch, and where Python does not handle the signal.
        pub(super) fn new() -> Option<Self> {
            // SAFETY: neither call has arguments, and neither fails.
            if unsafe { libc::gettid() != libc::getpid() } {
                return None;
            }
            let mut found = MaybeUninit::<libc::sigaction>::uninit();
            // SAFETY: a null action changes nothing, and `found` is large enough for the present one.
            let python = unsafe {
                if libc::sigaction(libc::SIGINT, ptr::null(), found.as_mut_ptr()) != 0 {
                    return None;
                }
                found.assume_init()
            };
            let ours = note as extern "C" fn(c_int) as usize;
            let is_plain = python.sa_flags & libc::SA_SIGINFO == 0;
            if !is_plain || [libc::SIG_DFL, libc::SIG_IGN, ours].contains(&python.sa_sigaction) {
                return None;
            }
            PYTHON.store(python.sa_sigaction, Ordering::Release);
            let action = libc::sigaction { sa_sigaction: ours, ..python };
            // SAFETY: `note` has the signature of a plain handler and does only what one may; mask and flags are Python's.
            let failed = unsafe { libc::sigaction(libc::SIGINT, &raw const action, ptr::null_mut()) } != 0;
            (!failed).then_some(Self { python })
        }
    }

    impl Drop for Installed {
        fn drop(&mut self) {
            // SAFETY: the action is the one that was found.
            unsafe { libc::sigaction(libc::SIGINT, &raw const self.python, ptr::null_mut()) };
        }
    }
}
