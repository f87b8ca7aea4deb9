//! The budget: given, or a share of the machine's memory.

use super::size::format_bytes;
use std::fmt;

/// Share of the machine's memory that a session may take by default; the rest is for the system and other programs.
const MACHINE_SHARE: f64 = 0.75;

/// Largest memory of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryBudget {
    /// Allowed memory, bytes; `None` for any amount.
    bytes: Option<u64>,
    /// Whether it is the default share of the machine's memory.
    is_default: bool,
}

impl MemoryBudget {
    /// A budget of this many bytes.
    pub fn new(bytes: u64) -> Self {
        Self { bytes: Some(bytes), is_default: false }
    }

    /// Allowed memory, bytes; `u64::MAX` without a limit.
    pub fn bytes(&self) -> u64 {
        self.bytes.unwrap_or(u64::MAX)
    }
}

impl Default for MemoryBudget {
    /// Three quarters of the machine's memory, or of what its control group allows this process if that is less. No limit where the system
    /// tells neither.
    fn default() -> Self {
        let bytes = machine_memory().map(|all| (MACHINE_SHARE * all as f64) as u64);
        Self { bytes, is_default: true }
    }
}

impl fmt::Display for MemoryBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.bytes, self.is_default) {
            (None, _) => f.write_str("any amount: this system does not tell its memory"),
            (Some(bytes), false) => f.write_str(&format_bytes(bytes)),
            (Some(bytes), true) => write!(f, "{}, three quarters of this machine's memory", format_bytes(bytes)),
        }
    }
}

/// Memory of the machine, or of the control group of this process if that is less, bytes; `None` if the system tells neither.
fn machine_memory() -> Option<u64> {
    let read = |path| std::fs::read_to_string(path).unwrap_or_default();
    let info = read("/proc/meminfo");
    let total = info.lines().find_map(|line| line.strip_prefix("MemTotal:")?.trim().strip_suffix("kB"));
    let total = total.and_then(|kilobytes| kilobytes.trim().parse::<u64>().ok()).map(|kilobytes| 1024 * kilobytes);
    let group = read("/sys/fs/cgroup/memory.max").trim().parse::<u64>().ok();
    total.into_iter().chain(group).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_said_to_be_the_machines() {
        let budget = MemoryBudget::default();
        assert!(budget.bytes() > 100_000_000, "{budget}");
        assert!(budget.to_string().contains("machine") || budget.bytes() == u64::MAX, "{budget}");
        assert_eq!(MemoryBudget::new(2_000_000_000).to_string(), "2.00 GB");
    }
}
