//! Tracks which pages of a long list have changed, so that a viewer copies those alone.

/// Number of entries of a page.
pub const PAGE: usize = 256;

/// The period of the last change of each page of a list. A viewer ends a period when it has copied the list.
#[derive(Clone, Debug)]
pub struct PageStamps {
    /// Period of the last change of each page; 0 where it has not changed.
    stamps: Vec<u64>,
    /// Number of the present period, from 1.
    period: u64,
}

impl Default for PageStamps {
    fn default() -> Self {
        Self { stamps: Vec::new(), period: 1 }
    }
}

impl PageStamps {
    /// Marks an entry as changed.
    pub fn mark(&mut self, entry: u32) {
        let page = entry as usize / PAGE;
        if page >= self.stamps.len() {
            self.stamps.resize(page + 1, 0);
        }
        self.stamps[page] = self.period;
    }

    /// Marks all entries of a list of `count` as changed.
    pub fn mark_all(&mut self, count: usize) {
        self.stamps.clear();
        self.stamps.resize(count.div_ceil(PAGE), self.period);
    }

    /// Marks all entries of a list of `count` as changed, for viewers that have looked at `other` in its place.
    pub fn take_place_of(&mut self, other: &Self, count: usize) {
        self.period = self.period.max(other.period);
        self.mark_all(count);
    }

    /// Ends the present period and returns its number; later changes have larger numbers.
    pub fn end_period(&mut self) -> u64 {
        self.period += 1;
        self.period - 1
    }

    /// Pages that have changed in a period after `period`, ascending.
    pub fn changed_after(&self, period: u64) -> impl Iterator<Item = usize> + '_ {
        self.stamps.iter().enumerate().filter(move |(_, stamp)| **stamp > period).map(|(page, _)| page)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_reader_sees_what_has_changed_since_its_last_look() {
        let mut pages = PageStamps::default();
        pages.mark(0);
        let first = pages.end_period();
        pages.mark(PAGE as u32);
        pages.mark(3 * PAGE as u32 - 1);
        let second = pages.end_period();
        assert_eq!(pages.changed_after(0).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(pages.changed_after(first).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(pages.changed_after(second).count(), 0);
        pages.mark_all(5 * PAGE);
        assert_eq!(pages.changed_after(second).count(), 5);
    }
}
