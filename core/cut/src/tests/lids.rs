//! Small holes get lids, large ones do not.

use crate::CutMesh;
use crate::record::OPEN;
use pliant_mesh::testing::without;
use pliant_mesh::{Placement, generate};

#[test]
fn small_holes_get_lids_and_large_ones_do_not() {
    let sphere = generate::sphere(8, 0.5).unwrap();
    let count = sphere.face_count();
    for (gone, closed) in
        [(vec![], true), (vec![3], true), (vec![0, 1, 2, 40, 41], true), ((0..count / 4).collect(), false)]
    {
        let mesh = CutMesh::new(&without(&sphere, &gone), &Placement::default());
        assert_eq!(mesh.body.iter().all(|body| *body != OPEN), closed, "{} of {count} faces gone", gone.len());
        assert_eq!(mesh.surface().triangles.len() > sphere_triangles(&mesh), closed && !gone.is_empty());
    }
}

fn sphere_triangles(mesh: &CutMesh) -> usize {
    (0..mesh.surface().triangles.len() as u32).filter(|t| !mesh.is_lid(*t)).count()
}

#[test]
fn an_open_sheet_with_a_hole_stays_open() {
    let sheet = generate::grid([8, 8], [1.0, 1.0], generate::Pattern::Regular).unwrap();
    let mesh = CutMesh::new(&without(&sheet, &[60]), &Placement::default());
    assert!(mesh.body.iter().all(|body| *body == OPEN));
}
