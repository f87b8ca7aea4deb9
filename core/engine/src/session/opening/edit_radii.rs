//! Warnings about edits whose radius the cells of a body are too wide for.

use crate::body::Body;
use crate::edit::MIN_RADIUS_EDGES;
use crate::session::Session;
use crate::session::warning::{Warning, WarningCode};

impl Session {
    /// A warning for each edit of the scene whose `radius` is below the least radius on every body: which of them it will meet is not known. A default
    /// radius is not warned of: it asks for nothing.
    pub(super) fn find_radius_warnings(&self) -> Vec<Warning> {
        let mut found: Vec<Warning> = Vec::new();
        for edit in &self.plan.edits {
            let Some(radius) = edit.radius else { continue };
            let edge = |body: &Body| body.discretization.edge();
            let Some(body) = self.bodies.iter().min_by(|a, b| edge(a).total_cmp(&edge(b))) else { continue };
            let (edge, least) = (edge(body), MIN_RADIUS_EDGES * edge(body));
            // Mirrored hands have the edit of their original.
            if radius >= least || found.iter().any(|known| known.place == edit.place) {
                continue;
            }
            let (what, remedy) = match body.discretization.lattice() {
                Some(lattice) if lattice.source.plugin().is_some() => ("cells", "a finer `level`"),
                _ => ("edges", "a finer mesh"),
            };
            let message = format!(
                "the {} has a radius of {:.3} mm, and body `{}` has {what} of {:.3} mm, on which an edit acts within {:.3} mm at least; give the \
                 body {remedy}, or the edit a larger `radius`",
                edit.kind.name(),
                1e3 * radius,
                body.name,
                1e3 * edge,
                1e3 * least
            );
            found.push(Warning { code: WarningCode::SmallRadius, place: edit.place.clone(), message });
        }
        found
    }
}
