//! A fixed polynomial in a matrix in the place of its inverse (Chebyshev's iteration from zero, on rows over their diagonal).
//!
//! Each row has up to four partners. On a regular mesh rows of one kind have theirs at the same distances: put kind by kind, eight
//! rows have them side by side, a lane is a row and nothing is gathered. Elsewhere it goes row by row. Lanes never meet, so every
//! vector unit gives the same bytes, and each row is computed in one place, so does any number of threads.

use super::pool::Pool;
use pulp::{Simd, WithSimd, bytemuck};

/// Rows of a slice.
const LANES: usize = 8;
/// Numbers of the rows of a slice.
type Slice = [f64; LANES];
/// Distances of a row in its slice, on average, past which going row by row is faster.
const MOST: usize = 12;
/// Bytes that memory comes in.
const LINE: usize = 64;
/// Slices in a piece of work for a thread.
const PIECE: usize = 128;

/// A matrix with a unit diagonal, rows by place, and vectors in its order.
#[derive(Debug, Default)]
pub struct Chebyshev {
    /// Least and greatest eigenvalue, at the widest.
    spectrum: [f64; 2],
    terms: usize,
    /// Row of the given matrix in each place, and over which diagonal; 0 where there is none.
    row: Vec<u32>,
    over: Vec<f64>,
    /// (n)
    place: Vec<u32>,
    rows: Rows,
    /// All between two slices of nothing.
    load: Slices,
    solution: Slices,
    before: Slices,
}

/// What is beside the diagonal, over that of the row.
#[derive(Debug)]
enum Rows {
    /// Of each slice's distances (slices + 1), by distance where the partners of its first row are, and values.
    Alike { start: Vec<usize>, partner: Vec<u32>, value: Slices },
    /// Places of up to four partners, and values.
    Each { partner: Vec<[u32; 4]>, value: Vec<[f64; 4]> },
}

/// Slices that lie where memory is read at once.
#[derive(Debug, Default)]
struct Slices {
    numbers: Vec<f64>,
    first: usize,
    count: usize,
}

impl Slices {
    fn new(of: &[Slice]) -> Self {
        let mut numbers = vec![0.0; LANES * (of.len() + 1)];
        // Where the system does not say, anywhere will do.
        let first = numbers.as_ptr().align_offset(LINE).min(LANES);
        numbers[first..first + LANES * of.len()].copy_from_slice(of.as_flattened());
        Self { numbers, first, count: of.len() }
    }

    #[inline(always)]
    fn flat(&self) -> &[f64] {
        &self.numbers[self.first..self.first + LANES * self.count]
    }

    #[inline(always)]
    fn all(&self) -> &[Slice] {
        self.flat().as_chunks().0
    }

    fn all_mut(&mut self) -> &mut [Slice] {
        self.numbers[self.first..self.first + LANES * self.count].as_chunks_mut().0
    }
}

impl Default for Rows {
    fn default() -> Self {
        Self::Each { partner: Vec::new(), value: Vec::new() }
    }
}

impl Chebyshev {
    /// Of a matrix with this diagonal, whose rows over their diagonal have eigenvalues within `spectrum`; `entries` are the others by
    /// row and column, rising, at most four a row. Rows without a diagonal are as if they were not there.
    pub fn new(diagonal: &[f64], entries: &[(u32, u32, f64)], spectrum: [f64; 2], terms: usize) -> Self {
        let n = diagonal.len();
        let partners = Partners::new(n, entries);
        let order = partners.by_kind();
        let mut this = Self { spectrum, terms, ..Self::default() };
        this.take_order(order, diagonal);
        match this.alike(&partners, diagonal) {
            Some(alike) => this.rows = alike,
            None => {
                this.take_order((0..n as u32).collect(), diagonal);
                this.rows = Self::each(&partners, diagonal);
            }
        }
        let nothing = vec![[0.0; LANES]; n.div_ceil(LANES) + 2];
        (this.load, this.solution, this.before) = (Slices::new(&nothing), Slices::new(&nothing), Slices::new(&nothing));
        this
    }

    fn take_order(&mut self, row: Vec<u32>, diagonal: &[f64]) {
        self.place = vec![0; row.len()];
        for (place, row) in row.iter().enumerate() {
            self.place[*row as usize] = place as u32;
        }
        let over = |row: &u32| if diagonal[*row as usize] > 0.0 { 1.0 / diagonal[*row as usize] } else { 0.0 };
        self.over = row.iter().map(over).collect();
        self.row = row;
    }

    fn alike(&self, partners: &Partners<'_>, diagonal: &[f64]) -> Option<Rows> {
        let (mut start, mut partner, mut value) = (vec![0], Vec::new(), Vec::new());
        for (slice, rows) in self.row.chunks(LANES).enumerate() {
            // Where the first row's partner would be, counted with the slice of nothing before all: a lane's is as many places on.
            let first = |lane: usize, j: u32| self.place[j as usize] + (LANES - lane) as u32;
            let all = |lane: usize| partners.of(rows[lane] as usize).iter().map(move |p| (lane, p));
            let mut firsts: Vec<u32> = (0..rows.len()).flat_map(all).map(|(lane, (_, j, _))| first(lane, *j)).collect();
            firsts.sort_unstable();
            firsts.dedup();
            let own = value.len();
            value.resize(own + firsts.len(), [0.0; LANES]);
            for (lane, (i, j, v)) in (0..rows.len()).flat_map(all) {
                let at = firsts.binary_search(&first(lane, *j)).expect("it is among them");
                value[own + at][lane] += v / diagonal[*i as usize];
            }
            partner.extend(firsts);
            start.push(partner.len());
            debug_assert_eq!(start.len(), slice + 2);
        }
        (partner.len() * LANES <= MOST * diagonal.len()).then(|| Rows::Alike {
            start,
            partner,
            value: Slices::new(&value),
        })
    }

    fn each(partners: &Partners<'_>, diagonal: &[f64]) -> Rows {
        let room = diagonal.len().next_multiple_of(LANES);
        let (mut partner, mut value) = (vec![[0; 4]; room], vec![[0.0; 4]; room]);
        for (row, diagonal) in diagonal.iter().enumerate() {
            for (at, (_, j, v)) in partners.of(row).iter().enumerate() {
                (partner[row][at], value[row][at]) = (j + LANES as u32, v / diagonal);
            }
        }
        Rows::Each { partner, value }
    }

    /// `out = p(A) b`
    pub fn apply(&mut self, pool: &Pool, b: &[f64], out: &mut [f64]) {
        let [low, high] = self.spectrum;
        let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
        let (mut alpha, n) = (1.0 / centre, self.row.len());
        let (row, over) = (&self.row, &self.over);
        let inner = 1..n.div_ceil(LANES) + 1;
        let vectors = (
            &mut self.load.all_mut()[inner.clone()],
            (&mut self.solution.all_mut()[inner.clone()], &mut self.before.all_mut()[inner.clone()]),
        );
        pool.pieces(vectors, PIECE, &|first, (load, (solution, before))| {
            let places = row[LANES * first..].iter().zip(&over[LANES * first..]);
            for ((load, solution), (row, over)) in
                load.as_flattened_mut().iter_mut().zip(solution.as_flattened_mut()).zip(places)
            {
                *load = b[*row as usize] * over;
                *solution = alpha * *load;
            }
            before.fill([0.0; LANES]);
        });
        for k in 1..self.terms {
            let beta = (if k == 1 { 0.5_f64.sqrt() } else { 0.5 } * half * alpha).powi(2);
            alpha = 1.0 / (centre - beta / alpha);
            let mut before = std::mem::take(&mut self.before);
            pool.pieces(&mut before.all_mut()[inner.clone()], PIECE, &|first, next| {
                pulp::Arch::new().dispatch(Term { of: self, first, next, factors: (alpha, beta) });
            });
            self.before = std::mem::replace(&mut self.solution, before);
        }
        let (place, solution) = (&self.place, &self.solution.flat()[LANES..]);
        pool.pieces(out, LANES * PIECE, &|first, out| {
            for (out, place) in out.iter_mut().zip(&place[first..]) {
                *out = solution[*place as usize];
            }
        });
    }
}

/// Entries beside the diagonal, by row.
struct Partners<'a> {
    entries: &'a [(u32, u32, f64)],
    /// (n + 1)
    start: Vec<usize>,
}

impl<'a> Partners<'a> {
    fn new(n: usize, entries: &'a [(u32, u32, f64)]) -> Self {
        let mut start = vec![0; n + 1];
        entries.iter().for_each(|(i, ..)| start[*i as usize + 1] += 1);
        (0..n).for_each(|i| start[i + 1] += start[i]);
        Self { entries, start }
    }

    fn of(&self, row: usize) -> &'a [(u32, u32, f64)] {
        &self.entries[self.start[row]..self.start[row + 1]]
    }

    /// Rows in an order in which those of one kind are together: whose partners are at the same distances.
    fn by_kind(&self) -> Vec<u32> {
        let kind = |row: usize| {
            let mut kind = [i64::MAX; 4];
            for (kind, (i, j, _)) in kind.iter_mut().zip(self.of(row)) {
                *kind = i64::from(*j) - i64::from(*i);
            }
            kind
        };
        let mut order: Vec<([i64; 4], u32)> = (0..self.start.len() - 1).map(|row| (kind(row), row as u32)).collect();
        order.sort_unstable();
        let mut kinds: Vec<&[([i64; 4], u32)]> = order.chunk_by(|a, b| a.0 == b.0).collect();
        kinds.sort_unstable_by_key(|rows| rows[0].1);
        kinds.iter().flat_map(|rows| rows.iter().map(|(_, row)| *row)).collect()
    }
}

/// From the solution so far, and the one before in whose place it is put, the next one.
struct Term<'a> {
    of: &'a Chebyshev,
    first: usize,
    next: &'a mut [Slice],
    factors: (f64, f64),
}

impl WithSimd for Term<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { of, first, next, factors } = self;
        let (load, solution) = (&of.load.all()[1 + first..], of.solution.flat());
        match &of.rows {
            Rows::Alike { start, partner, value } => {
                let value = value.all();
                for (at, (next, load)) in next.iter_mut().zip(load).enumerate() {
                    let (slice, own) = (first + at, LANES * (first + at + 1));
                    let all = start[slice]..start[slice + 1];
                    let (partner, value) = (&partner[all.clone()], &value[all]);
                    for half in (0..LANES).step_by(S::F64_LANES) {
                        let m = read(simd, &solution[own..own + LANES], half);
                        let mut sum = m;
                        if let ([a, b, c, d], [u, v, w, x]) = (partner, value) {
                            // Most slices: without a loop, whose end is guessed wrong where the next one is longer.
                            let one = simd
                                .add_f64s(product(simd, solution, *a, u, half), product(simd, solution, *b, v, half));
                            let two = simd
                                .add_f64s(product(simd, solution, *c, w, half), product(simd, solution, *d, x, half));
                            sum = simd.add_f64s(sum, simd.add_f64s(one, two));
                        } else {
                            for (&partner, value) in partner.iter().zip(value) {
                                sum = simd.add_f64s(sum, product(simd, solution, partner, value, half));
                            }
                        }
                        let before = read(simd, next, half);
                        let rest = simd.sub_f64s(read(simd, load, half), sum);
                        let turn = simd.mul_f64s(simd.splat_f64s(factors.1), simd.sub_f64s(m, before));
                        let step = simd.add_f64s(simd.mul_f64s(simd.splat_f64s(factors.0), rest), turn);
                        let whole = simd.add_f64s(m, step);
                        let bytes = bytemuck::cast_slice_mut::<f64, u8>(&mut next[half..half + S::F64_LANES]);
                        bytes.copy_from_slice(bytemuck::bytes_of(&whole));
                    }
                }
            }
            Rows::Each { partner, value } => {
                let own = LANES * first;
                let rows = next.as_flattened_mut().iter_mut().zip(load.as_flattened());
                for ((next, load), i) in rows.zip(own..) {
                    let (m, [a, b, c, d], v) = (solution[LANES + i], &partner[i], &value[i]);
                    let sum = (v[0] * solution[*a as usize] + v[1] * solution[*b as usize])
                        + (v[2] * solution[*c as usize] + v[3] * solution[*d as usize]);
                    let step = factors.0 * (load - (m + sum)) + factors.1 * (m - *next);
                    *next = m + step;
                }
            }
        }
    }
}

/// Values times what partners have.
#[inline(always)]
fn product<S: Simd>(simd: S, solution: &[f64], partner: u32, value: &Slice, half: usize) -> S::f64s {
    simd.mul_f64s(read(simd, value, half), read(simd, solution, partner as usize + half))
}

#[inline(always)]
fn read<S: Simd>(_: S, from: &[f64], at: usize) -> S::f64s {
    bytemuck::pod_read_unaligned(bytemuck::cast_slice::<f64, u8>(&from[at..at + S::F64_LANES]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPECTRUM: [f64; 2] = [0.3, 1.7];

    /// Rows of three kinds by turns, each beside those of the others; at the ends they have less.
    fn alike(n: usize) -> Vec<(u32, u32, f64)> {
        let mut entries = Vec::new();
        for i in 0..n {
            let far = [17, 31, 44][i % 3];
            for j in [i.checked_sub(far), i.checked_sub(1), Some(i + 1), Some(i + far)].into_iter().flatten() {
                if j < n {
                    entries.push((i as u32, j as u32, 0.3 * (1.0 + ((i * j) as f64).sin()) / 2.0));
                }
            }
        }
        entries
    }

    /// The same by other means: the iteration on steps and residuals, row by row.
    fn plain(diagonal: &[f64], entries: &[(u32, u32, f64)], terms: usize, b: &[f64]) -> Vec<f64> {
        let [low, high] = SPECTRUM;
        let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
        let mut residual: Vec<f64> = b.iter().zip(diagonal).map(|(b, d)| b / d).collect();
        let (mut step, mut out, mut alpha) = (vec![0.0; b.len()], vec![0.0; b.len()], 1.0 / centre);
        for k in 0..terms {
            let beta = [0.0, 0.5 * (half * alpha).powi(2), (0.5 * half * alpha).powi(2)][k.min(2)];
            alpha = if k > 0 { 1.0 / (centre - beta / alpha) } else { alpha };
            step = residual.iter().zip(&step).map(|(r, s)| alpha * r + beta * s).collect::<Vec<f64>>();
            (0..b.len()).for_each(|i| out[i] += step[i]);
            (0..b.len()).for_each(|i| residual[i] -= step[i]);
            entries.iter().for_each(|&(i, j, v)| residual[i as usize] -= v / diagonal[i as usize] * step[j as usize]);
        }
        out
    }

    #[test]
    fn rows_alike_and_each_by_itself_give_the_polynomial_for_any_number_of_threads() {
        let n = 5003;
        let entries = alike(n);
        let diagonal: Vec<f64> = (0..n).map(|i| 2.0 + (i as f64).cos()).collect();
        let b: Vec<f64> = (0..n).map(|i| ((i * i) as f64).sin()).collect();
        let want = plain(&diagonal, &entries, 12, &b);
        let mut sliced = Chebyshev::new(&diagonal, &entries, SPECTRUM, 12);
        assert!(matches!(sliced.rows, Rows::Alike { .. }) && sliced.row.windows(2).any(|rows| rows[1] != rows[0] + 1));
        let mut each = Chebyshev::new(&diagonal, &entries, SPECTRUM, 12);
        each.take_order((0..n as u32).collect(), &diagonal);
        each.rows = Chebyshev::each(&Partners::new(n, &entries), &diagonal);
        for inverse in [&mut sliced, &mut each] {
            let mut first = vec![0.0; n];
            inverse.apply(&Pool::new(1), &b, &mut first);
            let most = want.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            assert!(first.iter().zip(&want).all(|(a, b)| (a - b).abs() < 1e-13 * most));
            for threads in [1, 3] {
                let mut again = vec![0.0; n];
                inverse.apply(&Pool::new(threads), &b, &mut again);
                assert!(first.iter().zip(&again).all(|(a, b)| a.to_bits() == b.to_bits()));
            }
        }
    }

    #[test]
    fn every_vector_unit_gives_the_same_bytes() {
        let n = 1003;
        let mut of = Chebyshev::new(&vec![2.0; n], &alike(n), SPECTRUM, 12);
        let b: Vec<f64> = (0..n).map(|i| ((i * i) as f64).sin()).collect();
        of.apply(&Pool::new(1), &b, &mut vec![0.0; n]);
        let term = |arch: pulp::Arch| {
            let mut next = of.before.all()[1..of.before.count - 1].to_vec();
            arch.dispatch(Term { of: &of, first: 0, next: &mut next, factors: (0.7, 0.2) });
            next.into_iter().flatten().map(f64::to_bits).collect::<Vec<_>>()
        };
        let first = term(pulp::Arch::Scalar);
        assert_eq!(first, term(pulp::Arch::new()));
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = pulp::x86::V3::try_new() {
            assert_eq!(first, term(pulp::Arch::V3(unit)));
        }
    }

    #[test]
    fn rows_that_do_not_lie_alike_and_those_without_a_diagonal() {
        let n = 2000;
        let mut entries = Vec::new();
        for i in 0..n / 2 {
            let j = n / 2 + i * 7919 % (n / 2);
            entries.extend([(i as u32, j as u32, 0.4), (j as u32, i as u32, 0.4)]);
        }
        entries.sort_by_key(|(i, j, _)| (*i, *j));
        let mut diagonal = vec![1.0; n];
        (diagonal[0], diagonal[n / 2]) = (0.0, 0.0);
        entries.retain(|(i, j, _)| ![0, n as u32 / 2].contains(i) && ![0, n as u32 / 2].contains(j));
        let mut inverse = Chebyshev::new(&diagonal, &entries, [0.6, 1.4], 20);
        let mut out = vec![1.0; n];
        inverse.apply(&Pool::new(1), &vec![1.0; n], &mut out);
        for (i, out) in out.iter().enumerate() {
            let want = if diagonal[i] == 0.0 { 0.0 } else { 1.0 / 1.4 };
            assert!((out - want).abs() < 1e-9, "{i}: {out}");
        }
    }
}
