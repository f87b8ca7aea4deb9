//! `pliant run --live`.

use crate::args::{Cli, RunArgs};
use crate::open::open;
use crate::outcome::{Failure, Outcome};
use crate::run::{default_folder, outcome, stop_flag};
use crate::text;
use pliant_live::{LiveSession, LiveSettings, LiveSummary, Percentiles};
use pliant_record::{Recorder, RecordingInputs, RecordingWriter};
use std::sync::atomic::Ordering;
use std::time::Instant;

pub fn live(cli: &Cli, args: &RunArgs) -> Result<Outcome, Failure> {
    let began = Instant::now();
    let (scene, source, mut session) = open(cli, &args.scene)?;
    if session.devices.is_empty() {
        return Err(source.whole("nothing to run live: no edit uses a tool, so no device is open").into());
    }
    let folder = args.out.clone().unwrap_or_else(|| default_folder(&args.scene.scene));
    let mut recorder = Recorder::new(&scene, &source, &session, &folder, began)?;
    let mut recording = match &args.record {
        Some(path) => {
            let mesh = args.scene.mesh.as_deref();
            let inputs = RecordingInputs { scene: &scene, source: &source, session: &session, mesh, live: true };
            Some(RecordingWriter::create(path, &inputs)?)
        }
        None => None,
    };
    let duration = args.duration.unwrap_or(scene.time.duration.get_ref().si);
    let stop = stop_flag();
    let mut live = LiveSession::start(&mut session, LiveSettings { rate: args.rate, viewer: None })?;
    let mut stopped = false;
    loop {
        let samples = live.step(&mut session);
        if let Some(recording) = &mut recording {
            recording.step(&session, samples.device_forces.iter().copied())?;
        }
        stopped |= stop.load(Ordering::Relaxed);
        let last = stopped || !live.is_alive() || live.seconds() >= duration;
        recorder.step(&mut session, last)?;
        if last {
            break;
        }
    }
    // The hands are let go first; files can wait.
    let lived = live.finish();
    let panicked = lived.panicked;
    recorder.live = Some(lived);
    if let Some(recording) = recording {
        recording.finish()?;
    }
    let summary = recorder.finish(&mut session, stopped)?;
    if cli.json {
        text::out(&crate::pretty(&summary))?;
    } else if !args.quiet {
        crate::run::tell(&summary, &folder);
    }
    if panicked {
        return Err(Failure::plugin("the haptic thread ended by a panic; the devices were stopped"));
    }
    Ok(outcome(&summary, stopped))
}

/// What a person wants to know of it.
pub fn tell(live: &LiveSummary) {
    let kept = 100.0 * live.real_time_factor;
    text::note(&format!(
        "live for {}: {} ticks at {} Hz, {} missed; priority {}",
        text::seconds(live.seconds),
        live.ticks,
        live.rate,
        live.missed,
        live.realtime.priority
    ));
    text::note(&format!("  timer {}; memory {}", live.realtime.timer, live.realtime.memory));
    if let Some(usage) = live.thread_usage {
        let [ran, waited, stolen] = [usage.running, usage.waiting, usage.steal_time].map(text::seconds);
        text::note(&format!(
            "  the haptic thread ran {ran}, was ready without a processor for {waited}, preempted {} times, {} page \
             faults; {stolen} of all processors went to other machines",
            usage.preemptions, usage.page_faults
        ));
    }
    spread("  period", live.period);
    spread("  late", live.lateness);
    spread("  device to force", live.latency);
    spread("  age of contacts", live.contact_age);
    text::note(&format!("the simulation kept {kept:.1} % of real time, {} were lost", text::seconds(live.lost_time)));
    if live.watchdog_trips > 0 {
        text::note(&format!("the watchdog stopped the devices {} times", live.watchdog_trips));
    }
    for hand in &live.hands {
        for (cause, count) in hand.safety_counts.iter().filter(|(_, count)| **count > 0) {
            text::note(&format!("hand of tool `{}`: {cause}, {count} times", hand.tool));
        }
        if hand.dropped_samples + hand.speed_limited_samples > 0 {
            let (name, dropped, slowed) = (&hand.tool, hand.dropped_samples, hand.speed_limited_samples);
            text::note(&format!("hand of tool `{name}`: {dropped} samples dropped, {slowed} followed at its speed"));
        }
    }
}

fn spread(what: &str, spread: Option<Percentiles>) {
    if let Some(s) = spread {
        let [p50, p99, p999, max] = [s.p50, s.p99, s.p999, s.max].map(text::seconds);
        text::note(&format!("{what}: {p50} (p99 {p99}, p99.9 {p999}, most {max})"));
    }
}
