//! Models of few faces are subdivided: dents have vertices to show them, and what the file had stays.

use pliant_mesh::ObjDocument;
use pliant_mesh::testing::models;
use pliant_tests::{Bench, box_scene, open};

/// A block of 40 mm of `cells` squares along an edge, pressed 3 mm deep by a ball of 4 mm.
fn block(cells: u32, subdivide: &str) -> String {
    let shape = format!("cells = {cells}");
    box_scene("", subdivide, "").replace("cells = 12", &shape)
}

#[test]
fn a_cube_of_eight_corners_has_the_dent_of_a_fine_one() {
    let felt = |cells: u32, subdivide: &str| {
        let mut session = open(&block(cells, subdivide), 1);
        (0..40).for_each(|_| session.step());
        session.update_surface();
        let body = &session.bodies[0];
        let moved = body.skin.x.iter().zip(&body.model.surface.points).map(|(x, at)| (x - at).norm());
        (session.frame().tools[0].force.norm(), moved.fold(0.0, f64::max), body.model.surface.points.len())
    };
    let (fine_force, fine_dent, _) = felt(32, "");
    let (coarse_force, coarse_dent, _) = felt(1, "");
    assert!(coarse_dent < 0.2 * fine_dent, "{coarse_dent} {fine_dent}");
    for subdivide in ["subdivide = \"auto\"", "subdivide = 5"] {
        let (force, dent, vertices) = felt(1, subdivide);
        assert_eq!(vertices, 6 * 32 * 32 + 2, "sides of 40 mm are halved to 1.25 mm: under half of 4 mm, 2.5 is over");
        // The same lattice, touched on the same plane: what differs is where the tool finds its triangles.
        assert!((force / fine_force - 1.0).abs() < 0.01 && (dent / fine_dent - 1.0).abs() < 0.01, "{force} {dent}");
    }
    assert!(coarse_force > 0.0);
}

#[test]
fn results_of_any_model_have_its_vertices_first_and_its_faces_divided() {
    for model in models(4, 9) {
        let bench = Bench::new();
        bench.write("model.obj", &model.text);
        let scene = r#"
            format = 1
            [time]
            duration = 0.003
            [[body]]
            mesh = "model.obj"
            size = "100 mm"
            subdivide = 2
            material = { plugin = "mass-spring" }
            [[device]]
            name = "hand"
            params = { path = [[0, 0, 0, 0.2], [1, 0, 0, 0.2]] }
            [[tool]]
            name = "ball"
            device = "hand"
            radius = "6 mm"
            [[edit]]
            kind = "touch"
            tool = "ball"
            "#;
        bench.write("scene.toml", scene);
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
        let read = |name: &str| ObjDocument::read(&bench.path(name)).unwrap();
        let (before, after) = (read("model.obj"), read("out/final.obj"));
        let once = before.subdivided().unwrap();
        assert_eq!(after.face_count(), once.faces_subdivided(), "{}", model.name);
        assert_eq!(&after.positions()[..before.positions().len()], before.positions(), "{}", model.name);
        assert_eq!(after.groups(), before.groups(), "{}", model.name);
        let chosen = bench.summary("out")["choices"]["subdivisions"].clone();
        assert_eq!((&chosen[0]["level"], &chosen[0]["why"]), (&2.into(), &"the scene asks for it".into()), "{chosen}");
    }
}

#[test]
fn what_cannot_be_subdivided_is_refused_at_its_place() {
    let bench = Bench::new();
    for (value, said) in [
        ("0", "allowed is a whole number from 1"),
        ("11", "allowed is 1 to 10, or \"auto\""),
        ("\"twice\"", "allowed is a whole number from 1, or \"auto\""),
        ("10", "memory"),
    ] {
        bench.write("scene.toml", block(12, &format!("subdivide = {value}")));
        let ran = bench.pliant(&["plan", "scene.toml"]).expect(2);
        assert!(ran.err.contains(said) && ran.err.contains("scene.toml:"), "{value}: {}", ran.err);
    }
}
