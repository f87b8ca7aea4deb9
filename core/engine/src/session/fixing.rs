//! What a `[[body.fixed]]` holds or moves: nodes in a place, of a group, or by number.

use super::place::{group_part, named_faces, named_group};
use crate::body::{CellCorners, Discretization, Fixing, Model, Place};
use crate::scene::{BodyScene, FixedScene, SceneError, Source};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::{Surface, TetMesh};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use toml::Spanned;

/// A fixing: nodes of a body that are held or moved along a path.
///
/// # Errors
/// A group that the model does not have.
pub(super) fn fixing(
    spanned: &Spanned<FixedScene>,
    source: &Source,
    model: &Model,
    discretization: &Discretization,
) -> Result<Fixing, SceneError> {
    let (scene, span) = (spanned.get_ref(), spanned.span());
    let place = match scene {
        FixedScene { box_: Some([min, max]), .. } => {
            Place::Box { min: min.map(|c| c.si).into(), max: max.map(|c| c.si).into() }
        }
        FixedScene { ball: Some(centre), .. } => {
            Place::Ball { centre: centre.map(|c| c.si).into(), radius: scene.radius.map_or(0.0, |r| r.si) }
        }
        FixedScene { group: Some(name), .. } => {
            if let Some(cells) = &model.tetrahedra {
                let nodes = named_group(name, source, cells.mesh())?.nodes.clone();
                return Ok(fixing_at(scene, Place::Vertices(nodes.into_iter().collect())));
            }
            let faces = named_faces(name, source, &model.document)?;
            let Surface { points, triangles, face_of } = &model.surface;
            let named = triangles.iter().zip(face_of).filter(|(_, face)| faces[**face as usize]).map(|(t, _)| *t);
            match discretization {
                Discretization::Sheet(_) => Place::Vertices(named.flatten().collect()),
                Discretization::Lattice(lattice) => {
                    let named = named.map(|corners| corners.map(|v| points[v as usize]));
                    Place::Cells(CellCorners::of(named, &lattice.facts))
                }
            }
        }
        FixedScene { nodes, .. } => {
            let given = nodes.as_deref().unwrap_or_default();
            match &model.tetrahedra {
                Some(cells) => Place::Vertices(numbered_nodes(given, source, span, cells.mesh())?),
                None => Place::Nodes(given.to_vec()),
            }
        }
    };
    Ok(fixing_at(scene, place))
}

/// Checks the groups and numbers of nodes that a body which stands names: of a body that moves, [`fixing`], fields and fibres look them up.
///
/// # Errors
/// A group, or a node of a tetrahedral mesh, that the model does not have.
pub(super) fn check_groups(body: &BodyScene, source: &Source, model: &Model) -> Result<(), SceneError> {
    for fixed in &body.fixed {
        let (mesh, scene) = (model.tetrahedra.as_ref().map(|cells| cells.mesh()), fixed.get_ref());
        match (&scene.group, &scene.nodes, mesh) {
            (Some(name), _, Some(mesh)) => drop(named_group(name, source, mesh)?),
            (Some(name), _, None) => drop(named_faces(name, source, &model.document)?),
            (None, Some(nodes), Some(mesh)) => drop(numbered_nodes(nodes, source, fixed.span(), mesh)?),
            (None, _, _) => {}
        }
    }
    let of_fields = body.field.iter().filter_map(|field| field.get_ref().group.as_ref());
    let of_fibres = body.fibre.iter().filter_map(|fibre| fibre.get_ref().group.as_ref());
    of_fields.chain(of_fibres).try_for_each(|name| group_part(name, source, model).map(drop))
}

/// A fixing of the nodes in a place.
fn fixing_at(scene: &FixedScene, place: Place) -> Fixing {
    let path = scene.path.iter().map(|&[t, x, y, z]| (t, Vec3::new(x, y, z)));
    Fixing { place, clamp: scene.clamp, path: path.collect() }
}

/// Nodes of a tetrahedral mesh by their numbers in the file.
///
/// # Errors
/// A number that no node of a tetrahedron has.
fn numbered_nodes(
    given: &[u32],
    source: &Source,
    span: Range<usize>,
    mesh: &TetMesh,
) -> Result<HashSet<u32>, SceneError> {
    let index: HashMap<u64, u32> = mesh.node_number.iter().copied().zip(0..).collect();
    let node = |number: &u32| {
        index.get(&u64::from(*number)).copied().ok_or_else(|| {
            let (least, most) = (mesh.node_number.iter().min(), mesh.node_number.iter().max());
            let text = format!(
                "no tetrahedron of {} has node {number}; allowed is the number of a node in the file, from {} to {}",
                mesh.name().display(),
                least.unwrap_or(&0),
                most.unwrap_or(&0)
            );
            source.error(span.clone(), text)
        })
    };
    given.iter().map(node).collect()
}
