//! Files that a file manager drags over the window and drops on it.

use crate::display::{Display, MIDDLE};
use crate::drag::{Drag, Finished, Habits, uri_list};
use crate::leaving::{CANCEL, DISCARD, SAVE, click};
use crate::models::{ball, two_balls, vertices};
use crate::window::Window;
use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};

/// What a source is told of files that the window took; it asked once for their names.
const TAKEN: Finished = Finished { is_accepted: true, requests: 1 };

/// Two balls in a file whose name a URI has to write otherwise: spaces, letters beyond ASCII and a percent sign that is no escape.
fn two_balls_with_a_name(folder: &Path) -> PathBuf {
    let path = folder.join("zwei Bälle – 50%20 größer.obj");
    std::fs::rename(two_balls(folder), &path).unwrap();
    path
}

/// Drops files on the middle of the picture.
fn drop_files(display: &Display, paths: &[&Path]) {
    assert_eq!(Drag::start(display, uri_list(paths), MIDDLE, Habits::default()).let_go(), TAKEN);
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn a_file_with_spaces_and_letters_beyond_ascii_is_opened_by_a_drop_and_takes_strokes() {
    let folder = tempfile::tempdir().unwrap();
    let (model, other) = (ball(folder.path()), two_balls_with_a_name(folder.path()));
    let [of_ball, of_two] = [&model, &other].map(|path| std::fs::read(path).unwrap());
    let display = Display::start();
    let mut window = Window::start(&display, &model);

    // What only passes over it changes nothing.
    Drag::start(&display, uri_list(&[&other]), MIDDLE, Habits::default()).leave();
    assert!(window.save(&display, &model) == of_ball);

    drop_files(&display, &[&other]);
    assert_eq!(window.wait("opening")["path"].as_str(), other.to_str());
    window.wait("opened");
    let [x, y] = MIDDLE;
    window.stroke(&display, [[x + 100, y], [x + 140, y]], 20, "1");
    let pressed = window.save_at_rest(&display, &other);
    assert!(
        pressed != of_two && vertices(&pressed) == vertices(&of_two),
        "the model that was dropped takes the stroke"
    );
    display.key("ctrl+z");
    window.wait_for_history("0", "1");
    assert!(window.save(&display, &other) == of_two, "it is what the file was, to the byte");
    assert!(std::fs::read(&model).unwrap() == of_ball, "the model before is left alone");
    window.close(&display);
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn a_file_that_is_no_model_gives_an_error_panel_and_leaves_the_open_model_with_its_strokes() {
    let folder = tempfile::tempdir().unwrap();
    let model = ball(folder.path());
    let original = std::fs::read(&model).unwrap();
    let [notes, inner] = ["Notizen für später.txt", "Ordner.obj"].map(|name| folder.path().join(name));
    std::fs::write(&notes, "to do").unwrap();
    std::fs::create_dir(&inner).unwrap();
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let [x, y] = MIDDLE;
    window.stroke(&display, [MIDDLE, [x + 40, y]], 20, "1");
    for (path, words) in [(&notes, "allowed are models (.obj"), (&inner, "a folder")] {
        window.wait_for_rest();
        let before = display.picture();
        drop_files(&display, &[path]);
        let said = window.wait("failed")["text"].as_str().unwrap().to_owned();
        assert!(said.contains(path.file_name().unwrap().to_str().unwrap()) && said.contains(words), "{said}");
        // A panel is shown over the model until it is closed.
        window.wait_for_picture(&display, &before, false);
        display.key("Escape");
        window.wait_for_picture(&display, &before, true);
    }
    // No other model was opened: the stroke is in the history, and is undone.
    let pressed = window.save_at_rest(&display, &model);
    assert!(pressed != original);
    display.key("ctrl+z");
    window.wait_for_history("0", "1");
    assert!(window.save(&display, &model) == original);
    window.close(&display);
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn a_drop_on_unsaved_strokes_asks_and_does_what_is_answered() {
    let folder = tempfile::tempdir().unwrap();
    let (model, other) = (ball(folder.path()), two_balls_with_a_name(folder.path()));
    let [of_ball, of_two] = [&model, &other].map(|path| std::fs::read(path).unwrap());
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let [x, y] = MIDDLE;
    window.stroke(&display, [MIDDLE, [x + 40, y]], 20, "1");

    drop_files(&display, &[&other]);
    window.wait("unsaved");
    assert!(std::fs::read(&model).unwrap() == of_ball, "nothing is written without an answer");
    click(&display, CANCEL);
    // The ball is still open, with its stroke: it takes another.
    window.stroke(&display, [[x, y - 80], [x + 40, y - 80]], 20, "2");

    drop_files(&display, &[&other]);
    window.wait("unsaved");
    click(&display, SAVE);
    window.wait("saved");
    assert_eq!(window.wait("opening")["path"].as_str(), other.to_str());
    window.wait("opened");
    let pressed = std::fs::read(&model).unwrap();
    assert!(pressed != of_ball && vertices(&pressed) == vertices(&of_ball), "both strokes are saved");

    window.stroke(&display, [[x + 100, y], [x + 140, y]], 20, "1");
    drop_files(&display, &[&model]);
    window.wait("unsaved");
    click(&display, DISCARD);
    assert_eq!(window.wait("opening")["path"].as_str(), model.to_str());
    window.wait("opened");
    assert!(std::fs::read(&other).unwrap() == of_two, "what is given up is not written");
    assert!(window.save(&display, &model) == pressed, "and what was saved is what is open");
    window.close(&display);
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn of_several_files_in_one_drop_the_model_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let (model, other) = (ball(folder.path()), two_balls_with_a_name(folder.path()));
    let of_two = std::fs::read(&other).unwrap();
    let [notes, materials] = ["Notizen.txt", "zwei Bälle.mtl"].map(|name| folder.path().join(name));
    std::fs::write(&notes, "to do").unwrap();
    std::fs::write(&materials, "newmtl a\n").unwrap();
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    // `wait` takes no error: those that are left out are none.
    drop_files(&display, &[&notes, &materials, &other, &model]);
    assert_eq!(window.wait("opening")["path"].as_str(), other.to_str());
    window.wait("opened");
    assert!(window.save(&display, &other) == of_two);
    // A source that knows no proxies speaks to the window library.
    let list = uri_list(&[&notes, &model, &other]);
    let habits = Habits { ignores_proxies: true, ..Habits::default() };
    assert_eq!(Drag::start(&display, list, MIDDLE, habits).let_go(), TAKEN);
    assert_eq!(window.wait("opening")["path"].as_str(), model.to_str());
    window.wait("opened");
    window.close(&display);
}

/// The window library drops each of these lists in silence.
#[test]
#[ignore = "needs Xvfb and xdotool"]
fn lists_as_other_programs_write_them_are_taken_and_what_is_no_file_here_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let (model, other) = (ball(folder.path()), two_balls(folder.path()));
    // A name that is not UTF-8, which a scene cannot hold.
    let latin = folder.path().join(OsString::from_vec(b"B\xe4lle.obj".to_vec()));
    std::fs::copy(&other, &latin).unwrap();
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let path = other.to_str().unwrap();
    let late = Habits { answers_late: true, ..Habits::default() };
    let takes = [
        (format!("file://localhost{path}\r\n"), Habits::default()),
        (format!("file:{path}\r\n"), Habits::default()),
        (format!("file://{path}\n"), Habits::default()),
        (format!("# of a file manager\r\nfile://{path}\r\n\0"), Habits::default()),
        (format!("sftp://there{path}\r\nfile://{path}\r\n"), Habits::default()),
        (format!("file://{path}.gone.txt\r\nfile://{path}\r\n"), Habits::default()),
        (format!("file://{path}\r\n"), late),
    ];
    for (list, habits) in takes {
        assert_eq!(Drag::start(&display, &*list, MIDDLE, habits).let_go(), TAKEN, "{list}");
        assert_eq!(window.wait("opening")["path"].as_str(), Some(path), "{list}");
        window.wait("opened");
    }
    let refused = [
        (format!("file://{path}.gone.obj\r\n"), "balls.obj.gone.obj: there is no such file"),
        (format!("sftp://there{path}\r\n"), "not a file of this machine"),
        (format!("file://there{path}\r\n"), "not a file of this machine"),
        (format!("file://{}/B%E4lle.obj\r\n", folder.path().display()), "lle.obj; paths are relative to the scene"),
    ];
    for (list, words) in refused {
        assert_eq!(Drag::start(&display, &*list, MIDDLE, Habits::default()).let_go(), TAKEN, "{list}");
        let said = window.wait("failed")["text"].as_str().unwrap().to_owned();
        assert!(said.contains(words), "{list}: {said}");
        display.key("Escape");
    }
    window.close(&display);
}
