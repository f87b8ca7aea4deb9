//! The strokes of a device, by the buttons of each step: the window hears of a button a frame later than the simulation.

use pliant_editor::{HandStroke, MAX_PAINTED, hand_strokes};
use pliant_engine::scene::Release;
use pliant_host::Pose;

/// Follows the buttons of a hand.
pub(super) struct DeviceStrokes {
    strokes: Vec<HandStroke>,
    /// What was pressed in the last step.
    pressed: Option<&'static str>,
}

/// What has begun or ended with a step.
#[derive(Debug, PartialEq)]
pub(super) enum StrokeChange {
    /// No stroke has begun or ended.
    None,
    /// A stroke of this edit kind has begun, whether or not another has ended.
    Began(&'static str),
    /// The stroke has ended.
    Ended,
}

impl DeviceStrokes {
    pub(super) fn new() -> Self {
        Self { strokes: hand_strokes(MAX_PAINTED), pressed: None }
    }

    /// Takes in the hand of a step. What springs back of itself leaves nothing to take back, and is no stroke.
    pub(super) fn update(&mut self, hand: Option<&Pose>) -> StrokeChange {
        let button = hand.map_or(u32::BITS, |pose| pose.buttons.trailing_zeros()) as usize;
        let stroke = self.strokes.get(button).filter(|stroke| stroke.release == Release::Keep);
        let pressed = stroke.map(|stroke| stroke.kind.name());
        match (std::mem::replace(&mut self.pressed, pressed), pressed) {
            (before, Some(now)) if before != Some(now) => StrokeChange::Began(now),
            (Some(_), None) => StrokeChange::Ended,
            _ => StrokeChange::None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_editor::stroke_button;
    use pliant_engine::edit::KINDS;

    #[test]
    fn every_stroke_that_stays_has_a_name_and_others_are_none() {
        let mut strokes = DeviceStrokes::new();
        let pose = |buttons| Pose { buttons, ..Pose::default() };
        for kind in KINDS.iter().copied() {
            let mask = |release| 1 << stroke_button(kind, release, Default::default());
            assert_eq!(strokes.update(Some(&pose(0))), StrokeChange::None);
            assert_eq!(strokes.update(Some(&pose(mask(Release::Keep)))), StrokeChange::Began(kind.name()));
            assert_eq!(strokes.update(Some(&pose(mask(Release::Keep)))), StrokeChange::None);
            assert_eq!(strokes.update(None), StrokeChange::Ended);
        }
        let touch = KINDS.iter().copied().find(|kind| kind.name() == "touch").unwrap();
        let felt = 1 << stroke_button(touch, Release::SpringBack, Default::default());
        assert_eq!(strokes.update(Some(&pose(felt))), StrokeChange::None);
    }
}
