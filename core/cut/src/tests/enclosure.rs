//! Which parts of cut bodies are around points.

use super::refined::cut_through;
use super::*;
use pliant_mesh::geometry::Vec3;

#[test]
fn points_in_a_row_are_in_the_same_parts_as_each_alone() {
    let mut random = Random(77);
    let (mut inside, mut parted) = (0, 0);
    for case in 0..30 {
        let mut mesh = cut_mesh(&body(&mut random));
        let sums = Sums::new(&mesh);
        cut_through(&mut random, &mut mesh, &sums);
        mesh.refine_cut_surfaces(0.1);
        let part_of = mesh.body_parts();
        let mut at = 0.8 * random.vector();
        let points: Vec<Vec3> = (0..400)
            .map(|_| {
                at = if random.below(20) == 0 { 0.8 * random.vector() } else { 0.95 * at + 0.05 * random.vector() };
                at
            })
            .collect();
        let alone: Vec<_> = points.iter().flat_map(|point| mesh.parts_around(&[*point], &part_of)).collect();
        // Few points in a row often have no surface between them.
        for length in [4, points.len()] {
            let together = points.chunks(length).flat_map(|row| mesh.parts_around(row, &part_of));
            assert_eq!(together.zip(&alone).position(|(a, b)| a != *b), None, "case {case}, {length} in a row");
        }
        inside += alone.iter().filter(|parts| !parts.is_empty()).count();
        parted += alone.windows(2).filter(|pair| pair.iter().all(|p| !p.is_empty()) && pair[0] != pair[1]).count();
    }
    assert!(inside > 3000 && parted > 50, "{inside} points inside, {parted} pairs in different parts");
}
