//! Reading a scene file.

use super::schema::Scene;
use super::set;
use super::source::{SceneError, Source};
use pliant_mesh::read::{TEXT_LIMIT, read_file};
use std::ops::Range;
use std::path::Path;

/// The version of the scene format that this program reads.
const FORMAT: u32 = 1;

/// Reads a scene file and replaces values by `set` (path, value), as `--set` does.
///
/// # Errors
/// Fails for a file that cannot be read or is not UTF-8, for invalid TOML, unknown keys, values of a wrong type and another format version.
pub fn load(path: &Path, set: &[(String, String)]) -> Result<(Scene, Source), SceneError> {
    let mut source = Source::new(path, "");
    let bytes = read_file(path, TEXT_LIMIT).map_err(|e| source.whole(format!("cannot be read: {e}")))?;
    if let Err(error) = std::str::from_utf8(&bytes) {
        source.text = String::from_utf8_lossy(&bytes).into();
        // The lossy text is the same up to the first invalid byte.
        let at = error.valid_up_to();
        return Err(source.error(at..at + 1, "not UTF-8 text; allowed is a TOML file in UTF-8"));
    }
    let text = String::from_utf8(bytes).expect("checked above");
    source.text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text).into();
    parse(source, set)
}

/// Parses a scene from `text`; relative paths in it are relative to the folder of `path`.
///
/// # Errors
/// Fails for invalid TOML, unknown keys, values of a wrong type and another format version.
pub fn load_text(path: &Path, text: String, set: &[(String, String)]) -> Result<(Scene, Source), SceneError> {
    parse(Source::new(path, text), set)
}

fn parse(mut source: Source, set: &[(String, String)]) -> Result<(Scene, Source), SceneError> {
    if !set.is_empty() {
        source.text = set::apply(&source, set)?.into();
        source.changed = true;
    }
    let scene: Scene = toml::from_str(&source.text).map_err(|e| source.error(place(&e), plain(e.message())))?;
    if *scene.format.get_ref() != FORMAT {
        let text = format!("format {}; allowed is {FORMAT}, the one this program reads", scene.format.get_ref());
        return Err(source.error(scene.format.span(), text));
    }
    Ok((scene, source))
}

/// Span of a parser's error. An error at the first character gets a span of its own, as 0..0 means the file as a whole, which is right for a
/// missing key alone.
fn place(error: &toml::de::Error) -> Range<usize> {
    let span = error.span().unwrap_or(0..0);
    let missing = error.message().starts_with("missing field");
    if span == (0..0) && !missing { 0..1 } else { span }
}

/// The parser's message on one line, without names of Rust types.
fn plain(message: &str) -> String {
    let message = message.trim().replace('\n', " ");
    if message.contains("wanted string or table") {
        return "wrong type; allowed is a text".into();
    }
    message.replace("expected u32", "expected a whole number, 0 or more").replace("expected f64", "expected a number")
}
