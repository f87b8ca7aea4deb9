#![allow(dead_code, reason = "not every test uses all of it")]
//! A window without a graphics card, a model to open in it, and strokes of the pointer.

use eframe::egui::{self, Key, Modifiers, Pos2, pos2};
use egui_kittest::Harness;
use pliant_mesh::generate;
use pliant_window::app::{App, EventLog};
use pliant_window::arguments::Arguments;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time that anything is waited for.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A ball of radius 100 mm as a model in a folder.
pub fn ball(folder: &Path) -> PathBuf {
    let path = folder.join("ball.obj");
    let document = generate::sphere(12, 0.1).unwrap();
    let mut file = std::fs::File::create(&path).unwrap();
    let points = document.positions().to_vec();
    document.write(&points, None, &mut file).unwrap();
    path
}

/// A square of 100 mm that faces the viewer as a model in a folder: a sheet, which hangs by its upper edge.
pub fn sheet(folder: &Path) -> PathBuf {
    let path = folder.join("sheet.obj");
    let document = generate::grid([12; 2], [0.1; 2], generate::Pattern::Regular).unwrap();
    let mut file = std::fs::File::create(&path).unwrap();
    let points = document.positions().to_vec();
    document.write(&points, None, &mut file).unwrap();
    path
}

/// A coarse model on one thread, with its shapes beside it.
pub fn arguments(path: &Path) -> Arguments {
    let autosave = Some(path.with_file_name("autosave"));
    Arguments { path: Some(path.to_owned()), level: 4, threads: 1, autosave, ..Arguments::default() }
}

/// A window with the coarse model of a path ([`arguments`]).
pub fn window(path: &Path) -> Harness<'static, App> {
    window_with(arguments(path))
}

/// A window that was called with these arguments.
pub fn window_with(arguments: Arguments) -> Harness<'static, App> {
    window_scaled(arguments, egui::vec2(1200.0, 800.0), 1.0)
}

/// The same with a size (points), and pixels of a point.
pub fn window_scaled(arguments: Arguments, size: egui::Vec2, pixels_per_point: f32) -> Harness<'static, App> {
    let build = move |creation: &mut eframe::CreationContext<'_>| {
        let mut app = App::new(creation.egui_ctx.clone(), None, EventLog::none());
        app.begin(&arguments, None);
        app
    };
    Harness::builder().with_size(size).with_pixels_per_point(pixels_per_point).build_eframe(build)
}

/// A file that is dropped on the window.
#[derive(Debug)]
pub struct Dropped(pub PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// Shows frames until something is so.
pub fn wait(harness: &mut Harness<'_, App>, what: &str, mut is_so: impl FnMut(&App) -> bool) {
    let began = Instant::now();
    loop {
        harness.step();
        if is_so(harness.state()) {
            return;
        }
        let state = harness.state();
        assert!(began.elapsed() < PATIENCE, "waited for {what}: {:?} {:?}", state.status(), state.error());
        std::thread::sleep(Duration::from_millis(16));
    }
}

/// Holds the left button in the picture for some frames, moving a little.
pub fn stroke(harness: &mut Harness<'_, App>, at: Pos2) {
    harness.hover_at(at);
    (0..5).for_each(|_| pause(harness));
    harness.drag_at(at);
    for n in 0..30 {
        harness.hover_at(at + egui::vec2(n as f32, 0.0));
        pause(harness);
    }
    harness.drop_at(at);
    pause(harness);
}

/// Shows a frame and waits for the next.
pub fn pause(harness: &mut Harness<'_, App>) {
    harness.step();
    std::thread::sleep(Duration::from_millis(16));
}

/// The middle of the picture, between the panels.
pub const MIDDLE: Pos2 = pos2(570.0, 400.0);

/// Saves, and gives the bytes of the file.
pub fn saved(harness: &mut Harness<'_, App>, path: &Path) -> Vec<u8> {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(harness, "saving", |app| !app.is_unsaved());
    std::fs::read(path).unwrap()
}
