//! Permission for real-time priority.

use crate::probe::Finding;

/// Bit of `CAP_SYS_NICE` in a capability mask.
#[cfg(target_os = "linux")]
const CAP_SYS_NICE: u32 = 23;

/// What these findings are about.
const WHAT: &str = "real-time rights";

/// Whether a haptic thread may have real-time priority, from the limits and capabilities of this process.
#[cfg(target_os = "linux")]
pub fn realtime_rights() -> Finding {
    rights_from([LIMITS, STATUS].map(std::fs::read_to_string))
}

/// File with the limits of this process.
#[cfg(target_os = "linux")]
const LIMITS: &str = "/proc/self/limits";
/// File with the capabilities of this process.
#[cfg(target_os = "linux")]
const STATUS: &str = "/proc/self/status";

/// Whether a haptic thread may have real-time priority, from the text of [`LIMITS`] and [`STATUS`].
#[cfg(target_os = "linux")]
fn rights_from([limits, status]: [std::io::Result<String>; 2]) -> Finding {
    let mask = status.and_then(|text| field(&text, "CapEff:", |mask| u64::from_str_radix(mask, 16).ok()));
    if mask.as_ref().is_ok_and(|mask| mask >> CAP_SYS_NICE & 1 == 1) {
        return Finding::present(WHAT, "CAP_SYS_NICE");
    }
    let limit = limits.and_then(|text| field(&text, "Max realtime priority", |limit| Some(limit.to_owned())));
    match (limit, mask) {
        (Ok(limit), _) if limit != "0" => Finding::present(WHAT, format!("real-time priority up to {limit}")),
        (Ok(_), Ok(_)) => Finding::degraded(
            WHAT,
            "the limit of the real-time priority is 0",
            "add `@USERS - rtprio 80` to /etc/security/limits.conf and log in again, or expect missed deadlines under load",
        ),
        (Err(error), _) => unknown(LIMITS, &error),
        (_, Err(error)) => unknown(STATUS, &error),
    }
}

/// The first word after `name` at the beginning of a line, read by `parse`.
///
/// # Errors
/// A text without such a line, and a word that cannot be read.
#[cfg(target_os = "linux")]
fn field<T>(text: &str, name: &str, parse: impl FnOnce(&str) -> Option<T>) -> std::io::Result<T> {
    let line = text.lines().find_map(|line| line.strip_prefix(name));
    let value = line.and_then(|line| parse(line.split_whitespace().next()?));
    value.ok_or_else(|| std::io::Error::other(format!("it has no `{name}` that can be read")))
}

/// The finding if a file of the system does not tell.
#[cfg(target_os = "linux")]
fn unknown(file: &str, error: &std::io::Error) -> Finding {
    let found = format!("unknown: {file}: {error}");
    Finding::degraded(WHAT, found, "mount /proc, or expect missed deadlines under load")
}

/// Whether a haptic thread may have real-time priority; not known on this system.
#[cfg(not(target_os = "linux"))]
pub fn realtime_rights() -> Finding {
    Finding::degraded(WHAT, "unknown: this system does not tell", "expect missed deadlines under load")
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use pliant_plugin_api::abi;
    use std::io::{Error, ErrorKind};

    /// The limits of a process with this limit of the real-time priority.
    fn limits(limit: &str) -> String {
        format!(
            "Limit                     Soft Limit           Hard Limit           Units\nMax realtime priority     {limit}                    0\n"
        )
    }

    const NONE: &str = "Name:\tpliant\nCapEff:\t0000000000000000\n";
    const NICE: &str = "CapEff:\t0000000000800000\n";

    #[test]
    fn a_limit_that_cannot_be_read_is_unknown_and_not_0() {
        let gone = || Err(Error::from(ErrorKind::PermissionDenied));
        let found = |limits, status| rights_from([limits, status]);
        let unknown = [
            (found(gone(), gone()), LIMITS),
            (found(gone(), Ok(NONE.into())), LIMITS),
            (found(Ok(String::new()), Ok(NONE.into())), LIMITS),
            (found(Ok(limits("0")), gone()), STATUS),
        ];
        for (finding, file) in unknown {
            assert!(finding.found.starts_with(&format!("unknown: {file}: ")), "{finding:?}");
            assert_eq!(finding.severity, abi::WARNING);
        }
        assert_eq!(found(Ok(limits("0")), Ok(NONE.into())).found, "the limit of the real-time priority is 0");
        assert_eq!(found(Ok(limits("80")), gone()).found, "real-time priority up to 80");
        assert_eq!(found(gone(), Ok(NICE.into())).found, "CAP_SYS_NICE");
    }
}
