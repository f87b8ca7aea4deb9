//! The closed loop of arm, coupling and controller in a time of its own: stable where it must be, and no blind measure.

use pliant_tests::wall::{Wall, swing};

/// m, ten counts of the arm's encoder: what an arm at rest may stay within
const STILL: f64 = 5.5e-4;

/// An arm of 0.8 N s/m on a wall of so many times the bound of passivity, 2 b / T (Colgate and Schenkel 1997).
fn wall(rate: f64, times: f64, controls: bool) -> Wall {
    let damping = 0.8;
    Wall { rate, damping, stiffness: times * 2.0 * damping * rate, controls, ..Wall::default() }
}

#[test]
fn below_the_bound_the_arm_comes_to_rest_and_far_above_it_does_not() {
    for rate in [250.0, 1000.0, 4000.0] {
        let [below, above] = [0.5, 3.0].map(|times| swing(&wall(rate, times, false)));
        println!("{rate} Hz: {below:e} m at half of the bound, {above:e} m at three times of it");
        assert!(below < STILL, "{rate} Hz, half of the bound: {below} m");
        assert!(above > 3.0 * STILL, "{rate} Hz, three times the bound: {above} m");
    }
}

#[test]
fn with_the_controller_the_arm_comes_to_rest_far_above_the_bound() {
    // At every rate: a controller that is late, as one over a fixed number of samples is at 250 Hz, drives the arm itself.
    for (rate, times) in [(250.0, 0.5), (250.0, 2.0), (500.0, 3.0), (1000.0, 3.0), (2000.0, 3.0), (4000.0, 10.0)] {
        let rest = swing(&wall(rate, times, true));
        println!("{rate} Hz: {rest:e} m at {times} times the bound");
        assert!(rest < STILL, "{rate} Hz, {times} times the bound: {rest} m");
    }
}

#[test]
fn a_pressed_spring_is_no_credit_for_a_swing() {
    // Hardly damped, pressed in by 18 mm: what the spring holds then would pay for minutes of a swing of millimetres.
    let press = |controls| swing(&Wall { damping: 0.05, stiffness: 110.0, controls, ..Wall::default() });
    let [alone, controlled] = [false, true].map(press);
    println!("{alone:e} m alone, {controlled:e} m with the controller");
    assert!(alone > 3.0 * STILL && controlled < STILL, "{alone} m alone, {controlled} m with the controller");
}
