//! What is said of the display before a window is there.

use crate::display::Display;
use crate::window::pliant;
use std::process::Command;

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn doctor_says_what_a_window_draws_with() {
    let folder = tempfile::tempdir().unwrap();
    let display = Display::start();
    let run = pliant(folder.path()).arg("doctor").env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY").output();
    let said = run.unwrap();
    let out = String::from_utf8_lossy(&said.stdout);
    assert!(said.status.success() && out.contains("it draws with") && out.contains("OpenGL"), "{out}");
    let run = pliant(folder.path()).arg("doctor").env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").output().unwrap();
    let out = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.code() == Some(1) && out.contains("missing  window: there is no display"), "{out}");
}

#[test]
fn without_a_display_it_says_so_and_ends_with_2() {
    let run = Command::new(env!("CARGO_BIN_EXE_pliant-window"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(said.contains("no display") && said.lines().count() == 1, "{said}");
}
