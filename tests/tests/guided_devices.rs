//! A device that a program guides: its place, scale and buttons in a scene, what it feels, and that it stays safe.

use nalgebra::UnitQuaternion;
use pliant_editor::{Draft, DraftMaterial, SOLIDS, SolidPreset, stroke_button};
use pliant_engine::edit::KINDS;
use pliant_engine::scene::Release;
use pliant_engine::session::{HandPose, Session};
use pliant_host::{DeviceInfo, EffectorOutput, POSE_VALID, Pose};
use pliant_live::{DeviceScale, Guide, GuidedDevice, HapticDevice, PointerDevice, StopDevice};
use pliant_mesh::testing::Random;
use pliant_mesh::{Surface, generate};
use pliant_plugin_api::abi::Status;
use pliant_solver::Vec3;
use pliant_tests::arm::{Arm, ArmModel};
use pliant_tests::bout::Bout;
use pliant_tests::{Bench, open_drafted};
use std::sync::{Arc, Mutex};

/// What a device says and hears.
struct Wire {
    pose: Pose,
    status: Status,
    /// N, and N m
    rendered: [Vec3; 2],
}

/// A device of two effectors that stands where it is told to.
struct Told(Arc<Mutex<Wire>>);

impl HapticDevice for Told {
    fn device_info(&self) -> DeviceInfo {
        let arm = Arm::new(ArmModel::desktop(|_| Vec3::zeros())).0.device_info();
        DeviceInfo { effectors: 2, workspace: [-0.1, 0.0, -0.05, 0.1, 0.3, 0.15], peak_torque: 0.1, ..arm }
    }

    fn read(&mut self, _: u64, poses: &mut [Pose]) -> Status {
        let wire = self.0.lock().unwrap();
        poses.fill(wire.pose);
        wire.status
    }

    fn write(&mut self, _: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        let mut wire = self.0.lock().unwrap();
        wire.rendered = [outputs[0].force.into(), outputs[0].torque.into()];
        assert_eq!(outputs.len(), 2, "one for each effector");
        assert!(outputs[1].force == [0.0; 3] && outputs[1].valid_until == outputs[0].valid_until);
        Status::OK
    }

    fn stop_handle(&self) -> StopDevice {
        Box::new(|| {})
    }
}

/// A guided device, its wire, and the handles of its guide and pointer.
fn guided(
    scale: DeviceScale,
) -> (GuidedDevice, Arc<Mutex<Wire>>, pliant_live::GuideHandle, pliant_live::PointerHandle) {
    let wire = Wire { pose: Pose::default(), status: Status::OK, rendered: [Vec3::zeros(); 2] };
    let wire = Arc::new(Mutex::new(wire));
    let told = Told(Arc::clone(&wire));
    let (pointer, hand) = PointerDevice::new(told.device_info());
    let (device, guide) = GuidedDevice::new(Box::new(told), pointer, scale);
    (device, wire, guide, hand)
}

/// Motions go from the device to the scene and forces back so that the power of one is that of the other, at one scale for forces and torques.
#[test]
fn power_has_one_scale_in_any_view() {
    let mut random = Random(7);
    for case in 0..200 {
        let scale = DeviceScale { length: 10_f64.powf(2.0 * random.signed()), force: 10_f64.powf(random.signed()) };
        let (mut device, wire, mut handle, _pointer) = guided(scale);
        let rotation = UnitQuaternion::from_scaled_axis(3.0 * random.vector());
        let (centre, share) = (random.vector(), random.unit());
        handle.set(Guide { leads: true, centre, rotation, force_share: share, buttons: [4, 8, 16] });
        let turns = [random.vector(), random.vector()].map(UnitQuaternion::from_scaled_axis);
        let places = [0.1, 0.1].map(|reach| reach * random.vector());
        let mut seen = Vec::new();
        for (tick, (place, turn)) in places.into_iter().zip(turns).enumerate() {
            let buttons = [0, 1, 2, 3][(case + tick) % 4];
            wire.lock().unwrap().pose = Pose {
                flags: POSE_VALID,
                buttons,
                position: place.into(),
                orientation: turn.coords.into(),
                ..Pose::default()
            };
            let mut poses = [Pose::default()];
            assert_eq!(device.read(1_000_000 * (tick as u64 + 1), &mut poses), Status::OK);
            assert_eq!(poses[0].buttons, [4, 8, 16, 8][buttons as usize]);
            seen.push(poses[0]);
        }
        let moved = Vec3::from(seen[1].position) - Vec3::from(seen[0].position);
        let turned = seen.iter().map(|pose| UnitQuaternion::new_normalize(pose.orientation.into()));
        let turned: Vec<_> = turned.collect();
        let turned = (turned[1] * turned[0].inverse()).scaled_axis();
        let (force, torque) = (random.vector(), random.vector());
        let output =
            EffectorOutput { force: force.into(), torque: torque.into(), valid_until: 9, ..EffectorOutput::default() };
        assert_eq!(device.write(3_000_000, &[output]), Status::OK);
        let [on_hand, on_wrist] = wire.lock().unwrap().rendered;
        let (work, of_torque) =
            (on_hand.dot(&(places[1] - places[0])), on_wrist.dot(&(turns[1] * turns[0].inverse()).scaled_axis()));
        let ratio = share * scale.force / scale.length;
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (a.abs() + b.abs() + ratio * 10.0);
        assert!(near(work, ratio * force.dot(&moved)), "case {case}: {work} J for {} J", force.dot(&moved));
        assert!(
            near(of_torque, ratio * torque.dot(&turned)),
            "case {case}: {of_torque} J for {} J",
            torque.dot(&turned)
        );
        // The middle of the workspace is where it is asked to be.
        wire.lock().unwrap().pose.position = [0.0, 0.15, 0.05];
        let mut poses = [Pose::default()];
        device.read(4_000_000, &mut poses);
        assert!((Vec3::from(poses[0].position) - centre).norm() < 1e-12 * (1.0 + scale.length), "case {case}");
    }
}

/// The pointer moves the hand while the device does not lead; with a device that is lost there is no hand until the pointer leads.
#[test]
fn the_pointer_has_the_hand_where_the_device_does_not_lead() {
    let (mut device, wire, mut handle, mut pointer) = guided(DeviceScale { length: 1.0, force: 1.0 });
    wire.lock().unwrap().pose = Pose { flags: POSE_VALID, buttons: 1, position: [0.05; 3], ..Pose::default() };
    pointer.move_to(Vec3::new(1.0, 2.0, 3.0), 32);
    let mut poses = [Pose::default()];
    device.read(1, &mut poses);
    assert_eq!((poses[0].position, poses[0].buttons), ([1.0, 2.0, 3.0], 32));
    assert!(handle.hand().place.is_some() && handle.hand().pressed == 1, "the device is watched all the same");
    let output = EffectorOutput { force: [1.0, 0.0, 0.0], valid_until: 5, ..EffectorOutput::default() };
    device.write(1, &[output]);
    assert_eq!(wire.lock().unwrap().rendered[0], Vec3::zeros(), "and feels nothing");
    assert_eq!(pointer.force(), Vec3::x());
    let guide = Guide { leads: true, buttons: [1, 2, 4], ..Guide::default() };
    handle.set(guide);
    device.read(2, &mut poses);
    assert_eq!(poses[0].buttons, 2);
    wire.lock().unwrap().status = Status::IO;
    assert_eq!(device.read(3, &mut poses), Status::OK, "the session goes on without it");
    assert_eq!(poses[0].flags & POSE_VALID, 0, "and no hand is there");
    assert_eq!(handle.hand().lost, Some(Status::IO));
    handle.set(Guide { leads: false, ..guide });
    device.read(4, &mut poses);
    assert_eq!(poses[0].position, [1.0, 2.0, 3.0]);
}

/// A view that turns at once takes the hand along within a tenth of a second and never jerks it.
#[test]
fn the_hand_follows_the_view_smoothly() {
    let (mut device, wire, mut handle, _pointer) = guided(DeviceScale { length: 1.0, force: 1.0 });
    wire.lock().unwrap().pose = Pose { flags: POSE_VALID, position: [0.1, 0.15, 0.05], ..Pose::default() };
    let at = |device: &mut GuidedDevice, ms: u64| {
        let mut poses = [Pose::default()];
        device.read(1_000_000 * ms, &mut poses);
        Vec3::from(poses[0].position)
    };
    handle.set(Guide { leads: true, ..Guide::default() });
    assert!((at(&mut device, 1) - Vec3::new(0.1, 0.0, 0.0)).norm() < 1e-12);
    let rotation = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), 1.0);
    handle.set(Guide { leads: true, rotation, ..Guide::default() });
    let mut last = Vec3::new(0.1, 0.0, 0.0);
    for ms in 2..100 {
        let now = at(&mut device, ms);
        assert!((now - last).norm() < 0.1 / 30.0 * 1.1, "{ms} ms: {last:?} to {now:?}");
        last = now;
    }
    let end = rotation * Vec3::new(0.1, 0.0, 0.0);
    assert!((last - end).norm() < 0.005, "{last:?} {end:?}");
}

/// A session on a cube of this size (m), drafted as an editor does and without symmetry, and its draft.
fn drafted(size: f64, solid: &SolidPreset) -> (Session, Draft) {
    let bench = Bench::new();
    let cube = generate::cuboid(8, [size; 3]).expect("a cube");
    let mut obj = Vec::new();
    cube.write(&Surface::from_document(&cube).points, None, &mut obj).expect("written");
    bench.write("cube.obj", String::from_utf8(obj).expect("text"));
    let plugin = if solid.flow.is_some() { "neo-hookean" } else { "mass-spring" };
    let material = DraftMaterial::Solid { plugin: plugin.into(), preset: *solid, level: 4 };
    let draft =
        Draft { mesh: bench.path("cube.obj"), scale: 1.0, size, subdivide: false, weld: None, material, dt: 1e-3 };
    (open_drafted(&bench.write("scene.toml", draft.to_toml(&bench.path("")))), draft)
}

/// A hand is as strong as its model asks for, from a tenth of a millimetre to a hill.
#[test]
fn a_model_of_any_size_and_material_gets_a_hand() {
    for size in [1e-4, 1e-2, 1.0, 1e2, 1e4] {
        for solid in SOLIDS {
            let (session, draft) = drafted(size, solid);
            let facts = session.devices[0].facts;
            assert!((facts.peak_force / draft.peak_force() - 1.0).abs() < 1e-12, "{size} m, {}", solid.name);
        }
    }
}

/// A view that goes around a model at any height, at sixty frames a second: the hand goes along and never the long way round.
#[test]
fn the_hand_goes_the_short_way_round_with_any_view() {
    let (mut device, wire, mut handle, _pointer) = guided(DeviceScale { length: 1.0, force: 1.0 });
    wire.lock().unwrap().pose = Pose { flags: POSE_VALID, position: [0.1, 0.15, 0.05], ..Pose::default() };
    for pitch in [-1.5, -0.6, 0.0, 0.3, 1.2] {
        let mut last = None;
        for ms in 0_u32..4000 {
            if ms.is_multiple_of(16) {
                let yaw = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), 4e-3 * f64::from(ms));
                let view = yaw * UnitQuaternion::from_axis_angle(&Vec3::x_axis(), pitch);
                // By its axes, as a camera has it, which says nothing of the sign of the quaternion.
                let rotation = UnitQuaternion::from_rotation_matrix(&view.to_rotation_matrix());
                handle.set(Guide { leads: true, rotation, ..Guide::default() });
            }
            let mut poses = [Pose::default()];
            device.read(1_000_000 * u64::from(ms + 1), &mut poses);
            let now = Vec3::from(poses[0].position);
            // Half a millimetre a tick at 4 rad/s; what has been asked for is followed within its time constant.
            let jump = last.replace(now).map_or(0.0, |last: Vec3| (now - last).norm());
            assert!(ms < 200 || jump < 2e-3, "pitch {pitch}, {ms} ms: {jump} m");
        }
    }
}

/// An arm presses the middle of a cube of any size and stiffness from any side: it feels what its own range allows, never more than its peak, and gets no
/// energy.
#[test]
fn an_arm_feels_models_of_any_size_and_stiffness() {
    let mut random = Random(11);
    let touch = KINDS.iter().copied().find(|kind| kind.name() == "touch").expect("a kind");
    let touches = 1 << stroke_button(touch, Release::SpringBack, Default::default());
    for size in [0.004, 0.1, 3.0] {
        let elastic: Vec<_> = SOLIDS.iter().filter(|solid| solid.flow.is_none()).collect();
        for solid in [elastic[0], elastic[elastic.len() / 2], elastic[elastic.len() - 1]] {
            let (session, draft) = drafted(size, solid);
            let hand = draft.hand();
            let middle = session.bodies[0].model.surface.bounds().centre();
            // From the side of the viewer into the cube, by a fourteenth of its size.
            let reach = 0.5 * 0.7 * 0.2;
            let way = move |t: f64| Vec3::new(0.0, 0.0, 0.1 - (0.1 - reach + 0.01) * t.min(1.0));
            let (arm, state) = Arm::new(ArmModel::desktop(way));
            let scale = DeviceScale::fit(&arm.device_info(), hand.size, hand.coupling, hand.peak_force);
            let (pointer, _handle) = PointerDevice::new(session.devices[0].facts);
            let (device, mut guide) = GuidedDevice::new(Box::new(arm), pointer, scale);
            // Onto one of the sides.
            let quarters = 0.5 * std::f64::consts::PI * random.below(4) as f64;
            let axis = random.pick(&[Vec3::x_axis(), Vec3::y_axis()]);
            let turns = UnitQuaternion::from_axis_angle(&axis, quarters);
            guide.set(Guide { leads: true, centre: middle, rotation: turns, force_share: 1.0, buttons: [touches; 3] });
            let mut bout = Bout::with_devices(session, vec![Box::new(device)], vec![state]);
            bout.run(1500, 1);
            let (before, felt) = (bout.arm(0).given, bout.arm(0).force);
            bout.run(500, 1);
            let arm = bout.arm(0);
            let what = format!("{size} m, {}", solid.name);
            assert!(felt[2] > 0.1 && felt.norm() <= 3.3 + 1e-9, "{what}: {felt:?} N");
            assert!((felt - arm.force).norm() < 0.1 * felt.norm(), "{what}: it settles: {felt:?}, {:?} N", arm.force);
            // A hundredth of the work of the press, while the body settles.
            let work = 0.01 * felt.norm();
            assert!(arm.given - before < 0.01 * work, "{what}: {} J of {work} J", arm.given - before);
            bout.forces_are_safe(0, hand.slew() * scale.force);
        }
    }
}

/// A hand that presses is inside of the body. A stroke that begins or ends there leaves the tool outside: it is pushed out, and comes out freely.
#[test]
fn a_tool_that_presses_stays_outside_when_a_stroke_begins_and_ends() {
    let touch = KINDS.iter().copied().find(|kind| kind.name() == "touch").expect("a kind");
    let mask = |release| 1 << stroke_button(touch, release, Default::default());
    let (felt, kept) = (mask(Release::SpringBack), mask(Release::Keep));
    for size in [0.004, 0.1, 3.0] {
        for depth in [0.02, 0.04, 0.07, 0.1] {
            let (mut session, _) = drafted(size, &SOLIDS[1]);
            let top = session.bodies[0].model.surface.bounds().centre() + 0.5 * size * Vec3::z();
            let mut go = |from: f64, to: f64, buttons: u32| {
                for step in 1..=60 {
                    let height = from + (to - from) * f64::from(step) / 60.0;
                    let position = top + height * size * Vec3::z();
                    session.place_hand(0, Some(HandPose { position, rotation: UnitQuaternion::identity(), buttons }));
                    session.step();
                }
                let tool = session.frame().tools[0];
                (tool.force.z, tool.contact)
            };
            let what = format!("{size} m, {depth} of it deep");
            let (first, contact) = go(0.1, -depth, felt);
            assert!(first > 0.0 && contact.is_some(), "{what}: {first} N");
            for buttons in [kept, felt, kept, felt] {
                let (force, _) = go(-depth, -depth, buttons);
                assert!(force > -0.05 * first, "{what}: the surface draws the hand in: {force} N after {first} N");
            }
            let (_, contact) = go(-depth, 0.1, felt);
            assert!(contact.is_none(), "{what}: it comes out");
        }
    }
}

/// Counts how often a device is read, stopped and closed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Calls {
    reads: u64,
    stops: u64,
    closed: u64,
}

/// A device whose calls are counted.
struct Counted<D>(D, Arc<Mutex<Calls>>);

impl<D: HapticDevice> HapticDevice for Counted<D> {
    fn device_info(&self) -> DeviceInfo {
        self.0.device_info()
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        self.1.lock().unwrap().reads += 1;
        self.0.read(time, poses)
    }

    fn write(&mut self, time: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        self.0.write(time, outputs)
    }

    fn stop_handle(&self) -> StopDevice {
        let (stop, calls) = (self.0.stop_handle(), Arc::clone(&self.1));
        Box::new(move || {
            calls.lock().unwrap().stops += 1;
            stop();
        })
    }
}

impl<D> Drop for Counted<D> {
    fn drop(&mut self) {
        self.1.lock().unwrap().closed += 1;
    }
}

/// What is another in the session that an arm's hand goes on in.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    /// Nothing: a cut elsewhere, or settings that do not matter here.
    Nothing,
    /// A softer material.
    Softer,
    /// A stiffer material.
    Stiffer,
    /// A model of twice the size, around the hand and where the tool was.
    Grown,
}

/// A session that is opened anew, for another material or shape, takes the device over: it is neither stopped nor closed, the force never changes faster than the
/// slew of the hand, also not to zero, and where nothing is another it stays.
#[test]
fn a_session_that_is_opened_anew_keeps_device_and_force() {
    let touch = KINDS.iter().copied().find(|kind| kind.name() == "touch").expect("a kind");
    let touches = 1 << stroke_button(touch, Release::SpringBack, Default::default());
    for size in [0.004, 0.1, 3.0] {
        for change in [Change::Nothing, Change::Softer, Change::Stiffer, Change::Grown] {
            let what = format!("{size} m, {change:?}");
            let (session, draft) = drafted(size, &SOLIDS[1]);
            let middle = session.bodies[0].model.surface.bounds().centre();
            let reach = 0.5 * 0.7 * 0.2;
            let way = move |t: f64| Vec3::new(0.0, 0.0, 0.1 - (0.1 - reach + 0.01) * t.min(1.0));
            let (arm, state) = Arm::new(ArmModel::desktop(way));
            let calls = Arc::new(Mutex::new(Calls::default()));
            let (arm, hand) = (Counted(arm, Arc::clone(&calls)), draft.hand());
            let scale = DeviceScale::fit(&arm.device_info(), hand.size, hand.coupling, hand.peak_force);
            let (pointer, _handle) = PointerDevice::new(session.devices[0].facts);
            let (device, mut guide) = GuidedDevice::new(Box::new(arm), pointer, scale);
            let rotation = UnitQuaternion::identity();
            guide.set(Guide { leads: true, centre: middle, rotation, force_share: 1.0, buttons: [touches; 3] });
            let mut bout = Bout::with_devices(session, vec![Box::new(device)], vec![state]);
            bout.run(1500, 1);
            let (before, ticks) = (bout.arm(0).force, bout.arm(0).forces.len());
            assert!(before[2] > 0.1, "{what}: {before:?} N");
            let (next, draft) = match change {
                Change::Nothing => drafted(size, &SOLIDS[1]),
                Change::Softer => drafted(size, &SOLIDS[0]),
                Change::Stiffer => drafted(size, &SOLIDS[2]),
                Change::Grown => drafted(2.0 * size, &SOLIDS[1]),
            };
            let now = draft.hand();
            let rescaling = guide.rescale(now.size, now.coupling, now.peak_force);
            bout.hand_over(next, &[Some(rescaling)]);
            bout.run(1000, 1);
            let (seen, arm) = (*calls.lock().unwrap(), bout.arm(0));
            assert!(!arm.stopped, "{what}");
            assert_eq!(seen, Calls { reads: 2500, stops: 0, closed: 0 }, "{what}");
            let slew = (hand.slew() * scale.force).max(now.slew() * guide.scale().force);
            let mut last = before;
            for (tick, force) in arm.forces[ticks..].iter().enumerate() {
                let jump = (force - last).norm();
                assert!(jump <= 1.001e-3 * slew, "{what}: tick {tick}: {last:?} to {force:?} N");
                assert!(force.norm() <= 3.3 + 1e-9, "{what}: tick {tick}: {force:?} N");
                let is_kept = change != Change::Nothing || (force - before).norm() < 0.5 * before.norm();
                assert!(is_kept, "{what}: tick {tick}: {before:?} to {force:?} N");
                last = *force;
            }
            // It presses still, from the same side.
            assert!(last[2] > 0.02, "{what}: {last:?} N");
            let is_as_before = change != Change::Nothing || (last - before).norm() < 0.15 * before.norm();
            assert!(is_as_before, "{what}: {before:?} and then {last:?} N");
        }
    }
}

/// An undo under a hand that presses: the shape is another one, the tool is on its outside, and what is felt comes back within the slew.
#[test]
fn a_tool_that_presses_is_outside_after_an_undo() {
    let touch = KINDS.iter().copied().find(|kind| kind.name() == "touch").expect("a kind");
    let mask = |release| 1 << stroke_button(touch, release, Default::default());
    let (felt, kept) = (mask(Release::SpringBack), mask(Release::Keep));
    for size in [0.004, 0.1, 3.0] {
        for depth in [0.02, 0.05, 0.1] {
            let what = format!("{size} m, {depth} of it deep");
            let (mut session, _) = drafted(size, &SOLIDS[1]);
            session.keep_history();
            let top = session.bodies[0].model.surface.bounds().centre() + 0.5 * size * Vec3::z();
            let go = |session: &mut Session, from: f64, to: f64, buttons: u32| {
                for step in 1..=60 {
                    let height = from + (to - from) * f64::from(step) / 60.0;
                    let position = top + height * size * Vec3::z();
                    session.place_hand(0, Some(HandPose { position, rotation: UnitQuaternion::identity(), buttons }));
                    session.step();
                }
                session.frame().tools[0]
            };
            go(&mut session, 0.1, -depth, kept);
            let dented = go(&mut session, -depth, -1.2 * depth, felt);
            assert!(dented.force.z > 0.0, "{what}: {} N", dented.force.z);
            assert!(session.undo(), "{what}");
            let undone = go(&mut session, -1.2 * depth, -1.2 * depth, felt);
            assert!(undone.contact.is_some() && undone.force.z > dented.force.z, "{what}: {undone:?}");
            assert!(undone.proxy.z > top.z - 1.2 * depth * size, "{what}: {undone:?}");
            assert!(session.redo(), "{what}");
            let redone = go(&mut session, -1.2 * depth, -1.2 * depth, felt);
            assert!(redone.contact.is_some() && redone.force.z > 0.0, "{what}: {redone:?}");
            let away = go(&mut session, -1.2 * depth, 0.1, felt);
            assert!(away.contact.is_none() && away.force.norm() == 0.0, "{what}: it comes out: {away:?}");
        }
    }
}

/// How deep a hand may be, in radii of its tool, and still be outside when a stroke begins or ends there.
#[test]
fn a_tool_that_presses_deep_stays_outside() {
    let touch = KINDS.iter().copied().find(|kind| kind.name() == "touch").expect("a kind");
    let mask = |release| 1 << stroke_button(touch, release, Default::default());
    let (felt, kept) = (mask(Release::SpringBack), mask(Release::Keep));
    let mut failed = Vec::new();
    for (index, solid) in SOLIDS.iter().enumerate() {
        for size in [[0.1, 3.0], [3.0, 0.004], [0.004, 0.1]][index % 3] {
            for radii in [2.0, 3.5, 5.0] {
                let (mut session, draft) = drafted(size, solid);
                let depth = radii * draft.hand().radius / size;
                let top = session.bodies[0].model.surface.bounds().centre() + 0.5 * size * Vec3::z();
                let mut go = |from: f64, to: f64, buttons: u32| {
                    for step in 1..=60 {
                        let height = from + (to - from) * f64::from(step) / 60.0;
                        let position = top + height * size * Vec3::z();
                        session
                            .place_hand(0, Some(HandPose { position, rotation: UnitQuaternion::identity(), buttons }));
                        session.step();
                    }
                    let tool = session.frame().tools[0];
                    (tool.force.z, tool.contact, tool.proxy.z)
                };
                let what = format!("{size} m, {}, {radii} radii deep", solid.name);
                let (first, contact, _) = go(0.1, -depth, felt);
                if contact.is_none() {
                    failed.push(format!("{what}: nothing met, {first} N"));
                    continue;
                }
                for (turn, buttons) in [kept, felt, kept, felt].into_iter().enumerate() {
                    let (force, contact, proxy) = go(-depth, -depth, buttons);
                    if force <= -0.05 * first.abs() || contact.is_none() {
                        let above = (proxy - top.z) / size + depth;
                        failed.push(format!("{what}: turn {turn}: {force} N after {first} N, {contact:?}, {above}"));
                        break;
                    }
                }
            }
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
