//! What every plugin promises.

use super::super::candidate::{Candidate, Kind};
use super::super::opened::Opened;
use super::{Case, Verdict, judge, told};
use crate::abi;
use core::ffi::CStr;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "descriptor-is-stable",
        promise: "the descriptor is the same whenever it is asked for, and its words make sense",
        run: descriptor,
    },
    Case { name: "unknown-id-is-refused", promise: "an id that is not its own makes no instance", run: unknown_id },
    Case {
        name: "unknown-extension-is-not-offered",
        promise: "an extension it does not know is null",
        run: unknown_extension,
    },
    Case {
        name: "out-of-range-is-refused",
        promise: "a parameter takes no value outside of its declared range",
        run: out_of_range,
    },
    Case { name: "opens-with-defaults", promise: "it can be activated with what it declares", run: defaults },
    Case { name: "opens-many-times", promise: "instances can be made and destroyed again and again", run: many },
];

fn is_kebab(text: &str) -> bool {
    let part = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    !text.is_empty() && text.chars().all(part)
}

fn descriptor(c: &Candidate) -> Result<Verdict, String> {
    let (first, second) = (c.descriptor(), c.descriptor());
    let same = first.kind == second.kind
        && first.flags == second.flags
        && first.id == second.id
        && first.params == second.params
        && first.param_count == second.param_count;
    judge(same, || "two looks at it differ".into())?;
    let id = c.id().to_str().map_err(|_| "its id is not UTF-8")?;
    judge(id.split('.').all(is_kebab), || {
        format!("id `{id}`; allowed is kebab-case, with a reversed domain before it")
    })?;
    let params = c.params();
    for (i, p) in params.iter().enumerate() {
        let key = Candidate::key(p);
        judge(is_kebab(key), || format!("key `{key}`; allowed is kebab-case"))?;
        judge(!params[..i].iter().any(|q| Candidate::key(q) == key), || format!("parameter `{key}` is there twice"))?;
        if p.kind == abi::PARAM_NUMBER {
            let sound = p.min <= p.fallback && p.fallback <= p.max && p.min.is_finite() && p.max.is_finite();
            judge(sound, || format!("parameter `{key}`: default {} in {} to {}", p.fallback, p.min, p.max))?;
        }
    }
    Ok(Verdict::Passed)
}

fn unknown_id(c: &Candidate) -> Result<Verdict, String> {
    let other: &CStr = c"org.nobody.no-such-plugin";
    judge(Opened::named(c, other).is_err(), || format!("it made an instance of {other:?}"))?;
    Ok(Verdict::Passed)
}

fn unknown_extension(c: &Candidate) -> Result<Verdict, String> {
    let opened = Opened::new(c).map_err(told)?;
    let found = opened.extension::<usize>(c"org.nobody.no-such-extension/1").map_err(told)?;
    judge(found.is_none(), || "it offered an extension nobody has defined".into())?;
    Ok(Verdict::Passed)
}

fn out_of_range(c: &Candidate) -> Result<Verdict, String> {
    let params = c.params();
    let mut opened = Opened::new(c).map_err(told)?;
    let beyond = opened.set(params.len() as u32, 0.0);
    judge(beyond.is_err(), || format!("it took parameter {}, of {}", params.len(), params.len()))?;
    for (place, p) in params.iter().enumerate() {
        let wide = (p.max - p.min).abs().max(1.0);
        let values = match p.kind {
            abi::PARAM_NUMBER => vec![p.max + wide, p.min - wide, f64::NAN, f64::INFINITY],
            abi::PARAM_CHOICE => vec![Candidate::choices(p).len() as f64, -1.0, 0.5, f64::NAN],
            _ => vec![0.0],
        };
        for value in values {
            let key = Candidate::key(p);
            judge(opened.set(place as u32, value).is_err(), || format!("parameter `{key}` took {value}"))?;
        }
    }
    Ok(Verdict::Passed)
}

/// Whether it needs something of the scene that nobody here has: a file, a text, a table, a device.
pub(super) fn needs_more(c: &Candidate) -> bool {
    c.params().iter().any(|p| [abi::PARAM_TEXT, abi::PARAM_PATH, abi::PARAM_TABLE].contains(&p.kind))
}

fn defaults(c: &Candidate) -> Result<Verdict, String> {
    match c.open(&[]) {
        Ok(_) => Ok(Verdict::Passed),
        Err(fault) if needs_more(c) => Ok(Verdict::Skipped(format!("it wants more than numbers: {}", told(fault)))),
        Err(fault) => Err(told(fault)),
    }
}

fn many(c: &Candidate) -> Result<Verdict, String> {
    if let (Err(fault), true) = (c.open(&[]).map(drop), needs_more(c)) {
        return Ok(Verdict::Skipped(format!("it wants more than numbers: {}", told(fault))));
    }
    // Hardware takes its time to open, and may be there once: a second instance is then refused, and harms nobody.
    let device = c.kind() == Some(Kind::Device);
    let rounds = if device { 5 } else { 50 };
    for round in 0..rounds {
        let two = (c.open(&[]), c.open(&[]));
        judge(two.0.is_ok(), || format!("round {round} of {rounds} made no instance"))?;
        judge(device || two.1.is_ok(), || format!("round {round} of {rounds} made no second instance"))?;
    }
    Ok(Verdict::Passed)
}
