//! The same question, the same answer: by parts, again, beside another instance, and without memory.

use super::super::allocations;
use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::opened::Opened;
use super::material::{deform, set_moving, sound, specimen};
use super::{Verdict, judge, told};
use crate::abi;
use crate::fault::Fault;
use crate::material::Tangent;

const BOTH: Tangent = Tangent { stiffness: 1.0, damping: 0.5 };

/// Every result of a state, as bits, in ranges of at most `most` elements; the energy is a sum and left out.
fn bits(material: &Opened, body: &Body, most: usize) -> Result<Vec<u64>, Fault> {
    let mut force = vec![[0.0; 3]; body.x.len()];
    body.add_forces_in(material, most, &mut force)?;
    let blocks = body.blocks(material, BOTH, most)?;
    let single = body.single_blocks(material, BOTH, most)?;
    let mut parts = vec![[0.0; 6]; body.x.len()];
    if let Some(normals) = normals_of(material, body)? {
        body.add_normals_forces_in(material, most, &normals, &mut parts)?;
    }
    let all = force.iter().flatten().chain(blocks.iter().flatten().flatten()).chain(parts.iter().flatten());
    let all = all.map(|v| v.to_bits());
    Ok(all.chain(single.iter().flatten().flatten().map(|v| u64::from(v.to_bits()))).collect())
}

/// Normals of the body, if the material wants them.
fn normals_of(material: &Opened, body: &Body) -> Result<Option<Vec<[f64; 3]>>, Fault> {
    if !body.has(abi::WANTS_NORMALS) {
        return Ok(None);
    }
    let (_, triangles) = body.tilts(material)?;
    Ok(Some(body.normals(&triangles)))
}

fn moving(c: &Candidate) -> Result<(Opened, Body), String> {
    let (material, mut body) = sound(c)?;
    deform(&mut body, 1.05, 0.05);
    set_moving(&mut body);
    Ok((material, body))
}

pub(super) fn ranges(c: &Candidate) -> Result<Verdict, String> {
    let (material, body) = moving(c)?;
    let whole = bits(&material, &body, usize::MAX).map_err(told)?;
    for most in [1, 3, 7, 16, 29] {
        let parts = bits(&material, &body, most).map_err(told)?;
        judge(parts == whole, || format!("calls over {most} elements at a time came to other bytes"))?;
    }
    Ok(Verdict::Passed)
}

pub(super) fn same_bytes(c: &Candidate) -> Result<Verdict, String> {
    if c.descriptor().flags & abi::FLAG_DETERMINISTIC == 0 {
        return Ok(Verdict::Skipped("it does not declare itself deterministic".into()));
    }
    let (material, body) = moving(c)?;
    let first = bits(&material, &body, usize::MAX).map_err(told)?;
    let mut other = body.clone();
    deform(&mut other, 0.9, 0.2);
    for _ in 0..3 {
        let between = bits(&material, &other, usize::MAX).map_err(told)?;
        judge(between != first, || "two states gave the same bytes".into())?;
        let again = bits(&material, &body, usize::MAX).map_err(told)?;
        judge(again == first, || "the same state gave other bytes after another one was looked at".into())?;
    }
    Ok(Verdict::Passed)
}

pub(super) fn instances(c: &Candidate) -> Result<Verdict, String> {
    let (material, body) = moving(c)?;
    let first = bits(&material, &body, usize::MAX).map_err(told)?;
    for (place, p) in c.params().iter().enumerate().filter(|(_, p)| p.kind == abi::PARAM_NUMBER) {
        let value = if p.fallback == p.max { p.min } else { 0.5 * (p.fallback + p.max) };
        let Ok(other) = c.open(&[(place, value)]) else { continue };
        if let Ok(mut theirs) = specimen(&other) {
            theirs.x.clone_from(&body.x);
            let _ = bits(&other, &theirs, usize::MAX);
        }
        let again = bits(&material, &body, usize::MAX).map_err(told)?;
        judge(again == first, || format!("another instance with `{}` = {value} changed it", Candidate::key(p)))?;
    }
    Ok(Verdict::Passed)
}

pub(super) fn allocates(c: &Candidate) -> Result<Verdict, String> {
    if allocations().is_none() {
        let why = "no counting allocator sees it; `kit::CountingAllocator` in a test that links the plugin does";
        return Ok(Verdict::Skipped(why.into()));
    }
    let (material, body) = moving(c)?;
    let mut force = vec![[0.0; 3]; body.x.len()];
    let mut calls = || -> Result<[u64; 2], Fault> {
        let now = || allocations().unwrap_or(0);
        let start = now();
        body.add_forces(&material, &mut force)?;
        let forces = now();
        body.energy(&material)?;
        let energy = now();
        Ok([forces - start, energy - forces])
    };
    calls().map_err(told)?; // a first call may still find its way
    let [forces, energy] = calls().map_err(told)?;
    // The counter's own question takes one.
    judge(forces <= 1, || format!("`forces` took memory {} times", forces - 1))?;
    judge(energy <= 1, || format!("`energy` took memory {} times", energy - 1))?;
    if let Some(normals) = normals_of(&material, &body).map_err(told)? {
        let mut parts = vec![[0.0; 6]; body.x.len()];
        let before = allocations().unwrap_or(0);
        body.add_normals_forces_in(&material, usize::MAX, &normals, &mut parts).map_err(told)?;
        body.normals_energy(&material, &normals).map_err(told)?;
        let taken = allocations().unwrap_or(0) - before;
        judge(taken <= 1, || format!("an energy of normals took memory {} times", taken - 1))?;
    }
    // Blocks go into buffers made for them: what one call takes more than many small ones is not the plugin's, what many
    // small ones take more than one is.
    let (one, many) = (taken(|| body.blocks(&material, BOTH, usize::MAX))?, taken(|| body.blocks(&material, BOTH, 1))?);
    judge(many <= one, || format!("`tangent` took memory {} times", many - one))?;
    let single = |most: usize| taken(|| body.single_blocks(&material, BOTH, most));
    let (one, many) = (single(usize::MAX)?, single(1)?);
    judge(many <= one, || format!("`single_tangent` took memory {} times", many - one))?;
    Ok(Verdict::Passed)
}

fn taken<T>(run: impl Fn() -> Result<T, Fault>) -> Result<u64, String> {
    let before = allocations().unwrap_or(0);
    run().map_err(told)?;
    Ok(allocations().unwrap_or(0) - before)
}
