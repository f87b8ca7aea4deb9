//! Reading a scene file.

use super::schema::Scene;
use super::set;
use super::source::{SceneError, Source};
use pliant_mesh::read::{TEXT_LIMIT, read_file};
use std::ops::Range;
use std::path::Path;

/// The version of the format this program reads.
const FORMAT: u32 = 1;

/// Reads a scene, with `set` (path, value) put in the place of what the file says.
///
/// # Errors
/// A file that cannot be read, is not TOML, or says something a scene cannot.
pub fn load(path: &Path, set: &[(String, String)]) -> Result<(Scene, Source), SceneError> {
    let mut source = Source::new(path, "");
    let bytes = read_file(path, TEXT_LIMIT).map_err(|e| source.whole(format!("cannot be read: {e}")))?;
    if let Err(error) = std::str::from_utf8(&bytes) {
        source.text = String::from_utf8_lossy(&bytes).into_owned();
        // As far as it is valid, the text is the same.
        let at = error.valid_up_to();
        return Err(source.error(at..at + 1, "not UTF-8 text; allowed is a TOML file in UTF-8"));
    }
    let text = String::from_utf8(bytes).expect("just looked");
    source.text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
    parse(source, set)
}

/// The same from a text that stood in `path`.
///
/// # Errors
/// A text that is not TOML, or says something a scene cannot.
pub fn load_text(path: &Path, text: String, set: &[(String, String)]) -> Result<(Scene, Source), SceneError> {
    parse(Source::new(path, text), set)
}

fn parse(mut source: Source, set: &[(String, String)]) -> Result<(Scene, Source), SceneError> {
    if !set.is_empty() {
        source.text = set::apply(&source, set)?;
        source.changed = true;
    }
    let scene: Scene = toml::from_str(&source.text).map_err(|e| source.error(place(&e), plain(e.message())))?;
    if *scene.format.get_ref() != FORMAT {
        let text = format!("format {}; allowed is {FORMAT}, the one this program reads", scene.format.get_ref());
        return Err(source.error(scene.format.span(), text));
    }
    Ok((scene, source))
}

/// Where the parser stopped: what is wrong with the first character is at the first line, what is missing nowhere.
fn place(error: &toml::de::Error) -> Range<usize> {
    let span = error.span().unwrap_or(0..0);
    let missing = error.message().starts_with("missing field");
    if span == (0..0) && !missing { 0..1 } else { span }
}

/// What the parser says, on one line and without the names of Rust's types.
fn plain(message: &str) -> String {
    let message = message.trim().replace('\n', " ");
    if message.contains("wanted string or table") {
        return "wrong type; allowed is a text".into();
    }
    message.replace("expected u32", "expected a whole number, 0 or more").replace("expected f64", "expected a number")
}
