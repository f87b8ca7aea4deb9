//! A program sends positions and receives forces.

use pliant_plugin_api::Device;
use pliant_plugin_api::abi::{Output, POSE_VALID, Pose};
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

/// Reads until the pose is valid, or until it is not.
fn read(pointer: &Pointer, valid: bool) -> Pose {
    let (begin, mut poses) = (Instant::now(), [Pose::default()]);
    while (poses[0].flags & POSE_VALID != 0) != valid || begin.elapsed() < Duration::from_millis(20) {
        assert!(begin.elapsed() < Duration::from_secs(10), "no such pose within 10 s");
        pointer.read(0, &mut poses).unwrap();
    }
    poses[0]
}

fn output(force: [f64; 3]) -> [Output; 1] {
    let (size, taxels, valid_until_ns) = (size_of::<Output>(), std::ptr::null(), 100);
    [Output { size, force, torque: [0.0; 3], taxels, valid_until_ns }]
}

#[test]
fn positions_are_read_and_forces_answered() {
    let pointer = open("127.0.0.1:0", 0.3);
    assert_eq!(read(&pointer, false).flags, 0, "no datagram has arrived");
    let user = UdpSocket::bind("127.0.0.1:0").unwrap();
    user.connect(pointer.address().unwrap()).unwrap();
    user.send(b"0.01 0.02 0.5 3").unwrap();
    let pose = read(&pointer, true);
    assert_eq!((pose.position, pose.buttons), ([0.01, 0.02, 0.1], 3), "clamped to the workspace");
    user.send(b"nan 0 0").unwrap();
    assert_eq!(read(&pointer, true).position, pose.position);
    assert_eq!(pointer.counter(1), Some((c"lines rejected", 1)));
    pointer.write(1, &output([33.0, 0.0, 0.0])).unwrap();
    let mut bytes = [0; 64];
    let length = user.recv(&mut bytes).unwrap();
    assert_eq!(&bytes[..length], b"3.300000 0.000000 0.000000\n");
    let mut rendered = output([0.0; 3]);
    pointer.rendered(99, &mut rendered).unwrap();
    assert!((rendered[0].force[0] - 3.3).abs() < 1e-12);
    pointer.rendered(100, &mut rendered).unwrap();
    assert_eq!(rendered[0].force[0], 0.0, "the force has expired");
    assert_eq!(read(&pointer, false).flags, 0, "the position has expired");
}

#[test]
fn reading_and_writing_do_not_allocate() {
    let pointer = open("127.0.0.1:0", 10.0);
    let user = UdpSocket::bind("127.0.0.1:0").unwrap();
    user.send_to(b"0 0 0", pointer.address().unwrap()).unwrap();
    read(&pointer, true);
    let mut poses = [Pose::default()];
    let before = allocations().expect("the counting allocator is installed");
    for _ in 0..100 {
        user.send_to(b"0.001 -0.002 0.003 1", pointer.address().unwrap()).unwrap();
        pointer.read(0, &mut poses).unwrap();
        pointer.write(0, &output([f64::NAN, 1.0, 0.0])).unwrap();
    }
    assert_eq!(
        allocations().expect("the counting allocator is installed") - before,
        1,
        "`allocations` itself allocates once"
    );
}

#[test]
fn probe_reports_a_port_in_use() {
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
