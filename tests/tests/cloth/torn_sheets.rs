//! Files and probes of sheets that are torn and also cut or stitched: they have what viewers draw, and nothing else.

use pliant_cut::{Blade, Stroke};
use pliant_engine::plan::Plan;
use pliant_engine::probe::{Quantity, Reading};
use pliant_engine::scene::load;
use pliant_engine::session::{Options, Session};
use pliant_host::SearchPath;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::{ObjDocument, Surface};
use pliant_record::{Recorder, write_model_to};
use pliant_tests::{Bench, deps};
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// Cells along each side of a sheet of 0.1 m.
const CELLS: u32 = 20;
/// m
const CELL: f64 = 0.1 / CELLS as f64;

/// A flat sheet that can tear and be cut, in a folder, with faces of three or four corners.
struct Torn {
    bench: Bench,
    session: Session,
    recorder: Recorder,
}

impl Torn {
    fn open(has_quads: bool) -> Self {
        let mut obj = String::from("v 7 7 7\n");
        let rows = 0..=CELLS;
        rows.clone().for_each(|row| {
            rows.clone()
                .for_each(|column| _ = writeln!(obj, "v {} {} 0", f64::from(column) * CELL, f64::from(row) * CELL));
        });
        for (row, column) in (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| (row, column))) {
            let a = row * (CELLS + 1) + column + 2;
            let [b, c, d] = [a + 1, a + CELLS + 2, a + CELLS + 1];
            _ = match has_quads {
                true => writeln!(obj, "f {a} {b} {c} {d}"),
                false => writeln!(obj, "f {a} {b} {c}\nf {a} {c} {d}"),
            };
        }
        let bench = Bench::new();
        bench.write("sheet.obj", obj);
        // A hand far away: its edit keeps a mesh that can be cut.
        let text = r#"
            format = 1
            gravity = [0, 0, -1e-9]
            [time]
            duration = 1
            integrator = "backward-euler"
            [[body]]
            name = "sheet"
            mesh = "sheet.obj"
            sheet = { warp = [1, 0, 0] }
            material = { plugin = "tearing", params = { young = 1e6, strength = 1e5, fracture-energy = 150, thickness = "0.2 mm", damping-time = "5 ms" } }
            [[device]]
            name = "hand"
            params = { path = [[0, 1, 1, 1]] }
            [[tool]]
            name = "knife"
            device = "hand"
            radius = "1 mm"
            blade = { length = "20 mm", direction = [0, 0, 1] }
            [[edit]]
            kind = "cut"
            tool = "knife"
            [output]
            parts = "files"
            trace = false
        "#;
        let (scene, source) = load(&bench.write("scene.toml", text), &[]).expect("a scene");
        let plan = Plan::new(&scene, &source).expect("a plan");
        let options = Options::new(SearchPath::new(&[deps()]), 1);
        let mut session = Session::open(&scene, &source, plan, &options).expect("a session");
        let recorder = Recorder::new(&scene, &source, &session, &bench.path("out"), Instant::now()).expect("a folder");
        session.step();
        Self { bench, session, recorder }
    }

    /// Tears all triangles in cells whose centre, m, is in a region, by giving them the history of a large strain.
    fn tear(&mut self, region: impl Fn(f64, f64) -> bool) {
        let system = &mut self.session.bodies[0].system;
        let rest = &system.nodes.rest;
        let set = system.sets.iter_mut().find(|set| !set.failed().is_empty()).expect("triangles");
        let mut history = set.history().to_vec();
        for (corners, strain) in set.nodes().chunks(3).zip(&mut history) {
            let centre = corners.iter().map(|node| rest[*node as usize]).sum::<Vec3>() / 3.0;
            let [x, y] = [centre.x, centre.y].map(|c| ((c / CELL).floor() + 0.5) * CELL);
            if region(x, y) {
                *strain = 1e3;
            }
        }
        set.set_history(&history);
        self.session.step();
    }

    /// Cuts along a line of the rest shape, m.
    fn cut(&mut self, from: [f64; 2], to: [f64; 2]) {
        let body = &mut self.session.bodies[0];
        let at = |s: f64| {
            let [x, y] = [0, 1].map(|i| from[i] + s * (to[i] - from[i]));
            Blade { tip: Vec3::new(x, y, -0.01), heel: Vec3::new(x + 1e-4, y + 1e-4, 0.01) }
        };
        let mut stroke = Stroke::begin(at(0.0)).expect("a blade");
        let mut advances = 0;
        for step in 1..=60 {
            let advance = body.cut.as_mut().expect("a mesh").advance(&mut stroke, at(f64::from(step) / 60.0));
            let Some(advance) = advance.ok().filter(|advance| advance.has_cut()) else { continue };
            body.take_cut(&advance).expect("sound");
            advances += 1;
        }
        assert!(advances > 5, "{advances} advances");
        self.session.step();
    }

    /// Value of a probe of the whole sheet.
    fn probe(&mut self, name: &str) -> f64 {
        self.session.update_surface();
        let quantity = Quantity::find(name).unwrap_or_else(|| panic!("no quantity `{name}`"));
        let session = &self.session;
        quantity.value(&Reading { session, frame: session.frame(), of: 0, part: None, vertex: 0 }, None)
    }

    /// The triangles that viewers draw, and those that the file has, as corners, m.
    fn drawn_and_written(&mut self) -> [Vec<[Vec3; 3]>; 2] {
        self.session.update_surface();
        let body = &self.session.bodies[0];
        let triangles = &body.model.surface.triangles;
        let drawn = (0..triangles.len() as u32).filter(|t| body.look(*t).is_some()).map(|t| triangles[t as usize]);
        let mut bytes = Vec::new();
        write_model_to(body, "cap", &mut bytes).expect("written");
        let written = Surface::from_document(&ObjDocument::parse(bytes, Path::new("torn.obj")).expect("an OBJ file"));
        [
            drawn.map(|t| t.map(|v| body.skin.x[v as usize])).collect(),
            written.triangles.iter().map(|t| t.map(|v| written.points[v as usize])).collect(),
        ]
    }
}

/// Centroids of triangles in units of 10 nm, sorted.
fn centroids(triangles: &[[Vec3; 3]]) -> Vec<[i64; 3]> {
    let centroid = |[a, b, c]: &[Vec3; 3]| ((a + b + c) / 3.0 * 1e8).map(|c| c.round() as i64).into();
    let mut centroids: Vec<_> = triangles.iter().map(centroid).collect();
    centroids.sort_unstable();
    centroids
}

/// First moment of triangles, m^3, in which the diagonal of a flat quad does not count.
fn moment(triangles: &[[Vec3; 3]]) -> Vec3 {
    triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm() * (a + b + c) / 3.0).sum()
}

fn disc(x: f64, y: f64) -> bool {
    (x - 0.03).hypot(y - 0.03) < 0.013
}

#[test]
fn a_sheet_that_is_torn_and_cut_is_written_as_it_is_drawn() {
    for has_quads in [false, true] {
        for is_cut_first in [false, true] {
            let mut torn = Torn::open(has_quads);
            let all = torn.session.bodies[0].model.surface.triangles.len();
            // Through what has torn, and through what has not.
            let line = ([0.022, 0.004], [0.041, 0.083]);
            if is_cut_first {
                torn.cut(line.0, line.1);
                torn.tear(disc);
            } else {
                torn.tear(disc);
                torn.cut(line.0, line.1);
            }
            let [drawn, written] = torn.drawn_and_written();
            let now = torn.session.bodies[0].model.surface.triangles.len();
            assert!(
                now > all + 10 && drawn.len() + 20 < now,
                "{} of {now} triangles are left, {all} before",
                drawn.len()
            );
            let is_equal = match has_quads {
                // A reader may divide a square along its other diagonal.
                true => drawn.len() == written.len() && (moment(&drawn) - moment(&written)).norm() < 1e-10,
                false => centroids(&drawn) == centroids(&written),
            };
            assert!(is_equal, "quads {has_quads}, cut first {is_cut_first}: {} and {}", drawn.len(), written.len());
        }
    }
}

#[test]
fn parts_of_a_torn_and_stitched_sheet_are_those_that_hang_together() {
    let mut torn = Torn::open(false);
    // Cut through across the middle, and sewn again; the hole is in vertices with lower numbers than those of the seam.
    torn.cut([-0.01, 0.0503], [0.11, 0.0507]);
    assert_eq!(torn.probe("parts"), 2.0);
    torn.session.bodies[0].stitch(Vec3::new(0.05, 0.05, 0.0), 0.06).expect("sound");
    torn.tear(disc);
    assert!(!torn.session.bodies[0].joined_vertices().is_empty());
    assert_eq!(torn.probe("parts"), 1.0, "sewn");
    // A column across the seam.
    torn.tear(|x, _| (0.07..0.07 + CELL).contains(&x));
    assert_eq!(torn.probe("parts"), 2.0, "torn apart");
    let Torn { bench, mut session, recorder } = torn;
    recorder.finish(&mut session, false).expect("results");
    let read = |name: &str| {
        let document = ObjDocument::read(&bench.path(&format!("out/{name}"))).unwrap_or_else(|error| panic!("{error}"));
        Surface::from_document(&document)
    };
    let names: Vec<String> = bench.names("out").into_iter().filter(|name| name.contains("-part-")).collect();
    let areas: Vec<f64> = names.iter().map(|name| read(name).areas().iter().sum()).collect();
    let whole: f64 = read("final.obj").areas().iter().sum();
    assert_eq!(names.len(), 2, "{names:?}");
    assert!((areas.iter().sum::<f64>() / whole - 1.0).abs() < 1e-9, "{areas:?} of {whole} m^2");
    for (area, width) in areas.iter().zip([0.07, 0.1 - 0.07 - CELL]) {
        let hole = if width > 0.05 { std::f64::consts::PI * 0.013 * 0.013 } else { 0.0 };
        assert!((area / (0.1 * width - hole) - 1.0).abs() < 0.05, "{area} m^2 of a part {width} m wide");
    }
}

#[test]
fn probes_count_what_has_not_torn() {
    for has_quads in [false, true] {
        let mut torn = Torn::open(has_quads);
        let area = torn.probe("area");
        assert!((area / 0.01 - 1.0).abs() < 1e-9 && torn.probe("parts") == 1.0, "{area} m^2");
        torn.tear(|x, _| (0.05..0.05 + CELL).contains(&x));
        let left = torn.probe("area");
        assert!((left / (area - 0.1 * CELL) - 1.0).abs() < 1e-4, "{left} m^2");
        assert_eq!(torn.probe("parts"), 2.0);
    }
}
