//! A pointer for use without a mouse: arrow keys move it, Space grips and lets go.

use eframe::egui::{self, Key, Pos2, Rect, Vec2, vec2};

/// Speed of the pointer while an arrow key is down, points a second.
const SPEED: f32 = 160.0;
/// Factor of the speed with Shift held.
const FAST: f32 = 4.0;
/// Picture heights a second that the view turns with Alt and an arrow key.
const TURN_SPEED: f32 = 0.25;
/// Wheel turns a second, points, that Page up and Page down stand for.
const WHEEL_SPEED: f32 = 240.0;
/// Longest time between two frames that counts, s.
const LONGEST_FRAME: f32 = 0.1;

/// Effects of the keys since the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct KeyMotion {
    /// Turn of the view in picture heights, right and up.
    pub(super) turn: Vec2,
    /// Points of a wheel: nearer, or in a stroke deeper.
    pub(super) wheel: f32,
    /// Whether a stroke begins.
    pub(super) began: bool,
}

/// A pointer that is moved by keys.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct KeyPointer {
    /// Where it is; `None` while the mouse points.
    at: Option<Pos2>,
    /// Whether it holds.
    is_down: bool,
}

impl KeyPointer {
    /// Where it is; `None` while the mouse points.
    pub(super) fn at(&self) -> Option<Pos2> {
        self.at
    }

    /// Whether it holds.
    pub(super) fn is_down(&self) -> bool {
        self.is_down
    }

    /// Takes in the keys of a frame; the picture is at `rect`. A mouse that moves takes over, except in a stroke.
    pub(super) fn update(&mut self, context: &egui::Context, rect: Rect) -> KeyMotion {
        let (mouse, dt) = context.input(|input| (input.pointer.delta(), input.stable_dt.min(LONGEST_FRAME)));
        if mouse != Vec2::ZERO && !self.is_down {
            self.at = None;
        }
        if context.egui_wants_keyboard_input() {
            return KeyMotion::default();
        }
        let down = |key| context.input(|input| input.key_down(key));
        let modifiers = context.input(|input| input.modifiers);
        let axis = |less, more| f32::from(i8::from(down(more)) - i8::from(down(less)));
        let arrows = vec2(axis(Key::ArrowLeft, Key::ArrowRight), axis(Key::ArrowUp, Key::ArrowDown));
        let mut motion =
            KeyMotion { wheel: WHEEL_SPEED * dt * axis(Key::PageDown, Key::PageUp), ..KeyMotion::default() };
        if modifiers.alt {
            motion.turn = TURN_SPEED * dt * vec2(arrows.x, -arrows.y);
        } else if arrows != Vec2::ZERO && !modifiers.command {
            let speed = if modifiers.shift { FAST * SPEED } else { SPEED };
            let at = self.at.unwrap_or(rect.center()) + speed * dt * arrows;
            self.at = Some(rect.shrink(1.0).clamp(at));
        }
        if context.input(|input| input.key_pressed(Key::Space)) {
            self.is_down = !self.is_down;
            motion.began = self.is_down;
            self.at = self.at.or(Some(rect.center()));
        }
        if arrows != Vec2::ZERO || motion.wheel != 0.0 {
            context.request_repaint();
        }
        motion
    }

    /// Ends the grip after the stroke has ended.
    pub(super) fn let_go(&mut self) {
        self.is_down = false;
    }
}
