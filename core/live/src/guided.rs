//! A device in the axes of a view, whose place, scale and buttons a program chooses while it is used.
//!
//! The hand is that of the device as long as the device leads, otherwise that of a [`PointerDevice`]. Positions are scaled from the device's workspace to the
//! scene and forces back, each by one number: as long as the workspace stands still in the scene, a force that gives no energy to the scene's hand gives none to
//! the device's.
//!
//! *Real time*: as every device; what is asked for comes through a triple buffer.

use crate::device::{HapticDevice, StopDevice};
use crate::pointer::PointerDevice;
use nalgebra::UnitQuaternion;
use pliant_host::{DeviceInfo, EffectorOutput, MAX_EFFECTORS, POSE_VALID, Pose};
use pliant_plugin_api::abi::Status;
use pliant_solver::Vec3;
use triple_buffer::{Input, Output, triple_buffer};

/// How lengths and forces of a device are scaled to those of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceScale {
    /// Displacement in the scene for one of the device.
    pub length: f64,
    /// Force on the device for one in the scene.
    pub force: f64,
}

/// Share of a workspace's width that the model takes: a hand must get around it.
const MODEL_SHARE: f64 = 0.7;
/// Width of a workspace that a device does not state, m.
const DEFAULT_WIDTH: f64 = 0.15;
/// Share of the largest stable stiffness of a device that the coupling may have.
const STIFFNESS_SHARE: f64 = 0.8;

/// Scale of a new fit over the one before for which lengths keep theirs: the model takes half to all of the workspace.
const LENGTHS_KEPT: std::ops::RangeInclusive<f64> = 0.5 / MODEL_SHARE..=1.0 / MODEL_SHARE;

/// Force on the device for one in the scene, at a scale of lengths at which neither `coupling` (N/m) nor `peak_force` (N) are more than the device can render.
fn force_scale(device: &DeviceInfo, length: f64, coupling: f64, peak_force: f64) -> f64 {
    let force = (STIFFNESS_SHARE * device.stiffness / (coupling * length)).min(device.peak_force / peak_force);
    // A device that renders no force needs no scale of it.
    if force > 0.0 { force } else { 1.0 }
}

impl DeviceScale {
    /// The scale at which a model of this `size` (m) fits into the workspace, and at which neither the `coupling` (N/m) nor the `peak_force` (N) of the hand in
    /// the scene are more than the device can render.
    pub fn fit(device: &DeviceInfo, size: f64, coupling: f64, peak_force: f64) -> Self {
        let [left, bottom, _, right, top, _] = device.workspace;
        let width = (right - left).min(top - bottom);
        let length = size / (MODEL_SHARE * if width > 0.0 { width } else { DEFAULT_WIDTH });
        Self { length, force: force_scale(device, length, coupling, peak_force) }
    }

    /// Limits of a device as those of the hand in the scene, with one effector and buttons for every edit.
    fn info(&self, device: &DeviceInfo) -> DeviceInfo {
        let stiffness = self.force * self.length;
        DeviceInfo {
            effectors: 1,
            buttons: u32::BITS,
            taxel_rows: 0,
            taxel_columns: 0,
            peak_force: device.peak_force / self.force,
            continuous_force: device.continuous_force / self.force,
            stiffness: device.stiffness / stiffness,
            damping: device.damping / stiffness,
            resolution: device.resolution * self.length,
            workspace: device.workspace.map(|c| c * self.length),
            peak_torque: device.peak_torque * self.length / self.force,
            ..*device
        }
    }
}

/// A new scale of a guided device, for a session that takes the device over from another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rescaling {
    before: DeviceScale,
    scale: DeviceScale,
    /// Limits of the device at the new scale.
    pub(crate) info: DeviceInfo,
}

impl Rescaling {
    /// Whether lengths have the scale they had.
    pub(crate) fn keeps_lengths(&self) -> bool {
        self.before.length == self.scale.length
    }

    /// A force, and a torque, in the scene at the new scale over what the device renders alike at the old one.
    pub(crate) fn factors(&self) -> [f64; 2] {
        let [force, length] = [self.before.force / self.scale.force, self.before.length / self.scale.length];
        [force, force / length]
    }
}

/// What a program asks of a guided device.
#[derive(Clone, Copy, Debug)]
pub struct Guide {
    /// Whether the device leads the hand, and not the pointer.
    pub leads: bool,
    /// Where the middle of the device's workspace is in the scene, m.
    pub centre: Vec3,
    /// Rotation from axes of the device to those of the scene.
    pub rotation: UnitQuaternion<f64>,
    /// Share of the force that the scale allows, 0 to 1.
    pub force_share: f64,
    /// Buttons of the scene (bit i is button i) that are pressed while no button of the device is, while its first is, and while only another is.
    pub buttons: [u32; 3],
}

impl Default for Guide {
    fn default() -> Self {
        Self {
            leads: false,
            centre: Vec3::zeros(),
            rotation: UnitQuaternion::identity(),
            force_share: 1.0,
            buttons: [0; 3],
        }
    }
}

/// Where the hand of a guided device is.
#[derive(Clone, Copy, Debug, Default)]
pub struct GuidedHand {
    /// Position (m) and rotation in the scene; `None` while the device gives no pose.
    pub place: Option<(Vec3, UnitQuaternion<f64>)>,
    /// Place in [`Guide::buttons`] of what is pressed.
    pub pressed: usize,
    /// Buttons of the scene that are pressed: bit i is button i.
    pub buttons: u32,
    /// Force the device was given in the last tick, in its own axes, N.
    pub force: Vec3,
    /// What the device returned when it was lost.
    pub lost: Option<Status>,
}

/// The program's end of a guided device.
pub struct GuideHandle {
    guide: Input<Guide>,
    hand: Output<GuidedHand>,
    /// Scale and limits of the device.
    scale: DeviceScale,
    device: DeviceInfo,
}

impl GuideHandle {
    /// Asks for this; a new place of the workspace is reached within a tenth of a second.
    pub fn set(&mut self, guide: Guide) {
        self.guide.write(guide);
    }

    /// The scale at which the device fits another session, see [`DeviceScale::fit`]. Lengths keep their scale as long as the model takes between half and all of
    /// the workspace, so that the hand does not jump when a model has grown or shrunk a little. The device has the new scale once the session has the device.
    pub fn rescale(&mut self, size: f64, coupling: f64, peak_force: f64) -> Rescaling {
        let (before, device) = (self.scale, self.device);
        let mut scale = DeviceScale::fit(&device, size, coupling, peak_force);
        if LENGTHS_KEPT.contains(&(scale.length / before.length)) {
            scale =
                DeviceScale { length: before.length, force: force_scale(&device, before.length, coupling, peak_force) };
        }
        self.scale = scale;
        Rescaling { before, scale, info: scale.info(&device) }
    }

    /// How lengths and forces are scaled.
    pub fn scale(&self) -> DeviceScale {
        self.scale
    }

    /// Limits of the device itself.
    pub fn device_info(&self) -> DeviceInfo {
        self.device
    }

    /// The hand at the last tick.
    pub fn hand(&mut self) -> GuidedHand {
        *self.hand.read()
    }
}

/// Time constant with which the workspace follows the place that is asked for, s: a view that turns at sixty frames a second must not jerk the hand.
const FOLLOW_TIME: f64 = 0.03;

/// A device that a program guides, and a pointer that has the hand while it does not lead.
pub struct GuidedDevice {
    device: Box<dyn HapticDevice>,
    pointer: PointerDevice,
    scale: DeviceScale,
    info: DeviceInfo,
    /// Middle of the workspace, m, in axes of the device.
    middle: Vec3,
    guide: Output<Guide>,
    hand: Input<GuidedHand>,
    /// What is in force now; follows what is asked for.
    now: Option<Guide>,
    /// Time of the last tick, ns.
    last: u64,
    lost: Option<Status>,
    /// Force of the last tick, in axes of the device, N.
    force: Vec3,
    /// Poses of all effectors of the device.
    poses: Vec<Pose>,
}

impl GuidedDevice {
    /// A device at this scale, a pointer, and the handle that guides both.
    pub fn new(device: Box<dyn HapticDevice>, pointer: PointerDevice, scale: DeviceScale) -> (Self, GuideHandle) {
        let own = device.device_info();
        let (asked, guide) = triple_buffer(&Guide::default());
        let (hand, seen) = triple_buffer(&GuidedHand::default());
        let [x0, y0, z0, x1, y1, z1] = own.workspace;
        let device = Self {
            info: scale.info(&own),
            middle: 0.5 * Vec3::new(x0 + x1, y0 + y1, z0 + z1),
            poses: vec![Pose::default(); (own.effectors as usize).min(MAX_EFFECTORS)],
            device,
            pointer,
            scale,
            guide,
            hand,
            now: None,
            last: 0,
            lost: None,
            force: Vec3::zeros(),
        };
        (device, GuideHandle { guide: asked, hand: seen, scale, device: own })
    }

    /// What is in force at `time` (ns): place, rotation and force follow what is asked for, all else is taken at once.
    fn follow(&mut self, time: u64) -> Guide {
        let asked = *self.guide.read();
        let dt = time.saturating_sub(self.last) as f64 * 1e-9;
        self.last = time;
        let share = (dt / FOLLOW_TIME).min(1.0);
        // A device that begins to lead comes where it is asked to at once.
        let before = self.now.filter(|now| now.leads && asked.leads);
        let now = before.map_or(asked, |now| Guide {
            centre: now.centre.lerp(&asked.centre, share),
            rotation: towards(&now.rotation, &asked.rotation, share),
            force_share: now.force_share + share * (asked.force_share - now.force_share),
            ..asked
        });
        self.now = Some(now);
        now
    }

    /// The pose of the device's first effector in the scene.
    fn pose(&self, guide: &Guide) -> (Pose, GuidedHand) {
        let mut pose = self.poses[0];
        let pressed = match pose.buttons {
            0 => 0,
            mask if mask & 1 != 0 => 1,
            _ => 2,
        };
        let position = self.scale.length * (Vec3::from(pose.position) - self.middle);
        let position = guide.centre + guide.rotation * position;
        let velocity = self.scale.length * (guide.rotation * Vec3::from(pose.velocity));
        let rotation = guide.rotation * UnitQuaternion::new_normalize(pose.orientation.into());
        pose.position = position.into();
        pose.velocity = velocity.into();
        pose.orientation = rotation.coords.into();
        pose.buttons = guide.buttons[pressed];
        let place = (pose.flags & POSE_VALID != 0).then_some((position, rotation));
        (pose, GuidedHand { place, pressed, buttons: pose.buttons, force: self.force, lost: None })
    }
}

/// A share (0 to 1) of the way from one rotation to another, the short way round: q and -q are the same rotation.
fn towards(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>, share: f64) -> UnitQuaternion<f64> {
    let near = if from.coords.dot(&to.coords) < 0.0 { UnitQuaternion::new_unchecked(-to.into_inner()) } else { *to };
    from.nlerp(&near, share)
}

impl HapticDevice for GuidedDevice {
    fn device_info(&self) -> DeviceInfo {
        self.info
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        let guide = self.follow(time);
        // A device that does not lead is read too: it may say that it is lost, and some must be served.
        self.poses.fill(Pose::default());
        if self.lost.is_none() {
            let status = self.device.read(time, &mut self.poses);
            self.lost = (status != Status::OK).then_some(status);
        }
        let (pose, hand) = match self.lost {
            None => self.pose(&guide),
            lost => (Pose::default(), GuidedHand { lost, ..GuidedHand::default() }),
        };
        self.hand.write(hand);
        if !guide.leads {
            return self.pointer.read(time, poses);
        }
        poses.fill(Pose::default());
        poses.iter_mut().take(1).for_each(|first| *first = pose);
        Status::OK
    }

    fn write(&mut self, time: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        let guide = self.now.unwrap_or_default();
        if self.lost.is_none() {
            let valid_until = outputs.first().map_or(time, |output| output.valid_until);
            let mut rendered = [EffectorOutput { valid_until, ..EffectorOutput::default() }; MAX_EFFECTORS];
            if let (true, Some(output)) = (guide.leads, outputs.first()) {
                let (back, force) = (guide.rotation.inverse(), guide.force_share * self.scale.force);
                rendered[0].force = (force * (back * Vec3::from(output.force))).into();
                // A rotation is not scaled, so a torque has the scale of the energy.
                rendered[0].torque = (force / self.scale.length * (back * Vec3::from(output.torque))).into();
            }
            self.force = rendered[0].force.into();
            let status = self.device.write(time, &rendered[..self.poses.len()]);
            self.lost = (status != Status::OK).then_some(status);
        }
        self.pointer.write(time, outputs)
    }

    fn stop_handle(&self) -> StopDevice {
        self.device.stop_handle()
    }

    fn rescale(&mut self, rescaling: &Rescaling) {
        (self.scale, self.info) = (rescaling.scale, rescaling.info);
    }

    fn counters(&self) -> Vec<(String, u64)> {
        self.device.counters()
    }

    fn describe_status(&self, call: &'static str, status: Status) -> String {
        self.device.describe_status(call, status)
    }
}
