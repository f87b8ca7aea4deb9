//! A pressure acts where the hand is, and its own deformation of the surface does not move it about or let it go.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Random, models};
use pliant_mesh::{Bounds, Surface};
use pliant_tests::{Bench, open_file};

/// m: the longest edge of a model, the tool, the soft region, and how high the hand is above the surface
const SIZE: f64 = 0.1;
const TOOL: f64 = 0.005;
const RADIUS: f64 = 0.015;
const HEIGHT: f64 = 0.001;

/// A scene in which a hand goes along a line in 0.2 s from 0.1 s on, m.
fn scene(body: &str, kind: &str, pressure: f64, [from, to]: [Vec3; 2]) -> String {
    let row = |time: f64, p: Vec3| format!("[{time}, {}, {}, {}]", p.x, p.y, p.z);
    let path = [row(0.0, from), row(0.1, from), row(0.3, to)].join(", ");
    format!(
        "format = 1\n[time]\nduration = 1\ndt = \"2 ms\"\n[[body]]\n{body}\n[[device]]\nname = \"hand\"\n\
         params = {{ interpolation = \"smooth\", peak-force = \"50 N\", path = [{path}] }}\n[[tool]]\nname = \"finger\"\ndevice = \"hand\"\n\
         radius = {TOOL}\n[[edit]]\nkind = \"{kind}\"\ntool = \"finger\"\nradius = {RADIUS}\nstrength = {pressure}\n"
    )
}

/// Holds the half of a body about the origin that a hand is not at: a pressure pushes a free body away.
fn far_half(hand: Vec3) -> String {
    let axis = hand.iamax();
    let (mut min, mut max) = ([-1.0; 3], [1.0; 3]);
    if hand[axis] > 0.0 {
        max[axis] = 0.0
    } else {
        min[axis] = 0.0
    }
    format!("[[body.fixed]]\nbox = [{min:?}, {max:?}]\n")
}

/// Places in the shape at rest and in the present shape, in the steps of 0.3 s, m; fails where there is none.
fn places(bench: &Bench, text: String, what: &str) -> Vec<[Vec3; 2]> {
    let mut session: Session = open_file(&bench.write("scene.toml", text), 1, None);
    let place = |session: &mut Session| {
        session.step();
        let at = session.tools[0].tool.contact();
        let rest = at.unwrap_or_else(|| panic!("{what}: the place is lost at {:.3} s", session.time())).rest;
        [rest, session.bodies[0].embed_point(rest).expect("a place").now]
    };
    (0..150).map(|_| place(&mut session)).collect()
}

/// Fails where a place moves on the body under a hand at rest.
fn stays(places: &[[Vec3; 2]], what: &str) {
    let far = places.iter().map(|[rest, _]| (rest - places[0][0]).norm()).fold(0.0, f64::max);
    assert!(far == 0.0, "{what}: the place moves by {far} m under a hand at rest");
}

#[test]
fn a_pressure_stays_where_a_hand_at_rest_is() {
    let mut random = Random(41);
    for model in models(6, 17).iter().filter(|model| model.closed && model.genus.is_some()) {
        let bench = Bench::new();
        bench.write("model.obj", &model.text);
        let surface = Surface::from_document(&model.document());
        let Bounds { min, max } = surface.bounds();
        let (scale, centre) = (SIZE / (max - min).max(), min.lerp(&max, 0.5));
        for kind in ["inflate", "deflate"] {
            let triangle = surface.triangles[random.next_u64() as usize % surface.triangles.len()];
            let [a, b, c] = triangle.map(|v| scale * (surface.points[v as usize] - centre));
            let hand = (a + b + c) / 3.0 + HEIGHT * (b - a).cross(&(c - a)).normalize();
            let (young, share) = (1e4, 0.03 + 0.27 * random.unit());
            let body = format!(
                "mesh = \"model.obj\"\nsize = {SIZE}\ngrid = {{ level = 5 }}\n\
                 material = {{ plugin = \"mass-spring\", params = {{ young = {young}, damping-time = \"1 ms\" }} }}\n{}",
                far_half(hand)
            );
            let what = format!("{kind} of {} by {share:.2} E at {:.3?}", model.name, hand.as_slice());
            let places = places(&bench, scene(&body, kind, share * young, [hand; 2]), &what);
            stays(&places, &what);
        }
    }
}

#[test]
fn a_pressure_goes_where_the_hand_goes() {
    let slab = "shape = { kind = \"box\", cells = 16, size = [0.1, 0.1, 0.03] }\ngrid = { level = 5 }\n\
                material = { plugin = \"mass-spring\", params = { young = 1e4, damping-time = \"1 ms\" } }\n\
                [[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, -0.0149]]";
    let sheet = "shape = { kind = \"sheet\", pattern = \"alternating\", cells = 24, size = [0.1, 0.1, 0] }\nposition = [-0.05, -0.05, 0]\nsheet = {}\n\
                 material = { plugin = \"cloth\", params = { young-warp = 200, young-weft = 200, poisson = 0.2, damping-time = \"5 ms\" } }\n\
                 [[body.fixed]]\nbox = [[-1, -1, -1], [1, -0.0499, 1]]\n[[body.fixed]]\nbox = [[-1, 0.0499, -1], [1, 1, 1]]";
    for (body, top, pressure) in [(slab, 0.015, 300.0), (slab, 0.015, 2e3), (sheet, 0.0, 20.0)] {
        for kind in ["inflate", "deflate"] {
            let hand = [-0.012, 0.012].map(|x| Vec3::new(x, 0.003, top + HEIGHT));
            let bench = Bench::new();
            let places = places(&bench, scene(body, kind, pressure, hand), kind);
            for ([_, place], hand) in [(places[0], hand[0]), (places[149], hand[1])] {
                let beside = (place - hand).xy().norm();
                // The falloff there is 0.98 of that at the centre.
                assert!(beside < 0.1 * RADIUS, "{kind}: the place {place:?} is {beside} m beside the hand at {hand:?}");
            }
        }
    }
}
