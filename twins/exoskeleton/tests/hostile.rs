//! A million datagrams nobody should obey, beside one conversation that goes on.

use pliant_exoskeleton::key::Key;
use pliant_exoskeleton::wire::{self, EFFECTORS, Feel, Header, Layout, MOST_BYTES};
use pliant_twin_exoskeleton::{Fingers, Hand, Limits, Path, Twin};
use std::net::SocketAddr;

const LAYOUT: Layout = Layout { rows: 5, columns: 6 };
const MANY: u64 = 1_000_000;
/// ns
const MS: u64 = 1_000_000;

struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

fn host() -> SocketAddr {
    "127.0.0.1:1000".parse().unwrap()
}

/// A command as a host would send it.
fn command(header: &Header, force: f64, layout: Layout, key: Option<&Key>) -> Vec<u8> {
    let mut bytes = [0; MOST_BYTES];
    let feels = [Feel { force: [force, 0.0, 0.0], ..Feel::default() }; EFFECTORS];
    let length = wire::write_command(&mut bytes, layout, header, &feels, key);
    bytes[..length].to_vec()
}

/// A twin that renders 1 N in a conversation, and the header of the command it was told by.
fn pressed(key: Option<&Key>) -> (Twin, Header) {
    let fingers = Fingers::new(Path::default(), Hand::Keyframed, 0.0);
    let mut twin = Twin::new(LAYOUT, key.cloned(), Limits { force: 5.0, taxel: 0.073 }, fingers);
    let hello = Header { from: 77, sequence: 1, time: 1, ..Header::default() };
    assert!(twin.take(&command(&hello, 0.0, LAYOUT, key), host(), MS));
    let mut bytes = [0; MOST_BYTES];
    let (length, to) = twin.tell(&mut bytes, MS, false).expect("it answers");
    assert_eq!(to, host());
    let (told, _) = wire::read_pose(&bytes[..length], LAYOUT, key).expect("its own format");
    let header = Header { to: told.from, sequence: 2, valid: 200_000, ..hello };
    twin.take(&command(&header, 1.0, LAYOUT, key), host(), MS);
    assert_eq!(twin.force(MS), [[1.0, 0.0, 0.0]; 2], "a sound command is obeyed");
    (twin, header)
}

/// One datagram that must not be obeyed, and who sends it.
fn attack(r: &mut Random, header: Header, key: Option<&Key>) -> (Vec<u8>, SocketAddr) {
    let good = Header { sequence: 3 + r.next() % 1000, ..header };
    let sound = |header: &Header| command(header, 3.0, LAYOUT, key);
    let patched = |at: usize, with: &[u8]| {
        // With a checksum that fits, so that it is the value itself that is looked at.
        let mut bytes = command(&good, 3.0, LAYOUT, None);
        bytes[at..at + with.len()].copy_from_slice(with);
        let end = bytes.len() - 4;
        let sum = crc32(&bytes[..end]);
        bytes[end..].copy_from_slice(&sum.to_le_bytes());
        bytes
    };
    let bytes = match r.below(16) {
        0 => (0..r.below(2000)).map(|_| r.next() as u8).collect(),
        1 => {
            let mut bytes = sound(&good);
            let bit = r.below(8 * bytes.len());
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes
        }
        2 => {
            let bytes = sound(&good);
            bytes[..r.below(bytes.len())].to_vec()
        }
        3 => {
            let mut bytes = sound(&good);
            bytes.extend((0..1 + r.below(1200)).map(|_| r.next() as u8));
            bytes
        }
        4 => sound(&Header { to: r.next(), ..good }),
        5 => sound(&Header { from: r.next() | 1, ..good }),
        6 => sound(&Header { from: r.next() | 1, to: 0, ..good }),
        7 => sound(&header),
        8 => sound(&Header { sequence: 1 + r.next() % 2, ..header }),
        9 => command(&good, 3.0, Layout { rows: r.next() as u8 % 12, columns: 7 }, key),
        10 => command(&good, [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][r.below(3)], LAYOUT, key),
        11 => patched(4, &[2 + r.next() as u8 % 200, 0]),
        12 => patched(wire::HEADER + 24, &f32::NAN.to_le_bytes()),
        13 => patched(6 + r.below(2), &[0x80 | r.next() as u8]),
        14 => {
            let other = Key::new(&r.next().to_le_bytes().repeat(2).try_into().unwrap());
            command(&good, 3.0, LAYOUT, Some(&other))
        }
        _ => return (sound(&good), SocketAddr::from(([127, 0, 0, 1], 2000 + r.next() as u16 % 1000))),
    };
    (bytes, host())
}

/// The checksum of the protocol (IEEE 802.3), written anew.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |sum, b| {
        (0..8).fold(sum ^ u32::from(*b), |s, _| if s & 1 == 1 { s >> 1 ^ 0xedb8_8320 } else { s >> 1 })
    })
}

fn a_million(key: Option<&Key>) {
    let (mut twin, header) = pressed(key);
    let (_, obeyed, _) = twin.counts();
    let mut r = Random(0x1234_5678_9abc_def1);
    for i in 0..MANY {
        let (bytes, from) = attack(&mut r, header, key);
        twin.take(&bytes, from, 2 * MS);
        assert_eq!(twin.force(2 * MS), [[1.0, 0.0, 0.0]; 2], "attack {i} was obeyed: {bytes:?} from {from}");
    }
    let (counts, after, _) = twin.counts();
    assert_eq!((obeyed, counts.taken), (after, 2));
    let met = counts.malformed + counts.unauthentic + counts.foreign + counts.duplicate + counts.late;
    assert_eq!(met, MANY, "every one is counted, once: {counts:?}");
    assert!(counts.malformed > MANY / 4 && counts.foreign > MANY / 8 && counts.duplicate > MANY / 16, "{counts:?}");
    // The conversation goes on, and what it says still ends by itself.
    twin.take(&command(&Header { sequence: 3, time: 2 * MS, ..header }, 2.0, LAYOUT, key), host(), 2 * MS);
    assert_eq!(twin.force(2 * MS), [[2.0, 0.0, 0.0]; 2]);
    assert_eq!(twin.force(203 * MS), [[0.0; 3]; 2]);
}

#[test]
fn a_million_hostile_datagrams_are_counted_and_none_is_obeyed() {
    a_million(None);
}

#[test]
fn the_same_with_a_key() {
    a_million(Some(&Key::new(b"0123456789abcdef")));
}

#[test]
fn what_a_host_sent_before_its_goodbye_begins_nothing_after_it() {
    let (mut twin, header) = pressed(None);
    let goodbye = Header { sequence: 50_000, time: 2 * MS, stop: true, last: true, ..header };
    twin.take(&command(&goodbye, 0.0, LAYOUT, None), host(), 2 * MS);
    let before = twin.counts().0;
    let late = Header { sequence: 49_990, time: 2 * MS, ..header };
    assert!(!twin.take(&command(&late, 1.0, LAYOUT, None), host(), 3 * MS), "no conversation");
    let after = twin.counts().0;
    assert_eq!((after.lost, after.foreign), (before.lost, before.foreign + 1), "one datagram of nobody, none lost");
    assert!(twin.force(3 * MS) == [[0.0; 3]; 2] && twin.peer().is_none());
    // Another host is answered.
    let hello = Header { from: 78, sequence: 1, time: 1, ..Header::default() };
    assert!(twin.take(&command(&hello, 0.0, LAYOUT, None), host(), 4 * MS));
}

#[test]
fn poses_that_are_not_sound_are_refused_by_the_host_too() {
    let (mut twin, _) = pressed(None);
    let mut bytes = [0; MOST_BYTES];
    let mut r = Random(99);
    let (length, _) = twin.tell(&mut bytes, MS, false).unwrap();
    assert!(wire::read_pose(&bytes[..length], LAYOUT, None).is_ok());
    for _ in 0..200_000 {
        let mut broken = bytes[..length].to_vec();
        match r.below(3) {
            0 => broken.truncate(r.below(length)),
            1 => broken[r.below(length)] ^= 1 + r.next() as u8 % 255,
            _ => broken.iter_mut().for_each(|b| *b = r.next() as u8),
        }
        assert!(wire::read_pose(&broken, LAYOUT, None).is_err());
    }
}

#[test]
fn forces_over_the_limits_are_cut_and_a_stop_is_at_once() {
    let (mut twin, header) = pressed(None);
    twin.take(&command(&Header { sequence: 3, ..header }, 50.0, LAYOUT, None), host(), MS);
    assert_eq!(twin.force(MS), [[5.0, 0.0, 0.0]; 2]);
    twin.take(&command(&Header { sequence: 4, stop: true, ..header }, 50.0, LAYOUT, None), host(), MS);
    assert_eq!(twin.force(MS), [[0.0; 3]; 2]);
}

#[test]
fn a_recording_of_an_earlier_conversation_moves_nothing() {
    let (mut twin, header) = pressed(None);
    let recorded = command(&Header { sequence: 9, ..header }, 3.0, LAYOUT, None);
    // The host has fallen silent; the recording begins a conversation at most, and says nothing in it.
    twin.take(&recorded, host(), 5_000 * MS);
    for i in 0..100 {
        twin.take(&recorded, host(), (5_000 + i) * MS);
        assert_eq!(twin.force((5_000 + i) * MS), [[0.0; 3]; 2]);
    }
}

#[test]
fn a_greeting_is_heard_and_never_rendered() {
    let (mut twin, header) = pressed(None);
    // The host's own address and number, but not the device's: what one could send who does not hear it.
    for sequence in 3..100 {
        twin.take(&command(&Header { to: 0, sequence, ..header }, 3.0, LAYOUT, None), host(), MS);
        assert_eq!(twin.force(MS), [[1.0, 0.0, 0.0]; 2]);
    }
}
