//! R17 and R19: a fingertip on a taut membrane, and friction, against closed forms; what friction takes, against the energy.

#![allow(clippy::print_stdout, reason = "the table of errors")]

use pliant_engine::session::{EventKind, Session};
use pliant_solver::Vec3;
use pliant_tests::cloth::G;
use pliant_tests::{Bench, open, open_file};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write;

/// A disc: rings of equilateral triangles out to `fine` (m), `rings` of them, then rings that grow with their radius out to
/// `radius`. Points, triangles, and how many points are not on the border.
fn disc(rings: u32, fine: f64, radius: f64) -> (Vec<Vec3>, Vec<[u32; 3]>, usize) {
    let (mut points, mut triangles) = (vec![Vec3::zeros()], Vec::new());
    let around = 6 * rings;
    let growth = 1.0 + TAU / f64::from(around);
    let outer = ((radius / fine).ln() / growth.ln()).round().max(1.0);
    let mut ring = |count: u32, r: f64| {
        let first = points.len() as u32;
        points.extend((0..count).map(|i| {
            let (sine, cosine) = (TAU * f64::from(i) / f64::from(count)).sin_cos();
            Vec3::new(r * cosine, r * sine, 0.0)
        }));
        first
    };
    let (mut inner, mut held) = ((0, 1), 1);
    for k in 1..=rings {
        let (first, before) = (ring(6 * k, fine * f64::from(k) / f64::from(rings)), inner.1);
        for sector in 0..6 {
            for i in 0..k {
                // Of a sector: k edges outside, one less inside.
                let out = |i: u32| first + (sector * k + i) % (6 * k);
                let inn = |i: u32| inner.0 + (sector * (k - 1) + i) % before;
                triangles.push([inn(i), out(i), out(i + 1)]);
                if i + 1 < k {
                    triangles.push([inn(i), out(i + 1), inn(i + 1)]);
                }
            }
        }
        inner = (first, 6 * k);
    }
    for j in 1..=outer as u32 {
        let first = ring(around, fine * (radius / fine).powf(f64::from(j) / outer));
        for i in 0..around {
            let [a, b, c, d] = [inner.0 + i, inner.0 + (i + 1) % around, first + i, first + (i + 1) % around];
            triangles.extend(if (i + j) % 2 == 0 { [[a, c, d], [a, d, b]] } else { [[a, c, b], [b, c, d]] });
        }
        (inner, held) = ((first, around), first as usize);
    }
    (points, triangles, held)
}

/// N, on a tip of `radius` that is pressed `depth` (m) into a membrane of radius `around` under `tension` (N/m), and the radius
/// of the contact, m: small slopes, no friction, the pressure 2 T / R inside of it.
fn indented(tension: f64, radius: f64, around: f64, depth: f64) -> (f64, f64) {
    let (mut low, mut high) = (0.0, radius);
    for _ in 0..200 {
        let a = 0.5 * (low + high);
        let deep = a * a / (2.0 * radius) + a * a / radius * (around / a).ln();
        (low, high) = if deep < depth { (a, high) } else { (low, a) };
    }
    (TAU * tension * low * low / radius, low)
}

/// Stretch of the membrane from its rest shape: the more, the less its tension rises where it is dented.
const STRETCH: f64 = 6.0;

/// N, on the tip and on the border, of a tip of 8 mm that goes `depth` (m) into a taut membrane of 0.1 m under 10 N/m.
fn pressed(rings: u32, depth: f64, by: &str) -> [f64; 2] {
    let (points, triangles, held) = disc(rings, 2e-3, 0.1);
    let mut obj = String::new();
    points.iter().for_each(|p| _ = writeln!(obj, "v {:?} {:?} 0", p[0] / STRETCH, p[1] / STRETCH));
    triangles.iter().for_each(|t| _ = writeln!(obj, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1));
    // T = E (s - 1) / s for each width it has come to; 0.2 kg/m^2 of the stretched membrane.
    let young = 10.0 * STRETCH / (STRETCH - 1.0);
    let border: Vec<usize> = (held..points.len()).collect();
    let low = 0.008 - depth;
    let bench = Bench::new();
    bench.write("disc.obj", obj);
    let scene = format!(
        r#"
        format = 1
        [time]
        duration = 9
        dt = {dt}
        integrator = "backward-euler"
        [solver]
        tolerance = 1e-8
        iterations = 5000
        [[body]]
        mesh = "disc.obj"
        sheet = {{ warp = [1, 0, 0] }}
        [body.material]
        plugin = "cloth"
        params = {{ density = {density}, young-warp = {young}, poisson = 0, bending = "none" }}
        [[body.fixed]]
        nodes = {border:?}
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0, 0, 0.0081], [0.2, 0, 0, {low}], [9, 0, 0, {low}]] }}
        [[tool]]
        name = "finger"
        device = "hand"
        radius = "8 mm"
        stiffness = 300
        friction = [0, 0]
        sheets = "{by}"
        slew = "1e9 N/s"
        [[edit]]
        kind = "touch"
        tool = "finger"
        "#,
        density = 0.2 * STRETCH * STRETCH,
        dt = if by == "vertices" { 1e-2 } else { 1e-3 },
    );
    let mut session = open_file(&bench.write("scene.toml", scene), 1, None);
    session.bodies[0].system.nodes.x.iter_mut().for_each(|x| *x *= STRETCH);
    let (mut before, mut felt) = (0.0_f64, 0.0_f64);
    while session.time() < 0.4 || (session.time() < 2.0 && (felt - before).abs() > 1e-4 * felt) {
        before = felt;
        (0..if by == "vertices" { 7 } else { 70 }).for_each(|_| session.step());
        felt = session.frame().tools[0].force[2];
    }
    assert_eq!(session.events.count(EventKind::NotConverged) + session.events.count(EventKind::Quarantine), 0);
    let of_border = session.reactions(0)[held..].iter().map(|f| f[2]).sum();
    [session.frame().tools[0].force[2], of_border]
}

#[test]
fn r17_a_sphere_in_a_taut_membrane() {
    for (depth, radius, force) in [(5e-4, 8.73687122e-4, 5.99517341e-3), (1e-3, 1.28359419e-3, 1.29403304e-2)] {
        let (exact, contact) = indented(10.0, 8e-3, 0.1, depth);
        assert!((exact / force - 1.0).abs() < 1e-7 && (contact / radius - 1.0).abs() < 1e-7, "{exact} {contact}");
        for by in ["vertices", "triangles", "penalty"] {
            let rings = if by == "vertices" { &[4, 8, 12][..] } else { &[4, 6] };
            let error = |rings: &u32| {
                let [felt, border] = pressed(*rings, depth, by);
                assert!((felt / border - 1.0).abs() < 0.01, "{by} {rings}: tip {felt} N, border {border} N");
                felt / exact - 1.0
            };
            let errors: Vec<f64> = rings.iter().map(error).collect();
            println!(
                "R17 {depth} m {by}: {rings:?} rings of 2 mm, radius of contact {contact:.1e} m, errors {errors:.4?}"
            );
            // Slopes of 0.11 and 0.16 at the edge of the contact: the formula is of small ones.
            assert!(errors.iter().all(|e| e.abs() < 0.025), "{depth} {by}: {errors:?}");
        }
    }
}

/// A sheet of 0.2 m, of cells of 50 mm, on a tip so large that it is a plane, with `mu` between them, and gravity at `degrees`
/// from the plane's normal: on an incline.
fn incline(mu: f64, degrees: f64, by: &str, dt: f64) -> Session {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let scene = format!(
        r#"
        format = 1
        gravity = [{}, 0, {}]
        [time]
        duration = 1
        dt = {dt}
        integrator = "backward-euler"
        [solver]
        tolerance = 1e-10
        [output]
        energy = true
        [[body]]
        shape = {{ kind = "sheet", cells = 4, size = [0.2, 0.2, 0] }}
        sheet = {{ warp = [1, 0, 0] }}
        material = {{ plugin = "cloth", params = {{ density = 0.2, young-warp = 1000, poisson = 0.3 }} }}
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0.1, 0.1, -10000], [1, 0.1, 0.1, -10000]] }}
        [[tool]]
        name = "plane"
        device = "hand"
        radius = 1e4
        stiffness = 1000
        friction = [{mu}, {mu}]
        sheets = "{by}"
        slew = "1e9 N/s"
        [[edit]]
        kind = "touch"
        tool = "plane"
        "#,
        G * sine,
        -G * cosine,
    );
    open(&scene, 1)
}

/// Lets it come to lie on the plane, then has every vertex move with `speed` along it (m/s).
fn set_off(session: &mut Session, speed: f64) {
    (0..50).for_each(|_| session.step());
    session.bodies[0].system.nodes.v.fill(Vec3::new(speed, 0.0, 0.0));
}

/// Mean place and velocity along the slope, m and m/s.
fn along(session: &Session) -> [f64; 2] {
    let nodes = &session.bodies[0].system.nodes;
    let mean = |of: &dyn Fn(usize) -> f64| (0..nodes.len()).map(of).sum::<f64>() / nodes.len() as f64;
    [mean(&|i| nodes.x[i][0] - nodes.rest[i][0]), mean(&|i| nodes.v[i][0])]
}

#[test]
fn r19_a_sheet_on_an_incline_stays_and_slides_as_coulomb_says() {
    let (mu, slip) = (0.3_f64, 16.6992442);
    assert!((mu.atan().to_degrees() - slip).abs() < 1e-6);
    for by in ["vertices", "penalty"] {
        let [stays, slides] = [0.99, 1.01].map(|share| {
            let mut session = incline(mu, share * slip, by, 1e-3);
            set_off(&mut session, 0.0);
            let [from, _] = along(&session);
            (0..300).for_each(|_| session.step());
            let [to, speed] = along(&session);
            [to - from, speed]
        });
        let free = 0.5 * G * (1.01 * slip).to_radians().sin() * 0.09;
        println!(
            "R19 {by}: after 0.3 s at 0.99 and 1.01 of the slip angle {stays:?} {slides:?}, without friction {free}"
        );
        assert!(stays[0].abs() < 1e-4 * free && stays[1].abs() < 1e-4, "{by}: {stays:?}");
        let expected = G * ((1.01 * slip).to_radians().sin() - mu * (1.01 * slip).to_radians().cos());
        assert!((slides[1] / (0.3 * expected) - 1.0).abs() < 0.05, "{by}: {slides:?}, of {} m/s", 0.3 * expected);
        let mut session = incline(mu, 30.0, by, 1e-3);
        (0..100).for_each(|_| session.step());
        let early = along(&session)[1];
        (0..200).for_each(|_| session.step());
        let acceleration = (along(&session)[1] - early) / 0.2;
        println!("R19 {by}: {acceleration} m/s^2 on 30 degrees, exact 2.35628724");
        assert!((acceleration / 2.35628724 - 1.0).abs() < 0.01, "{by}: {acceleration} m/s^2");
    }
}

#[test]
fn r19_a_sheet_that_slides_stops_and_friction_has_what_it_had() {
    for by in ["vertices", "penalty"] {
        for dt in [1e-3, 5e-4] {
            let mut session = incline(0.3, 0.0, by, dt);
            set_off(&mut session, 1.0);
            let [from, _] = along(&session);
            let mass: f64 = session.bodies[0].system.nodes.mass.iter().sum();
            let mut taken = 0.0;
            for _ in 0..(0.5 / dt) as usize {
                session.step();
                taken += session.frame().friction_work;
            }
            let [to, speed] = along(&session);
            let gone = to - from;
            println!(
                "R19 {by} {dt} s: stopped after {gone} m, exact 0.169894665; friction took {taken} J of {} J",
                0.5 * mass
            );
            assert!(speed.abs() < 1e-3 && (gone / 0.169894665 - 1.0).abs() < 0.01, "{by}: {gone} m, {speed} m/s");
            assert!((taken / (0.5 * mass) - 1.0).abs() < 0.01, "{by}: {taken} J");
        }
    }
}

/// Tension of both ends, N, of a strip laid around a ball of 50 mm over `degrees`, one end held and one drawn.
fn capstan(degrees: f64, mu: f64, cells: u32) -> [f64; 2] {
    let (radius, tail, width) = (0.05, 0.02, 1e-3);
    let arc = radius * degrees.to_radians();
    let length = arc + 2.0 * tail;
    // Along the strip, from the middle of the arc on: where it is in the plane of the great circle, and which way it goes.
    let place = |s: f64| {
        let (sine, cosine) = (s.clamp(-0.5 * arc, 0.5 * arc) / radius).sin_cos();
        let beyond = s - s.clamp(-0.5 * arc, 0.5 * arc);
        ([radius * sine + beyond * cosine, radius * cosine - beyond * sine], [cosine, -sine])
    };
    let drawn = place(0.5 * length).1;
    let end = [drawn[0], drawn[1]].map(|c| 2e-3 * c);
    let bench = Bench::new();
    let scene = format!(
        r#"
        format = 1
        [time]
        duration = 9
        dt = "1 ms"
        integrator = "backward-euler"
        [solver]
        tolerance = 1e-10
        iterations = 20000
        [[body]]
        shape = {{ kind = "sheet", cells = {cells}, rows = 1, size = [{length}, {width}, 0] }}
        sheet = {{ warp = [1, 0, 0] }}
        [body.material]
        plugin = "cloth"
        params = {{ density = 0.2, young-warp = 1000, poisson = 0, bending = "none", damping-time = "1 ms" }}
        [[body.fixed]]
        box = [[-1, -1, -1], [1e-9, 1, 1]]
        [[body.fixed]]
        box = [[{}, -1, -1], [1, 1, 1]]
        path = [[0, 0, 0, 0], [0.5, {}, 0, {}], [9, {}, 0, {}]]
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0, 0, 0], [9, 0, 0, 0]] }}
        [[tool]]
        name = "drum"
        device = "hand"
        radius = {radius}
        friction = [{mu}, {mu}]
        sheets = "vertices"
        slew = "1e9 N/s"
        [[edit]]
        kind = "touch"
        tool = "drum"
        "#,
        length - 1e-9,
        end[0],
        end[1],
        end[0],
        end[1],
    );
    let mut session = open_file(&bench.write("scene.toml", scene), 1, None);
    let nodes = &mut session.bodies[0].system.nodes;
    for i in 0..nodes.len() {
        let [s, y, _] = nodes.rest[i].into();
        let ([x, z], _) = place(s - 0.5 * length);
        let across = y - 0.5 * width;
        let on = Vec3::new(x, across, z);
        // On the ball, a little inside; the tails beside it.
        let touches = (s - 0.5 * length).abs() <= 0.5 * arc;
        nodes.x[i] = if touches { on * radius * (1.0 - 1e-7) / on.norm() } else { on };
    }
    (0..800).for_each(|_| session.step());
    assert_eq!(session.events.count(EventKind::NotConverged) + session.events.count(EventKind::Quarantine), 0);
    let nodes = &session.bodies[0].system.nodes;
    let pull = |chosen: &dyn Fn(Vec3) -> bool| {
        let all = nodes.rest.iter().zip(session.reactions(0)).filter(|(rest, _)| chosen(**rest));
        all.map(|(_, f)| *f).sum::<Vec3>().norm()
    };
    [pull(&|rest| rest[0] < 1e-9), pull(&|rest| rest[0] > length - 1e-9)]
}

#[test]
fn r19_a_strip_around_a_ball_holds_as_on_a_capstan() {
    for (degrees, exact) in [(90.0, 1.60197765), (180.0, 2.5663324)] {
        let angle: f64 = degrees * PI / 180.0;
        assert!(((0.3 * angle).exp() / exact - 1.0).abs() < 1e-8 && angle >= FRAC_PI_2);
        let found = [30, 60].map(|cells| {
            let [held, drawn] = capstan(degrees, 0.3, cells);
            drawn / held
        });
        println!("R19 capstan {degrees}: {found:?}, exact {exact}");
        assert!((found[1] / exact - 1.0).abs() < 0.01, "{degrees}: {found:?}");
        let [held, drawn] = capstan(degrees, 0.0, 30);
        assert!((drawn / held - 1.0).abs() < 5e-3, "without friction: {held} N, {drawn} N");
    }
}
