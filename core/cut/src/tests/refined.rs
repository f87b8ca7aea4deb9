//! Refined cut surfaces: edges of a bounded length, walls that stay mirror images, and meshes that can be cut on.

use super::*;
use pliant_mesh::geometry::Vec3;
use std::collections::{HashMap, HashSet};

/// The corners of a triangle by their bits, the least first, in their order.
fn places(mesh: &CutMesh, triangle: u32) -> [[u64; 3]; 3] {
    let mut at: [[u64; 3]; 3] = mesh.corners_of(triangle).map(|x| x.map(f64::to_bits).into());
    let first = (0..3).min_by_key(|i| at[*i]).unwrap();
    at.rotate_left(first);
    at
}

fn caps(mesh: &CutMesh) -> Vec<u32> {
    (0..mesh.surface().triangles.len() as u32).filter(|t| mesh.is_cap(*t)).collect()
}

/// Cap triangles whose mirror image is missing.
fn unmatched(mesh: &CutMesh) -> usize {
    let mut count: HashMap<[[u64; 3]; 3], i32> = HashMap::new();
    for triangle in caps(mesh) {
        let [a, b, c] = places(mesh, triangle);
        let (key, sign) = if b < c { ([a, b, c], 1) } else { ([a, c, b], -1) };
        *count.entry(key).or_default() += sign;
    }
    count.values().filter(|sum| **sum != 0).count()
}

/// Quality of a triangle: 4 sqrt(3) times the area over the sum of the squared sides, 1 if equilateral.
fn quality(mesh: &CutMesh, triangle: u32) -> f64 {
    let [a, b, c] = mesh.corners_of(triangle);
    let sides = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    2.0 * 3.0_f64.sqrt() * mesh.cross(triangle).norm() / sides
}

fn median_quality(mesh: &CutMesh) -> f64 {
    let mut all: Vec<f64> = caps(mesh).iter().map(|t| quality(mesh, *t)).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// Lengths of edges between cap triangles over `longest` that nothing keeps from being divided: an edge stays if it is one of the skin, or has a corner
/// at its middle, or if a triangle at it has a longer edge that stays.
fn too_long(mesh: &CutMesh, longest: f64) -> Vec<f64> {
    type Key = [[u64; 3]; 2];
    let ends = |half: u32| [mesh.point(mesh.tail(half)), mesh.point(mesh.head(half))];
    let length = |half: u32| (ends(half)[1] - ends(half)[0]).norm();
    let key = |half: u32| -> Key {
        let mut key = ends(half).map(|x| x.map(f64::to_bits).into());
        key.sort_unstable();
        key
    };
    let halves: Vec<u32> = caps(mesh).into_iter().flat_map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let sides = |half: u32| [1, 2].map(|step| half - half % 3 + (half % 3 + step) % 3);
    let stays_first = |half: u32| {
        let [a, b] = ends(half);
        let apex = mesh.point(mesh.head(sides(half)[0]));
        let on_skin = mesh.around(half).any(|other| !mesh.is_cap(other / 3));
        on_skin || (apex - a.lerp(&b, 0.5)).norm() <= 1e-6 * longest
    };
    // The walls share their edges, so what one of them has to keep stays in the other.
    let mut stays: HashSet<Key> = halves.iter().filter(|half| stays_first(**half)).map(|half| key(*half)).collect();
    loop {
        let known = stays.len();
        let is_held = |half: u32| sides(half).iter().any(|s| length(*s) > length(half) && stays.contains(&key(*s)));
        let held: Vec<Key> = halves.iter().filter(|half| is_held(**half)).map(|half| key(*half)).collect();
        stays.extend(held);
        if stays.len() == known {
            return halves
                .iter()
                .map(|h| (*h, length(*h)))
                .filter(|(h, l)| *l > longest && !stays.contains(&key(*h)))
                .map(|(_, l)| l)
                .collect();
        }
    }
}

/// Strokes of a blade that goes through a body, some of them with bends.
pub(super) fn cut_through(random: &mut Random, mesh: &mut CutMesh, sums: &Sums) -> usize {
    let mut refused = 0;
    for _ in 0..1 + random.below(3) {
        let mut point = |reach: f64| Vec3::from_fn(|_, _| reach * (random.unit() - 0.5));
        let (centre, along, bend) = (point(0.5), point(1.0).normalize(), 0.3 * point(1.0));
        let way = along.cross(&point(1.0)).normalize();
        let steps = 3 + random.below(10);
        let at = |step: u64| {
            let t = 2.4 * (step as f64 / steps as f64 - 0.5);
            let middle = centre + t * way + t * t * bend;
            blade(middle - 1.5 * along, middle + 1.5 * along)
        };
        let mut stroke = Stroke::begin(at(0)).unwrap();
        let last = if random.below(3) == 0 { steps / 2 } else { steps };
        for step in 1..=last {
            match mesh.advance(&mut stroke, at(step)) {
                Ok(_) => sums.check(mesh),
                Err(_) => refused += 1,
            }
        }
    }
    refused
}

#[test]
fn cut_surfaces_get_edges_of_a_bounded_length() {
    let cases = std::env::var("REFINED").map_or(40, |count| count.parse().unwrap());
    let mut random = Random(41);
    let (mut refused, mut before, mut after, mut mirrored) = ([0; 2], Vec::new(), Vec::new(), 0);
    for case in 0..cases {
        let document = body(&mut random);
        let mut mesh = cut_mesh(&document);
        let sums = Sums::new(&mesh);
        let longest = 0.03 + 0.1 * random.unit();
        for round in 0..2 {
            refused[round] += cut_through(&mut random, &mut mesh, &sums);
            if caps(&mesh).is_empty() {
                continue;
            }
            let was = format!("{:?} {:?}", mesh.surface(), mesh.links);
            // A cut across others snaps to one wall and not to the one opposite now and then.
            let was_unmatched = unmatched(&mesh);
            before.push(median_quality(&mesh));
            let depth = mesh.depth();
            let done = mesh.refine_cut_surfaces(longest);
            sums.check(&mesh);
            mirrored += usize::from(was_unmatched == 0);
            let matched = was_unmatched > 0 || unmatched(&mesh) == 0;
            assert!(matched, "case {case}, round {round}: {} triangles without mirror image", unmatched(&mesh));
            let long = too_long(&mesh, longest);
            assert!(
                long.is_empty(),
                "case {case}, round {round}: over {longest}: {} of {}, {:?}",
                long.len(),
                caps(&mesh).len(),
                &long[..long.len().min(4)]
            );
            assert_eq!(mesh.depth(), depth + usize::from(done.is_some()));
            after.push(median_quality(&mesh));
            if done.is_some() {
                let now = format!("{:?} {:?}", mesh.surface(), mesh.links);
                assert!(mesh.undo());
                assert_eq!(format!("{:?} {:?}", mesh.surface(), mesh.links), was, "case {case}: undone");
                assert!(mesh.redo());
                assert_eq!(format!("{:?} {:?}", mesh.surface(), mesh.links), now, "case {case}: redone");
                assert!(mesh.refine_cut_surfaces(longest).is_none(), "case {case}: refined again");
            }
        }
    }
    let median = |all: &mut Vec<f64>| {
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    println!(
        "{refused:?} refused; {mirrored} of {} mirrored; median quality {:.3}, then {:.3}",
        before.len(),
        median(&mut before),
        median(&mut after)
    );
}
