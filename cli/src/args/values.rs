//! Values of arguments: quantities and settings.

use pliant_engine::memory::{MemoryBudget, parse_bytes};
use pliant_engine::scene::parse_quantity;
use pliant_engine::session::MAX_THREADS;

/// A time above zero, s.
pub(super) fn duration(text: &str) -> Result<f64, String> {
    parse_quantity(text, "s").and_then(|t| if t > 0.0 { Ok(t) } else { Err("allowed is a time above 0".into()) })
}

/// Time that a case of the conformance suite may take, s.
pub(super) fn case_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.1..=1e6).contains(seconds));
    seconds.ok_or_else(|| "allowed is 0.1 to 1000000 s".into())
}

/// A rate of the haptic loop, Hz.
pub(super) fn rate(text: &str) -> Result<f64, String> {
    let allowed = |rate: &f64| (100.0..=4000.0).contains(rate);
    parse_quantity(text, "Hz").and_then(|r| Some(r).filter(allowed).ok_or("allowed is 100 Hz to 4 kHz".into()))
}

/// The memory of a session.
pub(super) fn memory(text: &str) -> Result<MemoryBudget, String> {
    parse_bytes(text).map(MemoryBudget::new)
}

/// A number of threads; 0 stands for all processors.
pub(super) fn thread_count(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| *count <= MAX_THREADS);
    count.ok_or_else(|| format!("allowed is 0 to {MAX_THREADS}"))
}

/// A path and a value.
pub(super) fn setting(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((path, value)) if !path.trim().is_empty() => Ok((path.trim().to_owned(), value.trim().to_owned())),
        _ => Err("allowed is PATH=VALUE, for example time.dt=2ms".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absurd_numbers_of_threads_are_refused() {
        assert_eq!((thread_count("0"), thread_count("1024")), (Ok(0), Ok(1024)));
        for absurd in ["1025", "100000", "18446744073709551615", "18446744073709551616", "-1", "two"] {
            assert_eq!(thread_count(absurd), Err("allowed is 0 to 1024".into()), "{absurd}");
        }
    }

    #[test]
    fn a_setting_is_a_path_and_a_value() {
        assert_eq!(setting("time.dt = 2e-3"), Ok(("time.dt".into(), "2e-3".into())));
        assert_eq!(setting("title=a=b"), Ok(("title".into(), "a=b".into())));
        assert!(setting("time.dt").is_err() && setting("=3").is_err());
    }
}
