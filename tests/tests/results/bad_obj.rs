//! Models that cannot be used are refused with file, line, entity, value and what is allowed; odd ones that can be are used.

use pliant_tests::Bench;
use pliant_tests::models::CUBE;

const SCENE: &str = r#"format = 1
[time]
duration = 0.01
[[body]]
mesh = "model.obj"
size = "40 mm"
material = { plugin = "mass-spring" }
grid = { level = 4 }
[[device]]
name = "hand"
frame = { body = "body", from = [0.4, 0.6, 2.0], toward = [0.4, 0.6, 0.5] }
params = { path = [[0.0, 0.0, 0.0, 0.004], [0.01, 0.0, 0.0, 0.001]] }
[[tool]]
name = "finger"
device = "hand"
radius = "4 mm"
[[edit]]
kind = "touch"
tool = "finger"
"#;

fn bench(model: impl AsRef<[u8]>) -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", SCENE);
    bench.write("model.obj", model);
    bench
}

/// The cube with a line of a vertex in the place of the seventh.
fn vertex(line: &str) -> Vec<u8> {
    CUBE.replace("v 1 1 1", line).into_bytes()
}

/// The cube with one more line, the fifteenth.
fn and(line: &str) -> Vec<u8> {
    format!("{CUBE}{line}").into_bytes()
}

#[test]
fn a_model_that_cannot_be_used_is_refused_and_nothing_is_written() {
    let number = "allowed: a finite decimal number";
    let range = "allowed: 1 to 8, or -1 to -8 counting back";
    let utf16: Vec<u8> = CUBE.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let junk: Vec<u8> = (0..40_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8 | 1).collect();
    for (what, model, said) in [
        ("cut off in a vertex", and("v 1 2"), &["model.obj:15:", "`v` has 2 numbers", "allowed: 3"][..]),
        ("cut off in a face", and("f 1 2"), &[":15:", "`f` has 2 corners", "allowed: 3 or more"]),
        ("cut off in a normal", and("vn 1"), &[":15:", "`vn` has 1 numbers", "allowed: 3"]),
        ("cut off in a texture", and("vt"), &[":15:", "`vt` has 0 numbers", "allowed: 1"]),
        ("not a number", vertex("v 1 nan 1"), &["model.obj:7:", "`v`", "`nan`", number]),
        ("infinite", vertex("v 1 -inf 1"), &[":7:", "`v`", "`-inf`", number]),
        ("too large", vertex("v 1 1e999 1"), &[":7:", "`v`", "`1e999`", number]),
        ("hexadecimal", vertex("v 0x1 1 1"), &[":7:", "`v`", "`0x1`", number]),
        ("comma", vertex("v 1,0 1 1"), &[":7:", "`v`", "`1,0`", number]),
        ("words", vertex("v one one one"), &[":7:", "`v`", "`one`", number]),
        ("no weight", vertex("v 1 1 1 0"), &[":7:", "w = `0`", "allowed: any finite w but 0"]),
        ("normal", and("vn 0 0 inf"), &[":15:", "`vn`", "`inf`", number]),
        ("beyond the last", and("f 1 2 9"), &[":15:", "corner `9`", "no such v", range]),
        ("beyond any", and("f 1 2 99999999999999999999"), &[":15:", "`99999999999999999999`", "no such v", range]),
        ("zero", and("f 0 1 2"), &[":15:", "corner `0`", "no such v", range]),
        ("before the first", and("f -1 -2 -9"), &[":15:", "corner `-9`", "no such v", range]),
        ("half an index", and("f 1.5 2 3"), &[":15:", "corner `1.5`", "allowed: v, v/vt, v//vn or v/vt/vn"]),
        ("no texture", and("f 1/1 2/1 3/1"), &[":15:", "corner `1`", "no such vt", "the file has none"]),
        ("too many parts", and("f 1/1/1/1 2 3"), &[":15:", "`1/1/1/1`", "allowed: v, v/vt, v//vn or v/vt/vn"]),
        ("a vertex twice", and("f 1 2 2"), &[":15:", "`f` names vertex 2 twice", "allowed: each vertex once"]),
        ("no faces", CUBE[..64].into(), &[":9:", "8 vertices but no faces", "allowed: one `f` line at least"]),
        ("no vertices", b"# a title\nf 1 2 3\n".into(), &[":3:", "no vertices", "allowed: one `v` line"]),
        ("empty", Vec::new(), &[":1:", "the file is empty", "allowed: one `v` and one `f`"]),
        ("blank", b" \n\t\r\n".into(), &[":3:", "the file is empty", "allowed: one `v` and one `f`"]),
        ("zeros", vec![0; 4096], &[":1:", "a NUL byte", "allowed: OBJ text in UTF-8 or Latin-1"]),
        ("UTF-16", utf16, &[":1:", "a NUL byte", "UTF-16", "allowed: OBJ text"]),
        ("junk", junk, &["model.obj:", "no vertices", "allowed: one `v` line"]),
        (
            "a point",
            b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n".into(),
            &["body `body`", "longest edge", "is 0", "above 0"],
        ),
        ("5 MB of a number", and(&format!("v {} 0 0", "1".repeat(5_000_000))), &[":15:", "`v`", "1111…`", number]),
        ("5 MB of a face", and(&format!("f {}", "1 2 3 4 ".repeat(600_000))), &[":15:", "vertex 1 twice", "allowed"]),
    ] {
        let bench = bench(model);
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]);
        assert_eq!(ran.code, 2, "{what}: {}", ran.err);
        assert!(ran.err.len() < 400 && !ran.err.contains("panicked"), "{what}: {}", ran.err);
        ran.says(said).says(&["error: ./model.obj:"]);
        assert_eq!(bench.names("."), ["model.obj", "scene.toml"], "{what}: nothing was written");
    }
}

#[test]
fn a_model_that_is_not_there_or_no_file_is_refused() {
    let bench = bench(CUBE);
    std::fs::create_dir(bench.path("folder.obj")).expect("a folder");
    for name in ["nowhere.obj", "folder.obj"] {
        let set = format!("body.0.mesh={name}");
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out", "--set", &set]).expect(2);
        ran.says(&["scene.toml:5:8: no file ./", name, "relative to the scene"]);
        bench.pliant(&["run", "scene.toml", "--out", "out", "--mesh", name]).expect(2).says(&[name, "cannot be read"]);
    }
    assert!(!bench.path("out").exists());
}

#[test]
fn a_model_with_odd_lines_is_used_as_it_is() {
    for (what, model) in [
        ("line ends", CUBE.replace('\n', "\r\n").into_bytes()),
        ("old line ends", CUBE.replace('\n', "\r").into_bytes()),
        ("tabs", CUBE.replace(' ', "\t").into_bytes()),
        ("byte order mark", format!("\u{feff}{CUBE}").into_bytes()),
        ("Latin-1", [b"# caf\xe9 \xff\ng t\xeate\n", CUBE.as_bytes()].concat()),
        ("continuations", CUBE.replace("v 1 1 1", "v 1 \\\n 1 \\\r\n1").into_bytes()),
        ("5 MB of a comment", format!("# {}\n{CUBE}", "x".repeat(5_000_000)).into_bytes()),
        ("other ways to write a number", vertex("v +1 1. .1e1 1 # here")),
        ("colours", vertex("v 1 1 1 0.5 0.5 0.5")),
        ("words nobody knows", format!("hello world\n{CUBE}f\u{e9}e 3\n").into_bytes()),
        ("no line end at the end", CUBE.trim_end().into()),
    ] {
        let bench = bench(&model);
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
        assert!(bench.summary("out")["event_counts"].get("model").is_none(), "{what}");
        assert!(bench.summary("out")["contact_steps"].as_u64() > Some(0), "{what}");
        bench.pliant(&["run", "scene.toml", "-q", "--out", "idle", "--set", "edit=[]"]).expect(0);
        assert!(bench.read("idle/final.obj") == model, "{what} come back");
    }
}

#[test]
fn a_model_with_doubtful_faces_is_used_and_the_summary_tells() {
    for (line, said) in [
        ("v 2 0 0\nf 1 2 9\n", "triangles without area: 1, at face 7 (line 16); allowed: an area above"),
        ("f 4 3 2 1\n", "duplicate triangles: 2, at face 7 (line 15)"),
        ("v 0.5 0.5 0.5\nf 1 2 9\n", "edges of more than two triangles: 1, at edge 1-2 (line 9); allowed: one or two"),
        ("v 9 9 9\n", "vertices no face uses: 1, at vertex 9 (line 15); allowed: any number"),
        ("v 1 1 1\nf 7 9 3\n", "edges of no length: 1, at edge 7-9 (line 16)"),
    ] {
        let bench = bench(and(line));
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
        let summary = bench.summary("out");
        let told = |e: &serde_json::Value| e["text"].as_str().is_some_and(|t| t.contains(said));
        assert!(summary["events"].as_array().is_some_and(|e| e.iter().any(told)), "{said}: {}", summary["events"]);
        let plan = bench.pliant(&["plan", "scene.toml"]).expect(0).out;
        assert!(plan.contains(said), "{said}: {plan}");
    }
}
