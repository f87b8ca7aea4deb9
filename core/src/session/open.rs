//! Opening a scene: models, plugins, bodies, tools; and choosing how to move them.

use super::{Choices, DeviceSlot, EventKind, Events, Frame, Loaded, Session, SessionError, StepCost, ToolSlot, place};
use crate::body::{Body, Lattice, Model, RegionSettings, Skin};
use crate::contact::{Friction, Samples};
use crate::host::{Device, Grid, Kind, Library, Material, PluginInfo, Pose, Search, Settings};
use crate::mesh::check::{Severity, Use};
use crate::plan::Plan;
use crate::scene::{BodyScene, Extent, IntegratorChoice, Scene, Source, ToolScene, settings};
use crate::step::{Frequencies, Integrator, NodeSprings, Pool, Scheme, StepLimit, System};
use crate::tool::{Coupling, ForceLimits, ForceSafety, Hand, Tool};
use pliant_plugin_api::abi::Ball;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use toml::Spanned;

/// What the caller decides.
pub struct Options {
    /// Where plugins are looked for.
    pub search: Search,
    /// Threads; 0 takes what the machine has.
    pub threads: usize,
    /// Another model in the place of the first body's.
    pub mesh: Option<PathBuf>,
}

/// Cells of a local region's radius, where the scene gives none.
const REGION_CELLS: f64 = 10.0;
/// Share of a device's stiffness that a coupling takes, where the scene gives none.
const COUPLING_SHARE: f64 = 0.3;
/// Square of the frequency the layer of a contact adds to a surface node, over that of the body's fastest mode.
const LAYER_SHARE: f64 = 1.0;
/// Share of the step limit that is used.
const STEP_SHARE: f64 = 0.9;
/// Substeps up to which an explicit integrator is preferred.
const FEW_SUBSTEPS: usize = 8;

type Given = BTreeMap<String, Spanned<toml::Value>>;

impl Session {
    /// Opens what `plan` needs of a scene, and nothing else.
    ///
    /// # Errors
    /// A model or plugin that cannot be used; an explicit integrator over its limit.
    pub fn open(scene: &Scene, source: &Source, plan: Plan, options: &Options) -> Result<Self, SessionError> {
        let dt = scene.time.dt.get_ref().si;
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            given => given,
        };
        let mut opening = Opening { source, options, dt, loaded: Vec::new(), events: Events::default() };
        let mut models = Vec::new();
        for (i, body) in scene.body.iter().enumerate() {
            let instead = options.mesh.as_deref().filter(|_| i == 0);
            let model = place::model(body, source, instead)?;
            opening.judge(&body.name, &model);
            models.push((body.name.clone(), model));
        }
        let devices = plan.devices.iter().map(|&d| opening.device(scene, d, &models)).collect::<Result<Vec<_>, _>>()?;
        let (mut bodies, mut standing) = (Vec::new(), Vec::new());
        for (i, (name, model)) in models.into_iter().enumerate() {
            if plan.moving[i] {
                bodies.push(opening.body(&scene.body[i], name, model)?);
            } else {
                standing.push((name, model));
            }
        }
        let tools = plan
            .tools
            .iter()
            .map(|&t| opening.tool(&scene.tool[t], &devices, scene, &plan, bodies.len()))
            .collect::<Result<Vec<_>, _>>()?;
        let count = bodies.len();
        let springs = tools.iter().map(|_| NodeSprings::default()).collect();
        let mut session = Self {
            bodies,
            standing,
            devices,
            tools,
            choices: Choices {
                integrator: "none",
                why: "nothing moves".into(),
                step_limit: None,
                certain_step_limit: None,
                substeps: 1,
                threads,
            },
            loaded: opening.loaded,
            left_out: plan.left_out.clone(),
            events: opening.events,
            plan,
            pool: Pool::new(threads),
            integrators: Vec::new(),
            frequencies: Vec::new(),
            planned: Vec::new(),
            costs: Vec::new(),
            scheme: Scheme::SymplecticEuler,
            most_substeps: scene.time.most_substeps.max(1) as usize,
            forced: scene.time.force_unstable,
            dt,
            steps: 0,
            energy: scene.output.energy,
            moved: vec![0.0; count],
            springs,
            balls: Vec::new(),
            frame: Frame::default(),
        };
        session.sample()?;
        session.measure()?;
        session.choose(scene)?;
        session.choices.threads = session.pool.threads();
        Ok(session)
    }

    /// Samples the surfaces that a ball may touch.
    fn sample(&mut self) -> Result<(), SessionError> {
        for body in &mut self.bodies {
            if self.tools.iter().any(|slot| Tool::is_ball(slot.tool.proxy.radius, body.lattice.edge())) {
                let of_body = |error| SessionError::Lattice { body: body.name.clone(), error };
                body.samples = Arc::new(Samples::new(&body.model.surface, &body.lattice).map_err(of_body)?);
            }
        }
        Ok(())
    }

    /// Finds how fast each body can move: on the whole of it, or on the cells around one of its points.
    fn measure(&mut self) -> Result<(), SessionError> {
        for body in &mut self.bodies {
            let of_body = |error| SessionError::Lattice { body: body.name.clone(), error };
            let radius = body.lattice.settings.radius;
            let centre = body.model.surface.points[body.model.surface.triangles[0][0] as usize];
            let Body { model, skin, system, lattice, fixings, .. } = body;
            lattice.follow(&[Ball { centre, radius }], model, fixings, skin, system).map_err(of_body)?;
            let found = Frequencies::of(system, &self.pool)?;
            // A surface node has half the mass of one inside; its share of the layer is that of a cell's face.
            let mass = system.nodes.mass.iter().copied().fold(0.0, f64::max);
            let layer = LAYER_SHARE * found.stiffness.powi(2) * 0.5 * mass;
            body.layer_stiffness = layer / lattice.edge().powi(2);
            let touched = found.with_spring((LAYER_SHARE * found.stiffness.powi(2), 0.0));
            self.planned.push(if self.tools.is_empty() { found } else { touched });
            self.frequencies.push(found);
            let pass = Instant::now();
            let mut force = vec![[0.0; 3]; system.nodes.len()];
            system.forces(&self.pool, &system.nodes.v, (0.0, self.dt), &mut force)?;
            let seconds = pass.elapsed().as_secs_f64();
            let (nodes, elements) = (system.nodes.len(), system.elements());
            self.costs.push(StepCost { body: body.name.clone(), nodes, elements, seconds });
            if !lattice.is_whole() {
                let of_body = |error| SessionError::Lattice { body: body.name.clone(), error };
                lattice.follow(&[], model, fixings, skin, system).map_err(of_body)?;
            }
        }
        Ok(())
    }

    /// Chooses scheme and substeps, or refuses.
    fn choose(&mut self, scene: &Scene) -> Result<(), SessionError> {
        if self.bodies.is_empty() {
            self.left_out("integration", "nothing moves");
            return Ok(());
        }
        let time = &scene.time;
        let symplectic = self.limit(Scheme::SymplecticEuler);
        let needed = |limit: f64| (self.dt / (STEP_SHARE * limit)).ceil().max(1.0);
        let few = FEW_SUBSTEPS as f64;
        let (scheme, why) = match time.integrator {
            IntegratorChoice::ExplicitEuler => (Scheme::ExplicitEuler, "the scene asks for it".into()),
            IntegratorChoice::SymplecticEuler => (Scheme::SymplecticEuler, "the scene asks for it".into()),
            IntegratorChoice::BackwardEuler => (Scheme::BackwardEuler, "the scene asks for it".into()),
            IntegratorChoice::Auto => match symplectic {
                Some(limit) if needed(limit) > few => (
                    Scheme::BackwardEuler,
                    format!("explicit steps would need {} substeps, more than {FEW_SUBSTEPS}", needed(limit)),
                ),
                _ => (Scheme::SymplecticEuler, format!("explicit steps need at most {FEW_SUBSTEPS} substeps")),
            },
        };
        let limit = self.limit(scheme);
        let certain = self.certain_limit(scheme);
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
        let (tolerance, most) = (*solver.tolerance.get_ref(), solver.iterations.max(1) as usize);
        self.integrators = self.bodies.iter().map(|_| Integrator::new(scheme, tolerance, most)).collect();
        for (integrator, body) in self.integrators.iter_mut().zip(&self.bodies) {
            integrator.resize(body.system.nodes.len());
        }
        self.scheme = scheme;
        self.choices.integrator = scheme.name();
        self.choices.why = why;
        self.choices.step_limit = limit;
        self.choices.certain_step_limit = certain;
        self.choices.substeps = substeps;
        self.costs.iter_mut().for_each(|c| c.seconds *= substeps as f64);
        Ok(())
    }

    fn substeps(&mut self, scene: &Scene, scheme: Scheme, limit: Option<f64>) -> Result<usize, SessionError> {
        let time = &scene.time;
        let given = time.substeps as usize;
        let Some(limit) = limit else { return Ok(given.max(1)) };
        let h = self.dt / given.max(1) as f64;
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
                self.dt
            );
            Err(SessionError::StepLimit(text))
        };
        if limit == 0.0 {
            return refuse("without damping it grows at any step".into());
        }
        if given > 0 {
            let stable = h <= limit;
            return if stable { Ok(given) } else { refuse(format!("{given} substeps are too few")) };
        }
        let needed = (self.dt / (STEP_SHARE * limit)).ceil().max(1.0);
        if needed > self.most_substeps as f64 {
            return refuse(format!("{needed} substeps are more than the {} allowed", self.most_substeps));
        }
        Ok(needed as usize)
    }

    /// s, the step up to which `scheme` is stable for every body.
    fn limit(&self, scheme: Scheme) -> Option<f64> {
        least(self.planned.iter().map(|f| f.limit(scheme)))
    }

    fn certain_limit(&self, scheme: Scheme) -> Option<f64> {
        least(self.planned.iter().map(|f| Frequencies { stiffness: f.bound, ..*f }.limit(scheme)))
    }

    /// Substeps that keep a body with these frequencies stable, at most what is allowed.
    pub(super) fn substeps_for(&self, frequencies: &Frequencies) -> usize {
        match frequencies.limit(self.scheme) {
            StepLimit::At(limit) if limit > 0.0 && !self.forced => {
                let needed = (self.dt / limit).ceil().min(self.most_substeps as f64) as usize;
                needed.max(self.choices.substeps)
            }
            _ => self.choices.substeps,
        }
    }

    fn left_out(&mut self, what: &str, why: &str) {
        self.left_out.push(crate::plan::LeftOut { what: what.into(), why: why.into() });
    }
}

fn least(limits: impl Iterator<Item = StepLimit>) -> Option<f64> {
    let at = |limit| if let StepLimit::At(at) = limit { Some(at) } else { None };
    limits.filter_map(at).reduce(f64::min)
}

struct Opening<'a> {
    source: &'a Source,
    options: &'a Options,
    dt: f64,
    loaded: Vec<Loaded>,
    events: Events,
}

impl Opening<'_> {
    /// Finds a plugin, checks its parameters and notes its file.
    fn plugin(
        &mut self,
        kind: Kind,
        name: &Spanned<String>,
        given: &Given,
    ) -> Result<(&'static Library, &'static PluginInfo, Settings), SessionError> {
        let (file, id) = match name.get_ref().split_once('#') {
            Some((file, id)) => (file, id),
            None => (name.get_ref().as_str(), name.get_ref().as_str()),
        };
        let found = self.options.search.find(file, self.source.folder())?;
        let library = Library::open(&found.path)?;
        let id = if id.contains(['/', '\\']) { found.name.as_str() } else { id };
        let info = library.plugin(kind, id)?;
        let settings = settings(self.source, info, given)?;
        let path = library.path().display().to_string();
        if !self.loaded.iter().any(|l| l.path == path && l.id == info.id) {
            let (kind, id, version) = (kind.name(), info.id.clone(), info.version.clone());
            self.loaded.push(Loaded { kind, id, version, path });
        }
        Ok((library, info, settings))
    }

    fn device(&mut self, scene: &Scene, index: usize, models: &[(String, Model)]) -> Result<DeviceSlot, SessionError> {
        let device = &scene.device[index];
        let frame = place::frame(&device.frame, self.source, models, self.options.mesh.is_some())?;
        let (library, info, settings) = self.plugin(Kind::Device, &device.plugin, &device.params)?;
        let opened = Device::open(library, &info.id, &settings, self.dt)?;
        let poses = vec![Pose::default(); opened.facts().effectors as usize];
        Ok(DeviceSlot { name: device.name.get_ref().clone(), device: Some(opened), frame, poses })
    }

    fn body(&mut self, scene: &BodyScene, name: String, model: Model) -> Result<Body, SessionError> {
        let (library, info, settings) = self.plugin(Kind::Material, &scene.material.plugin, &scene.material.params)?;
        let material = Material::open(library, &info.id, &settings, self.dt)?;
        let families = material.requests().iter().fold(0, |all, r| all | r.families);
        let (library, info, settings) = self.plugin(Kind::Grid, &scene.grid.plugin, &scene.grid.params)?;
        let grid = Grid::open(library, &info.id, &settings, self.dt)?;
        let relaxation = scene.grid.relaxation.get_ref().si;
        let level = *scene.grid.level.get_ref();
        let whole = scene.grid.region == Extent::Whole;
        let radius = if whole { f64::INFINITY } else { scene.grid.radius.as_ref().map_or(0.0, |r| r.get_ref().si) };
        let region = RegionSettings { level, radius, relaxation };
        let of_body = |error| SessionError::Lattice { body: name.clone(), error };
        let mut lattice = Lattice::new(grid, region, families, &model).map_err(of_body)?;
        if lattice.settings.radius == 0.0 {
            lattice.settings.radius = REGION_CELLS * lattice.edge();
        }
        let skin = Skin::new(&model);
        let fixings = scene.fixed.iter().map(place::fixing).collect();
        Ok(Body {
            name,
            model,
            skin,
            system: System::new(material),
            lattice,
            samples: Arc::default(),
            layer_stiffness: 0.0,
            fixings,
            frozen: None,
        })
    }

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
        let facts = *devices[device].device.as_ref().expect("just opened").facts();
        let effector = scene.effector.as_ref().map_or(0, |e| *e.get_ref());
        if effector >= facts.effectors {
            let span = scene.effector.as_ref().map_or(0..0, |e| e.span());
            let text = format!("effector {effector} of a device that has {}, from 0", facts.effectors);
            return Err(self.source.error(span, text).into());
        }
        let coupling = Coupling {
            stiffness: scene.stiffness.as_ref().map_or(COUPLING_SHARE * facts.stiffness, |k| k.get_ref().si),
            damping: scene.damping.as_ref().map_or(0.0, |b| b.get_ref().si),
            most: facts.peak_force,
        };
        let [fixed, sliding] = *scene.friction.get_ref();
        let friction = Friction { fixed, sliding };
        let (name, radius) = (scene.name.get_ref().clone(), scene.radius.get_ref().si);
        Ok(ToolSlot {
            tool: Tool::new(name, radius, friction, coupling, bodies),
            hand: Hand::new(scene.speed.get_ref().si),
            safety: ForceSafety::new(ForceLimits { peak: facts.peak_force, slew: scene.slew.get_ref().si }),
            device,
            effector: effector as usize,
            edit: None,
        })
    }

    /// Tells what is wrong with a model that is carried by a grid: nothing that stops it.
    fn judge(&mut self, name: &str, model: &Model) {
        for finding in &model.findings {
            if finding.severity(Use::Embedded) != Severity::Note {
                self.events.add(EventKind::Model, 0.0, || format!("body `{name}`: {finding}"));
            }
        }
    }
}
