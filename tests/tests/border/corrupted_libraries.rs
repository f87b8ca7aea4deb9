//! A library that crashes whoever opens it is listed with its path, by `plugin list` and `device list`, and the others are listed all the same.

use pliant_mesh::testing::Random;
use pliant_tests::native::file_name;
use pliant_tests::{Bench, Ran, library};
use serde_json::Value;

/// Lists plugins and devices with the folder `plugins`, as JSON.
fn lists(bench: &Bench) -> [Ran; 2] {
    ["plugin", "device"].map(|verb| bench.pliant(&[verb, "list", "--plugin-path", "plugins", "--json"]))
}

/// The entries of a list that are unusable: the path or reason of each.
fn unusable(plugins: &Value, devices: &Value) -> [Vec<String>; 2] {
    let texts = |list: &Value, key: &str| {
        let rows = list.as_array().expect("a list").iter();
        rows.filter_map(|row| row[key].as_str().map(str::to_owned)).collect()
    };
    [texts(&plugins["plugins"], "error"), texts(&devices["unusable"], "found")]
}

#[test]
#[cfg(unix)]
fn a_library_that_crashes_or_ends_the_process_is_unusable_and_the_others_are_listed() {
    let bench = Bench::new();
    let constructor = |body: &str| {
        format!(
            "#include <stdlib.h>\n#include <stdio.h>\n\
             __attribute__((constructor)) static void at_load(void) {{ {body} }}\n"
        )
    };
    bench.compile("plugins", "crashes", &constructor("volatile int *nowhere = 0; *nowhere = 1;"));
    bench.compile("plugins", "ends", &constructor("printf(\"{\\\"answer\\\": 1\"); fflush(stdout); _Exit(0);"));
    bench.compile("plugins", "quits", &constructor("abort();"));
    bench.write(
        &format!("plugins/{}", file_name("middle")),
        std::fs::read(library("mass-spring").path()).expect("read"),
    );
    let [plugins, devices] = lists(&bench).map(|ran| ran.expect(3).json());
    let rows = plugins["plugins"].as_array().expect("a list");
    let has =
        |path: &str| rows.iter().any(|r| r["id"].is_string() && r["path"].as_str().is_some_and(|p| p.ends_with(path)));
    assert!(has(&file_name("middle")) && has(&file_name("pliant_scripted")), "{plugins}");
    assert!(devices["devices"].as_array().is_some_and(|all| all.iter().any(|d| d["id"] == "scripted")), "{devices}");
    for errors in unusable(&plugins, &devices) {
        assert_eq!(errors.len(), 3, "{errors:?}");
        for (stem, how) in [("crashes", "signal 11"), ("ends", "with code 0"), ("quits", "signal 6")] {
            let told = |error: &&String| error.contains(&file_name(stem)) && error.contains(how);
            assert_eq!(errors.iter().filter(told).count(), 1, "{stem}: {errors:?}");
        }
    }
    let doctor = bench.pliant(&["device", "doctor", "--plugin-path", "plugins", "--json"]).expect(1).json();
    let mut host = doctor["host"].as_array().expect("a list").iter();
    assert!(host.any(|found| found["what"] == "plugin `crashes`" && found["state"] == "missing"), "{doctor}");
    let text = bench.pliant(&["plugin", "list", "--plugin-path", "plugins"]).expect(3);
    assert!(text.out.contains("unusable    crashes"), "{}", text.out);
}

#[test]
fn copies_with_flipped_bytes_never_end_the_list() {
    let bench = Bench::new();
    let real = std::fs::read(library("scripted").path()).expect("read");
    let mut random = Random(38);
    for number in 0..60 {
        let mut bytes = real.clone();
        if number % 4 == 0 {
            bytes.truncate(random.below(real.len() as u64) as usize);
        }
        // Among the tables of the linker, where a flip does most.
        for _ in 0..1 + random.below(8) {
            let at = random.below(bytes.len().clamp(1, 16_384) as u64) as usize;
            bytes.get_mut(at).into_iter().for_each(|byte| *byte ^= 1 << random.below(8));
        }
        bench.write(&format!("plugins/{}", file_name(&format!("copy{number:02}"))), bytes);
    }
    let [plugins, devices] = lists(&bench);
    for ran in [&plugins, &devices] {
        assert!([0, 3].contains(&ran.code), "{}: {}", ran.code, ran.err);
    }
    let rows = plugins.json()["plugins"].as_array().cloned().expect("a list");
    assert!(rows.iter().any(|row| row["id"] == "mass-spring"), "{rows:?}");
    let of_copies = |row: &&Value| row["path"].as_str().is_some_and(|path| path.contains("copy"));
    assert_eq!(rows.iter().filter(of_copies).count(), 60, "each is listed, usable or not");
    assert!(devices.json()["devices"].as_array().is_some_and(|all| all.iter().any(|d| d["id"] == "scripted")));
}
