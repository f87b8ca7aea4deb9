//! The sparse symmetric matrix of a body, in 3 x 3 blocks.
//!
//! Blocks on and above the diagonal are stored row by row, the diagonal first: the index of a stored block is its slot. Each row also lists
//! the slots of the transposes of its blocks below the diagonal. A product thus computes a row at once, in one order: it needs no scatter,
//! and its bytes do not depend on the number of threads.

pub mod assembly;
pub mod f32_blocks;
pub mod pattern;
pub mod product;

use super::algebra::{Block, Vec3, matrix3};
use super::constraint::Constraint;
use super::coupled::{CoupledHinges, is_coupled_hinges};
use super::elements::ElementSet;
use super::elements::fused_assembly::FusedAssembly;
use super::hinge_assembly::BlocksMut;
#[cfg(test)]
use super::lanes::Work;
use super::lanes::widest;
use super::nodes::Nodes;
use super::normals::{NormalsEnergy, wants_normals};
use super::springs::NodeSprings;
use super::system::SystemState;
use super::system_scales::SystemScales;
use super::threads::Pool;
use crate::force_model::ForceError;
use assembly::Assembly;
use f32_blocks::F32Blocks;
use pattern::{LowerBlock, OffDiagonal, Pattern, UpperBlock};
use pliant_plugin_api::{TangentScale, abi};
use product::{Row, RowsProduct};
use std::ops::Range;

/// The sparse symmetric matrix of a body: a 3 x 3 block for each node and each pair of nodes that share an element.
#[derive(Debug, Default)]
pub struct Matrix {
    /// Slot of the diagonal block of each row, and the number of slots (n + 1).
    row: Vec<usize>,
    /// Column of the block in each slot, ascending within a row.
    column: Vec<u32>,
    /// Blocks by slot; empty if the matrix was never assembled in double precision.
    values: Vec<Block>,
    /// Where the blocks of each row begin in `lower` (n + 1).
    lower_row: Vec<usize>,
    /// Blocks below the diagonal, row by row.
    lower: Vec<LowerBlock>,
    /// Order in which elements are assembled.
    assembly: FusedAssembly,
    /// The blocks if `is_f32`.
    f32_blocks: F32Blocks,
    /// Whether the last assembly was in single precision.
    is_f32: bool,
}

/// The blocks of a matrix in their precision.
#[derive(Clone, Copy)]
pub(super) enum Values<'a> {
    /// Blocks in double precision, by slot.
    F64(&'a [Block]),
    /// Blocks in single precision with row sums.
    F32(&'a F32Blocks),
}

/// Whether elements of a set add blocks to the matrix.
fn has_stiffness(set: &ElementSet) -> bool {
    set.has(abi::HAS_FORCES) || is_coupled_hinges(set) || wants_normals(set)
}

/// Rows in a chunk of a product.
const ROWS: usize = 256;

impl Matrix {
    /// Builds the pattern for `n` nodes from the sets that have stiffness, and lists the slots of each set's elements in it.
    pub fn rebuild(&mut self, n: usize, sets: &mut [ElementSet]) {
        let all: &[ElementSet] = sets;
        self.set_pattern(n, |visit| {
            for set in all.iter().filter(|s| has_stiffness(s)) {
                for element in set.list.nodes.chunks_exact(set.stencil()) {
                    for a in 0..set.stencil() {
                        for b in a + 1..set.stencil() {
                            visit(element[a].min(element[b]), element[a].max(element[b]));
                        }
                    }
                }
            }
        });
        for set in sets.iter_mut() {
            self.list_slots(set);
        }
        self.assembly = FusedAssembly::cut(n, sets, |set| set.has(abi::HAS_FORCES) || is_coupled_hinges(set));
    }

    /// Sets the pattern to the diagonal and the blocks (i, j), i < j, that `pairs` passes to its argument. It may pass a block several times and is
    /// called twice: to count and to list.
    pub(super) fn set_pattern(&mut self, n: usize, pairs: impl Fn(&mut dyn FnMut(u32, u32))) {
        let mut next = vec![1_usize; n];
        pairs(&mut |i, _| next[i as usize] += 1);
        let mut total = 0;
        for count in &mut next {
            total += std::mem::replace(count, total);
        }
        let starts = next.clone();
        let mut columns = vec![0_u32; total];
        for i in 0..n {
            columns[next[i]] = i as u32;
            next[i] += 1;
        }
        pairs(&mut |i, j| {
            columns[next[i as usize]] = j;
            next[i as usize] += 1;
        });
        self.row.clear();
        self.column.clear();
        for i in 0..n {
            self.row.push(self.column.len());
            let row = &mut columns[starts[i]..next[i]];
            row.sort_unstable();
            for (at, &column) in row.iter().enumerate() {
                if at == 0 || row[at - 1] != column {
                    self.column.push(column);
                }
            }
        }
        self.row.push(self.column.len());
        self.values.clear();
        self.f32_blocks.clear();
        self.is_f32 = false;
        self.list_lower(n);
    }

    /// Lists the blocks below the diagonal by row.
    fn list_lower(&mut self, n: usize) {
        let mut count = vec![0_usize; n + 1];
        for UpperBlock { row, column, .. } in self.upper_blocks() {
            assert!(row < column);
            count[column as usize] += 1;
        }
        self.lower_row.clear();
        let mut total = 0;
        for c in &mut count {
            self.lower_row.push(total);
            total += std::mem::replace(c, total);
        }
        let mut lower = vec![LowerBlock { column: 0, slot: 0 }; total];
        for UpperBlock { row, column, slot } in self.upper_blocks() {
            lower[count[column as usize]] = LowerBlock { column: row, slot };
            count[column as usize] += 1;
        }
        self.lower = lower;
    }

    /// Every block above the diagonal, in the order of slots.
    pub(super) fn upper_blocks(&self) -> impl Iterator<Item = UpperBlock> + '_ {
        (0..self.rows()).flat_map(move |i| {
            let block = move |slot: usize| UpperBlock { row: i as u32, column: self.column[slot], slot: slot as u32 };
            (self.row[i] + 1..self.row[i + 1]).map(block)
        })
    }

    /// Lists the slot of each pair of nodes of the stencils of a set, marked where the stored block is the transpose.
    fn list_slots(&self, set: &mut ElementSet) {
        set.slots.clear();
        if !has_stiffness(set) {
            return;
        }
        let stencil = set.stencil();
        for element in set.list.nodes.chunks_exact(stencil) {
            for a in 0..stencil {
                for b in a..stencil {
                    let (i, j) = (element[a], element[b]);
                    let slot = self.slot(i.min(j), i.max(j)) as u32;
                    set.slots.push(if i > j { slot | abi::TRANSPOSED } else { slot });
                }
            }
        }
    }

    /// Slot of block (i, j), i <= j.
    ///
    /// # Panics
    /// If the block is not in the pattern.
    pub(super) fn slot(&self, i: u32, j: u32) -> usize {
        let row = &self.column[self.row[i as usize]..self.row[i as usize + 1]];
        self.row[i as usize] + row.binary_search(&j).expect("every pair of an element is in the pattern")
    }

    /// Slot of the diagonal block of row i.
    pub(super) fn diagonal_slot(&self, i: usize) -> usize {
        self.row[i]
    }

    /// Rows with blocks in a range of slots, each with its part of the range.
    pub(super) fn rows_of(&self, slots: Range<usize>) -> impl Iterator<Item = (usize, Range<usize>)> + '_ {
        let first = self.row.partition_point(|start| *start <= slots.start).saturating_sub(1);
        let of_row = move |i: usize| (i, self.row[i].max(slots.start)..self.row[i + 1].min(slots.end));
        (first..self.rows()).map(of_row).take_while(|(_, slots)| !slots.is_empty())
    }

    /// Column of the block in a slot.
    pub(super) fn column(&self, slot: usize) -> usize {
        self.column[slot] as usize
    }

    /// The stored blocks.
    pub(super) fn values(&self) -> Values<'_> {
        if self.is_f32 { Values::F32(&self.f32_blocks) } else { Values::F64(&self.values) }
    }

    /// Whether the blocks off the diagonal are stored in single precision.
    pub fn is_f32(&self) -> bool {
        self.is_f32
    }

    /// Number of block rows, one for each node.
    pub fn rows(&self) -> usize {
        self.row.len().saturating_sub(1)
    }

    /// Number of blocks on and above the diagonal.
    pub fn blocks(&self) -> usize {
        self.column.len()
    }

    /// Memory of the values and indices, bytes.
    pub fn bytes(&self) -> usize {
        let values = self.values.len() * size_of::<Block>() + self.f32_blocks.bytes();
        values + self.column.len() * 4 + self.lower.len() * 8 + self.row.len() * 16
    }

    /// Assembles `mass M + stiffness K + damping C` of a state with the factors `scales`, without energies of normals
    /// ([`Matrix::add_normals`]). `coupled` are the coupled hinges of the body; `None` leaves out their stiffness.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn assemble(
        &mut self,
        pool: &Pool,
        state: SystemState<'_>,
        coupled: Option<&mut CoupledHinges>,
        scales: SystemScales,
    ) -> Result<(), ForceError> {
        self.is_f32 = scales.allow_f32 && state.material.has_single();
        let coupled = match coupled {
            Some(coupled) if scales.stiffness != 0.0 && state.sets.iter().any(is_coupled_hinges) => {
                if !scales.strains_are_current {
                    coupled.update_strains(pool, state)?;
                }
                Some(&*coupled)
            }
            _ => None,
        };
        let from = Assembly { state, coupled, scales };
        if self.is_f32 {
            let pattern =
                Pattern { row: &self.row, column: &self.column, lower_row: &self.lower_row, lower: &self.lower };
            return self.f32_blocks.assemble(pool, pattern, &self.assembly, &from);
        }
        let (row, mass) = (&self.row, &state.nodes.mass);
        self.values.resize(self.column.len(), [0.0; 9]);
        let clear = |nodes: Range<usize>, blocks: &mut [Block]| {
            blocks.as_flattened_mut().fill(0.0);
            for (start, m) in row[nodes.clone()].iter().zip(&mass[nodes.clone()]) {
                let (diagonal, m) = (&mut blocks[start - row[nodes.start]], scales.mass * m);
                (diagonal[0], diagonal[4], diagonal[8]) = (m, m, m);
            }
        };
        self.assembly.run(pool, row, &mut self.values, &clear, &|set, chunk, blocks| {
            from.add(set, chunk, BlocksMut { first: row[chunk.window.start], blocks })
        })
    }

    /// Adds the approximate Hessian of an energy of normals, which [`Matrix::assemble`] leaves out.
    pub fn add_normals(
        &mut self,
        pool: &Pool,
        normals: &NormalsEnergy,
        sets: &[ElementSet],
        nodes: &Nodes,
        scales: SystemScales,
    ) {
        normals.add_tangent(pool, sets, nodes, scales, &self.row, &mut self.values);
    }

    /// Adds the springs and dampers of a tool to the diagonal, multiplied by the scales.
    pub fn add_diagonal(&mut self, springs: &NodeSprings, TangentScale { stiffness, damping }: TangentScale) {
        for (i, &node) in springs.nodes.iter().enumerate() {
            let mut more = [0.0; 9];
            for e in 0..9 {
                more[e] = stiffness * springs.stiffness[i][e] + damping * springs.damping[i][e];
            }
            if self.is_f32 {
                self.f32_blocks.add_tool(node as usize, &more);
                continue;
            }
            let diagonal = &mut self.values[self.row[node as usize]];
            (0..9).for_each(|e| diagonal[e] += more[e]);
        }
    }

    /// `out = A x`, in double precision (n x 3).
    pub fn product(&self, pool: &Pool, x: &[Vec3], out: &mut [Vec3]) {
        self.products(pool, [x], [out]);
    }

    /// `out[k] = A x[k]`, in double precision (n x 3 each). The matrix is read once for all k.
    pub fn products<const K: usize>(&self, pool: &Pool, x: [&[Vec3]; K], out: [&mut [Vec3]; K]) {
        pool.par_chunks(out, ROWS, &|first, out| self.rows_products(first, x, out));
    }

    /// Rows `first` on of `A x`, as many as `out` has.
    pub fn rows_product(&self, first: usize, x: &[Vec3], out: &mut [Vec3]) {
        self.rows_products(first, [x], [out]);
    }

    /// Rows `first` on of `A x[k]`, as many as `out[k]` has.
    fn rows_products<const K: usize>(&self, first: usize, x: [&[Vec3]; K], out: [&mut [Vec3]; K]) {
        match self.is_f32 {
            true => widest(self.f32_blocks.rows_product(self.pattern(), first, x, out)),
            false => widest(RowsProduct { out, x, row: |i| self.row_at(first + i) }),
        }
    }

    /// One row of [`Matrix::product`].
    #[cfg(test)]
    pub fn row_product(&self, i: usize, x: &[Vec3]) -> Vec3 {
        let mut out = [Vec3::zeros()];
        self.rows_product(i, x, &mut out);
        out[0]
    }

    /// Row i in double precision, for a product.
    #[inline(always)]
    fn row_at(&self, i: usize) -> Row<'_> {
        let upper = self.row[i]..self.row[i + 1];
        let lower = &self.lower[self.lower_row[i]..self.lower_row[i + 1]];
        Row { values: &self.values, lower, upper: &self.values[upper.clone()], columns: &self.column[upper] }
    }

    /// Rows and columns of the nonzero blocks.
    pub(super) fn pattern(&self) -> Pattern<'_> {
        Pattern { row: &self.row, column: &self.column, lower_row: &self.lower_row, lower: &self.lower }
    }

    /// Adds `A x` to `out` (n x 3), where x is u at node j and zero elsewhere.
    pub(super) fn add_column(&self, j: usize, u: Vec3, out: &mut [Vec3]) {
        let OffDiagonal { lower, first_slot, columns } = self.pattern().off_diagonal(j);
        out[j] += matrix3(self.diagonal(j)) * u;
        for &LowerBlock { column: i, slot } in lower {
            out[i as usize] += matrix3(&self.block(slot as usize)) * u;
        }
        for (slot, &i) in (first_slot..).zip(columns) {
            out[i as usize] += matrix3(&self.block(slot)).transpose() * u;
        }
    }

    /// Row i of `A x`, where `x(j)` is the vector of node j.
    pub(super) fn row_of(&self, i: usize, x: impl Fn(usize) -> Vec3) -> Vec3 {
        let OffDiagonal { lower, first_slot, columns } = self.pattern().off_diagonal(i);
        let mut sum = matrix3(self.diagonal(i)) * x(i);
        for &LowerBlock { column: j, slot } in lower {
            sum += matrix3(&self.block(slot as usize)).transpose() * x(j as usize);
        }
        for (slot, &j) in (first_slot..).zip(columns) {
            sum += matrix3(&self.block(slot)) * x(j as usize);
        }
        sum
    }

    /// The block in a slot above the diagonal, in double precision.
    fn block(&self, slot: usize) -> Block {
        if self.is_f32 { self.f32_blocks.blocks()[slot].map(f64::from) } else { self.values[slot] }
    }

    /// The diagonal block of a node.
    #[inline(always)]
    pub fn diagonal(&self, i: usize) -> &Block {
        if self.is_f32 { self.f32_blocks.diagonal(i) } else { &self.values[self.row[i]] }
    }

    /// Turns the matrix into one in single precision.
    #[cfg(test)]
    pub(super) fn round(&mut self) {
        self.f32_blocks = F32Blocks::rounded(self.pattern(), &self.values);
        self.is_f32 = true;
    }

    /// Sum of the blocks of row i of a matrix in single precision.
    #[cfg(test)]
    pub(super) fn row_sum(&self, i: usize) -> Block {
        self.f32_blocks.row_sum(i).block()
    }

    /// The loop that computes `out = A x` of a matrix in single precision.
    #[cfg(test)]
    pub(super) fn f32_rows_product<'a>(&'a self, x: &'a [Vec3], out: &'a mut [Vec3]) -> impl Work<Output = ()> + 'a {
        self.f32_blocks.rows_product(self.pattern(), 0, [x], [out])
    }

    /// The stored blocks in double precision, zero if there were none.
    #[cfg(test)]
    pub(super) fn values_mut(&mut self) -> &mut [Block] {
        self.values.resize(self.column.len(), [0.0; 9]);
        &mut self.values
    }

    /// The diagonal block of a node in double precision.
    #[cfg(test)]
    pub(super) fn diagonal_mut(&mut self, i: usize) -> &mut Block {
        let at = self.row[i];
        &mut self.values_mut()[at]
    }

    /// The largest `sum_j |A_ij| / m_i` over scalar rows i of nodes that are not fixed: an upper bound for the eigenvalues of
    /// `M^-1 A` (Gershgorin 1931).
    pub fn gershgorin(&self, mass: &[f64], constraints: &[Constraint]) -> f64 {
        let is_movable = |node: u32| constraints[node as usize] != Constraint::Fixed;
        let mut bound = 0.0_f64;
        for i in (0..self.rows()).filter(|i| is_movable(*i as u32)) {
            let mut sums = [0.0; 3];
            let lower = &self.lower[self.lower_row[i]..self.lower_row[i + 1]];
            for block in lower.iter().filter(|block| is_movable(block.column)) {
                let b = &self.values[block.slot as usize];
                for c in 0..3 {
                    sums[c] += b[c].abs() + b[3 + c].abs() + b[6 + c].abs();
                }
            }
            let upper = self.row[i]..self.row[i + 1];
            let blocks = self.values[upper.clone()].iter().zip(&self.column[upper]);
            for (b, _) in blocks.filter(|(_, j)| is_movable(**j)) {
                for c in 0..3 {
                    sums[c] += b[3 * c].abs() + b[3 * c + 1].abs() + b[3 * c + 2].abs();
                }
            }
            bound = sums.iter().fold(bound, |bound, s| bound.max(s / mass[i]));
        }
        bound
    }
}
