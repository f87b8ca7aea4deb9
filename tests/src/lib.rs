//! What the tests of the whole share: finding the program and its plugins, running scenes, reading results.
//!
//! Cargo builds plugins as shared libraries beside the test executables, in `deps/`; the program is looked for one folder up.
//! `cargo test --workspace` builds both.

pub mod arm;
pub mod bar;
pub mod batch;
pub mod bout;
pub mod breaking;
pub mod cloth;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
pub mod faults;
pub mod models;
pub mod native;
pub mod pulling;
pub mod result_sets;
pub mod solid;
pub mod sweep;
pub mod table;
pub mod tetrahedral;
pub mod twin;
pub mod wall;

use pliant_host::{Library, SearchPath};
use pliant_mesh::geometry::Vec3;
use pliant_solver::StepTime;
use serde_json::Value;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::time::{Duration, Instant};

/// A step of a millisecond, where a test asks for what a body is in it.
pub const NOW: StepTime = StepTime { start: 0.0, dt: 1e-3 };

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ is in the repository").to_path_buf()
}

/// Where this test executable is: `target/PROFILE/deps`.
pub fn deps() -> PathBuf {
    std::env::current_exe().expect("a running test has a path").parent().expect("in a folder").to_path_buf()
}

/// The `pliant` program of the same build.
///
/// # Panics
/// If it was not built.
pub fn program() -> PathBuf {
    let path = deps().parent().expect("deps/ is in a folder").join(format!("pliant{}", std::env::consts::EXE_SUFFIX));
    assert!(path.is_file(), "{} is not there: run `cargo test --workspace`, which builds it", path.display());
    path
}

/// A file cargo has built beside this test, by its name.
///
/// # Panics
/// If it was not built.
pub fn built(name: &str) -> PathBuf {
    let path = deps().join(name);
    assert!(path.is_file(), "{} is not there", path.display());
    path
}

/// A plugin library of the same build.
///
/// # Panics
/// If it was not built or cannot be opened.
pub fn library(name: &str) -> &'static Library {
    let found = SearchPath::new(&[deps()]).find(name, Path::new(".")).unwrap_or_else(|e| panic!("{e}"));
    Library::open(&found.path).unwrap_or_else(|e| panic!("{e}"))
}

/// A model of the folder `../shared/meshes`. Tests that need one are ignored by default.
///
/// # Panics
/// If it is not there.
pub fn shared_mesh(name: &str) -> PathBuf {
    let path = root().join("../shared/meshes").join(name);
    assert!(path.is_file(), "{} is not there", path.display());
    path
}

/// Numbers of the random cases that an environment variable asks for, as `0..2000`, if it is set.
///
/// # Panics
/// If it is no such range.
pub fn asked_cases(variable: &str) -> Option<Range<u64>> {
    let text = std::env::var(variable).ok()?;
    let range = text.split_once("..").and_then(|(first, end)| Some(first.parse().ok()?..end.parse().ok()?));
    Some(range.unwrap_or_else(|| panic!("{variable} is {text}; allowed is a range such as 0..2000")))
}

/// Number of random cases, each drawn after the one before it: the end of the range that an environment variable asks for, else `usual`.
///
/// # Panics
/// As [`asked_cases`].
pub fn case_count(variable: &str, usual: usize) -> usize {
    asked_cases(variable).map_or(usual, |asked| asked.end as usize)
}

/// A folder of its own with scenes and results in it.
pub struct Bench {
    folder: tempfile::TempDir,
}

/// How a run of the program ended.
pub struct Ran {
    /// Exit code of the program.
    pub code: i32,
    /// What it wrote to standard output.
    pub out: String,
    /// What it wrote to standard error.
    pub err: String,
}

impl From<Output> for Ran {
    /// A process that was killed has code -1.
    fn from(Output { status, stdout, stderr }: Output) -> Self {
        let [out, err] = [stdout, stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        Self { code: status.code().unwrap_or(-1), out, err }
    }
}

impl Ran {
    /// Standard output as JSON.
    ///
    /// # Panics
    /// If it is not.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e} in:\n{}\n{}", self.out, self.err))
    }

    /// The same run, if it ended with this code.
    ///
    /// # Panics
    /// If it did not, with everything it said.
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, code, "\n---- out\n{}\n---- err\n{}\n----", self.out, self.err);
        self
    }

    /// The same run, if it said all of this on standard error.
    ///
    /// # Panics
    /// If it did not, with what is missing.
    pub fn says(self, parts: &[&str]) -> Self {
        for part in parts {
            assert!(self.err.contains(part), "`{part}` is not in:\n{}", self.err);
        }
        self
    }
}

/// Codes of the warnings in the summary of a run, or in the JSON of a run or a plan.
///
/// # Panics
/// If the document has no list of warnings.
pub fn warning_codes(document: &Value) -> Vec<String> {
    let list = document["warnings"].as_array().expect("a list");
    list.iter().map(|w| w["code"].as_str().expect("a code").to_owned()).collect()
}

/// Kinds of the plugins that were loaded, by the summary of a run or the JSON of a plan.
///
/// # Panics
/// If the document has no list of plugins.
pub fn loaded_kinds(document: &Value) -> Vec<String> {
    let list = document["loaded"].as_array().expect("a list");
    list.iter().map(|plugin| plugin["kind"].as_str().expect("a kind").to_owned()).collect()
}

/// Asks again and again until it holds, every few milliseconds.
///
/// # Panics
/// If it does not hold within a minute.
pub fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < Duration::from_secs(60), "{what}: not within a minute");
        std::thread::sleep(Duration::from_millis(5));
    }
}

impl Default for Bench {
    fn default() -> Self {
        Self::new()
    }
}

impl Bench {
    /// An empty one.
    ///
    /// # Panics
    /// If the system gives no folder.
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// A path in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file in it.
    ///
    /// # Panics
    /// If it cannot be written.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("in a folder")).expect("folder");
        std::fs::write(&path, bytes).expect("written");
        path
    }

    /// A file's bytes.
    ///
    /// # Panics
    /// If it is not there.
    pub fn read(&self, name: &str) -> Vec<u8> {
        let path = self.path(name);
        std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    /// Names in a folder of it, sorted; none where there is no such folder.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).into_iter().flatten().flatten();
        let mut names: Vec<String> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The summary a run left in a folder of it.
    ///
    /// # Panics
    /// If there is none.
    pub fn summary(&self, folder: &str) -> Value {
        serde_json::from_slice(&self.read(&format!("{folder}/summary.json"))).expect("JSON")
    }

    /// Temporary folders of the results of runs into `out` that are under way, or were killed.
    pub fn stages(&self) -> Vec<String> {
        let is_stage = |name: &String| name.starts_with("out.pliant-") && name.ends_with(".partial");
        self.names(".").into_iter().filter(is_stage).collect()
    }

    /// Waits until a run into `out` has written rows of its trace in a temporary folder that is none of `older`; they reach the file some
    /// dozens at a time.
    ///
    /// # Panics
    /// If the run ends before.
    pub fn wait_for_rows(&self, run: &mut Child, older: &[String]) {
        self.wait_for_trace(run, older, |rows| !rows.is_empty());
    }

    /// The same, until what it has written holds.
    ///
    /// # Panics
    /// If the run ends before.
    pub fn wait_for_trace(&self, run: &mut Child, older: &[String], holds: impl Fn(&str) -> bool) {
        let written = |stage: &String| {
            let trace = |name: &String| name.starts_with("trace.csv.pliant-") && name.ends_with(".partial");
            let text = |name: String| std::fs::read_to_string(self.path(&format!("{stage}/{name}"))).ok();
            !older.contains(stage)
                && self.names(stage).into_iter().filter(trace).filter_map(text).any(|rows| holds(&rows))
        };
        while !self.stages().iter().any(written) {
            assert!(run.try_wait().expect("asked").is_none(), "it ended by itself");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Looks for numbers that are not finite in the files of a run.
    ///
    /// # Panics
    /// If there is one.
    pub fn is_finite(&self, folder: &str, what: &str) {
        let names = self.names(folder);
        assert!(names.iter().any(|name| name == "summary.json"), "{what}: {names:?}");
        for name in names.iter().filter(|name| self.path(&format!("{folder}/{name}")).is_file()) {
            let text = String::from_utf8(self.read(&format!("{folder}/{name}"))).expect("UTF-8");
            let mut words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
            let odd = words.find(|word| word.parse::<f64>().is_ok_and(|v| !v.is_finite()));
            assert_eq!(odd, None, "{what}: {name}");
        }
    }

    /// Runs `pliant` in it.
    ///
    /// # Panics
    /// If the program cannot be started.
    pub fn pliant(&self, args: &[&str]) -> Ran {
        self.pliant_with(args, &[])
    }

    /// Runs `pliant` in it with environment variables.
    ///
    /// # Panics
    /// If the program cannot be started.
    pub fn pliant_with(&self, args: &[&str], environment: &[(&str, &str)]) -> Ran {
        let mut command = self.command(args);
        Ran::from(command.envs(environment.iter().copied()).output().expect("the program starts"))
    }

    /// `pliant` with these arguments, to be run in it: with its own plugins only.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(program());
        command.args(args).current_dir(self.folder.path());
        command.env_remove("PLIANT_PLUGIN_PATH").env("XDG_DATA_HOME", self.path("nobody"));
        command
    }
}

/// A small scene: a box pressed by a finger from above, with lines put into it.
pub fn box_scene(time: &str, body: &str, rest: &str) -> String {
    format!(
        r#"format = 1
[time]
duration = 0.05
{time}
[[body]]
name = "block"
shape = {{ kind = "box", cells = 12, size = [0.04, 0.04, 0.04] }}
material = {{ plugin = "mass-spring" }}
grid = {{ level = 5 }}
{body}
[[device]]
name = "hand"
frame = {{ body = "block", from = [0.45, 0.55, 2.0], toward = [0.45, 0.55, 0.5] }}
params = {{ path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]] }}
[[tool]]
name = "finger"
device = "hand"
radius = "4 mm"
[[edit]]
kind = "touch"
tool = "finger"
{rest}
"#
    )
}

/// A body that fills its cells.
#[derive(Debug)]
pub struct Everywhere;

impl pliant_engine::body::BodyInterior for Everywhere {
    fn triangles_near(&self, _: Vec3, _: f64) -> Vec<[Vec3; 3]> {
        Vec::new()
    }

    fn contains(&self, _: Vec3) -> bool {
        true
    }
}

/// Opens a scene given as text.
///
/// # Panics
/// If it cannot be opened.
pub fn open(text: &str, threads: usize) -> pliant_engine::session::Session {
    let bench = Bench::new();
    open_file(&bench.write("scene.toml", text), threads, None)
}

/// The scene file of an editor's draft, opened as an editor does: strokes are not mirrored before that is asked for.
///
/// # Panics
/// If it cannot be.
pub fn open_drafted(path: &Path) -> pliant_engine::session::Session {
    use pliant_engine::session::SessionCommand;
    let mut session = open_file(path, 1, None);
    let off = SessionCommand::SetSymmetry { axes: [false; 3], centre: pliant_mesh::geometry::Vec3::zeros() };
    assert!(session.apply(off), "its edits can be mirrored");
    session
}

/// A scene file, opened; with another model in the place of its first body's, if one is given.
///
/// # Panics
/// If it cannot be.
pub fn open_file(path: &Path, threads: usize, mesh: Option<PathBuf>) -> pliant_engine::session::Session {
    use pliant_engine::plan::Plan;
    use pliant_engine::scene;
    use pliant_engine::session;
    let (scene, source) = scene::load(path, &[]).unwrap_or_else(|e| panic!("{e}"));
    let plan = Plan::new(&scene, &source).unwrap_or_else(|e| panic!("{e}"));
    // As many threads as a test asks for, on any machine.
    let options =
        session::Options { mesh, oversubscribe: true, ..session::Options::new(SearchPath::new(&[deps()]), threads) };
    session::Session::open(&scene, &source, plan, &options).unwrap_or_else(|e| panic!("{e}"))
}
