//! An emulated network for one direction: it loses, delays, repeats and reorders datagrams, and counts what it did.

use std::collections::BTreeSet;
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
}

/// A datagram that is not delivered yet.
struct InFlight {
    /// When it is delivered, ns.
    release_ns: u64,
    /// Order of sending; decides between equal release times.
    order: u64,
    /// Whether a copy of it was delivered already.
    is_repeat: bool,
    datagram: Datagram,
}

/// The datagrams on their way in one direction.
pub struct Network {
    impairments: Impairments,
    /// State of the random numbers.
    random_state: u64,
    in_flight: Vec<InFlight>,
    sent_order: u64,
    /// Highest sequence number delivered.
    newest: u64,
    /// Sequence numbers of lost datagrams above `newest`.
    lost_last: BTreeSet<u64>,
    counts: InjectedCounts,
}

/// Additional delay of a reordered datagram, ns: three datagrams at 1 kHz.
const REORDER_DELAY_NS: u64 = 3_000_000;

impl Network {
    /// An idle network. The same seed gives the same impairments for the same sequence of datagrams.
    pub fn new(impairments: Impairments, seed: u64) -> Self {
        Self {
            impairments,
            random_state: seed,
            in_flight: Vec::new(),
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
            self.in_flight.push(InFlight {
                release_ns: now_ns + self.impairments.delay_ns + jitter_ns + reorder_ns,
                order: self.sent_order,
                is_repeat: false,
                datagram: datagram.clone(),
            });
        }
    }

    /// When the next datagram is to be delivered, ns; none if no datagram is on its way.
    pub fn next_release_ns(&self) -> Option<u64> {
        self.in_flight.iter().map(|d| d.release_ns).min()
    }

    /// Delivers the next datagram that is due at `now_ns`.
    pub fn deliver(&mut self, now_ns: u64) -> Option<Datagram> {
        let due = self.in_flight.iter().enumerate().filter(|(_, d)| d.release_ns <= now_ns);
        let (index, _) = due.min_by_key(|(_, d)| (d.release_ns, d.order))?;
        let InFlight { datagram, is_repeat, .. } = self.in_flight.swap_remove(index);
        if is_repeat {
            self.counts.duplicate += 1;
            return Some(datagram);
        }
        // Which of two copies is the repetition is decided by the order of delivery, not of sending.
        if let Some(copy) = self.in_flight.iter_mut().find(|d| d.datagram.sequence == datagram.sequence) {
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
}
