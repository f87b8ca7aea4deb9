//! A device that has the hand in the window, moved by datagrams.

mod common;

use common::{MIDDLE, arguments, ball, pause, saved, stroke, wait, window_with};
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use pliant_editor::DeviceRequest;
use pliant_window::app::App;
use pliant_window::arguments::Arguments;

/// An address of this machine that is free.
fn free_address() -> String {
    std::net::UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string()
}

/// The user of a device that is moved by datagrams.
struct DeviceUser {
    socket: std::net::UdpSocket,
    address: String,
}

impl DeviceUser {
    fn new(address: &str) -> Self {
        let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_nonblocking(true).unwrap();
        Self { socket, address: address.to_owned() }
    }

    /// Moves along the axis towards the user within some frames, from one place to another (m), with these buttons; gives the last force, N.
    fn go(&self, harness: &mut Harness<'_, App>, [from, to]: [f64; 2], buttons: u32) -> f64 {
        for n in 0..=20 {
            let z = from + (to - from) * f64::from(n) / 20.0;
            self.socket.send_to(format!("0 0 {z} {buttons}").as_bytes(), &self.address).unwrap();
            pause(harness);
        }
        self.force().unwrap_or(0.0)
    }

    /// The last force since the last call, along the axis towards the user, N; `None` if the device said nothing.
    fn force(&self) -> Option<f64> {
        let (mut buffer, mut force) = ([0; 256], None);
        while let Ok(length) = self.socket.recv(&mut buffer) {
            let text = String::from_utf8_lossy(&buffer[..length]).into_owned();
            force = Some(text.split_whitespace().nth(2).unwrap().parse().unwrap());
        }
        force
    }
}

/// A device feels the model without a button, sculpts with one in the tool that is chosen, and gives the hand back to the mouse.
#[test]
fn a_device_has_the_hand_until_the_mouse_takes_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let original = std::fs::read(&path).unwrap();
    let address = free_address();
    let settings = vec![("address".to_owned(), address.clone()), ("hold".to_owned(), "60".to_owned())];
    let device = Some(DeviceRequest { plugin: "pointer".into(), settings, ..DeviceRequest::default() });
    let mut harness = window_with(Arguments { device, ..arguments(&path) });
    wait(&mut harness, "the model", App::is_open);
    let user = DeviceUser::new(&address);
    // The ball takes 70 mm from the middle of the workspace of 200 mm.
    assert_eq!(user.go(&mut harness, [0.09, 0.08], 0), 0.0, "nothing is near");
    let felt = user.go(&mut harness, [0.08, 0.062], 0);
    assert!(felt > 0.05, "{felt} N pushes the hand back");
    user.go(&mut harness, [0.062, 0.09], 0);
    assert_eq!(harness.state().status().done, 0, "to feel is no stroke");
    let pressed = user.go(&mut harness, [0.09, 0.06], 1);
    assert!(pressed > 0.05 && pressed <= 3.3, "{pressed} N");
    user.go(&mut harness, [0.06, 0.09], 0);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    let name = harness.state().status().strokes[0].name;
    assert_eq!(name, "touch");
    assert_ne!(saved(&mut harness, &path), original, "the shape was kept");
    // The knife in the hand, along the axis of the device, from the front.
    harness.key_press(Key::Num3);
    user.go(&mut harness, [0.09, -0.09], 1);
    user.go(&mut harness, [-0.09, 0.09], 0);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut harness, "undo", |app| app.status().done <= 1);
    harness.key_press(Key::Num1);
    let strokes = harness.state().status().done;
    harness.get_by_role_and_label(Role::ComboBox, "Hand").click_accesskit();
    harness.run_steps(2);
    harness.get_by_label("mouse").click_accesskit();
    harness.run_steps(2);
    user.go(&mut harness, [0.09, 0.05], 1);
    assert_eq!(harness.state().status().done, strokes, "the device has no hand any more");
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke by mouse", |app| app.status().done == strokes + 1);
}

/// A scene's device is offered, and a device that cannot be opened is named while the mouse has the hand.
#[test]
fn a_device_of_the_scene_is_chosen_in_the_panel() {
    let folder = tempfile::tempdir().unwrap();
    let address = free_address();
    ball(folder.path());
    let scene = folder.path().join("scene.toml");
    let text = format!(
        "format = 1\n[[body]]\nname = \"ball\"\nmesh = \"ball.obj\"\nmaterial = {{ plugin = \"mass-spring\" }}\n\
         grid = {{ level = 4 }}\n[[device]]\nname = \"stylus\"\nplugin = \"pointer\"\n\
         params = {{ address = \"{address}\", hold = \"60 s\" }}\n[[tool]]\nname = \"tip\"\ndevice = \"stylus\"\n\
         radius = \"10 mm\"\n[[edit]]\nkind = \"touch\"\ntool = \"tip\"\n"
    );
    std::fs::write(&scene, text).unwrap();
    let device = Some(DeviceRequest { plugin: "no-such-device".into(), ..DeviceRequest::default() });
    let mut harness = window_with(Arguments { device, ..arguments(&scene) });
    wait(&mut harness, "the model", App::is_open);
    let error = harness.state().error().expect("a sentence").to_owned();
    assert!(error.contains("no-such-device"), "{error}");
    harness.key_press(Key::Escape);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke by mouse", |app| app.status().done == 1);
    harness.get_by_role_and_label(Role::ComboBox, "Hand").click_accesskit();
    harness.run_steps(2);
    harness.get_by_label("stylus").click_accesskit();
    harness.run_steps(2);
    wait(&mut harness, "the present shape with the device", |app| app.is_open() && app.status().done == 0);
    let user = DeviceUser::new(&address);
    user.go(&mut harness, [0.09, 0.08], 0);
    let felt = user.go(&mut harness, [0.08, 0.06], 0);
    assert!(felt > 0.05, "{felt} N");
}

/// Ids of the haptic threads of this process.
#[cfg(target_os = "linux")]
fn haptic_threads() -> Vec<String> {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap().filter_map(Result::ok);
    let named = tasks
        .filter(|task| std::fs::read_to_string(task.path().join("comm")).is_ok_and(|name| name.trim() == "haptic"));
    named.map(|task| task.file_name().to_string_lossy().into_owned()).collect()
}

/// Another choice in the panel of the material opens the model anew. The device stays with its thread meanwhile, and the hand that presses feels the model all the
/// time.
#[cfg(target_os = "linux")]
#[test]
fn a_model_that_is_opened_anew_leaves_the_device_open() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let address = free_address();
    let settings = vec![("address".to_owned(), address.clone()), ("hold".to_owned(), "60".to_owned())];
    let device = Some(DeviceRequest { plugin: "pointer".into(), settings, ..DeviceRequest::default() });
    let mut harness = window_with(Arguments { device, ..arguments(&path) });
    wait(&mut harness, "the model", App::is_open);
    let before = haptic_threads();
    let user = DeviceUser::new(&address);
    user.go(&mut harness, [0.09, 0.08], 0);
    let felt = user.go(&mut harness, [0.08, 0.06], 0);
    assert!(felt > 0.05, "{felt} N");
    harness.get_by_role_and_label(Role::CheckBox, "Divide large faces").click_accesskit();
    harness.run_steps(2);
    harness.get_by_role_and_label(Role::Button, "Apply").click_accesskit();
    let began = std::time::Instant::now();
    let (mut was_closed, mut least) = (false, felt);
    while !(was_closed && harness.state().is_open()) {
        assert!(began.elapsed() < common::PATIENCE, "{:?}", harness.state().error());
        user.socket.send_to(b"0 0 0.06 0", &user.address).unwrap();
        pause(&mut harness);
        was_closed |= !harness.state().is_open();
        least = user.force().map_or(least, |force| least.min(force));
    }
    least = least.min(user.go(&mut harness, [0.06, 0.06], 0));
    assert!(least > 0.5 * felt, "{least} N after {felt} N");
    let after = haptic_threads();
    assert!(
        before.iter().any(|thread| after.contains(thread)),
        "the device was closed and opened: {before:?}, {after:?}"
    );
}
