//! Files of cloth: fabrics of one's own, and forces as a picture.

use pliant_tests::Bench;

const SCENE: &str = r#"format = 1
gravity = [0, -9.81, 0]
[time]
duration = 1
dt = 1
integrator = "quasi-static"
[[body]]
shape = { kind = "sheet", cells = 4, rows = 16, size = [0.05, 0.2, 0], pattern = "regular" }
sheet = { warp = [0, 1, 0] }
material = { plugin = "cloth", params = { fabric-file = "own/wool.toml", bending = "none" } }
[[body.fixed]]
box = [[-1, 0.1999, -1], [1, 1, 1]]
[[probe]]
name = "sag"
quantity = "displacement"
at = [0.025, 0, 0]
expected = 3.924e-4
tolerance = 0.002
source = "rho g L^2 / 2 E"
[output]
forces = true
"#;

const WOOL: &str = "# a strip of wool, hung\nsource = \"nobody: a test\"\nunknown = \"thickness\"\n\ndensity = 0.2\nyoung-warp = 100\npoisson = 0\nshear = 20\n";

fn bench(scene: &str, fabric: &str) -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", scene);
    bench.write("own/wool.toml", fabric);
    bench
}

#[test]
fn a_fabric_of_ones_own_is_read_beside_the_scene() {
    let run = ["run", "scene.toml", "-q", "--out", "out"];
    bench(SCENE, WOOL).pliant(&run).expect(0);
    // What the scene gives goes before the file: half the stiffness, twice the sag.
    let softer = SCENE.replace("bending = \"none\"", "bending = \"none\", young-warp = 50");
    bench(&softer.replace("3.924e-4", "7.848e-4"), WOOL).pliant(&run).expect(0);
    bench(&softer, WOOL).pliant(&run).expect(1);
}

#[test]
fn what_is_wrong_with_it_is_told_with_file_and_line() {
    for (scene, fabric, said) in [
        (
            SCENE.to_owned(),
            WOOL.replace("density = 0.2", "density = \"light\""),
            &["wool.toml:5:", "`density`", "allowed is a number"][..],
        ),
        (SCENE.to_owned(), WOOL.replace("shear", "sheer"), &["wool.toml:8:", "`sheer`", "young-warp"]),
        (SCENE.to_owned(), WOOL.replace("poisson = 0", "poisson 0"), &["wool.toml:7:"]),
        (SCENE.to_owned(), WOOL.replace("source = \"nobody: a test\"\n", ""), &["wool.toml:1:", "`source`"]),
        (SCENE.to_owned(), WOOL.replace("young-warp = 100\n", ""), &["wool.toml", "stretch", "`young-warp`"]),
        (SCENE.to_owned(), WOOL.replace("shear = 20\n", ""), &["wool.toml", "`shear`"]),
        (SCENE.to_owned(), WOOL.replace("density = 0.2\n", ""), &["wool.toml", "`density`"]),
        (SCENE.replace(", bending = \"none\"", ""), WOOL.to_owned(), &["wool.toml", "`bending-warp`"]),
        (SCENE.replace("bending = \"none\"", "fabric = \"denim\""), WOOL.to_owned(), &["`fabric` and `fabric-file`"]),
        (SCENE.replace("own/wool", "own/silk"), WOOL.to_owned(), &["silk.toml"]),
    ] {
        let ran = bench(&scene, &fabric).pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(2);
        ran.says(&["scene.toml:10:"]).says(said);
    }
}

/// Attributes of the arrows of a class: x1, y1, x2, y2.
fn arrows(svg: &str, class: &str) -> Vec<[f64; 4]> {
    let of_class = format!("<line class=\"{class}\"");
    let number = |line: &str, key: &str| {
        let at = line.find(&format!(" {key}=\"")).expect("the attribute") + key.len() + 3;
        line[at..].split('"').next().and_then(|text| text.parse().ok()).expect("a number")
    };
    svg.lines()
        .filter(|line| line.starts_with(&of_class))
        .map(|line| ["x1", "y1", "x2", "y2"].map(|key| number(line, key)))
        .collect()
}

#[test]
fn forces_that_hold_nodes_are_drawn_as_arrows() {
    let bench = bench(SCENE, WOOL);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    let svg = String::from_utf8(bench.read("out/forces.svg")).expect("UTF-8");
    let held = arrows(&svg, "held");
    assert_eq!((held.len(), arrows(&svg, "tip").len()), (5, 0), "five nodes hold the strip:\n{svg}");
    // Along y, which is to the upper right at 30 degrees, on a page whose y goes down.
    for [x1, y1, x2, y2] in &held {
        assert!(x2 > x1 && ((y1 - y2) / (x2 - x1) - 30_f64.to_radians().tan()).abs() < 0.02, "{held:?}");
    }
    let longest = held.iter().map(|[x1, y1, x2, y2]| (x2 - x1).hypot(y2 - y1)).fold(0.0, f64::max);
    assert!((longest - 160.0).abs() < 0.1, "a fifth of the page: {longest}");
    // The nodes inside of the edge carry a quarter of the weight each; those at its ends together one more.
    let told: f64 =
        svg.split("longest arrow ").nth(1).and_then(|t| t.split(' ').next()).and_then(|t| t.parse().ok()).expect("N");
    let weight = 0.2 * 0.05 * 0.2 * 9.81;
    assert!((told / (0.25 * weight) - 1.0).abs() < 0.2, "{told} N of {weight} N");
    // Nothing is drawn that was not asked for.
    let plain = SCENE.replace("forces = true", "");
    let other = Bench::new();
    other.write("scene.toml", plain);
    other.write("own/wool.toml", WOOL);
    other.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    assert!(!other.names("out").contains(&"forces.svg".to_owned()));
    other.write("scene.toml", SCENE.replace("forces = true", "forces = 1"));
    other.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(2).says(&["scene.toml:21:", "forces"]);
}

#[test]
fn each_fabric_says_where_its_numbers_come_from_and_what_is_not_known() {
    let bench = Bench::new();
    bench.pliant(&["plugin", "info", "cloth"]).expect(0).out.find("Wang, O'Brien and Ramamoorthi 2011").expect("named");
    let told = bench.pliant(&["plugin", "info", "cloth", "--json"]).expect(0).json();
    let params = told["plugins"][0]["params"].as_array().expect("parameters");
    let fabric = params.iter().find(|p| p["key"] == "fabric").expect("fabric");
    let choices = fabric["choices"].as_array().expect("choices");
    for choice in choices {
        let source = &fabric["sources"][choice.as_str().expect("a name")];
        assert!(["source", "unknown"].iter().all(|k| source[k].as_str().is_some_and(|t| !t.is_empty())), "{choice}");
    }
    let sweater = fabric["sources"]["sweater"]["unknown"].as_str().expect("told");
    assert!(sweater.contains("indefinite"), "{sweater}");
    assert!(params.iter().filter(|p| p["key"] != "fabric").all(|p| p["sources"].is_null()));
}
