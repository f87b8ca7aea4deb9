//! The cases for the arrays that a call is given: nothing around them is read or written, inputs stay as they are, and a call writes to what belongs to its own
//! elements alone.

use super::super::body::{Body, Function, GuardChange, INPUTS, OUTPUT, PLANES, StrayWrite, Surroundings};
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::material::{default_body, deform, set_moving};
use super::{CaseResult, describe_fault, ensure, skipped};
use crate::abi;
use std::ops::Range;

/// Numbers around an array of floats: what a material reads there appears in its results.
const NUMBERS: [f64; 2] = [1e3, f64::NAN];
/// Numbers around an array of integers, all of them nodes, families and slots that are there.
const INTEGERS: [f64; 2] = [1.0, 2.0];

/// A body that is deformed and moves, with a history and with fields.
pub(super) fn moving_body(c: &Candidate) -> Result<(TestInstance, Body), String> {
    let (material, mut body) = default_body(c)?;
    let fields = c.params().iter().filter(|p| p.flags & abi::PARAM_FIELD != 0).count();
    body.set_fields(&material, fields, |_, _| 1.25).map_err(describe_fault)?;
    deform(&mut body, 1.05, 0.05);
    set_moving(&mut body);
    body.advance(&material).map_err(describe_fault)?;
    Ok((material, body))
}

/// Sets and functions that a body is called with.
pub(super) fn calls(body: &Body) -> Vec<(usize, Function)> {
    let sets = 0..body.set_counts().len();
    let all = sets.flat_map(|set| Function::ALL.map(|function| (set, function)));
    all.filter(|(set, function)| body.calls(*set, *function)).collect()
}

/// What is called, at the beginning of a sentence.
pub(super) fn call_name(body: &Body, set: usize, function: Function, range: &Range<usize>) -> String {
    let kind = match body.set_kind(set) {
        abi::POINT => "points",
        abi::LINK => "links",
        abi::TRIANGLE => "triangles",
        abi::HINGE => "hinges",
        _ => "tetrahedra",
    };
    format!("`{}` of {kind} {} to {}", function.name(), range.start, range.end - 1)
}

/// Whether a write outside of an output belongs to the planes of a material.
fn is_of_planes(function: Function, array: &str) -> bool {
    PLANES.contains(&array) || array == OUTPUT && matches!(function, Function::Rest | Function::Advance)
}

/// Nothing around `arrays` is read, and nothing in or around them is written. A write around an output counts where `is_judged`.
fn look_around(c: &Candidate, arrays: &[&'static str], is_judged: fn(Function, &str) -> bool) -> CaseResult {
    let (material, body) = moving_body(c)?;
    let counts = body.set_counts();
    for (set, function) in calls(&body) {
        let middle = counts[set] / 3..counts[set].div_ceil(2);
        for range in [0..counts[set], middle].into_iter().filter(|range| !range.is_empty()) {
            let run = |around| body.guarded_call(&material, set, function, range.clone(), around);
            let name = || call_name(&body, set, function, &range);
            let plain = run(Surroundings::Guards);
            if let Some(StrayWrite { array, is_outside, place }) = &plain.stray_write
                && is_judged(function, array)
                && (*is_outside || *array != OUTPUT)
            {
                return Err(format!("{} wrote to `{array}`: the value {place} was changed", name()).into());
            }
            if run(Surroundings::Guards).bits != plain.bits {
                return Err(skipped("results differ from call to call: see `results-are-deterministic`"));
            }
            for &array in arrays {
                let offsets = body.guard_offsets(set, array);
                let is_integer = ["elements", "family", "slots"].contains(&array);
                for number in if is_integer { INTEGERS } else { NUMBERS } {
                    let changed = |offset| Surroundings::Changed(GuardChange { array, number, offset });
                    let reads = |offset| run(changed(offset)).bits != plain.bits;
                    if offsets.is_empty() || !reads(None) {
                        continue;
                    }
                    let at = offsets.iter().find(|offset| reads(Some(**offset)));
                    let place = at.map_or("around it".into(), |at| body.describe_guard(set, array, *at));
                    return Err(format!(
                        "{} reads outside of `{array}`: {number} as the value {place} changes its results",
                        name()
                    )
                    .into());
                }
            }
        }
    }
    Ok(())
}

/// Nothing around rest data, history and fields is read or written, and they stay as they are.
pub(super) fn planes_are_kept_to(c: &Candidate) -> CaseResult {
    let (material, mut body) = moving_body(c)?;
    let before = body.input_bits();
    body.write_rest_data(&material).map_err(describe_fault)?;
    ensure(body.input_bits() == before, || {
        "`rest` called again with the same shape changed its rest data, or wrote outside of its planes".into()
    })?;
    look_around(c, &PLANES, is_of_planes)
}

/// Nothing around the other arrays is read or written, and what is not an output stays as it is.
pub(super) fn arrays_are_kept_to(c: &Candidate) -> CaseResult {
    look_around(c, &INPUTS, |function, array| !is_of_planes(function, array))
}

/// A call for one element writes to its nodes, blocks and values alone.
pub(super) fn writes_stay_at_own_elements(c: &Candidate) -> CaseResult {
    let (material, body) = moving_body(c)?;
    let counts = body.set_counts();
    for (set, function) in calls(&body) {
        for range in (0..counts[set]).map(|e| e..e + 1) {
            let done = body.guarded_call(&material, set, function, range.clone(), Surroundings::Guards);
            if let Some(StrayWrite { array: OUTPUT, is_outside: false, place }) = &done.stray_write {
                let name = call_name(&body, set, function, &range);
                return Err(
                    format!("{name} wrote to value {place} of its output, which belongs to other elements").into()
                );
            }
        }
    }
    Ok(())
}

#[cfg(test)]
#[allow(unsafe_code, reason = "a material that goes where it may not, as one in C can")]
mod tests {
    use super::super::super::protected_memory::ProtectedMemory;
    use super::super::NotPassed;
    use super::super::pages::are_left_alone;
    use super::*;
    use crate::{
        AsMaterial, Blocks, ElementRequest, Elements, Info, Material, NodeScalars, NodeVectors, Params, Planes,
        TangentScale,
    };
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Plane before or behind the one plane of rest data of [`Stray`] that it reads, and whether it writes to that one.
    trait Fault: Send + Sync + 'static {
        const READS: Option<isize>;
        const WRITES: bool;
    }

    /// A material of links that pull with the number in their rest data, and with what lies around it where it is faulty.
    struct Stray<F>(core::marker::PhantomData<F>);

    impl<F: Fault> Material for Stray<F> {
        const INFO: Info = Info { id: c"stray", name: c"", version: c"0.1.0", summary: c"", params: &[] };

        fn new(_: &Params<'_>) -> Result<Self, crate::Fault> {
            Ok(Self(core::marker::PhantomData))
        }

        fn elements(&self) -> Vec<ElementRequest> {
            let (kind, families, flags) = (abi::LINK, abi::STRUCTURAL, abi::HAS_FORCES);
            vec![ElementRequest { kind, families, flags, rest_stride: 1, history_stride: 0 }]
        }

        fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), crate::Fault> {
            let [pull] = out.first_planes();
            (0..elements.len()).for_each(|e| pull[e] = 1.0);
            Ok(())
        }

        fn mass(&self, _: &Elements<'_>, _: &mut NodeScalars<'_>) -> Result<(), crate::Fault> {
            Ok(())
        }

        fn energy(&self, _: &Elements<'_>) -> Result<f64, crate::Fault> {
            Ok(0.0)
        }

        fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), crate::Fault> {
            let own = elements.rest_data(0);
            // SAFETY: the planes of a test body lie between guard planes of as many elements, in one allocation.
            let stray = F::READS.map_or(0.0, |plane| unsafe { *own.as_ptr().offset(plane * own.len() as isize) });
            for (ends, pull) in elements.corners::<2>().iter().zip(own) {
                out.add(ends[0], [pull + stray, 0.0, 0.0]);
            }
            if F::WRITES {
                // SAFETY: the test body has no other user of the plane.
                unsafe { own.as_ptr().cast_mut().write(2.0) };
            }
            Ok(())
        }

        fn tangent(&self, _: &Elements<'_>, _: TangentScale, _: &mut Blocks<'_>) -> Result<(), crate::Fault> {
            Ok(())
        }
    }

    macro_rules! faults {
        ($($name:ident: $reads:expr, $writes:expr;)*) => {
            $(struct $name; impl Fault for $name { const READS: Option<isize> = $reads; const WRITES: bool = $writes; })*
        };
    }
    faults! {
        Sound: None, false;
        ReadsBefore: Some(-1), false;
        ReadsBehind: Some(1), false;
        Writes: None, true;
    }

    /// What the case says of a fault; empty where it passes.
    fn said<F: Fault>() -> String {
        match planes_are_kept_to(&Candidate::of::<AsMaterial<Stray<F>>>()) {
            Ok(()) => String::new(),
            Err(NotPassed::Failed(why) | NotPassed::Skipped(why)) => why,
        }
    }

    /// Memory with room for any array of a test body.
    #[repr(align(64))]
    struct Page([u8; 1 << 14]);

    #[test]
    fn the_tables_of_a_material_are_called_with_arrays_of_their_own() {
        let (material, body) = moving_body(&Candidate::of::<AsMaterial<Stray<Sound>>>()).expect("sound");
        for (set, function) in calls(&body) {
            let done = body.guarded_call(&material, set, function, 3..9, Surroundings::Guards);
            assert!(done.bits.is_ok() && done.stray_write.is_none(), "{function:?}");
        }
    }

    #[test]
    #[cfg_attr(miri, ignore = "takes minutes for thousands of calls like those above")]
    fn a_sound_material_keeps_to_arrays_between_guards_and_at_pages() {
        static CALLS: AtomicUsize = AtomicUsize::new(0);
        let memory = &mut Box::leak(Box::new(Page([0; 1 << 14]))).0;
        let memory = ProtectedMemory::new(memory, |_| _ = CALLS.fetch_add(1, Ordering::Relaxed));
        let candidate = Candidate::of::<AsMaterial<Stray<Sound>>>().with_protected_memory(memory);
        for case in [planes_are_kept_to, arrays_are_kept_to, writes_stay_at_own_elements, are_left_alone] {
            assert!(case(&candidate).is_ok());
        }
        // rest, energy, forces and tangent, of all links and of some, with 14 arrays, at both ends.
        assert_eq!(CALLS.load(Ordering::Relaxed), 4 * 2 * 14 * 2);
    }

    #[test]
    #[cfg_attr(miri, ignore = "reads around a slice on purpose")]
    fn reads_around_the_planes_and_writes_to_them_are_found() {
        assert_eq!(said::<Sound>(), "");
        let told = said::<ReadsBefore>();
        assert!(told.contains("`forces` of links 0 to ") && told.contains("outside of `rest_data`"), "{told}");
        assert!(told.contains(" before its first changes its results"), "{told}");
        let told = said::<ReadsBehind>();
        assert!(told.contains("outside of `rest_data`") && told.contains("1 behind its last"), "{told}");
        let told = said::<Writes>();
        assert!(
            told.contains("`forces` of links 0 to ") && told.contains("wrote to `rest_data`: the value number 0"),
            "{told}"
        );
    }
}
