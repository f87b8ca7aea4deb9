//! The thread of the simulation.

use super::autosave::Autosave;
use super::device_strokes::{DeviceStrokes, StrokeChange};
use super::export::{write_bodies, write_together};
use super::faint_stroke::FaintStroke;
use super::gauges::GaugeWindow;
use super::history::{HistoryStep, StrokeLog};
use super::messages::{Command, EndedRun, Notice, Notifier, OpenModel, Status};
use super::session_file::SessionFile;
use super::takeover::{HandedOver, Handover, Predecessor, TakenOver};
use crate::opening::{OpenRequest, Opened, open};
use crate::strings;
use pliant_editor::DeviceHand;
use pliant_editor::surface::ViewSurface;
use pliant_engine::session::{CancelToken, EventKind, Session, SessionCommand};
use pliant_host::Device;
use pliant_live::{HapticDevice, LiveSession, LiveSettings, PointerDevice, PointerHandle, ViewWriter, view_buffer};
use pliant_solver::Vec3;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, PoisonError};
use std::time::Instant;
use triple_buffer::Input;

/// s, between two reports of the state of affairs
const REPORT_PERIOD: f64 = 0.1;

/// What the thread hears and tells.
pub(super) struct Channels<'a> {
    /// What to do between two steps.
    pub(super) commands: &'a Receiver<Command>,
    /// Where it tells what has happened.
    pub(super) notifier: &'a Notifier,
    /// Ends the step under way, for the simulation is to end.
    pub(super) cancel: CancelToken,
    /// Where it leaves its live session for another simulation.
    pub(super) handover: &'a Handover,
}

/// Opens what is asked for and steps it until it is told to end.
pub(super) fn run(
    request: &OpenRequest,
    viewing: bool,
    before: Option<Predecessor>,
    channels: Channels<'_>,
    status: Input<Status>,
) {
    let notifier = channels.notifier;
    let work = || work(request, viewing, before, channels, status);
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)) {
        Ok(Ok(())) => {}
        Ok(Err(text)) => notifier.send(Notice::Failed(text)),
        Err(_) => notifier.send(Notice::Failed(strings::SIMULATION_FAILED.into())),
    }
}

fn work(
    request: &OpenRequest,
    viewing: bool,
    before: Option<Predecessor>,
    channels: Channels<'_>,
    mut status: Input<Status>,
) -> Result<(), String> {
    let Channels { commands, notifier, cancel, handover } = channels;
    let began = Instant::now();
    let mut opened = open(request)?;
    opened.session.keep_history();
    let mut session_file = SessionFile::begin(&opened, !request.is_scene() && !request.is_tetrahedral());
    let Opened { mut session, facts, .. } = opened;
    session.cancel_when(cancel);
    let (writer, reader) = view_buffer(&session);
    let surfaces = reader.bodies.iter().map(ViewSurface::new).collect();
    // The scene can mirror the hand along all axes; the window says along which.
    session_file.apply(&mut session, SessionCommand::SetSymmetry { axes: [false; 3], centre: Vec3::zeros() });
    let [slot] = &session.devices[..] else { return Err(strings::NOT_ONE_HAND.into()) };
    let device_frame = slot.frame;
    let view = Some(writer).filter(|_| viewing);
    let Started { mut live, hand, device_hand } = start(request, before, &mut session, view, notifier)?;
    let has_device = device_hand.is_some();
    let cap_material = facts.cap_material.clone();
    let seconds = began.elapsed().as_secs_f64();
    let moving = session.bodies.iter().map(|body| &body.model);
    let models = moving.chain(session.standing.iter().map(|(_, model)| model)).map(Arc::clone).collect();
    let opened = OpenModel { facts, reader, surfaces, models, hand, device_hand, device_frame, seconds };
    notifier.send(Notice::Opened(Box::new(opened)));
    let mut device_strokes = has_device.then(DeviceStrokes::new);
    let mut log = StrokeLog::default();
    let mut autosave = Autosave::new(request);
    let mut gauges = GaugeWindow::new(session.dt());
    let (mut reported, mut noticed) = (f64::NEG_INFINITY, 0);
    let mut session_path: Option<PathBuf> = None;
    let (mut in_stroke, mut warnings, mut told) = (false, session.warnings(), Status::default());
    let (mut was_at_rest, mut faint_stroke) = (false, FaintStroke::default());
    let mut pending = VecDeque::new();
    // What is asked for while a stroke is under way, and done when it has ended.
    let mut after_stroke = VecDeque::new();
    while live.is_alive() {
        let samples = live.step_after(&mut session, |session| {
            pending.extend(commands.try_iter());
            apply_settings(&mut pending, session, &mut session_file);
        });
        let hand = samples.poses.first().and_then(|poses| poses.first());
        let change = device_strokes.as_mut().map_or(StrokeChange::None, |strokes| strokes.update(hand));
        // A step that was cancelled is followed by the command to end.
        if !session.is_cancelled() {
            session_file.step(&session, &samples.device_forces);
            // Commands are recorded with the step after them.
            if let Some(path) = session_path.take() {
                notifier.send(save_session(&mut session_file, &session, &path));
            }
        }
        if let (Some(frame), Some(slot)) = (session.frame().tools.first(), session.tools.first())
            && faint_stroke.update(frame, slot.tool.proxy.radius())
        {
            notifier.send(Notice::Message(strings::FAINT_STROKE.to_owned()));
        }
        let now = live.seconds();
        let (mut changed, mut save_now) = (false, false);
        // A stroke that has begun in the step is known by its name before the history is looked at.
        match change {
            StrokeChange::None => {}
            StrokeChange::Began(name) => {
                in_stroke = true;
                log.begin(name);
                save_now |= autosave.begin_stroke();
            }
            StrokeChange::Ended => {
                in_stroke = false;
                autosave.end_stroke(now);
            }
        }
        pending.extend(commands.try_iter());
        for command in pending.drain(..) {
            match command {
                Command::BeginStroke(name) => {
                    in_stroke = true;
                    log.begin(name);
                    save_now |= autosave.begin_stroke();
                }
                Command::EndStroke => {
                    in_stroke = false;
                    autosave.end_stroke(now);
                }
                Command::Undo => {
                    changed |= log.update(session.history(), session.edits_forgotten(), now);
                    let count = log.count_before();
                    let has_gone = go_to(&mut session, &mut session_file, &mut log, count);
                    changed |= has_gone;
                    if !has_gone {
                        notifier.send(Notice::Message(strings::NOTHING_TO_UNDO.to_owned()));
                    }
                }
                Command::Redo => {
                    changed |= log.update(session.history(), session.edits_forgotten(), now);
                    let count = log.count_after();
                    let has_gone = go_to(&mut session, &mut session_file, &mut log, count);
                    changed |= has_gone;
                    if !has_gone {
                        notifier.send(Notice::Message(strings::NOTHING_TO_REDO.to_owned()));
                    }
                }
                Command::JumpTo(count) => {
                    changed |= log.update(session.history(), session.edits_forgotten(), now);
                    changed |= go_to(&mut session, &mut session_file, &mut log, count);
                }
                Command::ChangeBrush(setting) => _ = session_file.apply(&mut session, setting),
                Command::SetStiffness { factor } => {
                    changed |= log.update(session.history(), session.edits_forgotten(), now);
                    let before = session.stiffness().wanted;
                    if session_file.apply(&mut session, SessionCommand::SetStiffness { factor }) {
                        log.change_stiffness(strings::HISTORY_STIFFNESS, [before, session.stiffness().wanted], now);
                        reported = f64::NEG_INFINITY;
                    }
                }
                Command::ChangeLayers(command) => {
                    changed |= log.update(session.history(), session.edits_forgotten(), now);
                    log.begin(layer_change(&command));
                    if session_file.apply(&mut session, command) {
                        autosave.need(now);
                    }
                    // The panel follows at once, also where the history does not change.
                    reported = f64::NEG_INFINITY;
                }
                Command::Split { body, triangle } => {
                    changed |= log.update(session.history(), session.edits_forgotten(), now);
                    log.begin(strings::HISTORY_SPLIT);
                    if session_file.apply(&mut session, SessionCommand::SplitBody { body, triangle }) {
                        autosave.need(now);
                    }
                    reported = f64::NEG_INFINITY;
                }
                Command::Save { .. } | Command::ReportShape if in_stroke || session.edits_under_way() > 0 => {
                    after_stroke.push_back(command);
                }
                Command::Save { path, for_user } => {
                    changed |= log.update(session.history(), session.edits_forgotten(), now);
                    notifier.send(save(&mut session, request, &cap_material, path, for_user, log.shape()));
                }
                Command::ReportShape => {
                    changed |= log.update(session.history(), session.edits_forgotten(), now);
                    notifier.send(Notice::Shape(log.shape()));
                }
                Command::SaveSession { path } => session_path = Some(path),
                Command::HandOver => {
                    autosave.discard();
                    let left = HandedOver { live, touching: session.touching_proxies() };
                    *handover.lock().unwrap_or_else(PoisonError::into_inner) = Some(left);
                    return Ok(());
                }
                Command::End => {
                    autosave.discard();
                    let ended = EndedRun { live: live.finish(), step: gauges.all() };
                    notifier.send(Notice::Ended(Box::new(ended)));
                    return Ok(());
                }
            }
        }
        gauges.step(session.frame().seconds);
        changed |= log.update(session.history(), session.edits_forgotten(), now);
        if changed {
            autosave.need(now);
        }
        if let Err(text) = autosave.poll() {
            notifier.send(Notice::Message(text));
        }
        if save_now || autosave.is_due(now) {
            session.update_surface();
            if let Err(text) = autosave.save(&session, &cap_material) {
                notifier.send(Notice::Message(text));
            }
        }
        let is_under_way = in_stroke || session.edits_under_way() > 0;
        if !is_under_way {
            // They come before what is asked for from now on.
            pending.append(&mut after_stroke);
        }
        let is_at_rest = !is_under_way && session.is_at_rest();
        changed |= std::mem::replace(&mut was_at_rest, is_at_rest) != is_at_rest;
        if changed || now >= reported + REPORT_PERIOD {
            reported = now;
            gauges.update(live.gauges());
            gauges.size(session.frame().nodes, session.frame().elements, session.bytes());
            let strokes = log.strokes().to_vec();
            // A stroke has met nothing until it meets something.
            if !in_stroke {
                warnings = session.warnings();
            }
            let state = Status {
                gauges: gauges.gauges(),
                strokes,
                begun: log.done(),
                done: log.ended(is_under_way),
                shape: log.shape(),
                is_at_rest,
                stiffness: session.stiffness(),
                layers: session.sculpt_layers(),
                warnings: warnings.clone(),
            };
            let is_changed = state.is_news_after(&told);
            told.clone_from(&state);
            status.write(state);
            if is_changed {
                notifier.wake();
            }
            let news = session.events.described().iter().skip(noticed).filter(|(kind, _)| is_news(*kind, has_device));
            for (kind, event) in news {
                notifier.send(Notice::Message(strings::news(*kind, &event.text, request.is_scene())));
            }
            noticed = session.events.described().len();
        }
    }
    Err(strings::HAPTIC_THREAD_ENDED.into())
}

/// A session that has begun in real time.
struct Started {
    live: LiveSession,
    /// The hand of the pointer.
    hand: PointerHandle,
    device_hand: Option<DeviceHand>,
}

/// Starts a session in real time: with the device of a predecessor, with one that is opened for it, or with the pointer alone.
fn start(
    request: &OpenRequest,
    before: Option<Predecessor>,
    session: &mut Session,
    mut view: Option<ViewWriter>,
    notifier: &Notifier,
) -> Result<Started, String> {
    if let Some(before) = before
        && let Some(TakenOver { live, hand, device_hand }) = before.hand_over(session, view.take())
    {
        return Ok(Started { live, hand, device_hand: Some(device_hand) });
    }
    let [slot] = &session.devices[..] else { return Err(strings::NOT_ONE_HAND.into()) };
    let (device, hand) = PointerDevice::new(slot.facts);
    // Last: an arm that is open is served from here on.
    let real =
        request.device.as_ref().map(|device| request.search().and_then(|search| device.open(&search, session.dt())));
    let (device, device_hand) = give_device(device, real, session, request, notifier);
    let devices: Vec<Box<dyn HapticDevice>> = vec![device];
    let live = LiveSession::start_with_devices(session, devices, LiveSettings { rate: None, view })
        .map_err(|error| strings::not_live(&error))?;
    Ok(Started { live, hand, device_hand })
}

/// The device of the hand: the pointer, or with `real` a device that can have the hand in its place.
fn give_device(
    pointer: PointerDevice,
    real: Option<Result<Device, String>>,
    session: &Session,
    request: &OpenRequest,
    notifier: &Notifier,
) -> (Box<dyn HapticDevice>, Option<DeviceHand>) {
    let real = match real {
        None => return (Box::new(pointer), None),
        Some(Err(text)) => {
            notifier.send(Notice::NoDevice(text));
            return (Box::new(pointer), None);
        }
        Some(Ok(device)) => device,
    };
    let name = request.device.as_ref().map_or_else(String::new, |device| device.plugin.clone());
    let (guided, hand) = DeviceHand::give(Box::new(real), pointer, session, 0, name);
    (Box::new(guided), Some(hand))
}

/// Applies the settings of the brush that were asked for before anything else was: a stroke that begins in the step to come has them all.
fn apply_settings(pending: &mut VecDeque<Command>, session: &mut Session, session_file: &mut SessionFile) {
    while let Some(Command::ChangeBrush(_)) = pending.front() {
        let Some(Command::ChangeBrush(setting)) = pending.pop_front() else { return };
        session_file.apply(session, setting);
    }
}

/// Whether people should hear of it. A pointer jumps and leaves as a hand does not, what is taken back is in the history, substeps and repeated steps
/// are in the times of the gauges, and that a model comes to rest is seen. What keeps the force on a device safe is news where there is a device. Hands that are
/// mirror images are meant to work each on its own side.
fn is_news(kind: EventKind, has_device: bool) -> bool {
    match kind {
        EventKind::SpeedLimit
        | EventKind::SampleDropped
        | EventKind::History
        | EventKind::Asleep
        | EventKind::Substeps
        | EventKind::GripsApart
        | EventKind::RepeatedStep => false,
        EventKind::ForceSafety => has_device,
        EventKind::Message
        | EventKind::Quarantine
        | EventKind::DeviceLost
        | EventKind::GripLost
        | EventKind::ForceLimit
        | EventKind::CutRefused
        | EventKind::CutHeld
        | EventKind::CutAgain
        | EventKind::StitchRefused
        | EventKind::StitchOpened
        | EventKind::PaintRefused
        | EventKind::Split
        | EventKind::SplitRefused
        | EventKind::LayerRefused
        | EventKind::LayerFixed
        | EventKind::NotConverged
        | EventKind::LongStep
        | EventKind::Unstable
        | EventKind::CollisionsLeft
        | EventKind::ElementsFailed
        | EventKind::Model
        | EventKind::Welded
        | EventKind::NotKept
        | EventKind::Repaired
        | EventKind::FoldsLeft => true,
    }
}

/// What a change of the sculpt layers is called in the history.
fn layer_change(command: &SessionCommand) -> &'static str {
    match command {
        SessionCommand::AddLayer { .. } => strings::HISTORY_NEW_LAYER,
        SessionCommand::RenameLayer { .. } => strings::HISTORY_RENAME_LAYER,
        SessionCommand::RecordLayer { .. } => strings::HISTORY_RECORD_LAYER,
        SessionCommand::SetLayerStrength { .. } => strings::HISTORY_LAYER_STRENGTH,
        SessionCommand::MergeLayer { .. } => strings::HISTORY_MERGE_LAYER,
        SessionCommand::DeleteLayer { .. } => strings::HISTORY_DELETE_LAYER,
        SessionCommand::Undo
        | SessionCommand::Redo
        | SessionCommand::ResizeTools { .. }
        | SessionCommand::SplitBody { .. }
        | SessionCommand::SetBrush { .. }
        | SessionCommand::SetSymmetry { .. }
        | SessionCommand::SetStiffness { .. } => "",
    }
}

/// Takes back or makes again until `count` entries of the history are there. Returns whether anything has changed.
fn go_to(session: &mut Session, session_file: &mut SessionFile, log: &mut StrokeLog, count: usize) -> bool {
    let mut has_changed = false;
    while let Some(step) = log.step_to(count) {
        has_changed = true;
        match step {
            HistoryStep::Undo => {
                while session.history().done > log.edits() && session_file.apply(session, SessionCommand::Undo) {}
            }
            HistoryStep::Redo => {
                while session.history().done < log.edits() && session_file.apply(session, SessionCommand::Redo) {}
            }
            HistoryStep::Stiffness(factor) => {
                session_file.apply(session, SessionCommand::SetStiffness { factor });
            }
        }
    }
    has_changed
}

/// Writes the recording of the session, and its scene and model beside it.
fn save_session(session_file: &mut SessionFile, session: &Session, path: &Path) -> Notice {
    match session_file.save(session, path) {
        Ok(scene) => Notice::Message(strings::session_saved(path, &scene, !session.timeouts().is_empty())),
        Err(text) => Notice::NotSaved(text),
    }
}

/// Writes every body that moves: the first to `path`, others beside it with their names added. `shape`: the shape that is written.
fn save(
    session: &mut Session,
    request: &OpenRequest,
    cap_material: &str,
    path: PathBuf,
    for_user: bool,
    shape: u64,
) -> Notice {
    session.update_surface();
    // What is opened again is one file: with all bodies, as after a split.
    let written = match for_user {
        true => write_bodies(session, cap_material, request.material_folder(), &path),
        false => write_together(session, cap_material, &path).map(|()| Vec::new()),
    };
    match written {
        Ok(problems) => Notice::Saved { path, for_user, shape, problems },
        Err(error) => Notice::NotSaved(error.to_string()),
    }
}
