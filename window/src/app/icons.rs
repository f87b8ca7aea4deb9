//! Signs of the tools: lines in a square, for the fonts have none.

use eframe::egui::{self, Pos2, Sense, Shape, Stroke, vec2};

/// Points of a line in the unit square, from the upper left.
type Polyline = &'static [[f32; 2]];

/// Side of a sign, points.
const SIDE: f32 = 16.0;

/// Draws the sign of a tool at the present place of a panel.
pub(super) fn show(ui: &mut egui::Ui, tool: &str) {
    let (rect, _) = ui.allocate_exact_size(vec2(SIDE, SIDE), Sense::hover());
    let stroke = Stroke::new(1.4, ui.visuals().text_color());
    let place = |[x, y]: &[f32; 2]| rect.min + SIDE * vec2(*x, *y);
    for line in lines(tool) {
        ui.painter().add(Shape::line(line.iter().map(place).collect::<Vec<Pos2>>(), stroke));
    }
}

/// The lines of a tool's sign; a ring for a tool that has none of its own.
fn lines(tool: &str) -> &'static [Polyline] {
    match tool {
        "touch" => &[&[[0.0, 0.6], [0.3, 0.6], [0.5, 0.9], [0.7, 0.6], [1.0, 0.6]], &[[0.5, 0.05], [0.5, 0.65]]],
        "pull" => &[
            &[[0.0, 0.9], [0.3, 0.9], [0.5, 0.45], [0.7, 0.9], [1.0, 0.9]],
            &[[0.35, 0.2], [0.5, 0.05], [0.65, 0.2]],
            &[[0.5, 0.05], [0.5, 0.4]],
        ],
        "cut" => &[&[[0.1, 0.95], [0.9, 0.05]], &[[0.0, 0.5], [0.35, 0.5]], &[[0.65, 0.5], [1.0, 0.5]]],
        "grab" => &[
            &[[0.5, 0.05], [0.5, 0.95]],
            &[[0.05, 0.5], [0.95, 0.5]],
            &[[0.38, 0.17], [0.5, 0.05], [0.62, 0.17]],
            &[[0.83, 0.38], [0.95, 0.5], [0.83, 0.62]],
        ],
        "inflate" => &[&[[0.0, 0.8], [0.2, 0.8], [0.3, 0.4], [0.5, 0.25], [0.7, 0.4], [0.8, 0.8], [1.0, 0.8]]],
        "deflate" => &[&[[0.0, 0.2], [0.2, 0.2], [0.3, 0.6], [0.5, 0.75], [0.7, 0.6], [0.8, 0.2], [1.0, 0.2]]],
        "smooth" => &[
            &[[0.0, 0.3], [0.15, 0.1], [0.3, 0.5], [0.45, 0.2], [0.6, 0.4], [0.75, 0.3], [1.0, 0.3]],
            &[[0.0, 0.8], [1.0, 0.8]],
        ],
        "flatten" => &[&[[0.0, 0.85], [1.0, 0.85]], &[[0.3, 0.1], [0.3, 0.6]], &[[0.7, 0.1], [0.7, 0.6]]],
        "pinch" => &[
            &[[0.5, 0.05], [0.5, 0.95]],
            &[[0.05, 0.3], [0.3, 0.5], [0.05, 0.7]],
            &[[0.95, 0.3], [0.7, 0.5], [0.95, 0.7]],
        ],
        "relax" => &[&[[0.0, 0.1], [0.1, 0.45], [0.25, 0.7], [0.5, 0.85], [1.0, 0.9]]],
        "grow" => &[&[[0.5, 0.1], [0.5, 0.9]], &[[0.1, 0.5], [0.9, 0.5]]],
        "shrink" => &[&[[0.1, 0.5], [0.9, 0.5]]],
        "pin" => &[
            &[[0.3, 0.05], [0.7, 0.05], [0.7, 0.5], [0.85, 0.6], [0.15, 0.6], [0.3, 0.5], [0.3, 0.05]],
            &[[0.5, 0.6], [0.5, 1.0]],
        ],
        "unpin" => &[
            &[[0.3, 0.05], [0.7, 0.05], [0.7, 0.5], [0.85, 0.6], [0.15, 0.6], [0.3, 0.5], [0.3, 0.05]],
            &[[0.5, 0.6], [0.5, 1.0]],
            &[[0.0, 1.0], [1.0, 0.0]],
        ],
        "paint" => {
            &[&[[0.95, 0.05], [0.45, 0.55]], &[[0.45, 0.55], [0.3, 0.6], [0.05, 0.95], [0.4, 0.75], [0.45, 0.55]]]
        }
        "stitch" => &[
            &[[0.0, 0.5], [1.0, 0.5]],
            &[[0.1, 0.2], [0.3, 0.8]],
            &[[0.4, 0.2], [0.6, 0.8]],
            &[[0.7, 0.2], [0.9, 0.8]],
        ],
        _ => OTHER,
    }
}

/// The sign of a tool without one.
const OTHER: &[Polyline] = &[&[[0.5, 0.1], [0.9, 0.5], [0.5, 0.9], [0.1, 0.5], [0.5, 0.1]]];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::ToolKind;

    #[test]
    fn every_tool_has_a_sign_of_its_own_within_the_square() {
        let all: Vec<&[Polyline]> = ToolKind::all().iter().map(|tool| lines(tool.name())).collect();
        for (i, sign) in all.iter().enumerate() {
            assert!(*sign != OTHER && !all[..i].contains(sign), "tool {i}");
            assert!(sign.iter().flat_map(|line| line.iter()).flatten().all(|c| (0.0..=1.0).contains(c)));
        }
    }
}
