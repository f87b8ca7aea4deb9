//! Opening a scene: creates its models, plugins, bodies and tools.

use super::body_contacts::BodyContacts;
use super::history::History;
use super::level_choice::{LevelChosen, ToolRadii, choose_level};
use super::obstacles::Obstacles;
use super::seam_pairs::Seam;
use super::seams::Seams;
use super::shared::{SharedModel, SharedParts};
use super::sleep::Sleep;
use super::step::TORQUE_AXES;
use super::step_limits::StepLimits;
use super::timeout::StepGuard;
use super::warning::Warnings;
use super::workers::Workers;
use super::{
    Choices, Clock, DeviceSlot, EventKind, Events, Frame, Loaded, Scratch, Session, SessionError, ToolSlot, place,
};
use crate::body::{
    Body, CellSource, Discretization, FailedTriangles, Lattice, LatticeError, MaterialRecipe, Model, RegionSettings,
    Sheet, Skin, StiffnessFactor, Subdivision, TetrahedralCells,
};
use crate::contact::{Friction, LayerLaw, SheetTips};
use crate::edit::BladeEdge;
use crate::memory::{MemoryAccount, MemoryBudget, document_bytes};
use crate::plan::Plan;
use crate::recording::RecordedHands;
use crate::scene::{
    BladeScene, BodyScene, EditScene, Extent, FixedScene, Level, PluginScene, Scene, Source, ToolScene, settings,
};
use crate::tool::{Coupling, ForceLimits, ForceSafety, Hand, TactilePad, TipMass, Tool, TorqueSafety};
use bytemuck::cast_slice;
use pliant_cut::CutMesh;
use pliant_host::{
    ContactLaw, DeviceInfo, Grid, HostError, Library, Material, ParamKind, ParamSettings, ParamValue, PluginInfo,
    PluginKind, SearchPath,
};
use pliant_mesh::check::{Severity, Use};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::require_for_mesh_elements;
use pliant_plugin_api::abi;
use pliant_plugin_api::lanes::check_vector_unit;
use pliant_solver::ForceModel;
use pliant_solver::{NodeSprings, Scheme, System};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use toml::Spanned;

/// Options of [`Session::open`].
pub struct Options {
    /// Folders in which plugins are searched for.
    pub search: SearchPath,
    /// Number of threads; 0 for all processors.
    pub threads: usize,
    /// Model file that replaces the one of the first body.
    pub mesh: Option<PathBuf>,
    /// Device information by device name: these devices are not opened, because the caller provides the poses of their hands.
    pub recorded: Option<Vec<(String, DeviceInfo)>>,
    /// Largest memory of the session, estimated before it is allocated.
    pub memory: MemoryBudget,
}

impl Options {
    /// Options with these plugin folders and number of threads (0 for all processors); models and devices are those of the scene, and memory is the
    /// default budget.
    pub fn new(search: SearchPath, threads: usize) -> Self {
        Self { search, threads, mesh: None, recorded: None, memory: MemoryBudget::default() }
    }
}

/// Default radius of a local region: the larger one of this many cells and of [`REGION_TOOL_RADII`] radii of the largest tool. A contact of radius a in
/// a region of radius Rb with a fixed boundary is too stiff by the factor (1 + 0.584 a/Rb)^1.5, at most 1.21 at four radii.
const REGION_CELLS: f64 = 10.0;
const REGION_TOOL_RADII: f64 = 4.0;

/// Default radius of a local region of cells with this edge, m, with a largest tool of this radius, m.
pub(super) fn region_radius(edge: f64, largest_tool: f64) -> f64 {
    (REGION_CELLS * edge).max(REGION_TOOL_RADII * largest_tool)
}
/// Parameter of materials that is a factor of all their stiffness.
const STIFFNESS: &str = "young";
/// Default stiffness of a coupling, as a fraction of the device's largest stiffness.
const COUPLING_SHARE: f64 = 0.3;

pub(super) type Given = BTreeMap<String, Spanned<toml::Value>>;

impl Session {
    /// Opens the parts of a scene that `plan` needs.
    ///
    /// # Errors
    /// Returns an error if a model or plugin cannot be used, or if an explicit integrator exceeds its step limit.
    pub fn open(scene: &Scene, source: &Source, plan: Plan, options: &Options) -> Result<Self, SessionError> {
        Self::open_shared(scene, source, plan, options, &SharedParts::default())
    }

    /// The same, reusing models and grids in `shared`. Results are bit-identical to those of [`Session::open`].
    ///
    /// # Errors
    /// Those of [`Session::open`].
    pub fn open_shared(
        scene: &Scene,
        source: &Source,
        plan: Plan,
        options: &Options,
        shared: &SharedParts,
    ) -> Result<Self, SessionError> {
        check_vector_unit().map_err(SessionError::VectorUnit)?;
        let dt = scene.time.dt.get_ref().si;
        let threads = match options.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            given => given,
        };
        let mut tool_radii = ToolRadii::default();
        for tool in &plan.tools {
            tool_radii.add(place::shape(&scene.tool[*tool], source)?.shape().length_scale());
        }
        let mut opening = Opening {
            source,
            options,
            shared,
            dt,
            tool_radii,
            levels: Vec::new(),
            loaded: Vec::new(),
            field_files: Vec::new(),
            recordings: Vec::new(),
            events: Events::default(),
            measured_keys: Vec::new(),
            seams: Vec::new(),
            memory: MemoryAccount::new(options.memory),
            regions: plan.tools.len(),
            is_implicit: scene.time.integrator.scheme().is_none_or(Scheme::is_implicit),
        };
        let (mut models, mut subdivisions) = (Vec::new(), Vec::new());
        for (i, body) in scene.body.iter().enumerate() {
            let instead = options.mesh.as_deref().filter(|_| i == 0);
            let smallest = opening.tool_radii.smallest;
            let key = || place::model_key(body, source, instead, smallest);
            opening.memory.add_body(body.name.get_ref());
            let model = shared.model(key, || place::model(body, source, instead, &opening.memory, smallest))?;
            if let Some(Subdivision { levels, why }) = &model.model.subdivision {
                let body = body.name.get_ref().clone();
                subdivisions.push(LevelChosen { body, level: *levels, why: why.clone() });
            }
            opening.memory.body(i).model = document_bytes(&model.model.document);
            opening.report_defects(body.name.get_ref(), &model.model);
            models.push((body.name.get_ref().clone(), model));
        }
        let devices = plan.devices.iter().map(|&d| opening.device(scene, d, &models)).collect::<Result<Vec<_>, _>>()?;
        let (mut bodies, mut standing) = (Vec::new(), Vec::new());
        for (i, (name, model)) in models.into_iter().enumerate() {
            if plan.moving[i] {
                bodies.push(opening.body(&scene.body[i], i, name, model, (&scene.edit, plan.cuts()))?);
            } else {
                standing.push((name, model.model));
            }
        }
        let mut tools = plan
            .tools
            .iter()
            .map(|&t| opening.tool(&scene.tool[t], &devices, scene, &plan, bodies.len()))
            .collect::<Result<Vec<_>, _>>()?;
        for (at, slot) in tools.iter_mut().enumerate() {
            slot.has_torque = plan.has_torque(at);
        }
        let unpaired = super::mirror::join(&mut tools, &plan.mirrors, &bodies);
        let (obstacles, obstacle_files) = opening.obstacles(scene)?;
        let places = scene.obstacle.iter().map(|obstacle| source.error(obstacle.name.span(), "").place()).collect();
        let count = bodies.len();
        let has_seams = opening.seams.iter().any(|seams| !seams.is_empty());
        let springs = (0..tools.len() + usize::from(has_seams)).map(|_| NodeSprings::default()).collect();
        let of_body = if has_seams { std::mem::take(&mut opening.seams) } else { Vec::new() };
        let seams = Seams::new(of_body);
        let body_contacts = BodyContacts::new(&plan, &bodies);
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
                contacts: Vec::new(),
                levels: opening.levels,
                subdivisions,
                preconditioners: Vec::new(),
            },
            memory: opening.memory.into_bodies(),
            loaded: opening.loaded,
            field_files: opening.field_files,
            obstacle_files,
            commands: Vec::with_capacity(super::recorded::most_commands(&opening.recordings)),
            recordings: opening.recordings,
            left_out: plan.left_out.clone(),
            events: opening.events,
            energy: plan.energy,
            warnings: Warnings::new(source.error(0..0, "").place(), plan.edits.len()),
            plan,
            clock: Clock { dt, steps: 0 },
            workers: Workers::new(threads, count),
            limits: StepLimits::new(&scene.time),
            integrators: Vec::new(),
            guard: StepGuard::new(scene.time.patience.get_ref().si),
            sleep: Sleep::new(scene.time.sleep.as_ref().map_or(0.0, |s| s.get_ref().si), count),
            moved: vec![0.0; count],
            sheet_tips: (0..count).map(|_| SheetTips::default()).collect(),
            obstacles: Obstacles::new(obstacles, places, count),
            body_contacts,
            seams,
            unpaired,
            ties: super::Ties::default(),
            scratch: Scratch { springs, has_seams, balls: Vec::new() },
            frame: Frame::default(),
            stiffness: super::StiffnessState::default(),
            history: History::default(),
            layers: super::SculptLayers::default(),
            divided: super::DividedBodies::new(count),
        };
        session.open_pads();
        let has_undo = session.recordings.iter().any(|recording| recording.has_undo());
        session.history.kept = !session.plan.history_steps.is_empty() || has_undo;
        session.sample(shared)?;
        session.check_contact_laws(scene, source)?;
        session.meet(scene);
        session.measure(shared, &opening.measured_keys)?;
        session.choose(scene)?;
        session.open_stitches(scene, source)?;
        session.check_paint_params(scene, source)?;
        session.limit_painting(scene, source);
        session.choices.threads = session.workers.all.threads();
        session.find_opening_warnings(scene, source, options.mesh.is_some())?;
        Ok(session)
    }
}

fn edge(blade: &BladeScene) -> BladeEdge {
    BladeEdge {
        length: blade.length.get_ref().si,
        direction: Vec3::from(*blade.direction.get_ref()).normalize(),
        toughness: blade.toughness.get_ref().si,
        tear: blade.tear.get_ref().si,
    }
}

/// A scene that is being opened.
pub(super) struct Opening<'a> {
    pub(super) source: &'a Source,
    pub(super) options: &'a Options,
    shared: &'a SharedParts,
    pub(super) dt: f64,
    pub(super) tool_radii: ToolRadii,
    /// Levels chosen where the scene leaves the choice.
    levels: Vec<LevelChosen>,
    loaded: Vec<Loaded>,
    field_files: Vec<PathBuf>,
    /// Recordings that devices take their hands from, each once.
    pub(super) recordings: Vec<Arc<RecordedHands>>,
    events: Events,
    /// For each moving body, the cache key of its frequencies; empty if it has none.
    measured_keys: Vec<String>,
    /// Seams of each moving body.
    seams: Vec<Vec<Seam>>,
    pub(super) memory: MemoryAccount,
    /// Largest number of contacts that have a local region at a time.
    pub(super) regions: usize,
    /// Whether the integrator may be an implicit one.
    pub(super) is_implicit: bool,
}

impl Opening<'_> {
    /// Finds a plugin, checks its parameters and records its file.
    pub(super) fn plugin(
        &mut self,
        kind: PluginKind,
        name: &Spanned<String>,
        given: &Given,
    ) -> Result<(&'static Library, &'static PluginInfo, ParamSettings), SessionError> {
        let (file, id, id_given) = match name.get_ref().split_once('#') {
            Some((file, id)) => (file, id, true),
            None => (name.get_ref().as_str(), name.get_ref().as_str(), false),
        };
        let search = &self.options.search;
        let found = search.find(file, self.source.folder()).map_err(|error| self.refused(name.span(), error))?;
        let library = Library::open(&found.path)?;
        let id = if id.contains(['/', '\\']) { found.name.as_str() } else { id };
        let only = || if id_given { None } else { library.only_plugin(kind) };
        let info = library.plugin(kind, id).or_else(|error| only().ok_or(error))?;
        let settings = settings(self.source, info, given)?;
        self.check_libraries(info, &settings, given)?;
        let path = library.path().display().to_string();
        if !self.loaded.iter().any(|l| l.path == path && l.id == info.id) {
            let (kind, id, version) = (kind.name(), info.id.clone(), info.version.clone());
            self.loaded.push(Loaded { kind, id, version, path });
        }
        Ok((library, info, settings))
    }

    /// Checks that no parameter names a library that the caller does not allow.
    fn check_libraries(&self, info: &PluginInfo, settings: &ParamSettings, given: &Given) -> Result<(), SessionError> {
        for (index, value) in settings {
            let param = &info.params[*index];
            // Text parameters are checked too, because only the plugin knows whether they are paths.
            let (ParamKind::Path | ParamKind::Text, ParamValue::Text(text)) = (&param.kind, value) else { continue };
            let span = given.get(&param.key).map_or(0..0, Spanned::span);
            let allowed = self.options.search.allowed().check_parameter(text.as_ref());
            allowed.map_err(|error| self.refused(span, error))?;
        }
        Ok(())
    }

    /// Opens the body `index` of the scene.
    fn body(
        &mut self,
        scene: &BodyScene,
        index: usize,
        name: String,
        shared: SharedModel,
        (edits, cuts): (&[EditScene], bool),
    ) -> Result<Body, SessionError> {
        let (library, info, settings) =
            self.plugin(PluginKind::Material, &scene.material.plugin, &scene.material.params)?;
        let material_key = format!("{} {} {settings:?}", library.path().display(), info.id);
        let material = Material::open(library, &info.id, &settings, self.dt).map_err(|error| {
            let material = &scene.material;
            self.refused(span_of(&error, &material.params, material.plugin.span()), error)
        })?;
        let model = Arc::clone(&shared.model);
        super::fields::check_paint_range(edits, self.source, info, &settings)?;
        let fields = super::fields::fields(scene, self.source, info, &settings, &shared)?;
        let fibres = super::fibres::fibres(scene, self.source, &material, &shared)?;
        let files = scene.field.iter().filter_map(|field| field.get_ref().file());
        let files = files.filter(|file| !self.source.factors.contains_key(file.get_ref()));
        let files = files.chain(scene.fibre.iter().filter_map(|fibre| fibre.get_ref().csv.as_ref()));
        self.field_files.extend(files.map(|file| self.source.folder().join(file.get_ref())));
        let mut discretization = match &scene.sheet {
            Some(sheet) => {
                let of_mesh = |error| place::of_mesh(scene, &model.document, error);
                require_for_mesh_elements(&model.findings).map_err(of_mesh)?;
                self.check_sheet(scene, index, model.surface.triangles.len())?;
                Discretization::Sheet(Box::new(Sheet::new(&model, place::warp(sheet.get_ref()))))
            }
            None => Discretization::Lattice(Box::new(match shared.model.tetrahedra.clone() {
                Some(cells) => self.tetrahedra(scene, index, (&shared, cells), &material)?,
                None => self.lattice(scene, index, &shared, &material)?,
            })),
        };
        let plane = info.fields().position(|param| param.key == STIFFNESS);
        let params = info.fields().map(|param| param.key.clone()).collect();
        let stiffness = plane.map(|plane| StiffnessFactor::new(plane, info.fields().count()));
        match &mut discretization {
            Discretization::Lattice(lattice) => {
                (lattice.fields, lattice.fibres, lattice.stiffness) = (fields, fibres, stiffness);
            }
            Discretization::Sheet(sheet) => (sheet.fields, sheet.stiffness) = (fields, stiffness),
        }
        let made = if scene.sheet.is_some() { CutMesh::sheet } else { CutMesh::new };
        let recipe = MaterialRecipe { library, id: info.id.clone(), settings: settings.clone(), dt: self.dt };
        let measured_key = |lattice: &Lattice| {
            let settings = &lattice.settings;
            format!("{} {settings:?} {material_key} {:?} {:?}", lattice.key, scene.field, scene.fibre)
        };
        self.measured_keys.push(discretization.lattice().map(measured_key).unwrap_or_default());
        let skin = Skin::new(&model, shared.tree);
        let fixing = |f: &Spanned<FixedScene>| place::fixing(f, self.source, &model, &discretization);
        let fixings = scene.fixed.iter().map(fixing).collect::<Result<_, _>>()?;
        let seams = self.seams(scene, &model, &discretization)?;
        self.seams.push(seams);
        Ok(Body {
            name,
            number: self.seams.len() as u32 - 1,
            cut_margins: std::collections::HashMap::default(),
            cut: cuts.then(|| Box::new(made(&model.document, &model.placement))),
            model,
            skin,
            system: System::new(Box::new(material)),
            recipe: Arc::new(recipe),
            discretization,
            samples: Arc::default(),
            layer_stiffness: 0.0,
            layer_mass: 0.0,
            params,
            tints: Default::default(),
            failed_triangles: FailedTriangles::default(),
            most_stiffening: f64::INFINITY,
            fixings,
            symmetry: None,
            frozen: None,
        })
    }

    fn lattice(
        &mut self,
        scene: &BodyScene,
        index: usize,
        shared: &SharedModel,
        material: &Material,
    ) -> Result<Lattice, SessionError> {
        let name = scene.name.get_ref();
        let families = material.requests().iter().fold(0, |all, r| all | r.families);
        let (library, info, settings) =
            self.plugin(PluginKind::Grid, &scene.grid.get_ref().plugin, &scene.grid.get_ref().params)?;
        let radius = match scene.grid.get_ref().region {
            Extent::Whole => Some(f64::INFINITY),
            Extent::Local => scene.grid.get_ref().radius.as_ref().map(|r| r.get_ref().si),
        };
        let level = match *scene.grid.get_ref().level.get_ref() {
            Level::At(level) => level,
            Level::Auto => {
                let (level, why) = choose_level(&shared.model.surface, self.tool_radii, radius);
                self.levels.push(LevelChosen { body: name.clone(), level, why });
                level
            }
        };
        let relaxation = scene.grid.get_ref().relaxation.get_ref().si;
        // Slopes that are continued across a crack would know what is on its other side.
        let can_fail = material.requests().iter().any(|r| r.kind == abi::TETRAHEDRON && r.flags & abi::CAN_FAIL != 0);
        let region = RegionSettings {
            level,
            radius: radius.unwrap_or(0.0),
            relaxation,
            smooth: scene.grid.get_ref().smooth.as_ref().is_none_or(|smooth| *smooth.get_ref()) && !can_fail,
        };
        let (number, path, dt) = (shared.number, library.path().display(), self.dt);
        let key = format!("{number} {level} {dt:e} {path} {} {settings:?}", info.id);
        let grid = match self.shared.idle_grid(&key) {
            Some(grid) => grid,
            None => {
                self.check_grid(scene, index, level)?;
                let mut grid = Grid::open(library, &info.id, &settings, self.dt)
                    .map_err(|error| self.refused(scene.grid.get_ref().level.span(), error))?;
                let surface = &shared.model.surface;
                let built = grid.build(cast_slice(&surface.points), &surface.triangles, level);
                built.map_err(|error| self.level_refused(scene, level, surface.bounds().longest_edge(), error))?;
                grid
            }
        };
        let grid = CellSource::Grid(self.shared.pool(key.clone(), grid));
        let mut lattice = Lattice::new(grid, key, region, families).map_err(|error| match error {
            LatticeError::Host(error) => self.refused(scene.grid.get_ref().level.span(), error),
            error => SessionError::Lattice { body: name.clone(), error },
        })?;
        if radius.is_none() {
            lattice.settings.radius = region_radius(lattice.edge(), self.tool_radii.largest);
        }
        self.check_lattice(scene, index, shared, material, &mut lattice)?;
        Ok(lattice)
    }

    /// The lattice of the tetrahedra of a file, simulated as a whole.
    fn tetrahedra(
        &mut self,
        scene: &BodyScene,
        index: usize,
        (shared, cells): (&SharedModel, Arc<TetrahedralCells>),
        material: &Material,
    ) -> Result<Lattice, SessionError> {
        self.check_tetrahedra(scene, index, shared, (material, &cells.facts()))?;
        if cells.corner_weights().is_some() && material.requests().iter().any(|r| r.flags & abi::CAN_FAIL != 0) {
            let (id, name) = (&material.info().id, scene.name.get_ref());
            let text = format!(
                "material `{id}` of body `{name}` can fail, and its mesh has quadratic tetrahedra of 10 nodes, which cannot; allowed are tetrahedra \
                 of 4 nodes (`gmsh -3 -order 1`)"
            );
            return Err(self.source.error(scene.material.plugin.span(), text).into());
        }
        for note in cells.mesh().notes.iter().filter(|note| !note.is_doubtful()) {
            self.events.add(EventKind::Model, 0.0, || format!("body `{}`: {note}", scene.name.get_ref()));
        }
        // Nothing of a whole body returns to rest, so the relaxation is not used.
        let settings = RegionSettings { level: 1, radius: f64::INFINITY, relaxation: 1.0, smooth: false };
        let key = format!("{} tetrahedra", shared.number);
        let made = Lattice::new(CellSource::Tetrahedra(cells), key, settings, 0);
        made.map_err(|error| SessionError::Lattice { body: scene.name.get_ref().clone(), error })
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
            was: None,
            turned: None,
            tip: scene.mass.as_ref().map(|mass| TipMass::new(mass.get_ref().si)),
            hand_was: None,
            on_sheets: Vec3::zeros(),
            drift: Vec3::zeros(),
        })
    }

    /// Opens the contact law of a tool.
    fn contact_law(&mut self, scene: &PluginScene) -> Result<Arc<ContactLaw>, SessionError> {
        let at_plugin = |error| match error {
            SessionError::Host(error @ HostError::NoSuchPlugin { .. }) => {
                SessionError::Scene(self.source.error(scene.plugin.span(), error.to_string()))
            }
            error => error,
        };
        let found = self.plugin(PluginKind::ContactLaw, &scene.plugin, &scene.params);
        let (library, info, settings) = found.map_err(at_plugin)?;
        let law = ContactLaw::open(library, &info.id, &settings, self.dt);
        law.map(Arc::new).map_err(|error| self.refused(span_of(&error, &scene.params, scene.plugin.span()), error))
    }

    /// The error of a plugin that refuses a parameter, at the span of the scene.
    pub(super) fn refused(&self, span: Range<usize>, error: HostError) -> SessionError {
        if error.is_refusal() { self.source.error(span, error.to_string()).into() } else { error.into() }
    }

    /// The error of a grid that refuses a level for a body with this longest edge (m). Suggests the coarsest level whose cells are at most as wide
    /// as the radius of the largest tool.
    fn level_refused(&self, scene: &BodyScene, level: u32, longest: f64, error: HostError) -> SessionError {
        let span = scene.grid.get_ref().level.span();
        let edge = |level: u32| longest / (1_u64 << (level - 1)) as f64;
        // The cell edge halves from level to level; 64 levels exceed the range of a shift.
        let fitting = (1..level.min(64)).find(|&level| edge(level) <= self.tool_radii.largest);
        let Some(fitting) = fitting.filter(|_| error.is_refusal()) else {
            return self.refused(span, error);
        };
        let [edge, radius] = [edge(fitting), self.tool_radii.largest].map(|length| 1e3 * length);
        let text =
            format!("{error}; level {fitting}, with cells of {edge:.3} mm, fits the tool, of radius {radius:.3} mm");
        self.source.error(span, text).into()
    }

    /// Reports defects of a model that is embedded in a grid, as events; none of them prevents the simulation.
    fn report_defects(&mut self, name: &str, model: &Model) {
        for finding in &model.findings {
            if finding.severity(Use::Embedded) != Severity::Note {
                self.events.add(EventKind::Model, 0.0, || format!("body `{name}`: {finding}"));
            }
        }
    }
}

/// Span of the scene for a plugin's error: that of the first parameter it names, or of the plugin.
pub(super) fn span_of(error: &HostError, given: &Given, plugin: Range<usize>) -> Range<usize> {
    let text = error.to_string();
    let named = given.iter().filter_map(|(key, value)| Some((text.find(&format!("`{key}`"))?, value.span())));
    named.min_by_key(|(at, _)| *at).map_or(plugin, |(_, span)| span)
}
