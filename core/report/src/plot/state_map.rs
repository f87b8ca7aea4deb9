//! Maps of states over two parameters.

use super::svg::{Anchor, Svg, format_short};

/// A state for every pair of values of two parameters.
#[derive(Clone, Debug, Default)]
pub(crate) struct StateMap {
    /// Title above the picture.
    pub(crate) title: String,
    /// Name and unit of the horizontal parameter.
    pub(crate) x: String,
    /// Name and unit of the vertical parameter.
    pub(crate) y: String,
    /// Values of the horizontal parameter, ascending.
    pub(crate) columns: Vec<f64>,
    /// Values of the vertical parameter, ascending.
    pub(crate) rows: Vec<f64>,
    /// State in each row and column.
    pub(crate) states: Vec<Vec<String>>,
    /// Predicted limit in each column, in values of the vertical parameter.
    pub(crate) predicted: Vec<Option<f64>>,
}

/// Name, colour and letter of each state; the letter identifies the state without colour.
const STATE_STYLES: [(&str, &str, &str); 6] = [
    ("stable", "#9fd3b5", "s"),
    ("damped", "#cfe8f7", "d"),
    ("growing", "#f0a07c", "G"),
    ("refused", "#d9d9d9", "r"),
    ("not converged", "#f5dc8f", "n"),
    ("long step", "#e8d4ee", "l"),
];

/// px, left margin
const LEFT: f64 = 78.0;
/// px, upper margin
const TOP: f64 = 40.0;
/// px, width and height of a cell
const CELL: (f64, f64) = (46.0, 24.0);

impl StateMap {
    /// The picture as SVG.
    pub(crate) fn svg(&self) -> String {
        let size = (CELL.0 * self.columns.len() as f64, CELL.1 * self.rows.len() as f64);
        let height = (TOP + size.1 + 62.0).max(TOP + 24.0 * (STATE_STYLES.len() + 2) as f64);
        let mut svg = Svg::new((LEFT + size.0 + 170.0).max(460.0), height, &self.title);
        let up = |row: f64| TOP + size.1 - CELL.1 * row;
        for (r, row) in self.states.iter().enumerate() {
            svg.text((LEFT - 7.0, up(r as f64 + 0.5) + 4.0), Anchor::End, "", &format_short(self.rows[r]));
            for (c, state) in row.iter().enumerate() {
                let style = STATE_STYLES.iter().find(|l| l.0 == state).unwrap_or(&("", "#ffffff", "?"));
                let at = (LEFT + CELL.0 * c as f64, up(r as f64 + 1.0));
                svg.rect(at, CELL, &format!("fill=\"{}\" stroke=\"#fff\"", style.1));
                svg.text((at.0 + 0.5 * CELL.0, at.1 + 16.0), Anchor::Middle, "fill=\"#333\"", style.2);
            }
        }
        for (c, value) in self.columns.iter().enumerate() {
            let at = (LEFT + CELL.0 * (c as f64 + 0.5), TOP + size.1 + 17.0);
            svg.text(at, Anchor::Middle, "", &format_short(*value));
        }
        for (c, limit) in self.predicted.iter().enumerate() {
            let Some(at) = limit.and_then(|l| self.place(l)) else { continue };
            let (x, y) = (LEFT + CELL.0 * c as f64, up(at));
            svg.line((x, y), (x + CELL.0, y), "stroke=\"#000\" stroke-width=\"3\"");
        }
        svg.text((LEFT + 0.5 * size.0, TOP + size.1 + 42.0), Anchor::Middle, "", &self.x);
        svg.text_up((20.0, TOP + 0.5 * size.1), &self.y);
        let right = LEFT + size.0 + 18.0;
        let seen = |l: &&(&str, &str, &str)| self.states.iter().flatten().any(|s| s == l.0);
        let styles: Vec<_> = STATE_STYLES.iter().filter(seen).collect();
        for (i, style) in styles.iter().enumerate() {
            let y = TOP + 24.0 * i as f64;
            svg.rect((right, y), (26.0, 18.0), &format!("fill=\"{}\"", style.1));
            svg.text((right + 13.0, y + 13.0), Anchor::Middle, "fill=\"#333\"", style.2);
            svg.text((right + 34.0, y + 13.0), Anchor::Start, "", style.0);
        }
        if self.predicted.iter().any(Option::is_some) {
            let y = TOP + 24.0 * styles.len() as f64 + 9.0;
            svg.line((right, y), (right + 26.0, y), "stroke=\"#000\" stroke-width=\"3\"");
            svg.text((right + 34.0, y + 4.0), Anchor::Start, "", "predicted limit");
        }
        svg.finish()
    }

    /// Height of a value among the rows, in cells from below: the middle of a row is its value, between them the scale is logarithmic.
    fn place(&self, value: f64) -> Option<f64> {
        let logs: Vec<f64> = self.rows.iter().map(|r| r.ln()).collect();
        let (first, last) = (*logs.first()?, *logs.last()?);
        let spacing = (last - first) / (logs.len().max(2) - 1) as f64;
        let at = (value.ln() - first) / spacing + 0.5;
        (0.0..=logs.len() as f64).contains(&at).then_some(at)
    }
}
