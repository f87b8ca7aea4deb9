//! The tools of the window: one for each edit kind of the engine.

use pliant_editor::{Gesture, PaintStroke, device_button, has_release, opposite_kind, stroke_button};
use pliant_engine::body::Axes;
use pliant_engine::edit::{DEFAULT_RADIUS, EditKind, Falloff, KINDS, KeyName};
use pliant_engine::scene::Release;

/// A tool of the tool bar: what a stroke with it does.
#[derive(Clone, Copy, Debug)]
pub struct ToolKind {
    /// The edit kind.
    pub kind: &'static dyn EditKind,
}

impl ToolKind {
    /// All of them: those of every hand first, then the others in the order of the engine's registry.
    pub fn all() -> Vec<Self> {
        let mut all: Vec<Self> = KINDS.iter().map(|kind| Self { kind: *kind }).collect();
        let rank = |tool: &Self| FIRST.iter().position(|name| *name == tool.name()).unwrap_or(FIRST.len());
        all.sort_by_key(rank);
        all
    }

    /// What the tool does with Ctrl held: the opposite, if the engine has it.
    pub fn inverse(&self, all: &[Self]) -> Option<Self> {
        let name = opposite_kind(self.name())?;
        all.iter().find(|tool| tool.name() == name).copied()
    }

    /// What a device does without a button: it feels the surface.
    pub fn feeling(all: &[Self]) -> Option<Self> {
        all.iter().find(|tool| tool.name() == FIRST[0]).copied()
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
        !has_release(self.kind)
    }

    /// Whether it paints a parameter of the material; with Ctrl it lowers it.
    pub fn paints(&self) -> bool {
        self.kind.param().is_some()
    }

    /// What the strength of its strokes is.
    pub fn strength(&self) -> ToolStrength {
        if self.kind.cuts() || self.paints() {
            ToolStrength::Fixed
        } else if self.kind.strength().is_some() {
            ToolStrength::Brush
        } else if self.gesture() == Gesture::Press {
            ToolStrength::Depth
        } else {
            ToolStrength::Fixed
        }
    }

    /// Radius of the region on which it acts over that of the tool; `None` where it acts on what it meets.
    pub fn region(&self) -> Option<f64> {
        self.kind.keys().iter().any(|key| key.name == KeyName::Radius).then_some(DEFAULT_RADIUS)
    }

    /// Whether its effect decreases from the centre of the region to its radius, in a way that may be chosen.
    pub fn has_falloff(&self) -> bool {
        self.kind.keys().iter().any(|key| key.name == KeyName::Falloff)
    }

    /// The mask of the button that begins a stroke of a device.
    pub fn device_buttons(&self, release: Release, paint: PaintStroke) -> u32 {
        1 << device_button(self.kind, release, paint)
    }

    /// The mask of the button that begins a stroke of the pointer.
    pub fn buttons(&self, release: Release, paint: PaintStroke) -> u32 {
        1 << stroke_button(self.kind, release, paint)
    }
}

/// Edit kinds with the first keys.
const FIRST: [&str; 4] = ["touch", "pull", "cut", "grab"];
/// Letters of tools that have no digit.
const LETTERS: [(&str, char); 6] =
    [("grow", 'G'), ("shrink", 'H'), ("pin", 'M'), ("unpin", 'N'), ("paint", 'P'), ("stitch", 'S')];
/// The edit kind that evens out.
const SMOOTHING: &str = "smooth";

/// What makes a stroke stronger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToolStrength {
    /// Nothing: what it does follows the hand, or is chosen otherwise.
    Fixed,
    /// The depth to which it presses.
    Depth,
    /// The strength of the edit, such as its pressure or its rate.
    Brush,
}

/// What a stroke does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolSettings {
    /// Radius over that of a new tool.
    pub size: f64,
    /// Depth of a press in radii of the tool.
    pub depth: f64,
    /// Strength of an edit over that of a new tool.
    pub brush: f64,
    /// How the effect of an edit decreases towards the radius of its region.
    pub falloff: Falloff,
    /// What becomes of the shape.
    pub release: Release,
    /// Depth of a cut over the size of the model: how far behind the pointer the tip of the blade is.
    pub cut_depth: f64,
    /// Axes (x, y, z) along which strokes are mirrored.
    pub symmetry: Axes,
    /// Place of the parameter that is painted among those of the model.
    pub painted: usize,
}

impl Default for ToolSettings {
    fn default() -> Self {
        Self {
            size: 1.0,
            depth: 1.0,
            brush: 1.0,
            falloff: Falloff::default(),
            release: Release::Keep,
            cut_depth: 1.0,
            symmetry: [false; 3],
            painted: 0,
        }
    }
}

impl ToolSettings {
    /// Sizes a tool may have.
    pub const SIZES: std::ops::RangeInclusive<f64> = 0.25..=6.0;
    /// Strengths a stroke may have: depths of a press in radii of the tool, or factors of that of a new tool.
    pub const STRENGTHS: std::ops::RangeInclusive<f64> = 0.05..=3.0;

    /// Makes the tool larger or smaller by a factor.
    pub fn resize(&mut self, factor: f64) {
        self.size = (self.size * factor).clamp(*Self::SIZES.start(), *Self::SIZES.end());
    }

    /// The strength of a tool's strokes, within [`ToolSettings::STRENGTHS`]; `None` where it is fixed.
    pub fn strength_mut(&mut self, tool: ToolKind) -> Option<&mut f64> {
        match tool.strength() {
            ToolStrength::Fixed => None,
            ToolStrength::Depth => Some(&mut self.depth),
            ToolStrength::Brush => Some(&mut self.brush),
        }
    }

    /// Makes strokes of a tool stronger or weaker by a factor, if they can be.
    pub fn strengthen(&mut self, tool: ToolKind, factor: f64) {
        if let Some(strength) = self.strength_mut(tool) {
            *strength = (*strength * factor).clamp(*Self::STRENGTHS.start(), *Self::STRENGTHS.end());
        }
    }

    /// Depth of a press, in radii of the tool.
    pub fn depth_of(&self, tool: ToolKind) -> f64 {
        if tool.strength() == ToolStrength::Depth { self.depth } else { 1.0 }
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
        // The panel, keys and signs follow the engine's list: none of its kinds is missing.
        assert_eq!(
            names.iter().collect::<BTreeSet<_>>(),
            KINDS.iter().map(|kind| kind.name()).collect::<Vec<_>>().iter().collect()
        );
        let mut masks = BTreeSet::new();
        for tool in &tools {
            let releases =
                if tool.always_stays() { vec![Release::Keep] } else { vec![Release::Keep, Release::SpringBack] };
            let paints = match tool.paints() {
                true => (0..2).flat_map(|param| [false, true].map(|lowers| PaintStroke { param, lowers })).collect(),
                false => vec![PaintStroke::default()],
            };
            for (release, paint) in
                releases.iter().flat_map(|release| paints.iter().map(move |paint| (*release, *paint)))
            {
                let mask = tool.buttons(release, paint);
                assert!(mask.count_ones() == 1 && masks.insert(mask), "{}: {release:?} {paint:?}", tool.name());
            }
        }
        assert_eq!(names[..3], ["touch", "pull", "cut"]);
        for tool in &tools {
            if let Some(inverse) = tool.inverse(&tools) {
                assert_eq!(inverse.inverse(&tools).map(|tool| tool.name()), Some(tool.name()));
            }
        }
        let keys: BTreeSet<_> = tools.iter().enumerate().map(|(index, tool)| tool.key(index)).collect();
        assert!(keys.len() == tools.len() && !keys.contains(&None), "every tool has a key of its own: {keys:?}");
        for tool in tools {
            assert_eq!(tool.gesture() == Gesture::Slice, tool.kind.cuts(), "{}", tool.name());
        }
    }
}
