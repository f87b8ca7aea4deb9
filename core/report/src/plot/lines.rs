//! Line plots.

use super::axis::Axis;
use super::svg::{Anchor, COLOURS, Svg, format_short};

/// One curve of a line plot.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Points (x, y) in the order they are joined.
    pub points: Vec<(f64, f64)>,
    /// Whether each point has a large mark; points beyond the end of the list have a small one.
    pub large: Vec<bool>,
    /// Whether it is a theoretical curve, drawn dashed without marks.
    pub theory: bool,
}

/// Curves over common axes.
#[derive(Clone, Debug, Default)]
pub struct LinePlot {
    /// Title above the picture.
    pub title: String,
    /// Horizontal axis, with its name, unit and scale.
    pub x: Axis,
    /// Vertical axis, with its name, unit and scale.
    pub y: Axis,
    /// Curves in the order of the legend.
    pub curves: Vec<Curve>,
}

/// px, left margin
const LEFT: f64 = 78.0;
/// px, upper margin
const TOP: f64 = 40.0;
/// px, width of the plot
const WIDTH: f64 = 430.0;
/// px, height of the plot
const HEIGHT: f64 = 300.0;
/// px, width of the legend
const LEGEND: f64 = 300.0;

/// Maps the values of an axis to its length.
struct Scale {
    low: f64,
    high: f64,
    log: bool,
}

impl Scale {
    /// A scale that contains all values, with a margin.
    fn new(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let seen = values.filter(|v| v.is_finite() && (!axis.log || *v > 0.0));
        let place = |v: f64| if axis.log { v.log10() } else { v };
        let (low, high) = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(place(v)), h.max(place(v))));
        if low > high {
            return Self { low: 0.0, high: 1.0, log: axis.log };
        }
        let room = if high > low { 0.06 * (high - low) } else { 0.5 };
        Self { low: if axis.log || low < 0.0 { low - room } else { 0.0 }, high: high + room, log: axis.log }
    }

    /// Position of a value, 0 to 1 along the axis.
    fn at(&self, value: f64) -> f64 {
        let place = if self.log { value.log10() } else { value };
        (place - self.low) / (self.high - self.low)
    }

    /// Values with a tick and a label.
    fn ticks(&self) -> Vec<f64> {
        let span = self.high - self.low;
        if self.log && span >= 2.0 {
            let step = (span / 7.0).ceil().max(1.0);
            let first = (self.low / step).ceil() as i64;
            let all = (first..).map(|i| i as f64 * step).take_while(|t| *t <= self.high);
            return all.map(|t| 10.0_f64.powf(t)).collect();
        }
        if self.log {
            let mantissas = if span < 0.5 { &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0][..] } else { &[1.0, 2.0, 5.0] };
            let decades = self.low.floor() as i32..=self.high.ceil() as i32;
            let all = decades.flat_map(|d| mantissas.iter().map(move |m| m * 10.0_f64.powi(d)));
            return all.filter(|t| (0.0..=1.0).contains(&self.at(*t))).collect();
        }
        let raw = span / 6.0;
        let decade = 10.0_f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * decade).find(|s| *s >= raw).unwrap_or(decade);
        let first = (self.low / step).ceil() as i64;
        (first..).map(|i| i as f64 * step).take_while(|t| *t <= self.high).collect()
    }
}

impl LinePlot {
    /// The picture as SVG.
    pub fn svg(&self) -> String {
        let all = || self.curves.iter().flat_map(|c| c.points.iter());
        let x = Scale::new(&self.x, all().map(|p| p.0));
        let y = Scale::new(&self.y, all().map(|p| p.1));
        let place = |p: (f64, f64)| (LEFT + WIDTH * x.at(p.0), TOP + HEIGHT * (1.0 - y.at(p.1)));
        let height = (TOP + HEIGHT + 60.0).max(TOP + 20.0 + 18.0 * self.curves.len() as f64);
        let mut svg = Svg::new(LEFT + WIDTH + 20.0 + LEGEND, height, &self.title);
        let (right, bottom) = (LEFT + WIDTH, TOP + HEIGHT);
        for tick in x.ticks() {
            let at = LEFT + WIDTH * x.at(tick);
            svg.line((at, TOP), (at, bottom), "stroke=\"#e4e4e4\"");
            svg.text((at, bottom + 17.0), Anchor::Middle, "", &format_short(tick));
        }
        for tick in y.ticks() {
            let at = TOP + HEIGHT * (1.0 - y.at(tick));
            svg.line((LEFT, at), (right, at), "stroke=\"#e4e4e4\"");
            svg.text((LEFT - 7.0, at + 4.0), Anchor::End, "", &format_short(tick));
        }
        svg.rect((LEFT, TOP), (WIDTH, HEIGHT), "fill=\"none\" stroke=\"#666\"");
        svg.text((LEFT + 0.5 * WIDTH, bottom + 42.0), Anchor::Middle, "", &self.x.label);
        svg.text_up((20.0, TOP + 0.5 * HEIGHT), &self.y.label);
        for (i, curve) in self.curves.iter().enumerate() {
            let colour = if curve.theory { "#888888" } else { COLOURS[i % COLOURS.len()] };
            let dash = if curve.theory { "stroke-dasharray=\"6 4\"" } else { "" };
            let inside = |p: &&(f64, f64)| [x.at(p.0), y.at(p.1)].iter().all(|v| (-1e-9..=1.0 + 1e-9).contains(v));
            let points: Vec<_> = curve.points.iter().filter(inside).map(|p| place(*p)).collect();
            svg.polyline(&points, &format!("stroke=\"{colour}\" stroke-width=\"1.6\" {dash}"));
            let beside = TOP + 10.0 + 18.0 * i as f64;
            let sample = [(right + 18.0, beside - 4.0), (right + 40.0, beside - 4.0)];
            svg.line(sample[0], sample[1], &format!("stroke=\"{colour}\" stroke-width=\"1.6\" {dash}"));
            if !curve.theory {
                for (k, point) in curve.points.iter().enumerate().filter(|(_, p)| inside(p)) {
                    svg.mark(place(*point), i, colour, curve.large.get(k) == Some(&true));
                }
                svg.mark((right + 29.0, beside - 4.0), i, colour, false);
            }
            svg.text((right + 47.0, beside), Anchor::Start, "", &shorten(&curve.name, 42));
        }
        svg.finish()
    }
}

/// A text of at most `most` characters, for the legend.
fn shorten(text: &str, most: usize) -> String {
    if text.chars().count() <= most { text.into() } else { text.chars().take(most - 1).chain(['…']).collect() }
}
