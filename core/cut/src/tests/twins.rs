//! Two quads with two common edges, which are split along other diagonals than each would be alone: parts in which one of them is left.

use super::*;

#[test]
fn a_quad_whose_twin_was_cut_keeps_its_triangles_in_its_part() {
    // A cube whose top is a roof of two quads, with a tip that they alone have in common.
    let document = document(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 0.5 0.5 3\n\
         f 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 7 9\nf 5 9 7 8\n",
    );
    let mut mesh = cut_mesh(&document);
    let sums = Sums::new(&mesh);
    // Away from the second quad: a corner of the first.
    let at = |way: f64| {
        let [x, y] = [0.7 + way, way];
        blade([x, y, -1.0], [x, y, 5.0])
    };
    assert_eq!(stroke(&mut mesh, at(-1.0), at(1.0), 1, &sums), []);
    let parts = mesh.parts();
    assert_eq!(parts.all.len(), 2);
    for number in 0..2 {
        let part = mesh.part(&document, |t| parts.of[t as usize] == number, "cap");
        let part = part.unwrap_or_else(|error| panic!("part {number}: {error}"));
        assert_eq!(part.triangle.len(), parts.all[number as usize].triangles, "part {number}");
    }
}
