//! The lower edge of the window: what has happened, what the tool does, and the keys.

use super::App;
use super::dropped::takes_drops;
use crate::strings;
use eframe::egui::{self, Align2, Key, RichText, Vec2, vec2};

/// Width of the list of messages, points.
const MESSAGES_WIDTH: f32 = 560.0;
/// Largest share of the height of the window that the list of messages takes.
const LIST_SHARE: f32 = 0.5;
/// Size of the list of keys, points: all of it without scrolling.
const KEYS_SIZE: Vec2 = vec2(960.0, 560.0);
/// Largest share of the window that it takes.
const KEYS_SHARE: f32 = 0.85;
/// Space between the columns and rows of the list of keys, points.
const KEY_SPACING: Vec2 = vec2(14.0, 4.0);

impl App {
    /// The last message with the list of all, and below it what the tool does with the list of keys.
    pub(super) fn status_bar(&mut self, ui: &mut egui::Ui) {
        egui::Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                self.message_list(ui);
                let last = self.messages.last().map_or("", |(_, message)| message.as_str());
                ui.add(egui::Label::new(last.lines().next().unwrap_or_default()).truncate()).on_hover_text(last);
            });
            ui.horizontal(|ui| {
                let keys = egui::Button::selectable(self.shows_keys, strings::KEYS_BUTTON).frame_when_inactive(true);
                self.shows_keys ^= ui.add(keys).clicked();
                let tool = self.tools[self.tool];
                let inverse = tool.inverse(&self.tools).map(|tool| tool.name());
                let hint = match &self.model {
                    Some(_) => strings::tool_hint(tool.name(), tool.gesture(), inverse),
                    None => strings::no_model(takes_drops()).to_owned(),
                };
                ui.add(egui::Label::new(&hint).truncate()).on_hover_text(&hint);
            });
        });
    }

    /// A button that shows all messages, whole, the newest first.
    fn message_list(&mut self, ui: &mut egui::Ui) {
        ui.menu_button(strings::messages(self.messages.len()), |ui| {
            ui.set_max_width(MESSAGES_WIDTH);
            let height = LIST_SHARE * ui.ctx().content_rect().height();
            egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
                if self.messages.is_empty() {
                    ui.label(strings::NO_MESSAGES);
                }
                for (when, message) in self.messages.iter().rev() {
                    ui.small(strings::ago(when.elapsed()));
                    ui.label(message);
                }
            });
        });
    }

    /// All keys and buttons of the mouse, until it is closed.
    pub(super) fn key_window(&mut self, context: &egui::Context) {
        if !self.shows_keys {
            self.keys_were_shown = false;
            return;
        }
        let size = KEYS_SIZE.min(KEYS_SHARE * context.content_rect().size());
        let mut is_closed = context.input(|input| input.key_pressed(Key::Escape));
        let window = egui::Window::new("keys").title_bar(false).resizable(false);
        window.anchor(Align2::CENTER_CENTER, [0.0; 2]).show(context, |ui| {
            ui.set_min_width(size.x);
            is_closed |= ui.button(strings::CLOSE).clicked();
            let area = egui::ScrollArea::both().max_width(size.x).max_height(size.y).min_scrolled_height(size.y);
            area.show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    for (column, groups) in strings::KEYS.chunks(2).enumerate() {
                        egui::Grid::new(("keys", column)).num_columns(2).spacing(KEY_SPACING).show(ui, |ui| {
                            groups.iter().for_each(|(heading, keys)| key_rows(ui, heading, keys));
                        });
                    }
                });
            });
        });
        // A window is measured in its first frame and drawn in the next; nothing else asks for that at once.
        if std::mem::replace(&mut self.keys_were_shown, !is_closed) == is_closed {
            context.request_repaint();
        }
        self.shows_keys = !is_closed;
    }
}

/// A group of keys as rows of a grid.
fn key_rows(ui: &mut egui::Ui, heading: &str, keys: &[(&str, &str)]) {
    ui.heading(heading);
    ui.end_row();
    for (key, effect) in keys {
        ui.label(RichText::new(*key).strong());
        ui.label(*effect);
        ui.end_row();
    }
}
