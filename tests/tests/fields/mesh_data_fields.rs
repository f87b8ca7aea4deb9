//! Fields by numbers at the nodes and elements of a tetrahedral mesh: what the material gets is what the file says, in every format, and what does not fit is refused.

use pliant_engine::session::Session;
use pliant_mesh::TetMesh;
use pliant_mesh::testing::Random;
use pliant_mesh::testing::tet_data::{TetData, VtuEncoding, VtuFormat};
use pliant_mesh::testing::tetrahedra::{TetBox, TetFormat};
use pliant_plugin_api::abi::TETRAHEDRON;
use pliant_tests::tetrahedral::{orders, scene};
use pliant_tests::{Bench, open_file};

/// Files of a mesh with numbers: names and bytes.
fn files(mesh: &TetBox, data: &TetData) -> Vec<(String, Vec<u8>)> {
    let msh = [TetFormat::Msh2, TetFormat::Msh2Binary, TetFormat::Msh4, TetFormat::Msh4Binary];
    let vtk = [TetFormat::Vtk, TetFormat::VtkBinary, TetFormat::Vtk5];
    let vtu = VtuFormat::all().filter(|format| !format.is_big_endian);
    let msh = msh.map(|format| ("box.msh".to_owned(), mesh.bytes_with(format, data)));
    let vtk = vtk.map(|format| ("box.vtk".to_owned(), mesh.bytes_with(format, data)));
    let vtu = vtu.map(|format| ("box.vtu".to_owned(), mesh.vtu_bytes(format, data)));
    msh.into_iter().chain(vtk).chain(vtu).collect()
}

fn open(name: &str, bytes: &[u8], field: &str) -> Session {
    let bench = Bench::new();
    bench.write(name, bytes);
    let text = scene("dt = 1e-3\nduration = 1", "neo-hookean", field, "gravity = [0, 0, -1]");
    open_file(&bench.write("scene.toml", text.replace("box.msh", name)), 1, None)
}

/// Factor that each element of the material gets of a parameter.
fn factors(session: &Session, param: &str) -> Vec<f64> {
    let body = &session.bodies[0];
    let plane = body.params.iter().position(|key| key == param).unwrap();
    let set = body.system.sets.iter().find(|set| set.request().kind == TETRAHEDRON).unwrap();
    set.fields()[plane * set.count()..][..set.count()].to_vec()
}

fn close(found: &[f64], exact: &[f64], tolerance: f64) {
    assert_eq!(found.len(), exact.len());
    let worst = found.iter().zip(exact).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    assert!(worst < tolerance, "{worst}");
}

#[test]
fn each_tetrahedron_gets_the_number_of_its_element() {
    for seed in 0..3 {
        let mesh = TetBox::new([3, 2, 2], [0.03, 0.02, 0.02], 0.1, seed).shuffled(seed);
        let mut random = Random(seed + 5);
        let exact: Vec<f64> = mesh.tetrahedra.iter().map(|_| 10_f64.powf(0.99 * random.signed())).collect();
        let data = TetData { nodes: vec![1.0; mesh.points.len()], elements: exact.clone() };
        for (name, bytes) in files(&mesh, &data) {
            let session = open(&name, &bytes, "[[body.field]]\nparam = \"young\"\ndata = \"E\"");
            close(&factors(&session, "young"), &exact, 1e-15);
        }
        // Values of the parameter in a unit: the modulus of the scene is 100 kPa.
        let absolute = TetData { elements: exact.iter().map(|factor| 100.0 * factor).collect(), ..data };
        for (name, bytes) in files(&mesh, &absolute) {
            let session = open(&name, &bytes, "[[body.field]]\nparam = \"young\"\ndata = \"E\"\nunit = \"kPa\"");
            close(&factors(&session, "young"), &exact, 1e-14);
        }
    }
}

#[test]
fn mass_is_that_of_densities_at_elements_and_at_nodes() {
    for (seed, linear) in (0..2).map(|seed| (seed, TetBox::new([3, 2, 2], [0.03, 0.02, 0.02], 0.1, seed))) {
        for mesh in orders(&linear) {
            let mesh = mesh.shuffled(seed);
            let mut random = Random(seed);
            let elements: Vec<f64> = mesh.tetrahedra.iter().map(|_| 0.2 + 3.0 * random.unit()).collect();
            // Linear in space, as between nodes.
            let slope = [10.0 * random.signed(), 10.0 * random.signed(), 10.0 * random.signed()];
            let at = |p: &pliant_mesh::geometry::Vec3| 2.0 + (0..3).map(|i| slope[i] * p[i]).sum::<f64>();
            let data = TetData { nodes: mesh.points.iter().map(at).collect(), elements };
            let volume = |element: usize| match mesh.quadratic.get(element) {
                Some(nodes) => TetMesh::quadratic_volume(&mesh.points, nodes),
                None => TetMesh::six_volumes(&mesh.points, mesh.tetrahedra[element]) / 6.0,
            };
            let all: f64 = (0..mesh.tetrahedra.len()).map(volume).sum();
            let at_elements = (0..mesh.tetrahedra.len()).map(|e| volume(e) * data.elements[e]).sum::<f64>() / all;
            for (name, bytes) in files(&mesh, &data).into_iter().step_by(3) {
                let mean = |array: &str| {
                    let field = format!("[[body.field]]\nparam = \"density\"\ndata = \"{array}\"");
                    let session = open(&name, &bytes, &field);
                    session.bodies[0].system.nodes.mass.iter().sum::<f64>() / (1000.0 * all)
                };
                let found = mean("E");
                assert!((found / at_elements - 1.0).abs() < 1e-12, "{name}, {seed}: {found}, exact {at_elements}");
                // A factor at the middle of a linear tetrahedron is the mean of it over the tetrahedron, and of the box that at its middle.
                let found = mean("at nodes");
                let exact = at(&(0.5 * pliant_mesh::geometry::Vec3::from(mesh.size)));
                let tolerance = if mesh.quadratic.is_empty() { 1e-12 } else { 0.02 };
                assert!((found / exact - 1.0).abs() < tolerance, "{name}, {seed}: {found}, exact {exact}");
            }
        }
    }
}

#[test]
fn numbers_that_do_not_fit_are_refused_with_file_line_and_entity() {
    let mesh = TetBox::new([2, 2, 2], [0.02; 3], 0.1, 3);
    let mut data = TetData { nodes: vec![1.0; mesh.points.len()], elements: vec![2.0; mesh.tetrahedra.len()] };
    data.elements[7] = 12.5;
    data.nodes[3] = f64::NAN;
    let text =
        VtuFormat { encoding: VtuEncoding::Text, is_compressed: false, is_big_endian: false, has_long_sizes: false };
    let good = mesh.vtu_bytes(text, &data);
    let line = |name: &str| {
        let text = String::from_utf8(good.clone()).unwrap();
        1 + text.lines().position(|line| line.contains(&format!("Name=\"{name}\""))).unwrap()
    };
    let (e, nodes) =
        (format!("box.vtu:{}: array `E`", line("E")), format!("box.vtu:{}: array `at nodes`", line("at nodes")));
    let cases = [
        ("data = \"E\"", vec![e.as_str(), "element 7 has factor 12.5", "0.1 to 10"]),
        ("data = \"E\"\nunit = \"MPa\"", vec![e.as_str(), "element 0 has 2 MPa, 20 times", "`young`"]),
        ("data = \"at nodes\"", vec![nodes.as_str(), "node 3 has no number"]),
        ("data = \"F\"", vec!["no array `F`", "`at nodes` (at nodes), `E` (at elements)"]),
        ("data = \"velocity\"", vec!["no array `velocity` of one number each"]),
        ("data = \"E\"\nunit = \"mm\"", vec!["unit `mm` of `young`"]),
        ("data = \"E\"\nfactor = 2", vec!["`data` and `factor`", "`data` with or without `unit`"]),
        ("unit = \"kPa\"", vec!["`unit`"]),
    ];
    for (field, says) in cases {
        let bench = Bench::new();
        bench.write("box.vtu", &good);
        let field = format!("[[body.field]]\nparam = \"young\"\n{field}");
        let text = scene("dt = 1e-3\nduration = 0.01", "neo-hookean", &field, "gravity = [0, 0, -1]");
        bench.write("scene.toml", text.replace("box.msh", "box.vtu"));
        for verb in ["plan", "run"] {
            bench.pliant(&[verb, "scene.toml"]).expect(2).says(&says);
        }
    }
    let bench = Bench::new();
    bench.write("box.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    let field = "[[body.field]]\nparam = \"young\"\ndata = \"E\"\n[body.grid]\nregion = \"whole\"";
    let text = scene("dt = 1e-3\nduration = 0.01", "neo-hookean", field, "gravity = [0, 0, -1]");
    bench.write("scene.toml", text.replace("box.msh", "box.obj"));
    bench.pliant(&["plan", "scene.toml"]).expect(2).says(&["`data` is of the file of a tetrahedral mesh", "`csv`"]);
}
