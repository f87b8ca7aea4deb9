//! What is drawn over the picture: the ring of the tool, the force on the hand, a scale bar.

use super::Camera;
use crate::strings;
use eframe::egui::{Align, Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Vec2, pos2, vec2};
use nalgebra::{Point3, Vector3};
use pliant_editor::format_length;

/// The part of the screen that shows the scene, and what sees it.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    /// In points of the screen.
    pub rect: Rect,
    /// What sees it.
    pub camera: &'a Camera,
}

impl Frame<'_> {
    /// Width over height.
    pub fn aspect(&self) -> f64 {
        f64::from(self.rect.width() / self.rect.height().max(1.0))
    }

    /// Where a point of the scene (m) is on the screen; `None` behind the viewer.
    pub fn to_screen(&self, point: &Point3<f64>) -> Option<Pos2> {
        let ([x, y], _) = self.camera.project(point, self.aspect())?;
        let across = self.rect.width() * (0.5 + 0.5 * x as f32);
        let down = self.rect.height() * (0.5 - 0.5 * y as f32);
        Some(self.rect.min + vec2(across, down))
    }

    /// The place of the picture at a point of the screen: -1 to 1 from left to right and from bottom to top.
    pub fn place(&self, at: Pos2) -> [f64; 2] {
        let from = at - self.rect.min;
        let x = f64::from(from.x / self.rect.width().max(1.0)) * 2.0 - 1.0;
        let y = 1.0 - f64::from(from.y / self.rect.height().max(1.0)) * 2.0;
        [x, y]
    }
}

/// Points of a ring.
const RING_POINTS: usize = 48;

/// A ring of a radius (m) around a point of the surface, and a line along its normal.
pub fn ring(
    painter: &Painter,
    frame: Frame<'_>,
    centre: Point3<f64>,
    normal: Vector3<f64>,
    radius: f64,
    colour: Color32,
) {
    let aside = if normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let u = normal.cross(&aside).normalize();
    let v = normal.cross(&u);
    let mut points = Vec::with_capacity(RING_POINTS + 1);
    for turn in 0..=RING_POINTS {
        let (s, c) = (turn as f64 * std::f64::consts::TAU / RING_POINTS as f64).sin_cos();
        // Lifted a little, so that the ring is seen over a bulge.
        points.extend(frame.to_screen(&(centre + radius * (c * u + s * v) + 0.02 * radius * normal)));
    }
    painter.line(points.clone(), Stroke::new(3.5, Color32::from_black_alpha(110)));
    painter.line(points, Stroke::new(1.6, colour));
    let ends = [frame.to_screen(&centre), frame.to_screen(&(centre + 0.6 * radius * normal))];
    if let [Some(from), Some(to)] = ends {
        painter.line_segment([from, to], Stroke::new(1.2, colour));
    }
}

/// Points of the screen of a dot where a tool touches without a share of the force, and more with all of it.
const DOT: [f32; 2] = [1.8, 1.8];

/// Dots where tools touch (m), larger with a larger share of the force.
pub fn contact_points(painter: &Painter, frame: Frame<'_>, contacts: impl Iterator<Item = (Point3<f64>, f64)>) {
    for (place, share) in contacts {
        let Some(at) = frame.to_screen(&place) else { continue };
        let radius = DOT[0] + DOT[1] * share.clamp(0.0, 1.0) as f32;
        painter.circle_filled(at, radius + 1.2, Color32::from_black_alpha(150));
        painter.circle_filled(at, radius, Color32::from_rgb(255, 235, 190));
    }
}

/// The edge of a blade (m), its end in the hand marked.
pub fn blade(painter: &Painter, frame: Frame<'_>, ends: [Point3<f64>; 2]) {
    let [Some(hand), Some(heel)] = ends.map(|end| frame.to_screen(&end)) else { return };
    painter.line_segment([hand, heel], Stroke::new(4.5, Color32::from_black_alpha(130)));
    painter.line_segment([hand, heel], Stroke::new(2.2, Color32::from_rgb(225, 230, 235)));
    painter.circle_filled(hand, 3.0, Color32::from_rgb(255, 110, 90));
}

/// Points of the screen that the arrow of an endless force would have.
const LONGEST_ARROW: f32 = 170.0;
/// Points of the screen between the tip of an arrow and its number.
const LABEL_GAP: f32 = 10.0;
/// Points of the screen below which an arrow is not drawn.
const SHORTEST_ARROW: f32 = 2.0;

/// The force on the hand (N) as an arrow that ends in the hand, with its number. `usual` (N) is drawn half as long as an endless one.
pub fn force_arrow(painter: &Painter, frame: Frame<'_>, hand: Point3<f64>, force: Vector3<f64>, usual: f64) {
    let size = force.norm();
    let Some(at) = frame.to_screen(&hand) else { return };
    let length = LONGEST_ARROW * (size / (size + usual.max(1e-12))) as f32;
    let ahead = hand + force * (0.2 * frame.camera.distance / size.max(1e-12));
    let Some(towards) = frame.to_screen(&ahead) else { return };
    let colour = Color32::from_rgb(255, 170, 40);
    // Beyond the tip, so that the number lies beside the arrow whatever way that points.
    let label = |tip: Pos2, direction: Vec2| {
        let text = format_force(size);
        let place = tip + direction * LABEL_GAP;
        let side = |along: f32| {
            if along < -0.4 {
                Align::Max
            } else if along > 0.4 {
                Align::Min
            } else {
                Align::Center
            }
        };
        let anchor = Align2([side(direction.x), side(direction.y)]);
        let font = FontId::proportional(16.0);
        painter.text(place + Vec2::splat(1.0), anchor, &text, font.clone(), Color32::from_black_alpha(200));
        painter.text(place, anchor, &text, font, colour);
    };
    if size <= 0.0 || length < SHORTEST_ARROW {
        return;
    }
    // A force along the line of sight is short on the screen, as its direction is.
    let direction = towards - at;
    let flat = (direction.length() / (0.2 * frame.rect.height())).min(1.0);
    let direction = if direction.length() > 0.5 { direction.normalized() } else { vec2(0.0, -1.0) };
    let length = length * flat.max(0.45);
    let tip = at + direction * length;
    for (stroke, tint) in [(7.0, Color32::from_black_alpha(140)), (4.0, colour)] {
        painter.line_segment([at, tip], Stroke::new(stroke, tint));
        let side = direction.rot90();
        let head = 11.0;
        for turn in [side, -side] {
            painter.line_segment([tip, tip - direction * head + turn * head * 0.6], Stroke::new(stroke, tint));
        }
    }
    painter.circle_filled(at, 5.0, colour);
    label(tip, direction);
}

/// A force for people: three digits, in the unit that reads best.
pub fn format_force(newtons: f64) -> String {
    if newtons >= 99.5 {
        strings::newtons(newtons, 0)
    } else if newtons >= 9.95 {
        strings::newtons(newtons, 1)
    } else if newtons >= 0.0995 || newtons == 0.0 {
        strings::newtons(newtons, 2)
    } else if newtons >= 0.995e-4 {
        strings::millinewtons(newtons)
    } else {
        strings::micronewtons(newtons)
    }
}

/// m, a round length (1, 2 or 5 times a power of ten) of at most `most` metres
pub fn round_length(most: f64) -> f64 {
    let decade = 10_f64.powf(most.max(1e-12).log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|digit| digit * decade).find(|length| *length <= most).unwrap_or(decade)
}

/// A bar of a round length, as long as it is at the depth the camera looks at.
pub fn scale_bar(painter: &Painter, frame: Frame<'_>, colour: Color32) {
    let metres_per_point = frame.camera.metres_per_pixel(f64::from(frame.rect.height()));
    let length = round_length(140.0 * metres_per_point);
    let width = (length / metres_per_point) as f32;
    let left = frame.rect.left_bottom() + vec2(16.0, -18.0);
    let stroke = Stroke::new(1.5, colour);
    painter.line_segment([left, left + vec2(width, 0.0)], stroke);
    for end in [0.0, width] {
        painter.line_segment([left + vec2(end, -4.0), left + vec2(end, 4.0)], stroke);
    }
    let middle = pos2(left.x + 0.5 * width, left.y - 5.0);
    painter.text(middle, Align2::CENTER_BOTTOM, format_length(length), FontId::proportional(13.0), colour);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_scale_bars_are_round_and_fit() {
        for (most, length) in [(0.14, 0.1), (0.06, 0.05), (0.003, 0.002), (9.0, 5.0), (1.0, 1.0)] {
            assert!((round_length(most) / length - 1.0).abs() < 1e-9, "{most}");
        }
        assert_eq!(format_force(614.4), "614 N");
        assert_eq!(format_force(12.34), "12.3 N");
        assert_eq!(format_force(1.234), "1.23 N");
        assert_eq!(format_force(0.0567), "56.7 mN");
        assert_eq!(format_force(0.0), "0.00 N");
    }

    #[test]
    fn a_place_of_the_screen_and_the_scene_are_each_others_inverse() {
        let camera = Camera::default();
        let rect = Rect::from_min_size(pos2(30.0, 50.0), vec2(640.0, 480.0));
        let frame = Frame { rect, camera: &camera };
        for at in [pos2(100.0, 90.0), pos2(350.0, 290.0), pos2(600.0, 500.0)] {
            let ray = camera.ray(frame.place(at), frame.aspect());
            let seen = frame.to_screen(&(ray.origin + 0.3 * ray.direction)).unwrap();
            assert!(seen.distance(at) < 0.01, "{at:?} {seen:?}");
        }
    }
}
