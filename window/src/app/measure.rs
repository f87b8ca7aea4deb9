//! Strokes that the program makes by itself, to measure what the window costs the simulation.

use super::App;
use super::gauges::FrameTimes;
use super::model::Model;
use crate::arguments::Arguments;
use crate::sim::{EndedRun, Notice, Simulation, StepTimes};
use crate::strings;
use crate::tools::ToolKind;
use crate::view::{Camera, Ray};
use eframe::egui;
use pliant_editor::{PaintStroke, PointerRay, StrokeStart};
use pliant_engine::scene::Release;
use pliant_live::LiveSummary;
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// What a measurement has found.
#[derive(Clone, Debug, Serialize)]
pub struct Measurement {
    /// Of the session: ticks, lateness, real-time factor.
    pub live: LiveSummary,
    /// Wall-clock times of the steps.
    pub step: StepTimes,
    /// Wall-clock times of the frames of the window, by part.
    pub frames: BTreeMap<&'static str, StepTimes>,
}

impl Measurement {
    pub(super) fn new(ended: EndedRun, times: Option<&FrameTimes>) -> Self {
        let EndedRun { live, step } = ended;
        Self { live, step, frames: times.map(FrameTimes::parts).unwrap_or_default() }
    }
}

/// Presses and strokes the model in the middle of the picture, again and again.
pub(super) struct ScriptedStrokes {
    /// With the first frame of the model: opening it is not measured.
    began: Option<Instant>,
    last: Option<Instant>,
    /// s
    duration: f64,
}

/// s, of a stroke and the pause after it
const PERIOD: f64 = 2.0;
/// s, of a stroke
const STROKE: f64 = 1.4;
/// Radius of the circle that a stroke goes along, of the height of the picture.
const CIRCLE: f64 = 0.12;

impl ScriptedStrokes {
    pub(super) fn new(duration: f64) -> Self {
        Self { began: None, last: None, duration }
    }

    /// Moves the hand on; gives whether there is more to do.
    pub(super) fn advance(&mut self, model: &mut Model, camera: &Camera, tool: ToolKind) -> bool {
        let seconds = self.began.get_or_insert_with(Instant::now).elapsed().as_secs_f64();
        let now = Instant::now();
        let dt = now.duration_since(self.last.replace(now).unwrap_or(now)).as_secs_f64();
        let phase = seconds % PERIOD;
        let (s, c) = (phase * std::f64::consts::TAU / STROKE).sin_cos();
        let ray = pointer_ray(camera.ray([CIRCLE * c, CIRCLE * s], 1.0));
        let reach = 2.0 * (camera.distance + camera.scene_radius);
        let hit = model.pick(&ray, reach).map(|picked| picked.hit.at);
        if phase < STROKE {
            if model.hand.is_busy() {
                model.hand.follow(ray, hit);
            } else {
                let radius = model.facts.hand.radius;
                let start = StrokeStart {
                    gesture: tool.gesture(),
                    ray,
                    hit,
                    back: camera.axes()[2],
                    focus: camera.target.coords,
                    radius,
                    depth: 0.6 * radius,
                };
                model.hand.begin(start, tool.buttons(Release::SpringBack, PaintStroke::default()));
            }
            model.hand.advance(dt);
        } else {
            model.hand.end();
        }
        seconds < self.duration
    }
}

impl App {
    /// Goes on with a measurement, if one is under way, and closes the window at its end.
    pub(super) fn run_script(&mut self) {
        let (Some(script), Some(model)) = (&mut self.script, &mut self.model) else { return };
        if script.advance(model, &self.camera, self.tools[self.tool]) {
            self.context.request_repaint();
            return;
        }
        self.script = None;
        // The stroke that is under way ends before the simulation does.
        self.model.take().into_iter().for_each(|mut model| _ = model.hand.end());
        let notices = self.simulation.take().map(Simulation::finish).unwrap_or_default();
        let summary = notices.into_iter().find_map(|notice| match notice {
            Notice::Ended(ended) => Some(ended),
            _ => None,
        });
        if let (Some(ended), Ok(mut measured)) = (summary, self.measured.lock()) {
            *measured = Some(Measurement::new(*ended, Some(&self.times)));
        }
        self.may_close = true;
        self.context.send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

/// A ray of the camera as the hand takes it.
pub(super) fn pointer_ray(ray: Ray) -> PointerRay {
    PointerRay { origin: ray.origin.coords, direction: ray.direction }
}

/// Makes the same strokes without a window.
///
/// # Errors
/// A model that cannot be opened.
pub fn measure_without_window(arguments: &Arguments) -> Result<Measurement, String> {
    let simulation = Simulation::start(arguments.request(), false, None, || {}).map_err(|error| error.to_string())?;
    let mut opened = None;
    while opened.is_none() {
        std::thread::sleep(Duration::from_millis(10));
        for notice in simulation.notices() {
            match notice {
                Notice::Failed(text) => return Err(text),
                Notice::Opened(model) => opened = Some(model),
                _ => {}
            }
        }
    }
    let mut model = Model::new(*opened.ok_or(strings::NOTHING_OPENED)?, None, egui::Context::default());
    let mut camera = Camera::default();
    let (centre, radius) = model.ball();
    camera.frame(centre, radius, 1.3);
    let tool = ToolKind::all()[0];
    let mut script = ScriptedStrokes::new(arguments.measure.unwrap_or_default());
    while script.advance(&mut model, &camera, tool) {
        std::thread::sleep(Duration::from_micros(16_667));
    }
    let ended = simulation.finish().into_iter().find_map(|notice| match notice {
        Notice::Ended(ended) => Some(ended),
        _ => None,
    });
    Ok(Measurement::new(*ended.ok_or(strings::ENDED_EARLY)?, None))
}
