//! Real models, where they are on this machine.

use super::*;
use pliant_mesh::testing::shared_models;

#[test]
fn real_models_are_cut_in_two_and_keep_every_promise() {
    for path in shared_models() {
        let document = ObjDocument::read(&path).unwrap();
        let placement = Placement::fit(&pliant_mesh::Surface::from_document(&document).bounds(), 0.1).unwrap();
        let mut mesh = CutMesh::new(&document, &placement);
        let sums = Sums::new(&mesh);
        let parts = mesh.parts().all.len();
        let mut refused = Vec::new();
        for (at, steps) in [(-0.02, 1), (0.004, 9), (0.015, 25)] {
            let (from, way) = (blade([-0.08, at, -0.08], [-0.08, at, 0.08]), 0.16);
            let to = blade([way - 0.08, at + 0.003, -0.08], [way - 0.08, at + 0.003, 0.08]);
            refused.extend(stroke(&mut mesh, from, to, steps, &sums));
        }
        assert!(mesh.parts().all.len() > parts, "{}", path.display());
        assert!(refused.len() < 3, "{}: {refused:?}", path.display());
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if ["stanford-bunny", "spot"].iter().any(|solid| *solid == name) {
            assert!(mesh.parts().all.iter().all(|part| part.closed), "{name} has small holes or none");
        }
    }
}
