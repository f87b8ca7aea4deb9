//! Placement of models and devices in a scene.

use super::SessionError;
use super::memory_checks::ModelCheck;
use super::ray_miss::{self, Ray};
use super::shared::SharedModel;
use super::subdivision::subdivide;
use crate::body::{Model, Warp};
use crate::memory::MemoryAccount;
use crate::scene::{
    BodyScene, FrameScene, PatternScene, RotationScene, SceneError, ShapeKind, ShapeScene, SheetScene, Source,
    ToolScene, WarpScene, Weld,
};
use crate::shape::{self, OrientedShape, ShapeParams};
use crate::tool::Frame;
use nalgebra::{Unit, UnitQuaternion};
use pliant_mesh::generate::Pattern;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::geometry::cast;
use pliant_mesh::tetrahedra::Group;
use pliant_mesh::{MeshError, ObjDocument, Placement, Surface, TetMesh, generate};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// Loads the model of a body, within the memory that `account` has left. `instead` is a replacement file, scaled to the bounding box of the
/// body's own model. `smallest` is the radius of the smallest tool, m, 0 without one.
pub(super) fn model(
    scene: &BodyScene,
    source: &Source,
    instead: Option<&Path>,
    account: &MemoryAccount,
    smallest: f64,
) -> Result<Model, SessionError> {
    let check = ModelCheck { scene, source, account };
    let wants = scene.is_tetrahedral();
    let is_in_memory = instead.is_none() && has_document(scene, source);
    let mut tetrahedra = None;
    let mut read = |path: &Path| -> Result<ObjDocument, SessionError> {
        check.file(path)?;
        if TetMesh::is_name(&path.to_string_lossy()) != wants {
            let wanted =
                if wants { "a tetrahedral mesh (.msh, .vtk or .vtu), as the body is one" } else { "an OBJ file" };
            let text = format!(
                "the model {} in the place of that of body `{}`; allowed is {wanted}",
                path.display(),
                scene.name.get_ref()
            );
            return Err(source.whole(text).into());
        }
        if !wants {
            return Ok(ObjDocument::read(path)?);
        }
        let mesh = TetMesh::read(path)?;
        check.tetrahedra(&mesh)?;
        let document = mesh.surface()?;
        tetrahedra = Some(mesh);
        Ok(document)
    };
    let document = match (&scene.mesh, &scene.shape) {
        (Some(mesh), _) if has_document(scene, source) => source.documents.get(mesh.get_ref()).cloned(),
        (Some(mesh), _) => {
            let path = source.folder().join(mesh.get_ref());
            if !path.is_file() && instead.is_none() {
                let text = format!("no file {}; paths are relative to the scene", path.display());
                return Err(source.error(mesh.span(), text).into());
            }
            if path.is_file() { Some(read(&path)?) } else { None }
        }
        (None, Some(shape)) => {
            check.shape(shape.get_ref())?;
            Some(shape_document(shape.get_ref()).map_err(|e| source.error(shape.span(), e.to_string()))?)
        }
        (None, None) => None,
    };
    let placement = document.as_ref().map(|d| placement(scene, source, d)).transpose()?;
    let make = |document: ObjDocument, placement: Placement, tetrahedra: Option<TetMesh>| {
        if let Some(mesh) = tetrahedra {
            return Ok(Model::of_tetrahedra(mesh, document, placement));
        }
        let mut document = weld(scene, document, is_in_memory, placement.scale);
        let turned_over = document.faces_turned_over(&Surface::from_document(&document));
        document.turn_over(&turned_over);
        let (document, subdivision) = subdivide(&check, document, placement.scale, smallest)?;
        let mut model = Model::new(document, placement);
        model.subdivision = subdivision;
        Ok(model)
    };
    match (document, placement, instead) {
        (Some(document), Some(placement), None) => {
            check.document(&document)?;
            make(document, placement, tetrahedra)
        }
        (own, placement, Some(path)) => {
            let document = read(path)?;
            check.document(&document)?;
            let rotation = placement.map_or(UnitQuaternion::identity(), |p| p.rotation);
            let bounds = Surface::from_document(&document).bounds();
            let (size, centre) = match own.zip(placement) {
                Some((own, placement)) => {
                    let bounds = Surface::from_document(&own).bounds();
                    let centre = placement.apply(bounds.centre());
                    (placement.scale * bounds.longest_edge(), centre)
                }
                None => {
                    let size = scene.size.as_ref().map_or(0.1, |s| s.get_ref().si);
                    (size, position(scene))
                }
            };
            let fit = Placement::fit(&bounds, size).map_err(|error| of_mesh(scene, &document, error))?;
            let translation = rotation * fit.translation + centre;
            make(document, Placement { rotation, translation, ..fit }, tetrahedra)
        }
        _ => Err(source.whole(format!("body `{}` has no model", scene.name.get_ref())).into()),
    }
}

/// Cache key of [`model`] with all of its inputs; `None` for a model the program passes in memory, whose name does not identify it.
pub(super) fn model_key(scene: &BodyScene, source: &Source, instead: Option<&Path>, smallest: f64) -> Option<String> {
    if has_document(scene, source) {
        return None;
    }
    let mesh = scene.mesh.as_ref().map(|mesh| source.folder().join(mesh.get_ref()));
    let shape = scene.shape.as_ref().map(|shape| shape.get_ref());
    let (size, scale) = (scene.size.as_ref().map(|s| s.get_ref().si), scene.scale.as_ref().map(|s| *s.get_ref()));
    let rotation = scene.rotation.as_ref().map(|r| (*r.axis.get_ref(), r.angle.si));
    let position = scene.position.map(|p| p.map(|c| c.si));
    let subdivide = scene.subdivide.as_ref().map(|levels| (*levels.get_ref(), smallest));
    let weld = scene.weld.as_ref().map(|weld| *weld.get_ref());
    Some(format!("{mesh:?} {shape:?} {size:?} {scale:?} {rotation:?} {position:?} {instead:?} {subdivide:?} {weld:?}"))
}

/// Whether the program passes the mesh of a body in memory.
fn has_document(scene: &BodyScene, source: &Source) -> bool {
    scene.mesh.as_ref().is_some_and(|mesh| source.documents.contains_key(mesh.get_ref()))
}

/// Welds the borders of a document as its scene asks for. Without a word there, those of a file are welded that lie at exactly one place, unless they are cuts or
/// the scene stitches them; a program that passes a mesh in memory has chosen its vertices. `scale` is metres per unit of the file.
fn weld(scene: &BodyScene, mut document: ObjDocument, is_in_memory: bool, scale: f64) -> ObjDocument {
    let is_as_given = || is_in_memory || !scene.stitch.is_empty() || document.has_cut_borders();
    let distance = match scene.weld.as_ref().map(|weld| *weld.get_ref()) {
        Some(Weld::Within(distance)) => distance.si / scale,
        None if !is_as_given() => 0.0,
        Some(Weld::Off) | None => return document,
    };
    let pairs = document.coincident_borders(&Surface::from_document(&document), distance);
    document.weld(&pairs);
    document
}

pub(super) fn of_mesh(scene: &BodyScene, document: &ObjDocument, error: MeshError) -> SessionError {
    SessionError::Mesh { file: document.name().into(), body: scene.name.get_ref().clone(), error: Box::new(error) }
}

fn position(scene: &BodyScene) -> Vec3 {
    scene.position.map_or(Vec3::zeros(), |p| p.map(|c| c.si).into())
}

fn shape_document(shape: &ShapeScene) -> Result<ObjDocument, MeshError> {
    let [x, y, z] = shape.size.map(|s| s.si);
    match shape.kind {
        ShapeKind::Box => generate::cuboid(shape.cells, [x, y, z]),
        ShapeKind::Sphere => generate::sphere(shape.cells, 0.5 * x),
        ShapeKind::Sheet => {
            let rows = match shape.rows {
                0 if shape.pattern == PatternScene::Equilateral => generate::equilateral_rows(shape.cells, [x, y]),
                0 => (f64::from(shape.cells) * y / x).round().max(1.0) as u32,
                rows => rows,
            };
            let pattern = match shape.pattern {
                PatternScene::Regular => Pattern::Regular,
                PatternScene::Alternating => Pattern::Alternating,
                PatternScene::Equilateral => Pattern::Equilateral,
                PatternScene::Irregular => Pattern::Irregular,
            };
            generate::grid([shape.cells, rows], [x, y], pattern)
        }
        ShapeKind::Cylinder => generate::cylinder(4 * shape.cells, shape.cells, 0.5 * x, z),
    }
}

/// The shape of a tool with its rotation.
pub(super) fn shape(scene: &ToolScene, source: &Source) -> Result<OrientedShape, SceneError> {
    let tool = scene.name.get_ref();
    match (&scene.radius, &scene.shape) {
        (Some(radius), None) => Ok(OrientedShape::sphere(radius.get_ref().si)),
        (None, Some(given)) => {
            let of = given.get_ref();
            let params = ShapeParams {
                radius: of.radius.map(|r| r.si),
                length: of.length.map(|l| l.si),
                size: of.size.map(|size| size.map(|s| s.si)),
            };
            let wrong = |text| source.error(given.span(), format!("tool `{tool}`: {text}"));
            let mut shape = OrientedShape::new(shape::build(of.kind.get_ref(), &params).map_err(wrong)?);
            if let Some(turn) = &of.rotation {
                shape.set_rotation(rotation(turn, source)?);
            }
            Ok(shape)
        }
        (Some(_), Some(given)) => {
            Err(source.error(given.span(), format!("tool `{tool}` has `radius` and `shape`; allowed is one of them")))
        }
        (None, None) => {
            let text = format!("tool `{tool}` has no shape; allowed is `radius`, of a sphere, or `shape`");
            Err(source.error(scene.name.span(), text))
        }
    }
}

fn placement(scene: &BodyScene, source: &Source, document: &ObjDocument) -> Result<Placement, SessionError> {
    let rotation = scene.rotation.as_ref().map_or(Ok(UnitQuaternion::identity()), |r| rotation(r, source))?;
    let position = position(scene);
    let Some(size) = &scene.size else {
        let scale = scene.scale.as_ref().map_or(1.0, |s| *s.get_ref());
        return Ok(Placement { scale, rotation, translation: position });
    };
    let bounds = Surface::from_document(document).bounds();
    let fit = Placement::fit(&bounds, size.get_ref().si).map_err(|error| of_mesh(scene, document, error))?;
    Ok(Placement { rotation, translation: rotation * fit.translation + position, ..fit })
}

pub(super) fn rotation(scene: &RotationScene, source: &Source) -> Result<UnitQuaternion<f64>, SceneError> {
    let axis = Unit::try_new(Vec3::from(*scene.axis.get_ref()), 1e-12).ok_or_else(|| {
        let text = format!("rotation about {:?}; allowed is an axis with a length", scene.axis.get_ref());
        source.error(scene.axis.span(), text)
    })?;
    Ok(UnitQuaternion::from_axis_angle(&axis, scene.angle.si))
}

/// Direction of the warp of a sheet.
pub(super) fn warp(scene: &SheetScene) -> Warp {
    match &scene.warp {
        WarpScene::Axis(axis) => Warp::Axis((*axis).into()),
        WarpScene::Name(_) => Warp::Texture,
    }
}

/// What a group of a model is for fields and fibres.
pub(super) enum GroupPart {
    /// What is nearest to triangles of the surface: whether to each.
    Triangles(Vec<bool>),
    /// Some tetrahedra of the model: whether each.
    Tetrahedra(Vec<bool>),
}

/// The faces, or of a tetrahedral mesh the faces or tetrahedra, of a group.
///
/// # Errors
/// A name that is not there, a group without faces on the surface, and one of points or lines.
pub(super) fn group_part(name: &Spanned<String>, source: &Source, model: &Model) -> Result<GroupPart, SceneError> {
    let wrong = |text: String| Err(source.error(name.span(), text));
    let no_faces = || wrong(format!("group `{}` of the model has no faces", name.get_ref()));
    if let Some(cells) = &model.tetrahedra {
        let group = named_group(name, source, cells.mesh())?;
        match group.dimension {
            // Faces inside of the body are not of the surface.
            2 if model.document.faces_named(&group.name).is_none() => return no_faces(),
            2 => {}
            3 => {
                let mut is_inside = vec![false; cells.mesh().tetrahedra.len()];
                group.tetrahedra.iter().for_each(|tetrahedron| is_inside[*tetrahedron as usize] = true);
                return Ok(GroupPart::Tetrahedra(is_inside));
            }
            _ => {
                let kind = group.kind();
                return wrong(format!("group `{}` is of {kind}; allowed is one of faces or tetrahedra", group.name));
            }
        }
    }
    let faces = named_faces(name, source, &model.document)?;
    if !faces.contains(&true) {
        return no_faces();
    }
    Ok(GroupPart::Triangles(model.surface.face_of.iter().map(|face| faces[*face as usize]).collect()))
}

/// The physical group of a tetrahedral mesh with a name.
///
/// # Errors
/// A name that no group has, with those that there are.
pub(super) fn named_group<'a>(
    name: &Spanned<String>,
    source: &Source,
    mesh: &'a TetMesh,
) -> Result<&'a Group, SceneError> {
    mesh.group(name.get_ref()).ok_or_else(|| {
        let text = format!("no group `{}` in the model; allowed is {}", name.get_ref(), mesh.list_groups());
        source.error(name.span(), text)
    })
}

/// Whether each face of a model is under a `g` or `o` line with a name.
///
/// # Errors
/// A name that no line has, with those that there are.
pub(super) fn named_faces(
    name: &Spanned<String>,
    source: &Source,
    document: &ObjDocument,
) -> Result<Vec<bool>, SceneError> {
    document.faces_named(name.get_ref()).ok_or_else(|| {
        let text = format!("no group `{}` in the model; allowed is {}", name.get_ref(), document.list_names());
        source.error(name.span(), text)
    })
}

/// The frame of a device: given by the scene, or placed where a ray hits a body. With `near`, a ray that misses is placed at the closest vertex.
pub(super) fn frame(
    scene: &FrameScene,
    source: &Source,
    device: Range<usize>,
    bodies: &[(String, SharedModel)],
    near: bool,
) -> Result<Frame, SceneError> {
    let scale = scene.scale.as_ref().map_or(1.0, |s| *s.get_ref());
    if !(scale.is_finite() && scale > 0.0) {
        let span = scene.scale.as_ref().map_or(0..0, |s| s.span());
        return Err(source.error(span, format!("scale {scale}; allowed is a number above 0")));
    }
    let turned = scene.rotation.as_ref().map_or(Ok(UnitQuaternion::identity()), |r| rotation(r, source))?;
    let Some(name) = &scene.body else {
        if scene.from.is_some() || scene.toward.is_some() {
            let text = "`from` and `toward` without `body`; allowed is all three, or `origin` and `rotation`";
            return Err(source.error(device, text));
        }
        let origin = scene.origin.map_or(Vec3::zeros(), |o| o.map(|c| c.si).into());
        return Ok(Frame { origin, rotation: turned, scale });
    };
    let wrong = |text: String| source.error(name.span(), text);
    if scene.origin.is_some() {
        return Err(wrong("`origin` and `body`; allowed is one of them".into()));
    }
    let Some((_, SharedModel { model, .. })) = bodies.iter().find(|(n, _)| n == name.get_ref()) else {
        let known: Vec<String> = bodies.iter().map(|(n, _)| format!("`{n}`")).collect();
        return Err(wrong(format!("no body `{}`; allowed is {}", name.get_ref(), known.join(", "))));
    };
    let (Some(from), Some(toward)) = (scene.from, scene.toward) else {
        return Err(wrong("`body` alone; allowed is `body` with `from` and `toward`, two places in its box".into()));
    };
    let bounds = model.surface.bounds();
    let in_box = |p: [f64; 3]| bounds.min + Vec3::from(p).component_mul(&(bounds.max - bounds.min));
    let (origin, ray) = (in_box(from), in_box(toward) - in_box(from));
    let hit = cast(&model.surface.points, &model.surface.triangles, origin, ray);
    let met = hit.filter(|_| ray.norm() > 0.0).map(|hit| origin + hit.time * ray);
    let missed = || near.then(|| closest_vertex(model, &origin, &ray));
    let Some(met) = met.or_else(missed) else {
        let why = ray_miss::reason(&model.surface, &Ray { origin, direction: ray });
        let name = name.get_ref();
        return Err(wrong(format!("the ray from {from:?} toward {toward:?} does not meet body `{name}`: {why}")));
    };
    let back = (-ray).normalize();
    let rotation = rotation_from_z(&back) * turned;
    Ok(Frame { origin: met, rotation, scale })
}

fn closest_vertex(model: &Model, origin: &Vec3, ray: &Vec3) -> Vec3 {
    let away = |p: &&Vec3| (**p - origin).cross(ray).norm_squared();
    let vertices = model.surface.triangles.iter().flatten().map(|&v| &model.surface.points[v as usize]);
    vertices.min_by(|a, b| away(a).total_cmp(&away(b))).map_or(*origin, |p| *p)
}

/// The smallest rotation from z to `to`; half a turn about x if `to` is -z.
fn rotation_from_z(to: &Vec3) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vec3::z(), to)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI))
}
