//! `forces.svg`: a plot of reactions as arrows on the mesh, like figure 8 of Tripicchio, D'Avella and Ruffaldi (2022).

use super::{BoxedOutput, FileNames, Output, OutputFolder, OutputKind};
use pliant_engine::body::Body;
use pliant_engine::session::{Session, Warning};
use pliant_solver::Vec3;
use std::io::{self, Write};

/// Name of the file.
const NAME: &str = "forces.svg";

/// The plot of reactions at the end, if the scene asks for it.
pub(super) static FORCES: OutputKind = OutputKind {
    names: FileNames::One(NAME),
    replaces: |_, _| vec![NAME.into()],
    begin: |request| Ok(request.scene.output.forces.then(|| Box::new(ForcePlot) as BoxedOutput)),
};

/// Writes the plot at the end.
struct ForcePlot;

impl Output for ForcePlot {
    fn finish(self: Box<Self>, session: &Session, folder: &OutputFolder) -> io::Result<Option<Warning>> {
        let bodies = session.bodies.iter().enumerate().map(|(i, body)| (body, session.reactions(i)));
        let mut file = folder.create(NAME)?;
        write_force_plot(bodies, &mut file)?;
        file.finish().map(|()| None)
    }
}

/// Width of the drawing in its own units.
const WIDTH: f64 = 800.0;
/// Length of the longest arrow as a share of the width.
const LONGEST_ARROW: f64 = 0.2;
/// Arrows shorter than this share of the longest are left out.
const SHORTEST_ARROW: f64 = 1e-3;
/// Sine and cosine of 30 degrees, the angle of both horizontal axes in isometric projection.
const AXIS_ANGLE: (f64, f64) = (0.5, 0.866_025_403_784_438_6);

/// Writes an SVG of all bodies with their reactions (N, n x 3): dark blue at nodes that the scene fixes, red at nodes on a tip. The projection
/// is isometric, with z up, x to the lower right and y to the upper right.
///
/// # Errors
/// Returns the errors of `file`.
fn write_force_plot<'a>(bodies: impl Iterator<Item = (&'a Body, &'a [Vec3])>, file: &mut impl Write) -> io::Result<()> {
    let bodies: Vec<(&Body, &[Vec3])> = bodies.collect();
    let points = bodies.iter().flat_map(|(body, _)| &body.skin.x).map(|p| project(*p));
    let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for p in points {
        for i in 0..2 {
            (bounds[0][i], bounds[1][i]) = (bounds[0][i].min(p[i]), bounds[1][i].max(p[i]));
        }
    }
    let extent = (bounds[1][0] - bounds[0][0]).max(bounds[1][1] - bounds[0][1]).max(f64::MIN_POSITIVE);
    let largest = bodies.iter().flat_map(|(_, all)| *all).map(|f| f.norm()).fold(0.0, f64::max);
    let margin = LONGEST_ARROW * WIDTH;
    let scale = (WIDTH - 2.0 * margin) / extent;
    let on_page = |p: [f64; 2]| [margin + scale * (p[0] - bounds[0][0]), margin + scale * (bounds[1][1] - p[1])];
    let height = 2.0 * margin + scale * (bounds[1][1] - bounds[0][1]) + 30.0;
    writeln!(
        file,
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:.0}" font-family="sans-serif" font-size="14">
<title>forces that hold nodes, N</title>
<rect width="{WIDTH}" height="{height:.0}" fill="white"/>
<defs><marker id="held" viewBox="0 0 6 6" refX="5" refY="3" markerWidth="5" markerHeight="5" orient="auto"><path d="M0 0L6 3L0 6z" fill="#1f3c88"/></marker>
<marker id="tip" viewBox="0 0 6 6" refX="5" refY="3" markerWidth="5" markerHeight="5" orient="auto"><path d="M0 0L6 3L0 6z" fill="#c0392b"/></marker></defs>"##
    )?;
    for (body, _) in &bodies {
        write!(file, r##"<path fill="none" stroke="#b8b8b8" stroke-width="0.6" d=""##)?;
        for (ends, _) in body.model.surface.edges().iter() {
            let [a, b] = ends.map(|v| on_page(project(body.skin.x[v as usize])));
            write!(file, "M{:.2} {:.2}L{:.2} {:.2}", a[0], a[1], b[0], b[1])?;
        }
        writeln!(file, r#""/>"#)?;
    }
    for (body, reactions) in &bodies {
        let nodes = &body.system.nodes;
        for (i, force) in reactions.iter().enumerate() {
            let size = force.norm();
            if largest == 0.0 || size < SHORTEST_ARROW * largest {
                continue;
            }
            let (from, along) = (on_page(project(nodes.x[i])), project(*force).map(|c| margin * c / largest));
            let (class, colour) = if nodes.constraint[i].is_free() { ("tip", "#c0392b") } else { ("held", "#1f3c88") };
            writeln!(
                file,
                r#"<line class="{class}" x1="{:.2}" y1="{:.2}" x2="{:.2}" y2="{:.2}" stroke="{colour}" stroke-width="1.4" marker-end="url(#{class})"/>"#,
                from[0],
                from[1],
                from[0] + along[0],
                from[1] - along[1],
            )?;
        }
    }
    writeln!(
        file,
        r##"<text x="10" y="{:.0}">longest arrow {largest:.4e} N; <tspan fill="#1f3c88">held nodes</tspan>, <tspan fill="#c0392b">nodes on a tip</tspan></text>
</svg>"##,
        height - 10.0
    )?;
    Ok(())
}

/// Isometric projection of a point (m): coordinates to the right and up, m.
fn project(p: Vec3) -> [f64; 2] {
    let (s, c) = AXIS_ANGLE;
    [c * (p[0] + p[1]), p[2] + s * (p[1] - p[0])]
}
