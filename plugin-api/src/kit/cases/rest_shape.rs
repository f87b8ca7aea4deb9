//! Cases for the shape at rest: how it lies in space says nothing to a material, and it may be curved.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::sheet;
use super::invariance::{compare, ensure_objective, rotate};
use super::material::{EDGE, default_body, deform, force_tolerance, max_component};
use super::{CaseResult, describe_fault, ensure, skipped};
use crate::abi::{self, Status};

/// Turning the shape at rest changes neither energy nor forces: axes of a material are those of its fibres or of its material coordinates, which
/// turn with it.
pub(super) fn axes_turn_with_it(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    if body.has(abi::WANTS_DIRECTIONS) {
        return Err(skipped("it wants fibre directions: see `directions-turn-with-the-shape-at-rest`"));
    }
    ensure_objective(c)?;
    deform(&mut body, 1.05, 0.05);
    let mut turned = body.clone();
    turned.rotate_rest(&material, rotate).map_err(describe_fault)?;
    compare(&material, &body, &turned, |f| f)?;
    Ok(())
}

/// Angle between neighbouring strips of the curved sheet, rad.
const FOLD: f64 = 0.3;

/// A sheet that is curved about the y axis at rest, by a fold between each two strips of squares, so that its material coordinates, which are
/// those of the flat one, keep the shape of each triangle.
fn curved(flat: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let strip_end = |strip: usize| {
        let angles = (0..strip).map(|s| FOLD * s as f64);
        angles.fold([0.0, 0.0], |[x, z]: [f64; 2], angle| [x + EDGE * angle.cos(), z + EDGE * angle.sin()])
    };
    let place = |p: &[f64; 3]| {
        let [x, z] = strip_end((p[0] / EDGE).round() as usize);
        [x, p[1], z]
    };
    flat.iter().map(place).collect()
}

/// A sheet that is curved at rest has no forces there, whichever way it lies; one that is bent from there has some.
pub(super) fn curved_is_force_free(c: &Candidate) -> CaseResult {
    let (material, flat) = default_body(c)?;
    if !flat.element_counts().any(|(r, _)| r.kind == abi::TRIANGLE || r.kind == abi::HINGE) {
        return Err(skipped("it has no triangles or hinges"));
    }
    let list = sheet([3, 3], EDGE);
    let body = match Body::new(&material, curved(&list.rest), |r| list.elements(r.kind)) {
        Ok(body) => body,
        Err(fault) if fault.status != Status::PANICKED => {
            return Err(skipped(format!("it takes no curved shape at rest: {}", describe_fault(fault))));
        }
        Err(fault) => return Err(describe_fault(fault).into()),
    };
    let tolerance = force_tolerance(&material, &body)?;
    let force = max_component(&body.forces(&material).map_err(describe_fault)?);
    ensure(force <= tolerance, || format!("a force of {force:.3e} N on a curved sheet at rest"))?;
    if body.has(abi::IS_COUPLED) {
        let strain = |body: &Body| -> Result<f64, String> {
            let strains = body.strains(&material).map_err(describe_fault)?;
            Ok(strains.plane(0).iter().fold(0.0, |max: f64, s| max.max(s.abs())))
        };
        let mut bent = body.clone();
        deform(&mut bent, 1.0, 0.2);
        let (rest, bent) = (strain(&body)?, strain(&bent)?);
        ensure(rest <= 1e-9 * bent, || format!("a hinge of a curved sheet at rest has a strain of {rest:.3e} m"))?;
    }
    Ok(())
}
