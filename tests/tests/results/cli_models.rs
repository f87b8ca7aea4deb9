//! Models of one's own in a scene, and the sample, schema and completions to start with.

use pliant_mesh::ObjDocument;
use pliant_mesh::testing::models;
use pliant_tests::models::{CUBE, elephant, moved_lines};
use pliant_tests::{Bench, box_scene, root, shared_mesh};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The scene with another model in it, planned and run: the plan's first body.
fn tried(bench: &Bench, mesh: &Path) -> Value {
    let mesh = mesh.to_str().expect("UTF-8");
    let plan = bench.pliant(&["plan", "scene.toml", "--mesh", mesh, "--json"]).expect(0).json();
    bench.pliant(&["run", "scene.toml", "-q", "--mesh", mesh, "--out", "out"]).expect(0);
    assert!(bench.summary("out")["contact_steps"].as_u64() > Some(0), "the finger touches {mesh}");
    plan["bodies"][0].clone()
}

/// Each model takes the box's place: as large as it was, and pressed.
fn are_put_in_place(bench: &Bench, meshes: &[PathBuf]) {
    bench.write("scene.toml", box_scene("", "position = [0.3, 0.2, 0.1]", ""));
    let own = bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json();
    for mesh in meshes {
        let body = tried(bench, mesh);
        let cell = body["edge"].as_f64().expect("a number") / own["bodies"][0]["edge"].as_f64().expect("a number");
        assert!((cell - 1.0).abs() < 1e-3, "{}: as large as the box was, but {cell} times", mesh.display());
        assert_eq!(body["model"].as_str(), mesh.to_str());
        let (before, after) = (std::fs::read(mesh).expect("read"), bench.read("out/final.obj"));
        assert!(moved_rows(&before, &after) > 0, "{}: it was pressed", mesh.display());
    }
}

/// How many vertices of a model are elsewhere. Where no normal was parted its lines tell; new rows move the faces that name them.
fn moved_rows(before: &[u8], after: &[u8]) -> usize {
    let document = |bytes: &[u8]| ObjDocument::parse(bytes.to_vec(), Path::new("model.obj")).expect("a model");
    let [from, to] = [before, after].map(document);
    if from.normals().len() == to.normals().len() {
        return moved_lines(before, after);
    }
    let faces = |document: &ObjDocument| -> Vec<Vec<u32>> {
        let mut faces: Vec<Vec<u32>> =
            document.shaded_faces().iter().map(|face| face.iter().map(|corner| corner[0]).collect()).collect();
        faces.sort_unstable();
        faces
    };
    assert_eq!((from.positions().len(), faces(&from)), (to.positions().len(), faces(&to)));
    assert!(to.normals().len() > from.normals().len(), "rows are added, none goes");
    from.positions().iter().zip(to.positions()).filter(|(a, b)| a != b).count()
}

#[test]
fn any_model_is_put_in_place_scaled_to_fit() {
    let bench = Bench::new();
    let huge: String =
        CUBE.lines().map(|l| if l.starts_with('v') { l.replace('1', "1e6") } else { l.into() } + "\n").collect();
    let texts =
        [("cube", CUBE.to_owned()), ("huge", huge), ("elephant", elephant())].map(|(n, text)| (n.to_owned(), text));
    let made = models(6, 1).into_iter().map(|model| (model.name, model.text));
    let meshes = texts.into_iter().chain(made).map(|(name, text)| bench.write(&format!("{name}.obj"), text));
    are_put_in_place(&bench, &meshes.collect::<Vec<_>>());
}

#[test]
#[ignore = "needs ../shared/meshes"]
fn real_models_are_put_in_place_scaled_to_fit() {
    are_put_in_place(&Bench::new(), &["suzanne.obj", "spot.obj", "teapot.obj"].map(shared_mesh));
}

#[test]
fn the_sample_is_the_elephant_of_the_scenes() {
    let bench = Bench::new();
    bench.pliant(&["sample"]).expect(0).says(&["elephant.obj and elephant.mtl"]);
    for name in ["elephant.obj", "elephant.mtl"] {
        assert!(bench.read(name) == std::fs::read(root().join("scenes").join(name)).expect("read"), "{name}");
    }
    bench.write("elephant.mtl", "my own");
    bench.write("elephant.obj", "my own");
    bench.pliant(&["sample"]).expect(2).says(&["elephant.obj exists already", "--force"]);
    bench.pliant(&["sample", "-o", "other.obj"]).expect(2).says(&["elephant.mtl exists already", "--force"]);
    assert!(!bench.path("other.obj").exists());
    assert_eq!((bench.read("elephant.obj"), bench.read("elephant.mtl")), (b"my own".to_vec(), b"my own".to_vec()));
    bench.pliant(&["sample", "--force", "--detail", "1"]).expect(0);
    assert!(bench.read("elephant.obj").starts_with(b"# elephant: a sample made by pliant"));
    bench.pliant(&["sample", "-o", "deep/er/model.obj"]).expect(0);
    assert_eq!(bench.names("deep/er"), ["elephant.mtl", "model.obj"]);
}

#[test]
fn completions_know_every_verb() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish"] {
        let script = bench.pliant(&["completions", shell]).expect(0).out;
        for word in ["run", "plan", "plugin", "info", "schema", "completions", "sample", "plugin-path", "threads"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
        assert!(script.contains("pliant"), "{shell}");
    }
}

/// Whether `schema` allows every key of `value`, or the path of the first it does not.
fn allows(root: &Value, schema: &Value, value: &toml::Value, path: &str) -> Result<(), String> {
    if let Some(name) = schema["$ref"].as_str() {
        let target = root.pointer(name.trim_start_matches('#')).ok_or_else(|| format!("{path}: no {name}"))?;
        return allows(root, target, value, path);
    }
    if let Some(any) = schema["anyOf"].as_array() {
        let tried: Vec<_> = any.iter().map(|one| allows(root, one, value, path)).collect();
        return if tried.iter().any(Result::is_ok) { Ok(()) } else { tried.into_iter().next().unwrap_or(Ok(())) };
    }
    match value {
        toml::Value::Table(table) => table.iter().try_for_each(|(key, value)| {
            let path = format!("{path}.{key}");
            match schema["properties"].get(key) {
                Some(inner) => allows(root, inner, value, &path),
                None if schema["additionalProperties"] == true => Ok(()),
                None => Err(path),
            }
        }),
        toml::Value::Array(list) => list.iter().try_for_each(|one| allows(root, &schema["items"], one, path)),
        toml::Value::String(_)
        | toml::Value::Integer(_)
        | toml::Value::Float(_)
        | toml::Value::Boolean(_)
        | toml::Value::Datetime(_) => Ok(()),
    }
}

#[test]
fn the_schema_names_every_key_of_the_scenes() {
    let schema = Bench::new().pliant(&["schema"]).expect(0).json();
    assert_eq!(schema["title"], "Scene");
    let mut scenes = 0;
    for entry in std::fs::read_dir(root().join("scenes")).expect("scenes/").flatten() {
        if entry.path().extension().is_some_and(|e| e == "toml") {
            let scene: toml::Table = std::fs::read_to_string(entry.path()).expect("read").parse().expect("TOML");
            allows(&schema, &schema, &toml::Value::Table(scene), "").unwrap_or_else(|key| panic!("{entry:?}: {key}"));
            scenes += 1;
        }
    }
    assert!(scenes >= 3, "{scenes} scenes");
    let wrong: toml::Table = "body = [{ grid = { levle = 4 } }]".parse().expect("TOML");
    assert_eq!(allows(&schema, &schema, &toml::Value::Table(wrong), ""), Err(".body.grid.levle".into()));
}
