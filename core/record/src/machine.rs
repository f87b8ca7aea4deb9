//! Description of the machine of a run or measurement.

use serde::Serialize;

/// Properties of a machine on which measured times depend.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Model name of the processor, or `unknown`.
    pub cpu: String,
    /// Logical processors the program may use.
    pub processors: usize,
    /// Operating system and architecture.
    pub system: String,
    /// Load average over the last minute; `None` if the system does not report it.
    pub load: Option<f64>,
}

impl Machine {
    /// The machine on which this program runs, with its current load.
    pub fn current() -> Self {
        let read = |path| std::fs::read_to_string(path).unwrap_or_default();
        let info = read("/proc/cpuinfo");
        let model = info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(':'));
        Self {
            cpu: model.map_or_else(|| "unknown".into(), |(_, m)| m.trim().to_owned()),
            processors: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            load: read("/proc/loadavg").split(' ').next().and_then(|l| l.parse().ok()),
        }
    }

    /// Peak resident memory of the program so far, bytes; `None` if the system does not report it.
    pub fn peak_memory() -> Option<u64> {
        let status = std::fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kb| kb * 1024)
    }
}
