//! Cuts whose outcome is known.

use super::checks::euler;
use super::*;
use pliant_mesh::generate;
use pliant_mesh::generate::Pattern;

fn cuboid() -> CutMesh {
    cut_mesh(&generate::cuboid(4, [1.0, 1.0, 1.0]).unwrap())
}

fn sheet() -> CutMesh {
    cut_mesh(&generate::grid([5, 5], [1.0, 1.0], Pattern::Regular).unwrap())
}

#[test]
fn a_box_in_two() {
    for steps in [1, 2, 7, 30] {
        let mut mesh = cuboid();
        let sums = Sums::new(&mesh);
        let bounds = mesh.surface().bounds();
        let [low, high] = [bounds.min, bounds.max];
        let z = low[2] + 0.37;
        let from = blade([low[0] - 0.2, low[1] - 0.1, z], [low[0] - 0.2, high[1] + 0.1, z]);
        let to = blade([high[0] + 0.3, low[1] - 0.1, z], [high[0] + 0.3, high[1] + 0.1, z]);
        let refused = stroke(&mut mesh, from, to, steps, &sums);
        assert!(refused.is_empty(), "{steps}: {refused:?}");
        let parts = mesh.parts();
        assert_eq!(parts.all.len(), 2, "{steps} steps");
        let mut volumes: Vec<f64> = parts.all.iter().map(|part| part.volume).collect();
        volumes.sort_by(f64::total_cmp);
        assert!((volumes[0] - 0.37).abs() < 1e-12 && (volumes[1] - 0.63).abs() < 1e-12, "{volumes:?}");
        assert!(parts.all.iter().all(|part| part.closed));
        assert_eq!(euler(mesh.surface()), 4, "two spheres");
    }
}

#[test]
fn a_box_half_cut_is_one_closed_body() {
    let mut mesh = cuboid();
    let sums = Sums::new(&mesh);
    let low = mesh.surface().bounds().min;
    let at = |x: f64, y: f64| Vec3::new(low[0] + x, low[1] + y, low[2] + 0.4);
    let refused = stroke(&mut mesh, blade(at(-0.1, 0.6), at(-0.1, 1.2)), blade(at(0.55, 0.6), at(0.55, 1.2)), 6, &sums);
    assert!(refused.is_empty(), "{refused:?}");
    let parts = mesh.parts();
    assert_eq!((parts.all.len(), parts.all[0].closed), (1, true));
    assert_eq!(euler(mesh.surface()), 2);
    let caps: f64 = (0..mesh.surface().triangles.len() as u32)
        .filter(|&triangle| mesh.is_cap(triangle))
        .map(|triangle| 0.5 * mesh.cross(triangle).norm())
        .sum();
    assert!((caps - 2.0 * 0.55 * 0.4).abs() < 0.02, "{caps}");
}

#[test]
fn sheets_by_the_way_the_blade_goes() {
    let across = [([-0.2, 0.0], [1.2, 0.0], 1, 2), ([-0.2, 0.0], [0.5, 0.0], 0, 1), ([0.2, 0.0], [0.8, 0.0], -1, 1)];
    for (from, to, change, parts) in across {
        for steps in [1, 3, 10] {
            let mut mesh = sheet();
            let sums = Sums::new(&mesh);
            let before = euler(mesh.surface());
            let low = mesh.surface().bounds().min;
            let at = |x: f64, z: f64| Vec3::new(low[0] + x, low[1] + 0.33 + 0.1 * x, low[2] + z);
            let refused = stroke(
                &mut mesh,
                blade(at(from[0], -0.1), at(from[0], 0.1)),
                blade(at(to[0], -0.1), at(to[0], 0.1)),
                steps,
                &sums,
            );
            assert!(refused.is_empty(), "{refused:?}");
            assert_eq!(euler(mesh.surface()) - before, change, "{from:?} to {to:?} in {steps}");
            assert_eq!(mesh.parts().all.len(), parts, "{from:?} to {to:?} in {steps}");
        }
    }
}

#[test]
fn a_box_with_holes_is_cut_like_one_without() {
    let whole = generate::cuboid(8, [1.0, 1.0, 1.0]).unwrap();
    // Faces by their middles: one on the way of the blade on either side, and one beside it.
    let surface = pliant_mesh::Surface::from_document(&whole);
    let low = surface.bounds().min;
    let middle = |t: usize| {
        let corners = surface.triangles[t].map(|vertex| surface.points[vertex as usize]);
        [0, 1, 2].map(|i| corners.iter().map(|corner| corner[i]).sum::<f64>() / 3.0 - low[i])
    };
    let near = |t: &usize| {
        let [x, y, z] = middle(*t);
        (x < 1e-9 && (y - 0.44).abs() < 0.15 && (z - 0.37).abs() < 0.1) || (z < 1e-9 && x.max(y) < 0.1)
    };
    let mut gone: Vec<usize> = (0..surface.triangles.len()).filter(near).map(|t| surface.face_of[t] as usize).collect();
    gone.dedup();
    assert!(gone.len() > 3);
    let document = without(&whole, &gone);
    for steps in [1, 5] {
        let mut mesh = cut_mesh(&document);
        let lids = (0..mesh.surface().triangles.len() as u32).filter(|t| mesh.is_lid(*t)).count();
        assert!(lids > 2);
        let sums = Sums::new(&mesh);
        let z = low[2] + 0.37;
        let at = |x: f64| blade([low[0] + x, low[1] - 0.1, z], [low[0] + x, low[1] + 1.1, z]);
        let refused = stroke(&mut mesh, at(-0.2), at(1.3), steps, &sums);
        assert!(refused.is_empty(), "{steps}: {refused:?}");
        let mut volumes: Vec<f64> = mesh.parts().all.iter().map(|part| part.volume).collect();
        volumes.sort_by(f64::total_cmp);
        assert!(volumes.len() == 2 && (volumes[0] - 0.37).abs() < 1e-12, "{volumes:?}");
        let mut out = Vec::new();
        mesh.write(&document, &mesh.surface().points, MATERIAL, &mut out).unwrap();
        let back = pliant_mesh::Surface::from_document(&ObjDocument::parse(out, "back.obj".as_ref()).unwrap());
        let caps = (0..mesh.surface().triangles.len() as u32).filter(|t| mesh.is_cap(*t)).count();
        let skin = (0..mesh.surface().triangles.len() as u32).filter(|t| !mesh.is_cap(*t) && !mesh.is_lid(*t)).count();
        assert_eq!(back.triangles.len(), caps + skin, "lids are not written");
        let mut used = vec![false; back.points.len()];
        back.triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
        let first = document.positions().len();
        assert!(used[first..].iter().all(|used| *used), "nor are the vertices of lids");
        while mesh.undo() {}
        let mut out = Vec::new();
        mesh.write(&document, &mesh.surface().points, MATERIAL, &mut out).unwrap();
        assert_eq!(out, document.bytes());
    }
}
