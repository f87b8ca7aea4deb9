//! Calls of a model that wants whole lists: all elements in each, one at a time.

use super::*;
use crate::System;
use crate::system_scales::{HessianApproximation, SystemScales};
use pliant_plugin_api::{PlanesMut, TangentScale};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Number of links: enough for several chunks and threads.
const LINKS: usize = 40_000;

/// What was called.
#[derive(Default)]
struct Log {
    calls: Mutex<Vec<&'static str>>,
    /// Calls that have not returned.
    running: AtomicUsize,
    /// Whether a call had a part of the list, or ran at the same time as another.
    has_part: AtomicBool,
    is_shared: AtomicBool,
}

/// Links with a history, of which every call is logged.
struct Logged {
    requests: [ElementRequest; 1],
    wants_whole_lists: bool,
    log: Arc<Log>,
}

impl Logged {
    fn note(&self, name: &'static str, call: &ElementCall<'_>) -> Result<(), ForceError> {
        let Log { calls, running, has_part, is_shared } = &*self.log;
        is_shared.fetch_or(running.fetch_add(1, Ordering::SeqCst) > 0, Ordering::SeqCst);
        has_part.fetch_or(call.range != (0..LINKS), Ordering::SeqCst);
        calls.lock().unwrap_or_else(PoisonError::into_inner).push(name);
        std::thread::sleep(std::time::Duration::from_millis(2));
        running.fetch_sub(1, Ordering::SeqCst);
        Ok(())
    }
}

impl ForceModel for Logged {
    fn name(&self) -> &str {
        "logged"
    }

    fn wants_whole_lists(&self) -> bool {
        self.wants_whole_lists
    }

    fn requests(&self) -> &[ElementRequest] {
        &self.requests
    }

    fn rest(&self, call: &ElementCall<'_>, _: &mut [f64]) -> Result<(), ForceError> {
        self.note("rest", call)
    }

    fn mass(&self, call: &ElementCall<'_>, _: &mut [f64]) -> Result<(), ForceError> {
        self.note("mass", call)
    }

    fn energy(&self, call: &ElementCall<'_>) -> Result<f64, ForceError> {
        self.note("energy", call).map(|()| 0.0)
    }

    fn forces(&self, call: &ElementCall<'_>, _: &mut [[f64; 3]]) -> Result<(), ForceError> {
        self.note("forces", call)
    }

    fn tangent(
        &self,
        call: &ElementCall<'_>,
        _: TangentScale,
        _: &[u32],
        _: usize,
        _: &mut [[f64; 9]],
    ) -> Result<(), ForceError> {
        self.note("tangent", call)
    }

    fn advance(&self, call: &ElementCall<'_>, _: &mut PlanesMut<'_>) -> Result<(), ForceError> {
        self.note("advance", call)
    }
}

/// The calls that a body of links makes for its rest data and in one round of every function of a step, on three threads.
fn calls_of(wants_whole_lists: bool) -> Arc<Log> {
    let log = Arc::new(Log::default());
    let flags = abi::HAS_MASS | abi::HAS_FORCES | abi::HAS_HISTORY;
    let requests = [ElementRequest { kind: abi::LINK, families: 0, flags, rest_stride: 1, history_stride: 1 }];
    let mut system = System::new(Box::new(Logged { requests, wants_whole_lists, log: Arc::clone(&log) }));
    system.nodes = Nodes::at_rest(vec![Vec3::zeros(); LINKS + 1]);
    system.sets[0].list_mut().nodes = (0..LINKS as u32).flat_map(|e| [e, e + 1]).collect();
    system.prepare().expect("sound");
    system.enable_matrix();
    let (pool, time) = (Pool::new(3), StepTime { start: 0.0, dt: 1e-3 });
    system.forces(&pool, None, time, &mut vec![Vec3::zeros(); LINKS + 1]).expect("sound");
    system.energy(time).expect("sound");
    let mut matrix = system.matrix.take().expect("enabled");
    let (state, coupled) = system.assembly_parts(time);
    let scales = SystemScales {
        mass: 1.0,
        stiffness: 1.0,
        damping: 1.0,
        hessian: HessianApproximation::UpperBound,
        strains_are_current: false,
        allow_f32: false,
    };
    matrix.assemble(&pool, state, coupled, scales).expect("sound");
    system.advance(&pool, time).expect("sound");
    log
}

#[test]
fn each_function_is_called_once_for_the_whole_list() {
    let log = calls_of(true);
    assert!(!log.has_part.load(Ordering::SeqCst) && !log.is_shared.load(Ordering::SeqCst));
    let calls = log.calls.lock().unwrap_or_else(PoisonError::into_inner);
    assert_eq!(calls[..], ["rest", "mass", "forces", "energy", "tangent", "advance"]);
}

#[test]
fn other_models_are_called_for_parts() {
    let log = calls_of(false);
    assert!(log.has_part.load(Ordering::SeqCst));
    let calls = log.calls.lock().unwrap_or_else(PoisonError::into_inner);
    for name in ["forces", "tangent", "advance"] {
        assert!(calls.iter().filter(|call| **call == name).count() > 1, "{name}");
    }
}
