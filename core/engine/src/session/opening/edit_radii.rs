//! Warnings about edits whose radius the cells of a body are too wide for.

use crate::edit::MIN_RADIUS_EDGES;
use crate::session::Session;
use crate::session::warning::{Warning, WarningCode};

impl Session {
    /// A warning for each edit of the scene whose `radius` is below the least radius on a body, with the first such body. A default radius is not
    /// warned of: it asks for nothing.
    pub(super) fn find_radius_warnings(&self) -> Vec<Warning> {
        let mut found: Vec<Warning> = Vec::new();
        for edit in &self.plan.edits {
            let Some(radius) = edit.radius else { continue };
            let least = |edge: f64| MIN_RADIUS_EDGES * edge;
            let coarse = self.bodies.iter().find(|body| radius < least(body.discretization.edge()));
            // Mirrored hands have the edit of their original.
            let Some(body) = coarse.filter(|_| found.iter().all(|known| known.place != edit.place)) else { continue };
            let edge = body.discretization.edge();
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
                1e3 * least(edge)
            );
            found.push(Warning { code: WarningCode::SmallRadius, place: edit.place.clone(), message });
        }
        found
    }
}
