//! Keys that choose a tool, or change how it is set.

use super::App;
use super::key_presses::{is_pressed, plain_presses, switches};
use eframe::egui::{self, Event, Key};

/// Factor of the tool's size or strength for a press of its key.
const KEY_STEP: f64 = 1.15;
/// Factor of the stiffness for a press of its key: four make an octave and a half.
const STIFFNESS_KEY_STEP: f64 = 1.3;

impl App {
    /// Does what the keys of these events say, before the next stroke begins.
    pub(super) fn tool_keys(&mut self, ui: &egui::Ui, events: &[Event]) {
        if ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        for tool in 0..self.tools.len() {
            let key = self.tools[tool].key(tool).and_then(|key| Key::from_name(&key.to_string()));
            if key.is_some_and(|key| is_pressed(events, key)) {
                self.choose_tool(tool);
            }
        }
        for (key, factor) in [(Key::OpenBracket, 1.0_f64 / KEY_STEP), (Key::CloseBracket, KEY_STEP)] {
            let presses = plain_presses(events, key);
            if presses > 0 {
                self.settings.resize(factor.powi(presses));
                self.resize_tool();
            }
        }
        for (key, factor) in [(Key::Minus, 1.0_f64 / KEY_STEP), (Key::Equals, KEY_STEP)] {
            let presses = plain_presses(events, key);
            if presses > 0 {
                self.settings.strengthen(self.tools[self.tool], factor.powi(presses));
                self.set_brush();
            }
        }
        for (key, factor) in [(Key::Comma, 1.0_f64 / STIFFNESS_KEY_STEP), (Key::Period, STIFFNESS_KEY_STEP)] {
            let presses = plain_presses(events, key);
            if presses > 0 {
                self.stiffen(self.stiffness * factor.powi(presses));
            }
        }
        for (axis, key) in [Key::X, Key::Y, Key::Z].into_iter().enumerate() {
            self.settings.symmetry[axis] ^= switches(events, key);
        }
        self.send_symmetry();
        if switches(events, Key::K) {
            self.toggle_release();
        }
    }
}
