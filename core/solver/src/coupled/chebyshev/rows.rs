//! Storage formats of the entries off the diagonal.

use super::slices::LANES;

/// Largest mean number of distances of a slice at which it is faster than row by row.
const MAX_DISTANCES: usize = 12;
/// Largest number of bands that are sorted by themselves.
const MAX_BANDS: usize = 4;
/// Fewest rows of a band.
const MIN_BAND: usize = 2048;

/// Columns of the entries off the diagonal, as indices into vectors of the iteration: a row's place plus [`LANES`], as these begin with a
/// slice of zeros.
#[derive(Debug)]
pub enum RowFormat {
    /// SELL-8 with distances: slices of eight rows whose entries lie at common distances from the diagonal.
    Sell {
        /// Where the distances of each slice begin (slices + 1).
        start: Vec<usize>,
        /// Column of the first row of the slice at each distance; those of the other rows follow.
        column: Vec<u32>,
    },
    /// ELLPACK: four columns for each row.
    Ellpack {
        /// Columns of the entries of each row; unused ones are 0.
        column: Vec<[u32; 4]>,
    },
}

/// The entries off the diagonal in a format.
pub struct StoredRows {
    /// Columns of the entries of each row.
    pub format: RowFormat,
    /// Entries over the diagonal of their rows, in the order of the columns: eight numbers for each distance of a slice, four for each row.
    pub values: Vec<f64>,
}

impl Default for RowFormat {
    fn default() -> Self {
        Self::Ellpack { column: Vec::new() }
    }
}

impl StoredRows {
    /// Stores rows in the order `row` by slices of eight, where `place` is the place of each row in that order. `None` if slices have too many
    /// distances.
    pub fn sell(entries: &OffDiagonals<'_>, diagonal: &[f64], row: &[u32], place: &[u32]) -> Option<Self> {
        let (mut start, mut column, mut value) = (vec![0], Vec::new(), Vec::<[f64; LANES]>::new());
        for rows in row.chunks(LANES) {
            // Column of the slice's first row at the distance at which this lane has column j.
            let first_column = |lane: usize, j: u32| place[j as usize] + (LANES - lane) as u32;
            let all = |lane: usize| entries.of(rows[lane] as usize).iter().map(move |entry| (lane, entry));
            let columns = (0..rows.len()).flat_map(all).map(|(lane, (_, j, _))| first_column(lane, *j));
            let mut columns: Vec<u32> = columns.collect();
            columns.sort_unstable();
            columns.dedup();
            let first = value.len();
            value.resize(first + columns.len(), [0.0; LANES]);
            for (lane, (i, j, v)) in (0..rows.len()).flat_map(all) {
                let at = columns.binary_search(&first_column(lane, *j)).expect("every column was listed");
                value[first + at][lane] += v / diagonal[*i as usize];
            }
            column.extend(columns);
            start.push(column.len());
        }
        let is_fast = column.len() * LANES <= MAX_DISTANCES * diagonal.len();
        is_fast.then(|| Self { format: RowFormat::Sell { start, column }, values: value.into_flattened() })
    }

    /// Stores rows in the order of the matrix with their columns.
    pub fn ellpack(entries: &OffDiagonals<'_>, diagonal: &[f64]) -> Self {
        let padded = diagonal.len().next_multiple_of(LANES);
        let (mut column, mut value) = (vec![[0; 4]; padded], vec![[0.0; 4]; padded]);
        for (row, diagonal) in diagonal.iter().enumerate() {
            for (at, (_, j, v)) in entries.of(row).iter().enumerate() {
                (column[row][at], value[row][at]) = (j + LANES as u32, v / diagonal);
            }
        }
        Self { format: RowFormat::Ellpack { column }, values: value.into_flattened() }
    }
}

/// Entries off the diagonal by row.
pub struct OffDiagonals<'a> {
    /// Row, column and value of each entry.
    entries: &'a [(u32, u32, f64)],
    /// Where the entries of each row begin (n + 1).
    start: Vec<usize>,
}

impl<'a> OffDiagonals<'a> {
    /// Entries (row, column, value) of a matrix of `n` rows, sorted by row and column.
    pub fn new(n: usize, entries: &'a [(u32, u32, f64)]) -> Self {
        let mut start = vec![0; n + 1];
        entries.iter().for_each(|(i, ..)| start[*i as usize + 1] += 1);
        (0..n).for_each(|i| start[i + 1] += start[i]);
        Self { entries, start }
    }

    /// Entries of a row.
    fn of(&self, row: usize) -> &'a [(u32, u32, f64)] {
        &self.entries[self.start[row]..self.start[row + 1]]
    }

    /// An order of the rows in which, within each of a few bands, rows of one kind are together: those whose entries lie at the same distances
    /// from the diagonal. With bands, the columns of a row stay near it, within its thread's part of the vectors or beside it.
    pub fn by_kind(&self) -> Vec<u32> {
        let distances = |row: usize| {
            let mut distances = [i64::MAX; 4];
            for (distance, (i, j, _)) in distances.iter_mut().zip(self.of(row)) {
                *distance = i64::from(*j) - i64::from(*i);
            }
            distances
        };
        let n = self.start.len() - 1;
        let band = n.div_ceil(MAX_BANDS).max(MIN_BAND);
        let mut order: Vec<([i64; 4], u32)> = (0..n).map(|row| (distances(row), row as u32)).collect();
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
