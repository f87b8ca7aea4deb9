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

#[test]
#[cfg(unix)]
fn a_library_that_crashes_ends_or_blocks_is_told_by_info_and_doctor() {
    let bench = Bench::new();
    for (stem, body, how) in [
        ("crashes", "volatile int *nowhere = 0; *nowhere = 1;", "was ended by signal 11"),
        ("ends", "_Exit(0);", "ended with code 0"),
        ("blocks", "for (;;) {}", "did not end within 1 s"),
    ] {
        let at_load = format!("__attribute__((constructor)) static void at_load(void) {{ {body} }}\n");
        let path = bench.compile("plugins", stem, &format!("#include <stdlib.h>\n{at_load}")).display().to_string();
        for verb in [["plugin", "info"], ["device", "doctor"]] {
            let ran = bench.pliant(&[&verb[..], &[&path, "--seconds", "1"]].concat()).expect(3);
            ran.says(&[&format!("error: {path}: cannot be used"), how]);
        }
    }
}

#[test]
#[cfg(unix)]
fn a_device_that_crashes_when_it_is_asked_is_told_by_the_doctor() {
    let bench = Bench::new();
    bench.pliant(&["plugin", "new", "arm", "--kind", "device", "--lang", "c"]).expect(0);
    let source = std::fs::read_to_string(bench.path("arm/src/arm.c")).expect("read");
    let own = "static pliant_status ask(const pliant_plugin *p, void *data, pliant_say say) {\n\
               (void)p, (void)data, (void)say; abort(); }\n\
               static const pliant_probe own_probe = {sizeof(pliant_probe), ask};\n";
    let (rendered, tables) = ("static const pliant_rendered rendered_table", "(strcmp(id, PLIANT_RENDERED) == 0");
    assert!(source.contains(rendered) && source.contains(tables), "the template has changed");
    let both = tables.replace("(strcmp", "(strcmp(id, PLIANT_PROBE) == 0 ? (const void *)&own_probe : strcmp");
    let source = source.replace(rendered, &format!("{own}{rendered}")).replace(tables, &both);
    let path = bench.compile("lib", "arm", &source).display().to_string();
    bench.pliant(&["device", "doctor", &path]).expect(3).says(&[&path, "cannot be used", "signal 6 (abort)"]);
    bench.pliant(&["device", "doctor", &path, "--set", "no-key=1"]).expect(2).says(&["no-key"]);
    let neo = library("neo-hookean").path().display().to_string();
    bench.pliant(&["device", "doctor", &neo]).expect(2).says(&["is not a device"]);
    bench.pliant(&["plugin", "info", &path]).expect(0);
}
