//! The projected Laplacian in a scene: what is refused with it, that explicit steps know its limit, and that it is told of.

use pliant_tests::{Bench, root};

const SCENE: &str = r#"format = 1
gravity = [0, 0, -9.81]
[time]
integrator = "backward-euler"
duration = 0.01
[[body]]
name = "cloth"
shape = { kind = "sheet", cells = 8, rows = 8, pattern = "alternating", size = [0.01, 0.01, 0] }
sheet = { warp = [1, 0, 0] }
material = { plugin = "cloth", params = { bending = "projected-laplacian", bending-warp = 1e-3, young-warp = 1 } }
"#;

fn bench(scene: &str) -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", scene);
    bench
}

#[test]
fn what_makes_no_sense_with_it_is_refused_by_name() {
    for (key, value) in [("bending-hysteresis", "0.01"), ("bending-bias", "1e-3")] {
        let scene = SCENE.replace("young-warp", &format!("{key} = {value}, young-warp"));
        let said = bench(&scene).pliant(&["run", "scene.toml", "-q"]).expect(2).err;
        assert!(said.contains(key) && said.contains("projected-laplacian"), "{said}");
    }
}

#[test]
fn a_sheet_that_is_not_flat_is_refused_with_its_fold() {
    let bench = bench(&SCENE.replace(
        "shape = { kind = \"sheet\", cells = 8, rows = 8, pattern = \"alternating\", size = [0.01, 0.01, 0] }",
        "mesh = \"sheet.obj\"",
    ));
    let bent = std::fs::read(root().join("scenes/sleeve.obj")).expect("a sleeve");
    bench.write("sheet.obj", bent);
    let said = bench.pliant(&["run", "scene.toml", "-q"]).expect(3).err;
    assert!(said.contains("hinge ") && said.contains(" rad at rest") && said.contains("flat"), "{said}");
}

#[test]
fn explicit_steps_know_its_limit() {
    let bench = bench(SCENE);
    let explicit = ["run", "scene.toml", "-q", "--set", "time.integrator=symplectic-euler", "--set", "time.dt=1e-3"];
    let said = bench.pliant(&explicit).expect(2).err;
    assert!(said.contains("substeps"), "{said}");
    let soft = "body.0.material.params={ bending = \"none\", young-warp = 1 }";
    bench.pliant(&[&explicit[..], &["--set", soft]].concat()).expect(0);
}

#[test]
fn it_is_told_of() {
    let told = Bench::new().pliant(&["plugin", "info", "cloth"]).expect(0).out;
    assert!(told.contains("projected-laplacian"), "{told}");
}
