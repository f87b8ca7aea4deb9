//! Cases for energies of vertex normals: forces at fixed normals, derivatives by the normals, and their stiffness against tilting.

use super::super::ElementList;
use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::super::random::Random;
use super::invariance::{rigid_motion, rotate};
use super::material::{default_body, deform};
use super::matrix::max_abs;
use super::{CaseResult, NotPassed, describe_fault, ensure, skipped};
use crate::abi;

/// Step of finite differences over positions, m.
const STEP: f64 = 1e-5;
/// Step of finite differences over angles, rad.
const ANGLE_STEP: f64 = 1e-3;

/// A body with an energy of normals.
struct NormalsBody {
    material: TestInstance,
    body: Body,
    triangles: Vec<[u32; 3]>,
}

/// Results of an energy of normals.
struct NormalsResults {
    energy: f64,
    /// -dE/dx at fixed normals, N (n x 3).
    forces: Vec<[f64; 3]>,
    /// dE/dn, J (n x 3).
    derivatives: Vec<[f64; 3]>,
}

/// A material with an energy of normals and its test body; skips a material that does not ask for normals with its defaults.
fn normals_body(c: &Candidate) -> Result<NormalsBody, NotPassed> {
    let (material, body) = default_body(c)?;
    let wants = |kind: u32| body.element_counts().any(|(r, _)| r.kind == kind && r.flags & abi::WANTS_NORMALS != 0);
    let (hinges, triangles) = (wants(abi::HINGE), wants(abi::TRIANGLE));
    ensure(hinges == triangles, || {
        "the flag WANTS_NORMALS is set for one of hinges and triangles, and not for both".into()
    })?;
    if !triangles {
        return Err(skipped("no triangle wants normals with its defaults"));
    }
    let triangles = body.tilts(&material).map_err(describe_fault)?.corners;
    Ok(NormalsBody { material, body, triangles })
}

impl NormalsBody {
    /// Unit normals of the body in its current state.
    fn normals(&self) -> Vec<[f64; 3]> {
        self.body.normals(&self.triangles)
    }

    /// Energy, forces and derivatives for given unit normals.
    fn results(&self, normals: &[[f64; 3]]) -> Result<NormalsResults, String> {
        let energy = self.body.normals_energy(&self.material, normals).map_err(describe_fault)?;
        let all = self.body.normals_forces(&self.material, normals).map_err(describe_fault)?;
        let (forces, derivatives) = all.iter().map(|[a, b, c, p, q, r]| ([*a, *b, *c], [*p, *q, *r])).unzip();
        Ok(NormalsResults { energy, forces, derivatives })
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn normalised(a: [f64; 3]) -> [f64; 3] {
    a.map(|c| c / dot(a, a).sqrt())
}

/// Derivative of `f` at zero by a difference of fourth order with step `h`.
fn derivative(f: impl Fn(f64) -> Result<f64, String>, h: f64) -> Result<f64, String> {
    Ok((8.0 * (f(h)? - f(-h)?) - (f(2.0 * h)? - f(-2.0 * h)?)) / (12.0 * h))
}

const SAME_BITS: &str = "both are identical to the last bit: one is made of the other";

pub(super) fn force_is_energy_gradient(c: &Candidate) -> CaseResult {
    let mut sheet = normals_body(c)?;
    deform(&mut sheet.body, 1.02, 0.2);
    let normals = sheet.normals();
    let force = sheet.results(&normals)?.forces;
    let (tolerance, mut bit_identical) = (1e-6 * max_abs(force.iter().flatten()), true);
    ensure(tolerance > 0.0, || "no force in a deformed state".into())?;
    for node in 0..sheet.body.x.len() {
        for axis in 0..3 {
            let energy_at = |step: f64| {
                let mut moved = sheet.body.clone();
                moved.x[node][axis] += step;
                moved.normals_energy(&sheet.material, &normals).map_err(describe_fault)
            };
            let (slope, force) = (derivative(energy_at, STEP)?, force[node][axis]);
            bit_identical &= slope == -force;
            ensure((slope + force).abs() <= tolerance, || {
                format!("node {node}, axis {axis}: force {force:.6e} N, finite difference of the energy {slope:.6e} N")
            })?;
        }
    }
    ensure(!bit_identical, || SAME_BITS.into())?;
    Ok(())
}

pub(super) fn derivative_is_energy_gradient(c: &Candidate) -> CaseResult {
    let mut sheet = normals_body(c)?;
    deform(&mut sheet.body, 1.02, 0.2);
    let normals = sheet.normals();
    let derivatives = sheet.results(&normals)?.derivatives;
    let (tolerance, mut bit_identical) = (1e-6 * max_abs(derivatives.iter().flatten()), true);
    let mut random = Random(1);
    ensure(tolerance > 0.0, || "no derivative in a deformed state".into())?;
    for (node, n) in normals.iter().enumerate() {
        // A unit normal can only rotate, so the direction is perpendicular to it.
        let any = random.vector();
        let tangent = normalised([0, 1, 2].map(|i| any[i] - dot(any, *n) * n[i]));
        let energy_at = |angle: f64| {
            let mut tilted = normals.clone();
            let (s, c) = angle.sin_cos();
            tilted[node] = [0, 1, 2].map(|i| c * n[i] + s * tangent[i]);
            sheet.body.normals_energy(&sheet.material, &tilted).map_err(describe_fault)
        };
        let (slope, along) = (derivative(energy_at, ANGLE_STEP)?, dot(derivatives[node], tangent));
        bit_identical &= slope == along;
        ensure((slope - along).abs() <= tolerance, || {
            format!("normal of node {node}: derivative {along:.6e} J, finite difference of the energy {slope:.6e} J")
        })?;
    }
    ensure(!bit_identical, || SAME_BITS.into())?;
    Ok(())
}

pub(super) fn energy_is_objective(c: &Candidate) -> CaseResult {
    let mut sheet = normals_body(c)?;
    deform(&mut sheet.body, 1.02, 0.2);
    let before = sheet.results(&sheet.normals())?;
    sheet.body.x.iter_mut().for_each(|x| *x = rigid_motion(*x));
    let after = sheet.results(&sheet.normals())?;
    ensure((before.energy - after.energy).abs() <= 1e-9 * before.energy, || {
        format!("the energy changed from {:.9e} J to {:.9e} J", before.energy, after.energy)
    })?;
    let fields = [("force", &before.forces, &after.forces), ("derivative", &before.derivatives, &after.derivatives)];
    for (name, before, after) in fields {
        let tolerance = 1e-9 * max_abs(before.iter().flatten());
        for (node, (before, after)) in before.iter().zip(after).enumerate() {
            let expected = rotate(*before);
            let change = (0..3).fold(0.0, |max: f64, i| max.max((expected[i] - after[i]).abs()));
            ensure(change <= tolerance, || format!("the {name} of node {node} changed by {change:.3e}"))?;
        }
    }
    Ok(())
}

pub(super) fn rest_is_force_free(c: &Candidate) -> CaseResult {
    let mut sheet = normals_body(c)?;
    // The largest force, and the largest derivative perpendicular to its normal: along the normal it has no effect.
    let largest = |sheet: &NormalsBody| -> Result<(f64, f64), String> {
        let normals = sheet.normals();
        let results = sheet.results(&normals)?;
        let torques = results.derivatives.iter().zip(&normals);
        let torques: Vec<f64> = torques.flat_map(|(d, n)| [0, 1, 2].map(|i| d[i] - dot(*d, *n) * n[i])).collect();
        Ok((max_abs(results.forces.iter().flatten()), max_abs(&torques)))
    };
    let (force, torque) = largest(&sheet)?;
    deform(&mut sheet.body, 1.0, 0.2);
    let (bent_force, bent_torque) = largest(&sheet)?;
    ensure(force <= 1e-9 * bent_force, || format!("a force of {force:.3e} N on a flat body at rest"))?;
    ensure(torque <= 1e-9 * bent_torque, || format!("a derivative of {torque:.3e} J rotates a normal at rest"))?;
    Ok(())
}

pub(super) fn tilt_is_an_upper_bound(c: &Candidate) -> CaseResult {
    let NormalsBody { material, .. } = normals_body(c)?;
    // A single scalene triangle, so that no other triangle depends on its normals.
    let corners = [[0.0, 0.0], [0.012, 0.001], [0.004, 0.009]];
    let triangle = ElementList { nodes: vec![0, 1, 2], material: corners.concat(), ..ElementList::default() };
    let rest = corners.map(|[x, y]: [f64; 2]| [x, y, 0.0]).to_vec();
    let body = Body::new(&material, rest, |r| match r.kind {
        abi::TRIANGLE => triangle.clone(),
        _ => ElementList::default(),
    });
    let body = body.map_err(describe_fault)?;
    let tilts = body.tilts(&material).map_err(describe_fault)?.values;
    ensure(tilts.iter().all(|t| t.is_finite() && *t >= 0.0), || format!("{tilts:?} N m: negative or not written"))?;
    for (side, tilt) in tilts.iter().enumerate() {
        let (a, b) = (corners[side], corners[(side + 1) % 3]);
        let across = normalised([b[1] - a[1], a[0] - b[0], 0.0]);
        for corner in 0..3 {
            let torque_at = |angle: f64| -> Result<f64, String> {
                let mut normals = vec![[0.0, 0.0, 1.0]; 3];
                let (s, c) = angle.sin_cos();
                normals[corner] = [s * across[0], s * across[1], c];
                let all = body.normals_forces(&material, &normals).map_err(describe_fault)?;
                Ok((0..3).map(|i| all[corner][3 + i] * across[i]).sum())
            };
            let stiffness = derivative(torque_at, ANGLE_STEP)?;
            ensure(stiffness <= 1.0001 * tilt, || {
                format!(
                    "side {side}, corner {corner}: `tilt` gives {tilt:.6e} N m, and the energy has {stiffness:.6e} N m"
                )
            })?;
        }
    }
    Ok(())
}
