//! What every device promises.

use super::super::candidate::Candidate;
use super::super::opened_device::{OpenedDevice, output};
use super::border::needs_more;
use super::{Case, Verdict, judge, told};
use crate::abi::POSE_VALID;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "limits-make-sense",
        promise: "rate, forces, stiffness and workspace can be worked with",
        run: limits,
    },
    Case {
        name: "poses-are-sound",
        promise: "a valid pose is finite, turned by a unit quaternion, in the workspace",
        run: poses,
    },
    Case {
        name: "force-stays-in-limits",
        promise: "whatever is asked, it renders no more than its peak force",
        run: force,
    },
    Case { name: "stop-is-at-once", promise: "after a stop it renders nothing, whatever was asked before", run: stop },
    Case { name: "stale-force-expires", promise: "a force ends by itself when its time has passed", run: stale },
    Case {
        name: "unplugged-is-silent",
        promise: "a device opened anew renders nothing of what was before",
        run: unplug,
    },
];

/// ns
const MS: u64 = 1_000_000;

/// The device, or why it cannot be looked at here.
fn open(c: &Candidate) -> Result<Result<OpenedDevice, Verdict>, String> {
    match c.open(&[]) {
        Ok(opened) => OpenedDevice::new(opened).map(Ok).map_err(told),
        Err(fault) if needs_more(c) => Ok(Err(Verdict::Skipped(told(fault)))),
        Err(fault) => Err(told(fault)),
    }
}

macro_rules! device {
    ($c:ident) => {
        match open($c)? {
            Ok(device) => device,
            Err(skipped) => return Ok(skipped),
        }
    };
}

/// N, what it renders, or out of here.
macro_rules! renders {
    ($device:ident, $time:expr) => {
        match $device.renders($time).map_err(told)? {
            Some(force) => force,
            None => return Ok(Verdict::Skipped("it does not offer `pliant.rendered/1`".into())),
        }
    };
}

fn limits(c: &Candidate) -> Result<Verdict, String> {
    let f = device!(c).facts;
    for (what, value) in [
        ("rate", f.rate),
        ("peak force", f.peak_force),
        ("continuous force", f.continuous_force),
        ("stiffness", f.stiffness),
    ] {
        judge(value.is_finite() && value > 0.0, || format!("its {what} is {value}; allowed is above 0"))?;
    }
    judge(f.continuous_force <= f.peak_force, || "its continuous force is above its peak".into())?;
    judge(f.damping >= 0.0 && f.resolution >= 0.0, || "its damping or resolution is below 0".into())?;
    let w = f.workspace;
    judge((0..3).all(|i| w[i] <= w[i + 3]), || format!("its workspace ends before it begins: {w:?}"))?;
    Ok(Verdict::Passed)
}

fn poses(c: &Candidate) -> Result<Verdict, String> {
    let device = device!(c);
    let w = device.facts.workspace;
    let bounded = (0..3).any(|i| w[i] < w[i + 3]);
    for tick in 0..200 {
        for pose in device.read(tick * MS).map_err(told)?.iter().filter(|p| p.flags & POSE_VALID != 0) {
            let p = pose.position;
            judge(p.iter().all(|c| c.is_finite()), || format!("position {p:?} at tick {tick}"))?;
            let size: f64 = pose.orientation.iter().map(|q| q * q).sum();
            judge((size - 1.0).abs() < 1e-6, || format!("orientation {:?} at tick {tick}", pose.orientation))?;
            let inside = (0..3).all(|i| (w[i] - 1e-9..=w[i + 3] + 1e-9).contains(&p[i]));
            judge(!bounded || inside, || format!("position {p:?} m outside of the workspace {w:?}"))?;
        }
    }
    Ok(Verdict::Passed)
}

fn force(c: &Candidate) -> Result<Verdict, String> {
    let device = device!(c);
    let peak = device.facts.peak_force;
    for (tick, asked) in [0.5 * peak, 10.0 * peak, -1e9, f64::INFINITY, f64::NAN].into_iter().enumerate() {
        let now = (tick as u64 + 1) * MS;
        // It may refuse, as long as it does not render it.
        let _ = device.write(now, output([asked, asked, 0.0], now + 50 * MS));
        let found = renders!(device, now);
        judge(found <= peak * (1.0 + 1e-9), || format!("asked for {asked} N it renders {found} N of {peak} N"))?;
    }
    Ok(Verdict::Passed)
}

/// Writes a force it can render, and sees that it does.
fn press(device: &OpenedDevice, now: u64) -> Result<Option<Verdict>, String> {
    let force = 0.3 * device.facts.continuous_force;
    device.write(now, output([force, 0.0, 0.0], now + 50 * MS)).map_err(told)?;
    match device.renders(now).map_err(told)? {
        None => Ok(Some(Verdict::Skipped("it does not offer `pliant.rendered/1`".into()))),
        Some(found) => judge(found > 0.0, || format!("asked for {force} N it renders nothing")).map(|()| None),
    }
}

fn stop(c: &Candidate) -> Result<Verdict, String> {
    let device = device!(c);
    device.stop().map_err(|fault| format!("before anything else: {}", told(fault)))?;
    if let Some(skipped) = press(&device, MS)? {
        return Ok(skipped);
    }
    device.stop().map_err(told)?;
    let found = renders!(device, 2 * MS);
    judge(found == 0.0, || format!("{found} N after a stop"))?;
    Ok(Verdict::Passed)
}

fn stale(c: &Candidate) -> Result<Verdict, String> {
    let device = device!(c);
    if let Some(skipped) = press(&device, MS)? {
        return Ok(skipped);
    }
    let found = renders!(device, 500 * MS);
    judge(found == 0.0, || format!("{found} N, 0.45 s after its time"))?;
    Ok(Verdict::Passed)
}

fn unplug(c: &Candidate) -> Result<Verdict, String> {
    let device = device!(c);
    if let Some(skipped) = press(&device, MS)? {
        return Ok(skipped);
    }
    drop(device);
    let device = device!(c);
    let found = renders!(device, 2 * MS);
    judge(found == 0.0, || format!("{found} N of the instance before"))?;
    Ok(Verdict::Passed)
}
