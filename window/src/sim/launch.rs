//! Priorities: the window yields to the simulation, also where a picture is drawn without a graphics card.
//!
//! On Linux a thread takes over the niceness of the one that starts it. A thread that was started before the window became nice starts
//! those of the simulation, so that they compete with nothing of the window; the threads of a software renderer are as nice as the window.

use crate::strings;
use std::io;
use std::sync::OnceLock;
use std::sync::mpsc::{Sender, channel};
use std::thread::{Builder, JoinHandle};

/// What is started: its work, and where its handle goes.
type Start = (Box<dyn FnOnce() + Send>, Sender<io::Result<JoinHandle<()>>>);

static LAUNCHER: OnceLock<Sender<Start>> = OnceLock::new();

/// Makes the calling thread, and all that it starts from now on, yield to the simulations that will be started. Does nothing where
/// the system gives no thread.
pub fn prepare() {
    let (sender, requests) = channel::<Start>();
    let launch = move || {
        for (work, answer) in requests {
            // Whoever asked may have gone.
            let _ = answer.send(spawn_here(work));
        }
    };
    if Builder::new().name("launcher".into()).spawn(launch).is_ok() && LAUNCHER.set(sender).is_ok() {
        become_nice();
    }
}

/// Starts a thread of a simulation.
pub(super) fn spawn(work: Box<dyn FnOnce() + Send>) -> io::Result<JoinHandle<()>> {
    let Some(launcher) = LAUNCHER.get() else { return spawn_here(work) };
    let (answer, handle) = channel();
    let gone = |_| io::Error::other(strings::LAUNCHER_ENDED);
    launcher.send((work, answer)).map_err(|_| io::Error::other(strings::LAUNCHER_ENDED))?;
    handle.recv().map_err(gone)?
}

fn spawn_here(work: Box<dyn FnOnce() + Send>) -> io::Result<JoinHandle<()>> {
    Builder::new().name("simulation".into()).spawn(work)
}

/// Niceness of the window: a third of the share of a processor that the simulation gets where both want it.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 5;

#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "`nice` has no safe wrapper among the crates that are here")]
fn become_nice() {
    // SAFETY: it takes a number and touches no memory; on Linux it acts on the calling thread.
    let _ = unsafe { libc::nice(NICENESS) };
}

#[cfg(not(target_os = "linux"))]
fn become_nice() {}
