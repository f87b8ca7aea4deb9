//! Lines drawn where a cut already is. `LINES=0..60` asks for more.

use crate::ball_cuts::{LEVEL, RADIUS, cut_ball, result};
use pliant_mesh::testing::Random;
use pliant_solver::Vec3;
use pliant_tests::case_count;

/// A stride of the blade, m: a quarter of a cell.
const STRIDE: f64 = 0.25 * 2.0 * RADIUS / (1 << LEVEL) as f64;

/// A line through the ball at `x` (m), turned by an angle (rad) about the middle of the line.
fn line(x: f64, angle: f64) -> [Vec3; 2] {
    [2.0, -2.0].map(|share| Vec3::new(x + share * RADIUS * angle.sin(), share * RADIUS * angle.cos(), 0.0))
}

#[test]
fn a_line_that_is_drawn_again_cuts_nothing_and_a_longer_one_goes_on() {
    let mut random = Random(70);
    for case in 0..case_count("LINES", 3) {
        let drawn = line(0.5 * RADIUS * random.signed(), 0.0);
        let off = [0.0, 1e-5, 1.0][case % 3] * 0.2 * STRIDE * random.signed() * Vec3::x();
        let (again, once) = (drawn.map(|point| point + off), result(&cut_ball(&[drawn], false)));
        assert_eq!(result(&cut_ball(&[drawn, again], false)), once, "case {case}, {drawn:?}, off by {off:?} m");
        let short = [drawn[0], drawn[0].lerp(&drawn[1], 0.4 + 0.2 * random.unit())];
        let (parts, area) = result(&cut_ball(&[short, again], false));
        // The strip through the walls begins one stride behind, and one that the mesh refuses waits for three.
        let most = once.1 + 5.0 * STRIDE * 2.0 * RADIUS;
        assert!((2..=3).contains(&parts), "case {case}, {short:?} and {again:?}: {parts} parts");
        assert!((0.99 * once.1..most).contains(&area), "case {case}: {area} m^2 of {} m^2", once.1);
    }
}

#[test]
fn a_line_that_crosses_a_cut_parts_both_sides_of_it() {
    let mut random = Random(71);
    for case in 0..case_count("LINES", 4) {
        let (x, angle) = (0.5 * RADIUS * random.signed(), 0.1 + 1.2 * random.unit());
        let once = result(&cut_ball(&[line(x, 0.0)], false)).1 + result(&cut_ball(&[line(x, angle)], false)).1;
        let (parts, area) = result(&cut_ball(&[line(x, 0.0), line(x, angle)], false));
        assert!(parts >= 4, "case {case}, at {x} m, angle {angle}: {parts} parts");
        // Within 0.2 rad, whose cosine is 0.98, and as much as its way wanders, it goes along the slit from 0.1 of a cell on one side to 0.4 on the other; a stride more or less.
        let along = if angle < 0.3 { 4.0 * STRIDE * 0.5 / angle.sin() + 2.0 * STRIDE } else { 0.0 };
        let least = 0.97 * once - along * 2.0 * RADIUS;
        assert!((least..1.03 * once).contains(&area), "case {case}, at {x} m, angle {angle}: {area} m^2 of {once} m^2");
    }
}
