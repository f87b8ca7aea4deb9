//! The case for stiffness in single precision.

use super::super::candidate::Candidate;
use super::super::corners;
use super::material::{default_body, deform, set_moving};
use super::matrix::max_abs;
use super::{CaseResult, describe_fault, ensure, skipped};
use crate::abi;
use crate::blocks::pair_index;
use crate::material::TangentScale;

/// Accepted rounding error of an entry in single precision, relative to the largest entry: some hundred roundings of 6e-8.
const ROUNDING: f64 = 2e-5;

pub(super) fn stiffness_matches(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    if !body.has(abi::HAS_SINGLE) {
        return Err(skipped("no element has the flag HAS_SINGLE with its defaults"));
    }
    let without_forces = |flags: u32| flags & abi::HAS_SINGLE != 0 && flags & abi::HAS_FORCES == 0;
    ensure(!body.element_counts().any(|(r, _)| without_forces(r.flags)), || {
        "the flag HAS_SINGLE is set for elements without HAS_FORCES".into()
    })?;
    deform(&mut body, 0.97, 0.08);
    set_moving(&mut body);
    let scale = TangentScale { stiffness: 0.7, damping: 0.3 };
    let double = body.blocks(&material, scale, usize::MAX).map_err(describe_fault)?;
    let single = body.single_blocks(&material, scale, usize::MAX).map_err(describe_fault)?;
    for (((request, count), double), single) in body.element_counts().zip(&double).zip(&single) {
        if request.flags & abi::HAS_SINGLE == 0 {
            continue;
        }
        let (k, largest) = (corners(request.kind), max_abs(double.iter().flatten()));
        let block = |e: usize, a: usize, b: usize| e * (k * (k + 1) / 2) + pair_index(a.min(b), a.max(b), k);
        for (e, a) in (0..count).flat_map(|e| (0..k).map(move |a| (e, a))) {
            let mut row_sum = double[block(e, a, a)];
            ensure(single[block(e, a, a)] == [0.0; 9], || format!("element {e}: block ({a}, {a}) was written"))?;
            for b in (0..k).filter(|b| *b != a) {
                let index = block(e, a, b);
                for i in 0..9 {
                    let entry = if a < b { i } else { 3 * (i % 3) + i / 3 };
                    row_sum[i] += double[index][entry];
                    let (found, expected) = (f64::from(single[index][i]), double[index][i]);
                    ensure((found - expected).abs() <= ROUNDING * largest, || {
                        format!(
                            "element {e}, block ({a}, {b}): {found:.6e} in single precision, {expected:.6e} in double"
                        )
                    })?;
                }
            }
            let rest = max_abs(&row_sum) / largest;
            ensure(rest <= 1e-9, || {
                format!("element {e} resists a translation: the blocks of a row sum to {rest:.3e} of the largest entry")
            })?;
        }
    }
    Ok(())
}
