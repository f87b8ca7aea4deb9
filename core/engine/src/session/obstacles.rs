//! Obstacles of a session: their surfaces, where they are, and their contact with bodies.

use super::{Session, Warning, WarningCode};
use crate::body::{Body, LatticeError};
use crate::contact::{ObstacleContacts, PlacedObstacle};
use crate::obstacle::{Obstacle, ObstacleSurface};
use pliant_solver::{Constraint, StepTime, Vec3};
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;

/// What a session knows about its obstacles.
#[derive(Default)]
pub(super) struct Obstacles {
    /// The obstacles, in the order of the scene.
    list: Vec<Obstacle>,
    /// Location of each in the scene.
    places: Vec<String>,
    /// Number of steps in which each pushed a body.
    pushes: Vec<u64>,
    /// Contacts of each moving body; empty without obstacles.
    contacts: Vec<ObstacleContacts>,
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

    /// Whether the scene has none.
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Adapts to another number of moving bodies.
    pub(super) fn resize(&mut self, bodies: usize) {
        let bodies = if self.list.is_empty() { 0 } else { bodies };
        self.contacts.resize_with(bodies, ObstacleContacts::new);
        self.unseen.resize(bodies, 0.0);
    }

    /// Forgets what follows from the surface of a body, after a change of it.
    pub(super) fn surface_changed(&mut self, body: usize) {
        self.contacts.iter_mut().skip(body).take(1).for_each(ObstacleContacts::invalidate);
    }

    /// Nodes of a body that obstacles hold, each with what it may still do.
    pub(super) fn held(&self, body: usize) -> impl Iterator<Item = (u32, Constraint)> + '_ {
        self.contacts.get(body).into_iter().flat_map(|contacts| contacts.held())
    }

    /// Contacts of a body in this step; `None` where no obstacle is near.
    pub(super) fn near_mut(&mut self, body: usize) -> Option<&mut ObstacleContacts> {
        self.contacts.get_mut(body).filter(|contacts| contacts.is_near())
    }

    /// Moves vertices of a body's surface that are inside of obstacles out of them.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn clear_skin(&self, index: usize, body: &mut Body) -> Result<(), LatticeError> {
        self.contacts.get(index).map_or(Ok(()), |contacts| contacts.clear_skin(body))
    }

    /// Whether an obstacle moves in a step near the box of a body, m.
    pub(super) fn come_near(&self, [low, high]: [Vec3; 2], reach: f64, time: StepTime) -> bool {
        self.list.iter().any(|obstacle| {
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

    /// Finds the points of a body that may meet an obstacle in a step under this gravity (m/s^2).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn place(
        &mut self,
        index: usize,
        body: &mut Body,
        gravity: Vec3,
        time: StepTime,
    ) -> Result<(), LatticeError> {
        let Some(contacts) = self.contacts.get_mut(index) else { return Ok(()) };
        let list = &self.list;
        let x = &body.system.nodes.x;
        let fastest = list.iter().fold(0.0, |most: f64, obstacle| most.max(obstacle.fastest(x, time)));
        let speed = body.system.nodes.v.iter().fold(0.0, |most: f64, v| most.max(v.norm_squared())).sqrt();
        let reach = time.dt * (2.0 * speed + fastest + 2.0 * time.dt * gravity.norm());
        let placed = list.iter().map(|obstacle| PlacedObstacle {
            surface: Arc::clone(&obstacle.surface),
            rotation: obstacle.rotation_at(time.start),
            position: obstacle.position_at(time.start),
            velocity: obstacle.velocity(time),
            spin: obstacle.spin(time),
            restitution: obstacle.restitution,
            friction: obstacle.friction,
        });
        contacts.place(body, placed, time.dt, std::mem::take(&mut self.unseen[index]), reach)
    }

    /// Moves the obstacles to the end of a step and sums the forces on them. `moved` is the largest displacement of a node of each body in the step, m.
    pub(super) fn finish_step(&mut self, bodies: &[Body], moved: &[f64], time: StepTime) {
        let list = &self.list;
        for ((unseen, moved), body) in self.unseen.iter_mut().zip(moved).zip(bodies) {
            let x = &body.system.nodes.x;
            let fastest = list.iter().fold(0.0, |most: f64, obstacle| most.max(obstacle.fastest(x, time)));
            *unseen += moved + time.dt * fastest;
        }
        for (at, obstacle) in self.list.iter_mut().enumerate() {
            let end = time.end();
            (obstacle.position, obstacle.rotation) = (obstacle.position_at(end), obstacle.rotation_at(end));
            (obstacle.force, obstacle.friction_work) = (Vec3::zeros(), 0.0);
            for (contacts, body) in self.contacts.iter().zip(bodies) {
                if body.frozen.is_none()
                    && let (Some(force), Some(work)) = (contacts.force.get(at), contacts.friction_work.get(at))
                {
                    obstacle.force += force;
                    obstacle.friction_work += work;
                }
            }
            self.pushes[at] += u64::from(obstacle.force != Vec3::zeros());
        }
    }

    /// Energy dissipated by friction of bodies on all obstacles in the last step, J.
    pub(super) fn friction_work(&self) -> f64 {
        self.list.iter().map(|obstacle| obstacle.friction_work).sum()
    }

    /// The obstacles for plans and summaries. The time of distances is measured at vertices of `bodies`.
    fn summaries(&self, bodies: &[Body]) -> Vec<ObstacleSummary> {
        let each = self.list.iter().map(|obstacle| {
            let triangles = match &*obstacle.surface {
                ObstacleSurface::Shape(..) => 0,
                ObstacleSurface::Mesh(mesh) => mesh.triangles(),
            };
            let (name, surface) = (obstacle.name.clone(), obstacle.kind.clone());
            let (moves, distance_seconds) = (obstacle.moves(), time_distances(obstacle, bodies));
            ObstacleSummary { name, surface, triangles, moves, distance_seconds }
        });
        each.collect()
    }

    /// Warnings about obstacles and bodies that are found when a scene is opened.
    pub(super) fn opening_warnings(&self, bodies: &[Body]) -> Vec<Warning> {
        let mut found = Vec::new();
        let each = bodies.iter().flat_map(|body| self.list.iter().zip(&self.places).map(move |of| (body, of)));
        for (body, (obstacle, place)) in each {
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

    /// Warnings about obstacles that no body has met in `steps` steps.
    pub(super) fn warn_unmet(&self, steps: u64) -> impl Iterator<Item = Warning> + '_ {
        let each = self.list.iter().zip(&self.places).zip(&self.pushes);
        each.filter(move |(_, pushes)| steps > 0 && **pushes == 0).map(move |((obstacle, place), _)| Warning {
            code: WarningCode::MeetsNothing,
            place: place.clone(),
            message: format!(
                "no body met obstacle `{}` in {steps} steps; move it into the way of one, or leave it out (a body with a local region meets it only \
                 where cells around a tool are simulated)",
                obstacle.name
            ),
        })
    }
}

impl Session {
    /// The obstacles, in the order of the scene.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.interactions.obstacles.list
    }

    /// The obstacles for plans and summaries.
    pub fn obstacle_summaries(&self) -> Vec<ObstacleSummary> {
        self.interactions.obstacles.summaries(&self.bodies)
    }
}

/// Wall-clock time of the distance of a vertex of `bodies` from an obstacle, s.
fn time_distances(obstacle: &Obstacle, bodies: &[Body]) -> f64 {
    let points = bodies.iter().flat_map(|body| &body.model.surface.points).take(TIMED_DISTANCES);
    let began = Instant::now();
    let (count, sum) = points.fold((0, 0.0), |(count, sum), p| (count + 1, sum + obstacle.distance(*p)));
    std::hint::black_box(sum);
    began.elapsed().as_secs_f64() / f64::from(count.max(1))
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
