//! A plugin that never returns, or that ends the program: the program can be ended, names the call, and does not report success.
#![cfg(unix)]

use pliant_tests::{Bench, box_scene};
use std::io::Read;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

/// File in which the material `hangs` writes the id of its process, in the bench.
const HANGS: &str = "hangs.pid";

/// A bench with a scene whose material is a faulty one.
fn bench(material: &str) -> Bench {
    let bench = Bench::new();
    let text = box_scene("", "", "").replace("\"mass-spring\"", &format!("\"faulty-plugins#{material}\""));
    bench.write("scene.toml", text);
    bench
}

/// Starts the program and waits until its plugin hangs; gives the id of the process that hangs too.
fn start_hanging(bench: &Bench, args: &[&str]) -> (Child, u32) {
    let _ = std::fs::remove_file(bench.path(HANGS));
    let mut command = bench.command(args);
    command.env("PLIANT_TEST_HANGS_FILE", bench.path(HANGS)).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("started");
    loop {
        let written = std::fs::read_to_string(bench.path(HANGS)).ok().and_then(|text| text.parse().ok());
        if let Some(pid) = written {
            return (child, pid);
        }
        assert!(child.try_wait().expect("asked").is_none(), "{args:?}: it ended before its plugin hung");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Sends a signal.
fn signal(name: &str, pid: u32) {
    let sent = Command::new("kill").args([format!("-{name}"), pid.to_string()]).status().expect("`kill` starts");
    assert!(sent.success(), "kill -{name} {pid}");
}

/// How a child ended, and what it said.
fn end(mut child: Child) -> (ExitStatus, String) {
    let mut said = String::new();
    child.stderr.take().expect("piped").read_to_string(&mut said).expect("text");
    (child.wait().expect("ended"), said)
}

/// Reads what a child says until a line has `part`.
fn wait_for_line(child: &mut Child, part: &str) {
    let stderr = child.stderr.as_mut().expect("piped");
    let (mut said, mut byte) = (Vec::new(), [0]);
    while !String::from_utf8_lossy(&said).contains(part) {
        assert_eq!(stderr.read(&mut byte).expect("readable"), 1, "{}", String::from_utf8_lossy(&said));
        said.push(byte[0]);
    }
}

#[test]
fn the_second_signal_ends_every_command_at_once_and_names_the_call() {
    let bench = bench("hangs");
    let never = "body.0.material.params.after=1e3";
    let record = ["run", "scene.toml", "-q", "--out", "out", "--set", never, "--record", "hand.rec"];
    bench.pliant(&record).expect(0);
    let at_once = "body.0.material.params.after=0";
    let commands: [(&[&str], &[&str]); 4] = [
        (&["run", "scene.toml", "-q", "--out", "run"], &["TERM", "TERM"]),
        (&["run", "scene.toml", "-q", "--out", "run"], &["INT", "TERM"]),
        // While the scene is opened there is nothing to finish: one is enough.
        (&["run", "scene.toml", "-q", "--live", "--out", "live", "--set", at_once], &["INT"]),
        (
            &["replay", "hand.rec", "-q", "--out", "again", "--set", "body.0.material.params.after=0.01"],
            &["INT", "INT"],
        ),
    ];
    for (args, signals) in commands {
        let (mut child, _) = start_hanging(&bench, args);
        signal(signals[0], child.id());
        if let Some(second) = signals.get(1) {
            wait_for_line(&mut child, "Ctrl-C again");
            signal(second, child.id());
        }
        let (status, said) = end(child);
        assert_eq!(status.code(), Some(130), "{args:?}: {said}");
        assert!(said.contains("`forces`") && said.contains("`hangs`"), "{args:?}: {said}");
    }
    // Nothing is to be finished: one is enough.
    let (child, pid) = start_hanging(&bench, &["plan", "scene.toml", "--set", at_once]);
    signal("INT", pid);
    let (status, said) = end(child);
    assert_eq!(status.code(), Some(130), "{said}");
    assert!(!bench.names(".").iter().any(|name| ["run", "again"].contains(&name.as_str()) && {
        bench.names(name).iter().any(|file| file == "summary.json")
    }));
}

#[test]
fn the_second_signal_ends_a_batch_at_once() {
    let bench = bench("hangs");
    let sweep = "format = 1\nscene = \"scene.toml\"\n[[axis]]\npath = \"time.duration\"\nlist = [0.04, 0.05]\n";
    bench.write("sweep.toml", sweep);
    let (mut child, _) = start_hanging(&bench, &["batch", "sweep.toml", "--out", "out", "-q"]);
    signal("INT", child.id());
    wait_for_line(&mut child, "Ctrl-C again");
    signal("INT", child.id());
    let (status, said) = end(child);
    assert_eq!(status.code(), Some(130), "{said}");
}

#[test]
fn an_isolated_run_ends_a_call_that_does_not_return_and_names_it() {
    let bench = bench("hangs");
    let isolated = ["run", "scene.toml", "-q", "--isolate", "--call-limit", "300 ms", "--out", "out"];
    bench.pliant(&isolated).expect(3).says(&["error: ", "`forces`", "`hangs`", "did not return within 0.3 s"]);
    assert!(!bench.names("out").contains(&"summary.json".to_owned()));
    bench.pliant(&[&isolated[..], &["--set", "body.0.material.params.after=1e3"]].concat()).expect(0);
    bench.pliant(&["run", "scene.toml", "--call-limit", "1 s"]).expect(2).says(&["--isolate"]);
}

#[test]
fn plans_and_reports_end_a_call_that_does_not_return_and_name_it() {
    let bench = bench("hangs");
    let said = ["error: ", "`forces`", "`hangs`", "did not return within 0.3 s (`--call-limit`)"];
    let at_once = "body.0.material.params.after=0";
    bench.pliant(&["plan", "scene.toml", "--call-limit", "300 ms", "--set", at_once]).expect(3).says(&said);
    let report = ["report", "accuracy", "--scene", "scene.toml", "-q", "--quick", "--out", "report"];
    let limited = [&report[..], &["--call-limit", "300 ms"]].concat();
    bench.pliant(&limited).expect(3).says(&said).says(&["the same command resumes it"]);
    // A slow step of many quick calls is none of its.
    let never = [&limited[..], &["--set", "body.0.material.params.after=1e3"]].concat();
    bench.pliant(&never).expect(0);
}

#[test]
fn signals_reach_an_isolated_run() {
    let bench = bench("hangs");
    let (mut child, hanging) = start_hanging(&bench, &["run", "scene.toml", "-q", "--isolate", "--out", "out"]);
    assert_ne!(child.id(), hanging, "the plugin is in a process of its own");
    signal("TERM", child.id());
    wait_for_line(&mut child, "Ctrl-C again");
    signal("TERM", child.id());
    assert_eq!(end(child).0.code(), Some(130));
    assert!(is_gone(hanging));
}

#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "other systems do not end a process with its parent")]
fn an_isolated_run_ends_with_its_parent() {
    let bench = bench("hangs");
    let (child, hanging) = start_hanging(&bench, &["run", "scene.toml", "-q", "--isolate", "--out", "out"]);
    signal("KILL", child.id());
    end(child);
    while !is_gone(hanging) {
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Whether a process has ended, or waits for nothing but to be asked how.
fn is_gone(pid: u32) -> bool {
    let state = Command::new("ps").args(["-o", "stat=", "-p", &pid.to_string()]).output().expect("`ps` starts").stdout;
    state.is_empty() || state.starts_with(b"Z")
}

#[test]
fn a_plugin_that_ends_the_program_is_a_failure_of_the_plugin() {
    let bench = bench("exits");
    let said = ["error: ", "`forces`", "`exits`"];
    for isolate in [&[][..], &["--isolate"]] {
        let run = [&["run", "scene.toml", "-q", "--out", "out"], isolate].concat();
        bench.pliant(&run).expect(3).says(&said);
        assert!(!bench.names("out").contains(&"summary.json".to_owned()), "{isolate:?}");
        let document = bench.pliant(&[&run[..], &["--json"]].concat()).expect(3).json();
        assert_eq!(document["exit_code"], 3, "{document}");
    }
    bench.pliant(&["plan", "scene.toml", "--set", "body.0.material.params.after=0"]).expect(3).says(&said);
    // The next run into the folder is not harmed.
    let never = ["run", "scene.toml", "-q", "--out", "out", "--set", "body.0.material.params.after=1e3"];
    bench.pliant(&never).expect(0);
    assert!(bench.names("out").iter().all(|name| !name.ends_with(".partial")) && bench.stages().is_empty());
}
