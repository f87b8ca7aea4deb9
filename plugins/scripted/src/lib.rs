//! A device without hardware: its pose follows a table of keyframes or a recording, and it renders no force.
//!
//! It declares limits like those of a desktop arm, so that a scene gets the gains it would get with one.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod path;
mod rotation;

use path::{Interpolation, Path, Sample};
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, Pose};
use pliant_plugin_api::{AsDevice, Device, Fault, Info, Param, Params, export_plugins};

/// A device whose poses follow a path or a recording; it renders no force.
pub struct Scripted {
    path: Path,
    /// Rotation vectors, degrees; `None`: the hand does not turn.
    rotation: Option<Path>,
    info: DeviceInfo,
}

const PARAMS: &[Param] = &[
    Param::table(c"path", c"time|x|y|z", c"keyframes: time in s, position in m, device axes"),
    Param::table(c"buttons", c"time|mask", c"pressed buttons from each time on: button i is bit i of the mask"),
    Param::path(c"recording", c"in the place of `path`: a CSV file with rows time,x,y,z or time,x,y,z,mask"),
    Param::choice(
        c"interpolation",
        c"linear|smooth",
        c"linear: constant speed between keyframes; smooth: rest at every keyframe",
    ),
    Param::number(c"peak-force", c"N", 1e-12..=1e15, 3.3, c"peak force it declares"),
    Param::number(c"peak-torque", c"N m", 0.0..=1e3, 0.0, c"peak torque it declares; 0 for a device that renders none"),
    Param::number(c"stiffness", c"N/m", 1e-12..=1e15, 700.0, c"largest stable stiffness it declares"),
    Param::table(
        c"rotation",
        c"time|x|y|z",
        c"keyframes: time in s, rotation vector (axis times angle) in degrees, device axes; the hand does not turn by default",
    ),
];

impl Device for Scripted {
    const INFO: Info = Info {
        id: c"scripted",
        name: c"Scripted hand",
        version: c"0.1.0",
        summary: c"a keyframed or recorded path with buttons",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let interpolation =
            if params.choice("interpolation") == 0 { Interpolation::Linear } else { Interpolation::Smooth };
        let path = match (params.table("path"), params.text("recording")) {
            (Some(keys), None) => Path::from_keys(keys, params.table("buttons"), interpolation)?,
            (None, Some(file)) => Path::from_file(file, interpolation)?,
            (Some(_), Some(_)) => return Err(Fault::bad_argument("`path` and `recording`; allowed is one of them")),
            (None, None) => return Err(Fault::bad_argument("neither `path` nor `recording`; allowed is one of them")),
        };
        let rotation = params.table("rotation").map(|keys| Path::of_rotations(keys, interpolation)).transpose()?;
        let (peak_force, stiffness) = (params.number("peak-force"), params.number("stiffness"));
        let peak_torque = params.number("peak-torque");
        let info = DeviceInfo {
            size: size_of::<DeviceInfo>(),
            effectors: 1,
            buttons: 32,
            driven_axes: if peak_torque > 0.0 { 6 } else { 3 },
            taxel_rows: 0,
            taxel_columns: 0,
            rate: 1000.0,
            peak_force,
            continuous_force: peak_force,
            stiffness,
            damping: 5.0,
            resolution: 0.0,
            workspace: path.bounds(),
            taxel_pitch: 0.0,
            taxel_force: 0.0,
            peak_torque,
        };
        Ok(Self { path, rotation, info })
    }

    fn describe(&self) -> DeviceInfo {
        self.info
    }

    fn read(&self, time_ns: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let Sample { position, buttons } = self.path.sample(time_ns as f64 * 1e-9);
        let turn = self.rotation.as_ref().map(|path| path.sample(time_ns as f64 * 1e-9).position);
        let orientation = turn.map_or(Pose::default().orientation, rotation::quaternion);
        for pose in poses {
            *pose = Pose { time_ns, flags: POSE_VALID, buttons, position, orientation, ..Pose::default() };
        }
        Ok(())
    }

    fn write(&self, _time_ns: u64, _outputs: &[Output]) -> Result<(), Fault> {
        Ok(())
    }

    fn stop(&self) {}
}

export_plugins!(AsDevice<Scripted>);
