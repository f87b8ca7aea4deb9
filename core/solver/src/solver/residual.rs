//! What is left to do of a system: in double precision, and as the iterations of a solve have it.

use crate::algebra::Vec3;
use crate::lanes::threes::{Flat, apart};
use crate::lanes::{LANES, Lanes, Vectors, Work, dusted, put};
use bytemuck::{cast_slice, cast_slice_mut};

/// Sums that go on side by side, for one has to wait for the sum before.
const SUMS: usize = 24;

/// `r = b - taken`.
pub struct Left<'a> {
    pub b: &'a [Vec3],
    pub taken: Option<&'a [Vec3]>,
    pub r: &'a mut [Vec3],
}

impl pulp::NullaryFnOnce for Left<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (r, b) = (cast_slice_mut::<Vec3, f64>(self.r), cast_slice::<Vec3, f64>(self.b));
        match self.taken {
            Some(taken) => {
                r.iter_mut().zip(b).zip(cast_slice::<Vec3, f64>(taken)).for_each(|((r, b), taken)| *r = b - taken)
            }
            None => r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r),
        }
    }
}

/// `r . r`
pub struct Squares<'a>(pub &'a [Vec3]);

impl pulp::NullaryFnOnce for Squares<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let (rows, rest) = cast_slice::<Vec3, f64>(self.0).as_chunks::<SUMS>();
        let mut sums = [0.0; SUMS];
        for row in rows {
            (0..SUMS).for_each(|k| sums[k] += row[k] * row[k]);
        }
        sums.iter().sum::<f64>() + rest.iter().map(|v| v * v).sum::<f64>()
    }
}

/// Vectors times a number, rounded, to where iterations have them.
pub struct BySixteen<'a> {
    pub down: f64,
    pub r: &'a [Vec3],
    pub to: &'a mut [Vectors],
}

impl Work for BySixteen<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        for (to, r) in self.to.iter_mut().zip(self.r.chunks(LANES)) {
            let mut flat: Flat = [0.0; 3 * LANES];
            for (flat, r) in flat.iter_mut().zip(cast_slice::<Vec3, f64>(r)) {
                *flat = dusted((self.down * r) as f32);
            }
            *to = put(unit, apart(unit, &flat));
        }
    }
}
