//! Solids that a test breaks: elements fail where it says, and what is shown, written and met is compared.

use pliant_engine::body::Body;
use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_mesh::{ObjDocument, Surface};
use std::collections::BTreeMap;
use std::path::Path;

/// Has all tetrahedra fail whose centroid at rest (m) is in a region, by giving them the history of complete damage, and steps once. Returns how many there are.
pub fn fail(session: &mut Session, region: impl Fn(Vec3) -> bool) -> usize {
    let system = &mut session.bodies[0].system;
    let rest = &system.nodes.rest;
    let set = system.sets.iter_mut().find(|set| !set.failed().is_empty()).expect("tetrahedra");
    let mut history = set.history().to_vec();
    let mut count = 0;
    for (nodes, damage) in set.nodes().chunks(4).zip(&mut history) {
        if region(nodes.iter().map(|node| rest[*node as usize]).sum::<Vec3>() / 4.0) {
            *damage = 1.0;
            count += 1;
        }
    }
    set.set_history(&history);
    session.step();
    count
}

/// A few random boxes in the bounds of a body.
pub fn random_boxes(body: &Body, random: &mut Random) -> Vec<[Vec3; 2]> {
    let bounds = body.model.surface.bounds();
    let size = bounds.max - bounds.min;
    let count = 1 + random.below(3);
    (0..count)
        .map(|_| {
            let middle = bounds.min + size.component_mul(&Vec3::from_fn(|_, _| random.unit()));
            let half = size.component_mul(&Vec3::from_fn(|_, _| 0.05 + 0.25 * random.unit()));
            [middle - half, middle + half]
        })
        .collect()
}

/// Whether a point (m) is in one of the boxes.
pub fn is_in(boxes: &[[Vec3; 2]], point: Vec3) -> bool {
    boxes.iter().any(|[low, high]| (0..3).all(|i| (low[i]..=high[i]).contains(&point[i])))
}

/// Corners of the triangles that viewers draw, as vertices.
pub fn drawn(body: &Body) -> Vec<[u32; 3]> {
    (0..body.model.surface.triangles.len() as u32).filter_map(|t| Some(body.look(t)?.corners)).collect()
}

/// Directed edges of triangles that have no partner in the other direction.
pub fn open_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut count: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for t in triangles {
        (0..3).for_each(|i| *count.entry([t[i], t[(i + 1) % 3]]).or_default() += 1);
    }
    let partners = |[a, b]: [u32; 2]| count.get(&[b, a]).copied().unwrap_or(0);
    count.iter().filter(|(edge, n)| **n != partners(**edge)).map(|(edge, _)| *edge).collect()
}

/// The file of a body, and the surface in it.
pub fn written(session: &mut Session) -> (Vec<u8>, Surface) {
    session.update_surface();
    let mut bytes = Vec::new();
    pliant_record::write_model_to(&session.bodies[0], "fracture", &mut bytes).expect("written");
    let document = ObjDocument::parse(bytes.clone(), Path::new("broken.obj")).expect("an OBJ file");
    (bytes, Surface::from_document(&document))
}

/// Everything of a surface that is saved, drawn or met.
pub type Shown = (Surface, Vec<Vec3>, Vec<[u32; 3]>, Vec<Vec3>);

/// What a session shows of its first body.
pub fn shown(session: &mut Session) -> Shown {
    session.update_surface();
    let body = &session.bodies[0];
    let samples = body.samples.place.clone();
    (body.model.surface.clone(), body.skin.settled.to_vec(), drawn(body), samples)
}
