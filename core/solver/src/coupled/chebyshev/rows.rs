//! Off-diagonal entries of a matrix, sorted by kind of row where rows have the same pattern.

use super::slices::LANES;

/// Mean number of distances in a slice of rows above which going row by row is faster.
const MAX_DISTANCES: usize = 12;
/// Largest number of bands.
const BANDS: usize = 4;
/// Fewest rows of a band.
const BAND: usize = 2048;

/// Columns of the off-diagonal entries.
#[derive(Debug)]
pub enum Rows {
    /// Slices of eight rows with their columns at common distances.
    Banded {
        /// Where the distances of each slice begin (slices + 1).
        start: Vec<usize>,
        /// Column of the slice's first row at each distance.
        partner: Vec<u32>,
    },
    /// Row by row.
    Csr {
        /// Columns of up to four entries of each row.
        partner: Vec<[u32; 4]>,
    },
}

/// Columns with the entries of a matrix, in the same order, each over the diagonal of its row.
pub struct RowValues {
    pub rows: Rows,
    pub values: Vec<f64>,
}

impl Default for Rows {
    fn default() -> Self {
        Self::Csr { partner: Vec::new() }
    }
}

impl Rows {
    /// Rows in the order `row`, with the place of each in `place`, eight at a time; `None` if their columns have too many distances.
    pub fn banded(partners: &Partners<'_>, diagonal: &[f64], row: &[u32], place: &[u32]) -> Option<RowValues> {
        let (mut start, mut partner, mut value) = (vec![0], Vec::new(), Vec::<[f64; LANES]>::new());
        for rows in row.chunks(LANES) {
            // Where the first row's partner would be, counted with the slice of nothing before all: a lane's is as many places on.
            let first = |lane: usize, j: u32| place[j as usize] + (LANES - lane) as u32;
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
        }
        let few = partner.len() * LANES <= MAX_DISTANCES * diagonal.len();
        few.then(|| RowValues { rows: Self::Banded { start, partner }, values: value.into_flattened() })
    }

    /// Csr row by itself, in the order of the matrix.
    pub fn csr(partners: &Partners<'_>, diagonal: &[f64]) -> RowValues {
        let room = diagonal.len().next_multiple_of(LANES);
        let (mut partner, mut value) = (vec![[0; 4]; room], vec![[0.0; 4]; room]);
        for (row, diagonal) in diagonal.iter().enumerate() {
            for (at, (_, j, v)) in partners.of(row).iter().enumerate() {
                (partner[row][at], value[row][at]) = (j + LANES as u32, v / diagonal);
            }
        }
        RowValues { rows: Self::Csr { partner }, values: value.into_flattened() }
    }
}

/// Off-diagonal entries by row.
pub struct Partners<'a> {
    entries: &'a [(u32, u32, f64)],
    /// Where each row begins (n + 1).
    start: Vec<usize>,
}

impl<'a> Partners<'a> {
    /// Entries (row, column, value) of a matrix of `n` rows, sorted by row and column.
    pub fn new(n: usize, entries: &'a [(u32, u32, f64)]) -> Self {
        let mut start = vec![0; n + 1];
        entries.iter().for_each(|(i, ..)| start[*i as usize + 1] += 1);
        (0..n).for_each(|i| start[i + 1] += start[i]);
        Self { entries, start }
    }

    fn of(&self, row: usize) -> &'a [(u32, u32, f64)] {
        &self.entries[self.start[row]..self.start[row + 1]]
    }

    /// Rows in an order in which, in each of a few bands, those of one kind are together: whose partners are at the same distances.
    /// A row's partners are in its own band or in one beside it, near to whatever thread has it.
    pub fn by_kind(&self) -> Vec<u32> {
        let kind = |row: usize| {
            let mut kind = [i64::MAX; 4];
            for (kind, (i, j, _)) in kind.iter_mut().zip(self.of(row)) {
                *kind = i64::from(*j) - i64::from(*i);
            }
            kind
        };
        let n = self.start.len() - 1;
        let band = n.div_ceil(BANDS).max(BAND);
        let mut order: Vec<([i64; 4], u32)> = (0..n).map(|row| (kind(row), row as u32)).collect();
        let mut out = Vec::with_capacity(n);
        for rows in order.chunks_mut(band) {
            rows.sort_unstable();
            let mut kinds: Vec<&[([i64; 4], u32)]> = rows.chunk_by(|a, b| a.0 == b.0).collect();
            kinds.sort_unstable_by_key(|rows| rows[0].1);
            out.extend(kinds.iter().flat_map(|rows| rows.iter().map(|(_, row)| *row)));
        }
        out
    }
}
