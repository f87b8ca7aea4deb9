//! A cut face is touched like the skin around it: the dent that a ball presses into it is drawn. `LEVEL=6` runs it with another level.

#![allow(clippy::print_stdout, reason = "what was seen of each case")]

use crate::drawn_line::extra_parts;
use pliant_engine::session::Session;
use pliant_mesh::geometry::{Vec3, closest_point};
use pliant_mesh::testing::{Random, scan};
use pliant_mesh::{ObjDocument, generate};
use pliant_tests::{Bench, open_file};

/// Radius of the ball, m.
const BALL: f64 = 0.006;
/// How deep the hand goes below the cut face, m.
const DEPTH: f64 = 0.005;
/// Largest distance between the ball and the surface that is drawn, in depths of the dent. A cell is as large as the ball at the coarsest level here, and
/// the surface is as smooth as the cells are.
const MAX_GAP: f64 = 0.4;

/// A scene in which a blade cuts a body of 100 mm across the middle, the upper part flies off, and a ball is pressed into the face below. The ball is less
/// than two cells wide, so it meets triangles.
fn scene(material: &str, level: u32, at: f64) -> String {
    format!(
        r#"
        format = 1
        gravity = [0, 40, 0]
        [time]
        duration = "2 s"
        dt = "1 ms"
        [[body]]
        name = "model"
        mesh = "model.obj"
        size = "100 mm"
        material = {{ plugin = "{material}", params = {{ young = "30 kPa", density = 1000 }} }}
        grid = {{ level = {level}, region = "whole" }}
        [[body.fixed]]
        box = [[-1, -1, -1], [1, -0.012, 1]]
        [[device]]
        name = "hand"
        params = {{ peak-force = "50 N", path = [[0.0, -0.08, 0.001, -0.1], [0.1, 0.08, 0.001, -0.1], [0.4, 0.3, 0.3, 0.0],
            [0.7, {at}, 0.05, {at}], [0.9, {at}, {deep}, {at}], [2.0, {at}, {deep}, {at}]] }}
        [[tool]]
        name = "knife"
        device = "hand"
        radius = {BALL}
        stiffness = "2000 N/m"
        blade = {{ length = "200 mm", direction = [0, 0, 1], toughness = "1 J/m^2" }}
        [[edit]]
        kind = "cut"
        tool = "knife"
        end = "0.12 s"
        split = true
        [[edit]]
        kind = "touch"
        tool = "knife"
        start = "0.6 s"
        "#,
        deep = 0.001 + BALL - DEPTH
    )
}

/// Distance from a place to the surface that is drawn of the body that the ball is on, m.
fn distance(session: &mut Session, place: Vec3) -> f64 {
    session.update_surface();
    let body = &session.bodies[session.tools[0].tool.contact().expect("a contact").body as usize];
    let corners = body.model.surface.triangles.iter().map(|t| t.map(|v| body.skin.x[v as usize]));
    corners.map(|corners| (closest_point(place, corners).point - place).norm()).fold(f64::INFINITY, f64::min)
}

fn models(random: &mut Random) -> Vec<(&'static str, ObjDocument)> {
    vec![
        ("ball", generate::sphere(16, 0.05).unwrap()),
        ("box", generate::cuboid(10, [0.1, 0.09, 0.08]).unwrap()),
        ("coarse box", generate::cuboid(3, [0.1, 0.09, 0.08]).unwrap()),
        ("cylinder", generate::cylinder(40, 12, 0.04, 0.1).unwrap()),
        ("scan", scan(0, 3000, 0, random.next_u64()).document()),
    ]
}

#[test]
fn a_ball_presses_a_dent_into_a_cut_face() {
    let mut random = Random(5);
    let bench = Bench::new();
    let materials = ["mass-spring", "neo-hookean", "corotational"].into_iter().cycle();
    for ((name, document), material) in models(&mut random).into_iter().zip(materials) {
        let level = 4 + random.below(2) as u32;
        let level = std::env::var("LEVEL").map_or(level, |level| level.parse().expect("a level"));
        let at = 0.02 * (random.unit() - 0.5);
        bench.write("model.obj", document.bytes());
        let mut session = open_file(&bench.write("scene.toml", scene(material, level, at)), 1, None);
        (0..1100).for_each(|_| session.step());
        let what = format!("{name} of {material}, level {level}");
        assert_eq!(session.bodies.len(), 2, "{what}: parted");
        // Nothing beside the parts of the surface flies about.
        let extra: usize = session.bodies.iter().map(extra_parts).sum();
        assert_eq!(extra, 0, "{what}: parts of the lattice");
        let tool = &session.tools[0].tool;
        let (ball, force) =
            (tool.proxy.position, tool.coupling.stiffness * (tool.proxy.position.y - (0.001 + BALL - DEPTH)));
        let dent = 0.001 + BALL - ball.y;
        let gap = (distance(&mut session, ball) - BALL).abs();
        println!("{what}: {force:.3} N, a dent of {:.2} mm, {:.2} mm from the ball", 1e3 * dent, 1e3 * gap);
        assert!(session.bodies.iter().all(|body| body.frozen.is_none()), "{what}: in quarantine");
        assert!(dent > 0.2 * DEPTH, "{what}: a dent of {dent} m");
        assert!(gap <= MAX_GAP * dent, "{what}: {gap} m between the ball and what is drawn, in a dent of {dent} m");
    }
}
