//! A tool of a session, with what a step keeps about it for the next one.

use super::hand_events::Ongoing;
use super::mirror::Mirror;
use super::proxy_places::Begin;
use crate::contact::SoftTip;
use crate::tool::{ForceSafety, Hand, TactilePad, TipMass, Tool, TorqueSafety};
use nalgebra::UnitQuaternion;
use pliant_host::ContactLaw;
use pliant_mesh::geometry::Vec3;
use std::sync::Arc;

/// A tool with its hand, device and force safety.
pub struct ToolSlot {
    /// State of the tool.
    pub tool: Tool,
    /// The hand that holds it.
    pub hand: Hand,
    /// Force safety of its effector.
    pub safety: ForceSafety,
    /// Safety of its torque; `None` for a device that does not state a peak torque.
    pub torque_safety: Option<TorqueSafety>,
    /// Its tactile pad, if its device has an array.
    pub pad: Option<TactilePad>,
    /// Last contact point in the rest shape of a body, m.
    pub(super) slid_from: Option<(u32, Vec3)>,
    /// Index of its device.
    pub device: usize,
    /// Index of the effector of that device.
    pub effector: usize,
    /// The mirror, if it is a mirrored tool.
    pub mirror: Option<Mirror>,
    /// Whether its blade would cut the same as that of its original, and rests.
    pub(super) cuts_the_same: bool,
    /// Whether the scene has an edit with it that renders torque.
    pub has_torque: bool,
    pub(super) edit: Option<usize>,
    /// For each body, its soft tip on that sheet; `None` if it uses contact constraints.
    pub(super) soft: Vec<Option<SoftTip>>,
    /// Its contact law, if the scene gives one.
    pub(super) law: Option<Arc<ContactLaw>>,
    pub(super) restitution: f64,
    /// Ongoing events of its hand.
    pub(super) ongoing: Ongoing,
    /// The edit that was active at an undo; it does not continue.
    pub(super) taken_back: Option<usize>,
    /// Where the proxy is when the next edit begins; `None`: at the hand.
    pub(super) begins_at: Option<Begin>,
    /// Number of advances of its blade in the active edit.
    pub(super) advances: usize,
    /// Whether the active edit has tied points of two bodies, and whether it has been said that it cannot.
    pub(super) has_tied: bool,
    pub(super) is_stitch_refused: bool,
    /// Whether the active edit has let go of a body because its force was over the limit.
    pub(super) has_lost_grip: bool,
    /// Previous position of the tool, m; `None` if it was absent.
    pub(super) was: Option<Vec3>,
    /// Previous rotation of its shape.
    pub(super) turned: Option<UnitQuaternion<f64>>,
    /// Its fingertip on sheets, if that has a mass.
    pub(super) tip: Option<TipMass>,
    /// Previous position of the hand of a tip with mass, m.
    pub(super) hand_was: Option<Vec3>,
    /// Force of sheets on the tip in the last step, N.
    pub(super) on_sheets: Vec3,
    /// Velocity of the contact surface, m/s.
    pub(super) drift: Vec3,
}

impl ToolSlot {
    /// Forgets what it knows of the nodes of a body, after a change of them.
    pub(super) fn body_changed(&mut self, body: usize) {
        self.tool.invalidate(body);
        self.soft[body].iter_mut().for_each(SoftTip::invalidate);
    }

    /// Adapts to other bodies, of which each is a part of the body of the scene in `roots`, or that body; those before number `kept` are as they were.
    pub(super) fn set_bodies(&mut self, roots: &[usize], kept: usize) {
        self.tool.resize_bodies(roots.len());
        self.soft.truncate(kept);
        for &root in &roots[kept..] {
            let soft = self.soft[root].as_ref().map(SoftTip::with_same_method);
            self.soft.push(soft);
        }
    }
}
