//! Cloth against closed forms and high-accuracy values.

use pliant_engine::session::{EventKind, Session};
use pliant_mesh::geometry::Vec3;
use pliant_tests::open;

/// A sheet of `cells` along x and y, of `size` (m), with `material` parameters and more lines.
fn sheet(pattern: &str, [cells, rows]: [u32; 2], size: [f64; 2], material: &str, time: &str, rest: &str) -> Session {
    let scene = format!(
        r#"
        format = 1
        {time}
        [[body]]
        shape = {{ kind = "sheet", cells = {cells}, rows = {rows}, pattern = "{pattern}", size = [{}, {}, 0] }}
        sheet = {{ warp = [1, 0, 0] }}
        material = {{ plugin = "cloth", params = {{ {material} }} }}
        {rest}
        "#,
        size[0], size[1]
    );
    open(&scene, 1)
}

const STATIC: &str = r#"
        [time]
        integrator = "quasi-static"
        dt = 1
        duration = 1
        [solver]
        tolerance = 1e-8
        newton = 400
        newton-tolerance = 1e-8
        iterations = 20000"#;

/// Vertices that rest where `wanted` says, where they are now.
fn places(session: &mut Session, wanted: impl Fn(Vec3) -> bool) -> Vec<Vec3> {
    session.update_surface();
    let body = &session.bodies[0];
    let all = body.model.surface.points.iter().zip(&body.skin.x);
    all.filter(|(rest, _)| wanted(**rest)).map(|(_, x)| *x).collect()
}

fn mean(places: &[Vec3], i: usize) -> f64 {
    places.iter().map(|x| x[i]).sum::<f64>() / places.len() as f64
}

/// Tip of a cantilever under its own weight, dimensionless load `gamma`: error in lengths.
fn elastica(pattern: &str, n: u32, gamma: f64, [h, w]: [f64; 2]) -> f64 {
    let (rho, l) = (0.2_f64, 0.2_f64);
    let rigidity = rho * 9.81 * l.powi(3) / gamma;
    let cell = l / f64::from(n);
    let width = 4.0 * cell * if pattern == "equilateral" { 0.75_f64.sqrt() } else { 1.0 };
    let material = format!("density = {rho}, young-warp = 2000, poisson = 0, bending-warp = {rigidity}");
    let held = "[[body.fixed]]\nbox = [[-1, -1, -1], [1e-9, 1, 1]]\nclamp = true";
    let time = format!("gravity = [0, 0, -9.81]{STATIC}");
    let mut session = sheet(pattern, [n, 4], [l, width], &material, &time, held);
    session.step();
    assert_eq!(session.events.count(EventKind::NotConverged), 0, "{pattern} {n} {gamma}");
    let tip = places(&mut session, |p| p[0] > l - 1e-9);
    (-mean(&tip, 2) / l - h).hypot(mean(&tip, 0) / l - w)
}

#[test]
fn a_cantilever_bends_as_the_heavy_elastica_on_any_mesh() {
    // Tip at rest: H/L and W/L (reference R06, two independent methods that agree to 2e-7).
    for (gamma, tip) in [
        (0.1, [0.0124984, 0.9999107]),
        (1.0, [0.1234714, 0.9912464]),
        (10.0, [0.7001997, 0.6563538]),
        (100.0, [0.9375239, 0.1592234]),
    ] {
        for pattern in ["regular", "alternating", "equilateral", "irregular"] {
            let [coarse, fine] = [8, 16].map(|n| elastica(pattern, n, gamma, tip));
            let order = (coarse / fine).log2();
            let told = format!("{pattern}, {gamma}: {coarse:.2e}, {fine:.2e}, order {order:.2}");
            assert!(fine < 0.01, "{told}");
            // Beyond, eight cells are too few to tell.
            assert!(gamma > 1.0 || order > 1.9, "{told}");
        }
    }
}

#[test]
fn a_strip_hangs_as_a_bar_does() {
    // R03: the tip sinks by rho g L^2 / 2 E, the top carries rho g L.
    let (rho, young, l) = (0.2, 1000.0, 0.2);
    let material = format!("density = {rho}, young-warp = {young}, poisson = 0, bending = \"none\"");
    let held = format!("[[body.fixed]]\nbox = [[-1, {}, -1], [1, 1, 1]]", l - 1e-9);
    let mut errors = Vec::new();
    for n in [10, 20, 40] {
        let time = format!("gravity = [0, -9.81, 0]{STATIC}");
        let mut session = sheet("regular", [n / 5, n], [0.2 * l, l], &material, &time, &held);
        session.step();
        let tip = places(&mut session, |p| p[1] < 1e-9);
        errors.push((-mean(&tip, 1) / (rho * 9.81 * l * l / (2.0 * young)) - 1.0).abs());
        let top: Vec3 = session.reactions(0).iter().sum();
        let weight = rho * 9.81 * 0.2 * l * l;
        assert!((top[1] / weight - 1.0).abs() < 1e-6, "{top:?} N carry {weight} N");
    }
    assert!(errors[2] < 2e-5, "{errors:?}");
}

#[test]
fn a_strip_between_two_rods_is_a_catenary() {
    // R02: length 0.2 m, span 0.15 m, 0.2 kg/m^2, 1000 N/m: sag 0.0588883 m.
    let (l, span) = (0.2, 0.15);
    let material = "density = 0.2, young-warp = 1000, poisson = 0, bending = \"none\"";
    let mut errors = Vec::new();
    for n in [20_u32, 40] {
        let held = format!(
            "[[body.fixed]]\nbox = [[-1, -1, -1], [1e-9, 1, 1]]\npath = [[0, 0, 0, 0], [1, {a}, 0, 0]]\n\
             [[body.fixed]]\nbox = [[{b}, -1, -1], [1, 1, 1]]\npath = [[0, 0, 0, 0], [1, -{a}, 0, 0]]",
            a = 0.5 * (l - span),
            b = l - 1e-9
        );
        let time = format!("gravity = [0, 0, -9.81]{}", STATIC.replace("dt = 1", "dt = 0.05"));
        let mut session = sheet("alternating", [n, 2], [l, 2.0 * l / f64::from(n)], material, &time, &held);
        (0..25).for_each(|_| session.step());
        let low = places(&mut session, |p| (p[0] - 0.5 * l).abs() < 1e-9);
        errors.push((-mean(&low, 2) / 0.0588883 - 1.0).abs());
    }
    assert!(errors[1] < 2e-3 && errors[0] / errors[1] > 3.0, "{errors:?}");
}

/// Holds all of the border of a cloth of 0.2 m.
const FRAME: &str = "
        [[body.fixed]]
        box = [[-1, 0.1999, -1], [1, 1, 1]]
        [[body.fixed]]
        box = [[-1, -1, -1], [1, 0.0001, 1]]
        [[body.fixed]]
        box = [[-1, -1, -1], [0.0001, 1, 1]]
        [[body.fixed]]
        box = [[0.1999, -1, -1], [1, 1, 1]]";

/// A cloth of 0.2 m, held, with a fingertip pressed into its middle.
fn pressed(n: u32, held: &str, deep: f64, friction: &str, time: &str) -> Session {
    let rest = format!(
        r#"
        {held}
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0.1, 0.1, 0.009], [0.05, 0.1, 0.1, {}]] }}
        [[tool]]
        name = "finger"
        device = "hand"
        radius = "8 mm"
        friction = {friction}
        slew = "1e9 N/s"
        [[edit]]
        kind = "touch"
        tool = "finger"
        "#,
        0.008 - deep
    );
    let material = "density = 0.15, young-warp = 500, poisson = 0.3, bending-warp = 10e-6, damping-time = 1e-2";
    sheet("alternating", [n, n], [0.2, 0.2], material, time, &rest)
}

#[test]
fn a_fingertip_feels_what_it_takes_to_hold_the_cloth() {
    let time = "gravity = [0, 0, 0]\n[time]\nduration = 2\nintegrator = \"backward-euler\"\n[solver]\ntolerance = 1e-8";
    let mut session = pressed(31, FRAME, 0.010, "[0.35, 0.3]", time);
    (0..400).for_each(|_| session.step());
    let felt = session.frame().tools[0];
    let top = session.reactions(0);
    let body = &session.bodies[0];
    let held = (0..top.len()).filter(|i| !body.system.nodes.constraint[*i].is_free());
    let border: Vec3 = held.map(|i| top[i]).sum();
    assert!(felt.force[2] > 0.0, "{felt:?}");
    let off = felt.force - border;
    assert!(off.norm() < 0.02 * felt.force[2], "finger {:?} N, border {border:?} N", felt.force);
    let all = places(&mut session, |_| true);
    let inside = all.iter().filter(|x| (**x - Vec3::new(0.1, 0.1, -0.002)).norm() < 0.008 * (1.0 - 1e-3));
    assert_eq!(inside.count(), 0, "no vertex is inside the tip");
    assert_eq!(session.events.count(EventKind::NotConverged) + session.events.count(EventKind::Quarantine), 0);
}

#[test]
fn a_sheet_that_nothing_acts_on_is_at_equilibrium() {
    // Turned, its forces at rest are rounding and not zero.
    let turned = "rotation = { axis = [1, 2, 3], angle = 0.7 }\nposition = [0.3, 0.1, 0.2]";
    let far = "[[device]]\nname = \"hand\"\nparams = { path = [[0, 5, 0, 0], [1, 5, 0, 0]] }\n\
               [[tool]]\nname = \"tip\"\ndevice = \"hand\"\nradius = 0.005\n[[edit]]\nkind = \"touch\"\ntool = \"tip\"";
    for pattern in ["alternating", "equilateral"] {
        for place in ["", turned] {
            let mut session =
                sheet(pattern, [8; 2], [0.1; 2], "fabric = \"interlock\"", STATIC, &format!("{place}\n{far}"));
            let before = session.bodies[0].system.nodes.x.clone();
            for _ in 0..3 {
                session.step();
            }
            let told = session.events.described();
            assert_eq!(session.events.count(EventKind::NotConverged), 0, "{pattern} {place}: {told:?}");
            let nodes = &session.bodies[0].system.nodes;
            let moved = nodes.x.iter().zip(&before).map(|(x, from)| (x - from).norm()).fold(0.0, f64::max);
            assert!(moved < 1e-12, "{pattern} {place}: {moved} m");
        }
    }
}
