//! Files that are dropped on the window.

use super::App;
use crate::opening::is_model_name;
use crate::reference::is_image;
use crate::strings;
use eframe::egui;
use std::path::{Path, PathBuf};

impl App {
    /// Opens the first model or scene of the files that were dropped. Where there is none, the first image is shown behind the open model. Files that are left
    /// out are told.
    pub(super) fn dropped_files(&mut self, context: &egui::Context) {
        let dropped =
            context.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_path_buf()).collect());
        let dropped: Vec<PathBuf> = dropped;
        let Some(taken) = taken_of(&dropped) else {
            if !dropped.is_empty() {
                self.fail(strings::not_dropped(&dropped));
            }
            return;
        };
        let is_reference = !is_model_name(taken);
        if is_reference && self.model.is_none() {
            return self.fail(strings::image_without_model(taken));
        }
        let left: Vec<&Path> = dropped.iter().map(PathBuf::as_path).filter(|path| *path != taken).collect();
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
