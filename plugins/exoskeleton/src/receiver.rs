//! Newest wins: which datagrams of a conversation are taken, and what became of the others.

/// What was received, and what became of it. Every datagram is in exactly one of `taken`, `late`, `duplicate`, `malformed`,
/// `unauthentic` and `foreign`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Newer than all before.
    pub taken: u64,
    /// Arrived after a newer one.
    pub late: u64,
    /// Arrived before.
    pub duplicate: u64,
    /// Sent and not arrived (yet).
    pub lost: u64,
    /// Length, magic, version, kind, layout, checksum or a value is wrong.
    pub malformed: u64,
    /// Without the right key.
    pub unauthentic: u64,
    /// From another sender or for another conversation.
    pub foreign: u64,
    /// Of those taken: so old on arrival that what it says did not hold any more.
    pub stale: u64,
}

impl Counts {
    /// Names and values, in order.
    pub fn named(&self) -> [(&'static str, u64); 8] {
        [
            ("taken", self.taken),
            ("late", self.late),
            ("duplicate", self.duplicate),
            ("lost", self.lost),
            ("malformed", self.malformed),
            ("unauthentic", self.unauthentic),
            ("foreign", self.foreign),
            ("stale", self.stale),
        ]
    }
}

/// Sequence numbers behind the newest that are told apart.
const WINDOW: u64 = 4096;
/// A sender's clock may run this much slower than ours.
const DRIFT: f64 = 1e-4;

/// The receiving end of one conversation.
pub struct Receiver {
    newest: u64,
    /// Bit `s % WINDOW`: whether `s` has arrived, of the last `WINDOW`.
    seen: [u64; (WINDOW / 64) as usize],
    /// ns, arrival less time of sending, of the fastest so far, and when it was last looked at
    offset: Option<(i128, u64)>,
}

impl Default for Receiver {
    fn default() -> Self {
        Self { newest: 0, seen: [0; (WINDOW / 64) as usize], offset: None }
    }
}

impl Receiver {
    /// Whether a datagram with this number is newer than all before it.
    pub fn is_newest(&mut self, sequence: u64, counts: &mut Counts) -> bool {
        if sequence > self.newest {
            let missed = sequence - self.newest - 1;
            for gone in (self.newest + 1..sequence).rev().take(WINDOW as usize) {
                self.mark(gone, false);
            }
            self.mark(sequence, true);
            self.newest = sequence;
            counts.lost = counts.lost.saturating_add(missed);
            counts.taken += 1;
            return true;
        }
        if self.newest - sequence >= WINDOW || self.is_marked(sequence) {
            counts.duplicate += 1;
            return false;
        }
        self.mark(sequence, true);
        counts.late += 1;
        counts.lost = counts.lost.saturating_sub(1);
        false
    }

    /// ns on our clock: until when a content holds that was sent at `time` (ns, sender's clock), holds for `valid` (ns) and
    /// arrived at `now`. The fastest datagram so far is taken to have taken no time; what another took longer is taken off.
    pub fn deadline(&mut self, time: u64, valid: u64, now: u64) -> u64 {
        let offset = i128::from(now) - i128::from(time);
        let least = match self.offset {
            None => offset,
            Some((least, then)) => offset.min(least + (DRIFT * now.saturating_sub(then) as f64) as i128),
        };
        self.offset = Some((least, now));
        let older = (offset - least).max(0) as u64;
        now + valid.saturating_sub(older)
    }

    fn mark(&mut self, sequence: u64, seen: bool) {
        let (word, bit) = ((sequence % WINDOW / 64) as usize, sequence % 64);
        if seen {
            self.seen[word] |= 1 << bit;
        } else {
            self.seen[word] &= !(1 << bit);
        }
    }

    fn is_marked(&self, sequence: u64) -> bool {
        self.seen[(sequence % WINDOW / 64) as usize] >> (sequence % 64) & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_datagram_is_counted_once() {
        let (mut receiver, mut counts) = (Receiver::default(), Counts::default());
        let taken: Vec<bool> =
            [1, 2, 5, 4, 5, 4, 9, 1].into_iter().map(|s| receiver.is_newest(s, &mut counts)).collect();
        assert_eq!(taken, [true, true, true, false, false, false, true, false]);
        assert_eq!((counts.taken, counts.late, counts.duplicate), (4, 1, 3));
        assert_eq!(counts.lost, 4, "3, 6, 7 and 8");
        receiver.is_newest(1 << 40, &mut counts);
        receiver.is_newest((1 << 40) - 5000, &mut counts);
        assert_eq!(counts.duplicate, 4, "too old to be told apart");
        receiver.is_newest(u64::MAX, &mut counts);
        assert!(!receiver.is_newest(u64::MAX, &mut counts));
    }

    #[test]
    fn what_took_longer_holds_shorter() {
        let mut receiver = Receiver::default();
        assert_eq!(receiver.deadline(1_000, 50, 9_000), 9_050);
        assert_eq!(receiver.deadline(2_000, 50, 10_020), 10_050, "20 ns later than the fastest");
        assert_eq!(receiver.deadline(3_000, 50, 11_900), 11_900, "over before it came");
        assert_eq!(receiver.deadline(u64::MAX, 50, 12_000), 12_050, "a wild clock gains nothing");
    }
}
