//! Pens without hardware: a recording of events that plays in its time, and a pipe that somebody writes events to.

use pliant_pen::Pen;
use pliant_plugin_api::Device;
use pliant_plugin_api::abi::{POSE_VALID, Pose};
use pliant_plugin_api::kit::{CountingAllocator, allocations};
use pliant_plugin_api::param::{self, Params, Value};
use std::io::Write;
use std::path::Path;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

// Kinds of events, and codes of axes and keys.
const SYN: u16 = 0;
const KEY: u16 = 1;
const ABS: u16 = 3;
const X: u16 = 0;
const Y: u16 = 1;
const PRESSURE: u16 = 0x18;
const TILT_X: u16 = 0x1a;
const PEN: u16 = 0x140;
const TOUCH: u16 = 0x14a;
const STYLUS: u16 = 0x14b;

/// The bytes of a frame at a time (ms), as the kernel of this machine writes them.
fn frame(milliseconds: u64, events: &[(u16, u16, i32)]) -> Vec<u8> {
    let (seconds, microseconds) = (1_700_000_000 + milliseconds / 1000, 1000 * (milliseconds % 1000));
    let mut bytes = Vec::new();
    for (kind, code, value) in events.iter().chain([&(SYN, 0, 0)]) {
        bytes.extend((seconds as usize).to_ne_bytes());
        bytes.extend((microseconds as usize).to_ne_bytes());
        bytes.extend(kind.to_ne_bytes());
        bytes.extend(code.to_ne_bytes());
        bytes.extend(value.to_ne_bytes());
    }
    bytes
}

/// A pen comes near, presses ever harder for a second while it goes to the right, and leaves.
fn stroke() -> Vec<u8> {
    let mut bytes = frame(0, &[(KEY, PEN, 1), (ABS, X, 1000), (ABS, Y, 2500), (ABS, TILT_X, 30)]);
    for step in 1..=100 {
        let down: &[(u16, u16, i32)] = if step == 1 { &[(KEY, TOUCH, 1), (KEY, STYLUS, 1)] } else { &[] };
        bytes.extend(frame(
            10 * step as u64,
            &[down, &[(ABS, X, 1000 + 80 * step), (ABS, PRESSURE, 20 * step)]].concat(),
        ));
    }
    bytes.extend(frame(1100, &[(KEY, TOUCH, 0), (ABS, PRESSURE, 0), (KEY, STYLUS, 0)]));
    bytes.extend(frame(1200, &[(ABS, X, 0), (ABS, Y, 0), (KEY, PEN, 0)]));
    bytes
}

fn open(path: &Path, maxima: [f64; 3]) -> Result<Pen, String> {
    let mut values = param::defaults(Pen::INFO.params);
    values[0] = Value::Text(path.to_str().unwrap().into());
    maxima.into_iter().enumerate().for_each(|(axis, max)| values[4 + axis] = Value::Number(max));
    Pen::new(&Params::new(Pen::INFO.params, &values)).map_err(|fault| fault.to_string())
}

fn read(pen: &Pen, time_ns: u64) -> Pose {
    let mut poses = [Pose::default()];
    pen.read(time_ns, &mut poses).unwrap();
    poses[0]
}

/// Whether two positions (m) are the same but for rounding.
fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

const MAXIMA: [f64; 3] = [10_000.0, 5000.0, 2000.0];

#[test]
fn a_recording_plays_in_its_own_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pen.events");
    std::fs::write(&path, stroke()).unwrap();
    let pen = open(&path, MAXIMA).unwrap();
    // The clock of the host starts anywhere.
    let at = |milliseconds: u64| 77_000_000_000 + milliseconds * 1_000_000;
    let before = allocations().expect("the counting allocator is installed");
    let poses = [0, 5, 500, 509, 1000, 1150, 1300].map(|milliseconds| read(&pen, at(milliseconds)));
    assert_eq!(allocations().expect("as before") - before, 1, "`allocations` itself allocates once");
    let [hovers, still, half, same, full, lifted, gone] = poses;
    assert!(hovers.flags == POSE_VALID && hovers.buttons == 0, "{hovers:?}");
    assert!(near(hovers.position, [-0.08, 0.0, 0.005]) && hovers.position == still.position, "{hovers:?}");
    assert!((2.0 * hovers.orientation[1].asin() - 30_f64.to_radians()).abs() < 1e-9, "tilted to the right: {hovers:?}");
    assert!(near(half.position, [0.0, 0.0, -0.0025]) && half.position == same.position, "{half:?}");
    assert_eq!(half.buttons, 0b11, "the tip and the lower button");
    assert!(near(full.position, [0.08, 0.0, -0.01]), "{full:?}");
    assert!(near(lifted.position, [0.08, 0.0, 0.005]) && lifted.buttons == 0, "{lifted:?}");
    assert_eq!((gone.flags, pen.counter(1)), (0, Some((c"reads without a pen near", 1))));
}

#[cfg(target_os = "linux")]
#[test]
fn a_pipe_is_read_as_events_arrive_also_in_pieces() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&path).status().expect("mkfifo is there");
    assert!(made.success());
    let mut values = param::defaults(Pen::INFO.params);
    values[0] = Value::Text(path.to_str().unwrap().into());
    let found = Pen::probe(&Params::new(Pen::INFO.params, &values));
    assert_eq!(found.len(), 2, "a look at the pipe does not wait for a writer");
    let pen = open(&path, MAXIMA).unwrap();
    assert_eq!(read(&pen, 0).flags, 0, "nobody writes yet");
    let mut writer = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    let bytes = frame(0, &[(KEY, PEN, 1), (ABS, X, 7500), (ABS, Y, 0), (KEY, TOUCH, 1), (ABS, PRESSURE, 1000)]);
    for piece in bytes.chunks(7) {
        assert_eq!(read(&pen, 0).flags, 0, "the frame is not whole");
        writer.write_all(piece).unwrap();
    }
    let pose = read(&pen, 0);
    assert_eq!((pose.flags, pose.buttons), (POSE_VALID, 1));
    assert!(near(pose.position, [0.05, 0.05, -0.0025]), "{pose:?}");
    assert_eq!(read(&pen, 0).position, pose.position, "it holds still");
    drop(writer);
    assert_eq!(read(&pen, 0).flags, 0, "whoever wrote has gone");
}

#[test]
fn what_is_no_pen_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pen.events");
    let said = |bytes: &[u8], maxima| {
        std::fs::write(&path, bytes).unwrap();
        open(&path, maxima).err().unwrap_or_default()
    };
    for (text, part) in [
        (said(&stroke(), [0.0; 3]), "give `x-max`, `y-max` and `pressure-max`"),
        (said(&stroke()[1..], MAXIMA), "allowed are whole events"),
        (said(b"", MAXIMA), "0 bytes"),
        (said(&frame(0, &[])[..0], MAXIMA), "0 bytes"),
    ] {
        assert!(text.contains("pen.events") && text.contains(part), "{text}");
    }
    let gone = open(&folder.path().join("event99"), MAXIMA).err().unwrap();
    assert!(gone.contains("event99") && gone.contains("No such file"), "{gone}");
    #[cfg(target_os = "linux")]
    for maxima in [MAXIMA, [0.0; 3]] {
        let other = open(Path::new("/dev/null"), maxima).err().unwrap();
        assert!(other.contains("/dev/null: a device without a position; allowed is a pen"), "{other}");
    }
}
