//! A line drawn across a soft body parts it: whatever the speed of the hand, the jumps between its samples, the body and its material, the blade of an
//! editor leaves the parts that the drawn area separates, or it is told what holds.
//!
//! `DRAWN=0..2000 cargo test --release -p pliant-tests --test cuts drawn` draws those cuts in place of the fixed ones.

#![allow(clippy::print_stdout, reason = "what failed, and the count")]

use crate::drawn_line::{DrawnCut, Unparted, count};
use pliant_engine::session::HistoryCounts;
use pliant_tests::{Bench, asked_cases};

#[test]
fn a_drawn_line_parts_the_body_or_it_is_told_what_holds() {
    let (asked, mut unparted) = (asked_cases("DRAWN"), Unparted::default());
    // s, of a step that cuts and of the last one
    let (mut slowest, mut slowest_end) = (0.0_f64, 0.0_f64);
    // Finer grids take minutes.
    let levels = if asked.is_some() { 4..=7 } else { 4..=5 };
    for number in asked.unwrap_or(0..24) {
        let bench = Bench::new();
        let (case, document) = DrawnCut::new(number, &levels);
        let mut session = case.open(&bench, &document);
        let Some(expected) = case.expected(&session, &[case.line]) else { continue };
        case.draw(&mut session, case.line);
        unparted.add(number, &case, &mut session, expected);
        let seconds = &session.cuts().seconds;
        slowest = slowest.max(seconds.iter().copied().fold(0.0, f64::max));
        slowest_end = slowest_end.max(seconds.last().copied().unwrap_or(0.0));
        assert_eq!(
            session.history(),
            HistoryCounts { done: 1, undone: 0 },
            "{number}: a stroke is one step of the history"
        );
        assert!(session.undo(), "{number}");
        assert_eq!(count(&session.bodies[0].model.surface), 1, "{number}: one undo takes the stroke back");
    }
    unparted.print();
    println!("The slowest step that cuts takes {slowest:.3} s, the slowest end of a stroke {slowest_end:.3} s");
    let Unparted { drawn, necks, silent, ended, joined, extra } = unparted;
    assert!(silent.is_empty(), "{silent:?}");
    // Where the mesh refuses every strip there is no way around; before the swept area was one, half of the lines left a neck.
    assert!(20 * necks.len() <= drawn, "{} of {drawn}: {necks:?}", necks.len());
    assert!(5 * ended.len() <= drawn, "{} of {drawn} have a branch: {ended:?}", ended.len());
    assert!(20 * joined.len() <= drawn, "{} of {drawn}: {joined:?}", joined.len());
    assert!(20 * extra.len() <= drawn, "{} of {drawn}: {extra:?}", extra.len());
}
