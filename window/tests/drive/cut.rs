//! Lines drawn with the knife.

use crate::display::{Display, MIDDLE};
use crate::models::{ball, parts};
use crate::window::Window;
use std::f64::consts::{PI, TAU};

/// Pixels from the middle of the picture to the ends of a line: beside the ball, whose outline has a radius of some 200, and within the picture.
const REACH: f64 = 310.0;
/// What is said of a blade that was drawn right through, where parts still hold together.
const HELD: &str = "still hold together";

/// A line across the ball, and how fast it is drawn.
struct Line {
    ends: [[i32; 2]; 2],
    /// Moves of the pointer from one end to the other, one in 30 ms or so.
    moves: i32,
}

/// The lines of a family, evenly spread over directions and distances from the middle: the golden ratio leaves no gaps.
fn lines(count: u32) -> impl Iterator<Item = Line> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    (1..=count).map(move |number| {
        let turn = (f64::from(number) * golden).fract() * TAU;
        // At most two thirds of the ball's radius beside its middle, so that each line meets it.
        let aside = 130.0 * (PI * f64::from(number) * golden).sin();
        let (sin, cos) = turn.sin_cos();
        let half = (REACH * REACH - aside * aside).sqrt();
        let ends = [-half, half].map(|along| {
            let place = [along * cos - aside * sin, along * sin + aside * cos];
            [0, 1].map(|axis: usize| MIDDLE[axis] + place[axis].round() as i32)
        });
        Line { ends, moves: [1, 2, 4, 9, 20, 45][number as usize % 6] }
    })
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn a_line_across_the_ball_parts_it_at_any_speed_or_the_window_tells_what_holds() {
    let folder = tempfile::tempdir().unwrap();
    let model = ball(folder.path());
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    display.key("3");
    let (count, mut parted) = (12, 0);
    for Line { ends: [from, to], moves } in lines(count) {
        let told = window.messages(HELD);
        window.stroke(&display, [from, to], moves, "1");
        let parts = parts(window.save_at_rest(&display, &model));
        let is_told = window.messages(HELD) > told;
        assert!(
            parts > 1 || is_told,
            "from {from:?} to {to:?} in {moves} moves: the ball is whole, and nothing is told"
        );
        parted += u32::from(parts > 1);
        display.key("ctrl+z");
        window.wait_for_history("0", "1");
    }
    // Where the mesh refuses a strip a neck may be left, however the line is drawn.
    assert!(3 * parted > count, "{parted} of {count} lines part the ball");
    window.save(&display, &model);
    window.close(&display);
}
