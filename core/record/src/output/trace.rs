//! `trace.csv`: a row for each step.

use super::{FileNames, Output, OutputFolder, OutputKind};
use crate::atomic::AtomicFile;
use pliant_engine::edit::EditKind;
use pliant_engine::session::{Frame, Session, Warning};
use std::io::{self, Write};

/// Name of the file.
const NAME: &str = "trace.csv";

/// The trace, if the scene asks for it.
pub(super) static TRACE: OutputKind = OutputKind {
    names: FileNames::One(NAME),
    replaces: |_, _| vec![NAME.into()],
    begin: |request| {
        if !request.scene.output.trace {
            return Ok(None);
        }
        let mut file = request.folder.create(NAME)?;
        write_header(request.session, &mut file)?;
        Ok(Some(Box::new(Trace { file })))
    },
};

/// Writes a row in each step.
struct Trace {
    file: AtomicFile,
}

impl Output for Trace {
    fn step(&mut self, session: &Session, _folder: &OutputFolder) -> io::Result<()> {
        write_row(session.frame(), &mut self.file)
    }

    fn finish(self: Box<Self>, _session: &Session, _folder: &OutputFolder) -> io::Result<Option<Warning>> {
        self.file.finish().map(|()| None)
    }
}

/// A tool as a trace knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TracedTool<'a> {
    /// Name of the tool, which begins the names of its columns.
    pub name: &'a str,
    /// Whether an edit with it renders torque.
    pub has_torque: bool,
}

/// The tools of a session, in the order of its trace.
pub fn traced_tools(session: &Session) -> impl Iterator<Item = TracedTool<'_>> {
    session.tools.iter().map(|slot| TracedTool { name: &slot.tool.name, has_torque: slot.has_torque })
}

/// Names of the columns of a trace with these tools, in order; units are at their ends.
pub fn trace_columns<'a>(tools: impl IntoIterator<Item = TracedTool<'a>>) -> Vec<String> {
    let mut columns = vec!["time_s".to_owned()];
    for TracedTool { name, has_torque } in tools {
        let vector = |group: &str, unit: &str| ["x", "y", "z"].map(|axis| format!("{name}.{group}_{axis}_{unit}"));
        columns.extend(["hand", "proxy"].iter().flat_map(|group| vector(group, "m")));
        columns.extend(["contact", "depth_m"].map(|quantity| format!("{name}.{quantity}")));
        columns.extend(["force", "device_force"].iter().flat_map(|group| vector(group, "N")));
        if has_torque {
            columns.extend(["torque", "device_torque"].iter().flat_map(|group| vector(group, "Nm")));
        }
    }
    let of_session = [
        "nodes",
        "elements",
        "kinetic_energy_J",
        "elastic_energy_J",
        "substeps",
        "iterations",
        "residual",
        "step_seconds",
    ];
    columns.extend(of_session.map(str::to_owned));
    columns
}

/// Writes the line with the names of the columns.
fn write_header(session: &Session, out: &mut impl Write) -> io::Result<()> {
    let columns = trace_columns(traced_tools(session));
    writeln!(out, "{}", columns.join(","))
}

/// Cells of the trace for one step, in the order of [`trace_columns`]: numbers as text, and for `contact` a word or nothing.
pub fn trace_cells(frame: &Frame) -> Vec<String> {
    let mut row = Vec::new();
    write_row(frame, &mut row).expect("a list of bytes takes every byte");
    String::from_utf8_lossy(&row).trim_end().split(',').map(str::to_owned).collect()
}

/// Writes the row of one step.
fn write_row(frame: &Frame, out: &mut impl Write) -> io::Result<()> {
    write!(out, "{}", frame.time)?;
    for t in &frame.tools {
        let gripping = t.edit.filter(|_| t.grips).map(EditKind::name);
        let contact = gripping.unwrap_or(if t.contact.is_some() { "touch" } else { "" });
        let [[hx, hy, hz], [px, py, pz]] = [t.hand, t.proxy].map(<[f64; 3]>::from);
        let [[fx, fy, fz], [dx, dy, dz]] = [t.force, t.device_force].map(<[f64; 3]>::from);
        write!(out, ",{hx},{hy},{hz},{px},{py},{pz},{contact},{},{fx},{fy},{fz},{dx},{dy},{dz}", t.depth)?;
        if t.has_torque {
            let [[tx, ty, tz], [dx, dy, dz]] = [t.torque, t.device_torque].map(<[f64; 3]>::from);
            write!(out, ",{tx},{ty},{tz},{dx},{dy},{dz}")?;
        }
    }
    writeln!(
        out,
        ",{},{},{:e},{:e},{},{},{:e},{:.3e}",
        frame.nodes,
        frame.elements,
        frame.kinetic_energy,
        frame.elastic_energy,
        frame.substeps,
        frame.iterations,
        frame.residual,
        frame.seconds
    )
}
