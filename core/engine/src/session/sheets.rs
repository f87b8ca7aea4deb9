//! Contact of tools with sheets: the choice of method, and the tips of a step.

use super::interactions::Interactions;
use super::step::freeze_body;
use super::{ContactChoice, Session, ToolSlot};
use crate::body::Body;
use crate::contact::{Press, SheetTips, SoftMethod, SoftPress, SoftTip, Tip};
use crate::scene::{Scene, SheetContact};
use pliant_solver::{StepTime, Vec3};
use std::sync::Arc;

/// Largest ratio of a sheet's edge to the feature size of a tip for which vertices are dense enough for constraints.
const MAX_EDGE_RATIO: f64 = 1.0;

impl Session {
    /// Chooses the contact method of each tool on each sheet.
    pub(super) fn meet(&mut self, scene: &Scene) {
        for slot in &mut self.tools {
            let of_tool = scene.tool.iter().find(|t| *t.name.get_ref() == slot.tool.name);
            let wanted = of_tool.and_then(|t| t.sheets.as_ref()).map(|sheets| *sheets.get_ref());
            for (index, body) in self.bodies.iter().enumerate() {
                let Some(sheet) = body.discretization.sheet() else { continue };
                let edge_ratio = sheet.edge() / slot.tool.proxy.shape.shape().feature_size();
                let fits = if edge_ratio <= MAX_EDGE_RATIO { SheetContact::Vertices } else { SheetContact::Triangles };
                if let Some(law) = &slot.law {
                    slot.soft[index] = Some(SoftTip::with_law(Arc::clone(law)));
                    let why = "a contact law acts at vertices".into();
                    let (tool, body, law) = (slot.tool.name.clone(), body.name.clone(), Some(law.info().id.clone()));
                    self.choices.contacts.push(ContactChoice { tool, body, by: "penalty", law, why });
                    continue;
                }
                let (by, meets) = match wanted.unwrap_or(fits) {
                    SheetContact::Vertices => ("vertices", None),
                    SheetContact::Triangles => ("triangles", Some(SoftMethod::AugmentedLagrangian)),
                    SheetContact::Penalty => ("penalty", Some(SoftMethod::Penalty)),
                };
                slot.soft[index] = meets.map(SoftTip::new);
                let why = match wanted {
                    Some(_) => String::new(),
                    None => {
                        format!(
                            "an edge is {edge_ratio:.2} of the tip's smallest dimension; constraints at vertices are used up to {MAX_EDGE_RATIO}"
                        )
                    }
                };
                let (tool, body) = (slot.tool.name.clone(), body.name.clone());
                self.choices.contacts.push(ContactChoice { tool, body, by, law: None, why });
            }
        }
    }

    /// Computes the contact forces of soft tips in a step that starts at `start` (s).
    pub(super) fn press_sheets(&mut self, start: f64) {
        let time = StepTime { start, dt: self.clock.dt };
        let is_explicit = !self.motion.is_implicit();
        let touching = self.tools.iter().filter(|slot| slot.touches()).count();
        for slot in &mut self.tools {
            let tip = slot.fingertip(self.clock.dt);
            for (index, body) in self.bodies.iter_mut().enumerate() {
                let (Some(soft), Some(sheet)) = (&mut slot.soft[index], body.discretization.sheet()) else { continue };
                let Some(tip) = tip.as_ref().filter(|_| body.frozen.is_none()) else {
                    soft.leave();
                    continue;
                };
                let count = body.model.surface.triangles.len() as u32;
                let triangles = |t| (!body.failed_triangles.contains(t)).then(|| sheet.nodes_of(&body.model, t));
                let press = SoftPress {
                    stiffness: slot.tool.coupling.stiffness,
                    moved: self.motion.moved[index],
                    time,
                    is_explicit,
                };
                if let Some(areas) = soft.outdated_areas() {
                    areas.resize(body.system.nodes.len(), 0.0);
                    sheet.add_node_areas(&body.model, &body.failed_triangles, areas);
                }
                soft.keeps_multipliers = touching == 1;
                let springs = slot.tool.springs_mut(index);
                if let Err(error) = soft.press(tip, triangles, count, &body.system.nodes, press, springs) {
                    soft.leave();
                    freeze_body(body, &mut self.events, start, error.to_string());
                }
            }
        }
    }

    /// Updates the histories of contact laws after the bodies have moved in a step.
    pub(super) fn advance_contact_laws(&mut self, time: StepTime) {
        for slot in self.tools.iter_mut().filter(|slot| slot.law.is_some()) {
            for (soft, body) in slot.soft.iter_mut().zip(&mut self.bodies) {
                let Some(soft) = soft.as_mut().filter(|_| body.frozen.is_none()) else { continue };
                if let Err(error) = soft.advance_law(&body.system.nodes, time) {
                    soft.leave();
                    freeze_body(body, &mut self.events, time.start, error.to_string());
                }
            }
        }
    }
}

impl Interactions {
    /// Sets the tips of the touching tools on a sheet for a step of `dt` (s); `moved` is the largest displacement of a node of the sheet in the last one, m.
    pub(super) fn place_tips(&mut self, index: usize, body: &Body, tools: &[ToolSlot], moved: f64, dt: f64) {
        if body.discretization.sheet().is_none() {
            return;
        }
        let tips = &mut self.tips[index];
        tips.set_loose_nodes(body.failed_triangles.loose_nodes());
        tips.tips.clear();
        tips.friction_work = 0.0;
        tips.moved = moved;
        tips.is_pressed = tools.iter().any(|slot| slot.soft[index].as_ref().is_some_and(|soft| soft.contacts() > 0));
        tips.tips.extend(tools.iter().filter_map(|slot| {
            let constrains = slot.soft[index].is_none();
            slot.fingertip(dt).map(|tip| Tip { constrains, ..tip })
        }));
        tips.forget_lost_contacts();
        for (tool, slot) in tools.iter().enumerate() {
            let (Some(place), Some(tip)) = (place_of_tip(tools, tool), &slot.tip) else { continue };
            let of_others = |(other, tips): (usize, &SheetTips)| {
                tips.tips.get(place).filter(|_| other != index).map_or(Vec3::zeros(), |tip| tip.force)
            };
            let others = self.tips.iter().enumerate().map(of_others).sum();
            self.tips[index].tips[place].response = tip.response(others, dt);
        }
    }

    /// Moves tips with a mass as the step of `dt` (s) of a sheet has found that they move.
    pub(super) fn return_tips(&self, index: usize, tools: &mut [ToolSlot], dt: f64) {
        for tool in 0..tools.len() {
            let found = place_of_tip(tools, tool).and_then(|place| self.tips[index].tips.get(place));
            let Some((end, Some(force))) = found.map(|tip| (tip.position, tip.implicit_force)) else { continue };
            let slot = &mut tools[tool];
            if let (Some(tip), None) = (&mut slot.tip, slot.tool.proxy.touch) {
                tip.apply_implicit_force((end - slot.tool.proxy.position) / dt, force, dt);
                slot.tool.proxy.position = end;
            }
        }
    }

    /// Energy dissipated by friction of sheets on tips, and of bodies on obstacles, in the last step of `dt` (s), J.
    pub(super) fn friction_work(&self, bodies: &[Body], tools: &[ToolSlot], dt: f64) -> f64 {
        let mut sum = self.obstacles.friction_work();
        for (index, body) in bodies.iter().enumerate().filter(|(_, body)| body.frozen.is_none()) {
            sum += self.tips[index].friction_work;
            for slot in tools {
                if let (Some(soft), Some(tip)) = (&slot.soft[index], slot.fingertip(dt)) {
                    sum += soft.friction_work(&tip, &body.system.nodes, dt);
                }
            }
        }
        sum
    }

    /// Force of the sheets on a tool by contact constraints, N, and the index of the last sheet it touches.
    pub(super) fn sheet_contact_force(&self, tools: &[ToolSlot], tool: usize) -> (Vec3, Option<u32>) {
        let Some(place) = place_of_tip(tools, tool) else { return (Vec3::zeros(), None) };
        let (mut force, mut of) = (Vec3::zeros(), None);
        for (index, tips) in self.tips.iter().enumerate() {
            let soft = tools[tool].soft[index].as_ref().map_or(0, SoftTip::contacts);
            if let Some(tip) = tips.tips.get(place).filter(|tip| tip.constrained > 0 || soft > 0) {
                (force, of) = (force + tip.force, Some(index as u32));
            }
        }
        (force, of)
    }

    /// Contacts of a tool with sheets in the last step, where they are recorded.
    pub(super) fn presses(&self, tools: &[ToolSlot], tool: usize) -> impl Iterator<Item = &Press> {
        let of_place = |place| {
            let all = self.tips.iter().flat_map(|tips| tips.presses.iter().flatten());
            all.filter(move |press: &&Press| press.tip == place)
        };
        place_of_tip(tools, tool).into_iter().flat_map(of_place)
    }
}

/// Index of a tool's tip among the tips on sheets; `None` if it does not touch.
fn place_of_tip(tools: &[ToolSlot], tool: usize) -> Option<usize> {
    tools[tool].touches().then(|| tools[..tool].iter().filter(|slot| slot.touches()).count())
}

impl ToolSlot {
    /// Force of the sheets on it by its soft tips, N; part of its reaction.
    pub(super) fn soft_contact_force(&self, bodies: &[Body]) -> Vec3 {
        let each = self.soft.iter().zip(bodies).enumerate();
        each.filter(|(_, (soft, _))| soft.as_ref().is_some_and(|soft| soft.contacts() > 0)).fold(
            Vec3::zeros(),
            |sum, (i, (_, body))| {
                let nodes = &body.system.nodes;
                sum - self.tool.springs(i).total(&nodes.x, &nodes.v)
            },
        )
    }

    /// Whether its tool is a fingertip with a hand now.
    pub(super) fn touches(&self) -> bool {
        self.tool.is_fingertip() && self.hand.present
    }

    /// Angular velocity of its shape over a step of `dt` (s), rad/s, from the vector part of the rotation, which is valid for small angles.
    fn spin(&self, dt: f64) -> Vec3 {
        let turn = self.turned.map(|turned| self.tool.proxy.shape.rotation() * turned.inverse());
        turn.map_or(Vec3::zeros(), |turn| 2.0 / dt * turn.w.signum() * turn.imag())
    }

    /// Its fingertip at the end of a step of `dt` (s); `None` if it does not touch.
    pub(super) fn fingertip(&self, dt: f64) -> Option<Tip> {
        self.touches().then(|| {
            let position = self.tool.proxy.position;
            let velocity = self.was.map_or(Vec3::zeros(), |was| (position - was) / dt);
            let (shape, spin) = (self.tool.proxy.shape.clone(), self.spin(dt));
            let (friction, restitution) = (self.tool.friction, self.restitution);
            Tip {
                position,
                velocity,
                spin,
                shape,
                friction,
                restitution,
                constrains: true,
                response: None,
                implicit_force: None,
                force: Vec3::zeros(),
                constrained: 0,
            }
        })
    }
}
