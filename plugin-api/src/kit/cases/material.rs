//! What every material promises, and the bodies it is looked at in.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::opened::Opened;
use super::super::subject::Subject;
use super::super::{block, sheet};
use super::coupled::{coupled_slope, coupled_turns, definite};
use super::derivatives::{damping, force_slope, stiffness_slope};
use super::invariance::{order, rotation, translation};
use super::linear::largest;
use super::repeat::{allocates, instances, ranges, same_bytes};
use super::{Case, Verdict, judge, normals, single, told};
use crate::abi;
use crate::material::Tangent;

pub(super) const CASES: &[Case] = &[
    Case { name: "mass-is-positive", promise: "every node of a whole body has a finite mass above zero", run: mass },
    Case { name: "rest-is-force-free", promise: "nothing pulls while the body is at rest", run: rest },
    Case { name: "force-is-energy-slope", promise: "the force is minus the slope of the energy", run: force_slope },
    Case {
        name: "stiffness-is-force-slope",
        promise: "the stiffness is minus the slope of the force, or a stand-in that is nowhere softer",
        run: stiffness_slope,
    },
    Case {
        name: "single-stiffness-is-the-stiffness",
        promise: "in single precision the stiffness is the same, of two corners alone, and the others are what those leave",
        run: single::stiffness,
    },
    Case {
        name: "damping-dissipates",
        promise: "damping is symmetric, takes energy, and is minus the slope of the force over velocity",
        run: damping,
    },
    Case {
        name: "coupled-strain-has-its-slope",
        promise: "the gradient of a coupled hinge's strain is its slope, and there is no strain at rest",
        run: coupled_slope,
    },
    Case {
        name: "coupled-strain-turns",
        promise: "a body elsewhere and turned has the same strains of coupled hinges, and turned gradients",
        run: coupled_turns,
    },
    Case {
        name: "compliance-is-definite",
        promise: "the compliance between coupled hinges is positive definite, in each triangle and in sum",
        run: definite,
    },
    Case {
        name: "normals-force-has-its-slope",
        promise: "at fixed normals, the force of an energy of normals is minus its slope",
        run: normals::force_slope,
    },
    Case {
        name: "normals-slope-has-its-slope",
        promise: "what is given as the slope in the normals is that of the energy",
        run: normals::normal_slope,
    },
    Case {
        name: "normals-turn",
        promise: "a body elsewhere and turned has the same energy of normals, and turned forces and slopes",
        run: normals::turns,
    },
    Case {
        name: "normals-rest-is-force-free",
        promise: "a flat body at rest is left alone by its normals",
        run: normals::rest,
    },
    Case {
        name: "tilt-is-stiff-enough",
        promise: "a normal tilts across a side no stiffer than is said",
        run: normals::tilt,
    },
    Case { name: "translation-changes-nothing", promise: "energy and force do not depend on where", run: translation },
    Case {
        name: "rotation-turns-the-force",
        promise: "a turned body has the same energy and turned forces",
        run: rotation,
    },
    Case { name: "order-changes-nothing", promise: "the order of the elements does not matter", run: order },
    Case {
        name: "ranges-give-the-same-bytes",
        promise: "calls over parts of the list come to one call's bytes",
        run: ranges,
    },
    Case {
        name: "same-state-same-bytes",
        promise: "a state gives the same bytes whatever was asked before",
        run: same_bytes,
    },
    Case {
        name: "instances-do-not-share",
        promise: "what one instance is told does not reach another",
        run: instances,
    },
    Case {
        name: "finite-at-extremes",
        promise: "numbers at the ends of their ranges give finite results",
        run: extremes,
    },
    Case {
        name: "nan-is-reported",
        promise: "a place that is not a number does not vanish in a finite force",
        run: nan,
    },
    Case { name: "no-allocation-in-a-step", promise: "calls of a step take no memory from the system", run: allocates },
];

/// m
const EDGE: f64 = 0.01;

/// A small body at rest with the elements the material wants.
pub(super) fn specimen(material: &Opened) -> Result<Body, String> {
    let wanted = material.wants().map_err(told)?;
    let surface = wanted.iter().any(|r| [abi::TRIANGLE, abi::HINGE].contains(&r.kind));
    let families = wanted.iter().fold(0, |all, r| all | r.families);
    let body = if surface {
        let sheet = sheet([3, 3], EDGE);
        Body::new(material, sheet.rest.clone(), |r| sheet.given(r.kind))
    } else {
        let block = block([2, 2, 2], EDGE, families);
        Body::new(material, block.rest.clone(), |r| block.given(r.kind))
    };
    let body = body.map_err(|fault| format!("at rest: {}", told(fault)))?;
    let none = body.counts().find(|(_, count)| *count == 0);
    match none {
        Some((r, _)) => Err(format!("no elements of kind {} and families {} in a block", r.kind, r.families)),
        None => Ok(body),
    }
}

/// An instance with its defaults and a small body of it.
pub(super) fn sound(c: &Candidate) -> Result<(Opened, Body), String> {
    let material = c.open(&[]).map_err(told)?;
    let body = specimen(&material)?;
    Ok((material, body))
}

/// Numbers within [-1, 1], the same on every run.
pub(super) fn random() -> impl FnMut() -> f64 {
    let mut seed = 1_u64;
    move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Moves every node by up to `share` of an edge, after a stretch by `stretch`.
pub(super) fn deform(body: &mut Body, stretch: f64, share: f64) {
    let mut next = random();
    for x in &mut body.x {
        *x = x.map(|c| stretch * c + share * EDGE * next());
    }
}

/// Velocities of up to 1 m/s.
pub(super) fn set_moving(body: &mut Body) {
    let mut next = random();
    for v in &mut body.v {
        *v = [next(), next(), next()];
    }
}

/// N, a force that counts as none: what moves a node by 1e-9 of an edge.
pub(super) fn nothing(material: &Opened, body: &Body) -> Result<f64, String> {
    let k = body.tangent(material, Tangent { stiffness: 1.0, damping: 0.0 }).map_err(told)?;
    Ok(1e-9 * EDGE * largest(&k))
}

/// The largest component of forces, N.
pub(super) fn size(forces: &[[f64; 3]]) -> f64 {
    largest(forces.iter().flatten())
}

fn mass(c: &Candidate) -> Result<Verdict, String> {
    let (material, body) = sound(c)?;
    let mass = body.mass(&material).map_err(told)?;
    match mass.iter().position(|m| !(m.is_finite() && *m > 0.0)) {
        Some(node) => Err(format!("node {node} of a block has {} kg", mass[node])),
        None => Ok(Verdict::Passed),
    }
}

fn rest(c: &Candidate) -> Result<Verdict, String> {
    let (material, body) = sound(c)?;
    let (found, most) = (size(&body.forces(&material).map_err(told)?), nothing(&material, &body)?);
    judge(found <= most, || format!("a force of {found:.3e} N at rest"))?;
    let mut moved = body;
    deform(&mut moved, 1.02, 0.0);
    let found = size(&moved.forces(&material).map_err(told)?);
    judge(found > most, || "nothing pulls while it is stretched either".into())?;
    Ok(Verdict::Passed)
}

fn extremes(c: &Candidate) -> Result<Verdict, String> {
    for (place, p) in c.params().iter().enumerate() {
        let values = match p.kind {
            abi::PARAM_NUMBER => vec![p.min, p.max],
            abi::PARAM_CHOICE => (0..Candidate::choices(p).len()).map(|i| i as f64).collect(),
            _ => continue,
        };
        for value in values {
            let at = || format!("`{}` = {value}", Candidate::key(p));
            let material = match c.open(&[(place, value)]) {
                Ok(material) => material,
                // A refusal is an answer.
                Err(fault) if fault.status == abi::Status::BAD_ARGUMENT => continue,
                Err(fault) => return Err(format!("{}: {}", at(), told(fault))),
            };
            let mut body = specimen(&material).map_err(|why| format!("{}: {why}", at()))?;
            deform(&mut body, 1.1, 0.05);
            set_moving(&mut body);
            let results = || -> Result<[f64; 4], crate::Fault> {
                let tangent = body.tangent(&material, Tangent { stiffness: 1.0, damping: 1.0 })?;
                let (force, mass) = (body.forces(&material)?, body.mass(&material)?);
                Ok([body.energy(&material)?, sum(force.iter().flatten()), sum(&tangent), sum(&mass)])
            };
            let results = results().map_err(|fault| format!("{}: {}", at(), told(fault)))?;
            for (what, value) in ["energy", "force", "matrix", "mass"].iter().zip(results) {
                judge(value.is_finite(), || format!("{}: the {what} is not finite", at()))?;
            }
        }
    }
    Ok(Verdict::Passed)
}

fn sum<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().map(|v| v.abs()).sum()
}

fn nan(c: &Candidate) -> Result<Verdict, String> {
    let (material, body) = sound(c)?;
    for node in [0, body.x.len() / 2, body.x.len() - 1] {
        let mut broken = body.clone();
        broken.x[node][1] = f64::NAN;
        if let Ok(force) = broken.forces(&material) {
            let vanished = force.iter().flatten().all(|f| f.is_finite());
            judge(!vanished, || format!("node {node} at NaN gave finite forces and no fault"))?;
        }
    }
    Ok(Verdict::Passed)
}
