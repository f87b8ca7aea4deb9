//! The window: what it shows, and what happens in it.

mod device_panel;
mod files;
mod gauges;
mod icons;
mod key_pointer;
mod key_presses;
mod layers;
mod log;
mod measure;
mod model;
mod panels;
mod reference_panel;
mod status_bar;
mod timings;
mod unit_question;
mod viewport;

pub use log::EventLog;
pub use measure::{Measurement, measure_without_window};
pub use timings::{Latency, PointerLatency, START_STAGES, SeenHand, StartStage, StartTimes};

use crate::arguments::Arguments;
use crate::gl::{Line, Shading, Stereo, SurfaceRenderer, Wireframe};
use crate::opening::OpenRequest;
use crate::picture::Upload;
use crate::recent::recent_files;
use crate::sim::{
    Abandoned, Command, EarlySimulation, ModelFormat, Notice, Simulation, Status, abandoned, state_folder,
};
use crate::strings;

use crate::tools::{ToolKind, ToolSettings};
use crate::view::Camera;
use eframe::egui;
use files::{FileDialog, Question};
use gauges::{ForcePlot, FrameTimes};
use key_pointer::KeyPointer;
use layers::LayerPanel;
use measure::ScriptedStrokes;
use model::Model;
use pliant_editor::{DeviceChoice, Substance};
use pliant_engine::body::Axes;
use reference_panel::Reference;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A renderer that a picture's callback can use.
pub type SharedRenderer = Arc<Mutex<dyn SurfaceRenderer + Send>>;

/// What the renderer is still to be given.
#[derive(Default)]
struct PendingUploads {
    /// Whether it has the bodies of another model.
    is_new_model: bool,
    uploads: Vec<Upload>,
    reference: Option<Arc<image::RgbaImage>>,
    /// Whether a picture of a model was painted since this was asked last.
    was_painted: bool,
}

/// How the model is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSettings {
    /// Of the surfaces.
    pub shading: Shading,
    /// How edges of triangles are drawn.
    pub wireframe: Wireframe,
    /// Whether surfaces have the colours and textures of the file.
    pub file_colours: bool,
    /// Opacity of surfaces, 0 to 1.
    pub opacity: f32,
    /// How the pictures of two eyes are shown.
    pub stereo: Stereo,
    /// Whether there is a grid on the ground.
    pub ground: bool,
    /// Whether the simulated cells are drawn.
    pub cells: bool,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            shading: Shading::Studio,
            wireframe: Wireframe::Off,
            file_colours: true,
            opacity: 1.0,
            stereo: Stereo::Off,
            ground: true,
            cells: false,
        }
    }
}

/// Time in which a message that comes again is the same one: a stroke that is refused is so in many of its steps.
const SAME_MESSAGE: Duration = Duration::from_secs(5);
/// Factors of the stiffness that may be asked for while a model is open.
const STIFFNESS_FACTORS: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

/// The window: what is shown and what has been asked of the simulation.
pub struct App {
    context: egui::Context,
    renderer: Option<SharedRenderer>,
    pending: Arc<Mutex<PendingUploads>>,
    log: EventLog,
    request: OpenRequest,
    simulation: Option<Simulation>,
    status: Status,
    model: Option<Model>,
    camera: Camera,
    view: ViewSettings,
    tools: Vec<ToolKind>,
    tool: usize,
    settings: ToolSettings,
    /// Axes of the symmetry that the session has; a new one has none.
    sent_symmetry: Axes,
    /// Files that were opened last, the newest first.
    recent: Vec<PathBuf>,
    /// Where Save writes.
    save_path: Option<PathBuf>,
    /// Number of strokes that the saved file has, and whether any was made or taken back since.
    saved_strokes: Option<usize>,
    /// What to open once the present shape is written.
    after_save: Option<OpenRequest>,
    quit_after_save: bool,
    /// The session whose shape is open, until it is saved or the window is closed.
    recovered: Option<Abandoned>,
    dialog: Option<FileDialog>,
    question: Option<Question>,
    /// Whether the unit of the model is asked for.
    asks_unit: bool,
    /// Whether the list of keys is shown.
    shows_keys: bool,
    /// Whether it was in the frame before.
    keys_were_shown: bool,
    error: Option<String>,
    /// What happened, and when.
    messages: Vec<(Instant, String)>,
    /// Device plugins, once they were looked for.
    devices: Option<Vec<DeviceChoice>>,
    /// Share of the force that a device renders, of what it can.
    force_share: f64,
    /// The pointer of those who use no mouse.
    keys: KeyPointer,
    layers: LayerPanel,
    reference: Reference,
    force: ForcePlot,
    times: FrameTimes,
    start: StartTimes,
    latency: PointerLatency,
    /// What the picture of the last frame was of.
    painted: Option<StartStage>,
    /// Whether times are printed.
    prints_timings: bool,
    script: Option<ScriptedStrokes>,
    /// Summary and step times of a measurement that has ended.
    measured: Arc<Mutex<Option<Measurement>>>,
    pictures: u32,
    /// Whether the material that is chosen is not the one that is simulated.
    is_material_changed: bool,
    /// Young's modulus (Pa) that the model was opened with; `None` for sheets and scenes.
    opened_young: Option<f64>,
    /// Stiffness that is asked for, over that at the opening.
    stiffness: f64,
    /// Whether the history was gone through since it was asked for: the session says what it is then.
    follows_stiffness: bool,
    /// Folders of shapes that are, or will be, open in another material; each goes with its entry.
    shapes: Vec<TempDir>,
    /// Pixels of the screen for a point.
    pixels_per_point: f32,
}

impl App {
    /// A window without a model. A test may do without a renderer.
    pub fn new(context: egui::Context, renderer: Option<SharedRenderer>, log: EventLog) -> Self {
        Self {
            context,
            renderer,
            pending: Arc::default(),
            log,
            request: OpenRequest::new(PathBuf::new()),
            simulation: None,
            status: Status::default(),
            model: None,
            camera: Camera::default(),
            view: ViewSettings::default(),
            tools: ToolKind::all(),
            tool: 0,
            settings: ToolSettings::default(),
            sent_symmetry: [false; 3],
            // What is wrong with the list is told when a file is opened.
            recent: state_folder().and_then(|folder| recent_files(&folder).ok()).unwrap_or_default(),
            save_path: None,
            saved_strokes: Some(0),
            after_save: None,
            quit_after_save: false,
            recovered: None,
            dialog: None,
            question: None,
            asks_unit: false,
            shows_keys: false,
            keys_were_shown: false,
            error: None,
            messages: Vec::new(),
            devices: None,
            force_share: 1.0,
            keys: KeyPointer::default(),
            layers: LayerPanel::default(),
            reference: Reference::default(),
            force: ForcePlot::default(),
            times: FrameTimes::default(),
            start: StartTimes::since(Instant::now()),
            latency: PointerLatency::default(),
            painted: None,
            prints_timings: false,
            script: None,
            measured: Arc::default(),
            pictures: 0,
            is_material_changed: false,
            opened_young: None,
            stiffness: 1.0,
            follows_stiffness: false,
            shapes: Vec::new(),
            pixels_per_point: 1.0,
        }
    }

    /// Opens what the program was called with. `early`: the simulation that opens the path of the arguments already, if there is one.
    pub fn begin(&mut self, arguments: &Arguments, early: Option<EarlySimulation>) {
        self.start = StartTimes::since(arguments.began);
        self.start.reach(StartStage::Window);
        self.prints_timings = arguments.timings;
        self.script = arguments.measure.map(ScriptedStrokes::new);
        let request = arguments.request();
        match (early, arguments.path.is_some()) {
            (Some(early), true) => {
                self.log.event("opening", &[("path", request.path.display().to_string())]);
                let started = early.join(&self.context);
                self.follow(started, request);
            }
            (None, true) => self.open(request),
            (_, false) => self.request = request,
        }
        let name = |path: &std::path::Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        let wanted = arguments.path.as_deref().map(name);
        // Without a model any shape is offered, with one those of the same.
        let of_model = |found: &Abandoned| wanted.as_ref().is_none_or(|wanted| found.path() == wanted);
        if self.script.is_none()
            && let Some(found) = abandoned(arguments.autosave.as_deref()).into_iter().find(of_model)
        {
            self.log.event("recovery offered", &[("path", found.path().display().to_string())]);
            self.question = Some(Question::Recover(found));
        }
    }

    /// Times of the start of the program.
    pub fn start_times(&self) -> &StartTimes {
        &self.start
    }

    /// How soon the picture shows what the pointer does.
    pub fn pointer_latency(&self) -> &PointerLatency {
        &self.latency
    }

    /// Where the result of a measurement will be.
    pub fn measurement(&self) -> Arc<Mutex<Option<Measurement>>> {
        Arc::clone(&self.measured)
    }

    /// Opens a model or a scene in the place of what is open.
    pub fn open(&mut self, request: OpenRequest) {
        self.log.event("opening", &[("path", request.path.display().to_string())]);
        let before = self.predecessor(&request);
        self.close();
        let context = self.context.clone();
        let started = Simulation::start(request.clone(), true, before, move || context.request_repaint());
        self.follow(started, request);
    }

    /// Ends what is open.
    fn close(&mut self) {
        self.model = None;
        // The old session ends before the new one begins, as both would ask for the same processors; but for one whose device goes on.
        self.simulation = None;
    }

    /// Shows a simulation that opens what was asked for.
    fn follow(&mut self, started: std::io::Result<Simulation>, request: OpenRequest) {
        self.shapes.retain(|folder| request.shape.as_ref().is_some_and(|shape| shape.starts_with(folder.path())));
        self.status = Status::default();
        self.layers = LayerPanel::default();
        // The shape that is open may not be the one of the file.
        (self.stiffness, self.follows_stiffness) = (1.0, false);
        self.is_material_changed = false;
        (self.error, self.saved_strokes) = (None, request.shape.is_none().then_some(0));
        let is_written = !request.is_scene() && !request.is_tetrahedral();
        self.save_path = is_written.then(|| request.path.clone());
        match started {
            Ok(simulation) => self.simulation = Some(simulation),
            Err(error) => self.fail(strings::no_thread(&error)),
        }
        self.request = request;
    }

    /// The newest strokes and gauges.
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// Number of messages so far.
    pub fn message_count(&self) -> usize {
        self.messages.len()
    }

    /// The error that is shown.
    pub fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }

    /// Whether a model is open.
    pub fn is_open(&self) -> bool {
        self.model.is_some()
    }

    /// Tints of the drawn vertices that are pinned or painted, as [`pliant_engine::body::Body::tints`].
    pub fn tints(&self) -> impl Iterator<Item = f32> + '_ {
        self.model.iter().flat_map(Model::tints)
    }

    /// The tool and how it is set.
    pub fn tool(&self) -> (ToolKind, ToolSettings) {
        (self.tools[self.tool], self.settings)
    }

    /// Where the model is seen from.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// How the model is shown.
    pub fn view(&self) -> ViewSettings {
        self.view
    }

    /// Shows a message for a while. One that is shown already is shown longer.
    fn tell(&mut self, text: String) {
        match self.messages.last_mut() {
            Some((when, last)) if *last == text && when.elapsed() < SAME_MESSAGE => *when = Instant::now(),
            _ => self.messages.push((Instant::now(), text)),
        }
    }

    fn fail(&mut self, text: String) {
        self.log.event("failed", &[("text", text.clone())]);
        self.error = Some(text);
    }

    fn send(&self, command: Command) {
        if let Some(simulation) = &self.simulation {
            simulation.send(command);
        }
    }

    /// Takes in what the simulation says.
    fn listen(&mut self) {
        let Some(simulation) = &mut self.simulation else { return };
        let before = (self.status.done, self.status.strokes.len());
        let edits = self.status.edits;
        self.status = simulation.status().clone();
        for notice in simulation.notices() {
            self.take(notice);
        }
        let now = (self.status.done, self.status.strokes.len());
        if before != now {
            let (done, undone) = (now.0.to_string(), (now.1 - now.0).to_string());
            self.log.event("history", &[("done", done), ("undone", undone)]);
        }
        if self.status.edits != edits {
            self.saved_strokes = self.saved_strokes.filter(|saved| *saved == self.status.edits);
        }
        // An undo that is not done yet leaves the stiffness that was asked for last.
        if self.follows_stiffness {
            self.take_stiffness(self.status.stiffness.wanted);
        }
    }

    fn take(&mut self, notice: Notice) {
        match notice {
            Notice::Opened(opened) => {
                self.start.reach(StartStage::Opened);
                let (seconds, is_reopened) = (opened.seconds, self.request.shape.is_some() && self.recovered.is_none());
                let material_folder = self.request.material_folder().map(PathBuf::from);
                self.asks_unit = self.is_unit_unsure(&opened.facts);
                let model = Model::new(*opened, material_folder, self.context.clone());
                self.log.event(
                    "opened",
                    &[("seconds", format!("{seconds:.3}")), ("triangles", model.triangles().to_string())],
                );
                if !is_reopened {
                    self.look_at_all(&model);
                }
                if self.request.is_tetrahedral() && !model.facts.is_tetrahedral {
                    self.tell(strings::TETRAHEDRA_LEFT.to_owned());
                }
                let is_solid = model.facts.taken_as == Some(Substance::Solid);
                self.opened_young = is_solid.then_some(self.request.solid.young);
                self.model = Some(model);
                self.open_remembered_reference();
                self.remember_opened();
                self.resize_tool();
                self.set_brush();
                self.sent_symmetry = [false; 3];
            }
            Notice::Failed(text) => {
                self.model = None;
                self.fail(text);
            }
            Notice::Saved { path, for_user, problems } => {
                self.saved(path, for_user);
                problems.into_iter().for_each(|problem| self.tell(problem));
            }
            Notice::NotSaved(text) => {
                (self.after_save, self.quit_after_save) = (None, false);
                self.fail(text);
            }
            Notice::NoDevice(text) => {
                self.request.device = None;
                self.log.event("no device", &[("text", text.clone())]);
                self.error = Some(text);
            }
            Notice::Message(text) => {
                self.log.event("message", &[("text", text.clone())]);
                self.tell(text);
            }
            Notice::Ended(_) => {}
        }
    }

    fn saved(&mut self, path: PathBuf, for_user: bool) {
        if for_user {
            self.log.event("saved", &[("path", path.display().to_string())]);
            self.tell(strings::model_saved(&path));
            if ModelFormat::of(&path) != ModelFormat::Obj {
                // An export: it does not hold the lines of the model.
                return;
            }
            self.saved_strokes = Some(self.status.edits);
            self.recovered.take().into_iter().for_each(Abandoned::discard);
            self.save_path = Some(path);
            if std::mem::take(&mut self.quit_after_save) {
                self.context.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        } else if let Some(request) = self.after_save.take() {
            let (target, is_same) = (self.save_path.clone(), request.path == self.request.path);
            self.open(OpenRequest { shape: Some(path), ..request });
            if is_same {
                self.save_path = target;
            }
        }
    }

    /// Whether there are strokes that have not been saved.
    pub fn is_unsaved(&self) -> bool {
        self.saved_strokes.is_none()
    }

    /// Looks at all of a model.
    fn look_at_all(&mut self, model: &Model) {
        let (centre, radius) = model.ball();
        self.camera.frame(centre, radius, self.times.aspect());
    }

    /// Gives the tool of the session the size that is set.
    fn resize_tool(&mut self) {
        let Some(model) = &self.model else { return };
        let hand = model.facts.hand;
        // A larger ball meets more of the surface, so the spring to the hand grows as the contact does: with the radius.
        let (radius, coupling) = (self.settings.size * hand.radius, self.settings.size * hand.coupling);
        self.send(Command::ResizeTool { radius, coupling });
    }

    /// Gives the edits of the session the strength and the falloff that are set.
    fn set_brush(&mut self) {
        let ToolSettings { brush, falloff, .. } = self.settings;
        self.send(Command::SetBrush { strength: brush, falloff });
    }

    /// Gives the session the symmetry that is set, between two strokes.
    fn send_symmetry(&mut self) {
        let wanted = self.settings.symmetry;
        let Some(model) = self.model.as_ref().filter(|model| !model.hand.is_busy()) else { return };
        if wanted != self.sent_symmetry {
            self.send(Command::SetSymmetry { axes: wanted, centre: model.symmetry(wanted).centre });
            self.sent_symmetry = wanted;
        }
    }

    /// Asks for a stiffness, as a factor of that at the opening.
    fn stiffen(&mut self, factor: f64) {
        self.follows_stiffness = false;
        self.take_stiffness(factor.clamp(*STIFFNESS_FACTORS.start(), *STIFFNESS_FACTORS.end()));
        self.send(Command::SetStiffness { factor: self.stiffness });
    }

    /// Shows a stiffness as the one that is asked for.
    fn take_stiffness(&mut self, factor: f64) {
        if self.stiffness == factor {
            return;
        }
        self.stiffness = factor;
        if let Some(young) = self.opened_young {
            self.request.solid.young = young * factor;
        }
    }

    /// Radius of the tool, m; 0 without a model.
    pub fn tool_radius(&self) -> f64 {
        self.settings.size * self.model.as_ref().map_or(0.0, |model| model.facts.hand.radius)
    }

    /// Shows the window and does what happens in it.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        self.pixels_per_point = ui.ctx().pixels_per_point();
        self.times.begin();
        self.note_painted();
        self.listen();
        if let Some(model) = &mut self.model {
            model.update(&mut self.times, self.view);
            for problem in model.take_materials() {
                self.log.event("material", &[("problem", problem.clone())]);
                self.messages.push((Instant::now(), problem));
            }
        }
        self.see_hand();
        self.update_reference(ui.ctx());
        self.shortcuts(ui.ctx());
        self.dropped_files(ui.ctx());
        self.menu(ui);
        self.status_bar(ui);
        self.left_panel(ui);
        self.right_panel(ui);
        self.send_symmetry();
        self.viewport(ui);
        self.windows(ui.ctx());
        self.close_requests(ui.ctx());
        self.run_script();
        self.track_hand();
        self.times.end();
        self.painted = Some(if self.model.is_some() { StartStage::ModelShown } else { StartStage::FirstFrame });
        // Gauges move on by themselves.
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(500));
    }

    /// The picture of the frame before is on screen. Where that is a stage of the start, the frame after it comes at once, for its time to be known.
    fn note_painted(&mut self) {
        let Some(stage) = self.painted.take().filter(|_| self.renderer.is_some()) else { return };
        let was_painted = self.pending.lock().is_ok_and(|mut pending| std::mem::take(&mut pending.was_painted));
        if stage == StartStage::ModelShown && !was_painted {
            return; // egui has thrown the frame away
        }
        if !self.start.reach(stage) {
            return;
        }
        if let (StartStage::ModelShown, Some(seconds)) = (stage, self.start.of(stage)) {
            self.log.event("model shown", &[("seconds", format!("{seconds:.3}"))]);
            if self.prints_timings {
                eprintln!("{}", strings::start_timings(&self.start));
            }
        }
    }

    /// Takes in where the newest frame of the simulation has the hand.
    fn see_hand(&mut self) {
        let time = self.context.input(|input| input.time);
        let tool = self.model.as_ref().and_then(Model::tool);
        let seen =
            tool.map(|tool| SeenHand { position: tool.hand, is_in_contact: tool.contact.is_some() || tool.grips });
        let radius = self.tool_radius();
        self.latency.begin_frame(time, seen, radius);
    }

    /// Notes where the hand was sent in this frame.
    fn track_hand(&mut self) {
        let radius = self.tool_radius();
        if let Some(model) = self.model.as_ref().filter(|model| !model.hand.is_by_device())
            && let Some(position) = model.hand.position()
        {
            self.latency.send(position, radius, model.hand.is_busy());
        }
        let is_start = self.painted_is_awaited();
        if is_start || self.latency.is_waiting() {
            self.context.request_repaint();
        }
    }

    /// Whether the picture of this frame is the first of its kind.
    fn painted_is_awaited(&self) -> bool {
        let stage = if self.model.is_some() { StartStage::ModelShown } else { StartStage::FirstFrame };
        self.renderer.is_some() && self.start.of(stage).is_none()
    }

    fn run_script(&mut self) {
        let (Some(script), Some(model)) = (&mut self.script, &mut self.model) else { return };
        if script.advance(model, &self.camera, self.tools[self.tool]) {
            self.context.request_repaint();
            return;
        }
        self.script = None;
        // The stroke that is under way ends before the simulation does.
        self.model.take().into_iter().for_each(|mut model| _ = model.hand.end());
        let notices = self.simulation.take().map(Simulation::finish).unwrap_or_default();
        let summary = notices.into_iter().find_map(|notice| match notice {
            Notice::Ended(ended) => Some(ended),
            _ => None,
        });
        if let (Some(ended), Ok(mut measured)) = (summary, self.measured.lock()) {
            *measured = Some(Measurement::new(*ended, Some(&self.times)));
        }
        self.saved_strokes = Some(0);
        self.context.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    /// Lines in the scene: the grid on the ground, and the simulated cells.
    fn lines(&self) -> Vec<Line> {
        self.model.as_ref().map_or_else(Vec::new, |model| model.lines(self.view, &self.camera))
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        if self.prints_timings {
            eprintln!("{}", strings::pointer_timings(&self.latency));
        }
        self.model = None;
        self.simulation = None;
        self.shapes.clear();
        // Whoever closes the window has saved, or was asked.
        self.recovered.take().into_iter().for_each(Abandoned::discard);
    }
}
