//! Conversion of sixteen vectors from one behind the other to by component.

use super::{LOOKED_UP, Lanes, Sixteen};

/// Numbers of sixteen vectors, one behind the other.
pub type Flat = [f32; 48];

/// Where each number of a component comes from: among the first two rows, then among those and the third.
const PLACES: [[[u8; 16]; 2]; 3] = places();

const fn places() -> [[[u8; 16]; 2]; 3] {
    let mut places = [[[0; 16]; 2]; 3];
    let mut at = 0;
    while at < 48 {
        let (c, lane) = (at / 16, at % 16);
        let from = 3 * lane + c;
        let is_third = from >= LOOKED_UP;
        places[c][0][lane] = if is_third { 0 } else { from as u8 };
        places[c][1][lane] = if is_third { (from - LOOKED_UP + 16) as u8 } else { lane as u8 };
        at += 1;
    }
    places
}

/// The components of vectors one behind the other.
#[inline(always)]
pub fn apart<U: Lanes>(unit: U, flat: &Flat) -> [U::V; 3] {
    let rows: &[Sixteen] = flat.as_chunks().0;
    let (two, third) = ([unit.load(&rows[0]), unit.load(&rows[1])], unit.load(&rows[2]));
    let [x, y, z] = &PLACES;
    [
        unit.lookup([unit.lookup(two, &x[0]), third], &x[1]),
        unit.lookup([unit.lookup(two, &y[0]), third], &y[1]),
        unit.lookup([unit.lookup(two, &z[0]), third], &z[1]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Unit, Vectors, Work, put};

    struct Apart(Flat);

    impl Work for Apart {
        type Output = Vectors;

        #[inline(always)]
        fn on(self, unit: impl Lanes) -> Vectors {
            put(unit, apart(unit, &self.0))
        }
    }

    #[test]
    fn vectors_come_apart() {
        let flat: Flat = std::array::from_fn(|k| k as f32);
        let want = [0, 1, 2].map(|c| std::array::from_fn(|lane| (3 * lane + c) as f32));
        assert_eq!(Unit::ALL.map(|unit| unit.run(Apart(flat))), [want; 3]);
    }
}
