//! `pliant-window`: the window of pliant, started by `pliant edit`.
//!
//! Exit codes are those of `pliant`: 0 done, 2 unusable input, usage or display, 3 a failure of the program.

use eframe::egui::{ViewportBuilder, vec2};
use pliant_window::app::{App, EventLog, measure_without_window};
use pliant_window::arguments::{Arguments, USAGE};
use pliant_window::gl::{GlRenderer, renderer_name};
use pliant_window::sim::EarlySimulation;
use pliant_window::strings;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Exit code of unusable input, usage or display.
const UNUSABLE: u8 = 2;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            eprintln!("error: {text}");
            ExitCode::from(UNUSABLE)
        }
    }
}

fn run() -> Result<(), String> {
    let began = Instant::now();
    let arguments = Arguments::parse(std::env::args().skip(1)).map_err(|text| format!("{text}\n\n{USAGE}"))?;
    let arguments = Arguments { began, ..arguments };
    if arguments.help {
        println!("{USAGE}");
        return Ok(());
    }
    if let Some(path) = arguments.path.as_ref().filter(|path| !path.is_file()) {
        return Err(format!("{}: there is no such file", path.display()));
    }
    if arguments.without_window {
        return print(&measure_without_window(&arguments)?);
    }
    find_display()?;
    if arguments.renderer {
        return print_renderer();
    }
    pliant_window::sim::prepare();
    show(&arguments)
}

/// A sentence instead of what a window library says where there is no display.
fn find_display() -> Result<(), String> {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(target_os = "linux") && !["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(is_set) {
        let text =
            "there is no display: neither DISPLAY nor WAYLAND_DISPLAY is set. Start this from a desktop, or under Xvfb";
        return Err(text.into());
    }
    Ok(())
}

/// Prints which renderer a window gets, without showing one.
fn print_renderer() -> Result<(), String> {
    let found = Arc::new(Mutex::new(None));
    let of_window = Arc::clone(&found);
    let options = eframe::NativeOptions {
        viewport: ViewportBuilder::default().with_visible(false),
        ..eframe::NativeOptions::default()
    };
    // Ends before the first frame: the renderer is known once there is a context.
    let create = move |context: &eframe::CreationContext<'_>| {
        let gl = context.gl.clone().ok_or(strings::NO_CONTEXT)?;
        GlRenderer::new(Arc::clone(&gl))?;
        if let Ok(mut found) = of_window.lock() {
            *found = Some(renderer_name(&gl));
        }
        Err(strings::ONLY_ASKED.into())
    };
    let ended = eframe::run_native(strings::TITLE, options, Box::new(create));
    let name = found.lock().ok().and_then(|found| found.clone());
    let name =
        name.ok_or_else(|| strings::no_window(&ended.err().map_or_else(String::new, |error| error.to_string())))?;
    println!("{name}");
    Ok(())
}

fn show(arguments: &Arguments) -> Result<(), String> {
    let log = match &arguments.log {
        Some(path) => EventLog::create(path).map_err(|error| format!("{}: {error}", path.display()))?,
        None => EventLog::none(),
    };
    let viewport = ViewportBuilder::default()
        .with_title(strings::TITLE)
        .with_app_id("pliant")
        .with_inner_size(vec2(1280.0, 800.0));
    let options = eframe::NativeOptions {
        viewport,
        multisampling: arguments.antialias,
        depth_buffer: 24,
        ..eframe::NativeOptions::default()
    };
    let mut early = arguments.path.is_some().then(|| EarlySimulation::start(arguments.request()));
    let measured = Arc::new(Mutex::new(None));
    let of_window = Arc::clone(&measured);
    let create = move |context: &eframe::CreationContext<'_>| {
        let gl = context.gl.clone().ok_or(strings::NO_CONTEXT)?;
        let renderer = GlRenderer::new(gl)?;
        let mut app = App::new(context.egui_ctx.clone(), Some(Arc::new(Mutex::new(renderer))), log);
        #[cfg(target_os = "linux")]
        if let Some(window) = x_window(context) {
            let to_wake = context.egui_ctx.clone();
            app.hear_of_drags(pliant_window::drops::take_drops(window, move || to_wake.request_repaint()));
        }
        app.begin(arguments, early.take());
        if let Ok(mut measured) = of_window.lock() {
            *measured = Some(app.measurement());
        }
        Ok(Box::new(app) as Box<dyn eframe::App>)
    };
    eframe::run_native(strings::TITLE, options, Box::new(create)).map_err(|error| strings::no_window(&error))?;
    let found = measured.lock().ok().and_then(|measured| measured.as_ref()?.lock().ok()?.take());
    match (found, arguments.measure) {
        (Some(found), _) => print(&found),
        (None, Some(_)) => Err("the window was closed before the measurement ended".into()),
        (None, None) => Ok(()),
    }
}

/// The window's name on an X server; `None` on Wayland.
#[cfg(target_os = "linux")]
fn x_window(context: &eframe::CreationContext<'_>) -> Option<u32> {
    use raw_window_handle::{HasWindowHandle, RawWindowHandle};
    match context.window_handle().ok()?.as_raw() {
        RawWindowHandle::Xlib(handle) => u32::try_from(handle.window).ok(),
        RawWindowHandle::Xcb(handle) => Some(handle.window.get()),
        _ => None,
    }
}

/// Prints one document of JSON.
fn print(value: &impl serde::Serialize) -> Result<(), String> {
    println!("{}", serde_json::to_string_pretty(value).map_err(|error| error.to_string())?);
    Ok(())
}
