//! Paint over the surface: a layer under the side that faces the tool, on solids and sheets, and how a painted body feels.

use pliant_editor::SurfacePoint;
use pliant_engine::body::{Body, Lattice};
use pliant_engine::session::Session;
use pliant_mesh::Surface;
use pliant_mesh::geometry::{Vec3, closest_point};
use pliant_mesh::testing::{Random, models};
use pliant_tests::{Bench, open, open_file};
use std::collections::BTreeSet;

/// The factor that strokes reach.
const FACTOR: f64 = 4.0;

/// A scene with one stroke of paint that stands where the surface has this place (m) and normal.
fn scene(body: &str, SurfacePoint { point: at, normal }: SurfacePoint, radius: f64, depth: &str) -> String {
    let row = |time: f64, height: f64| {
        let p = at + height * normal;
        format!("[{time}, {}, {}, {}]", p.x, p.y, p.z)
    };
    format!(
        "format = 1\n[time]\nduration = 1\nintegrator = \"backward-euler\"\n[[body]]\n{body}\n[[device]]\nname = \"hand\"\n\
         params = {{ path = [{}, {}] }}\n[[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"4 mm\"\n[[edit]]\nkind = \"paint\"\n\
         tool = \"finger\"\nradius = {radius}\nfalloff = \"constant\"\nstrength = {FACTOR}\ndepth = {depth}\n",
        row(0.0, 0.006),
        row(0.02, 0.0035)
    )
}

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
}

fn lattice(body: &Body) -> &Lattice {
    body.discretization.lattice().expect("a solid")
}

/// Painted elements: cells of a solid or triangles of a sheet.
fn painted(body: &Body) -> BTreeSet<u64> {
    let elements: Vec<(u64, f64)> = match body.discretization.lattice() {
        Some(lattice) => lattice.painted().elements().map(|(id, factors)| (id, factors[0])).collect(),
        None => body.discretization.sheet().unwrap().painted().elements().map(|(t, factors)| (t, factors[0])).collect(),
    };
    elements.into_iter().filter(|(_, factor)| *factor != 1.0).map(|(id, _)| id).collect()
}

/// The id of the active cell around a point of the rest shape (m).
fn cell_at(body: &Body, point: Vec3) -> Option<u64> {
    let lattice = lattice(body);
    lattice.cell_of(point).expect("a cell").map(|cell| lattice.region().cell_id[cell])
}

/// On a plate the cells of a layer are known: those whose middles are as deep as it is thick, or that the top goes through.
#[test]
fn a_layer_of_a_plate_is_as_thick_as_asked_and_leaves_the_other_side() {
    const TOP: f64 = 0.006;
    for level in [4, 5, 6] {
        for (depth, thickness) in
            [("\"surface\"", 0.0_f64), ("\"2.5 mm\"", 0.0025), ("0.005", 0.005), ("\"through\"", 1.0)]
        {
            let body = format!(
                "shape = {{ kind = \"box\", cells = 20, size = [0.06, 0.06, 0.012] }}\ngrid = {{ level = {level}, region = \"whole\" }}\n\
                 material = {{ plugin = \"corotational\" }}\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]"
            );
            let radius = 0.016;
            let place = SurfacePoint { point: Vec3::new(0.001, 0.002, TOP), normal: Vec3::z() };
            let mut session = open(&scene(&body, place, radius, depth), 1);
            run(&mut session, 0.06);
            let body = &session.bodies[0];
            let (found, lattice, edge) = (painted(body), lattice(body), lattice(body).edge());
            let at = session.tools[0].tool.proxy.touch.expect("a contact").rest;
            let (half, mut cells) = (0.5 * edge, 0);
            for (id, corners) in lattice.region().cell_id.iter().zip(&lattice.region().cell_corners) {
                let middle = corners.iter().map(|n| lattice.grid_rest(*n)).sum::<Vec3>() / 8.0;
                let below = TOP - middle.z;
                let is_deep = below > thickness.max(half) + 1e-9 || below < -half - 1e-9;
                let away = (middle.xy() - at.xy()).norm();
                let what = format!("level {level}, depth {depth}: cell at {middle:?}, {below} m deep");
                if found.contains(id) {
                    assert!(!is_deep && away < radius + edge, "{what} is painted");
                    cells += 1;
                } else {
                    let is_inside = (middle - at).norm() < radius - edge;
                    assert!(is_deep || !is_inside || thickness.max(half) - below < 1e-9, "{what} is not painted");
                }
            }
            assert!(cells > 8, "level {level}, depth {depth}: {cells} cells");
            if depth != "\"through\"" && edge < 0.004 {
                let back = cell_at(body, Vec3::new(at.x, at.y, -TOP + 1e-6)).expect("a cell");
                assert!(!found.contains(&back), "level {level}, depth {depth}: the other side is painted");
            }
        }
    }
}

/// Where a ray from the contact into a body leaves it again, m along the ray; `None` where it does not.
fn thickness(surface: &Surface, from: Vec3, along: Vec3) -> Option<f64> {
    let hits = surface.triangles.iter().filter_map(|triangle| {
        let [a, b, c] = triangle.map(|v| surface.points[v as usize]);
        let normal = (b - a).cross(&(c - a));
        let t = (a - from).dot(&normal) / along.dot(&normal);
        let p = from + t * along;
        let is_in = [(a, b), (b, c), (c, a)].iter().all(|(a, b)| (b - a).cross(&(p - a)).dot(&normal) >= 0.0);
        (is_in && t > 1e-5).then_some(t)
    });
    hits.min_by(f64::total_cmp)
}

/// Distance (m) of a point from the nearest triangle whose normal is less than 90 degrees from `normal`.
fn nearest_facing(surface: &Surface, point: Vec3, normal: Vec3) -> f64 {
    let corners = surface.triangles.iter().map(|triangle| triangle.map(|v| surface.points[v as usize]));
    let facing = corners.filter(|[a, b, c]| (b - a).cross(&(c - a)).dot(&normal) > 0.0);
    facing.map(|corners| (closest_point(point, corners).point - point).norm()).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_stroke_over_the_surface_of_any_model_leaves_the_other_side_and_the_depth() {
    let (mut thin, mut strokes) = (0, 0);
    for (i, model) in models(4, 5).iter().filter(|m| m.closed && m.genus.is_some()).enumerate() {
        let surface = Surface::from_document(&model.document());
        let is_thin = model.name == "tube";
        let levels: &[u32] = if is_thin { &[7; 14] } else { &[5, 6] };
        for (k, level) in levels.iter().enumerate() {
            let bench = Bench::new();
            bench.write("model.obj", &model.text);
            let bounds = surface.bounds();
            let scale = 0.1 / bounds.longest_edge();
            let triangle = surface.triangles[(37 + 91 * i + 173 * k) % surface.triangles.len()];
            let corners = triangle.map(|v| scale * (surface.points[v as usize] - bounds.centre()));
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
            let place = SurfacePoint { point: corners.iter().sum::<Vec3>() / 3.0, normal };
            let body = format!(
                "mesh = \"model.obj\"\nsize = 0.1\nmaterial = {{ plugin = \"mass-spring\" }}\ngrid = {{ level = {level}, radius = 0.002 }}\n\
                 [[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]"
            );
            let layers = ["\"surface\"", "0.006", "\"through\""].map(|depth| {
                let mut session = open_file(&bench.write("scene.toml", scene(&body, place, 0.018, depth)), 1, None);
                run(&mut session, 0.06);
                session
            });
            let what = format!("{} at level {level}, triangle {triangle:?}", model.name);
            let Some(touch) = layers[0].tools[0].tool.proxy.touch else { continue };
            strokes += 1;
            let bodies = layers.each_ref().map(|session| &session.bodies[0]);
            let [surface, layer, through] = bodies.map(painted);
            let sizes = [&surface, &layer, &through].map(BTreeSet::len);
            assert!(sizes[0] >= 4 && sizes[0] <= sizes[1], "{what}: {sizes:?} cells");
            // Through the depth the middle of a cell has to be in the ball, in a layer the surface over it; and the elastic layer is as stiff as what is
            // painted below it, so the contacts are not at quite the same places.
            let beyond = [surface.difference(&layer).count(), layer.difference(&through).count()];
            let is_rim = |(count, size): (&usize, &usize)| 5 * count <= *size;
            assert!(beyond.iter().zip(&sizes).all(is_rim), "{what}: {beyond:?} of {sizes:?} cells");
            let edge = lattice(bodies[0]).edge();
            let at = touch.rest - 1e-6 * touch.rest_normal.normalize();
            assert!(surface.contains(&cell_at(bodies[0], at).expect("a cell")), "{what}: the cell it touches");
            let inwards = -touch.rest_normal.normalize();
            let Some(thick) = thickness(&bodies[0].model.surface, at, inwards) else { continue };
            let back = cell_at(bodies[0], at + (thick - 1e-5) * inwards);
            for (found, depth) in [(&surface, 0.0), (&layer, 0.006)] {
                // A cell has one factor: where the side that faces the tool goes through it too, it is painted.
                let from = at + (thick - 1e-5) * inwards;
                if nearest_facing(&bodies[0].model.surface, from, -inwards) > depth + edge * f64::sqrt(3.0) {
                    assert!(
                        back.is_none_or(|cell| !found.contains(&cell)),
                        "{what}: the other side, {thick} m through"
                    );
                    thin += usize::from(back.is_some_and(|cell| through.contains(&cell)));
                }
            }
        }
    }
    assert!(strokes > 10 && thin > 3, "{thin} thin parts of {strokes} strokes");
}

/// A strip of cloth folded once: two arms, one over the other, 6 mm apart. Every triangle is turned round with a probability of `flipped`.
fn hairpin(flipped: f64) -> String {
    const GAP: f64 = 0.006;
    let bend = std::f64::consts::PI * 0.5 * GAP;
    let along = |s: f64| {
        let (arm, angle) = (0.03, s / (0.5 * GAP));
        if s < 0.0 {
            [-s.min(arm), 0.5 * GAP]
        } else if s <= bend {
            [-0.5 * GAP * f64::sin(angle), 0.5 * GAP * f64::cos(angle)]
        } else {
            [s - bend, -0.5 * GAP]
        }
    };
    let (rows, columns) = (48, 16);
    let (mut text, mut random) = (String::new(), Random(7));
    for i in 0..=rows {
        let [x, z] = along(-0.03 + (0.06 + bend) * f64::from(i) / f64::from(rows));
        for j in 0..=columns {
            text += &format!("v {x} {} {z}\n", 0.03 * (f64::from(j) / f64::from(columns) - 0.5));
        }
    }
    for i in 0..rows {
        for j in 0..columns {
            let v = |i: i32, j: i32| i * (columns + 1) + j + 1;
            for [a, b, c] in [[v(i, j), v(i + 1, j), v(i + 1, j + 1)], [v(i, j), v(i + 1, j + 1), v(i, j + 1)]] {
                let [b, c] = if random.unit() < flipped { [c, b] } else { [b, c] };
                text += &format!("f {a} {b} {c}\n");
            }
        }
    }
    text
}

#[test]
fn a_stroke_over_a_folded_sheet_leaves_the_other_arm() {
    let mut sets = Vec::new();
    for flipped in [0.0, 0.5, 1.0] {
        let bench = Bench::new();
        bench.write("fold.obj", hairpin(flipped));
        let body = "mesh = \"fold.obj\"\nsheet = {}\nmaterial = { plugin = \"cloth\" }\n[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]";
        let place = SurfacePoint { point: Vec3::new(0.004, 0.0, 0.003), normal: Vec3::z() };
        for depth in ["\"surface\"", "\"1 mm\"", "\"through\""] {
            let mut session = open_file(&bench.write("scene.toml", scene(body, place, 0.012, depth)), 1, None);
            run(&mut session, 0.06);
            let body = &session.bodies[0];
            let found = painted(body);
            let height = |t: &u64| {
                let corners = body.model.surface.triangles[*t as usize];
                corners.iter().map(|v| body.model.surface.points[*v as usize].z).sum::<f64>() / 3.0
            };
            let below = found.iter().filter(|t| height(t) < -1e-4).count();
            let above = found.len() - below;
            assert!(above > 40, "{depth}, {flipped} turned round: {above} triangles");
            assert_eq!(below > 10, depth == "\"through\"", "{depth}, {flipped} turned round: {below} below");
            assert!(depth == "\"through\"" || below == 0, "{depth}, {flipped} turned round: {below} below");
            if depth == "\"surface\"" {
                sets.push(found);
            }
        }
    }
    assert!(sets.windows(2).all(|pair| pair[0] == pair[1]), "orientation of triangles matters");
}

/// Pa
const YOUNG: f64 = 40e3;

/// The force (N) at the end of a press by a finger of this radius, on a ball of this stiffness and painted like this.
fn press(radius: &str, young: f64, paint: &str) -> f64 {
    let text = format!(
        "format = 1\n[time]\nduration = 1\nintegrator = \"backward-euler\"\n[[body]]\n\
         shape = {{ kind = \"sphere\", cells = 16, size = [0.06, 0.06, 0.06] }}\ngrid = {{ level = 5, region = \"whole\" }}\n\
         material = {{ plugin = \"corotational\", params = {{ young = {young}, damping-time = \"10 ms\" }} }}\n[[body.fixed]]\n\
         box = [[-1, -1, -1], [1, 1, -0.02]]\n[[device]]\nname = \"hand\"\n\
         params = {{ peak-force = \"50 N\", path = [[0, 0, 0, 0.04], [0.03, 0, 0, {}]] }}\n[[tool]]\nname = \"finger\"\ndevice = \"hand\"\n\
         radius = \"{radius}\"\nfriction = [0, 0]\nstiffness = \"1000 N/m\"\n[[edit]]\ntool = \"finger\"\n{paint}\n",
        0.027 + pliant_engine::scene::parse_quantity(radius, "m").expect("a length"),
    );
    let mut session = open(&text, 1);
    run(&mut session, 0.25);
    session.frame().tools[0].force.norm()
}

/// A body that is painted all over is one of that stiffness, and so is the elastic layer by which tools meet it.
#[test]
fn a_body_that_is_painted_all_over_feels_as_one_of_that_stiffness() {
    for (radius, factor) in [("8 mm", 4.0), ("1 mm", 4.0), ("8 mm", 0.25)] {
        let all = format!("kind = \"paint\"\nradius = 0.3\nfalloff = \"constant\"\nstrength = {factor}");
        let painted = press(radius, YOUNG, &all);
        let given = press(radius, factor * YOUNG, "kind = \"touch\"");
        // The press ends in equilibrium up to what 0.1 s of damping leave.
        assert!(given > 0.1 && (painted / given - 1.0).abs() < 1e-3, "{radius}: {painted} N painted, {given} N given");
    }
}

/// A painted spot feels stiffer than a plain one also where only its surface is painted, and the more the deeper the paint goes.
#[test]
fn a_painted_spot_feels_stiffer_the_deeper_the_paint_goes() {
    for radius in ["8 mm", "1 mm"] {
        let spot = |depth: &str| {
            press(
                radius,
                10e3,
                &format!("kind = \"paint\"\nradius = \"12 mm\"\nfalloff = \"constant\"\nstrength = 8\ndepth = {depth}"),
            )
        };
        let plain = press(radius, 10e3, "kind = \"touch\"");
        let forces = [plain, spot("\"surface\""), spot("\"through\"")];
        assert!(forces.windows(2).all(|pair| pair[1] > 1.02 * pair[0]), "{radius}: {forces:?} N");
    }
}

#[test]
fn a_depth_that_cannot_be_is_refused_by_name() {
    let cases: [(&str, &[&str]); 4] = [
        ("kind = \"paint\"\ndepth = \"deep\"", &["depth \"deep\"", "\"surface\" or the thickness of a layer"]),
        ("kind = \"paint\"\ndepth = -0.01", &["depth is -0.01 m", "above 0"]),
        ("kind = \"paint\"\ndepth = \"3 kPa\"", &["depth \"3 kPa\"", "m"]),
        ("kind = \"touch\"\ndepth = \"surface\"", &["`touch` does not read `depth`"]),
    ];
    for (edit, said) in cases {
        let bench = Bench::new();
        bench.write("scene.toml", pliant_tests::box_scene("", "", "").replace("kind = \"touch\"", edit));
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2);
        assert!(ran.err.starts_with("error: scene.toml:"), "{edit}: {}", ran.err);
        ran.says(said);
    }
}
