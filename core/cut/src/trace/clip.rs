//! Clipping of a run to the facet.

/// An end of a clipped run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// The run's own end.
    Own,
    /// The intersection with a side of the facet, at a parameter of the run in (0, 1).
    Crossing { side: usize, t: f64 },
}

/// Result of clipping a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ClippedRun {
    Nothing,
    /// A piece so short that it is collapsed to a point.
    Location,
    Piece([End; 2]),
}

/// Clips a run. For each end and side of the facet, `rim` is the position of the end, inside (1), on the side (0) or outside (-1), and `depth`
/// its signed distance inside, m. A piece shorter than the fraction `least` of the run is collapsed to a point.
pub(super) fn clip(rim: [[i8; 3]; 2], depth: [[f64; 3]; 2], least: f64) -> ClippedRun {
    let (mut from, mut to) = ((0.0, End::Own), (1.0, End::Own));
    for side in 0..3 {
        match [rim[0][side], rim[1][side]] {
            [-1, -1 | 0] | [0, -1] => return ClippedRun::Nothing,
            [-1, 1] => {
                let t = cross(depth, side);
                if t > from.0 {
                    from = (t, End::Crossing { side, t });
                }
            }
            [1, -1] => {
                let t = cross(depth, side);
                if t < to.0 {
                    to = (t, End::Crossing { side, t });
                }
            }
            _ => {}
        }
    }
    if from.0 >= to.0 {
        return ClippedRun::Nothing;
    }
    match [from.1, to.1] {
        [End::Crossing { .. }, End::Crossing { .. }] if to.0 - from.0 < least => ClippedRun::Location,
        ends => ClippedRun::Piece(ends),
    }
}

/// Parameter of the run at its intersection with a side, strictly between 0 and 1.
pub(super) fn cross(depth: [[f64; 3]; 2], side: usize) -> f64 {
    let (from, to) = (depth[0][side].abs(), depth[1][side].abs());
    let t = from / (from + to);
    if t.is_finite() { t.clamp(1e-3, 1.0 - 1e-3) } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_of_a_run() {
        let inside = [1, 1, 1];
        let piece = clip([inside, [1, -1, 1]], [[1.0; 3], [1.0, -3.0, 1.0]], 0.05);
        assert_eq!(piece, ClippedRun::Piece([End::Own, End::Crossing { side: 1, t: 0.25 }]));
        assert_eq!(clip([inside, inside], [[1.0; 3]; 2], 0.05), ClippedRun::Piece([End::Own; 2]));
        assert_eq!(
            clip([[-1, 1, 1], [0, 1, 1]], [[-1.0; 3], [0.0; 3]], 0.05),
            ClippedRun::Nothing,
            "touches from outside"
        );
        assert_eq!(
            clip([[0, 1, 1], [0, 1, 1]], [[0.0; 3]; 2], 0.05),
            ClippedRun::Piece([End::Own; 2]),
            "runs along a side"
        );
        let through = [[-1.0, 1.0, 1.0], [1.0, -0.97, 1.0]];
        assert_eq!(clip([[-1, 1, 1], [1, -1, 1]], through, 0.05), ClippedRun::Location);
    }
}
