//! Files that are dragged over the window and dropped on it.

use super::App;
use crate::drops::{DragNews, DraggedFiles};
use crate::opening::is_model_name;
use crate::reference::is_image;
use crate::strings;
use eframe::egui::{self, Align2, Color32, FontId, Stroke, StrokeKind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;

/// Width of the frame around the window while files are dragged over it, points.
const FRAME: f32 = 4.0;
/// Colours of the frame: of what can be opened, and of what cannot.
const FRAME_COLOURS: [Color32; 2] = [Color32::from_rgb(110, 190, 255), Color32::from_rgb(240, 110, 90)];

impl App {
    /// A frame around the window while files are dragged over it, and what becomes of them if they are dropped.
    pub(super) fn hovered_files(&self, context: &egui::Context) {
        let of_library = context.input(|input| input.raw.hovered_files.clone());
        let hovered: Vec<PathBuf> =
            of_library.into_iter().filter_map(|file| file.path).chain(self.dragged.paths.iter().cloned()).collect();
        let others = &self.dragged.others;
        let (text, is_taken) = match taken_of(&hovered) {
            Some(taken) if is_model_name(taken) => (strings::drop_to_open(taken), true),
            Some(taken) if self.model.is_none() => (strings::image_without_model(taken), false),
            Some(taken) => (strings::drop_as_reference(taken), true),
            None if !hovered.is_empty() => (strings::not_dropped(&hovered), false),
            None if !others.is_empty() => (strings::no_files_here(others), false),
            None => return,
        };
        let colour = FRAME_COLOURS[usize::from(!is_taken)];
        let (rect, id) = (context.content_rect(), egui::Id::unique("hovered"));
        let painter = context.layer_painter(egui::LayerId::new(egui::Order::Foreground, id));
        painter.rect_filled(rect, 0.0, Color32::from_black_alpha(130));
        painter.rect_stroke(rect, 0.0, Stroke::new(FRAME, colour), StrokeKind::Inside);
        let galley = painter.layout(text.clone(), FontId::proportional(20.0), colour, 0.8 * rect.width());
        let at = Align2::CENTER_CENTER.anchor_size(rect.center(), galley.size());
        painter.galley(at.min, galley, colour);
        // For those who do not see it.
        egui::Area::new(id).order(egui::Order::Foreground).interactable(false).show(context, |ui| {
            let response = ui.allocate_rect(at, egui::Sense::hover());
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &text));
        });
    }

    /// Opens the first model or scene of the files that were dropped. Where there is none, the first image is shown behind the open model. Files that are left
    /// out are told.
    pub(super) fn dropped_files(&mut self, context: &egui::Context) {
        let of_library = context.input(|input| input.raw.dropped_files.clone());
        let mut dropped: Vec<PathBuf> = of_library.iter().map(|file| file.path().to_path_buf()).collect();
        let mut others = Vec::new();
        for news in self.drags.iter().flat_map(Receiver::try_iter) {
            self.dragged = DraggedFiles::default();
            match news {
                DragNews::Over(files) => self.dragged = files,
                DragNews::Left => {}
                DragNews::Dropped(files) => {
                    dropped.extend(files.paths);
                    others.extend(files.others);
                }
            }
        }
        let Some(taken) = taken_of(&dropped) else {
            if !dropped.is_empty() {
                self.fail(strings::not_dropped(&dropped));
            } else if !others.is_empty() {
                self.fail(strings::no_files_here(&others));
            }
            return;
        };
        let is_reference = !is_model_name(taken);
        if is_reference && self.model.is_none() {
            return self.fail(strings::image_without_model(taken));
        }
        let left = dropped.iter().map(PathBuf::as_path).filter(|path| *path != taken);
        let left: Vec<&Path> = left.chain(others.iter().map(Path::new)).collect();
        if !left.is_empty() {
            self.tell(strings::dropped_left_out(taken, &left));
        }
        if is_reference {
            self.open_reference(taken);
        } else {
            self.open_another(taken.clone());
        }
    }
}

/// Whether the window is told of files that are dropped on it: its library (winit 0.30) hears of them from X servers and from other systems, and not from Wayland,
/// which it takes where these variables say that there is one.
pub(super) fn takes_drops() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let may_be_wayland = cfg!(all(target_os = "linux", feature = "wayland"));
    !(may_be_wayland && ["WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(is_set))
}

/// The file that is opened of those that were dropped: the first model or scene, otherwise the first image.
fn taken_of(dropped: &[PathBuf]) -> Option<&PathBuf> {
    dropped.iter().find(|path| is_model_name(path)).or_else(|| dropped.iter().find(|path| is_image(path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_goes_before_an_image_and_both_before_other_files() {
        let taken = |names: &[&str]| {
            let paths: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            taken_of(&paths).map(|path| path.to_string_lossy().into_owned())
        };
        assert_eq!(taken(&["a.mtl", "a.png", "a.OBJ", "b.obj"]).as_deref(), Some("a.OBJ"));
        assert_eq!(taken(&["a.mtl", "a.png"]).as_deref(), Some("a.png"));
        assert_eq!(taken(&["a.mtl", "folder"]), None);
        assert_eq!(taken(&[]), None);
    }
}
