//! Cut: the tool's blade cuts bodies.

mod body_stroke;
mod cut_step;
mod detour;
mod kept_shape;
mod knife;
mod middle;
mod rest_blade;
mod sheet_intersection;
mod slit;
mod stroke_end;
mod sweep;
mod swept_area;

pub use cut_step::{CutAgain, CutStep, HeldBody};
pub use knife::{BladeEdge, STRIDE};

use super::{Action, ActiveBall, BodyPoint, EditKind, Key, KeyName, Step};
use crate::body::{Body, EmbeddedPoint, LatticeError};
use crate::plan::Edit;
use crate::tool::{Hand, Tool, diagonal};
use knife::Knife;
use pliant_solver::Vec3;
use rest_blade::SAMPLES;
use schemars::JsonSchema;
use serde::Deserialize;

/// Cuts with a tool that has a blade.
pub(super) struct Cut;

/// Which layers of a sheet a blade cuts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SheetLayers {
    /// The one that it met first, as it moves and against the cutting resistance.
    #[default]
    One,
    /// All that it has swept since the edit began, when that ends: in the shape that the sheet has then, and without resistance.
    All,
}

impl EditKind for Cut {
    fn name(&self) -> &'static str {
        "cut"
    }

    fn summary(&self) -> &'static str {
        "Cut with a tool that has a blade."
    }

    fn keys(&self) -> &'static [Key] {
        &[
            Key {
                name: KeyName::Split,
                default: "false",
                summary: "Whether the parts of what it has cut become bodies of their own at its end.",
            },
            Key {
                name: KeyName::SheetLayers,
                default: "one",
                summary: "SheetLayers of a sheet that it cuts: `one` as the blade moves, against resistance; `all` that it has swept, at its end.",
            },
        ]
    }

    fn cuts(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, bodies: usize) -> Box<dyn Action> {
        let edge = tool.blade.clone().expect("the plan refuses a cut without a blade");
        Box::new(Cutting { knife: Knife::new(edge, bodies, edit.sheet_layers) })
    }
}

/// What of a blade is in a body.
pub struct EdgeInside {
    /// Index of the body.
    pub body: u32,
    /// Ends of its edge there, in the rest shape, m.
    pub ends: [Vec3; 2],
    /// Unit vector of the cutting direction; `None` before the first cut.
    pub heading: Option<Vec3>,
}

/// A cut in progress.
struct Cutting {
    knife: Knife,
}

impl Action for Cutting {
    fn contact(&self, _tool: &Tool) -> Option<BodyPoint> {
        self.knife.inside.as_ref().map(|inside| BodyPoint { body: inside.body, rest: inside.points[0] })
    }

    fn active_ball(&self, _tool: &Tool) -> Option<ActiveBall> {
        let inside = self.knife.inside.as_ref()?;
        let (low, high) = (inside.points[0], inside.points[inside.points.len() - 1]);
        let span = high - low;
        Some(ActiveBall { body: inside.body, centre: low + 0.5 * span, extra_radius: 0.5 * span.norm() })
    }

    fn edge_inside(&self) -> Option<EdgeInside> {
        let inside = self.knife.inside.as_ref()?;
        let ends = [inside.points[0], inside.points[inside.points.len() - 1]];
        Some(EdgeInside { body: inside.body, ends, heading: self.knife.heading })
    }

    fn cut(&mut self, tool: &Tool, hand: &Hand, bodies: &mut [Body], last: bool) -> Result<CutStep, LatticeError> {
        let mut step = CutStep::default();
        if hand.present {
            step = self.knife.cut(hand, tool.coupling.stiffness, bodies, last)?;
        }
        if last {
            self.knife.cut_layers(bodies, &mut step)?;
        }
        Ok(step)
    }

    /// Applies the pull of the hand to the body, evenly over the sample points of the edge that are inside of it.
    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        _contact: Option<EmbeddedPoint>,
    ) -> Result<(), LatticeError> {
        let knife = &self.knife;
        tool.proxy.position = knife.tip;
        let Some(inside) = &knife.inside else { return Ok(()) };
        tool.depth = knife.edge.length * inside.points.len() as f64 / SAMPLES as f64;
        let coupling = tool.coupling;
        let pulled = coupling.stiffness * (step.hand.position - knife.tip);
        if knife.resistance == 0.0 || pulled == Vec3::zeros() {
            return Ok(());
        }
        let fraction = 1.0 / inside.points.len() as f64;
        let body = &mut step.bodies[inside.body as usize];
        tool.loads.clear();
        let edge = body.discretization.edge();
        for point in &inside.points {
            let point = inside.ahead(*point, knife.heading, edge);
            let [stiffness, damping] = [coupling.stiffness, coupling.damping].map(|k| diagonal(fraction * k));
            tool.loads.push(point, fraction * pulled, stiffness, damping);
        }
        tool.attach_loads(body, inside.body)?;
        tool.limit_springs(body, inside.body, inside.points[0], pulled.norm())
    }

    fn release(&mut self) {
        self.knife.lift();
    }
}
