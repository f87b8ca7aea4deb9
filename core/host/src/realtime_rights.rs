//! Permission for real-time priority.

use crate::probe::Finding;

/// Bit of `CAP_SYS_NICE` in a capability mask.
#[cfg(target_os = "linux")]
const CAP_SYS_NICE: u32 = 23;

/// Whether a haptic thread may have real-time priority, from the limits and capabilities of this process.
#[cfg(target_os = "linux")]
pub fn realtime_rights() -> Finding {
    let read = |file| std::fs::read_to_string(file).unwrap_or_default();
    let (limits, status) = (read("/proc/self/limits"), read("/proc/self/status"));
    let soft = limits.lines().find_map(|l| l.strip_prefix("Max realtime priority")).unwrap_or_default();
    let soft = soft.split_whitespace().next().unwrap_or("0");
    let mask = status.lines().find_map(|l| l.strip_prefix("CapEff:")).unwrap_or_default();
    let mask = u64::from_str_radix(mask.trim(), 16).unwrap_or(0);
    match soft {
        _ if mask >> CAP_SYS_NICE & 1 == 1 => Finding::present("real-time rights", "CAP_SYS_NICE"),
        "0" => Finding::degraded(
            "real-time rights",
            "the limit of the real-time priority is 0",
            "add `@USERS - rtprio 80` to /etc/security/limits.conf and log in again, or expect missed deadlines under load",
        ),
        soft => Finding::present("real-time rights", format!("real-time priority up to {soft}")),
    }
}

/// Whether a haptic thread may have real-time priority; not known on this system.
#[cfg(not(target_os = "linux"))]
pub fn realtime_rights() -> Finding {
    Finding::degraded("real-time rights", "unknown: this system does not tell", "expect missed deadlines under load")
}
