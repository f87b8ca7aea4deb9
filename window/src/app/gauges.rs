//! Gauges: how well everything keeps time, and the force on the hand.

use super::App;
use super::timings::StartStage;
use crate::gl::PixelArea;
use crate::sim::StepTimes;
use crate::strings;
use crate::view::overlay::format_force;
use eframe::egui::{self, Color32, Stroke, pos2, vec2};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Where the time of a frame goes. Uploads and drawing are timed where they are done, so they come through a lock.
#[derive(Default)]
pub(super) struct FrameTimes {
    began: Option<Instant>,
    /// s, of each frame: taking in the newest frame of the session
    copies: Vec<f64>,
    /// s, of each frame: all of the window's own work, copying included
    windows: Vec<f64>,
    pub(super) drawn: Arc<Mutex<DrawTimes>>,
    area: Option<PixelArea>,
}

/// Times of the renderer.
#[derive(Default)]
pub(super) struct DrawTimes {
    /// s, of each frame: uploading
    pub(super) uploads: Vec<f64>,
    /// s, of each frame: drawing, until the picture is done
    pub(super) draws: Vec<f64>,
}

/// Frames that are remembered.
const REMEMBERED: usize = 20_000;

impl FrameTimes {
    pub(super) fn begin(&mut self) {
        self.began = Some(Instant::now());
    }

    pub(super) fn copy(&mut self, time: Duration) {
        remember(&mut self.copies, time);
    }

    pub(super) fn end(&mut self) {
        if let Some(began) = self.began.take() {
            remember(&mut self.windows, began.elapsed());
        }
    }

    pub(super) fn show_in(&mut self, area: PixelArea) {
        self.area = Some(area);
    }

    /// Width over height of the picture; of a usual one before the first.
    pub(super) fn aspect(&self) -> f64 {
        self.area.map_or(1.3, |area| f64::from(area.width) / f64::from(area.height.max(1)))
    }

    /// Times of each part.
    pub(super) fn parts(&self) -> BTreeMap<&'static str, StepTimes> {
        let of = |list: &[f64]| StepTimes::of(&mut list.to_vec());
        let mut all = BTreeMap::from([("copy", of(&self.copies)), ("window", of(&self.windows))]);
        if let Ok(drawn) = self.drawn.lock() {
            all.extend([("upload", of(&drawn.uploads)), ("draw", of(&drawn.draws))]);
        }
        all
    }
}

/// Adds a time to a list that is kept short.
pub(super) fn remember(list: &mut Vec<f64>, time: Duration) {
    if list.len() >= REMEMBERED {
        list.drain(..REMEMBERED / 2);
    }
    list.push(time.as_secs_f64());
}

/// s, shown by the plot of the force
pub(super) const PLOTTED: f64 = 6.0;

/// The force on the hand over the last seconds.
#[derive(Default)]
pub(super) struct ForcePlot {
    /// s, simulated time, and N
    points: VecDeque<(f64, f64)>,
}

impl ForcePlot {
    pub(super) fn add(&mut self, time: f64, force: f64) {
        if self.points.back().is_some_and(|(last, _)| *last == time) {
            return;
        }
        self.points.push_back((time, force));
        while self.points.front().is_some_and(|(first, _)| *first < time - PLOTTED || *first > time) {
            self.points.pop_front();
        }
    }

    fn show(&self, ui: &mut egui::Ui) {
        let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), 56.0), egui::Sense::hover());
        let rect = response.rect;
        painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
        let most = self.points.iter().map(|(_, force)| *force).fold(0.0, f64::max);
        let Some((now, _)) = self.points.back() else { return };
        if most > 0.0 {
            let place = |(time, force): &(f64, f64)| {
                let x = 1.0 - ((now - time) / PLOTTED) as f32;
                let y = 1.0 - 0.92 * (force / most) as f32;
                pos2(rect.left() + x * rect.width(), rect.top() + y * rect.height())
            };
            let line: Vec<_> = self.points.iter().map(place).collect();
            painter.line(line, Stroke::new(1.5, Color32::from_rgb(255, 170, 40)));
        }
        response.on_hover_text(strings::force_plot(PLOTTED, &format_force(most)));
    }
}

impl App {
    /// The force on the hand, and what to do where the simulation is slower than time.
    pub(super) fn force_panel(&mut self, ui: &mut egui::Ui) {
        let gauges = self.status.gauges;
        let force = self.model.as_ref().and_then(super::model::Model::tool).map_or(0.0, |tool| tool.force.norm());
        let limit = self.model.as_ref().map_or(0.0, |model| model.facts.hand.peak_force);
        ui.label(strings::force_of(&format_force(force), &format_force(limit)));
        self.force.show(ui);
        let warn = |ui: &mut egui::Ui, text: String| ui.colored_label(Color32::from_rgb(240, 90, 80), text);
        if self.model.is_none() || !gauges.is_slow() {
            return;
        }
        if gauges.is_held_up() {
            warn(ui, strings::held_up(gauges.real_time_factor));
            return;
        }
        let taken_as = self.model.as_ref().and_then(|model| model.facts.taken_as);
        warn(ui, strings::slow(gauges.real_time_factor, taken_as));
        if let Some(remedy) = self.request.remedy(taken_as)
            && ui.button(strings::remedy(remedy)).clicked()
        {
            self.request.take_remedy(remedy);
            self.reopen();
        }
    }

    /// Times of the loops, and how much is simulated.
    pub(super) fn gauge_panel(&mut self, ui: &mut egui::Ui) {
        let gauges = self.status.gauges;
        ui.heading(strings::GAUGES);
        let ms = strings::milliseconds;
        egui::Grid::new("gauges").num_columns(2).show(ui, |ui| {
            let mut row = |name: &str, value: String| {
                ui.label(name);
                ui.label(value);
                ui.end_row();
            };
            row(strings::REAL_TIME, strings::percent(gauges.real_time_factor));
            row(strings::STEP, strings::with_p99(gauges.step_median, gauges.step_p99));
            row(strings::TIME_STEP, ms(gauges.dt));
            row(strings::HAPTIC_LOOP, strings::rate(gauges.haptic_rate));
            row(strings::LATENESS, strings::with_missed(gauges.lateness, gauges.missed));
            row(strings::SIMULATED, strings::size_of(gauges.nodes, gauges.elements));
            row(strings::MEMORY, strings::megabytes(gauges.bytes));
            if let Some(seconds) = self.start.of(StartStage::ModelShown) {
                row(strings::FIRST_PICTURE, strings::seconds(seconds));
            }
            row(strings::TO_SCREEN, strings::latency(&self.latency.motions()));
        });
    }
}
