//! The reference image: reading it, its controls, and where it is remembered.

use super::App;
use super::dropped::takes_drops;
use super::files::Purpose;
use crate::reference::{
    ReferenceImage, ReferenceLoad, ReferencePlane, ReferenceQuad, ReferenceSettings, remember, remembered,
};
use crate::sim::state_folder;
use crate::strings;
use eframe::egui::{self, DragValue, Slider};
use image::RgbaImage;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// The reference image of the window.
#[derive(Default)]
pub(super) struct Reference {
    loading: Option<ReferenceLoad>,
    image: Option<ReferenceImage>,
    /// Pixels that the renderer does not have yet.
    upload: Option<Arc<RgbaImage>>,
    /// Settings that were written last.
    written: Option<ReferenceSettings>,
    /// Whether the user has removed it. One that cannot be read, as on a drive that is not there, stays remembered.
    is_removed: bool,
    /// Why the renderer has not taken the image, until it is told.
    problem: Arc<Mutex<Option<String>>>,
}

impl Reference {
    /// Where the renderer says why it does not take the image.
    pub(super) fn problem(&self) -> Arc<Mutex<Option<String>>> {
        Arc::clone(&self.problem)
    }

    /// Pixels to upload, once.
    pub(super) fn take_upload(&mut self) -> Option<Arc<RgbaImage>> {
        self.upload.take()
    }
}

impl App {
    /// The reference image that is shown.
    pub fn reference(&self) -> Option<&ReferenceImage> {
        self.reference.image.as_ref()
    }

    /// Shows a PNG or JPEG behind the model.
    pub(super) fn open_reference(&mut self, path: &Path) {
        let Some(model) = &self.model else { return };
        let mut settings = ReferenceSettings::new(path, model.facts.hand.size);
        if let Some(image) = &self.reference.image {
            // Another image takes the place of the one before.
            settings = ReferenceSettings { path: settings.path, visible: true, ..image.settings.clone() };
        }
        self.reference.loading = Some(ReferenceLoad::start(settings, self.context.clone()));
    }

    /// Shows again what was last shown with the model that has been opened.
    pub(super) fn open_remembered_reference(&mut self) {
        let read = self.state_folder().map(|folder| remembered(&folder, &self.request.path));
        let settings = read.transpose().unwrap_or_else(|error| {
            self.tell(strings::reference_unknown(&error));
            None
        });
        let settings = settings.flatten();
        let is_open = |image: &ReferenceImage| Some(&image.settings) == settings.as_ref();
        if self.reference.image.as_ref().is_some_and(is_open) {
            return;
        }
        self.reference = Reference { written: settings.clone(), ..Reference::default() };
        self.reference.loading = settings.map(|settings| ReferenceLoad::start(settings, self.context.clone()));
    }

    /// Folder of what is remembered from one session to the next; `None` without a home folder.
    pub(super) fn state_folder(&self) -> Option<PathBuf> {
        self.request.autosave.clone().or_else(state_folder)
    }

    /// Takes in an image that has been read, and writes settings that have changed.
    pub(super) fn update_reference(&mut self, context: &egui::Context) {
        if let Some(read) = self.reference.loading.as_ref().and_then(ReferenceLoad::take) {
            self.reference.loading = None;
            match read {
                Ok(image) => {
                    self.log.event("reference", &[("path", image.settings.path.display().to_string())]);
                    self.reference.upload = Some(Arc::clone(&image.pixels));
                    self.reference.image = Some(image);
                    self.reference.is_removed = false;
                }
                Err(text) => self.fail(text),
            }
        }
        let problem = self.reference.problem.lock().ok().and_then(|mut problem| problem.take());
        if let (Some(why), Some(image)) = (problem, &self.reference.image) {
            let ([width, height], path) = (image.pixels.dimensions().into(), image.settings.path.clone());
            self.fail(strings::reference_not_shown(&path, [width, height], &why));
        }
        let settings = self.reference.image.as_ref().map(|image| &image.settings);
        // Not in the middle of a drag.
        if settings == self.reference.written.as_ref()
            || (settings.is_none() && !self.reference.is_removed)
            || self.reference.loading.is_some()
            || self.model.is_none()
            || context.input(|input| input.pointer.any_down())
        {
            return;
        }
        let written = settings.cloned();
        if let Some(folder) = self.state_folder()
            && let Err(error) = remember(&folder, &self.request.path, written.as_ref())
        {
            self.tell(strings::reference_forgotten(&error));
        }
        self.reference.written = written;
    }

    /// The image in the scene.
    pub(super) fn reference_quad(&self) -> Option<ReferenceQuad> {
        self.reference.image.as_ref()?.quad(&self.camera, self.model.as_ref()?.opened_bounds())
    }

    /// Controls of the image, or a button that asks for one.
    pub(super) fn reference_panel(&mut self, ui: &mut egui::Ui) {
        if self.model.is_none() {
            return;
        }
        ui.heading(strings::REFERENCE);
        if ui.button(strings::OPEN_REFERENCE).on_hover_text(strings::reference_hint(takes_drops())).clicked() {
            self.ask_for_file(Purpose::Reference);
        }
        let Some(image) = &mut self.reference.image else { return };
        let settings = &mut image.settings;
        let name = settings.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut is_removed = false;
        ui.horizontal(|ui| {
            ui.checkbox(&mut settings.visible, name).on_hover_text(settings.path.display().to_string());
            is_removed = ui.small_button(strings::REMOVE).clicked();
        });
        let name_of = |plane: ReferencePlane| {
            ReferencePlane::ALL.iter().position(|other| *other == plane).map_or("", |place| strings::PLANES[place])
        };
        egui::ComboBox::from_label(strings::PLANE).selected_text(name_of(settings.plane)).show_ui(ui, |ui| {
            for plane in ReferencePlane::ALL {
                ui.selectable_value(&mut settings.plane, plane, name_of(plane));
            }
        });
        let opacity = Slider::new(&mut settings.opacity, 0.0..=1.0).max_decimals(2);
        ui.scope(|ui| {
            ui.spacing_mut().slider_width *= 0.75;
            ui.add(opacity.text(strings::REFERENCE_OPACITY));
        });
        // A drag of a hundred points doubles the height.
        let speed = (0.01 * settings.height).max(1e-3);
        let millimetres = |value, least: f64| {
            DragValue::new(value).speed(speed).range(least..=1e6).max_decimals(2).suffix(strings::MILLIMETRE)
        };
        let [right, up] = &mut settings.offset;
        for (value, least, label) in [
            (&mut settings.height, 1e-3, strings::REFERENCE_HEIGHT),
            (right, -1e6, strings::REFERENCE_RIGHT),
            (up, -1e6, strings::REFERENCE_UP),
        ] {
            ui.horizontal(|ui| {
                let name = ui.label(label).id;
                ui.add(millimetres(value, least)).labelled_by(name);
            });
        }
        if is_removed {
            (self.reference.image, self.reference.is_removed) = (None, true);
        }
    }
}
