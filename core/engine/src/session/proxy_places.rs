//! Proxies of tools in contact, so that contacts go on after an undo, and in a session that takes over the hands of another one.
//!
//! A hand that presses is inside of the body, or beyond the sheet. A tool that began there would touch the surface from the wrong side.

use super::{Session, ToolSlot};
use crate::body::Body;
use pliant_mesh::geometry::meet;
use pliant_solver::Vec3;

/// The proxy of a tool that a surface keeps from its hand.
#[derive(Clone, Debug, PartialEq)]
pub struct TouchingProxy {
    /// Name of the tool.
    pub tool: String,
    /// Position of the proxy, m.
    pub position: Vec3,
    /// Unit contact normal, from the surface to the proxy.
    pub normal: Vec3,
    /// Position of the hand, m.
    pub hand: Vec3,
}

/// Initial position of the proxy of a tool in its next edit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Begin {
    /// Position of the proxy, m.
    position: Vec3,
    /// Position of the hand at the call of [`Session::resume_touching`], m.
    hand: Vec3,
    /// Largest displacement of the hand since then for which `position` is used, m: a hand that has moved farther may have left the body.
    nearness: f64,
}

/// Largest number of nested surfaces that enclose a proxy.
const MAX_SURFACES: usize = 8;

impl Session {
    /// The proxies that surfaces keep from their hands, in the order of the tools.
    pub fn touching_proxies(&self) -> Vec<TouchingProxy> {
        self.tools.iter().filter_map(ToolSlot::touching_proxy).collect()
    }

    /// Sets the position at which the next edit of each named tool begins: that of the proxy instead of that of the hand. If the hand has moved by then
    /// farther than its distance from the proxy, the edit begins at the hand. A proxy inside of a solid is first moved out of it along its normal. Proxies
    /// of tools that the session does not have are ignored.
    pub fn resume_touching(&mut self, proxies: &[TouchingProxy]) {
        for proxy in proxies {
            let Some(slot) = self.tools.iter_mut().find(|slot| slot.tool.name == proxy.tool) else { continue };
            let position = outside(&self.bodies, proxy, slot.tool.proxy.radius());
            let nearness = (position - proxy.hand).norm();
            slot.begins_at = Some(Begin { position, hand: proxy.hand, nearness });
        }
    }
}

impl ToolSlot {
    /// Where its proxy is while a surface keeps it from the hand.
    pub(super) fn touching_proxy(&self) -> Option<TouchingProxy> {
        let (position, normal) = match (&self.tool.proxy.touch, &self.tip) {
            (Some(touch), _) => (self.tool.proxy.position, touch.normal),
            (None, Some(tip)) => (tip.position, self.on_sheets.try_normalize(0.0)?),
            (None, None) => return None,
        };
        Some(TouchingProxy { tool: self.tool.name.clone(), position, normal, hand: self.hand.position })
    }

    /// Moves the proxy of an edit that begins now to the position that [`Session::resume_touching`] has set, if any.
    pub(super) fn begin_where_asked(&mut self) {
        if !self.hand.present || !self.tool.is_active() {
            return;
        }
        let Some(Begin { position, hand, nearness }) = self.begins_at.take() else { return };
        if (self.hand.position - hand).norm() > nearness {
            return;
        }
        self.tool.proxy.position = position;
        if let Some(tip) = &mut self.tip {
            tip.begin_at(position);
        }
    }
}

/// The position of a proxy, m, moved along its normal until no solid is around it.
fn outside(bodies: &[Body], proxy: &TouchingProxy, radius: f64) -> Vec3 {
    let mut position = proxy.position;
    for _ in 0..MAX_SURFACES {
        let above = bodies.iter().filter(|body| body.discretization.sheet().is_none());
        let first = above.filter_map(|body| first_above(body, position, proxy.normal));
        match first.min_by(|a, b| a.0.total_cmp(&b.0)) {
            // The inner side of a surface is seen.
            Some((distance, true)) => position += (distance + radius) * proxy.normal,
            _ => break,
        }
    }
    position
}

/// Distance (m) from a point to the first triangle of a body along a unit vector, and whether the ray leaves the body there.
fn first_above(body: &Body, from: Vec3, along: Vec3) -> Option<(f64, bool)> {
    let triangles = body.model.surface.triangles.iter().enumerate();
    let there = triangles.filter(|(index, _)| !body.failed_triangles.contains(*index as u32));
    let met = there.filter_map(|(_, corners)| {
        let [a, b, c] = corners.map(|v| body.skin.x[v as usize]);
        let (distance, _) = meet([a, b, c], from, along)?;
        Some((distance, (b - a).cross(&(c - a)).dot(&along) > 0.0))
    });
    met.min_by(|a, b| a.0.total_cmp(&b.0))
}
