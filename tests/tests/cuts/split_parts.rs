//! Parts of cut models as files of their own.

use pliant_engine::plan::Plan;
use pliant_engine::scene::load;
use pliant_engine::session::{Options, Session, WarningCode};
use pliant_host::SearchPath;
use pliant_mesh::check::Kind;
use pliant_mesh::testing::Random;
use pliant_mesh::{Face, ObjDocument, Surface, check};
use pliant_record::Recorder;
use pliant_tests::sweep::{Sweep, cut};
use pliant_tests::{Bench, deps, open};
use std::time::Instant;

/// s, from above a block to below it.
const SECONDS: f64 = 0.3;
/// The same for a fast hand, which moves by 0.7 mm a step, s.
const FAST_SECONDS: f64 = 0.1;

/// A scene in which blades go down through a free block, all at once.
fn scene(cuts: &[Cut], body: &str, output: &str) -> String {
    let knife = |(i, cut): (usize, &Cut)| {
        let (x, z) = (cut.x, 0.035);
        let end = x + cut.slope * 2.0 * z;
        format!(
            "[[device]]\nname = \"hand{i}\"\nparams = {{ path = [[0, {x}, -0.05, {z}], [{SECONDS}, {end}, -0.05, -{z}]] }}\n\
             [[tool]]\nname = \"knife{i}\"\ndevice = \"hand{i}\"\nradius = \"1 mm\"\nblade = {{ length = \"100 mm\", direction = [0, 1, 0] }}\n\
             [[edit]]\nkind = \"cut\"\ntool = \"knife{i}\"\n"
        )
    };
    let knives: String = cuts.iter().enumerate().map(knife).collect();
    format!(
        "format = 1\n[time]\nduration = {}\n[[body]]\nname = \"block\"\n{body}\n\
         material = {{ plugin = \"mass-spring\", params = {{ young = \"200 kPa\", damping-time = \"2 ms\" }} }}\n\
         grid = {{ level = 4, region = \"whole\" }}\n{knives}\n[output]\nnodes = false\n{output}\n",
        SECONDS + 0.02
    )
}

/// A cut through a block from above: where it begins, m, and how far it goes aside for each m down.
struct Cut {
    x: f64,
    slope: f64,
}

const BLOCK: &str = "shape = { kind = \"box\", cells = 8, size = [0.04, 0.04, 0.04] }";

fn read(bench: &Bench, name: &str) -> ObjDocument {
    ObjDocument::read(&bench.path(&format!("out/{name}"))).unwrap_or_else(|error| panic!("{error}"))
}

/// Every part of a body that was cut right through is a closed model; together they have the faces and the volume of the whole.
#[test]
fn parts_of_cut_bodies_are_closed_models_of_their_own() {
    let shapes = ["box\", cells = 12, size = [0.1, 0.09, 0.08]", "sphere\", cells = 10, size = [0.1, 0.1, 0.1]"];
    let mut split = 0;
    for seed in 0..8 {
        let bench = Bench::new();
        let body = format!("shape = {{ kind = \"{} }}", shapes[seed as usize % 2]);
        // A hand far away: its edit keeps a mesh that can be cut.
        let text = scene(&[Cut { x: 10.0, slope: 0.0 }], &body, "parts = \"files\"\ntrace = false");
        let (scene, source) = load(&bench.write("scene.toml", text), &[]).expect("a scene");
        let plan = Plan::new(&scene, &source).expect("a plan");
        let options = Options::new(SearchPath::new(&[deps()]), 1);
        let mut session = Session::open(&scene, &source, plan, &options).expect("a session");
        let recorder = Recorder::new(&scene, &source, &session, &bench.path("out"), Instant::now()).expect("a folder");
        session.step();
        for sweep in 0..1 + seed % 3 {
            cut(&mut session.bodies[0], &Sweep::random(100 * seed + sweep), 40);
        }
        session.changed(0);
        let summary = recorder.finish(&mut session, false).expect("results");
        let whole = read(&bench, "final.obj");
        let expected = Surface::from_document(&whole).shells().into_iter().max().map_or(1, |last| last + 1) as usize;
        let names: Vec<String> = bench.names("out").into_iter().filter(|name| name.contains("-part-")).collect();
        let is_told = summary.warnings.iter().any(|warning| warning.code == WarningCode::OnePart);
        assert!(
            is_told == (expected == 1) && names.len() == if expected == 1 { 0 } else { expected },
            "{seed}: {names:?}"
        );
        assert!(names.iter().all(|name| summary.files.contains(name)), "{:?}", summary.files);
        if names.is_empty() {
            continue;
        }
        split += 1;
        let volume = |document: &ObjDocument| Surface::from_document(document).volume();
        let (mut sum, mut faces, mut caps) = (0.0, 0, 0);
        for name in &names {
            let part = read(&bench, name);
            let surface = Surface::from_document(&part);
            let findings = check(&surface, &part);
            assert!(findings.iter().all(|finding| finding.kind != Kind::Border), "{seed} {name}: {findings:?}");
            assert!(surface.shells().iter().all(|shell| *shell == 0), "{seed} {name} hangs not together");
            let cap = part.materials().iter().position(|material| *material == session.plan().cap_material);
            let is_cap = |face: &Face<'_>| cap.is_some() && face.attributes.material == cap.map(|index| index as u32);
            caps += part.faces().filter(is_cap).count();
            sum += volume(&part);
            faces += part.face_count();
        }
        assert!(faces == whole.face_count() && caps > 0, "{seed}: {faces} faces, {caps} of them made by the cut");
        assert!((sum / volume(&whole) - 1.0).abs() < 1e-9, "{seed}: {sum} of {} m^3", volume(&whole));
    }
    assert!(split >= 6, "{split} of 8 bodies were cut apart");
}

#[test]
fn a_model_in_one_part_is_told_and_has_no_files_of_parts() {
    let bench = Bench::new();
    // Half way through.
    let text =
        scene(&[Cut { x: 0.0, slope: 0.0 }], BLOCK, "parts = \"files\"").replace("-0.05, -0.035]", "-0.05, 0.005]");
    bench.write("scene.toml", text);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0).says(&["one-part", "scene.toml:"]);
    assert!(bench.names("out").iter().all(|name| !name.contains("part")));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "strict", "--strict"]).expect(2).says(&["one-part"]);
    bench.write("scene.toml", scene(&[], BLOCK, "parts = \"apart\""));
    bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2).says(&["scene.toml:", "apart", "`files`"]);
}

/// Parts are measured on their own: their volumes add up to that of the whole, and areas are those of the files.
#[test]
fn probes_of_parts_add_up_to_those_of_the_body() {
    let bench = Bench::new();
    let cuts = [Cut { x: -0.007, slope: 0.02 }, Cut { x: 0.007, slope: -0.01 }];
    let probe = |name: &str, quantity: &str, of: &str| {
        format!("[[probe]]\nname = \"{name}\"\nquantity = \"{quantity}\"\nof = \"{of}\"\n")
    };
    let probes: String = ["volume", "area"]
        .map(|quantity| {
            let parts = (1..=4).map(|n| probe(&format!("{quantity}-{n}"), quantity, &format!("block.part{n}")));
            probe(quantity, quantity, "block") + &parts.collect::<String>()
        })
        .concat();
    bench.write("scene.toml", scene(&cuts, BLOCK, "parts = \"files\"") + &probes);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    let summary = bench.summary("out");
    let value = |name: &str| {
        let probes = summary["probes"].as_array().expect("probes");
        probes.iter().find(|probe| probe["name"] == name).expect("the probe")["value"].as_f64()
    };
    for quantity in ["volume", "area"] {
        let parts: Vec<f64> = (1..=3).map(|n| value(&format!("{quantity}-{n}")).expect("a number")).collect();
        let (sum, whole) = (parts.iter().sum::<f64>(), value(quantity).expect("a number"));
        assert!(parts.iter().all(|part| *part > 0.05 * whole), "{quantity}: {parts:?}");
        assert!((sum / whole - 1.0).abs() < 1e-9, "{quantity}: {parts:?} of {whole}");
        assert_eq!(value(&format!("{quantity}-4")), None, "there is no fourth part");
    }
    for n in 1..=3 {
        let file = Surface::from_document(&read(&bench, &format!("final-part-{n}.obj"))).volume();
        let probe = value(&format!("volume-{n}")).expect("a number");
        // Files are written with rounded coordinates.
        assert!((file / probe - 1.0).abs() < 1e-5, "part {n}: {file} m^3 in its file, {probe} m^3 by its probe");
    }
    let cases = [
        ("block.part0", "volume", "part 0"),
        ("block.part1", "parts", "allowed of a part is"),
        ("wall.part1", "volume", "no body"),
    ];
    for (of, quantity, said) in cases {
        bench.write("scene.toml", scene(&cuts, BLOCK, "") + &probe("probe", quantity, of));
        bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2).says(&["scene.toml:", said]);
    }
}

/// A part that the next run reads is not written over by it.
#[test]
fn a_part_that_a_run_reads_is_not_replaced() {
    let bench = Bench::new();
    let cuts = [Cut { x: -0.007, slope: 0.02 }, Cut { x: 0.007, slope: -0.01 }];
    bench.write("scene.toml", scene(&cuts, BLOCK, "parts = \"files\""));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    let before = bench.read("out/final-part-1.obj");
    // Without the key there are no files of parts, and those of the run before are gone.
    bench.pliant(&["run", "scene.toml", "-q", "--out", "other"]).expect(0);
    assert!(bench.names("other").iter().any(|name| name == "final-part-1.obj"));
    bench.write("together.toml", scene(&[], BLOCK, ""));
    bench.pliant(&["run", "together.toml", "-q", "--out", "other"]).expect(0);
    assert!(bench.names("other").iter().all(|name| !name.contains("part")), "{:?}", bench.names("other"));
    bench.write("scene.toml", scene(&cuts, "mesh = \"out/final-part-1.obj\"", "parts = \"files\""));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(2).says(&["a model of this run"]);
    assert_eq!(bench.read("out/final-part-1.obj"), before);
}

/// Blades go right through a block whose sides are held: along its whole back too, nothing is left that joins the two parts. Where a stroke has to begin
/// anew within the body, because an advance is refused, a neck may be left (docs/numerics.md): in 6 of 90 such cuts, all at level 5.
#[test]
fn a_blade_right_through_a_held_block_parts_it() {
    let random = &mut Random(17);
    let sides = ["box = [[-0.1, -0.1, -0.1], [-0.015, 0.1, 0.1]]", "box = [[0.015, -0.1, -0.1], [0.1, 0.1, 0.1]]"];
    let mut joined = Vec::new();
    for case in 0..8 {
        let fixed: String = sides[..1 + case / 2 % 2].iter().map(|side| format!("[[body.fixed]]\n{side}\n")).collect();
        let cut = Cut { x: 0.01 * (random.unit() - 0.5), slope: 0.2 * (random.unit() - 0.5) };
        let level = if case == 7 { 5 } else { 3 + case % 2 };
        let text = scene(&[cut], BLOCK, "")
            .replacen("\n[[device]]", &format!("\n{fixed}[[device]]"), 1)
            .replace("level = 4", &format!("level = {level}"))
            .replace(&format!("[{SECONDS}, "), &format!("[{FAST_SECONDS}, "));
        let mut session = open(&text, 1);
        for _ in 0..((FAST_SECONDS + 0.02) * 1e3) as usize {
            session.step();
        }
        let shells = session.bodies[0].model.surface.shells();
        let parts = shells.into_iter().max().map_or(0, |last| last + 1);
        assert!(
            parts == 2 || level == 5 && parts == 1,
            "case {case}: {parts} parts by {} advances",
            session.cuts().advances
        );
        joined.extend((parts == 1).then_some(case));
    }
    assert!(joined.len() <= 1, "{joined:?} of 8 are joined");
}
