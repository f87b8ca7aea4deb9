//! A model in pieces that lie together is with `weld = true` the model that it looks like, and one with faces turned over always: in its steps, in cuts and in files.

use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Apart, Random, apart, document, models};
use pliant_mesh::{ObjDocument, Surface};
use pliant_tests::Bench;
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
    let found = run(bench, &pieces.text, &format!("weld = true\n{settings}"), edit, way);
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

/// Closed models, each in pieces of its own: a vertex for each corner, or random patches.
fn solids() -> Vec<(String, ObjDocument, Apart)> {
    let random = &mut Random(5);
    let all = models(6, 2).into_iter().filter(|model| model.closed && model.genus.is_some() && model.holes == 0);
    all.enumerate()
        .map(|(round, model)| {
            let whole = model.document();
            let patches: Vec<usize> = whole.faces().map(|_| random.below(4) as usize).collect();
            let pieces = apart(&whole, |face| if round % 2 == 0 { face } else { patches[face] });
            (model.name, whole, pieces)
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

/// Where a sheet was cut the borders lie together, and its file says so: neither is it welded by an editor nor is there a warning.
#[test]
fn slits_of_a_sheet_are_told_from_borders_that_continue() {
    let bench = Bench::new();
    let whole =
        pliant_mesh::generate::grid([14, 10], [0.1, 0.08], pliant_mesh::generate::Pattern::Regular).expect("a sheet");
    let text = String::from_utf8(whole.bytes().to_vec()).expect("text");
    let cut = run(&bench, &text, SHEET, CUT, [0.02, -0.02]);
    assert!(cut.written.has_cut_borders());
    let pairs = |document: &ObjDocument| document.coincident_borders(&Surface::from_document(document), 0.0).len();
    let warned = |model: &[u8], settings: &str| {
        run(&bench, std::str::from_utf8(model).expect("text"), settings, PULL, [0.001, 0.02]);
        let warnings = bench.summary("out")["warnings"].clone();
        warnings.as_array().expect("a list").iter().any(|w| w["code"] == "coincident-borders")
    };
    assert!(!warned(&cut.bytes, SHEET));
    let pieces = apart(&whole, |face| face / 30);
    assert!(pairs(&document(&pieces.text)) > 10);
    assert!(warned(pieces.text.as_bytes(), SHEET));
    assert!(!warned(pieces.text.as_bytes(), &format!("weld = false\n{SHEET}")));
    assert!(!warned(pieces.text.as_bytes(), &format!("weld = true\n{SHEET}")));
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
