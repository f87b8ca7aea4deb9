//! Choice of integrator, substeps and preconditioner for the bodies of a scene, from their frequencies.

use super::edit_costs::RegionSize;
use super::shared::{Measured, SharedParts};
use super::{EventKind, PreconditionerChosen, Session, SessionError, StepCost};
use crate::body::Samples;
use crate::body::{Body, Fixing};
use crate::plan::LeftOut;
use crate::scene::{PreconditionerChoice, Scene};
use crate::tool::Tool;
use pliant_mesh::geometry::Vec3;
use pliant_plugin_api::abi::{self, Ball};
use pliant_solver::{ElementSet, Frequencies, Integrator, Pool, Preconditioner, Scheme, SpringRates, StepTime};
use std::sync::Arc;
use std::time::Instant;

/// Squared frequency that the elastic layer of a contact adds to a surface node, relative to that of the body's fastest mode.
const LAYER_SHARE: f64 = 1.0;
/// Stiffness of the layer relative to that of the tool's coupling, for a body without free nodes.
const HELD_LAYER: f64 = 10.0;
/// Fraction of the step limit that is used.
const STEP_SHARE: f64 = 0.9;
/// Largest step without a warning, s.
const LONG_STEP: f64 = 0.05;
/// Largest number of explicit substeps that cost less than an implicit step (docs/performance.md): for springs, for solids with a stiffness in single
/// precision, and for all others.
const FEW_OF_SPRINGS: usize = 16;
const FEW_OF_SOLIDS: usize = 12;
const FEW_SUBSTEPS: usize = 4;
/// Largest factor by which the substeps of a step that would gain energy are divided, even beyond `most-substeps`: a solid that is stretched fourfold
/// has sixteen times the damping.
const MOST_DIVIDED: usize = 16;
/// Displacement of a node in an explicit step, in edges of the body, from which on the step may not gain energy. A mode that grows gets there in a few
/// steps.
const STRAIN_OF_GUARDED_STEP: f64 = 0.1;
/// Number of nodes below which the setup of multilevel preconditioning does not pay.
const FEW_NODES: usize = 200;
/// Product of step and highest frequency below which block Jacobi needs few iterations.
const SHORT_REACH: f64 = 6.0;

impl Session {
    /// Samples the surfaces of bodies that a large tool may touch.
    pub(super) fn sample(&mut self, shared: &SharedParts) -> Result<(), SessionError> {
        for body in &mut self.bodies {
            let edge = body.discretization.edge();
            let by_tool = self.tools.iter().any(|slot| Tool::meets_samples(&slot.tool.proxy.shape, edge));
            if by_tool || !self.interactions.obstacles.is_empty() {
                let of_body = |error| SessionError::Lattice { body: body.name.clone(), error };
                let Some(lattice) = body.discretization.lattice() else { continue };
                let make = || Samples::new(&body.model.surface, lattice);
                body.samples = shared.samples(|| lattice.key.clone(), make).map_err(of_body)?;
            }
        }
        Ok(())
    }

    /// Computes the frequencies of each body: of the whole body, or of the cells around one of its points. Results are cached under `keys` (one for each
    /// body), except for bodies that are simulated as a whole.
    pub(super) fn measure(&mut self, shared: &SharedParts, keys: &[String]) -> Result<(), SessionError> {
        let coupling = self.tools.iter().map(|slot| slot.tool.coupling.stiffness).fold(0.0, f64::max);
        let radii: Vec<Vec<f64>> = self.bodies.iter().map(|body| self.edit_regions(body)).collect();
        let mut regions = Vec::new();
        for ((body, key), radii) in self.bodies.iter_mut().zip(keys).zip(&radii) {
            let measured = if body.discretization.is_whole() {
                measure_body(body, self.motion.pool(), self.clock.dt, radii)?
            } else {
                let key = || format!("{key} {radii:?}");
                shared.measured(key, || measure_body(body, self.motion.pool(), self.clock.dt, radii))?
            };
            let Measured { frequencies: mut found, mass, nodes, elements, seconds, regions: of_edits } = measured;
            regions.push(of_edits);
            // Measured at one place, and where a parameter differs another may be as much stiffer, or lighter.
            if let Some(fields) =
                body.discretization.lattice().filter(|l| !l.is_whole()).and_then(|l| l.fields.as_ref())
            {
                let spread = fields.spread();
                found.stiffness *= spread.sqrt();
                found.bound *= spread.sqrt();
                found.damping *= spread;
            }
            let layer = match found.stiffness {
                // A body without free nodes has no step limit.
                0.0 => HELD_LAYER * coupling,
                stiffness => LAYER_SHARE * stiffness.powi(2) * 0.5 * mass,
            };
            body.layer_stiffness = layer / body.discretization.edge().powi(2);
            body.layer_mass = 0.5 * mass / body.discretization.edge().powi(2);
            let touched =
                found.with_spring(SpringRates { stiffness: LAYER_SHARE * found.stiffness.powi(2), damping: 0.0 });
            self.motion.limits.planned.push(if self.tools.is_empty() { found } else { touched });
            self.motion.limits.frequencies.push(found);
            self.motion.limits.costs.push(StepCost { body: body.name.clone(), nodes, elements, seconds });
        }
        self.estimate_edits(&regions);
        Ok(())
    }

    /// Chooses scheme and substeps.
    ///
    /// # Errors
    /// Returns an error if an explicit integrator exceeds its step limit.
    pub(super) fn choose(&mut self, scene: &Scene) -> Result<(), SessionError> {
        if self.bodies.is_empty() {
            self.left_out("integration", "nothing moves");
            return Ok(());
        }
        if self.clock.dt > LONG_STEP {
            let text = || format!("dt is {} s; above {LONG_STEP} s a hand is followed in jumps", self.clock.dt);
            self.events.add(EventKind::LongStep, 0.0, text);
        }
        let time = &scene.time;
        let symplectic = self.motion.limits.limit(Scheme::SymplecticEuler);
        let needed = |limit: f64| (self.clock.dt / (STEP_SHARE * limit)).ceil().max(1.0);
        let (scheme, why) = match time.integrator.scheme() {
            Some(scheme) => (scheme, "the scene asks for it".into()),
            None if self.plan.is_stitched => {
                (Scheme::BackwardEuler, "bodies are stitched together, which explicit steps cannot solve".into())
            }
            None => {
                let (substeps, few) = (symplectic.map_or(1.0, needed), self.few_substeps());
                let why =
                    format!("explicit steps cost less than an implicit one up to {few} substeps, and need {substeps}");
                let cheap = substeps <= few as f64;
                (if cheap { Scheme::SymplecticEuler } else { Scheme::BackwardEuler }, why)
            }
        };
        let limit = self.motion.limits.limit(scheme);
        let certain = self.motion.limits.certain_limit(scheme);
        let substeps = self.substeps(scene, scheme, limit)?;
        if scheme.is_implicit() {
            for body in &mut self.bodies {
                body.system.enable_matrix();
            }
        } else {
            self.left_out("matrix and linear solver", "the integrator is explicit");
        }
        if self.bodies.iter().all(|b| !b.system.is_damped()) {
            self.left_out("damping of the material", "its damping time is zero");
        }
        let solver = &scene.solver;
        let (tolerance, most) = (*solver.tolerance.get_ref(), *solver.iterations.get_ref() as usize);
        self.motion.integrators = self.bodies.iter().map(|_| Integrator::new(scheme, tolerance, most)).collect();
        for ((integrator, body), found) in
            self.motion.integrators.iter_mut().zip(&self.bodies).zip(&self.motion.limits.frequencies)
        {
            integrator.max_newton =
                scene.solver.newton.as_ref().map_or(integrator.max_newton, |n| *n.get_ref() as usize);
            let edge = body.discretization.edge();
            integrator.guarded_speed = if scheme.is_implicit() {
                // A node that moves by d across an edge of length e stretches it by d^2 / 2 e^2 before the next linearisation. That is more energy than
                // its motion has where d / e times step times frequency is about 3; from a third of it on a step is looked at.
                edge / (self.clock.dt * (self.clock.dt * found.stiffness).max(1.0))
            } else {
                STRAIN_OF_GUARDED_STEP * edge / self.clock.dt
            };
            // `force-unstable` is there to show instability.
            if self.motion.limits.is_forced {
                integrator.guarded_speed = f64::INFINITY;
            }
            integrator.max_substeps = self.motion.limits.max_substeps.max(MOST_DIVIDED * substeps);
            integrator.newton_tolerance = *scene.solver.newton_tolerance.get_ref();
            integrator.max_displacement = 0.5 * edge;
            integrator.resize(body.system.nodes.len());
        }
        self.motion.limits.scheme = scheme;
        if scheme.is_implicit() {
            self.choose_preconditioners(solver.preconditioner);
        }
        self.choices.integrator = scheme.name();
        self.choices.why = why;
        self.choices.step_limit = limit;
        self.choices.certain_step_limit = certain;
        self.choices.substeps = substeps;
        self.motion.limits.costs.iter_mut().for_each(|c| c.seconds *= substeps as f64);
        self.motion.limits.edit_costs.iter_mut().for_each(|c| c.seconds *= substeps as f64);
        Ok(())
    }

    /// Largest number of explicit substeps that cost less than an implicit step.
    fn few_substeps(&self) -> usize {
        let few = |set: &ElementSet| match set.request().kind {
            abi::LINK => FEW_OF_SPRINGS,
            abi::TETRAHEDRON if set.has(abi::HAS_SINGLE) => FEW_OF_SOLIDS,
            _ => FEW_SUBSTEPS,
        };
        let forces = self.bodies.iter().flat_map(|b| &b.system.sets).filter(|set| set.has(abi::HAS_FORCES));
        forces.map(few).min().unwrap_or(FEW_OF_SPRINGS)
    }

    /// Chooses the preconditioner of each body. Multilevel preconditioning pays if a wave crosses many nodes in a step, and needs a body whose nodes do
    /// not change.
    fn choose_preconditioners(&mut self, choice: PreconditionerChoice) {
        for ((body, integrator), found) in
            self.bodies.iter().zip(&mut self.motion.integrators).zip(&self.motion.limits.frequencies)
        {
            let nodes = body.system.nodes.len();
            let reach =
                if self.motion.limits.scheme.has_inertia() { self.clock.dt * found.stiffness } else { f64::INFINITY };
            let (preconditioner, why) = match choice {
                PreconditionerChoice::BlockJacobi => (Preconditioner::BlockJacobi, "the scene asks for it".into()),
                PreconditionerChoice::Multilevel => (Preconditioner::Multilevel, "the scene asks for it".into()),
                PreconditionerChoice::Auto if !body.discretization.is_whole() => {
                    (Preconditioner::BlockJacobi, "its nodes change with the region of a touch".into())
                }
                PreconditionerChoice::Auto if nodes < FEW_NODES => {
                    (Preconditioner::BlockJacobi, format!("{nodes} nodes are fewer than {FEW_NODES}"))
                }
                PreconditionerChoice::Auto if reach < SHORT_REACH => (
                    Preconditioner::BlockJacobi,
                    format!("a step is {reach:.1} over its fastest frequency, less than {SHORT_REACH}"),
                ),
                PreconditionerChoice::Auto => (
                    Preconditioner::Multilevel,
                    format!(
                        "{nodes} nodes, and a step is {reach:.1} over its fastest frequency: {SHORT_REACH} or more"
                    ),
                ),
            };
            integrator.set_preconditioner(preconditioner);
            let preconditioner = preconditioner.name();
            self.choices.preconditioners.push(PreconditionerChosen { body: body.name.clone(), preconditioner, why });
        }
    }

    fn substeps(&mut self, scene: &Scene, scheme: Scheme, limit: Option<f64>) -> Result<usize, SessionError> {
        let time = &scene.time;
        let given = *time.substeps.get_ref() as usize;
        let Some(limit) = limit else { return Ok(given.max(1)) };
        let h = self.clock.dt / given.max(1) as f64;
        if time.force_unstable {
            if h > limit {
                let text = || format!("{} at {h} s, over its limit of {limit:.3e} s", scheme.name());
                self.events.add(EventKind::Unstable, 0.0, text);
            }
            return Ok(given.max(1));
        }
        let refuse = |reason: String| {
            let text = format!(
                "{} is stable up to a step of {limit:.4e} s here, and dt is {} s: {reason}. Allowed: a smaller dt, more \
                 substeps, `integrator = \"backward-euler\"`, or `force-unstable = true` to see it grow",
                scheme.name(),
                self.clock.dt
            );
            Err(SessionError::StepLimit(text))
        };
        if limit == 0.0 {
            return refuse("without damping it grows at any step".into());
        }
        if given > 0 {
            let stable = h <= limit;
            return if stable {
                Ok(given)
            } else {
                refuse(match given {
                    1 => "one step without substeps is too long".into(),
                    more => format!("{more} substeps are too few"),
                })
            };
        }
        let needed = (self.clock.dt / (STEP_SHARE * limit)).ceil().max(1.0);
        if needed > self.motion.limits.max_substeps as f64 {
            return refuse(format!("{needed} substeps are more than the {} allowed", self.motion.limits.max_substeps));
        }
        Ok(needed as usize)
    }

    fn left_out(&mut self, what: &str, why: &str) {
        self.plan.left_out.push(LeftOut { what: what.into(), why: why.into() });
    }
}

/// Computes the frequencies of a body: of the whole body, or of the cells around one of its points, which are deactivated again.
fn measure_body(body: &mut Body, pool: &Pool, dt: f64, regions: &[f64]) -> Result<Measured, SessionError> {
    let of_body = |error| SessionError::Lattice { body: body.name.clone(), error };
    let radius = body.discretization.radius();
    let centre = body.model.surface.points[body.model.surface.triangles[0][0] as usize];
    let Body { model, skin, system, discretization, fixings, .. } = body;
    // The fixings of a local region depend on its position; without them the frequencies are highest.
    // The place may be one without fibres, and a stroke may go where they are.
    let everywhere = discretization.lattice().filter(|l| !l.is_whole()).and_then(|l| l.fibres.as_ref());
    let everywhere = everywhere.map(|fibres| Arc::new(fibres.everywhere()));
    let fibres = discretization.lattice_mut().filter(|_| everywhere.is_some());
    let fibres = fibres.and_then(|lattice| lattice.replace_fibres(everywhere));
    let held: &[Fixing] = if discretization.is_whole() { fixings } else { &[] };
    discretization.follow(&[Ball { centre: centre.into(), radius }], model, held, skin, system).map_err(of_body)?;
    let frequencies = Frequencies::of(system, pool)?;
    // A surface node has half of the mass of an interior node, and the layer area of one cell face.
    let mass = system.nodes.mass.iter().copied().fold(0.0, f64::max);
    let pass = Instant::now();
    let mut force = vec![Vec3::zeros(); system.nodes.len()];
    system.forces(pool, None, StepTime { start: 0.0, dt }, &mut force)?;
    let seconds = pass.elapsed().as_secs_f64();
    let (nodes, elements) = (system.nodes.len(), system.elements());
    let mut sizes = Vec::new();
    if !discretization.is_whole() {
        let of_body = |error| SessionError::Lattice { body: body.name.clone(), error };
        if let Some(lattice) = discretization.lattice_mut().filter(|_| fibres.is_some()) {
            lattice.replace_fibres(fibres);
        }
        for &radius in regions {
            let ball = Ball { centre: centre.into(), radius };
            discretization.follow(&[ball], model, held, skin, system).map_err(of_body)?;
            sizes.push(RegionSize { radius, nodes: system.nodes.len(), elements: system.elements() });
        }
        discretization.follow(&[], model, fixings, skin, system).map_err(of_body)?;
    }
    Ok(Measured { frequencies, mass, nodes, elements, seconds, regions: sizes })
}
