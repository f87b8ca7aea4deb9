//! Blocks of a body's matrix in single precision.
//!
//! Where a matrix is not far from that of the masses, rounding its blocks changes less than a solve leaves: a 1e-7th of what
//! neighbours do to each other. What has to be exact is that a motion of the whole meets nothing but masses, so the blocks of the
//! diagonal are what those of their rows leave, in double precision, and products are of differences:
//! `y_i = own_i x_i + sum_j A_ij (x_j - x_i)`. Materials write half as much, and half as much is read.

use super::coupled::Coupled;
use super::elements::ElementSet;
use super::matrix::{Assembly, Rows, WholeRows};
use super::pool::Pool;
use super::rounded_product::{Row, rows_product};
use super::single::SingleBlock;
use super::single_update::others_sum;
use super::{Block, Factors, V3};
use crate::host::HostError;
use pliant_plugin_api::abi;

/// See above. Where blocks are, the matrix knows.
#[derive(Debug, Default)]
pub struct Rounded {
    /// Those of the diagonal are not used.
    blocks: Vec<SingleBlock>,
    /// What the blocks of a row leave: masses, and what tools do (n).
    own: Vec<Block>,
    /// (n)
    diagonal: Vec<Block>,
}

/// Rows in a piece of work for a thread.
const ROWS: usize = 256;

impl Rounded {
    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.blocks.len() * size_of::<SingleBlock>() + 2 * self.own.len() * size_of::<Block>()
    }

    /// In the places of the matrix's blocks.
    pub fn blocks(&self) -> &[SingleBlock] {
        &self.blocks
    }

    /// What the blocks of row `i` leave.
    pub fn own(&self, i: usize) -> &Block {
        &self.own[i]
    }

    /// The diagonal block of row `i`.
    #[inline(always)]
    pub fn diagonal(&self, i: usize) -> &Block {
        &self.diagonal[i]
    }

    /// Another pattern comes.
    pub fn forget(&mut self) {
        self.blocks.clear();
    }

    /// Adds to the diagonal.
    pub fn add_own(&mut self, i: usize, block: &Block) {
        for e in 0..9 {
            self.own[i][e] += block[e];
            self.diagonal[i][e] += block[e];
        }
    }

    /// Becomes `mass M + stiffness K + damping C`, with `row` for where each row begins.
    ///
    /// # Errors
    /// What the material says.
    pub fn assemble(
        &mut self,
        pool: &Pool,
        (row, rows): (&[usize], Rows<'_>),
        Assembly { material, sets, nodes, time }: Assembly<'_>,
        coupled: Option<(&mut Coupled, &ElementSet)>,
        factors: Factors,
    ) -> Result<(), HostError> {
        let n = nodes.len();
        self.blocks.resize(row[n], [0.0; 9]);
        self.own.resize(n, [0.0; 9]);
        self.diagonal.resize(n, [0.0; 9]);
        let all = (WholeRows { row, values: &mut self.blocks[..] }, &mut self.own[..]);
        pool.pieces(all, ROWS, &|first, (rows, own)| {
            rows.values.as_flattened_mut().fill(0.0);
            for (own, m) in own.iter_mut().zip(&nodes.mass[first..]) {
                let m = factors.mass * m;
                *own = [m, 0.0, 0.0, 0.0, m, 0.0, 0.0, 0.0, m];
            }
        });
        for set in sets.iter().filter(|s| s.has(abi::HAS_FORCES)) {
            set.schedule.run(pool, &mut self.blocks, &|node| row[node], &|chunk, blocks| {
                let (call, scale) = (set.call(chunk, nodes, &nodes.v, time), (factors.stiffness, factors.damping));
                material.single_tangent(&call, scale, &set.slots, row[chunk.window.start], blocks)
            })?;
        }
        if let Some((coupled, set)) = coupled {
            let factors = (factors.stiffness, factors.stand_in, factors.after_forces);
            let blocks = (&|node: usize| row[node], &mut self.blocks[..]);
            coupled.tangent(pool, material, (set, nodes, time), factors, blocks)?;
        }
        let (blocks, own) = (&self.blocks[..], &self.own[..]);
        pool.pieces(&mut self.diagonal[..], ROWS, &|first, diagonal| {
            pulp::Arch::new().dispatch(Diagonal { first, own, blocks, rows, diagonal });
        });
        Ok(())
    }

    /// `out[k] = A x[k]`, rows `first` on.
    pub fn rows_product<const K: usize>(&self, rows: Rows<'_>, first: usize, x: [&[V3]; K], out: [&mut [V3]; K]) {
        rows_product(out, first, x, |i| self.row(rows, first + i));
    }

    #[inline(always)]
    fn row<'a>(&'a self, rows: Rows<'a>, i: usize) -> Row<'a> {
        let (lower, above, columns) = rows.around(i);
        let upper = &self.blocks[above..above + columns.len()];
        Row { own: &self.own[i], values: &self.blocks, lower, upper, columns }
    }
}

/// What the blocks of rows leave, from row `first` on.
struct Diagonal<'a> {
    first: usize,
    own: &'a [Block],
    blocks: &'a [SingleBlock],
    rows: Rows<'a>,
    diagonal: &'a mut [Block],
}

impl pulp::NullaryFnOnce for Diagonal<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { first, own, blocks, rows, diagonal } = self;
        for (i, diagonal) in (first..).zip(diagonal) {
            let others = others_sum(rows, blocks, i);
            (0..9).for_each(|e| diagonal[e] = own[i][e] - others[e]);
        }
    }
}
