//! Leaving the open model, to close the window or to open another file: a stroke in the hand ends first, and work that is not saved is asked about.

use super::App;
use crate::opening::OpenRequest;
use crate::sim::{Abandoned, Command};
use crate::strings;
use eframe::egui::{self, Key, ViewportCommand};
use std::path::PathBuf;

/// What happens once the open model may be left.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Departure {
    /// The window closes.
    Quit,
    /// Another model, or another shape, is opened.
    Open {
        request: Box<OpenRequest>,
        /// The session that it is the shape of, if that has ended without closing.
        recovered: Option<Abandoned>,
    },
}

/// A question to the user.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Question {
    /// Whether to save before the open model is left.
    Unsaved(Departure),
    /// Whether to open the shape of a session that has ended without closing.
    Recover(Abandoned),
    /// Whether to write over a file that is not the one that is open.
    Replace(PathBuf),
}

impl App {
    /// The window closes only when nothing is lost by it.
    pub(super) fn close_requests(&mut self, context: &egui::Context) {
        if context.input(|input| input.viewport().close_requested()) && !self.may_close {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            self.leave(Departure::Quit);
        }
    }

    /// Leaves the open model once the stroke in the hand has ended and all work is saved or given up.
    pub(super) fn leave(&mut self, departure: Departure) {
        // The last request counts.
        (self.asked_after_save, self.dialog) = (None, None);
        if matches!(self.question, Some(Question::Unsaved(_) | Question::Replace(_))) {
            self.question = None;
        }
        let is_by_pointer = self.model.as_ref().is_some_and(|model| !model.hand.is_by_device());
        let is_busy = is_by_pointer && self.is_stroke_under_way();
        // A second request does not wait: the simulation may never answer. What a device holds ends when its hand lets go.
        if !is_by_pointer || self.leaving.is_some() || (self.is_unsaved() && !is_busy) {
            self.leaving = None;
            return self.save_or_depart(departure);
        }
        self.let_go();
        self.leaving = Some(departure);
        self.send(Command::ReportShape);
    }

    /// Ends the stroke in the hand as if its button, or key, were let go.
    fn let_go(&mut self) {
        self.keys.let_go();
        if let Some(model) = &mut self.model {
            self.is_press_spent = model.hand.is_busy();
            model.hand.let_go();
        }
    }

    /// No stroke is under way, and the model has this shape.
    pub(super) fn take_shape(&mut self, shape: u64) {
        // The stroke may have begun so late that the simulation has not heard of it.
        if self.leaving.is_some() && self.is_stroke_under_way() {
            return self.send(Command::ReportShape);
        }
        self.status.shape = shape;
        if let Some(departure) = self.leaving.take() {
            self.save_or_depart(departure);
        }
    }

    /// Asks about work that is not saved, or leaves.
    fn save_or_depart(&mut self, departure: Departure) {
        if self.is_unsaved() || self.is_stroke_under_way() {
            self.log.event("unsaved", &[]);
            self.question = Some(Question::Unsaved(departure));
        } else {
            self.depart(departure);
        }
    }

    /// Leaves the open model, with what is not saved.
    fn depart(&mut self, departure: Departure) {
        match departure {
            Departure::Quit => {
                self.may_close = true;
                self.context.send_viewport_cmd(ViewportCommand::Close);
            }
            Departure::Open { request, recovered } => {
                // The shape that was recovered before is saved or given up.
                std::mem::replace(&mut self.recovered, recovered).into_iter().for_each(Abandoned::discard);
                self.open(*request);
            }
        }
    }

    pub(super) fn question_window(&mut self, context: &egui::Context) {
        let Some(question) = self.question.take() else { return };
        let (mut save, mut discard, mut cancel, mut recover) = (false, false, false, false);
        egui::Window::new("question").title_bar(false).anchor(egui::Align2::CENTER_CENTER, [0.0; 2]).show(
            context,
            |ui| {
                ui.strong(match &question {
                    Question::Recover(found) => strings::recovery(found.path()),
                    Question::Replace(path) => strings::replace(path),
                    Question::Unsaved(_) => strings::UNSAVED.to_owned(),
                });
                ui.horizontal(|ui| {
                    recover = matches!(question, Question::Recover(_)) && ui.button(strings::RECOVER).clicked();
                    save = matches!(question, Question::Unsaved(_)) && ui.button(strings::SAVE).clicked();
                    discard = ui
                        .button(match question {
                            Question::Recover(_) => strings::DISCARD_SHAPE,
                            Question::Replace(_) => strings::REPLACE,
                            Question::Unsaved(_) => strings::DISCARD,
                        })
                        .clicked();
                    cancel = ui.button(strings::CANCEL).clicked() || ui.input(|input| input.key_pressed(Key::Escape));
                });
            },
        );
        match question {
            Question::Unsaved(departure) if save => {
                self.asked_after_save = Some(departure);
                self.save();
            }
            Question::Recover(found) if recover => {
                let request = Box::new(found.request(&self.request));
                self.leave(Departure::Open { request, recovered: Some(found) });
            }
            Question::Unsaved(departure) if discard => self.depart(departure),
            Question::Recover(found) if discard => found.discard(),
            Question::Replace(path) if discard => self.send(Command::Save { path, for_user: true }),
            _ if cancel => self.asked_after_save = None,
            question => self.question = Some(question),
        }
    }
}
