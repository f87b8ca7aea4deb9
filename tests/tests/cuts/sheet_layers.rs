//! A line drawn across a sheet parts all layers of it that lie behind each other there, whatever shape it has.
//!
//! `LAYERS=0..1000 cargo test --release -p pliant-tests --test cuts sheet_layers` draws those lines in place of the fixed ones.

#![allow(clippy::print_stdout, reason = "what failed, and the count")]

use crate::drawn_line::{DrawnCut, count};
use nalgebra::Vector3;
use pliant_engine::scene::Release;
use pliant_engine::session::{EventKind, Session};
use pliant_mesh::DisjointSets;
use pliant_mesh::testing::Random;
use pliant_tests::{Bench, asked_cases};

/// Distance from the drawn plane up to which a vertex may be on either side, in mean edges: vertices up to a fifth of their shortest edge away are snapped to the cut, and
/// crossings within a tenth of an edge, which may be three times as long, to its end.
const SNAPPED: f64 = 0.35;

/// The sheet and the drawn plane.
struct Parted {
    /// Triangles that reach farther to both sides than what is snapped.
    crossing: usize,
    /// Number of pieces that the plane leaves of the surface and that reach farther than that to one side.
    pieces: usize,
    /// Whether the line begins and ends beside the sheet.
    is_across: bool,
}

fn parted(session: &mut Session, case: &DrawnCut) -> Parted {
    session.update_surface();
    let (normal, body) = (case.plane(), &session.bodies[0]);
    let margin = SNAPPED * body.discretization.edge();
    let heights: Vec<f64> = body.skin.x.iter().map(|x: &Vector3<f64>| (x - case.line[0]).dot(&normal)).collect();
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

#[test]
fn a_line_across_a_sheet_parts_all_its_layers() {
    let (mut drawn, mut held, mut silent) = (0, Vec::new(), Vec::new());
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
        let done = session.history().done;
        let before = session.bodies[0].model.surface.triangles.clone();
        let mass: f64 = session.bodies[0].system.nodes.mass.iter().sum();
        let expected = parted(&mut session, &case);
        if expected.crossing == 0 || !expected.is_across {
            continue;
        }
        case.draw(&mut session, case.line);
        let after = parted(&mut session, &case);
        // A sheet that drifts after the grab may have come beyond an end of the line.
        if !after.is_across {
            continue;
        }
        drawn += 1;
        if after.crossing > 0 || count(&session.bodies[0].model.surface) < expected.pieces as u32 {
            let parts = count(&session.bodies[0].model.surface);
            println!(
                "{number}: {} of {} triangles across the line, {parts} of {} parts: {case:?}",
                after.crossing, expected.crossing, expected.pieces
            );
            held.push(number);
            if session.events.count(EventKind::CutRefused) == 0 {
                silent.push(number);
            }
        }
        let cut_mass: f64 = session.bodies[0].system.nodes.mass.iter().sum();
        assert!((cut_mass - mass).abs() < 1e-9 * mass, "{number}: {mass} kg became {cut_mass}");
        assert_eq!(session.history().done, done + 1, "{number}: a line is one entry of the history");
        assert!(session.undo(), "{number}");
        assert_eq!(session.bodies[0].model.surface.triangles, before, "{number}: one undo takes the cut back");
    }
    println!(
        "{} of {drawn} lines leave layers that hold together: {held:?}; {} of them without a word",
        held.len(),
        silent.len()
    );
    // Where a line grazes a border, a piece of a few triangles may hang on by a vertex that was snapped to the cut.
    assert!(500 * silent.len() <= drawn, "{silent:?}");
    assert!(100 * held.len() <= drawn, "{held:?}");
}
