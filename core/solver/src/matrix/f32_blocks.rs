//! Blocks of a body's matrix in single precision.
//!
//! Used where the masses dominate the matrix: rounding then changes elastic forces by 1e-7 of themselves, less than the error of a solve.
//! The elastic blocks of a row must still cancel exactly in a rigid translation, which they do not after rounding. So the sum s_i of the
//! blocks of each row is stored in double precision, and products are formed from differences: `y_i = s_i x_i + sum_j A_ij (x_j - x_i)`.
//! Half the memory of double precision is written in assembly and read in products.

use super::assembly::Assembly;
use super::pattern::{OffDiagonal, Pattern, off_diagonal_sum};
use super::product::f32_blocks::{Row, RowsProduct};
use crate::algebra::{Block, SingleBlock, Vec3};
use crate::elements::fused_assembly::FusedAssembly;
use crate::force_model::ForceError;
use crate::hinge_assembly::BlocksMut;
use crate::lanes::Work;
use crate::threads::Pool;
use pliant_plugin_api::lanes::vector_unit;
use std::ops::Range;

/// The sum of all blocks of a row.
pub enum RowSum {
    /// A mass, kg, times the identity, as the elastic blocks of a row cancel.
    Mass(f64),
    /// A mass and the springs of tools on the node.
    Block(Block),
}

impl RowSum {
    /// The sum as a block.
    #[inline(always)]
    pub fn block(self) -> Block {
        match self {
            Self::Mass(m) => [m, 0.0, 0.0, 0.0, m, 0.0, 0.0, 0.0, m],
            Self::Block(block) => block,
        }
    }
}

/// Springs and dampers of tools on a node, as a part of its diagonal block.
#[derive(Debug)]
pub struct ToolBlock {
    /// Index of the node.
    pub node: u32,
    /// Sum of its springs and dampers, times the scales of the matrix.
    pub block: Block,
}

/// Blocks in single precision and row sums in double, in the pattern of a [`crate::Matrix`].
#[derive(Debug, Default)]
pub struct F32Blocks {
    /// Blocks by slot (those of the diagonal are not used).
    blocks: Vec<SingleBlock>,
    /// Mass part of each row sum, kg (n).
    mass: Vec<f64>,
    /// Tool part of the row sums, in the order in which nodes were added.
    tools: Vec<ToolBlock>,
    /// Index in `tools` of each node, or [`NONE`] (n).
    tool_index: Vec<u32>,
    /// Diagonal blocks of the matrix (n).
    diagonal: Vec<Block>,
}

/// Rows in a chunk of work for a thread.
const ROWS: usize = 256;
/// Index of a node on which no tool acts.
const NONE: u32 = u32::MAX;

impl F32Blocks {
    /// Memory of the blocks and masses, bytes.
    pub fn bytes(&self) -> usize {
        self.blocks.len() * size_of::<SingleBlock>() + self.mass.len() * (12 + size_of::<Block>())
    }

    /// The blocks, by slot.
    pub fn blocks(&self) -> &[SingleBlock] {
        &self.blocks
    }

    /// Sum of the blocks of row i.
    #[inline(always)]
    pub fn row_sum(&self, i: usize) -> RowSum {
        if self.tool_index[i] == NONE {
            return RowSum::Mass(self.mass[i]);
        }
        let (mut sum, tool) = (RowSum::Mass(self.mass[i]).block(), &self.tools[self.tool_index[i] as usize]);
        (0..9).for_each(|e| sum[e] += tool.block[e]);
        RowSum::Block(sum)
    }

    /// Mass part of the row sums, kg (n).
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// Tool part of the row sums, in no particular order.
    pub fn tools(&self) -> &[ToolBlock] {
        &self.tools
    }

    /// The diagonal block of row `i`.
    #[inline(always)]
    pub fn diagonal(&self, i: usize) -> &Block {
        &self.diagonal[i]
    }

    /// Removes the blocks, for a new pattern.
    pub fn clear(&mut self) {
        self.blocks.clear();
    }

    /// Adds a block of a tool to the diagonal of row i.
    pub fn add_tool(&mut self, i: usize, block: &Block) {
        if self.tool_index[i] == NONE {
            self.tool_index[i] = self.tools.len() as u32;
            self.tools.push(ToolBlock { node: i as u32, block: [0.0; 9] });
        }
        let tool = &mut self.tools[self.tool_index[i] as usize];
        for e in 0..9 {
            tool.block[e] += block[e];
            self.diagonal[i][e] += block[e];
        }
    }

    /// The rounded blocks of a matrix, with masses, and tools on some nodes.
    #[cfg(test)]
    pub fn rounded(pattern: Pattern<'_>, exact: &[Block]) -> Self {
        let (blocks, n) = (exact.iter().map(|block| block.map(|v| v as f32)).collect(), pattern.count());
        let (mass, diagonal) = ((0..n).map(|i| 0.1 + i as f64).collect(), vec![[0.0; 9]; n]);
        let mut this = Self { blocks, mass, tools: Vec::new(), tool_index: vec![NONE; n], diagonal };
        this.compute_diagonal(&Pool::new(1), pattern);
        // Two tools on stretches of nodes, in no order.
        for i in (0..n).rev().chain(0..n).filter(|i| i % 3 > 0 && i / 70 % 2 == 0) {
            this.add_tool(i, &crate::matrix::pattern::row_sum(pattern, exact, i).map(|v| 0.5 * v));
        }
        this
    }

    /// Assembles the blocks and row sums of a state.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn assemble(
        &mut self,
        pool: &Pool,
        pattern: Pattern<'_>,
        assembly: &FusedAssembly,
        from: &Assembly<'_>,
    ) -> Result<(), ForceError> {
        let (n, row) = (from.state.nodes.len(), pattern.row);
        self.blocks.resize(row[n], [0.0; 9]);
        self.diagonal.resize(n, [0.0; 9]);
        // Reserved for all nodes, so that a step allocates nothing.
        self.tools.clear();
        self.tools.reserve(n);
        self.tool_index.clear();
        self.tool_index.resize(n, NONE);
        self.mass.clear();
        self.mass.extend(from.state.nodes.mass.iter().map(|m| from.scales.mass * m));
        let clear = |_: Range<usize>, blocks: &mut [SingleBlock]| blocks.as_flattened_mut().fill(0.0);
        assembly.run(pool, row, &mut self.blocks, &clear, &|set, chunk, blocks| {
            from.add(set, chunk, BlocksMut { first: row[chunk.window.start], blocks })
        })?;
        self.compute_diagonal(pool, pattern);
        Ok(())
    }

    /// Computes diagonal blocks from masses and the other blocks of their rows.
    fn compute_diagonal(&mut self, pool: &Pool, pattern: Pattern<'_>) {
        let (blocks, mass) = (&self.blocks[..], &self.mass[..]);
        pool.par_chunks(&mut self.diagonal[..], ROWS, &|first, diagonal| {
            vector_unit().dispatch(Diagonal { first, mass: &mass[first..], blocks, pattern, diagonal });
        });
    }

    /// The loop that computes rows `first` on of `out[k] = A x[k]`, as many as `out[k]` has.
    pub fn rows_product<'a, const K: usize>(
        &'a self,
        pattern: Pattern<'a>,
        first: usize,
        x: [&'a [Vec3]; K],
        out: [&'a mut [Vec3]; K],
    ) -> impl Work<Output = ()> + 'a {
        RowsProduct { out, first, x, row: move |i| self.row(pattern, first + i) }
    }

    /// Row i, for a product.
    #[inline(always)]
    fn row<'a>(&'a self, pattern: Pattern<'a>, i: usize) -> Row<'a> {
        let OffDiagonal { lower, first_slot, columns } = pattern.off_diagonal(i);
        let upper = &self.blocks[first_slot..first_slot + columns.len()];
        Row { sum: self.row_sum(i).block(), values: &self.blocks, lower, upper, columns }
    }
}

/// The loop that computes diagonal blocks of rows `first` on: row sums without tools minus the other blocks of the row.
struct Diagonal<'a> {
    first: usize,
    mass: &'a [f64],
    blocks: &'a [SingleBlock],
    pattern: Pattern<'a>,
    diagonal: &'a mut [Block],
}

impl pulp::NullaryFnOnce for Diagonal<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { first, mass, blocks, pattern, diagonal } = self;
        for (i, (mass, diagonal)) in (first..).zip(mass.iter().zip(diagonal)) {
            let others = off_diagonal_sum(pattern, blocks, i);
            let sum = RowSum::Mass(*mass).block();
            (0..9).for_each(|e| diagonal[e] = sum[e] - others[e]);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::algebra::{Vec3, matrix3};
    use crate::lanes::Unit;
    use crate::matrix::Matrix;

    fn wave(i: usize) -> f64 {
        (1.7 * i as f64).sin() * 10_f64.powi((i % 7) as i32 - 3)
    }

    /// A matrix with an irregular pattern, in single precision.
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
        let x: Vec<Vec3> = (0..n).map(|j| Vec3::from_fn(|c, _| wave(500 + 3 * j + c))).collect();
        let (mut out, mut columns) = (vec![Vec3::zeros(); n], vec![Vec3::zeros(); n]);
        matrix.rows_product(0, &x, &mut out);
        (0..n).for_each(|j| matrix.add_column(j, x[j], &mut columns));
        let most = out.iter().flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
        assert!(out.iter().flatten().zip(columns.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-13 * most));
        assert_eq!(matrix.row_product(7, &x), out[7]);
    }

    #[test]
    fn a_rigid_translation_is_multiplied_by_row_sums_alone() {
        let (n, matrix) = (31, rounded(31));
        let x = vec![Vec3::new(3.0, -1.0, 0.1); n];
        let mut out = vec![Vec3::zeros(); n];
        matrix.rows_product(0, &x, &mut out);
        for (i, out) in out.iter().enumerate() {
            let want = matrix3(&matrix.row_sum(i)) * x[0];
            assert!((0..3).all(|c| (out[c] - want[c]).abs() <= 1e-15 * (1.0 + want[c].abs())), "{out:?} {want:?}");
        }
    }

    #[test]
    fn every_vector_unit_gives_the_same_bytes() {
        let (n, matrix) = (31, rounded(31));
        let x: Vec<Vec3> = (0..n).map(|j| Vec3::from_fn(|c, _| wave(900 + 3 * j + c))).collect();
        let products = Unit::ALL.map(|unit| {
            let mut out = vec![Vec3::zeros(); n];
            unit.run(matrix.f32_rows_product(&x, &mut out));
            out.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>()
        });
        assert!(products.iter().all(|out| *out == products[0]));
    }
}
