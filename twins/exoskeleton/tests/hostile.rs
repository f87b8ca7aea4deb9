//! A twin in a session with its host applies none of a million forged, broken or replayed datagrams.

use pliant_exoskeleton::key::Key;
use pliant_exoskeleton::wire::{self, EFFECTOR_COUNT, FingerCommand, Header, MAX_DATAGRAM_BYTES, TaxelLayout};
use pliant_plugin_api::kit::Random;
use pliant_twin_exoskeleton::{Datagram, FingerPath, Fingers, HandModel, Limits, Twin};
use std::net::SocketAddr;

const LAYOUT: TaxelLayout = TaxelLayout { rows: 5, columns: 6 };
const ATTACK_COUNT: u64 = 1_000_000;
/// A millisecond in ns.
const MS: u64 = 1_000_000;

/// A random number from 0 to `bound - 1`.
fn below(random: &mut Random, bound: usize) -> usize {
    (random.next_u64() % bound as u64) as usize
}

fn host_address() -> SocketAddr {
    "127.0.0.1:1000".parse().unwrap()
}

/// The bytes of a command with a force of `force` (N) along x on both fingertips.
fn command(header: &Header, force: f64, layout: TaxelLayout, key: Option<&Key>) -> Vec<u8> {
    let mut bytes = [0; MAX_DATAGRAM_BYTES];
    let fingers = [FingerCommand { force: [force, 0.0, 0.0], ..FingerCommand::default() }; EFFECTOR_COUNT];
    let length = wire::write_command(&mut bytes, layout, header, &fingers, key);
    bytes[..length].to_vec()
}

/// A twin that renders 1 N in a session, and the header of the command that says so.
fn twin_in_contact(key: Option<&Key>) -> (Twin, Header) {
    let fingers = Fingers::new(FingerPath::default(), HandModel::Keyframed, 0.0);
    let mut twin = Twin::new(LAYOUT, key.cloned(), Limits { force: 5.0, taxel_force: 0.073 }, fingers);
    let hello = Header { sender_nonce: 77, sequence: 1, time_ns: 1, ..Header::default() };
    assert!(twin.receive(&command(&hello, 0.0, LAYOUT, key), host_address(), MS).unwrap());
    let Datagram { address, bytes, .. } = twin.next_pose(MS, false).expect("a pose for the new host");
    assert_eq!(address, host_address());
    let (pose_header, _) = wire::read_pose(&bytes, LAYOUT, key).expect("a valid pose");
    let header = Header { receiver_nonce: pose_header.sender_nonce, sequence: 2, valid_us: 200_000, ..hello };
    twin.receive(&command(&header, 1.0, LAYOUT, key), host_address(), MS).unwrap();
    assert_eq!(twin.force(MS), [[1.0, 0.0, 0.0]; 2], "a valid command is applied");
    (twin, header)
}

/// A datagram that must not be applied, and the address it comes from. `header` is that of the last applied command.
fn attack(random: &mut Random, header: Header, key: Option<&Key>) -> (Vec<u8>, SocketAddr) {
    let next = Header { sequence: 3 + random.next_u64() % 1000, ..header };
    let valid = |header: &Header| command(header, 3.0, LAYOUT, key);
    let bytes = match below(random, 16) {
        0 => (0..below(random, 2000)).map(|_| random.next_u64() as u8).collect(),
        // One flipped bit.
        1 => {
            let mut bytes = valid(&next);
            let bit = below(random, 8 * bytes.len());
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes
        }
        // Cut off.
        2 => {
            let bytes = valid(&next);
            bytes[..below(random, bytes.len())].to_vec()
        }
        // Too long.
        3 => {
            let mut bytes = valid(&next);
            bytes.extend((0..1 + below(random, 1200)).map(|_| random.next_u64() as u8));
            bytes
        }
        // Forged by a sender that does not know the device's nonce, the host's nonce, or both.
        4 => valid(&Header { receiver_nonce: random.next_u64(), ..next }),
        5 => valid(&Header { sender_nonce: random.next_u64() | 1, ..next }),
        6 => valid(&Header { sender_nonce: random.next_u64() | 1, receiver_nonce: 0, ..next }),
        // Replayed.
        7 => valid(&header),
        8 => valid(&Header { sequence: 1 + random.next_u64() % 2, ..header }),
        // Other taxels.
        9 => command(&next, 3.0, TaxelLayout { rows: random.next_u64() as u8 % 12, columns: 7 }, key),
        // Values that are not finite.
        10 => command(&next, [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][below(random, 3)], LAYOUT, key),
        11 => patched(&next, wire::HEADER_BYTES + 24, &f32::NAN.to_le_bytes()),
        // Another version, kind or undefined flags.
        12 => patched(&next, 4, &[2 + random.next_u64() as u8 % 200, 0]),
        13 => patched(&next, 6 + below(random, 2), &[0x80 | random.next_u64() as u8]),
        // Another key.
        14 => {
            let other = Key::new(&random.next_u64().to_le_bytes().repeat(2).try_into().unwrap());
            command(&next, 3.0, LAYOUT, Some(&other))
        }
        // Another address.
        _ => return (valid(&next), SocketAddr::from(([127, 0, 0, 1], 2000 + random.next_u64() as u16 % 1000))),
    };
    (bytes, host_address())
}

/// A command with other bytes at an offset and a matching checksum, so that the value is what is rejected.
fn patched(header: &Header, offset: usize, with: &[u8]) -> Vec<u8> {
    let mut bytes = command(header, 3.0, LAYOUT, None);
    bytes[offset..offset + with.len()].copy_from_slice(with);
    let end = bytes.len() - 4;
    let checksum = crc32(&bytes[..end]);
    bytes[end..].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

/// CRC-32 (IEEE 802.3), independent of the crate that the protocol uses.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |sum, b| {
        (0..8).fold(sum ^ u32::from(*b), |s, _| if s & 1 == 1 { s >> 1 ^ 0xedb8_8320 } else { s >> 1 })
    })
}

fn attack_a_session(key: Option<&Key>) {
    let (mut twin, header) = twin_in_contact(key);
    let before = twin.counts();
    let mut random = Random(0x1234_5678_9abc_def1);
    for i in 0..ATTACK_COUNT {
        let (bytes, from) = attack(&mut random, header, key);
        twin.receive(&bytes, from, 2 * MS).unwrap();
        assert_eq!(twin.force(2 * MS), [[1.0, 0.0, 0.0]; 2], "attack {i} was applied: {bytes:?} from {from}");
    }
    let after = twin.counts();
    let received = after.received;
    assert_eq!((after.commands_applied, received.accepted), (before.commands_applied, before.received.accepted));
    let rejected = received.malformed + received.unauthentic + received.foreign + received.duplicate + received.late;
    assert_eq!(rejected, ATTACK_COUNT, "every datagram is counted once: {received:?}");
    // Lower bounds: of the sixteen attacks at least five are malformed, four foreign and two duplicates.
    let all_kinds = received.malformed > ATTACK_COUNT / 4
        && received.foreign > ATTACK_COUNT / 8
        && received.duplicate > ATTACK_COUNT / 16;
    assert!(all_kinds, "{received:?}");
    // The session continues, and its next command expires as usual.
    let next = Header { sequence: 3, time_ns: 2 * MS, ..header };
    twin.receive(&command(&next, 2.0, LAYOUT, key), host_address(), 2 * MS).unwrap();
    assert_eq!(twin.force(2 * MS), [[2.0, 0.0, 0.0]; 2]);
    assert_eq!(twin.force(203 * MS), [[0.0; 3]; 2]);
}

#[test]
fn a_million_hostile_datagrams_are_counted_and_not_applied() {
    attack_a_session(None);
}

#[test]
fn a_million_hostile_datagrams_are_not_applied_with_a_key() {
    attack_a_session(Some(&Key::new(b"0123456789abcdef")));
}

#[test]
fn a_late_command_after_the_goodbye_begins_no_session() {
    let (mut twin, header) = twin_in_contact(None);
    let goodbye = Header { sequence: 50_000, time_ns: 2 * MS, stop: true, last: true, ..header };
    twin.receive(&command(&goodbye, 0.0, LAYOUT, None), host_address(), 2 * MS).unwrap();
    let before = twin.counts().received;
    let late = Header { sequence: 49_990, time_ns: 2 * MS, ..header };
    assert!(!twin.receive(&command(&late, 1.0, LAYOUT, None), host_address(), 3 * MS).unwrap(), "no session begins");
    let after = twin.counts().received;
    assert_eq!((after.lost, after.foreign), (before.lost, before.foreign + 1), "one foreign datagram, none lost");
    assert!(twin.force(3 * MS) == [[0.0; 3]; 2] && twin.host_address().is_none());
    // Another host can connect.
    let hello = Header { sender_nonce: 78, sequence: 1, time_ns: 1, ..Header::default() };
    assert!(twin.receive(&command(&hello, 0.0, LAYOUT, None), host_address(), 4 * MS).unwrap());
}

#[test]
fn the_host_rejects_broken_poses() {
    let (mut twin, _) = twin_in_contact(None);
    let mut random = Random(99);
    let pose = twin.next_pose(MS, false).unwrap().bytes;
    assert!(wire::read_pose(&pose, LAYOUT, None).is_ok());
    for _ in 0..200_000 {
        let mut broken = pose.clone();
        match below(&mut random, 3) {
            0 => broken.truncate(below(&mut random, pose.len())),
            1 => broken[below(&mut random, pose.len())] ^= 1 + random.next_u64() as u8 % 255,
            _ => broken.iter_mut().for_each(|b| *b = random.next_u64() as u8),
        }
        assert!(wire::read_pose(&broken, LAYOUT, None).is_err());
    }
}

#[test]
fn forces_are_clamped_to_the_limit_and_a_stop_is_immediate() {
    let (mut twin, header) = twin_in_contact(None);
    twin.receive(&command(&Header { sequence: 3, ..header }, 50.0, LAYOUT, None), host_address(), MS).unwrap();
    assert_eq!(twin.force(MS), [[5.0, 0.0, 0.0]; 2]);
    let stop = Header { sequence: 4, stop: true, ..header };
    twin.receive(&command(&stop, 50.0, LAYOUT, None), host_address(), MS).unwrap();
    assert_eq!(twin.force(MS), [[0.0; 3]; 2]);
}

#[test]
fn a_replayed_session_renders_nothing() {
    let (mut twin, header) = twin_in_contact(None);
    let recorded = command(&Header { sequence: 9, ..header }, 3.0, LAYOUT, None);
    // After a long silence the recording can begin a session, but it carries the nonce of the old one.
    twin.receive(&recorded, host_address(), 5_000 * MS).unwrap();
    for i in 0..100 {
        twin.receive(&recorded, host_address(), (5_000 + i) * MS).unwrap();
        assert_eq!(twin.force((5_000 + i) * MS), [[0.0; 3]; 2]);
    }
}

#[test]
fn a_command_without_the_nonce_of_the_device_renders_nothing() {
    let (mut twin, header) = twin_in_contact(None);
    // With the address and the nonce of the host: what a sender can forge that does not receive the poses.
    for sequence in 3..100 {
        let forged = Header { receiver_nonce: 0, sequence, ..header };
        twin.receive(&command(&forged, 3.0, LAYOUT, None), host_address(), MS).unwrap();
        assert_eq!(twin.force(MS), [[1.0, 0.0, 0.0]; 2]);
    }
}
