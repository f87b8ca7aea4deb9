//! `pliant run --isolate`: the run in a child process, and this process as its watchdog.
//!
//! The child notes on a board in shared memory which plugin calls it is in, and that it ends by itself. So a call that does not return is
//! named and ended here, a crash has a place, and a plugin that ends the process does not pass for a run that was done.

use crate::args::RunArgs;
use crate::call_watchdog::OverdueCalls;
use crate::child::signal_name;
use crate::outcome::{Failure, Outcome};
use crate::output::note;
use pliant_host::{CallBoard, PluginCall, end_with_parent, share_calls};
use std::process::{Child, Command, ExitStatus};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Variable that tells a child the file of the board and its parent's process: `PID:PATH`.
const BOARD: &str = "PLIANT_ISOLATED_RUN";
/// Time from one look at the child to the next.
const TICK: Duration = Duration::from_millis(20);
/// Time a child has to stop its devices once it was told to end at once.
const GRACE: Duration = Duration::from_millis(500);

/// Whether this process is the child of an isolated run.
pub fn is_child() -> bool {
    std::env::var_os(BOARD).is_some()
}

/// In the child of an isolated run: notes calls where the parent sees them, and ends with the parent.
pub fn watch_child() -> Result<(), Failure> {
    let Some(value) = std::env::var_os(BOARD) else { return Ok(()) };
    let value = value.to_string_lossy();
    let parts = value.split_once(':').and_then(|(parent, path)| Some((parent.parse().ok()?, path)));
    let (parent, path) = parts.ok_or_else(|| Failure::input(format!("{BOARD}: `{value}`; allowed is PID:PATH")))?;
    end_with_parent(parent);
    Ok(share_calls(path.as_ref())?)
}

/// Runs the same command in a child process and watches it.
pub fn run_isolated(args: &RunArgs) -> Result<Outcome, Failure> {
    let file = tempfile::NamedTempFile::new()?;
    let board = CallBoard::new(file.as_file())?;
    let signals = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&signals);
    let _ = ctrlc::set_handler(move || _ = counter.fetch_add(1, Ordering::Relaxed));
    let mut command = Command::new(std::env::current_exe()?);
    command.args(std::env::args_os().skip(1));
    command.env(BOARD, format!("{}:{}", std::process::id(), file.path().display()));
    // A group of its own: signals reach it from here alone, so that each counts once.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let child = command.spawn()?;
    Watch { child, board: &board, overdue: OverdueCalls::new(args.call_limit), ended: None }.wait(&signals)
}

/// A child under watch.
struct Watch<'a> {
    child: Child,
    board: &'a CallBoard,
    overdue: OverdueCalls,
    /// When it was first seen that the child had ended its work.
    ended: Option<Instant>,
}

impl Watch<'_> {
    fn wait(mut self, signals: &AtomicUsize) -> Result<Outcome, Failure> {
        let mut passed_on = 0;
        loop {
            let calls = self.board.calls();
            if let Some(status) = self.child.try_wait()? {
                let stopped = passed_on > 0 && status.code() == Some(Outcome::Stopped.exit_code().into());
                return if stopped { Ok(Outcome::Stopped) } else { self.outcome(status, &calls) };
            }
            let asked = signals.load(Ordering::Relaxed);
            if asked > passed_on {
                passed_on = asked;
                self.terminate();
                if asked > 1 {
                    self.end_within(GRACE)?;
                    return Ok(Outcome::Stopped);
                }
            }
            if let Some(call) = self.overdue.find(&calls) {
                self.end_at_once()?;
                let limit = self.overdue.limit().as_secs_f64();
                return Err(Failure::plugin(format!(
                    "{call} did not return within {limit} s (`--call-limit`); the run was ended, no results were written"
                )));
            }
            if let Some(code) = self.board.exit_code()
                && self.ended.get_or_insert_with(Instant::now).elapsed() > self.overdue.limit()
            {
                self.end_at_once()?;
                note("a plugin kept the process of the run from ending; it was ended");
                return Ok(Outcome::from_exit_code(code.into()).unwrap_or(Outcome::Plugin));
            }
            sleep(TICK);
        }
    }

    /// How a run ended whose process has ended: as it says itself, or else by a plugin.
    fn outcome(&self, status: ExitStatus, calls: &[PluginCall]) -> Result<Outcome, Failure> {
        let own = self.board.exit_code().filter(|code| status.code() == Some((*code).into()));
        if let Some(outcome) = own.and_then(|code| Outcome::from_exit_code(code.into())) {
            return Ok(outcome);
        }
        let place = match calls {
            [] => "a plugin of the scene".to_owned(),
            calls => calls.iter().map(ToString::to_string).collect::<Vec<_>>().join(" or "),
        };
        Err(Failure::plugin(match status.code() {
            Some(code) => format!("{place} ended the process of the run, with code {code}; no results were written"),
            None => {
                format!("the process was ended by {}: {place} crashed; no results were written", signal_name(status))
            }
        }))
    }

    /// Tells the child to stop its devices and end at once.
    fn end_at_once(&mut self) -> std::io::Result<()> {
        self.terminate();
        sleep(TICK);
        self.terminate();
        self.end_within(GRACE)
    }

    /// Ends the child if it does not end within a time.
    fn end_within(&mut self, time: Duration) -> std::io::Result<()> {
        let start = Instant::now();
        while start.elapsed() < time {
            if self.child.try_wait()?.is_some() {
                return Ok(());
            }
            sleep(TICK);
        }
        self.child.kill()?;
        self.child.wait().map(drop)
    }

    /// Asks the child to end.
    #[cfg(unix)]
    fn terminate(&self) {
        use nix::sys::signal::{Signal, kill};
        let _ = kill(nix::unistd::Pid::from_raw(self.child.id() as i32), Signal::SIGTERM);
    }

    /// Asks the child to end: on this system it is ended.
    #[cfg(not(unix))]
    fn terminate(&mut self) {
        let _ = self.child.kill();
    }
}
