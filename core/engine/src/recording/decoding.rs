//! Decoding of poses, devices, timeouts and commands from little-endian bytes. `pliant_record` encodes them.

use super::format::{PEAK_TORQUE_VERSION, command_code};
use crate::edit::Falloff;
use crate::session::{SessionCommand, Stage, StepTimeout};
use pliant_host::{DeviceInfo, Pose};
use pliant_solver::Vec3;

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

    /// A pose, in the order of its fields.
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

    /// Name and description of a device in a file of this version, the name last.
    pub(super) fn device(&mut self, version: u32) -> Option<(String, DeviceInfo)> {
        let mut counts = [0; 5];
        for count in &mut counts {
            *count = self.u32()?;
        }
        let [effectors, buttons, driven_axes, taxel_rows, taxel_columns] = counts;
        let [rate, peak_force, continuous_force, stiffness, damping, resolution, taxel_pitch, taxel_force] =
            self.numbers()?;
        let workspace = self.numbers()?;
        let [peak_torque] = if version >= PEAK_TORQUE_VERSION { self.numbers()? } else { [0.0] };
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
            workspace,
            taxel_pitch,
            taxel_force,
            peak_torque,
        };
        Some((self.text()?, info))
    }

    /// A command, its kind first and a name last; `None` for an unknown kind or invalid numbers.
    pub(super) fn command(&mut self) -> Option<SessionCommand> {
        match self.byte()? {
            command_code::UNDO => Some(SessionCommand::Undo),
            command_code::REDO => Some(SessionCommand::Redo),
            command_code::RESIZE_TOOLS => {
                let [radius, coupling] = self.numbers()?;
                let is_valid = [radius, coupling].iter().all(|n| n.is_finite() && *n > 0.0);
                is_valid.then_some(SessionCommand::ResizeTools { radius, coupling })
            }
            command_code::SET_STIFFNESS => {
                let [factor] = self.numbers()?;
                (0.001..=1000.0).contains(&factor).then_some(SessionCommand::SetStiffness { factor })
            }
            command_code::ADD_LAYER => Some(SessionCommand::AddLayer { name: self.text()? }),
            command_code::RENAME_LAYER => Some(SessionCommand::RenameLayer { layer: self.u32()?, name: self.text()? }),
            command_code::RECORD_LAYER => {
                let layer = match self.byte()? {
                    0 => None,
                    1 => Some(self.u32()?),
                    _ => return None,
                };
                Some(SessionCommand::RecordLayer { layer })
            }
            command_code::SET_LAYER_STRENGTH => {
                let layer = self.u32()?;
                let [strength] = self.numbers()?;
                (0.0..=1.0).contains(&strength).then_some(SessionCommand::SetLayerStrength { layer, strength })
            }
            command_code::MERGE_LAYER => Some(SessionCommand::MergeLayer { layer: self.u32()? }),
            command_code::DELETE_LAYER => Some(SessionCommand::DeleteLayer { layer: self.u32()? }),
            command_code::SPLIT_BODY => {
                let (body, has_triangle, triangle) = (self.u32()?, self.byte()?, self.u32()?);
                (has_triangle <= 1)
                    .then_some(SessionCommand::SplitBody { body, triangle: (has_triangle == 1).then_some(triangle) })
            }
            command_code::SET_BRUSH => {
                let falloff = *Falloff::ALL.get(usize::from(self.byte()?))?;
                let [strength] = self.numbers()?;
                (strength.is_finite() && strength > 0.0).then_some(SessionCommand::SetBrush { strength, falloff })
            }
            command_code::SET_SYMMETRY => {
                let bits = self.byte()?;
                let centre = Vec3::from(self.numbers()?);
                let axes = std::array::from_fn(|i| bits >> i & 1 == 1);
                (bits < 8 && centre.iter().all(|c| c.is_finite()))
                    .then_some(SessionCommand::SetSymmetry { axes, centre })
            }
            _ => None,
        }
    }

    /// A timeout, its reason last.
    pub(super) fn timeout(&mut self) -> Option<StepTimeout> {
        let (step, body) = (self.u64()?, self.u32()?);
        let stage = match self.byte()? {
            0 => Stage::Region,
            1 => Stage::Step,
            2 => Stage::Interrupted,
            _ => return None,
        };
        Some(StepTimeout { step, body, stage, why: self.text()? })
    }
}
