//! Events of a tool's hand: dropped samples, limited speed, limited force. Every step is counted; an episode is described once, at its beginning.

use super::event::{EventKind, Events};
use super::{DeviceSlot, ToolSlot};
use crate::tool::{Cause, ForceLimits};
use pliant_solver::Vec3;

/// Events of a hand that were ongoing in the last step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ongoing {
    dropped: bool,
    slowed: bool,
    pulled: bool,
    /// Whether force safety acted, by cause, in the order of [`Cause::ALL`].
    limited: [bool; Cause::ALL.len()],
    /// Whether the torque was limited.
    pub(super) torque_limited: bool,
}

/// Counters of a hand before a sample.
#[derive(Clone, Copy)]
pub(super) struct SampleCounts {
    dropped: u64,
    slowed: u64,
}

impl SampleCounts {
    /// The present counters.
    pub(super) fn of(slot: &ToolSlot) -> Self {
        Self { dropped: slot.hand.dropped, slowed: slot.hand.slowed }
    }
}

/// A force before and after force safety, in device axes.
#[derive(Clone, Copy)]
pub(super) struct SafetyPass {
    /// Number of changes by each cause before the force was passed.
    pub(super) counts: [u64; Cause::ALL.len()],
    /// The previously applied force, N.
    pub(super) last: Vec3,
    /// The requested force, N.
    pub(super) wanted: Vec3,
    /// The applied force, N.
    pub(super) given: Vec3,
}

/// Adds the events of a hand's latest sample at `time` (s).
pub(super) fn add_sample_events(
    events: &mut Events,
    slot: &mut ToolSlot,
    device: &DeviceSlot,
    before: SampleCounts,
    time: f64,
) {
    let (name, hand) = (&slot.tool.name, &slot.hand);
    let dropped = hand.dropped - before.dropped;
    let text = || match hand.was_seen() {
        false => format!("hand of tool `{name}`: nothing heard yet from {}", device.origin),
        true => format!(
            "hand of tool `{name}`: a sample of {} is not valid or not finite; the last good one stands for 50 ms, then the \
             hand is let go",
            device.origin
        ),
    };
    events.add_episode(EventKind::SampleDropped, dropped, &mut slot.ongoing.dropped, time, text);
    let slowed = hand.slowed - before.slowed;
    let text =
        || format!("hand of tool `{name}`: it moves faster than the {} m/s it is followed at (`speed`)", hand.fastest);
    events.add_episode(EventKind::SpeedLimit, slowed, &mut slot.ongoing.slowed, time, text);
}

/// Adds the event of a tool that grips a body and needs more force at `time` (s) than its coupling allows.
pub(super) fn add_limit_event(events: &mut Events, slot: &mut ToolSlot, device: &str, time: f64) {
    let wanted = slot.tool.force_over_limit.filter(|_| slot.tool.is_gripping());
    let (name, most) = (&slot.tool.name, slot.tool.coupling.max_force);
    let text = || {
        format!(
            "tool `{name}`: the hand pulls with {:.3} N and device `{device}` gives {most} N at most (its peak force): the body \
             follows less than the hand; more is given by a device with a larger `peak-force`",
            wanted.unwrap_or(0.0)
        )
    };
    events.add_episode(EventKind::ForceLimit, u64::from(wanted.is_some()), &mut slot.ongoing.pulled, time, text);
}

/// Adds the events of a force that passed force safety at `time` (s).
pub(super) fn add_safety_events(events: &mut Events, slot: &mut ToolSlot, pass: &SafetyPass, time: f64) {
    let (name, limits) = (&slot.tool.name, slot.safety.limits());
    for (i, (cause, count)) in slot.safety.counts().enumerate() {
        let text = || format!("tool `{name}`: {}", safety_text(cause, pass, limits));
        events.add_episode(EventKind::ForceSafety, count - pass.counts[i], &mut slot.ongoing.limited[i], time, text);
    }
}

/// Description of the effect of a cause on a force, with the limit.
fn safety_text(cause: Cause, pass: &SafetyPass, limits: ForceLimits) -> String {
    let [last, wanted, given] = [pass.last, pass.wanted, pass.given].map(|force| force.norm());
    let ForceLimits { peak, continuous, slew } = limits;
    match cause {
        Cause::Slew if wanted == 0.0 => {
            format!("released: force faded from {last:.3} N over {:.1} ms (slew limit, {slew} N/s)", 1e3 * last / slew)
        }
        Cause::Slew => {
            format!(
                "the device gets {given:.3} N instead of {wanted:.3} N: the force changes faster than {slew} N/s (`slew`)"
            )
        }
        Cause::NotFinite => format!("the force {:?} N is not finite; the device gets 0 N", pass.wanted),
        Cause::Magnitude => format!("the force of {wanted:.3} N is over the device's peak, {peak} N"),
        Cause::Continuous => {
            format!("the mean force over ten seconds comes near the device's continuous rating, {continuous} N")
        }
        Cause::Passivity => "the force had given the hand more energy than it took; it is damped".into(),
        Cause::Stale => "the simulation behind the force was silent for 50 ms; the force fades".into(),
    }
}
