//! Fixings of a scene: nodes of a body that are held or moved along a path.

use super::place::{group_part, named_faces, named_group};
use super::surface_values::SurfaceValues;
use crate::body::{CellCorners, Discretization, Fixing, Lattice, Model, Place};
use crate::scene::{BodyScene, FixedScene, SceneError, Source};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::{GreyImage, Surface, TetMesh};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use toml::Spanned;

/// Value from which on colours and textures hold, where a scene does not say it.
const DEFAULT_ABOVE: f64 = 0.5;
/// Longest side of the pieces of a triangle within which a texture counts as linear, in cell edges.
const PIECE: f64 = 0.5;

/// A body of a scene whose nodes are to be held.
#[derive(Clone, Copy)]
pub(super) struct FixedBody<'a> {
    pub(super) source: &'a Source,
    pub(super) model: &'a Model,
    pub(super) discretization: &'a Discretization,
}

/// A corner of a triangle with a value: its position (m) and the value.
type Valued = (Vec3, f64);

impl FixedBody<'_> {
    /// A fixing of an entry of the scene.
    ///
    /// # Errors
    /// A group that the model does not have, a node that it does not have, and colours, texture coordinates or an image that are not there.
    pub(super) fn fixing(&self, spanned: &Spanned<FixedScene>) -> Result<Fixing, SceneError> {
        let (scene, span) = (spanned.get_ref(), spanned.span());
        let path = scene.path.iter().map(|&[t, x, y, z]| (t, Vec3::new(x, y, z)));
        Ok(Fixing { place: self.place(scene, span)?, clamp: scene.clamp, path: path.collect() })
    }

    fn place(&self, scene: &FixedScene, span: Range<usize>) -> Result<Place, SceneError> {
        let least = scene.above.as_ref().map_or(DEFAULT_ABOVE, |above| *above.get_ref());
        let values = SurfaceValues { model: self.model, source: self.source };
        match scene {
            FixedScene { box_: Some([min, max]), .. } => {
                Ok(Place::Box { min: min.map(|c| c.si).into(), max: max.map(|c| c.si).into() })
            }
            FixedScene { ball: Some(centre), .. } => {
                Ok(Place::Ball { centre: centre.map(|c| c.si).into(), radius: scene.radius.map_or(0.0, |r| r.si) })
            }
            FixedScene { group: Some(name), .. } => self.group(name),
            FixedScene { colour: Some(channel), .. } => {
                let colours = values.colours(*channel, &span)?;
                let at_corners = self.model.surface.triangles.iter().map(|t| t.map(|v| colours[v as usize]));
                Ok(self.at_least(least, at_corners, |lattice| {
                    let valued = self.triangles().zip(&self.model.surface.triangles);
                    let valued = valued.map(|(points, t)| [0, 1, 2].map(|i| (points[i], colours[t[i] as usize])));
                    CellCorners::of(valued.flat_map(|corners| part_at_least(corners, least)), &lattice.facts)
                }))
            }
            FixedScene { texture: Some(texture), .. } => {
                let (image, corners) = (values.image(texture)?, values.texture_corners(&texture.span())?);
                let at_corners = corners.iter().map(|corners| corners.map(|at| image.sample(at)));
                Ok(self.at_least(least, at_corners, |lattice| {
                    let side = PIECE * lattice.edge();
                    let pieces = self.triangles().zip(&corners).flat_map(|(p, at)| pieces(p, *at, side, &image));
                    CellCorners::of(pieces.flat_map(|corners| part_at_least(corners, least)), &lattice.facts)
                }))
            }
            FixedScene { nodes, .. } => {
                let given = nodes.as_deref().unwrap_or_default();
                match &self.model.tetrahedra {
                    Some(cells) => Ok(Place::Vertices(numbered_nodes(given, self.source, span, cells.mesh())?)),
                    None => Ok(Place::Nodes(given.iter().map(|v| self.model.document.in_place_of(*v)).collect())),
                }
            }
        }
    }

    /// The corners of the triangles of the surface, m.
    fn triangles(&self) -> impl Iterator<Item = [Vec3; 3]> {
        let Surface { points, triangles, .. } = &self.model.surface;
        triangles.iter().map(|corners| corners.map(|v| points[v as usize]))
    }

    /// The vertices of faces with a name, or the corners of the cells that they go through, or the nodes of a physical group.
    fn group(&self, name: &Spanned<String>) -> Result<Place, SceneError> {
        if let Some(cells) = &self.model.tetrahedra {
            let nodes = named_group(name, self.source, cells.mesh())?.nodes.clone();
            return Ok(Place::Vertices(nodes.into_iter().collect()));
        }
        let faces = named_faces(name, self.source, &self.model.document)?;
        let Surface { triangles, face_of, .. } = &self.model.surface;
        let is_named = face_of.iter().map(|face| faces[*face as usize]);
        Ok(match self.discretization {
            Discretization::Sheet(_) => {
                Place::Vertices(triangles.iter().zip(is_named).filter(|(_, is)| *is).flat_map(|(t, _)| *t).collect())
            }
            Discretization::Lattice(lattice) => {
                let named = self.triangles().zip(is_named).filter(|(_, is)| *is).map(|(corners, _)| corners);
                Place::Cells(CellCorners::of(named, &lattice.facts))
            }
        })
    }

    /// The vertices of a sheet whose value at a corner of a triangle is at least `least`, or of a lattice what `cells` finds.
    fn at_least(
        &self,
        least: f64,
        at_corners: impl Iterator<Item = [f64; 3]>,
        cells: impl FnOnce(&Lattice) -> CellCorners,
    ) -> Place {
        match self.discretization {
            Discretization::Sheet(_) => {
                let corners = self.model.surface.triangles.iter().flatten().copied();
                let held = corners.zip(at_corners.flatten()).filter(|(_, value)| *value >= least);
                Place::Vertices(held.map(|(vertex, _)| vertex).collect())
            }
            Discretization::Lattice(lattice) => Place::Cells(cells(lattice)),
        }
    }
}

/// Triangles that cover the part of a triangle where a value, linear between its corners, is at least `least`.
fn part_at_least(corners: [Valued; 3], least: f64) -> Vec<[Vec3; 3]> {
    let mut polygon = Vec::with_capacity(4);
    for i in 0..3 {
        let ((p, a), (q, b)) = (corners[i], corners[(i + 1) % 3]);
        if a >= least {
            polygon.push(p);
        }
        if (a >= least) != (b >= least) {
            polygon.push(p.lerp(&q, (least - a) / (b - a)));
        }
    }
    (2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]]).collect()
}

/// A triangle with texture coordinates `at`, halved until its sides are at most `side` (m), with the values of an image at the corners. Each time
/// the longest side is halved, so a sliver has no more pieces than its length asks for.
fn pieces(points: [Vec3; 3], at: [[f64; 2]; 3], side: f64, image: &GreyImage) -> Vec<[Valued; 3]> {
    let (mut all, mut left) = (Vec::new(), vec![[0, 1, 2].map(|i| (points[i], at[i]))]);
    while let Some(corners) = left.pop() {
        let length = |i: usize| (corners[(i + 1) % 3].0 - corners[i].0).norm();
        let longest = (1..3).fold(0, |longest, i| if length(i) > length(longest) { i } else { longest });
        if length(longest) <= side {
            all.push(corners.map(|(point, at)| (point, image.sample(at))));
            continue;
        }
        let [a, b, c] = [0, 1, 2].map(|i| corners[(longest + i) % 3]);
        let middle = (a.0.lerp(&b.0, 0.5), [0, 1].map(|i| 0.5 * (a.1[i] + b.1[i])));
        left.extend([[a, middle, c], [middle, b, c]]);
    }
    all
}

/// Checks the groups and numbers of nodes that a body which stands names: of a body that moves, [`FixedBody`], fields and fibres look them up.
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
