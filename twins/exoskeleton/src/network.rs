//! An emulated network for one direction: it loses, delays, repeats and reorders datagrams, and counts what it did.

use std::collections::{BTreeMap, BTreeSet};
use std::net::SocketAddr;

/// A datagram on its way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Datagram {
    /// Its sequence number in its session; 0 if it has none.
    pub sequence: u64,
    /// Address of the other side: the receiver, or the sender of an incoming one.
    pub address: SocketAddr,
    /// Payload of the datagram, as it is sent.
    pub bytes: Vec<u8>,
}

/// What the network does to datagrams. Shares are probabilities per datagram, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impairments {
    /// Share of datagrams that are lost.
    pub loss: f64,
    /// Delay of every datagram, ns.
    pub delay_ns: u64,
    /// Largest additional delay, ns; uniformly distributed from 0.
    pub jitter_ns: u64,
    /// Share of datagrams that are delivered twice.
    pub duplicates: f64,
    /// Share of datagrams that are delayed by a further 3 ms, so that later ones overtake them.
    pub reorder: f64,
}

/// What the network did, counted as the receiver of the datagrams would count it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InjectedCounts {
    /// Datagrams given to the network.
    pub sent: u64,
    /// Lost datagrams after which a later one was delivered, so that the receiver can know of the loss.
    pub lost: u64,
    /// Datagrams lost after the last delivered one.
    pub lost_last: u64,
    /// Datagrams delivered a second time.
    pub duplicate: u64,
    /// Datagrams delivered for the first time after a later one.
    pub late: u64,
    /// Datagrams dropped as more were on their way than one side sends.
    pub overflow: u64,
}

/// When a datagram is delivered, in ns, and its order of sending, which decides between equal times.
type Release = (u64, u64);

/// A datagram that is not delivered yet.
struct InFlight {
    /// Whether a copy of it was delivered already.
    is_repeat: bool,
    datagram: Datagram,
}

/// The datagrams on their way in one direction.
pub struct Network {
    impairments: Impairments,
    /// State of the random numbers.
    random_state: u64,
    in_flight: BTreeMap<Release, InFlight>,
    /// Most datagrams on their way; those beyond it are dropped.
    capacity: usize,
    sent_order: u64,
    /// Highest sequence number delivered.
    newest: u64,
    /// Sequence numbers of lost datagrams above `newest`.
    lost_last: BTreeSet<u64>,
    counts: InjectedCounts,
}

/// Additional delay of a reordered datagram, ns: three datagrams at 1 kHz.
const REORDER_DELAY_NS: u64 = 3_000_000;
/// Highest rate at which one side sends, Hz; every datagram may be on its way twice.
const MAX_RATE: f64 = 4000.0;
/// Datagrams on their way besides those that the delay keeps there.
const SPARE_CAPACITY: usize = 1024;

impl Network {
    /// An idle network. The same seed gives the same impairments for the same sequence of datagrams.
    pub fn new(impairments: Impairments, seed: u64) -> Self {
        let longest_ns = impairments.delay_ns.saturating_add(impairments.jitter_ns).saturating_add(REORDER_DELAY_NS);
        Self {
            impairments,
            random_state: seed,
            in_flight: BTreeMap::new(),
            capacity: SPARE_CAPACITY + (2.0 * MAX_RATE * 1e-9 * longest_ns as f64) as usize,
            sent_order: 0,
            newest: 0,
            lost_last: BTreeSet::new(),
            counts: InjectedCounts::default(),
        }
    }

    /// A uniform random number from 0 to 1: SplitMix64 (Steele, Lea and Flood 2014).
    fn random(&mut self) -> f64 {
        self.random_state = self.random_state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.random_state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Begins a session: sequence numbers start anew, and datagrams of the old session are dropped.
    pub fn begin_session(&mut self) {
        self.counts.lost_last += self.lost_last.len() as u64;
        self.newest = 0;
        self.lost_last.clear();
        self.in_flight.clear();
    }

    /// Gives a datagram to the network at `now_ns`.
    pub fn send(&mut self, datagram: Datagram, now_ns: u64) {
        if self.in_flight.len() >= self.capacity {
            self.counts.overflow += 1;
            return;
        }
        self.counts.sent += 1;
        if self.random() < self.impairments.loss {
            self.lost_last.insert(datagram.sequence);
            return;
        }
        let copies = if self.random() < self.impairments.duplicates { 2 } else { 1 };
        for _ in 0..copies {
            let reorder_ns = if self.random() < self.impairments.reorder { REORDER_DELAY_NS } else { 0 };
            let jitter_ns = (self.random() * self.impairments.jitter_ns as f64) as u64;
            self.sent_order += 1;
            let release_ns = now_ns + self.impairments.delay_ns + jitter_ns + reorder_ns;
            let in_flight = InFlight { is_repeat: false, datagram: datagram.clone() };
            self.in_flight.insert((release_ns, self.sent_order), in_flight);
        }
    }

    /// When the next datagram is to be delivered, ns; none if no datagram is on its way.
    pub fn next_release_ns(&self) -> Option<u64> {
        self.in_flight.first_key_value().map(|((release_ns, _), _)| *release_ns)
    }

    /// Delivers the next datagram that is due at `now_ns`.
    pub fn deliver(&mut self, now_ns: u64) -> Option<Datagram> {
        let next = self.in_flight.first_entry().filter(|next| next.key().0 <= now_ns)?;
        let InFlight { datagram, is_repeat } = next.remove();
        if is_repeat {
            self.counts.duplicate += 1;
            return Some(datagram);
        }
        // Which of two copies is the repetition is decided by the order of delivery, not of sending.
        if self.impairments.duplicates > 0.0
            && let Some(copy) = self.in_flight.values_mut().find(|d| d.datagram.sequence == datagram.sequence)
        {
            copy.is_repeat = true;
        }
        if datagram.sequence > self.newest {
            self.set_newest(datagram.sequence);
        } else {
            self.counts.late += 1;
        }
        Some(datagram)
    }

    /// Records that a datagram was delivered without passing through the network.
    pub fn bypass(&mut self, sequence: u64) {
        self.set_newest(self.newest.max(sequence));
    }

    /// Counts the lost datagrams below the newest delivered one.
    fn set_newest(&mut self, sequence: u64) {
        self.newest = sequence;
        let later = self.lost_last.split_off(&sequence);
        self.counts.lost += self.lost_last.len() as u64;
        self.lost_last = later;
    }

    /// What the network did so far.
    pub fn counts(&self) -> InjectedCounts {
        InjectedCounts { lost_last: self.counts.lost_last + self.lost_last.len() as u64, ..self.counts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_counts_agree_with_what_the_receiver_sees() {
        const COUNT: u64 = 20_000;
        const MS: u64 = 1_000_000;
        let impairments = Impairments { loss: 0.2, delay_ns: MS, jitter_ns: 5 * MS, duplicates: 0.1, reorder: 0.1 };
        let mut network = Network::new(impairments, 7);
        let address = "127.0.0.1:1".parse().unwrap();
        let (mut arrived, mut newest) = (BTreeSet::new(), 0);
        let (mut late, mut duplicate) = (0, 0);
        for sequence in 1..=COUNT {
            network.send(Datagram { sequence, address, bytes: Vec::new() }, sequence * MS);
            let now_ns = if sequence == COUNT { u64::MAX } else { sequence * MS };
            while let Some(Datagram { sequence, .. }) = network.deliver(now_ns) {
                if !arrived.insert(sequence) {
                    duplicate += 1;
                } else if sequence < newest {
                    late += 1;
                }
                newest = newest.max(sequence);
            }
        }
        let counts = network.counts();
        let lost = COUNT - arrived.len() as u64;
        assert_eq!((counts.sent, counts.lost + counts.lost_last), (COUNT, lost));
        assert_eq!((counts.late, counts.duplicate), (late, duplicate));
        // Expected are 20 % lost and 10 % of the others repeated; the bounds are more than five standard deviations away.
        assert!((3_700..4_300).contains(&lost) && (1_400..1_800).contains(&duplicate) && late > 1_000, "{counts:?}");
    }

    #[test]
    fn a_flood_is_dropped_and_what_one_side_sends_is_not() {
        let address = "127.0.0.1:1".parse().unwrap();
        let impairments = Impairments { delay_ns: 10_000_000_000, duplicates: 1.0, ..Impairments::default() };
        let mut network = Network::new(impairments, 3);
        let tick_ns = (1e9 / MAX_RATE) as u64;
        let give = |network: &mut Network, now_ns| {
            network.send(Datagram { sequence: now_ns / tick_ns + 1, address, bytes: Vec::new() }, now_ns);
            while network.deliver(now_ns).is_some() {}
        };
        (0..100_000).for_each(|tick| give(&mut network, tick * tick_ns));
        assert_eq!(network.counts().overflow, 0);
        (0..100_000).for_each(|_| give(&mut network, 100_000 * tick_ns));
        assert!(network.counts().overflow > 90_000 && network.in_flight.len() <= network.capacity + 1);
    }
}
