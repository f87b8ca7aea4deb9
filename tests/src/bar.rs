//! Bars whose material differs from place to place.

use crate::{Bench, NOW, open_file};
use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;

/// Factors of the two halves of a bar.
pub const FACTORS: [f64; 2] = [0.3, 4.0];
/// Strain of a half, small enough for linear elasticity.
pub const STRAIN: f64 = 1e-5;
/// Every material with fields: what carries it, and the parameter that makes it stiffer in proportion.
pub const MATERIALS: [(&str, &str, &str); 6] = [
    ("mass-spring", "", "young"),
    ("neo-hookean", "poisson = 0.4", "young"),
    ("neo-hookean", "poisson = 0.3, yield-strain = 0.1", "young"),
    ("corotational", "poisson = 0.45", "young"),
    ("cloth", "bending = \"hinge\"", "young"),
    ("cloth", "", "thickness"),
];
/// A solid bar along x about the origin.
pub const SOLID: &str =
    "shape = { kind = \"box\", cells = 8, size = [0.08, 0.04, 0.04] }\ngrid = { level = 5, region = \"whole\" }";
/// A sheet along x about the origin.
pub const SHEET: &str =
    "shape = { kind = \"sheet\", cells = 16, size = [0.08, 0.04, 0.0] }\nposition = [-0.04, -0.02, 0]\nsheet = {}";

/// A whole body with fields, after a step.
pub fn open_bar(bench: &Bench, body: &str, material: &str, params: &str, fields: &str) -> Session {
    let text = format!(
        "format = 1\n[time]\nduration = 0.01\n[[body]]\n{body}\n[body.material]\nplugin = \"{material}\"\nparams = {{ {params} }}\n{fields}\n\
         [[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1]]\npath = [[0, 0, 0, 0], [1, 1e-9, 0, 0]]\n"
    );
    let mut session = open_file(&bench.write("scene.toml", text), 1, None);
    session.step();
    session
}

/// Elastic energy (J) with one strain along x where x < 0 and another beyond, the sides confined.
///
/// # Panics
/// If it is not finite.
pub fn energy(session: &mut Session, strains: [f64; 2]) -> f64 {
    let system = &mut session.bodies[0].system;
    for (x, rest) in system.nodes.x.iter_mut().zip(&system.nodes.rest) {
        let strain = if rest.x < 0.0 { strains[0] } else { strains[1] };
        *x = rest + Vec3::new(strain * rest.x, 0.0, 0.0);
    }
    system.energy(NOW).expect("finite")
}

/// The least elastic energy (J) of a bar that is [`STRAIN`] longer as a whole, where each half has a strain of its own.
pub fn energy_in_series(session: &mut Session) -> f64 {
    // E = a s0^2 + b s1^2 + c s0 s1, and the middle of the bar goes to where E is least with s0 + s1 = 2 STRAIN.
    let [a, b, both] = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|s| energy(session, s.map(|s| s * STRAIN)));
    let c = both - a - b;
    let share = (2.0 * b - c) / (2.0 * a + 2.0 * b - 2.0 * c);
    energy(session, [2.0 * share * STRAIN, 2.0 * (1.0 - share) * STRAIN])
}

/// A field of both halves along an axis.
pub fn halves(param: &str, axis: usize) -> String {
    let half = |side: usize| {
        let (mut low, mut high) = ([-1.0; 3], [1.0; 3]);
        [&mut high, &mut low][side][axis] = 0.0;
        format!("[[body.field]]\nparam = \"{param}\"\nbox = [{low:?}, {high:?}]\nfactor = {}\n", FACTORS[side])
    };
    half(0) + &half(1)
}
