//! A model in pieces that lie together is the model that it looks like, and so is one with faces turned over: in its steps, in cuts and in files.

use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session, WarningCode};
use pliant_host::SearchPath;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Apart, Random, apart, document, models};
use pliant_mesh::{ObjDocument, Surface};
use pliant_tests::{Bench, deps};
use std::collections::HashMap;
use std::path::Path;

const SOLID: &str = "material = { plugin = \"neo-hookean\", params = { young = \"20 kPa\" } }\ngrid = { level = 5 }";
const SHEET: &str = "sheet = {}\nmaterial = { plugin = \"cloth\", params = { fabric = \"denim\" } }\n\
                     fixed = [{ box = [[-1.0, -1.0, -1.0], [-0.035, 1.0, 1.0]] }]";
/// A tool that comes from above, goes into the body and along, and what it does.
const TOUCH: &str = "radius = \"8 mm\"\n[[edit]]\nkind = \"touch\"\nrelease = \"keep\"";
const PULL: &str = "radius = \"8 mm\"\n[[edit]]\nkind = \"pull\"\nrelease = \"keep\"";
const CUT: &str = "radius = \"1 mm\"\nblade = { length = \"300 mm\", toughness = \"0 J/m^2\", direction = [1.0, 0.1, 0.0] }\n[[edit]]\nkind = \"cut\"";

/// What a run of a model gave: rows of the written file, and parts at its end.
struct Ran {
    written: ObjDocument,
    bytes: Vec<u8>,
    parts: f64,
}

/// Runs an edit of a model; the body has `settings`, the hand goes from `from` to `to` above where it meets the body, m.
fn run(bench: &Bench, model: &str, settings: &str, edit: &str, [from, to]: [f64; 2]) -> Ran {
    bench.write("model.obj", model);
    let frame = match settings.contains("sheet") {
        true => "frame = { origin = [0.012, 0.003, 0.0] }".to_owned(),
        false => {
            let [x, y] = top(&document(model));
            format!("frame = {{ body = \"body\", from = [{x}, {y}, 2.0], toward = [{x}, {y}, 0.5] }}")
        }
    };
    let path = format!("path = [[0.0, 0.0, 0.0, {from}], [0.03, 0.001, 0.0, {to}], [0.04, 0.001, 0.0, {to}]]");
    let scene = format!(
        "format = 1\ntime = {{ duration = 0.06 }}\n[[body]]\nname = \"body\"\nmesh = \"model.obj\"\nsize = \"100 mm\"\n{settings}\n\
         [[device]]\nname = \"hand\"\nplugin = \"scripted\"\n\
         {frame}\nparams = {{ {path} }}\n\
         [[tool]]\nname = \"tool\"\ndevice = \"hand\"\n{edit}\ntool = \"tool\"\n\
         [[probe]]\nname = \"parts\"\nquantity = \"parts\"\n"
    );
    bench.write("scene.toml", scene);
    bench.pliant(&["run", "scene.toml", "-q", "--threads", "1", "--out", "out"]).expect(0);
    let bytes = bench.read("out/final.obj");
    let parts = bench.summary("out")["probes"][0]["value"].as_f64().expect("a number");
    Ran { written: ObjDocument::parse(bytes.clone(), Path::new("final.obj")).expect("a model"), bytes, parts }
}

/// Where the highest vertex of a model is in its box, along x and y, a little towards the middle.
fn top(model: &ObjDocument) -> [f64; 2] {
    let surface = Surface::from_document(model);
    let (bounds, mut corners) = (surface.bounds(), surface.triangles.iter().flatten());
    let first = corners.next().map_or(Vec3::zeros(), |v| surface.points[*v as usize]);
    let highest = corners.map(|v| surface.points[*v as usize]).fold(first, |a, b| if b.z > a.z { b } else { a });
    [0, 1].map(|axis| 0.01 + 0.98 * (highest[axis] - bounds.min[axis]) / (bounds.max[axis] - bounds.min[axis]))
}

/// Compares a model in pieces with the whole: every copy of a vertex is where the vertex is, bit by bit. `whole` has its vertices in the order of the first copies.
fn compare(
    name: &str,
    bench: &Bench,
    whole: &ObjDocument,
    pieces: &Apart,
    settings: &str,
    edit: &str,
    way: [f64; 2],
) -> Ran {
    let first = apart(whole, |_| 0);
    let row_of: HashMap<u32, usize> = first.copy_of.iter().zip(0..).map(|(vertex, row)| (*vertex, row)).collect();
    let expected = run(bench, &first.text, settings, edit, way);
    let found = run(bench, &pieces.text, settings, edit, way);
    assert_eq!(found.parts, expected.parts, "{name}");
    for (row, vertex) in pieces.copy_of.iter().enumerate() {
        let [now, then] = [found.written.positions()[row], expected.written.positions()[row_of[vertex]]];
        assert!((now - then).norm() == 0.0, "{name}: vertex {row} is at {now:?}, as a whole {then:?}");
    }
    let moved = |ran: &Ran, text: &str| {
        let before = document(text);
        ran.written.positions().iter().zip(before.positions()).any(|(now, then)| now != then)
    };
    assert!(moved(&found, &pieces.text), "{name}: nothing moved");
    found
}

/// Closed models, each in pieces of its own: a vertex for each corner, or random patches; of every second one some faces are turned over.
fn solids() -> Vec<(String, ObjDocument, Apart)> {
    let random = &mut Random(5);
    let all = models(6, 2).into_iter().filter(|model| model.closed && model.genus.is_some() && model.holes == 0);
    all.enumerate()
        .map(|(round, model)| {
            let whole = model.document();
            let patches: Vec<usize> = whole.faces().map(|_| random.below(4) as usize).collect();
            let Apart { text, copy_of } = apart(&whole, |face| if round % 2 == 0 { face } else { patches[face] });
            let text = turned(&document(&text), |face| round / 2 % 2 == 0 && face % 5 < 2);
            (model.name, whole, Apart { text, copy_of })
        })
        .collect()
}

#[test]
fn a_solid_in_pieces_is_pressed_and_cut_as_a_whole() {
    let all = solids();
    assert!(all.len() >= 5, "{}", all.len());
    for (name, whole, pieces) in &all {
        let bench = Bench::new();
        compare(name, &bench, whole, pieces, SOLID, TOUCH, [0.01, -0.006]);
        let cut = compare(name, &bench, whole, pieces, SOLID, CUT, [0.02, -0.2]);
        let surface = Surface::from_document(&cut.written);
        assert!(surface.points.len() > pieces.copy_of.len(), "{name}: nothing was cut");
    }
}

#[test]
fn a_sheet_in_pieces_is_pulled_as_a_whole() {
    for seed in 0..4 {
        let bench = Bench::new();
        let cells = [12 + seed as u32, 9];
        let pattern = [pliant_mesh::generate::Pattern::Regular, pliant_mesh::generate::Pattern::Irregular][seed % 2];
        let whole = pliant_mesh::generate::grid(cells, [0.1, 0.08], pattern).expect("a sheet");
        let pieces = apart(&whole, |face| face * (seed + 1) / 30);
        compare(&format!("sheet {seed}"), &bench, &whole, &pieces, SHEET, PULL, [0.001, 0.02]);
    }
}

/// A document with some faces turned over.
fn turned(whole: &ObjDocument, is_turned: impl Fn(usize) -> bool) -> String {
    let text = String::from_utf8(whole.bytes().to_vec()).expect("text");
    let mut face = 0;
    let line = |line: &str| {
        if !line.starts_with("f ") {
            return line.to_owned();
        }
        face += 1;
        let mut corners: Vec<&str> = line[2..].split_whitespace().collect();
        if is_turned(face - 1) {
            corners[1..].reverse();
        }
        format!("f {}", corners.join(" "))
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn a_solid_with_faces_turned_over_is_pressed_and_cut_as_it_looks() {
    for (round, (name, whole, _)) in solids().into_iter().enumerate() {
        let bench = Bench::new();
        let whole = apart(&whole, |_| 0).text;
        let random = std::cell::RefCell::new(Random(round as u64));
        let inside_out = turned(&document(&whole), |_| true);
        let mixed = turned(&document(&whole), |_| random.borrow_mut().below(3) == 0);
        for (edit, way) in [(TOUCH, [0.01, -0.006]), (CUT, [0.02, -0.2])] {
            let expected = run(&bench, &whole, SOLID, edit, way);
            for (what, text) in [("inside out", &inside_out), ("mixed", &mixed)] {
                let found = run(&bench, text, SOLID, edit, way);
                assert_eq!(found.parts, expected.parts, "{name} {what}");
                assert_eq!(found.written.positions(), expected.written.positions(), "{name} {what}");
                // What is written is the same model, turned over as its file was.
                let mut back = found.written.clone();
                back.turn_over(&back.faces_turned_over(&Surface::from_document(&back)));
                let [now, then] = [&back, &expected.written].map(|of| Surface::from_document(of).volume());
                assert!((now - then).abs() <= 1e-9 * then.abs(), "{name} {what}: {now}, as it looks {then}");
                let as_written = Surface::from_document(&found.written).volume();
                assert!(what != "inside out" || (as_written + then).abs() <= 1e-9 * then.abs(), "{name}: {as_written}");
                let model = document(text);
                let kept =
                    found.written.faces().filter(|face| model.faces().any(|own| own.corners == face.corners)).count();
                assert!(2 * kept > model.face_count() || edit == CUT, "{name} {what}: {kept} faces are as in the file");
            }
        }
    }
}

/// Where a sheet was cut the borders lie together, and its file says so: they are not welded, unless the scene asks for it.
#[test]
fn slits_of_a_sheet_are_told_from_borders_that_continue() {
    let bench = Bench::new();
    let whole =
        pliant_mesh::generate::grid([14, 10], [0.1, 0.08], pliant_mesh::generate::Pattern::Regular).expect("a sheet");
    let text = String::from_utf8(whole.bytes().to_vec()).expect("text");
    let cut = run(&bench, &text, SHEET, CUT, [0.02, -0.02]);
    assert!(cut.written.has_cut_borders());
    let pairs = |document: &ObjDocument| document.coincident_borders(&Surface::from_document(document), 0.0).len();
    let welded = |model: &[u8], settings: &str| {
        run(&bench, std::str::from_utf8(model).expect("text"), &format!("{settings}\n{SHEET}"), PULL, [0.001, 0.02]);
        let summary = bench.summary("out");
        assert_eq!(summary["warnings"].as_array().map(Vec::len), Some(0), "{}", summary["warnings"]);
        summary["bodies"][0]["welded_vertices"].as_u64().expect("a number") as usize
    };
    assert_eq!(welded(&cut.bytes, ""), 0);
    // The first pull has opened the slit, so nothing is left to weld in its result.
    assert_eq!(welded(&cut.bytes, "weld = true"), pairs(&document(std::str::from_utf8(&cut.bytes).expect("text"))));
    let pieces = apart(&whole, |face| face / 30);
    let doubled = pairs(&document(&pieces.text));
    assert!(doubled > 10);
    for (settings, expected) in [("", doubled), ("weld = true", doubled), ("weld = false", 0)] {
        assert_eq!(welded(pieces.text.as_bytes(), settings), expected, "{settings}");
    }
}

/// A program that passes a mesh has chosen its vertices: they stay, and it is told, unless it says what it wants.
#[test]
fn a_mesh_in_memory_keeps_its_vertices_and_is_warned_of() {
    for (name, whole, pieces) in solids() {
        let model = document(&pieces.text);
        let doubled = model.coincident_borders(&Surface::from_document(&model), 0.0).len();
        for (document, weld, welded, warnings) in [
            (&model, "", 0, 1),
            (&model, "weld = false", 0, 0),
            (&model, "weld = true", doubled, 0),
            (&whole, "", 0, 0),
        ] {
            let session = open_in_memory(document, weld);
            assert_eq!(session.bodies[0].model.document.welds().len(), welded, "{name}: {weld}");
            let told = session.warnings().into_iter().filter(|told| told.code == WarningCode::CoincidentBorders);
            assert_eq!(told.count(), warnings, "{name}: {weld}");
        }
    }
}

/// A session with a document as the mesh of its body.
fn open_in_memory(document: &ObjDocument, weld: &str) -> Session {
    let text = format!(
        "format = 1\n[[body]]\nmesh = \"given\"\nsize = 0.1\n{weld}\n{SOLID}\n[[device]]\nname = \"hand\"\nplugin = \"scripted\"\n\
         params = {{ path = [[0, 0, 0, 0.2]] }}\n[[tool]]\nname = \"tool\"\ndevice = \"hand\"\n{TOUCH}\ntool = \"tool\"\n"
    );
    let (scene, mut source) = scene::load_text(Path::new("memory"), text, &[]).expect("a scene");
    source.documents.insert("given".into(), document.clone());
    let plan = Plan::new(&scene, &source).expect("a plan");
    Session::open(&scene, &source, plan, &Options::new(SearchPath::new(&[deps()]), 1)).expect("a session")
}

#[test]
fn what_weld_may_be() {
    let bench = Bench::new();
    let pieces = apart(&document(pliant_tests::models::CUBE), |face| face);
    bench.write("model.obj", &pieces.text);
    let plan = |weld: &str| {
        let body = format!("[[body]]\nmesh = \"model.obj\"\nsize = \"40 mm\"\nweld = {weld}\n{SOLID}\n");
        let hand = "[[device]]\nname = \"hand\"\nplugin = \"scripted\"\nparams = { path = [[0, 0, 0, 0.1]] }\n\
                    [[tool]]\nname = \"tool\"\ndevice = \"hand\"\nradius = \"5 mm\"\n[[edit]]\nkind = \"touch\"\ntool = \"tool\"\n";
        bench.write("scene.toml", format!("format = 1\n{body}{hand}"));
        bench.pliant(&["plan", "scene.toml", "--json"])
    };
    for (weld, welded, border) in [("true", 16, 0), ("\"1 um\"", 16, 0), ("false", 0, 24)] {
        let body = plan(weld).expect(0).json()["bodies"][0].clone();
        assert_eq!(body["border_edges"], border, "{weld}: {body}");
        assert_eq!(body["welded_vertices"], welded, "{weld}: {body}");
    }
    for (weld, said) in [("-1e-3", "weld = -0.001"), ("0", "weld = 0"), ("\"auto\"", "auto"), ("\"2 kg\"", "a mass")] {
        plan(weld).expect(2).says(&["scene.toml:5", said]);
    }
}
