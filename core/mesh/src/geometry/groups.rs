//! Triangles in groups of a few that are near each other.

/// Largest number of triangles of a group.
pub(super) const GROUP: usize = 4;

/// The middle of a triangle's box (m), and the triangle. Single precision: it is compared with others alone.
type Middle = ([f32; 3], u32);

/// Numbers of triangles with these middles (m) in an order in which each [`GROUP`] of them is a group. Sets are halved across their longest axis
/// until they are groups.
pub(super) fn groups(middles: impl Iterator<Item = [f64; 3]>) -> Vec<u32> {
    let mut middles: Vec<Middle> = middles.zip(0..).map(|(at, triangle)| (at.map(|c| c as f32), triangle)).collect();
    let mut open = vec![&mut middles[..]];
    while let Some(set) = open.pop() {
        if set.len() > GROUP {
            let axis = longest_axis(set);
            // Whole groups to the left, so that only the last group of all may be smaller.
            let half = (set.len() / 2).next_multiple_of(GROUP);
            set.select_nth_unstable_by(half, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
            let (left, right) = set.split_at_mut(half);
            open.extend([left, right]);
        }
    }
    middles.into_iter().map(|(_, triangle)| triangle).collect()
}

/// The axis along which the middles of a set are farthest apart.
fn longest_axis(set: &[Middle]) -> usize {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for (at, _) in set {
        for i in 0..3 {
            (low[i], high[i]) = (low[i].min(at[i]), high[i].max(at[i]));
        }
    }
    (0..3).max_by(|a, b| (high[*a] - low[*a]).total_cmp(&(high[*b] - low[*b]))).unwrap_or(0)
}
