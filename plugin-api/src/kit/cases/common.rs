//! Cases for plugins of every kind.

use super::super::candidate::{Candidate, Kind};
use super::super::instance::TestInstance;
use super::{Case, CaseResult, UNCOUNTED, describe_fault, ensure, skipped};
use crate::abi;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "descriptor-is-stable",
        promise: "every call gives the same descriptor; id, keys and ranges are valid",
        run: descriptor_is_stable,
    },
    Case {
        name: "unknown-id-is-refused",
        promise: "`create` with an unknown id gives no instance",
        run: unknown_id_is_refused,
    },
    Case {
        name: "unknown-extension-is-not-offered",
        promise: "`extension` with an unknown id gives null",
        run: unknown_extension_is_not_offered,
    },
    Case {
        name: "out-of-range-is-refused",
        promise: "a parameter takes no value outside its declared range",
        run: out_of_range_is_refused,
    },
    Case {
        name: "opens-with-defaults",
        promise: "the plugin can be activated with the defaults it declares",
        run: opens_with_defaults,
    },
    Case { name: "opens-many-times", promise: "instances can be made and destroyed repeatedly", run: opens_many_times },
    Case {
        name: "memory-is-given-back",
        promise: "an instance that is destroyed has given back what it allocated",
        run: memory_is_given_back,
    },
];

/// Lower-case letters, digits and dashes.
fn is_kebab_case(text: &str) -> bool {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    !text.is_empty() && text.chars().all(allowed)
}

fn descriptor_is_stable(c: &Candidate) -> CaseResult {
    let (first, second) = (c.descriptor(), c.descriptor());
    let same = first.kind == second.kind
        && first.flags == second.flags
        && first.id == second.id
        && first.params == second.params
        && first.param_count == second.param_count;
    ensure(same, || "two calls gave different descriptors".into())?;
    let id = c.id().to_str().map_err(|_| "the id is not UTF-8".to_owned())?;
    ensure(id.split('.').all(is_kebab_case), || {
        format!("id `{id}`; allowed is kebab-case, with a reversed domain before it")
    })?;
    let params = c.params();
    for (i, p) in params.iter().enumerate() {
        let key = Candidate::key(p);
        ensure(is_kebab_case(key), || format!("key `{key}`; allowed is kebab-case"))?;
        ensure(!params[..i].iter().any(|q| Candidate::key(q) == key), || format!("two parameters are called `{key}`"))?;
        if p.kind == abi::PARAM_NUMBER {
            let valid = p.min <= p.fallback && p.fallback <= p.max && p.min.is_finite() && p.max.is_finite();
            ensure(valid, || {
                format!("parameter `{key}`: the default {} lies outside {} to {}", p.fallback, p.min, p.max)
            })?;
        }
    }
    Ok(())
}

fn unknown_id_is_refused(c: &Candidate) -> CaseResult {
    let unknown = c"org.nobody.no-such-plugin";
    ensure(TestInstance::with_id(c, unknown).is_err(), || format!("`create` made an instance of {unknown:?}"))?;
    Ok(())
}

fn unknown_extension_is_not_offered(c: &Candidate) -> CaseResult {
    let instance = TestInstance::new(c).map_err(describe_fault)?;
    let unknown = c"org.nobody.no-such-extension/1";
    let table = instance.extension::<usize>(unknown).map_err(describe_fault)?;
    ensure(table.is_none(), || format!("`extension` gave a table for {unknown:?}"))?;
    Ok(())
}

fn out_of_range_is_refused(c: &Candidate) -> CaseResult {
    let params = c.params();
    let mut instance = TestInstance::new(c).map_err(describe_fault)?;
    let past_the_end = instance.set(params.len() as u32, 0.0);
    ensure(past_the_end.is_err(), || format!("it has {} parameters and took number {0}", params.len()))?;
    for (index, p) in params.iter().enumerate() {
        let width = (p.max - p.min).abs().max(1.0);
        let refused = match p.kind {
            abi::PARAM_NUMBER => vec![p.max + width, p.min - width, f64::NAN, f64::INFINITY],
            abi::PARAM_CHOICE => vec![Candidate::choices(p).len() as f64, -1.0, 0.5, f64::NAN],
            _ => vec![0.0],
        };
        for value in refused {
            let key = Candidate::key(p);
            ensure(instance.set(index as u32, value).is_err(), || format!("parameter `{key}` took {value}"))?;
        }
    }
    Ok(())
}

/// Whether the plugin declares a text, path or table, which the suite cannot provide.
pub(super) fn needs_more_than_numbers(c: &Candidate) -> bool {
    c.params().iter().any(|p| [abi::PARAM_TEXT, abi::PARAM_PATH, abi::PARAM_TABLE].contains(&p.kind))
}

/// Result for a plugin that cannot be opened with its defaults because it needs a text, path or table.
fn skipped_without_input(fault: crate::Fault) -> CaseResult {
    Err(skipped(format!("its defaults are not enough: {}", describe_fault(fault))))
}

fn opens_with_defaults(c: &Candidate) -> CaseResult {
    match c.open(&[]) {
        Ok(_) => Ok(()),
        Err(fault) if needs_more_than_numbers(c) => skipped_without_input(fault),
        Err(fault) => Err(describe_fault(fault).into()),
    }
}

fn opens_many_times(c: &Candidate) -> CaseResult {
    if let (Err(fault), true) = (c.open(&[]).map(drop), needs_more_than_numbers(c)) {
        return skipped_without_input(fault);
    }
    // Hardware is slow to open and may exist once, so a device may refuse a second instance at the same time.
    let is_device = c.kind() == Some(Kind::Device);
    let rounds = if is_device { 5 } else { 50 };
    for round in 0..rounds {
        let (first, second) = (c.open(&[]), c.open(&[]));
        ensure(first.is_ok(), || format!("round {round} of {rounds}: no instance"))?;
        ensure(is_device || second.is_ok(), || format!("round {round} of {rounds}: no second instance"))?;
    }
    Ok(())
}

fn memory_is_given_back(c: &Candidate) -> CaseResult {
    /// Instances that are made before memory is counted: the first ones may make what all share.
    const FIRST: usize = 3;
    /// Instances whose memory is counted.
    const COUNTED: i64 = 4;
    let live = c.live_count().ok_or_else(|| skipped(UNCOUNTED))?;
    for _ in 0..FIRST {
        if let Err(fault) = c.open(&[]) {
            return Err(skipped(describe_fault(fault)));
        }
    }
    let before = live();
    (0..COUNTED).for_each(|_| drop(c.open(&[])));
    let kept = live() - before;
    // A list that all instances share may grow now and then, and not with each.
    Ok(ensure(kept < COUNTED, || {
        format!("{COUNTED} instances that were made and destroyed left {kept} allocations behind")
    })?)
}
