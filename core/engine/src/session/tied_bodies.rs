//! The `[[stitch]]` entries of a scene: which points of two bodies are tied from the start.

use super::interactions::Interactions;
use super::ties::{CLOSING_TIME, tie_refusal, tie_spacing};
use super::{Session, SessionError};
use crate::body::Body;
use crate::contact::{StitchCandidate, StitchSearch, TiePoint};
use crate::scene::{Scene, SceneError, Source, StitchScene};
use toml::Spanned;

/// Displacement below which points are together, in edges.
const TOGETHER: f64 = 1e-9;

impl Session {
    /// Ties what the scene stitches together.
    ///
    /// # Errors
    /// An integrator without the solve that ties are a part of, vertices that a body does not have or that are not simulated, points that are too far apart, surfaces
    /// that are nowhere near each other.
    pub(super) fn open_stitches(&mut self, scene: &Scene, source: &Source) -> Result<(), SessionError> {
        for entry in &scene.stitch {
            let names = entry.get_ref().bodies.each_ref().map(|name| name.get_ref().as_str());
            let place = |name: &str| self.bodies.iter().position(|body| body.name == name);
            // A body that nothing moves stands, and so does what is stitched to it.
            let (Some(i), Some(j)) = (place(names[0]), place(names[1])) else { continue };
            if let Some(why) = tie_refusal(self.motion.limits.scheme, &self.bodies, [i, j]) {
                return Err(source.error(entry.span(), why).into());
            }
            let lattice = |error| SessionError::Lattice { body: names[0].to_owned(), error };
            let found = match &entry.get_ref().pairs {
                Some(pairs) => self.tied_vertices(pairs, [i, j], source)?,
                None => self.tied_surfaces(entry, [i, j], source)?,
            };
            let time = entry.get_ref().time.as_ref().map_or(0.0, |time| time.get_ref().si);
            let edge = [i, j].map(|index| self.bodies[index].discretization.edge());
            let edge = edge[0].min(edge[1]);
            let most = Body::join_distance(edge);
            let numbers = [i, j].map(|index| self.bodies[index].number);
            let Interactions { ties, body_contacts, .. } = &mut self.interactions;
            let collisions = body_contacts.collisions(self.bodies.len());
            for points in found {
                let gap = collisions.gap([i, j], points, &mut self.bodies).map_err(lattice)?;
                let Some(gap) = gap else {
                    let text = format!(
                        "vertices {} of body `{}` and {} of body `{}` are to be tied, and one of them is on no simulated part; allowed are \
                         vertices of the surface",
                        points[0].vertices[0], names[0], points[1].vertices[0], names[1]
                    );
                    return Err(source.error(entry.span(), text).into());
                };
                if time == 0.0 && gap.norm() > most {
                    let text = format!(
                        "points of bodies `{}` and `{}` that are to be tied are {:.4} m apart; allowed is up to {most:.4} m, a quarter of an edge, or \
                         a `time` in which they are drawn together",
                        names[0],
                        names[1],
                        gap.norm()
                    );
                    return Err(source.error(entry.span(), text).into());
                }
                let closed_at = match time {
                    0.0 if gap.norm() > TOGETHER * edge => CLOSING_TIME,
                    time => time,
                };
                ties.add(numbers, points, gap, closed_at);
            }
        }
        Ok(())
    }

    /// The points of pairs of vertices.
    fn tied_vertices(
        &self,
        pairs: &Spanned<Vec<[u32; 2]>>,
        bodies: [usize; 2],
        source: &Source,
    ) -> Result<Vec<[TiePoint; 2]>, SceneError> {
        let models = bodies.map(|index| &self.bodies[index].model);
        for pair in pairs.get_ref() {
            for (side, vertex) in pair.iter().enumerate() {
                let count = models[side].surface.points.len();
                let name = &self.bodies[bodies[side]].name;
                if *vertex as usize >= count || models[side].around(*vertex).is_empty() {
                    let text = format!(
                        "`pairs` has vertex {vertex} of body `{name}`; allowed is a vertex of a face, from 0 to {}",
                        count.saturating_sub(1)
                    );
                    return Err(source.error(pairs.span(), text));
                }
            }
        }
        Ok(pairs.get_ref().iter().map(|pair| pair.map(TiePoint::vertex)).collect())
    }

    /// Points of two surfaces that are nearer to each other than the `distance` of an entry.
    fn tied_surfaces(
        &mut self,
        entry: &Spanned<StitchScene>,
        bodies: [usize; 2],
        source: &Source,
    ) -> Result<Vec<[TiePoint; 2]>, SessionError> {
        let Some(distance) = &entry.get_ref().distance else { return Ok(Vec::new()) };
        let spacing = tie_spacing(&self.bodies, bodies);
        let reach = distance.get_ref().si;
        let names = bodies.map(|index| self.bodies[index].name.clone());
        let lattice = |error| SessionError::Lattice { body: names[0].clone(), error };
        let points = |found: Vec<StitchCandidate>| found.iter().map(|candidate| candidate.points).collect::<Vec<_>>();
        let found = self.find_stitches(bodies, StitchSearch { ball: None, reach, spacing }).map_err(lattice)?;
        if !found.is_empty() {
            return Ok(points(found));
        }
        let anywhere = StitchSearch { ball: None, reach: f64::MAX, spacing: 0.0 };
        let nearest = self.find_stitches(bodies, anywhere).map_err(lattice)?;
        let nearest = nearest.iter().map(|candidate| candidate.gap().norm()).fold(f64::INFINITY, f64::min);
        let where_ = match nearest.is_finite() {
            true => format!("points that face each other are at least {nearest:.4} m apart"),
            false => "no points face each other".to_owned(),
        };
        let text = format!(
            "`distance = {reach}` m ties nothing of bodies `{}` and `{}`: {where_}; allowed is a larger distance, or bodies nearer to each other",
            names[0], names[1]
        );
        Err(source.error(distance.span(), text).into())
    }
}
