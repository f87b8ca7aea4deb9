//! Opening of a tool: its shape, its coupling to a device, its limits of force and its blade.

use super::Opening;
use crate::contact::{Friction, LayerLaw};
use crate::edit::BladeEdge;
use crate::plan::Plan;
use crate::scene::{BladeScene, Scene, ToolScene};
use crate::session::step::TORQUE_AXES;
use crate::session::{DeviceSlot, SessionError, ToolSlot, place};
use crate::tool::{Coupling, ForceLimits, ForceSafety, Hand, TactilePad, TipMass, Tool, TorqueSafety};
use pliant_mesh::geometry::Vec3;
use std::sync::Arc;

/// Default stiffness of a coupling, as a fraction of the device's largest stiffness.
const COUPLING_SHARE: f64 = 0.3;

impl Opening<'_> {
    /// Opens the tools of a plan, which meet this number of `bodies`.
    pub(super) fn tools(
        &mut self,
        scene: &Scene,
        plan: &Plan,
        devices: &[DeviceSlot],
        bodies: usize,
    ) -> Result<Vec<ToolSlot>, SessionError> {
        let mut tools = Vec::with_capacity(plan.tools.len());
        for (at, &tool) in plan.tools.iter().enumerate() {
            let slot = self.tool(&scene.tool[tool], devices, scene, plan, bodies)?;
            tools.push(ToolSlot { has_torque: plan.has_torque(at), ..slot });
        }
        Ok(tools)
    }

    /// Opens a tool that meets this number of `bodies`.
    fn tool(
        &mut self,
        scene: &ToolScene,
        devices: &[DeviceSlot],
        whole: &Scene,
        plan: &Plan,
        bodies: usize,
    ) -> Result<ToolSlot, SessionError> {
        let of = |d: &usize| whole.device[*d].name.get_ref() == scene.device.get_ref();
        let device = plan.devices.iter().position(of).expect("the plan opens the device of every tool in use");
        let facts = devices[device].facts;
        let effector = scene.effector.as_ref().map_or(0, |e| *e.get_ref());
        if effector >= facts.effectors {
            let span = scene.effector.as_ref().map_or(0..0, |e| e.span());
            let text =
                format!("effector {effector}, from 0; allowed is below {}, as many as the device has", facts.effectors);
            return Err(self.source.error(span, text).into());
        }
        let coupling = Coupling {
            stiffness: scene.stiffness.as_ref().map_or(COUPLING_SHARE * facts.stiffness, |k| k.get_ref().si),
            damping: scene.damping.as_ref().map_or(0.0, |b| b.get_ref().si),
            max_force: facts.peak_force,
        };
        let restitution = scene.restitution.as_ref().map_or(0.0, |e| *e.get_ref());
        let [static_coefficient, kinetic_coefficient] = *scene.friction.get_ref();
        let friction = Friction { static_coefficient, kinetic_coefficient };
        let name = scene.name.get_ref().clone();
        let mut tool = Tool::new(name, place::shape(scene, self.source)?, friction, coupling, bodies);
        tool.blade = scene.blade.as_ref().filter(|_| plan.cuts()).map(|blade| edge(blade.get_ref()));
        let law = scene.contact_law.as_ref().map(|law| self.contact_law(law.get_ref())).transpose()?;
        tool.law = law.as_ref().map(|law| LayerLaw::new(Arc::clone(law)));
        let limits =
            ForceLimits { peak: facts.peak_force, continuous: facts.continuous_force, slew: scene.slew.get_ref().si };
        let has_torque = facts.driven_axes >= TORQUE_AXES;
        Ok(ToolSlot {
            tool,
            hand: Hand::new(scene.speed.get_ref().si),
            safety: ForceSafety::new(limits),
            torque_safety: has_torque.then(|| TorqueSafety::new(facts.peak_torque, limits)).flatten(),
            pad: TactilePad::of(&facts),
            slid_from: None,
            device,
            effector: effector as usize,
            mirror: None,
            cuts_the_same: false,
            has_torque: false,
            edit: None,
            soft: (0..bodies).map(|_| None).collect(),
            law,
            restitution,
            ongoing: Default::default(),
            taken_back: None,
            begins_at: None,
            advances: 0,
            has_tied: false,
            is_stitch_refused: false,
            has_lost_grip: false,
            was: None,
            turned: None,
            tip: scene.mass.as_ref().map(|mass| TipMass::new(mass.get_ref().si)),
            hand_was: None,
            on_sheets: Vec3::zeros(),
            drift: Vec3::zeros(),
        })
    }
}

/// The blade of a tool.
fn edge(blade: &BladeScene) -> BladeEdge {
    BladeEdge {
        length: blade.length.get_ref().si,
        direction: Vec3::from(*blade.direction.get_ref()).normalize(),
        toughness: blade.toughness.get_ref().si,
        tear: blade.tear.get_ref().si,
    }
}
