//! Heat maps: a number over two parameters, as colour.

use super::svg::{Anchor, Svg, format_short};

/// A number for every pair of values of two parameters.
#[derive(Clone, Debug, Default)]
pub struct HeatMap {
    /// Title above the picture: name and unit of the numbers.
    pub title: String,
    /// Name and unit of the horizontal parameter.
    pub x: String,
    /// Name and unit of the vertical parameter.
    pub y: String,
    /// Values of the horizontal parameter, ascending (c).
    pub columns: Vec<f64>,
    /// Values of the vertical parameter from below, as texts (r).
    pub rows: Vec<String>,
    /// Number in each row and column (r x c); `None` where there is none.
    pub values: Vec<Vec<Option<f64>>>,
}

/// Colours from the smallest number to the largest: evenly spaced samples of viridis (van der Walt and Smith 2015), whose lightness rises
/// evenly.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 44.0, 122.0],
    [59.0, 81.0, 139.0],
    [44.0, 113.0, 142.0],
    [33.0, 144.0, 141.0],
    [39.0, 173.0, 129.0],
    [92.0, 200.0, 99.0],
    [170.0, 220.0, 50.0],
    [253.0, 231.0, 37.0],
];
/// px, left margin
const LEFT: f64 = 90.0;
/// px, upper margin
const TOP: f64 = 40.0;
/// px, width and height of all cells
const SIZE: (f64, f64) = (460.0, 320.0);
/// Most labels along an axis.
const LABELS: usize = 12;
/// Steps of the scale of colours beside the picture.
const STEPS: usize = 40;

impl HeatMap {
    /// The picture as SVG.
    pub fn svg(&self) -> String {
        let (wide, high) = (SIZE.0 / self.columns.len() as f64, SIZE.1 / self.rows.len() as f64);
        let mut svg = Svg::new(LEFT + SIZE.0 + 130.0, TOP + SIZE.1 + 62.0, &self.title);
        let seen = self.values.iter().flatten().flatten().copied().filter(|v| v.is_finite());
        let (low, most) = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let share = |value: f64| if most > low { (value - low) / (most - low) } else { 0.5 };
        for (r, row) in self.values.iter().enumerate() {
            for (c, value) in row.iter().enumerate() {
                let at = (LEFT + wide * c as f64, TOP + SIZE.1 - high * (r + 1) as f64);
                let fill = value.filter(|v| v.is_finite()).map_or("#eeeeee".into(), |value| colour(share(value)));
                svg.rect(at, (wide, high), &format!("fill=\"{fill}\""));
            }
        }
        for c in (0..self.columns.len()).step_by(self.columns.len().div_ceil(LABELS)) {
            let at = (LEFT + wide * (c as f64 + 0.5), TOP + SIZE.1 + 17.0);
            svg.text(at, Anchor::Middle, "", &format_short(self.columns[c]));
        }
        for r in (0..self.rows.len()).step_by(self.rows.len().div_ceil(LABELS)) {
            let at = (LEFT - 7.0, TOP + SIZE.1 - high * (r as f64 + 0.5) + 4.0);
            svg.text(at, Anchor::End, "", &self.rows[r]);
        }
        svg.text((LEFT + 0.5 * SIZE.0, TOP + SIZE.1 + 42.0), Anchor::Middle, "", &self.x);
        svg.text_up((20.0, TOP + 0.5 * SIZE.1), &self.y);
        let (right, step) = (LEFT + SIZE.0 + 18.0, SIZE.1 / STEPS as f64);
        for i in 0..STEPS {
            let at = (right, TOP + SIZE.1 - step * (i + 1) as f64);
            svg.rect(at, (18.0, step + 0.5), &format!("fill=\"{}\"", colour((i as f64 + 0.5) / STEPS as f64)));
        }
        for (value, y) in [(low, TOP + SIZE.1), (0.5 * (low + most), TOP + 0.5 * SIZE.1), (most, TOP)] {
            svg.text((right + 25.0, y + 4.0), Anchor::Start, "", &format_short(value));
        }
        svg.finish()
    }
}

/// The colour at a share of the scale, 0 to 1.
fn colour(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let (i, rest) = ((at as usize).min(VIRIDIS.len() - 2), at - (at as usize).min(VIRIDIS.len() - 2) as f64);
    let [r, g, b] = [0, 1, 2].map(|c| (VIRIDIS[i][c] + rest * (VIRIDIS[i + 1][c] - VIRIDIS[i][c])).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_and_the_largest_number_have_the_ends_of_the_scale() {
        let map = HeatMap {
            title: "force (N)".into(),
            columns: vec![1.0, 2.0],
            rows: vec!["a".into(), "b".into()],
            values: vec![vec![Some(-3.0), None], vec![Some(0.0), Some(7.0)]],
            ..HeatMap::default()
        };
        let svg = map.svg();
        for part in ["#440154", "#fde725", "#eeeeee", ">7<", ">-3<", "force (N)"] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(colour(0.5), "#21908d");
    }
}
