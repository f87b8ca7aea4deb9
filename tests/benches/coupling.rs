//! Up to what stiffness a coupling is stable, by the rate of the loop and the damping of the device, beside the bound of
//! passivity of Colgate and Schenkel (1997), K < 2 b / T: `cargo bench -p pliant-tests --bench coupling`.
//!
//! A simulated arm (45 g) leans on a virtual wall, let go at 5 mm in front of it with 2 N towards it and no hand that would
//! calm it. Unstable: long after its own damping would have calmed it, it still goes to and fro by more than ten counts of
//! its encoder.
#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

use pliant_tests::wall::{Wall, swing};

fn main() {
    println!(
        "largest stable K, N/m, and its ratio to 2 b / T, by rate, damping of the device and control of passivity"
    );
    println!("{:>7} {:>9} {:>10} {:>20} {:>20}", "rate Hz", "b N s/m", "2b/T N/m", "observer alone", "with controller");
    for rate in [250.0, 500.0, 1000.0, 2000.0, 4000.0] {
        for damping in [0.05, 0.2, 0.8] {
            let bound = 2.0 * damping * rate;
            let [alone, controlled] = [false, true].map(|controls| largest(rate, damping, controls, 5.5e-5));
            println!(
                "{rate:>7} {damping:>9} {bound:>10.0} {alone:>12.0} ({:>5.2}) {controlled:>12.0} ({:>5.2})",
                alone / bound,
                controlled / bound
            );
        }
    }
    println!("with a step of the simulation in every fourth tick, 1 kHz, b = 0.2 N s/m:");
    for (what, slope) in [("contact model with its stiffness", true), ("force alone, held", false)] {
        let at = |k: f64| Wall { stiffness: k, every: 4, slope, controls: false, ..Wall::default() };
        println!("  {what}: {:.0} N/m", bisect(|k| swing(&at(k)) < 5.5e-4));
    }
    println!("without quantisation, 1 kHz, b = 0.2 N s/m: {:.0} N/m", largest(1000.0, 0.2, false, 0.0));
}

fn largest(rate: f64, damping: f64, controls: bool, resolution: f64) -> f64 {
    bisect(|stiffness| swing(&Wall { rate, damping, stiffness, controls, resolution, ..Wall::default() }) < 5.5e-4)
}

/// The largest stiffness below the first unstable one, to 2 %.
fn bisect(stable: impl Fn(f64) -> bool) -> f64 {
    let mut low = 10.0;
    while low < 2e5 && stable(low * 1.25) {
        low *= 1.25;
    }
    let mut high = low * 1.25;
    while high / low > 1.02 {
        let middle = (low * high).sqrt();
        if stable(middle) { low = middle } else { high = middle }
    }
    low
}
