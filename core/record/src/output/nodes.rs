//! `nodes.csv`: the nodes of every body at the end.

use super::{BoxedOutput, FileNames, Output, OutputFolder, OutputKind};
use pliant_engine::session::{Session, Warning};
use std::io::{self, Write};

/// Name of the file.
const NAME: &str = "nodes.csv";

/// Nodes at the end, if the scene asks for them.
pub(super) static NODES: OutputKind = OutputKind {
    names: FileNames::One(NAME),
    replaces: |_, _| vec![NAME.into()],
    begin: |request| Ok(request.scene.output.nodes.then(|| Box::new(Nodes) as BoxedOutput)),
};

/// Writes nodes at the end.
struct Nodes;

impl Output for Nodes {
    fn finish(self: Box<Self>, session: &Session, folder: &OutputFolder) -> io::Result<Option<Warning>> {
        let mut file = folder.create(NAME)?;
        write_nodes(session, &mut file)?;
        file.finish().map(|()| None)
    }
}

/// Writes the current nodes of every body, with a header line.
fn write_nodes(session: &Session, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "body,node,rest_x_m,rest_y_m,rest_z_m,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,mass_kg,constraint")?;
    for body in &session.bodies {
        let n = &body.system.nodes;
        for i in 0..n.len() {
            let [[a, b, c], [x, y, z], [u, v, w]] = [n.rest[i], n.x[i], n.v[i]].map(<[f64; 3]>::from);
            let held = if n.constraint[i].is_free() { "free" } else { "held" };
            writeln!(out, "{},{i},{a},{b},{c},{x},{y},{z},{u},{v},{w},{},{held}", body.name, n.mass[i])?;
        }
    }
    Ok(())
}
