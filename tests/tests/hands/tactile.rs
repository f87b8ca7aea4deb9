//! What a tactile array shows of a contact in a session: the normal force, where the contact is.

use pliant_engine::session::Session;
use pliant_tests::{open, twin::Twin};

/// A scene with the index of an exoskeleton over a body, and the thumb away from it.
fn scene(peer: &str, body: &str, origin: &str, radius: &str, time: &str) -> Session {
    let text = format!(
        r#"format = 1
[time]
duration = 100
{time}
[[body]]
name = "thing"
{body}
[[device]]
name = "hand"
plugin = "exoskeleton"
frame = {{ {origin} }}
params = {{ peer = "{peer}", patience = 20 }}
[[tool]]
name = "index"
device = "hand"
radius = "{radius}"
sheets = "vertices"
[[edit]]
kind = "touch"
tool = "index"
"#
    );
    open(&text, 1)
}

/// A twin whose index stands above the origin and comes down to a height, m, and stays.
fn pressing(bench: &pliant_tests::Bench, height: f64) -> Twin {
    let path = bench.write("path.csv", format!("0,0,0,0.02,0,0,-1\n0.3,0,0,{height},0,0,-1\n"));
    Twin::exoskeleton(&["--hand", "keyframed", "--path", path.to_str().unwrap()])
}

/// Steps until the contact has come to rest; gives the force on the hand along z, and what the pad has: shown, clipped, beside.
fn settled(session: &mut Session) -> (f64, f64, f64, f64) {
    let (mut last, mut calm) = (0.0, 0);
    let begun = std::time::Instant::now();
    // The twin goes by its own clock; how many steps that takes is not known.
    while begun.elapsed().as_secs() < 30 {
        session.step();
        let force = session.frame().tools[0].force[2];
        calm = if force > 1e-7 && (force - last).abs() < 1e-6 * force { calm + 1 } else { 0 };
        last = force;
        if calm > 20 {
            let pad = session.tools[0].pad.as_ref().expect("its device has taxels");
            assert!(pad.taxels.iter().all(|t| (0.0..=0.073).contains(t)));
            return (force, pad.taxels.iter().sum(), pad.clipped, pad.beside);
        }
    }
    panic!("no rest: {last} N");
}

#[test]
fn the_pins_give_the_normal_force_of_a_sheet_up_to_their_limit() {
    let bench = pliant_tests::Bench::new();
    // One vertex of a held square is right under the tip, and no other within its reach.
    let sheet = |size: f64| {
        format!(
            "shape = {{ kind = \"sheet\", cells = 8, size = [{size}, {size}, 0] }}\nsheet = {{ warp = [1, 0, 0] }}\n\
             material = {{ plugin = \"cloth\", params = {{ fabric = \"denim\" }} }}\n\
             fixed = [{{ box = [[-1, -1, -1], [1, 0.001, 1]] }}, {{ box = [[-1, {}, -1], [1, 1, 1]] }}]",
            size - 1e-3
        )
    };
    for (height, clips) in [(0.0065, false), (0.002, true)] {
        let twin = pressing(&bench, height);
        let time = "dt = \"1 ms\"\nintegrator = \"backward-euler\"";
        let mut session = scene(&twin.address, &sheet(0.08), "origin = [0.04, 0.04, 0]", "8 mm", time);
        let (force, shown, clipped, beside) = settled(&mut session);
        println!("{height}: force {force} N, shown {shown} N, clipped {clipped} N, beside {beside} N");
        assert!((shown + clipped + beside - force).abs() < 1e-6 * force, "{force} {shown} {clipped} {beside}");
        assert!(beside == 0.0 && (clipped > 1e-6) == clips, "{clipped}");
        let pad = session.tools[0].pad.as_ref().unwrap();
        let (rows, columns) = (pad.array().rows, pad.array().columns);
        let at = |i: usize| {
            [(i / columns) as f64 - 0.5 * (rows - 1) as f64, (i % columns) as f64 - 0.5 * (columns - 1) as f64]
        };
        let centroid =
            pad.taxels.iter().enumerate().fold([0.0; 2], |c, (i, t)| [c[0] + t * at(i)[0], c[1] + t * at(i)[1]]);
        assert!(centroid.iter().all(|c| (c / shown).abs() < 1e-3), "right under it: {centroid:?}");
    }
}

#[test]
fn the_pins_give_the_normal_force_of_a_body() {
    let bench = pliant_tests::Bench::new();
    let body = "shape = { kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }\n\
                material = { plugin = \"mass-spring\", params = { damping-time = \"5 ms\" } }\ngrid = { level = 5 }";
    for radius in ["8 mm", "0.5 mm"] {
        let twin = pressing(&bench, if radius == "8 mm" { 0.0075 } else { -0.0005 });
        let mut session = scene(
            &twin.address,
            body,
            "body = \"thing\", from = [0.5, 0.5, 2.0], toward = [0.5, 0.5, 0.5]",
            radius,
            "dt = \"1 ms\"",
        );
        let (force, shown, clipped, beside) = settled(&mut session);
        println!("{radius}: force {force} N, shown {shown} N, clipped {clipped} N, beside {beside} N");
        let all = shown + clipped + beside;
        assert!((all - force).abs() < 0.03 * force, "{force} {shown} {clipped} {beside}");
    }
}

#[test]
fn without_taxels_nothing_is_computed_and_it_is_said() {
    let session = open(&pliant_tests::box_scene("", "", ""), 1);
    assert!(session.tools[0].pad.is_none());
    assert!(session.plan().left_out.iter().any(|l| l.what == "tactile rendering" && l.why.contains("no device")));
}
