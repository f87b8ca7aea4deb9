//! Nodes that are held by the names of faces, and by what the surface is painted with.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Random, document, models};
use pliant_mesh::{ObjDocument, Surface};
use pliant_tests::{Bench, open_file, warning_codes};

/// How far the held part is led, m.
const WAY: [f64; 3] = [0.002, -0.001, 0.0015];

/// A document with a group around some of its faces.
fn with_group(document: &ObjDocument, is_in: impl Fn(usize) -> bool, statement: &str) -> String {
    let text = String::from_utf8(document.bytes().to_vec()).expect("UTF-8");
    let (mut face, mut out) = (0, String::new());
    for line in text.lines() {
        let is_face = line.starts_with("f ");
        // Names of the model itself would end those given here.
        if line.starts_with("g ") || line.starts_with("o ") {
            continue;
        }
        if is_face {
            out += &format!("{statement} {}\n", if is_in(face) { "held" } else { "rest" });
            face += 1;
        }
        out += &format!("{line}\n");
    }
    out
}

/// A body of a file `model.obj` with lines in its `[[body.fixed]]`, after some steps.
fn stepped(bench: &Bench, body: &str, fixed: &str) -> Session {
    let text = format!(
        "format = 1\ngravity = [0, 0, -9.81]\n[time]\nduration = 0.02\nintegrator = \"backward-euler\"\n[[body]]\nmesh = \"model.obj\"\nsize = 0.1\n{body}\n\
         [[body.fixed]]\n{fixed}\n"
    );
    let mut session = open_file(&bench.write("scene.toml", text), 1, None);
    for _ in 0..20 {
        session.step();
    }
    session.update_surface();
    session
}

/// Largest distance of vertices (m) from where the held part was led, of those of the held faces and of all.
fn apart(session: &Session, is_in: impl Fn(usize) -> bool) -> [f64; 2] {
    let body = &session.bodies[0];
    let Surface { points, triangles, face_of } = &body.model.surface;
    let away = |v: u32| (body.skin.x[v as usize] - points[v as usize] - Vec3::from(WAY)).norm();
    let greatest = |all: &mut dyn Iterator<Item = u32>| all.map(away).fold(0.0, f64::max);
    let held = triangles.iter().zip(face_of).filter(|(_, face)| is_in(**face as usize));
    [greatest(&mut held.flat_map(|(t, _)| *t)), greatest(&mut triangles.iter().flatten().copied())]
}

fn led(group: &str) -> String {
    let [x, y, z] = WAY;
    format!("group = \"{group}\"\npath = [[0, 0, 0, 0], [0.01, {x}, {y}, {z}]]")
}

/// Faces of a group go exactly where they are led, whatever the model and its discretisation are; the rest of it falls behind.
#[test]
fn faces_of_a_group_go_where_they_are_led() {
    let mut random = Random(6);
    for (round, model) in models(6, 6).into_iter().enumerate() {
        let document = &document(&model.text);
        let faces = document.face_count();
        // A stretch of faces; those of the end are near each other in most models.
        let (count, offset) = (1 + random.below(faces as u64 / 4) as usize, random.below(faces as u64) as usize);
        let is_in = |face: usize| (face + faces - offset) % faces < count;
        let bench = Bench::new();
        bench.write("model.obj", with_group(document, is_in, ["g", "o", "g first"][round % 3]));
        let solid = "material = { plugin = \"corotational\", params = { young = \"5 kPa\" } }\n\
                     grid = { level = 5, region = \"whole\", smooth = false }";
        let [held, all] = apart(&stepped(&bench, solid, &led("held")), is_in);
        // A face that near to a plane of the lattice counts as in it: 1e-6 of the body's size.
        assert!(held < 1e-7, "{}: a held vertex is {held} m off", model.name);
        assert!(all > 1e-4, "{}: everything was held", model.name);
    }
}

/// The same faces by a box and by their name hold the same nodes, where they lie in a plane of the lattice.
#[test]
fn a_group_in_a_plane_of_the_lattice_is_a_box_around_it() {
    let bench = Bench::new();
    let cube = pliant_mesh::generate::cuboid(8, [0.1; 3]).expect("a cube");
    let surface = Surface::from_document(&cube);
    let is_low = |v: &u32| surface.points[*v as usize].z < -0.05 + 1e-9;
    let is_in = |face: usize| cube.face(face).expect("a face").corners.iter().all(|corner| is_low(&corner.v));
    bench.write("model.obj", with_group(&cube, is_in, "g"));
    for region in ["whole", "local"] {
        let body = format!("material = {{ plugin = \"neo-hookean\" }}\ngrid = {{ level = 5, region = \"{region}\" }}");
        let by_box = led("held").replace("group = \"held\"", "box = [[-1, -1, -1], [1, 1, -0.0499]]");
        let [by_group, by_box] = [led("held"), by_box].map(|fixed| stepped(&bench, &body, &fixed));
        let [found, exact] = [&by_group, &by_box].map(|session| &session.bodies[0].system.nodes);
        assert!(found.x == exact.x && found.constraint == exact.constraint, "{region}");
    }
}

#[test]
fn vertices_of_a_group_of_a_sheet_are_held() {
    let bench = Bench::new();
    let sheet = pliant_mesh::generate::cuboid(6, [0.1; 3]).expect("a cube");
    let is_in = |face: usize| face.is_multiple_of(7);
    bench.write("model.obj", with_group(&sheet, is_in, "g"));
    let session = stepped(&bench, "sheet = {}\nmaterial = { plugin = \"cloth\" }", &led("held"));
    let [held, all] = apart(&session, is_in);
    assert!(held < 1e-15 && all > 1e-5, "{held} {all}");
}

#[test]
fn a_group_that_is_not_there_is_refused_and_an_empty_one_told() {
    let bench = Bench::new();
    let cube = pliant_mesh::generate::cuboid(4, [0.1; 3]).expect("a cube");
    bench.write("model.obj", with_group(&cube, |face| face < 3, "g") + "g nothing\n");
    let run = |fixed: &str| {
        let path = "path = [[0, 0, 0, 0], [1, 1e-4, 0, 0]]";
        let text = format!(
            "format = 1\n[time]\nduration = 0.01\n[[body]]\nmesh = \"model.obj\"\nmaterial = {{ plugin = \"mass-spring\" }}\n\
             grid = {{ region = \"whole\", level = 4 }}\n[[body.fixed]]\n{fixed}\n{path}\n"
        );
        bench.write("scene.toml", text);
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"])
    };
    run("group = \"hold\"").expect(2).says(&[
        "scene.toml:",
        "no group `hold` in the model; allowed is",
        "`held`",
        "`rest`",
        "`nothing`",
    ]);
    // Where nothing moves, too.
    let text = String::from_utf8(bench.read("scene.toml")).expect("text");
    let standing = text.replace("\npath = [[0, 0, 0, 0], [1, 1e-4, 0, 0]]", "");
    let elsewhere =
        ["[[body.field]]\nparam = \"young\"\nfactor = 2\ngroup = \"hold\"", "[[body.fixed]]\ngroup = \"hold\""];
    for entry in elsewhere {
        bench.write("scene.toml", standing.replace("[[body.fixed]]\ngroup = \"hold\"", entry));
        let ran = bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(2);
        ran.says(&["scene.toml:", "no group `hold` in the model; allowed is", "`held`", "`rest`", "`nothing`"]);
    }
    bench.write("scene.toml", standing.replace("hold", "held"));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    run("group = \"held\"\nbox = [[0, 0, 0], [1, 1, 1]]").expect(2).says(&["`box` and `group`; allowed is", "`group`"]);
    for (group, codes) in [("nothing", &["fixes-nothing"][..]), ("held", &[])] {
        run(&format!("group = \"{group}\"")).expect(0);
        assert_eq!(warning_codes(&bench.summary("out")), codes, "{group}");
    }
}

/// A document with a colour at each vertex whose channels are `value`, and with texture coordinates (0.5, value).
fn painted(document: &ObjDocument, value: impl Fn(Vec3) -> f64) -> String {
    let text = String::from_utf8(document.bytes().to_vec()).expect("UTF-8");
    let mut out: String = document.positions().iter().map(|p| format!("vt 0.5 {}\n", value(*p))).collect();
    let mut points = document.positions().iter();
    for line in text.lines() {
        let (kind, rest) = line.trim().split_once(char::is_whitespace).unwrap_or((line, ""));
        out += &match kind {
            "v" => {
                let place: Vec<&str> = rest.split_whitespace().take(3).collect();
                format!("v {} {} 0 1\n", place.join(" "), value(*points.next().expect("a vertex")))
            }
            "vt" => String::new(),
            "f" => {
                let corners = rest.split_whitespace().map(|corner| corner.split('/').next().expect("a vertex"));
                format!("f {}\n", corners.map(|v| format!("{v}/{v}")).collect::<Vec<_>>().join(" "))
            }
            _ => format!("{line}\n"),
        };
    }
    out
}

/// Lines of a `[[body.fixed]]` in the place of [`led`]'s group.
fn led_by(place: &str) -> String {
    led("held").replace("group = \"held\"", place)
}

/// Whatever the model is, vertices with at least the value go exactly where they are led, and the rest falls behind.
#[test]
fn what_is_painted_goes_where_it_is_led() {
    let mut random = Random(16);
    for model in models(6, 6) {
        let document = &document(&model.text);
        let surface = Surface::from_document(document);
        let (bounds, axis) = (surface.bounds(), random.below(3) as usize);
        let value = |p: Vec3| ((p - bounds.min)[axis] / (bounds.max - bounds.min)[axis]).clamp(0.0, 1.0);
        let above = 0.7 + 0.25 * random.unit();
        let bench = Bench::new();
        bench.write("model.obj", painted(document, value));
        let body = "material = { plugin = \"corotational\", params = { young = \"5 kPa\" } }\n\
                    grid = { level = 5, region = \"whole\", smooth = false }";
        let session = stepped(&bench, body, &led_by(&format!("colour = \"red\"\nabove = {above}")));
        let body = &session.bodies[0];
        let away = |v: usize| (body.skin.x[v] - body.model.surface.points[v] - Vec3::from(WAY)).norm();
        let all = 0..surface.points.len();
        let is_held = |v: &usize| value(document.positions()[*v]) >= above;
        let held = all.clone().filter(is_held).map(away).fold(0.0, f64::max);
        // As for groups.
        assert!(held < 1e-7, "{}: a held vertex is {held} m off", model.name);
        assert!(all.map(away).fold(0.0, f64::max) > 1e-4, "{}: everything was held", model.name);
    }
}

/// The upper half of a cube, by the names of its faces, by a colour and by an image, holds the same nodes; of the cube as a sheet, the same vertices.
#[test]
fn a_colour_and_an_image_hold_what_a_group_holds() {
    let bench = Bench::new();
    let cube = pliant_mesh::generate::cuboid(8, [0.1; 3]).expect("a cube");
    let surface = Surface::from_document(&cube);
    let is_high = |v: &u32| surface.points[*v as usize].z > -1e-9;
    let is_in = |face: usize| cube.face(face).expect("a face").corners.iter().all(|corner| is_high(&corner.v));
    let text = with_group(&cube, is_in, "g");
    bench.write("model.obj", painted(&document(&text), |p| (10.0 * p.z + 0.5).clamp(0.0, 1.0)));
    // Between the middles of its two pixels an image is linear, and 0.5 in its middle.
    bench.write("half.png", pliant_mesh::testing::grey_png(1, 2, &[255, 0]));
    for body in [
        "material = { plugin = \"neo-hookean\" }\ngrid = { level = 5, region = \"whole\" }",
        "sheet = {}\nmaterial = { plugin = \"cloth\" }",
    ] {
        let places = ["group = \"held\"", "colour = \"red\"", "texture = \"half.png\""];
        let [by_group, by_colour, by_image] = places.map(|place| stepped(&bench, body, &led_by(place)));
        let nodes = |session: &Session| session.bodies[0].system.nodes.constraint.clone();
        let held = nodes(&by_group).iter().filter(|constraint| !constraint.is_free()).count();
        assert!(held > 0 && held < nodes(&by_group).len(), "{body}: {held} nodes are held");
        assert!(nodes(&by_colour) == nodes(&by_group), "{body}: by a colour");
        assert!(nodes(&by_image) == nodes(&by_group), "{body}: by an image");
    }
}

#[test]
fn paint_that_is_not_there_is_refused_and_black_told() {
    let bench = Bench::new();
    let cube = pliant_mesh::generate::cuboid(4, [0.1; 3]).expect("a cube");
    bench.write("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    bench.write("model.obj", painted(&cube, |_| 0.25));
    bench.write("grey.png", pliant_mesh::testing::grey_png(2, 2, &[10; 4]));
    let run = |mesh: &str, fixed: &str| {
        let text = format!(
            "format = 1\n[time]\nduration = 0.01\n[[body]]\nmesh = \"{mesh}.obj\"\nmaterial = {{ plugin = \"mass-spring\" }}\n\
             grid = {{ region = \"whole\", level = 4 }}\n[[body.fixed]]\n{fixed}\npath = [[0, 0, 0, 0], [1, 1e-4, 0, 0]]\n"
        );
        bench.write("scene.toml", text);
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"])
    };
    run("plain", "colour = \"red\"").expect(2).says(&["scene.toml:", "vertex 1 has no colour", "allowed is"]);
    run("plain", "texture = \"grey.png\"").expect(2).says(&["scene.toml:", "without texture coordinates"]);
    run("model", "texture = \"gone.png\"").expect(2).says(&["scene.toml:", "gone.png"]);
    run("model", "colour = \"red\"\nabove = 1.5").expect(2).says(&["scene.toml:", "`above` is 1.5; allowed is"]);
    run("model", "group = \"x\"\nabove = 0.5").expect(2).says(&["`group` and `above`; allowed is"]);
    for fixed in ["colour = \"red\"", "texture = \"grey.png\""] {
        run("model", fixed).expect(0);
        assert_eq!(warning_codes(&bench.summary("out")), ["fixes-nothing"], "{fixed}");
    }
    let recorded = bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", "grey.png"]);
    recorded.expect(2).says(&["grey.png: a file of a field, of fibres or of a `fixed` of this run"]);
    run("model", "colour = \"blue\"").expect(0);
    assert_eq!(warning_codes(&bench.summary("out")), [""; 0]);
}
