//! Models as people bring them: made here, and real ones where they are.

use super::*;
use pliant_mesh::testing::{models, shared_models};

/// Three strokes through a model of 0.1 m, each advance checked. Gives the refusals.
fn cut_through(mesh: &mut CutMesh) -> Vec<Refused> {
    let sums = Sums::new(mesh);
    let mut refused = Vec::new();
    for (at, steps) in [(-0.02, 1), (0.004, 9), (0.015, 25)] {
        let (from, way) = (blade([-0.08, at, -0.08], [-0.08, at, 0.08]), 0.16);
        let to = blade([way - 0.08, at + 0.003, -0.08], [way - 0.08, at + 0.003, 0.08]);
        refused.extend(stroke(mesh, from, to, steps, &sums));
    }
    refused
}

fn fitted(document: &ObjDocument) -> CutMesh {
    CutMesh::new(document, &Placement::fit(&pliant_mesh::Surface::from_document(document).bounds(), 0.1).unwrap())
}

#[test]
fn models_of_every_kind_are_cut_in_two_and_keep_every_promise() {
    for (cells, seed) in [(5, 1), (9, 2), (14, 3)] {
        for model in models(cells, seed) {
            let mut mesh = fitted(&model.document());
            let parts = mesh.parts().all.len();
            let refused = cut_through(&mut mesh);
            assert!(mesh.parts().all.len() > parts, "{}, {cells} cells", model.name);
            assert!(refused.len() < 3, "{}, {cells} cells: {refused:?}", model.name);
            assert!(!model.closed || mesh.parts().all.iter().all(|part| part.closed), "{}, {cells} cells", model.name);
        }
    }
}

#[test]
#[ignore = "needs ../shared/meshes"]
fn real_models_are_cut_in_two_and_keep_every_promise() {
    for path in shared_models() {
        let mut mesh = fitted(&ObjDocument::read(&path).unwrap());
        let parts = mesh.parts().all.len();
        let refused = cut_through(&mut mesh);
        assert!(mesh.parts().all.len() > parts, "{}", path.display());
        assert!(refused.len() < 3, "{}: {refused:?}", path.display());
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if ["stanford-bunny", "spot"].iter().any(|solid| *solid == name) {
            assert!(mesh.parts().all.iter().all(|part| part.closed), "{name} has small holes or none");
        }
    }
}
