//! Pieces of cloth under loads and integrators of a test's own.

use crate::{Bench, open_file};
use pliant_engine::session::Session;
use pliant_mesh::Surface;
use pliant_mesh::generate::{Pattern, equilateral_rows, grid};
use pliant_solver::{Integrator, Loads, Pool, Scheme, StepError, StepReport, StepTime, System, Vec3};
use std::fmt::Write;

/// The patterns of reference cases.
pub const PATTERNS: [Pattern; 4] = [Pattern::Regular, Pattern::Alternating, Pattern::Equilateral, Pattern::Irregular];

/// Acceleration of gravity, m/s^2.
pub const G: f64 = 9.81;

/// A flat sheet of triangles in the plane z = 0. Equilateral ones have as many rows as make them so.
///
/// # Panics
/// If there is no such sheet.
pub fn sheet(pattern: Pattern, [columns, rows]: [u32; 2], size: [f64; 2]) -> Surface {
    let rows = if pattern == Pattern::Equilateral { equilateral_rows(columns, size) } else { rows };
    Surface::from_document(&grid([columns, rows], size, pattern).unwrap_or_else(|e| panic!("{e}")))
}

/// A piece of cloth, and what moves it.
pub struct Piece {
    /// What it was opened as. Its own integrator is not used.
    pub session: Session,
    /// How it moves.
    pub integrator: Integrator,
    /// Acceleration of gravity on the piece, m/s^2.
    pub gravity: Vec3,
    /// N (n x 3), or empty
    pub forces: Vec<Vec3>,
    /// Simulated time so far, s.
    pub time: f64,
}

impl Piece {
    /// Of a mesh, with `params` of the plugin in TOML; held where `held` says, clamped if `clamp`. The warp runs along x.
    ///
    /// # Panics
    /// If the scene cannot be opened.
    pub fn new(surface: &Surface, params: &str, held: impl Fn(Vec3) -> bool, clamp: bool) -> Self {
        let mut obj = String::new();
        surface.points.iter().for_each(|p| _ = writeln!(obj, "v {:?} {:?} {:?}", p[0], p[1], p[2]));
        surface
            .triangles
            .iter()
            .map(|t| t.map(|v| v + 1))
            .for_each(|t| _ = writeln!(obj, "f {} {} {}", t[0], t[1], t[2]));
        let numbers: Vec<usize> = (0..surface.points.len()).filter(|v| held(surface.points[*v])).collect();
        let fixed = match numbers.len() {
            0 => String::new(),
            _ => format!("[[body.fixed]]\nnodes = {numbers:?}\nclamp = {clamp}"),
        };
        let bench = Bench::new();
        bench.write("sheet.obj", obj);
        let scene = format!(
            "format = 1\ngravity = [0, 0, -9.81]\n[time]\nintegrator = \"backward-euler\"\n[[body]]\nmesh = \"sheet.obj\"\nsheet = {{ warp = [1, 0, 0] }}\n\
             material = {{ plugin = \"cloth\", params = {{ {params} }} }}\n{fixed}"
        );
        let session = open_file(&bench.write("scene.toml", scene), 1, None);
        let mut piece = Self {
            session,
            integrator: Integrator::new(Scheme::BackwardEuler, 1e-10, 20_000),
            gravity: Vec3::zeros(),
            forces: Vec::new(),
            time: 0.0,
        };
        let n = piece.system().nodes.len();
        piece.integrator.resize(n);
        piece
    }

    /// Its nodes, elements and material.
    pub fn system(&mut self) -> &mut System {
        &mut self.session.bodies[0].system
    }

    /// Moved by another scheme from now on.
    pub fn moved_by(mut self, scheme: Scheme) -> Self {
        self.integrator = Integrator::new(scheme, 1e-10, 20_000);
        let n = self.system().nodes.len();
        self.integrator.resize(n);
        self
    }

    /// Puts every node where `place` says, from where it rests (m), and stops it.
    pub fn put(&mut self, mut place: impl FnMut(Vec3) -> Vec3) {
        let nodes = &mut self.system().nodes;
        for i in 0..nodes.len() {
            (nodes.x[i], nodes.v[i]) = (place(nodes.rest[i]), Vec3::zeros());
        }
        self.integrator.forget_history();
    }

    /// One step of `dt`, s.
    ///
    /// # Panics
    /// If it fails.
    pub fn step(&mut self, dt: f64) -> StepReport {
        self.try_step(dt).unwrap_or_else(|e| panic!("{e}"))
    }

    /// One step of `dt`, s.
    ///
    /// # Errors
    /// What the integrator says.
    pub fn try_step(&mut self, dt: f64) -> Result<StepReport, StepError> {
        let loads = Loads { gravity: self.gravity, forces: &self.forces, tools: &[] };
        let system = &mut self.session.bodies[0].system;
        let report = self.integrator.step(&Pool::new(1), system, &loads, StepTime { start: self.time, dt }, 1);
        self.time += dt;
        report
    }

    /// Goes to equilibrium, but for `tolerance` of the largest force; then moves as before.
    ///
    /// # Panics
    /// If it does not get there.
    pub fn settle(&mut self, tolerance: f64) {
        let mut statics = Integrator::new(Scheme::QuasiStatic, 1e-8, 20_000);
        (statics.max_newton, statics.newton_tolerance) = (2000, tolerance);
        statics.max_displacement = 0.5 * self.session.bodies[0].discretization.edge();
        let n = self.system().nodes.len();
        statics.resize(n);
        std::mem::swap(&mut self.integrator, &mut statics);
        let report = self.step(1.0);
        assert!(report.converged, "{report:?}");
        std::mem::swap(&mut self.integrator, &mut statics);
        self.integrator.reaction.copy_from_slice(&statics.reaction);
        self.integrator.forget_history();
    }

    /// N, the sum of what it took to hold nodes that rest where `chosen` says, in the last step.
    pub fn reaction(&mut self, chosen: impl Fn(Vec3) -> bool) -> Vec3 {
        let nodes = &self.session.bodies[0].system.nodes;
        let all = self.integrator.reaction.iter().zip(&nodes.rest);
        all.filter(|(_, rest)| chosen(**rest)).map(|(f, _)| *f).sum()
    }

    /// Mean place of nodes that rest where `chosen` says, m.
    pub fn mean(&mut self, chosen: impl Fn(Vec3) -> bool) -> Vec3 {
        let nodes = &self.session.bodies[0].system.nodes;
        let all: Vec<Vec3> = nodes.rest.iter().zip(&nodes.x).filter(|(r, _)| chosen(**r)).map(|(_, x)| *x).collect();
        all.iter().map(|x| 1.0 / all.len() as f64 * *x).sum()
    }

    /// Mean place along the line that rests at `x` (m) across the sheet, m: of the surface, whatever its triangles are.
    ///
    /// # Panics
    /// If no triangle is there.
    pub fn mean_across(&mut self, x: f64) -> Vec3 {
        const PLACES: usize = 256;
        let surface = &self.session.bodies[0].model.surface;
        let nodes = &self.session.bodies[0].system.nodes;
        let [low, high] = [f64::min, f64::max].map(|pick| surface.points.iter().map(|p| p[1]).reduce(pick).unwrap());
        let mut sum = Vec3::zeros();
        for i in 0..PLACES {
            let y = low + (high - low) * (i as f64 + 0.5) / PLACES as f64;
            let weights = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| [surface.points[v as usize][0] - x, surface.points[v as usize][1] - y]);
                let turn = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
                let areas = [turn(b, c), turn(c, a), turn(a, b)];
                let all: f64 = areas.iter().sum();
                areas.map(|area| area / all)
            };
            let least = |w: &[f64; 3]| w[0].min(w[1]).min(w[2]);
            let all = surface.triangles.iter().map(|t| (t, weights(t)));
            let (t, w) = all.max_by(|a, b| least(&a.1).total_cmp(&least(&b.1))).expect("a sheet has triangles");
            for (v, w) in t.iter().zip(w) {
                sum += w / PLACES as f64 * nodes.x[*v as usize];
            }
        }
        sum
    }

    /// J, kinetic, elastic and of gravity.
    ///
    /// # Panics
    /// If the material fails.
    pub fn energies(&mut self) -> [f64; 3] {
        let (gravity, time) = (self.gravity, self.time);
        let system = self.system();
        let elastic = system.energy(StepTime { start: time, dt: 0.0 }).unwrap_or_else(|e| panic!("{e}"));
        let nodes = &system.nodes;
        let free = nodes.mass.iter().zip(&nodes.x).zip(&nodes.constraint).filter(|(_, c)| c.is_free());
        let height = free.map(|((m, x), _)| -m * gravity.dot(x)).sum();
        [nodes.kinetic_energy(), elastic, height]
    }
}

/// Energy of bending a sheet of 0.2 m and 15 uN m, of `n` cells, to a cylinder of `radius` (m) along a direction, over that of a
/// plate.
pub fn cylinder(pattern: Pattern, n: u32, degrees: f64, bending: &str, radius: f64) -> f64 {
    let d = 15e-6;
    let (s, c) = degrees.to_radians().sin_cos();
    let surface = sheet(pattern, [n, n], [0.2, 0.2]);
    let high = surface.points.iter().fold(0.0, |m: f64, p| m.max(p[1]));
    let energy = |bending: &str| {
        let params =
            format!("young-warp = 1000, poisson = 0, damping-time = 0, bending-warp = {d}, bending = \"{bending}\"");
        let mut piece = Piece::new(&surface, &params, |_| false, false);
        piece.put(|p| {
            let (along, across) = (c * p[0] + s * p[1], c * p[1] - s * p[0]);
            let (sine, cosine) = (along / radius).sin_cos();
            let bent = radius * sine;
            Vec3::new(c * bent - s * across, s * bent + c * across, radius * (1.0 - cosine))
        });
        piece.energies()[1]
    };
    (energy(bending) - energy("none")) / (0.5 * d / (radius * radius) * 0.2 * high)
}

/// The order observed between errors of a mesh and of one twice as fine.
pub fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).abs().log2()
}
