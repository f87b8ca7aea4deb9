//! The receiving end of a session: accepts a datagram only if it is newer than all before it, counts the others, and estimates how long
//! the content of a datagram is still valid.

/// Counters of received datagrams. Every datagram is counted in exactly one of `accepted`, `late`, `duplicate`, `malformed`,
/// `unauthentic` and `foreign`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReceiveCounts {
    /// Datagrams newer than all before them.
    pub accepted: u64,
    /// Datagrams that arrived after a newer one, for the first time.
    pub late: u64,
    /// Datagrams that had arrived before, or that are too old to tell.
    pub duplicate: u64,
    /// Sequence numbers that have not arrived; falls when one arrives late.
    pub lost: u64,
    /// Datagrams with a wrong length, magic, version, kind, layout, checksum or value, or a sequence number too far ahead.
    pub malformed: u64,
    /// Datagrams without the right key.
    pub unauthentic: u64,
    /// Datagrams from another sender or of another session.
    pub foreign: u64,
    /// Accepted datagrams whose content was no longer valid on arrival.
    pub stale: u64,
}

impl ReceiveCounts {
    /// Names and values, in the order of the fields.
    pub fn named(&self) -> [(&'static str, u64); 8] {
        [
            ("accepted", self.accepted),
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

/// Number of sequence numbers, counted back from the newest, whose arrival is remembered.
const SEQUENCE_WINDOW: u64 = 4096;
/// Largest number of sequence numbers that are skipped at once: 17 minutes at 1 kHz, and a session ends after a minute of silence. A datagram
/// further ahead would make all that follow it old.
const MAX_SKIPPED: u64 = 1 << 20;
/// Largest assumed drift between the two clocks, seconds per second.
const MAX_CLOCK_DRIFT: f64 = 1e-4;

/// The smallest difference of arrival and sending time seen so far: the clock offset plus the shortest travel time.
#[derive(Clone, Copy)]
struct ClockOffset {
    /// Arrival time minus sending time, ns; each is on its own side's clock.
    offset_ns: i128,
    /// When it was updated last, ns on the receiver's clock.
    updated_ns: u64,
}

/// The state of the receiving end of one session.
pub struct Receiver {
    /// The largest sequence number so far.
    newest: u64,
    /// Bit `s % SEQUENCE_WINDOW` tells whether sequence number `s` has arrived, for the last `SEQUENCE_WINDOW` numbers.
    arrived: [u64; (SEQUENCE_WINDOW / 64) as usize],
    /// Estimate from the datagrams so far; `None` before the first.
    clock_offset: Option<ClockOffset>,
}

impl Default for Receiver {
    fn default() -> Self {
        Self { newest: 0, arrived: [0; (SEQUENCE_WINDOW / 64) as usize], clock_offset: None }
    }
}

impl Receiver {
    /// Records the arrival of a sequence number in `counts`. Returns whether it is newer than all before it, that is, whether its
    /// datagram is to be used.
    pub fn accept(&mut self, sequence: u64, counts: &mut ReceiveCounts) -> bool {
        if sequence > self.newest {
            let skipped = sequence - self.newest - 1;
            if skipped > MAX_SKIPPED {
                counts.malformed += 1;
                return false;
            }
            for missing in (self.newest + 1..sequence).rev().take(SEQUENCE_WINDOW as usize) {
                self.set_arrived(missing, false);
            }
            self.set_arrived(sequence, true);
            self.newest = sequence;
            counts.lost = counts.lost.saturating_add(skipped);
            counts.accepted += 1;
            return true;
        }
        if self.newest - sequence >= SEQUENCE_WINDOW || self.has_arrived(sequence) {
            counts.duplicate += 1;
            return false;
        }
        self.set_arrived(sequence, true);
        counts.late += 1;
        counts.lost = counts.lost.saturating_sub(1);
        false
    }

    /// When the content of a datagram expires, ns on the receiver's clock. The datagram was sent at `sent_ns` on the sender's clock, is
    /// valid for `valid_ns` and arrived at `now_ns` on the receiver's clock.
    ///
    /// The clocks are not synchronised: the fastest datagram so far counts as having travelled in no time, and what another travelled
    /// longer than that is subtracted from its validity.
    pub fn expiry_ns(&mut self, sent_ns: u64, valid_ns: u64, now_ns: u64) -> u64 {
        let offset_ns = i128::from(now_ns) - i128::from(sent_ns);
        let smallest_ns = match self.clock_offset {
            None => offset_ns,
            Some(previous) => {
                let drift_ns = MAX_CLOCK_DRIFT * now_ns.saturating_sub(previous.updated_ns) as f64;
                offset_ns.min(previous.offset_ns + drift_ns as i128)
            }
        };
        self.clock_offset = Some(ClockOffset { offset_ns: smallest_ns, updated_ns: now_ns });
        let delay_ns = (offset_ns - smallest_ns).max(0) as u64;
        now_ns + valid_ns.saturating_sub(delay_ns)
    }

    /// Marks a sequence number of the window as arrived or missing.
    fn set_arrived(&mut self, sequence: u64, arrived: bool) {
        let (word, bit) = ((sequence % SEQUENCE_WINDOW / 64) as usize, sequence % 64);
        if arrived {
            self.arrived[word] |= 1 << bit;
        } else {
            self.arrived[word] &= !(1 << bit);
        }
    }

    /// Whether a sequence number of the window has arrived.
    fn has_arrived(&self, sequence: u64) -> bool {
        self.arrived[(sequence % SEQUENCE_WINDOW / 64) as usize] >> (sequence % 64) & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_datagram_is_counted_once() {
        let (mut receiver, mut counts) = (Receiver::default(), ReceiveCounts::default());
        let accepted: Vec<bool> =
            [1, 2, 5, 4, 5, 4, 9, 1].into_iter().map(|s| receiver.accept(s, &mut counts)).collect();
        assert_eq!(accepted, [true, true, true, false, false, false, true, false]);
        assert_eq!((counts.accepted, counts.late, counts.duplicate), (4, 1, 3));
        assert_eq!(counts.lost, 4, "3, 6, 7 and 8");
        receiver.accept(1 << 20, &mut counts);
        receiver.accept((1 << 20) - 5000, &mut counts);
        assert_eq!(counts.duplicate, 4, "older than the window");
    }

    #[test]
    fn a_sequence_number_far_ahead_neither_ends_the_session_nor_counts_as_a_loss() {
        let (mut receiver, mut counts) = (Receiver::default(), ReceiveCounts::default());
        for (number, far) in [u64::MAX, u64::MAX - 1, 1 << 63, 1 << 40, MAX_SKIPPED + 6].into_iter().enumerate() {
            let next = number as u64 + 1;
            assert!(!receiver.accept(far, &mut counts), "{far}");
            assert!(receiver.accept(next, &mut counts), "the session goes on after {far}");
        }
        assert_eq!((counts.lost, counts.accepted), (0, 5));
        let mut sequence = 5;
        for _ in 0..1000 {
            sequence += 1 + MAX_SKIPPED;
            assert!(receiver.accept(sequence, &mut counts));
        }
        assert_eq!(counts.lost, 1000 * MAX_SKIPPED);
    }

    #[test]
    fn a_longer_travel_time_shortens_the_validity() {
        let mut receiver = Receiver::default();
        assert_eq!(receiver.expiry_ns(1_000, 50, 9_000), 9_050);
        assert_eq!(receiver.expiry_ns(2_000, 50, 10_020), 10_050, "20 ns slower than the fastest");
        assert_eq!(receiver.expiry_ns(3_000, 50, 11_900), 11_900, "expired before it arrived");
        assert_eq!(
            receiver.expiry_ns(u64::MAX, 50, 12_000),
            12_050,
            "a wrong sender clock does not extend the validity"
        );
    }
}
