//! Strips of cloth with four patterns of triangles.

use pliant_plugin_api::kit::{Random, Sheet};

/// How a strip is triangulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// Squares, all divided by the same diagonal.
    Regular,
    /// Squares divided by alternating diagonals.
    Alternating,
    /// Equilateral triangles; half of one at the ends of every second row.
    Equilateral,
    /// Squares with their vertices displaced at random, divided by the shorter diagonal.
    Irregular,
}

/// Every pattern of triangles, for tests that hold for each.
pub const PATTERNS: [Pattern; 4] = [Pattern::Regular, Pattern::Alternating, Pattern::Equilateral, Pattern::Irregular];

/// Width of a strip of length 1 m, m; rounded to whole rows of triangles.
pub const WIDTH: f64 = 0.25;

/// A strip of length 1 m along x, with `cells` cells along it.
pub fn strip(pattern: Pattern, cells: usize) -> Sheet {
    let h = 1.0 / cells as f64;
    let height = if pattern == Pattern::Equilateral { 0.75_f64.sqrt() * h } else { h };
    let rows = (WIDTH / height).round().max(1.0) as usize;
    let mut random = Random(7);
    let (mut rest, mut rows_of_nodes) = (Vec::new(), Vec::new());
    for j in 0..=rows {
        let shift = if pattern == Pattern::Equilateral && j % 2 == 1 { 0.5 } else { 0.0 };
        let mut xs: Vec<f64> = (0..=cells).map(|i| (i as f64 + shift) * h).collect();
        if shift > 0.0 {
            xs.insert(0, 0.0);
            xs.truncate(cells + 1);
            xs.push(1.0);
        }
        let first = rest.len() as u32;
        for (i, x) in xs.iter().enumerate() {
            let (is_end, is_side) = (i == 0 || i + 1 == xs.len(), j == 0 || j == rows);
            let jitter = if pattern == Pattern::Irregular { 0.3 * h } else { 0.0 };
            let (dx, dy) = (jitter * random.signed(), jitter * random.signed());
            let dx = if is_end { 0.0 } else { dx };
            let dy = if is_end || is_side { 0.0 } else { dy };
            rest.push([x + dx, j as f64 * height + dy, 0.0]);
        }
        rows_of_nodes.push(first..rest.len() as u32);
    }
    let mut triangles = Vec::new();
    for (j, rows) in rows_of_nodes.windows(2).enumerate() {
        let (lower, upper) = (&rows[0], &rows[1]);
        // The edge from a to b advances along the two rows; each triangle moves one of its ends.
        let (mut a, mut b) = (lower.start, upper.start);
        while a + 1 < lower.end || b + 1 < upper.end {
            let squared_distance = |p: u32, q: u32| {
                let (p, q) = (rest[p as usize], rest[q as usize]);
                (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)
            };
            let moves_a = if b + 1 == upper.end {
                true
            } else if a + 1 == lower.end {
                false
            } else {
                let (column_a, column_b) = (a - lower.start, b - upper.start);
                match pattern {
                    Pattern::Regular => column_a != column_b,
                    Pattern::Alternating if column_a == column_b => (column_a + j as u32).is_multiple_of(2),
                    Pattern::Alternating => column_a < column_b,
                    Pattern::Equilateral | Pattern::Irregular => {
                        squared_distance(a + 1, b) <= squared_distance(a, b + 1)
                    }
                }
            };
            if moves_a {
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
