//! The simulation behind the window: what is asked of it, and what it says.

use super::App;
use super::layers::LayerPanel;
use super::model::Model;
use super::timings::StartStage;
use crate::opening::OpenRequest;
use crate::sim::{Abandoned, Command, ModelFormat, Notice, Simulation, Status};
use crate::strings;
use pliant_editor::Substance;
use std::path::PathBuf;

impl App {
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
        self.closed_unit = self.model.take().and_then(|model| model.facts.unit);
        // The old session ends before the new one begins, as both would ask for the same processors; but for one whose device goes on.
        self.simulation = None;
    }

    /// Shows a simulation that opens what was asked for.
    pub(super) fn follow(&mut self, started: std::io::Result<Simulation>, request: OpenRequest) {
        self.shapes.retain(|folder| request.shape.as_ref().is_some_and(|shape| shape.starts_with(folder.path())));
        self.status = Status::default();
        self.layers = LayerPanel::default();
        // The shape that is open may not be the one of the file.
        (self.stiffness, self.follows_stiffness) = (1.0, false);
        self.is_material_changed = false;
        self.leaving = None;
        (self.error, self.saved_shape) = (None, request.shape.is_none().then_some(0));
        let is_written = !request.is_scene() && !request.is_tetrahedral();
        self.save_path = is_written.then(|| request.path.clone());
        match started {
            Ok(simulation) => self.simulation = Some(simulation),
            Err(error) => self.fail(strings::no_thread(&error)),
        }
        self.request = request;
    }

    /// Sends a command to the simulation, if there is one.
    pub(super) fn send(&self, command: Command) {
        if let Some(simulation) = &self.simulation {
            simulation.send(command);
        }
    }

    /// Takes in what the simulation says.
    pub(super) fn listen(&mut self) {
        let Some(simulation) = &mut self.simulation else { return };
        let counts = |status: &Status| (status.done, status.begun, status.strokes.len());
        let (before, was_at_rest) = (counts(&self.status), self.status.is_at_rest);
        self.status = simulation.status().clone();
        for notice in simulation.notices() {
            self.take(notice);
        }
        if self.status.is_at_rest != was_at_rest {
            self.log.event("rest", &[("is_at_rest", self.status.is_at_rest.to_string())]);
        }
        let now @ (done, begun, all) = counts(&self.status);
        if before != now {
            self.log.event("history", &[("done", done.to_string()), ("undone", (all - begun).to_string())]);
        }
        // An undo that is not done yet leaves the stiffness that was asked for last.
        if self.follows_stiffness {
            self.take_stiffness(self.status.stiffness.wanted);
        }
    }

    /// Takes in one notice.
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
                match (self.closed_unit, model.facts.unit) {
                    _ if !is_reopened => self.look_at_all(&model),
                    // What was in the picture stays there.
                    (Some(before), Some(now)) => self.camera.scale(now.metres() / before.metres()),
                    _ => {}
                }
                if self.request.is_tetrahedral() && !model.facts.is_tetrahedral {
                    self.tell(strings::TETRAHEDRA_LEFT.to_owned());
                }
                let is_solid = model.facts.taken_as == Some(Substance::Solid);
                self.opened_young = is_solid.then_some(self.request.solid.young);
                self.model = Some(model);
                self.opened = Some(self.request.clone());
                self.open_remembered_reference();
                self.remember_opened();
                self.resize_tool();
                self.set_brush();
                self.sent_symmetry = [false; 3];
            }
            Notice::Failed(text) => self.take_failure(text),
            Notice::Saved { path, for_user, shape, problems } => {
                self.saved(path, for_user, shape);
                problems.into_iter().for_each(|problem| self.tell(problem));
            }
            Notice::Shape(shape) => self.take_shape(shape),
            Notice::NotSaved(text) => {
                (self.after_save, self.asked_after_save) = (None, None);
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

    /// The model cannot be opened, or goes no further.
    fn take_failure(&mut self, text: String) {
        let was_opening = self.model.take().is_none();
        (self.leaving, self.asked_after_save) = (None, None);
        if let Some(before) = self.opened.take().filter(|_| was_opening) {
            self.open_again(before);
        } else {
            // Nothing is left that could be saved. Autosave has the last shape, and the next start offers it; so it does with one that could not be recovered.
            (self.saved_shape, self.recovered) = (Some(self.status.shape), None);
        }
        self.fail(text);
    }

    /// Opens the model again that was open before one that cannot be opened: in its material with the present shape, if that was to be opened in another material.
    fn open_again(&mut self, before: OpenRequest) {
        if before.path == self.request.path {
            let (shape, target) = (self.request.shape.clone(), self.save_path.clone());
            self.open(OpenRequest { shape, ..before });
            self.save_path = target;
        } else {
            self.recovered = None;
            // What it had of strokes was saved or given up.
            self.open(OpenRequest { shape: None, ..before });
        }
    }

    /// The model was written: `for_user` says whether to the file of the user or to open it in another material.
    fn saved(&mut self, path: PathBuf, for_user: bool, shape: u64) {
        if for_user {
            self.log.event("saved", &[("path", path.display().to_string())]);
            self.tell(strings::model_saved(&path));
            if ModelFormat::of(&path) != ModelFormat::Obj {
                // An export: it does not hold the lines of the model.
                self.asked_after_save = None;
                return;
            }
            // The status may come later.
            (self.status.shape, self.saved_shape) = (shape, Some(shape));
            self.recovered.take().into_iter().for_each(Abandoned::discard);
            self.save_path = Some(path);
            if let Some(departure) = self.asked_after_save.take() {
                self.leave(departure);
            }
        } else if let Some(request) = self.after_save.take() {
            let (target, is_same) = (self.save_path.clone(), request.path == self.request.path);
            self.open(OpenRequest { shape: Some(path), ..request });
            if is_same {
                self.save_path = target;
            }
        }
    }
}
