//! The shipped scenes in the window.

use pliant_editor::PaintStroke;
use pliant_engine::scene::Release;
use pliant_window::opening::{OpenRequest, open};
use pliant_window::tools::ToolKind;
use std::fs;
use std::path::Path;

/// Each opens with the window's hand in the place of its own. A tool whose strokes do nothing there says why, and the others have an edit on their button.
#[test]
fn every_shipped_scene_opens_and_tools_that_do_nothing_say_why() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut counts = [0; 2];
    for path in files.filter(|path| path.extension().is_some_and(|ending| ending == "toml")) {
        let name = path.display().to_string();
        let opened = open(&OpenRequest { threads: 1, ..OpenRequest::new(path) }).unwrap_or_else(|why| panic!("{why}"));
        let has_tetrahedra = opened.scene.body.iter().any(|body| body.is_tetrahedral());
        counts[usize::from(has_tetrahedra)] += 1;
        for tool in ToolKind::all() {
            let why = opened.facts.why_idle(tool);
            let buttons = tool.buttons(Release::Keep, PaintStroke::default());
            let begins = |button: Option<u32>| button.is_some_and(|button| buttons == 1 << button);
            let has_edit = opened.session.plan().edits.iter().any(|edit| begins(edit.button));
            assert_eq!(why.is_none(), has_edit, "{name}: {}: {why:?}", tool.name());
            let divides = ["cut", "stitch"].contains(&tool.name());
            assert!(why.is_none() || tool.paints() || (divides && has_tetrahedra), "{name}: {why:?}");
            assert!(!(divides && has_tetrahedra) || why.is_some(), "{name}: {} is refused", tool.name());
        }
    }
    assert!(counts[0] > 20 && counts[1] > 1, "{counts:?} scenes without and with tetrahedra");
}
