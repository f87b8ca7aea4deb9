//! The vector units of x86-64.

mod avx2;
mod avx512;
mod blocks;

/// Places of each of four numbers, four times.
const EACH_FOUR: [[u32; 8]; 2] = [[0, 0, 0, 0, 1, 1, 1, 1], [2, 2, 2, 2, 3, 3, 3, 3]];

/// As many numbers as a register takes, from the beginning of a slice.
#[inline(always)]
fn first<T, const N: usize>(from: &[T]) -> &[T; N] {
    from.first_chunk().expect("as many as registers take")
}
