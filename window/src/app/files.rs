//! Files, menus, shortcuts and questions.

use super::App;
use super::leaving::{Departure, Question};
use crate::opening::{MODEL_ENDINGS, OpenRequest};
use crate::recent::{add_recent_file, recent_files};
use crate::sim::Command;
use crate::strings;
use eframe::egui::{self, Key, KeyboardShortcut, Modifiers, ViewportCommand};
use pliant_mesh::TetMesh;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Asks for a file: its path in a field, or the system's dialog.
pub(super) struct FileDialog {
    purpose: Purpose,
    path: String,
    /// Answer of the system's dialog, which has a thread of its own.
    browsing: Option<Receiver<Option<PathBuf>>>,
    /// Whether the field takes keys.
    takes_keys: bool,
}

/// What a file is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    Open,
    SaveAs,
    SaveSession,
    Export,
    Reference,
}

const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
const SAVE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);
const SAVE_AS: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
const SAVE_SESSION: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::ALT), Key::S);
const EXPORT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::E);
const QUIT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Q);
const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
const REDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
const REDO_TOO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);
const PICTURE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::F12);
const KEYS: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::F1);

impl App {
    pub(super) fn menu(&mut self, ui: &mut egui::Ui) {
        egui::Panel::top("menu").show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.menu_button(strings::FILE, |ui| {
                    let is_open = self.model.is_some();
                    let item = |ui: &mut egui::Ui, text: &str, shortcut: KeyboardShortcut, enabled: bool| {
                        let text_of_keys = ui.ctx().format_shortcut(&shortcut);
                        let button = egui::Button::new(text).shortcut_text(text_of_keys);
                        ui.add_enabled(enabled, button).clicked()
                    };
                    if item(ui, strings::OPEN, OPEN, true) {
                        self.ask_for_file(Purpose::Open);
                    }
                    self.recent_menu(ui);
                    if item(ui, strings::SAVE, SAVE, is_open) {
                        self.save();
                    }
                    if item(ui, strings::SAVE_AS, SAVE_AS, is_open) {
                        self.ask_for_file(Purpose::SaveAs);
                    }
                    if item(ui, strings::SAVE_SESSION, SAVE_SESSION, is_open) {
                        self.ask_for_file(Purpose::SaveSession);
                    }
                    if ui.add_enabled(is_open, egui::Button::new(strings::OPEN_REFERENCE)).clicked() {
                        self.ask_for_file(Purpose::Reference);
                    }
                    if item(ui, strings::EXPORT, EXPORT, is_open) {
                        self.ask_for_file(Purpose::Export);
                    }
                    if item(ui, strings::PICTURE, PICTURE, is_open) {
                        self.save_picture();
                    }
                    if item(ui, strings::QUIT, QUIT, true) {
                        ui.ctx().send_viewport_cmd(ViewportCommand::Close);
                    }
                });
                self.undo_buttons(ui);
                ui.separator();
                let name = self.request.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                ui.label(format!("{name}{}", if self.is_unsaved() { " *" } else { "" }));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let is_dark = ui.visuals().dark_mode;
                    if ui.button(if is_dark { strings::LIGHT } else { strings::DARK }).clicked() {
                        ui.ctx().set_theme(if is_dark { egui::Theme::Light } else { egui::Theme::Dark });
                    }
                });
            });
        });
    }

    /// Buttons that take strokes back and make them again.
    fn undo_buttons(&mut self, ui: &mut egui::Ui) {
        let (begun, undone) = (self.status.begun, self.status.strokes.len() - self.status.begun);
        let button = |ui: &mut egui::Ui, text: &str, keys: &KeyboardShortcut, enabled: bool| {
            let keys = ui.ctx().format_shortcut(keys);
            ui.add_enabled(enabled, egui::Button::new(text)).on_hover_text(keys).clicked()
        };
        if button(ui, strings::UNDO, &UNDO, begun > 0) {
            self.undo();
        }
        if button(ui, strings::REDO, &REDO_TOO, undone > 0) {
            self.redo();
        }
    }

    /// Takes the last stroke back.
    pub fn undo(&mut self) {
        self.log.event("undo", &[]);
        self.follows_stiffness = true;
        self.send(Command::Undo);
    }

    /// Makes the stroke again that was taken back last.
    pub fn redo(&mut self) {
        self.log.event("redo", &[]);
        self.follows_stiffness = true;
        self.send(Command::Redo);
    }

    pub(super) fn shortcuts(&mut self, context: &egui::Context) {
        let pressed = |shortcut: &KeyboardShortcut| context.input_mut(|input| input.consume_shortcut(shortcut));
        // Those with Shift first: without it they would be taken for the others.
        if pressed(&SAVE_AS) && self.model.is_some() {
            self.ask_for_file(Purpose::SaveAs);
        }
        if pressed(&SAVE_SESSION) && self.model.is_some() {
            self.ask_for_file(Purpose::SaveSession);
        }
        if pressed(&EXPORT) && self.model.is_some() {
            self.ask_for_file(Purpose::Export);
        }
        // Several may come in a slow frame.
        let presses = |keys: &KeyboardShortcut| {
            context.input_mut(|input| input.count_and_consume_key(keys.modifiers, keys.logical_key))
        };
        for _ in 0..presses(&REDO) + presses(&REDO_TOO) {
            self.redo();
        }
        for _ in 0..presses(&UNDO) {
            self.undo();
        }
        if pressed(&SAVE) && self.model.is_some() {
            self.save();
        }
        if pressed(&OPEN) {
            self.ask_for_file(Purpose::Open);
        }
        if pressed(&PICTURE) && self.model.is_some() {
            self.save_picture();
        }
        if pressed(&KEYS) {
            self.shows_keys = !self.shows_keys;
        }
        if pressed(&QUIT) {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    /// Saves to the file that is known, or asks for one.
    pub fn save(&mut self) {
        match self.save_path.clone() {
            Some(path) => self.send(Command::Save { path, for_user: true }),
            None => self.ask_for_file(Purpose::SaveAs),
        }
    }

    pub(super) fn ask_for_file(&mut self, purpose: Purpose) {
        let path = match purpose {
            Purpose::Open => self.request.path.clone(),
            Purpose::SaveAs => self.save_path.clone().unwrap_or_else(|| self.request.path.with_extension("obj")),
            Purpose::SaveSession => self.request.path.with_extension("rec"),
            Purpose::Export => self.request.path.with_extension("glb"),
            Purpose::Reference => self.request.path.with_extension("png"),
        };
        self.dialog =
            Some(FileDialog { purpose, path: path.to_string_lossy().into_owned(), browsing: None, takes_keys: false });
    }

    /// Opens another file with the present settings, after the question about strokes that are not saved. The open model stays where there is no such file.
    pub(super) fn open_another(&mut self, path: PathBuf) {
        if !path.is_file() {
            return self.fail(strings::no_such_file(&path));
        }
        let request = OpenRequest { path, shape: None, unit: None, substance: None, ..self.request.clone() };
        self.leave(Departure::Open { request: Box::new(request), recovered: None });
    }

    /// The files that were opened last.
    fn recent_menu(&mut self, ui: &mut egui::Ui) {
        let others: Vec<PathBuf> = self.recent.iter().filter(|file| **file != self.request.path).cloned().collect();
        ui.add_enabled_ui(!others.is_empty(), |ui| {
            ui.menu_button(strings::OPEN_RECENT, |ui| {
                for path in others {
                    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                        self.open_another(path);
                    }
                }
            });
        });
    }

    /// Puts the open file first in the list of recent ones.
    pub(super) fn remember_opened(&mut self) {
        let Some(folder) = self.state_folder() else { return };
        let listed = add_recent_file(&folder, &self.request.path).and_then(|()| recent_files(&folder));
        match listed {
            Ok(files) => self.recent = files,
            Err(error) => self.tell(strings::recent_problem(&error)),
        }
    }

    /// Dialogs, questions and errors.
    pub(super) fn windows(&mut self, context: &egui::Context) {
        self.file_window(context);
        self.question_window(context);
        self.key_window(context);
        let mut is_closed = false;
        if let Some(error) = &self.error {
            egui::Window::new("error").title_bar(false).anchor(egui::Align2::CENTER_CENTER, [0.0; 2]).show(
                context,
                |ui| {
                    ui.set_max_width(620.0);
                    ui.label(egui::RichText::new(error).monospace().strong());
                    let is_escape = ui.input(|input| input.key_pressed(egui::Key::Escape));
                    is_closed = ui.button(strings::CLOSE).clicked() || is_escape;
                },
            );
        }
        if is_closed {
            self.error = None;
        }
    }

    fn file_window(&mut self, context: &egui::Context) {
        let Some(mut dialog) = self.dialog.take() else { return };
        let title = match dialog.purpose {
            Purpose::Open => strings::OPEN,
            Purpose::SaveAs => strings::SAVE_AS,
            Purpose::SaveSession => strings::SAVE_SESSION,
            Purpose::Export => strings::EXPORT,
            Purpose::Reference => strings::OPEN_REFERENCE,
        };
        let (mut answer, mut is_done, mut is_confirmed) = (None, false, false);
        if let Some(browsing) = &dialog.browsing {
            match browsing.try_recv() {
                // The system's dialog asks before it gives a file that is there.
                Ok(Some(path)) => (answer, is_confirmed) = (Some(path), true),
                Ok(None) | Err(TryRecvError::Disconnected) => dialog.browsing = None,
                Err(TryRecvError::Empty) => {}
            }
        }
        egui::Window::new(title).collapsible(false).anchor(egui::Align2::CENTER_CENTER, [0.0; 2]).show(context, |ui| {
            let field =
                ui.add(egui::TextEdit::singleline(&mut dialog.path).desired_width(420.0).hint_text(strings::PATH));
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            if !field.has_focus() && !entered {
                field.request_focus();
            }
            if field.has_focus() && !std::mem::replace(&mut dialog.takes_keys, true) {
                self.log.event("dialog", &[("title", title.to_owned())]);
            }
            ui.horizontal(|ui| {
                if ui.button(title).clicked() || entered {
                    answer = Some(PathBuf::from(dialog.path.trim()));
                }
                if ui.add_enabled(dialog.browsing.is_none(), egui::Button::new(strings::BROWSE)).clicked() {
                    dialog.browsing = browse(dialog.purpose, &dialog.path, ui.ctx().clone());
                }
                is_done = ui.button(strings::CANCEL).clicked() || ui.input(|input| input.key_pressed(Key::Escape));
            });
        });
        match (answer, dialog.purpose) {
            (Some(path), Purpose::Open) => {
                self.open_another(path);
            }
            (Some(path), Purpose::SaveAs | Purpose::Export) if TetMesh::is_name(&path.to_string_lossy()) => {
                self.fail(strings::tetrahedra_not_written(&path));
            }
            (Some(path), Purpose::SaveAs | Purpose::Export)
                if path.exists() && !is_confirmed && self.save_path.as_ref() != Some(&path) =>
            {
                self.question = Some(Question::Replace(path));
            }
            (Some(path), Purpose::SaveAs | Purpose::Export) => self.send(Command::Save { path, for_user: true }),
            (Some(path), Purpose::Reference) => self.open_reference(&path),
            (Some(path), Purpose::SaveSession) => self.send(Command::SaveSession { path }),
            (None, _) if !is_done => self.dialog = Some(dialog),
            (None, _) => self.asked_after_save = None,
        }
    }

    /// Writes what is seen as `pliant-N.png` beside the model.
    fn save_picture(&mut self) {
        let folder = self.request.path.parent().map_or_else(PathBuf::new, PathBuf::from);
        self.pictures += 1;
        let path = folder.join(format!("pliant-{}.png", self.pictures));
        self.tell(strings::picture_saved(&path));
        self.log.event("picture", &[("path", path.display().to_string())]);
        let write = move |picture: std::sync::Arc<egui::ColorImage>| {
            let [width, height] = picture.size.map(|edge| edge as u32);
            let bytes: Vec<u8> = picture.pixels.iter().flat_map(|pixel| pixel.to_array()).collect();
            // A picture that cannot be written is no reason to stop an artist.
            let _ = image::save_buffer(&path, &bytes, width, height, image::ColorType::Rgba8);
        };
        self.context.send_viewport_cmd(ViewportCommand::Screenshot(egui::ScreenshotCallback::new(write)));
    }
}

/// Opens the system's dialog on a thread of its own.
fn browse(purpose: Purpose, path: &str, context: egui::Context) -> Option<Receiver<Option<PathBuf>>> {
    let (sender, receiver) = channel();
    let path = PathBuf::from(path);
    let ask = move || {
        let mut dialog = rfd::FileDialog::new();
        if let Some(folder) = path.parent().filter(|folder| folder.is_dir()) {
            dialog = dialog.set_directory(folder);
        }
        let answer = match purpose {
            Purpose::Open => dialog.add_filter(strings::MODELS_AND_SCENES, &MODEL_ENDINGS).pick_file(),
            Purpose::Reference => dialog.add_filter(strings::IMAGES, &["png", "jpg", "jpeg"]).pick_file(),
            Purpose::SaveAs | Purpose::SaveSession | Purpose::Export => {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                dialog.set_file_name(name).save_file()
            }
        };
        let _ = sender.send(answer);
        context.request_repaint();
    };
    std::thread::Builder::new().name("dialog".into()).spawn(ask).ok().map(|_| receiver)
}
