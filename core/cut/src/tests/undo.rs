//! Back and forth again, the same cut twice, and the document.

use super::*;
use pliant_mesh::generate::{self, Pattern};
use pliant_mesh::geometry::Vec3;

/// All there is of a mesh, for comparison.
fn state(mesh: &CutMesh) -> String {
    let origins: Vec<Origin> = (0..mesh.surface.points.len() as u32).map(|vertex| mesh.origin(vertex)).collect();
    let rows = (&mesh.texture, &mesh.shading, &mesh.texcoords, &mesh.normals);
    format!("{:?} {:?} {:?} {rows:?} {origins:?}", mesh.surface, mesh.links, mesh.body)
}

fn written(mesh: &CutMesh, document: &ObjDocument) -> Vec<u8> {
    let mut out = Vec::new();
    mesh.write(document, &mesh.surface().points, MATERIAL, &mut out).unwrap();
    out
}

fn documents() -> Vec<ObjDocument> {
    vec![
        generate::cuboid(4, [1.0, 1.0, 1.0]).unwrap(),
        generate::sphere(6, 0.5).unwrap(),
        generate::grid([7, 7], [1.0, 1.0], Pattern::Alternating).unwrap(),
    ]
}

#[test]
fn undo_gives_back_every_bit_and_so_does_redo() {
    let mut random = Random(3);
    for document in documents() {
        let mut mesh = cut_mesh(&document);
        assert_eq!(written(&mesh, &document), document.bytes(), "uncut");
        let mut states = vec![state(&mesh)];
        let c = mesh.surface().bounds().centre();
        for _ in 0..6 {
            let mut point = |reach: f64| -> Vec3 { Vec3::from_fn(|i, _| c[i] + reach * (random.unit() - 0.5)) };
            let mut stroke = Stroke::begin(blade(point(1.0), point(3.0))).unwrap();
            for _ in 0..4 {
                if mesh.advance(&mut stroke, blade(point(1.0), point(3.0))).is_ok_and(|advance| advance.has_cut()) {
                    states.push(state(&mesh));
                }
            }
        }
        assert!(states.len() > 5);
        for round in 0..3 {
            for at in (1..states.len()).rev() {
                assert_eq!(state(&mesh), states[at], "round {round}");
                assert!(mesh.undo());
            }
            assert_eq!(state(&mesh), states[0]);
            assert!(!mesh.undo());
            assert_eq!(written(&mesh, &document), document.bytes(), "undone");
            for state_after in &states[1..] {
                assert!(mesh.redo());
                assert_eq!(&state(&mesh), state_after);
            }
            assert!(!mesh.redo());
        }
    }
}

#[test]
fn the_same_cut_twice_is_one() {
    for document in documents() {
        for steps in [1, 3, 8] {
            let mut mesh = cut_mesh(&document);
            let sums = Sums::new(&mesh);
            let (from, to) = (blade([0.1, -0.8, -0.9], [0.2, -0.7, 0.9]), blade([0.13, 0.65, -0.9], [0.23, 0.75, 0.9]));
            assert!(stroke(&mut mesh, from, to, steps, &sums).is_empty());
            let once = state(&mesh);
            assert!(once != state(&cut_mesh(&document)));
            assert!(stroke(&mut mesh, from, to, steps, &sums).is_empty());
            assert!(state(&mesh) == once, "{steps} steps forth");
            assert!(stroke(&mut mesh, to, from, steps, &sums).is_empty());
            assert!(state(&mesh) == once, "{steps} steps back");
        }
    }
}

#[test]
fn the_document_reads_back_as_the_mesh() {
    let text = "mtllib a.mtl\no one\ng top\nusemtl red\ns 1\nv -1 0 0\nv 1 0 0\nv 1 2 0\nv -1 2 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
        vt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\no two\ng far\nusemtl blue\nv 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\n\
        f -4 -3 -2 -1 # kept\nl -1 -2\nv 9 0 0\nv 9 1 0\nv 8 0 0\nf -3 -1 -2\nl 1 -1\n";
    let document = document(text);
    let mut mesh = cut_mesh(&document);
    let sums = Sums::new(&mesh);
    let refused = stroke(
        &mut mesh,
        blade([-2.0, 0.9, -1.0], [-2.0, 0.9, 1.0]),
        blade([2.0, 1.1, -1.0], [2.0, 1.1, 1.0]),
        2,
        &sums,
    );
    assert!(refused.is_empty(), "{refused:?}");
    let out = String::from_utf8(written(&mesh, &document)).unwrap();
    let back = ObjDocument::parse(out.clone().into_bytes(), "back.obj".as_ref()).unwrap();
    let surface = pliant_mesh::Surface::from_document(&back);
    assert_eq!(surface.points, mesh.surface().points, "{out}");
    let sorted = |surface: &pliant_mesh::Surface| {
        let mut triangles = surface.triangles.clone();
        triangles.sort_unstable();
        triangles
    };
    assert_eq!(sorted(&surface), sorted(mesh.surface()), "{out}");
    assert!(out.contains("f -4 -3 -2 -1 # kept\nl -1 -2\n"), "{out}");
    assert!(out.contains("l 1 11\n"), "{out}");
    for face in back.faces().filter(|face| face.corners[0].vt().is_some()) {
        let name = |names: &[String], at: Option<u32>| names[at.unwrap() as usize].clone();
        assert_eq!(name(back.groups(), face.attributes.group), "top");
        assert_eq!(name(back.materials(), face.attributes.material), "red");
        for corner in face.corners {
            let (at, [u, v]) = (back.positions()[corner.v as usize], back.texcoords()[corner.vt().unwrap() as usize]);
            assert!((at[0] - (2.0 * u - 1.0)).abs() < 1e-12 && (at[1] - 2.0 * v).abs() < 1e-12);
        }
    }
    assert_eq!(back.faces().filter(|face| face.corners[0].vt().is_none()).count(), 2);
}

#[test]
fn normals_turn_with_the_mesh() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nvn 0 0 -1\nvn 0 -1 0.5\nvn 1 0 0.5\nvn 0 1 0.5\nvn -1 0 0.5\n\
        f 4//1 3//1 2//1 1//1\nf 1//2 2//2 5//2\nf 2//3 3//3 5//3\nf 3//4 4//4 5//4\nf 4//5 1//5 5//5\n";
    let document = document(text);
    let mut mesh = cut_mesh(&document);
    let sums = Sums::new(&mesh);
    let refused = stroke(
        &mut mesh,
        blade([-1.0, -1.0, 0.3], [-1.0, 2.0, 0.3]),
        blade([2.0, -1.0, 0.3], [2.0, 2.0, 0.3]),
        3,
        &sums,
    );
    assert!(refused.is_empty(), "{refused:?}");
    assert_eq!(mesh.turned_normals(&mesh.surface().points).rows, mesh.normals());
    let turned: Vec<Vec3> = mesh.surface().points.iter().map(|p| Vec3::new(-p.y, p.x, p.z)).collect();
    for (now, then) in mesh.turned_normals(&turned).rows.iter().zip(mesh.normals()) {
        assert!((0..3).all(|i| (now[i] - [-then[1], then[0], then[2]][i]).abs() < 1e-12), "{now:?} {then:?}");
    }
    let mut out = Vec::new();
    mesh.write(&document, &turned, MATERIAL, &mut out).unwrap();
    let back = ObjDocument::parse(out, "back.obj".as_ref()).unwrap();
    assert_eq!(back.normals().len(), mesh.normals().len());
    assert_eq!(back.materials(), [MATERIAL]);
}
