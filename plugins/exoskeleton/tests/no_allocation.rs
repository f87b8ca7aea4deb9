//! Reading and writing do not allocate, and opening reports what is wrong.

use pliant_exoskeleton::link::{CommandKind, Link};
use pliant_exoskeleton::wire::{
    self, EFFECTOR_COUNT, FINGER_SENSED, FINGER_VELOCITY, FingerCommand, FingerState, Header, MAX_DATAGRAM_BYTES,
    TaxelLayout,
};
use pliant_exoskeleton::{Exoskeleton, key::Key};
use pliant_plugin_api::abi::{Output, POSE_VALID, Pose};
use pliant_plugin_api::kit::{CountingAllocator, allocations};
use pliant_plugin_api::param::{self, Params, Value};
use pliant_plugin_api::{Device, Fault};
use std::net::UdpSocket;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

const LAYOUT: TaxelLayout = TaxelLayout { rows: 5, columns: 6 };
/// Position of both fingertips that the device reports, m.
const POSITION: [f64; 3] = [0.01, 0.02, 0.03];

/// Answers every command with a pose until told to stop; a busy machine may pause for longer than any time-out.
fn answer_commands(socket: &UdpSocket, stop: &AtomicBool) {
    let (mut bytes, mut sequence) = ([0; MAX_DATAGRAM_BYTES], 0);
    while !stop.load(Ordering::Relaxed) {
        let Ok((length, host)) = socket.recv_from(&mut bytes) else { continue };
        let (command, _) = wire::read_command(&bytes[..length], LAYOUT, None).expect("a valid command");
        sequence += 1;
        let header = Header {
            sender_nonce: 5,
            receiver_nonce: command.sender_nonce,
            sequence,
            time_ns: sequence,
            valid_us: 50_000,
            ..Header::default()
        };
        let finger = FingerState { flags: FINGER_SENSED | FINGER_VELOCITY, position: POSITION, ..Default::default() };
        let length = wire::write_pose(&mut bytes, LAYOUT, &header, &[finger; EFFECTOR_COUNT], None);
        socket.send_to(&bytes[..length], host).expect("the pose is sent");
    }
}

fn open(peer: &str) -> Result<Exoskeleton, Fault> {
    let mut values = param::defaults(Exoskeleton::INFO.params);
    values[0] = Value::Text(peer.into());
    Exoskeleton::new(&Params::new(Exoskeleton::INFO.params, &values))
}

#[test]
fn read_and_write_do_not_allocate() {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
    let peer = socket.local_addr().unwrap().to_string();
    let stop = Arc::new(AtomicBool::new(false));
    let told = Arc::clone(&stop);
    let thread = std::thread::spawn(move || answer_commands(&socket, &told));
    let exoskeleton = open(&peer).unwrap();
    let taxels = [0.05; 30];
    let output = |force| Output {
        size: size_of::<Output>(),
        force: [force, 0.0, 0.0],
        torque: [0.0; 3],
        taxels: taxels.as_ptr(),
        valid_until_ns: u64::MAX,
    };
    let mut poses = [Pose::default(); EFFECTOR_COUNT];
    let before = allocations().expect("the counting allocator is installed");
    let (mut valid, mut ticks) = (0, 0);
    // More ticks if the device thread, on a busy machine, answers late.
    while ticks < 300 || (valid <= 100 && ticks < 100_000) {
        exoskeleton.read(ticks, &mut poses).unwrap();
        valid += poses.iter().filter(|p| p.flags & POSE_VALID != 0 && p.position == POSITION).count();
        exoskeleton.write(ticks, &[output(1.0), output(f64::NAN)]).unwrap();
        exoskeleton.stop();
        std::thread::sleep(Duration::from_micros(200));
        ticks += 1;
    }
    // `allocations` itself allocates once, to find out whether the counting allocator is installed.
    assert_eq!(allocations().expect("the counting allocator is installed") - before, 1);
    assert!(valid > 100, "{valid} valid poses");
    let rejected = (0..).map_while(|index| exoskeleton.counter(index)).find(|(name, _)| *name == c"forces rejected");
    assert_eq!(rejected, Some((c"forces rejected", ticks)));
    drop(exoskeleton);
    stop.store(true, Ordering::Relaxed);
    thread.join().unwrap();
}

#[test]
fn opening_a_silent_device_names_its_address_and_a_remedy() {
    let silent = UdpSocket::bind("127.0.0.1:0").unwrap();
    let peer = silent.local_addr().unwrap().to_string();
    let fault = open(&peer).err().expect("no device answers");
    assert!(fault.reason.contains(&peer) && fault.reason.contains("pliant device emulate"), "{fault}");
    let fault = open("nowhere").err().expect("not an address");
    assert!(fault.reason.contains("`peer` is `nowhere`"), "{fault}");
    // An address for documentation (RFC 5737): nothing is sent to it.
    let fault = open("192.0.2.1:48620").err().expect("no key on a network");
    assert!(fault.reason.contains("192.0.2.1 is on a network") && fault.reason.contains("`key`"), "{fault}");
}

#[test]
fn a_malformed_key_file_is_named_and_its_contents_are_not_shown() {
    let file = std::env::temp_dir().join(format!("pliant-key-{}", std::process::id()));
    let name = file.to_str().unwrap();
    std::fs::write(&file, "000102030405060708090a0b0c0d0e0f\n").unwrap();
    #[cfg(unix)]
    for rights in [0o604, 0o620, 0o600] {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(rights)).unwrap();
        if rights != 0o600 {
            let text = Key::from_file(name).err().expect("others may use it");
            assert!(text.contains(name) && text.contains("chmod 600"), "{text}");
        }
    }
    let key = Key::from_file(name).unwrap_or_else(|e| panic!("{e}"));
    assert!(key.verify(b"message", &key.tag(b"message")) && !key.verify(b"massage", &key.tag(b"message")));
    std::fs::write(&file, "secret").unwrap();
    let text = Key::from_file(name).err().expect("not a key");
    assert!(text.contains(name) && !text.contains("secret"), "{text}");
    std::fs::remove_file(&file).unwrap();
    let link = Link::new("127.0.0.1:9".parse().unwrap(), LAYOUT, Some(key)).unwrap();
    link.send(&[FingerCommand::default(); EFFECTOR_COUNT], 0, CommandKind::Stop);
}
