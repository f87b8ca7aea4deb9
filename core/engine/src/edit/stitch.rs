//! Stitch: the sides of a cut, or two borders of a sheet, are drawn together where the tool touches, and grow together.
//!
//! While they are apart each pair of facing nodes is pulled together by equal and opposite springs, as a suture does; together they are as stiff as
//! the tool's coupling. A pair that is near enough becomes one node. Points of two bodies that face each other are tied by the session ([`StitchRequest`]).

use super::brush::BrushShape;
use super::key::{Key, RADIUS};
use super::touch_stroke::{Due, TouchStroke};
use super::{Action, BodyPoint, CutStep, EditKind, Falloff, Step, StitchRequest};
use crate::body::{Body, EmbeddedPoint, LatticeError};
use crate::contact::NodeSums;
use crate::plan::Edit;
use crate::tool::{Hand, Tool, diagonal};

/// Joins what faces each other where the tool touches.
pub(super) struct Stitch;

impl EditKind for Stitch {
    fn name(&self) -> &'static str {
        "stitch"
    }

    fn summary(&self) -> &'static str {
        "Draw the sides of a cut, two borders of a sheet, or two bodies together where the tool touches, and join them."
    }

    fn keys(&self) -> &'static [Key] {
        &[RADIUS]
    }

    fn changes_body(&self) -> bool {
        true
    }

    fn changes_topology(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        let shape = BrushShape { falloff: Falloff::Constant, ..BrushShape::of(edit, tool) };
        Box::new(Stitching {
            shape,
            suture: None,
            due: None,
            sums: NodeSums::default(),
            has_joined: false,
            stroke: TouchStroke::new(),
        })
    }
}

/// Pairs of nodes of a body that are drawn together.
struct Suture {
    body: u32,
    pairs: Vec<[u32; 2]>,
    /// Version of the body's node numbering for which the pairs are valid.
    numbering: u64,
}

/// A stroke that joins.
struct Stitching {
    shape: BrushShape,
    suture: Option<Suture>,
    /// Where the next step joins what is near enough.
    due: Option<BodyPoint>,
    /// Springs by node (buffer).
    sums: NodeSums,
    /// Whether it has joined nodes since the last step.
    has_joined: bool,
    stroke: TouchStroke,
}

impl Action for Stitching {
    fn contact(&self, tool: &Tool) -> Option<BodyPoint> {
        self.stroke.contact(tool)
    }

    fn extra_region_radius(&self, edge: f64) -> f64 {
        self.shape.radius_at(edge)
    }

    fn is_fingertip(&self) -> bool {
        true
    }

    fn stitch_request(&self, bodies: &[Body]) -> Option<StitchRequest> {
        let edge = |at: BodyPoint| bodies[at.body as usize].discretization.edge();
        self.due.map(|at| StitchRequest { at, radius: self.shape.radius_at(edge(at)) })
    }

    /// Joins before bodies move, for nodes get other numbers.
    fn cut(&mut self, tool: &Tool, _hand: &Hand, bodies: &mut [Body], last: bool) -> Result<CutStep, LatticeError> {
        let Some(at) = self.due.take().filter(|_| !last) else { return Ok(CutStep::default()) };
        let body = &mut bodies[at.body as usize];
        let radius = self.shape.radius_at(body.discretization.edge());
        let suture = body.stitch(at.rest, radius)?;
        self.has_joined |= suture.has_joined;
        self.suture = Some(Suture { body: at.body, pairs: suture.apart, numbering: tool.numbering(at.body) });
        Ok(CutStep::default())
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPoint>,
    ) -> Result<(), LatticeError> {
        if let Some(Due { at, .. }) = self.stroke.follow(tool, step, contact)? {
            self.due = Some(at);
        }
        tool.changed_body |= std::mem::take(&mut self.has_joined);
        let Some(Suture { body, pairs, numbering }) = &self.suture else { return Ok(()) };
        if *numbering != tool.numbering(*body) || pairs.is_empty() {
            self.suture = None;
            return Ok(());
        }
        let nodes = &step.bodies[*body as usize].system.nodes;
        let stiffness = tool.coupling.stiffness / pairs.len() as f64;
        let gap = |[a, b]: [u32; 2]| nodes.x[b as usize] - nodes.x[a as usize];
        let size: f64 = pairs.iter().map(|pair| stiffness * gap(*pair).norm()).sum();
        let share = tool.cap(size);
        let springs = tool.springs_mut(*body as usize);
        self.sums.begin(nodes.len());
        self.sums.add_all(springs);
        let (block, none) = (diagonal(0.5 * share * stiffness), [0.0; 9]);
        for &[a, b] in pairs {
            let force = 0.5 * share * stiffness * gap([a, b]);
            self.sums.add(a, 1.0, force, &block, &none);
            self.sums.add(b, 1.0, -force, &block, &none);
        }
        self.sums.drain_into(1.0, &nodes.x, springs);
        Ok(())
    }

    fn release(&mut self) {
        (self.suture, self.due) = (None, None);
    }
}
