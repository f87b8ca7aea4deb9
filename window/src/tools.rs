//! The tools of the window: one for each edit kind of the engine.

use pliant_editor::{Gesture, stroke_button, stroke_kinds};
use pliant_engine::edit::EditKind;
use pliant_engine::scene::Release;

/// A tool.
#[derive(Clone, Copy, Debug)]
pub struct ToolKind {
    /// The edit kind.
    pub kind: &'static dyn EditKind,
    /// Place among the kinds that have buttons.
    place: usize,
}

impl ToolKind {
    /// All of them: those of every hand first, then the others in the order of the engine's registry.
    pub fn all() -> Vec<Self> {
        let mut all: Vec<Self> = stroke_kinds().enumerate().map(|(place, kind)| Self { kind, place }).collect();
        let rank = |tool: &Self| FIRST.iter().position(|name| *name == tool.name()).unwrap_or(FIRST.len());
        all.sort_by_key(rank);
        all
    }

    /// What the tool does with Ctrl held: the opposite, if the engine has it.
    pub fn inverse(&self, all: &[Self]) -> Option<Self> {
        let of = |[a, b]: [&str; 2]| {
            if a == self.name() { Some(b.to_owned()) } else { (b == self.name()).then(|| a.to_owned()) }
        };
        let name = OPPOSITES.into_iter().find_map(of)?;
        all.iter().find(|tool| tool.name() == name).copied()
    }

    /// What any tool does with Shift held, if the engine has it.
    pub fn smoothing(all: &[Self]) -> Option<Self> {
        all.iter().find(|tool| tool.name() == SMOOTHING).copied()
    }

    /// The key that takes the tool, where it is number `index` of all, from 0: ten digits, the last of which is 0, then letters.
    pub fn key(&self, index: usize) -> Option<char> {
        let digit = || char::from_digit((index as u32 + 1) % 10, 10);
        let letter = LETTERS.iter().find(|(name, _)| *name == self.name()).map(|(_, letter)| *letter);
        if index < 10 { digit() } else { letter }
    }

    /// As scenes write it.
    pub fn name(&self) -> &'static str {
        self.kind.name()
    }

    /// How the pointer drives it: a blade points away from the viewer, what takes hold is dragged, everything else lies on the surface.
    pub fn gesture(&self) -> Gesture {
        if self.kind.cuts() {
            Gesture::Slice
        } else if self.kind.grips() {
            Gesture::Drag
        } else {
            Gesture::Press
        }
    }

    /// Whether its stroke changes the model for good even if no shape is kept.
    pub fn always_stays(&self) -> bool {
        self.kind.cuts() || self.kind.changes_body()
    }

    /// The mask of the button that begins a stroke.
    pub fn buttons(&self, release: Release) -> u32 {
        1 << stroke_button(self.place, release)
    }
}

/// Edit kinds with the first keys.
const FIRST: [&str; 4] = ["touch", "pull", "cut", "grab"];
/// Edit kinds that undo each other.
const OPPOSITES: [[&str; 2]; 3] = [["inflate", "deflate"], ["grow", "shrink"], ["pin", "unpin"]];
/// Letters of tools that have no digit.
const LETTERS: [(&str, char); 4] = [("pin", 'M'), ("unpin", 'N'), ("paint", 'P'), ("stitch", 'S')];
/// The edit kind that evens out.
const SMOOTHING: &str = "smooth";

/// What a stroke does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolSettings {
    /// Radius over that of a new tool.
    pub size: f64,
    /// Depth of a press in radii of the tool.
    pub strength: f64,
    /// What becomes of the shape.
    pub release: Release,
    /// Depth of a cut over the size of the model: how far behind the pointer the tip of the blade is.
    pub cut_depth: f64,
    /// Axis (0 for x) across which strokes are mirrored.
    pub mirror: Option<usize>,
}

impl Default for ToolSettings {
    fn default() -> Self {
        Self { size: 1.0, strength: 1.0, release: Release::Keep, cut_depth: 1.0, mirror: None }
    }
}

impl ToolSettings {
    /// Sizes a tool may have.
    pub const SIZES: std::ops::RangeInclusive<f64> = 0.25..=6.0;
    /// Strengths a press may have.
    pub const STRENGTHS: std::ops::RangeInclusive<f64> = 0.05..=3.0;

    /// Makes the tool larger or smaller by a factor.
    pub fn resize(&mut self, factor: f64) {
        self.size = (self.size * factor).clamp(*Self::SIZES.start(), *Self::SIZES.end());
    }

    /// Makes a press deeper or shallower by a factor.
    pub fn strengthen(&mut self, factor: f64) {
        self.strength = (self.strength * factor).clamp(*Self::STRENGTHS.start(), *Self::STRENGTHS.end());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_edit_kind_of_the_engine_is_a_tool_with_buttons_of_its_own() {
        let tools = ToolKind::all();
        let names: Vec<_> = tools.iter().map(ToolKind::name).collect();
        assert!(["touch", "pull", "cut"].iter().all(|name| names.contains(name)), "{names:?}");
        let masks: BTreeSet<u32> =
            tools.iter().flat_map(|t| [Release::Keep, Release::SpringBack].map(|release| t.buttons(release))).collect();
        assert_eq!(masks.len(), 2 * tools.len());
        assert!(masks.iter().all(|mask| mask.count_ones() == 1));
        assert_eq!(names[..3], ["touch", "pull", "cut"]);
        for tool in &tools {
            if let Some(inverse) = tool.inverse(&tools) {
                assert_eq!(inverse.inverse(&tools).map(|tool| tool.name()), Some(tool.name()));
            }
        }
        for tool in tools {
            assert_eq!(tool.gesture() == Gesture::Slice, tool.kind.cuts(), "{}", tool.name());
        }
    }
}
