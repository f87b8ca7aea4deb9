//! Opening of the obstacles of a scene: their surfaces, motion and friction.

use super::Opening;
use crate::contact::Friction;
use crate::memory::{file_bytes, format_bytes};
use crate::obstacle::{MeshSurface, Obstacle, ObstacleSurface};
use crate::scene::{ObstacleScene, Scene};
use crate::session::{SessionError, place};
use crate::shape::{self, ShapeParams};
use nalgebra::UnitQuaternion;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::{ObjDocument, Placement, Surface};
use std::sync::Arc;
use toml::Spanned;

impl Opening<'_> {
    /// Opens the obstacles of a scene, and records the files that are read.
    pub(super) fn obstacles(&mut self, scene: &Scene) -> Result<Vec<Obstacle>, SessionError> {
        scene.obstacle.iter().map(|obstacle| self.obstacle(obstacle)).collect()
    }

    fn obstacle(&mut self, scene: &ObstacleScene) -> Result<Obstacle, SessionError> {
        let name = scene.name.get_ref().clone();
        let rotation = scene.rotation.as_ref().map(|r| place::rotation(r, self.source)).transpose()?;
        let origin = scene.position.map_or(Vec3::zeros(), |p| p.map(|c| c.si).into());
        let surface = self.obstacle_surface(scene)?;
        let [static_coefficient, kinetic_coefficient] = *scene.friction.get_ref();
        let path: Vec<(f64, Vec3)> = scene.path.get_ref().iter().map(|&[t, x, y, z]| (t, Vec3::new(x, y, z))).collect();
        let degrees = |&[t, x, y, z]: &[f64; 4]| (t, Vec3::new(x, y, z) * (std::f64::consts::PI / 180.0));
        let turns = scene.rotation_path.get_ref().iter().map(degrees).collect();
        let kind = scene.shape.as_ref().map_or("mesh", |shape| shape.get_ref().kind.get_ref()).to_owned();
        let mut obstacle = Obstacle {
            name,
            kind,
            surface: Arc::new(surface),
            rotation: UnitQuaternion::identity(),
            initial_rotation: rotation.unwrap_or_else(UnitQuaternion::identity),
            origin,
            path,
            turns,
            restitution: scene.restitution.as_ref().map_or(0.0, |e| *e.get_ref()),
            friction: Friction { static_coefficient, kinetic_coefficient },
            position: origin,
            force: Vec3::zeros(),
            friction_work: 0.0,
        };
        (obstacle.position, obstacle.rotation) = (obstacle.position_at(0.0), obstacle.rotation_at(0.0));
        Ok(obstacle)
    }

    /// The surface of an obstacle: its shape or its mesh.
    fn obstacle_surface(&mut self, scene: &ObstacleScene) -> Result<ObstacleSurface, SessionError> {
        let name = scene.name.get_ref();
        let thickness = scene.thickness.as_ref().map_or(0.0, |t| t.get_ref().si);
        match (&scene.shape, &scene.mesh) {
            (Some(given), _) => {
                let of = given.get_ref();
                let params = ShapeParams {
                    radius: of.radius.map(|r| r.si),
                    length: of.length.map(|l| l.si),
                    size: of.size.map(|size| size.map(|s| s.si)),
                };
                let wrong = |text| self.source.error(given.span(), format!("obstacle `{name}`: {text}"));
                Ok(ObstacleSurface::Shape(shape::build(of.kind.get_ref(), &params).map_err(wrong)?, thickness))
            }
            (None, Some(mesh)) => {
                let surface = whole_surface(self.obstacle_document(name, mesh)?);
                let wrong = |text: String| self.source.error(mesh.span(), format!("obstacle `{name}`: {text}"));
                let placement = match &scene.size {
                    Some(size) => {
                        Placement::fit(&surface.bounds(), size.get_ref().si).map_err(|e| wrong(e.to_string()))?
                    }
                    None => Placement {
                        scale: scene.scale.as_ref().map_or(1.0, |s| *s.get_ref()),
                        rotation: UnitQuaternion::identity(),
                        translation: Vec3::zeros(),
                    },
                };
                let made = MeshSurface::new(&surface.placed(&placement), thickness);
                Ok(ObstacleSurface::Mesh(Box::new(made.map_err(|e| wrong(e.to_string()))?)))
            }
            (None, None) => {
                let text = format!("obstacle `{name}` has no surface; allowed is one of `mesh` and `shape`");
                Err(self.source.error(scene.name.span(), text).into())
            }
        }
    }

    /// The mesh of an obstacle, of the source or read from its file, within the memory that is left.
    fn obstacle_document(&mut self, name: &str, mesh: &Spanned<String>) -> Result<ObjDocument, SessionError> {
        if let Some(document) = self.source.documents.get(mesh.get_ref()) {
            return Ok(document.clone());
        }
        let path = self.source.folder().join(mesh.get_ref());
        if !path.is_file() {
            let text = format!("no file {}; paths are relative to the scene", path.display());
            return Err(self.source.error(mesh.span(), text).into());
        }
        let size = std::fs::metadata(&path).map_or(0, |facts| facts.len());
        let what = format!("the mesh {} of {}", path.display(), format_bytes(size));
        let checked = self.memory.check(&format!("obstacle `{name}`"), file_bytes(size), &what, |_| None);
        checked.map_err(|text| SessionError::Memory(self.source.error(mesh.span(), text)))?;
        let document = ObjDocument::read(&path)?;
        self.inputs.obstacle_files.push(path);
        Ok(document)
    }
}

/// The surface of the mesh of an obstacle with its coincident borders welded and its faces turned the same way round: of an obstacle only the surface counts.
fn whole_surface(mut document: ObjDocument) -> Surface {
    let pairs = document.coincident_borders(&Surface::from_document(&document), 0.0);
    document.weld(&pairs);
    document.turn_over(&document.faces_turned_over(&Surface::from_document(&document)));
    Surface::from_document(&document)
}
