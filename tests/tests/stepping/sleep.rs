//! Bodies that have come to rest sleep where the scene asks for it, and wake when something comes near.

use pliant_engine::session::{EventKind, HandPose, Session};
use pliant_solver::Vec3;
use pliant_tests::open;

/// A damped cloth that is held all around; a finger comes down on it after a second and stays.
fn held_all_around(sleep: &str) -> Session {
    open(
        &format!(
            r#"
            format = 1
            gravity = [0, 0, -9.81]
            [time]
            duration = 3
            dt = 0.005
            integrator = "backward-euler"
            {sleep}
            [[body]]
            name = "cloth"
            shape = {{ kind = "sheet", cells = 32, rows = 32, size = [0.2, 0.2, 0] }}
            sheet = {{ warp = [1, 0, 0] }}
            material = {{ plugin = "cloth", params = {{ density = 0.15, young-warp = 500, poisson = 0.3, bending-warp = 10e-6, damping-time = 0.02 }} }}
            fixed = [
                {{ box = [[-1, -1, -1], [0.001, 1, 1]] }}, {{ box = [[0.199, -1, -1], [1, 1, 1]] }},
                {{ box = [[-1, -1, -1], [1, 0.001, 1]] }}, {{ box = [[-1, 0.199, -1], [1, 1, 1]] }},
            ]
            [[device]]
            name = "hand"
            params = {{ path = [[0, 0.1, 0.1, 0.1], [1, 0.1, 0.1, 0.1], [1.3, 0.1, 0.1, -0.004], [3, 0.1, 0.1, -0.004]] }}
            [[tool]]
            name = "finger"
            device = "hand"
            radius = "10 mm"
            slew = "1e9 N/s"
            [[edit]]
            kind = "touch"
            tool = "finger"
            "#
        ),
        1,
    )
}

fn run_to(session: &mut Session, time: f64) {
    while session.time() < time - 1e-9 {
        session.step();
    }
}

#[test]
fn a_cloth_at_rest_costs_nothing_and_is_there_when_it_is_touched() {
    let (mut sleeping, mut waking) = (held_all_around("sleep = \"1 mm/s\""), held_all_around(""));
    for session in [&mut sleeping, &mut waking] {
        run_to(session, 0.99);
    }
    assert_eq!((sleeping.events.count(EventKind::Asleep), waking.events.count(EventKind::Asleep)), (1, 0));
    let x = sleeping.bodies[0].system.nodes.x.clone();
    sleeping.step();
    waking.step();
    assert_eq!(sleeping.frame().iterations, 0);
    // A body at rest may need no iterations, but the one that wakes finds its forces.
    assert!(sleeping.frame().work[0] == 0.0 && waking.frame().work[0] > 0.0);
    assert!(x == sleeping.bodies[0].system.nodes.x && x != sleeping.bodies[0].system.nodes.rest);
    for session in [&mut sleeping, &mut waking] {
        run_to(session, 2.5);
    }
    let force = |session: &Session| session.frame().tools[0].force[2];
    assert!(force(&waking) > 0.05, "{}", force(&waking));
    let off = (force(&sleeping) / force(&waking) - 1.0).abs();
    assert!(off < 1e-3, "the finger feels {} of {} N", force(&sleeping), force(&waking));
    assert_eq!(sleeping.events.count(EventKind::Asleep), 1, "a cloth that is held down does not sleep");
}

/// The box of a sheet with a reach of an edge is larger than what a fingertip can touch.
#[test]
fn a_finger_that_comes_near_a_cloth_without_touching_it_wakes_nothing() {
    let mut session = held_all_around("sleep = \"1 mm/s\"");
    run_to(&mut session, 1.0);
    let place = |z: f64| HandPose { position: Vec3::new(0.1, 0.1, z), rotation: Default::default(), buttons: 0 };
    let lowest = session.bodies[0].system.nodes.x.iter().fold(0.0, |low: f64, x| low.min(x.z));
    assert!(lowest < -1e-4, "it sags");
    // A finger of 10 mm above the middle, where the cloth is lowest, and the edges of the cloth are 6 mm. What jumps there could touch; what comes slowly does not.
    let hold = |session: &mut Session, z: f64| {
        session.place_hand(0, Some(place(z)));
        session.step();
    };
    (0..400).for_each(|_| hold(&mut session, 0.02));
    for step in 0..=95 {
        let z = 0.02 - 1e-4 * f64::from(step);
        hold(&mut session, z);
        assert!(session.is_at_rest() && session.frame().work[0] == 0.0, "the finger is at {z} m");
    }
    for _ in 0..20 {
        session.place_hand(0, Some(place(lowest + 0.009)));
        session.step();
    }
    assert!(!session.is_at_rest() && session.frame().tools[0].force[2] > 0.0, "it is touched");
}
