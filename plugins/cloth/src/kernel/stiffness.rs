//! Membrane stiffness of triangles, in double and in single precision.

use super::{load_triangles, prefetch_elements, prefetch_slots};
use crate::membrane::Membrane;
use crate::triangle::{self, Triangle};
use crate::vector::Vec3;
use pliant_plugin_api::lanes::{
    MAX_LANES, MAX_SINGLE_LANES, NodeVectorsView, SingleWide, SplitBlock, Wide, add_block, gather,
};
use pliant_plugin_api::{BlockWindow, Blocks, Elements, SingleBlocks, TangentScale};
use pulp::{Simd, WithSimd};

/// Pairs of corners of a triangle.
const PAIRS: usize = 6;

/// Adds `scale.stiffness` K + `scale.damping` C of triangles.
pub(crate) struct Stiffness<'a, 'b> {
    pub(crate) membrane: &'a Membrane,
    pub(crate) elements: &'a Elements<'a>,
    pub(crate) scale: TangentScale,
    pub(crate) out: &'a mut Blocks<'b>,
}

impl WithSimd for Stiffness<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { membrane, elements, scale, out } = self;
        let (x, nodes) = (NodeVectorsView::new(elements.x()), elements.corners::<3>());
        let BlockWindow { slots, first_slot, blocks: targets } = out.window::<PAIRS>();
        // The first eight entries of each pair's block, by lane, and the ninth.
        let (mut rows, mut last) = ([[[0.0; 8]; MAX_LANES]; PAIRS], [[0.0; MAX_LANES]; PAIRS]);
        let planes = core::array::from_fn(|s| elements.rest_data(s));
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            prefetch_elements::<S, 3, { triangle::STRIDE }>(nodes, &planes, e);
            prefetch_slots(slots, e, S::F64_LANES);
            let shape = load_triangles(simd, &planes, e);
            let f = shape.deformation_gradient(gather(simd, nodes, e, x));
            let count = S::F64_LANES.min(nodes.len() - e);
            let blocks = membrane.tangent(&shape, f, scale).blocks(&shape);
            for pair in 0..PAIRS {
                let [[a, b, c], [d, e, f], [g, h, i]] = blocks[pair];
                (rows[pair], last[pair]) = (Wide::rows([a, b, c, d, e, f, g, h]), i.to_array());
            }
            for lane in 0..count {
                let slots = &slots[e + lane];
                for pair in 0..PAIRS {
                    let block = SplitBlock { first: &rows[pair][lane], last: last[pair][lane] };
                    add_block(simd, targets, first_slot, slots[pair], block);
                }
            }
        }
    }
}

/// [`Stiffness`] in single precision, of the off-diagonal blocks alone.
pub(crate) struct SingleStiffness<'a, 'b> {
    pub(crate) membrane: &'a Membrane,
    pub(crate) elements: &'a Elements<'a>,
    pub(crate) scale: TangentScale,
    pub(crate) out: &'a mut SingleBlocks<'b>,
}

/// Indices of the off-diagonal pairs (0,1) (0,2) (1,2) among all pairs.
const OFF_DIAGONAL: [usize; 3] = [1, 2, 4];

/// Aligns its content to a cache line, so that no aligned read crosses one.
#[repr(align(64))]
struct CacheAligned<T>(T);

impl WithSimd for SingleStiffness<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { membrane, elements, scale, out } = self;
        let (x, nodes) = (NodeVectorsView::new(elements.x()), elements.corners::<3>());
        let BlockWindow { slots, first_slot, blocks: targets } = out.window::<PAIRS>();
        let planes = core::array::from_fn(|s| elements.rest_data(s));
        let mut rows = CacheAligned([[[0.0; 8]; MAX_SINGLE_LANES]; 3]);
        let mut last = CacheAligned([[0.0; MAX_SINGLE_LANES]; 3]);
        let (rows, last) = (&mut rows.0, &mut last.0);
        for e in (0..nodes.len()).step_by(S::F32_LANES) {
            prefetch_elements::<S, 3, { triangle::STRIDE }>(nodes, &planes, e);
            prefetch_elements::<S, 3, { triangle::STRIDE }>(nodes, &planes, e + S::F64_LANES);
            prefetch_slots(slots, e, S::F32_LANES);
            // Differences of positions are formed in double precision and then rounded. A register of f32 has the elements of two
            // registers of f64.
            let (low, high) = (load_triangles(simd, &planes, e), load_triangles(simd, &planes, e + S::F64_LANES));
            let f_low = low.deformation_gradient(gather(simd, nodes, e, x));
            let f_high = high.deformation_gradient(gather(simd, nodes, e + S::F64_LANES, x));
            let mut f = [Vec3([SingleWide::round(f_low[0][0], f_high[0][0]); 3]); 2];
            for column in 0..2 {
                for i in 0..3 {
                    f[column][i] = SingleWide::round(f_low[column][i], f_high[column][i]);
                }
            }
            let ([_, b, c], [_, p, q]) = (low.gradient, high.gradient);
            let gradients = [
                [SingleWide::round(b[0], p[0]), SingleWide::round(b[1], p[1])],
                [SingleWide::round(c[0], q[0]), SingleWide::round(c[1], q[1])],
            ];
            let shape = Triangle::from_gradients(gradients, SingleWide::round(low.area, high.area));
            let blocks = membrane.tangent(&shape, f, scale).off_diagonal_blocks(&shape);
            for k in 0..3 {
                let [[a, b, c], [d, e, f], [g, h, i]] = blocks[k];
                (rows[k], last[k]) = (SingleWide::rows([a, b, c, d, e, f, g, h]), i.to_array());
            }
            for lane in 0..S::F32_LANES.min(nodes.len() - e) {
                for k in 0..3 {
                    let block = SplitBlock { first: &rows[k][lane], last: last[k][lane] };
                    add_block(simd, targets, first_slot, slots[e + lane][OFF_DIAGONAL[k]], block);
                }
            }
        }
    }
}
