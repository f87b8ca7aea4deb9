//! The panel of the sculpt layers: the topmost first, the base below all.

use super::App;
use crate::sim::Command;
use crate::strings;
use eframe::egui::{self, Key, Slider};
use pliant_engine::session::{SculptLayerState, SessionCommand};
use std::sync::Arc;

/// What the panel remembers between frames.
#[derive(Debug, Default)]
pub(super) struct LayerPanel {
    /// A strength that is being dragged: its layer and the value, which the session follows.
    dragged: Option<(u32, f64)>,
    /// Strengths to show hidden layers with again, by layer.
    shown: Vec<(u32, f64)>,
    /// A layer that is being renamed, and its name so far.
    renamed: Option<(u32, String)>,
    /// Names of the layers in the last frame: where they change, by undo too, so do the numbers of layers.
    names: Vec<Arc<str>>,
}

impl LayerPanel {
    /// Forgets what it knows by the number of a layer if there are other layers than in the last frame.
    fn follow(&mut self, layers: &[SculptLayerState]) {
        if !layers.iter().map(|layer| &layer.name).eq(&self.names) {
            let names = layers.iter().map(|layer| Arc::clone(&layer.name)).collect();
            *self = Self { names, ..Self::default() };
        }
    }
}

impl App {
    /// The layers and what strokes are recorded in.
    pub(super) fn layer_panel(&mut self, ui: &mut egui::Ui) {
        if self.model.is_none() {
            return;
        }
        ui.heading(strings::LAYERS);
        let layers = self.status.layers.clone();
        self.layers.follow(&layers);
        if ui.button(strings::NEW_LAYER).on_hover_text(strings::NEW_LAYER_HINT).clicked() {
            let is_taken = |name: &String| layers.iter().any(|layer| *layer.name == **name);
            let name = (1..).map(strings::layer_name).find(|name| !is_taken(name)).unwrap_or_default();
            self.change_layers(SessionCommand::AddLayer { name });
        }
        for (layer, state) in layers.iter().enumerate().rev() {
            ui.push_id(layer, |ui| self.layer_row(ui, layer as u32, state));
        }
        let records_base = layers.iter().all(|layer| !layer.records);
        if !layers.is_empty()
            && ui.selectable_label(records_base, strings::BASE).on_hover_text(strings::BASE_HINT).clicked()
            && !records_base
        {
            self.change_layers(SessionCommand::RecordLayer { layer: None });
        }
    }

    fn layer_row(&mut self, ui: &mut egui::Ui, layer: u32, state: &SculptLayerState) {
        let name = state.name.to_string();
        ui.horizontal(|ui| {
            let mut visible = state.strength > 0.0;
            let eye = ui.add_enabled(!state.is_fixed, egui::Checkbox::without_text(&mut visible));
            let eye = eye.on_hover_text(strings::LAYER_VISIBLE_HINT);
            let label = strings::layer_visible(&name);
            eye.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, visible, &label));
            if eye.changed() {
                self.show_layer(layer, state.strength, visible);
            }
            self.layer_name(ui, layer, state, &name);
            let merge = ui.small_button(strings::MERGE).on_hover_text(strings::MERGE_HINT);
            if merge.clicked() {
                self.change_layers(SessionCommand::MergeLayer { layer });
            }
            let delete = ui.add_enabled(!state.is_fixed, egui::Button::new(strings::DELETE).small());
            if delete.on_hover_text(strings::DELETE_HINT).on_disabled_hover_text(strings::FIXED_HINT).clicked() {
                self.change_layers(SessionCommand::DeleteLayer { layer });
            }
        });
        if state.is_fixed {
            ui.small(strings::LAYER_FIXED).on_hover_text(strings::FIXED_HINT);
            return;
        }
        let dragged = self.layers.dragged.filter(|(other, _)| *other == layer).map(|(_, strength)| strength);
        let mut strength = dragged.unwrap_or(state.strength);
        let slider = ui.horizontal(|ui| {
            let slider = ui.add(Slider::new(&mut strength, 0.0..=1.0).max_decimals(2));
            if ui.small_button(strings::RENAME).clicked() {
                self.layers.renamed = Some((layer, name.clone()));
            }
            slider
        });
        let slider = slider.inner;
        let label = strings::layer_strength(&name);
        slider.widget_info(|| egui::WidgetInfo::slider(true, strength, &label));
        if slider.changed() {
            self.layers.dragged = Some((layer, strength));
            self.change_layers(SessionCommand::SetLayerStrength { layer, strength });
        } else if dragged.is_some() && !slider.dragged() && (dragged == Some(state.strength) || !slider.has_focus()) {
            self.layers.dragged = None;
        }
    }

    /// The name, which a click records in; a field while it is changed.
    fn layer_name(&mut self, ui: &mut egui::Ui, layer: u32, state: &SculptLayerState, name: &str) {
        if let Some((_, text)) = self.layers.renamed.as_mut().filter(|(other, _)| *other == layer) {
            let field = ui.add(egui::TextEdit::singleline(text).desired_width(90.0));
            field.request_focus();
            let text = text.trim().to_owned();
            let (entered, escaped) = ui.input(|input| (input.key_pressed(Key::Enter), input.key_pressed(Key::Escape)));
            if entered || escaped || field.clicked_elsewhere() {
                self.layers.renamed = None;
                if !escaped && !text.is_empty() && text != name {
                    self.change_layers(SessionCommand::RenameLayer { layer, name: text });
                }
            }
            return;
        }
        let label = ui.add_enabled(!state.is_fixed, egui::Button::selectable(state.records, name).truncate());
        let label = label.on_hover_text(strings::layer_hint(state.vertices));
        if label.clicked() && !state.records {
            self.change_layers(SessionCommand::RecordLayer { layer: Some(layer) });
        }
    }

    /// Hides a layer, or shows it with the strength that it had.
    fn show_layer(&mut self, layer: u32, strength: f64, visible: bool) {
        let before = self.layers.shown.iter().position(|(other, _)| *other == layer);
        let before = before.map(|place| self.layers.shown.swap_remove(place).1);
        if !visible {
            self.layers.shown.push((layer, strength));
        }
        let strength = if visible { before.unwrap_or(1.0) } else { 0.0 };
        self.change_layers(SessionCommand::SetLayerStrength { layer, strength });
    }

    fn change_layers(&mut self, command: SessionCommand) {
        // Strengths right after each other are one stroke of the history, so its last number does not tell. Which layer records changes no shape.
        if !matches!(command, SessionCommand::RecordLayer { .. }) {
            self.saved_shape = None;
        }
        if !matches!(command, SessionCommand::SetLayerStrength { .. } | SessionCommand::RecordLayer { .. }) {
            // Numbers of layers change.
            self.layers.shown.clear();
        }
        self.log.event("layers", &[("command", format!("{command:?}"))]);
        self.send(Command::ChangeLayers(command));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An undo gives the numbers of layers to others.
    #[test]
    fn what_is_known_by_number_goes_with_the_list() {
        let state = |name: &str| SculptLayerState {
            name: name.into(),
            strength: 1.0,
            records: false,
            is_fixed: false,
            vertices: 0,
        };
        let mut panel = LayerPanel::default();
        panel.follow(&[state("a"), state("b")]);
        (panel.shown, panel.renamed) = (vec![(1, 0.4)], Some((1, "c".into())));
        panel.follow(&[state("a"), SculptLayerState { strength: 0.0, ..state("b") }]);
        assert_eq!((panel.shown.len(), panel.renamed.is_some()), (1, true), "the same layers");
        panel.follow(&[state("a")]);
        assert_eq!((panel.shown.len(), panel.renamed), (0, None));
    }
}
