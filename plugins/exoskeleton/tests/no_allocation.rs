//! Reading and writing takes nothing from the system's memory.

use pliant_exoskeleton::link::{Link, Say};
use pliant_exoskeleton::wire::{self, EFFECTORS, Feel, Finger, Header, Layout, MOST_BYTES};
use pliant_exoskeleton::{Exoskeleton, key::Key};
use pliant_plugin_api::abi::{Output, Pose};
use pliant_plugin_api::kit::{CountingAllocator, allocations};
use pliant_plugin_api::param::{self, Params, Value};
use pliant_plugin_api::{Device, Fault};
use std::net::UdpSocket;
use std::time::Duration;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

const LAYOUT: Layout = Layout { rows: 5, columns: 6 };

/// Answers every command with a pose, until nothing comes any more.
fn device(socket: &UdpSocket) {
    let (mut bytes, mut sequence) = ([0; MOST_BYTES], 0);
    while let Ok((length, peer)) = socket.recv_from(&mut bytes) {
        let (heard, _) = wire::read_command(&bytes[..length], LAYOUT, None).expect("a command");
        sequence += 1;
        let header = Header { from: 5, to: heard.from, sequence, time: sequence, valid: 50_000, ..Header::default() };
        let finger = Finger { flags: 3, position: [0.01, 0.02, 0.03], ..Finger::default() };
        let length = wire::write_pose(&mut bytes, LAYOUT, &header, &[finger; EFFECTORS], None);
        socket.send_to(&bytes[..length], peer).expect("sent");
    }
}

fn open(peer: &str) -> Result<Exoskeleton, Fault> {
    let mut values = param::defaults(Exoskeleton::INFO.params);
    values[0] = Value::Text(peer.into());
    Exoskeleton::new(&Params::new(Exoskeleton::INFO.params, &values))
}

#[test]
fn read_and_write_take_no_memory() {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(1))).unwrap();
    let peer = socket.local_addr().unwrap().to_string();
    let thread = std::thread::spawn(move || device(&socket));
    let exoskeleton = open(&peer).unwrap();
    let taxels = [0.05; 30];
    let output = |force| Output {
        size: size_of::<Output>(),
        force: [force, 0.0, 0.0],
        torque: [0.0; 3],
        taxels: taxels.as_ptr(),
        valid_until_ns: u64::MAX,
    };
    let mut poses = [Pose::default(); EFFECTORS];
    let before = allocations().expect("counted");
    let (mut valid, mut ticks) = (0, 0);
    // A busy machine may let the other side answer late; all ticks count alike.
    while ticks < 300 || (valid <= 100 && ticks < 100_000) {
        let tick = ticks;
        exoskeleton.read(tick, &mut poses).unwrap();
        valid += poses.iter().filter(|p| p.flags & 1 == 1 && p.position == [0.01, 0.02, 0.03]).count();
        exoskeleton.write(tick, &[output(1.0), output(f64::NAN)]).unwrap();
        exoskeleton.stop();
        std::thread::sleep(Duration::from_micros(200));
        ticks += 1;
    }
    // Asking for the count takes one.
    assert_eq!(allocations().expect("counted") - before, 1);
    assert!(valid > 100, "{valid} poses that hold");
    let refused = (0..).map_while(|index| exoskeleton.counter(index)).find(|(name, _)| *name == c"forces refused");
    assert_eq!(refused, Some((c"forces refused", ticks)));
    drop(exoskeleton);
    thread.join().unwrap();
}

#[test]
fn a_device_that_does_not_answer_is_named_with_what_to_do() {
    let silent = UdpSocket::bind("127.0.0.1:0").unwrap();
    let peer = silent.local_addr().unwrap().to_string();
    let fault = open(&peer).err().expect("nobody answers");
    assert!(fault.reason.contains(&peer) && fault.reason.contains("pliant device emulate"), "{fault}");
    let fault = open("nowhere").err().expect("no address");
    assert!(fault.reason.contains("`peer` is `nowhere`"), "{fault}");
}

#[test]
fn a_key_is_read_from_a_file_and_never_shown() {
    let file = std::env::temp_dir().join(format!("pliant-key-{}", std::process::id()));
    let name = file.to_str().unwrap();
    std::fs::write(&file, "000102030405060708090a0b0c0d0e0f\n").unwrap();
    let key = Key::from_file(name).unwrap_or_else(|e| panic!("{e}"));
    assert!(key.is_tag(b"message", &key.tag(b"message")) && !key.is_tag(b"massage", &key.tag(b"message")));
    std::fs::write(&file, "secret").unwrap();
    let text = Key::from_file(name).err().expect("no key");
    assert!(text.contains(name) && !text.contains("secret"), "{text}");
    std::fs::remove_file(&file).unwrap();
    let link = Link::new("127.0.0.1:9".parse().unwrap(), LAYOUT, Some(key)).unwrap();
    link.send(&[Feel::default(); EFFECTORS], 0, Say::Stop);
}
