//! The surface of a solid follows its lattice with continuous slopes, on generated bodies, whole and cut: affine motion exactly, no crease
//! along the cells, power conserved, and nothing across a cut.

#![allow(clippy::print_stdout, reason = "jumps of the slope")]

use pliant_engine::body::{Body, Lattice};
use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Random, TestModel, scan};
use pliant_solver::Nodes;
use pliant_tests::{Bench, Everywhere, open_file};

/// A whole body of 100 mm whose surface is smooth or not; nothing happens to it.
fn body(bench: &Bench, model: &TestModel, level: u32, solid: &str, smooth: bool) -> Session {
    bench.write("model.obj", &model.text);
    let scene = format!(
        r#"
        format = 1
        [time]
        duration = 1
        dt = 0.001
        [[body]]
        name = "model"
        mesh = "model.obj"
        size = "100 mm"
        material = {{ plugin = "{solid}", params = {{ young = 2e4, density = 1000 }} }}
        grid = {{ level = {level}, region = "whole", smooth = {smooth} }}
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0, 0, 1]] }}
        [[tool]]
        name = "ball"
        device = "hand"
        radius = "5 mm"
        [[edit]]
        kind = "touch"
        tool = "ball"
        "#
    );
    let mut session = open_file(&bench.write("scene.toml", scene), 1, None);
    session.step();
    let nodes = &mut session.bodies[0].system.nodes;
    nodes.x.clone_from(&nodes.rest);
    session
}

/// Solids, levels from 3 to 6 and bodies of genus 0 to 2, drawn from a number.
fn draw(seed: u64) -> (TestModel, u32, &'static str) {
    let random = &mut Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let solid = random.pick(&["mass-spring", "neo-hookean", "corotational"]);
    (scan(random.below(3) as u32, 1200, 0, seed), 3 + random.below(4) as u32, solid)
}

/// Cuts the lattice of a body by a plane through its middle with this normal: all of it, or as far as `reach` (m) along `along`.
fn cut(body: &mut Body, normal: Vec3, along: Vec3, reach: f64) {
    let points = body.model.surface.points.clone();
    let middle = points.iter().map(|p| Vec3::from(*p)).sum::<Vec3>() / points.len() as f64;
    let along = (along - along.dot(&normal) * normal).normalize();
    let across = normal.cross(&along);
    let at = |u: f64, v: f64| middle + u * along + v * across;
    let swept = [[at(-0.3, -0.3), at(reach, -0.3), at(reach, 0.3)], [at(-0.3, -0.3), at(reach, 0.3), at(-0.3, 0.3)]];
    let side = |v: u32| Vec3::from(points[v as usize]);
    body.discretization
        .lattice_mut()
        .unwrap()
        .cut(&swept, std::iter::empty(), side, |_| Vec::new(), &Everywhere)
        .unwrap();
    let Body { model, skin, system, discretization, fixings, .. } = body;
    assert!(discretization.follow(&[], model, fixings, skin, system).unwrap());
}

fn lattice(body: &Body) -> &Lattice {
    body.discretization.lattice().unwrap()
}

/// Places in all of a body: its vertices, and random ones in its cells.
fn places(body: &Body, random: &mut Random) -> Vec<Vec3> {
    let lattice = lattice(body);
    let inside = (0..500).map(|_| {
        let cell = random.below(lattice.region().cell_corners.len() as u64) as usize;
        lattice.grid_rest(lattice.region().cell_corners[cell][0]) + lattice.edge() * Vec3::from_fn(|_, _| random.unit())
    });
    let vertices = body.model.surface.points.iter().map(|p| Vec3::from(*p));
    vertices.chain(inside.collect::<Vec<_>>()).collect()
}

#[test]
fn affine_motion_of_the_nodes_is_affine_motion_of_the_surface_whole_and_cut() {
    let bench = Bench::new();
    for seed in 0..12 {
        let (model, level, solid) = draw(seed);
        let mut session = body(&bench, &model, level, solid, true);
        let random = &mut Random(seed + 77);
        let body = &mut session.bodies[0];
        if seed % 3 > 0 {
            let reach = if seed % 3 == 1 { 0.3 } else { 0.01 };
            cut(body, random.direction(), random.direction(), reach);
        }
        let columns: [Vec3; 3] = std::array::from_fn(|_| 2.0 * random.direction());
        let shift = random.direction();
        let map = |x: Vec3| shift + x[0] * columns[0] + x[1] * columns[1] + x[2] * columns[2];
        let nodes = &mut body.system.nodes;
        (0..nodes.x.len()).for_each(|i| nodes.x[i] = map(nodes.rest[i]));
        for place in places(body, random) {
            let Some(moved) = lattice(body).displacement_at(place, &body.system.nodes).unwrap() else { continue };
            let off = (place + moved - map(place)).norm();
            assert!(off < 1e-12, "{} level {level}: {place:?} is off by {off} m", model.name);
        }
        if seed % 3 == 0 {
            session.update_surface();
            let body = &session.bodies[0];
            for (x, rest) in body.skin.x.iter().zip(&body.model.surface.points) {
                let off = (x - map(Vec3::from(*rest))).norm();
                assert!(off < 1e-12, "{} level {level}: the vertex at {rest:?} is off by {off} m", model.name);
            }
        }
    }
}

/// Moves nodes by a field of soft dents, a few cells wide.
fn dent(nodes: &mut Nodes, edge: f64, random: &mut Random) {
    let dents: Vec<(Vec3, Vec3)> = (0..6)
        .map(|_| (nodes.rest[random.below(nodes.rest.len() as u64) as usize], 1.5 * edge * random.direction()))
        .collect();
    for i in 0..nodes.x.len() {
        let by = |(at, depth): &(Vec3, Vec3)| {
            let r = (nodes.rest[i] - at).norm() / (3.0 * edge);
            *depth / (1.0 + r * r).powi(3)
        };
        nodes.x[i] = nodes.rest[i] + dents.iter().map(by).sum::<Vec3>();
    }
}

/// Root mean square of the jumps of slopes over faces of cells, at random places of them.
fn jumps(body: &Body, random: &mut Random) -> f64 {
    let lattice = lattice(body);
    let (region, edge, nodes) = (lattice.region(), lattice.edge(), &body.system.nodes);
    let (mut sum, mut count) = (0.0, 0.0);
    for corners in &region.cell_corners {
        let axis = random.below(3) as usize;
        let mut on_face = lattice.grid_rest(corners[0]) + edge * Vec3::from_fn(|_, _| 0.05 + 0.9 * random.unit());
        on_face[axis] = lattice.grid_rest(corners[0])[axis];
        let along = Vec3::ith(axis, 1e-5 * edge);
        let at = |steps: f64| lattice.displacement_at(on_face + steps * along, nodes).unwrap();
        let [Some(a), Some(b), Some(c), Some(d)] = [at(-2.0), at(-1.0), at(1.0), at(2.0)] else { continue };
        // Where a cut runs along the face, both sides are their own.
        let sides = [-1.0, 1.0].map(|steps| lattice.cell_of(on_face + steps * along).unwrap().unwrap());
        let [low, high] = sides.map(|cell| region.cell_corners[cell]);
        if low.iter().filter(|node| high.contains(node)).count() < 4 {
            continue;
        }
        let jump = ((d - c) - (b - a)) / along.norm();
        sum += jump.norm_squared();
        count += 1.0;
    }
    assert!(count > 10.0);
    f64::sqrt(sum / count)
}

#[test]
fn slopes_do_not_jump_from_cell_to_cell() {
    let bench = Bench::new();
    for seed in 20..32 {
        let (model, level, solid) = draw(seed);
        let mut found = [false, true].map(|smooth| {
            let mut session = body(&bench, &model, level, solid, smooth);
            let body = &mut session.bodies[0];
            if seed % 2 == 1 {
                let random = &mut Random(seed);
                cut(body, random.direction(), random.direction(), 0.3);
            }
            let edge = body.discretization.edge();
            dent(&mut body.system.nodes, edge, &mut Random(seed + 5));
            jumps(body, &mut Random(seed + 6))
        });
        println!("{} level {level}: slopes jump by {:.5} trilinear, {:.7} smooth", model.name, found[0], found[1]);
        // Rounding of displacements over the step of the difference.
        found[1] -= 1e-8;
        assert!(found[1] < 0.01 * found[0], "{} level {level}: {found:?}", model.name);
    }
}

#[test]
fn forces_on_the_surface_have_the_power_of_their_nodes() {
    let bench = Bench::new();
    for seed in 40..48 {
        let (model, level, solid) = draw(seed);
        let mut session = body(&bench, &model, level, solid, true);
        let random = &mut Random(seed + 9);
        let body = &mut session.bodies[0];
        if seed % 2 == 1 {
            cut(body, random.direction(), random.direction(), 0.01);
        }
        let places = places(body, random);
        let forces: Vec<Vec3> = places.iter().map(|_| random.direction()).collect();
        let nodes = &mut body.system.nodes;
        // Velocities as displacements: the surface is linear in them.
        (0..nodes.x.len()).for_each(|i| nodes.x[i] = nodes.rest[i] + random.direction());
        let (mut cells, mut weights) = (Vec::new(), Vec::new());
        let lattice = body.discretization.lattice_mut().unwrap();
        lattice.find(&places, &mut cells, &mut weights).unwrap();
        let (mut by_nodes, mut total) = (0.0, Vec3::zeros());
        lattice.distribute_forces(&cells, &weights, &forces, |node, f| {
            by_nodes += f.dot(&(nodes.x[node as usize] - nodes.rest[node as usize]));
            total += f;
        });
        let (mut at_places, mut wanted) = (0.0, Vec3::zeros());
        for (place, force) in places.iter().zip(&forces) {
            if let Some(moved) = lattice.displacement_at(*place, nodes).unwrap() {
                at_places += force.dot(&moved);
                wanted += *force;
            }
        }
        let scale = places.len() as f64;
        assert!((by_nodes - at_places).abs() < 1e-12 * scale, "{by_nodes} W at nodes, {at_places} W at places");
        assert!((total - wanted).norm() < 1e-12 * scale, "{total:?} N at nodes, {wanted:?} N at places");
    }
}

#[test]
fn a_part_that_is_cut_off_takes_nothing_of_the_other_along() {
    let bench = Bench::new();
    for seed in 60..70 {
        let (model, level, solid) = draw(seed);
        // Coarser, every cell is cut, and a surface that is not goes with one part of them.
        let level = level.max(5);
        let mut session = body(&bench, &model, level, solid, true);
        let random = &mut Random(seed);
        cut(&mut session.bodies[0], random.direction(), random.direction(), 0.3);
        let parts = lattice(&session.bodies[0]).parts();
        assert!(parts.iter().any(|part| *part != parts[0]), "the cut goes through");
        let nodes = &mut session.bodies[0].system.nodes;
        for i in 0..nodes.x.len() {
            let shift = if parts[i] == parts[0] { Vec3::zeros() } else { Vec3::new(0.02, 0.5, -0.1) };
            nodes.x[i] = nodes.rest[i] + shift;
        }
        session.update_surface();
        let body = &session.bodies[0];
        let mut moved = 0;
        for (v, cell) in body.skin.cell.iter().enumerate() {
            let part = parts[lattice(body).region().cell_corners[*cell as usize][0] as usize];
            let (x, settled) = (body.skin.x[v], body.skin.settled[v]);
            if part == parts[0] {
                assert_eq!(x, settled, "{} level {level}: vertex {v} stays", model.name);
            } else {
                moved += 1;
                let off = (x - settled - Vec3::new(0.02, 0.5, -0.1)).norm();
                assert!(off < 1e-12, "{} level {level}: vertex {v} is off by {off} m", model.name);
            }
        }
        assert!(moved > 0);
    }
}
