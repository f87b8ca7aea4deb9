//! Parameters that differ from place to place: against bars of two stiffnesses, from all sources a scene may name, and what is refused.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_tests::bar::{FACTORS, MATERIALS, SHEET, SOLID, STRAIN, energy, energy_in_series, halves, open_bar};
use pliant_tests::{Bench, open_file};

/// A bar along x about the origin, whole, with fields.
fn bar(bench: &Bench, material: &str, params: &str, fields: &str) -> Session {
    open_bar(bench, if material == "cloth" { SHEET } else { SOLID }, material, params, fields)
}

/// In series the softer half gives way: 1/k is the sum of those of the halves. In parallel k is their mean.
#[test]
fn bars_of_two_stiffnesses_are_as_stiff_as_theory_says() {
    for (material, params, param) in MATERIALS {
        let bench = Bench::new();
        let mut plain = bar(&bench, material, params, "");
        let uniform = energy(&mut plain, [STRAIN, STRAIN]);
        assert!(uniform > 0.0);
        let mut series = bar(&bench, material, params, &halves(param, 0));
        let found = energy_in_series(&mut series) / uniform;
        let exact = 2.0 / (1.0 / FACTORS[0] + 1.0 / FACTORS[1]);
        assert!((found / exact - 1.0).abs() < 0.01, "{material} {param} in series: {found}, exact {exact}");
        let mut parallel = bar(&bench, material, params, &halves(param, 1));
        let found = energy(&mut parallel, [STRAIN, STRAIN]) / uniform;
        let exact = 0.5 * (FACTORS[0] + FACTORS[1]);
        assert!((found / exact - 1.0).abs() < 0.01, "{material} {param} in parallel: {found}, exact {exact}");
    }
}

/// Mass of the nodes of the first body, kg.
fn mass(session: &Session) -> f64 {
    session.bodies[0].system.nodes.mass.iter().sum()
}

#[test]
fn mass_follows_the_fields_of_density_and_thickness() {
    for (material, param) in
        [("mass-spring", "density"), ("neo-hookean", "density"), ("corotational", "density"), ("cloth", "thickness")]
    {
        let bench = Bench::new();
        let plain = mass(&bar(&bench, material, "", ""));
        let found = mass(&bar(&bench, material, "", &halves(param, 0))) / plain;
        let exact = 0.5 * (FACTORS[0] + FACTORS[1]);
        assert!((found / exact - 1.0).abs() < 1e-9, "{material}: {found}, exact {exact}");
    }
}

/// A cube with a group of its left face, red from 0 at the left to 1 at the right.
fn cube() -> String {
    let mut text = String::new();
    for i in 0..8 {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2];
        text += &format!("v {x} {y} {z} {x} 0.5 0\n");
    }
    text += "g rest\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\ng left\nf 1 5 7 3\n";
    text
}

fn coloured(bench: &Bench, fields: &str, region: &str) -> Session {
    bench.write("cube.obj", cube());
    let text = format!(
        "format = 1\n[time]\nduration = 0.01\n[[body]]\nmesh = \"cube.obj\"\nsize = 0.1\nmaterial = {{ plugin = \"corotational\" }}\n\
         grid = {{ level = 5, region = \"{region}\" }}\n{fields}\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.04]]\n\
         path = [[0, 0, 0, 0], [1, 1e-9, 0, 0]]\n"
    );
    let mut session = open_file(&bench.write("scene.toml", text), 1, None);
    session.step();
    session
}

/// Mass of the nodes at a height over the left side, m, in a slice through the middle; the ratio to that without fields.
fn mass_by_x(session: &Session, plain: &Session, x: f64) -> f64 {
    let of = |session: &Session| -> f64 {
        let nodes = &session.bodies[0].system.nodes;
        // Away from the other sides, which are nearer to what is there.
        let near = |r: &Vec3| (r.x - x).abs() < 1e-3 && r.y.abs() < 0.011 && r.z.abs() < 0.011;
        nodes.rest.iter().zip(&nodes.mass).filter(|(r, _)| near(r)).map(|(_, m)| m).sum()
    };
    of(session) / of(plain)
}

#[test]
fn groups_colours_and_files_reach_from_the_surface_through_the_depth() {
    let bench = Bench::new();
    let plain = coloured(&bench, "", "whole");
    let group = coloured(&bench, "[[body.field]]\nparam = \"density\"\ngroup = \"left\"\nfactor = 5.0", "whole");
    let (left, right) = (mass_by_x(&group, &plain, -0.05), mass_by_x(&group, &plain, 0.05));
    assert!((left - 5.0).abs() < 1e-9 && (right - 1.0).abs() < 1e-9, "{left} {right}");
    let colour = coloured(&bench, "[[body.field]]\nparam = \"density\"\ncolour = \"red\"\nrange = [0.5, 8.0]", "whole");
    // Cells beside the faces x = 0 and 1 have the factors of their faces.
    let (left, right) = (mass_by_x(&colour, &plain, -0.05), mass_by_x(&colour, &plain, 0.05));
    assert!((left - 0.5).abs() < 1e-9 && (right - 8.0).abs() < 1e-9, "{left} {right}");
    bench.write("factors.csv", "# one a vertex\n0.5\n8\n0.5\n8\n0.5\n8\n0.5\n8\n");
    let csv = coloured(&bench, "[[body.field]]\nparam = \"density\"\ncsv = \"factors.csv\"", "whole");
    let pairs = csv.bodies[0].system.nodes.mass.iter().zip(&colour.bodies[0].system.nodes.mass);
    assert!(pairs.clone().count() > 100 && pairs.clone().all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
}

#[test]
fn what_a_field_cannot_be_is_refused() {
    let cases: [(&str, &str, &[&str]); 9] = [
        (
            "corotational",
            "param = \"poisson\"\ngroup = \"left\"\nfactor = 2.0",
            &["`poisson` cannot differ", "young, density"],
        ),
        ("corotational", "param = \"young\"\ngroup = \"left\"\nfactor = 11.0", &["factor 11", "0.1 to 10"]),
        ("corotational", "param = \"young\"\ngroup = \"right\"\nfactor = 2.0", &["`right`", "`rest`, `left`"]),
        (
            "corotational",
            "param = \"young\"\nball = [1, 0, 0]\nradius = 0.1\nfactor = 2.0",
            &["meets no part of the body"],
        ),
        ("corotational", "param = \"young\"\ngroup = \"left\"", &["`field` has `group`", "allowed is"]),
        ("corotational", "param = \"young\"\ncsv = \"none.csv\"", &["none.csv"]),
        ("corotational", "param = \"young\"\ncsv = \"few.csv\"", &["2 factors; expected one per vertex (8)"]),
        ("corotational", "param = \"young\"\ncolour = \"red\"\nrange = [0.0, 2.0]", &["range [0, 2]"]),
        (
            "mass-spring",
            "param = \"flexion\"\ngroup = \"left\"\nfactor = 2.0",
            &["`flexion` cannot differ", "young, density"],
        ),
    ];
    for (material, field, said) in cases {
        let bench = Bench::new();
        bench.write("cube.obj", cube());
        bench.write("few.csv", "1\n2\n");
        bench.write(
            "scene.toml",
            format!(
                "format = 1\n[[body]]\nmesh = \"cube.obj\"\nsize = 0.1\nmaterial = {{ plugin = \"{material}\" }}\ngrid = {{ region = \"whole\" }}\n\
                 [[body.field]]\n{field}\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]\npath = [[0, 0, 0, 0], [1, 1e-9, 0, 0]]\n"
            ),
        );
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]);
        assert_eq!(ran.code, 2, "{field}: {}", ran.err);
        assert!(ran.err.starts_with("error: scene.toml:"), "{field}: {}", ran.err);
        ran.says(said);
    }
}

/// A local region has the same factors as the whole body, wherever it is.
#[test]
fn a_stroke_over_a_border_of_stiffness_feels_both_sides() {
    let bench = Bench::new();
    let force = |fields: &str| {
        let text = pliant_tests::box_scene("", "", "").replace("[[device]]", &format!("{fields}\n[[device]]"));
        bench.write("scene.toml", text);
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
        bench.summary("out")["largest_force"].as_f64().expect("a force")
    };
    let field =
        |factor: f64| format!("[[body.field]]\nparam = \"young\"\nbox = [[-1, -1, -1], [1, 1, 1]]\nfactor = {factor}");
    let (soft, plain, stiff) = (force(&field(0.5)), force(""), force(&field(2.0)));
    assert!(soft < 0.95 * plain && plain < 0.95 * stiff, "{soft} {plain} {stiff} N");
}
