//! Cuts of whole scenes.

use pliant_tests::{open_file, root};

#[test]
fn trunk() {
    let mut session = open_file(&root().join("scenes/cut.toml"), 1, None);
    for _ in 0..450 {
        session.step();
    }
    session.update_surface();
    let body = &session.bodies[0];
    let parts = body.lattice.parts();
    let count = parts.iter().max().unwrap() + 1;
    for p in 0..count {
        let nodes: Vec<usize> = (0..parts.len()).filter(|n| parts[*n] == p).collect();
        let mass: f64 = nodes.iter().map(|n| body.system.nodes.mass[*n]).sum();
        println!("part {p}: {} nodes {mass:.3e} kg first {:?} now {:?}", nodes.len(), body.system.nodes.rest[nodes[0]], body.system.nodes.x[nodes[0]]);
    }
    let shells = body.model.surface.shells();
    for s in 0..=*shells.iter().max().unwrap() {
        let mut by = std::collections::BTreeMap::new();
        for (t, _) in shells.iter().enumerate().filter(|(_, x)| **x == s) {
            for v in body.model.surface.triangles[t] {
                let cell = body.skin.cell[v as usize];
                let node = body.lattice.region().cell_corners[cell as usize][0];
                by.entry(parts[node as usize]).or_insert_with(std::collections::BTreeSet::new).insert(v);
            }
        }
        if s == 0 {
            let mesh = body.cut.as_ref().unwrap();
            for (part, list) in by.iter().filter(|(k, _)| **k != 0) {
                for v in list.iter().take(400) {
                    let cap = body.model.around(*v).iter().filter(|t| mesh.is_cap(**t)).count();
                    println!("V {part} {v} {:?} caps {cap} of {} {:?}", body.model.surface.points[*v as usize], body.model.around(*v).len(), mesh.origin(*v));
                }
            }
        }
        println!("shell {s}: {:?}", by.iter().map(|(k, v)| (k, v.len())).collect::<Vec<_>>());
    }
}
