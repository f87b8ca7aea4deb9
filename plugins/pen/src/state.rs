//! The state of a pen, frame by frame, and the pose of the hand that follows from it.

use crate::axes::Axes;
use crate::event::{
    ABS_DISTANCE, ABS_PRESSURE, ABS_TILT_X, ABS_TILT_Y, ABS_X, ABS_Y, BTN_STYLUS, BTN_STYLUS2, BTN_TOOL_PEN,
    BTN_TOOL_RUBBER, BTN_TOUCH, EV_ABS, EV_KEY, EV_SYN, Event, SYN_DROPPED, SYN_REPORT,
};
use pliant_plugin_api::abi::{POSE_VALID, Pose};

/// Button of the hand: the tip touches.
pub(crate) const TIP: u32 = 1;
/// Button of the hand: the lower button of the barrel.
pub(crate) const LOWER: u32 = 1 << 1;
/// Button of the hand: the upper button of the barrel.
pub(crate) const UPPER: u32 = 1 << 2;
/// Button of the hand: the eraser is towards the tablet.
pub(crate) const ERASER: u32 = 1 << 3;

/// Mapping from values of the pen to the space of the hand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mapping {
    /// Axes of the tablet.
    pub axes: Axes,
    /// Width and height of the tablet in the space of the hand, m.
    pub size: [f64; 2],
    /// Depth of the hand below the tablet at full pressure, m.
    pub depth: f64,
    /// Height of the hand above the tablet without pressure, m; up to twice as high if the device measures the distance of the tip.
    pub hover: f64,
}

/// Values of a pen's axes, each in the device's own units, and the buttons that are down, [`TIP`] to [`ERASER`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Values {
    x: i32,
    y: i32,
    pressure: i32,
    distance: i32,
    tilt_x: i32,
    tilt_y: i32,
    buttons: u32,
}

/// State of a pen that follows from its events.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PenState {
    /// Values at the end of the last complete frame.
    shown: Values,
    /// Values with the events of the present frame so far.
    coming: Values,
    /// Whether the pen is near the tablet.
    is_near: bool,
    /// Whether x and y are known: the kernel sends only values that change, so one of them may arrive long before the other.
    knows: [bool; 2],
    /// Whether the present frame has a position, or an event that the pen has come near.
    has_moved: bool,
    /// Whether the present frame has an event that the pen has left.
    has_left: bool,
    /// Whether events are missing up to the end of the present frame.
    is_dropped: bool,
    /// Number of frames with missing events.
    pub dropped: u64,
}

impl PenState {
    /// A pen whose axes have the values that the device says it has at opening. It is near once it moves.
    pub fn opened(axes: &Axes) -> Self {
        let Axes { x, y, pressure, distance, tilt_x, tilt_y } = axes;
        let [x, y, pressure, distance, tilt_x, tilt_y] =
            [x, y, pressure, distance, tilt_x, tilt_y].map(|axis| axis.value);
        let values = Values { x, y, pressure, distance, tilt_x, tilt_y, buttons: 0 };
        Self { shown: values, coming: values, knows: [true; 2], ..Self::default() }
    }

    /// Applies an event. Returns whether it ends a frame.
    pub fn take(&mut self, event: Event) -> bool {
        match (event.kind, event.code) {
            (EV_SYN, SYN_DROPPED) => {
                // What is missing may be the tip that was lifted.
                self.is_dropped = true;
                self.dropped += 1;
            }
            (EV_SYN, SYN_REPORT) => {
                self.end_frame();
                return true;
            }
            _ if self.is_dropped => {}
            (EV_ABS, code) => self.move_axis(code, event.value),
            (EV_KEY, code) => self.press(code, event.value != 0),
            _ => {}
        }
        false
    }

    fn move_axis(&mut self, code: u16, value: i32) {
        let place = match code {
            ABS_X => &mut self.coming.x,
            ABS_Y => &mut self.coming.y,
            ABS_PRESSURE => &mut self.coming.pressure,
            ABS_DISTANCE => &mut self.coming.distance,
            ABS_TILT_X => &mut self.coming.tilt_x,
            ABS_TILT_Y => &mut self.coming.tilt_y,
            _ => return,
        };
        *place = value;
        self.knows[0] |= code == ABS_X;
        self.knows[1] |= code == ABS_Y;
        // A pen that was near before the device was opened does not say so again.
        self.has_moved |= code == ABS_X || code == ABS_Y;
    }

    fn press(&mut self, code: u16, down: bool) {
        let button = match code {
            BTN_TOUCH => TIP,
            BTN_STYLUS => LOWER,
            BTN_STYLUS2 => UPPER,
            BTN_TOOL_PEN | BTN_TOOL_RUBBER => {
                self.has_left |= !down;
                self.has_moved |= down;
                if code == BTN_TOOL_PEN { 0 } else { ERASER }
            }
            _ => return,
        };
        self.coming.buttons = if down { self.coming.buttons | button } else { self.coming.buttons & !button };
    }

    fn end_frame(&mut self) {
        if self.is_dropped {
            // The tip may have been lifted meanwhile. Where the pen is has changed little, and what has not changed is not sent again.
            let values = Values { pressure: 0, buttons: 0, ..self.coming };
            *self = Self { shown: values, coming: values, knows: self.knows, dropped: self.dropped, ..Self::default() };
            return;
        }
        if self.has_left {
            self.coming.buttons = 0;
        }
        let has_place = self.knows == [true; 2];
        self.is_near = !self.has_left && has_place && (self.is_near || self.has_moved);
        (self.has_moved, self.has_left) = (false, false);
        self.shown = self.coming;
    }

    /// Marks the pen as away, when its events have ceased.
    pub fn leave(&mut self) {
        *self = Self { dropped: self.dropped, ..Self::default() };
    }

    /// The pose of the hand; an invalid one while no pen is near.
    pub fn pose(&self, map: &Mapping) -> Pose {
        if !self.is_near {
            return Pose::default();
        }
        let (Values { x, y, pressure, distance, tilt_x, tilt_y, buttons }, axes) = (self.shown, &map.axes);
        let touches = buttons & TIP != 0;
        // Without a jump where the tip begins to touch: there is no pressure yet.
        let height = match touches {
            true => map.hover - (map.hover + map.depth) * axes.pressure.share(pressure),
            false => map.hover * (1.0 + axes.distance.share(distance)),
        };
        // The device's y axis goes up, that of a tablet towards the user.
        let position = [(axes.x.share(x) - 0.5) * map.size[0], (0.5 - axes.y.share(y)) * map.size[1], height];
        let orientation = along([axes.tilt_x.angle(tilt_x), -axes.tilt_y.angle(tilt_y)]);
        Pose { flags: POSE_VALID, buttons, position, orientation, ..Pose::default() }
    }
}

/// Largest tilt that is used, rad: a pen that lies flat has no direction.
const MAX_TILT: f64 = 1.4;

/// The shortest turn (unit quaternion x, y, z, w) of the z axis to a barrel that is tilted by these angles (rad) to the right and up.
fn along(tilt: [f64; 2]) -> [f64; 4] {
    let [x, y] = tilt.map(|angle| libm::tan(angle.clamp(-MAX_TILT, MAX_TILT)));
    let length = (x * x + y * y + 1.0).sqrt();
    let [x, y, z] = [x / length, y / length, 1.0 / length];
    let norm = (2.0 + 2.0 * z).sqrt();
    [-y / norm, x / norm, 0.0, (1.0 + z) / norm]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axes::Axis;

    fn map() -> Mapping {
        let axes = Axes {
            x: Axis { min: 0, max: 1000, resolution: 0, value: 0 },
            y: Axis { min: -100, max: 400, resolution: 0, value: 0 },
            pressure: Axis { min: 0, max: 2000, resolution: 0, value: 0 },
            ..Axes::default()
        };
        Mapping { axes, size: [0.2, 0.1], depth: 0.01, hover: 0.005 }
    }

    fn frame(pen: &mut PenState, events: &[(u16, u16, i32)]) {
        for &(kind, code, value) in events.iter().chain([&(EV_SYN, SYN_REPORT, 0)]) {
            pen.take(Event { time_ns: 0, kind, code, value });
        }
    }

    #[test]
    fn a_stroke_hovers_presses_and_leaves() {
        let (mut pen, map) = (PenState::default(), map());
        assert_eq!(pen.pose(&map).flags, 0, "no pen is near");
        frame(&mut pen, &[(EV_KEY, BTN_TOOL_PEN, 1), (EV_ABS, ABS_X, 750), (EV_ABS, ABS_Y, -100)]);
        let pose = pen.pose(&map);
        assert_eq!((pose.flags, pose.buttons, pose.position), (POSE_VALID, 0, [0.05, 0.05, 0.005]));
        assert_eq!(pose.orientation, [0.0, 0.0, 0.0, 1.0]);
        frame(&mut pen, &[(EV_KEY, BTN_TOUCH, 1), (EV_ABS, ABS_PRESSURE, 500), (EV_KEY, BTN_STYLUS2, 1)]);
        let pose = pen.pose(&map);
        assert_eq!((pose.buttons, pose.position[..2].to_vec()), (TIP | UPPER, vec![0.05, 0.05]));
        assert!((pose.position[2] - 0.00125).abs() < 1e-12, "{pose:?}");
        // Until a frame is whole the one before counts.
        pen.take(Event { time_ns: 0, kind: EV_ABS, code: ABS_X, value: 0 });
        assert_eq!(pen.pose(&map).position[0], 0.05);
        frame(&mut pen, &[]);
        assert_eq!(pen.pose(&map).position[0], -0.1);
        frame(&mut pen, &[(EV_KEY, BTN_TOUCH, 0), (EV_ABS, ABS_PRESSURE, 0), (EV_KEY, BTN_STYLUS2, 0)]);
        assert_eq!((pen.pose(&map).buttons, pen.pose(&map).position[2]), (0, 0.005));
        frame(&mut pen, &[(EV_ABS, ABS_X, 0), (EV_ABS, ABS_Y, 0), (EV_KEY, BTN_TOOL_PEN, 0)]);
        assert_eq!(pen.pose(&map).flags, 0);
    }

    #[test]
    fn missing_events_lift_the_pen_until_it_is_heard_again() {
        let (mut pen, map) = (PenState::default(), map());
        frame(
            &mut pen,
            &[(EV_KEY, BTN_TOOL_PEN, 1), (EV_ABS, ABS_X, 500), (EV_ABS, ABS_Y, 400), (EV_KEY, BTN_TOUCH, 1)],
        );
        pen.take(Event { time_ns: 0, kind: EV_SYN, code: SYN_DROPPED, value: 0 });
        frame(&mut pen, &[(EV_ABS, ABS_X, 900)]);
        assert_eq!((pen.pose(&map).flags, pen.dropped), (0, 1));
        frame(&mut pen, &[(EV_ABS, ABS_X, 250)]);
        let pose = pen.pose(&map);
        assert_eq!((pose.flags, pose.buttons, pose.position), (POSE_VALID, 0, [-0.05, -0.05, 0.005]), "y was kept");
    }

    /// The kernel sends only what changes: x alone places no pen unless the device has said y.
    #[test]
    fn a_pen_is_near_once_both_axes_are_known() {
        let map = map();
        let mut pen = PenState::default();
        frame(&mut pen, &[(EV_ABS, ABS_X, 750)]);
        assert_eq!(pen.pose(&map).flags, 0, "y is unknown");
        frame(&mut pen, &[(EV_ABS, ABS_Y, 400)]);
        assert_eq!((pen.pose(&map).flags, pen.pose(&map).position), (POSE_VALID, [0.05, -0.05, 0.005]));
        let y = Axis { value: 275, ..map.axes.y };
        let mut pen = PenState::opened(&Axes { y, ..map.axes });
        assert_eq!(pen.pose(&map).flags, 0, "it may be far away");
        frame(&mut pen, &[(EV_ABS, ABS_X, 750)]);
        assert_eq!((pen.pose(&map).flags, pen.pose(&map).position), (POSE_VALID, [0.05, -0.025, 0.005]));
    }

    /// Over all tilts the z axis goes where the barrel points.
    #[test]
    fn the_hand_turns_with_the_barrel() {
        for (right, up) in (-8..=8).flat_map(|a| (-8..=8).map(move |b| (0.15 * f64::from(a), 0.15 * f64::from(b)))) {
            let [x, y, z, w] = along([right, up]);
            assert!((x * x + y * y + z * z + w * w - 1.0).abs() < 1e-12);
            let barrel = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
            assert!((barrel[0] / barrel[2] - right.tan()).abs() < 1e-9, "{right} {up}: {barrel:?}");
            assert!((barrel[1] / barrel[2] - up.tan()).abs() < 1e-9, "{right} {up}: {barrel:?}");
        }
    }
}
