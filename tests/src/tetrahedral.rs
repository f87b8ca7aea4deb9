//! Sessions of one body of tetrahedra from a generated file.

use crate::{Bench, open_file};
use pliant_engine::session::Session;
use pliant_mesh::testing::tetrahedra::{TetBox, TetFormat};

/// A scene of one body of `box.msh` with this material, 100 kPa and 0.3, and further lines: of the body first, then of the scene.
pub fn scene(time: &str, material: &str, body: &str, rest: &str) -> String {
    format!(
        "format = 1\n{rest}\n[time]\n{time}\n[[body]]\nmesh = \"box.msh\"\nmaterial = {{ plugin = \"{material}\", params = {{ young = 1e5, poisson = 0.3, \
         density = 1000, damping-time = 0 }} }}\n{body}\n"
    )
}

/// The session of a scene beside a mesh.
pub fn open(mesh: &TetBox, scene: &str) -> Session {
    let bench = Bench::new();
    bench.write("box.msh", mesh.bytes(TetFormat::Msh4));
    open_file(&bench.write("scene.toml", scene), 1, None)
}

/// Steps a session.
pub fn run(session: &mut Session, steps: usize) {
    (0..steps).for_each(|_| session.step());
}

/// A mesh of linear tetrahedra, with nodes in the middles of its edges, and with these moved by up to 0.3 % of the box: its quadratic ones, straight and curved.
pub fn orders(linear: &TetBox) -> [TetBox; 3] {
    let straight = linear.quadratic();
    let curved = straight.curved(0.003, 1);
    [linear.clone(), straight, curved]
}
