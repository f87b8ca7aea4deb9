//! Tetrahedra of a lattice: they fill its cells, and those of cells a blade has parted weigh what is left of them.

use pliant_engine::body::Body;
use pliant_plugin_api::abi;
use pliant_solver::{StepTime, Vec3};
use pliant_tests::{Everywhere, box_scene, open};

#[test]
fn a_cut_keeps_the_energy_of_a_solid() {
    for material in ["neo-hookean", "corotational"] {
        let scene = box_scene("", "", "")
            .replace("level = 5", "level = 4, region = \"whole\"")
            .replace("mass-spring", material);
        let mut session = open(&scene, 1);
        session.step();
        let body = &mut session.bodies[0];
        let nodes = &mut body.system.nodes;
        for i in 0..nodes.x.len() {
            let [x, y, z] = nodes.rest[i].into();
            nodes.x[i] = Vec3::new(x + 4.0 * y * z, y - 3.0 * x * z, z * 1.1);
        }
        let tetrahedra = |body: &Body| {
            body.system.sets.iter().find(|s| s.request().kind == abi::TETRAHEDRON).map_or(0, |s| s.count())
        };
        assert_eq!(tetrahedra(body), 5 * body.discretization.lattice().unwrap().region().cell_id.len());
        let before = (body.system.energy(StepTime::default()).unwrap(), tetrahedra(body));

        // A wall beside the middle of a cell: it parts cells into a quarter and three.
        let (at, low, high) = (0.0013, -0.03, 0.03);
        let wall: [[Vec3; 3]; 2] = [
            [Vec3::new(at, low, low), Vec3::new(at, high, low), Vec3::new(at, high, high)],
            [Vec3::new(at, low, low), Vec3::new(at, high, high), Vec3::new(at, low, high)],
        ];
        let points = body.model.surface.points.clone();
        let inside = |v: u32| points[v as usize].map(|c| c * (1.0 - 1e-3));
        body.discretization
            .lattice_mut()
            .unwrap()
            .cut(&wall, std::iter::empty(), inside, |_| Vec::new(), &Everywhere)
            .unwrap();
        let Body { model, skin, system, discretization, fixings, .. } = body;
        assert!(discretization.follow(&[], model, fixings, skin, system).unwrap());
        let after = (body.system.energy(StepTime::default()).unwrap(), tetrahedra(body));
        assert!(after.1 > before.1, "{material}: cells were parted: {before:?} {after:?}");
        assert!((after.0 / before.0 - 1.0).abs() < 1e-11, "{material}: {before:?} {after:?}");
    }
}
