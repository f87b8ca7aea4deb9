//! Presses of keys since the last frame. Each has the modifiers of its own time: those at the end of a slow frame may be of a key that came later.

use eframe::egui::{Event, Key, PointerButton};

/// The events of a frame before the main button of the pointer is pressed, and those from then on: a stroke begins with what the first have set.
pub(super) fn around_press(events: &[Event]) -> [&[Event]; 2] {
    let is_press =
        |event: &Event| matches!(event, Event::PointerButton { button: PointerButton::Primary, pressed: true, .. });
    let (before, after) = events.split_at(events.iter().position(is_press).unwrap_or(events.len()));
    [before, after]
}

/// How often a key was pressed without modifiers; one that is held counts again and again where `with_repeats`.
fn count(events: &[Event], wanted: Key, with_repeats: bool) -> usize {
    let is_press = |event: &&Event| {
        matches!(event, Event::Key { key, pressed: true, repeat, modifiers, .. }
            if *key == wanted && modifiers.is_none() && (with_repeats || !repeat))
    };
    events.iter().filter(is_press).count()
}

/// How often a key was pressed without modifiers; one that is held counts again and again.
pub(super) fn plain_presses(events: &[Event], key: Key) -> i32 {
    count(events, key, true) as i32
}

/// Whether a key was pressed without modifiers.
pub(super) fn is_pressed(events: &[Event], key: Key) -> bool {
    count(events, key, false) > 0
}

/// Whether the presses of a key without modifiers switch what each of them switches; two leave it as it was.
pub(super) fn switches(events: &[Event], key: Key) -> bool {
    count(events, key, false) % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Modifiers, Pos2};

    fn presses(presses: &[(Key, Modifiers, bool)]) -> Vec<Event> {
        let event =
            |&(key, modifiers, repeat)| Event::Key { key, physical_key: None, pressed: true, repeat, modifiers };
        presses.iter().map(event).collect()
    }

    #[test]
    fn a_press_has_the_modifiers_of_its_own_time() {
        let plain = (Key::X, Modifiers::NONE, false);
        let save = (Key::S, Modifiers::COMMAND, false);
        // Ctrl+S right after X, in one frame.
        let frame = presses(&[plain, save]);
        assert!(is_pressed(&frame, Key::X) && switches(&frame, Key::X) && !is_pressed(&frame, Key::S));
        // Ctrl+X, let go before the end of the frame.
        assert!(!is_pressed(&presses(&[(Key::X, Modifiers::COMMAND, false)]), Key::X));
        // Twice in one frame.
        let twice = presses(&[plain, plain]);
        assert!(is_pressed(&twice, Key::X) && !switches(&twice, Key::X));
        // One that is held makes a tool grow, but switches nothing to and fro.
        let held = presses(&[plain, (Key::X, Modifiers::NONE, true)]);
        assert!(switches(&held, Key::X) && plain_presses(&held, Key::X) == 2);
    }

    #[test]
    fn a_stroke_begins_with_what_was_set_before_it() {
        let [plain, other] = [Key::X, Key::Y].map(|key| presses(&[(key, Modifiers::NONE, false)]).remove(0));
        let button =
            |button| Event::PointerButton { pos: Pos2::ZERO, button, pressed: true, modifiers: Modifiers::NONE };
        let frame = [plain.clone(), button(PointerButton::Middle), button(PointerButton::Primary), other.clone()];
        let [before, after] = around_press(&frame);
        assert!(switches(before, Key::X) && !switches(before, Key::Y));
        assert!(switches(after, Key::Y) && !switches(after, Key::X));
        let without = [plain, other];
        let [before, after] = around_press(&without);
        assert!(switches(before, Key::X) && switches(before, Key::Y) && after.is_empty());
    }
}
