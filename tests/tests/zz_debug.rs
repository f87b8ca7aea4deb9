use pliant_core::session::Session;
use pliant_tests::open_file;
use std::collections::BTreeMap;

#[test]
fn debug() {
    let mesh = std::env::var("MESH").unwrap();
    let scene = std::env::var("SCENE").unwrap();
    let mut session: Session = open_file(std::path::Path::new(&scene), 2, Some(std::path::PathBuf::from(&mesh)));
    let steps: usize = std::env::var("STEPS").unwrap().parse().unwrap();
    for _ in 0..steps {
        session.step();
    }
    session.update_surface();
    let body = &session.bodies[0];
    let parts = body.lattice.parts();
    let shells = body.model.surface.shells();
    let mut counts: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
    for (triangle, shell) in body.model.surface.triangles.iter().zip(&shells) {
        for vertex in triangle {
            let cell = body.skin.cell[*vertex as usize];
            let part = if cell == u32::MAX { 99 } else { parts[body.lattice.region().cell_corners[cell as usize][0] as usize] };
            counts.entry((*shell, part)).or_default().push(*vertex);
        }
    }
    for ((s, p), v) in &mut counts {
        v.sort();
        v.dedup();
        println!("shell {s} part {p}: {} vertices", v.len());
        if v.len() < 700 {
            for &x in v.iter().take(12) {
                let cell = body.skin.cell[x as usize];
                let id = if cell == u32::MAX { 0 } else { body.lattice.region().cell_id[cell as usize] };
                println!("   {x} {:?} {:?} cell {id}", body.model.surface.points[x as usize], body.cut.as_ref().unwrap().origin(x));
            }
        }
    }
    println!("edge {}", body.lattice.edge());
}

#[test]
fn where_is() {
    let mesh = std::env::var("MESH").unwrap();
    let scene = std::env::var("SCENE").unwrap();
    let mut session: Session = open_file(std::path::Path::new(&scene), 2, Some(std::path::PathBuf::from(&mesh)));
    for step in 0..300 {
        session.step();
        let body = &session.bodies[0];
        if step < 100 { continue; }
        let p = body.model.surface.points[1282];
        let at = body.lattice.anchor_at(p).unwrap();
        let q = [p[0] + 0.0015, p[1], p[2]];
        let r = [p[0] + 0.0015, p[1] + 0.001, p[2]];
        let cell = body.skin.cell[1282];
        if step % 10 == 0 { println!("{step} {p:?} {at:?} {:?} {:?} skin {:?} inside {:?}", body.lattice.anchor_at(q).unwrap(), body.lattice.anchor_at(r).unwrap(), body.lattice.region().cell_id[cell as usize], body.cut.as_ref().unwrap().encloses(q)); }
    }
    let body = &session.bodies[0];
    for t in body.model.around(1282) {
        println!("{:?}", body.model.surface.triangles[*t as usize].map(|v| body.model.surface.points[v as usize]));
    }
}
