//! Times by how often they occurred, in a fixed space: a session may last for hours.

use serde::Serialize;

/// Counts of times in ns, to 0.2 % of each.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: Vec<u64>,
    total: u64,
    most: u64,
}

/// Parts of an octave, as a power of two.
const BITS: u32 = 9;

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: vec![0; place(u64::MAX) + 1], total: 0, most: 0 }
    }
}

fn place(value: u64) -> usize {
    let octave = (u64::BITS - value.leading_zeros()).saturating_sub(BITS + 1);
    ((octave as usize) << BITS) + (value >> octave) as usize
}

/// The largest value of a place.
fn end(place: usize) -> u64 {
    let octave = (place >> BITS).saturating_sub(1);
    let part = (place - (octave << BITS)) as u64;
    ((part + 1) << octave).wrapping_sub(1)
}

impl Histogram {
    /// One more. *Real time*: no allocation.
    pub fn add(&mut self, ns: u64) {
        self.counts[place(ns)] += 1;
        self.total += 1;
        self.most = self.most.max(ns);
    }

    /// How many there are.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// ns, what this share of all does not exceed
    fn at(&self, share: f64) -> u64 {
        let wanted = ((self.total as f64 * share).ceil() as u64).max(1);
        let mut seen = 0;
        let found = self.counts.iter().position(|count| {
            seen += count;
            seen >= wanted
        });
        found.map_or(0, |place| end(place).min(self.most))
    }

    /// `None` of none.
    pub fn spread(&self) -> Option<Spread> {
        let at = |share| self.at(share) as f64 * 1e-9;
        let max = self.most as f64 * 1e-9;
        (self.total > 0).then(|| Spread { p50: at(0.5), p99: at(0.99), p999: at(0.999), max })
    }
}

/// How times spread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// s, the median
    pub p50: f64,
    /// s
    pub p99: f64,
    /// s
    pub p999: f64,
    /// s
    pub max: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_the_sorted_list_to_a_quarter_percent() {
        let mut histogram = Histogram::default();
        let mut list: Vec<u64> = (0..50_000_u64).map(|i| (i * i * 2_654_435_761) % 3_000_017 + i % 7).collect();
        list.iter().for_each(|ns| histogram.add(*ns));
        list.sort_unstable();
        let spread = histogram.spread().unwrap();
        for (share, found) in [(0.5, spread.p50), (0.99, spread.p99), (0.999, spread.p999), (1.0, spread.max)] {
            let exact = list[((list.len() as f64 * share) as usize).min(list.len() - 1)] as f64 * 1e-9;
            assert!((found / exact - 1.0).abs() < 2.5e-3, "{share}: {found} {exact}");
        }
        assert_eq!(spread.max, *list.last().unwrap() as f64 * 1e-9);
    }

    #[test]
    fn every_value_has_one_place_and_places_rise() {
        let mut before = 0;
        for value in
            (0..70_u64).chain((7..64).flat_map(|bit| [(1 << bit) - 1, 1 << bit, (1 << bit) + (1 << (bit - 2))]))
        {
            let at = place(value);
            assert!(at >= before && end(at) >= value, "{value}");
            before = at;
        }
        assert_eq!(end(place(u64::MAX)), u64::MAX);
    }
}
