//! Many runs, runs that are stopped, and runs that cannot go on.

mod batch;
mod batch_faults;
mod batch_kill;
mod cancelling;
mod hanging_plugins;
mod refused_threads;
mod session_batch;
