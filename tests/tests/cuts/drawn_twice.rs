//! Two lines drawn across a body one after the other: they cross, or the second goes along with the first.
//!
//! `CROSSED=0..100` and `AGAIN=0..100 cargo test --release -p pliant-tests --test cuts drawn_twice` draw those cases in place of the fixed ones.

#![allow(clippy::print_stdout, reason = "what failed, and the count")]

use crate::drawn_line::{DrawnCut, Unparted, count};
use pliant_engine::session::{EventKind, Session};
use pliant_tests::{Bench, asked_cases};

/// Least angle between two lines at which they cross, rad. Below it the second goes along the slit of the first for a while, and may leave the body there.
const LEAST_ANGLE: f64 = 0.2;

#[test]
fn a_line_that_crosses_a_cut_parts_what_lies_on_both_sides() {
    let asked = asked_cases("CROSSED");
    let (mut crossing_lines, mut slanted_lines) = (Unparted::default(), Unparted::default());
    // Finer grids take minutes.
    let levels = if asked.is_some() { 4..=7 } else { 4..=5 };
    for number in asked.unwrap_or(0..10) {
        let bench = Bench::new();
        let (case, document) = DrawnCut::new(number, &levels);
        let mut session = case.open(&bench, &document);
        let crossing = case.crossing(number);
        let [along, across] = [case.line, crossing].map(|[start, end]| end - start);
        let is_slanted = along.angle(&across) < LEAST_ANGLE;
        // A body that floats has moved by then, and the line may be beside the first one.
        if is_slanted && case.is_whole {
            continue;
        }
        let unparted = if is_slanted { &mut slanted_lines } else { &mut crossing_lines };
        let Some(expected) = case.expected(&session, &[case.line, crossing]) else { continue };
        case.draw(&mut session, case.line);
        case.draw(&mut session, crossing);
        unparted.add(number, &case, &mut session, expected);
        assert!(session.undo() && session.undo(), "{number}");
        assert_eq!(count(&session.bodies[0].model.surface), 1, "{number}: two undos take both strokes back");
    }
    slanted_lines.print();
    crossing_lines.print();
    assert!(slanted_lines.silent.is_empty(), "{:?}", slanted_lines.silent);
    let Unparted { drawn, necks, silent, ended, joined, extra } = crossing_lines;
    assert!(silent.is_empty(), "{silent:?}");
    assert!(10 * necks.len() <= drawn, "{} of {drawn}: {necks:?}", necks.len());
    // Where a line crosses the walls of the first, strips that lead around what the mesh refuses begin beside it.
    assert!(3 * ended.len() <= drawn, "{} of {drawn} have a branch: {ended:?}", ended.len());
    assert!(20 * joined.len() <= drawn, "{} of {drawn}: {joined:?}", joined.len());
    assert!(10 * extra.len() <= drawn, "{} of {drawn}: {extra:?}", extra.len());
}

#[test]
fn a_line_that_is_drawn_again_leaves_no_crumbs() {
    let (asked, mut drawn) = (asked_cases("AGAIN"), 0);
    let (mut crumbled, mut wandered, mut turned) = (Vec::new(), Vec::new(), Vec::new());
    for number in asked.unwrap_or(0..20) {
        let bench = Bench::new();
        let (case, document) = DrawnCut::new(number, &(4..=6));
        let mut session = case.open(&bench, &document);
        // A body that floats has moved by then, and the line is at another place of it.
        if case.is_whole || case.expected(&session, &[case.line]).is_none() {
            continue;
        }
        drawn += 1;
        let draw = |session: &mut Session| {
            case.draw(session, case.line);
            (count(&session.bodies[0].model.surface), session.cuts().area)
        };
        let once = draw(&mut session);
        assert_eq!(session.events.count(EventKind::CutAgain), 0, "{number}: nothing was cut before");
        let again = draw(&mut session);
        let told = session.events.count(EventKind::CutAgain);
        if again.0 != once.0 {
            // A blade that turns is farther from its slit where the material gave way.
            if case.is_perspective() { &mut turned } else { &mut crumbled }.push(number);
        } else if again.1 > 1.01 * once.1 {
            // Where the material gives way the blade may come out of the slit.
            wandered.push(number);
        }
        assert!(told <= 1 && (told == 1 || again.1 > once.1), "{number}: told {told} times, {once:?}, then {again:?}");
        if again != once {
            println!("{number}: {once:?}, then {again:?} parts and m^2: {case:?}");
        }
    }
    println!("{} of {drawn} lines drawn again leave other parts: {crumbled:?}", crumbled.len());
    println!("{} of {drawn} lines drawn again in perspective leave other parts: {turned:?}", turned.len());
    println!("{} of {drawn} lines drawn again cut over 1 % more: {wandered:?}", wandered.len());
    assert!(crumbled.is_empty(), "{} of {drawn}: {crumbled:?}", crumbled.len());
    assert!(4 * (turned.len() + wandered.len()) <= drawn, "of {drawn} lines: {turned:?} {wandered:?}");
}
