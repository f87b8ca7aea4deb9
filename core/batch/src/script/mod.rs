//! Launchers: scripts that run the shards of a sweep with a workload manager.

use std::fmt;
use std::path::PathBuf;

/// A workload manager.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Slurm: a job array.
    Slurm,
    /// HyperQueue: a task array.
    HyperQueue,
    /// Dask: a Python program with a task for each shard.
    Dask,
    /// GNU parallel, on one machine or several.
    Parallel,
    /// Snakemake: a Snakefile with a rule for the shards and one that collects them.
    Snakemake,
}

impl Engine {
    /// The template of the script; `@NAME@` is replaced by a value.
    fn template(self) -> &'static str {
        match self {
            Self::Slurm => include_str!("slurm.sh"),
            Self::HyperQueue => include_str!("hyperqueue.sh"),
            Self::Dask => include_str!("dask.py"),
            Self::Parallel => include_str!("parallel.sh"),
            Self::Snakemake => include_str!("snakemake.smk"),
        }
    }

    /// Whether texts are quoted for Python; otherwise for a shell.
    fn is_python(self) -> bool {
        matches!(self, Self::Dask | Self::Snakemake)
    }
}

/// Contents of a launcher.
#[derive(Clone, Debug)]
pub struct Launch {
    /// Path of the program on the machines that run shards.
    pub program: PathBuf,
    /// Options before the sweep, such as folders of plugins.
    pub options: Vec<String>,
    /// Path of the sweep file on those machines.
    pub sweep: PathBuf,
    /// Folder of the results, the same on all machines.
    pub out: PathBuf,
    /// Number of shards.
    pub shards: u64,
    /// Number of parallel runs of each shard.
    pub jobs: usize,
}

/// A script that runs all shards with an engine; comments at its beginning explain its use.
pub fn launcher(engine: Engine, launch: &Launch) -> String {
    let quote = if engine.is_python() { python } else { shell };
    let path = |path: &PathBuf| quote(&path.to_string_lossy());
    let options: Vec<String> = launch.options.iter().map(|option| quote(option)).collect();
    let options = match (engine.is_python(), options.is_empty()) {
        (true, _) => options.iter().map(|option| format!("{option}, ")).collect(),
        (false, true) => String::new(),
        (false, false) => format!(" {}", options.join(" ")),
    };
    let name = launch.sweep.file_stem().unwrap_or_default().to_string_lossy();
    let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let values = [
        ("@PROGRAM@", path(&launch.program)),
        ("@OPTIONS@", options),
        ("@SWEEP@", path(&launch.sweep)),
        ("@OUT@", path(&launch.out)),
        ("@SHARDS@", launch.shards.to_string()),
        ("@JOBS@", launch.jobs.to_string()),
        ("@NAME@", name),
    ];
    values.iter().fold(engine.template().to_owned(), |text, (from, to)| text.replace(from, to))
}

/// A text for a shell, in quotes if it needs them.
fn shell(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text.into() } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

/// A text as a Python literal, which a JSON string is.
fn python(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

impl fmt::Display for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Slurm => "slurm",
            Self::HyperQueue => "hyperqueue",
            Self::Dask => "dask",
            Self::Parallel => "parallel",
            Self::Snakemake => "snakemake",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_launcher_runs_every_shard_and_leaves_no_placeholder() {
        for engine in [Engine::Slurm, Engine::HyperQueue, Engine::Dask, Engine::Parallel, Engine::Snakemake] {
            let launch = Launch {
                program: "/opt/my tools/pliant".into(),
                options: vec!["--plugin-path".into(), "/opt/plug ins".into()],
                sweep: "it's.toml".into(),
                out: "out/a".into(),
                shards: 37,
                jobs: 4,
            };
            let text = launcher(engine, &launch);
            let placeholder = text
                .split('@')
                .skip(1)
                .step_by(2)
                .find(|word| word.chars().all(|c| c.is_ascii_uppercase()) && !word.is_empty());
            assert_eq!(placeholder, None, "{engine}");
            assert!(text.contains("37") && text.contains("--resume"), "{engine}");
            let quoted = if engine.is_python() { "\"/opt/my tools/pliant\"" } else { "'/opt/my tools/pliant'" };
            assert!(text.contains(quoted), "{engine}: {text}");
        }
        assert_eq!(shell("it's"), r"'it'\''s'");
    }
}
