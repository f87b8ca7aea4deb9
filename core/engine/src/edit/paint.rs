//! Paint: a parameter of the material goes to a factor of itself where the tool touches.
//!
//! The factor moves by at most one octave in [`OCTAVE_TIME`], times the falloff, so a hand that presses feels the body stiffen without a jump.

use super::brush::BrushShape;
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::touch_stroke::{Due, TouchStroke};
use super::{Action, BodyPoint, EditKind, Step};
use crate::body::{EmbeddedPoint, FactorChange, LatticeError};
use crate::plan::Edit;
use crate::tool::Tool;

/// Changes a parameter of the material where the tool touches.
pub(super) struct Paint;

/// Default factor.
const FACTOR: f64 = 4.0;
/// Factors that may be painted, as those of `[[body.field]]`.
const RANGE: [f64; 2] = [0.1, 10.0];
/// Default parameter.
const PARAM: &str = "young";
/// Time in which the factor doubles or halves at the centre of the brush, s.
const OCTAVE_TIME: f64 = 0.05;

impl EditKind for Paint {
    fn name(&self) -> &'static str {
        "paint"
    }

    fn summary(&self) -> &'static str {
        "Change a parameter of the material where the tool touches: stiffness, density or thickness."
    }

    fn keys(&self) -> &'static [Key] {
        &[
            RADIUS,
            FALLOFF,
            Key { name: KeyName::Strength, default: "4", summary: "Factor of the parameter to reach, 0.1 to 10." },
            Key {
                name: KeyName::Param,
                default: "young",
                summary: "Parameter of the material that is painted, one that may vary over a body.",
            },
        ]
    }

    fn strength(&self) -> Option<Strength> {
        Some(Strength { unit: "", default: FACTOR, range: Some(RANGE) })
    }

    fn param(&self) -> Option<&'static str> {
        Some(PARAM)
    }

    fn changes_body(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        Box::new(Painting {
            shape: BrushShape::of(edit, tool),
            param: edit.param.clone().unwrap_or_else(|| PARAM.into()),
            factor: edit.strength.unwrap_or(FACTOR),
            refused_by: None,
            stroke: TouchStroke::new(),
        })
    }
}

/// A stroke that paints a parameter.
struct Painting {
    shape: BrushShape,
    /// Key of the parameter.
    param: String,
    /// Factor to reach.
    factor: f64,
    /// Body whose material has refused the parameter.
    refused_by: Option<u32>,
    stroke: TouchStroke,
}

impl Action for Painting {
    fn contact(&self, tool: &Tool) -> Option<BodyPoint> {
        self.stroke.contact(tool)
    }

    fn extra_region_radius(&self, edge: f64) -> f64 {
        self.shape.radius_at(edge)
    }

    fn is_fingertip(&self) -> bool {
        true
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPoint>,
    ) -> Result<(), LatticeError> {
        let Some(Due { at, seconds }) = self.stroke.follow(tool, step, contact)? else { return Ok(()) };
        let body = &mut step.bodies[at.body as usize];
        let Some(plane) = body.params.iter().position(|key| *key == self.param) else {
            if self.refused_by.replace(at.body) != Some(at.body) {
                tool.refused_param = Some((at.body, self.param.clone()));
            }
            return Ok(());
        };
        let octaves = seconds / OCTAVE_TIME;
        let change = FactorChange { plane, goal: self.factor, octaves };
        tool.changed_body |= body.paint(at.rest, self.shape, change)?;
        Ok(())
    }
}
