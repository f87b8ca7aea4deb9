//! One step: hands, edits, regions, contact, integration, reaction, coupling, force safety, devices. Data flows in this order; no stage calls an
//! earlier one.

use super::event::{EventKind, Events};
use super::frame::{Frame, ToolFrame};
use super::hand_events::{SafetyPass, add_limit_event, add_safety_events};
use super::interactions::Interactions;
use super::motion::Motion;
use super::{Session, Stage};
use crate::body::{Body, LatticeError};
use crate::contact::SoftTip;
use crate::edit::Step;
use crate::tool::{Cause, Tool, TorqueSafety};
use pliant_solver::{Frequencies, Interrupts, Loads, StepError, StepReport, StepTime, Vec3};
use std::time::{Duration, Instant};

/// Number of driven axes of a device that renders torque.
pub(super) const TORQUE_AXES: u32 = 6;
/// Why a body was not moved.
enum NotMoved {
    /// The session was stopped; the body is where it was.
    Cancelled,
    /// The step took longer than the scene's `patience`; the body is where it was.
    TimedOut,
    /// What failed, in words.
    Failed(String),
}

impl Session {
    /// All stages between reading the devices and writing to them.
    pub(super) fn advance(&mut self) {
        let start = Instant::now();
        let time = StepTime { start: self.time(), dt: self.clock.dt };
        self.guard.is_cancelled = false;
        // What a cancelled step has done stays done, and this one goes on from there.
        let resumed = self.guard.resumes_at.take();
        let [regions, contact] = match resumed {
            Some(_) => [start.elapsed(); 2],
            None => self.follow_hands(time, start),
        };
        let mut frame = std::mem::take(&mut self.frame);
        if resumed.is_none() {
            frame.begin();
            let Interactions { body_contacts, ties, .. } = &mut self.interactions;
            body_contacts.begin(&self.bodies, ties, &mut self.motion, self.plan.gravity, time);
        }
        self.move_bodies(resumed.unwrap_or(0), time, &mut frame);
        if self.guard.is_cancelled {
            self.frame = frame;
            return;
        }
        self.resolve_body_contact(time);
        self.interactions.obstacles.finish_step(&self.bodies, &self.motion.moved, time);
        self.advance_contact_laws(time);
        self.clock.steps += 1;
        frame.friction_work = self.interactions.friction_work(&self.bodies, &self.tools, time.dt);
        self.render_forces(time, &mut frame);
        frame.time = self.time();
        let is_tied = |pair| self.interactions.body_contacts.is_tied(pair);
        self.warnings.overlaps.update(self.clock.steps, frame.time, &self.bodies, is_tied);
        frame.seconds = start.elapsed().as_secs_f64();
        frame.parts = [regions, contact - regions, start.elapsed() - contact].map(|d| d.as_secs_f64());
        self.sum_energies(&mut frame);
        self.frame = frame;
    }

    /// The stages before bodies move, of a step that began at `start` on the wall clock. Returns the wall-clock time up to the end of moving regions and up
    /// to their own end.
    fn follow_hands(&mut self, time: StepTime, start: Instant) -> [Duration; 2] {
        self.apply_recorded();
        self.sample_hands(time);
        self.change_modes(time.start);
        self.change_stiffness(time.start);
        self.cut(time.start);
        self.open_cut_ties(time.start);
        self.move_regions(time.start);
        self.close_seams(time.start);
        let regions = start.elapsed();
        self.touch(time.start);
        [regions, start.elapsed()]
    }

    /// Invalidates everything that depends on the nodes of a body, as after a change of them. A step that was cancelled then begins anew.
    pub fn changed(&mut self, index: usize) {
        self.guard.resumes_at = None;
        self.motion.changed(index, &self.bodies[index]);
        self.interactions.changed(index);
        self.tools.iter_mut().for_each(|slot| slot.body_changed(index));
    }

    /// Stops a body for good at `time` (s), and says why.
    pub(super) fn freeze(&mut self, index: usize, time: f64, why: String) {
        freeze_body(&mut self.bodies[index], &mut self.events, time, why);
    }

    fn move_regions(&mut self, time: f64) {
        let (mut balls, mut grips) = (std::mem::take(&mut self.motion.balls), std::mem::take(&mut self.motion.grips));
        for index in 0..self.bodies.len() {
            let body = &mut self.bodies[index];
            if body.frozen.is_some() {
                continue;
            }
            balls.clear();
            grips.clear();
            // A body that is simulated as a whole has no region to move.
            if !body.discretization.is_whole() {
                for slot in &mut self.tools {
                    balls.extend(slot.tool.required_ball(index, body, &slot.hand, time));
                    grips.extend(slot.tool.grip_on(index));
                }
            }
            if let Some(lattice) = body.discretization.lattice_mut() {
                lattice.set_grips(&grips);
            }
            let Body { name, model, skin, system, discretization, fixings, .. } = body;
            let start = Instant::now();
            let were_apart = discretization.lattice().is_some_and(|lattice| lattice.grips_apart.is_some());
            match discretization.follow(&balls, model, fixings, skin, system) {
                Ok(true) => {
                    let apart = discretization.lattice().and_then(|lattice| lattice.grips_apart);
                    if let (Some(grips), false) = (apart, were_apart) {
                        self.events.add(EventKind::GripsApart, time, || grips_apart_text(name, grips));
                    }
                    self.changed(index);
                    // Tetrahedra that have failed have other numbers in the new cells.
                    if let Err(error) = self.take_failed(index, time) {
                        self.freeze(index, time, error.to_string());
                    }
                }
                Ok(false) => {}
                Err(error) => self.freeze(index, time, error.to_string()),
            }
            self.check_patience(index, Stage::Region, time, start);
        }
        (self.motion.balls, self.motion.grips) = (balls, grips);
    }

    fn touch(&mut self, time: f64) {
        let is_explicit = !self.motion.is_implicit();
        for slot in &mut self.tools {
            let lost = slot.tool.slipped;
            let mut step = Step {
                hand: &slot.hand,
                bodies: &mut self.bodies,
                moved: &self.motion.moved,
                time: StepTime { start: time, dt: self.clock.dt },
                is_explicit,
            };
            if let Err(error) = slot.tool.follow(&mut step) {
                if let LatticeError::ContactLaw { body, error } = error {
                    freeze_body(&mut self.bodies[body as usize], &mut self.events, time, error.to_string());
                } else {
                    self.events.add(EventKind::Message, time, || error.to_string());
                }
                slot.tool.release(&slot.hand);
            }
            let slipped = slot.tool.slipped - lost;
            slot.has_lost_grip |= slipped > 0;
            self.events.add_many(EventKind::GripLost, slipped, time, || {
                format!(
                    "tool `{}`: it let go for the rest of its stroke: its force was over the `limit` of its edit",
                    slot.tool.name
                )
            });
            if let Some((body, param)) = slot.tool.refused_param.take() {
                let why = super::fields::refusal(&self.bodies[body as usize], &param);
                self.events.add(EventKind::PaintRefused, time, || format!("tool `{}`: {why}", slot.tool.name));
            }
            add_limit_event(&mut self.events, slot, &self.devices[slot.device].name, time);
        }
        self.move_tips(self.clock.dt);
        self.press_sheets(time);
    }

    /// Moves the bodies from number `first` on.
    fn move_bodies(&mut self, first: usize, time: StepTime, frame: &mut Frame) {
        for index in first..self.bodies.len() {
            let body = &self.bodies[index];
            frame.nodes += body.system.nodes.len();
            frame.elements += body.system.elements();
            if body.frozen.is_some() || body.system.nodes.is_empty() {
                self.motion.moved[index] = 0.0;
                continue;
            }
            let start = Instant::now();
            let mut stage = Stage::Step;
            // Contact within the step reads what the body moved in the last one.
            let moved = self.move_body(index, time, start, frame);
            self.motion.moved[index] = moved.as_ref().map_or(0.0, |fastest| fastest * self.clock.dt);
            match moved {
                Ok(fastest) => {
                    if let Err(error) = self.take_failed(index, time.start) {
                        self.freeze(index, time.start, error.to_string());
                        continue;
                    }
                    // A body near others comes to rest after contact.
                    if !self.interactions.body_contacts.is_near(index) {
                        self.rest(index, fastest, time);
                    }
                }
                Err(NotMoved::Cancelled) => {
                    self.guard.is_cancelled = true;
                    self.guard.resumes_at = Some(index);
                    // It is counted again when the step goes on.
                    frame.nodes -= self.bodies[index].system.nodes.len();
                    frame.elements -= self.bodies[index].system.elements();
                    return;
                }
                Err(NotMoved::TimedOut) => stage = Stage::Interrupted,
                Err(NotMoved::Failed(why)) => self.freeze(index, time.start, why),
            }
            self.check_patience(index, stage, time.start, start);
        }
    }

    /// Takes account of the elements of a body that have failed in a step: its surface follows, contacts forget what is gone, and an event counts them.
    fn take_failed(&mut self, index: usize, time: f64) -> Result<(), LatticeError> {
        let change = self.bodies[index].update_failed_triangles()?;
        self.bodies[index].embed_exposed_faces();
        if change.surface {
            self.tools.iter_mut().for_each(|slot| slot.tool.invalidate(index));
            self.interactions.obstacles.surface_changed(index);
        }
        if change.elements == 0 {
            return Ok(());
        }
        self.interactions.body_contacts.changed(index);
        for slot in &mut self.tools {
            slot.soft[index].iter_mut().for_each(SoftTip::invalidate_areas);
        }
        let body = &self.bodies[index];
        self.events.add_many(EventKind::ElementsFailed, change.elements as u64, time, || {
            format!("body `{}`: its material failed: {}", body.name, body.describe_failed())
        });
        Ok(())
    }

    /// Moves a body; the step began at `start` on the wall clock. Returns the speed of its fastest node, m/s.
    fn move_body(&mut self, index: usize, time: StepTime, start: Instant, frame: &mut Frame) -> Result<f64, NotMoved> {
        let body = &self.bodies[index];
        let factor = body.stiffness_factor().unwrap_or(1.0) * body.painted_stiffening();
        let mut frequencies = self.motion.limits.frequencies[index].stiffened(factor);
        self.motion.loads.exchange(&mut self.tools, index);
        if let Some(springs) = self.motion.loads.seams_mut() {
            let explicit_substeps = (!self.motion.limits.scheme.is_implicit()).then_some(self.choices.substeps);
            self.interactions.seams.draw(index, body, explicit_substeps, time, springs, &mut self.events);
        }
        for springs in self.motion.loads.springs() {
            frequencies = frequencies.with_spring(springs.rates(&body.system.nodes.mass));
        }
        let deadline = self.guard.deadline(self.clock.steps, index, start);
        self.motion.integrators[index].interrupts = Interrupts { cancel: self.guard.cancel.clone(), deadline };
        let moved = self.move_under(index, time, &frequencies, frame);
        self.motion.loads.exchange(&mut self.tools, index);
        moved
    }

    /// Steps a body under its loads.
    fn move_under(
        &mut self,
        index: usize,
        time: StepTime,
        frequencies: &Frequencies,
        frame: &mut Frame,
    ) -> Result<f64, NotMoved> {
        let substeps = self.contact_substeps(index, time, frequencies);
        let body = &mut self.bodies[index];
        self.interactions.place_tips(index, body, &self.tools, self.motion.moved[index], time.dt);
        body.discretization.prescribe(&mut body.system.nodes, &body.fixings, time);
        if self.sleeps(index, time) {
            return Ok(0.0);
        }
        let body = &mut self.bodies[index];
        if let Err(error) = self.interactions.obstacles.place(index, body, self.plan.gravity, time) {
            self.freeze(index, time.start, error.to_string());
        }
        let body = &mut self.bodies[index];
        let gravity = if body.discretization.is_whole() { self.plan.gravity } else { Vec3::zeros() };
        let is_single = substeps == 1 && self.motion.is_implicit();
        let (elements, nodes) = (body.system.elements(), body.system.nodes.len());
        let Motion { workers, integrators, loads, .. } = &mut self.motion;
        let (integrator, springs, system) = (&mut integrators[index], loads.springs(), &mut body.system);
        let stepped = self.interactions.step_in_contact(index, is_single.then_some(nodes), |contacts, forces| {
            let loads = Loads { gravity, forces, tools: springs };
            workers.run(index, elements, |pool| {
                integrator.step_with_contacts(pool, system, &loads, contacts, time, substeps)
            })
        });
        self.choices.threads = workers.all.threads();
        if body.discretization.sheet().is_some() {
            let nodes = &body.system.nodes;
            springs.iter().for_each(|s| s.add_to(&mut integrator.reaction, &nodes.x, Some(&nodes.v)));
        }
        let report = stepped.map_err(|error| match error {
            StepError::Diverged { node } => {
                let (at, material) = (body.system.nodes.rest[node], body.system.material.name());
                NotMoved::Failed(format!("`{material}`: {error}, at {:?} m; its step may be too long", at.as_slice()))
            }
            StepError::Force(error) => NotMoved::Failed(error.to_string()),
            StepError::Cancelled => NotMoved::Cancelled,
            StepError::TimedOut => NotMoved::TimedOut,
        })?;
        self.note_step(index, time, &report);
        frame.substeps = frame.substeps.max(report.substeps);
        frame.iterations += report.iterations;
        frame.residual = frame.residual.max(report.residual);
        frame.work[0] += report.assembly_seconds;
        frame.work[1] += report.solve_seconds;
        self.interactions.return_tips(index, &mut self.tools, time.dt);
        Ok(report.max_speed)
    }

    /// Number of substeps of a body's step under contacts of these frequencies; adds an event where there are more than chosen, or fewer than needed.
    fn contact_substeps(&mut self, index: usize, time: StepTime, frequencies: &Frequencies) -> usize {
        let needed = if self.motion.limits.is_forced {
            1
        } else {
            self.motion.limits.needed_substeps(frequencies, self.clock.dt)
        };
        let substeps = needed.min(self.motion.limits.max_substeps).max(self.choices.substeps);
        if needed > substeps {
            self.events.add(EventKind::Unstable, time.start, || {
                format!(
                    "body `{}`: the stiffness of a contact asks for {needed} substeps; allowed is {substeps} (`most-substeps`)",
                    self.bodies[index].name
                )
            });
        }
        if substeps > self.choices.substeps {
            self.events.add(EventKind::Substeps, time.start, || {
                format!(
                    "body `{}`: {substeps} substeps instead of {}, for the stiffness of a contact",
                    self.bodies[index].name, self.choices.substeps
                )
            });
        }
        substeps
    }

    /// Adds events for a step of a body whose solve did not converge, or that was taken again.
    fn note_step(&mut self, index: usize, time: StepTime, report: &StepReport) {
        if !report.converged {
            let text = || format!("relative residual {:.2e} after {} iterations", report.residual, report.iterations);
            self.events.add(EventKind::NotConverged, time.start, text);
        }
        let repeated = report.repeated_steps as u64;
        self.events.add_many(EventKind::RepeatedStep, repeated, time.start, || {
            let with = match self.motion.limits.scheme.is_implicit() {
                true => "more Newton iterations".to_owned(),
                false => format!("{} substeps", report.substeps),
            };
            format!(
                "body `{}`: a step of {} s is long for its forces and would have gained energy; it was taken again with {with}",
                self.bodies[index].name, self.clock.dt
            )
        });
    }

    /// Renders to each device the force and torque of its tools, after force safety.
    fn render_forces(&mut self, StepTime { start: time, dt }: StepTime, frame: &mut Frame) {
        for tool in 0..self.tools.len() {
            let (held, sheet) = self.interactions.sheet_contact_force(&self.tools, tool);
            let pressed = self.tools[tool].soft_contact_force(&self.bodies);
            let on_sheets = held + pressed;
            let slot = &mut self.tools[tool];
            let place = slot.tool.proxy.position;
            slot.drift = slot.was.map_or(Vec3::zeros(), |was| (place - was) / dt);
            slot.was = slot.hand.present.then_some(place);
            slot.turned = slot.hand.present.then(|| slot.tool.proxy.shape.rotation());
            slot.on_sheets = on_sheets;
            let of_sheets = match &slot.tip {
                Some(tip) if slot.tool.proxy.touch.is_none() => {
                    tip.coupling_force(slot.hand.position, &slot.tool.coupling)
                }
                _ => on_sheets,
            };
            let on_bodies = slot.tool.reaction(&self.bodies) - pressed;
            let force = on_bodies + of_sheets;
            let to_device = &self.devices[slot.device].frame;
            let (last, wanted) = (slot.safety.last(), to_device.to_device(force));
            let mut counts = [0; Cause::ALL.len()];
            counts.iter_mut().zip(slot.safety.counts()).for_each(|(to, (_, count))| *to = count);
            let device_force = slot.safety.pass(wanted, dt);
            let pass = SafetyPass { counts, last, wanted, given: device_force };
            add_safety_events(&mut self.events, slot, &pass, time + dt);
            let mut felt = tool_frame(&slot.tool, slot.hand.position, force, device_force);
            felt.edit = slot.edit.map(|edit| self.plan.edits[edit].kind);
            felt.has_torque = slot.has_torque;
            felt.torque = slot.tool.reaction_torque(slot.hand.position, &self.bodies);
            if self.devices[slot.device].facts.driven_axes >= TORQUE_AXES {
                // The torque comes from the same springs as the force, so it is scaled like the force by force safety.
                let share = if wanted.norm() > 0.0 { (device_force.norm() / wanted.norm()).min(1.0) } else { 1.0 };
                felt.device_torque = share * to_device.to_device(felt.torque);
                let limited = &mut slot.ongoing.torque_limited;
                if let Some(safety) = &mut slot.torque_safety {
                    let (name, peak, wanted) = (&slot.tool.name, safety.peak(), felt.device_torque);
                    let count = |safety: &TorqueSafety| safety.counts().map(|(_, count)| count).sum::<u64>();
                    let before = count(safety);
                    felt.device_torque = safety.pass(wanted, dt);
                    let text = || {
                        format!(
                            "tool `{name}`: the device gets {:.4} N m instead of {:.4} N m (its peak is {peak} N m; its continuous torque and \
                             `slew` are the same part of those of the force)",
                            felt.device_torque.norm(),
                            wanted.norm()
                        )
                    };
                    self.events.add_episode(EventKind::ForceSafety, count(safety) - before, limited, time + dt, text);
                }
            }
            felt.contact = felt.contact.or(sheet);
            frame.tools.push(felt);
            self.warnings.tally(&self.tools[tool], &self.bodies, force.norm());
            self.show(tool, on_bodies, dt);
        }
    }

    /// Computes kinetic and elastic energy for the frame if an output needs them; not part of the step's time.
    fn sum_energies(&mut self, frame: &mut Frame) {
        if !self.plan.energy {
            return;
        }
        for index in 0..self.bodies.len() {
            let system = &mut self.bodies[index].system;
            frame.kinetic_energy += system.nodes.kinetic_energy();
            match system.energy(StepTime { start: frame.time, dt: self.clock.dt }) {
                Ok(energy) => frame.elastic_energy += energy,
                Err(error) if self.bodies[index].frozen.is_none() => self.freeze(index, frame.time, error.to_string()),
                Err(_) => {}
            }
        }
    }
}

/// Stops a body for good at `time` (s), and says why.
pub(super) fn freeze_body(body: &mut Body, events: &mut Events, time: f64, why: String) {
    body.system.nodes.v.fill(Vec3::zeros());
    events.add(EventKind::Quarantine, time, || format!("body `{}` stands still: {why}", body.name));
    body.frozen = Some(why);
}

fn tool_frame(tool: &Tool, hand: Vec3, force: Vec3, device_force: Vec3) -> ToolFrame {
    ToolFrame {
        hand,
        proxy: tool.proxy.position,
        contact: tool.contact().map(|place| place.body),
        edit: None,
        grips: tool.is_gripping(),
        depth: tool.depth,
        force,
        device_force,
        has_torque: false,
        torque: Vec3::zeros(),
        device_torque: Vec3::zeros(),
    }
}

fn grips_apart_text(body: &str, [a, b]: [Vec3; 2]) -> String {
    format!(
        "body `{body}`: two hands hold it {:.0} mm from each other, in regions of the grid that do not meet: what is between them stays at rest; \
         a larger `radius` of the grid, or `region = \"whole\"`, lets it move",
        1e3 * (a - b).norm()
    )
}
