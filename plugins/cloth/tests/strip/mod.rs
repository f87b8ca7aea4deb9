//! A strip of cloth in four patterns of triangles.

use pliant_plugin_api::kit::Sheet;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    Regular,
    Alternating,
    Equilateral,
    Irregular,
}

pub const PATTERNS: [Pattern; 4] = [Pattern::Regular, Pattern::Alternating, Pattern::Equilateral, Pattern::Irregular];

/// m, of strips of length 1
pub const WIDTH: f64 = 0.25;

/// A strip along x, `cells` long.
pub fn strip(pattern: Pattern, cells: usize) -> Sheet {
    let h = 1.0 / cells as f64;
    let height = if pattern == Pattern::Equilateral { 0.75_f64.sqrt() * h } else { h };
    let rows = (WIDTH / height).round().max(1.0) as usize;
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let (mut rest, mut chains) = (Vec::new(), Vec::new());
    for j in 0..=rows {
        let shift = if pattern == Pattern::Equilateral && j % 2 == 1 { 0.5 } else { 0.0 };
        let mut along: Vec<f64> = (0..=cells).map(|i| (i as f64 + shift) * h).collect();
        if shift > 0.0 {
            along.insert(0, 0.0);
            along.truncate(cells + 1);
            along.push(1.0);
        }
        let first = rest.len() as u32;
        for (i, x) in along.iter().enumerate() {
            let (end, side) = (i == 0 || i + 1 == along.len(), j == 0 || j == rows);
            let jitter = if pattern == Pattern::Irregular { 0.3 * h } else { 0.0 };
            let (dx, dy) = (jitter * random(), jitter * random());
            rest.push([x + if end { 0.0 } else { dx }, j as f64 * height + if end || side { 0.0 } else { dy }, 0.0]);
        }
        chains.push(first..rest.len() as u32);
    }
    let mut triangles = Vec::new();
    for (j, pair) in chains.windows(2).enumerate() {
        let (mut a, mut b) = (pair[0].start, pair[1].start);
        while a + 1 < pair[0].end || b + 1 < pair[1].end {
            let gap = |p: u32, q: u32| {
                let (p, q) = (rest[p as usize], rest[q as usize]);
                (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)
            };
            let below = if b + 1 == pair[1].end {
                true
            } else if a + 1 == pair[0].end {
                false
            } else {
                let (step_below, step_above) = (gap(a + 1, b), gap(a, b + 1));
                let square = (a - pair[0].start) == (b - pair[1].start);
                match pattern {
                    Pattern::Regular => !square,
                    Pattern::Alternating if square => (a - pair[0].start + j as u32).is_multiple_of(2),
                    Pattern::Alternating => a - pair[0].start < b - pair[1].start,
                    _ => step_below <= step_above,
                }
            };
            if below {
                triangles.push([a, a + 1, b]);
                a += 1;
            } else {
                triangles.push([a, b + 1, b]);
                b += 1;
            }
        }
    }
    Sheet::new(rest, &triangles)
}
