//! A line drawn across a sheet, straight or with a corner, parts all layers of it that lie behind each other there, whatever shape it has.
//!
//! `LAYERS=0..1000 cargo test --release -p pliant-tests --test cuts sheet_layers` draws those lines in place of the fixed ones.

#![allow(clippy::print_stdout, reason = "what failed, and the count")]

use crate::drawn_line::{DrawnCut, SIZE, count};
use nalgebra::Vector3;
use pliant_engine::scene::Release;
use pliant_engine::session::{EventKind, Session};
use pliant_mesh::DisjointSets;
use pliant_mesh::testing::Random;
use pliant_tests::{Bench, asked_cases};

/// Distance from the drawn plane up to which a vertex may be on either side, in mean edges: vertices up to a fifth of their shortest edge away are snapped to the cut, and
/// crossings within a tenth of an edge, which may be three times as long, to its end.
const SNAPPED: f64 = 0.35;

/// The sheet and the drawn area.
struct Parted {
    /// Triangles that reach farther to both sides than what is snapped.
    crossing: usize,
    /// Number of pieces that the area leaves of the surface and that reach farther than that to one side.
    pieces: usize,
    /// Whether the line begins and ends beside the sheet.
    is_across: bool,
}

/// `height` is the signed distance from the drawn area, m.
fn parted(session: &mut Session, case: &DrawnCut, height: impl Fn(Vector3<f64>) -> f64) -> Parted {
    session.update_surface();
    let body = &session.bodies[0];
    let margin = SNAPPED * body.discretization.edge();
    let heights: Vec<f64> = body.skin.x.iter().map(|x| height(*x)).collect();
    let triangles = &body.model.surface.triangles;
    // A piece is on one side: vertices of each side that share an edge, and the two sides of a triangle are apart.
    let mut sets = DisjointSets::new(heights.len());
    let mut crossing = 0;
    for corners in triangles {
        let of = corners.map(|v| heights[v as usize]);
        crossing += usize::from(of.iter().any(|h| *h > margin) && of.iter().any(|h| *h < -margin));
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if of[i] * of[j] > 0.0 {
                sets.unite(corners[i], corners[j]);
            }
        }
    }
    let far = |v: &u32| heights[*v as usize].abs() > margin;
    let mut roots: Vec<u32> = triangles.iter().flatten().copied().filter(far).map(|v| sets.find(v)).collect();
    roots.sort_unstable();
    roots.dedup();
    let way = case.line[1] - case.line[0];
    let share = |x: &Vector3<f64>| (case.on_line_plane(*x) - case.line[0]).dot(&way) / way.norm_squared();
    let is_across = body.skin.x.iter().all(|x| (0.0..=1.0).contains(&share(x)));
    Parted { crossing, pieces: roots.len(), is_across }
}

/// Lines that leave layers of a sheet that hold together, by the numbers of their cases.
#[derive(Default)]
struct Held {
    drawn: usize,
    all: Vec<u64>,
    /// Those of them of which no event tells.
    silent: Vec<u64>,
}

impl Held {
    /// Draws a line across the sheet of a case, and takes it back. `height` is the signed distance from the drawn area, m.
    fn add(
        &mut self,
        number: u64,
        (case, session): (&DrawnCut, &mut Session),
        height: impl Fn(Vector3<f64>) -> f64 + Copy,
        draw: impl FnOnce(&mut Session),
    ) {
        let done = session.history().done;
        let before = session.bodies[0].model.surface.triangles.clone();
        let mass = |session: &Session| session.bodies[0].system.nodes.mass.iter().sum::<f64>();
        let (whole, expected) = (mass(session), parted(session, case, height));
        if expected.crossing == 0 || !expected.is_across {
            return;
        }
        draw(session);
        let after = parted(session, case, height);
        // A sheet that drifts after the grab may have come beyond an end of the line.
        if !after.is_across {
            return;
        }
        self.drawn += 1;
        let parts = count(&session.bodies[0].model.surface);
        if after.crossing > 0 || parts < expected.pieces as u32 {
            println!(
                "{number}: {} of {} triangles across the line, {parts} of {} parts: {case:?}",
                after.crossing, expected.crossing, expected.pieces
            );
            self.all.push(number);
            if session.events.count(EventKind::CutRefused) == 0 {
                self.silent.push(number);
            }
        }
        let cut = mass(session);
        assert!((cut - whole).abs() < 1e-9 * whole, "{number}: {whole} kg became {cut}");
        assert_eq!(session.history().done, done + 1, "{number}: a line is one entry of the history");
        assert!(session.undo(), "{number}");
        assert_eq!(session.bodies[0].model.surface.triangles, before, "{number}: one undo takes the cut back");
    }

    fn check(&self) {
        let Self { drawn, all, silent } = self;
        println!("{} of {drawn} lines leave layers that hold together: {all:?}; {silent:?} without a word", all.len());
        // Where a line grazes a border, a piece of a few triangles may hang on by a vertex that was snapped to the cut.
        assert!(500 * silent.len() <= *drawn, "{silent:?}");
        assert!(100 * all.len() <= *drawn, "{all:?}");
    }
}

#[test]
fn a_line_across_a_sheet_parts_all_its_layers() {
    let mut held = Held::default();
    for number in asked_cases("LAYERS").unwrap_or(0..40) {
        let bench = Bench::new();
        let (case, document) = DrawnCut::of_sheet(number);
        let mut session = case.open_sheet(&bench, &document);
        // Every other sheet has been deformed, so that its present shape is not that of the file.
        if number % 4 < 2 {
            let random = &mut Random(number);
            let points = &session.bodies[0].model.surface.points;
            let held = points[random.below(points.len() as u64) as usize];
            case.stroke(&mut session, "grab", Release::Keep, [held, held + 0.02 * random.direction()]);
        }
        let height = |x: Vector3<f64>| (x - case.line[0]).dot(&case.plane());
        held.add(number, (&case, &mut session), height, |session| case.draw(session, case.line));
    }
    held.check();
}

#[test]
fn a_line_with_a_corner_parts_what_is_on_its_sides() {
    let mut held = Held::default();
    // Blades of even numbers stay parallel.
    for number in asked_cases("LAYERS").unwrap_or(0..40).filter(|number| number % 2 == 0) {
        let bench = Bench::new();
        let (case, document) = DrawnCut::of_sheet(number);
        let mut session = case.open_sheet(&bench, &document);
        let random = &mut Random(number ^ 0x636f_726e);
        let ([start, end], normal) = (case.line, case.plane());
        let aside = SIZE * (0.05 + 0.3 * random.unit()) * random.signed().signum();
        let corner = start.lerp(&end, 0.3 + 0.4 * random.unit()) + aside * normal;
        // A hand that hesitates goes back a part of its way.
        let back = corner.lerp(&start, 0.1 + 0.8 * random.unit());
        let way = if number % 4 == 0 { vec![start, corner, end] } else { vec![start, corner, back, corner, end] };
        let along = (end - start).cross(&normal).normalize();
        let sides = [[start, corner], [corner, end]].map(|[from, to]| (from, along.cross(&(to - from)).normalize()));
        let height = |x: Vector3<f64>| {
            let [a, b] = sides.map(|(from, up)| (x - from).dot(&up) * up.dot(&normal).signum());
            if aside > 0.0 { a.max(b) } else { a.min(b) }
        };
        held.add(number, (&case, &mut session), height, |session| case.draw_bent(session, &way));
    }
    held.check();
}
