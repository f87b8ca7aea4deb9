//! Paint: a parameter of the material goes to a factor of itself where the tool touches.
//!
//! The factor moves by at most one octave in [`OCTAVE_TIME`], times the falloff, so a hand that presses feels the body stiffen without a jump.

use super::brush::BrushShape;
use super::key::{FALLOFF, Key, KeyName, RADIUS, Strength};
use super::touch_stroke::{BodyChange, ChangingTouch, Due};
use super::{Action, EditKind, Step};
use crate::body::{FactorChange, LatticeError, PaintDepth};
use crate::plan::Edit;
use crate::tool::Tool;

/// Changes a parameter of the material where the tool touches.
pub(super) struct Paint;

/// Factor of the parameter that a stroke without `strength` goes to.
const FACTOR: f64 = 4.0;
/// Factors that may be painted, as those of `[[body.field]]`.
const RANGE: [f64; 2] = [0.1, 10.0];
/// Key of the parameter that a stroke without `param` paints.
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
            Key {
                name: KeyName::Depth,
                default: "through",
                summary: "How deep it paints: through, surface (the side that faces the tool), or the thickness of a layer below it.",
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
        let painting = Painting {
            param: edit.param.clone().unwrap_or_else(|| PARAM.into()),
            factor: edit.strength.unwrap_or(FACTOR),
            depth: edit.depth,
            refused_by: None,
        };
        ChangingTouch::begin(BrushShape::of(edit, tool), painting)
    }
}

/// Paints a parameter.
struct Painting {
    /// Key of the parameter.
    param: String,
    /// Factor to reach.
    factor: f64,
    depth: PaintDepth,
    /// Body whose material has refused the parameter.
    refused_by: Option<u32>,
}

impl BodyChange for Painting {
    fn change(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        shape: BrushShape,
        Due { at, seconds }: Due,
    ) -> Result<bool, LatticeError> {
        let body = &mut step.bodies[at.body as usize];
        let Some(plane) = body.params.iter().position(|key| *key == self.param) else {
            if self.refused_by.replace(at.body) != Some(at.body) {
                tool.refused_param = Some((at.body, self.param.clone()));
            }
            return Ok(false);
        };
        let octaves = seconds / OCTAVE_TIME;
        body.paint(at.rest, shape, self.depth, FactorChange { plane, goal: self.factor, octaves })
    }
}
