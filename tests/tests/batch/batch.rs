//! A sweep gives one table, however it is run.

use pliant_tests::Bench;
use pliant_tests::batch::{rows, run_batch, small_bench, small_scene, small_sweep};
use serde_json::Value;

#[test]
fn a_row_has_what_a_run_of_its_edit_has() {
    let bench = small_bench(2, "[keep]\ntrace = [\"finger.force_z_N\"]\ntrace-every = 5\nmeshes = true\n");
    run_batch(&bench, &["--out", "out"]).expect(0);
    let rows = rows(&bench, "out");
    assert_eq!(rows.len(), 6);
    for (row, [young, radius]) in rows.iter().zip([["5 kPa", "3 mm"], ["5 kPa", "4 mm"]]) {
        let (young, radius) = (format!("body.0.material.params.young={young}"), format!("tool.0.radius={radius}"));
        bench.pliant(&["run", "scene.toml", "-q", "--out", "run", "--set", &young, "--set", &radius]).expect(0);
        let summary = bench.summary("run");
        assert!(summary["largest_force"].as_f64() > Some(0.001), "{summary}");
        for key in ["largest_force", "most_nodes", "steps", "contact_steps"] {
            assert_eq!(row[key], summary[key], "{key}");
        }
        assert_eq!(row["deepest"], summary["probes"][0]["value"]);
        let trace = String::from_utf8(bench.read("run/trace.csv")).unwrap();
        let mut lines = trace.lines();
        let column = lines.next().unwrap().split(',').position(|name| name == "finger.force_z_N").unwrap();
        let forces: Vec<f64> = lines.map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect();
        let kept: Vec<f64> = [0, 5, 10, 11].map(|step| forces[step]).to_vec();
        assert_eq!(row["finger.force_z"], serde_json::json!(kept));
        let address = row["mesh"].as_str().unwrap();
        assert_eq!(bench.read(&format!("out/meshes/{}/{address}.obj", &address[..2])), bench.read("run/final.obj"));
    }
}

#[test]
fn threads_children_and_shards_give_the_same_table() {
    let bench = small_bench(4, "");
    run_batch(&bench, &["--out", "one", "--jobs", "1"]).expect(0);
    run_batch(&bench, &["--out", "three", "--jobs", "3", "--oversubscribe"]).expect(0);
    run_batch(&bench, &["--out", "children", "--jobs", "2", "--isolate"]).expect(0);
    for shard in ["1/5", "2/5", "3/5", "4/5", "5/5"] {
        run_batch(&bench, &["--out", "shards", "--shard", shard, "--jobs", "2"]).expect(0);
    }
    let collected = bench.pliant(&["batch", "collect", "shards", "--json"]).expect(0).json();
    assert_eq!((&collected["rows"], &collected["failed"]), (&Value::from(12), &Value::from(0)));
    let table = String::from_utf8(bench.read("one/results.csv")).unwrap();
    assert_eq!(table.lines().count(), 13);
    for other in ["three", "children", "shards"] {
        assert_eq!(String::from_utf8(bench.read(&format!("{other}/results.csv"))).unwrap(), table, "{other}");
    }
}

#[test]
fn no_more_edits_run_at_a_time_than_processors_and_memory_allow() {
    let bench = small_bench(4, "");
    let processors = std::thread::available_parallelism().expect("a number").get();
    let asked = (processors + 3).to_string();
    let run = |out: &str, more: &[&str]| {
        let ran = bench.pliant(&[&["batch", "sweep.toml", "--out", out, "--jobs", &asked], more].concat()).expect(0);
        (ran.err.clone(), bench.read(&format!("{out}/results.csv")))
    };
    let (said, table) = run("capped", &[]);
    let told = format!("warning: `--jobs {asked}` exceeds the {processors} processor");
    assert!(said.contains(&told) && said.contains(&format!("{processors} at a time")), "{said}");
    assert!(!said.contains("warning: memory"), "{said}");
    let (said, same) = run("all", &["--oversubscribe"]);
    assert!(!said.contains("warning") && said.contains(&format!("{asked} at a time")), "{said}");
    assert!(same == table);
    // A run takes 24 MB and more: one fits, or two.
    let needed = bench.pliant(&["batch", "sweep.toml", "--dry-run", "--json"]).expect(0).json()["edit_memory"].clone();
    let needed = needed.as_u64().expect("bytes");
    for isolate in [&[][..], &["--isolate"]] {
        let out = format!("memory-{}", isolate.len());
        let memory = (needed * 3 / 2).to_string() + " B";
        let more = [&["--memory", &memory, "--oversubscribe"][..], isolate].concat();
        assert!(!run(&format!("{out}-over"), &more).0.contains("warning"));
        let more = [&["--memory", &memory][..], isolate].concat();
        let (said, same) = run(&out, &more);
        assert!(same == table, "{out}");
        let told = format!("warning: only 1 of {processors} runs at a time fit into ");
        assert!(processors == 1 || said.contains(&told), "{said}");
    }
    let jobs = |memory: u64| {
        let memory = format!("{memory} B");
        let args = ["batch", "sweep.toml", "--dry-run", "--json", "--jobs", "2", "--memory", &memory];
        bench.pliant(&args).expect(0).json()["jobs"].clone()
    };
    assert_eq!((jobs(2 * needed), jobs(2 * needed - 1)), (processors.min(2).into(), 1.into()));
    // One that needs more than all of it fails by itself.
    let small = (needed / 2).to_string() + " B";
    let ran = bench.pliant(&["batch", "sweep.toml", "--quiet", "--out", "small", "--memory", &small]).expect(1);
    assert!(rows(&bench, "small").iter().all(|row| row["class"] == "memory-limit"), "{}", ran.err);
}

#[test]
fn what_is_there_is_not_done_again() {
    let bench = small_bench(2, "");
    run_batch(&bench, &["--out", "out"]).expect(0);
    let table = bench.read("out/results.csv");
    run_batch(&bench, &["--out", "out"]).expect(2).says(&["6 rows", "add --resume"]);
    let again = run_batch(&bench, &["--out", "out", "--resume", "--json"]).expect(0).json();
    assert_eq!((&again["new"], &again["done"]), (&Value::from(0), &Value::from(6)));
    assert_eq!(bench.read("out/results.csv"), table);
    // Another comment in the scene and another order of values change no edit; one more value is one more.
    bench.write("scene.toml", format!("# soft\n{}", small_scene()));
    let more = small_sweep(2, "").replace("[\"3 mm\", \"4 mm\", \"5 mm\"]", "[\"2 mm\", \"5 mm\", \"4 mm\", \"3 mm\"]");
    bench.write("sweep.toml", &more);
    let again = run_batch(&bench, &["--out", "out", "--resume", "--json"]).expect(0).json();
    assert_eq!((&again["new"], &again["outdated"]), (&Value::from(2), &Value::from(0)));
    run_batch(&bench, &["--out", "fresh"]).expect(0);
    assert_eq!(bench.read("out/results.csv"), bench.read("fresh/results.csv"));
}

#[test]
fn a_dry_run_counts_and_writes_nothing() {
    let bench = small_bench(100, "");
    let ran = bench.pliant(&["batch", "sweep.toml", "--dry-run", "--shard", "2/7", "--json"]).expect(0).json();
    assert_eq!((&ran["edits"], &ran["shard_edits"]), (&Value::from(300), &Value::from(43)));
    assert!(ran["seconds"].as_f64() > Some(0.0) && ran["table_bytes"].as_u64() > Some(43 * 100));
    assert_eq!(bench.names("."), ["scene.toml", "sweep.toml"]);
    let text = bench.pliant(&["batch", "sweep.toml", "--dry-run"]).expect(0).out;
    assert!(text.contains("300 runs") && text.contains("young_kPa, radius_mm"), "{text}");
}

#[test]
fn the_estimate_of_a_table_is_of_its_order() {
    let bench = small_bench(20, "");
    let bytes = bench.pliant(&["batch", "sweep.toml", "--dry-run", "--json"]).expect(0).json()["table_bytes"].clone();
    run_batch(&bench, &["--out", "out"]).expect(0);
    let found = (bench.read("out/shard-1-of-1.journal").len() + bench.read("out/shard-1-of-1.rows").len()) as f64;
    let ratio = bytes.as_f64().unwrap() / found;
    assert!((0.5..2.0).contains(&ratio), "estimated {bytes}, found {found}");
}

#[test]
fn a_sweep_that_cannot_be_is_refused_with_its_line() {
    let bench = small_bench(2, "");
    for (old, new, said) in [
        ("scene = \"scene.toml\"", "scene = \"nowhere.toml\"", "bad.toml:2:9"),
        ("tool.0.radius", "tool.7.radius", "there is no 7"),
        ("count = 2", "count = 0", "count 0; allowed is 1"),
        ("[[axis]]", "[[axes]]", "unknown field `axes`"),
    ] {
        bench.write("bad.toml", small_sweep(2, "").replace(old, new));
        bench.pliant(&["batch", "bad.toml"]).expect(2).says(&[said]);
    }
    bench.pliant(&["batch", "sweep.toml", "--shard", "3/2"]).expect(2).says(&["I from 1 to N"]);
    bench.pliant(&["batch"]).expect(2).says(&["<SWEEP>"]);
    assert!(!bench.path("out").exists());
}

#[test]
fn models_of_a_pattern_take_the_place_of_the_scenes_own() {
    let bench = Bench::new();
    bench.write("scene.toml", small_scene());
    for (name, detail) in [("a", "2"), ("b", "3")] {
        bench
            .pliant(&["sample", "elephant", "-o", &format!("models/{name}.obj"), "--detail", detail, "--force"])
            .expect(0);
    }
    bench.write("sweep.toml", "format = 1\nscene = \"scene.toml\"\nmodels = \"models/*.obj\"\n");
    run_batch(&bench, &["--out", "out"]).expect(0);
    let rows = rows(&bench, "out");
    assert_eq!([&rows[0]["model"], &rows[1]["model"]], ["models/a.obj", "models/b.obj"]);
    assert_ne!(rows[0]["deepest"], rows[1]["deepest"]);
}

#[test]
fn pictures_and_launchers_are_made_of_a_sweep() {
    let bench = small_bench(3, "");
    run_batch(&bench, &["--out", "out"]).expect(0);
    let plot = |args: &[&str]| bench.pliant(&[&["batch", "plot", "out", "young", "largest_force"], args].concat());
    plot(&["--by", "radius", "-o", "lines.svg"]).expect(0);
    let lines = String::from_utf8(bench.read("lines.svg")).unwrap();
    assert!(["young (kPa)", "largest force (N)", "radius 3 mm", "radius 5 mm"].iter().all(|part| lines.contains(part)));
    plot(&["--by", "radius", "--heat", "-o", "heat.svg"]).expect(0);
    assert!(String::from_utf8(bench.read("heat.svg")).unwrap().contains("#fde725"));
    plot(&["--by", "hue"]).expect(2).says(&["no column `hue`", "largest_force"]);
    for engine in ["slurm", "hyperqueue", "dask", "parallel", "snakemake"] {
        let args = ["batch", "script", "sweep.toml", "--engine", engine, "--shards", "8", "--out", "out"];
        assert!(bench.pliant(&args).expect(0).out.contains("--resume"), "{engine}");
    }
}

#[test]
fn the_shell_launcher_runs_every_shard() {
    let bench = small_bench(2, "");
    run_batch(&bench, &["--out", "one"]).expect(0);
    let script = ["batch", "script", "sweep.toml", "--engine", "slurm", "--shards", "3", "--out", "out"];
    let script = bench.pliant(&script).expect(0).out;
    bench.write("job.sh", script);
    // What Slurm does with it: a process for each task of the array.
    for task in ["1", "2", "3"] {
        let mut command = std::process::Command::new("bash");
        command.arg("job.sh").current_dir(bench.path(".")).env("SLURM_ARRAY_TASK_ID", task);
        assert!(command.output().unwrap().status.success());
    }
    bench.pliant(&["batch", "collect", "out"]).expect(0).says(&["6 of 6 runs, 0 failed"]);
    assert_eq!(bench.read("out/results.csv"), bench.read("one/results.csv"));
}
