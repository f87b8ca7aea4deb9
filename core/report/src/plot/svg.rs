//! Shapes and texts of an SVG picture, and short numbers.

use crate::xml::escape;
use std::fmt::Write;

/// An SVG figure in progress. Lengths are in pixels, y points down.
pub(crate) struct Svg {
    text: String,
}

/// Which point of a text is at its position.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    /// The text begins at the place.
    Start,
    /// The text is centred at the place.
    Middle,
    /// The text ends at the place.
    End,
}

/// Colours that are distinguishable with colour blindness (Okabe and Ito 2008), without the yellow.
pub(crate) const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#444444"];

impl Svg {
    /// An empty picture with a title.
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Self {
        let mut text = String::new();
        let _ = write!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" role=\"img\">\
             <title>{}</title><rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>",
            escape(title)
        );
        let mut svg = Self { text };
        svg.text((16.0, 22.0), Anchor::Start, "font-size=\"14\" font-weight=\"bold\"", title);
        svg
    }

    /// Adds a line from `a` to `b`.
    pub(crate) fn line(&mut self, a: (f64, f64), b: (f64, f64), style: &str) {
        let _ = write!(self.text, "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" {style}/>", a.0, a.1, b.0, b.1);
    }

    /// Adds lines through points.
    pub(crate) fn polyline(&mut self, points: &[(f64, f64)], style: &str) {
        let places: Vec<String> = points.iter().map(|p| format!("{:.1},{:.1}", p.0, p.1)).collect();
        let _ = write!(self.text, "<polyline points=\"{}\" fill=\"none\" {style}/>", places.join(" "));
    }

    /// Adds a rectangle with its upper left corner at `at`.
    pub(crate) fn rect(&mut self, at: (f64, f64), size: (f64, f64), style: &str) {
        let (x, y, w, h) = (at.0, at.1, size.0, size.1);
        let _ = write!(self.text, "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" {style}/>");
    }

    /// Adds the mark of the `i`-th curve: its shape changes where the colours repeat.
    pub(crate) fn mark(&mut self, at: (f64, f64), i: usize, colour: &str, large: bool) {
        let ((x, y), r) = (at, if large { 5.5 } else { 3.5 });
        let ring = if large { "stroke=\"#000\" stroke-width=\"1.5\"" } else { "" };
        let shape = match i / COLOURS.len() % 3 {
            0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\""),
            1 => format!("<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{}\" height=\"{}\"", x - r, y - r, 2.0 * r, 2.0 * r),
            _ => format!("<path d=\"M{:.1} {:.1}l{r} {}h-{}z\"", x, y - r, 2.0 * r, 2.0 * r),
        };
        let _ = write!(self.text, "{shape} fill=\"{colour}\" {ring}/>");
    }

    /// Adds a text.
    pub(crate) fn text(&mut self, at: (f64, f64), anchor: Anchor, style: &str, words: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y) = at;
        let _ = write!(
            self.text,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" {style}>{}</text>",
            escape(words)
        );
    }

    /// Adds a text that runs upwards.
    pub(crate) fn text_up(&mut self, (x, y): (f64, f64), words: &str) {
        let words = escape(words);
        let _ = write!(
            self.text,
            "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" text-anchor=\"middle\">{words}</text>"
        );
    }

    /// The picture as a text.
    pub(crate) fn finish(mut self) -> String {
        self.text.push_str("</svg>");
        self.text
    }
}

/// A number with three significant digits, or two in scientific notation outside of 0.01 to 10 000.
pub(crate) fn format_short(value: f64) -> String {
    let size = value.abs();
    match size {
        0.0 => "0".into(),
        s if !s.is_finite() => "-".into(),
        s if (1e-2..1e4).contains(&s) => {
            let digits = (2 - s.log10().floor() as i32).max(0) as usize;
            let text = format!("{value:.digits$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
        }
        _ => {
            let text = format!("{value:.1e}");
            text.replace(".0e", "e")
        }
    }
}
