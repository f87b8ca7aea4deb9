//! Ctrl-C within a step: the signal ends the step under way, and Python's own handler is called as ever.
//!
//! Python's handler only notes the signal until the interpreter runs again, which a long step does not let it do. While the main thread takes steps,
//! a handler before Python's cancels them; [`check_signals`](super::law::check_signals) then raises what Python raises. On Linux; elsewhere Ctrl-C is
//! noticed between steps.

use pliant_engine::session::CancelToken;
#[cfg(target_os = "linux")]
use std::sync::{
    Arc, OnceLock,
    atomic::{AtomicBool, Ordering},
};

/// Set by the signal. One for the process, for only its main thread watches.
#[cfg(target_os = "linux")]
static PRESSED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// While it lives, Ctrl-C cancels [`CtrlC::token`].
pub struct CtrlC {
    #[cfg(target_os = "linux")]
    installed: Option<handler::Installed>,
}

impl CtrlC {
    /// Watches on the main thread of a Python that handles the signal, and nowhere else: Python raises on that thread alone.
    pub fn watch() -> Self {
        Self {
            #[cfg(target_os = "linux")]
            installed: handler::Installed::new(pressed()),
        }
    }

    /// The token for steps: cancelled by Ctrl-C, or never where it is not watched.
    pub fn token(&self) -> CancelToken {
        #[cfg(target_os = "linux")]
        if self.installed.is_some() {
            return CancelToken::from(Arc::clone(pressed()));
        }
        CancelToken::default()
    }

    /// Forgets the signal. Called before Python is asked what it raises, so that a later signal cancels the next step.
    pub fn clear(&self) {
        #[cfg(target_os = "linux")]
        if self.installed.is_some() {
            pressed().store(false, Ordering::Relaxed);
        }
    }
}

#[cfg(target_os = "linux")]
fn pressed() -> &'static Arc<AtomicBool> {
    PRESSED.get_or_init(Arc::default)
}

#[cfg(target_os = "linux")]
mod handler {
    #![allow(unsafe_code, reason = "handlers of signals are C")]

    use std::ffi::c_int;
    use std::mem::{MaybeUninit, transmute};
    use std::ptr;
    use std::sync::atomic::{AtomicBool, AtomicPtr, Ordering};

    /// Python's handler.
    static PYTHON: AtomicPtr<()> = AtomicPtr::new(ptr::null_mut());

    /// Sets the flag and calls Python's handler. Nothing in it allocates or locks.
    extern "C" fn note(signal: c_int) {
        if let Some(pressed) = super::PRESSED.get() {
            pressed.store(true, Ordering::Relaxed);
        }
        // SAFETY: `Installed::new` stored the address of a handler with this signature before it installed this one.
        let python: extern "C" fn(c_int) = unsafe { transmute(PYTHON.load(Ordering::Acquire)) };
        python(signal);
    }

    fn ours() -> usize {
        note as extern "C" fn(c_int) as usize
    }

    /// What is done on the signal now.
    fn present() -> Option<libc::sigaction> {
        let mut found = MaybeUninit::<libc::sigaction>::uninit();
        // SAFETY: a null action changes nothing, and `found` is large enough for the present one.
        let failed = unsafe { libc::sigaction(libc::SIGINT, ptr::null(), found.as_mut_ptr()) } != 0;
        // SAFETY: the call filled it in.
        (!failed).then(|| unsafe { found.assume_init() })
    }

    /// The handler in place of Python's, which comes back when this is dropped.
    pub(super) struct Installed {
        python: libc::sigaction,
    }

    impl Installed {
        /// `None` on other threads than the main one, inside of another watch, and where Python does not handle the signal.
        pub(super) fn new(pressed: &AtomicBool) -> Option<Self> {
            // SAFETY: neither call has arguments, and neither fails.
            if unsafe { libc::gettid() != libc::getpid() } {
                return None;
            }
            let python = present()?;
            let is_plain = python.sa_flags & libc::SA_SIGINFO == 0;
            if !is_plain || [libc::SIG_DFL, libc::SIG_IGN, ours()].contains(&python.sa_sigaction) {
                return None;
            }
            PYTHON.store(ptr::with_exposed_provenance_mut(python.sa_sigaction), Ordering::Release);
            pressed.store(false, Ordering::Relaxed);
            let action = libc::sigaction { sa_sigaction: ours(), ..python };
            // SAFETY: `note` has the signature of a plain handler and does only what one may; mask and flags are Python's.
            let failed = unsafe { libc::sigaction(libc::SIGINT, &raw const action, ptr::null_mut()) } != 0;
            (!failed).then_some(Self { python })
        }
    }

    impl Drop for Installed {
        fn drop(&mut self) {
            // A handler that Python code has set meanwhile stays.
            if present().is_some_and(|action| action.sa_sigaction == ours()) {
                // SAFETY: the action is the one that was found.
                unsafe { libc::sigaction(libc::SIGINT, &raw const self.python, ptr::null_mut()) };
            }
        }
    }
}
