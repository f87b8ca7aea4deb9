use super::*;
use crate::hand::PointerRay;
use pliant_engine::body::{ABSENT, CAP, Model};
use pliant_mesh::{ObjDocument, Placement, generate};
use std::path::Path;
use std::sync::Arc;

/// The topology of a document's model, at rest.
fn topology(document: ObjDocument) -> BodyTopology {
    let model = Model::new(document, Placement::default());
    let origin = model.surface.bounds().centre();
    let looks = (0..model.surface.triangles.len() as u32).map(|t| model.look(t, None)).collect();
    let positions = model.surface.points.iter().map(|p| (p - origin).map(|c| c as f32).into()).collect();
    BodyTopology { name: "body".into(), triangles: Arc::new(looks), origin, positions, moves: true }
}

fn parse(text: &str) -> ObjDocument {
    ObjDocument::parse(text.as_bytes().to_vec(), Path::new("test.obj")).unwrap()
}

/// A cube of eight vertices with outward faces.
const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";

#[test]
fn a_cube_has_hard_edges_and_a_ball_is_round() {
    let cube = ViewSurface::new(&topology(parse(CUBE)));
    assert_eq!(cube.drawn().len(), 24, "each vertex is drawn once for each of its three sides");
    for (triangle, corners) in cube.corners().iter().enumerate() {
        let flat = cube.cross(triangle as u32).normalize();
        for corner in corners {
            let normal = Vec3::from(cube.normals()[*corner as usize].map(f64::from));
            assert!((normal - flat).norm() < 1e-6);
        }
    }
    assert_eq!(cube.edges().len(), 12, "no diagonals");
    let ball = ViewSurface::new(&topology(generate::sphere(12, 1.0).unwrap()));
    // Its texture has seams, which part drawn vertices and leave their normals the same.
    assert!(ball.drawn().len() > ball.positions().len());
    for (drawn, normal) in ball.drawn().iter().zip(ball.normals()) {
        let out = Vec3::from(ball.positions()[drawn.vertex as usize].map(f64::from)).normalize();
        assert!(out.dot(&Vec3::from(normal.map(f64::from))) > 0.99);
    }
}

#[test]
fn seams_normals_and_materials_of_the_file_part_vertices() {
    let two = |extra: &str, faces: &str| {
        let text = format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n{extra}{faces}");
        ViewSurface::new(&topology(parse(&text))).drawn().len()
    };
    assert_eq!(two("", "f 1 2 3\nf 1 3 4\n"), 4);
    assert_eq!(two("vt 0 0\nvt 1 1\n", "f 1/1 2/1 3/1\nf 1/2 3/2 4/2\n"), 6, "a texture seam");
    assert_eq!(two("vn 0 0 1\nvn 0 1 0\n", "f 1//1 2//1 3//1\nf 1//2 3//2 4//2\n"), 6, "a hard edge by vn");
    assert_eq!(two("", "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n"), 6, "two materials");
}

/// A view of the surface with some vertices moved, in frame `number`.
fn moved(surface: &ViewSurface, number: u64, moves: &[(usize, [f32; 3])]) -> BodyView {
    let mut positions = surface.positions().to_vec();
    for (vertex, to) in moves {
        positions[*vertex] = *to;
    }
    BodyView::of_positions(surface.origin, positions, number)
}

#[test]
fn an_update_tells_what_moved_and_gives_the_normals_of_a_new_surface() {
    let mut surface = ViewSurface::new(&topology(generate::sphere(10, 1.0).unwrap()));
    let view = moved(&surface, 1, &[(7, [1.5, 0.2, 0.1])]);
    let changes = surface.update(1, &view, &[]);
    assert_eq!(changes.moved, [7]);
    let changed: usize = changes.vertices.iter().map(ExactSizeIterator::len).sum();
    assert!(changed >= 7 && changes.triangles.is_empty() && changes.looks.is_empty(), "{changes:?}");
    let mut fresh = topology(generate::sphere(10, 1.0).unwrap());
    fresh.positions = surface.positions().to_vec();
    let fresh = ViewSurface::new(&fresh);
    // The same to the bit, but that hard edges are those of the shape the session was opened with.
    let of_vertex = |s: &ViewSurface, v: usize| s.normals()[s.span_of[v].0 as usize];
    for v in 0..surface.positions().len() {
        if surface.span_of[v].1 == fresh.span_of[v].1 {
            assert_eq!(of_vertex(&surface, v), of_vertex(&fresh, v), "{v}");
        }
    }
    let same = surface.update(2, &moved(&surface, 2, &[]), &[]);
    assert!(same.is_empty());
}

/// The unit normal of a drawn vertex from its triangles alone, each with the angle between its edges.
fn normal_of_triangles(surface: &ViewSurface, drawn: u32) -> Vec3 {
    let DrawnVertex { vertex, group, .. } = surface.drawn[drawn as usize];
    let mut sum = Vec3::zeros();
    for &triangle in surface.around(vertex) {
        let look = surface.triangles[triangle as usize].unwrap();
        let corner = look.corners.iter().position(|v| *v == vertex).unwrap();
        if surface.drawn[surface.corners[triangle as usize][corner] as usize].group == group {
            let place = |corner: usize| surface.place(look.corners[corner % 3]);
            let [to_next, to_last] = [1, 2].map(|other| place(corner + other) - place(corner));
            sum += to_next.angle(&to_last) * surface.cross(triangle).normalize();
        }
    }
    sum.normalize()
}

#[test]
fn normals_are_means_by_angle_after_moves_and_patches_in_any_order() {
    let check = |surface: &ViewSurface, what: &str| {
        for (vertex, (first, count)) in surface.span_of.iter().enumerate() {
            // A vertex of a cut keeps the normal that was shown there.
            if surface.kept_normals.contains_key(&(vertex as u32)) {
                continue;
            }
            for drawn in *first..first + count {
                let normal = Vec3::from(surface.normals()[drawn as usize].map(f64::from));
                // A few roundings in single precision.
                assert!((normal - normal_of_triangles(surface, drawn)).norm() < 1e-6, "{what}: {vertex}");
            }
        }
    };
    let before = topology(generate::sphere(6, 1.0).unwrap());
    let mut surface = ViewSurface::new(&before);
    check(&surface, "new");
    for number in 1..=20_u64 {
        let count = surface.positions().len();
        // Vertices all over the ball; in frames without a patch also those of the triangle that comes and goes.
        let anywhere = (0..number as usize % 9).map(|n| (37 * number as usize + n * n) % count);
        let corners = before.triangles[7].unwrap().corners.map(|vertex| vertex as usize);
        let vertices = anywhere.chain(corners.into_iter().filter(|_| number % 2 == 1));
        let moves: Vec<(usize, [f32; 3])> = vertices
            .enumerate()
            .map(|(n, vertex)| (vertex, surface.positions()[vertex].map(|c| c * (0.92 + 0.02 * n as f32))))
            .collect();
        // Every other frame a triangle is taken away, or is there again.
        let look = before.triangles[7].filter(|_| number % 4 == 0);
        let patch = TopologyPatch { body: 0, number, count: before.triangles.len(), changed: vec![(7, look)] };
        let patches = if number % 2 == 0 { vec![patch] } else { Vec::new() };
        let view = moved(&surface, number, &moves);
        surface.update(number, &view, &patches);
        check(&surface, &format!("frame {number}"));
    }
}

#[test]
fn a_patch_and_its_undoing_give_the_surface_back() {
    let before = topology(parse(CUBE));
    let mut surface = ViewSurface::new(&before);
    // Triangle 0 is split at a new vertex in its middle, as a cut does, and a cap is added.
    let look = before.triangles[0].unwrap();
    let [a, b, c] = look.corners;
    let middle = (0..3).fold([0.0; 3], |sum: [f32; 3], i| {
        let p = surface.positions()[look.corners[i] as usize];
        std::array::from_fn(|k| sum[k] + p[k] / 3.0)
    });
    let mut positions = surface.positions().to_vec();
    positions.push(middle);
    let piece = |corners: [u32; 3]| Some(TriangleLook { corners, ..look });
    let cap = TriangleLook { corners: [a, 8, b], material: CAP, face: 6, shading: [ABSENT; 3], texture: [[0.0; 2]; 3] };
    let changed = vec![(0, piece([a, b, 8])), (12, piece([b, c, 8])), (13, piece([c, a, 8])), (14, Some(cap))];
    let cut = TopologyPatch { body: 0, number: 1, count: 15, changed };
    let undo = || TopologyPatch { body: 0, number: 2, count: 12, changed: vec![(0, Some(look))] };
    // Between two frames triangles may come and go: the ranges are those of what is there.
    let mut passed = ViewSurface::new(&before);
    let view = BodyView::of_positions(passed.origin, before.positions.clone(), 1);
    let changes = passed.update(1, &view, &[cut.clone(), undo()]);
    assert!(changes.triangles.iter().all(|range| range.end <= passed.corners().len()), "{changes:?}");
    assert_eq!(passed.triangles(), ViewSurface::new(&before).triangles());
    let changes = surface.update(1, &BodyView::of_positions(surface.origin, positions, 1), &[cut]);
    assert_eq!(surface.triangles().len(), 15);
    assert!(!changes.triangles.is_empty() && !changes.looks.is_empty());
    // Every corner is drawn by a vertex of the right mesh vertex, and caps share none with the skin.
    for (look, corners) in surface.triangles().iter().zip(surface.corners()) {
        let look = look.unwrap();
        for (vertex, drawn) in look.corners.iter().zip(corners) {
            let drawn = surface.drawn()[*drawn as usize];
            assert_eq!((drawn.vertex, drawn.material), (*vertex, look.material));
        }
    }
    let view = BodyView::of_positions(surface.origin, before.positions.clone(), 2);
    surface.update(2, &view, &[undo()]);
    let fresh = ViewSurface::new(&before);
    assert_eq!(surface.triangles(), fresh.triangles());
    for (a, b) in surface.corners().iter().zip(fresh.corners()) {
        for (a, b) in a.iter().zip(b) {
            assert_eq!(surface.drawn()[*a as usize].vertex, fresh.drawn()[*b as usize].vertex);
            assert_eq!(surface.normals()[*a as usize], fresh.normals()[*b as usize]);
        }
    }
    assert_eq!(surface.edges().len(), 12);
    // What is drawn no longer can still be asked for: ranges of an upload go over it.
    assert!(surface.drawn().iter().any(|drawn| drawn.vertex as usize >= surface.positions().len()));
    for drawn in 0..surface.drawn().len() {
        assert!(surface.position(drawn).iter().all(|c| c.is_finite()) && surface.displacement(drawn) == 0.0);
    }
}

#[test]
fn the_picker_finds_what_looking_at_all_finds_also_after_a_move() {
    let mut surface = ViewSurface::new(&topology(generate::sphere(10, 1.0).unwrap()));
    let mut picker = Picker::new(&surface);
    let rays: Vec<PointerRay> = (0..50).map(|i| ray(f64::from(i))).collect();
    let slow: Vec<_> = rays.iter().map(|r| picker_without_tree(&surface).pick(&surface, r, 10.0)).collect();
    while !picker.is_ready() {
        picker.update(&surface, &[], std::iter::empty());
        std::thread::yield_now();
    }
    let quick: Vec<_> = rays.iter().map(|r| picker.pick(&surface, r, 10.0)).collect();
    assert_eq!(slow, quick);
    assert!(quick.iter().flatten().count() > 10);
    let hit = quick.iter().flatten().next().unwrap();
    assert!((hit.at.point.norm() - 1.0).abs() < 0.05 && hit.at.normal.dot(&hit.at.point) > 0.9);
    let view = moved(&surface, 1, &[(7, [2.0, 0.0, 0.0])]);
    let changes = surface.update(1, &view, &[]);
    picker.update(&surface, &changes.moved, std::iter::empty());
    let moved_out = surface.corner_places(surface.around(7)[0]).unwrap();
    let middle = moved_out.iter().sum::<Vec3>() / 3.0;
    let side = (moved_out[1] - moved_out[0]).cross(&(moved_out[2] - moved_out[0])).normalize();
    let down = PointerRay { origin: middle + side, direction: -side };
    let hit = picker.pick(&surface, &down, 10.0).expect("what has moved out is met there");
    assert!(hit.distance <= 1.0 + 1e-6, "{hit:?}");
}

/// Barycentric coordinates are affine, so a point goes where an affine motion of all vertices takes it.
#[test]
fn a_point_that_was_hit_is_followed_while_the_surface_moves() {
    let mut surface = ViewSurface::new(&topology(generate::sphere(10, 1.0).unwrap()));
    let hits: Vec<Hit> =
        (0..50).filter_map(|i| picker_without_tree(&surface).pick(&surface, &ray(f64::from(i)), 10.0)).collect();
    assert!(hits.len() > 10);
    for hit in &hits {
        let at = surface.point_at(hit.triangle, &hit.weights).unwrap();
        // Positions are in single precision.
        assert!((at.point - hit.at.point).norm() < 1e-5 && at.normal == hit.at.normal, "{hit:?}");
    }
    let turn = nalgebra::Rotation3::from_scaled_axis(Vec3::new(0.3, -1.1, 0.7));
    let motion = |p: Vec3| turn * (1.7 * p) + Vec3::new(0.4, -0.2, 0.9);
    let places: Vec<(usize, [f32; 3])> = surface
        .positions()
        .iter()
        .enumerate()
        .map(|(vertex, p)| (vertex, motion(Vec3::from(p.map(f64::from))).map(|c| c as f32).into()))
        .collect();
    let view = moved(&surface, 1, &places);
    surface.update(1, &view, &[]);
    for hit in &hits {
        let at = surface.point_at(hit.triangle, &hit.weights).unwrap();
        assert!((at.point - motion(hit.at.point)).norm() < 1e-5, "{hit:?}");
        assert!((at.normal - turn * hit.at.normal).norm() < 1e-5, "{hit:?}");
    }
    assert_eq!(surface.point_at(surface.triangles().len() as u32, &hits[0].weights), None);
}

/// Splits a triangle at the point with these barycentric coordinates, as a cut does, with a cap on one of its edges. Returns the patch and the new positions.
fn split_at(surface: &ViewSurface, triangle: u32, weights: [f64; 3]) -> (TopologyPatch, Vec<[f32; 3]>) {
    let look = surface.triangles()[triangle as usize].unwrap();
    let (count, new) = (surface.triangles().len() as u32, surface.positions().len() as u32);
    let [a, b, c] = look.corners;
    let corners = look.corners.map(|v| surface.positions()[v as usize]);
    let place = std::array::from_fn(|k| (0..3).map(|i| weights[i] * f64::from(corners[i][k])).sum::<f64>() as f32);
    let piece = |corners: [u32; 3]| Some(TriangleLook { corners, ..look });
    let cap =
        TriangleLook { corners: [a, new, b], material: CAP, face: count, shading: [ABSENT; 3], texture: [[0.0; 2]; 3] };
    let changed = vec![
        (triangle, piece([a, b, new])),
        (count, piece([b, c, new])),
        (count + 1, piece([c, a, new])),
        (count + 2, Some(cap)),
    ];
    let mut positions = surface.positions().to_vec();
    positions.push(place);
    (TopologyPatch { body: 0, number: 1, count: count as usize + 3, changed }, positions)
}

#[test]
fn a_cut_leaves_the_shading_beside_it_and_it_turns_with_the_surface() {
    for (size, triangle, weights) in [(6, 20, [0.2, 0.3, 0.5]), (8, 77, [0.6, 0.1, 0.3]), (12, 150, [1.0 / 3.0; 3])] {
        let before = topology(generate::sphere(size, 1.0).unwrap());
        let mut surface = ViewSurface::new(&before);
        let look = surface.triangles()[triangle as usize].unwrap();
        let normals_of =
            |s: &ViewSurface, t: usize| s.corners()[t].map(|d| Vec3::from(s.normals()[d as usize].map(f64::from)));
        let shown = normals_of(&surface, triangle as usize);
        let expected = (0..3).map(|i| weights[i] * shown[i]).sum::<Vec3>().normalize();
        let flat = surface.cross(triangle).normalize();
        let (patch, positions) = split_at(&surface, triangle, weights);
        assert_eq!(surface.cut_edges().len(), 0);
        surface.update(1, &BodyView::of_positions(surface.origin, positions.clone(), 1), &[patch]);
        // The two old corners of the first piece, and the new one.
        let [a, b, new] = normals_of(&surface, triangle as usize);
        assert!((a - shown[0]).norm() < 1e-6 && (b - shown[1]).norm() < 1e-6, "what was smooth stays so");
        assert!((new - expected).norm() < 1e-5 && (new - flat).norm() > 1e-3, "{new} and not {expected}");
        let mut edges = surface.cut_edges();
        edges.iter_mut().for_each(|ends| ends.sort_unstable());
        edges.sort_unstable();
        let [a, b, _] = look.corners;
        let mut around = [[a, b], [a, positions.len() as u32 - 1], [b, positions.len() as u32 - 1]];
        around.iter_mut().for_each(|ends| ends.sort_unstable());
        around.sort_unstable();
        assert_eq!(edges, around, "the edges of the cap");
        let turn = nalgebra::Rotation3::from_scaled_axis(Vec3::new(-0.4, 0.9, 1.3));
        let turned = positions.iter().map(|p| (turn * Vec3::from(p.map(f64::from))).map(|c| c as f32).into()).collect();
        surface.update(2, &BodyView::of_positions(surface.origin, turned, 2), &[]);
        assert!((normals_of(&surface, triangle as usize)[2] - turn * expected).norm() < 1e-5);
        let undo =
            TopologyPatch { body: 0, number: 2, count: before.triangles.len(), changed: vec![(triangle, Some(look))] };
        surface.update(3, &BodyView::of_positions(surface.origin, before.positions.clone(), 3), &[undo]);
        let fresh = ViewSurface::new(&before);
        for t in 0..before.triangles.len() {
            assert_eq!(normals_of(&surface, t), normals_of(&fresh, t), "undo gives the normals back");
        }
        assert_eq!(surface.cut_edges().len(), 0);
    }
}

fn ray(i: f64) -> PointerRay {
    let origin = Vec3::new(3.0 * (0.7 * i).sin(), 3.0 * (0.31 * i).cos(), 3.0 * (1.3 * i).sin());
    let aim = Vec3::new(0.9 * (2.1 * i).sin(), 0.9 * (1.7 * i).cos(), 0.0);
    PointerRay { origin, direction: (aim - origin).normalize() }
}

fn picker_without_tree(surface: &ViewSurface) -> Picker {
    let mut picker = Picker::new(surface);
    picker.building = None;
    picker
}
