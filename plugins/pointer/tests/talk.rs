//! Someone sends places and gets forces.

use pliant_plugin_api::Device;
use pliant_plugin_api::abi::{Output, Pose};
use pliant_plugin_api::kit::{CountingAllocator, allocations};
use pliant_plugin_api::param::{self, Params, Value};
use pliant_pointer::Pointer;
use std::net::UdpSocket;
use std::time::{Duration, Instant};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

fn open(address: &str, hold: f64) -> Pointer {
    let mut values = param::defaults(Pointer::INFO.params);
    (values[0], values[1]) = (Value::Text(address.into()), Value::Number(hold));
    Pointer::new(&Params::new(Pointer::INFO.params, &values)).unwrap_or_else(|e| panic!("{e}"))
}

/// Reads until a pose is there or not.
fn read(pointer: &Pointer, valid: bool) -> Pose {
    let (begun, mut poses) = (Instant::now(), [Pose::default()]);
    while (poses[0].flags & 1 == 1) != valid || begun.elapsed() < Duration::from_millis(20) {
        assert!(begun.elapsed() < Duration::from_secs(10), "it never comes");
        pointer.read(0, &mut poses).unwrap();
    }
    poses[0]
}

fn output(force: [f64; 3]) -> [Output; 1] {
    let (size, taxels, valid_until_ns) = (size_of::<Output>(), std::ptr::null(), 100);
    [Output { size, force, torque: [0.0; 3], taxels, valid_until_ns }]
}

#[test]
fn places_go_in_and_forces_come_out() {
    let pointer = open("127.0.0.1:0", 0.3);
    assert_eq!(read(&pointer, false).flags, 0, "nobody has moved it");
    let user = UdpSocket::bind("127.0.0.1:0").unwrap();
    user.connect(pointer.address().unwrap()).unwrap();
    user.send(b"0.01 0.02 0.5 3").unwrap();
    let pose = read(&pointer, true);
    assert_eq!((pose.position, pose.buttons), ([0.01, 0.02, 0.1], 3), "within its workspace");
    user.send(b"nan 0 0").unwrap();
    assert_eq!(read(&pointer, true).position, pose.position);
    assert_eq!(pointer.counter(1), Some((c"lines refused", 1)));
    pointer.write(1, &output([33.0, 0.0, 0.0])).unwrap();
    let mut bytes = [0; 64];
    let length = user.recv(&mut bytes).unwrap();
    assert_eq!(&bytes[..length], b"3.300000 0.000000 0.000000\n");
    let mut felt = output([0.0; 3]);
    pointer.rendered(99, &mut felt).unwrap();
    assert!((felt[0].force[0] - 3.3).abs() < 1e-12);
    pointer.rendered(100, &mut felt).unwrap();
    assert_eq!(felt[0].force[0], 0.0, "over when its time is");
    assert_eq!(read(&pointer, false).flags, 0, "let go");
}

#[test]
fn reading_and_writing_takes_no_memory() {
    let pointer = open("127.0.0.1:0", 10.0);
    let user = UdpSocket::bind("127.0.0.1:0").unwrap();
    user.send_to(b"0 0 0", pointer.address().unwrap()).unwrap();
    read(&pointer, true);
    let mut poses = [Pose::default()];
    let before = allocations().expect("counted");
    for _ in 0..100 {
        user.send_to(b"0.001 -0.002 0.003 1", pointer.address().unwrap()).unwrap();
        pointer.read(0, &mut poses).unwrap();
        pointer.write(0, &output([f64::NAN, 1.0, 0.0])).unwrap();
    }
    assert_eq!(allocations().expect("counted") - before, 1, "the count itself");
}

#[test]
fn a_port_in_use_is_told() {
    let pointer = open("127.0.0.1:0", 1.0);
    let address = pointer.address().unwrap().to_string();
    let mut values = param::defaults(Pointer::INFO.params);
    values[0] = Value::Text(address.clone());
    let found = Pointer::probe(&Params::new(Pointer::INFO.params, &values));
    assert!(found[0].found.contains(&address) && found[0].remedy.contains("address"), "{found:?}");
    drop(pointer);
    let found = Pointer::probe(&Params::new(Pointer::INFO.params, &values));
    assert!(found[0].remedy.is_empty(), "{found:?}");
}
