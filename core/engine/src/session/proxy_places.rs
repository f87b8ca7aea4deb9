//! Where tools touch, so that they go on touching there: after an undo, and in a session that takes the hands of another over.
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

/// Where the proxy of a tool is when its next edit begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Begin {
    /// Position of the proxy, m.
    position: Vec3,
    /// Position of the hand when this was asked for, m.
    hand: Vec3,
    /// Path of the hand until which it holds, m: from there the hand may have come out of the body.
    nearness: f64,
}

/// Largest number of surfaces that lie above a proxy, one in the other.
const MAX_SURFACES: usize = 8;

impl Session {
    /// The proxies that surfaces keep from their hands, in the order of the tools.
    pub fn touching_proxies(&self) -> Vec<TouchingProxy> {
        self.tools.iter().filter_map(ToolSlot::touching_proxy).collect()
    }

    /// Has the next edit of each tool with one of these names begin where the proxy is, and not at the hand, unless the hand has moved by then as far as it was
    /// from the proxy. A proxy that is inside of a solid now begins outside of it, along its normal. Proxies of tools that the session does not have are left out.
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

    /// Has the edit that begins now start where [`Session::resume_touching`] has asked for, if it has.
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

/// Distance (m) from a point to the first triangle of a body along a unit vector, and whether that is met from inside of the body.
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
