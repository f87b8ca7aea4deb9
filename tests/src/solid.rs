//! Blocks of a solid material, as the engine moves them.

use crate::library;
use pliant_host::{Material, ParamValue};
use pliant_plugin_api::kit;
use pliant_solver::{Constraint, Integrator, Loads, Nodes, Pool, Scheme, StepTime, System, Vec3};

/// Opens a material with numbers for its parameters.
///
/// # Panics
/// If it cannot be opened, or has no such parameter.
pub fn material(name: &str, numbers: &[(&str, f64)], dt: f64) -> Material {
    let library = library(name);
    let params = &library.plugins()[0].params;
    let place = |key: &str| params.iter().position(|p| p.key == key).unwrap_or_else(|| panic!("no `{key}`"));
    let settings = numbers.iter().map(|(key, value)| (place(key), ParamValue::Number(*value))).collect();
    Material::open(library, name, &settings, dt).unwrap_or_else(|e| panic!("{e}"))
}

/// A block of `cells` cubes with edge `h` (m) of `material`, at rest, with a matrix.
///
/// # Panics
/// If the material refuses it.
pub fn block(material: Material, cells: [u32; 3], h: f64) -> System {
    let mut system = System::new(Box::new(material));
    let families = system.sets.iter().fold(0, |all, set| all | set.request().families);
    let block = kit::block(cells, h, families);
    system.nodes = Nodes::at_rest(block.rest.iter().copied().map(Vec3::from).collect());
    for set in &mut system.sets {
        let kind = set.request().kind;
        let given = block.elements(kind);
        let list = set.list_mut();
        (list.nodes, list.family, list.measure) = (given.nodes, given.family, given.measure);
        list.measure.resize(list.nodes.len() / kit::corners(kind), 1.0);
    }
    system.prepare().unwrap_or_else(|e| panic!("{e}"));
    system.enable_matrix();
    system
}

/// Fixes or leads nodes: `place` gives where a node with this rest place stands, or `None` for a free one.
pub fn hold(system: &mut System, place: impl Fn(Vec3) -> Option<Vec3>) {
    let nodes = &mut system.nodes;
    for i in 0..nodes.len() {
        if let Some(x) = place(nodes.rest[i]) {
            nodes.constraint[i] = Constraint::Fixed;
            nodes.x[i] = x;
        }
    }
}

/// Finds the equilibrium under `forces` (N, n x 3): Newton's method, as implicit steps so long that mass plays no part.
/// Gives the largest force left on a free node, N.
///
/// # Panics
/// If the material fails.
pub fn settle(system: &mut System, forces: &[Vec3], newton_steps: usize) -> f64 {
    let pool = Pool::new(1);
    let mut integrator = Integrator::new(Scheme::BackwardEuler, 1e-10, 20_000);
    integrator.resize(system.nodes.len());
    for _ in 0..newton_steps {
        system.nodes.v.fill(Vec3::zeros());
        let loads = Loads { forces, ..Loads::default() };
        let report = integrator
            .step(&pool, system, &loads, StepTime { start: 0.0, dt: 1e4 }, 1)
            .unwrap_or_else(|e| panic!("{e}"));
        assert!(report.converged, "{report:?}");
    }
    system.nodes.v.fill(Vec3::zeros());
    let (force, nodes) = (self::forces(system), &system.nodes);
    let free = (0..nodes.len()).filter(|i| nodes.constraint[*i] == Constraint::Free);
    free.flat_map(|i| (0..3).map(move |c| (i, c)))
        .map(|(i, c)| (force[i][c] + forces.get(i).map_or(0.0, |f| f[c])).abs())
        .fold(0.0, f64::max)
}

/// N (n x 3), of the material, at rest.
///
/// # Panics
/// If the material fails.
pub fn forces(system: &mut System) -> Vec<Vec3> {
    let mut force = vec![Vec3::zeros(); system.nodes.len()];
    system
        .forces(&Pool::new(1), Some(&vec![Vec3::zeros(); force.len()]), StepTime::default(), &mut force)
        .unwrap_or_else(|e| panic!("{e}"));
    force
}
