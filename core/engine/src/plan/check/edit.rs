//! Checks of the edits of a scene.

use super::Check;
use crate::body::PaintDepth;
use crate::edit::{Command, EditKind, KeyName, Strength};
use crate::scene::{Amount, EditScene, SceneError, Source, parse_quantity};
use toml::Spanned;

/// Number of buttons of a hand.
const BUTTONS: u32 = 32;

/// The `strength` of an edit in the SI unit of its kind; `None` if it is absent or the kind has none.
///
/// # Errors
/// Fails for a text with another unit and for a number that is not above 0.
pub(crate) fn strength(edit: &EditScene, kind: &dyn EditKind, source: &Source) -> Result<Option<f64>, SceneError> {
    let (Some(given), Some(Strength { unit, range, .. })) = (&edit.strength, kind.strength()) else { return Ok(None) };
    let value = match given.get_ref() {
        Amount::Number(value) => *value,
        Amount::Text(text) if unit.is_empty() => text.trim().parse().map_err(|_| {
            let text = format!("strength of a `{}`: `{text}` is not a number; a factor has no unit", kind.name());
            source.error(given.span(), text)
        })?,
        Amount::Text(text) => parse_quantity(text, unit)
            .map_err(|why| source.error(given.span(), format!("strength of a `{}`: {why}", kind.name())))?,
    };
    match range {
        Some([low, high]) if !(low..=high).contains(&value) => {
            let text = format!("strength of a `{}` is {value}; allowed is {low} to {high}", kind.name());
            Err(source.error(given.span(), text))
        }
        Some(_) => Ok(Some(value)),
        None => Check(source).above(value, given.span(), "strength", &format!(" {unit}")).map(|()| Some(value)),
    }
}

/// The `depth` of an edit.
///
/// # Errors
/// Fails for a text that is neither `through`, `surface` nor a length, and for a length that is not above 0.
pub(in crate::plan) fn depth(edit: &EditScene, source: &Source) -> Result<PaintDepth, SceneError> {
    let Some(given) = &edit.depth else { return Ok(PaintDepth::Through) };
    let thickness = match given.get_ref() {
        Amount::Number(value) => *value,
        Amount::Text(text) if text == "through" => return Ok(PaintDepth::Through),
        Amount::Text(text) if text == "surface" => return Ok(PaintDepth::Layer(0.0)),
        Amount::Text(text) => parse_quantity(text, "m").map_err(|why| {
            let allowed = "allowed is \"through\", \"surface\" or the thickness of a layer";
            source.error(given.span(), format!("depth {text:?}: {allowed}; {why}"))
        })?,
    };
    Check(source).above(thickness, given.span(), "depth", " m").map(|()| PaintDepth::Layer(thickness))
}

impl Check<'_> {
    /// The edit kind, or undo or redo, of an edit.
    pub(super) fn command(&self, edit: &EditScene) -> Result<Command, SceneError> {
        let name = &edit.kind.get_ref().0;
        Command::find(name).ok_or_else(|| {
            let known: Vec<String> = Command::names().map(|(name, _)| format!("`{name}`")).collect();
            self.0.error(edit.kind.span(), format!("edit kind `{name}`; allowed is {}", known.join(", ")))
        })
    }

    pub(super) fn edit(&self, edit: &EditScene) -> Result<(), SceneError> {
        let is_history = matches!(self.command(edit)?, Command::Undo | Command::Redo);
        match &edit.tool {
            Some(tool) if is_history => return self.wrong(tool.span(), "`undo` and `redo` have no tool"),
            None if !is_history => {
                return Err(self.0.whole("an [[edit]] without `tool`; only `undo` and `redo` have none"));
            }
            _ => {}
        }
        if let Some(start) = edit.start.as_ref().filter(|t| t.get_ref().si < 0.0) {
            let text = format!("start is {} s; allowed is 0 or more", start.get_ref().si);
            return self.wrong(start.span(), text);
        }
        let start = edit.start.as_ref().map_or(0.0, |t| t.get_ref().si);
        if let Some(end) = edit.end.as_ref().filter(|t| t.get_ref().si <= start) {
            let text = format!("end is {} s; allowed is after the start at {start} s", end.get_ref().si);
            return self.wrong(end.span(), text);
        }
        if let Some(limit) = &edit.limit {
            self.above(limit.get_ref().si, limit.span(), "limit", " N")?;
        }
        if let Some(radius) = &edit.radius {
            self.above(radius.get_ref().si, radius.span(), "radius", " m")?;
        }
        self.keys(edit)?;
        match &edit.button {
            Some(button) if *button.get_ref() >= BUTTONS => {
                self.wrong(button.span(), format!("button {}; allowed is 0 to {}", button.get_ref(), BUTTONS - 1))
            }
            _ => Ok(()),
        }
    }

    /// Checks that the kind of the edit reads every key given.
    fn keys(&self, edit: &EditScene) -> Result<(), SceneError> {
        let given = [
            (KeyName::Limit, edit.limit.as_ref().map(Spanned::span)),
            (KeyName::Radius, edit.radius.as_ref().map(Spanned::span)),
            (KeyName::Falloff, edit.falloff.as_ref().map(Spanned::span)),
            (KeyName::Strength, edit.strength.as_ref().map(Spanned::span)),
            (KeyName::Param, edit.param.as_ref().map(Spanned::span)),
            (KeyName::Depth, edit.depth.as_ref().map(Spanned::span)),
            (KeyName::SheetLayers, edit.sheet_layers.as_ref().map(Spanned::span)),
            (KeyName::Split, edit.split.as_ref().map(Spanned::span)),
        ];
        let (name, known) = match self.command(edit)? {
            Command::Tool(kind) => (kind.name(), kind.keys()),
            Command::Undo | Command::Redo => (edit.kind.get_ref().0.as_str(), [].as_slice()),
        };
        for (key, span) in given.into_iter().filter_map(|(key, span)| Some((key, span?))) {
            if known.iter().any(|k| k.name == key) {
                continue;
            }
            let list: Vec<String> = known.iter().map(|k| format!("`{}`", k.name.as_str())).collect();
            let allowed = if list.is_empty() { "none of these keys".into() } else { list.join(", ") };
            let text = format!("edit kind `{name}` does not read `{}`; it reads {allowed}", key.as_str());
            return self.wrong(span, text);
        }
        Ok(())
    }
}
