//! The mesh of a body as arrays: what is seen of it, before and after cuts.

use super::failure::Failure;
use pliant_engine::body::{Body, Model};
use pliant_engine::session::Session;
use pliant_solver::Vec3;

/// A body of a session: one that moves, by its index, or one that only stands there.
pub enum Found<'a> {
    /// It moves.
    Moving(usize, &'a Body),
    /// It stands.
    Standing(&'a Model),
}

impl<'a> Found<'a> {
    /// The body of that name.
    pub fn named(session: &'a Session, name: &str) -> Result<Self, Failure> {
        if let Some((index, body)) = session.bodies.iter().enumerate().find(|(_, body)| body.name == name) {
            return Ok(Self::Moving(index, body));
        }
        if let Some((_, model)) = session.standing.iter().find(|(standing, _)| standing == name) {
            return Ok(Self::Standing(model));
        }
        let names: Vec<String> = names(session).map(|known| format!("`{known}`")).collect();
        Err(Failure::argument(format!("no body `{name}`; allowed is {}", names.join(", "))))
    }

    /// What does not change while it deforms.
    pub fn model(&self) -> &'a Model {
        match self {
            Self::Moving(_, body) => &body.model,
            Self::Standing(model) => model,
        }
    }

    /// m (n x 3), where its vertices are
    pub fn positions(&self) -> &'a [Vec3] {
        match self {
            Self::Moving(_, body) => &body.skin.x,
            Self::Standing(model) => &model.surface.points,
        }
    }

    /// Triangles that are seen, lids over holes and triangles that have torn left out.
    pub fn triangles(&self) -> impl Iterator<Item = u32> + 'a {
        let model = self.model();
        let failed = match self {
            Self::Moving(_, body) => Some(&body.failed_triangles),
            Self::Standing(_) => None,
        };
        let has_failed = move |triangle| failed.is_some_and(|failed| failed.contains(triangle));
        (0..model.surface.triangles.len() as u32).filter(move |t| !model.is_lid(*t) && !has_failed(*t))
    }
}

/// Names of the bodies, those that move first.
pub fn names(session: &Session) -> impl Iterator<Item = &str> {
    let moving = session.bodies.iter().map(|body| body.name.as_str());
    moving.chain(session.standing.iter().map(|(name, _)| name.as_str()))
}
