//! An elephant: large ears, a trunk, a tail, tusks and legs to pull, and a broad back to press.
//!
//! It stands on y = 0 and looks along +z; its left is +x. Lengths here are in its own unit, about two feet.

use super::Part;
use super::cage::{Cage, Ring, Up};
use super::charts::View;

/// Parts by number, pairs with the left one first.
pub(super) const PARTS: [Part; 14] = [
    part("body", "skin", View::Sides),
    part("head", "skin", View::Sides),
    part("trunk", "skin", View::Sides),
    part("ear_left", "ear", View::Ends),
    part("ear_right", "ear", View::Ends),
    part("leg_front_left", "skin", View::Sides),
    part("leg_front_right", "skin", View::Sides),
    part("leg_back_left", "skin", View::Sides),
    part("leg_back_right", "skin", View::Sides),
    part("tail", "skin", View::Sides),
    part("tusk_left", "ivory", View::Sides),
    part("tusk_right", "ivory", View::Sides),
    part("eye_left", "eye", View::Sides),
    part("eye_right", "eye", View::Sides),
];

const Y: Up = [0.0, 1.0, 0.0];
const Z: Up = [0.0, 0.0, 1.0];
const FORWARD: [f64; 3] = [0.0, 0.0, 1.0];
const DOWN: [f64; 3] = [0.0, -1.0, 0.0];

/// The control cage.
pub(super) fn cage() -> Cage {
    let mut cage = Cage::body(&SPINE, Y, 4);
    middle(&mut cage, &[[0.2, 3.25, 3.6], [0.2, 3.7, 3.6]], &NOSE, 2);
    pair(&mut cage, &[[1.1, 3.9, 2.85], [1.1, 3.4, 2.85]], Y, &EAR, 3);
    pair(&mut cage, &[[0.8, 1.4, 1.1], [1.2, 2.0, 1.1]], Z, &FRONT_LEG, 5);
    pair(&mut cage, &[[0.9, 1.4, -1.3], [1.3, 1.9, -1.3]], Z, &BACK_LEG, 7);
    middle(&mut cage, &[[0.2, 2.95, -2.25]], &DOCK, 9);
    pair(&mut cage, &[[0.75, 2.9, 3.45]], Y, &TUSK, 10);
    pair(&mut cage, &[[0.95, 3.75, 3.4]], Y, &EYE, 12);
    cage
}

/// A limb in the middle, from the quads nearest to `places` and to their mirror images.
fn middle(cage: &mut Cage, places: &[[f64; 3]], rings: &[Ring], part: usize) {
    let both = places.iter().flat_map(|&[x, y, z]| [[x, y, z], [-x, y, z]]);
    let root: Vec<usize> = both.map(|place| cage.nearest(place)).collect();
    cage.limb(&root, Y, rings, part);
}

/// A limb on the left, from the quads nearest to `places`, and its mirror image on the right as the next part.
fn pair(cage: &mut Cage, places: &[[f64; 3]], up: Up, rings: &[Ring], left: usize) {
    let root: Vec<usize> = places.iter().map(|&place| cage.nearest(place)).collect();
    cage.limb(&root, up, rings, left);
    let root: Vec<usize> = places.iter().map(|&[x, y, z]| cage.nearest([-x, y, z])).collect();
    let mirrored: Vec<Ring> = rings.iter().map(Ring::mirrored).collect();
    cage.limb(&root, up, &mirrored, left + 1);
}

const fn ring(at: [f64; 3], facing: [f64; 3], half: [f64; 2]) -> Ring {
    Ring { at, facing, half }
}

const fn part(group: &'static str, material: &'static str, view: View) -> Part {
    Part { group, material, view }
}

/// From the rump to the forehead; the head begins at the neck.
const SPINE: [(Ring, usize); 10] = [
    (ring([0.0, 2.80, -2.25], FORWARD, [0.62, 0.62]), 0),
    (ring([0.0, 2.72, -1.80], FORWARD, [1.22, 1.20]), 0),
    (ring([0.0, 2.72, -0.85], FORWARD, [1.55, 1.52]), 0),
    (ring([0.0, 2.74, 0.00], FORWARD, [1.66, 1.62]), 0),
    (ring([0.0, 2.76, 0.70], FORWARD, [1.52, 1.52]), 0),
    (ring([0.0, 2.90, 1.45], FORWARD, [1.16, 1.24]), 0),
    (ring([0.0, 3.30, 2.05], [0.0, 0.3, 1.0], [0.78, 0.86]), 1),
    (ring([0.0, 3.65, 2.55], [0.0, 0.1, 1.0], [1.10, 1.14]), 1),
    (ring([0.0, 3.66, 3.12], [0.0, -0.05, 1.0], [1.12, 1.20]), 1),
    (ring([0.0, 3.48, 3.66], [0.0, -0.1, 1.0], [0.88, 0.98]), 1),
];

const NOSE: [Ring; 8] = [
    ring([0.0, 3.15, 4.00], [0.0, -0.5, 1.0], [0.60, 0.62]),
    ring([0.0, 2.62, 4.40], [0.0, -1.0, 0.8], [0.52, 0.52]),
    ring([0.0, 2.00, 4.60], [0.0, -1.0, 0.25], [0.45, 0.43]),
    ring([0.0, 1.40, 4.70], [0.0, -1.0, 0.1], [0.39, 0.36]),
    ring([0.0, 0.85, 4.80], [0.0, -1.0, 0.5], [0.34, 0.33]),
    ring([0.0, 0.55, 5.10], [0.0, -0.3, 1.0], [0.30, 0.29]),
    ring([0.0, 0.65, 5.50], [0.0, 0.6, 1.0], [0.28, 0.26]),
    ring([0.0, 0.95, 5.75], [0.0, 1.0, 0.7], [0.28, 0.25]),
];

const EAR: [Ring; 5] = [
    ring([1.15, 3.65, 2.72], [1.0, 0.0, -0.2], [0.22, 0.69]),
    ring([1.45, 3.65, 2.62], [1.0, 0.0, -0.5], [0.18, 1.19]),
    ring([1.95, 3.48, 2.35], [1.0, 0.0, -0.5], [0.18, 1.56]),
    ring([2.45, 3.38, 2.15], [1.0, 0.0, -0.2], [0.17, 1.35]),
    ring([2.80, 3.38, 2.15], [1.0, 0.0, 0.1], [0.15, 0.75]),
];

const FRONT_LEG: [Ring; 5] = [
    ring([0.88, 1.45, 1.08], [0.6, -1.0, 0.0], [0.62, 0.56]),
    ring([0.86, 1.05, 1.08], [0.2, -1.0, 0.0], [0.56, 0.58]),
    ring([0.84, 0.65, 1.08], DOWN, [0.52, 0.55]),
    ring([0.84, 0.22, 1.10], DOWN, [0.55, 0.58]),
    ring([0.84, 0.00, 1.12], DOWN, [0.60, 0.64]),
];

const BACK_LEG: [Ring; 5] = [
    ring([0.94, 1.42, -1.32], [0.6, -1.0, 0.0], [0.66, 0.62]),
    ring([0.90, 1.05, -1.35], [0.2, -1.0, 0.0], [0.58, 0.60]),
    ring([0.86, 0.65, -1.38], DOWN, [0.52, 0.55]),
    ring([0.86, 0.22, -1.34], DOWN, [0.55, 0.58]),
    ring([0.86, 0.00, -1.30], DOWN, [0.60, 0.64]),
];

const DOCK: [Ring; 6] = [
    ring([0.0, 3.05, -2.35], [0.0, -0.4, -1.0], [0.27, 0.24]),
    ring([0.0, 2.75, -2.60], [0.0, -1.0, -0.6], [0.18, 0.16]),
    ring([0.0, 2.25, -2.72], [0.0, -1.0, -0.1], [0.14, 0.14]),
    ring([0.0, 1.80, -2.76], [0.0, -1.0, -0.1], [0.12, 0.12]),
    ring([0.0, 1.60, -2.80], [0.0, -1.0, -0.2], [0.24, 0.24]),
    ring([0.0, 1.25, -2.88], [0.0, -1.0, -0.2], [0.14, 0.14]),
];

const TUSK: [Ring; 4] = [
    ring([0.76, 2.80, 3.60], [0.4, -0.8, 0.7], [0.26, 0.26]),
    ring([0.78, 2.30, 4.00], [0.2, -0.6, 1.0], [0.23, 0.23]),
    ring([0.80, 2.10, 4.50], [0.1, 0.0, 1.0], [0.19, 0.19]),
    ring([0.76, 2.25, 5.05], [-0.1, 0.5, 1.0], [0.11, 0.11]),
];

const EYE: [Ring; 4] = [
    ring([0.95, 3.76, 3.41], [1.0, 0.25, 0.45], [0.24, 0.20]),
    ring([0.97, 3.76, 3.42], [1.0, 0.25, 0.45], [0.19, 0.17]),
    ring([0.94, 3.76, 3.41], [1.0, 0.25, 0.45], [0.15, 0.14]),
    ring([1.02, 3.77, 3.44], [1.0, 0.25, 0.45], [0.11, 0.10]),
];
