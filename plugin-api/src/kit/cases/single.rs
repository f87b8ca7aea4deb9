//! Stiffness in single precision beside that in double.

use super::super::candidate::Candidate;
use super::super::corners;
use super::linear::largest;
use super::material::{deform, set_moving, sound};
use super::{Verdict, judge, told};
use crate::abi;
use crate::blocks::pair;
use crate::material::Tangent;

/// Of the largest entry, what rounding may come to along a kernel.
const ROUNDING: f64 = 2e-5;

pub(super) fn stiffness(c: &Candidate) -> Result<Verdict, String> {
    let (material, mut body) = sound(c)?;
    if !body.has(abi::HAS_SINGLE) {
        return Ok(Verdict::Passed);
    }
    let bare = |r: &crate::ElementRequest| r.flags & abi::HAS_SINGLE != 0 && r.flags & abi::HAS_FORCES == 0;
    judge(!body.counts().any(|(r, _)| bare(&r)), || "elements without forces have it".into())?;
    deform(&mut body, 0.97, 0.08);
    set_moving(&mut body);
    let scale = Tangent { stiffness: 0.7, damping: 0.3 };
    let exact = body.blocks(&material, scale, usize::MAX).map_err(told)?;
    let single = body.single_blocks(&material, scale, usize::MAX).map_err(told)?;
    for (((request, count), exact), single) in body.counts().zip(&exact).zip(&single) {
        if request.flags & abi::HAS_SINGLE == 0 {
            continue;
        }
        let (k, most) = (corners(request.kind), largest(exact.iter().flatten()));
        let block = |e: usize, a: usize, b: usize| e * (k * (k + 1) / 2) + pair(a.min(b), a.max(b), k);
        for (e, a) in (0..count).flat_map(|e| (0..k).map(move |a| (e, a))) {
            let mut left = exact[block(e, a, a)];
            judge(single[block(e, a, a)] == [0.0; 9], || format!("element {e}: block ({a}, {a}) was written"))?;
            for b in (0..k).filter(|b| *b != a) {
                let at = block(e, a, b);
                for i in 0..9 {
                    let from = if a < b { i } else { 3 * (i % 3) + i / 3 };
                    left[i] += exact[at][from];
                    let (got, want) = (f64::from(single[at][i]), exact[at][i]);
                    judge((got - want).abs() <= ROUNDING * most, || {
                        format!("element {e}, block ({a}, {b}): {got:.6e} in single precision, {want:.6e} in double")
                    })?;
                }
            }
            judge(largest(&left) <= 1e-9 * most, || {
                let share = largest(&left) / most;
                format!("element {e} resists a motion of all of its corners: {share:.3e} of its largest entry")
            })?;
        }
    }
    Ok(Verdict::Passed)
}
