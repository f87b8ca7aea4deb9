use super::*;
use crate::System;
use pliant_plugin_api::TangentScale;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Links with one history variable; a link has failed where it is above 1.
struct Ageing {
    requests: [ElementRequest; 1],
    /// Whether `failed` fails, after it has written something wrong.
    is_refused: Arc<AtomicBool>,
}

impl ForceModel for Ageing {
    fn name(&self) -> &str {
        "ageing"
    }

    fn requests(&self) -> &[ElementRequest] {
        &self.requests
    }

    fn rest(&self, _: &ElementCall<'_>, _: &mut [f64]) -> Result<(), ForceError> {
        Ok(())
    }

    fn mass(&self, _: &ElementCall<'_>, _: &mut [f64]) -> Result<(), ForceError> {
        Ok(())
    }

    fn energy(&self, call: &ElementCall<'_>) -> Result<f64, ForceError> {
        // Each corner of an element is a node of the call.
        let corners = &call.elements[call.range.start * call.corners..call.range.end * call.corners];
        assert!(corners.iter().all(|node| call.window.contains(&(*node as usize))));
        Ok(call.range.len() as f64)
    }

    fn forces(&self, _: &ElementCall<'_>, _: &mut [[f64; 3]]) -> Result<(), ForceError> {
        Ok(())
    }

    fn tangent(
        &self,
        _: &ElementCall<'_>,
        _: TangentScale,
        _: &[u32],
        _: usize,
        _: &mut [[f64; 9]],
    ) -> Result<(), ForceError> {
        Ok(())
    }

    fn failed(&self, call: &ElementCall<'_>, out: &mut [u8]) -> Result<(), ForceError> {
        if self.is_refused.load(Ordering::Relaxed) {
            out.fill(1);
            return Err(ForceError { model: "ageing".into(), call: "failed", reason: "refused on purpose".into() });
        }
        call.range.clone().for_each(|e| out[e] = u8::from(call.history[e] > 1.0));
        Ok(())
    }
}

#[test]
fn an_error_of_the_material_leaves_the_list_of_failed_elements_and_it_is_asked_again() {
    let is_refused = Arc::new(AtomicBool::new(false));
    let flags = abi::HAS_FORCES | abi::HAS_HISTORY | abi::CAN_FAIL;
    let request = ElementRequest { kind: abi::LINK, families: 0, flags, rest_stride: 0, history_stride: 1 };
    let mut system = System::new(Box::new(Ageing { requests: [request], is_refused: Arc::clone(&is_refused) }));
    system.nodes = Nodes::at_rest(vec![Vec3::zeros(); 3]);
    system.sets[0].list_mut().nodes = vec![0, 1, 1, 2];
    system.prepare().expect("sound");
    let time = StepTime { start: 0.0, dt: 1e-3 };
    system.sets[0].set_history(&[2.0, 0.0]);
    assert_eq!(system.energy(time).expect("sound"), 1.0);
    let changes = system.sets[0].failed_changes();
    is_refused.store(true, Ordering::Relaxed);
    system.sets[0].set_history(&[0.0, 2.0]);
    for _ in 0..2 {
        assert_eq!(system.energy(time).expect_err("refused").call, "failed");
        let set = &system.sets[0];
        assert_eq!((set.failed(), set.failed_count(), set.failed_changes()), (&[1, 0][..], 1, changes));
    }
    is_refused.store(false, Ordering::Relaxed);
    assert_eq!(system.energy(time).expect("sound"), 1.0);
    let set = &system.sets[0];
    assert_eq!((set.failed(), set.failed_changes()), (&[0, 1][..], changes + 1));
}

#[test]
fn elements_of_a_stencil_fail_one_by_one() {
    let flags = abi::HAS_FORCES | abi::HAS_HISTORY | abi::CAN_FAIL;
    let request = ElementRequest { kind: abi::TETRAHEDRON, families: 0, flags, rest_stride: 0, history_stride: 1 };
    let stencils = 40;
    for weights in [CornerWeights::straight_tetrahedra(), CornerWeights::curved_tetrahedra()] {
        let mut system = System::new(Box::new(Ageing { requests: [request], is_refused: Arc::default() }));
        system.nodes = Nodes::at_rest(vec![Vec3::zeros(); 10 * stencils]);
        let list = system.sets[0].list_mut();
        list.nodes = (0..10 * stencils as u32).collect();
        list.weights = Some(weights);
        system.prepare().expect("sound");
        let count = stencils * weights.parts();
        assert_eq!(system.sets[0].count(), count);
        let time = StepTime { start: 0.0, dt: 1e-3 };
        assert_eq!(system.energy(time).expect("sound"), count as f64);
        let gone = [0, 1, 5, 33, 34, 35, 36, 37, count - 1];
        let mut history = vec![0.0; count];
        gone.iter().for_each(|e| history[*e] = 2.0);
        system.sets[0].set_history(&history);
        assert_eq!(system.energy(time).expect("sound"), (count - gone.len()) as f64);
        assert!((0..count).all(|e| (system.sets[0].failed()[e] != 0) == gone.contains(&e)));
    }
}

#[test]
fn an_element_of_a_stencil_has_the_shape_of_its_tetrahedron() {
    // Where a map is affine, so is its tangent: corners are those of a tetrahedron of the same shape with the volume of the part.
    let corners = [[0.1, 0.2, 0.0], [1.3, 0.1, 0.2], [0.3, 1.1, -0.1], [0.2, 0.4, 0.9]].map(Vec3::from);
    let edges = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];
    let nodes: Vec<Vec3> = corners.into_iter().chain(edges.map(|[a, b]| 0.5 * (corners[a] + corners[b]))).collect();
    for weights in [CornerWeights::straight_tetrahedra(), CornerWeights::curved_tetrahedra()] {
        let scale = (1.0 / weights.parts() as f64).cbrt();
        let mut centre = Vec3::zeros();
        for part in weights.parts {
            let at = part.by_corner.map(|row| row.iter().zip(&nodes).map(|(w, x)| *w * x).sum::<Vec3>());
            for [a, b] in edges {
                let expected = scale * (corners[b] - corners[a]);
                assert!((at[b] - at[a] - expected).norm() < 1e-14);
            }
            // The point of the element is where it has the same barycentric coordinates.
            let middle = corners.iter().sum::<Vec3>() / 4.0;
            let own = at.iter().sum::<Vec3>() / 4.0;
            centre += (own - scale * middle) / (1.0 - scale) / weights.parts() as f64;
        }
        assert!((centre - corners.iter().sum::<Vec3>() / 4.0).norm() < 1e-14);
    }
}

#[test]
fn shares_of_the_mass_are_those_of_the_diagonal_of_the_consistent_matrix() {
    // Means of powers of barycentric coordinates over a tetrahedron: 3! a! b! / (a + b + 3)!.
    let factorial = |n: u32| (1..=n).product::<u32>();
    let mean = |a: u32, b: u32| f64::from(6 * factorial(a) * factorial(b)) / f64::from(factorial(a + b + 3));
    // Shape functions: L (2 L - 1) of a corner and 4 L M of the middle of an edge.
    let corner = 4.0 * mean(4, 0) - 4.0 * mean(3, 0) + mean(2, 0);
    let middle = 16.0 * mean(2, 2);
    let sum = 4.0 * corner + 6.0 * middle;
    for (node, share) in CornerWeights::MASS_SHARES.into_iter().enumerate() {
        let diagonal = if node < 4 { corner } else { middle };
        assert!((share - diagonal / sum).abs() < 1e-15, "node {node}");
    }
}
