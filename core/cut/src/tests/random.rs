//! Many blades over meshes of every kind.

use std::collections::BTreeMap;

use super::*;
use pliant_mesh::generate::{self, Pattern};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::sample;

/// A blade that passes near the middle of the mesh, and where it goes.
fn swing(random: &mut Random, mesh: &CutMesh, size: f64) -> [Blade; 2] {
    let centre = mesh.surface().bounds().centre();
    let mut point = |reach: f64| -> Vec3 { Vec3::from_fn(|i, _| centre[i] + reach * size * (random.unit() - 0.5)) };
    let (tip, way, other) = (point(1.0), point(1.5), point(3.0));
    let heel = tip + (other - centre);
    let shift = |x: Vec3| x + way - centre;
    [blade(tip, heel), blade(shift(tip), shift(heel))]
}

/// Snaps a coordinate to the lattice the generated meshes stand on, so that blades go through vertices and along edges.
fn to_lattice(at: Blade, pitch: f64) -> Blade {
    let snap = |x: Vec3| x.map(|c| (c / pitch).round() * pitch);
    blade(snap(at.tip), snap(at.heel))
}

fn meshes() -> Vec<(&'static str, ObjDocument)> {
    let needle =
        "v 0 0 0\nv 1 0 0\nv 0.5 0.0001 0\nv 0.5 -0.3 0.1\nv 0.5 0.2 0.3\nf 1 2 3\nf 2 1 4\nf 1 3 5\nf 3 2 5\n";
    let book =
        "v 0 0 0\nv 1 0 0\nv 0.5 1 0\nv 0.5 0 1\nv 0.5 -1 0.2\nv 0.2 -0.5 -1\nf 1 2 3\nf 1 2 4\nf 2 1 5\nf 1 2 6\n";
    let bow = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0.1\nv 0 -1 0.1\nf 1 2 3\nf 1 4 5\n";
    vec![
        ("box", generate::cuboid(3, [1.0, 0.8, 0.6]).unwrap()),
        ("sphere", generate::sphere(6, 0.5).unwrap()),
        ("cylinder", generate::cylinder(12, 4, 0.3, 1.0).unwrap()),
        ("sheet", generate::grid([8, 6], [1.0, 0.8], Pattern::Alternating).unwrap()),
        ("holes", without(&generate::sphere(8, 0.5).unwrap(), &[3, 40, 41, 100])),
        ("needle", document(needle)),
        ("book", document(book)),
        ("bow", document(bow)),
        ("sample", ObjDocument::parse(sample::sample("elephant", 1).unwrap(), "elephant.obj".as_ref()).unwrap()),
    ]
}

#[test]
fn random_strokes_keep_every_promise() {
    let mut random = Random(17);
    let mut refused: BTreeMap<(&str, Refusal, &str), usize> = BTreeMap::new();
    let mut advances = 0;
    for (name, document) in meshes() {
        let whole = cut_mesh(&document);
        let size = whole.surface().bounds().longest_edge();
        for round in 0..60 {
            let mut mesh = cut_mesh(&document);
            let sums = Sums::new(&mesh);
            for _ in 0..4 {
                let [mut from, mut to] = swing(&mut random, &mesh, size);
                if round % 4 == 3 {
                    (from, to) = (to_lattice(from, size / 6.0), to_lattice(to, size / 6.0));
                }
                let steps = 1 + random.below(6) as u32;
                advances += steps;
                for reason in stroke(&mut mesh, from, to, steps, &sums) {
                    *refused.entry((name, reason.reason, reason.entity)).or_default() += 1;
                }
            }
        }
    }
    let total: usize = refused.values().sum();
    println!("{advances} advances, {total} refused: {refused:#?}");
    assert!(total * 100 < advances as usize, "{total} of {advances} refused: {refused:#?}");
}
