//! The case for materials that want whole lists: no list is too long for them, and nothing of a longer one is left in a shorter.

use super::super::candidate::Candidate;
use super::material::{body_of_size, deform, set_moving};
use super::repeatability::result_bits;
use super::{CaseResult, describe_fault, ensure, skipped};
use crate::abi;

/// Cells and squares along each side of the bodies, one after the other: 40 and 20,480 tetrahedra, 18 and 18,432 triangles.
const SIDES: [[u32; 2]; 3] = [[2, 3], [16, 96], [2, 3]];
/// Most elements of the short calls.
const SHORT: usize = 100;

pub(super) fn are_taken(c: &Candidate) -> CaseResult {
    if c.descriptor().flags & abi::FLAG_WHOLE_LISTS == 0 {
        return Err(skipped("it does not want whole lists"));
    }
    let material = c.open(&[]).map_err(describe_fault)?;
    for [cells, squares] in SIDES {
        let mut body = body_of_size(&material, cells, squares)?;
        deform(&mut body, 1.05, 0.05);
        set_moving(&mut body);
        let whole = result_bits(&material, &body, usize::MAX).map_err(describe_fault)?;
        let parts = result_bits(&material, &body, SHORT).map_err(describe_fault)?;
        let count = body.element_counts().map(|(_, count)| count).max().unwrap_or(0);
        ensure(whole == parts, || format!("a call of {count} elements gives other bytes than calls of {SHORT}"))?;
    }
    Ok(())
}
