//! How much of a run lies within the facet.

/// An end of what is left of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// The run's own end.
    Own,
    /// Where it crosses a side of the facet, as a part of the run from its first end.
    Crossing { side: usize, t: f64 },
}

/// What is left of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Left {
    Nothing,
    /// So little that it is one place.
    Place,
    Piece([End; 2]),
}

/// Clips a run. `rim` says for each end and side of the facet whether the end is inside (1), on the side (0) or outside
/// (-1), `depth` how far inside. A piece of less than `least` of the run becomes a place.
pub(super) fn clip(rim: [[i8; 3]; 2], depth: [[f64; 3]; 2], least: f64) -> Left {
    let (mut from, mut to) = ((0.0, End::Own), (1.0, End::Own));
    for side in 0..3 {
        match [rim[0][side], rim[1][side]] {
            [-1, -1 | 0] | [0, -1] => return Left::Nothing,
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
        return Left::Nothing;
    }
    match [from.1, to.1] {
        [End::Crossing { .. }, End::Crossing { .. }] if to.0 - from.0 < least => Left::Place,
        ends => Left::Piece(ends),
    }
}

/// Part of the run, from its first end, at which it crosses a side; never one of the ends.
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
        assert_eq!(piece, Left::Piece([End::Own, End::Crossing { side: 1, t: 0.25 }]));
        assert_eq!(clip([inside, inside], [[1.0; 3]; 2], 0.05), Left::Piece([End::Own; 2]));
        assert_eq!(clip([[-1, 1, 1], [0, 1, 1]], [[-1.0; 3], [0.0; 3]], 0.05), Left::Nothing, "touches from outside");
        assert_eq!(clip([[0, 1, 1], [0, 1, 1]], [[0.0; 3]; 2], 0.05), Left::Piece([End::Own; 2]), "runs along a side");
        let through = [[-1.0, 1.0, 1.0], [1.0, -0.97, 1.0]];
        assert_eq!(clip([[-1, 1, 1], [1, -1, 1]], through, 0.05), Left::Place);
    }
}
