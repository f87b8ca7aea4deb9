//! Generators of flat sheets.

use super::{Model, need_cells, need_length};
use crate::geometry::Vec3;
use crate::{MeshError, ObjDocument};

/// Triangulation of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// All diagonals lead from the lower left to the upper right.
    Regular,
    /// Diagonals alternate from cell to cell, like the fields of a chessboard.
    Alternating,
    /// Every second row is moved by half a cell; half triangles keep the sides straight. With
    /// [`equilateral_rows`] rows all other triangles are equilateral, or as near as whole rows allow.
    Equilateral,
    /// Regular, with every interior vertex displaced pseudo-randomly by up to a quarter of a cell along each axis; the same in every run.
    Irregular,
}

/// A sheet of `cells` (columns, rows) and `size` (width, height in m) in the plane z = 0, its lower left corner in
/// the origin, of triangles.
///
/// Vertices go row by row from y = 0 up, x increasing within a row. A row has columns + 1 vertices; in the equilateral
/// pattern every second row, the one at y = 0 not among them, has columns + 2.
///
/// # Errors
/// [`MeshError::Parameter`] if cells are not 1 to 4096 or a size is not finite and above 0.
pub fn grid(cells: [u32; 2], size: [f64; 2], pattern: Pattern) -> Result<ObjDocument, MeshError> {
    let [columns, rows] = cells;
    need_cells("columns", columns, 1)?;
    need_cells("rows", rows, 1)?;
    need_length("width", size[0])?;
    need_length("height", size[1])?;
    let mut model = Model::default();
    let mut starts = Vec::new(); // first vertex of each row
    for row in 0..=rows {
        starts.push(model.points.len() as u32);
        let moved = pattern == Pattern::Equilateral && row % 2 == 1;
        let v = f64::from(row) / f64::from(rows);
        for column in 0..=columns + u32::from(moved) {
            let at = if moved { f64::from(column) - 0.5 } else { f64::from(column) };
            let inside = row > 0 && row < rows && column > 0 && column < columns;
            let [du, dv] = if pattern == Pattern::Irregular && inside { jitter(row, column) } else { [0.0; 2] };
            let u = (at + du).clamp(0.0, f64::from(columns)) / f64::from(columns);
            let v = v + dv / f64::from(rows);
            model.points.push(Vec3::new(u * size[0], v * size[1], 0.0));
            model.texcoords.push([u, v]);
        }
    }
    for row in 0..rows {
        let (low, high) = (starts[row as usize], starts[row as usize + 1]);
        match pattern {
            Pattern::Equilateral => equilateral_row(&mut model, columns, low, high, row % 2 == 1),
            Pattern::Regular | Pattern::Alternating | Pattern::Irregular => {
                for column in 0..columns {
                    let [a, b, d, c] = [low + column, low + column + 1, high + column, high + column + 1];
                    let falling = pattern == Pattern::Alternating && (row + column) % 2 == 1;
                    let halves = if falling { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
                    for half in halves {
                        model.face(&half.map(|vertex| [vertex, vertex]));
                    }
                }
            }
        }
    }
    model.into_document("grid")
}

/// A narrow [`grid`] of alternating pattern: `cells` along its `length` (m, in x), and as many across its `width`
/// (m, in y) as make them most nearly square.
///
/// # Errors
/// Those of [`grid`].
pub fn strip(cells: u32, length: f64, width: f64) -> Result<ObjDocument, MeshError> {
    need_length("length", length)?;
    let across = (f64::from(cells) * width / length).round().max(1.0) as u32;
    grid([cells, across], [length, width], Pattern::Alternating)
}

/// The number of rows, 1 at least, that makes the triangles of an equilateral sheet of `columns` and `size` (m)
/// most nearly equilateral.
pub fn equilateral_rows(columns: u32, size: [f64; 2]) -> u32 {
    let height = 0.75_f64.sqrt() * size[0] / f64::from(columns);
    (size[1] / height).round().max(1.0) as u32
}

/// Adds the row of triangles between the vertex rows `low` and `high`. The upper one has an additional vertex, or the lower one if `turned` is set.
fn equilateral_row(model: &mut Model, columns: u32, low: u32, high: u32, turned: bool) {
    let (short, long) = if turned { (high, low) } else { (low, high) };
    let mut face = |[a, b, c]: [u32; 3]| {
        let corners = if turned { [a, c, b] } else { [a, b, c] };
        model.face(&corners.map(|vertex| [vertex, vertex]));
    };
    for column in 0..=columns {
        face([short + column, long + column + 1, long + column]);
        if column < columns {
            face([short + column, short + column + 1, long + column + 1]);
        }
    }
}

/// Displacement of up to a quarter of a cell along each axis, as a hash of row and column.
fn jitter(row: u32, column: u32) -> [f64; 2] {
    let mut seed = u64::from(row) << 32 | u64::from(column) | 1 << 63;
    [(); 2].map(|()| {
        seed = (seed ^ seed >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        seed ^= seed >> 29;
        0.5 * ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Surface, check};

    #[test]
    fn every_pattern_covers_its_rectangle_once() {
        for pattern in [Pattern::Regular, Pattern::Alternating, Pattern::Equilateral] {
            let document = grid([7, 5], [0.7, 0.4], pattern).unwrap();
            let surface = Surface::from_document(&document);
            let edges = surface.edges();
            assert!((surface.areas().iter().sum::<f64>() - 0.28).abs() < 1e-14, "{pattern:?}");
            assert_eq!(surface.points.len() + surface.triangles.len(), edges.len() + 1, "a disc has Euler number 1");
            assert!(surface.vertex_normals().iter().all(|normal| normal[2] == 1.0), "{pattern:?}");
            let findings = check(&surface, &document);
            assert_eq!(findings.len(), 1, "only a border: {findings:?}");
            assert!(surface.areas().iter().all(|&area| area > 0.001));
        }
    }

    #[test]
    fn vertex_order_is_row_by_row() {
        let document = grid([2, 1], [2.0, 1.0], Pattern::Regular).unwrap();
        assert_eq!(document.positions()[..3], [0.0, 1.0, 2.0].map(|x| Vec3::new(x, 0.0, 0.0)));
        assert_eq!(document.positions()[4], Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(document.texcoords()[5], [1.0, 1.0]);
    }

    #[test]
    fn equilateral_triangles_are() {
        let size = [1.0, 8.0 * 0.75_f64.sqrt() / 10.0];
        let rows = equilateral_rows(10, size);
        assert_eq!(rows, 8);
        let surface = Surface::from_document(&grid([10, rows], size, Pattern::Equilateral).unwrap());
        let whole = 0.75_f64.sqrt() * 0.01 / 2.0;
        let halves = surface.areas().iter().filter(|&&area| (area - whole).abs() > 1e-12).count();
        assert_eq!(halves, 16, "two in each row");
    }

    #[test]
    fn strips_have_square_cells() {
        let document = strip(20, 0.2, 0.025).unwrap();
        assert_eq!(document.face_count(), 2 * 20 * 3);
        assert_eq!(strip(4, 1.0, 0.01).unwrap().face_count(), 8);
    }

    #[test]
    fn impossible_sheets_are_refused_by_name() {
        let error = grid([0, 1], [1.0, 1.0], Pattern::Regular).unwrap_err();
        assert_eq!(error.to_string(), "columns is 0; allowed: 1 to 4096");
        for size in [[0.0, 1.0], [1.0, f64::NAN], [f64::INFINITY, 1.0]] {
            assert!(grid([1, 1], size, Pattern::Regular).is_err());
        }
        assert!(strip(3, 0.0, 1.0).is_err());
        assert!(strip(3, 1.0, 1e9).is_err());
    }
}
