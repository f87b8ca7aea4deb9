//! Whether cuts keep what they promise, on many meshes and blades.

mod awkward;
mod checks;
mod crumbs;
mod enclosure;
mod exact;
mod lagging;
mod lids;
mod random;
mod refined;
mod shared;
mod through;
mod turned;
mod twins;
mod twisted;
mod undo;

use super::*;
use checks::Sums;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Random, document, scan, without};
use pliant_mesh::{ObjDocument, Placement, generate};

fn cut_mesh(document: &ObjDocument) -> CutMesh {
    CutMesh::new(document, &Placement::default())
}

fn blade(tip: impl Into<Vec3>, heel: impl Into<Vec3>) -> Blade {
    Blade { tip: tip.into(), heel: heel.into() }
}

/// A ball, a box or a lump with about the shape of a scan, whose longest edge is about 1.
fn body(random: &mut Random) -> ObjDocument {
    match random.below(3) {
        0 => generate::sphere(8, 0.5).unwrap(),
        1 => generate::cuboid(6, [1.0, 0.6, 0.5]).unwrap(),
        _ => scan(random.below(2) as u32, 600, 0, random.next_u64()).document(),
    }
}

/// A stroke from blade to blade in `steps` advances; every one is checked. Gives the refusals.
fn stroke(mesh: &mut CutMesh, from: Blade, to: Blade, steps: u32, sums: &Sums) -> Vec<Refused> {
    let mut refused = Vec::new();
    let mut stroke = match Stroke::begin(from) {
        Ok(stroke) => stroke,
        Err(reason) => return vec![reason],
    };
    for step in 1..=steps {
        let t = f64::from(step) / f64::from(steps);
        let mix = |a: Vec3, b: Vec3| a + t * (b - a);
        match mesh.advance(&mut stroke, blade(mix(from.tip, to.tip), mix(from.heel, to.heel))) {
            Ok(_) => sums.check(mesh),
            Err(reason) => refused.push(reason),
        }
    }
    refused
}
