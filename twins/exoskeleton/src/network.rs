//! A bad network, played for both directions: it loses, delays, repeats and reorders, and counts what it did.

use std::collections::BTreeSet;
use std::net::SocketAddr;

/// How bad it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weather {
    /// Share of datagrams that get lost.
    pub loss: f64,
    /// ns, every datagram
    pub delay: u64,
    /// ns, at most, on top of it, evenly spread
    pub jitter: u64,
    /// Share that arrives twice.
    pub duplicates: f64,
    /// Share that is held back so long that later ones overtake it.
    pub reorder: f64,
}

/// What was done, in the words of who receives it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Injected {
    /// Handed in.
    pub sent: u64,
    /// Lost, and a later one has passed.
    pub lost: u64,
    /// Lost since the last that has passed.
    pub lost_last: u64,
    /// Passed a second time.
    pub duplicate: u64,
    /// Passed the first time after a later one.
    pub late: u64,
}

struct Held {
    release: u64,
    order: u64,
    number: u64,
    again: bool,
    address: SocketAddr,
    bytes: Vec<u8>,
}

/// Datagrams on their way in one direction.
pub struct Network {
    weather: Weather,
    state: u64,
    held: Vec<Held>,
    order: u64,
    newest: u64,
    lost: BTreeSet<u64>,
    injected: Injected,
}

/// ns, how long a reordered datagram is held back besides
const HELD_BACK: u64 = 3_000_000;

impl Network {
    /// The same seed does the same to the same datagrams.
    pub fn new(weather: Weather, seed: u64) -> Self {
        let (held, lost, injected) = (Vec::new(), BTreeSet::new(), Injected::default());
        Self { weather, state: seed, held, order: 0, newest: 0, lost, injected }
    }

    /// From 0 to 1 (Steele, Lea and Flood 2014).
    fn random(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A conversation begins: numbers start anew. What is held back of the one before is dropped.
    pub fn begin(&mut self) {
        self.injected.lost_last += self.lost.len() as u64;
        (self.newest, self.lost) = (0, BTreeSet::new());
        self.held.clear();
    }

    /// Hands in a datagram with its sequence number and the other side's address at `now` (ns).
    pub fn send(&mut self, bytes: &[u8], (number, address): (u64, SocketAddr), now: u64) {
        self.injected.sent += 1;
        if self.random() < self.weather.loss {
            self.lost.insert(number);
            return;
        }
        let twice = self.random() < self.weather.duplicates;
        for again in [false, true] {
            if again && !twice {
                break;
            }
            let back = if self.random() < self.weather.reorder { HELD_BACK } else { 0 };
            let jitter = (self.random() * self.weather.jitter as f64) as u64;
            let release = now + self.weather.delay + jitter + back;
            self.order += 1;
            let bytes = bytes.to_vec();
            self.held.push(Held { release, order: self.order, number, again: false, address, bytes });
        }
        // Which of two copies is the repeated one is known when they pass.
        if twice {
            self.held.last_mut().expect("just put there").again = true;
        }
    }

    /// ns, when the next is due
    pub fn next(&self) -> Option<u64> {
        self.held.iter().map(|h| h.release).min()
    }

    /// The next that is due at `now` (ns).
    pub fn pass(&mut self, now: u64) -> Option<(Vec<u8>, SocketAddr)> {
        let due = self.held.iter().enumerate().filter(|(_, h)| h.release <= now);
        let place = due.min_by_key(|(_, h)| (h.release, h.order)).map(|(place, _)| place)?;
        let held = self.held.swap_remove(place);
        let other = self.held.iter_mut().find(|h| h.number == held.number);
        match other {
            // The copy that is left is the repeated one, whichever was handed in first.
            Some(other) => other.again = true,
            None if held.again => {
                self.injected.duplicate += 1;
                return Some((held.bytes, held.address));
            }
            None => {}
        }
        if held.number > self.newest {
            self.newest = held.number;
            let still = self.lost.split_off(&held.number);
            self.injected.lost += self.lost.len() as u64;
            self.lost = still;
        } else {
            self.injected.late += 1;
        }
        Some((held.bytes, held.address))
    }

    /// A datagram with this number has gone past it, unharmed.
    pub fn passed_by(&mut self, number: u64) {
        self.newest = self.newest.max(number);
        self.injected.lost += self.lost.len() as u64;
        self.lost.clear();
    }

    /// What was done so far.
    pub fn injected(&self) -> Injected {
        Injected { lost_last: self.injected.lost_last + self.lost.len() as u64, ..self.injected }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_counts_is_what_passes() {
        let weather = Weather { loss: 0.2, delay: 1_000_000, jitter: 5_000_000, duplicates: 0.1, reorder: 0.1 };
        let mut network = Network::new(weather, 7);
        let address = "127.0.0.1:1".parse().unwrap();
        let (mut seen, mut newest) = (BTreeSet::new(), 0);
        let (mut late, mut duplicate) = (0, 0);
        for tick in 1..=20_000_u64 {
            network.send(&tick.to_le_bytes(), (tick, address), tick * 1_000_000);
            let last = if tick == 20_000 { u64::MAX } else { tick * 1_000_000 };
            while let Some((bytes, _)) = network.pass(last) {
                let number = u64::from_le_bytes(bytes.try_into().unwrap());
                if !seen.insert(number) {
                    duplicate += 1;
                } else if number < newest {
                    late += 1;
                }
                newest = newest.max(number);
            }
        }
        let injected = network.injected();
        let lost = 20_000 - seen.len() as u64;
        assert_eq!((injected.sent, injected.lost + injected.lost_last), (20_000, lost));
        assert_eq!((injected.late, injected.duplicate), (late, duplicate));
        assert!((3_700..4_300).contains(&lost) && (1_400..1_800).contains(&duplicate) && late > 1_000, "{injected:?}");
    }
}
