//! The case for measures: what an element stands for scales everything it contributes.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::super::tested_material::MaterialUnderTest;
use super::material::{default_body, deform, set_moving};
use super::matrix::max_abs;
use super::{CaseResult, describe_fault, ensure, tested};
use crate::abi;
use crate::fault::Fault;
use crate::material::TangentScale;

/// Largest difference that is rounding, over the largest value of the element: products in another order.
const ROUNDING: f64 = 1e-9;
/// Kinds whose measure is not always 1, with their names.
const KINDS: [(u32, &str); 3] = [(abi::POINT, "point"), (abi::LINK, "link"), (abi::TETRAHEDRON, "tetrahedron")];

/// The part of its measure that element `e` keeps, as at a boundary or a cut; neighbours of the list keep different ones.
fn kept(e: usize) -> f64 {
    [1.0, 0.5, 0.25, 0.8][e % 4]
}

/// A result of one element.
struct Contribution {
    /// What it is, for messages.
    what: &'static str,
    element: usize,
    values: Vec<f64>,
}

/// Everything the elements of a kind contribute, in a call for each: masses and forces of all nodes, energy, and blocks with damping.
fn contributions(material: &TestInstance, body: &Body, kind: u32) -> Result<Vec<Contribution>, Fault> {
    let (n, mut all) = (body.x.len(), Vec::new());
    let mut add = |what, element, values| all.push(Contribution { what, element, values });
    body.for_each_call(abi::HAS_MASS, 1, |_, call| {
        let mut mass = vec![0.0; n];
        if call.batch.kind == kind {
            material.call_mass(call, &mut mass)?;
            add("mass", call.batch.begin, mass);
        }
        Ok(())
    })?;
    body.for_each_call(abi::HAS_FORCES, 1, |_, call| {
        if call.batch.kind != kind {
            return Ok(());
        }
        let (element, corners) = (call.batch.begin, call.batch.corners as usize);
        add("energy", element, vec![material.call_energy(call)?]);
        let mut force = vec![[0.0; 3]; n];
        material.call_forces(call, &mut force)?;
        add("force", element, force.into_flattened());
        let pairs = corners * (corners + 1) / 2;
        let slots: Vec<u32> = (0..call.batch.count * pairs).map(|slot| (slot % pairs) as u32).collect();
        let mut blocks = vec![[0.0; 9]; pairs];
        material.call_tangent(call, TangentScale { stiffness: 1.0, damping: 0.5 }, &slots, &mut blocks)?;
        add("matrix", element, blocks.into_flattened());
        Ok(())
    })?;
    Ok(all)
}

/// Each element with a part of its measure contributes that part of everything.
pub(super) fn scales_contributions(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    deform(&mut body, 1.05, 0.05);
    set_moving(&mut body);
    let mut count = 0;
    for (kind, name) in KINDS {
        let whole = contributions(&material, &body, kind).map_err(describe_fault)?;
        let mut part = body.clone();
        part.scale_measures(&material, kind, kept).map_err(describe_fault)?;
        let part = contributions(&material, &part, kind).map_err(describe_fault)?;
        for (whole, part) in whole.iter().zip(&part) {
            let (expected, e) = (kept(whole.element), whole.element);
            let tolerance = ROUNDING * max_abs(&whole.values);
            let off = whole.values.iter().zip(&part.values).find(|(whole, part)| {
                let difference = (expected * **whole - **part).abs();
                difference.is_nan() || difference > tolerance
            });
            ensure(off.is_none(), || {
                let (whole, found) = off.unwrap_or((&0.0, &0.0));
                let what = part.what;
                format!(
                    "{name} {e} with {expected} of its measure: {what} {found:.6e} instead of {:.6e}",
                    expected * whole
                )
            })?;
            count += 1;
        }
    }
    tested(count, "it has no points, links or tetrahedra with masses or forces")
}
