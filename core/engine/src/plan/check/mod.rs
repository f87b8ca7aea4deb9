//! Checks of a parsed scene: names, ranges of numbers, keys that belong together.

mod body;
mod edit;
mod obstacle;
mod time;
mod tool;

pub(super) use edit::depth;
pub(crate) use edit::strength;

use crate::scene::{ProbeScene, Scene, SceneError, Source};
use std::collections::HashSet;
use std::ops::Range;
use toml::Spanned;

/// Checks a scene.
///
/// # Errors
/// Returns the first error, with the value found and what is allowed.
pub(super) fn check(scene: &Scene, source: &Source) -> Result<(), SceneError> {
    let check = Check(source);
    check.time(scene)?;
    check.names("body", scene.body.iter().map(|b| &b.name))?;
    check.names("obstacle", scene.obstacle.iter().map(|o| &o.name))?;
    check.names("device", scene.device.iter().map(|d| &d.name))?;
    check.names("tool", scene.tool.iter().map(|t| &t.name))?;
    scene.body.iter().try_for_each(|body| check.body(body))?;
    scene.body.iter().try_for_each(|body| super::collisions::check(body, scene, source))?;
    scene.body.iter().filter_map(|body| body.friction.as_ref()).try_for_each(|friction| check.friction(friction))?;
    super::stitches::check(scene, source)?;
    scene.obstacle.iter().try_for_each(|obstacle| check.obstacle(obstacle, scene))?;
    scene.device.iter().try_for_each(|device| check.device(device))?;
    scene.tool.iter().try_for_each(|tool| check.tool(tool))?;
    scene.edit.iter().try_for_each(|edit| check.edit(edit))?;
    check.edits_of_tetrahedra(scene)?;
    scene.probe.iter().try_for_each(|probe| check.probe(probe, scene.time.duration.get_ref().si))?;
    match &scene.output.frames {
        Some(rate) => check.above(rate.get_ref().si, rate.span(), "frames", " Hz"),
        None => Ok(()),
    }
}

/// Checks with the source for error messages.
pub(super) struct Check<'a>(&'a Source);

impl Check<'_> {
    /// An error at a span of the source.
    pub(in crate::plan) fn wrong(&self, span: Range<usize>, text: impl Into<String>) -> Result<(), SceneError> {
        Err(self.0.error(span, text))
    }

    /// Checks that a value is finite and above 0.
    fn above(&self, value: f64, span: Range<usize>, what: &str, unit: &str) -> Result<(), SceneError> {
        if value.is_finite() && value > 0.0 {
            return Ok(());
        }
        self.wrong(span, format!("{what} is {value}{unit}; allowed is a number above 0"))
    }

    /// Checks that names are unique and can be used in names of files and CSV columns.
    fn names<'a>(&self, what: &str, names: impl Iterator<Item = &'a Spanned<String>>) -> Result<(), SceneError> {
        let mut known: HashSet<&str> = HashSet::new();
        for spanned in names {
            let name = spanned.get_ref().as_str();
            if name.is_empty() || name.contains(|c: char| c.is_control() || r#"/\,""#.contains(c)) {
                let text = format!("{what} {name:?}; allowed is a name without / \\ , \" and control characters");
                return self.wrong(spanned.span(), text);
            }
            if !known.insert(name) {
                return self
                    .wrong(spanned.span(), format!("{what} `{name}` is there twice; allowed is one of each name"));
            }
        }
        Ok(())
    }

    fn probe(&self, probe: &ProbeScene, duration: f64) -> Result<(), SceneError> {
        self.above(*probe.tolerance.get_ref(), probe.tolerance.span(), "tolerance", "")?;
        if let Some(expected) = probe.expected.as_ref().filter(|e| !e.get_ref().is_finite()) {
            return self
                .wrong(expected.span(), format!("expected is {}; allowed is a finite number", expected.get_ref()));
        }
        match &probe.time {
            Some(time) if !(0.0..=duration).contains(&time.get_ref().si) => {
                let text = format!("time is {} s; allowed is 0 to {duration} s, the scene's end", time.get_ref().si);
                self.wrong(time.span(), text)
            }
            _ => Ok(()),
        }
    }
}
