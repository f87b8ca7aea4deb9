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
