//! A part of a sheet that becomes a body of its own: its nodes and elements keep their order, its triangles get new numbers.

use super::paint::SheetPaint;
use super::{NONE, Sheet, SheetState};
use crate::body::lattice::DrivenNode;
use crate::body::model::Model;
use std::sync::Arc;

/// A part of a sheet with its state.
pub(in crate::body) struct SheetPart {
    /// The sheet, without nodes.
    pub sheet: Sheet,
    /// Its state, to be restored.
    pub state: SheetState,
    /// New number of each node of the whole, or `u32::MAX` for one of another part (n).
    pub node_number: Vec<u32>,
}

impl Sheet {
    /// A part of the sheet of `model`, the whole. `owns` tells of each vertex whether it is in the part, `triangle` gives the triangles of the part their new
    /// numbers.
    pub(in crate::body) fn part(
        &self,
        model: &Model,
        owns: impl Fn(u32) -> bool,
        triangle: impl Fn(u32) -> Option<u32>,
    ) -> SheetPart {
        let has_ends = |ends: &[u32; 2]| ends.iter().all(|vertex| owns(*vertex));
        let of_nodes = self.vertex_of.iter().map(|vertex| owns(*vertex));
        let is_kept: Vec<bool> = of_nodes.chain(self.clamped.iter().map(has_ends)).collect();
        let mut node_number = vec![NONE; is_kept.len()];
        let kept = node_number.iter_mut().zip(&is_kept).filter(|(_, kept)| **kept);
        kept.zip(0..).for_each(|((number, _), new)| *number = new);
        let elements = self.material.chunks_exact(6).zip(&self.triangle_of);
        let material = elements.filter(|(_, t)| triangle(**t).is_some()).flat_map(|(of, _)| of.iter().copied());
        let driven = self.driven.iter().filter(|driven| is_kept[driven.node as usize]);
        let driven = driven.map(|driven| DrivenNode { node: node_number[driven.node as usize], ..*driven });
        let pins = self.paint.pins.iter().copied().filter(|vertex| owns(*vertex)).collect();
        let number = |t: u64| triangle(t as u32).map(u64::from);
        let factors = self.paint.factors.renumbered(number);
        let welds = self.welds.iter().filter(|(vertex, _)| owns(**vertex)).map(|(vertex, of)| (*vertex, *of));
        let state = SheetState {
            order: Arc::new(self.order.of_part(&model.surface, &owns, &triangle)),
            material: Arc::new(material.collect()),
            clamped: Arc::new(self.clamped.iter().copied().filter(has_ends).collect()),
            driven: driven.collect(),
            active: self.active,
            paint: SheetPaint { pins: Arc::new(pins), factors: Arc::new(factors) },
            welds: Arc::new(welds.collect()),
        };
        let mut sheet = Self::new(model, self.warp);
        sheet.edge = self.edge;
        (sheet.fields, sheet.stiffness) = (self.fields.clone(), self.stiffness);
        SheetPart { sheet, state, node_number }
    }
}
