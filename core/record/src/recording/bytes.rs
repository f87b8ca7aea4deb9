//! Poses, limits and lapses as bytes.

use pliant_engine::session::{Lapse, Stage};
use pliant_host::{DeviceInfo, Pose};
use pliant_solver::V3;

pub(super) fn put_numbers(out: &mut Vec<u8>, numbers: &[f64]) {
    numbers.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes()));
}

pub(super) fn put_pose(out: &mut Vec<u8>, pose: &Pose) {
    out.extend_from_slice(&pose.time_ns.to_le_bytes());
    out.extend_from_slice(&pose.flags.to_le_bytes());
    out.extend_from_slice(&pose.buttons.to_le_bytes());
    put_numbers(out, &pose.position);
    put_numbers(out, &pose.orientation);
    put_numbers(out, &pose.velocity);
}

pub(super) fn put_device(out: &mut Vec<u8>, name: &str, facts: &DeviceInfo) {
    let counts = [facts.effectors, facts.buttons, facts.driven_axes, facts.taxel_rows, facts.taxel_columns];
    counts.iter().for_each(|n| out.extend_from_slice(&n.to_le_bytes()));
    put_numbers(out, &limits_of(facts));
    put_numbers(out, &facts.workspace);
    out.extend_from_slice(name.as_bytes());
}

fn limits_of(f: &DeviceInfo) -> [f64; 8] {
    [f.rate, f.peak_force, f.continuous_force, f.stiffness, f.damping, f.resolution, f.taxel_pitch, f.taxel_force]
}

pub(super) fn put_lapse(out: &mut Vec<u8>, lapse: &Lapse) {
    out.extend_from_slice(&lapse.step.to_le_bytes());
    out.extend_from_slice(&lapse.body.to_le_bytes());
    out.push(u8::from(lapse.stage == Stage::Step));
    out.extend_from_slice(lapse.why.as_bytes());
}

/// Takes things off the front of bytes; `None` where they end too soon.
pub(super) struct Taker<'a>(pub(super) &'a [u8]);

impl<'a> Taker<'a> {
    pub(super) fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    pub(super) fn byte(&mut self) -> Option<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.array()?);
        }
        Some(numbers)
    }

    pub(super) fn vector(&mut self) -> Option<V3> {
        self.numbers()
    }

    pub(super) fn text(&mut self) -> Option<String> {
        String::from_utf8(std::mem::take(&mut self.0).to_vec()).ok()
    }

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

    pub(super) fn device(&mut self) -> Option<(String, DeviceInfo)> {
        let mut counts = [0; 5];
        for count in &mut counts {
            *count = self.u32()?;
        }
        let [effectors, buttons, driven_axes, taxel_rows, taxel_columns] = counts;
        let [rate, peak_force, continuous_force, stiffness, damping, resolution, taxel_pitch, taxel_force] =
            self.numbers()?;
        let facts = DeviceInfo {
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
        Some((self.text()?, facts))
    }

    pub(super) fn lapse(&mut self) -> Option<Lapse> {
        let (step, body) = (self.u64()?, self.u32()?);
        let stage = if self.byte()? == 0 { Stage::Region } else { Stage::Step };
        Some(Lapse { step, body, stage, why: self.text()? })
    }
}
