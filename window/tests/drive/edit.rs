//! Editing by hand: what is pressed, grabbed, cut, undone, saved and opened again.

use crate::display::{Display, MIDDLE};
use crate::models::{ball, farthest, two_balls, vertices};
use crate::window::{Window, pliant};
use std::path::PathBuf;

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn open_press_grab_cut_undo_redo_save_reopen() {
    let folder = tempfile::tempdir().unwrap();
    let model = ball(folder.path());
    let original = std::fs::read(&model).unwrap();
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let [x, y] = MIDDLE;

    window.stroke(&display, [MIDDLE, [x + 40, y]], 20, "1");
    let pressed = window.save_at_rest(&display, &model);
    assert_ne!(pressed, original, "a press whose shape is kept changes the model");
    assert_eq!(vertices(&pressed), vertices(&original), "and no topology");

    // On both sides of the plane x = 0, as one stroke.
    display.key("x");
    display.key("4");
    window.stroke(&display, [[x + 130, y - 60], [x + 210, y - 110]], 30, "2");
    display.key("x");
    let grabbed = window.save_at_rest(&display, &model);
    assert_eq!(vertices(&grabbed), vertices(&original), "a grab moves vertices");
    let [right, left] = [1.0, -1.0].map(|side| farthest(&pressed, &grabbed, side));
    // Nearly as far: the press before was on one side.
    assert!(right > 5e-3 && (right / left - 1.0).abs() < 0.02, "both sides are drawn out: {right} m, {left} m");

    display.key("3");
    window.stroke(&display, [[x, y - 320], [x, y + 320]], 60, "3");
    let cut = window.save_at_rest(&display, &model);
    assert!(vertices(&cut) > vertices(&original), "a cut adds vertices");
    assert!(String::from_utf8_lossy(&cut).contains("usemtl cut"), "and faces inside of the ball");

    for (keys, done, undone, expected) in [
        ("ctrl+z", "2", "1", &grabbed),
        ("ctrl+z", "1", "2", &pressed),
        ("ctrl+z", "0", "3", &original),
        ("ctrl+shift+z", "1", "2", &pressed),
        ("ctrl+y", "2", "1", &grabbed),
        ("ctrl+y", "3", "0", &cut),
    ] {
        display.key(keys);
        window.wait_for_history(done, undone);
        let saved = window.save(&display, &model);
        let [lines, before] =
            [&saved, expected].map(|file| file.split(|byte| *byte == b'\n').map(String::from_utf8_lossy));
        let differ: Vec<_> = lines.zip(before).filter(|(line, before)| line != before).collect();
        assert!(
            saved == *expected,
            "{keys} to {done} strokes: {} lines are not what they were, to the byte: {:?}",
            differ.len(),
            differ.first()
        );
    }
    display.key("ctrl+alt+s");
    window.wait("dialog");
    display.key("Return");
    let said = window.wait("message")["text"].as_str().unwrap().to_owned();
    assert!(said.contains("pliant run") && said.contains("ball.session.toml"), "{said}");
    window.close(&display);
    let session = folder.path().join("ball");
    for arguments in [&["run", "ball.session.toml", "--out"][..], &["replay", "ball.rec", "--verify", "--out"]] {
        let ran = pliant(folder.path()).args(arguments).arg(&session).output().unwrap();
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        let made = std::fs::read(session.join("final.obj")).unwrap();
        assert!(made == cut, "{arguments:?}: the pipeline makes the bytes that the hand made");
    }

    let mut again = Window::start(&display, &model);
    let reopened = again.save(&display, &model);
    assert!(reopened == cut, "a model that nothing was done to is saved as it was");
    again.close(&display);
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn a_part_is_split_off_saved_and_joined_again_by_undo() {
    let folder = tempfile::tempdir().unwrap();
    let model = two_balls(folder.path());
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let [x, y] = MIDDLE;
    // A press, so that there is a shape to save.
    window.stroke(&display, [[x - 180, y], [x - 150, y]], 20, "1");
    let whole = window.save_at_rest(&display, &model);
    display.move_to([x - 180, y]);
    display.key("b");
    window.wait_for_history("2", "0");
    let rest = window.save_at_rest(&display, &model);
    let others = || {
        let files = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
        let mut others: Vec<PathBuf> =
            files.filter(|path| path.extension().is_some_and(|e| e == "obj") && *path != model).collect();
        others.sort();
        others
    };
    let part = std::fs::read(others().first().expect("the part has a file of its own")).unwrap();
    let faces = |file: &[u8]| file.split(|byte| *byte == b'\n').filter(|line| line.starts_with(b"f ")).count();
    assert_eq!(faces(&rest) + faces(&part), faces(&whole), "the faces of the parts are those of the whole");
    assert!(vertices(&rest) < vertices(&whole) && vertices(&part) < vertices(&whole));
    display.key("ctrl+z");
    window.wait_for_history("1", "1");
    assert!(window.save_at_rest(&display, &model) == whole, "undo makes it one body, to the byte");
    window.close(&display);
}
