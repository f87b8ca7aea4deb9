//! Which vertices the seams of a scene join.

use super::place::named_faces;
use crate::body::Model;
use crate::scene::{SceneError, SeamScene, Source};
use pliant_solver::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use toml::Spanned;

/// A seam of a sheet.
#[derive(Clone, Debug)]
pub(super) struct Seam {
    /// Pairs of vertices.
    pub pairs: Vec<[u32; 2]>,
    /// Time in which they are drawn together, s; 0 for vertices that are joined where they are.
    pub time: f64,
    /// Where the scene has it, for messages.
    pub place: String,
}

/// The pairs of vertices of a seam.
///
/// # Errors
/// Neither or both of `groups` and `pairs`, a group that the model does not have or without a border, groups with different numbers of vertices, and
/// a pair of vertices that are not there or the same.
pub(super) fn pairs(scene: &Spanned<SeamScene>, source: &Source, model: &Model) -> Result<Vec<[u32; 2]>, SceneError> {
    match scene.get_ref() {
        SeamScene { groups: Some(groups), pairs: None, .. } => of_groups(groups, source, model),
        SeamScene { groups: None, pairs: Some(pairs), .. } => {
            let vertices = model.surface.points.len() as u32;
            let wrong = |[a, b]: &&[u32; 2]| a == b || *a.max(b) >= vertices;
            match pairs.get_ref().iter().find(wrong) {
                Some([a, b]) => {
                    let text = format!(
                        "`pairs` has [{a}, {b}]; allowed is two different vertices from 0 to {}",
                        vertices.saturating_sub(1)
                    );
                    Err(source.error(pairs.span(), text))
                }
                None => {
                    let pairs_in_place = pairs.get_ref().iter().map(|pair| pair.map(|v| model.document.in_place_of(v)));
                    let in_place: Vec<[u32; 2]> = pairs_in_place.filter(|[a, b]| a != b).collect();
                    if let Some(vertex) = in_place.iter().flatten().find(|v| model.around(**v).is_empty()) {
                        let text =
                            format!("`pairs` has vertex {vertex}, which no face uses; allowed are vertices of faces");
                        return Err(source.error(pairs.span(), text));
                    }
                    Ok(in_place)
                }
            }
        }
        _ => Err(source.error(scene.span(), "a `stitch` has one of `groups` and `pairs`")),
    }
}

/// Pairs of the vertices of two groups, in their order along the border and turned so that they are nearest to each other.
fn of_groups(groups: &[Spanned<String>; 2], source: &Source, model: &Model) -> Result<Vec<[u32; 2]>, SceneError> {
    let [first, second] = [border_of(&groups[0], source, model)?, border_of(&groups[1], source, model)?];
    let [names, counts] = [
        [groups[0].get_ref().clone(), groups[1].get_ref().clone()],
        [first.vertices.len(), second.vertices.len()].map(|n| n.to_string()),
    ];
    if counts[0] != counts[1] || first.is_loop != second.is_loop {
        let kind = |border: &Border| if border.is_loop { "all around" } else { "in a row" };
        let text = format!(
            "group `{}` has {} vertices {} on the border and group `{}` has {} {}; allowed is two borders alike",
            names[0],
            counts[0],
            kind(&first),
            names[1],
            counts[1],
            kind(&second)
        );
        return Err(source.error(groups[1].span(), text));
    }
    if let Some(vertex) = first.vertices.iter().find(|v| second.vertices.contains(v)) {
        let text = format!(
            "groups `{}` and `{}` share vertex {vertex}; allowed is groups of different vertices",
            names[0], names[1]
        );
        return Err(source.error(groups[1].span(), text));
    }
    let count = first.vertices.len();
    let shifts = if first.is_loop { count } else { 1 };
    let x = |v: u32| model.surface.points[v as usize];
    let ways = (0..shifts).flat_map(|shift| [false, true].map(|turned| (shift, turned)));
    let paired = |(shift, turned): (usize, bool)| -> Vec<[u32; 2]> {
        let other = |i: usize| if turned { count - 1 - i } else { i };
        (0..count).map(|i| [first.vertices[i], second.vertices[(other(i) + shift) % count]]).collect()
    };
    let length = |pairs: &[[u32; 2]]| pairs.iter().map(|[a, b]| (x(*a) - x(*b)).norm()).sum::<f64>();
    let all = ways.map(paired).map(|pairs| (length(&pairs), pairs));
    Ok(all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, pairs)| pairs).unwrap_or_default())
}

/// Vertices of a group along the border of a sheet.
struct Border {
    vertices: Vec<u32>,
    is_loop: bool,
}

/// The border vertices whose faces are all of a group, in their order along the border.
fn border_of(name: &Spanned<String>, source: &Source, model: &Model) -> Result<Border, SceneError> {
    let faces = named_faces(name, source, &model.document)?;
    let surface = &model.surface;
    let is_named = |triangle: &u32| faces[surface.face_of[*triangle as usize] as usize];
    let is_own = |v: &u32| model.around(*v).iter().all(is_named);
    let mut count: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for [a, b, c] in &surface.triangles {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            *count.entry([*a.min(b), *a.max(b)]).or_default() += 1;
        }
    }
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (edge, _) in count.iter().filter(|(edge, count)| **count == 1 && edge.iter().all(is_own)) {
        for [a, b] in [[edge[0], edge[1]], [edge[1], edge[0]]] {
            next.entry(a).or_default().push(b);
        }
    }
    let wrong = |text: String| source.error(name.span(), format!("group `{}` {text}", name.get_ref()));
    let Some((&lowest, _)) = next.first_key_value() else {
        let text = "has no edge on the border of the sheet; allowed is faces along a border, of which all faces at each vertex of the seam are in the group";
        return Err(wrong(text.into()));
    };
    let end = next.iter().find(|(_, others)| others.len() == 1).map(|(v, _)| *v);
    let (mut vertices, mut seen) = (vec![end.unwrap_or(lowest)], BTreeSet::from([end.unwrap_or(lowest)]));
    while let Some(other) = next[&vertices[vertices.len() - 1]].iter().find(|other| !seen.contains(*other)) {
        seen.insert(*other);
        vertices.push(*other);
    }
    if vertices.len() < next.len() {
        let text = format!(
            "has {} vertices on the border, {} of them in one piece; allowed is one piece",
            next.len(),
            vertices.len()
        );
        return Err(wrong(text));
    }
    Ok(Border { vertices, is_loop: end.is_none() })
}

/// Distance (m) of the vertices of a pair at rest.
pub(super) fn gap(model: &Model, [a, b]: [u32; 2]) -> f64 {
    let x = |v: u32| -> Vec3 { model.surface.points[v as usize] };
    (x(a) - x(b)).norm()
}
