//! A material that wants whole lists: a neural network in a C project, beside the same that does not say so.

use pliant_tests::{Bench, program, warning_codes};
use std::process::Command;

/// The functions of the project's section "constitutive law" that the network replaces.
const NETWORK: &str = include_str!("neural.c");
const REPLACED: [&str; 2] = ["static pliant_status energy(", "static const pliant_material table"];

/// What else the project needs: a parameter for the time that each call waits, and the header of a clock.
const EDITS: [(&str, &str); 3] = [
    ("#include <string.h>\n", "#include <string.h>\n#include <time.h>\n"),
    ("DAMPING_TIME, PARAMS", "DAMPING_TIME, LATENCY, PARAMS"),
    (
        "0.0, 1.0, 2e-4, NULL, 0},\n",
        "0.0, 1.0, 2e-4, NULL, 0},\n    {PLIANT_PARAM_NUMBER, \"latency\", \"s\", \"time each call waits\", 0.0, 1.0, 0.0, NULL, 0},\n",
    ),
];

/// The descriptor's flags.
const FLAGS: &str = "PLIANT_FLAG_REAL_TIME | PLIANT_FLAG_DETERMINISTIC";

/// A project with the network as its material, and these flags.
fn project(bench: &Bench, name: &str, flags: &str) {
    bench.pliant(&["plugin", "new", name, "--kind", "material", "--lang", "c"]).expect(0);
    let source = format!("{name}/src/{name}.c");
    let mut text = String::from_utf8(bench.read(&source)).expect("UTF-8");
    let [begin, end] = REPLACED.map(|line| text.find(line).expect("a line of the project"));
    text.replace_range(begin..end, NETWORK);
    for (from, to) in EDITS.into_iter().chain([(FLAGS, flags)]) {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text = text.replace(from, to);
    }
    bench.write(&source, text);
    let built = Command::new("make").current_dir(bench.path(name)).env("PLIANT", program()).output().expect("make");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
}

/// Runs the scene of a project, and returns the shape it ends with and whether a call had a part of the list.
fn run(bench: &Bench, name: &str, threads: &str) -> (Vec<u8>, bool) {
    let (scene, out) = (format!("{name}/scene.toml"), format!("{name}/out-{threads}"));
    let threads = ["--threads", threads, "--oversubscribe", "--set", "time.duration=\"0.05 s\""];
    let args = [&["run", &scene, "--plugin-path", name, "--out", &out][..], &threads].concat();
    bench.pliant(&args).expect(0);
    let divided = warning_codes(&bench.summary(&out)).iter().any(|code| code == "plugin-warning");
    (bench.read(&format!("{out}/final.obj")), divided)
}

/// Coordinates of the vertices of an OBJ file, m.
fn coordinates(obj: &[u8]) -> Vec<f64> {
    let text = String::from_utf8_lossy(obj).into_owned();
    let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
    lines.flat_map(str::split_whitespace).map(|number| number.parse().expect("a number")).collect()
}

#[test]
#[cfg_attr(not(unix), ignore = "needs make and a C compiler with the options of GNU and Clang")]
fn a_network_gets_whole_lists_and_moves_as_with_divided_ones() {
    let bench = Bench::new();
    project(&bench, "neural", "PLIANT_FLAG_DETERMINISTIC | PLIANT_FLAG_WHOLE_LISTS");
    project(&bench, "divided", "PLIANT_FLAG_DETERMINISTIC");
    let [whole, divided] = [("neural", false), ("divided", true)].map(|(name, is_divided)| {
        let [one, two] = ["1", "2"].map(|threads| run(&bench, name, threads));
        assert_eq!([one.1, two.1], [is_divided; 2], "{name}: whether a call had a part of the list");
        assert!(one.0 == two.0, "{name}: other bytes with two threads");
        coordinates(&one.0)
    });
    // Elements give the same bytes; their sums at nodes differ by rounding, for parts are added in another order.
    let apart = whole.iter().zip(&divided).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(whole.len() == divided.len() && apart < 1e-12, "{apart} m apart");
    let library = format!("neural/{}", pliant_tests::native::file_name("neural"));
    let checked = bench.pliant(&["plugin", "check", &library]).expect(0);
    assert!(checked.out.contains("ok       whole-lists-are-taken"), "{}", checked.out);
    let info = bench.pliant(&["plugin", "info", "neural", "--plugin-path", "neural"]).expect(0);
    assert!(info.out.contains("gets whole lists"), "{}", info.out);
    let info = bench.pliant(&["plugin", "info", "divided", "--plugin-path", "divided", "--json"]).expect(0).json();
    assert_eq!(info["plugins"][0]["whole_lists"], false);
}
