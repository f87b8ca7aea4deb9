//! Shards: the parts of a sweep that processes run.

use std::fmt;
use std::str::FromStr;

/// Shard `number` of `count`: the runs whose index modulo `count` is `number - 1`. Costs that vary along an axis are thus distributed over all
/// shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shard {
    /// Number of the shard, from 1.
    pub number: u64,
    /// Number of shards.
    pub count: u64,
}

impl Default for Shard {
    /// The whole sweep.
    fn default() -> Self {
        Self { number: 1, count: 1 }
    }
}

impl Shard {
    /// Indices of its runs in a sweep of `edits`, ascending.
    pub fn edits(self, edits: u64) -> impl Iterator<Item = u64> {
        (self.number - 1..edits).step_by(self.count as usize)
    }

    /// Number of its runs in a sweep of `edits`.
    pub fn len(self, edits: u64) -> u64 {
        (edits + self.count - self.number) / self.count
    }

    /// Stem of the names of its files.
    pub(crate) fn stem(self) -> String {
        let digits = self.count.to_string().len();
        format!("shard-{:0digits$}-of-{}", self.number, self.count)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}`; allowed is I/N with I from 1 to N, for example 3/8");
        let (number, count) = text.split_once('/').ok_or_else(wrong)?;
        let parse = |part: &str| part.trim().parse::<u64>().map_err(|_| wrong());
        let shard = Self { number: parse(number)?, count: parse(count)? };
        if (1..=shard.count).contains(&shard.number) { Ok(shard) } else { Err(wrong()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_together_are_the_sweep() {
        for (edits, count) in [(0, 1), (1, 8), (7, 8), (8, 8), (100, 7)] {
            let mut all: Vec<u64> = Vec::new();
            for number in 1..=count {
                let shard = Shard { number, count };
                let own: Vec<u64> = shard.edits(edits).collect();
                assert_eq!(own.len() as u64, shard.len(edits), "{shard} of {edits}");
                all.extend(own);
            }
            all.sort_unstable();
            assert_eq!(all, (0..edits).collect::<Vec<_>>());
        }
    }

    #[test]
    fn shards_are_written_from_one() {
        assert_eq!("3/8".parse(), Ok(Shard { number: 3, count: 8 }));
        for wrong in ["0/8", "9/8", "3", "a/8", "3/0", "-1/2"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
        assert_eq!(Shard { number: 3, count: 16 }.stem(), "shard-03-of-16");
    }
}
