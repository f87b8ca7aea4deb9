//! The case for planes of doubles that a call is given: nothing around them is read, and nothing in them or around them is written.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::material::{default_body, deform, set_moving};
use super::repeatability::result_bits;
use super::{CaseResult, describe_fault, ensure, skipped};
use crate::abi;
use crate::fault::Fault;

/// Values of the planes around rest data and history: what a material reads there appears in its results.
const GUARDS: [f64; 3] = [0.0, 1e3, f64::NAN];

/// What a call did that changed its input.
const CHANGED: &str =
    "a call changed positions, velocities, measures, rest data, history or fields, or what lies around them";

/// Bits of everything a material computes.
fn all_bits(material: &TestInstance, body: &Body) -> Result<Vec<u64>, Fault> {
    let mut bits = result_bits(material, body, usize::MAX)?;
    bits.extend(body.mass(material)?.iter().map(|m| m.to_bits()));
    bits.push(body.energy(material)?.to_bits());
    if body.has(abi::IS_COUPLED) {
        let (strains, compliances) = (body.strains(material)?, body.compliances(material)?);
        bits.extend(strains.values.iter().chain(&compliances.values).map(|v| v.to_bits()));
    }
    Ok(bits)
}

/// Results do not depend on what lies around rest data and history; calls leave their input as it is, and write to their own planes alone.
pub(super) fn planes_are_kept_to(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    deform(&mut body, 1.05, 0.05);
    set_moving(&mut body);
    body.advance(&material).map_err(describe_fault)?;
    let before = body.input_bits();
    let expected = all_bits(&material, &body).map_err(describe_fault)?;
    ensure(body.input_bits() == before, || CHANGED.into())?;
    if all_bits(&material, &body).map_err(describe_fault)? != expected {
        return Err(skipped("results differ from call to call: see `results-are-deterministic`"));
    }
    for guard in GUARDS {
        body.set_guards(guard);
        let before = body.input_bits();
        body.write_rest_data(&material).map_err(describe_fault)?;
        ensure(body.input_bits() == before, || {
            "`rest` called again with the same shape changed its rest data, or wrote outside of its planes".into()
        })?;
        let found = all_bits(&material, &body).map_err(describe_fault)?;
        ensure(body.input_bits() == before, || CHANGED.into())?;
        ensure(found == expected, || {
            format!(
                "results depend on what lies around the planes of rest data and history: {guard} there changes them"
            )
        })?;
        let guards_kept = body.advance_keeps_guards(&material).map_err(describe_fault)?;
        ensure(guards_kept, || "`advance` wrote outside of the planes of the history".into())?;
    }
    Ok(())
}

#[cfg(test)]
#[allow(unsafe_code, reason = "a material that goes where it may not, as one in C can")]
mod tests {
    use super::super::NotPassed;
    use super::*;
    use crate::{
        AsMaterial, Blocks, ElementRequest, Elements, Info, Material, NodeScalars, NodeVectors, Params, Planes,
        TangentScale,
    };

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

    #[test]
    #[cfg_attr(miri, ignore = "reads around a slice on purpose")]
    fn reads_around_the_planes_and_writes_to_them_are_found() {
        assert_eq!(said::<Sound>(), "");
        assert!(said::<ReadsBefore>().contains("depend on what lies around"), "{}", said::<ReadsBefore>());
        assert!(said::<ReadsBehind>().contains("depend on what lies around"), "{}", said::<ReadsBehind>());
        assert!(said::<Writes>().contains("a call changed"), "{}", said::<Writes>());
    }
}
