//! Who has the hand: the pointer, or a haptic device.

use super::App;
use super::model::Model;
use crate::opening::OpenRequest;
use crate::sim::Predecessor;
use crate::strings;
use crate::tools::ToolKind;
use eframe::egui::{self, Slider};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use pliant_editor::{
    DeviceChoice, DeviceView, DeviceWish, HandNews, LengthUnit, PaintStroke, device_choices, format_length,
};
use pliant_engine::scene::Release;

impl App {
    /// The choice of what has the hand, and the share of its force.
    pub(super) fn device_panel(&mut self, ui: &mut egui::Ui) {
        let (device_hand, of_scene) = match &self.model {
            Some(model) => (
                model.hand.device_hand().map(|device_hand| (device_hand.name.clone(), device_hand.leads())),
                model.facts.devices.clone(),
            ),
            None => (None, Vec::new()),
        };
        // A scene's device by its name there, any other by its plugin.
        let opened = self.request.device.clone();
        let is_opened = |choice: &&DeviceChoice| opened.as_ref() == Some(&choice.request);
        let name = of_scene.iter().find(is_opened).map(|choice| choice.name.clone());
        let shown = match &device_hand {
            Some((plugin, true)) => name.unwrap_or_else(|| plugin.clone()),
            _ => strings::POINTER.to_owned(),
        };
        let mut wanted = None;
        let mut takes_pointer = false;
        egui::ComboBox::from_label(strings::HAND).selected_text(&shown).show_ui(ui, |ui| {
            takes_pointer = ui.selectable_label(shown == strings::POINTER, strings::POINTER).clicked();
            let request = &self.request;
            // Libraries are opened for it, so not before somebody asks.
            let found = || request.search().map(|search| device_choices(&search)).unwrap_or_default();
            let found = self.devices.get_or_insert_with(found);
            for choice in of_scene.iter().chain(found.iter()) {
                let label = ui.selectable_label(shown == choice.name, &choice.name);
                if label.on_hover_text(&choice.summary).clicked() {
                    wanted = Some(choice.clone());
                }
            }
        });
        if takes_pointer && let Some(model) = &mut self.model {
            model.hand.give_to_device(false);
        }
        if let Some(choice) = wanted {
            self.take_device(choice);
        }
        if device_hand.is_some_and(|(_, leads)| leads) {
            let slider = Slider::new(&mut self.force_share, 0.0..=1.0).max_decimals(2).text(strings::FORCE_SHARE);
            ui.add(slider).on_hover_text(strings::FORCE_SHARE_HINT);
            self.device_scale().into_iter().for_each(|line| _ = ui.small(line));
        }
    }

    /// Gives the hand to a device. Where another one, or none, was opened, the present shape is opened again with it.
    fn take_device(&mut self, DeviceChoice { request: device, .. }: DeviceChoice) {
        self.log.event("device", &[("name", device.plugin.clone())]);
        if self.request.device.as_ref() == Some(&device)
            && let Some(model) = self.model.as_mut().filter(|model| model.hand.device_hand().is_some())
            && !model.hand.is_device_lost()
        {
            return model.hand.give_to_device(true);
        }
        self.request.device = Some(device);
        if self.model.is_none() {
            return;
        }
        if self.status.strokes.is_empty() {
            let (request, target) = (self.request.clone(), self.save_path.clone());
            self.open(request);
            self.save_path = target;
        } else {
            self.reopen();
        }
    }

    /// The simulation that is open, if the device that has the hand goes on in the session to be opened: one of the same model in the same unit.
    pub(super) fn predecessor(&mut self, next: &OpenRequest) -> Option<Predecessor> {
        let has_same = next.device.is_some() && next.device == self.request.device;
        let is_same = |model: &Model| {
            // The panel has the unit in the request before the model is opened in it.
            let has_unit = next.unit.is_none_or(|unit| model.facts.unit == Some(unit));
            next.path == self.request.path && has_unit && model.hand.is_by_device()
        };
        let keeps = has_same && self.model.as_ref().is_some_and(is_same);
        let (simulation, model) = (self.simulation.take_if(|_| keeps)?, self.model.take()?);
        let (hand, device_hand) = model.into_hand();
        let mut device_hand = device_hand?;
        device_hand.pause_strokes();
        Some(Predecessor { simulation, hand, device_hand })
    }

    /// Guides the device that has the hand for a frame, and names its strokes.
    pub(super) fn use_device(&mut self, context: &egui::Context) {
        let tool = self.tools[self.tool];
        let other = tool.inverse(&self.tools);
        let Some(model) = &mut self.model else { return };
        let painted = self.settings.painted.min(model.facts.painted.len().saturating_sub(1));
        let paint = |lowers| PaintStroke { param: painted, lowers };
        let release = self.settings.release;
        // Without a button the surface is felt, and springs back.
        let felt = ToolKind::feeling(&self.tools).map_or(0, |touch| touch.buttons(Release::SpringBack, paint(false)));
        let buttons = [
            felt,
            tool.device_buttons(release, paint(false)),
            other.map_or_else(
                || tool.device_buttons(release, paint(true)),
                |other| other.device_buttons(release, paint(false)),
            ),
        ];
        // The force was made for a tool of the first size; the coupling of a larger one is stiffer.
        let share = self.force_share / self.settings.size.max(1.0);
        let device = model.hand.device_hand().map_or_else(String::new, |device_hand| device_hand.name.clone());
        let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&self.camera.axes()));
        let view =
            DeviceView { centre: self.camera.target.coords, rotation: UnitQuaternion::from_rotation_matrix(&axes) };
        let news = model.hand.guide_device(&DeviceWish { view, buttons, force_share: share });
        let [idle, idle_other] = [tool, other.unwrap_or(tool)].map(|tool| model.facts.why_idle(tool));
        match news {
            HandNews::None => {}
            HandNews::Began { is_other } => {
                let name = other.filter(|_| is_other).unwrap_or(tool).name();
                self.log.event("stroke begins", &[("tool", name.into())]);
                if let Some(why) = if is_other { idle_other } else { idle } {
                    self.tell(why);
                }
            }
            HandNews::Ended => self.log.event("stroke ends", &[("tool", tool.name().into())]),
            HandNews::Lost(why) => {
                self.log.event("device lost", &[("why", why.into())]);
                self.tell(strings::device_lost(&device, why));
            }
        }
        context.request_repaint();
    }

    /// A line on the scale of the device that has the hand.
    pub(super) fn device_scale(&self) -> Option<String> {
        let device_hand = self.model.as_ref()?.hand.device_hand().filter(|device_hand| device_hand.leads())?;
        let step = format_length(LengthUnit::Centimetre.metres() * device_hand.length_scale());
        Some(strings::device_scale(&step))
    }
}
