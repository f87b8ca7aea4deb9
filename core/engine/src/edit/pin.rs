//! Pin and unpin: nodes around the contact are held where they are, or freed.
//!
//! A pinned node keeps its present place: its velocity is zero, and what pulls at it goes nowhere. Its rest position and the forces of the body are
//! not changed, so a freed node starts from where it was held with the force that it was held against.

use super::brush::BrushShape;
use super::key::{Key, RADIUS};
use super::touch_stroke::{BodyChange, ChangingTouch, Due};
use super::{Action, EditKind, Falloff, Step};
use crate::body::LatticeError;
use crate::plan::Edit;
use crate::tool::Tool;

/// Pins or frees nodes where the tool touches.
pub(super) struct Pin {
    name: &'static str,
    summary: &'static str,
    /// The kind that does the opposite.
    opposite: &'static Self,
    /// Whether nodes are pinned, or else freed.
    pins: bool,
}

/// The edit kind `pin`: what the tool touches no longer moves.
pub(super) static PIN: Pin =
    Pin { name: "pin", summary: "Hold what the tool touches where it is.", opposite: &UNPIN, pins: true };
/// The edit kind `unpin`: what the tool touches moves again.
pub(super) static UNPIN: Pin =
    Pin { name: "unpin", summary: "Free what was pinned where the tool touches.", opposite: &PIN, pins: false };

impl EditKind for Pin {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn keys(&self) -> &'static [Key] {
        &[RADIUS]
    }

    fn changes_body(&self) -> bool {
        true
    }

    fn opposite(&self) -> Option<&'static dyn EditKind> {
        Some(self.opposite)
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        let shape = BrushShape { falloff: Falloff::Constant, ..BrushShape::of(edit, tool) };
        ChangingTouch::begin(shape, Pinning { pins: self.pins })
    }
}

/// Pins or frees nodes.
struct Pinning {
    pins: bool,
}

impl BodyChange for Pinning {
    fn change(
        &mut self,
        _tool: &mut Tool,
        step: &mut Step<'_>,
        shape: BrushShape,
        Due { at, .. }: Due,
    ) -> Result<bool, LatticeError> {
        let body = &mut step.bodies[at.body as usize];
        let radius = shape.radius_at(body.discretization.edge());
        if self.pins { body.pin(at.rest, radius) } else { body.unpin(at.rest, radius) }
    }
}
