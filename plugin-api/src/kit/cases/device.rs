//! Cases for every device.

use super::super::candidate::Candidate;
use super::super::device::{TestDevice, output};
use super::common::needs_more_than_numbers;
use super::{Case, CaseResult, NotPassed, describe_fault, ensure, skipped, tested};
use crate::abi::{DeviceInfo, POSE_VALID};
use std::time::Duration;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "limits-are-valid",
        promise: "rate, forces and stiffness are positive, the workspace is not reversed, and the shorter struct of an older host is not overrun",
        run: limits_are_valid,
    },
    Case {
        name: "poses-are-valid",
        promise: "a valid pose is finite, has a unit quaternion, and lies in the workspace",
        run: poses_are_valid,
    },
    Case {
        name: "force-stays-within-limits",
        promise: "whatever force is asked for, the device renders no more than its peak force",
        run: force_stays_within_limits,
    },
    Case {
        name: "stop-is-immediate",
        promise: "after a stop the device renders no force, whatever was asked for before",
        run: stop_is_immediate,
    },
    Case {
        name: "stale-force-expires",
        promise: "a force ends by itself when its time has passed",
        run: stale_force_expires,
    },
    Case {
        name: "reopened-device-is-silent",
        promise: "a device that is opened again renders nothing of what was asked for before",
        run: reopened_device_is_silent,
    },
    Case {
        name: "arrays-are-kept-to",
        promise: "calls write a pose for each effector and nothing around them, and leave the outputs that they read as they are",
        run: arrays_are_kept_to,
    },
];

/// A millisecond, ns.
const MS: u64 = 1_000_000;

/// Runs a test on a device opened with its defaults; skips it where the defaults are not enough.
fn with_device(c: &Candidate, test: impl FnOnce(TestDevice) -> CaseResult) -> CaseResult {
    match c.open(&[]) {
        Ok(instance) => test(TestDevice::new(instance).map_err(describe_fault)?),
        Err(fault) if needs_more_than_numbers(c) => Err(skipped(describe_fault(fault))),
        Err(fault) => Err(describe_fault(fault).into()),
    }
}

fn arrays_are_kept_to(c: &Candidate) -> CaseResult {
    with_device(c, |device| {
        for now in [0, MS, 20 * MS] {
            device.read(now).map_err(describe_fault)?;
            device.write(now, output([0.1, 0.2, -0.3], now + 5 * MS)).map_err(describe_fault)?;
            device.rendered_force(now).map_err(describe_fault)?;
        }
        device.guards.first_write().map_or(Ok(()), |write| Err(write.into()))
    })
}

/// The force a device renders at `now`, N; skips a device without `pliant.rendered/1`.
fn rendered_force(device: &TestDevice, now: u64) -> Result<f64, NotPassed> {
    let force = device.rendered_force(now).map_err(describe_fault)?;
    force.ok_or_else(|| skipped("it does not offer `pliant.rendered/1`"))
}

fn limits_are_valid(c: &Candidate) -> CaseResult {
    with_device(c, |device| {
        let info = device.info;
        for (name, value) in [
            ("rate", info.rate),
            ("peak force", info.peak_force),
            ("continuous force", info.continuous_force),
            ("stiffness", info.stiffness),
        ] {
            ensure(value.is_finite() && value > 0.0, || format!("its {name} is {value}; allowed is above 0"))?;
        }
        ensure(info.continuous_force <= info.peak_force, || "its continuous force is above its peak force".into())?;
        ensure(info.damping >= 0.0 && info.resolution >= 0.0, || "its damping or resolution is negative".into())?;
        let w = info.workspace;
        ensure((0..3).all(|i| w[i] <= w[i + 3]), || format!("its workspace ends before it begins: {w:?} m"))?;
        let (past_end, size) = device.describe_for_1_0().map_err(describe_fault)?;
        let host = core::mem::offset_of!(DeviceInfo, peak_torque);
        ensure(past_end == 0 && size <= host, || {
            format!(
                "for a host of 1.0, whose `pliant_device_info` has {host} bytes, `describe` sets its size to {size} and writes \
                 {past_end} bytes past its end; allowed is at most the `size` that the host has set"
            )
        })?;
        Ok(())
    })
}

/// Reads of the poses of a device, one right after the other.
const READS: u64 = 200;
/// Further reads, a millisecond apart, while it has had no valid pose.
const LATE_READS: u64 = 1000;

fn poses_are_valid(c: &Candidate) -> CaseResult {
    with_device(c, |device| {
        let w = device.info.workspace;
        let mut valid = 0;
        let is_bounded = (0..3).any(|i| w[i] < w[i + 3]);
        for tick in 0..READS + LATE_READS {
            if tick >= READS {
                // A device with a thread of its own may not have had a pose yet.
                if valid > 0 {
                    break;
                }
                std::thread::sleep(Duration::from_millis(1));
            }
            let poses = device.read(tick * MS).map_err(describe_fault)?;
            for pose in poses.iter().filter(|p| p.flags & POSE_VALID != 0) {
                valid += 1;
                let p = pose.position;
                ensure(p.iter().all(|c| c.is_finite()), || format!("position {p:?} m at tick {tick}"))?;
                let norm: f64 = pose.orientation.iter().map(|q| q * q).sum();
                ensure((norm - 1.0).abs() < 1e-6, || format!("orientation {:?} at tick {tick}", pose.orientation))?;
                let inside = (0..3).all(|i| (w[i] - 1e-9..=w[i + 3] + 1e-9).contains(&p[i]));
                ensure(!is_bounded || inside, || format!("position {p:?} m outside the workspace {w:?} m"))?;
            }
        }
        tested(valid, "none of its poses is marked as valid")
    })
}

fn force_stays_within_limits(c: &Candidate) -> CaseResult {
    with_device(c, |device| {
        let peak = device.info.peak_force;
        for (tick, asked) in [0.5 * peak, 10.0 * peak, -1e9, f64::INFINITY, f64::NAN].into_iter().enumerate() {
            let now = (tick as u64 + 1) * MS;
            // The device may refuse the output; what counts is what it renders.
            let _ = device.write(now, output([asked, asked, 0.0], now + 50 * MS));
            let force = rendered_force(&device, now)?;
            ensure(force <= peak * (1.0 + 1e-9), || {
                format!("asked for {asked} N, it renders {force} N; its peak force is {peak} N")
            })?;
        }
        Ok(())
    })
}

/// Writes a force within the limits, valid for 50 ms, and requires that the device renders one.
fn press(device: &TestDevice, now: u64) -> CaseResult {
    let asked = 0.3 * device.info.continuous_force;
    device.write(now, output([asked, 0.0, 0.0], now + 50 * MS)).map_err(describe_fault)?;
    let force = rendered_force(device, now)?;
    ensure(force > 0.0, || format!("asked for {asked} N, it renders nothing"))?;
    Ok(())
}

/// Requires that the device renders no force at `now`.
fn ensure_silent(device: &TestDevice, now: u64, when: &str) -> CaseResult {
    let force = rendered_force(device, now)?;
    ensure(force == 0.0, || format!("it renders {force} N {when}"))?;
    Ok(())
}

fn stop_is_immediate(c: &Candidate) -> CaseResult {
    with_device(c, |device| {
        device.stop().map_err(|fault| format!("`stop` before any output: {}", describe_fault(fault)))?;
        press(&device, MS)?;
        device.stop().map_err(describe_fault)?;
        ensure_silent(&device, 2 * MS, "after a stop")
    })
}

fn stale_force_expires(c: &Candidate) -> CaseResult {
    with_device(c, |device| {
        press(&device, MS)?;
        ensure_silent(&device, 500 * MS, "0.45 s after its force has expired")
    })
}

fn reopened_device_is_silent(c: &Candidate) -> CaseResult {
    with_device(c, |device| {
        press(&device, MS)?;
        drop(device);
        with_device(c, |device| ensure_silent(&device, 2 * MS, "that the previous instance was asked for"))
    })
}
