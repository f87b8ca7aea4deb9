//! Stacked bars: fractions of a total.

use super::svg::{Anchor, COLOURS, Svg, format_short};

/// Bars side by side, each a stack of parts of one height.
#[derive(Clone, Debug, Default)]
pub(crate) struct StackedBars {
    /// Title above the picture.
    pub(crate) title: String,
    /// Name and unit of what tells the bars apart.
    pub(crate) x: String,
    /// Name and unit of the height.
    pub(crate) y: String,
    /// Names of the stacked parts.
    pub(crate) parts: Vec<String>,
    /// Name and parts (s) of each bar.
    pub(crate) bars: Vec<(String, Vec<f64>)>,
}

/// px, left margin
const LEFT: f64 = 78.0;
/// px, upper margin
const TOP: f64 = 44.0;
/// px, height of the bars
const HEIGHT: f64 = 260.0;
/// px, distance between two bars
const BAR: f64 = 64.0;

impl StackedBars {
    /// The picture as SVG. All bars are of one height; the sum of each is written above it.
    pub(crate) fn svg(&self) -> String {
        let width = BAR * self.bars.len() as f64;
        let mut svg = Svg::new((LEFT + width + 230.0).max(460.0), TOP + HEIGHT + 66.0, &self.title);
        for tick in [0.0, 25.0, 50.0, 75.0, 100.0] {
            let y = TOP + 16.0 + (HEIGHT - 16.0) * (1.0 - tick / 100.0);
            svg.line((LEFT, y), (LEFT + width, y), "stroke=\"#e4e4e4\"");
            svg.text((LEFT - 7.0, y + 4.0), Anchor::End, "", &format!("{tick}"));
        }
        for (i, (name, parts)) in self.bars.iter().enumerate() {
            let (x, whole) = (LEFT + BAR * i as f64, parts.iter().sum::<f64>());
            let mut y = TOP + HEIGHT;
            for (part, value) in parts.iter().enumerate() {
                let high = (HEIGHT - 16.0) * value / whole.max(f64::MIN_POSITIVE);
                y -= high;
                let style = format!("fill=\"{}\"", COLOURS[part % COLOURS.len()]);
                svg.rect((x + 10.0, y), (BAR - 20.0, high), &style);
            }
            let middle = x + 0.5 * BAR;
            svg.text((middle, TOP + 10.0), Anchor::Middle, "", &format!("{} ms", format_short(1e3 * whole)));
            svg.text((middle, TOP + HEIGHT + 17.0), Anchor::Middle, "", name);
        }
        svg.text((LEFT + 0.5 * width, TOP + HEIGHT + 42.0), Anchor::Middle, "", &self.x);
        svg.text_up((20.0, TOP + 0.5 * HEIGHT), &self.y);
        for (i, part) in self.parts.iter().enumerate() {
            let (x, y) = (LEFT + width + 18.0, TOP + 22.0 * i as f64);
            svg.rect((x, y), (16.0, 14.0), &format!("fill=\"{}\"", COLOURS[i % COLOURS.len()]));
            svg.text((x + 24.0, y + 11.0), Anchor::Start, "", part);
        }
        svg.finish()
    }
}
