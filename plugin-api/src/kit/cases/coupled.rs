//! Hinges that act on each other: their strains, and the compliance between them.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::opened::Opened;
use super::invariance::turn;
use super::linear::{is_definite, largest};
use super::material::{deform, sound};
use super::{Verdict, judge, told};
use crate::abi;

/// m
const STEP: f64 = 1e-6;

/// A body with coupled hinges, if the material asks for them with its defaults.
fn coupled(c: &Candidate) -> Result<Option<(Opened, Body)>, String> {
    let (material, body) = sound(c)?;
    let flags = |kind: u32| body.counts().find(|(r, _)| r.kind == kind).map_or(0, |(r, _)| r.flags & abi::IS_COUPLED);
    let (hinges, triangles) = (flags(abi::HINGE), flags(abi::TRIANGLE));
    judge(hinges == triangles, || "hinges and triangles are coupled together, or neither is".into())?;
    Ok((hinges != 0).then_some((material, body)))
}

pub(super) fn coupled_slope(c: &Candidate) -> Result<Verdict, String> {
    let Some((material, mut body)) = coupled(c)? else { return Ok(Verdict::Passed) };
    let (at_rest, hinges) = body.strains(&material).map_err(told)?;
    let m = hinges.len();
    deform(&mut body, 1.02, 0.2);
    let (found, _) = body.strains(&material).map_err(told)?;
    judge(found.iter().all(|s| s.is_finite()), || "a strain or gradient is not finite or was not written".into())?;
    let most = 1e-9 * largest(&found[..m]);
    judge(most > 0.0, || "no strain in a deformed state".into())?;
    judge(largest(&at_rest[..m]) <= most, || format!("a strain of {:.3e} m at rest", largest(&at_rest[..m])))?;
    let (scale, mut same) = (largest(&found[m..]), true);
    for node in 0..body.x.len() {
        for axis in 0..3 {
            let at = |step: f64| -> Result<Vec<f64>, String> {
                let mut moved = body.clone();
                moved.x[node][axis] += step;
                moved.strains(&material).map_err(told).map(|(s, _)| s)
            };
            let (plus, minus) = (at(STEP)?, at(-STEP)?);
            for (e, corners) in hinges.iter().enumerate() {
                let own = corners.iter().position(|n| *n as usize == node);
                let given = own.map_or(0.0, |corner| found[(1 + 3 * corner + axis) * m + e]);
                let slope = (plus[e] - minus[e]) / (2.0 * STEP);
                same &= given == slope;
                judge((given - slope).abs() <= 1e-5 * scale, || {
                    format!("hinge {e}, node {node}, axis {axis}: gradient {given:.6e}, slope {slope:.6e}")
                })?;
            }
        }
    }
    judge(!same, || "gradient and slope are the same to the last bit: a thing is compared with itself".into())?;
    Ok(Verdict::Passed)
}

pub(super) fn coupled_turns(c: &Candidate) -> Result<Verdict, String> {
    let Some((material, mut body)) = coupled(c)? else { return Ok(Verdict::Passed) };
    deform(&mut body, 1.02, 0.2);
    let mut moved = body.clone();
    moved.x.iter_mut().for_each(|x| *x = turn([x[0] + 0.3, x[1] - 0.2, x[2] + 0.1]));
    let ((before, hinges), (after, _)) =
        (body.strains(&material).map_err(told)?, moved.strains(&material).map_err(told)?);
    let m = hinges.len();
    let (strain, slope) = (largest(&before[..m]), largest(&before[m..]));
    for e in 0..m {
        let off = (before[e] - after[e]).abs();
        judge(off <= 1e-9 * strain, || format!("the strain of hinge {e} changed by {off:.3e} m"))?;
        for corner in 0..4 {
            let of = |planes: &[f64]| [0, 1, 2].map(|axis| planes[(1 + 3 * corner + axis) * m + e]);
            let (wanted, got) = (turn(of(&before)), of(&after));
            let off = (0..3).fold(0.0, |most: f64, i| most.max((wanted[i] - got[i]).abs()));
            judge(off <= 1e-9 * slope, || format!("a gradient of hinge {e} changed by {off:.3e}"))?;
        }
    }
    Ok(Verdict::Passed)
}

pub(super) fn definite(c: &Candidate) -> Result<Verdict, String> {
    let Some((material, body)) = coupled(c)? else { return Ok(Verdict::Passed) };
    let (g, triangles) = body.compliances(&material).map_err(told)?;
    let m = triangles.len();
    let (_, hinges) = body.strains(&material).map_err(told)?;
    let hinge_of = |a: u32, b: u32| hinges.iter().position(|h| h[..2] == [a, b] || h[..2] == [b, a]);
    let mut sum = vec![0.0; hinges.len() * hinges.len()];
    for (e, t) in triangles.iter().enumerate() {
        let at = |plane: usize| g[plane * m + e];
        let own = [at(0), at(1), at(2), at(1), at(3), at(4), at(2), at(4), at(5)];
        judge(own.iter().all(|v| v.is_finite()), || format!("triangle {e}: not finite or not written"))?;
        let shift = -1e-9 * largest(&own);
        judge(is_definite(&own, 3, shift), || format!("triangle {e}: {own:?} is not positive definite"))?;
        let sides = [0, 1, 2].map(|s| hinge_of(t[s], t[(s + 1) % 3]));
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            if let (Some(p), Some(q)) = (sides[i], sides[j]) {
                sum[p * hinges.len() + q] += own[3 * i + j];
            }
        }
    }
    judge(is_definite(&sum, hinges.len(), 0.0), || "the sum is not positive definite".into())?;
    Ok(Verdict::Passed)
}
