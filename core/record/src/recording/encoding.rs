//! Encoding of poses, devices, lapses and commands as little-endian bytes, and decoding.

use pliant_engine::session::{Lapse, SessionCommand, Stage};
use pliant_host::{DeviceInfo, Pose};
use pliant_solver::Vec3;

/// Appends numbers, 8 bytes each.
pub(super) fn put_numbers(out: &mut Vec<u8>, numbers: &[f64]) {
    numbers.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes()));
}

/// Appends a pose: time, flags, buttons, position, orientation, velocity.
pub(super) fn put_pose(out: &mut Vec<u8>, pose: &Pose) {
    out.extend_from_slice(&pose.time_ns.to_le_bytes());
    out.extend_from_slice(&pose.flags.to_le_bytes());
    out.extend_from_slice(&pose.buttons.to_le_bytes());
    put_numbers(out, &pose.position);
    put_numbers(out, &pose.orientation);
    put_numbers(out, &pose.velocity);
}

/// Appends a device: its counts, limits and workspace, then its name up to the end of the block.
pub(super) fn put_device(out: &mut Vec<u8>, name: &str, info: &DeviceInfo) {
    let counts = [info.effectors, info.buttons, info.driven_axes, info.taxel_rows, info.taxel_columns];
    counts.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes()));
    put_numbers(out, &limits(info));
    put_numbers(out, &info.workspace);
    out.extend_from_slice(name.as_bytes());
}

/// The limits of a device except the workspace, in the order of the file.
fn limits(f: &DeviceInfo) -> [f64; 8] {
    [f.rate, f.peak_force, f.continuous_force, f.stiffness, f.damping, f.resolution, f.taxel_pitch, f.taxel_force]
}

/// Appends a lapse: step, body and stage, then its reason up to the end of the block.
pub(super) fn put_lapse(out: &mut Vec<u8>, lapse: &Lapse) {
    out.extend_from_slice(&lapse.step.to_le_bytes());
    out.extend_from_slice(&lapse.body.to_le_bytes());
    out.push(match lapse.stage {
        Stage::Region => 0,
        Stage::Step => 1,
        Stage::Interrupted => 2,
    });
    out.extend_from_slice(lapse.why.as_bytes());
}

/// Appends a command: its kind, then its numbers.
pub(super) fn put_command(out: &mut Vec<u8>, command: SessionCommand) {
    match command {
        SessionCommand::Undo => out.push(0),
        SessionCommand::Redo => out.push(1),
        SessionCommand::ResizeTools { radius, coupling } => {
            out.push(2);
            put_numbers(out, &[radius, coupling]);
        }
    }
}

/// Unread bytes, from whose front values are read. Each read returns `None` if there are too few bytes.
pub(super) struct ByteReader<'a>(pub(super) &'a [u8]);

impl<'a> ByteReader<'a> {
    /// The next `count` bytes.
    pub(super) fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    /// The next `N` bytes.
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    /// The next byte.
    fn byte(&mut self) -> Option<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    /// The next 32-bit integer.
    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// The next 64-bit integer.
    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// The next `N` numbers.
    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.array()?);
        }
        Some(numbers)
    }

    /// The next vector.
    pub(super) fn vector(&mut self) -> Option<Vec3> {
        self.numbers().map(Vec3::from)
    }

    /// The rest as text; `None` if it is not UTF-8.
    fn text(&mut self) -> Option<String> {
        String::from_utf8(std::mem::take(&mut self.0).to_vec()).ok()
    }

    /// A pose, as written by [`put_pose`].
    pub(super) fn pose(&mut self) -> Option<Pose> {
        Some(Pose {
            time_ns: self.u64()?,
            flags: self.u32()?,
            buttons: self.u32()?,
            position: self.numbers()?,
            orientation: self.numbers()?,
            velocity: self.numbers()?,
            ..Pose::default()
        })
    }

    /// Name and description of a device, as written by [`put_device`].
    pub(super) fn device(&mut self) -> Option<(String, DeviceInfo)> {
        let mut counts = [0; 5];
        for count in &mut counts {
            *count = self.u32()?;
        }
        let [effectors, buttons, driven_axes, taxel_rows, taxel_columns] = counts;
        let [rate, peak_force, continuous_force, stiffness, damping, resolution, taxel_pitch, taxel_force] =
            self.numbers()?;
        let info = DeviceInfo {
            size: size_of::<DeviceInfo>(),
            effectors,
            buttons,
            driven_axes,
            taxel_rows,
            taxel_columns,
            rate,
            peak_force,
            continuous_force,
            stiffness,
            damping,
            resolution,
            workspace: self.numbers()?,
            taxel_pitch,
            taxel_force,
        };
        Some((self.text()?, info))
    }

    /// A command, as written by [`put_command`]; `None` for an unknown kind or invalid numbers.
    pub(super) fn command(&mut self) -> Option<SessionCommand> {
        match self.byte()? {
            0 => Some(SessionCommand::Undo),
            1 => Some(SessionCommand::Redo),
            2 => {
                let [radius, coupling] = self.numbers()?;
                let is_valid = [radius, coupling].iter().all(|n| n.is_finite() && *n > 0.0);
                is_valid.then_some(SessionCommand::ResizeTools { radius, coupling })
            }
            _ => None,
        }
    }

    /// A lapse, as written by [`put_lapse`].
    pub(super) fn lapse(&mut self) -> Option<Lapse> {
        let (step, body) = (self.u64()?, self.u32()?);
        let stage = match self.byte()? {
            0 => Stage::Region,
            1 => Stage::Step,
            2 => Stage::Interrupted,
            _ => return None,
        };
        Some(Lapse { step, body, stage, why: self.text()? })
    }
}
