//! Pictures of a ball of a material, by which a surface is shaded: the normal as seen by the viewer is the place in the picture.

/// Pixels along an edge.
pub(super) const SIZE: usize = 128;

/// A ball under two lights.
struct Ball {
    /// Colours, red, green, blue: in the shade, lit, and of the highlight.
    shade: [f32; 3],
    lit: [f32; 3],
    highlight: [f32; 3],
    /// Sharpness of the highlight.
    gloss: i32,
    /// Brightness of the rim.
    rim: f32,
}

const CLAY: Ball =
    Ball { shade: [0.24, 0.15, 0.12], lit: [0.80, 0.58, 0.47], highlight: [0.18, 0.16, 0.14], gloss: 12, rim: 0.10 };
const METAL: Ball =
    Ball { shade: [0.06, 0.07, 0.09], lit: [0.52, 0.55, 0.60], highlight: [0.75, 0.76, 0.78], gloss: 40, rim: 0.55 };
const WAX: Ball =
    Ball { shade: [0.45, 0.29, 0.22], lit: [0.93, 0.83, 0.70], highlight: [0.30, 0.29, 0.26], gloss: 28, rim: 0.28 };

/// The pictures one under the other, clay, metal, wax (3 * SIZE x SIZE x 4 bytes), from the lowest row.
pub(super) fn pictures() -> Vec<u8> {
    [CLAY, METAL, WAX].iter().flat_map(picture).collect()
}

fn picture(ball: &Ball) -> Vec<u8> {
    let mut pixels = Vec::with_capacity(SIZE * SIZE * 4);
    for row in 0..SIZE {
        for column in 0..SIZE {
            let across = |pixel: usize| (pixel as f32 + 0.5) / SIZE as f32 * 2.0 - 1.0;
            let (x, y) = (across(column), across(row));
            // Outside of the ball its edge goes on, for normals that point a little away.
            let length = x.hypot(y).max(1e-6);
            let inside = length.min(0.999) / length;
            let (x, y) = (x * inside, y * inside);
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            pixels.extend(shade(ball, [x, y, z]));
        }
    }
    pixels
}

fn shade(ball: &Ball, normal: [f32; 3]) -> [u8; 4] {
    let dot = |a: [f32; 3]| a[0] * normal[0] + a[1] * normal[1] + a[2] * normal[2];
    let (key, fill) = (dot([-0.42, 0.62, 0.66]), dot([0.72, -0.10, 0.68]));
    let light = (0.5 + 0.5 * key).powi(2) * 0.85 + 0.25 * fill.max(0.0);
    let highlight = dot([-0.25, 0.37, 0.895]).max(0.0).powi(ball.gloss);
    let rim = ball.rim * (1.0 - normal[2]).powi(4);
    let colour = |c: usize| {
        let base = ball.shade[c] + (ball.lit[c] - ball.shade[c]) * light.min(1.0);
        ((base + highlight * ball.highlight[c] + rim).clamp(0.0, 1.0) * 255.0) as u8
    };
    [colour(0), colour(1), colour(2), 255]
}
