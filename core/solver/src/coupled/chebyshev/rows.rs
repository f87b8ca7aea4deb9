//! What is beside the diagonal of a matrix, put kind by kind where rows lie alike.

use super::slices::LANES;

/// Distances of a row in its slice, on average, past which going row by row is faster.
const MOST: usize = 12;
/// Bands at most, and rows of one at least.
const BANDS: usize = 4;
const BAND: usize = 2048;

/// Where what is beside the diagonal has its partners.
#[derive(Debug)]
pub enum Rows {
    /// Of each slice's distances (slices + 1), and by distance where the partners of its first row are.
    Alike { start: Vec<usize>, partner: Vec<u32> },
    /// Places of up to four partners.
    Each { partner: Vec<[u32; 4]> },
}

impl Default for Rows {
    fn default() -> Self {
        Self::Each { partner: Vec::new() }
    }
}

impl Rows {
    /// With the rows of `order`, whose places are `place`, eight at a time, and what is there over the diagonal of the row; `None`
    /// where they do not lie alike.
    pub fn alike(
        partners: &Partners<'_>,
        diagonal: &[f64],
        (order, place): (&[u32], &[u32]),
    ) -> Option<(Self, Vec<f64>)> {
        let (mut start, mut partner, mut value) = (vec![0], Vec::new(), Vec::<[f64; LANES]>::new());
        for rows in order.chunks(LANES) {
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
        let few = partner.len() * LANES <= MOST * diagonal.len();
        few.then(|| (Self::Alike { start, partner }, value.into_flattened()))
    }

    /// Each row by itself, in the order of the matrix.
    pub fn each(partners: &Partners<'_>, diagonal: &[f64]) -> (Self, Vec<f64>) {
        let room = diagonal.len().next_multiple_of(LANES);
        let (mut partner, mut value) = (vec![[0; 4]; room], vec![[0.0; 4]; room]);
        for (row, diagonal) in diagonal.iter().enumerate() {
            for (at, (_, j, v)) in partners.of(row).iter().enumerate() {
                (partner[row][at], value[row][at]) = (j + LANES as u32, v / diagonal);
            }
        }
        (Self::Each { partner }, value.into_flattened())
    }
}

/// Entries beside the diagonal, by row.
pub struct Partners<'a> {
    entries: &'a [(u32, u32, f64)],
    /// (n + 1)
    start: Vec<usize>,
}

impl<'a> Partners<'a> {
    /// Of `n` rows, by row and column, rising.
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
