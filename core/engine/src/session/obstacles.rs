//! Obstacles of a session: their surfaces, where they are, and their contact with bodies.

use super::opening::Opening;
use super::{Session, SessionError, Warning, WarningCode, place};
use crate::body::Body;
use crate::contact::{ObstacleContacts, PlacedObstacle};
use crate::memory::{file_bytes, format_bytes};
use crate::obstacle::{MeshSurface, Obstacle, ObstacleSurface};
use crate::scene::{ObstacleScene, Scene};
use crate::shape::{self, ShapeParams};
use nalgebra::UnitQuaternion;
use pliant_mesh::{ObjDocument, Placement, Surface};
use pliant_solver::{StepTime, Vec3};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// What a session knows about its obstacles.
#[derive(Default)]
pub(super) struct Obstacles {
    /// The obstacles, in the order of the scene.
    pub list: Vec<Obstacle>,
    /// Location of each in the scene.
    pub places: Vec<String>,
    /// Number of steps in which each pushed a body.
    pub pushes: Vec<u64>,
    /// Contacts of each moving body; empty without obstacles.
    pub contacts: Vec<ObstacleContacts>,
    /// What each body and the obstacles have moved since its contacts were last placed, m.
    unseen: Vec<f64>,
}

/// Depth of a vertex inside of an obstacle that counts, in edges of the body.
const INSIDE: f64 = 1e-6;

/// Number of distances that are timed for a plan.
const TIMED_DISTANCES: usize = 100;

/// An obstacle in plans and summaries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObstacleSummary {
    /// Name in the scene.
    pub name: String,
    /// Name of the shape, or `mesh`.
    pub surface: String,
    /// Number of triangles of a mesh.
    pub triangles: usize,
    /// Whether it moves along a path.
    pub moves: bool,
    /// Wall-clock time of a distance to it, s, measured now.
    pub distance_seconds: f64,
}

impl Obstacles {
    /// No obstacle, or these for `bodies` moving bodies.
    pub fn new(list: Vec<Obstacle>, places: Vec<String>, bodies: usize) -> Self {
        let bodies = if list.is_empty() { 0 } else { bodies };
        Self {
            pushes: vec![0; list.len()],
            contacts: (0..bodies).map(|_| ObstacleContacts::new()).collect(),
            unseen: vec![0.0; bodies],
            list,
            places,
        }
    }
}

impl Obstacles {
    /// Adapts to another number of moving bodies.
    pub(super) fn resize(&mut self, bodies: usize) {
        let bodies = if self.list.is_empty() { 0 } else { bodies };
        self.contacts.resize_with(bodies, ObstacleContacts::new);
        self.unseen.resize(bodies, 0.0);
    }
}

impl Opening<'_> {
    /// Opens the obstacles of a scene. Returns them and the files that were read.
    pub(super) fn obstacles(&mut self, scene: &Scene) -> Result<(Vec<Obstacle>, Vec<PathBuf>), SessionError> {
        let mut files = Vec::new();
        let list =
            scene.obstacle.iter().map(|obstacle| self.obstacle(obstacle, &mut files)).collect::<Result<_, _>>()?;
        Ok((list, files))
    }

    fn obstacle(&mut self, scene: &ObstacleScene, files: &mut Vec<PathBuf>) -> Result<Obstacle, SessionError> {
        let name = scene.name.get_ref().clone();
        let rotation = scene.rotation.as_ref().map(|r| place::rotation(r, self.source)).transpose()?;
        let origin = scene.position.map_or(Vec3::zeros(), |p| p.map(|c| c.si).into());
        let thickness = scene.thickness.as_ref().map_or(0.0, |t| t.get_ref().si);
        let surface = match (&scene.shape, &scene.mesh) {
            (Some(given), _) => {
                let of = given.get_ref();
                let params = ShapeParams {
                    radius: of.radius.map(|r| r.si),
                    length: of.length.map(|l| l.si),
                    size: of.size.map(|size| size.map(|s| s.si)),
                };
                let wrong = |text| self.source.error(given.span(), format!("obstacle `{name}`: {text}"));
                ObstacleSurface::Shape(shape::build(of.kind.get_ref(), &params).map_err(wrong)?, thickness)
            }
            (None, Some(mesh)) => {
                let key = mesh.get_ref();
                let document = match self.source.documents.get(key) {
                    Some(document) => document.clone(),
                    None => {
                        let path = self.source.folder().join(key);
                        if !path.is_file() {
                            let text = format!("no file {}; paths are relative to the scene", path.display());
                            return Err(self.source.error(mesh.span(), text).into());
                        }
                        let size = std::fs::metadata(&path).map_or(0, |facts| facts.len());
                        let what = format!("the mesh {} of {}", path.display(), format_bytes(size));
                        let checked =
                            self.memory.check(&format!("obstacle `{name}`"), file_bytes(size), &what, |_| None);
                        checked.map_err(|text| SessionError::Memory(self.source.error(mesh.span(), text)))?;
                        let document = ObjDocument::read(&path)?;
                        files.push(path);
                        document
                    }
                };
                let surface = Surface::from_document(&document);
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
                let made =
                    MeshSurface::new(&surface.placed(&placement), thickness).map_err(|e| wrong(e.to_string()))?;
                ObstacleSurface::Mesh(Box::new(made))
            }
            (None, None) => {
                let text = format!("obstacle `{name}` has no surface; allowed is one of `mesh` and `shape`");
                return Err(self.source.error(scene.name.span(), text).into());
            }
        };
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
            friction: crate::contact::Friction { static_coefficient, kinetic_coefficient },
            position: origin,
            force: Vec3::zeros(),
            friction_work: 0.0,
        };
        (obstacle.position, obstacle.rotation) = (obstacle.position_at(0.0), obstacle.rotation_at(0.0));
        Ok(obstacle)
    }
}

impl Session {
    /// The obstacles, in the order of the scene.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles.list
    }

    /// The obstacles for plans and summaries.
    pub fn obstacle_summaries(&self) -> Vec<ObstacleSummary> {
        let each = self.obstacles.list.iter().map(|obstacle| {
            let triangles = match &*obstacle.surface {
                ObstacleSurface::Shape(..) => 0,
                ObstacleSurface::Mesh(mesh) => mesh.triangles(),
            };
            let (name, surface) = (obstacle.name.clone(), obstacle.kind.clone());
            ObstacleSummary {
                name,
                surface,
                triangles,
                moves: obstacle.moves(),
                distance_seconds: self.time_distances(obstacle),
            }
        });
        each.collect()
    }

    /// Wall-clock time of the distance of a vertex from an obstacle, s.
    fn time_distances(&self, obstacle: &Obstacle) -> f64 {
        let points = self.bodies.iter().flat_map(|body| &body.model.surface.points).take(TIMED_DISTANCES);
        let began = Instant::now();
        let (count, sum) = points.fold((0, 0.0), |(count, sum), p| (count + 1, sum + obstacle.distance(*p)));
        std::hint::black_box(sum);
        began.elapsed().as_secs_f64() / f64::from(count.max(1))
    }

    /// Whether an obstacle moves in a step near the box of a body, m.
    pub(super) fn obstacle_comes(&self, [low, high]: [Vec3; 2], reach: f64, time: StepTime) -> bool {
        self.obstacles.list.iter().any(|obstacle| {
            let corners: [Vec3; 8] =
                std::array::from_fn(|i| Vec3::from_fn(|c, _| if i >> c & 1 == 1 { high[c] } else { low[c] }));
            let fastest = obstacle.fastest(&corners, time);
            if fastest == 0.0 {
                return false;
            }
            let [from, to] = obstacle.bounds_at(obstacle.position_at(time.start), obstacle.rotation_at(time.start));
            let reach = reach + 2.0 * time.dt * fastest;
            (0..3).all(|c| from[c] < high[c] + reach && low[c] < to[c] + reach)
        })
    }

    /// Finds the points of a body that may meet an obstacle in a step.
    pub(super) fn place_obstacles(&mut self, index: usize, time: StepTime) {
        let Some(contacts) = self.obstacles.contacts.get_mut(index) else { return };
        let list = &self.obstacles.list;
        let body = &mut self.bodies[index];
        let x = &body.system.nodes.x;
        let fastest = list.iter().fold(0.0, |most: f64, obstacle| most.max(obstacle.fastest(x, time)));
        let speed = body.system.nodes.v.iter().fold(0.0, |most: f64, v| most.max(v.norm_squared())).sqrt();
        let reach = time.dt * (2.0 * speed + fastest + 2.0 * time.dt * self.plan.gravity.norm());
        let placed = list.iter().map(|obstacle| PlacedObstacle {
            surface: Arc::clone(&obstacle.surface),
            rotation: obstacle.rotation_at(time.start),
            position: obstacle.position_at(time.start),
            velocity: obstacle.velocity(time),
            spin: obstacle.spin(time),
            restitution: obstacle.restitution,
            friction: obstacle.friction,
        });
        let moved = std::mem::take(&mut self.obstacles.unseen[index]);
        if let Err(error) = contacts.place(body, placed, time.dt, [moved, reach]) {
            self.freeze(index, time.start, error.to_string());
        }
    }

    /// Moves the obstacles to the end of a step and sums the forces on them.
    pub(super) fn finish_obstacles(&mut self, time: StepTime) {
        let list = &self.obstacles.list;
        for ((unseen, moved), body) in self.obstacles.unseen.iter_mut().zip(&self.moved).zip(&self.bodies) {
            let x = &body.system.nodes.x;
            let fastest = list.iter().fold(0.0, |most: f64, obstacle| most.max(obstacle.fastest(x, time)));
            *unseen += moved + time.dt * fastest;
        }
        for (at, obstacle) in self.obstacles.list.iter_mut().enumerate() {
            let end = time.end();
            (obstacle.position, obstacle.rotation) = (obstacle.position_at(end), obstacle.rotation_at(end));
            (obstacle.force, obstacle.friction_work) = (Vec3::zeros(), 0.0);
            for (contacts, body) in self.obstacles.contacts.iter().zip(&self.bodies) {
                if body.frozen.is_none()
                    && let (Some(force), Some(work)) = (contacts.force.get(at), contacts.friction_work.get(at))
                {
                    obstacle.force += force;
                    obstacle.friction_work += work;
                }
            }
            self.obstacles.pushes[at] += u64::from(obstacle.force != Vec3::zeros());
        }
    }

    /// Warnings about obstacles that are found when a scene is opened.
    pub(super) fn find_obstacle_warnings(&self) -> Vec<Warning> {
        let mut found = Vec::new();
        for (body, (obstacle, place)) in self
            .bodies
            .iter()
            .flat_map(|body| self.obstacles.list.iter().zip(&self.obstacles.places).map(move |of| (body, of)))
        {
            let texts = [
                (WarningCode::StartsInside, starts_inside(body, obstacle)),
                (WarningCode::CoarseSheet, is_coarse(body, obstacle)),
            ];
            found.extend(
                texts
                    .into_iter()
                    .filter_map(|(code, text)| Some(Warning { code, place: place.clone(), message: text? })),
            );
        }
        found
    }

    /// Warnings about obstacles that no body has met, once the session was stepped.
    pub(super) fn unmet_obstacles(&self) -> impl Iterator<Item = Warning> + '_ {
        let each = self.obstacles.list.iter().zip(&self.obstacles.places).zip(&self.obstacles.pushes);
        each.filter(|(_, pushes)| self.steps() > 0 && **pushes == 0).map(|((obstacle, place), _)| Warning {
            code: WarningCode::MeetsNothing,
            place: place.clone(),
            message: format!(
                "no body met obstacle `{}` in {} steps; move it into the way of one, or leave it out (a body with a local region meets it only \
                 where cells around a tool are simulated)",
                obstacle.name,
                self.steps()
            ),
        })
    }
}

/// The text of a warning if vertices of a body start inside of an obstacle.
fn starts_inside(body: &Body, obstacle: &Obstacle) -> Option<String> {
    let [low, high] = obstacle.bounds_at(obstacle.position, obstacle.rotation);
    let near = |p: &&Vec3| (0..3).all(|c| low[c] <= p[c] && p[c] <= high[c]);
    let depths = body.model.surface.points.iter().filter(near).map(|p| -obstacle.distance(*p));
    let inside = depths.filter(|depth| *depth > INSIDE * body.discretization.edge());
    let (count, deepest) = inside.fold((0, 0.0_f64), |(count, most), depth| (count + 1, most.max(depth)));
    (count > 0).then(|| {
        format!(
            "body `{}` starts inside of obstacle `{}`: {count} of its vertices, up to {:.3} mm deep, which are pushed out; move one of the two",
            body.name,
            obstacle.name,
            1e3 * deepest
        )
    })
}

/// The text of a warning if the vertices of a sheet are too sparse for an obstacle.
fn is_coarse(body: &Body, obstacle: &Obstacle) -> Option<String> {
    let (edge, feature) = (body.discretization.edge(), obstacle.surface.feature_size());
    (body.discretization.sheet().is_some() && edge > feature).then(|| {
        format!(
            "the edges of sheet `{}` are {:.3} mm long and obstacle `{}` has a size of {:.3} mm: vertices meet obstacles, and the triangles \
             between them can cut through; use a finer sheet",
            body.name,
            1e3 * edge,
            obstacle.name,
            1e3 * feature
        )
    })
}
