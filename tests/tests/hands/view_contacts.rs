//! What a viewer sees of tools: the points where they touch, and their blades.

use pliant_engine::session::Session;
use pliant_live::{ViewReader, ViewWriter, view_buffer};
use pliant_tests::{box_scene, open};

/// Steps a scene and hands each frame on.
fn watch(text: &str, mut each: impl FnMut(&Session, &ViewReader)) {
    let mut session = open(text, 1);
    let (mut writer, mut reader): (ViewWriter, ViewReader) = view_buffer(&session);
    for _ in 0..50 {
        session.step();
        writer.publish(&mut session);
        assert!(reader.update());
        each(&session, &reader);
    }
}

#[test]
fn contact_points_lie_on_the_tool_on_the_side_that_is_pushed_back() {
    let family = [
        ("", "touch"),
        ("symmetry = \"x\"", "touch"),
        ("symmetry = \"xy\"", "inflate"),
        ("release = \"keep\"", "smooth"),
    ];
    let mut free = 0;
    for (keys, kind) in family {
        let text = box_scene("", "", keys).replace("kind = \"touch\"", &format!("kind = \"{kind}\""));
        let mut touched = 0;
        watch(&text, |session, reader| {
            let frame = reader.frame();
            for (tool, felt) in frame.tools.iter().enumerate() {
                let points: Vec<_> = frame.contacts.iter().filter(|point| point.tool == tool).collect();
                if felt.contact.is_none() {
                    assert!(points.is_empty(), "{kind}: a tool that touches nothing");
                    free += 1;
                    continue;
                }
                touched += 1;
                let radius = session.tools[tool].tool.proxy.radius();
                for point in &points {
                    assert!(
                        ((point.position - felt.proxy).norm() / radius - 1.0).abs() < 1e-9,
                        "{kind}: on its surface"
                    );
                    assert!((point.direction.norm() - 1.0).abs() < 1e-9 && (0.0..=1.0).contains(&point.share));
                    // What an inflating tool lifts presses on it from inside.
                    let is_below = kind == "inflate" || point.direction.z < -0.2;
                    assert!(is_below, "{kind}: the block is below, {:?}", point.direction);
                }
                let shares: f64 = points.iter().map(|point| point.share).sum();
                assert!(points.is_empty() || (shares - 1.0).abs() < 1e-9, "{kind}: shares add to one, {shares}");
                assert!(felt.force.norm() == 0.0 || !points.is_empty(), "{kind}: a force comes from somewhere");
            }
        });
        assert!(touched > 10, "{kind}: {touched}");
    }
    assert!(free > 10, "tools over the block: {free}");
}

#[test]
fn what_is_gripped_is_held_at_the_proxy() {
    let text = box_scene("", "", "radius = \"10 mm\"")
        .replace("kind = \"touch\"", "kind = \"grab\"")
        .replace("0.0, 0.0, 0.0, 0.006]", "0.0, 0.0, 0.0, 0.001]");
    let mut gripped = 0;
    watch(&text, |_, reader| {
        let frame = reader.frame();
        if let Some(felt) = frame.tools.first().filter(|felt| felt.grips) {
            gripped += 1;
            assert!(frame.contacts.iter().all(|point| point.position == felt.proxy) && frame.contacts.len() == 1);
        }
    });
    assert!(gripped > 10, "{gripped}");
}

#[test]
fn a_blade_begins_in_the_hand_and_is_as_long_as_the_scene_says() {
    let text = box_scene("", "", "symmetry = \"y\"")
        .replace("radius = \"4 mm\"", "radius = \"4 mm\"\nblade = { length = \"70 mm\", direction = [0.6, 0.8, 0] }")
        .replace("kind = \"touch\"", "kind = \"cut\"");
    let mut seen = 0;
    watch(&text, |session, reader| {
        for blade in &reader.frame().blades {
            let [tip, heel] = blade.ends;
            assert_eq!(tip, session.tools[blade.tool].hand.position);
            assert!(((heel - tip).norm() - 0.07).abs() < 1e-12);
        }
        if let [own, mirrored] = &reader.frame().blades[..] {
            seen += 1;
            let [own, mirrored] = [own, mirrored].map(|blade| blade.ends[1] - blade.ends[0]);
            assert!((own.y + mirrored.y).abs() < 1e-12 && (own.x - mirrored.x).abs() < 1e-12, "{own:?} {mirrored:?}");
        }
    });
    assert!(seen > 10);
    watch(&box_scene("", "", ""), |_, reader| assert!(reader.frame().blades.is_empty(), "a tool without a blade"));
}
