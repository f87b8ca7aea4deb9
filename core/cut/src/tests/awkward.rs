//! Blades nobody would choose, in the places they would choose least.

use super::*;
use pliant_mesh::generate;

const BOX: f64 = 0.5;

fn cuboid() -> CutMesh {
    cut_mesh(&generate::cuboid(4, [1.0, 1.0, 1.0]).unwrap())
}

fn cut(from: [[f64; 3]; 2], to: [[f64; 3]; 2], steps: u32) -> (CutMesh, Vec<Refused>) {
    let mut mesh = cuboid();
    let sums = Sums::new(&mesh);
    let refused = stroke(&mut mesh, blade(from[0], from[1]), blade(to[0], to[1]), steps, &sums);
    sums.check(&mesh);
    (mesh, refused)
}

#[test]
fn blades_that_are_none_are_refused() {
    for bad in [f64::NAN, f64::INFINITY, 1e12] {
        let refused = Stroke::begin(blade([0.0, bad, 0.0], [1.0, 0.0, 0.0])).unwrap_err();
        assert_eq!(refused.reason, Refusal::NotFinite);
        let mut mesh = cuboid();
        let mut stroke = Stroke::begin(blade([0.0, -1.0, 0.0], [1.0, -1.0, 0.0])).unwrap();
        assert!(mesh.advance(&mut stroke, blade([0.0, 1.0, 0.0], [1.0, bad, 0.0])).is_err());
        assert_eq!(mesh.surface(), cuboid().surface());
    }
    assert_eq!(Stroke::begin(blade([0.1; 3], [0.1; 3])).unwrap_err().reason, Refusal::NoLength);
}

#[test]
fn a_blade_that_waits_or_slides_along_itself_cuts_nothing() {
    let mut mesh = cuboid();
    let start = blade([0.0; 3], [0.0, 2.0, 0.0]);
    let mut stroke = Stroke::begin(start).unwrap();
    for next in [start, blade([0.0, -0.2, 0.0], [0.0, 1.8, 0.0])] {
        assert!(!mesh.advance(&mut stroke, next).unwrap().has_cut());
    }
    assert_eq!(mesh.surface(), cuboid().surface());
    assert!(!mesh.undo());
}

#[test]
fn through_vertices_and_along_edges() {
    // A plane of lattice points: every vertex it meets is on it, and every edge in it is cut along.
    for steps in [1, 4, 5] {
        let (mesh, refused) =
            cut([[-0.8, 0.25, -0.9], [-0.8, 0.25, 0.9]], [[0.8, 0.25, -0.9], [0.8, 0.25, 0.9]], steps);
        assert!(refused.is_empty(), "{refused:?}");
        assert_eq!(mesh.parts().all.len(), 2);
        let (mesh, refused) = cut([[-0.8, -0.8, -0.9], [-0.8, -0.8, 0.9]], [[0.8, 0.8, -0.9], [0.8, 0.8, 0.9]], steps);
        assert!(refused.is_empty(), "{refused:?}");
        assert_eq!(mesh.parts().all.len(), 2, "through the edges of the box");
    }
}

#[test]
fn in_the_plane_of_faces_there_is_nothing_to_cut() {
    for at in [BOX, -BOX] {
        for steps in [1, 3] {
            let (mesh, refused) = cut([[-0.8, -0.9, at], [-0.8, 0.9, at]], [[0.8, -0.9, at], [0.8, 0.9, at]], steps);
            assert!(refused.is_empty(), "{refused:?}");
            assert_eq!(mesh.parts().all.len(), 1);
            assert!((mesh.parts().all[0].volume - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_blade_all_inside_leaves_the_body_whole() {
    let (mesh, refused) = cut([[-0.2, 0.1, -0.2], [-0.2, 0.1, 0.2]], [[0.2, 0.1, -0.2], [0.2, 0.1, 0.2]], 3);
    assert!(refused.is_empty());
    assert_eq!(mesh.surface(), cuboid().surface());
}

#[test]
fn a_star_of_cuts_leaves_its_slices() {
    let mut mesh = cuboid();
    let sums = Sums::new(&mesh);
    for turn in 0..3 {
        let angle = 0.3 + f64::from(turn) * std::f64::consts::PI / 3.0;
        let (x, y) = (1.1 * angle.cos(), 1.1 * angle.sin());
        let refused =
            stroke(&mut mesh, blade([-x, -y, -0.9], [-x, -y, 0.9]), blade([x, y, -0.9], [x, y, 0.9]), 7, &sums);
        assert!(refused.is_empty(), "{refused:?}");
    }
    let parts = mesh.parts();
    assert_eq!(parts.all.len(), 6);
    assert!(parts.all.iter().all(|part| part.closed && part.volume > 0.1));
    assert!((parts.all.iter().map(|part| part.volume).sum::<f64>() - 1.0).abs() < 1e-12);
}
