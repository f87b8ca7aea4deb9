//! Recordings from CSV files.

use pliant_plugin_api::abi::Pose;
use pliant_plugin_api::param::{Params, Value, defaults, position};
use pliant_plugin_api::{Device, Fault};
use pliant_scripted::Scripted;

/// A device with a recording of this text.
fn open(text: &str) -> Result<Scripted, Fault> {
    static COUNT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
    let number = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let file = std::env::temp_dir().join(format!("pliant-recording-{}-{number}.csv", std::process::id()));
    std::fs::write(&file, text).unwrap();
    let mut values = defaults(Scripted::INFO.params);
    values[position(Scripted::INFO.params, "recording").unwrap()] = Value::Text(file.to_str().unwrap().into());
    let opened = Scripted::new(&Params::new(Scripted::INFO.params, &values));
    std::fs::remove_file(&file).unwrap();
    opened
}

#[test]
fn poses_follow_the_recording() {
    let device = open("t,x,y,z,buttons\n# a comment\n0,0,0,0,0\r\n1, 0.1,0,0,2\n").unwrap();
    let mut poses = [Pose::default()];
    device.read(500_000_000, &mut poses).unwrap();
    assert!((poses[0].position[0] - 0.05).abs() < 1e-15 && poses[0].buttons == 0);
    device.read(2_000_000_000, &mut poses).unwrap();
    assert_eq!((poses[0].position, poses[0].buttons), ([0.1, 0.0, 0.0], 2));
}

#[test]
fn invalid_rows_are_refused_by_line() {
    for (text, part) in [
        ("", "no row"),
        ("0,0,0\n", ":1: not 4 or 5"),
        ("0,0,0,0\n1,0,zero,0\n", ":2: not a number"),
        ("0,0,0,0\n1,0,nan,0\n", ":2: not 4 or 5 finite"),
        ("0,0,0,0,1.5\n", ":1: button mask 1.5"),
        ("1,0,0,0\n0,0,0,0\n", "row 2 is at 0 s"),
    ] {
        let fault = open(text).err().unwrap();
        assert!(fault.reason.contains(part), "{text:?}: {fault}");
    }
}
