//! Rendering of a step's contacts on tactile arrays.

use super::Session;
use crate::plan::LeftOut;
use pliant_solver::Vec3;

impl Session {
    /// Enables recording of sheet contacts if a tool has a pad; otherwise lists tactile rendering among the parts left out.
    pub(super) fn open_pads(&mut self) {
        if self.tools.iter().all(|slot| slot.pad.is_none()) {
            if !self.tools.is_empty() {
                let (what, why) = ("tactile rendering".into(), "no device in use has taxels".into());
                self.plan.left_out.push(LeftOut { what, why });
            }
            return;
        }
        self.interactions.tips.iter_mut().for_each(|tips| tips.presses = Some(Vec::new()));
    }

    /// Renders the contacts of a tool on its pad. `force` (N) is the force on the tool by bodies that are not sheets.
    pub(super) fn show(&mut self, tool: usize, force: Vec3, dt: f64) {
        let tip = self.tools[tool].fingertip(dt);
        let Some(mut pad) = self.tools[tool].pad.take() else { return };
        let slot = &self.tools[tool];
        let (rotation, radius) = (slot.hand.rotation, slot.tool.proxy.shape.shape().length_scale());
        pad.begin();
        let (mut slip, mut total) = (Vec3::zeros(), 0.0);
        for press in self.interactions.presses(&self.tools, tool) {
            pad.press(&rotation, radius, press.direction, press.force);
            slip += press.force * press.slip;
            total += press.force;
        }
        for (soft, body) in slot.soft.iter().zip(&self.bodies) {
            let (Some(soft), Some(tip)) = (soft, &tip) else { continue };
            for (direction, size, past) in soft.presses(tip, &body.system.nodes) {
                pad.press(&rotation, radius, direction, size);
                slip += size * past;
                total += size;
            }
        }
        let touch = slot.tool.proxy.touch.filter(|_| !slot.tool.contact_directions.is_empty());
        let whole: Vec3 = slot.tool.contact_directions.iter().map(|(towards, share)| *share * *towards).sum();
        let size = whole.norm();
        if let Some(touch) = touch.filter(|_| size > 0.0) {
            let normal = (-force.dot(&whole) / size).max(0.0);
            for (towards, share) in &slot.tool.contact_directions {
                pad.press(&rotation, radius, *towards, share * normal);
            }
            // The contact moves over the rest shape, so the surface slips past the tip with the opposite velocity.
            let from = slot.slid_from.filter(|(body, _)| *body == touch.body).map_or(touch.rest, |(_, from)| from);
            slip += normal / dt * (from - touch.rest);
            total += normal;
        }
        let slip = if total > 0.0 { slip / total } else { Vec3::zeros() };
        pad.end(&rotation, slip, dt);
        let slot = &mut self.tools[tool];
        slot.slid_from = touch.map(|touch| (touch.body, touch.rest));
        slot.pad = Some(pad);
    }
}
