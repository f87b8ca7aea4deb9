//! A line drawn across a body whose shape was changed before and kept: the cut follows the line on the skin, however far the material there is from its place in the file.
//!
//! `KEPT=0..200 cargo test --release -p pliant-tests --test cuts kept` draws those cases in place of the fixed ones.

#![allow(clippy::print_stdout, reason = "what was seen of each case")]

use crate::drawn_line::{DrawnCut, SIZE, count};
use pliant_cut::testing::line_vertices;
use pliant_engine::scene::Release;
use pliant_engine::session::{EventKind, Session, SessionCommand};
use pliant_mesh::testing::Random;
use pliant_tests::{Bench, asked_cases};

/// Largest distance of the cut from the line on the skin, in cell edges: two strides of the knife. The blade draws the material along, and where it goes through several parts of a body that
/// have moved differently, a straight one cannot follow each.
const MAX_DISTANCE: f64 = 0.5;

/// Largest distance of a vertex of the cut from the plane of the line and the eye, m, over the vertices on the skin, where the body is now.
fn farthest(session: &mut Session, case: &DrawnCut) -> f64 {
    session.update_surface();
    let normal = case.plane();
    let body = &session.bodies[0];
    let mesh = body.cut.as_ref().expect("a solid that can be cut");
    let distance = |v: &u32| (body.skin.x[*v as usize] - case.line[0]).dot(&normal).abs();
    line_vertices(mesh).iter().map(distance).fold(0.0, f64::max)
}

#[test]
fn a_line_on_a_shape_that_was_kept_is_straight() {
    for number in asked_cases("KEPT").unwrap_or(0..12) {
        let bench = Bench::new();
        let (case, document) = DrawnCut::new(number, &(4..=6));
        // A body that floats goes on moving.
        if case.is_whole {
            continue;
        }
        let mut session = case.open(&bench, &document);
        let Some(expected) = case.expected(&session, &[case.line]) else { continue };
        let random = &mut Random(number ^ 0x6b65_7074);
        let radius = SIZE * (0.05 + 0.15 * random.unit());
        assert!(session.apply(SessionCommand::ResizeTools { radius, coupling: 500.0 }));
        let points = &session.bodies[0].model.surface.points;
        let held = points[random.below(points.len() as u64) as usize];
        let way = SIZE * (0.05 + 0.15 * random.unit()) * random.direction();
        case.stroke(&mut session, "grab", Release::Keep, [held, held + way]);
        // A hand that has let go leaves no shape, but a body on its way back.
        if session.events.count(EventKind::NotKept) > 0 {
            println!("{number}: the shape was not kept: {case:?}");
            continue;
        }
        session.update_surface();
        let body = &session.bodies[0];
        let moved = body.skin.x.iter().zip(&body.model.surface.points).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        case.draw(&mut session, case.line);
        let farthest = farthest(&mut session, &case);
        let cell = session.bodies[0].discretization.edge();
        println!(
            "{number}: the shape has moved by {:.1} cells, the cut is {:.2} cells from the line: {case:?}",
            moved / cell,
            farthest / cell
        );
        assert!(farthest <= MAX_DISTANCE * cell, "{number}: {:.2} cells from the line", farthest / cell);
        assert_eq!(count(&session.bodies[0].model.surface), expected, "{number}: parts");
    }
}
