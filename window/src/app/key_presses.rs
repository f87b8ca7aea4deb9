//! Presses of keys since the last frame. Each has the modifiers of its own time: those at the end of a slow frame may be of a key that came later.

use eframe::egui::{Event, InputState, Key};

/// How often a key was pressed without modifiers; one that is held counts again and again where `with_repeats`.
fn count(input: &InputState, wanted: Key, with_repeats: bool) -> usize {
    let is_press = |event: &&Event| {
        matches!(event, Event::Key { key, pressed: true, repeat, modifiers, .. }
            if *key == wanted && modifiers.is_none() && (with_repeats || !repeat))
    };
    input.events.iter().filter(is_press).count()
}

/// How often a key was pressed without modifiers; one that is held counts again and again.
pub(super) fn plain_presses(input: &InputState, key: Key) -> i32 {
    count(input, key, true) as i32
}

/// Whether a key was pressed without modifiers.
pub(super) fn is_pressed(input: &InputState, key: Key) -> bool {
    count(input, key, false) > 0
}

/// Whether the presses of a key without modifiers switch what each of them switches; two leave it as it was.
pub(super) fn switches(input: &InputState, key: Key) -> bool {
    count(input, key, false) % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::Modifiers;

    fn input(presses: &[(Key, Modifiers, bool)], modifiers: Modifiers) -> InputState {
        let event =
            |&(key, modifiers, repeat)| Event::Key { key, physical_key: None, pressed: true, repeat, modifiers };
        let mut state = InputState::default();
        state.events.extend(presses.iter().map(event));
        state.modifiers = modifiers;
        state
    }

    #[test]
    fn a_press_has_the_modifiers_of_its_own_time() {
        let plain = (Key::X, Modifiers::NONE, false);
        let save = (Key::S, Modifiers::COMMAND, false);
        // Ctrl+S right after X, in one frame at whose end Ctrl is down.
        let frame = input(&[plain, save], Modifiers::COMMAND);
        assert!(is_pressed(&frame, Key::X) && switches(&frame, Key::X) && !is_pressed(&frame, Key::S));
        // Ctrl+X, let go before the end of the frame.
        assert!(!is_pressed(&input(&[(Key::X, Modifiers::COMMAND, false)], Modifiers::NONE), Key::X));
        // Twice in one frame.
        let twice = input(&[plain, plain], Modifiers::NONE);
        assert!(is_pressed(&twice, Key::X) && !switches(&twice, Key::X));
        // One that is held makes a tool grow, but switches nothing to and fro.
        let held = input(&[plain, (Key::X, Modifiers::NONE, true)], Modifiers::NONE);
        assert!(switches(&held, Key::X) && plain_presses(&held, Key::X) == 2);
    }
}
