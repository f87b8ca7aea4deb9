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

    #[cfg(test)]
    pub fn of(rows: Rows<'_>, exact: &[Block]) -> Self {
        let blocks: Vec<SingleBlock> = exact.iter().map(|block| block.map(|v| v as f32)).collect();
        let own: Vec<Block> = (0..rows.count()).map(|i| super::single_update::row_sum(rows, exact, i)).collect();
        let mut diagonal = own.clone();
        pulp::Arch::new().dispatch(Diagonal { first: 0, own: &own, blocks: &blocks, rows, diagonal: &mut diagonal });
        Self { blocks, own, diagonal }
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

    #[cfg(test)]
    pub fn portable_row(&self, rows: Rows<'_>, i: usize, x: &[V3]) -> V3 {
        super::rounded_product::row_product(self.row(rows, i), i, x)
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

#[cfg(test)]
mod tests {
    use crate::step::{Matrix, V3};

    fn wave(i: usize) -> f64 {
        (1.7 * i as f64).sin() * 10_f64.powi((i % 7) as i32 - 3)
    }

    /// Rows that do not lie alike, with symmetric blocks on the diagonal.
    fn rounded(n: usize) -> Matrix {
        let mut matrix = Matrix::default();
        matrix.set_pattern(n, |pair| {
            for i in 0..n as u32 {
                (i + 1..n as u32).step_by(1 + i as usize % 5).take(9).for_each(|j| pair(i, j));
            }
        });
        for (slot, block) in matrix.values_mut().iter_mut().enumerate() {
            *block = std::array::from_fn(|e| wave(9 * slot + e));
        }
        matrix.round();
        matrix
    }

    #[test]
    fn a_product_is_that_of_its_columns() {
        let (n, matrix) = (31, rounded(31));
        let x: Vec<V3> = (0..n).map(|j| std::array::from_fn(|c| wave(500 + 3 * j + c))).collect();
        let (mut out, mut columns) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        matrix.rows_product(0, &x, &mut out);
        (0..n).for_each(|j| matrix.add_column(j, x[j], &mut columns));
        let most = out.iter().flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
        assert!(out.iter().flatten().zip(columns.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-13 * most));
        assert_eq!(matrix.row_product(7, &x), out[7]);
    }

    #[test]
    fn a_motion_of_the_whole_meets_what_rows_leave_and_nothing_else() {
        let (n, matrix) = (31, rounded(31));
        let x = vec![[3.0, -1.0, 0.1]; n];
        let mut out = vec![[0.0; 3]; n];
        matrix.rows_product(0, &x, &mut out);
        for (i, out) in out.iter().enumerate() {
            let own = matrix.own(i);
            let want: V3 =
                std::array::from_fn(|r| own[3 * r] * x[0][0] + own[3 * r + 1] * x[0][1] + own[3 * r + 2] * x[0][2]);
            assert!((0..3).all(|c| (out[c] - want[c]).abs() <= 1e-15 * (1.0 + want[c].abs())), "{out:?} {want:?}");
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn every_vector_unit_gives_the_same_bytes() {
        let (n, matrix) = (31, rounded(31));
        let x: Vec<V3> = (0..n).map(|j| std::array::from_fn(|c| wave(900 + 3 * j + c))).collect();
        let mut out = vec![[0.0; 3]; n];
        matrix.rows_product(0, &x, &mut out);
        for (i, out) in out.iter().enumerate() {
            assert_eq!(out.map(f64::to_bits), matrix.portable_row(i, &x).map(f64::to_bits));
        }
    }
}
