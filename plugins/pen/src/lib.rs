//! A pen on a tablet as a hand: position, pressure, tilt and buttons, read from evdev on Linux.
//!
//! The tablet is a plane of the hand's space: x to the right, y up, z out of it. The hand hovers while the pen is near and goes down through the
//! plane with the pressure of the tip; its z axis is the barrel of the pen. A file of events, as `cat /dev/input/eventN` gives it, plays in the place of
//! a device.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod axes;
mod event;
mod find;
mod source;
mod state;

use axes::{Axes, Axis};
use core::ffi::CStr;
use pliant_plugin_api::abi::{DeviceInfo, Output, Pose};
use pliant_plugin_api::{AsDevice, Device, Fault, Finding, Info, Param, Params, export_plugins};
use source::{RIGHTS_REMEDY, Source, cannot_open, find_file, open_without_waiting};
use state::{Mapping, PenState};
use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

const PARAMS: &[Param] = &[
    Param::path(
        c"device",
        c"the pen's device, as /dev/input/event5, or a recording of its events; default: the first pen there is",
    ),
    Param::number(
        c"width",
        c"m",
        0.0..=100.0,
        0.0,
        c"width of the tablet in the space of the hand; 0: its own, or 0.2 m where it is unknown",
    ),
    Param::number(c"depth", c"m", 1e-6..=1.0, 0.01, c"depth of the hand below the tablet at full pressure"),
    Param::number(c"hover", c"m", 0.0..=1.0, 0.005, c"height of the hand above the tablet without pressure"),
    Param::number(c"x-max", c"1", 0.0..=1e9, 0.0, c"of a recording or pipe: greatest value of the axis to the right"),
    Param::number(
        c"y-max",
        c"1",
        0.0..=1e9,
        0.0,
        c"of a recording or pipe: greatest value of the axis towards the user",
    ),
    Param::number(c"pressure-max", c"1", 0.0..=1e9, 0.0, c"of a recording or pipe: greatest pressure"),
    Param::number(c"peak-force", c"N", 1e-3..=1e4, 3.3, c"peak force it declares; it renders none"),
    Param::number(c"stiffness", c"N/m", 1e-3..=1e6, 700.0, c"largest stable stiffness it declares"),
];

/// Width where the device does not say it, m.
const WIDTH: f64 = 0.2;

/// A hand that is moved by a pen on a tablet, or by a recording of its events.
pub struct Pen {
    mapping: Mapping,
    info: DeviceInfo,
    reader: Mutex<Reader>,
}

/// What reading changes.
struct Reader {
    source: Source,
    state: PenState,
    /// Time of the first reading, ns.
    began_ns: Option<u64>,
    /// Readings without a pen near the tablet.
    away: u64,
}

impl Pen {
    /// The lock is free in a servo loop: only `read` and `counter` take it, for a moment.
    fn reader(&self) -> MutexGuard<'_, Reader> {
        self.reader.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The axes that parameters give to a source that does not say them.
fn given_axes(params: &Params<'_>, path: &Path) -> Result<Axes, Fault> {
    let [x, y, pressure] = ["x-max", "y-max", "pressure-max"].map(|key| Axis::up_to(params.number(key)));
    if x.is_present() && y.is_present() && pressure.is_present() {
        return Ok(Axes { x, y, pressure, ..Axes::default() });
    }
    Err(Fault::bad_argument(format!(
        "{}: a recording or pipe does not say how far its axes go; give `x-max`, `y-max` and `pressure-max` above 0, as `evtest` shows them",
        path.display()
    )))
}

/// Where the tablet is in the space of the hand.
fn mapping(params: &Params<'_>, axes: Axes, path: &Path) -> Result<Mapping, Fault> {
    let lacks =
        |what: &str| Fault::io(format!("{}: a device without {what}; allowed is a pen on a tablet", path.display()));
    if !axes.x.is_present() || !axes.y.is_present() {
        return Err(lacks("a position"));
    }
    if !axes.pressure.is_present() {
        return Err(lacks("a pressure"));
    }
    let own = axes.x.length().zip(axes.y.length());
    let [own_width, own_height] = own.map_or([WIDTH, WIDTH * axes.y.span() / axes.x.span()], |(w, h)| [w, h]);
    let width = Some(params.number("width")).filter(|width| *width > 0.0).unwrap_or(own_width);
    let size = [width, own_height * width / own_width];
    Ok(Mapping { axes, size, depth: params.number("depth"), hover: params.number("hover") })
}

impl Device for Pen {
    const INFO: Info = Info {
        id: c"pen",
        name: c"Pen",
        version: c"0.1.0",
        summary: c"a pen on a tablet: position, pressure, tilt and buttons",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let path = find_file(params.text("device"))?;
        let (source, axes) = Source::open(&path)?;
        let state = axes.as_ref().map_or_else(PenState::default, PenState::opened);
        let axes = axes.map_or_else(|| given_axes(params, &path), Ok)?;
        let mapping = mapping(params, axes, &path)?;
        let (peak, [width, height]) = (params.number("peak-force"), mapping.size);
        let info = DeviceInfo {
            size: size_of::<DeviceInfo>(),
            effectors: 1,
            buttons: 4,
            driven_axes: 0,
            taxel_rows: 0,
            taxel_columns: 0,
            rate: 1000.0,
            peak_force: peak,
            continuous_force: peak,
            stiffness: params.number("stiffness"),
            damping: 5.0,
            resolution: width / mapping.axes.x.span(),
            workspace: [-0.5 * width, -0.5 * height, -mapping.depth, 0.5 * width, 0.5 * height, 2.0 * mapping.hover],
            taxel_pitch: 0.0,
            taxel_force: 0.0,
            peak_torque: 0.0,
        };
        let reader = Reader { source, state, began_ns: None, away: 0 };
        Ok(Self { mapping, info, reader: Mutex::new(reader) })
    }

    fn describe(&self) -> DeviceInfo {
        self.info
    }

    fn read(&self, time_ns: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let mut reader = self.reader();
        let Reader { source, state, began_ns, away } = &mut *reader;
        let since = time_ns.saturating_sub(*began_ns.get_or_insert(time_ns));
        source.advance(state, since)?;
        let pose = Pose { time_ns, ..state.pose(&self.mapping) };
        *away += u64::from(pose.flags == 0);
        poses.fill(pose);
        Ok(())
    }

    /// A pen renders no force.
    fn write(&self, _time_ns: u64, _outputs: &[Output]) -> Result<(), Fault> {
        Ok(())
    }

    fn stop(&self) {}

    fn rendered(&self, _time_ns: u64, outputs: &mut [Output]) -> Result<(), Fault> {
        outputs.iter_mut().for_each(|output| output.force = [0.0; 3]);
        Ok(())
    }

    fn counter(&self, index: u32) -> Option<(&'static CStr, u64)> {
        let reader = self.reader();
        let all = [(c"frames dropped", reader.state.dropped), (c"reads without a pen near", reader.away)];
        all.get(index as usize).copied()
    }

    fn probe(params: &Params<'_>) -> Vec<Finding> {
        let path = match find_file(params.text("device")) {
            Ok(path) => path,
            Err(fault) => {
                let remedy = "connect a tablet with a pen, or give the file of one as `device`";
                return vec![Finding::missing("pen", fault.reason, remedy)];
            }
        };
        let pens = find::pens(Path::new(find::CLASS), Path::new(find::FILES));
        let name = pens.into_iter().find(|pen| pen.path == path).map(|pen| format!(" ({})", pen.name));
        let found = Finding::present("pen", format!("{}{}", path.display(), name.unwrap_or_default()));
        let rights = match if path.is_file() { File::open(&path) } else { open_without_waiting(&path) } {
            Ok(_) => Finding::present("rights", "its events may be read"),
            Err(error) if error.kind() == ErrorKind::PermissionDenied => {
                Finding::missing("rights", cannot_open(&path, &error).reason, RIGHTS_REMEDY)
            }
            Err(error) => {
                Finding::missing("file", format!("{}: {error}", path.display()), "give the file of a pen as `device`")
            }
        };
        vec![found, rights]
    }
}

export_plugins!(AsDevice<Pen>);
