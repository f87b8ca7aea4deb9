//! Lines that a hand draws across generated bodies, in which everything follows from a number.

#![allow(clippy::print_stdout, reason = "what failed, and the count")]

use nalgebra::{Rotation3, UnitQuaternion};
use pliant_cut::testing::line_ends;
use pliant_cut::{Blade, CutMesh, Stroke};
use pliant_editor::{Draft, DraftMaterial, PaintStroke, SOLIDS, stroke_button};
use pliant_engine::body::{Body, NOT_EMBEDDED};
use pliant_engine::edit::KINDS;
use pliant_engine::scene::Release;
use pliant_engine::session::{EventKind, HandPose, Session};
use pliant_mesh::testing::{Random, scan, without};
use pliant_mesh::{ObjDocument, Surface, generate};
use pliant_plugin_api::abi::Ball;
use pliant_solver::Vec3;
use pliant_tests::{Bench, open_drafted};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::ops::RangeInclusive;

const SOLIDS_OF: [&str; 3] = ["mass-spring", "neo-hookean", "corotational"];
/// Longest edge of a body's bounding box, m.
pub const SIZE: f64 = 0.1;
/// Volume of a part of the surface, in cells, above which the lattice has a part of its own for it: two of the smallest that it parts.
const LEAST_CELLS: f64 = 1.0;
/// Radius of an editor's tool on such a body, m.
const RADIUS: f64 = 0.04 * SIZE;

/// Distance of the eye of a perspective view from the body's middle, in sizes of the body.
const EYE: f64 = 2.0;

/// A line drawn across a body: everything about it follows from its number.
#[derive(Debug)]
#[allow(dead_code, reason = "the kind of body is read in messages")]
pub struct DrawnCut {
    body: &'static str,
    level: u32,
    /// Whether all of the body is simulated, so that it floats.
    pub is_whole: bool,
    plugin: &'static str,
    /// Pa
    young: f64,
    /// Ends of the tip's path, m
    pub line: [Vec3; 2],
    /// Direction of the view, towards the eye.
    back: Vec3,
    /// Where the eye of a perspective view is, m; `None` where the blade stays parallel to the direction of the view.
    eye: Option<Vec3>,
    /// Distance between two samples of the hand, m
    jump: f64,
    /// Steps before the button, and with the button at the end of the line.
    waits: [u32; 2],
}

/// A ring about z of 40 x 16 quads, m.
fn torus(random: &mut Random) -> ObjDocument {
    let (around, across) = (40, 16);
    let (major, minor) = (0.035, 0.008 + 0.006 * random.unit());
    let mut text = String::new();
    for i in 0..around {
        for j in 0..across {
            let [(s, c), (t, d)] = [(i, around), (j, across)]
                .map(|(i, n)| (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos());
            let r = major + minor * d;
            writeln!(text, "v {} {} {}", r * c, r * s, minor * t).expect("text");
        }
    }
    for i in 0..around {
        for j in 0..across {
            let v = |i: i32, j: i32| (i % around) * across + j % across + 1;
            writeln!(text, "f {} {} {} {}", v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)).expect("text");
        }
    }
    pliant_mesh::testing::document(&text)
}

/// The document with its points moved.
fn moved(document: &ObjDocument, to: impl Fn(Vec3) -> Vec3) -> ObjDocument {
    let points: Vec<Vec3> = document.positions().iter().map(|p| to(*p)).collect();
    let mut text = Vec::new();
    document.write(&points, None, &mut text).expect("written");
    pliant_mesh::testing::document(&String::from_utf8(text).expect("text"))
}

/// A body whose longest edge is [`SIZE`], about the origin.
fn model(kind: &str, random: &mut Random) -> ObjDocument {
    let document = match kind {
        "ball" => generate::sphere(16, 0.05).expect("a ball"),
        "ellipsoid" => {
            let [a, b] = [0.3 + 0.7 * random.unit(), 0.3 + 0.7 * random.unit()];
            moved(&generate::sphere(14, 0.05).expect("a ball"), |p| Vec3::new(p.x, a * p.y, b * p.z))
        }
        "box" => generate::cuboid(12, [0.1, 0.04 + 0.06 * random.unit(), 0.03 + 0.07 * random.unit()]).expect("a box"),
        "ring" => torus(random),
        _ => scan(random.below(2) as u32, 2500, 0, random.next_u64()).document(),
    };
    let bounds = Surface::from_document(&document).bounds();
    let extent = bounds.max - bounds.min;
    let scale = SIZE / extent.max();
    moved(&document, |p| scale * (p - bounds.centre()))
}

/// Kinds of open models.
const SHEETS: [&str; 4] = ["tube", "bowl", "wave", "pot"];

/// A net of 36 x 24 quads, joined at its ends along the first axis if it is `round`, at places from two coordinates between 0 and 1, m.
fn net(round: bool, place: impl Fn(f64, f64) -> Vec3) -> ObjDocument {
    let (columns, rows) = (36, 24);
    let last = if round { columns } else { columns + 1 };
    let mut text = String::new();
    for j in 0..=rows {
        for i in 0..last {
            let p = place(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            writeln!(text, "v {} {} {}", p.x, p.y, p.z).expect("text");
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let v = |i: i32, j: i32| j * last + i % last + 1;
            writeln!(text, "f {} {} {} {}", v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)).expect("text");
        }
    }
    pliant_mesh::testing::document(&text)
}

/// An open model whose longest edge is [`SIZE`], about the origin: layers of it lie behind each other from most directions.
fn sheet(kind: &str, random: &mut Random) -> ObjDocument {
    let [a, b, c] = [random.unit(), random.unit(), random.unit()];
    let turn = std::f64::consts::TAU;
    let round = |u: f64, r: f64, z: f64| Vec3::new(r * (turn * u).cos(), r * (turn * u).sin(), z);
    let document = match kind {
        "tube" => net(true, |u, v| round(u, 0.2 + 0.2 * a + 0.1 * b * (turn * v).sin(), v) + c * v * v * Vec3::x()),
        "bowl" => net(true, |u, v| {
            let (s, z) = ((0.05 + (1.4 + a) * v).sin(), (0.05 + (1.4 + a) * v).cos());
            round(u, 0.5 * s * (1.0 + 0.2 * b * (3.0 * turn * u).cos()), -0.5 * z)
        }),
        "wave" => {
            net(false, |u, v| Vec3::new(u, v, (0.1 + 0.2 * a) * ((1.0 + 2.0 * b) * turn * (u + 0.3 * c * v)).sin()))
        }
        _ => {
            let whole = scan(random.below(2) as u32, 2500, 0, random.next_u64()).document();
            let surface = Surface::from_document(&whole);
            let bounds = surface.bounds();
            let (out, reach) = (random.direction(), (0.3 + 0.4 * a) * bounds.longest_edge());
            let corner = bounds.centre() + 0.5 * bounds.longest_edge() * out;
            let is_open = |t: &usize| {
                let x = surface.triangles[*t].iter().map(|v| surface.points[*v as usize]).sum::<Vec3>() / 3.0;
                (x - corner).norm() < reach
            };
            without(&whole, &(0..surface.triangles.len()).filter(is_open).collect::<Vec<_>>())
        }
    };
    let bounds = Surface::from_document(&document).bounds();
    let scale = SIZE / (bounds.max - bounds.min).max();
    moved(&document, |p| scale * (p - bounds.centre()))
}

impl DrawnCut {
    /// The case of a number, and the model that is cut, at one of the levels.
    pub fn new(number: u64, levels: &RangeInclusive<u32>) -> (Self, ObjDocument) {
        let random = &mut Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x6b6e_6966);
        let body = random.pick(&["ball", "ellipsoid", "box", "ring", "lump"]);
        let document = model(body, random);
        let is_whole = random.unit() < 0.3;
        let finest = if is_whole { 5 } else { *levels.end() };
        let level = levels.start() + random.below(u64::from(finest - levels.start() + 1)) as u32;
        let case = Self { level, is_whole, ..Self::across(number, body, &document, random) };
        (case, document)
    }

    /// The case of a number of a line across a sheet, and the sheet.
    pub fn of_sheet(number: u64) -> (Self, ObjDocument) {
        let random = &mut Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x7368_6565);
        let body = random.pick(&SHEETS);
        let document = sheet(body, random);
        (Self::across(number, body, &document, random), document)
    }

    /// A line across a model.
    fn across(number: u64, body: &'static str, document: &ObjDocument, random: &mut Random) -> Self {
        let back = random.direction();
        let along = back.cross(&random.direction()).normalize();
        let aside = back.cross(&along);
        let points = Surface::from_document(document).points;
        let reach = |axis: Vec3| {
            points.iter().map(|p| p.dot(&axis)).fold([f64::INFINITY, -f64::INFINITY], |[a, b], x| [a.min(x), b.max(x)])
        };
        let [low, high] = reach(aside);
        let offset = low + (high - low) * (0.2 + 0.6 * random.unit());
        let [start, end] = reach(along);
        let mut beside = || 0.001 + 0.02 * random.unit();
        let (before, after) = (beside(), beside());
        let eye = (number % 2 == 1).then(|| EYE * SIZE * back);
        // The tip is a model's size behind the body's middle, as in the window; seen from an eye it goes a longer way there.
        let [aside_by, along_by] = if eye.is_some() { [1.0 + 1.0 / EYE, (EYE + 1.0) / (EYE - 0.5)] } else { [1.0; 2] };
        let at = |way: f64| aside_by * offset * aside + along_by * way * along - SIZE * back;
        let jump = 0.0005 * 48_f64.powf(random.unit());
        Self {
            body,
            level: 0,
            is_whole: false,
            plugin: random.pick(&SOLIDS_OF),
            young: 5e3 * 200_f64.powf(random.unit()),
            line: [at(start - before), at(end + after)],
            back,
            eye,
            jump,
            waits: [1 + random.below(5) as u32, random.below(4) as u32],
        }
    }

    /// Whether the blade points to the eye of a perspective view, and turns on its way.
    pub fn is_perspective(&self) -> bool {
        self.eye.is_some()
    }

    /// Unit vector from tip to heel of a blade whose tip is at a place (m): towards the eye.
    fn along_blade(&self, tip: Vec3) -> Vec3 {
        self.eye.map_or(self.back, |eye| (eye - tip).normalize())
    }

    /// Number of parts that the drawn areas leave of the body at rest, each of them in one advance; `None` where the geometry is refused, or one separates nothing.
    pub fn expected(&self, session: &Session, lines: &[[Vec3; 2]]) -> Option<u32> {
        let model = &session.bodies[0].model;
        let mut mesh = CutMesh::of_surface(&model.document, model.surface.clone(), &model.placement, false);
        let blade = |tip: Vec3| Blade { tip, heel: tip + 4.0 * SIZE * self.along_blade(tip) };
        let mut parts = 1;
        for [start, end] in lines {
            let mut stroke = Stroke::begin(blade(*start)).ok()?;
            mesh.advance(&mut stroke, blade(*end)).ok()?;
            let before = std::mem::replace(&mut parts, count(mesh.surface()));
            if parts <= before {
                return None;
            }
        }
        Some(parts)
    }

    /// A line that crosses the drawn one within the body, at 0.1 rad or more.
    pub fn crossing(&self, number: u64) -> [Vec3; 2] {
        let random = &mut Random(number ^ 0x0063_726f_7373);
        let [start, end] = self.line;
        let crossed_at = start.lerp(&end, 0.3 + 0.4 * random.unit());
        let angle = (0.1 + 1.4 * random.unit()) * random.signed().signum();
        let along = Rotation3::new(angle * self.back) * (end - start).normalize();
        [-1.2, 1.2].map(|side| crossed_at + side * SIZE * along)
    }

    /// A session of an editor with the model, where strokes can be undone.
    pub fn open(&self, bench: &Bench, document: &ObjDocument) -> Session {
        bench.write("model.obj", document.bytes());
        let preset = SOLIDS.iter().find(|preset| preset.name == "flesh").expect("a preset");
        let preset = pliant_editor::SolidPreset { young: self.young, ..*preset };
        let material = DraftMaterial::Solid { plugin: self.plugin.into(), preset, level: self.level };
        let mesh = bench.path("model.obj");
        let draft = Draft { mesh, scale: 1.0, size: SIZE, subdivide: false, weld: None, material, dt: 1e-3 };
        let mut scene = draft.to_toml(&bench.path(""));
        if self.is_whole {
            let line = format!("level = {}", self.level);
            assert!(scene.contains(&line), "{scene}");
            scene = scene.replace(&line, &format!("{line}\nregion = \"whole\""));
        }
        let mut session = open_drafted(&bench.write("scene.toml", scene));
        session.keep_history();
        session
    }

    /// A session of an editor with a sheet, where strokes can be undone.
    pub fn open_sheet(&self, bench: &Bench, document: &ObjDocument) -> Session {
        bench.write("model.obj", document.bytes());
        let material = DraftMaterial::Sheet { plugin: "cloth".into(), fabric: "denim".into(), held: Vec::new() };
        let mesh = bench.path("model.obj");
        let draft = Draft { mesh, scale: 1.0, size: SIZE, subdivide: false, weld: None, material, dt: 4e-3 };
        let mut session = open_drafted(&bench.write("scene.toml", draft.to_toml(&bench.path(""))));
        session.keep_history();
        session
    }

    /// The place behind which a place (m) is seen, at the depth of the drawn line.
    pub fn on_line_plane(&self, x: Vec3) -> Vec3 {
        let depth = |from: Vec3, to: Vec3| (to - from).dot(&self.back);
        let start = self.line[0];
        self.eye.map_or(x, |eye| eye.lerp(&x, depth(eye, start) / depth(eye, x)))
    }

    /// Unit normal of the plane in which the blade goes.
    pub fn plane(&self) -> Vec3 {
        let [start, end] = self.line;
        (end - start).cross(&self.along_blade(start)).normalize()
    }

    /// Goes to the first place, and from there to the second with the button of an edit kind, at 1 mm a step.
    pub fn stroke(&self, session: &mut Session, kind: &str, release: Release, [start, end]: [Vec3; 2]) {
        let kind = KINDS.iter().find(|other| other.name() == kind).expect("a kind");
        let button = 1 << stroke_button(*kind, release, PaintStroke::default());
        let mut sample = |position: Vec3, buttons: u32| {
            session.place_hand(0, Some(HandPose { position, rotation: UnitQuaternion::identity(), buttons }));
            session.step();
            session.frame().tools[0].hand
        };
        while (sample(start, 0) - start).norm() > 0.2 * RADIUS {}
        let steps = ((end - start).norm() / 1e-3).ceil().max(1.0) as u32;
        (1..=steps).for_each(|step| _ = sample(start.lerp(&end, f64::from(step) / f64::from(steps)), button));
        (0..50).for_each(|_| _ = sample(end, button));
        (0..50).for_each(|_| _ = sample(end, 0));
    }

    /// Draws the line as a window does that shows a simulation slower than the hand.
    pub fn draw(&self, session: &mut Session, [start, end]: [Vec3; 2]) {
        let cut = KINDS.iter().find(|kind| kind.name() == "cut").expect("a kind");
        let button = 1 << stroke_button(*cut, Release::Keep, PaintStroke::default());
        // As a pointer's hand goes: the blade stays in the plane of the eye and the line.
        let from = UnitQuaternion::rotation_between(&Vec3::z(), &self.along_blade(start)).expect("no half turn");
        let turn = UnitQuaternion::rotation_between(&self.along_blade(start), &self.along_blade(end));
        let to = turn.expect("no half turn") * from;
        self.draw_way(session, button, &[start, end], |position| {
            from.nlerp(&to, (position - start).norm() / (end - start).norm())
        });
    }

    /// Draws a line with corners, by a blade that stays parallel.
    pub fn draw_bent(&self, session: &mut Session, way: &[Vec3]) {
        let cut = KINDS.iter().find(|kind| kind.name() == "cut").expect("a kind");
        let button = 1 << stroke_button(*cut, Release::Keep, PaintStroke::default());
        let rotation = UnitQuaternion::rotation_between(&Vec3::z(), &self.back).expect("no half turn");
        self.draw_way(session, button, way, |_| rotation);
    }

    /// Draws from place to place (m) with a button, and the rotation of the hand at each.
    fn draw_way(
        &self,
        session: &mut Session,
        button: u32,
        way: &[Vec3],
        rotation_at: impl Fn(Vec3) -> UnitQuaternion<f64>,
    ) {
        let mut sample = |position: Vec3, buttons: u32| {
            session.place_hand(0, Some(HandPose { position, rotation: rotation_at(position), buttons }));
            session.step();
            session.frame().tools[0].hand
        };
        let (start, end) = (way[0], way[way.len() - 1]);
        while (sample(start, 0) - start).norm() > 0.2 * RADIUS {}
        (0..self.waits[0]).for_each(|_| _ = sample(start, 0));
        let mut hand = start;
        for [from, to] in way.windows(2).map(|pair| [pair[0], pair[1]]) {
            let steps = ((to - from).norm() / self.jump).ceil().max(1.0) as u32;
            (1..=steps).for_each(|step| hand = sample(from.lerp(&to, f64::from(step) / f64::from(steps)), button));
        }
        // The hand of the session is no faster than its limit, and the button is held until it has all but arrived.
        while (hand - end).norm() > 0.2 * RADIUS {
            hand = sample(end, button);
        }
        (0..self.waits[1]).for_each(|_| _ = sample(end, button));
        (0..3).for_each(|_| _ = sample(end, 0));
    }
}

/// What lines have not parted, by the numbers of their cases.
#[derive(Default)]
pub struct Unparted {
    /// Number of lines that were drawn.
    pub drawn: usize,
    /// Cases with fewer parts than expected.
    pub necks: Vec<u64>,
    /// Those of them of which no event tells.
    pub silent: Vec<u64>,
    /// Cases without a neck in which a line ends on the skin: it has a branch beside it.
    pub ended: Vec<u64>,
    /// Cases in which the lattice joins parts of the surface.
    pub joined: Vec<u64>,
    /// Cases in which the lattice has parts besides those of the surface.
    pub extra: Vec<u64>,
}

impl Unparted {
    /// Adds a case whose lines are drawn, and prints it if anything is not as `expected` (a number of parts).
    pub fn add(&mut self, number: u64, case: &DrawnCut, session: &mut Session, expected: u32) {
        self.drawn += 1;
        let parts = count(&session.bodies[0].model.surface);
        let told = session.events.count(EventKind::CutHeld) + session.events.count(EventKind::CutAgain);
        if parts < expected {
            self.necks.push(number);
            if told == 0 {
                self.silent.push(number);
            }
        }
        let ends = line_ends(session.bodies[0].cut.as_ref().expect("a solid that can be cut"));
        if !ends.is_empty() && parts >= expected {
            self.ended.push(number);
        }
        let pairs = joined_in_lattice(&mut session.bodies[0]);
        if pairs > 0 {
            self.joined.push(number);
        }
        let extra = extra_parts(&session.bodies[0]);
        if extra > 0 {
            self.extra.push(number);
        }
        if parts != expected || pairs > 0 || extra > 0 || !ends.is_empty() {
            println!(
                "{number}: {parts} of {expected} parts, {told} told, {pairs} joined in the lattice, {extra} parts too many of it, {} ends of lines: {case:?}",
                ends.len()
            );
            println!("{number}: volumes of the parts in cells: {:.2?}", volumes(&session.bodies[0]));
        }
    }

    /// Prints the counts.
    pub fn print(&self) {
        let Self { drawn, necks, silent, ended, joined, extra } = self;
        println!("{} of {drawn} lines leave a neck: {necks:?}; {} of them without a word", necks.len(), silent.len());
        println!("{} of {drawn} lines have a branch beside them: {ended:?}", ended.len());
        println!("{} of {drawn} lines leave parts of the surface that the lattice joins: {joined:?}", joined.len());
        println!("{} of {drawn} lines leave more parts of the lattice than of the surface: {extra:?}", extra.len());
    }
}

/// Volumes of the parts of a body's surface in cells, ascending.
fn volumes(body: &Body) -> Vec<f64> {
    let (Some(mesh), Some(lattice)) = (&body.cut, body.discretization.lattice()) else { return Vec::new() };
    let mut volumes: Vec<f64> = mesh.parts().all.iter().map(|part| part.volume / lattice.edge().powi(3)).collect();
    volumes.sort_by(f64::total_cmp);
    volumes
}

/// Number of connected parts of a surface.
pub fn count(surface: &Surface) -> u32 {
    surface.shells().iter().max().map_or(0, |last| last + 1)
}

/// Pairs of parts of the surface, each of them larger than [`LEAST_CELLS`], that one part of the lattice carries.
fn joined_in_lattice(body: &mut Body) -> usize {
    // Everything is active for this.
    if !body.discretization.is_whole() {
        let Body { model, skin, system, discretization, fixings, .. } = &mut *body;
        let ball = Ball { centre: [0.0; 3], radius: 4.0 * SIZE };
        discretization.follow(&[ball], model, fixings, skin, system).expect("a region");
    }
    let (Some(mesh), Some(lattice)) = (&body.cut, body.discretization.lattice()) else { return 0 };
    let parts = lattice.parts();
    let part = |v: u32| parts[lattice.region().cell_corners[body.skin.cell[v as usize] as usize][0] as usize];
    let least = LEAST_CELLS * lattice.edge().powi(3);
    let shells = mesh.parts();
    let mut carriers: Vec<BTreeMap<u32, usize>> = vec![BTreeMap::new(); shells.all.len()];
    for (corners, shell) in mesh.surface().triangles.iter().zip(&shells.of) {
        corners.iter().for_each(|v| *carriers[*shell as usize].entry(part(*v)).or_default() += 1);
    }
    let most = |carrier: &BTreeMap<u32, usize>| carrier.iter().max_by_key(|(_, count)| **count).map(|(part, _)| *part);
    let mut carriers: Vec<_> =
        carriers.iter().zip(&shells.all).filter(|(_, p)| p.volume > least).map(|(c, _)| most(c)).collect();
    let count = carriers.len();
    carriers.sort_unstable();
    carriers.dedup();
    count - carriers.len()
}

/// Number of parts of the active lattice that carry no part of the surface, or less of one than another does.
pub fn extra_parts(body: &Body) -> usize {
    let Some(lattice) = body.discretization.lattice() else { return 0 };
    let (parts, shells) = (lattice.parts(), body.model.surface.shells());
    let count = parts.iter().max().map_or(0, |last| *last as usize + 1);
    let mut points = vec![BTreeMap::<u32, usize>::new(); shells.iter().max().map_or(0, |last| *last as usize + 1)];
    for (corners, shell) in body.model.surface.triangles.iter().zip(&shells) {
        for cell in corners.map(|v| body.skin.cell[v as usize]).into_iter().filter(|cell| *cell != NOT_EMBEDDED) {
            *points[*shell as usize]
                .entry(parts[lattice.region().cell_corners[cell as usize][0] as usize])
                .or_default() += 1;
        }
    }
    let carriers = points.iter().filter_map(|of| of.iter().max_by_key(|(_, count)| **count).map(|(part, _)| *part));
    count - carriers.collect::<BTreeSet<_>>().len()
}
