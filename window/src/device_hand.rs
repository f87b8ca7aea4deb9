//! The hand of a device: where its workspace is in the picture, and what its buttons do.
//!
//! Right, up and towards the user of the device are those of the picture; the middle of its workspace is what the camera looks at. During a stroke the workspace
//! stays where it is, however the camera turns.

use crate::view::Camera;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use pliant_editor::HandPlace;
use pliant_live::{DeviceScale, Guide, GuideHandle};

/// A device that can have the hand.
pub struct DeviceHand {
    handle: GuideHandle,
    /// What was asked for last.
    guide: Guide,
    /// How lengths and forces are scaled.
    pub scale: DeviceScale,
    /// What the device is called.
    pub name: String,
    /// Place in [`Guide::buttons`] of what is pressed.
    pressed: usize,
}

/// What the device's user has done since the last call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HandNews {
    /// Nothing but motion.
    None,
    /// A stroke has begun, with the first button or with another.
    Began {
        /// Whether it is another than the first.
        is_other: bool,
    },
    /// The stroke has ended.
    Ended,
    /// The device is lost, and why; the pointer has the hand.
    Lost(&'static str),
}

impl DeviceHand {
    /// A device with its handle, scale and name. It leads at once.
    pub fn new(handle: GuideHandle, scale: DeviceScale, name: String) -> Self {
        Self { handle, guide: Guide { leads: true, ..Guide::default() }, scale, name, pressed: 0 }
    }

    /// Whether the device has the hand, and not the pointer.
    pub fn leads(&self) -> bool {
        self.guide.leads
    }

    /// Gives the hand to the device, or to the pointer. The device gets it with the next frame, where the picture then is.
    pub fn set_leads(&mut self, leads: bool) {
        self.guide.leads = leads;
        self.pressed = 0;
        if !leads {
            self.handle.set(self.guide);
        }
    }

    /// Whether a stroke is under way.
    pub fn is_busy(&self) -> bool {
        self.pressed > 0
    }

    /// Where the hand is in the scene, and its buttons there; `None` while the device gives no pose.
    pub fn place(&mut self) -> Option<(HandPlace, u32)> {
        let hand = self.handle.hand();
        hand.place.map(|(position, rotation)| (HandPlace { position, rotation }, self.guide.buttons[hand.pressed]))
    }

    /// Guides the device for a frame. `buttons`: as for [`Guide::buttons`]; `force_share`: of what the device can render, 0 to 1.
    pub fn advance(&mut self, camera: &Camera, buttons: [u32; 3], force_share: f64) -> HandNews {
        let hand = self.handle.hand();
        if let Some(status) = hand.lost {
            self.set_leads(false);
            return HandNews::Lost(status.meaning());
        }
        let before = std::mem::replace(&mut self.pressed, hand.pressed);
        if hand.pressed == 0 {
            let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&camera.axes()));
            self.guide.rotation = UnitQuaternion::from_rotation_matrix(&axes);
            self.guide.centre = camera.target.coords;
            self.guide.buttons = buttons;
        }
        self.guide.force_share = force_share;
        self.handle.set(self.guide);
        match (before, hand.pressed) {
            (0, 0) => HandNews::None,
            (0, pressed) => HandNews::Began { is_other: pressed > 1 },
            (_, 0) => HandNews::Ended,
            _ => HandNews::None,
        }
    }
}
