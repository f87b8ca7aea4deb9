//! A device without a hand: it goes where a table of keyframes or a recording says, and feels nothing.
//!
//! It declares limits like those of a desktop arm, so that a scene gets the same gains as with a real one.

mod path;

use path::{Interpolation, Path};
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, Pose};
use pliant_plugin_api::{AsDevice, Device, Fault, Info, Param, Params, export_plugins};

/// A path and the limits it pretends to have.
pub struct Scripted {
    path: Path,
    facts: DeviceInfo,
}

const PARAMS: &[Param] = &[
    Param::table(c"path", c"time|x|y|z", c"keyframes: s, then m in device axes"),
    Param::table(c"buttons", c"time|mask", c"from each time on, button i is bit i of the mask"),
    Param::path(c"recording", c"instead of `path`: a CSV file of rows time,x,y,z or time,x,y,z,mask"),
    Param::choice(c"interpolation", c"linear|smooth", c"smooth comes to rest at every keyframe"),
    Param::number(c"peak-force", c"N", (1e-3, 1e4), 3.3, c"largest force it pretends to give"),
    Param::number(c"stiffness", c"N/m", (1e-3, 1e6), 700.0, c"largest stiffness it pretends to render"),
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
        let how = if params.choice("interpolation") == 0 { Interpolation::Linear } else { Interpolation::Smooth };
        let path = match (params.table("path"), params.text("recording")) {
            (Some(keys), None) => Path::from_keys(keys, params.table("buttons"), how)?,
            (None, Some(file)) => Path::from_file(file, how)?,
            (Some(_), Some(_)) => return Err(Fault::bad_argument("`path` and `recording`; allowed is one of them")),
            (None, None) => return Err(Fault::bad_argument("neither `path` nor `recording`; allowed is one of them")),
        };
        let (peak_force, stiffness) = (params.number("peak-force"), params.number("stiffness"));
        let facts = DeviceInfo {
            size: size_of::<DeviceInfo>(),
            effectors: 1,
            buttons: 32,
            driven_axes: 3,
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
        };
        Ok(Self { path, facts })
    }

    fn describe(&self) -> DeviceInfo {
        self.facts
    }

    fn read(&self, time: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let (position, buttons) = self.path.at(time as f64 * 1e-9);
        for pose in poses {
            *pose = Pose { time_ns: time, flags: POSE_VALID, buttons, position, ..Pose::default() };
        }
        Ok(())
    }

    fn write(&self, _time: u64, _outputs: &[Output]) -> Result<(), Fault> {
        Ok(())
    }

    fn stop(&self) {}
}

export_plugins!(AsDevice<Scripted>);
