//! Time of one evaluation of the forces of a block of 16^3 particles, 43 872 springs, on one core.

#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

use pliant_mass_spring::MassSpring;
use pliant_plugin_api::{abi, kit};
use std::time::Instant;

fn main() {
    let block = kit::block([15, 15, 15], 2.5e-3, abi::STRUCTURAL | abi::SHEAR | abi::FLEXION);
    let springs = block.links.family.len();
    for damping_time in [0.0, 1e-4] {
        let material: MassSpring = kit::material(&[("flexion", 0.125), ("damping-time", damping_time)]).unwrap();
        let mut body = kit::Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
        for (i, x) in body.x.iter_mut().enumerate() {
            x[0] += 1e-4 * (i as f64).sin();
        }
        let mut force = vec![[0.0; 3]; body.x.len()];
        let mut seconds: Vec<f64> = (0..2000)
            .map(|_| {
                let start = Instant::now();
                body.add_forces(&material, &mut force).unwrap();
                start.elapsed().as_secs_f64()
            })
            .collect();
        seconds.sort_by(f64::total_cmp);
        let (fastest, median) = (seconds[0], seconds[seconds.len() / 2]);
        let ns_per_spring = 1e9 * median / springs as f64;
        println!(
            "{springs} springs, damping time {damping_time} s: median {:.1} us, fastest {:.1} us, {ns_per_spring:.2} ns per spring",
            1e6 * median,
            1e6 * fastest
        );
        assert!(force.iter().flatten().all(|f| f.is_finite()));
    }
}
