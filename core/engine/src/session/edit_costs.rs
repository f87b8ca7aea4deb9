//! What a step of each edit of a scene costs, for `pliant plan`: the size of the region that it simulates, and the time of a step with so many elements.

use super::{Session, StepCost};
use crate::body::Body;
use crate::edit::CHANGE_INTERVAL;
use serde::Serialize;

/// Cost of a step of a body under an edit, estimated when the session was opened.
#[derive(Clone, Debug, Serialize)]
pub struct EditCost {
    /// Kind of the edit.
    pub edit: &'static str,
    /// Name of its tool.
    pub tool: String,
    /// Name of the body in the scene.
    pub body: String,
    /// Radius of the cells that are simulated for it, m; `None` where the whole body is.
    pub radius: Option<f64>,
    /// Number of active nodes and elements around one contact.
    pub nodes: usize,
    /// Number of active elements.
    pub elements: usize,
    /// Time of all substeps, s, as for [`StepCost::seconds`].
    pub seconds: f64,
    /// Time between two changes of the body, s, after each of which the rest data of all active elements are made anew; `None` for an edit that makes none while it is
    /// active.
    pub changes_every: Option<f64>,
}

/// Number of nodes and elements of a region of this radius.
#[derive(Clone, Copy, Debug)]
pub(super) struct RegionSize {
    /// Radius of the region, m.
    pub radius: f64,
    pub nodes: usize,
    pub elements: usize,
}

impl Session {
    /// Radius (m) of the cells that each edit of the plan simulates in a body, in the order of the plan.
    fn edit_radii(&self, body: &Body) -> Vec<f64> {
        let edge = body.discretization.edge();
        let radius = |edit: &crate::plan::Edit| {
            let tool = &self.tools[edit.tool].tool;
            let extra = match edit.kind.cuts() {
                true => 0.0,
                false => edit.kind.begin(edit, tool, self.bodies.len()).extra_region_radius(edge),
            };
            body.discretization.radius() + extra + tool.proxy.shape.extra_region_radius()
        };
        self.plan.edits.iter().map(radius).collect()
    }

    /// The different radii of regions that edits simulate in a body that is not simulated as a whole, m, ascending.
    pub(super) fn edit_regions(&self, body: &Body) -> Vec<f64> {
        if body.discretization.is_whole() {
            return Vec::new();
        }
        let mut radii = self.edit_radii(body);
        radii.sort_by(f64::total_cmp);
        radii.dedup();
        radii
    }

    /// Costs of all edits, from the cost of a step of each body and the sizes of their regions.
    pub(super) fn estimate_edits(&mut self, regions: &[Vec<RegionSize>]) {
        let mut costs = Vec::new();
        for ((body, regions), cost) in self.bodies.iter().zip(regions).zip(&self.motion.limits.costs) {
            for (edit, radius) in self.plan.edits.iter().zip(self.edit_radii(body)) {
                // The mirror images of an edit cost what it costs.
                if self.tools[edit.tool].mirror.is_some() {
                    continue;
                }
                let StepCost { nodes, elements, seconds, .. } = *cost;
                let region = regions.iter().find(|region| region.radius == radius);
                let size = region.copied().unwrap_or(RegionSize { radius, nodes, elements });
                costs.push(EditCost {
                    edit: edit.kind.name(),
                    tool: self.tools[edit.tool].tool.name.clone(),
                    body: body.name.clone(),
                    radius: Some(radius).filter(|radius| radius.is_finite()),
                    nodes: size.nodes,
                    elements: size.elements,
                    seconds: seconds * size.elements as f64 / elements.max(1) as f64,
                    changes_every: (edit.kind.changes_body() && !edit.kind.cuts()).then_some(CHANGE_INTERVAL),
                });
            }
        }
        self.motion.limits.edit_costs = costs;
    }

    /// Cost of a step of each body under each edit of the scene.
    pub fn edit_costs(&self) -> &[EditCost] {
        &self.motion.limits.edit_costs
    }
}
