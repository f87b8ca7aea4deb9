//! The window: what it shows, and what happens in it.

mod device_panel;
mod dropped;
mod files;
mod gauges;
mod icons;
mod key_pointer;
mod key_presses;
mod layers;
mod leaving;
mod log;
mod measure;
mod messages;
mod model;
mod panels;
mod queries;
mod redraw;
mod reference_panel;
mod session_settings;
mod shown_frame;
mod simulation;
mod status_bar;
mod timings;
mod tool_keys;
mod unit_question;
mod view_settings;
mod viewport;

pub use log::EventLog;
pub use measure::{Measurement, measure_without_window};
pub use timings::{Latency, PointerLatency, START_STAGES, SeenHand, StartStage, StartTimes};
pub use view_settings::ViewSettings;

use crate::arguments::Arguments;
use crate::drops::{DragNews, DraggedFiles};
use crate::gl::{Line, SurfaceRenderer};
use crate::opening::OpenRequest;
use crate::picture::Upload;
use crate::recent::recent_files;
use crate::sim::{Abandoned, EarlySimulation, Simulation, Status, abandoned, state_folder};
use crate::strings;
use crate::tools::{ToolKind, ToolSettings};
use crate::view::Camera;
use eframe::egui;
use files::FileDialog;
use gauges::{ForcePlot, FrameTimes};
use key_pointer::KeyPointer;
use layers::LayerPanel;
use leaving::{Departure, Question};
use measure::ScriptedStrokes;
use model::Model;
use pliant_editor::{DeviceChoice, LengthUnit};
use pliant_engine::body::Axes;
use reference_panel::Reference;
use std::path::PathBuf;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex};
use std::time::Instant;
use tempfile::TempDir;

/// A renderer that a picture's callback can use.
pub type SharedRenderer = Arc<Mutex<dyn SurfaceRenderer + Send>>;

/// Data that the renderer has not received yet.
#[derive(Default)]
struct PendingUploads {
    /// Whether it has the bodies of another model.
    is_new_model: bool,
    uploads: Vec<Upload>,
    reference: Option<Arc<image::RgbaImage>>,
    /// Whether a picture of a model was painted since the last query of this flag.
    was_painted: bool,
}

/// The window: what is shown and what has been asked of the simulation.
pub struct App {
    context: egui::Context,
    renderer: Option<SharedRenderer>,
    pending: Arc<Mutex<PendingUploads>>,
    log: EventLog,
    request: OpenRequest,
    /// The request of the model that was opened last.
    opened: Option<OpenRequest>,
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
    /// File to which Save writes.
    save_path: Option<PathBuf>,
    /// The shape of the saved file, as in [`Status::shape`]; `None` of one that was never saved.
    saved_shape: Option<u64>,
    /// What to open once the present shape is written.
    after_save: Option<OpenRequest>,
    /// What follows once the model is saved: the answer to a question was to save first.
    asked_after_save: Option<Departure>,
    /// What waits until no stroke is under way.
    leaving: Option<Departure>,
    /// Whether the window closes when it is asked to: nothing is lost by it, or the user has said so.
    may_close: bool,
    /// Whether the button is still down that began a stroke which has ended without it.
    is_press_spent: bool,
    /// The session whose shape is open, until it is saved or the window is closed.
    recovered: Option<Abandoned>,
    dialog: Option<FileDialog>,
    question: Option<Question>,
    /// Whether the unit of the model is asked for.
    asks_unit: bool,
    /// Unit of the model that was open before; `None` of a scene, or if none was.
    closed_unit: Option<LengthUnit>,
    /// Whether the list of keys is shown.
    shows_keys: bool,
    /// Whether the list of keys was shown in the frame before.
    keys_were_shown: bool,
    error: Option<String>,
    /// What happened, and when.
    messages: Vec<(Instant, String)>,
    /// Device plugins, once they were looked for.
    devices: Option<Vec<DeviceChoice>>,
    /// Force that the device renders over the force that it can render, 0 to 1.
    force_share: f64,
    /// The pointer that keys move, for use without a mouse.
    keys: KeyPointer,
    layers: LayerPanel,
    reference: Reference,
    /// What is dragged over the window, where the window library is not the one that tells it.
    drags: Option<Receiver<DragNews>>,
    /// Files that are over the window now, as `drags` tells.
    dragged: DraggedFiles,
    force: ForcePlot,
    /// s, time of the frame since which the model is at rest; `None` while it moves
    rest_since: Option<f64>,
    times: FrameTimes,
    start: StartTimes,
    latency: PointerLatency,
    /// Stage of the opening that the picture of the last frame shows; `None` without a picture.
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
    /// Requested stiffness over that at the opening of the model, 1.
    stiffness: f64,
    /// Whether an undo or redo has run since `stiffness` was set, so that `stiffness` is taken from the session.
    follows_stiffness: bool,
    /// Folders of shapes that are, or will be, open in another material; each goes with its entry.
    shapes: Vec<TempDir>,
    /// Pixels of the screen per point of the interface.
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
            opened: None,
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
            saved_shape: Some(0),
            after_save: None,
            asked_after_save: None,
            leaving: None,
            may_close: false,
            is_press_spent: false,
            recovered: None,
            dialog: None,
            question: None,
            asks_unit: false,
            closed_unit: None,
            shows_keys: false,
            keys_were_shown: false,
            error: None,
            messages: Vec::new(),
            devices: None,
            force_share: 1.0,
            keys: KeyPointer::default(),
            layers: LayerPanel::default(),
            reference: Reference::default(),
            drags: None,
            dragged: DraggedFiles::default(),
            force: ForcePlot::default(),
            rest_since: None,
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
        // Without a model every saved shape is offered, with one only those of the same file.
        let of_model = |found: &Abandoned| wanted.as_ref().is_none_or(|wanted| found.path() == wanted);
        if self.script.is_none()
            && let Some(found) = abandoned(arguments.autosave.as_deref()).into_iter().find(of_model)
        {
            self.log.event("recovery offered", &[("path", found.path().display().to_string())]);
            self.question = Some(Question::Recover(found));
        }
    }

    /// Hears of files that are dragged over the window, beside what the window library tells.
    pub fn hear_of_drags(&mut self, drags: Receiver<DragNews>) {
        self.drags = Some(drags);
    }

    /// Looks at all of a model.
    fn look_at_all(&mut self, model: &Model) {
        let (centre, radius) = model.ball();
        self.camera.frame(centre, radius, self.times.aspect());
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
        self.hovered_files(ui.ctx());
        self.close_requests(ui.ctx());
        self.run_script();
        self.track_hand();
        self.times.end();
        self.painted = Some(if self.model.is_some() { StartStage::ModelShown } else { StartStage::FirstFrame });
        self.schedule_redraw(ui.input(|input| input.time));
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
        // The window closes after a save, or after the user has declined one.
        self.recovered.take().into_iter().for_each(Abandoned::discard);
    }
}
