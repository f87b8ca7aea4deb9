//! A histogram of times with constant memory, for sessions of hours.

use serde::Serialize;

/// Counts of times (ns) in logarithmic buckets of 0.2 % width.
#[derive(Clone, Debug)]
pub struct Histogram {
    /// Count of each bucket.
    counts: Vec<u64>,
    total: u64,
    /// Largest time, ns.
    longest: u64,
}

/// Binary logarithm of the number of buckets per octave.
const BUCKET_BITS: u32 = 9;

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: vec![0; bucket(u64::MAX) + 1], total: 0, longest: 0 }
    }
}

/// The bucket of a value.
fn bucket(value: u64) -> usize {
    let octave = (u64::BITS - value.leading_zeros()).saturating_sub(BUCKET_BITS + 1);
    ((octave as usize) << BUCKET_BITS) + (value >> octave) as usize
}

/// The largest value of a bucket.
fn upper_bound(bucket: usize) -> u64 {
    let octave = (bucket >> BUCKET_BITS).saturating_sub(1);
    let part = (bucket - (octave << BUCKET_BITS)) as u64;
    ((part + 1) << octave).wrapping_sub(1)
}

impl Histogram {
    /// Counts one time (ns). *Real time*: no allocation.
    pub fn add(&mut self, ns: u64) {
        self.counts[bucket(ns)] += 1;
        self.total += 1;
        self.longest = self.longest.max(ns);
    }

    /// Smallest bucket bound that this fraction (0 to 1) of all times does not exceed, ns.
    fn percentile(&self, fraction: f64) -> u64 {
        let wanted = ((self.total as f64 * fraction).ceil() as u64).max(1);
        let mut seen = 0;
        let found = self.counts.iter().position(|count| {
            seen += count;
            seen >= wanted
        });
        found.map_or(0, |bucket| upper_bound(bucket).min(self.longest))
    }

    /// Percentiles of all times counted; `None` without any.
    pub fn percentiles(&self) -> Option<Percentiles> {
        let at = |fraction| self.percentile(fraction) as f64 * 1e-9;
        let max = self.longest as f64 * 1e-9;
        (self.total > 0).then(|| Percentiles { p50: at(0.5), p99: at(0.99), p999: at(0.999), max })
    }
}

/// Percentiles of a set of times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Percentiles {
    /// Median of the durations, s.
    pub p50: f64,
    /// 99th percentile, s.
    pub p99: f64,
    /// 99.9th percentile, s.
    pub p999: f64,
    /// Longest of the durations, s.
    pub max: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_sorted_list_to_a_quarter_percent() {
        let mut histogram = Histogram::default();
        let mut list: Vec<u64> = (0..50_000_u64).map(|i| (i * i * 2_654_435_761) % 3_000_017 + i % 7).collect();
        list.iter().for_each(|ns| histogram.add(*ns));
        list.sort_unstable();
        let spread = histogram.percentiles().unwrap();
        for (fraction, found) in [(0.5, spread.p50), (0.99, spread.p99), (0.999, spread.p999), (1.0, spread.max)] {
            let exact = list[((list.len() as f64 * fraction) as usize).min(list.len() - 1)] as f64 * 1e-9;
            assert!((found / exact - 1.0).abs() < 2.5e-3, "{fraction}: {found} {exact}");
        }
        assert_eq!(spread.max, *list.last().unwrap() as f64 * 1e-9);
    }

    #[test]
    fn every_value_has_a_bucket_and_buckets_rise() {
        let mut before = 0;
        for value in
            (0..70_u64).chain((7..64).flat_map(|bit| [(1 << bit) - 1, 1 << bit, (1 << bit) + (1 << (bit - 2))]))
        {
            let at = bucket(value);
            assert!(at >= before && upper_bound(at) >= value, "{value}");
            before = at;
        }
        assert_eq!(upper_bound(bucket(u64::MAX)), u64::MAX);
    }
}
