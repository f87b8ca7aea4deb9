//! Vectors of nodes, gathered into registers.

#[cfg(target_arch = "x86_64")]
use super::x86;
use super::{MAX_LANES, Vec3, Wide};
use pulp::Simd;

/// Vectors of nodes, to be read four numbers at a time.
#[derive(Clone, Copy)]
pub struct NodeVectorsView<'a> {
    flat: &'a [f64],
    /// The vector of the last node, padded: nothing follows it in memory.
    last: [f64; 4],
}

impl<'a> NodeVectorsView<'a> {
    /// A view of the vectors (n x 3).
    #[inline(always)]
    pub fn new(vectors: &'a [[f64; 3]]) -> Self {
        let [x, y, z] = vectors.last().copied().unwrap_or_default();
        Self { flat: vectors.as_flattened(), last: [x, y, z, 0.0] }
    }

    /// The vector of a node, and a fourth number without meaning.
    #[inline(always)]
    fn padded(&self, node: u32) -> &[f64; 4] {
        let first = 3 * node as usize;
        match self.flat.get(first..first + 4).and_then(<[f64]>::first_chunk) {
            Some(padded) => padded,
            None => {
                assert_eq!(self.flat.len(), first + 3, "a corner is one of the nodes");
                &self.last
            }
        }
    }

    /// The vectors at one corner of as many elements as there are lanes.
    #[inline(always)]
    fn gather<S: Simd, const K: usize>(&self, simd: S, elements: &[[u32; K]], corner: usize) -> Vec3<Wide<S>> {
        let mut padded = [&self.last; MAX_LANES];
        for lane in 0..S::F64_LANES {
            padded[lane] = self.padded(elements[lane][corner]);
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(components) = x86::padded_components(simd, padded) {
            return Vec3(components);
        }
        let mut components = [[0.0; MAX_LANES]; 3];
        for lane in 0..S::F64_LANES {
            for i in 0..3 {
                components[i][lane] = padded[lane][i];
            }
        }
        let [x, y, z] = &components;
        Vec3([Wide::load(simd, x), Wide::load(simd, y), Wide::load(simd, z)])
    }
}

/// The vectors at the corners of elements `e, e + 1, ..`; lanes past the end repeat the last element. An element has up to four corners.
///
/// # Panics
/// If a corner is not one of the nodes.
#[inline(always)]
pub fn gather<S: Simd, const K: usize>(
    simd: S,
    nodes: &[[u32; K]],
    e: usize,
    vectors: NodeVectorsView<'_>,
) -> [Vec3<Wide<S>>; K] {
    let mut clamped = [[0; K]; MAX_LANES];
    let elements = match nodes.get(e..e + S::F64_LANES) {
        Some(elements) => elements,
        None => {
            for lane in 0..S::F64_LANES {
                clamped[lane] = nodes[(e + lane).min(nodes.len() - 1)];
            }
            &clamped[..S::F64_LANES]
        }
    };
    const { assert!(K <= 4, "corners are written out") };
    let zero = Vec3([Wide(simd.splat_f64s(0.0), simd); 3]);
    let mut all = [zero; K];
    // Written out: with a loop the compiler keeps the array in memory.
    if K > 0 {
        all[0] = vectors.gather(simd, elements, 0);
    }
    if K > 1 {
        all[1] = vectors.gather(simd, elements, 1);
    }
    if K > 2 {
        all[2] = vectors.gather(simd, elements, 2);
    }
    if K > 3 {
        all[3] = vectors.gather(simd, elements, 3);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::units;
    use pulp::WithSimd;

    struct Gathers;

    impl WithSimd for Gathers {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let wave = |i: usize| (1.7 * i as f64).sin();
            let points: Vec<[f64; 3]> = (0..9).map(|i| [wave(3 * i), wave(3 * i + 1), wave(3 * i + 2)]).collect();
            let elements = [8, 0, 5, 8, 3, 1, 7, 6, 2, 8, 4].map(|node| [2, node]);
            for e in [0, 3, 10] {
                let corners = gather(simd, &elements, e, NodeVectorsView::new(&points));
                let corners = corners.map(|corner| corner.0.map(Wide::to_array));
                for (lane, corner) in (0..S::F64_LANES).flat_map(|lane| [(lane, 0), (lane, 1)]) {
                    let node = elements[(e + lane).min(10)][corner] as usize;
                    assert_eq!(corners[corner].map(|axis| axis[lane]), points[node], "{e} {lane}");
                }
            }
        }
    }

    #[test]
    fn vectors_are_those_of_the_corners() {
        units().into_iter().for_each(|unit| unit.dispatch(Gathers));
    }
}
